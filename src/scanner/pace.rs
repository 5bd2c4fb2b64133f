//! Speed of a mirror that does not stop at the rows.
//!
//! In: settings, schedule and the times of the radar module. Out: a [`Cruise`], or `None` if there is no valid
//! one.

use super::settings::{MotorConfig, Settings};
use crate::schedule::{MICROSTEPS_PER_TURN, SHAFT_LIMIT, Schedule, microsteps};
use crate::signal::radar::wire::{RowTimes, SLACK_US};

/// Computation for a row. A module that takes one request at a time is triggered again only after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowWork {
    /// A scan's row: map, health checks and coherent image.
    Scan,
    /// A guard sweep's row: map and health checks.
    Guard,
}

impl RowWork {
    /// Returns the time for it, µs: the budget of 75,000 or 25,000 instructions at 168 MHz, and a third more.
    const fn us(self) -> u32 {
        match self {
            Self::Scan => 600,
            Self::Guard => 200,
        }
    }
}

/// Reciprocal of the share, 5 %, by which the time of a row exceeds that which the wire needs: the baud rates of
/// both ends may be 2 % off. The motor's steps come later than their timer by the interrupt's own time, which
/// adds margin.
const MARGIN: u32 = 20;
/// Reciprocal of a share of a row's time, 2 %: by that a chirp's timeout ends before its buffer is needed for
/// another row.
const TIMEOUT_MARGIN: u32 = 50;
/// Time at constant speed before the first row, µs: oscillations from the ramp decay as they do after a move.
const SETTLE_US: u32 = 5_000;

/// Speeds and times of a sweep at constant speed: ramps outside the sector, every row in passing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cruise {
    /// Speed of the shaft inside the sector, between the ramps, microsteps/s.
    pub speed: u32,
    /// Time from row to row, µs.
    pub period_us: u32,
    /// Timeout of a row's samples, µs: when it ends, the trigger of a later row needs their buffer.
    pub chirp_timeout_us: u32,
    /// Distance from an end of the shaft's travel to the nearest row, microsteps: ramp, settling, and the
    /// duration of a row's chirps.
    pub run_up: i32,
    /// Distance of the shaft before a row's position at which the delay of the row's trigger begins, microsteps.
    pub lead: i32,
    /// Delay of a row's trigger after the shaft is `lead` before the row's position, µs, so that this position is
    /// reached in mid chirp, or in the middle of the row's chirps.
    pub delay_us: u32,
}

/// Minimum speed of a sweep, microsteps/s: also the minimum of the setting `speed`.
const MIN_SPEED: u32 = 100;
/// Acceleration that stands for the setting 0, microsteps/s²: such a motor starts and stops without a ramp.
const DEAD_STOP: f32 = 1e9;

