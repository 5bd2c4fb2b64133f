"""The Cortex-M4: instructions by Unicorn; exceptions, priorities, sleep, faults and time here.

Unicorn executes up to the next event, and counts the instructions. An exception is entered and left here, as the
architecture says (ARMv7-M B1.5), between two instructions. While one is pending that does not come yet, instructions are
executed few at a time. `observe` finds what masks interrupts, and delay loops, in the code, and then knows their times to
the clock; it is several times as slow.
"""

import ctypes
import re
import struct

from unicorn import (UC_ARCH_ARM, UC_HOOK_CODE, UC_HOOK_INTR, UC_HOOK_MEM_PROT, UC_HOOK_MEM_READ,
                     UC_HOOK_MEM_UNMAPPED, UC_HOOK_MEM_WRITE, UC_MEM_FETCH_PROT, UC_MEM_FETCH_UNMAPPED,
                     UC_MEM_WRITE_PROT, UC_MODE_MCLASS, UC_MODE_THUMB, UC_PROT_EXEC, UC_PROT_READ,
                     UC_PROT_WRITE, Uc)
from unicorn import arm_const as arm
from unicorn.unicorn_py3.unicorn import uclib

from .units import UNITS_PER_S

# Clocks of an instruction on average, 4/3: loads, taken branches and what the flash accelerator does not hide; an
# estimate from CoreMark (3.4 a MHz on this chip, DS8626) and its some 230,000 instructions a pass.
CLOCKS = (4, 3)
# Clocks of a pass of a delay loop, a subtraction and a taken branch (Cortex-M4 TRM 3.3.1: 1 and 1 + 1 to 3).
DELAY_PASS = 3
ENTRY_CLOCKS, EXIT_CLOCKS = 12, 10
# Address that no code has: Unicorn stops by count, not by address.
NOWHERE = 0xFFFF_FFF0
NMI, HARD_FAULT, MEM_MANAGE, BUS_FAULT, USAGE_FAULT = 2, 3, 4, 5, 6
# Registers of an exception's frame in its order (PC and return flags in XPSR aside), and what else entry and exit touch.
STACKED = [arm.UC_ARM_REG_R0, arm.UC_ARM_REG_R1, arm.UC_ARM_REG_R2, arm.UC_ARM_REG_R3, arm.UC_ARM_REG_R12,
           arm.UC_ARM_REG_LR] + [arm.UC_ARM_REG_S0 + k for k in range(16)] + [arm.UC_ARM_REG_FPSCR]
MASKS = [arm.UC_ARM_REG_BASEPRI, arm.UC_ARM_REG_PRIMASK]
FRAME_WORDS = struct.Struct("<26I")
FRAME = 104
# Instructions at a time while an exception is pending that is masked: how late it may come behind the unmasking.
FEW = 8

# In the code: cpsid i, cpsie i; msr basepri, msr basepri_max, msr primask; and a delay loop.
CPS = {b"\x72\xb6", b"\x62\xb6"}
MSR = re.compile(rb"[\x80-\x8e]\xf3[\x10\x11\x12]\x88", re.DOTALL)
DELAY = re.compile(rb"(?:.[\x38-\x3f]\xfd\xd1|\xb1\xf1\x01.\xfc\xd1|[\xb0-\xbe]\xf1\x01.\xfc\xd1)", re.DOTALL)


def counter_offset():
    """Offset of the counter of instructions within Unicorn's state, behind which the limit stands.

    Unicorn does not show them; reading one gives the time of an access within a run, and lowering the other ends the run
    where an event has come nearer. Found by what they hold after runs of known lengths.
    """
    uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
    uc.mem_map(0, 0x1000)
    uc.mem_write(0, struct.pack("<2H", 0x3101, 0xE7FD))  # adds r1, #1; b to it
    found = None
    for count in (12_345, 54_321):
        uc.emu_start(1, NOWHERE, count=count)
        words = (ctypes.c_uint64 * 4096).from_address(uc._uch.value)
        here = {k for k in range(4095) if words[k] == count + 1 and words[k + 1] == count}
        found = here if found is None else found & here
    if len(found) != 1:
        raise RuntimeError("this version of Unicorn keeps its counter elsewhere: see chip/requirements.txt")
    return 8 * found.pop()


