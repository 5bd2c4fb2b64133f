"""The loader's update over the wire: trial, confirmation, rollback, and power cuts at any operation of the flash."""

import random
import subprocess

import pytest
from board.terminal import framed
from board.updater import Updater, images
from conftest import FIRMWARE, PROGRAM, ROOT, Bench, fields, in_fork

FLASH_CR = 0x4002_3C10
MBAUD = 3_000_000
CUTS = 200


@pytest.fixture(scope="session")
def package(tmp_path_factory):
    """The image that is flashed, once more with a higher number: what `cargo sim keys sign` writes."""
    signed = tmp_path_factory.mktemp("update") / "new.signed"
    # A copy: signing seals the file.
    elf = signed.with_suffix(".elf")
    elf.write_bytes((FIRMWARE / "stairscan").read_bytes())
    subprocess.run([PROGRAM, "keys", "sign", str(elf), "--key", str(ROOT / "boot/keys/development.key"), "--number", "2",
                    "-o", str(signed)], check=True, capture_output=True)
    return signed.read_bytes()


def in_loader(one):
    """A running scanner that has been told to take a new image."""
    one.boot()
    one.terminal.command("stop", "DONE")
    one.terminal.send(framed("PSTC,update"))
    one.terminal.wait("LOADER")
    return one


def update(one, package, until=None):
    with Updater(one.terminal) as updater:
        updater.hello()
        updater.rate(MBAUD)
        return updater.send(package, until)


def slots(line):
    """Slot, trial and states of both slots in a LOADER sentence."""
    return fields(line)[2:6]


def test_an_update_is_on_trial_then_confirmed_and_survives_a_power_cut(bench, package):
    one = in_loader(bench())
    assert update(one, package) == 0
    assert slots(one.terminal.wait("LOADER")) == ["b", "1", "confirmed", "trial"]
    one.terminal.wait("BOOT")
    # The self-test passes with a radar module only; here the image stays on trial until the third try is used up.
    for attempt in ("2", "3"):
        one.chip.press_reset()
        assert slots(one.terminal.wait("LOADER"))[:2] == ["b", attempt]
        one.terminal.wait("BOOT")
    one.chip.press_reset()
    # Rolled back: the confirmed image runs again.
    assert slots(one.terminal.wait("LOADER")) == ["a", "0", "confirmed", "failed"]
    assert fields(one.terminal.wait("BOOT"))[1] == "BOOT"


@pytest.mark.slow
def test_an_image_whose_self_test_passes_is_confirmed(bench, package):
    from test_scan import connected
    one = bench()
    module = connected(one, 3)
    assert one.terminal.command("save").startswith("$PSTR,DONE")
    one.terminal.send(framed("PSTC,update"))
    one.terminal.wait("LOADER")
    assert update(one, package) == 0
    assert slots(one.terminal.wait("LOADER"))[:2] == ["b", "1"]
    one.terminal.wait("BOOT")
    one.terminal.send("start\r\n")
    line = one.terminal.wait("LOADER", length=20)
    module.close()
    # The anti-rollback counter has gone up: the image before is an older version now.
    assert slots(line) == ["b", "0", "older-version", "confirmed"]


def test_an_image_that_was_altered_is_refused(bench, package):
    one = in_loader(bench())
    altered = bytearray(package)
    for header, _ in images(package):
        altered[package.index(header) + 30] ^= 1
    with Updater(one.terminal) as updater:
        updater.hello()
        assert updater.send(bytes(altered)) not in (0, None)
    # Nothing of the flash was touched.
    assert one.chip.flash.operations == 0


def test_control_lock_written_back(bench, package):
    """The defect that no update could be installed with."""
    one = in_loader(bench())
    one.chip.spoil[FLASH_CR] = lambda value: value | 1 << 31
    with Updater(one.terminal) as updater:
        updater.hello()
        assert updater.send(package, until=2048) not in (0, None)
    assert one.chip.flash.operations == 0
    one.chip.complaints.clear()


def test_below_2_7_volts_nothing_is_written(bench, package):
    one = in_loader(bench())
    one.chip.supply(2.6)
    with Updater(one.terminal) as updater:
        updater.hello()
        assert updater.send(package, until=2048) not in (0, None)
    assert one.chip.flash.operations == 0


# An update's first part: three erasures, the header, and 16 KB of words; the rest of the words are alike.
OPERATIONS = 3 + 36 + 4096
FIRST = [1, 2, 3, 4, 39, 40]


def cut(one, package, at):
    """What runs after a power cut in operation `at` of an update, and the code of the update that follows."""
    one.chip.flash.cut_at = one.chip.flash.operations + at
    update(one, package, until=16 * 1024)
    assert one.chip.off, "the power was to go"
    one.chip.flash.cut_at = None
    one.terminal.partial.clear()
    one.chip.power_on()
    boot = fields(one.terminal.wait("BOOT"))
    # A transfer that was cut off goes on, or begins anew.
    one.terminal.command("stop", "DONE")
    one.terminal.send(framed("PSTC,update"))
    one.terminal.wait("LOADER")
    code = update(one, package, until=20 * 1024)
    assert not one.chip.complaints, dict(one.chip.complaints)
    return boot[4], code


def check_cuts(package, places):
    one = in_loader(Bench())
    for at in places:
        cause, code = in_fork(lambda: cut(one, package, at))
        assert (cause, code) == ("power-on", 0), f"operation {at}: {cause}, {code}"


def drawn(count):
    return FIRST + sorted(random.Random(1).sample(range(41, OPERATIONS), count - len(FIRST)))


def test_power_cuts_at_some_places_of_an_update(package):
    places = drawn(CUTS)
    check_cuts(package, [places[k] for k in (0, 2, 4, 5, 100)])


@pytest.mark.slow
@pytest.mark.parametrize("part", range(10))
def test_power_cuts_at_200_places_of_an_update(package, part):
    check_cuts(package, drawn(CUTS)[part::10])
