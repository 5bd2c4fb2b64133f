"""TMC2209 behind its single wire: datagrams, registers, count of valid writes (data sheet 1.09, 4 and 5)."""

from model.units import UNITS_PER_S
from model.usart import BITS, Wire

SYNC, CHIP, MASTER, WRITE = 0x05, 0, 0xFF, 0x80
GSTAT, IFCNT, DRV_STATUS = 0x01, 0x02, 0x6F
# Registers that are written, with the bits that exist (5.1 to 5.5).
WRITABLE = {0x00: 0x3FF, 0x01: 7, 0x03: 0xF00, 0x10: 0xF1F1F, 0x11: 0xFF, 0x13: 0xFFFFF, 0x14: 0xFFFFF, 0x22: 0xFFFFFF,
            0x40: 0xFF, 0x42: 0xEFFF, 0x6C: 0xFF0387FF, 0x70: 0xFFFFFFFF}


def crc(data):
    value = 0
    for byte in data:
        for bit in range(8):
            carry = value >> 7 ^ byte >> bit & 1
            value = value << 1 & 0xFF ^ carry * 7
    return value


class Tmc2209:
    """The driver at USART3: its answers follow the request on the same wire, so that the port hears its own bytes."""

    def __init__(self, chip, silent=False):
        self.chip, self.silent = chip, silent
        self.registers = {GSTAT: 1, IFCNT: 0, DRV_STATUS: 0x8000_0000}
        self.frame = bytearray()
        self.last = 0
        self.wire = Wire(chip.usart["USART3"], 115_200)
        self.requests = []
        chip.usart["USART3"].sink = self.on_byte

    def on_byte(self, byte, rate):
        chip = self.chip
        # The resistor between TX and RX: the port receives what it sends.
        chip.usart["USART3"].arrived(byte, rate)
        if self.silent:
            return
        # A pause of 63 bits begins a new datagram (4.1.1).
        if chip.now() - self.last > 63 * UNITS_PER_S / rate + BITS * UNITS_PER_S / rate:
            self.frame.clear()
        self.last = chip.now()
        self.frame.append(byte)
        if self.frame[0] & 0xF != SYNC:
            chip.complain(f"TMC2209: datagram begins with 0x{self.frame[0]:02x}")
            self.frame.clear()
        elif len(self.frame) >= 3:
            length = 8 if self.frame[2] & WRITE else 4
            if len(self.frame) == length:
                self.datagram(bytes(self.frame), rate)
                self.frame.clear()

    def datagram(self, frame, rate):
        if crc(frame[:-1]) != frame[-1]:
            self.chip.complain("TMC2209: datagram with a wrong CRC")
            return
        if frame[1] != CHIP:
            return
        register = frame[2] & 0x7F
        self.requests.append((frame[2], int.from_bytes(frame[3:7], "big") if frame[2] & WRITE else None))
        if frame[2] & WRITE:
            self.write(register, int.from_bytes(frame[3:7], "big"))
            return
        data = bytes([SYNC, MASTER, register]) + self.registers.get(register, 0).to_bytes(4, "big")
        # Eight bit times behind the request (SENDDELAY, 5.1).
        self.wire.send(data + bytes([crc(data)]), round(8 * UNITS_PER_S / rate))

    def write(self, register, value):
        if register not in WRITABLE:
            self.chip.complain(f"TMC2209: write to register 0x{register:02x}")
            return
        if value & ~WRITABLE[register]:
            self.chip.complain(f"TMC2209: reserved bits of register 0x{register:02x}: 0x{value:08x}")
        self.registers[IFCNT] = self.registers[IFCNT] + 1 & 0xFF
        if register == GSTAT:
            self.registers[GSTAT] &= ~value
        else:
            self.registers[register] = value