class Batch:
    """Registers that are read or written together, in one call: one at a time costs more than all of the rest."""

    def __init__(self, uc, ids):
        self.handle, self.count = uc._uch, len(ids)
        self.ids = (ctypes.c_int * self.count)(*ids)
        self.values = (ctypes.c_uint64 * self.count)()
        base = ctypes.addressof(self.values)
        self.places = (ctypes.c_void_p * self.count)(*(base + 8 * k for k in range(self.count)))

    def read(self):
        uclib.uc_reg_read_batch(self.handle, self.ids, self.places, self.count)
        return [value & 0xFFFF_FFFF for value in self.values]

    def write(self, values):
        self.values[:] = values
        uclib.uc_reg_write_batch(self.handle, self.ids, self.places, self.count)


class Core:
    """The processor."""

    OFFSET = None

    def __init__(self, chip):
        if Core.OFFSET is None:
            Core.OFFSET = counter_offset()
        self.chip = chip
        uc = self.uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        uc.ctl_set_cpu_model(arm.UC_CPU_ARM_CORTEX_M4)
        self.counter = ctypes.c_uint64.from_address(uc._uch.value + Core.OFFSET)
        self.limit = ctypes.c_uint64.from_address(uc._uch.value + Core.OFFSET + 8)
        self.before = Batch(uc, STACKED + [arm.UC_ARM_REG_XPSR, arm.UC_ARM_REG_SP])
        # The exception number first: it decides in which mode the rest is written.
        self.after_entry = Batch(uc, [arm.UC_ARM_REG_XPSR, arm.UC_ARM_REG_SP, arm.UC_ARM_REG_LR])
        self.after_exit = Batch(uc, [arm.UC_ARM_REG_XPSR, arm.UC_ARM_REG_SP] + STACKED)
        self.masks = Batch(uc, MASKS)
        self.place = Batch(uc, [arm.UC_ARM_REG_PC])
        uc.hook_add(UC_HOOK_INTR, self.on_exception)
        uc.hook_add(UC_HOOK_MEM_UNMAPPED | UC_HOOK_MEM_PROT, self.on_bad_access)
        self.guard_hook = None
        self.regions = []
        self.running = False
        self.instructions = self.sleeps = 0
        self.masked = []  # (length in units, what masked, PC) of each section with interrupts masked.
        self.entries = {}  # Number of entries by exception.
        self.set_clock(16_000_000)
        self.lines = set()  # Exceptions whose line is high.
        self.pending = set()
        self.active = []
        self.clear()

    def clear(self):
        self.pending.clear()
        self.lines.clear()
        self.active = []
        self.stall = 0
        self.pc = 0
        self.asleep = self.returned = self.locked_up = self.event = False
        self.trouble = None
        self.masked_since = None

    def reset(self):
        """Begins at the vector table at the beginning of the flash."""
        self.clear()
        uc = self.uc
        stack, start = struct.unpack("<II", self.chip.memory(0x0800_0000, 8))
        uc.reg_write(arm.UC_ARM_REG_XPSR, 0x0100_0000)
        for register in (arm.UC_ARM_REG_CONTROL, arm.UC_ARM_REG_PRIMASK, arm.UC_ARM_REG_BASEPRI,
                         arm.UC_ARM_REG_FAULTMASK):
            uc.reg_write(register, 0)
        uc.reg_write(arm.UC_ARM_REG_LR, 0xFFFF_FFFF)
        uc.reg_write(arm.UC_ARM_REG_SP, stack)
        self.pc = start | 1
        self.protect([])

    def set_clock(self, hz):
        self.clock_units = UNITS_PER_S // hz
        self.cost = (self.clock_units * CLOCKS[0], CLOCKS[1])

    # Time within a run of instructions.

    def elapsed(self):
        """Units since the present run began; 0 between runs."""
        if not self.running:
            return 0
        return self.skipped + self.counter.value * self.cost[0] // self.cost[1]

    def end_by(self, time):
        """An event has come nearer: ends the present run there."""
        if self.running:
            left = time - self.chip.time - self.skipped
            count = max(self.counter.value, -(-left * self.cost[1] // self.cost[0]))
            if count < self.limit.value:
                self.limit.value = count

    def end_now(self):
        """Ends the present run behind the present instruction."""
        if self.running:
            self.limit.value = self.counter.value

    def skip(self, length):
        """Lets time pass within a run, up to the next event: what is executed meanwhile changes nothing."""
        if self.running:
            room = self.ends - self.chip.time - self.elapsed()
            self.skipped += max(0, min(length, room))
            self.end_by(self.ends)

    def stall_until(self, time):
        self.stall = max(self.stall, time)
        self.end_now()

    # Interrupts.

    def pend(self, number):
        self.pending.add(number)
        self.end_now()

    def line(self, number, level):
        if level:
            if number not in self.lines:
                self.lines.add(number)
                self.pend(number)
        else:
            self.lines.discard(number)

    def reconsider(self):
        if self.pending:
            self.end_now()

    def active_numbers(self):
        return [number for number, _ in self.active]

    def priority(self, number):
        if number in (NMI, HARD_FAULT):
            return number - 4
        return self.chip.scs.priority[number]

    def level(self, primask=True):
        """Priority of what runs: only what is more urgent, that is smaller, comes."""
        level = min((priority for _, priority in self.active), default=256)
        base, masked = self.masks.read()
        if base:
            level = min(level, base)
        return min(level, 0) if primask and masked & 1 else level

    def takeable(self, primask=True):
        """The most urgent exception that comes now; None."""
        if not self.pending:
            return None
        enabled = self.chip.scs.enabled
        ready = [(self.priority(n), n) for n in self.pending if n < 16 or n in enabled]
        if not ready:
            return None
        priority, number = min(ready)
        return number if priority < self.level(primask) else None

    def enter(self, number):
        """Enters an exception: the frame with floating-point registers, whether they were used or not."""
        self.asleep = False
        self.pending.discard(number)
        self.entries[number] = self.entries.get(number, 0) + 1
        *registers, flags, stack = self.before.read()
        frame = stack - FRAME & ~7
        flags = flags & ~(1 << 9) | (1 << 9 if stack - FRAME & 4 else 0) | 0x0100_0000
        words = registers[:6] + [self.pc & ~1, flags] + registers[6:] + [0]
        if self.open(frame, FRAME):
            self.uc.mem_write(frame, FRAME_WORDS.pack(*words))
        else:
            self.chip.scs.r["CFSR"] |= 1 << 4 if self.mapped(frame, FRAME) else 1 << 12
            number = HARD_FAULT
        self.active.append((number, self.priority(number)))
        self.after_entry.write([0x0100_0000 | number, frame, 0xFFFF_FFE1 if len(self.active) > 1 else 0xFFFF_FFE9])
        vectors = self.chip.scs.r["VTOR"] or 0x0800_0000
        self.pc = int.from_bytes(self.chip.memory(vectors + 4 * number, 4), "little") | 1
        self.chip.time += ENTRY_CLOCKS * self.clock_units

    def leave(self):
        """Leaves an exception by its return value in PC."""
        number, _ = self.active.pop()
        frame = self.uc.reg_read(arm.UC_ARM_REG_SP)
        words = FRAME_WORDS.unpack(self.uc.mem_read(frame, FRAME))
        flags = words[7]
        outer = self.active[-1][0] if self.active else 0
        stack = frame + FRAME + (4 if flags >> 9 & 1 else 0)
        self.after_exit.write([flags & ~(1 << 9) & ~0x1FF | outer, stack, *words[:6], *words[8:25]])
        self.pc = words[6] | 1
        if number in self.lines:
            self.pending.add(number)
        self.event = True
        self.chip.time += EXIT_CLOCKS * self.clock_units

    # Memory protection and faults.

    def protect(self, regions):
        """Memory protection as the MPU's regions say: (first, last, open, executable)."""
        self.regions = regions
        if self.guard_hook is not None:
            self.uc.hook_del(self.guard_hook)
            self.guard_hook = None
        closed = [(a, b) for a, b, open_, _ in regions if not open_]
        executable = not any(a <= 0x2000_0000 <= b and not run for a, b, _, run in regions)
        for start, size in self.chip.rams:
            prot = UC_PROT_READ | UC_PROT_WRITE | (UC_PROT_EXEC if executable else 0)
            if any(a <= start and start + size - 1 <= b for a, b in closed):
                prot = 0
            self.uc.mem_protect(start, size, prot)
        for a, b in closed:
            if b - a < 0x400:
                self.guard_hook = self.uc.hook_add(UC_HOOK_MEM_READ | UC_HOOK_MEM_WRITE, self.on_guard, begin=a, end=b)

    def mapped(self, address, size):
        return any(a <= address and address + size <= a + n for a, n in self.chip.rams)

    def open(self, address, size):
        """Whether data may be written there."""
        last = address + size - 1
        closed = any(a <= last and address <= b for a, b, open_, _ in self.regions if not open_)
        return self.mapped(address, size) and not closed

    def on_guard(self, uc, access, address, size, value, _):
        self.trouble = (UC_MEM_WRITE_PROT, address)
        uc.emu_stop()

    def on_bad_access(self, uc, access, address, size, value, _):
        self.trouble = (access, address)
        return False

    def on_exception(self, uc, number, _):
        if number == 8:
            self.returned = True
        else:
            self.trouble = ("exception", number)
        uc.emu_stop()

    def fault(self, kind, address):
        """Enters the fault that an access or an instruction has caused."""
        scs = self.chip.scs
        mapped = address is not None and isinstance(kind, int) and self.mapped(address, 1)
        if kind in (UC_MEM_FETCH_PROT,):
            number, bits = MEM_MANAGE, 1
        elif kind == UC_MEM_FETCH_UNMAPPED:
            number, bits = BUS_FAULT, 1 << 8
        elif kind == "exception":
            number, bits = USAGE_FAULT, {1: 1 << 16, 17: 1 << 19, 18: 1 << 17, 22: 1 << 24}.get(address, 1 << 16)
        elif mapped or any(a <= address <= b for a, b, open_, _ in self.regions if not open_):
            number, bits = MEM_MANAGE, 1 << 1 | 1 << 7
            scs.r["MMFAR"] = address
        else:
            number, bits = BUS_FAULT, 1 << 9 | 1 << 15
            scs.r["BFAR"] = address
        scs.r["CFSR"] |= bits
        at = f" at 0x{address:08x}" if number != USAGE_FAULT and address is not None else ""
        self.chip.note(f"fault 0x{bits:x}{at} by {self.where()}")
        enabled = scs.r["SHCSR"] >> {MEM_MANAGE: 16, BUS_FAULT: 17, USAGE_FAULT: 18}[number] & 1
        if any(n in (NMI, HARD_FAULT) for n in self.active_numbers()):
            self.chip.note(f"LOCKUP at {self.where()}")
            self.locked_up = True
            return
        if not enabled or self.priority(number) >= self.level():
            scs.r["HFSR"] |= 1 << 30
            number = HARD_FAULT
        self.enter(number)

    # What the code holds.

    def observe(self, start, data):
        """Observes delay loops, and instructions that mask interrupts, in the code at `start`."""
        # What has been translated already does not know the new hooks.
        self.uc.ctl_flush_tb()
        def hook(at, call):
            self.uc.hook_add(UC_HOOK_CODE, call, begin=at, end=at)

        for match in DELAY.finditer(data):
            if match.start() % 2 == 0:
                code = match.group()
                n = (code[1] & 7) if len(code) == 4 else code[3] & 15
                register = arm.UC_ARM_REG_R0 + n if n < 13 else None
                if register is not None and code[0] == 1 if len(code) == 4 else register is not None:
                    hook(start + match.start(), self.delay_hook(register))
        for at in range(0, len(data) - 3, 2):
            if data[at:at + 2] in CPS:
                hook(start + at, self.on_mask)
        for match in MSR.finditer(data):
            if match.start() % 2 == 0:
                hook(start + match.start(), self.on_mask)

    def delay_hook(self, register):
        def passes(uc, address, size, _):
            left = uc.reg_read(register)
            # Up to the next event at most; the last pass is executed.
            time = self.chip.time + self.elapsed()
            due = self.chip.events.next_time()
            room = (due - time) // (DELAY_PASS * self.clock_units) if due is not None else left
            skip = min(left - 1, max(room, 0)) if left else 0
            if skip > 0:
                uc.reg_write(register, left - skip)
                self.skipped += skip * DELAY_PASS * self.clock_units
            # What the count says of the pass that is executed: two instructions.
            self.skipped += DELAY_PASS * self.clock_units - 2 * self.cost[0] // self.cost[1]
            self.end_by(self.ends)
        return passes

    def on_mask(self, uc, address, size, _):
        """Behind an instruction that masks or unmasks interrupts: looks at what is pending, and at the time."""
        self.end_now()
        self.mask_at = address

    def mask_state(self):
        if self.uc.reg_read(arm.UC_ARM_REG_PRIMASK) & 1:
            return "PRIMASK"
        base = self.uc.reg_read(arm.UC_ARM_REG_BASEPRI)
        return f"BASEPRI {base}" if base else None

    def observe_mask(self):
        self.mask_at = None
        state = self.mask_state()
        if self.masked_since and state != self.masked_since[1]:
            since, what, where = self.masked_since
            self.masked.append((self.chip.time - since, what, where))
            self.masked_since = None
        if state and not self.masked_since:
            self.masked_since = (self.chip.time, state, self.pc)

    mask_at = None
    skipped = 0
    ends = 0

    # Execution.

    def step(self, until):
        """Executes up to the next event, exception or `until`; the chip's time goes on."""
        chip = self.chip
        due = chip.events.next_time()
        ends = self.ends = until if due is None else min(due, until)
        if self.locked_up or self.stall > chip.time:
            chip.time = ends if self.locked_up else min(self.stall, ends)
            return
        number = self.takeable()
        if number is not None:
            self.enter(number)
            return
        if self.asleep:
            if self.takeable(primask=False) is None:
                chip.time = ends
                return
            self.asleep = False
        self.execute(ends)

    def execute(self, ends):
        chip, uc = self.chip, self.uc
        count = max(1, -(-(ends - chip.time) * self.cost[1] // self.cost[0]))
        if self.pending:
            count = min(count, FEW)
        self.skipped = 0
        self.counter.value = 0
        self.running = True
        uc._hook_exception = None
        status = uclib.uc_emu_start(uc._uch, self.pc, NOWHERE, 0, count)
        passed = self.elapsed_at_end()
        self.running = False
        if uc._hook_exception is not None:
            raise uc._hook_exception
        self.pc = self.place.read()[0] | 1
        waited = self.stopped_early and not self.returned and self.waited()
        if status and self.trouble is None and not self.returned and not waited:
            self.trouble = ("exception", 1)
        chip.time += passed
        if chip.off:
            return
        if waited:
            self.trouble = None
        if self.trouble is not None:
            trouble, self.trouble = self.trouble, None
            self.fault(*trouble)
        elif self.returned:
            self.returned = False
            self.leave()
        if self.mask_at is not None:
            self.observe_mask()

    def elapsed_at_end(self):
        executed = min(self.counter.value, self.limit.value)
        self.stopped_early = self.counter.value <= self.limit.value
        self.instructions += executed
        return self.skipped + executed * self.cost[0] // self.cost[1]

    def waited(self):
        """Whether the run has ended behind WFI or WFE, which puts the core to sleep (ARMv7-M B1.5.18, B1.5.19)."""
        behind = self.pc & ~1
        if not 0x0800_0000 < behind < 0x0810_0000:
            return False
        before = self.chip.memory(behind - 2, 2)
        if before == b"\x30\xbf":
            self.asleep = True
        elif before == b"\x20\xbf":
            # An event since the last WFE, which each exception is, is used up; without one it sleeps.
            self.asleep, self.event = not self.event, False
        else:
            return False
        self.sleeps += 1
        return True

    def where(self):
        return self.chip.symbol(self.uc.reg_read(arm.UC_ARM_REG_PC) if self.running else self.pc & ~1)
