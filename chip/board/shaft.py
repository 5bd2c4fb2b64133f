"""The mirror's shaft with its step driver, home switch and stall output."""

from model.units import UNITS_PER_S, seconds

# Setup of DIR before STEP's edge, and shortest pulse (TMC2209 data sheet 13.1, at 12 MHz: 20 ns and 100 ns).
SETUP_S = 20e-9
PULSE_S = 100e-9


class Shaft:
    """Turns by STEP (PC6) and DIR (PC7) while EN (PC8) is low; presses HOME (PB0) at and below `switch`."""

    def __init__(self, chip, position=300, switch=0):
        self.chip = chip
        self.position, self.switch = position, switch
        self.steps = []  # (time in units, position) of each rising edge.
        self.widths = []  # Lengths of the pulses, units.
        self.dir_at = self.rise_at = 0
        chip.gpio.watch("PC6", self.on_step)
        chip.gpio.watch("PC7", self.on_dir)
        chip.gpio.drive("PB1", 0)
        self.press()

    def press(self):
        self.chip.gpio.drive("PB0", 1 if self.position <= self.switch else 0)

    def stall(self, on=True):
        self.chip.gpio.drive("PB1", int(on))

    def enabled(self):
        return self.chip.gpio.level("PC8") == 0

    def on_dir(self, level):
        self.dir_at = self.chip.now()

    def on_step(self, level):
        now = self.chip.now()
        if not level:
            self.widths.append(now - self.rise_at)
            if seconds(now - self.rise_at) < PULSE_S:
                self.chip.complain(f"STEP high for {seconds(now - self.rise_at) * 1e9:.0f} ns")
            return
        self.rise_at = now
        if seconds(now - self.dir_at) < SETUP_S:
            self.chip.complain("DIR changed right before STEP")
        if not self.enabled():
            self.chip.complain("STEP with the driver off")
            return
        self.position += 1 if self.chip.gpio.level("PC7") else -1
        self.steps.append((now, self.position))
        self.press()

    def rates(self, first=0, last=None):
        """Steps a second between consecutive edges."""
        times = [time for time, _ in self.steps[first:last]]
        return [UNITS_PER_S / (b - a) for a, b in zip(times, times[1:])]
