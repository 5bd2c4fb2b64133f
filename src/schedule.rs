//! Shaft position of each row, microsteps.
//!
//! 0.25° is 35 5/9 microsteps of a motor with 51,200 per turn. Each row's position is computed from its angle
//! alone and rounded once, so no error accumulates over scans, and both sweep directions use the same
//! microsteps. The map receives the actual angle of the shaft, at most 0.0035° from the scheduled one.

use crate::config::{Config, ConfigError, Plane, SweepConfig, check};

/// Microsteps per turn of the shaft: 200 full steps of 256.
pub const MICROSTEPS_PER_TURN: i32 = 51_200;

/// Microsteps of a quarter turn of the shaft.
const QUARTER_TURN: i32 = MICROSTEPS_PER_TURN / 4;

/// Maximum angle of the shaft to either side of the position at which the beam is horizontal, 0.001°.
pub const SHAFT_LIMIT: i32 = 170_000;

/// Ratio of microsteps to thousandths of a degree, in lowest terms. With these small factors dozens of turns
/// fit 32 bits, and the image needs no 64-bit division.
const SAME: Ratio = Ratio {
    numerator: 32,
    denominator: 225,
};
const _: () = assert!(MICROSTEPS_PER_TURN * SAME.denominator == 360_000 * SAME.numerator);

/// Ratio of two whole numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ratio {
    /// Numerator.
    pub numerator: i32,
    /// Denominator, positive.
    pub denominator: i32,
}

impl Ratio {
    /// The ratio 1.
    pub const ONE: Self = Self {
        numerator: 1,
        denominator: 1,
    };

    /// Returns the inverse ratio.
    pub const fn inverse(self) -> Self {
        Self {
            numerator: self.denominator,
            denominator: self.numerator,
        }
    }
}

/// Converts a shaft angle in 0.001° to the nearest microstep, halves away from zero.
pub const fn microsteps(shaft_angle: i32) -> i32 {
    scaled(shaft_angle, SAME)
}

/// Converts a microstep to the shaft angle in 0.001°, rounded: the angle in a trigger frame.
pub const fn shaft_angle(position: i32) -> i32 {
    scaled(position, SAME.inverse())
}

/// Returns x · `ratio`, rounded to the nearest whole number, halves away from zero. The products saturate.
#[inline(always)]
pub(crate) const fn scaled(x: i32, ratio: Ratio) -> i32 {
    let b = ratio.denominator;
    let doubled = x.saturating_mul(2 * ratio.numerator);
    let rounded = doubled.saturating_add(if doubled < 0 { -b } else { b });
    // No ratio has a b of 0; for a ratio that is not a constant `checked_div` avoids the panic.
    match rounded.checked_div(2 * b) {
        Some(quotient) => quotient,
        None => 0,
    }
}

/// Shaft positions of the rows of one scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    sweep: SweepConfig,
    plane: Plane,
}

impl Schedule {
    /// Schedule without rows.
    pub const EMPTY: Self = Self {
        sweep: SweepConfig {
            first_angle: 0,
            angle_step: 0,
            angle_count: 0,
        },
        plane: Plane::Depth,
    };

