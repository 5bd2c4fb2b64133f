"""The browser's page against the program: `python page.py HOST-SIM PAGE`, from the repository's root.

Opens the page from disk in Chromium and checks that its sentences are those of `replay` to the byte, for recordings
and settings alike; that it logs no error and asks no network; its looks at 1280 and 390 pixels, light and dark; files,
keys, fingers, slider, downloads; the truth that is edited there and read by the program; a scanner at a serial port
that the test plays; and the pages of `report --compare` and of `report LOG`.
"""

import json
import pathlib
import subprocess
import sys

from browser import Browser
import compare
import guard_page
import log_page
import serial_port
import truth

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Full scans: the page knows no sweeps of the guard.
RECORDINGS = sorted(
    p.with_suffix("")
    for p in ROOT.glob("recordings/*.sigmf-meta")
    if "stairscan:mode" not in json.loads(p.read_text())["global"]
)
SCRATCH = ROOT / "target" / "browser"
TAB, ENTER, RIGHT, HOME = 9, 13, 39, 36


def run(program: str, *arguments) -> str:
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, cwd=ROOT)
    assert done.returncode in (0, 1) and done.stdout, done.stderr
    return done.stdout


def sentences(program: str, *arguments) -> list[str]:
    """The sentences that `replay` prints."""
    lines = run(program, "replay", *arguments).splitlines()
    return [line.strip() for line in lines if line.startswith("  $PSTR")]


def told(browser: Browser, name: str) -> list[str]:
    """The sentences that the page shows of a recording, scan after scan, read from its own element."""
    browser.js("choose(data.recordings.findIndex((r) => r.name === arguments[0]))", name)
    count = browser.js("return recording().scans.length")
    lines = []
    for scan in range(count):
        browser.js("state.scan = arguments[0]; show()", scan)
        lines += browser.js("return document.getElementById('sentences').textContent").split("\n")
    return lines


def pair(path: pathlib.Path) -> list[pathlib.Path]:
    return [path.with_name(path.name + suffix) for suffix in (".sigmf-meta", ".sigmf-data")]


def files_input(browser: Browser, files: list[pathlib.Path]):
    field = browser.driver.find_element("id", "files")
    field.send_keys("\n".join(str(f) for f in files))
    browser.wait("document.getElementById('files').files.length === 0", "the files are taken")
    browser.settle()


def check_sentences(program: str, browser: Browser):
    """Built in, through the file input, dropped, as arrays: the bytes of `replay`."""
    expected = {path.name: sentences(program, path) for path in RECORDINGS}
    for name, lines in expected.items():
        assert lines and told(browser, name) == lines, f"built in: {name}"
    files_input(browser, [file for path in RECORDINGS for file in pair(path)])
    for name, lines in expected.items():
        assert told(browser, name) == lines, f"file input: {name}"
    again = SCRATCH / "dropped"
    for path in RECORDINGS:
        for old, new in zip(pair(path), pair(again / path.name)):
            again.mkdir(exist_ok=True)
            # Under another name, so that it is no recording that the page has already.
            new.with_name(f"dropped-{new.name}").write_bytes(old.read_bytes())
    browser.drop(sorted(again.iterdir()))
    last = f"dropped-{RECORDINGS[-1].name}"
    browser.wait(f"data.recordings.some((r) => r.name === '{last}' && r.scans.length)", "dropped files")
    browser.settle()
    for name, lines in expected.items():
        assert told(browser, f"dropped-{name}") == lines, f"dropped: {name}"


def check_arrays(program: str, browser: Browser):
    """An array with the keys of a recording beside it, and one by itself with the page's settings."""
    path = RECORDINGS[2]
    array = SCRATCH / "array.npy"
    run(program, "convert", path, "-o", array, "--force")
    meta = SCRATCH / "array.sigmf-meta"
    meta.write_bytes(pair(path)[0].read_bytes())
    expected = sentences(program, path)
    files_input(browser, [array, meta])
    assert told(browser, "array") == expected, "array with metadata"
    alone = SCRATCH / "alone.npy"
    alone.write_bytes(array.read_bytes())
    files_input(browser, [alone])
    # The paper's instrument and angles, which that recording was made with.
    assert told(browser, "alone") == expected, "array by itself"
    news = browser.js("return document.getElementById('news').textContent")
    assert news.startswith("alone.npy: an array holds samples only"), news
    assert browser.js("return document.getElementById('set').open"), "the assumed settings are shown"
    # Half of full scale as full scale: what is beyond is refused, twice as much is half the level.
    set_fields(browser, {"full_scale": "1"})
    assert "full scale of" in browser.js("return recording().error"), "beyond full scale"
    set_fields(browser, {"full_scale": ""})
    assert told(browser, "alone") == expected, "full scale of the format"
    set_fields(browser, {"angle_step_deg": "0"})
    assert "angle step: found 0" in browser.js("return recording().error")
    set_fields(browser, {"angle_step_deg": ""})


