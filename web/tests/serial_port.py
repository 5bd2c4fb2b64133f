"""A serial port that the test plays in the place of the browser's: sentences, noise, a broken stream, a pulled cable."""

from browser import Browser

# In the page before its own script: `fakePort.give(bytes)`, `.fail(name)` and `.pull()` are the scanner's side.
FAKE = """
class FakePort {
  constructor() { this.opened = null; }
  async open({ baudRate }) { this.opened = baudRate; this.start(); }
  start() {
    this.readable = new ReadableStream({
      start: (controller) => { this.controller = controller; },
      cancel: () => { this.readable = null; },
    });
  }
  getInfo() { return { usbVendorId: 0x0403, usbProductId: 0x6001 }; }
  async close() { this.opened = null; this.readable = null; }
  give(text) { this.controller.enqueue(Uint8Array.from(text, (c) => c.charCodeAt(0))); }
  fail(name) {
    const broken = this.controller;
    this.start();
    broken.error(new DOMException("a byte was damaged", name));
  }
  pull() {
    this.readable = null;
    this.controller.error(new DOMException("The device has been lost.", "NetworkError"));
  }
}
window.fakePort = new FakePort();
window.fakeSerial = { listeners: [], addEventListener(kind, listener) { this.listeners.push(listener); } };
Object.defineProperty(Navigator.prototype, "serial", {
  configurable: true,
  value: Object.assign(window.fakeSerial, { requestPort: async () => window.fakePort }),
});
"""


def shown(browser: Browser) -> str:
    return browser.js("return document.getElementById('live-state').textContent")


def status(browser: Browser) -> str:
    return browser.js("return document.getElementById('status').textContent")


def check(browser: Browser, sentences: list[str]):
    """A real scan's sentences, whole, damaged and cut into pieces, then a cable that is pulled."""
    browser.js("document.getElementById('live').open = true")
    browser.driver.find_element("id", "connect").click()
    browser.wait("fakePort.opened === 115200", "the port is open")
    browser.wait("recording().name === 'serial port 0403:6001'", "the port is shown")
    text = "\r\n".join(sentences) + "\r\n"
    # Cut anywhere: a port knows nothing of lines.
    for k in range(0, len(text), 37):
        browser.js("fakePort.give(arguments[0])", text[k : k + 37])
    browser.wait("recording().scans.length === 1", "the answer")
    assert browser.js("return document.getElementById('sentences').textContent").split("\n") == sentences
    assert status(browser) == "✓ ok"
    assert "0 damaged" in shown(browser), shown(browser)
    damaged = sentences[0].replace(",ok,", ",OK,", 1)
    browser.js("fakePort.give(arguments[0] + '\\r\\n')", damaged)
    browser.wait("document.getElementById('live-state').textContent.includes('1 damaged sentence')", "the damage")
    mark = browser.js("return document.querySelector('#live-log .damaged').textContent")
    assert mark == damaged, mark
    # The answer from before stays, and a broken stream is followed by the next one.
    browser.js("fakePort.fail('FramingError')")
    browser.wait("fakePort.readable && fakePort.readable.locked", "the next stream")
    # Two answers at once are two answers.
    more = sentences_of(sentences, 2) + sentences_of(sentences, 3)
    browser.js("fakePort.give(arguments[0])", "\r\n".join(more) + "\r\n")
    browser.wait("recording().scans.length === 3 && state.scan === 2", "two more answers")
    assert browser.js("return document.getElementById('scan-number').textContent") == "3 of 3"
    assert status(browser) == "✓ ok"
    browser.js("state.scan = 0; show()")
    assert status(browser) == "earlier answer"
    browser.js("state.scan = 2; show()")
    browser.wait("document.getElementById('live-state').textContent.includes('silent')", "silence")
    # An answer that is stale must not look like one to act on.
    browser.wait("document.getElementById('status').textContent === '✕ stale'", "staleness")
    mark = browser.js("return document.querySelector('#index [aria-current=true] .mark').textContent")
    assert mark == "✕ stale", mark
    assert "It was ok" in browser.js("return document.getElementById('advice').textContent")
    browser.js("fakePort.pull()")
    browser.wait("document.getElementById('live-state').textContent.includes('has gone')", "the pulled cable")
    assert browser.js("return document.getElementById('connect').textContent").startswith("Connect")
    assert "unplugged" in shown(browser), shown(browser)
    browser.js("fakeSerial.listeners.forEach((listener) => listener({ target: fakePort }))")
    browser.wait("fakePort.opened === 115200", "the port is opened again")
    browser.js("fakePort.give(arguments[0])", text)
    browser.wait("document.getElementById('status').textContent === '✓ ok'", "an answer anew")
    browser.driver.find_element("id", "connect").click()
    browser.wait("document.getElementById('connect').textContent.startsWith('Connect')", "disconnected")


def sentences_of(sentences: list[str], scan: int) -> list[str]:
    """The same sentences of another scan, closed anew."""
    from zlib import crc32

    lines = []
    for line in sentences:
        words = line[1 : line.index("*")].split(",")
        words[2] = str(scan)
        body = ",".join(words)
        lines.append(f"${body}*{crc32(body.encode()):08X}")
    return lines
