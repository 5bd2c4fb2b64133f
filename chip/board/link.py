"""The radar module at the link: frames by host-sim's own code in a process of its own, bytes and times here."""

import json
import struct
import subprocess

from model.units import seconds, us
from model.usart import Wire

# From a request's last byte to the answer's first one: chirp and the module's work.
CHIRP_US = 400
CONFIGURE_US = 200


class LinkModule:
    """`host-sim module RECORDING`: what the scanner sends goes there byte by byte, its answers come back at their rate."""

    def __init__(self, chip, program, recording, fastest=1, pin=False):
        self.chip = chip
        command = [program, "module", recording, "--fastest", str(fastest)] + (["--pin"] if pin else [])
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        head = json.loads(self.process.stdout.readline())
        self.settings = [(key, value) for key, value in head["set"]]
        self.wire = Wire(chip.usart["USART1"], 1_000_000)
        self.triggers = []  # Times at which a trigger's last byte came.
        self.pulses = []  # Times and widths of TRIG's pulses.
        self.rates = [1_000_000]
        self.request = bytearray()
        self.plays = True
        chip.usart["USART1"].sink = self.on_byte
        chip.gpio.watch("PC9", self.on_trig)

    def on_trig(self, level):
        now = self.chip.now()
        if level:
            self.pulses.append((now, None))
        elif self.pulses:
            self.pulses[-1] = (self.pulses[-1][0], now - self.pulses[-1][0])

    def on_byte(self, byte, rate):
        if abs(rate / self.wire.rate - 1) > 0.02:
            self.chip.complain(f"link sends at {rate:.0f} baud to a module at {self.wire.rate}")
            return
        self.request.append(byte)
        # Bytes before the beginning of a frame are passed over (src/signal/radar/frame.rs).
        while self.request and not b"SR".startswith(self.request[:2]):
            self.request.pop(0)
        # A frame's length stands in its header; the module reads whole frames.
        if len(self.request) >= 8 and len(self.request) == 12 + int.from_bytes(self.request[6:8], "little"):
            frame = bytes(self.request)
            self.request.clear()
            self.answer(frame)

    def answer(self, frame):
        trigger = frame[3] == 2
        if trigger:
            self.triggers.append(self.chip.now())
        if not self.plays:
            return
        self.process.stdin.write(struct.pack("<I", len(frame)) + frame)
        self.process.stdin.flush()
        rate, length = struct.unpack("<BI", self.process.stdout.read(5))
        answer = self.process.stdout.read(length)
        end = self.wire.send(answer, us(CHIRP_US if trigger else CONFIGURE_US))
        if rate:
            self.chip.at(end, lambda: self.set_rate(rate * 1_000_000))

    def set_rate(self, rate):
        self.wire.rate = rate
        self.rates.append(rate)
        self.chip.note(f"link at {rate} baud")

    def close(self):
        self.process.stdin.close()
        self.process.stdout.close()
        self.process.wait()

    def trigger_times(self):
        return [seconds(time) for time in self.triggers]