def set_fields(browser: Browser, values: dict[str, str | bool]):
    """Fills the form as a hand does, field by field."""
    for name, value in values.items():
        browser.js(
            """const field = document.getElementById("settings-of-scan").elements[arguments[0]];
            if (field.type === "checkbox") field.checked = arguments[1]; else field.value = arguments[1];
            field.dispatchEvent(new Event("change", { bubbles: true }));""",
            name,
            value,
        )
    browser.settle()


def check_settings(program: str, browser: Browser):
    """A changed setting changes the answer as it does with `replay`."""
    path = RECORDINGS[2]
    before = told(browser, path.name)
    set_fields(browser, {"estimator": "paper", "seed": "7"})
    expected = sentences(program, path, "--estimator", "paper", "--seed", "7")
    assert told(browser, path.name) == expected != before, "paper's estimator"
    browser.driver.find_element("id", "set").get_attribute("open") or browser.js("document.getElementById('set').open = true")
    browser.driver.find_element("css selector", "#settings-of-scan [type=reset]").click()
    browser.js("return new Promise((done) => setTimeout(done, 50))")
    browser.settle()
    assert told(browser, path.name) == before, "as recorded"
    document = json.loads(pair(path)[0].read_text())
    document["global"]["stairscan:mount_height_m"] = 0.43
    document["global"]["stairscan:mirror_offset_m"] = 0.25
    document["global"]["stairscan:beamwidth_deg"] = 4.0
    other = SCRATCH / "other"
    pair(other)[0].write_text(json.dumps(document))
    pair(other)[1].write_bytes(pair(path)[1].read_bytes())
    set_fields(browser, {"mount_height_m": "43", "mirror_offset_m": "25", "beamwidth_deg": "4"})
    expected = sentences(program, other)
    assert told(browser, path.name) == expected != before, "mount"
    document["global"]["stairscan:scan_plane"] = "height"
    pair(other)[0].write_text(json.dumps(document))
    set_fields(browser, {"plane": "height"})
    assert told(browser, path.name) == sentences(program, other), "plane"
    set_fields(browser, {"mount_height_m": "-3"})
    assert "mount height: found -0.03" in browser.js("return document.getElementById('summary').textContent")
    set_fields(browser, {"mount_height_m": "", "mirror_offset_m": "", "beamwidth_deg": "", "plane": ""})
    assert told(browser, path.name) == before, "empty fields"


def check_bad_files(browser: Browser):
    """A bad file is named with its fault, and costs no other."""
    bad = SCRATCH / "bad"
    bad.mkdir(exist_ok=True)
    files = {
        "text.npy": b"no array",
        "half.sigmf-meta": b"{}",
        "cut.sigmf-meta": b"{\"global\": ",
        "cut.sigmf-data": b"1234",
        "song.mp3": b"la",
    }
    for name, content in files.items():
        (bad / name).write_bytes(content)
    files_input(browser, [bad / name for name in files])
    news = browser.js("return document.getElementById('news').textContent")
    assert "song.mp3: expected" in news and "half.sigmf-data: missing" in news, news
    errors = browser.js("return Object.fromEntries(data.recordings.map((r) => [r.name, r.error]))")
    assert "numpy" in errors["text"] and "cut.sigmf-meta" in errors["cut"], errors
    browser.js("choose(0)")


def check_sequence(program: str, browser: Browser):
    """The slider goes through the scans, by keys, too."""
    path = SCRATCH / "approach"
    scene = ROOT / "scenes" / "approach.toml"
    run(program, "simulate", scene, "--approach", 3, "--step", 0.15, "--force", "-o", path)
    expected = sentences(program, path)
    assert told(browser, "approach") == expected, "sequence"
    browser.js("state.scan = 0; show(); document.getElementById('scan').focus()")
    assert browser.js("return !document.getElementById('scans').hidden")
    for scan in (2, 3):
        browser.key("ArrowRight", RIGHT)
        shown = browser.js("return document.getElementById('scan-number').textContent")
        assert shown == f"{scan} of 3", shown
    assert browser.js("return document.getElementById('sentences').textContent.split('\\n')[0]") in expected
    set_fields(browser, {"single": True})
    assert told(browser, "approach") == sentences(program, path, "--single"), "single"
    set_fields(browser, {"single": False})


