"""Makes a picture of a page: python3 tests/page/exact.py CHROMIUM ADDRESS WIDTH HEIGHT OUT

The picture is taken when the page says that it has drawn. Chromium's own --screenshot takes it after a while, drawn or not.
"""

import sys

from browser import Browser
from pages import opened


def main(chromium, address, width, height, out):
    with Browser(chromium, int(width), int(height)) as browser:
        state = opened(browser, address)
        if state != "drawn":
            return f"the page is {state}: {browser.messages()}"
        browser.picture(out)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
