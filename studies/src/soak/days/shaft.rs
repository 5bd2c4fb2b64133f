//! Shaft of the simulated mirror: positions are interpolated in time, without single steps.
//!
//! In: moves with their ramps. Out: position, end of the move, edge of the home switch, stall, and the times at which
//! rows become due, so that the loop can skip the time between them.

use stairscan::scanner::mirror::PulseState;
use stairscan::scanner::pace::Cruise;
use stairscan::scanner::ramp::Ramp;
use stairscan::schedule::Schedule;

/// Position of the home switch in the motor's count before the first homing, microsteps: -165° from the count's zero,
/// where default settings expect it.
const SWITCH: i32 = -23_467;
/// Time from a row's trigger to the loop's next look, µs: one pass of the loop.
const SLACK_US: u64 = 16;

/// A move with constant acceleration, constant speed, and constant deceleration.
#[derive(Clone, Copy, Debug)]
struct Travel {
    from: i32,
    to: i32,
    begun: u64,
    /// Speed between the ramps, microsteps/µs.
    speed: f64,
    /// Acceleration, microsteps/µs²; infinite without ramps.
    acceleration: f64,
    /// Durations of one ramp and of the whole move, µs.
    ramp_us: f64,
    total_us: f64,
    /// Whether the move ends at the home switch, which then reports an edge.
    edge: bool,
}

impl Travel {
    fn new(begun: u64, (from, to): (i32, i32), ramp: Ramp, edge: bool) -> Self {
        let way = f64::from(from.abs_diff(to));
        let top = f64::from(ramp.speed.max(1)) * 1e-6;
        let acceleration = match ramp.acceleration {
            0 => f64::INFINITY,
            a => f64::from(a) * 1e-12,
        };
        let speed = top.min((acceleration * way).sqrt());
        let ramp_us = speed / acceleration;
        let total_us = if way > 0.0 {
            way / speed + ramp_us
        } else {
            0.0
        };
        Self {
            from,
            to,
            begun,
            speed,
            acceleration,
            ramp_us,
            total_us,
            edge,
        }
    }

    fn direction(&self) -> i32 {
        (self.to - self.from).signum()
    }

    fn end(&self) -> u64 {
        self.begun + self.total_us.ceil() as u64
    }

    /// Returns the position at time `now`, microsteps: that of the last whole microstep.
    fn position(&self, now: u64) -> i32 {
        let t = now.saturating_sub(self.begun) as f64;
        if t >= self.total_us {
            return self.to;
        }
        let to_go = self.total_us - t;
        let way = f64::from(self.from.abs_diff(self.to));
        let done = if t < self.ramp_us {
            0.5 * self.acceleration * t * t
        } else if to_go < self.ramp_us {
            way - 0.5 * self.acceleration * to_go * to_go
        } else {
            self.speed * (t - 0.5 * self.ramp_us)
        };
        self.from + self.direction() * (done + 1e-6) as i32
    }

    /// Returns the time at which the shaft passes `place`, microsteps, which lies between the ramps; µs of the run.
    fn time_at(&self, place: i32) -> u64 {
        let way = f64::from(self.direction() * (place - self.from));
        self.begun + (way / self.speed + 0.5 * self.ramp_us).ceil() as u64
    }
}

/// Rows of one continuous sweep: the positions from which their triggers' delay counts, microsteps, in the sweep's
/// order.
#[derive(Clone, Debug)]
struct Rows {
    /// Position at which the sweep ends, microsteps.
    end: i32,
    places: Vec<i32>,
    /// Delay of a row's trigger after the shaft has passed the row's entry in `places`, µs.
    delay_us: u64,
}

/// Motor, shaft, home switch and stall output.
#[derive(Clone, Debug)]
pub struct ShaftModel {
    travel: Option<Travel>,
    position: i32,
    switch: i32,
    edge: bool,
    stalled: bool,
    /// Whether the current or next move will end in a stall.
    pub stalls: bool,
    turns: Vec<Rows>,
    /// Index in `turns` of the sweep under way, and index in its `places` of the next row; `None` in any other move.
    turn: Option<(usize, usize)>,
}

impl ShaftModel {
    /// Creates a shaft at rest, with position 0 and the driver off.
    pub fn new() -> Self {
        Self {
            travel: None,
            position: 0,
            switch: SWITCH,
            edge: false,
            stalled: false,
            stalls: false,
            turns: Vec::new(),
            turn: None,
        }
    }

