"""IWDG: the independent watchdog, with the times its registers need to be taken over (RM0090 21)."""

from .peripheral import Peripheral, Register
from .units import UNITS_PER_S

# The prescaler and reload registers are taken over after five clocks of its oscillator (21.4.4).
UPDATE_CLOCKS = 5


class Iwdg(Peripheral):
    NAME = "IWDG"
    BASE = 0x4000_3000
    REGISTERS = (
        Register(0x00, "KR", "21.4.1", 0, 0xFFFF, write_only=True),
        Register(0x04, "PR", "21.4.2", 0, 7),
        Register(0x08, "RLR", "21.4.3", 0xFFF, 0xFFF),
        Register(0x0C, "SR", "21.4.4", 0, 3, read_only=True),
    )

    def __init__(self, chip):
        self.lsi_hz = 32_000  # 17 to 47 kHz (DS8626, LSI oscillator characteristics).
        self.expires = None
        super().__init__(chip)

    def reset(self):
        super().reset()
        if self.expires:
            self.expires.cancel()
        self.expires = None
        self.running = self.open = False
        self.updated = {"PR": 0, "RLR": 0}  # Times at which they are taken over.
        self.divider, self.reload = 4, 0xFFF
        self.windows = []  # Lengths of the windows from each reload on, s.
        self.feeds = []

    def clock(self, count):
        return count * UNITS_PER_S // self.lsi_hz

    def window(self):
        return self.clock((self.reload + 1) * self.divider)

    def busy(self, name):
        return self.chip.now() < self.updated[name]

    def read_SR(self):
        return self.busy("PR") | self.busy("RLR") << 1

    def protect(self, name):
        if not self.open:
            self.complain(f"{name} written without the key 0x5555 (21.3.2)")
        elif self.busy(name):
            self.complain(f"{name} written while it is being updated (21.4.4)")
        else:
            self.updated[name] = self.chip.now() + self.clock(UPDATE_CLOCKS)
            return True
        return False

    def write_PR(self, value):
        if self.protect("PR"):
            self.r["PR"] = value
            left = self.expires.time - self.chip.now() if self.expires else 0
            before, self.divider = self.divider, 4 << min(value, 6)
            if self.running:
                self.arm(left * self.divider // before)

    def write_RLR(self, value):
        if self.protect("RLR"):
            self.r["RLR"] = value

    def arm(self, length):
        if self.expires:
            self.expires.cancel()
        self.expires = self.chip.after(length, self.bite)

    def bite(self):
        self.chip.note("watchdog")
        self.chip.system_reset("watchdog")

    def feed(self):
        # While RVU is set, the counter gets the value from before.
        if not self.busy("RLR"):
            self.reload = self.r["RLR"]
        self.windows.append(self.window() / UNITS_PER_S)
        self.feeds.append(self.chip.now())
        if self.running:
            self.arm(self.window())

    def write_KR(self, value):
        self.open = value == 0x5555
        if value == 0xAAAA:
            self.feed()
        elif value == 0xCCCC:
            self.running = True
            if not self.expires:
                self.arm(self.window())
        elif value != 0x5555:
            self.complain(f"key 0x{value:04x} (21.4.1)")
