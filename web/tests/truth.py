"""The truth of a recording, edited in the page: dragged, by keys, in its list; saved, and read by the program."""

import json
import pathlib
import subprocess

from browser import Browser

RIGHT, UP, DELETE, INSERT, PAGE_DOWN = 39, 38, 46, 45, 34
PLACE = """const { X, Y } = panes[0].frame;
const b = document.getElementById("side").getBoundingClientRect();
return [b.x + X(arguments[0]), b.y + Y(arguments[1])];"""


def open_editor(browser: Browser, name: str):
    browser.js("choose(data.recordings.findIndex((r) => r.name === arguments[0]))", name)
    browser.js("document.getElementById('truth').open = true")
    browser.wait("document.body.classList.contains('truth')", "the editor is open")
    browser.js("document.getElementById('side').scrollIntoView({ block: 'center' })")


def listed(browser: Browser) -> list[list[float | bool]]:
    """Distance and height of every step of the list, centimetres, and whether it counts."""
    return browser.js(
        """return [...document.querySelectorAll("#truth-steps tr")].slice(1).map((row) => {
            const [x, y, counted] = row.querySelectorAll("input");
            return [Number(x.value), Number(y.value), counted.checked];
        })"""
    )


def fill(browser: Browser, row: int, field: int, value: str):
    """Types into a field of the list, or ticks it."""
    browser.js(
        """const field = document.querySelectorAll("#truth-steps tr")[arguments[0]].querySelectorAll("input")[arguments[1]];
        if (field.type === "checkbox") field.click();
        else { field.value = arguments[2]; field.dispatchEvent(new Event("change", { bubbles: true })); }""",
        row,
        field,
        value,
    )


