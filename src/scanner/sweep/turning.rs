//! A sweep at constant speed: the position at which each row is triggered, and the rows that are under way.

use heapless::Deque;

use crate::scanner::pace::Cruise;
use crate::schedule::Schedule;
use crate::time::Micros;

/// A continuous sweep under way.
#[derive(Clone, Debug)]
pub(super) struct ContinuousSweep {
    pub cruise: Cruise,
    /// Next row to be triggered, in the order of the sweep.
    pub next: u16,
    /// Time of its trigger; `None` until its microstep is reached.
    pub due: Option<Micros>,
    /// Rows whose chirps are under way, in the order of their triggers, with the timeout of each.
    pub in_flight: Deque<(u16, Micros), 2>,
    /// Whether the next row is skipped to let the wire catch up.
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

    /// Returns the start position of the shaft, microsteps.
    pub fn start(&self, schedule: &Schedule, backward: bool) -> i32 {
        self.cruise.ends(schedule, backward).0
    }

    /// Returns the distance of a shaft at `position` behind the trigger position of `row`, microsteps; negative
    /// before it.
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