impl Cruise {
    /// Returns the sweep at constant speed by `settings`, with a module whose rows take `times` and `work`; `None` if
    /// the shaft has no room for the ramps, or the speed would be below `MIN_SPEED`.
    pub fn new(
        settings: &Settings,
        schedule: &Schedule,
        times: RowTimes,
        work: RowWork,
    ) -> Option<Self> {
        let motor = &settings.motor;
        let chirp_us = times.chirp_us.unwrap_or(settings.capture_us());
        let (trigger, answer) = (times.trigger_us, times.answer_us);
        let capture = trigger.saturating_add(chirp_us).saturating_add(SLACK_US);
        let busy = match times.ahead {
            true => answer.max(capture),
            false => capture.saturating_add(answer).saturating_add(work.us()),
        };
        let period_us = busy.saturating_add(busy / MARGIN);
        // Rows may be closer together than microsteps: their distance need not be a whole number.
        let way = settings.config.sweep.angle_step.unsigned_abs() as f32
            * (MICROSTEPS_PER_TURN as f32 / 360_000.0);
        let speed = ((way * 1e6 / period_us as f32) as u32).min(motor.speed);
        if speed < MIN_SPEED {
            return None;
        }
        let v = speed as f32 * 1e-6;
        let period_us = (way / v) as u32;
        let places = if times.ahead { 2 } else { 1 };
        let patience_us = period_us.saturating_mul(places) - period_us / TIMEOUT_MARGIN;
        let acceleration = match motor.acceleration {
            0 => DEAD_STOP,
            a => a as f32,
        };
        let ramp = speed as f32 * speed as f32 / (2.0 * acceleration);
        // Time from the trigger's call to the middle of the row's chirps.
        let early_us = trigger as f32 + 0.5 * chirp_us as f32;
        let lead = (v * early_us) as i32 + 1;
        let delay_us = (lead as f32 / v - early_us) as u32;
        let run = (ramp + v * (SETTLE_US as f32 + chirp_us as f32)) as i32;
        let run_up = run.saturating_add(lead).saturating_add(2);
        let cruise = Self {
            speed,
            period_us,
            chirp_timeout_us: patience_us.min(settings.row_timeout_us()),
            run_up,
            lead,
            delay_us,
        };
        let limit = microsteps(SHAFT_LIMIT);
        let last = schedule.rows().saturating_sub(1);
        let within = [false, true].into_iter().all(|backward| {
            let (start, end) = cruise.ends(schedule, backward);
            start.abs() <= limit && end.abs() <= limit
        });
        (within && last > 0).then_some(cruise)
    }

    /// Returns the duration of one of many consecutive sweeps in alternating directions, µs: the way from end
    /// to end and the ramps on it.
    pub fn sweep_us(&self, motor: &MotorConfig, schedule: &Schedule) -> u32 {
        let (start, end) = self.ends(schedule, false);
        let ramps = match motor.acceleration {
            0 => 0.0,
            a => self.speed as f32 / a as f32,
        };
        let seconds = start.abs_diff(end) as f32 / self.speed.max(1) as f32 + ramps;
        // `as` saturates.
        (seconds * 1e6) as u32
    }

    /// Returns the direction of the shaft from the sweep's first row to its last: 1 if the position grows, else
    /// -1.
    pub fn direction(schedule: &Schedule, backward: bool) -> i32 {
        let last = schedule.rows().saturating_sub(1);
        let down = schedule.scheduled_shaft(last) >= schedule.scheduled_shaft(0);
        if down != backward { 1 } else { -1 }
    }

