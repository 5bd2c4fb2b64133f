"""PWR: voltage scale and the voltage detector PVD (RM0090 5.4), with its line 16 of EXTI."""

from .peripheral import Peripheral, Register

# Falling thresholds of the detector by PLS, volts, typical (DS8626, embedded reset and power control block).
FALLS_V = (2.04, 2.14, 2.24, 2.34, 2.50, 2.65, 2.85, 2.92)
HYSTERESIS_V = 0.1
PVD_LINE = 16


class Pwr(Peripheral):
    NAME = "PWR"
    BASE = 0x4000_7000
    GATE = ("APB1", 28)
    REGISTERS = (
        Register(0x00, "CR", "5.4.1", 0x4000, 0x43FF),
        Register(0x04, "CSR", "5.4.2", 0, 0x430F),
    )

    def __init__(self, chip):
        self.low = False
        super().__init__(chip)

    def reset(self):
        super().reset()
        self.low = False

    def write_CR(self, value):
        self.r["CR"] = value
        self.compare()

    def read_CSR(self):
        return self.r["CSR"] | 1 << 14 | self.low << 2

    def compare(self):
        """Compares the supply with the detector's threshold; an edge of its output goes to EXTI."""
        control = self.r["CR"]
        before = self.low
        threshold = FALLS_V[control >> 5 & 7]
        if not control >> 4 & 1:
            self.low = False
        elif self.chip.volts < threshold:
            self.low = True
        elif self.chip.volts > threshold + HYSTERESIS_V:
            self.low = False
        if self.low != before:
            self.chip.exti.edge(PVD_LINE, self.low)
