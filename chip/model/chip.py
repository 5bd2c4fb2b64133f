"""The whole chip: memories, peripherals, bus, time, resets and power."""

import bisect
import collections
import random

from elftools.elf.elffile import ELFFile
from unicorn import UC_HOOK_MEM_WRITE, UC_PROT_ALL

from . import dbgmcu, exti, flash, gpio, iwdg, pwr, rcc, scs, spi, tim, usart
from .core import Core
from .events import Events
from .units import seconds, units

SRAM = (0x2000_0000, 128 * 1024)
CCM = (0x1000_0000, 64 * 1024)
UNIQUE_ID = (0x1FFF_7A10, bytes.fromhex("2600370018513432383335370000"[:24]))
FLASH_KB = (0x1FFF_7A22, (1024).to_bytes(2, "little"))


class Chip:
    """An STM32F405RG on its board, without power until `power_on`."""

    def __init__(self, seed=1, ccm=True, verbose=False):
        self.random = random.Random(seed)
        self.verbose = verbose
        self.time = 0
        self.events = Events()
        self.volts = 3.3
        self.off = True
        self.rams = [SRAM] + ([CCM] if ccm else [])
        self.complaints = collections.Counter()
        self.notes = []
        self.resets = []
        self.symbols, self.names = [], []
        self.halted = False
        self.core = Core(self)
        uc = self.core.uc
        uc.mem_map(flash.BASE, flash.SIZE)
        uc.mem_write(flash.BASE, b"\xff" * flash.SIZE)
        for start, size in self.rams:
            uc.mem_map(start, size, UC_PROT_ALL)
        uc.mem_map(0x1FFF_0000, 0x10000)
        for start, data in (UNIQUE_ID, FLASH_KB):
            uc.mem_write(start, data)
        uc.mem_map(0xFFFF_F000, 0x1000)
        uc.hook_add(UC_HOOK_MEM_WRITE, self.on_flash_write, begin=flash.BASE, end=flash.BASE + flash.SIZE - 1)
        self.add_peripherals()
        for base, size in ((0x4000_0000, 0x8_0000), (0x5000_0000, 0x8_0000), (0xE000_0000, 0x10_0000)):
            uc.mmio_map(base, size, self.read, base, self.write, base)
        uc.mmio_map(0x4200_0000, 0x100_0000, self.bit_read, 0, self.bit_write, 0)

    def add_peripherals(self):
        self.peripherals = []
        self.at_base = {}
        self.words = {}
        # Defects put back: by address, what becomes of a value that the program writes; None: nothing is written.
        self.spoil = {}
        self.gpio = None
        self.rcc = None
        self.rcc = self.add(rcc.Rcc(self))
        self.pwr = self.add(pwr.Pwr(self))
        self.flash = self.add(flash.Flash(self))
        self.iwdg = self.add(iwdg.Iwdg(self))
        self.scs = self.add(scs.Scs(self))
        self.dwt = self.add(scs.Dwt(self))
        self.dbgmcu = self.add(dbgmcu.Dbgmcu(self))
        self.syscfg = self.add(exti.Syscfg(self))
        self.exti = self.add(exti.Exti(self))
        self.gpio = gpio.Gpio(self)
        for port in self.gpio.ports.values():
            self.add(port)
        ports = (("USART1", 0x4001_1000, ("APB2", 4), 37, ("PA9", "PA10")),
                 ("USART2", 0x4000_4400, ("APB1", 17), 38, ("PA2", "PA3")),
                 ("USART3", 0x4000_4800, ("APB1", 18), 39, ("PB10", "PB11")))
        self.usart = {name: self.add(usart.Usart(self, name, *rest)) for name, *rest in ports}
        timers = (("TIM2", 0x4000_0000, ("APB1", 0), 28, 32), ("TIM3", 0x4000_0400, ("APB1", 1), 29, 16),
                  ("TIM4", 0x4000_0800, ("APB1", 2), 30, 16), ("TIM5", 0x4000_0C00, ("APB1", 3), 50, 32),
                  ("TIM6", 0x4000_1000, ("APB1", 4), 54, 16), ("TIM7", 0x4000_1400, ("APB1", 5), 55, 16),
                  ("TIM9", 0x4001_4000, ("APB2", 16), 24, 16), ("TIM10", 0x4001_4400, ("APB2", 17), 25, 16),
                  ("TIM11", 0x4001_4800, ("APB2", 18), 26, 16))
        self.tim = {name: self.add(tim.Timer(self, name, *rest)) for name, *rest in timers}
        self.spi1 = self.add(spi.Spi(self, "SPI1", 0x4001_3000, ("APB2", 12), ("PA5", "PA6", "PA7")))

    def add(self, peripheral):
        self.peripherals.append(peripheral)
        if peripheral.NAME != "SCS":
            gate, bit = (peripheral.GATE[0] + "ENR", peripheral.GATE[1]) if peripheral.GATE else (None, 0)
            for register in peripheral.REGISTERS:
                if not register.write_only:
                    self.words[peripheral.BASE + register.offset] = (
                        peripheral.readers[register.offset], peripheral, register.name, gate, bit)
        size = getattr(peripheral, "SIZE", 0x400)
        for base in range(peripheral.BASE, peripheral.BASE + size, 0x400):
            self.at_base[base] = peripheral
        return peripheral

    # Time.

    def now(self):
        return self.time + self.core.elapsed()

    def at(self, time, call):
        event = self.events.at(time, call)
        self.core.end_by(time)
        return event

    def after(self, length, call):
        return self.at(self.now() + length, call)

    def clock_changed(self, hclk):
        self.core.set_clock(hclk)
        self.core.end_now()

    def stop(self):
        """Ends `run` as soon as may be."""
        self.halted = True
        self.core.end_now()

    def run(self, length=None, until=None):
        """Lets time pass: `length` seconds, or until `until()` says so; False where that did not come in time."""
        end = self.time + units(length if length is not None else 60.0)
        while self.time < end and not self.off:
            self.events.run_until(self.time)
            if self.off:
                break
            if self.flash.pending:
                self.flash.settle()
            if self.wanted_reset:
                self.restart()
                continue
            if until is not None and until():
                return True
            self.core.step(end)
        return until is None or until()

    # Power and resets.

    def power_on(self, volts=3.3):
        """The supply comes: memory holds anything, the flash what it held."""
        self.volts = volts
        self.off = False
        self.wanted_reset = None
        for start, size in self.rams:
            self.memory_write(start, self.random.randbytes(size))
        self.dbgmcu.r = {}
        self.wanted_reset = "power"

    wanted_reset = None

    def power_cut(self):
        """The supply goes, now."""
        self.note("power cut")
        self.off = True
        self.core.end_now()
        self.events.clear()

    def supply(self, volts):
        """The supply changes."""
        self.volts = volts
        self.pwr.compare()

    def system_reset(self, cause):
        self.wanted_reset = cause
        self.core.end_now()

    def restart(self):
        cause, self.wanted_reset = self.wanted_reset, None
        self.resets.append((seconds(self.time), cause))
        self.note(f"reset: {cause}")
        self.rcc.begin(cause)
        for peripheral in self.peripherals:
            peripheral.reset()
        self.core.reset()

    def press_reset(self):
        self.system_reset("pin")

    # Bus.

    def read(self, uc, offset, size, base):
        address = base + offset
        entry = self.words.get(address & ~3)
        if entry is not None and size == 4:
            # As `Peripheral.read`, without its questions: a program polls registers all the time.
            reader, registers, name, gate, bit = entry
            if gate is None or self.rcc.r[gate] >> bit & 1:
                return reader() if reader else registers.r[name]
        peripheral = self.at_base.get(address & ~0x3FF)
        if peripheral is None:
            self.complain(f"read of 0x{address:08x}, where no peripheral is modelled")
            return 0
        return peripheral.read(address - peripheral.BASE, size)

    def write(self, uc, offset, size, value, base):
        address = base + offset
        spoilt = self.spoil.get(address & ~3)
        if spoilt:
            value = spoilt(value)
            if value is None:
                return
        peripheral = self.at_base.get(address & ~0x3FF)
        if peripheral is None:
            self.complain(f"write to 0x{address:08x}, where no peripheral is modelled")
            return
        peripheral.write(address - peripheral.BASE, size, value)

    def bit_read(self, uc, offset, size, _):
        word = 0x4000_0000 + (offset >> 7) * 4
        return self.read(uc, word - 0x4000_0000, 4, 0x4000_0000) >> (offset >> 2 & 31) & 1

    def bit_write(self, uc, offset, size, value, _):
        place, bit = (offset >> 7) * 4, offset >> 2 & 31
        before = self.read(uc, place, 4, 0x4000_0000)
        self.write(uc, place, 4, before & ~(1 << bit) | (value & 1) << bit, 0x4000_0000)

    # Memory.

    def memory(self, address, size):
        return bytes(self.core.uc.mem_read(address, size))

    def memory_write(self, address, data):
        self.core.uc.mem_write(address, data)

    def on_flash_write(self, uc, access, address, size, value, _):
        self.flash.programming(address, size, self.memory(address, size), value)
        self.core.end_now()

    def exti_pin(self, letter, n, level):
        if hasattr(self, "exti") and self.syscfg.port(n) == letter:
            self.exti.edge(n, level)

    # Code.

    def load(self, path):
        """Loads the segments of an ELF file into the flash, and its symbols."""
        with open(path, "rb") as file:
            elf = ELFFile(file)
            for segment in elf.iter_segments():
                if segment["p_type"] == "PT_LOAD" and segment["p_filesz"]:
                    self.memory_write(segment["p_paddr"], segment.data())
            self.add_symbols(elf)

    def add_symbols(self, elf, moved=0):
        found = dict(zip(self.symbols, self.names))
        for symbol in elf.get_section_by_name(".symtab").iter_symbols():
            if symbol["st_info"]["type"] == "STT_FUNC":
                found[(symbol["st_value"] & ~1) + moved] = symbol.name
        self.symbols = sorted(found)
        self.names = [found[address] for address in self.symbols]

    def symbol(self, address):
        k = bisect.bisect_right(self.symbols, address) - 1
        return f"0x{address:08x} {self.names[k][:80] if k >= 0 else '?'}"

    def address_of(self, part):
        """Address of the function whose name contains `part`."""
        return next(address for address, name in zip(self.symbols, self.names) if part in name)

    def observe(self, start, size):
        """From now on the times of delay loops and of sections with interrupts masked are exact, in this code."""
        self.core.observe(start, self.memory(start, size).rstrip(b"\xff"))

    # What is said.

    def complain(self, text):
        """Silicon would not forgive this."""
        self.complaints[text] += 1
        if self.complaints[text] == 1:
            self.note(f"COMPLAINT {text} at {self.core.where()}")

    def note(self, text):
        self.notes.append((seconds(self.now()), text))
        if self.verbose:
            print(f"[{seconds(self.now()):11.6f} s] {text}", flush=True)