    /// Returns start and end of the shaft's travel in a sweep, microsteps, ramps included. The end in one
    /// direction is the start in the other.
    pub fn ends(&self, schedule: &Schedule, backward: bool) -> (i32, i32) {
        let last = schedule.rows().saturating_sub(1);
        let (first, last) = match backward {
            false => (0, last),
            true => (last, 0),
        };
        let run = Self::direction(schedule, backward).saturating_mul(self.run_up);
        (
            schedule.position(first).saturating_sub(run),
            schedule.position(last).saturating_add(run),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::radar::wire::Wire;
    use proptest::prelude::*;

    fn cruise(settings: &Settings, wire: Wire) -> Option<Cruise> {
        let schedule = Schedule::new(&settings.config).unwrap();
        let times = wire.row_times(settings.config.radar.samples);
        Cruise::new(settings, &schedule, times, RowWork::Scan)
    }

    #[test]
    fn the_wire_keeps_up() {
        let settings = Settings::default();
        for (baud, ahead, slowest) in [
            (1_000_000, true, 8_600),
            (2_000_000, true, 4_300),
            (3_000_000, true, 2_900),
            (1_000_000, false, 10_700),
        ] {
            let wire = Wire {
                baud,
                ahead,
                pin: false,
            };
            let cruise = cruise(&settings, wire).unwrap();
            let answer = wire.chirp_us(200);
            assert_eq!(answer, (8_120_000_u32).div_ceil(baud / 1000));
            assert!(cruise.period_us > answer + answer / 25, "{cruise:?}");
            assert!(cruise.period_us < slowest, "{cruise:?}");
            let there = wire.trigger_us() + 1_000 + SLACK_US + answer;
            assert!(cruise.chirp_timeout_us > there, "{cruise:?}");
            // The row's place comes in mid chirp, within half a microstep.
            let early = wire.trigger_us() + 500 + cruise.delay_us;
            let way = early as f32 * cruise.speed as f32 * 1e-6;
            assert!((way - cruise.lead as f32).abs() < 0.1, "{way} {cruise:?}");
        }
    }

    #[test]
    fn the_pace_follows_the_chirps_of_a_row() {
        let mut settings = Settings::default();
        let wire = Wire {
            baud: 3_000_000,
            ahead: true,
            pin: false,
        };
        let one = cruise(&settings, wire).unwrap();
        settings.module.chirps = 2;
        // The answer of 2.7 ms takes longer than two chirps.
        assert_eq!(cruise(&settings, wire).unwrap().period_us, one.period_us);
        for chirps in [4, 16, 32] {
            settings.module.chirps = chirps;
            let cruise = cruise(&settings, wire).unwrap();
            let capture = 1_000 * u32::from(chirps);
            assert!(cruise.period_us > capture + SLACK_US, "{cruise:?}");
            assert!(cruise.period_us < capture + capture / 5, "{cruise:?}");
            assert!(cruise.chirp_timeout_us > capture + wire.chirp_us(200));
            // The position comes in the middle of the chirps.
            let early = wire.trigger_us() + capture / 2 + cruise.delay_us;
            let way = early as f32 * cruise.speed as f32 * 1e-6;
            assert!((way - cruise.lead as f32).abs() < 0.1, "{way} {cruise:?}");
        }
    }

    #[test]
    fn a_sector_without_room_for_ramps_is_not_swept() {
        let mut settings = Settings::default();
        settings.config.sweep.first_angle = -169_990;
        assert_eq!(cruise(&settings, Wire::default()), None);
        settings.config.sweep.first_angle = -160_000;
        assert!(cruise(&settings, Wire::default()).is_some());
        settings.motor.acceleration = 1_000;
        assert!(cruise(&settings, Wire::default()).is_none());
    }

    #[test]
    fn both_ways_have_the_same_ends() {
        let mut settings = Settings::default();
        for plane in [crate::config::Planes::Depth, crate::config::Planes::Height] {
            settings.config.mount.plane = plane;
            let schedule = Schedule::new(&settings.config).unwrap();
            let times = Wire::default().row_times(settings.config.radar.samples);
            let cruise = Cruise::new(&settings, &schedule, times, RowWork::Scan).unwrap();
            let (there, back) = (cruise.ends(&schedule, false), cruise.ends(&schedule, true));
            assert_eq!(there, (back.1, back.0));
            let sign = Cruise::direction(&schedule, false);
            assert_eq!((there.1 - there.0).signum(), sign);
        }
    }

    proptest! {
        #[test]
        fn never_faster_than_the_motor_nor_the_wire(
            speed in 100_u32..=102_400, acceleration in 1_000_u32..=100_000_000,
            chirp in 0_u32..=1_000_000, baud in 9_600_u32..=12_000_000, ahead: bool,
            step in 10_i32..=1_000,
        ) {
            let mut settings = Settings::default();
            settings.motor.speed = speed;
            settings.motor.acceleration = acceleration;
            settings.timing.chirp_duration = chirp;
            settings.config.sweep.angle_step = step;
            settings.config.sweep.angle_count = 100;
            let wire = Wire { baud, ahead, pin: false };
            let Some(cruise) = cruise(&settings, wire) else { return Ok(()) };
            prop_assert!(cruise.speed <= speed && cruise.speed >= MIN_SPEED);
            prop_assert!(cruise.period_us >= wire.chirp_us(200), "{:?}", cruise);
            prop_assert!(cruise.period_us >= chirp);
        }
    }
}
