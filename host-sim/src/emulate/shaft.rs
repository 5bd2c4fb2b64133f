//! The simulated motor at the driver's output: its position follows from the pulses in the emulator's log of GPIO
//! writes.

use stairscan::schedule::microsteps;

/// Distance of a pin's reset bit from its set bit in the bit set/reset register (BSRR).
const RESET: u32 = 16;
const STEP: u32 = 6;
const DIR: u32 = 7;
const ENABLE: u32 = 8;

/// Beginning of the log text of a write to a register of port C.
const WRITE: &str = "GPIOC: unimplemented device write";
const BSRR: &str = "offset 0x018, value 0x";
/// Beginning of the log text of a write to SysTick's reload register.
const RELOAD: &str = "systick_write systick write addr 0x4 data 0x";
/// Beginning of the log text of a write to SysTick's control register, which starts or stops it.
const CONTROL: &str = "systick_write systick write addr 0x0 data 0x";
/// Beginning of the log text of a read of SysTick's count.
const COUNT: &str = "systick_read systick read addr 0x8 data 0x";

/// SysTick's interval from one expiry to the next, from the log: the image sets the timer while it counts.
#[derive(Clone, Copy, Debug, Default)]
struct StepTimer {
    /// Last value for SysTick's reload plus one, clocks. 0 before the first one in the log.
    set: u64,
    /// Clocks since the last expiry at the last reading of the count; `None` if it was not read since the timer was last
    /// started or set.
    elapsed: Option<u64>,
    /// Clocks from expiry to expiry.
    wait: u64,
}

impl StepTimer {
    /// Processes one line of the emulator's log; returns whether it is about SysTick.
    fn log_line(&mut self, line: &str) -> bool {
        let value = |start: &str| {
            let digits = line.strip_prefix(start)?.split(' ').next()?;
            u64::from_str_radix(digits, 16).ok()
        };
        if let Some(reload) = value(RELOAD) {
            // The counter includes 0: one clock more.
            self.set = reload + 1;
            self.wait = self.set + self.elapsed.take().unwrap_or(0);
        } else if let Some(count) = value(COUNT) {
            self.elapsed = Some(if count == 0 {
                0
            } else {
                self.set.saturating_sub(count)
            });
        } else if value(CONTROL).is_some() {
            self.elapsed = None;
        } else {
            return false;
        }
        true
    }
}

/// A motor shaft, with a home switch that is pressed where `place`, in microsteps, is 0 or less.
#[derive(Clone, Debug)]
pub struct Shaft {
    place: i64,
    forward: bool,
    high: bool,
    enabled: bool,
    pulses: u64,
    zero: Option<i64>,
    idle_pulses: u64,
    timer: StepTimer,
    /// For each pulse since homing: the position after it, microsteps from the horizontal, and the timer's interval
    /// before it, clocks of the core.
    steps: Vec<(i64, u64)>,
}

impl Shaft {
    /// Creates a shaft at `place` microsteps above the home switch, with the driver off.
    pub fn new(place: i64) -> Self {
        Self {
            place,
            forward: true,
            high: false,
            enabled: false,
            pulses: 0,
            zero: None,
            idle_pulses: 0,
            timer: StepTimer::default(),
            steps: Vec::new(),
        }
    }

    /// Turns the shaft, as if by hand, to `place` microsteps above the home switch; its position is then unknown.
    pub fn turn_by_hand(&mut self, place: i64) {
        self.place = place;
        self.zero = None;
    }

    /// Processes one line of the emulator's log.
    pub fn log_line(&mut self, line: &str) {
        if self.timer.log_line(line) {
            return;
        }
        let value = line
            .strip_prefix(WRITE)
            .and_then(|rest| rest.split_once(BSRR))
            .and_then(|(_, value)| value.get(..8))
            .and_then(|hex| u32::from_str_radix(hex, 16).ok());
        if let Some(value) = value {
            self.write(value);
        }
    }

    /// Processes a write to port C's bit set/reset register. Setting has priority over resetting, as on the chip.
    fn write(&mut self, value: u32) {
        let set = |pin: u32| value & (1 << pin) != 0;
        let written = |pin: u32| set(pin) || set(pin + RESET);
        if written(DIR) {
            self.forward = set(DIR);
        }
        if written(ENABLE) {
            self.enabled = !set(ENABLE);
        }
        if written(STEP) {
            if set(STEP) && !self.high {
                self.pulse();
            }
            self.high = set(STEP);
        }
    }

