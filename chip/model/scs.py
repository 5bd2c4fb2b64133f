"""The processor's own registers: SysTick, NVIC, SCB, MPU, DWT (ARMv7-M, PM0214 4)."""

from .peripheral import Peripheral, Register
from .units import UNITS_PER_S

ENABLE, TICKINT, CORE, COUNTFLAG = 1, 2, 4, 1 << 16
FULL = 0x00FF_FFFF


class SysTick:
    """The core's timer: counts down to 0, sets the flag, and begins anew with the reload value."""

    def __init__(self, chip):
        self.chip = chip
        self.event = None
        self.reset()

    def reset(self):
        if self.event:
            self.event.cancel()
        self.event = None
        self.control = CORE
        self.reload = 0
        self.zero_at = None  # Time at which the counter reaches 0; None while it stands.
        self.standing = 0  # Its value while it stands.
        self.flag = False

    def clock(self):
        divider = 1 if self.control & CORE else 8
        return UNITS_PER_S * divider // self.chip.rcc.hclk

    def value(self):
        if self.zero_at is None:
            return self.standing
        left = -((self.chip.now() - self.zero_at) // self.clock())
        return max(0, min(left, FULL))

    def plan(self, clocks):
        """The counter reaches 0 after so many clocks."""
        if self.event:
            self.event.cancel()
        self.zero_at = self.chip.now() + clocks * self.clock()
        self.event = self.chip.at(self.zero_at, self.expired)

    def expired(self):
        self.flag = True
        if self.control & TICKINT:
            self.chip.core.pend(15)
        if self.reload:
            # One clock at 0, then the reload value.
            self.zero_at += (self.reload + 1) * self.clock()
            self.event = self.chip.at(self.zero_at, self.expired)
        else:
            self.halt(0)

    def halt(self, value):
        if self.event:
            self.event.cancel()
        self.event = None
        self.zero_at, self.standing = None, value

    def clock_changed(self):
        # An interval under way goes on with the new clock; the image changes it before it uses this timer.
        pass

    def read_control(self):
        value = self.control | (COUNTFLAG if self.flag else 0)
        self.flag = False
        return value

    def write_control(self, value):
        before, self.control = self.control, value & 7
        if value & ENABLE and not before & ENABLE:
            # A counter at 0 takes the reload value with the first clock.
            start = self.standing or self.reload + 1
            if self.reload or self.standing:
                self.plan(start)
        elif before & ENABLE and not value & ENABLE:
            self.halt(self.value())

    def clear(self):
        self.flag = False
        if self.zero_at is None:
            self.standing = 0
        elif self.reload:
            self.plan(self.reload + 1)
        else:
            self.halt(0)


class Scs(Peripheral):
    NAME = "SCS"
    BASE = 0xE000_E000
    SIZE = 0x1000
    REGISTERS = (
        Register(0xD88, "CPACR", "PM0214 4.6.1", 0, 0x00F0_0000),
        Register(0xD04, "ICSR", "PM0214 4.4.3"),
        Register(0xD08, "VTOR", "PM0214 4.4.4", 0, 0x3FFF_FE00),
        Register(0xD0C, "AIRCR", "PM0214 4.4.5", 0xFA05_0000),
        Register(0xD10, "SCR", "PM0214 4.4.6", 0, 0x16),
        Register(0xD14, "CCR", "PM0214 4.4.7", 0x200, 0x31B),
        Register(0xD24, "SHCSR", "PM0214 4.4.9", 0, 0x7FD8B),
        Register(0xD28, "CFSR", "PM0214 4.4.10"),
        Register(0xD2C, "HFSR", "PM0214 4.4.14", 0, 0xC000_0002),
        Register(0xD34, "MMFAR", "PM0214 4.4.15"),
        Register(0xD38, "BFAR", "PM0214 4.4.16"),
        Register(0xD90, "MPU_TYPE", "PM0214 4.2.5", 0x800, read_only=True),
        Register(0xD94, "MPU_CTRL", "PM0214 4.2.6", 0, 7),
        Register(0xD98, "MPU_RNR", "PM0214 4.2.7", 0, 7),
        Register(0xD9C, "MPU_RBAR", "PM0214 4.2.8"),
        Register(0xDA0, "MPU_RASR", "PM0214 4.2.9"),
        Register(0xDFC, "DEMCR", "ARMv7-M C1.6.5"),
        Register(0xF34, "FPCCR", "PM0214 4.6.2", 0xC000_0000),
        Register(0xF38, "FPCAR", "PM0214 4.6.3"),
        Register(0xF3C, "FPDSCR", "PM0214 4.6.5"),
        Register(0xD00, "CPUID", "PM0214 4.4.1", 0x410F_C241, read_only=True),
    )

    def __init__(self, chip):
        self.systick = SysTick(chip)
        super().__init__(chip)

    def reset(self):
        super().reset()
        self.systick.reset()
        self.regions = [(0, 0)] * 8
        self.enabled = set()
        self.priority = [0] * 256  # By exception number.

    # What is not stored word by word.

    def read(self, offset, size):
        word, core = offset & ~3, self.chip.core
        if word == 0x10:
            return self.systick.read_control()
        if word == 0x14:
            return self.systick.reload
        if word == 0x18:
            return self.systick.value()
        if word == 0x1C:
            return 0
        if 0x100 <= word < 0x300 or 0x300 <= word < 0x320:
            first = 16 + (word & 0x1F) * 8
            of = {0x100: self.enabled, 0x180: self.enabled, 0x200: core.pending, 0x280: core.pending,
                  0x300: set(core.active_numbers())}[word & ~0x1F]
            return sum(1 << k for k in range(32) if first + k in of)
        if 0x400 <= word < 0x4F0:
            return self.bytes_of(16 + offset - 0x400, size)
        if 0xD18 <= word < 0xD24:
            return self.bytes_of(4 + offset - 0xD18, size)
        return super().read(offset, size)

    def bytes_of(self, first, size):
        return int.from_bytes(bytes(self.priority[first:first + size]), "little")

    def write(self, offset, size, value):
        word, core = offset & ~3, self.chip.core
        if word == 0x10:
            self.systick.write_control(value)
        elif word == 0x14:
            self.systick.reload = value & FULL
        elif word == 0x18:
            self.systick.clear()
        elif 0x100 <= word < 0x300:
            first = 16 + (word & 0x1F) * 8
            numbers = {first + k for k in range(32) if value >> k & 1}
            kind = word & ~0x1F
            if kind == 0x100:
                self.enabled |= numbers
            elif kind == 0x180:
                self.enabled -= numbers
            elif kind == 0x200:
                for number in numbers:
                    core.pend(number)
            else:
                core.pending -= {n for n in numbers if n not in core.lines}
            core.reconsider()
        elif 0x400 <= word < 0x4F0:
            self.set_bytes(16 + offset - 0x400, size, value)
        elif 0xD18 <= word < 0xD24:
            self.set_bytes(4 + offset - 0xD18, size, value)
        elif word == 0xF00:
            core.pend(16 + (value & 0xFF))
        else:
            super().write(offset, size, value)

    def set_bytes(self, first, size, value):
        # Four bits of priority are there (RM0090 12.1).
        for k, byte in enumerate(value.to_bytes(size, "little")):
            self.priority[first + k] = byte & 0xF0
        self.chip.core.reconsider()

    def read_ICSR(self):
        core = self.chip.core
        active = core.active_numbers()
        value = active[-1] if active else 0
        return value | (15 in core.pending) << 26 | (14 in core.pending) << 28

    def write_ICSR(self, value):
        core = self.chip.core
        for bit, number, on in ((25, 15, False), (26, 15, True), (27, 14, False), (28, 14, True), (31, 2, True)):
            if value >> bit & 1:
                if on:
                    core.pend(number)
                else:
                    core.pending.discard(number)

    def write_VTOR(self, value):
        self.r["VTOR"] = value
        self.chip.note(f"vector table at 0x{value:08x}")

    def write_AIRCR(self, value):
        if value >> 16 != 0x05FA:
            self.complain("AIRCR written without its key")
        elif value & 4:
            self.chip.system_reset("software")

    def write_CFSR(self, value):
        self.r["CFSR"] &= ~value

    def write_HFSR(self, value):
        self.r["HFSR"] &= ~value

    def write_MPU_RBAR(self, value):
        if value >> 4 & 1:
            self.r["MPU_RNR"] = value & 7
        number = self.r["MPU_RNR"]
        self.regions[number] = (value & ~0x1F, self.regions[number][1])
        self.protect()

    def write_MPU_RASR(self, value):
        number = self.r["MPU_RNR"]
        self.regions[number] = (self.regions[number][0], value)
        self.protect()

    def read_MPU_RBAR(self):
        return self.regions[self.r["MPU_RNR"]][0] | self.r["MPU_RNR"]

    def read_MPU_RASR(self):
        return self.regions[self.r["MPU_RNR"]][1]

    def write_MPU_CTRL(self, value):
        self.r["MPU_CTRL"] = value
        self.protect()

    def write_DEMCR(self, value):
        self.r["DEMCR"] = value

    def protect(self):
        """The regions that are in force: first and last address, whether open, whether code may run there."""
        regions = []
        if self.r["MPU_CTRL"] & 1:
            for base, rasr in self.regions:
                if rasr & 1:
                    size = 2 << (rasr >> 1 & 31)
                    open_ = rasr >> 24 & 7 == 3
                    regions.append((base, base + size - 1, open_, not rasr >> 28 & 1))
        self.chip.core.protect(regions)


class Dwt(Peripheral):
    """The cycle counter (ARMv7-M C1.8)."""

    NAME = "DWT"
    BASE = 0xE000_1000
    SIZE = 0x1000
    REGISTERS = (
        Register(0x00, "CTRL", "C1.8.7", 0x4000_0000),
        Register(0x04, "CYCCNT", "C1.8.8"),
    )

    def read_CYCCNT(self):
        if not self.r["CTRL"] & 1:
            return self.r["CYCCNT"]
        passed = self.chip.now() - self.since
        return self.r["CYCCNT"] + passed * self.chip.rcc.hclk // UNITS_PER_S & 0xFFFF_FFFF

    def write_CTRL(self, value):
        self.r["CYCCNT"] = self.read_CYCCNT()
        self.r["CTRL"], self.since = value, self.chip.now()

    def write_CYCCNT(self, value):
        self.r["CYCCNT"], self.since = value, self.chip.now()
