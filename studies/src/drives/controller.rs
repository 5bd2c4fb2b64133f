//! Controller of a chair: joystick speed and `GUARD` sentences in, one speed command per control
//! cycle out.

use std::collections::VecDeque;

use stairscan::report::GuardLine;
use stairscan::verdict::Status;

use super::chair::CYCLE_S;
use stairscan_replay::limit::{Brakes, FreeAhead, max_speed};

/// Distance of the chair's foremost point before the mirror, metres. At a mounting height of 0.40 m
/// the mirror sits below the front edge of the seat, and footplates and toes stand out about this
/// far before that edge. A smaller distance could not be served: the sector's last row meets the
/// ground 0.51 m before the mirror, so that an edge 10 cm before the footplates is still in the
/// beam when the chair stands before it.
pub const FRONT_M: f64 = 0.40;
/// Properties of the chair that the controller assumes: the first column of docs/user/controller.md, and
/// a maximum age that bridges the loss of two sweeps' sentences.
const BRAKES: Brakes = Brakes {
    latency_ms: 200,
    deceleration_mm_s2: 1000,
    max_age_ms: 400,
};
/// Age of the free distance that the speed limit assumes, ms. The odometer carries the distance on,
/// so that it is as old as the odometer's reading: one control cycle.
const AGE_MS: u32 = 20;
/// Minimum speed limit other than 0, mm/s. Smaller limits are replaced by 0, because a chair cannot
/// creep more slowly.
const MIN_LIMIT_MM_S: u32 = 100;

/// The content of a `GUARD` sentence (the guard's answer on one sweep) that the controller uses.
#[derive(Clone, Copy, Debug)]
pub struct GuardInput {
    /// Free distance from the mirror at the sweep's last row, mm; 0 if the sweep's status is not
    /// `ok`.
    free_mm: i64,
    /// Reading of the odometer at the sweep's last row, metres.
    odometer_m: f64,
    /// Time of the sweep's last row, seconds.
    time_s: f64,
}

impl GuardInput {
    /// Takes the content of a sentence on a sweep whose last row was fired at `time_s` with the
    /// odometer at `odometer_m`.
    pub fn new(line: &GuardLine, time_s: f64, odometer_m: f64) -> Self {
        let free = line.free.filter(|_| line.status == Status::Ok);
        Self {
            free_mm: free.map_or(0, |tenths| i64::from(tenths.0).div_euclid(10)),
            odometer_m,
            time_s,
        }
    }
}

/// State of the chair's controller between two control cycles.
#[derive(Clone, Debug, Default)]
pub struct Controller {
    /// Content of the newest `GUARD` sentence received; `None` before the first.
    pub input: Option<GuardInput>,
    /// Measured and commanded speeds, mm/s, of the control cycles within one [`AGE_MS`] plus
    /// latency; the oldest first, two a cycle.
    speeds: VecDeque<u32>,
}

impl Controller {
    /// Returns the free distance before the chair's foremost point, mm: that of the newest sentence
    /// less the travel since. 0 without a sentence, or if it is older than the maximum age.
    fn free_mm(&self, now_s: f64, odometer_m: f64) -> u32 {
        let young =
            |input: &&GuardInput| (now_s - input.time_s) * 1e3 <= f64::from(BRAKES.max_age_ms);
        let Some(input) = self.input.as_ref().filter(young) else {
            return 0;
        };
        let driven = libm::ceil((odometer_m - input.odometer_m) * 1e3) as i64;
        let free_mm = input.free_mm - driven - (FRONT_M * 1e3) as i64;
        u32::try_from(free_mm).unwrap_or(0)
    }

    /// Returns the speed limit, mm/s: 0, or at least [`MIN_LIMIT_MM_S`].
    fn limit(&self, now_s: f64, odometer_m: f64) -> u32 {
        let ground = FreeAhead {
            free_mm: self.free_mm(now_s, odometer_m),
            age_ms: AGE_MS,
            max_speed_mm_s: self.speeds.iter().copied().max().unwrap_or(0),
        };
        match max_speed(&ground, &BRAKES) {
            limit if limit < MIN_LIMIT_MM_S => 0,
            limit => limit,
        }
    }

    /// Returns the speed command of the control cycle at `now_s` (seconds), m/s: the joystick's
    /// speed, but at most the speed limit. `speed_m_s` is the measured speed.
    pub fn cycle(&mut self, now_s: f64, odometer_m: f64, speed_m_s: f64, joystick_m_s: f64) -> f64 {
        self.push_speed(libm::ceil(speed_m_s * 1e3) as u32);
        let limit = f64::from(self.limit(now_s, odometer_m)) / 1e3;
        let command = joystick_m_s.min(limit);
        self.push_speed(libm::ceil(command * 1e3) as u32);
        command
    }

    /// Adds a measured or a commanded speed to `speeds`, and removes those that are older than age
    /// and latency together.
    fn push_speed(&mut self, speed_mm_s: u32) {
        let cycles = f64::from(AGE_MS + BRAKES.latency_ms) / (1e3 * CYCLE_S);
        self.speeds.push_back(speed_mm_s);
        if self.speeds.len() > 2 * (cycles as usize + 1) {
            self.speeds.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drives::chair::Chair;
    use crate::drives::plan::Plan;

    /// Drives towards the end of ground that is `free_m` long, with one sentence every tenth of a
    /// second. Returns the travel and whether the chair was ever faster than the joystick asked.
    fn driven(plan: &Plan, free_m: f64) -> (f64, bool) {
        let (mut chair, mut controller) = (Chair::new(plan), Controller::default());
        let mut fast = false;
        for cycle in 0..1_000 {
            let now_s = f64::from(cycle) * CYCLE_S;
            let pose = chair.at(now_s);
            if cycle % 5 == 0 {
                controller.input = Some(GuardInput {
                    free_mm: libm::floor((free_m - pose.travel_m) * 1e3) as i64,
                    odometer_m: plan.odometer.reading_m(pose.travel_m),
                    time_s: now_s,
                });
            }
            let odometer_m = plan.odometer.reading_m(pose.travel_m);
            let joystick = plan.joystick(now_s);
            let command = controller.cycle(now_s, odometer_m, pose.speed_m_s, joystick);
            fast |= command > joystick;
            chair.command(command);
        }
        (chair.at(999.0 * CYCLE_S).travel_m, fast)
    }

    #[test]
    fn a_chair_stops_before_the_free_ground_ends_and_near_it() {
        for number in 0..40 {
            let plan = Plan::draw(7, number);
            let (way, fast) = driven(&plan, 2.0);
            assert!(!fast, "faster than the joystick");
            let left = 2.0 - FRONT_M - way;
            assert!((0.0..0.08).contains(&left), "{number}: {left} m left");
        }
    }

    #[test]
    fn without_a_word_or_with_an_old_one_a_chair_stands() {
        let mut controller = Controller::default();
        assert_eq!(controller.cycle(0.0, 0.0, 0.0, 0.5), 0.0);
        controller.input = Some(GuardInput {
            free_mm: 1500,
            odometer_m: 0.0,
            time_s: 0.0,
        });
        assert_eq!(controller.cycle(0.4, 0.0, 0.0, 0.5), 0.5);
        assert_eq!(controller.cycle(0.42, 0.0, 0.0, 0.5), 0.0);
        assert_eq!(controller.cycle(0.4, 1.1, 0.0, 0.5), 0.0);
    }
}
