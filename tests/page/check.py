"""Looks at a page as a visitor does: python3 tests/page/check.py PAGE CHROMIUM [EXPECTED [AXE [EMULATOR]]]

PAGE is the folder of a page. It is opened from disk and over http, below a path with spaces, from servers that answer wrongly, by keys,
by touch, and in narrow windows. EXPECTED is a folder with views.json and pictures that the program rendered of these views: the page has
to show the same. AXE is the script of axe-core, which looks for what keeps people out, and EMULATOR that of
iwer, which emulates a headset. Every fault is a line; the exit status is 1 where there is one.
"""

import json
import math
import os
import shutil
import sys
import tempfile
import urllib.parse

from browser import Browser
from likeness import largest_changes, likeness, read_png, where_opaque
from pages import FRAMES, Handler, accessibility, expect, faults, from_disk_and_over_http, in_a_headset, local, opened, served

# Frames on the processor take long, and other work may go on beside.
SMALL = (360, 240)


def by_keys(browser):
    browser.evaluate("document.getElementById('view').focus()")
    before = browser.evaluate("quadratura.walker.eye")
    browser.key("w", held=1.0)
    after = browser.evaluate("quadratura.walker.eye")
    expect(before != after, "W walks")
    heading = browser.evaluate("quadratura.walker.heading")
    browser.key("ArrowLeft", held=1.0)
    expect(browser.evaluate("quadratura.walker.heading") > heading, "the left arrow turns to the left")
    browser.key("]")
    browser.wait("location.hash.startsWith('#photo=') && !quadratura.walker.flight")
    expect("Photo" in browser.evaluate("document.getElementById('status').textContent"), "a photo is named when one goes there")
    browser.key("p")
    expect("At photo" in browser.evaluate("document.getElementById('status').textContent"), "P says where one is")
    browser.evaluate("document.getElementById('share').click()")
    address = browser.evaluate("location.href")
    expect("#v=1&p=" in address, "the address of a view is there to be copied")
    reached = set()
    browser.evaluate("document.activeElement.blur()")
    browser.evaluate("document.getElementById('places').hidden && document.getElementById('places-button').click()")
    buttons = browser.evaluate("[...document.querySelectorAll('button')].filter((b) => b.checkVisibility()).length")
    for _ in range(buttons + 4):
        browser.key("Tab")
        reached.add(browser.evaluate("[...document.querySelectorAll('button')].indexOf(document.activeElement)"))
    expect(len(reached - {-1}) == buttons, f"all {buttons} buttons are reached by Tab, found {len(reached - {-1})}")
    browser.evaluate("document.getElementById('places-button').click()")
    return address


def by_touch(browser):
    heading = browser.evaluate("quadratura.walker.heading")
    browser.touch("touchStart", [(100, 100)])
    for x in range(110, 180, 10):
        browser.touch("touchMove", [(x, 100)])
    browser.touch("touchEnd", [])
    expect(browser.evaluate("quadratura.walker.heading") != heading, "a finger turns the view")
    eye = browser.evaluate("quadratura.walker.eye")
    browser.touch("touchStart", [(100, 120), (200, 120)])
    for by in range(5, 40, 5):
        browser.touch("touchMove", [(100 - by, 120), (200 + by, 120)])
    browser.touch("touchEnd", [])
    expect(browser.evaluate("quadratura.walker.eye") != eye, "two fingers walk")


def addresses(browser, base, shared):
    opened(browser, base + shared[shared.index("#"):])
    browser.wait("!quadratura.walker.flight")
    there = browser.evaluate("quadratura.share.of(quadratura.walker)")
    expect(there == shared[shared.index("#"):], f"a shared address leads there again: {there}")
    opened(browser, base + "#v=9&p=1,2,3")
    expect("no place" in browser.wait("document.getElementById('status').textContent"), "an address of another version is said to be unknown")
    opened(browser, base + "#photo=1")
    browser.evaluate("document.querySelectorAll('#photos button')[1].click()")
    browser.wait("location.hash === '#photo=2'")
    browser.evaluate("history.back()")
    browser.wait("location.hash === '#photo=1'")
    browser.wait("!quadratura.walker.flight")
    eye = browser.evaluate("quadratura.site.photos[0].centre.every((v, i) => Math.abs(v - quadratura.walker.eye[i]) < 1e-6)")
    expect(eye, "Back goes back")


