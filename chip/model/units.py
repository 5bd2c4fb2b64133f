"""Time of the model: whole units, so that no rounding accumulates.

A unit is 1/336 MHz: two of them are a clock at 168 MHz, 21 a clock at 16 MHz, 10,500 a clock of the
32 kHz oscillator.
"""

UNITS_PER_S = 336_000_000


def seconds(units):
    return units / UNITS_PER_S


def units(seconds_):
    return round(seconds_ * UNITS_PER_S)


def us(microseconds):
    return round(microseconds * (UNITS_PER_S // 1_000_000))