def check_downloads(program: str, browser: Browser):
    """The table is that of `convert`, and what the page shows; the picture is a PNG of what is drawn."""
    name = RECORDINGS[2].name
    browser.js("choose(data.recordings.findIndex((r) => r.name === arguments[0]))", name)
    browser.driver.find_element("id", "csv").click()
    table = browser.downloaded(f"{name}.csv")
    file = SCRATCH / "table.csv"
    run(program, "convert", RECORDINGS[2], "-o", file, "--force")
    assert table == file.read_bytes(), "CSV"
    rows = [line.split(",") for line in table.decode().splitlines()]
    column = {key: k for k, key in enumerate(rows[0])}
    shown = browser.js("return [...document.querySelectorAll('#steps tr')].slice(1).map((r) => [...r.cells].map((c) => c.textContent))")
    assert len(shown) == len(rows) - 1 > 0
    for row, cells in zip(rows[1:], shown):
        for key, cell in (("distance_m", cells[1]), ("height_m", cells[2])):
            in_cm = 100 * float(row[column[key]])
            assert abs(in_cm - float(cell.split(" ")[0].replace("−", "-"))) < 0.0501, (key, row, cells)
        assert f"{row[column['quality']]} %" == cells[5]
    browser.driver.find_element("id", "png").click()
    png = browser.downloaded(f"{name}.png")
    assert png.startswith(b"\x89PNG\r\n\x1a\n") and len(png) > 20_000, len(png)
    (SCRATCH / "picture.png").write_bytes(png)


def check_keys(browser: Browser):
    """Every control is reached by Tab, shows that it is, and works without a mouse."""
    browser.js("choose(0); document.activeElement?.blur(); document.getElementById('set').open = true; scrollTo(0, 0)")
    wanted = browser.js(
        """return [...document.querySelectorAll("button, input, select, summary, canvas[tabindex]")]
        .filter((e) => e.checkVisibility() && !e.disabled).length"""
    )
    seen = []
    for _ in range(wanted + 5):
        browser.key("Tab", TAB)
        mark = browser.js(
            """const e = document.activeElement;
            if (e === document.body) return null;
            e.dataset.seen = "yes";
            return [e.id || e.name || e.textContent.slice(0, 20), getComputedStyle(e).outlineStyle !== "none"];"""
        )
        if mark:
            assert mark[1], f"{mark[0]}: focus does not show"
            seen.append(mark[0])
    missed = browser.js(
        """return [...document.querySelectorAll("button, input, select, summary, canvas[tabindex]")]
        .filter((e) => e.checkVisibility() && !e.disabled && !e.dataset.seen).map((e) => e.id || e.name || e.textContent)"""
    )
    assert not missed, f"not reached by Tab: {missed}; reached: {seen}"
    browser.js("document.querySelectorAll('#index button')[2].focus()")
    browser.key("Enter", ENTER, text="\r")
    assert browser.js("return state.recording") == 2, "Enter on the index"
    browser.js("document.getElementById('side').focus()")
    before = browser.js("return [...state.place]")
    browser.key("ArrowRight", RIGHT)
    after = browser.js("return [...state.place]")
    assert abs(after[0] - before[0] - 0.01) < 1e-9, (before, after)
    assert not browser.js("return document.getElementById('tip').hidden")


def check_touch(browser: Browser):
    """A finger points at a place, chooses a recording and a layer."""
    browser.screen(390, touch=True)
    browser.js("choose(0); document.getElementById('side').scrollIntoView({ block: 'center' })")
    box = browser.js("const b = document.getElementById('side').getBoundingClientRect(); return [b.x, b.y, b.width, b.height]")
    before = browser.js("return document.getElementById('profile-title').textContent")
    browser.touch(box[0] + 0.7 * box[2], box[1] + 0.3 * box[3])
    after = browser.js("return document.getElementById('profile-title').textContent")
    assert before != after and not browser.js("return document.getElementById('tip').hidden"), (before, after)
    spot = "const b = arguments[0].getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]"
    button = browser.driver.find_elements("css selector", "#index button")[1]
    browser.js("arguments[0].scrollIntoView({ block: 'center' })", button)
    browser.touch(*browser.js(spot, button))
    browser.wait("state.recording === 1", "a recording chosen by touch")
    small = browser.js(
        """return [...document.querySelectorAll("#index button, #bench button, #bench select")]
        .filter((e) => e.checkVisibility()).filter((e) => e.getBoundingClientRect().height < 30).map((e) => e.id || e.textContent)"""
    )
    assert not small, f"too small for a finger: {small}"


def check_policy(browser: Browser):
    """The page may not load anything, were it asked to: a request does not leave the browser."""
    blocked = browser.js(
        """return new Promise((done) => {
            document.addEventListener("securitypolicyviolation", (e) => done(e.blockedURI), { once: true });
            fetch("http://127.0.0.1:9/x").catch(() => setTimeout(() => done("not by the policy"), 500));
        })"""
    )
    assert blocked.startswith("http://127.0.0.1:9/"), blocked
    assert browser.complaints(), "the console is silent about a violation"


