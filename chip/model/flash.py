"""Flash and its controller: lock, keys, programming, erasure with its stall of the bus, wear (RM0090 3.9)."""

from .peripheral import Peripheral, Register
from .units import us

BASE = 0x0800_0000
SIZE = 1 << 20
SECTORS = (16 * 1024,) * 4 + (64 * 1024,) + (128 * 1024,) * 7
STARTS = tuple(BASE + sum(SECTORS[:k]) for k in range(len(SECTORS)))

KEYS = (0x4567_0123, 0xCDEF_89AB)
OPTION_KEYS = (0x0819_2A3B, 0x4C5D_6E7F)
# Times with 32 bits at a time, typical (DS8626, flash memory programming).
ERASE_US = {16 * 1024: 250_000, 64 * 1024: 550_000, 128 * 1024: 1_000_000}
WORD_US = 16
# The option bytes lie in a sector of 16 KB.
OPTIONS_US = ERASE_US[16 * 1024]
# Erasures that a sector is specified for (DS8626, endurance).
ENDURANCE = 10_000
# Supply from which 32 bits at a time may be written (RM0090 table 7), volts.
WORDWISE_V = 2.7

PG, SER, MER, STRT, LOCK = 1, 1 << 1, 1 << 2, 1 << 16, 1 << 31
EOP, OPERR, WRPERR, PGAERR, PGPERR, PGSERR, BSY = 1, 2, 1 << 4, 1 << 5, 1 << 6, 1 << 7, 1 << 16
ICEN, DCEN, ICRST, DCRST = 1 << 9, 1 << 10, 1 << 11, 1 << 12
OPTLOCK, OPTSTRT = 1, 2