    /// Replaces the sweeps whose row times [`ShaftModel::next_event`] returns: each `Cruise` in both directions.
    pub fn expect_turns(&mut self, cruises: &[(Cruise, Schedule)]) {
        self.turns.clear();
        for (cruise, schedule) in cruises {
            for backward in [false, true] {
                let direction = Cruise::direction(schedule, backward);
                let rows = 0..schedule.rows();
                let place = |row| schedule.position(row) - direction * cruise.lead;
                let mut places: Vec<i32> = rows.map(place).collect();
                if backward {
                    places.reverse();
                }
                self.turns.push(Rows {
                    end: cruise.ends(schedule, backward).1,
                    places,
                    delay_us: cruise.delay_us.into(),
                });
            }
        }
    }

    /// Begins a move to `target`, microsteps; with `until_home` it ends at the home switch if that lies on the way.
    pub fn begin(&mut self, now: u64, target: i32, ramp: Ramp, until_home: bool) {
        let from = self.position(now);
        let edge = until_home && from > self.switch && target <= self.switch;
        let to = if edge { self.switch } else { target };
        self.position = from;
        self.edge = false;
        let travel = Travel::new(now, (from, to), ramp, edge);
        let turn = self.turns.iter().position(|turn| turn.end == target);
        let passes = |turn: &usize| {
            let first = self.turns[*turn].places.first();
            first.is_some_and(|&first| travel.direction() * (first - from) > 0)
        };
        self.turn = turn.filter(passes).map(|turn| (turn, 0));
        self.travel = Some(travel);
    }

    fn position(&self, now: u64) -> i32 {
        self.travel.map_or(self.position, |t| t.position(now))
    }

    /// Returns position, edge of the home switch and stall at time `now`; a move that has ended by then is finished.
    pub fn state(&mut self, now: u64) -> PulseState {
        if let Some(travel) = self.travel {
            self.position = travel.position(now);
            if std::mem::take(&mut self.stalls) {
                self.stalled = true;
                self.travel = None;
            } else if now >= travel.end() {
                self.edge |= travel.edge;
                self.travel = None;
            }
        }
        PulseState {
            position: self.position,
            moving: self.travel.is_some(),
            home_edge: self.edge,
            stalled: self.stalled,
        }
    }

    /// Whether the home switch is pressed at time `now`.
    pub fn pressed(&self, now: u64) -> bool {
        self.position(now) <= self.switch
    }

    /// Counts the present position of the shaft as `position`, microsteps.
    pub fn set_position(&mut self, position: i32) {
        self.switch += position - self.position;
        self.position = position;
    }

    /// Switches the driver on or off; off ends a move.
    pub fn set_enabled(&mut self, now: u64, on: bool) {
        self.position = self.position(now);
        self.travel = None;
        self.stalled &= !on;
    }

    /// Returns the first time after `seen` at which the move ends or a row becomes due, µs of the run.
    pub fn next_event(&mut self, seen: u64) -> u64 {
        let Some(travel) = self.travel else {
            return u64::MAX;
        };
        let end = Some(travel.end())
            .filter(|&end| end > seen)
            .unwrap_or(u64::MAX);
        let Some((turn, next)) = &mut self.turn else {
            return end;
        };
        let rows = &self.turns[*turn];
        while let Some(&place) = rows.places.get(*next) {
            let at = travel.time_at(place);
            let due = at + rows.delay_us + SLACK_US;
            if at > seen {
                return at.min(end);
            } else if due > seen {
                return due.min(end);
            }
            *next += 1;
        }
        end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RAMP: Ramp = Ramp {
        speed: 51_200,
        acceleration: 2_560_000,
    };

    #[test]
    fn a_move_takes_as_long_as_its_steps() {
        for way in [36, 500, 1_024, 5_000] {
            let travel = Travel::new(7, (100, 100 - way), RAMP, false);
            let steps = f64::from(RAMP.duration_us(way as u32));
            let ratio = travel.total_us / steps;
            assert!((0.9..1.1).contains(&ratio), "{way}: {ratio}");
            assert_eq!(travel.position(7), 100);
            assert_eq!(travel.position(travel.end()), 100 - way);
        }
    }

    #[test]
    fn a_row_is_due_when_its_position_is_reached() {
        let travel = Travel::new(7, (0, 9_955), RAMP, false);
        for place in [1_000, 5_000, 9_000] {
            let at = travel.time_at(place);
            assert_eq!(travel.position(at), place);
            assert_eq!(travel.position(at - 2), place - 1);
        }
    }

    #[test]
    fn homing_ends_at_the_switch() {
        let mut shaft = ShaftModel::new();
        let slow = Ramp {
            speed: 25_600,
            acceleration: 0,
        };
        shaft.begin(0, -51_200, slow, true);
        assert!(shaft.state(900_000).moving && !shaft.pressed(900_000));
        let state = shaft.state(1_000_000);
        assert!(state.home_edge && !state.moving && shaft.pressed(1_000_000));
        assert_eq!(state.position, SWITCH);
    }
}
