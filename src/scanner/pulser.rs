//! STEP/DIR/EN over embedded-hal pins.
//!
//! In: target positions and ramps. Out: pulses, and the position. The board calls [`Pulser::tick`] from a
//! timer's interrupt; this module does not depend on the timer. A pulse is one rising edge of STEP.
//!
//! Positions are in microsteps of 51,200 a turn, independent of the driver's resolution. A driver with coarser
//! steps is counted in its own steps: each target is rounded to the nearest of them, and each position is
//! computed from their number since the position was last set. So no error accumulates, and the position is
//! where the driver has the shaft.

use core::hint::black_box;

use embedded_hal::digital::OutputPin;

use super::ramp::{Ramp, StepRamp};
use super::settings::WireLevel;
use crate::schedule::{Ratio, scaled};

/// Generator of STEP pulses, DIR and EN for consecutive moves.
#[derive(Debug)]
pub struct Pulser<S, D, E> {
    step: S,
    dir: D,
    enable: E,
    /// Level of EN that switches the driver on.
    on: WireLevel,
    /// Ratio of the driver's own steps to microsteps of 51,200 a turn.
    ratio: Ratio,
    /// Position at which `steps` was last set to 0, microsteps.
    origin: i32,
    /// Number of the driver's own steps from `origin`, negative backward.
    steps: i32,
    forward: bool,
    done: u32,
    total: u32,
    /// Ramp of the current move.
    ramp: StepRamp,
    tick_hz: u32,
}

impl<S: OutputPin, D: OutputPin, E: OutputPin> Pulser<S, D, E> {
    /// Creates a pulser at position 0 with its driver off, which a low EN switches on; `tick_hz` is the timer's
    /// frequency.
    pub fn new(step: S, dir: D, enable: E, tick_hz: u32) -> Self {
        Self::with_enable(step, dir, enable, WireLevel::Low, tick_hz)
    }

    /// Creates a pulser at position 0 with its driver off, which the level `on` of EN switches on; `tick_hz` is
    /// the timer's frequency.
    pub fn with_enable(step: S, dir: D, enable: E, on: WireLevel, tick_hz: u32) -> Self {
        let mut pulser = Self {
            step,
            dir,
            enable,
            on,
            ratio: Ratio::ONE,
            origin: 0,
            steps: 0,
            forward: true,
            done: 0,
            total: 0,
            ramp: StepRamp {
                top: 1.0,
                acceleration: 0.0,
            },
            tick_hz,
        };
        pulser.set_enabled(false);
        pulser
    }

    /// Sets `ratio`, the driver's own steps over microsteps, and `on`, the level of EN that switches the driver
    /// on. The level takes effect with the next [`Pulser::set_enabled`].
    pub fn configure(&mut self, ratio: Ratio, on: WireLevel) {
        let origin = self.position();
        self.ratio = ratio;
        self.on = on;
        self.set_position(origin);
    }

    /// Switches the driver on or off; off also ends a move. The position of the shaft at switch-on is unknown
    /// and counts as 0.
    pub fn set_enabled(&mut self, on: bool) {
        if on {
            self.set_position(0);
        } else {
            self.stop();
        }
        // The chip's pins cannot fail.
        let _ = match (self.on, on) {
            (WireLevel::Low, true) | (WireLevel::High, false) => self.enable.set_low(),
            (WireLevel::Low, false) | (WireLevel::High, true) => self.enable.set_high(),
        };
    }

    /// Begins a move to `target`, microsteps; returns the timer ticks until the first pulse, or `None` if the
    /// shaft is already there.
    pub fn begin(&mut self, target: i32, ramp: Ramp) -> Option<u32> {
        let target = scaled(target.saturating_sub(self.origin), self.ratio);
        self.forward = target >= self.steps;
        self.total = target.abs_diff(self.steps);
        self.done = 0;
        self.ramp = ramp.scaled(self.ratio.numerator as f32 / self.ratio.denominator as f32);
        if self.total == 0 {
            return None;
        }
        // DIR is stable for the whole first interval before the first STEP edge.
        let _ = if self.forward {
            self.dir.set_high()
        } else {
            self.dir.set_low()
        };
        Some(self.interval())
    }

    fn interval(&self) -> u32 {
        self.ramp.interval(self.done, self.total, self.tick_hz)
    }

    /// Emits one pulse; returns the timer ticks until the next, or `None` if the move is done.
    ///
    /// The next interval is computed while STEP is high, after the last pulse, too.
    pub fn tick(&mut self) -> Option<u32> {
        self.tick_wide(|| ())
    }

    /// Emits one pulse as [`Pulser::tick`] does; STEP stays high until `hold` returns.
    #[inline]
    pub fn tick_wide(&mut self, hold: impl FnOnce()) -> Option<u32> {
        if !self.moving() {
            return None;
        }
        let _ = self.step.set_high();
        let direction = if self.forward { 1 } else { -1 };
        self.steps = self.steps.wrapping_add(direction);
        self.done += 1;
        // The compiler must neither move the computation behind the edge nor remove it.
        let interval = black_box(self.interval());
        hold();
        let _ = self.step.set_low();
        self.moving().then_some(interval)
    }

    /// Ends the move at the current position.
    pub fn stop(&mut self) {
        self.total = self.done;
    }

    /// Whether pulses are still to come.
    pub fn moving(&self) -> bool {
        self.done < self.total
    }

    /// Returns the current position of the shaft by the pulses, microsteps.
    pub fn position(&self) -> i32 {
        self.origin
            .saturating_add(scaled(self.steps, self.ratio.inverse()))
    }

    /// Ends the move, and counts the current position of the shaft as `position`, microsteps, from now on.
    pub fn set_position(&mut self, position: i32) {
        self.stop();
        (self.origin, self.steps) = (position, 0);
    }
}

#[cfg(test)]
mod tests;
