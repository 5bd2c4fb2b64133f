"""Registers of a peripheral, and what every one of them complains of."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Register:
    """A register: its offset, reset value, bits that exist, and section of RM0090."""

    offset: int
    name: str
    section: str
    reset: int = 0
    bits: int = 0xFFFF_FFFF
    write_only: bool = False
    read_only: bool = False


class Peripheral:
    """A peripheral of registers, behind a clock gate or none.

    `read_NAME()` and `write_NAME(value)` of a subclass give a register its behaviour; one without them is
    storage. `self.r` holds the registers' values by name.
    """

    NAME = "?"
    BASE = 0
    # Bus and bit of the clock gate in RCC_<bus>ENR, and of the reset in RCC_<bus>RSTR.
    GATE = None
    REGISTERS = ()

    def __init__(self, chip):
        self.chip = chip
        self.by_offset = {register.offset: register for register in self.REGISTERS}
        self.r = {}
        self.readers = {}
        self.writers = {}
        for register in self.REGISTERS:
            self.readers[register.offset] = getattr(self, "read_" + register.name, None)
            self.writers[register.offset] = getattr(self, "write_" + register.name, None)
        self.reset()

    def reset(self):
        """All registers as after a reset."""
        self.r = {register.name: register.reset for register in self.REGISTERS}

    def complain(self, text):
        self.chip.complain(f"{self.NAME}: {text}")

    def gated(self):
        """Whether the clock is off."""
        return self.GATE is not None and not self.chip.rcc.enabled(*self.GATE)

    def read(self, offset, size):
        register = self.by_offset.get(offset & ~3)
        if register is None:
            self.complain(f"read of offset 0x{offset:x}, where there is no register")
            return 0
        if self.gated():
            self.complain(f"{register.name} read with the peripheral's clock off")
            return 0
        if register.write_only:
            value = 0
        else:
            reader = self.readers[register.offset]
            value = reader() if reader else self.r[register.name]
        return value >> 8 * (offset & 3) & ((1 << 8 * size) - 1)

    def write(self, offset, size, value):
        register = self.by_offset.get(offset & ~3)
        if register is None:
            self.complain(f"write to offset 0x{offset:x}, where there is no register")
            return
        if self.gated():
            self.complain(f"{register.name} written with the peripheral's clock off")
            return
        if register.read_only:
            self.complain(f"{register.name} written, which can only be read")
            return
        if size != 4:
            shift = 8 * (offset & 3)
            mask = ((1 << 8 * size) - 1) << shift
            kept = 0 if register.write_only else self.r[register.name]
            value = kept & ~mask | value << shift & mask
        reserved = (value ^ register.reset) & ~register.bits & 0xFFFF_FFFF
        if reserved:
            self.complain(f"{register.name} ({register.section}): reserved bits 0x{reserved:x} changed")
            value = value & register.bits | register.reset & ~register.bits
        writer = self.writers[register.offset]
        if writer:
            writer(value)
        else:
            self.r[register.name] = value
