"""USART: bytes at their true time, with overrun and framing errors (RM0090 30)."""

from .peripheral import Peripheral, Register
from .units import UNITS_PER_S, us

PE, FE, NF, ORE, IDLE, RXNE, TC, TXE = (1 << k for k in range(8))
BITS = 10  # Start bit, eight data bits, stop bit.
# Two ends may differ by so much until bits are read wrongly (30.3.5: 3.75 % less what both add by sampling).
TOLERANCE = 0.025
# Equal readings of SR behind which time passes at once, and how much of it at a time.
MANY_POLLS, POLL_US = 8, 20


class Usart(Peripheral):
    """A port. `sink(byte, rate)` takes what it sends; `receive` gives it a byte that begins now."""

    REGISTERS = (
        Register(0x00, "SR", "30.6.1", 0xC0, 0x3FF),
        Register(0x04, "DR", "30.6.2", 0, 0x1FF),
        Register(0x08, "BRR", "30.6.3", 0, 0xFFFF),
        Register(0x0C, "CR1", "30.6.4", 0, 0xBFFF),
        Register(0x10, "CR2", "30.6.5", 0, 0x7F6F),
        Register(0x14, "CR3", "30.6.6", 0, 0x0FFF),
        Register(0x18, "GTPR", "30.6.7", 0, 0xFFFF),
    )

    def __init__(self, chip, name, base, gate, irq, pins):
        self.NAME, self.BASE, self.GATE = name, base, gate
        self.irq = irq
        self.tx_pin, self.rx_pin = pins
        self.sink = lambda byte, rate: None
        self.overruns = 0
        self.sent = self.shift_ends = None
        super().__init__(chip)

    def reset(self):
        super().reset()
        if self.shift_ends:
            self.shift_ends.cancel()
        self.shift_ends = None
        self.holding = None
        self.data = 0
        self.flags = 0  # RXNE and errors.
        self.read_status = False
        self.polls, self.polled = 0, None
        self.line()

    def rate(self):
        """Bit rate, baud; 0 where none is set."""
        brr, over8 = self.r["BRR"], self.r["CR1"] >> 15 & 1
        clocks = (brr >> 4) * 8 + (brr & 7) if over8 else brr
        clock = self.chip.rcc.pclk[self.GATE[0]]
        return clock / clocks if clocks else 0

    def byte_units(self):
        return round(BITS * UNITS_PER_S / self.rate())

    def on(self, bit):
        return self.r["CR1"] >> 13 & 1 and self.r["CR1"] >> bit & 1

    def line(self):
        """The interrupt's line: what is enabled and set."""
        control, status = self.r["CR1"], self.status()
        wanted = control >> 5 & 1 and status & (RXNE | ORE)
        wanted = wanted or control >> 7 & 1 and status & TXE
        wanted = wanted or control >> 6 & 1 and status & TC
        wanted = wanted or control >> 4 & 1 and status & IDLE
        self.chip.core.line(16 + self.irq, bool(wanted))

    def status(self):
        empty = TXE if self.holding is None else 0
        complete = TC if self.shift_ends is None else 0
        return self.flags | empty | complete

    # Registers.

    def read_SR(self):
        self.read_status = True
        status = self.status()
        if not self.r["CR1"] >> 5 & 1:
            # A port without interrupts is polled: nothing changes before the next event.
            self.polls = self.polls + 1 if status == self.polled else 0
            self.polled = status
            if self.polls > MANY_POLLS:
                self.chip.core.skip(us(POLL_US))
        return status

    def write_SR(self, value):
        # Zeros clear RXNE and TC; the rest is not written.
        if not value & RXNE:
            self.flags &= ~RXNE
        self.line()

    def read_DR(self):
        self.polled = None
        self.flags &= ~RXNE
        if self.read_status:
            self.flags &= ~(ORE | FE | NF | PE | IDLE)
        self.read_status = False
        self.line()
        return self.data

    def write_DR(self, value):
        if not self.on(3):
            self.complain("byte written with the transmitter off (30.6.4)")
            return
        if self.holding is not None:
            self.complain("byte written over one that waits (TXE was 0, 30.6.1)")
        if not self.rate():
            self.complain("byte written without a bit rate (30.6.3)")
            return
        if not self.chip.gpio.alternate(self.tx_pin, 7):
            self.complain(f"{self.tx_pin} is not in alternate function 7: the byte does not leave the chip")
        self.holding = value & 0xFF
        if self.shift_ends is None:
            self.shift()
        self.line()

    def shift(self):
        byte, self.holding = self.holding, None
        self.shift_ends = self.chip.after(self.byte_units(), lambda: self.shifted(byte, self.rate()))

    def shifted(self, byte, rate):
        self.shift_ends = None
        if self.holding is not None:
            self.shift()
        self.line()
        self.sink(byte, rate)

    def write_BRR(self, value):
        self.r["BRR"] = value
        if self.shift_ends:
            self.complain("bit rate changed while a byte is on its way (30.6.3)")

    def write_CR1(self, value):
        self.r["CR1"] = value
        self.line()

    # From the wire.

    def arrived(self, byte, rate):
        """A byte whose stop bit ends now, sent at `rate`."""
        if self.gated() or not self.on(2):
            return
        if not self.chip.gpio.alternate(self.rx_pin, 7):
            self.complain(f"{self.rx_pin} is not in alternate function 7: a byte is not received")
            return
        own = self.rate()
        errors = 0
        if not own or abs(own / rate - 1) > TOLERANCE:
            byte, errors = byte ^ 0x5A, FE
            self.complain(f"receives at {own:.0f} baud what is sent at {rate:.0f}")
        if self.flags & RXNE:
            self.overruns += 1
            self.flags |= ORE
            self.complain(f"overrun: a byte came before the last one was read ({self.chip.core.where()})")
        else:
            self.data = byte
            self.flags |= RXNE | errors
        self.line()


class Wire:
    """The far end of a port: sends bytes one behind the other at its own rate."""

    def __init__(self, usart, rate):
        self.usart, self.rate = usart, rate
        self.free = 0

    def send(self, data, after=0):
        """Sends bytes, the first one beginning `after` units from now at the earliest; returns the end's time."""
        chip = self.usart.chip
        start = max(self.free, chip.now() + after)
        length = BITS * UNITS_PER_S / self.rate
        rate = self.rate
        for k, byte in enumerate(data):
            chip.at(round(start + (k + 1) * length), lambda byte=byte: self.usart.arrived(byte, rate))
        self.free = round(start + len(data) * length)
        return self.free