class Flash(Peripheral):
    NAME = "FLASH"
    BASE = 0x4002_3C00
    REGISTERS = (
        Register(0x00, "ACR", "3.9.2", 0, 0x1F07),
        Register(0x04, "KEYR", "3.9.3", write_only=True),
        Register(0x08, "OPTKEYR", "3.9.4", write_only=True),
        Register(0x0C, "SR", "3.9.5", 0, 0x0001_00F3),
        Register(0x10, "CR", "3.9.6", LOCK, 0x8301_03FF & ~0x80),
        Register(0x14, "OPTCR", "3.9.8", 0x0FFF_AAED, 0x0FFF_FFEF),
    )

    def __init__(self, chip):
        self.wear = [0] * len(SECTORS)
        self.options = 0x0FFF_AAEC  # Kept without power; OPTLOCK aside.
        self.operations = 0  # Words and erasures begun since the chip was made.
        self.cut_at = None  # Number of the operation at which the power goes.
        super().__init__(chip)

    def reset(self):
        super().reset()
        self.key = self.option_key = 0
        self.locked = self.option_locked = True
        self.barred = self.option_barred = False  # By a wrong key, until the next reset.
        self.busy_until = 0
        self.stale = False  # The data cache may hold what stood there before.
        self.pending = {}
        self.r["OPTCR"] = self.options | OPTLOCK

    # Wait states.

    def check_wait_states(self):
        """Wait states by clock and supply (RM0090 table 10)."""
        volts, hclk = self.chip.volts, self.chip.rcc.hclk
        step = 30e6 if volts >= 2.7 else 24e6 if volts >= 2.4 else 22e6 if volts >= 2.1 else 20e6
        need = max(0, -int(-hclk // step) - 1)
        have = self.r["ACR"] & 7
        if have < need:
            self.complain(f"{hclk / 1e6:.0f} MHz with {have} wait states, needs {need} (table 10)")

    def write_ACR(self, value):
        before = self.r["ACR"]
        for reset, enable, name in ((ICRST, ICEN, "instruction"), (DCRST, DCEN, "data")):
            if value & reset & ~before and value & enable:
                self.complain(f"{name} cache reset while it is enabled (3.9.2)")
        if value & DCRST and not value & DCEN:
            self.stale = False
        self.r["ACR"] = value
        self.check_wait_states()

    # Keys.

    def write_KEYR(self, value):
        if self.barred:
            self.complain("key after a wrong one: locked until the next reset (3.9.3)")
        elif not self.locked:
            self.complain("key written while unlocked")
        elif value != KEYS[self.key]:
            self.complain(f"key 0x{value:08x} out of order (3.9.3)")
            self.barred = True
        else:
            self.key += 1
            if self.key == len(KEYS):
                self.locked, self.key = False, 0
                self.r["CR"] &= ~LOCK

    def write_OPTKEYR(self, value):
        if self.option_barred or not self.option_locked or value != OPTION_KEYS[self.option_key]:
            self.complain(f"option key 0x{value:08x} out of order (3.9.4)")
            self.option_barred = True
        else:
            self.option_key += 1
            if self.option_key == len(OPTION_KEYS):
                self.option_locked, self.option_key = False, 0
                self.r["OPTCR"] &= ~OPTLOCK

    def write_OPTCR(self, value):
        if self.option_locked:
            self.complain("OPTCR written while locked (3.9.8)")
            return
        self.r["OPTCR"] = value & ~OPTSTRT
        if value & OPTLOCK:
            self.option_locked = True
        if value & OPTSTRT:
            self.options = value & ~(OPTSTRT | OPTLOCK)
            self.begin(OPTIONS_US)

    # Control and status.

    def write_CR(self, value):
        if self.locked:
            if value != self.r["CR"]:
                self.complain(f"CR written with 0x{value:08x} while locked (3.9.6)")
            return
        if self.busy():
            self.complain("CR written during an operation (3.9.6)")
            return
        self.settle()
        if value & LOCK:
            self.locked = True
            self.r["CR"] |= LOCK
            if value & ~LOCK & ~self.r["CR"]:
                self.complain(f"CR written with 0x{value:08x}: LOCK is set beside other bits, which are lost")
            return
        self.r["CR"] = value & ~STRT
        if value & STRT:
            if value & SER:
                self.erase(value >> 3 & 15)
            elif value & MER:
                for sector in range(len(SECTORS)):
                    self.erase(sector)
            else:
                self.complain("STRT without SER or MER (3.9.6)")

    def busy(self):
        return self.chip.now() < self.busy_until

    def read_SR(self):
        self.settle()
        return self.r["SR"] | (BSY if self.busy() else 0)

    def write_SR(self, value):
        self.r["SR"] &= ~(value & 0xF3)

    def fail(self, flag, text):
        self.r["SR"] |= flag | OPERR
        self.complain(text)

    # Operations.

    def check_size(self):
        size = self.r["CR"] >> 8 & 3
        if size == 3:
            self.complain("64 bits at a time without an external Vpp (table 7)")
        if size == 2 and self.chip.volts < WORDWISE_V:
            self.complain(f"32 bits at a time at {self.chip.volts:.2f} V, needs {WORDWISE_V} (table 7)")
        return 1 << size

    def begin(self, duration_us):
        """An operation: nothing is fetched from the bank meanwhile."""
        self.busy_until = self.chip.now() + us(duration_us)
        self.chip.core.stall_until(self.busy_until)

    def count(self):
        """Counts an operation; True where the power goes in it."""
        self.operations += 1
        return self.cut_at is not None and self.operations >= self.cut_at

    def protected(self, sector):
        return not self.options >> 16 + sector & 1

    def erase(self, sector):
        if sector >= len(SECTORS):
            self.fail(PGSERR, f"erasure of sector {sector}, which is not there")
            return
        if self.protected(sector):
            self.fail(WRPERR, f"erasure of sector {sector}, which is write-protected")
            return
        self.check_size()
        size, start = SECTORS[sector], STARTS[sector]
        self.wear[sector] += 1
        if self.wear[sector] > ENDURANCE:
            self.complain(f"sector {sector} erased {self.wear[sector]} times")
        self.chip.note(f"erase sector {sector} ({size // 1024} KB)")
        if self.count():
            # Neither what stood there nor blank: some of each.
            old = self.chip.memory(start, size)
            mixed = bytes(a | b for a, b in zip(old, self.chip.random.randbytes(size)))
            self.chip.memory_write(start, mixed)
            self.chip.power_cut()
            return
        self.chip.memory_write(start, b"\xff" * size)
        self.stale = bool(self.r["ACR"] & DCEN)
        self.begin(ERASE_US[size])

    def programming(self, address, size, old, value):
        """The core writes to the flash; the bits are put right at the next access to the controller."""
        place = f"write of {size} bytes to 0x{address:08x}"
        sector = max(k for k, start in enumerate(STARTS) if start <= address)
        # What is wrong leaves the cells as they were.
        self.pending[address] = (size, old, int.from_bytes(old, "little"))
        if self.locked or not self.r["CR"] & PG:
            self.fail(PGSERR, f"{place} without PG (3.6.3)")
        elif size != self.check_size():
            self.fail(PGPERR, f"{place} with PSIZE {self.r['CR'] >> 8 & 3} (3.6.3)")
        elif address % size:
            self.fail(PGAERR, f"{place}, not aligned (3.6.3)")
        elif self.protected(sector):
            self.fail(WRPERR, f"{place}: sector {sector} is write-protected")
        else:
            self.pending[address] = (size, old, value)
            self.stale = bool(self.r["ACR"] & DCEN)
            if self.count():
                partial = value | self.chip.random.getrandbits(8 * size)
                self.pending[address] = (size, old, partial)
                self.settle()
                self.chip.power_cut()
                return
            self.begin(WORD_US)

    def settle(self):
        """Bits only go from 1 to 0."""
        for address, (size, old, value) in self.pending.items():
            new = (value & ((1 << 8 * size) - 1)).to_bytes(size, "little")
            self.chip.memory_write(address, bytes(a & b for a, b in zip(old, new)))
        self.pending = {}
