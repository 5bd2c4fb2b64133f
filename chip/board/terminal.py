"""The far end of the report port: lines that come, commands that go."""

import zlib

from model.units import seconds
from model.usart import Wire


def framed(body):
    """A command or sentence with its frame."""
    return f"${body}*{zlib.crc32(body.encode()):08X}\r\n"


def body(line):
    """A sentence's body where its checksum is right, else None."""
    text, star, crc = line.partition("*")
    if text.startswith("$") and star and crc == f"{zlib.crc32(text[1:].encode()):08X}":
        return text[1:]
    return None


class Terminal:
    """Lines of the report port with their times; `LIVE` sentences apart."""

    def __init__(self, chip, rate=115_200):
        self.chip = chip
        self.wire = Wire(chip.usart["USART2"], rate)
        self.lines, self.live = [], []
        self.partial = bytearray()
        self.read = 0
        chip.usart["USART2"].sink = self.on_byte

    def on_byte(self, byte, rate):
        if abs(rate / self.wire.rate - 1) > 0.025:
            self.chip.complain(f"report port sends at {rate:.0f} baud, not {self.wire.rate}")
        # A reader begins anew at `$`: a reset may have cut off the sentence before (docs/user/report.md).
        if byte == ord("$"):
            self.partial.clear()
        self.partial.append(byte)
        if byte == 10:
            line = bytes(self.partial).decode("latin1").strip()
            self.partial.clear()
            if line:
                self.chip.note("< " + line)
                (self.live if line.startswith("$PSTR,LIVE") else self.lines).append(line)

    def wait(self, *starts, length=10.0, fail=True):
        """The next line not yet read that begins, behind `$PSTR,`, with one of `starts`."""
        end = self.chip.time + round(length * 336e6)
        while True:
            while self.read < len(self.lines):
                line = self.lines[self.read]
                self.read += 1
                if not starts or any(line.startswith("$PSTR," + start) for start in starts):
                    return line
            count = len(self.lines)
            left = seconds(end - self.chip.time)
            if left <= 0 or self.chip.off or not self.chip.run(left, until=lambda: len(self.lines) > count):
                if fail:
                    raise AssertionError(f"{starts} did not come in {length} s; last: {self.lines[-5:]}")
                return None

    def send(self, text):
        self.wire.send(text.encode() if isinstance(text, str) else text)

    def command(self, text, *answers):
        """Sends a command and returns its answer."""
        self.send(framed("PSTC," + text))
        return self.wait(*(answers or ("DONE", "FAIL", "CONF", "VER", "STAT", "CRASH")))

    def set(self, key, value):
        answer = self.command(f"set,{key},{value}", "CONF", "FAIL")
        assert answer.startswith(f"$PSTR,CONF,{key},{value}"), answer
