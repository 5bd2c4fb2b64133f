"""A whole scan over the link: sentences as `replay` has them, every step and trigger at its place."""

import pytest
from board.link import LinkModule
from board.terminal import framed
from conftest import PROGRAM, ROOT, fields, replay
from model.units import UNITS_PER_S, seconds

RECORDING = ROOT / "recordings/stair_a"
USART1_BRR = 0x4001_1008
# Microsteps of a turn, and of a row of 0.25 degrees (docs/user/hardware.md).
TURN, ROWS = 51_200, 281


def connected(one, fastest, recording=RECORDING):
    """Boots with the recording's module and settings, stopped."""
    module = LinkModule(one.chip, PROGRAM, str(recording), fastest)
    one.boot()
    one.terminal.command("stop", "DONE")
    for key, value in module.settings:
        one.terminal.set(key, value)
    return module


def scan(one):
    """The sentences of the next scan."""
    one.terminal.send("start\r\n")
    lines = [one.terminal.wait("SCAN", length=12)]
    count = int(fields(lines[0])[5])
    lines += [one.terminal.wait("STEP", length=1) for _ in range(count)]
    return lines


@pytest.mark.parametrize("fastest", [1, 3])
def test_sentences_equal_replays_and_nothing_is_lost(bench, fastest):
    one = bench()
    module = connected(one, fastest)
    try:
        lines = scan(one)
    finally:
        module.close()
    expected = replay(RECORDING)
    assert lines == expected[:len(lines)] and len(lines) > 1
    assert module.rates[-1] == fastest * 1_000_000
    assert all(port.overruns == 0 for port in one.chip.usart.values())
    assert len(module.triggers) >= ROWS
    places_at_triggers(one, module)


def places_at_triggers(one, module):
    """The shaft stands at each trigger, at consecutive rows: 0.25 degrees apart with the remainder carried."""
    steps = one.shaft.steps
    places, k = [], 0
    for trigger in module.triggers[:ROWS]:
        while k < len(steps) and steps[k][0] < trigger:
            k += 1
        places.append(steps[k - 1][1])
        after = steps[k][0] - trigger if k < len(steps) else UNITS_PER_S
        before = trigger - steps[k - 1][0]
        # `settle` of 5 ms before, and the whole chirp of some 0.3 ms after.
        assert seconds(before) > 0.0049, f"row {len(places)} triggered {seconds(before) * 1e3:.2f} ms after a step"
        assert seconds(after) > 0.0003, f"row {len(places)} moves on {seconds(after) * 1e3:.2f} ms after its trigger"
    exact = [places[0] + round(row * TURN / 1440) for row in range(ROWS)]
    worst = max(abs(place - want) for place, want in zip(places, exact))
    assert worst <= 1, f"a row is {worst} microsteps off"


def test_control_a_wrong_rate_of_the_link(bench):
    one = bench()
    one.chip.spoil[USART1_BRR] = lambda value: value * 27 // 25
    module = connected(one, 1)
    one.terminal.send("start\r\n")
    line = one.terminal.wait("SCAN", length=4, fail=False)
    module.close()
    assert line is None or "fault" in line
    assert any("link sends at" in text for text in one.chip.complaints)
    one.chip.complaints.clear()


def test_control_bytes_that_find_interrupts_masked_are_lost(bench):
    """What the log once did: interrupts masked for 12 us while a chirp comes."""
    one = bench()
    module = connected(one, 3)
    chip = one.chip
    one.terminal.send("start\r\n")
    assert chip.run(3, until=lambda: len(module.triggers) >= 3)
    # Into the chirp's bytes, which begin 0.4 ms later.
    chip.run(600e-6)
    chip.core.stall_until(chip.time + round(12e-6 * UNITS_PER_S))
    chip.run(40e-6)
    module.close()
    assert any("USART1: overrun" in text for text in chip.complaints), dict(chip.complaints)
    chip.complaints.clear()


def test_motion_sentences_come_in_while_it_scans(bench):
    """Commands at the report port during a scan lose no byte of the link."""
    one = bench()
    module = connected(one, 3)
    one.terminal.send("start\r\n")
    assert one.chip.run(3, until=lambda: len(module.triggers) >= 3)
    for number in range(30):
        one.terminal.wire.send(framed(f"PSTC,MOTION,{number},0.0,").encode(), round(0.01 * number * UNITS_PER_S))
    one.chip.run(0.4)
    module.close()
    assert all(port.overruns == 0 for port in one.chip.usart.values())