def in_narrow_windows(browser, base):
    for width, height in [(320, 480), (200, 200)]:
        browser.resize(width, height)
        opened(browser, base)
        wide = browser.evaluate("document.documentElement.scrollWidth")
        expect(wide <= width, f"nothing is wider than a window of {width} pixels: {wide}")
    browser.resize(*SMALL)


def wrong_data(browser, page, base):
    """Chunks that are missing, cut, empty, HTML, or whose bits are flipped."""
    near, data = "near-1.js", lambda name: open(os.path.join(page, "data", name), "rb").read()
    flipped = bytearray(data(near))
    middle = len(flipped) // 2
    flipped[middle] = ord("A") if flipped[middle] != ord("A") else ord("B")
    cases = [("missing", 404, b"<html>not found</html>"), ("HTML", 200, b"<html>hello</html>"), ("empty", 200, b""),
             ("cut", 200, data(near)[:1000]), ("flipped", 200, bytes(flipped))]
    for what, status, body in cases:
        Handler.wrong = {near: (status, body)}
        expect(opened(browser, base) in ("walking", "drawn"), f"with a photo that is {what} the page opens")
        said = browser.wait("document.getElementById('status').textContent", 120)
        expect("1 of" in said, f"with a photo that is {what} it says so: {said}")
    for name in ["geometry.js", "site.js", "far-1.js"]:
        Handler.wrong = {name: (404, b"no")}
        state = opened(browser, base)
        said = browser.evaluate("document.getElementById('status').textContent")
        expect(state == "failed" and "pictures" in said, f"without {name} there are pictures and a message: {state}, {said}")
        poster = browser.evaluate("document.getElementById('poster').checkVisibility() && document.getElementById('poster').naturalWidth > 0")
        expect(poster, f"without {name} the poster is seen")
    Handler.wrong = {}


def lost_context(browser, base):
    opened(browser, base)
    browser.evaluate("quadratura.lose = quadratura.walker.painter.gl.getExtension('WEBGL_lose_context'), quadratura.lose.loseContext()")
    said = browser.wait("document.getElementById('status').textContent", 60)
    expect("graphics" in said, f"a lost device is said: {said}")


# What views of the page have to show of what `render` shows, in dB: pictures, kind of views, the least and the mean.
LIKENESSES = [("raw", "between", 35.0, 39.0), ("raw", "own", 38.0, 38.0), ("full", "between", 35.0, 39.0)]


def shows(browser, page, views):
    """Draws views exactly; yields each with the file of its picture."""
    shown = os.path.join(tempfile.gettempdir(), f"page-{os.getpid()}.png")
    for number, view in enumerate(views):
        browser.resize(*view["size"])
        if not number:
            opened(browser, local(page) + "#exact=" + urllib.parse.quote(json.dumps(view)))
            browser.wait("Boolean(quadratura.drawExactly)")
        browser.evaluate(f"quadratura.drawExactly(quadratura.exactView({json.dumps(view)}), quadratura.FINEST)")
        browser.picture(shown)
        yield view, shown


def views_of(expected, pictures, kind):
    """The views of a kind that have pictures, as the page takes them, and the function that gives a view's picture."""
    as_taken = {"exposure": "raw", "around": False} if pictures == "raw" else {}
    picture_of = lambda view: os.path.join(expected, pictures, view["name"] + ".png")
    views = [view | as_taken for view in json.load(open(os.path.join(expected, "views.json"))) if view["kind"] == kind]
    return [view for view in views if os.path.exists(picture_of(view))], picture_of