def drag(browser: Browser, start: tuple[float, float], end: tuple[float, float]):
    """Drags with the mouse from one place of the side view to another, metres."""
    places = [browser.js(PLACE, *place) for place in (start, end)]
    (x0, y0), (x1, y1) = places
    browser.cdp("Input.dispatchMouseEvent", type="mousePressed", x=x0, y=y0, button="left", buttons=1, clickCount=1)
    for part in (0.3, 0.7, 1.0):
        x, y = x0 + part * (x1 - x0), y0 + part * (y1 - y0)
        browser.cdp("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y, button="left", buttons=1)
    browser.cdp("Input.dispatchMouseEvent", type="mouseReleased", x=x1, y=y1, button="left", clickCount=1)


def saved(browser: Browser, name: str) -> dict:
    """The metadata that the page saves."""
    (browser.downloads / f"{name}.sigmf-meta").unlink(missing_ok=True)
    browser.driver.find_element("id", "truth-save").click()
    meta = json.loads(browser.downloaded(f"{name}.sigmf-meta"))
    browser.settle()
    return meta


def scored(program: str, scratch: pathlib.Path, meta: dict, samples: bytes) -> dict:
    """The score by the program of a recording with these metadata."""
    scratch.mkdir(exist_ok=True)
    for old in scratch.iterdir():
        old.unlink()
    (scratch / "edited.sigmf-meta").write_text(json.dumps(meta))
    (scratch / "edited.sigmf-data").write_bytes(samples)
    done = subprocess.run([program, "score", str(scratch), "--format", "json"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def check_drag(program: str, browser: Browser, path: pathlib.Path, scratch: pathlib.Path):
    """A step dragged with the mouse is where it was let go, in list, metadata and score."""
    samples = path.with_name(path.name + ".sigmf-data").read_bytes()
    before = json.loads(path.with_name(path.name + ".sigmf-meta").read_text())
    open_editor(browser, path.name)
    steps = before["global"]["stairscan:truth"]["steps"]
    assert len(listed(browser)) == len(steps) == 3
    right = scored(program, scratch, before, samples)
    assert not right["not_exact_or_wrong"], right
    second = (steps[1]["distance_m"], steps[1]["height_m"])
    drag(browser, second, (second[0] + 0.2, second[1] + 0.05))
    moved = listed(browser)
    # A pixel is some millimetres.
    assert abs(moved[1][0] - 100 * second[0] - 20) < 1 and abs(moved[1][1] - 100 * second[1] - 5) < 1, moved
    meta = saved(browser, path.name)
    truth = meta["global"]["stairscan:truth"]
    assert truth["direction"] == "up" and truth["steps"][0] == steps[0] and truth["steps"][2] == steps[2], truth
    assert abs(100 * truth["steps"][1]["distance_m"] - moved[1][0]) < 0.06, truth
    assert "snr_db" not in truth["steps"][1], "of a step that was moved it is not known"
    before["global"]["stairscan:truth"] = meta["global"]["stairscan:truth"]
    assert meta == before, "nothing but the truth has changed"
    [told] = scored(program, scratch, meta, samples)["not_exact_or_wrong"]
    assert not told["exact"] and told["matched"] == 2 and len(told["false_m"]) == 1, told
    # The page judges by the same truth.
    flaws = browser.js("return scan().flaws")
    assert flaws == told["wrong_because"], (flaws, told)


def check_keys(program: str, browser: Browser, path: pathlib.Path, scratch: pathlib.Path):
    """Keys choose, move, remove and add steps; the list holds exact values, and says what counts."""
    samples = path.with_name(path.name + ".sigmf-data").read_bytes()
    browser.driver.find_element("id", "truth-discard").click()
    browser.js("return new Promise((done) => setTimeout(done, 50))")
    browser.settle()
    steps = listed(browser)
    browser.js("document.getElementById('side').focus()")
    browser.key("PageDown", PAGE_DOWN)
    browser.key("ArrowRight", RIGHT)
    browser.key("ArrowUp", UP, modifiers=8)
    moved = listed(browser)
    assert abs(moved[0][0] - steps[0][0] - 1) < 0.01 and abs(moved[0][1] - steps[0][1] - 5) < 0.01, (steps, moved)
    browser.key("Delete", DELETE)
    assert listed(browser) == steps[1:]
    browser.js("state.place = [0.5, 0.165]")
    browser.key("Insert", INSERT)
    assert listed(browser) == [[50, 16.5, True], *steps[1:]]
    fill(browser, 3, 2, "")
    fill(browser, 2, 0, "77.9")
    fill(browser, 1, 1, "-20")
    news = "document.getElementById('news').textContent"
    browser.driver.find_element("id", "truth-save").click()
    browser.wait(f"{news}.includes('at once')", "steps up and down are refused")
    fill(browser, 1, 1, "16.5")
    meta = saved(browser, path.name)
    truth = meta["global"]["stairscan:truth"]
    assert [s["distance_m"] for s in truth["steps"]] == [0.5, 0.779], truth
    assert len(truth["uncounted"]) == 1, truth
    # What is not counted is neither missed nor made up.
    score = scored(program, scratch, meta, samples)
    assert not score["not_exact_or_wrong"], score


def check_others(program: str, browser: Browser, scratch: pathlib.Path):
    """A sequence, whose steps stand still in the world; and an array, which becomes a recording."""
    open_editor(browser, "approach")
    travel = browser.js("return chosen().edit.travel")
    assert travel[0] < travel[1] < travel[2], travel
    before = browser.js("return recording().scans.map((s) => s.truth.steps[0].distance_m)")
    fill(browser, 1, 0, str(100 * before[0] + 3))
    meta = saved(browser, "approach")
    after = [scan["steps"][0]["distance_m"] for scan in meta["global"]["stairscan:truth_scans"]]
    assert all(abs(b - a - 0.03) < 0.002 for a, b in zip(before, after)), (before, after)
    samples = (scratch.parent / "approach.sigmf-data").read_bytes()
    assert scored(program, scratch, meta, samples), "the program reads it"
    open_editor(browser, "alone")
    assert listed(browser) == []
    browser.driver.find_element("id", "truth-add").click()
    meta = saved(browser, "alone")
    assert meta["global"]["stairscan:truth"]["steps"] == [{"distance_m": 0.8, "height_m": 0.17}]
    assert scored(program, scratch, meta, browser.downloaded("alone.sigmf-data")), "the program reads it"


def check_touch(browser: Browser, path: pathlib.Path):
    """A finger drags a step, and the page does not scroll meanwhile."""
    browser.screen(390, touch=True)
    open_editor(browser, path.name)
    [x, y, _] = listed(browser)[0]
    start, end = [browser.js(PLACE, x / 100 + off, y / 100) for off in (0.0, 0.1)]
    top = browser.js("return scrollY")
    point = lambda place: [{"x": place[0], "y": place[1]}]
    browser.cdp("Input.dispatchTouchEvent", type="touchStart", touchPoints=point(start))
    browser.cdp("Input.dispatchTouchEvent", type="touchMove", touchPoints=point(end))
    assert browser.js("return scrollY") == top
    browser.cdp("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    assert abs(listed(browser)[0][0] - x - 10) < 1.5, (x, listed(browser))
    small = browser.js("return [...document.querySelectorAll('#truth button')].filter((b) => b.getBoundingClientRect().height < 30).length")
    assert not small, "too small for a finger"
    browser.shot(path.parents[1] / "target/browser/truth-390.png")
    browser.screen(1280)
    browser.shot(path.parents[1] / "target/browser/truth-1280.png")


def check(program: str, browser: Browser, path: pathlib.Path, scratch: pathlib.Path):
    check_drag(program, browser, path, scratch)
    check_keys(program, browser, path, scratch)
    check_others(program, browser, scratch)
    check_touch(browser, path)
    browser.driver.find_element("id", "truth-discard").click()
    browser.js("return new Promise((done) => setTimeout(done, 50))")
    browser.settle()
    browser.js("document.getElementById('truth').open = false")
