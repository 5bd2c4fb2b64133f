"""Timers: a free-running counter, its update interrupt, and one capture channel (RM0090 18 and 19)."""

from .peripheral import Peripheral, Register
from .units import UNITS_PER_S

CEN, UIE, UIF, UG, CC1IF = 1, 1, 1, 1, 2


class Timer(Peripheral):
    """TIM2 to TIM5 and TIM9 to TIM14 as far as the drivers use them: up-counting."""

    def __init__(self, chip, name, base, gate, irq, bits):
        self.NAME, self.BASE, self.GATE, self.irq = name, base, gate, irq
        self.bits = bits
        full = (1 << bits) - 1
        self.REGISTERS = (
            Register(0x00, "CR1", "18.4.1", 0, 0x3FF),
            Register(0x04, "CR2", "18.4.2", 0, 0xF8),
            Register(0x08, "SMCR", "18.4.3", 0, 0xFFF7),
            Register(0x0C, "DIER", "18.4.4", 0, 0x5F5F),
            Register(0x10, "SR", "18.4.5", 0, 0x1E5F),
            Register(0x14, "EGR", "18.4.6", 0, 0x5F, write_only=True),
            Register(0x18, "CCMR1", "18.4.7", 0, 0xFFFF),
            Register(0x1C, "CCMR2", "18.4.8", 0, 0xFFFF),
            Register(0x20, "CCER", "18.4.9", 0, 0xBBBB),
            Register(0x24, "CNT", "18.4.10", 0, full),
            Register(0x28, "PSC", "18.4.11", 0, 0xFFFF),
            Register(0x2C, "ARR", "18.4.12", full, full),
            Register(0x34, "CCR1", "18.4.13", 0, full),
            Register(0x38, "CCR2", "18.4.14", 0, full),
            Register(0x3C, "CCR3", "18.4.15", 0, full),
            Register(0x40, "CCR4", "18.4.16", 0, full),
            Register(0x50, "OR", "18.4.21", 0, 0xCC3),
        )
        self.update_event = self.capture_event = None
        super().__init__(chip)

    def reset(self):
        super().reset()
        for event in (self.update_event, self.capture_event):
            if event:
                event.cancel()
        self.update_event = self.capture_event = None
        self.since = None  # Time at which the counter was 0; None while it stands.
        self.stopped_at = 0
        self.prescaler = 0  # In force: PSC is taken over at an update.
        self.line()

    def hz(self):
        return self.chip.rcc.timer_hz[self.GATE[0]]

    def tick(self):
        """Length of a count, as a fraction of units."""
        return UNITS_PER_S * (self.prescaler + 1), self.hz()

    def period(self):
        over, hz = self.tick()
        return (self.r["ARR"] + 1) * over // hz

    def read_CNT(self):
        if self.since is None:
            return self.stopped_at
        over, hz = self.tick()
        return (self.chip.now() - self.since) * hz // over % (self.r["ARR"] + 1)

    def write_CNT(self, value):
        self.stopped_at = value
        if self.since is not None:
            self.start()

    def start(self):
        over, hz = self.tick()
        self.since = self.chip.now() - self.stopped_at * over // hz
        self.plan()

    def plan(self):
        """The next update, where somebody waits for it."""
        if self.update_event:
            self.update_event.cancel()
            self.update_event = None
        waited = self.r["DIER"] & UIE or self.r["ARR"] < 0x1_0000
        if self.since is None or not waited:
            return
        period = max(self.period(), 1)
        passed = (self.chip.now() - self.since) // period
        self.update_event = self.chip.at(self.since + (passed + 1) * period, self.updated)

    def updated(self):
        self.update_event = None
        if self.prescaler != self.r["PSC"]:
            self.since, self.prescaler = self.chip.now(), self.r["PSC"]
        self.r["SR"] |= UIF
        if self.r["CR1"] >> 3 & 1:
            self.stop()
        self.plan()
        self.line()

    def stop(self):
        self.stopped_at = self.read_CNT()
        self.since = None
        self.r["CR1"] &= ~CEN

    def line(self):
        if self.irq is not None:
            wanted = self.r["SR"] & self.r["DIER"] & 0x1F
            self.chip.core.line(16 + self.irq, bool(wanted))

    def write_CR1(self, value):
        before, self.r["CR1"] = self.r["CR1"], value
        if value & CEN and not before & CEN:
            self.start()
        elif before & CEN and not value & CEN:
            self.stop()
            self.plan()

    def write_EGR(self, value):
        if value & UG:
            self.prescaler = self.r["PSC"]
            self.stopped_at = 0
            if self.since is not None:
                self.start()
            if not self.r["CR1"] >> 2 & 1:
                self.r["SR"] |= UIF
            self.line()

    def write_ARR(self, value):
        now = self.read_CNT()
        self.r["ARR"] = value
        if self.since is not None:
            self.stopped_at = now
            self.start()

    def write_DIER(self, value):
        self.r["DIER"] = value
        self.plan()
        self.line()

    def write_SR(self, value):
        # Zeros clear, ones leave.
        self.r["SR"] &= value
        self.line()

    # Capture on channel 1: TIM11's input may be the crystal, divided for the RTC (19.5.11).

    def write_CCER(self, value):
        self.r["CCER"] = value
        self.plan_capture()

    def write_OR(self, value):
        self.r["OR"] = value
        self.plan_capture()

    def input_hz(self):
        """Frequency at the input of channel 1; 0 for none."""
        rcc = self.chip.rcc
        divider = rcc.r["CFGR"] >> 16 & 31
        if self.NAME == "TIM11" and self.r["OR"] & 3 == 2 and divider >= 2 and rcc.hse_on:
            return rcc.hse_hz / divider
        return 0

    def plan_capture(self):
        if self.capture_event:
            self.capture_event.cancel()
            self.capture_event = None
        hz = self.input_hz()
        if self.r["CCER"] & 1 and self.r["CCMR1"] & 3 == 1 and hz:
            each = 1 << (self.r["CCMR1"] >> 2 & 3)
            self.capture_event = self.chip.after(round(UNITS_PER_S * each / hz), self.captured)

    def captured(self):
        if self.r["SR"] & CC1IF:
            self.r["SR"] |= 1 << 9
        self.r["CCR1"] = self.read_CNT()
        self.r["SR"] |= CC1IF
        self.line()
        self.plan_capture()

    def read_CCR1(self):
        if self.r["CCMR1"] & 3:
            self.r["SR"] &= ~CC1IF
            self.line()
        return self.r["CCR1"]
