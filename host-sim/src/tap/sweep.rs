//! Finds the schedule of angles behind the triggers.
//!
//! A trigger contains the shaft's angle on its microstep, which differs from the scheduled angle by up to 0.0035°.
//! A recording with those angles would be another scan: its schedule would begin elsewhere, and rows would fall on
//! other microsteps. Therefore the schedule is searched that falls on all of these microsteps. If there are
//! several, the one with the roundest numbers is taken; the rows are the same.

use stairscan::config::{Plane, SweepConfig};
use stairscan::schedule::{microsteps, shaft_angle};

/// Maximum difference between a scheduled angle and the angle on its microstep, 0.001°, rounded up.
const OFF: i32 = 4;
/// Divisors that make an angle round, 0.001°, the roundest first: of several schedules, that of
/// rounder angles is taken.
const ROUND: [i32; 8] = [10_000, 5_000, 1_000, 500, 250, 100, 10, 1];

/// A schedule of angles, with the row of each trigger.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// First angle, step and number of angles.
    pub config: SweepConfig,
    /// Row of each trigger in the schedule, in the order of the triggers.
    pub rows: Vec<usize>,
}

/// Returns the schedule behind `angles` of the shaft (0.001°, in the order of the triggers); `None` if no schedule
/// falls on all of them, for example for a motor with other steps.
pub fn schedule(angles: &[i32], plane: Plane) -> Option<Sweep> {
    let beams: Vec<i32> = angles.iter().map(|angle| beam(*angle, plane)).collect();
    let places = places(&beams)?;
    let rows = places.iter().copied().max()?;
    let low = *beams.iter().min()?;
    let span = beams.iter().max()? - low;
    let step = (f64::from(span) / rows as f64).round() as i32;
    let mut best: Option<(usize, SweepConfig)> = None;
    for angle_step in step - 1..=step + 1 {
        for first_angle in low - OFF..=low + OFF {
            let config = SweepConfig {
                first_angle,
                angle_step,
                angle_count: u16::try_from(rows + 1).ok()?,
            };
            let falls = |(place, angle): (&usize, &i32)| on_shaft(&config, *place, plane) == *angle;
            let rank = round(first_angle) + round(angle_step);
            if best.is_none_or(|(least, _)| rank < least) && places.iter().zip(angles).all(falls) {
                best = Some((rank, config));
            }
        }
    }
    best.map(|(_, config)| Sweep {
        config,
        rows: places,
    })
}

/// Returns `config` with the row of each of `angles` (of the shaft, 0.001°); `None` unless each is
/// the microstep of one of its rows.
pub fn follows(config: &SweepConfig, angles: &[i32], plane: Plane) -> Option<Sweep> {
    let row = |angle: &i32| {
        let along = beam(*angle, plane) - config.first_angle + config.angle_step / 2;
        let row = usize::try_from(along.div_euclid(config.angle_step.max(1))).ok()?;
        let within = row < usize::from(config.angle_count);
        (within && on_shaft(config, row, plane) == *angle).then_some(row)
    };
    let rows: Option<Vec<usize>> = angles.iter().map(row).collect();
    Some(Sweep {
        config: *config,
        rows: rows?,
    })
}

impl Sweep {
    /// Whether the triggers are neighbouring rows of the schedule, except where some were not received.
    pub fn is_dense(&self) -> bool {
        let mut apart: Vec<usize> = (self.rows.windows(2))
            .map(|two| two[0].abs_diff(two[1]))
            .collect();
        apart.sort_unstable();
        apart.get(apart.len() / 2) == Some(&1)
    }

    /// Whether the triggers go over the whole schedule, from one end to the other.
    pub fn is_whole(&self) -> bool {
        let (first, last) = (self.rows.iter().min(), self.rows.iter().max());
        let end = usize::from(self.config.angle_count).checked_sub(1);
        self.is_dense() && first == Some(&0) && last.copied() == end
    }
}

