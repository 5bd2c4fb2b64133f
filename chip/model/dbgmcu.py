"""DBGMCU: what stands still under a debugger (RM0090 38.16)."""

from .peripheral import Peripheral, Register


class Dbgmcu(Peripheral):
    NAME = "DBGMCU"
    BASE = 0xE004_2000
    REGISTERS = (
        Register(0x00, "IDCODE", "38.6.1", 0x1007_6413, read_only=True),
        Register(0x04, "CR", "38.16.3", 0, 0x0000_00E7),
        Register(0x08, "APB1_FZ", "38.16.4", 0, 0x06E0_1DFF),
        Register(0x0C, "APB2_FZ", "38.16.5", 0, 0x0007_0003),
    )

    def reset(self):
        # A system reset leaves these (38.16.3).
        if not self.r:
            super().reset()
