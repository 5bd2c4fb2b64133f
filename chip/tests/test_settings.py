"""Settings: set, save, reset, get; and a power cut at every operation of a save."""

import pytest
from conftest import Bench, fields, in_fork

FLASH_CR = 0x4002_3C10
SETTINGS = (("plane", "depth"), ("mirror-offset", "22000"), ("mount-height", "40000"), ("home-angle", "-165000"))


def prepared(one):
    one.boot()
    one.terminal.command("stop", "DONE")
    for key, value in SETTINGS:
        one.terminal.set(key, value)
    return one


def get(one, key):
    return fields(one.terminal.command(f"get,{key}", "CONF", "FAIL"))[2:]


def test_what_is_saved_stands_after_a_reset_and_a_power_cut(bench):
    one = prepared(bench())
    assert one.terminal.command("save").startswith("$PSTR,DONE,save")
    one.chip.press_reset()
    assert fields(one.terminal.wait("BOOT"))[4] == "reset-pin"
    assert get(one, "mount-height") == ["mount-height", "40000"]
    one.chip.power_cut()
    one.chip.power_on()
    one.terminal.wait("BOOT")
    assert get(one, "mount-height") == ["mount-height", "40000"]
    assert one.chip.flash.locked and not one.chip.flash.stale


def test_erased_sectors_are_a_return_to_the_factory_settings(bench):
    one = prepared(bench())
    one.terminal.set("mount-height", "41000")
    assert one.terminal.command("save").startswith("$PSTR,DONE,save")
    one.chip.power_cut()
    # As a probe erases sectors 1 and 2.
    one.chip.memory_write(0x0800_4000, b"\xff" * 0x8000)
    one.chip.power_on()
    one.terminal.wait("BOOT")
    assert get(one, "mount-height") == ["mount-height", "40000"]
    one.terminal.command("stop", "DONE")


def test_a_save_at_a_low_supply_is_refused(bench):
    one = prepared(bench())
    one.chip.volts = 2.6  # Below the detector's threshold, without its interrupt.
    one.chip.exti.r["IMR"] &= ~(1 << 16)
    one.chip.pwr.compare()
    answer = one.terminal.command("save")
    assert answer.startswith("$PSTR,FAIL,save,") and "supply" in answer
    assert get(one, "mount-height") == ["mount-height", "40000"]


def test_control_lock_written_back(bench):
    """The defect that no setting could be saved with: LOCK is 1 in the reset value that a write began from."""
    one = prepared(bench())
    one.chip.spoil[FLASH_CR] = lambda value: value | 1 << 31
    assert one.terminal.command("save").startswith("$PSTR,FAIL,save")
    one.chip.complaints.clear()


def saved_twice():
    """A bench with a saved mount height of 400 mm and one of 410 that is to be saved."""
    one = prepared(Bench())
    assert one.terminal.command("save").startswith("$PSTR,DONE,save")
    one.terminal.set("mount-height", "41000")
    return one


def heights(one, cut):
    """Mount height after a power cut in operation `cut` of a save; None where the save ended before."""
    chip = one.chip
    first = chip.flash.operations
    chip.flash.cut_at = first + cut
    answer = None
    try:
        answer = one.terminal.command("save")
    except AssertionError:
        pass
    if answer is not None:
        return None
    chip.flash.cut_at = None
    chip.power_on()
    boot = one.terminal.wait("BOOT", length=5)
    assert fields(boot)[4] == "power-on"
    found = get(one, "mount-height")
    assert not chip.complaints, dict(chip.complaints)
    return found[1]


def every_cut(positions):
    one = saved_twice()
    found = [in_fork(lambda: heights(one, cut)) for cut in positions]
    return [height for height in found if height is not None]


def operations():
    """Number of words and erasures of a save."""
    def count():
        one = saved_twice()
        before = one.chip.flash.operations
        one.terminal.command("save")
        return one.chip.flash.operations - before
    return in_fork(count)


def check(found, total):
    assert found and set(found) <= {"40000", "41000"}, found
    # Old before, new behind: never both ways.
    assert found == sorted(found), found
    assert len(found) == total


def test_a_power_cut_at_some_words_of_a_save_leaves_old_or_new():
    total = operations()
    assert total > 20
    positions = sorted({1, 2, 3, total // 3, total // 2, total - 2, total - 1, total})
    check(every_cut(positions), len(positions))


@pytest.mark.slow
def test_a_power_cut_at_each_word_of_a_save_leaves_old_or_new():
    total = operations()
    check(every_cut(range(1, total + 1)), total)
