"""A crash: its place survives the reset, stands in BOOT and in the answer to `crash?`."""

import subprocess

import pytest
from conftest import FIRMWARE, PROGRAM, fields

from unicorn import arm_const as arm


def crashed(one, how):
    """A running scanner that crashes by `how`; the fields of the BOOT that follows."""
    one.boot()
    one.chip.run(0.3)
    how(one.chip)
    one.terminal.wait("HALT")
    return fields(one.terminal.wait("BOOT"))


def by_jump(chip):
    chip.core.pc = 0x3000_0001


def by_undefined_instruction(chip):
    chip.core.asleep = False
    chip.core.fault("exception", 1)


def by_read_of_nothing(chip):
    chip.core.asleep = False
    chip.core.fault(19, 0x4FFF_0000)


def by_stack(chip):
    # The stack pointer has left the memory: the next exception finds no room for its frame.
    chip.core.uc.reg_write(arm.UC_ARM_REG_SP, 0x2000_0010)
    chip.core.asleep = False
    chip.core.fault("exception", 1)


def dump(boot):
    """PC, LR, CFSR, fault address and place in a BOOT."""
    return boot[11:16]


def test_an_undefined_instruction_is_found_by_file_and_line(bench):
    one = bench()
    at = []

    def how(chip):
        at.append(chip.core.pc & ~1)
        by_undefined_instruction(chip)

    boot = crashed(one, how)
    assert boot[4] == "hard-fault"
    pc, lr, cfsr, address, place = dump(boot)
    assert int(pc, 16) & ~1 == at[0] and int(cfsr, 16) & 1 << 16 and address == "" and place == ""
    answer = fields(one.terminal.command("crash?", "CRASH"))
    assert pc in answer and lr in answer and cfsr in answer
    # A reset later it is still known.
    one.chip.press_reset()
    one.terminal.wait("BOOT")
    assert pc in fields(one.terminal.command("crash?", "CRASH"))
    line = one.terminal.lines[[line.startswith("$PSTR,BOOT") for line in one.terminal.lines].index(True, 1)]
    told = subprocess.run([PROGRAM, "crash", str(FIRMWARE / "stairscan"), "--sentence", line], capture_output=True, text=True)
    assert told.returncode == 0, told.stderr
    assert ".rs:" in told.stdout, told.stdout


def test_an_access_to_nothing_has_its_address(bench):
    boot = crashed(bench(), by_read_of_nothing)
    _, _, cfsr, address, _ = dump(boot)
    assert int(cfsr, 16) & 1 << 15 and int(address, 16) == 0x4FFF_0000


def test_a_jump_into_nothing(bench):
    boot = crashed(bench(), by_jump)
    assert int(dump(boot)[2], 16) & 1 << 8 and int(dump(boot)[0], 16) & ~1 == 0x3000_0000


def test_a_stack_that_has_left_the_memory_has_no_frame(bench):
    boot = crashed(bench(), by_stack)
    assert boot[4] in ("hard-fault", "memory-fault")
    assert dump(boot)[0] in ("", "00000000")


def test_control_retained_memory_that_is_lost(bench):
    """Without power in between the record is noise: no crash is made up."""
    one = bench()
    one.boot()
    one.chip.run(0.3)
    by_undefined_instruction(one.chip)
    one.terminal.wait("HALT")
    one.chip.run(0.0001)
    one.chip.power_cut()
    one.chip.power_on()
    boot = fields(one.terminal.wait("BOOT"))
    assert boot[4] == "power-on" and dump(boot) == [""] * 5
    assert not any("000" in field for field in fields(one.terminal.command("crash?", "CRASH"))[3:])


@pytest.mark.parametrize("seed", [11, 12])
def test_noise_at_power_up_is_no_crash(bench, seed):
    assert dump(fields(bench(seed=seed).boot())) == [""] * 5
