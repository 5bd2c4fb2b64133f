//! A sweep at constant speed: the position at which each row is triggered, and the rows that are under way.

use heapless::Deque;

use crate::scanner::pace::Cruise;
use crate::schedule::Schedule;
use crate::time::Micros;

/// State of a sweep at constant speed.
#[derive(Clone, Debug)]
pub(super) struct ContinuousSweep {
    pub cruise: Cruise,
    /// Index of the next row to be triggered, in the order of the sweep from 0.
    pub next: u16,
    /// Time of the next row's trigger; `None` until the shaft is at the microstep from which the delay of this
    /// trigger counts.
    pub due: Option<Micros>,
    /// Rows whose chirps are under way, as indices of the map in the order of their triggers, each with the
    /// timeout of its chirp.
    pub in_flight: Deque<(u16, Micros), 2>,
    /// Whether the next row is left out, and lost, to let the wire catch up.
    pub skip_next: bool,
}

impl ContinuousSweep {
    /// Creates a sweep that has not begun.
    pub fn new(cruise: Cruise) -> Self {
        Self {
            cruise,
            next: 0,
            due: None,
            in_flight: Deque::new(),
            skip_next: false,
        }
    }

    /// Returns the position from which the shaft starts, before its ramp, microsteps.
    pub fn start(&self, schedule: &Schedule, backward: bool) -> i32 {
        self.cruise.ends(schedule, backward).0
    }

    /// Returns how far a shaft at `position` is past the position at which the trigger of `row` is prepared,
    /// microsteps; negative before it.
    pub fn distance_past(
        &self,
        schedule: &Schedule,
        backward: bool,
        row: u16,
        position: i32,
    ) -> i32 {
        let direction = Cruise::direction(schedule, backward);
        let way = position.saturating_sub(schedule.position(row));
        direction
            .saturating_mul(way)
            .saturating_add(self.cruise.lead)
    }
}
