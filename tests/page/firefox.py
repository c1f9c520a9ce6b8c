"""Looks at pages with Firefox: python3 tests/page/firefox.py FIREFOX PAGE PHOTO [EXPECTED]

PAGE is the page of a site, PHOTO that of one layered depth image; both are opened from disk. EXPECTED is as in check.py; Firefox shows one
of its views. It is driven by WebDriver BiDi. Every fault is a line; the exit status is 1 where there is one.
"""

import base64
import json
import os
import subprocess
import sys
import tempfile
import time
import urllib.parse

from likeness import likeness
from pages import STATE, expect, faults, local
from websocket import Websocket

# Software drawing is asked for, as there is no device.
PREFERENCES = {"webgl.force-enabled": True, "webgl.disabled": False, "webgl.forbid-software": False, "browser.shell.checkDefaultBrowser": False,
               "datareporting.policy.dataSubmissionEnabled": False, "app.update.auto": False}


class Firefox:
    """Firefox, on a display: without one it draws no WebGL."""

    def __init__(self, program):
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        with open(os.path.join(self.profile.name, "user.js"), "w") as out:
            out.writelines(f"user_pref({json.dumps(name)}, {json.dumps(value)});\n" for name, value in PREFERENCES.items())
        arguments = ["--no-remote", "--profile", self.profile.name, "--remote-debugging-port=0"]
        self.process = subprocess.Popen([program, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        server = os.path.join(self.profile.name, "WebDriverBiDiServer.json")
        for _ in range(600):
            if os.path.exists(server) and os.path.getsize(server):
                break
            time.sleep(0.1)
        self.socket = Websocket(json.load(open(server))["ws_port"], "/session")
        self.number, self.said = 0, []
        self.call("session.new", capabilities={})
        self.call("session.subscribe", events=["log.entryAdded"])
        self.context = self.call("browsingContext.getTree")["contexts"][0]["context"]

    def call(self, method, **parameters):
        self.number += 1
        self.socket.send({"id": self.number, "method": method, "params": parameters})
        while True:
            answer = self.socket.receive()
            if answer.get("type") == "event":
                self.said.append(answer["params"].get("text"))
            elif answer.get("id") == self.number:
                if answer["type"] == "error":
                    raise RuntimeError(f"{method}: {answer['message']}")
                return answer["result"]

    def open(self, address, size):
        self.said = []
        self.call("browsingContext.setViewport", context=self.context, viewport={"width": size[0], "height": size[1]})
        self.call("browsingContext.navigate", context=self.context, url="about:blank", wait="complete")
        self.call("browsingContext.navigate", context=self.context, url=address, wait="complete")

    def evaluate(self, expression):
        wrapped = f"(async () => JSON.stringify(await ({expression})))()"
        answer = self.call("script.evaluate", expression=wrapped, target={"context": self.context}, awaitPromise=True)
        if answer["type"] == "exception":
            raise RuntimeError(f"{expression}: {answer['exceptionDetails']['text']}")
        value = answer["result"].get("value")
        return None if value is None else json.loads(value)

    def wait(self, expression, seconds=300):
        end = time.time() + seconds
        while time.time() < end:
            value = self.evaluate(expression)
            if value:
                return value
            time.sleep(0.1)
        raise RuntimeError(f"this never came true: {expression}\n{self.said}")

    def picture(self, file):
        with open(file, "wb") as out:
            out.write(base64.b64decode(self.call("browsingContext.captureScreenshot", context=self.context)["data"]))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()
        self.profile.cleanup()


def main(program, page, photo, expected=None):
    with Firefox(program) as browser:
        for what, folder, states in [("a site", page, ("walking", "drawn")), ("one photo", photo, ("drawn",))]:
            browser.open(local(folder), (360, 240))
            state = browser.wait(STATE)
            expect(state in states, f"Firefox opens the page of {what}: {state}")
            expect(not browser.said, f"nothing is refused or thrown: {browser.said[:3]}")
        if expected:
            view = json.load(open(os.path.join(expected, "views.json")))[0]
            exact = dict(view, exposure="raw", around=False)
            browser.open(local(page) + "#exact=" + urllib.parse.quote(json.dumps(exact)), view["size"])
            browser.wait("Boolean(window.quadratura && quadratura.drawExactly)")
            browser.evaluate("quadratura.drawExactly(quadratura.exactView(%s), quadratura.FINEST)" % json.dumps(exact))
            with tempfile.NamedTemporaryFile(suffix=".png") as shown:
                browser.picture(shown.name)
                found = likeness(os.path.join(expected, "raw", view["name"] + ".png"), shown.name)
            # As for Chromium, see check.py.
            expect(found >= 35.0, f"Firefox shows a view as the program does: {found:.1f} dB")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
