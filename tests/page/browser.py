"""Chromium, driven by the DevTools protocol. Python's standard library alone."""

import base64
import json
import os
import subprocess
import tempfile
import time
import urllib.request

from websocket import Websocket


class Browser:
    """Chromium without a window, which draws WebGL on the processor."""

    def __init__(self, program, width=960, height=540, arguments=()):
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        usual = ["--headless=new", "--no-sandbox", "--hide-scrollbars", "--use-gl=angle", "--use-angle=swiftshader",
                 "--enable-unsafe-swiftshader", "--force-device-scale-factor=1", "--remote-debugging-port=0",
                 f"--user-data-dir={self.profile.name}", f"--window-size={width},{height}"]
        self.process = subprocess.Popen([program, *usual, *arguments, "about:blank"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        port = self._port()
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/json") as answer:
            page = next(target for target in json.load(answer) if target["type"] == "page")
        self.events = []
        self.number = 0
        self.socket = Websocket(port, page["webSocketDebuggerUrl"].split(f":{port}", 1)[1])
        for domain in ["Page", "Runtime", "Log", "Network"]:
            self.call(f"{domain}.enable")
        self.call("Network.setCacheDisabled", cacheDisabled=True)
        self.resize(width, height)

    def _port(self):
        file = os.path.join(self.profile.name, "DevToolsActivePort")
        for _ in range(600):
            if os.path.exists(file) and "\n" in open(file).read():
                return int(open(file).readline())
            time.sleep(0.05)
        raise RuntimeError("the browser does not start")

    def call(self, method, **parameters):
        """Calls a method of the protocol and returns its result; events meanwhile are kept."""
        self.number += 1
        self.socket.send({"id": self.number, "method": method, "params": parameters})
        while True:
            answer = self.socket.receive()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self.events.append(answer)

    def resize(self, width, height, scale=1, mobile=False):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=mobile)

    def open(self, address):
        # A part of an address after # alone would not open the page again.
        self.call("Page.navigate", url="about:blank")
        self.call("Page.navigate", url=address)

    def evaluate(self, expression):
        """Returns the value of an expression in the page; a promise is awaited."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def wait(self, expression, seconds=240):
        """Waits until an expression holds, and returns its value."""
        end = time.time() + seconds
        while time.time() < end:
            value = self.evaluate(expression)
            if value:
                return value
            time.sleep(0.05)
        raise RuntimeError(f"this never came true: {expression}\n{self.messages()}")

    def key(self, key, code=None, held=0.0, modifiers=0):
        named = {"type": "keyDown", "key": key, "code": code or (f"Key{key.upper()}" if len(key) == 1 and key.isalpha() else key), "modifiers": modifiers}
        if len(key) == 1:
            named["text"] = key
        if key == "Enter":
            named["text"] = "\r"
        self.call("Input.dispatchKeyEvent", **named, windowsVirtualKeyCode={"Tab": 9, "Enter": 13, "Escape": 27, " ": 32, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40}.get(key, ord(key[0].upper())))
        time.sleep(held)
        named.pop("text", None)
        self.call("Input.dispatchKeyEvent", **{**named, "type": "keyUp"})

    def mouse(self, kind, x, y, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def touch(self, kind, points):
        self.call("Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(points)])

    def picture(self, file):
        with open(file, "wb") as out:
            out.write(base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"]))

    def messages(self):
        """What the page wrote to the console, and what went wrong in it."""
        self.evaluate("0")
        said = []
        for event in self.events:
            given = event.get("params", {})
            if event["method"] == "Runtime.exceptionThrown":
                said.append(str(given["exceptionDetails"].get("exception", {}).get("description", given["exceptionDetails"]["text"])))
            elif event["method"] == "Runtime.consoleAPICalled":
                said.append(" ".join(str(argument.get("value", argument.get("description"))) for argument in given["args"]))
            elif event["method"] == "Log.entryAdded":
                said.append(given["entry"]["text"] + " " + given["entry"].get("url", ""))
        return said

    def requests(self):
        """The addresses that the page asked for."""
        self.evaluate("0")
        return [event["params"]["request"]["url"] for event in self.events if event["method"] == "Network.requestWillBeSent"]

    def close(self):
        self.process.terminate()
        self.process.wait()
        self.profile.cleanup()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
