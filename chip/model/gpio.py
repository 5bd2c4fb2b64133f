"""GPIO: pins with their modes, resistors and what the board does to them (RM0090 8)."""

from .peripheral import Peripheral, Register

INPUT, OUTPUT, ALTERNATE, ANALOG = range(4)
# Ports of the F405RG with their reset values (8.4.1 to 8.4.4): those of the debug port on A and B.
RESET = {"A": (0xA800_0000, 0x0C00_0000, 0x6400_0000), "B": (0x0000_0280, 0x0000_00C0, 0x0000_0100)}


class Port(Peripheral):
    """One port. `driven[n]` is the level that the board puts on pin n, None where nothing drives it."""

    def __init__(self, chip, letter):
        self.letter = letter
        number = "ABCDEFGHI".index(letter)
        self.NAME = "GPIO" + letter
        self.BASE = 0x4002_0000 + 0x400 * number
        self.GATE = ("AHB1", number)
        moder, speed, pupdr = RESET.get(letter, (0, 0, 0))
        self.REGISTERS = (
            Register(0x00, "MODER", "8.4.1", moder),
            Register(0x04, "OTYPER", "8.4.2", 0, 0xFFFF),
            Register(0x08, "OSPEEDR", "8.4.3", speed),
            Register(0x0C, "PUPDR", "8.4.4", pupdr),
            Register(0x10, "IDR", "8.4.5", 0, 0xFFFF, read_only=True),
            Register(0x14, "ODR", "8.4.6", 0, 0xFFFF),
            Register(0x18, "BSRR", "8.4.7", 0, write_only=True),
            Register(0x1C, "LCKR", "8.4.8", 0, 0x1FFFF),
            Register(0x20, "AFRL", "8.4.9"),
            Register(0x24, "AFRH", "8.4.10"),
        )
        self.driven = [None] * 16
        self.watchers = [[] for _ in range(16)]
        self.levels = [0] * 16
        super().__init__(chip)

    def reset(self):
        super().reset()
        self.settle()

    def mode(self, n):
        return self.r["MODER"] >> 2 * n & 3

    def out(self, n):
        """Level that the chip itself drives, None for none."""
        if self.mode(n) != OUTPUT:
            return None
        level = self.r["ODR"] >> n & 1
        return None if level and self.r["OTYPER"] >> n & 1 else level

    def level(self, n):
        out, given = self.out(n), self.driven[n]
        open_drain = self.r["OTYPER"] >> n & 1
        if out is not None and given is not None:
            # A low one wins on an open-drain line; elsewhere the chip's own level.
            return out & given if open_drain or given == 0 and out == 0 else out
        if out is not None:
            return out
        if given is not None:
            return given
        pull = self.r["PUPDR"] >> 2 * n & 3
        return 1 if pull == 1 else 0

    def drive(self, n, level):
        """The board puts a level on a pin."""
        self.driven[n] = level
        self.settle()

    def settle(self):
        """Tells those who watch what has changed, and EXTI."""
        self.changed(0xFFFF)

    def changed(self, pins):
        """As `settle`, for these pins: an output that is written changes few."""
        n = 0
        while pins:
            if pins & 1:
                self.compare(n)
            pins >>= 1
            n += 1

    def compare(self, n):
        level = self.level(n)
        if level != self.levels[n]:
            self.levels[n] = level
            for watcher in self.watchers[n]:
                watcher(level)
            self.chip.exti_pin(self.letter, n, level)

    def read_IDR(self):
        value = 0
        for n in range(16):
            if self.mode(n) != ANALOG and self.level(n):
                value |= 1 << n
        return value

    def store(self, name, value):
        self.r[name] = value
        self.settle()

    def write_MODER(self, value):
        self.store("MODER", value)

    def write_OTYPER(self, value):
        self.store("OTYPER", value)

    def write_PUPDR(self, value):
        self.store("PUPDR", value)

    def write_ODR(self, value):
        self.store("ODR", value)

    def write_BSRR(self, value):
        before = self.r["ODR"]
        self.r["ODR"] = before & ~(value >> 16) | value & 0xFFFF
        self.changed(before ^ self.r["ODR"])


class Gpio:
    """All ports; a pin by its name, such as `PC6`."""

    def __init__(self, chip):
        self.ports = {letter: Port(chip, letter) for letter in "ABCDEFGHI"}

    def split(self, pin):
        return self.ports[pin[1]], int(pin[2:])

    def level(self, pin):
        port, n = self.split(pin)
        return port.levels[n]

    def drive(self, pin, level):
        port, n = self.split(pin)
        port.drive(n, level)

    def watch(self, pin, watcher):
        port, n = self.split(pin)
        port.watchers[n].append(watcher)

    def alternate(self, pin, function):
        port, n = self.split(pin)
        name, shift = ("AFRL", 4 * n) if n < 8 else ("AFRH", 4 * (n - 8))
        return port.mode(n) == ALTERNATE and port.r[name] >> shift & 15 == function
