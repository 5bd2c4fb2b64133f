"""The host's end of an update, at the report port: frames of `boot/src/frame.rs`, one request at a time."""

import struct
import zlib

from model.usart import Wire

HELLO, RATE, BEGIN, DATA, FINISH, BOOT, BACK = range(1, 8)
ANSWER = 0x80
HEADER, CHUNK = 144, 1024


def frame(kind, sequence, payload):
    head = b"SU" + struct.pack("<BBH", kind, sequence, len(payload)) + payload
    return head + struct.pack("<I", zlib.crc32(head))


def images(package):
    """Header and payload for each of the two slots in a signed file."""
    found, rest = [], package
    while rest:
        length = struct.unpack_from("<I", rest, 16)[0]
        found.append((rest[:HEADER], rest[HEADER:HEADER + length]))
        rest = rest[HEADER + length:]
    return found


class Updater:
    """Sends requests to the loader, and waits for their answers."""

    def __init__(self, terminal):
        self.terminal, self.chip = terminal, terminal.chip
        self.sequence = 0
        self.received = bytearray()
        self.usart = self.chip.usart["USART2"]
        self.spare = None

    def __enter__(self):
        self.before = self.usart.sink
        self.usart.sink = lambda byte, rate: self.received.append(byte)
        return self

    def __exit__(self, *_):
        self.usart.sink = self.before
        self.terminal.wire = Wire(self.usart, 115_200)

    def ask(self, kind, payload=b"", length=5.0):
        """The answer's payload; None where none comes."""
        self.sequence = self.sequence + 1 & 0xFF
        self.received.clear()
        self.terminal.wire.send(frame(kind, self.sequence, payload))
        mark = b"SU" + bytes([kind | ANSWER, self.sequence])

        def whole():
            at = self.received.find(mark)
            if at < 0 or len(self.received) < at + 6:
                return False
            return len(self.received) >= at + 10 + struct.unpack_from("<H", self.received, at + 4)[0]

        if not self.chip.run(length, until=whole):
            return None
        at = self.received.find(mark)
        count = struct.unpack_from("<H", self.received, at + 4)[0]
        return bytes(self.received[at + 6:at + 6 + count])

    def hello(self):
        info = self.ask(HELLO)
        assert info is not None, "the loader does not answer"
        self.spare = info[1]
        return info

    def rate(self, baud):
        assert self.ask(RATE, struct.pack("<I", baud)) == b"\0"
        self.terminal.wire = Wire(self.usart, baud)

    def send(self, package, until=None):
        """Sends the image for the spare slot; returns the code of the loader's last answer, None where it fell silent.

        A transfer that was interrupted goes on where it ended. `until`: bytes after which it stops.
        """
        header, payload = images(package)[self.spare]
        answer = self.ask(BEGIN, header, length=20.0)
        while answer is not None and answer[0] == 0:
            at = struct.unpack_from("<I", answer, 1)[0]
            if at >= len(payload) or until is not None and at >= until:
                break
            answer = self.ask(DATA, struct.pack("<I", at) + payload[at:at + CHUNK])
        if answer is None:
            return None
        if answer[0] or until is not None:
            return answer[0]
        answer = self.ask(FINISH, length=20.0)
        return None if answer is None else answer[0]
