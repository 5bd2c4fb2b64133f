"""Register models at the pins: radar chip on SPI, motor driver on its wire, encoder on I2C; homing and stall."""

import pytest
from board.as5600 import As5600
from board.bgt60 import Bgt60
from board.tmc2209 import DRV_STATUS, GSTAT, Tmc2209
from test_scan import connected

MOUNTING = (("plane", "depth"), ("mirror-offset", "22000"), ("mount-height", "40000"), ("home-angle", "-165000"))


def set_up(one, *settings):
    one.boot()
    one.terminal.command("stop", "DONE")
    for key, value in MOUNTING + settings:
        one.terminal.set(key, value)


def start(one):
    one.terminal.send("start\r\n")


def state(one, wanted, length=4):
    """Whether `LIVE` sentences come to a state."""
    return one.chip.run(length, until=lambda: any(f",{wanted}," in line for line in one.terminal.live))


# Homing.


def test_homing_finds_the_switch_from_both_sides(bench):
    for position in (900, -300):
        one = bench()
        one.shaft.position = position
        one.shaft.press()
        module = connected(one, 1)
        start(one)
        assert one.chip.run(8, until=lambda: module.triggers), one.terminal.live[-1:]
        module.close()
        at = one.shaft.position
        # The switch is at -165 degrees, the first row at -20.
        assert abs(at - 145 * 51_200 / 360) < 40, at


def test_control_a_switch_without_its_interrupt(bench):
    one = bench()
    one.chip.spoil[0x4001_3C00] = lambda value: value & ~1
    set_up(one)
    start(one)
    assert "home-not-found" in one.terminal.wait("SCAN,0,fault", length=12)


def test_a_stall_switches_the_driver_off(bench):
    one = bench()
    module = connected(one, 1)
    start(one)
    assert one.chip.run(2, until=lambda: len(one.shaft.steps) > 100)
    one.shaft.stall()
    one.chip.run(0.0001)
    assert not one.shaft.enabled()
    assert "motor-stall" in one.terminal.wait("SCAN", length=3)
    module.close()


# Motor driver.


def test_the_motor_driver_is_set_up_and_asked(bench):
    one = bench()
    driver = Tmc2209(one.chip)
    set_up(one, ("driver", "tmc2209"))
    # It homed at boot, without settings.
    one.shaft.steps.clear()
    start(one)
    assert one.chip.run(2, until=lambda: len(one.shaft.steps) > 50)
    written = [register for register, value in driver.requests if value is not None]
    assert len(written) == 7 and driver.registers[GSTAT] == 0
    assert driver.registers[0x00] == 0x1C0


def test_a_motor_driver_that_was_reset_or_is_silent_is_a_fault(bench):
    one = bench()
    Tmc2209(one.chip, silent=True)
    set_up(one, ("driver", "tmc2209"))
    start(one)
    assert "motor-driver" in one.terminal.wait("SCAN,0,fault", length=5)
    other = bench()
    driver = Tmc2209(other.chip)
    driver.registers[DRV_STATUS] |= 2
    set_up(other, ("driver", "tmc2209"))
    start(other)
    assert "motor-driver" in other.terminal.wait("SCAN", length=8)


# Encoder.


def test_the_encoder_is_read(bench):
    one = bench()
    As5600(one.chip, angle=lambda: one.shaft.position * 4096 // 51_200)
    module = connected(one, 1)
    one.terminal.set("encoder", "as5600")
    start(one)
    assert state(one, "scanning"), one.terminal.lines[-2:]
    module.close()


def test_an_encoder_that_does_not_answer_is_a_fault(bench):
    one = bench()
    As5600(one.chip, present=False)
    set_up(one, ("encoder", "as5600"))
    start(one)
    assert "encoder-silent" in one.terminal.wait("SCAN,0,fault", length=5)


# Radar chip.


def echo(frame):
    return [2048 + (37 * k + 11 * frame) % 400 for k in range(256)]


def with_radar(bench, frames):
    """A scanner with the radar chip that has made more than so many frames."""
    one = bench()
    radar = Bgt60(one.chip, echo)
    set_up(one, ("module", "bgt60"), ("motion", "standing"))
    start(one)
    assert one.chip.run(5, until=lambda: radar.frames_done > frames), one.terminal.lines[-2:]
    return one, radar


def test_chirps_come_over_spi(bench):
    _, radar = with_radar(bench, frames=40)
    assert not radar.errors_seen


def test_one_glitch_fails_one_chirp(bench):
    one, radar = with_radar(bench, frames=10)
    radar.glitch = True
    assert one.chip.run(1, until=lambda: radar.errors_seen)
    frames = radar.frames_done
    assert one.chip.run(2, until=lambda: radar.frames_done > frames + 20)
    assert len(radar.errors_seen) == 1
    assert not radar.errors, "the error is cleared"


def test_control_a_radar_chip_that_is_absent(bench):
    one = bench()
    set_up(one, ("module", "bgt60"))
    start(one)
    line = one.terminal.wait("SCAN,0,fault", length=15)
    assert any(reason in line for reason in ("module-error", "link-silent"))


@pytest.mark.parametrize("bit", [12])
def test_control_spi_without_its_clock(bench, bit):
    one = bench()
    Bgt60(one.chip, echo)
    one.chip.spoil[0x4002_3844] = lambda value: value & ~(1 << bit)
    one.chip.power_on()
    one.terminal.wait("BOOT", length=4, fail=False)
    assert any("SPI1" in text for text in one.chip.complaints)
    one.chip.complaints.clear()
