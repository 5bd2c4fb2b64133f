"""The page of guard sweeps, `report RECORDING`, in the same browser: readable on a phone."""

import pathlib

from browser import Browser

# Sizes on the screen: of the page and the strip, of the strip's text, of the longest line of the sentences and its room.
SIZES = """
const strip = document.querySelector('picture img'), lines = document.querySelector('pre');
const drawn = new DOMParser().parseFromString(decodeURIComponent(strip.currentSrc.split(',').slice(1).join(',')), 'text/html');
const svg = drawn.querySelector('svg'), scale = strip.getBoundingClientRect().width / svg.viewBox.baseVal.width;
return {page: document.documentElement.scrollWidth, text: scale * parseFloat(svg.getAttribute('font-size')),
        strip: strip.getBoundingClientRect().right, lines: lines.scrollWidth, room: lines.clientWidth};
"""


def check(recording: pathlib.Path, report, scratch: pathlib.Path):
    """`report` runs `host-sim report` with further arguments."""
    page = scratch / "guard.html"
    report(recording, "--force", "-o", page)
    with Browser(page) as browser:
        for width in (1280, 390):
            browser.screen(width, touch=width == 390)
            browser.driver.get(page.absolute().as_uri())
            browser.wait("document.querySelector('picture img')?.complete", "the strip")
            sizes = browser.js(SIZES)
            assert sizes["page"] <= width and sizes["strip"] <= width, (width, sizes)
            assert sizes["text"] >= 11.5, (width, sizes)
            assert sizes["lines"] <= sizes["room"], (width, sizes)
            browser.shot(page.with_name(f"guard-{width}.png"))
        assert not browser.complaints()