/// Whether two schedules have the same angle step, within the accuracy to which microsteps show it.
pub fn is_same_step(a: &SweepConfig, b: &SweepConfig) -> bool {
    a.angle_step.abs_diff(b.angle_step) <= OFF.unsigned_abs()
}

/// Converts an angle of the shaft to that of the beam from the plane's zero (horizontal, or
/// straight down), or back; both 0.001°.
pub fn beam(angle: i32, plane: Plane) -> i32 {
    match plane {
        Plane::Depth => angle,
        Plane::Height => 90_000_i32.saturating_sub(angle),
    }
}

/// Returns the shaft angle of row `row` on its microstep, 0.001°.
fn on_shaft(config: &SweepConfig, row: usize, plane: Plane) -> i32 {
    let angle = config.first_angle + config.angle_step * row as i32;
    shaft_angle(microsteps(beam(angle, plane)))
}

/// Returns the row of each beam angle, 0 for the lowest angle, on the assumption that the median difference between
/// neighbours is one row; `None` if the angles are not monotonic.
fn places(beams: &[i32]) -> Option<Vec<usize>> {
    let differences: Vec<i32> = beams.windows(2).map(|two| two[1] - two[0]).collect();
    let rising = *differences.first()? > 0;
    if differences.iter().any(|d| *d == 0 || (*d > 0) != rising) {
        return None;
    }
    let mut sorted: Vec<i32> = differences.iter().map(|d| d.abs()).collect();
    sorted.sort_unstable();
    let usual = f64::from(sorted[sorted.len() / 2]);
    let mut place = 0;
    let mut places = vec![0];
    for difference in &differences {
        place += (f64::from(difference.abs()) / usual).round().max(1.0) as usize;
        places.push(place);
    }
    if !rising {
        places.iter_mut().for_each(|row| *row = place - *row);
    }
    Some(places)
}

/// Returns the roundness of an angle (0.001°): the index of its first divisor in [`ROUND`], 0 for
/// the roundest.
fn round(angle: i32) -> usize {
    let place = ROUND.iter().position(|divisor| angle % divisor == 0);
    place.unwrap_or(ROUND.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn angles(config: &SweepConfig, plane: Plane) -> Vec<i32> {
        let rows = 0..usize::from(config.angle_count);
        rows.map(|row| on_shaft(config, row, plane)).collect()
    }

    #[test]
    fn the_papers_sweep_comes_back_from_its_microsteps() {
        let config = SweepConfig {
            first_angle: -20_000,
            angle_step: 250,
            angle_count: 281,
        };
        for plane in [Plane::Depth, Plane::Height] {
            let mut angles = angles(&config, plane);
            let found = schedule(&angles, plane).unwrap();
            assert_eq!(found.config, config);
            assert_eq!(found.rows, (0..281).collect::<Vec<_>>());
            // In the other direction, and with missing rows.
            angles.reverse();
            angles.drain(100..103);
            let found = schedule(&angles, plane).unwrap();
            assert_eq!(
                (found.config, found.rows[0], found.rows[100]),
                (config, 280, 177)
            );
            assert_eq!(follows(&config, &angles, plane), Some(found));
        }
    }

    #[test]
    fn what_is_no_schedule_is_none() {
        assert_eq!(schedule(&[], Plane::Depth), None);
        assert_eq!(schedule(&[5], Plane::Depth), None);
        assert_eq!(schedule(&[0, 1000, 1000], Plane::Depth), None);
        assert_eq!(schedule(&[0, 1000, 500], Plane::Depth), None);
        assert_eq!(schedule(&[1, 1003, 2009, 3001], Plane::Depth), None);
    }

    proptest! {
        #[test]
        fn a_schedule_that_is_found_falls_on_every_microstep(
            first_angle in -60_000..0_i32, angle_step in 100..2_000_i32, angle_count in 10..60_u16
        ) {
            let config = SweepConfig { first_angle, angle_step, angle_count };
            let all = angles(&config, Plane::Depth);
            let found = schedule(&all, Plane::Depth).unwrap();
            prop_assert_eq!(angles(&found.config, Plane::Depth), all);
        }
    }
}
