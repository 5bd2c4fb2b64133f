"""The page of a log, `report LOG`, in the same browser."""

import pathlib

from browser import Browser

# Red, green and blue of the canvas at a time, ms, and a distance, metres.
PIXEL = """
const [at, m] = arguments, scale = window.devicePixelRatio || 1;
return Array.from(context.getImageData((x(at) - 3) * scale, y(m) * scale, 1, 1).data).slice(0, 3);
"""


def check(answer: list[str], report, scratch: pathlib.Path):
    """`answer` holds the sentences of one answer, and `report` runs `host-sim report` with further arguments."""
    log, page = scratch / "answers.log", scratch / "answers.html"
    times = range(0, 50, 5)
    log.write_text("".join(f"12:00:{second:02} {line}\r\n" for second in times for line in answer))
    report(log, "--force", "-o", page)
    with Browser(page) as browser:
        browser.driver.get(page.absolute().as_uri())
        assert browser.js("return log.answers.length") == len(times)
        # The view begins a little before the log.
        shown = browser.js("return document.getElementById('span').textContent")
        assert shown.startswith("00:00:00.000 to 00:00:45"), shown
        assert not browser.complaints()
        # Silence follows each answer, and its free distance shows all the same.
        at, free_m = browser.js("return [log.answers[3].at, log.answers[3].free_m]")
        ink, ok = browser.js(PIXEL, at, free_m), bytes.fromhex(browser.js("return colour('ok')").strip("#"))
        assert ink == list(ok), (at, free_m, ink)
