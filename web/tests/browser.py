"""Chromium without a screen: the page opened from disk, what it logs and loads, keys, fingers and files."""

import base64
import json
import pathlib
import tempfile
import time

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service

ARGUMENTS = """--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking
--disable-component-update --disable-sync""".split()
PATIENCE_S = 120


class Browser:
    """One browser with a profile of its own, and downloads into a directory of its own."""

    def __init__(self, page: pathlib.Path):
        self.home = tempfile.TemporaryDirectory()
        self.downloads = pathlib.Path(self.home.name, "downloads")
        self.downloads.mkdir()
        options = Options()
        options.binary_location = "/usr/bin/chromium"
        for argument in ARGUMENTS:
            options.add_argument(argument)
        options.add_argument(f"--user-data-dir={self.home.name}/profile")
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
        self.driver.set_script_timeout(PATIENCE_S)
        self.cdp("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(self.downloads))
        self.page = page

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.driver.quit()
        self.home.cleanup()

    def cdp(self, command: str, **arguments):
        return self.driver.execute_cdp_cmd(command, arguments)

    def js(self, script: str, *arguments):
        return self.driver.execute_script(script, *arguments)

    def before_load(self, script: str):
        """Runs a script in every page before its own."""
        self.cdp("Page.addScriptToEvaluateOnNewDocument", source=script)

    def open(self):
        # The browser's own first page loads things of its own.
        self.driver.get("about:blank")
        self.driver.get_log("performance")
        self.driver.get(self.page.absolute().as_uri())
        self.settle()

    def wait(self, condition: str, what: str):
        """Waits until a JavaScript expression holds."""
        end = time.monotonic() + PATIENCE_S
        while not self.js(f"return Boolean({condition})"):
            assert time.monotonic() < end, f"{what}: did not come: {condition}"
            time.sleep(0.05)

    def settle(self):
        """Waits until everything is scanned."""
        idle = "bench.about && data.recordings.length && data.recordings.every((r) => !r.pending)"
        self.wait(f"{idle} && !document.body.classList.contains('busy')", "the scanner is done")

    def screen(self, width: int, height: int = 860, scheme: str = "light", touch: bool = False):
        self.cdp("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=touch)
        self.cdp("Emulation.setTouchEmulationEnabled", enabled=touch)
        scheme = [{"name": "prefers-color-scheme", "value": scheme}]
        self.cdp("Emulation.setEmulatedMedia", features=scheme)
        self.js("return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def shot(self, path: pathlib.Path):
        """A picture of the whole page."""
        size = self.js("return [innerWidth, document.documentElement.scrollHeight]")
        clip = {"x": 0, "y": 0, "width": size[0], "height": size[1], "scale": 1}
        shot = self.cdp("Page.captureScreenshot", captureBeyondViewport=True, clip=clip)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(base64.b64decode(shot["data"]))

    def key(self, key: str, code: int, **more):
        for kind in ("keyDown", "keyUp"):
            self.cdp("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code, **more)

    def touch(self, x: float, y: float):
        point = [{"x": x, "y": y}]
        self.cdp("Input.dispatchTouchEvent", type="touchStart", touchPoints=point)
        self.cdp("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])

    def drop(self, files: list[pathlib.Path]):
        """Drops files on the page, as a hand does."""
        data = {"items": [], "files": [str(f.absolute()) for f in files], "dragOperationsMask": 1}
        for kind in ("dragEnter", "dragOver", "drop"):
            self.cdp("Input.dispatchDragEvent", type=kind, x=200, y=200, data=data)

    def downloaded(self, name: str) -> bytes:
        path, end = self.downloads / name, time.monotonic() + PATIENCE_S
        while not path.exists():
            assert time.monotonic() < end, f"{name}: not downloaded"
            time.sleep(0.05)
        time.sleep(0.2)
        return path.read_bytes()

    def complaints(self) -> list[str]:
        """Errors and warnings on the console since the last call."""
        lines = self.driver.get_log("browser")
        return [line["message"] for line in lines if line["level"] in ("SEVERE", "WARNING")]

    def addresses(self) -> list[str]:
        """Everything that was asked for since the last call, but for the page itself and what stands in it."""
        found = []
        for line in self.driver.get_log("performance"):
            message = json.loads(line["message"])["message"]
            if message["method"] in ("Network.requestWillBeSent", "Network.webSocketCreated"):
                params = message["params"]
                found.append(params.get("request", params)["url"])
        own = self.page.absolute().as_uri()
        return [url for url in found if url != own and not url.startswith(("data:", "blob:"))]
