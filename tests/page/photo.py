"""Looks at the page of one layered depth image: python3 tests/page/photo.py PAGE CHROMIUM [AXE [EMULATOR]]

It is opened from disk and over http, leant into by keys and by the pointer, shown as a stereo pair, and given damaged data. Every fault is
a line; the exit status is 1 where there is one. `cargo test --test recipes` compares its pictures with those of the program.
"""

import os
import shutil
import sys
import tempfile
import urllib.parse

from browser import Browser
from pages import Handler, accessibility, expect, faults, from_disk_and_over_http, in_a_headset, opened, served

SIZE = (480, 320)
STATUS = "document.getElementById('status').textContent"


def by_hand(browser):
    browser.key("ArrowRight")
    expect("to the right" in browser.evaluate(STATUS), "an arrow key leans, and says so")
    browser.key("+")
    expect("nearer" in browser.evaluate(STATUS), "plus goes nearer")
    browser.key("Home")
    expect("the camera's" in browser.evaluate(STATUS), "Home goes back")
    browser.key("s")
    wide = browser.evaluate("(() => { const c = document.getElementById('view'); return c.width / c.height; })()")
    expect("side by side" in browser.evaluate(STATUS) and wide > 2, f"S shows a stereo pair: {wide:.2f}")
    browser.key("s")


def wrong_data(browser, page, base):
    whole = open(os.path.join(page, "data", "photo.js"), "rb").read()
    flipped = bytearray(whole)
    middle = len(flipped) // 2
    flipped[middle] = ord("A") if flipped[middle] != ord("A") else ord("B")
    for what, status, body in [("missing", 404, b"no"), ("HTML", 200, b"<html>hello</html>"), ("empty", 200, b""),
                               ("cut", 200, whole[: len(whole) // 2]), ("damaged", 200, bytes(flipped))]:
        Handler.wrong = {"photo.js": (status, body)}
        state = opened(browser, base)
        said = browser.evaluate("document.getElementById('help').textContent")
        poster = browser.evaluate("document.getElementById('poster').checkVisibility()")
        expect(state == "failed" and poster and "photo.js" in said, f"with data that are {what} one sees the photo, and is told: {state}, {said}")
    Handler.wrong = {}


def lost_context(browser, base):
    opened(browser, base)
    browser.evaluate("document.getElementById('view').getContext('webgl2').getExtension('WEBGL_lose_context').loseContext()")
    browser.wait(f"{STATUS}.includes('graphics')", 60)
    expect(browser.evaluate("document.getElementById('poster').checkVisibility()"), "with a lost device one sees the photo, and is told")


def main(page, chromium, axe=None, emulator=None):
    with tempfile.TemporaryDirectory() as folder, Browser(chromium, *SIZE) as browser:
        place = os.path.join(folder, "a ph\u00f6to & more")
        shutil.copytree(page, place)
        server = served(folder)
        base = f"http://127.0.0.1:{server.server_port}/" + urllib.parse.quote("a ph\u00f6to & more/index.html")
        from_disk_and_over_http(browser, page, base, ("drawn",))
        by_hand(browser)
        wrong_data(browser, place, base)
        lost_context(browser, base)
        if axe:
            accessibility(browser, base, axe)
        if emulator:
            halves = in_a_headset(browser, base, emulator)
            expect(min(sum(halves[:3]), sum(halves[4:7])) > 30, f"both eyes see something: {halves}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