    fn pulse(&mut self) {
        if !self.enabled {
            self.idle_pulses += 1;
            return;
        }
        self.pulses += 1;
        self.place += if self.forward { 1 } else { -1 };
        if let (Some(position), true) = (self.position(), self.timer.wait > 0) {
            self.steps.push((position, self.timer.wait));
        }
    }

    /// Whether the home switch is pressed.
    pub fn pressed(&self) -> bool {
        self.place <= 0
    }

    /// Whether the motor driver is on.
    pub fn enabled(&self) -> bool {
        self.enabled
    }

    /// Returns the number of pulses that turned the shaft.
    pub fn pulses(&self) -> u64 {
        self.pulses
    }

    /// Returns the number of pulses while the driver was off: the firmware assumes a move that did not happen.
    pub fn idle_pulses(&self) -> u64 {
        self.idle_pulses
    }

    /// Sets the position at the end of homing: the shaft's angle is now `home_angle` (0.001°).
    pub fn is_home(&mut self, home_angle: i32) {
        self.zero = Some(self.place - i64::from(microsteps(home_angle)));
        self.steps.clear();
    }

    /// Returns every pulse since homing, in a session with timing: the position after it, microsteps from the
    /// horizontal, and the time from expiry to expiry of the image's timer before it, clocks of the core. From the second
    /// pulse of a move on it lacks [`RESTART`](stairscan::scanner::step_timer::RESTART), which the log does not show.
    pub fn steps(&self) -> &[(i64, u64)] {
        &self.steps
    }

    /// Returns the position in microsteps from the horizontal, counted from the pulses; `None` before homing.
    pub fn position(&self) -> Option<i64> {
        self.zero.map(|zero| self.place - zero)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(shaft: &mut Shaft, value: u32) {
        shaft.log_line(&format!("{WRITE} (size 4, {BSRR}{value:08x})"));
    }

    #[test]
    fn counts_edges_of_step_in_the_direction_of_dir() {
        let mut shaft = Shaft::new(2);
        log(&mut shaft, 1 << STEP);
        assert_eq!(shaft.idle_pulses(), 1, "the driver is off");
        log(&mut shaft, 1 << (STEP + RESET));
        log(&mut shaft, 1 << (ENABLE + RESET) | 1 << (DIR + RESET));
        for _ in 0..3 {
            log(&mut shaft, 1 << STEP);
            log(&mut shaft, 1 << STEP);
            log(&mut shaft, 1 << (STEP + RESET));
        }
        assert_eq!(
            (shaft.place, shaft.pressed(), shaft.pulses()),
            (-1, true, 3)
        );
        shaft.is_home(-165_000);
        log(&mut shaft, 1 << DIR);
        log(&mut shaft, 1 << STEP);
        assert_eq!(shaft.position(), Some(-23_466));
        assert!(shaft.steps().is_empty(), "nobody timed it");
        shaft.log_line("systick_write systick write addr 0x4 data 0x3e7 size 4");
        shaft.log_line("systick_write systick write addr 0x0 data 0x7 size 4");
        log(&mut shaft, 1 << (STEP + RESET));
        log(&mut shaft, 1 << STEP);
        assert_eq!(shaft.steps(), [(-23_465, 1_000)]);
        // The timer was set anew 40 clocks after its expiry.
        shaft.log_line("systick_read systick read addr 0x8 data 0x3c0 size 4");
        shaft.log_line("systick_write systick write addr 0x4 data 0x1f3 size 4");
        log(&mut shaft, 1 << (STEP + RESET));
        log(&mut shaft, 1 << STEP);
        assert_eq!(shaft.steps()[1], (-23_464, 540));
        log(&mut shaft, 1 << (DIR + RESET));
        log(&mut shaft, 1 << (STEP + RESET));
        log(&mut shaft, 1 << STEP);
        shaft
            .log_line("GPIOA: unimplemented device write (size 4, offset 0x018, value 0x00000040)");
        shaft.log_line("GPIOC: unimplemented device read  (size 4, offset 0x010)");
        assert_eq!(shaft.position(), Some(-23_465));
    }
}