def luminance(colour: str) -> float:
    red, green, blue = [int(v) / 255 for v in colour[colour.index("(") + 1 : -1].split(",")[:3]]
    linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in (red, green, blue)]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def check_looks(browser: Browser):
    """1280 and 390 pixels, light and dark: nothing overflows, and text stands out (WCAG 2: 4.5 to 1)."""
    for width in (1280, 390):
        for scheme in ("light", "dark"):
            browser.screen(width, scheme=scheme, touch=width < 500)
            for name in ("stair_a", "approach", "descending"):
                browser.js("choose(data.recordings.findIndex((r) => r.name === arguments[0]))", name)
                browser.js("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
                # Not `innerWidth`, which grows with what overflows on a phone.
                wide = browser.js("return document.documentElement.scrollWidth")
                assert wide <= width, f"{name} at {width} px: {wide} pixels wide"
                # Neither tables nor numbers are cut: a cell without a space is one line.
                cut = browser.js(
                    """const tables = [...document.querySelectorAll("#pane .table")];
                    const broken = [...document.querySelectorAll("#steps td, #rivals td, #echoes td")]
                        .filter((cell) => !/\\s/.test(cell.textContent) && cell.getClientRects().length)
                        .filter((cell) => { const r = document.createRange(); r.selectNodeContents(cell); return r.getClientRects().length > 1; });
                    return [...tables.filter((t) => t.scrollWidth > t.clientWidth), ...broken].map((e) => e.textContent.slice(0, 40));"""
                )
                assert not cut, f"{name} at {width} px: cut: {cut}"
                browser.shot(SCRATCH / f"{name}-{width}-{scheme}.png")
            paper = luminance(browser.js("return getComputedStyle(document.body).backgroundColor"))
            assert (paper < 0.1) == (scheme == "dark"), (scheme, paper)
            for place in ("body", ".hint", "#status", "th", "#advice", "label", "summary"):
                ink = luminance(browser.js("return getComputedStyle(document.querySelector(arguments[0])).color", place))
                contrast = (max(paper, ink) + 0.05) / (min(paper, ink) + 0.05)
                assert contrast >= 4.5, f"{place}, {scheme}: contrast {contrast:.1f}"
            drawn = browser.js(
                """const side = document.getElementById("side");
                const copy = Object.assign(document.createElement("canvas"), { width: side.width, height: side.height });
                const g = copy.getContext("2d", { willReadFrequently: true });
                g.drawImage(side, 0, 0);
                return new Set(new Uint32Array(g.getImageData(0, 0, copy.width, copy.height).data.buffer)).size"""
            )
            assert drawn > 50, f"{width}, {scheme}: the side view has {drawn} colours"
    browser.screen(1280)


def main():
    program, page = sys.argv[1], pathlib.Path(sys.argv[2])
    size = page.stat().st_size
    assert size <= 3_000_000, f"{page}: {size} bytes"
    SCRATCH.mkdir(parents=True, exist_ok=True)
    with Browser(page) as browser:
        browser.before_load(serial_port.FAKE)
        browser.open()
        for check in (check_sentences, check_arrays, check_settings, check_sequence, check_downloads):
            check(program, browser)
            print(f"{check.__name__}: passed", flush=True)
        for check in (check_bad_files, check_keys, check_touch, check_looks):
            check(browser)
            print(f"{check.__name__}: passed", flush=True)
        truth.check(program, browser, RECORDINGS[-1], SCRATCH / "truth")
        print("truth: passed", flush=True)
        serial_port.check(browser, sentences(program, ROOT / "recordings/stair_a"))
        print("serial port: passed")
        complaints, addresses = browser.complaints(), browser.addresses()
        assert not complaints, complaints
        assert not addresses, f"asked for: {addresses}"
        check_policy(browser)
    with Browser(page) as browser:
        # A browser without WebSerial says so.
        browser.before_load("delete Navigator.prototype.serial;")
        browser.open()
        browser.js("document.getElementById('live').open = true")
        assert browser.js("return document.getElementById('live-none').checkVisibility() && !('serial' in navigator)")
        assert not browser.complaints()
    compare.check(program, ROOT / "recordings", SCRATCH / "approach", SCRATCH)
    print("compare: passed", flush=True)
    answer = sentences(program, ROOT / "recordings/stair_a")
    log_page.check(answer, lambda *arguments: run(program, "report", *arguments), SCRATCH)
    print("log: passed", flush=True)
    guard_page.check(
        ROOT / "recordings/guard_kerb", lambda *arguments: run(program, "report", *arguments), SCRATCH
    )
    print("guard sweeps: passed", flush=True)
    print(f"the page ({size} bytes) says what replay says, at every width, without a network")


main()
