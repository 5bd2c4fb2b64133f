"""SPI as a master of eight bits (RM0090 28)."""

from .peripheral import Peripheral, Register
from .units import UNITS_PER_S

RXNE, TXE, OVR, BSY = 1, 2, 1 << 6, 1 << 7


class Spi(Peripheral):
    """A port. `transfer(byte)` of the device that is selected gives the byte that comes back."""

    REGISTERS = (
        Register(0x00, "CR1", "28.5.1", 0, 0xFFFF),
        Register(0x04, "CR2", "28.5.2", 0, 0x00F7),
        Register(0x08, "SR", "28.5.3", 2, 0x01FF),
        Register(0x0C, "DR", "28.5.4", 0, 0xFFFF),
        Register(0x10, "CRCPR", "28.5.5", 7, 0xFFFF),
        Register(0x1C, "I2SCFGR", "28.5.8", 0, 0x0FBF),
        Register(0x20, "I2SPR", "28.5.9", 2, 0x03FF),
    )

    def __init__(self, chip, name, base, gate, pins):
        self.NAME, self.BASE, self.GATE = name, base, gate
        self.pins = pins
        self.transfer = lambda byte: 0xFF
        super().__init__(chip)

    def reset(self):
        super().reset()
        self.shifting = False
        self.waiting = None
        self.flags = 0
        self.data = 0

    def read_SR(self):
        empty = TXE if self.waiting is None else 0
        return self.flags | empty | (BSY if self.shifting else 0)

    def write_SR(self, value):
        pass

    def read_DR(self):
        self.flags &= ~(RXNE | OVR)
        return self.data

    def write_DR(self, value):
        if not self.r["CR1"] >> 6 & 1:
            self.complain("byte written with the port off (28.5.1)")
        for pin in self.pins:
            if not self.chip.gpio.alternate(pin, 5):
                self.complain(f"{pin} is not in alternate function 5")
        if self.waiting is not None:
            self.complain("byte written over one that waits (28.5.3)")
        self.waiting = value & 0xFF
        if not self.shifting:
            self.shift()

    def hz(self):
        return self.chip.rcc.pclk[self.GATE[0]] / (2 << (self.r["CR1"] >> 3 & 7))

    def shift(self):
        byte, self.waiting, self.shifting = self.waiting, None, True
        self.chip.after(round(8 * UNITS_PER_S / self.hz()), lambda: self.shifted(byte))

    def shifted(self, byte):
        self.shifting = False
        answer = self.transfer(byte)
        if self.flags & RXNE:
            self.flags |= OVR
            self.complain("overrun: a byte was not read in time (28.5.3)")
        else:
            self.data = answer
            self.flags |= RXNE
        if self.waiting is not None:
            self.shift()
