"""EXTI: edges of pins and of the voltage detector (RM0090 12.3), and SYSCFG, which chooses the port (9.2)."""

from .peripheral import Peripheral, Register

LINES = 23
BITS = (1 << LINES) - 1
# Interrupts of the lines (table 61): 0 to 4 their own, 5 to 9 and 10 to 15 together, 16 the PVD's.
IRQS = {0: 6, 1: 7, 2: 8, 3: 9, 4: 10, 16: 1}
IRQS.update({line: 23 for line in range(5, 10)})
IRQS.update({line: 40 for line in range(10, 16)})


class Exti(Peripheral):
    NAME = "EXTI"
    BASE = 0x4001_3C00
    REGISTERS = (
        Register(0x00, "IMR", "12.3.1", 0, BITS),
        Register(0x04, "EMR", "12.3.2", 0, BITS),
        Register(0x08, "RTSR", "12.3.3", 0, BITS),
        Register(0x0C, "FTSR", "12.3.4", 0, BITS),
        Register(0x10, "SWIER", "12.3.5", 0, BITS),
        Register(0x14, "PR", "12.3.6", 0, BITS),
    )

    def edge(self, line, rising):
        """An edge on a line."""
        if self.r["RTSR" if rising else "FTSR"] >> line & 1:
            self.r["PR"] |= 1 << line
            self.lines()

    def write_PR(self, value):
        self.r["PR"] &= ~value
        self.lines()

    def write_IMR(self, value):
        self.r["IMR"] = value
        self.lines()

    def lines(self):
        wanted = self.r["PR"] & self.r["IMR"]
        for irq in set(IRQS.values()):
            level = any(wanted >> line & 1 for line, of in IRQS.items() if of == irq)
            self.chip.core.line(16 + irq, level)


class Syscfg(Peripheral):
    NAME = "SYSCFG"
    BASE = 0x4001_3800
    GATE = ("APB2", 14)
    REGISTERS = (
        Register(0x00, "MEMRMP", "9.2.1", 0, 3),
        Register(0x04, "PMC", "9.2.2", 0, 0x0080_0000),
        Register(0x08, "EXTICR1", "9.2.3", 0, 0xFFFF),
        Register(0x0C, "EXTICR2", "9.2.4", 0, 0xFFFF),
        Register(0x10, "EXTICR3", "9.2.5", 0, 0xFFFF),
        Register(0x14, "EXTICR4", "9.2.6", 0, 0xFFFF),
        Register(0x20, "CMPCR", "9.2.7", 0, 0x101),
    )

    def port(self, n):
        """Letter of the port whose pin n is on line n."""
        return "ABCDEFGHI"[self.r[f"EXTICR{n // 4 + 1}"] >> 4 * (n % 4) & 15]