    /// Creates the schedule of a configuration, if the shaft can reach all angles; with `plane both` that of
    /// its first plane.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        Self::in_plane(config.sweep, config.mount.plane.first())
    }

    /// Creates the schedule of a sweep in `plane`.
    ///
    /// # Errors Returns `first-angle` if the shaft cannot reach all angles, or the setting that is beyond its limits.
    pub fn in_plane(sweep: SweepConfig, plane: Plane) -> Result<Self, ConfigError> {
        sweep.validate()?;
        let schedule = Self { sweep, plane };
        let last = sweep.angle_count.saturating_sub(1);
        let within = |row| (-SHAFT_LIMIT..=SHAFT_LIMIT).contains(&schedule.scheduled_shaft(row));
        check(
            within(0) && within(last),
            "first-angle",
            "a sweep within the 340 degrees of the shaft",
        )?;
        Ok(schedule)
    }

    /// Returns the number of rows.
    pub const fn rows(&self) -> u16 {
        self.sweep.angle_count
    }

    /// Returns the scheduled shaft angle of `row`, 0.001° downwards from the horizontal. A 45° mirror turns the beam by
    /// the shaft's angle, not by twice the angle. In the depth plane this is the beam's angle; in the height plane,
    /// where the beam's angle counts from straight down, 90° minus it.
    pub fn scheduled_shaft(&self, row: u16) -> i32 {
        let beam = self.sweep.angle(row);
        match self.plane {
            Plane::Depth => beam,
            Plane::Height => 90_000_i32.saturating_sub(beam),
        }
    }

    /// Returns the scheduled shaft position of `row`, microsteps from the horizontal.
    pub fn position(&self, row: u16) -> i32 {
        microsteps(self.scheduled_shaft(row))
    }

    /// Returns the beam angle at the microstep of `row`, radians: from the horizontal in the depth plane, from straight
    /// down in the height plane.
    pub fn row_angle_rad(&self, row: u16) -> f32 {
        self.beam_angle_rad(self.position(row))
    }

    /// Returns the beam angle at shaft position `position` (microsteps), radians: from the horizontal in the depth
    /// plane, from straight down in the height plane.
    pub fn beam_angle_rad(&self, position: i32) -> f32 {
        const RAD_PER_STEP: f32 = core::f32::consts::TAU / MICROSTEPS_PER_TURN as f32;
        let beam = match self.plane {
            Plane::Depth => position,
            Plane::Height => QUARTER_TURN.saturating_sub(position),
        };
        beam as f32 * RAD_PER_STEP
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn paper_schedule_stands_on_the_nearest_microstep() {
        let schedule = Schedule::new(&Config::default()).unwrap();
        let mut sum = 0;
        for row in 0..schedule.rows() {
            let exact = f64::from(schedule.scheduled_shaft(row)) * 51_200.0 / 360_000.0;
            let position = schedule.position(row);
            assert!((exact - f64::from(position)).abs() <= 0.5);
            let angle = f64::from(schedule.beam_angle_rad(position)).to_degrees();
            let wanted = -20.0 + 0.25 * f64::from(row);
            assert!((angle - wanted).abs() < 0.00352, "row {row}: {angle}");
            if row > 0 {
                sum += position - schedule.position(row - 1);
            }
        }
        // 70° are 9955.5 microsteps: the moves add up to this, not to 280 times 36.
        assert_eq!(sum, schedule.position(280) - schedule.position(0));
        assert_eq!(sum, 7111 + 2844);
    }

    #[test]
    fn rows_may_stand_closer_than_microsteps() {
        let mut config = Config::default();
        config.sweep.angle_step = 10;
        config.sweep.angle_count = 8192;
        let schedule = Schedule::new(&config).unwrap();
        for row in 0..schedule.rows() {
            let exact = f64::from(schedule.scheduled_shaft(row)) * 51_200.0 / 360_000.0;
            assert!((exact - f64::from(schedule.position(row))).abs() <= 0.5);
        }
        assert_eq!(schedule.scheduled_shaft(8191), 61_910);
    }

    #[test]
    fn height_plane_turns_the_other_way_from_straight_down() {
        let mut config = Config::default();
        config.mount.plane = crate::config::Planes::Height;
        let schedule = Schedule::new(&config).unwrap();
        assert_eq!(schedule.scheduled_shaft(80), 90_000);
        assert_eq!(schedule.position(80), 12_800);
        assert_eq!(schedule.beam_angle_rad(12_800), 0.0);
        assert!(schedule.beam_angle_rad(schedule.position(280)) > 0.87);
        config.sweep.first_angle = -81_000;
        assert_eq!(Schedule::new(&config).unwrap_err().field, "first-angle");
    }

    proptest! {
        #[test]
        fn positions_round_to_nearest(angle in -SHAFT_LIMIT..=SHAFT_LIMIT) {
            let exact = f64::from(angle) * 51_200.0 / 360_000.0;
            prop_assert!((exact - f64::from(microsteps(angle))).abs() <= 0.5);
            prop_assert_eq!(microsteps(-angle), -microsteps(angle));
            // The round trip is off by at most half a microstep and half a unit.
            let back = shaft_angle(microsteps(angle));
            prop_assert!((back - angle).abs() <= 4);
        }
    }
}
