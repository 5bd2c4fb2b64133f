//! Acceleration-limited moves: the time from one step to the next.

use crate::math;

/// Top speed and acceleration of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ramp {
    /// Top speed, microsteps/s.
    pub speed: u32,
    /// Acceleration and deceleration, microsteps/s²; 0 starts and stops at top speed.
    pub acceleration: u32,
}

/// Ramp in a driver's own steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepRamp {
    /// Top speed, steps/s.
    pub top: f32,
    /// Acceleration and deceleration, steps/s²; 0 starts and stops at top speed.
    pub acceleration: f32,
}

// Number of intervals that this thread has computed, for the tests of when an interval is computed.
#[cfg(test)]
std::thread_local! {
    pub(super) static COMPUTED: core::cell::Cell<u32> = const { core::cell::Cell::new(0) };
}

impl Ramp {
    /// Returns the time from microstep `k` (from 0) to the next in a move of `total` microsteps, in ticks of
    /// `tick_hz`.
    pub fn interval(&self, k: u32, total: u32, tick_hz: u32) -> u32 {
        self.scaled(1.0).interval(k, total, tick_hz)
    }

    /// Returns the ramp in steps of another size, of which `scale` are one microstep.
    pub(super) fn scaled(&self, scale: f32) -> StepRamp {
        StepRamp {
            top: self.speed.max(1) as f32 * scale,
            acceleration: self.acceleration as f32 * scale,
        }
    }

    /// Returns an upper limit of the duration of a move of `total` microsteps, µs: 1.5 times the s/v + v/a of a
    /// trapezoidal speed profile, which is never below the 2√(s/a) of a triangular one.
    pub fn bound_us(&self, total: u32) -> u32 {
        let speed = self.speed.max(1) as f32;
        let ramps = match self.acceleration {
            0 => 0.0,
            acceleration => speed / acceleration as f32,
        };
        let seconds = 1.5 * (total as f32 / speed + ramps);
        (seconds * 1e6) as u32
    }

    /// Returns the duration of a move of `total` microsteps, µs: the sum of all intervals.
    pub fn duration_us(&self, total: u32) -> u32 {
        const TICK_HZ: u32 = 1_000_000;
        (0..total).fold(0, |sum: u32, k| {
            sum.saturating_add(self.interval(k, total, TICK_HZ))
        })
    }
}

impl StepRamp {
    /// Returns the time from step `k` to the next of a move of `total` steps, in ticks of `tick_hz`.
    ///
    /// With constant acceleration a from rest the speed after the way s is v = √(2as). Counted from both ends that
    /// is a triangle for a short move and a trapezoid for a long one, without state and without accumulated error.
    /// It takes one square root and one division a step.
    #[inline]
    pub fn interval(self, k: u32, total: u32, tick_hz: u32) -> u32 {
        let Self { top, acceleration } = self;
        #[cfg(test)]
        COMPUTED.with(|count| count.set(count.get() + 1));
        let to_go = total.saturating_sub(1).saturating_sub(k);
        let way = k.min(to_go) as f32 + 0.5;
        let ramped = if acceleration == 0.0 {
            top
        } else {
            math::sqrt(2.0 * acceleration * way)
        };
        let speed = if ramped < top { ramped } else { top };
        // A float that is too large saturates; one tick is the minimum wait of a timer.
        ((tick_hz as f32 / speed) as u32).max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RAMP: Ramp = Ramp {
        speed: 51_200,
        acceleration: 2_560_000,
    };

    #[test]
    fn short_move_is_a_triangle() {
        // 36 steps: 2 √(s / a) = 7.5 ms in theory.
        let us = RAMP.duration_us(36);
        assert!((6_500..8_200).contains(&us), "{us}");
        assert!(RAMP.interval(18, 36, 1_000_000) > 1_000_000 / 51_200);
    }

    #[test]
    fn long_move_cruises() {
        // 9955 steps: s / v + v / a = 194.4 ms + 20 ms.
        let us = RAMP.duration_us(9955);
        assert!((205_000..225_000).contains(&us), "{us}");
        assert_eq!(RAMP.interval(5_000, 9_955, 84_000_000), 84_000_000 / 51_200);
    }

    #[test]
    fn bound_holds() {
        for total in [1, 2, 36, 500, 1024, 5_000, 50_000] {
            assert!(RAMP.duration_us(total) <= RAMP.bound_us(total), "{total}");
        }
    }

    proptest! {
        #[test]
        fn never_faster_than_allowed(k in 0u32..20_000, total in 1u32..20_000) {
            let hz = 84_000_000;
            let now = RAMP.interval(k, total, hz);
            prop_assert!(now >= hz / RAMP.speed);
            // The gain in speed from one step to the next stays within the acceleration.
            let v = |k| f64::from(hz) / f64::from(RAMP.interval(k, total, hz));
            if k + 1 < total {
                let (a, b) = (v(k), v(k + 1));
                let allowed = 2.0 * f64::from(RAMP.acceleration);
                // Change of the squared speed by one tick of the timer.
                let grain = 4.0 * b.max(a).powi(3) / f64::from(hz);
                prop_assert!((b * b - a * a).abs() <= allowed * 1.001 + grain, "{} {}", a, b);
            }
        }
    }
}
