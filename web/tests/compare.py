"""The page of `report --compare` in Chromium: differences first, both views beside each other or, on a phone, stacked."""

import pathlib
import subprocess

from browser import Browser

RIGHT = 39
BOXES = """return ["-a", "-b"].map((suffix) => {
    const b = document.getElementById("pane" + suffix).getBoundingClientRect();
    return [b.x, b.y, b.width, b.bottom];
})"""


def written(program: str, page: pathlib.Path, *arguments) -> str:
    """Writes the page, and returns what the program prints."""
    words = [program, "report", *map(str, arguments), "--compare", "--force", "-o", str(page)]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def rows(browser: Browser) -> list[list[str]]:
    """The table of differences, without its head."""
    script = "return [...document.querySelectorAll('#differing tr')].slice(1).map((r) => [...r.cells].map((c) => c.textContent))"
    return browser.js(script)


def load(browser: Browser, page: pathlib.Path):
    browser.driver.get(page.absolute().as_uri())


def check(program: str, recordings: pathlib.Path, approach: pathlib.Path, scratch: pathlib.Path):
    page = scratch / "compare.html"
    with Browser(page) as browser:
        # The browser's own first page loads things of its own.
        browser.driver.get("about:blank")
        browser.driver.get_log("performance")
        told = written(program, page, recordings / "stair_a", "--estimator", "paper")
        load(browser, page)
        seen = rows(browser)
        # What the program prints is what the page says.
        printed = [line.strip() for line in told.splitlines() if line.startswith("  ")]
        assert len(seen) == len(printed) > 5, (seen, printed)
        for (what, first, second, *_), line in zip(seen, printed):
            assert line.startswith(f"{what}: {first} | {second}"), (line, what)
        heights = [row for row in seen if row[0] == "step 3, height"]
        assert heights and heights[0][3].startswith("−") and " / " in heights[0][4], seen
        # Differences first.
        order = browser.js("return document.getElementById('differences').getBoundingClientRect().bottom")
        (ax, ay, aw, _), (bx, by, _, _) = browser.js(BOXES)
        assert order <= ay == by and bx >= ax + aw, "side by side"
        # The place that is pointed at is one in both.
        browser.js("document.getElementById('side-a').focus()")
        browser.key("ArrowRight", RIGHT)
        titles = browser.js("return ['-a', '-b'].map((s) => document.getElementById('profile-title' + s).textContent)")
        assert titles[0] == titles[1] and "row" in titles[0], titles
        scales = browser.js("return panes.map((p) => p.frame.X(1) - p.frame.X(0))")
        assert abs(scales[0] - scales[1]) < 1e-6, "one scale"
        for width in (1280, 390):
            for scheme in ("light", "dark"):
                browser.screen(width, scheme=scheme, touch=width < 500)
                wide = browser.js("return document.documentElement.scrollWidth")
                assert wide <= width, f"{width} px: {wide} pixels wide"
                cut = browser.js("return [...document.querySelectorAll('.table')].filter((t) => t.scrollWidth > t.clientWidth).length")
                assert not cut, f"{width} px: a table is cut"
                browser.shot(scratch / f"compare-{width}-{scheme}.png")
        (ax, _, _, bottom), (bx, by, _, _) = browser.js(BOXES)
        assert ax == bx and by >= bottom, "stacked"
        browser.screen(1280)
        assert "nothing differs" in written(program, page, recordings / "stair_a", "--with", "seed=1")
        load(browser, page)
        assert not rows(browser) and browser.js("return document.getElementById('same').checkVisibility()")
        written(program, page, approach, recordings / "stair_a")
        load(browser, page)
        assert rows(browser)[0][1] == "number of scans"
        browser.js("state.scan = 1; show()")
        summary = browser.js("return document.getElementById('summary-b').textContent")
        assert summary == "the recording holds 1 scan", summary
        assert browser.js("return document.getElementById('side-a').checkVisibility() && !document.getElementById('side-b').checkVisibility()")
        assert not browser.complaints()
        assert not [url for url in browser.addresses() if not url.startswith("file:")]