def likenesses(browser, page, expected):
    for pictures, kind, least, mean in LIKENESSES:
        views, picture_of = views_of(expected, pictures, kind)
        found = [likeness(picture_of(view), shown) for view, shown in shows(browser, page, views)]
        named = ", ".join(f"{view['name']} {value:.1f}" for view, value in zip(views, found))
        if found:
            expect(min(found) >= least and sum(found) / len(found) >= mean,
                   f"{pictures}, {kind}: {sum(found) / len(found):.1f} dB, worst {min(found):.1f} ({named})")
    browser.resize(*SMALL)


def nothing_pops(browser, page, expected):
    """From step to step of a walk nothing changes much more than where the program renders it."""
    views, picture_of = views_of(expected, "raw", "step")
    if not views:
        return
    expected_of = lambda view: read_png(picture_of(view))
    def as_opaque(view, shown):
        width, height, values = read_png(shown)
        return width, height, where_opaque(expected_of(view)[2], values)
    of_page = largest_changes(as_opaque(view, shown) for view, shown in shows(browser, page, views))
    of_program = largest_changes(expected_of(view) for view in views)
    expect(max(of_page) <= 1.5 * max(of_program),
           f"a step changes a square of 4 pixels by at most {max(of_page):.1f} of 255; rendered, by {max(of_program):.1f}")
    browser.resize(*SMALL)


def slowly(browser, base):
    """Chunks that arrive late, and in another order than they are asked for."""
    Handler.late_s = {"geometry.js": 2.0, "near-1.js": 3.0, "site.js": 0.5}
    expect(opened(browser, base) in ("walking", "drawn"), "over a slow network it opens")
    expect(browser.wait("quadratura.walker.painter.textures.isComplete()", 120), "over a slow network everything arrives")
    Handler.late_s = {}


def in_two_tabs(browser, base):
    opened(browser, base)
    browser.evaluate("localStorage.length + document.cookie.length") == 0 or expect(False, "nothing is stored")
    with Browser(sys.argv[2], *SMALL) as other:
        expect(opened(other, base) in ("walking", "drawn"), "in a second tab it opens")
    expect(browser.evaluate("quadratura.walker.painter.gl.isContextLost()") is False, "the first tab goes on")


def by_pointing(browser):
    """In a headset a hand that points at the ground goes there, and one that points at the sky goes nowhere."""
    where = "[...quadratura.walker.eye]"
    for tilt, moves in [(0.6, False), (-0.6, True)]:
        before = browser.evaluate(where)
        browser.evaluate(f"""(async () => {{
            {FRAMES}
            const hand = device.controllers.right;
            hand.position.set(0.2, 1.3, -0.2);
            hand.quaternion.set(Math.sin({tilt} / 2), 0, 0, Math.cos({tilt} / 2));
            await frames(2);
            hand.updateButtonValue("trigger", 1);
            await frames(3);
            hand.updateButtonValue("trigger", 0);
            await frames(3);
        }})()""")
        far = math.dist(before, browser.evaluate(where))
        expect((far > 0.1) == moves, f"a hand that points {'down' if moves else 'up'} moves the visitor by {far:.2f}")


def main(page, chromium, expected=None, axe=None, emulator=None):
    with tempfile.TemporaryDirectory() as folder, Browser(chromium, *SMALL) as browser:
        place = os.path.join(folder, "the squ\u00e4re & more")
        shutil.copytree(page, place)
        server = served(folder)
        base = f"http://127.0.0.1:{server.server_port}/" + urllib.parse.quote("the squ\u00e4re & more/index.html")
        from_disk_and_over_http(browser, page, base, ("walking", "drawn"))
        shared = by_keys(browser)
        by_touch(browser)
        addresses(browser, base, shared)
        in_narrow_windows(browser, base)
        wrong_data(browser, place, base)
        slowly(browser, base)
        in_two_tabs(browser, base)
        lost_context(browser, base)
        if axe:
            accessibility(browser, base, axe, "document.getElementById('places-button').click()")
        if emulator:
            halves = in_a_headset(browser, base, emulator, by_pointing)
            expect(min(sum(halves[:3]), sum(halves[4:7])) > 30, f"both eyes see something: {halves}")
        if expected:
            likenesses(browser, page, expected)
            nothing_pops(browser, page, expected)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
