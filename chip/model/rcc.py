"""RCC: oscillators with their start-up times, PLL, clock tree, gates, causes of the last reset (RM0090 7)."""

from .peripheral import Peripheral, Register
from .units import UNITS_PER_S, us

HSI_HZ = 16_000_000
# Crystal: 2 ms typical (DS8626, HSE oscillator characteristics). PLL: 200 us at most (PLL characteristics).
HSE_STARTS_US = 2_000
PLL_LOCKS_US = 200
SWITCH_CLOCKS = 12

AHB_DIVIDERS = {8: 2, 9: 4, 10: 8, 11: 16, 12: 64, 13: 128, 14: 256, 15: 512}
APB_DIVIDERS = {4: 2, 5: 4, 6: 8, 7: 16}

# Gates and resets that this chip has (RM0090 7.3.10 to 7.3.14, 7.3.5 to 7.3.9).
AHB1 = 0x7E7411FF
APB1 = 0x36FEC9FF
APB2 = 0x00075F33


def gates(name, offset, section, bits, reset=0):
    return Register(offset, name, section, reset, bits)


class Rcc(Peripheral):
    NAME = "RCC"
    BASE = 0x4002_3800
    REGISTERS = (
        Register(0x00, "CR", "7.3.1", 0x83, 0x0F0F_FFFB),
        Register(0x04, "PLLCFGR", "7.3.2", 0x2400_3010, 0x0F43_7FFF),
        Register(0x08, "CFGR", "7.3.3", 0, 0xFFFF_FCFF),
        Register(0x0C, "CIR", "7.3.4", 0, 0x00BF_3FBF),
        gates("AHB1RSTR", 0x10, "7.3.5", 0x2260_11FF),
        gates("AHB2RSTR", 0x14, "7.3.6", 0x0000_00F1),
        gates("AHB3RSTR", 0x18, "7.3.7", 1),
        gates("APB1RSTR", 0x20, "7.3.8", APB1),
        gates("APB2RSTR", 0x24, "7.3.9", 0x0007_5933),
        gates("AHB1ENR", 0x30, "7.3.10", AHB1, 0x0010_0000),
        gates("AHB2ENR", 0x34, "7.3.11", 0x0000_00F1),
        gates("AHB3ENR", 0x38, "7.3.12", 1),
        gates("APB1ENR", 0x40, "7.3.13", APB1),
        gates("APB2ENR", 0x44, "7.3.14", APB2),
        Register(0x50, "AHB1LPENR", "7.3.15", 0x7E67_91FF),
        Register(0x54, "AHB2LPENR", "7.3.16", 0xF1),
        Register(0x58, "AHB3LPENR", "7.3.17", 1),
        Register(0x60, "APB1LPENR", "7.3.18", 0x36FE_C9FF),
        Register(0x64, "APB2LPENR", "7.3.19", 0x0007_5F33),
        Register(0x70, "BDCR", "7.3.20", 0, 0x0001_8307),
        Register(0x74, "CSR", "7.3.21", 0x0E00_0000, 0xFF00_0003),
        Register(0x80, "SSCGR", "7.3.22"),
        Register(0x84, "PLLI2SCFGR", "7.3.23", 0x2000_3000),
    )
    # Bits of the causes in CSR.
    CAUSES = {"power": 1 << 27 | 1 << 25 | 1 << 26, "pin": 1 << 26, "software": 1 << 28 | 1 << 26,
              "watchdog": 1 << 29 | 1 << 26, "brownout": 1 << 25 | 1 << 26}

    def __init__(self, chip):
        self.csr = 0
        self.hse_hz = 8_000_000  # 0: there is no crystal.
        self.hse_ready = self.pll_ready = None
        super().__init__(chip)

    def reset(self):
        super().reset()
        for event in (self.hse_ready, self.pll_ready):
            if event:
                event.cancel()
        self.hse_ready = self.pll_ready = None
        self.hse_on = self.pll_on = False
        self.source = 0
        self.hclk = HSI_HZ
        self.update()

    def begin(self, cause):
        """Marks the cause of a reset; flags stay until RMVF or power-up."""
        if cause == "power":
            self.csr = 0
        self.csr |= self.CAUSES[cause]

    # Clock tree.

    def enabled(self, bus, bit):
        return self.r[bus + "ENR"] >> bit & 1

    def pll_hz(self):
        value = self.r["PLLCFGR"]
        source = self.hse_hz if value >> 22 & 1 else HSI_HZ
        m, n, p = value & 63, value >> 6 & 511, 2 * ((value >> 16 & 3) + 1)
        return source * n // (m * p) if m else 0

    def check_pll(self):
        value = self.r["PLLCFGR"]
        source = self.hse_hz if value >> 22 & 1 else HSI_HZ
        m, n, q = value & 63, value >> 6 & 511, value >> 24 & 15
        if m < 2 or not 950_000 <= source / m <= 2_100_000:
            self.complain(f"PLL input {source / max(m, 1) / 1e6:.2f} MHz, must be 0.95 to 2.1 (7.3.2)")
        elif not 100e6 <= source / m * n <= 432e6:
            self.complain(f"VCO {source / m * n / 1e6:.0f} MHz, must be 100 to 432 (7.3.2)")
        elif q >= 2 and source / m * n / q > 48_120_000:
            self.complain("48 MHz clock above 48 MHz (7.3.2)")

    def update(self):
        """Computes the frequencies, and checks them against the chip's limits."""
        cfgr = self.r["CFGR"]
        system = {0: HSI_HZ, 1: self.hse_hz, 2: self.pll_hz()}[self.source]
        apb1 = APB_DIVIDERS.get(cfgr >> 10 & 7, 1)
        apb2 = APB_DIVIDERS.get(cfgr >> 13 & 7, 1)
        self.hclk = system // AHB_DIVIDERS.get(cfgr >> 4 & 15, 1)
        self.pclk = {"APB1": self.hclk // apb1, "APB2": self.hclk // apb2}
        self.timer_hz = {
            "APB1": self.hclk if apb1 == 1 else 2 * self.hclk // apb1,
            "APB2": self.hclk if apb2 == 1 else 2 * self.hclk // apb2,
        }
        self.chip.clock_changed(self.hclk)

    def check(self):
        if self.hclk > 168_000_000:
            self.complain(f"HCLK {self.hclk / 1e6:.0f} MHz, at most 168")
        if self.pclk["APB1"] > 42_000_000 or self.pclk["APB2"] > 84_000_000:
            self.complain(f"bus clocks {self.pclk}, at most 42 and 84 MHz")
        if self.hclk > 144_000_000 and not self.chip.pwr.r["CR"] >> 14 & 1:
            self.complain("above 144 MHz at voltage scale 2 (5.4.1)")
        self.chip.flash.check_wait_states()

    # Registers.

    def read_CR(self):
        value = self.r["CR"] & ~(1 << 17 | 1 << 25 | 2)
        return value | (value & 1) << 1 | self.hse_on << 17 | self.pll_on << 25

    def write_CR(self, value):
        before, self.r["CR"] = self.r["CR"], value
        rose = value & ~before
        fell = before & ~value
        if fell >> 0 & 1 and self.source == 0:
            self.complain("HSI switched off while it is the system clock (ignored)")
            self.r["CR"] |= 1
        if rose >> 16 & 1 and self.hse_hz:
            self.hse_ready = self.chip.after(us(HSE_STARTS_US), self.hse_started)
        if fell >> 16 & 1:
            if self.source == 1 or self.source == 2 and self.r["PLLCFGR"] >> 22 & 1:
                self.complain("HSE switched off while it is in use")
            self.stop_hse()
        if rose >> 24 & 1:
            if self.r["PLLCFGR"] >> 22 & 1 and not self.hse_on:
                self.complain("PLL switched on before its source runs")
            self.check_pll()
            self.pll_ready = self.chip.after(us(PLL_LOCKS_US), self.pll_locked)
        if fell >> 24 & 1:
            if self.source == 2:
                self.complain("PLL switched off while it is the system clock")
            self.stop_pll()

    def hse_started(self):
        self.hse_on = True

    def pll_locked(self):
        self.pll_on = bool(self.hse_on or not self.r["PLLCFGR"] >> 22 & 1)

    def stop_hse(self):
        if self.hse_ready:
            self.hse_ready.cancel()
        self.hse_on = False

    def stop_pll(self):
        if self.pll_ready:
            self.pll_ready.cancel()
        self.pll_on = False

    def crystal_stops(self):
        """The crystal fails: with CSS the chip goes on from its internal oscillator, by an NMI (7.2.7)."""
        self.hse_hz = 0
        used = self.source == 1 or self.source == 2 and self.r["PLLCFGR"] >> 22 & 1
        watched = self.r["CR"] >> 19 & 1
        self.stop_hse()
        self.stop_pll()
        self.r["CR"] &= ~(1 << 16 | 1 << 24)
        if used and not watched:
            self.complain("the crystal has stopped, and nothing watches it: the core stands still")
        self.source = 0
        self.r["CFGR"] &= ~3
        self.update()
        if watched:
            self.r["CIR"] |= 1 << 7
            self.chip.core.pend(2)

    def write_PLLCFGR(self, value):
        if self.r["CR"] >> 24 & 1:
            self.complain("PLLCFGR written while the PLL is on (7.3.2)")
            return
        self.r["PLLCFGR"] = value

    def read_CFGR(self):
        return self.r["CFGR"] & ~0xC | self.source << 2

    def write_CFGR(self, value):
        self.r["CFGR"] = value & ~0xC
        wanted = value & 3
        if wanted == 2 and not self.pll_on:
            self.complain("switched to a PLL that is not locked (7.3.3)")
        elif wanted == 1 and not self.hse_on:
            self.complain("switched to a crystal that is not stable (7.3.3)")
        elif wanted != 3:
            self.chip.after(SWITCH_CLOCKS * UNITS_PER_S // self.hclk, lambda: self.switch(wanted))
        self.update()

    def switch(self, source):
        if self.r["CFGR"] & 3 == source:
            self.source = source
            self.update()
            self.check()

    def write_CIR(self, value):
        flags = self.r["CIR"] & 0xFF & ~(value >> 16 & 0xFF)
        self.r["CIR"] = value & 0x3F00 | flags

    def read_CSR(self):
        lsi = self.r["CSR"] & 1
        return self.csr | lsi | lsi << 1

    def write_CSR(self, value):
        if value >> 24 & 1:
            self.csr = 0
        self.r["CSR"] = value & 1

    def resets(self, bus, value):
        """A set bit holds its peripheral in reset."""
        for peripheral in self.chip.peripherals:
            if peripheral.GATE and peripheral.GATE[0] == bus and value >> peripheral.GATE[1] & 1:
                peripheral.reset()
        self.r[bus + "RSTR"] = value

    def write_AHB1RSTR(self, value):
        self.resets("AHB1", value)

    def write_APB1RSTR(self, value):
        self.resets("APB1", value)

    def write_APB2RSTR(self, value):
        self.resets("APB2", value)
