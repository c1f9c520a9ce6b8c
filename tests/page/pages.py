"""Pages as a browser and a server have them: what the checks of all kinds of pages share."""

import functools
import http.server
import threading
import time
import urllib.parse

STATE = "document.documentElement && document.documentElement.dataset.state"

faults = []


def expect(holds, what):
    print(("ok    " if holds else "FAULT ") + what, flush=True)
    if not holds:
        faults.append(what)


class Handler(http.server.SimpleHTTPRequestHandler):
    """A plain server, which answers wrongly or late for some names."""

    wrong = {}
    late_s = {}

    def log_message(self, *_):
        pass

    def do_GET(self):
        name = urllib.parse.unquote(self.path).rsplit("/", 1)[-1]
        time.sleep(self.late_s.get(name, 0))
        if name not in self.wrong:
            return super().do_GET()
        status, body = self.wrong[name]
        self.send_response(status)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(body)


def served(folder):
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return server


def opened(browser, address, seconds=300):
    browser.events = []
    browser.open(address)
    return browser.wait(STATE, seconds)


def local(page):
    """The address of a page on this disk."""
    return f"file://{urllib.parse.quote(page)}/index.html"


def from_disk_and_over_http(browser, page, base, states):
    for how, address in [("from disk", local(page)), ("over http", base)]:
        expect(opened(browser, address) in states, f"{how} it opens")
        expect(not browser.messages(), f"{how} nothing is refused or thrown: {browser.messages()[:3]}")
    others = [url for url in browser.requests() if not url.startswith((base.rsplit("/", 1)[0], "blob:", "data:", "about:"))]
    expect(not others, f"no other host is asked: {others[:3]}")


def accessibility(browser, base, axe, prepare="0"):
    source = open(axe).read()
    for scheme in ["light", "dark"]:
        browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        opened(browser, base)
        browser.evaluate(prepare)
        browser.evaluate(source + ";0")
        found = browser.evaluate("axe.run().then((result) => result.violations.map((violation) => violation.help))")
        expect(not found, f"axe-core finds nothing in the {scheme} scheme: {found}")


FRAMES = """const frames = async (wanted) => {
            let count = 0;
            const next = () => { count++; device.activeSession.requestAnimationFrame(next); };
            device.activeSession.requestAnimationFrame(next);
            while (count < wanted) await new Promise((resolve) => setTimeout(resolve, 50));
        };"""


def in_a_headset(browser, base, emulator, meanwhile=None):
    """Enters a headset that a script emulates, waits for frames, does what is to be done meanwhile, and leaves. Returns the mean
    colours of the first frame's left and right half."""
    source = open(emulator).read() + """;
        window.device = new (window.IWER || IWER).XRDevice((window.IWER || IWER).metaQuest3);
        window.device.installRuntime({ forceInstall: true });
        window.device.stereoEnabled = true;"""
    added = browser.call("Page.addScriptToEvaluateOnNewDocument", source=source)["identifier"]
    try:
        opened(browser, base)
        expect(browser.wait("!document.getElementById('vr').hidden", 30), "a headset is offered where there is one")
        browser.call("Runtime.evaluate", expression="document.getElementById('vr').click()", userGesture=True)
        browser.wait("Boolean(quadratura.inHeadset && device.activeSession)", 60)
        browser.evaluate(f"(async () => {{ {FRAMES} await frames(4); }})()")
        halves = browser.evaluate("""(() => {
            const canvas = document.createElement("canvas"), from = device.appCanvas || document.getElementById("view");
            [canvas.width, canvas.height] = [2, 1];
            const context = canvas.getContext("2d");
            context.drawImage(from, 0, 0, 2, 1);
            return [...context.getImageData(0, 0, 2, 1).data];
        })()""")
        if meanwhile:
            meanwhile(browser)
        browser.evaluate("device.activeSession.end()")
        browser.wait("!quadratura.inHeadset", 30)
        expect(not browser.messages(), f"with a headset nothing is thrown: {browser.messages()[:3]}")
        return halves
    finally:
        browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=added)
