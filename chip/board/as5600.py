"""AS5600 on the bit-banged I2C at PB8 and PB9: start, address, acknowledge, registers (data sheet 1-06)."""

from model.units import seconds

ADDRESS = 0x36
STATUS, RAW_ANGLE = 0x0B, 0x0C
MAGNET = 1 << 5
# Fast mode (UM10204, table 10): shortest low and high of SCL, s.
LOW_S, HIGH_S = 1.3e-6, 0.6e-6


class As5600:
    """A slave that follows the edges of both lines; `angle()` gives its 4096 counts a turn."""

    def __init__(self, chip, angle=lambda: 0, present=True):
        self.chip, self.angle, self.present = chip, angle, present
        self.magnet = True
        self.highs, self.lows = [], []  # Times of SCL, s.
        self.edge_at = None
        self.state = "idle"
        self.register = 0
        self.scl = self.sda = 1
        self.pull(None)
        chip.gpio.drive("PB8", 1)
        chip.gpio.watch("PB8", self.on_scl)
        chip.gpio.watch("PB9", self.on_sda)

    def pull(self, low):
        """Pulls SDA low, or lets it go to its resistor."""
        self.chip.gpio.drive("PB9", 0 if low else 1)

    def on_sda(self, level):
        before, self.sda = self.sda, level
        if self.scl and before != level:
            if not level:
                self.state, self.bits = "address", []
            else:
                self.state = "idle"
                self.edge_at = None

    def on_scl(self, level):
        now = self.chip.now()
        if self.edge_at is not None and self.state != "idle":
            length = seconds(now - self.edge_at)
            (self.lows if level else self.highs).append(length)
            if length < (LOW_S if level else HIGH_S):
                self.chip.complain(f"AS5600: SCL {'low' if level else 'high'} for {length * 1e6:.2f} us only")
        self.edge_at = now
        self.scl = level
        if level:
            self.rise()
        else:
            self.fall()

    def rise(self):
        if self.state in ("address", "register", "data"):
            self.bits.append(self.sda)
        elif self.state == "acknowledged":
            # The master's acknowledge of a byte that it has read.
            self.more = not self.sda

    def fall(self):
        if self.state in ("address", "register", "data") and len(self.bits) == 8:
            self.byte(int("".join(map(str, self.bits)), 2))
        elif self.state == "acknowledge":
            self.pull(False)
            self.state, self.bits = self.then, []
            if self.state == "send":
                self.load()
        elif self.state == "send":
            self.shift()
        elif self.state == "acknowledged":
            if self.more:
                self.state = "send"
                self.load()
            else:
                self.state = "idle"

    def byte(self, value):
        if self.state == "address":
            mine = value >> 1 == ADDRESS and self.present
            if not mine:
                self.state = "idle"
                return
            self.then = "send" if value & 1 else "register"
        elif self.state == "register":
            self.register, self.then = value, "data"
        else:
            self.chip.complain("AS5600: a register is written")
        self.state = "acknowledge"
        self.pull(True)

    def value(self):
        counts = self.angle() & 0xFFF
        return {STATUS: MAGNET if self.magnet else 0, RAW_ANGLE: counts >> 8, RAW_ANGLE + 1: counts & 0xFF}.get(
            self.register, 0)

    def load(self):
        value = self.value()
        self.register += 1
        self.out = [value >> k & 1 for k in range(7, -1, -1)]
        self.shift()

    def shift(self):
        if self.out:
            self.pull(not self.out.pop(0))
        else:
            self.pull(False)
            self.state = "acknowledged"
            self.more = False
