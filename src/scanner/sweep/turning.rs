//! A sweep at constant speed: which row is due where, and which are under way.

use heapless::Deque;

use crate::scanner::pace::Cruise;
use crate::schedule::Schedule;
use crate::time::Micros;

/// A continuous sweep under way.
#[derive(Clone, Debug)]
pub(super) struct ContinuousSweep {
    pub cruise: Cruise,
    /// The next row to be triggered, in the order of the sweep.
    pub next: u16,
    /// When it is, once its microstep has come.
    pub due: Option<Micros>,
    /// Rows whose chirps are under way, in the order of their triggers, and until when.
    pub flying: Deque<(u16, Micros), 2>,
    /// The wire is behind: the next row's time is left to it.
    pub skips: bool,
}

impl ContinuousSweep {
    /// One that has not begun.
    pub fn new(cruise: Cruise) -> Self {
        Self {
            cruise,
            next: 0,
            due: None,
            flying: Deque::new(),
            skips: false,
        }
    }

    /// Where the shaft's way begins.
    pub fn start(&self, schedule: &Schedule, backward: bool) -> i32 {
        self.cruise.ends(schedule, backward).0
    }

    /// Microsteps by which a shaft at `position` is past the place where `row` is triggered; before it,
    /// negative.
    pub fn past(&self, schedule: &Schedule, backward: bool, row: u16, position: i32) -> i32 {
        let direction = Cruise::direction(schedule, backward);
        let way = position.saturating_sub(schedule.position(row));
        direction
            .saturating_mul(way)
            .saturating_add(self.cruise.lead)
    }
}
