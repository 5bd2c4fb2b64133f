//! STEP/DIR/EN over embedded-hal pins.
//!
//! The board calls [`Pulser::tick`] from a timer's interrupt; nothing here knows the timer. EN is
//! active low and a pulse is one rising edge of STEP, as step drivers have it.

use core::hint::black_box;

use embedded_hal::digital::OutputPin;

use super::ramp::Ramp;

/// Emits the pulses of one move after another.
#[derive(Debug)]
pub struct Pulser<S, D, E> {
    step: S,
    dir: D,
    enable: E,
    position: i32,
    forward: bool,
    done: u32,
    total: u32,
    ramp: Ramp,
    tick_hz: u32,
}

impl<S: OutputPin, D: OutputPin, E: OutputPin> Pulser<S, D, E> {
    /// A pulser at position 0 with its driver off; `tick_hz` is the timer's frequency.
    pub fn new(step: S, dir: D, enable: E, tick_hz: u32) -> Self {
        let ramp = Ramp {
            speed: 1,
            acceleration: 0,
        };
        let mut pulser = Self {
            step,
            dir,
            enable,
            position: 0,
            forward: true,
            done: 0,
            total: 0,
            ramp,
            tick_hz,
        };
        pulser.set_enabled(false);
        pulser
    }

    /// Switches the driver; off also ends a move.
    pub fn set_enabled(&mut self, on: bool) {
        // Pins of the chip cannot fail.
        let _ = if on {
            self.enable.set_low()
        } else {
            self.stop();
            self.enable.set_high()
        };
    }

    /// Begins a move to `target`: ticks until the first pulse, or `None` when it is already there.
    pub fn begin(&mut self, target: i32, ramp: Ramp) -> Option<u32> {
        self.forward = target >= self.position;
        self.total = target.abs_diff(self.position);
        self.done = 0;
        self.ramp = ramp;
        if self.total == 0 {
            return None;
        }
        // DIR stands for the whole first interval before the first STEP edge.
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

    /// One pulse: ticks until the next, or `None` when the move is done.
    ///
    /// An interval is computed while STEP is high, behind the last pulse too: some 60 clocks, which
    /// make every pulse longer than the 100 ns that drivers ask for.
    pub fn tick(&mut self) -> Option<u32> {
        if !self.moving() {
            return None;
        }
        let _ = self.step.set_high();
        let direction = if self.forward { 1 } else { -1 };
        self.position = self.position.wrapping_add(direction);
        self.done += 1;
        // The compiler must neither put it off behind the edge nor leave it out.
        let interval = black_box(self.interval());
        let _ = self.step.set_low();
        self.moving().then_some(interval)
    }

    /// Ends the move where it is.
    pub fn stop(&mut self) {
        self.total = self.done;
    }

    /// Whether pulses are still to come.
    pub fn moving(&self) -> bool {
        self.done < self.total
    }

    /// Position, microsteps.
    pub fn position(&self) -> i32 {
        self.position
    }

    /// Declares the present place to be `position`.
    pub fn set_position(&mut self, position: i32) {
        self.stop();
        self.position = position;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::ramp::COMPUTED;
    use core::cell::Cell;
    use core::convert::Infallible;

    struct Pin<'a>(&'a Cell<(bool, u32)>);

    impl embedded_hal::digital::ErrorType for Pin<'_> {
        type Error = Infallible;
    }

    impl OutputPin for Pin<'_> {
        fn set_low(&mut self) -> Result<(), Infallible> {
            self.0.set((false, self.0.get().1));
            Ok(())
        }
        fn set_high(&mut self) -> Result<(), Infallible> {
            let (level, rises) = self.0.get();
            self.0.set((true, rises + u32::from(!level)));
            Ok(())
        }
    }

    /// STEP: intervals that were computed while it was high, one after the other.
    #[derive(Default)]
    struct Wide {
        up: u32,
        widths: std::vec::Vec<u32>,
    }

    impl embedded_hal::digital::ErrorType for &mut Wide {
        type Error = Infallible;
    }

    impl OutputPin for &mut Wide {
        fn set_low(&mut self) -> Result<(), Infallible> {
            self.widths.push(COMPUTED.get() - self.up);
            Ok(())
        }
        fn set_high(&mut self) -> Result<(), Infallible> {
            self.up = COMPUTED.get();
            Ok(())
        }
    }

    #[test]
    fn the_last_pulse_is_as_wide_as_the_others() {
        let (mut step, dir, enable) = (Wide::default(), Cell::default(), Cell::default());
        let ramp = Ramp {
            speed: 1000,
            acceleration: 10_000,
        };
        let mut pulser = Pulser::new(&mut step, Pin(&dir), Pin(&enable), 1_000_000);
        for target in [1, 40, 39] {
            pulser.begin(target, ramp);
            while pulser.tick().is_some() {}
        }
        assert_eq!(step.widths, [1; 41]);
    }

    #[test]
    fn pulses_count_and_driver_levels() {
        let (step, dir, enable) = (Cell::default(), Cell::default(), Cell::default());
        let ramp = Ramp {
            speed: 1000,
            acceleration: 10_000,
        };
        let mut pulser = Pulser::new(Pin(&step), Pin(&dir), Pin(&enable), 1_000_000);
        assert!(enable.get().0, "driver off after reset");
        pulser.set_enabled(true);
        assert!(!enable.get().0);
        let mut ticks = pulser.begin(100, ramp);
        while ticks.is_some() {
            ticks = pulser.tick();
        }
        assert_eq!((pulser.position(), step.get()), (100, (false, 100)));
        assert!(dir.get().0);
        assert!(pulser.begin(100, ramp).is_none());
        pulser.begin(60, ramp);
        assert!(!dir.get().0);
        for _ in 0..10 {
            pulser.tick();
        }
        pulser.set_enabled(false);
        assert_eq!(pulser.tick(), None);
        assert_eq!((pulser.position(), pulser.moving()), (90, false));
        assert!(enable.get().0);
    }
}
