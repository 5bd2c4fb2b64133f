//! Simulated radar module: its answers take as long as on a real link, or do not come.
//!
//! Timeouts are those of the scanner's 32-bit clock, as a real link's are.

use std::collections::VecDeque;
use std::task::Poll;

use stairscan::config::RadarConfig;
use stairscan::scanner::Micros;
use stairscan::signal::radar::LinkError;
use stairscan::signal::radar::wire::{RowTimes, SLACK_US, Wire};

/// Baud rate of the link: the fastest, at which the guard reaches its sweep rate with default settings.
const BAUD: u32 = 3_000_000;
/// Time from a query of the settings to the answer, µs: some hundred bytes, and the module's own time.
const SETTINGS_US: u64 = 3_000;
/// Duration of a chirp, µs: default of `chirp-duration`.
const CHIRP_US: u64 = 1_000;

/// A request whose answer is pending.
#[derive(Clone, Copy, Debug)]
struct Request {
    /// Time at which the answer arrives, µs of the run; `None` if it is lost.
    answer: Option<u64>,
    /// Time at which the scanner's loop must look at this request, µs of the run: that of its answer, or of its
    /// timeout.
    look: u64,
    deadline: Micros,
}

/// The radar module at the other end of the link, and its pending answers.
#[derive(Clone, Debug, Default)]
pub struct ModuleModel {
    settings: Option<Request>,
    chirps: VecDeque<Request>,
    /// Whether the module answers no request.
    pub silent: bool,
    /// Number of the next chirps that will be lost.
    pub losing: u32,
    /// Number of chirps that the module has delivered.
    pub answered: u64,
}

impl ModuleModel {
    /// Returns the times that a row of `samples` samples takes on the link: of its trigger and of its answer.
    pub fn row_times(samples: u16) -> RowTimes {
        let wire = Wire {
            baud: BAUD,
            ahead: true,
            pin: false,
        };
        wire.row_times(samples)
    }

    /// Takes a query of the module's settings; `deadline` is its timeout by the scanner's clock and in µs of the run.
    pub fn program(&mut self, now: u64, deadline: (Micros, u64)) {
        self.chirps.clear();
        let answer = (!self.silent).then_some(now + SETTINGS_US);
        self.settings = Some(Request {
            answer,
            look: answer.unwrap_or(deadline.1),
            deadline: deadline.0,
        });
    }

    /// Returns the module's settings once they have arrived, or an error at the timeout.
    pub fn settings(&mut self, now: u64, clock: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        let result = match answer(self.settings, now, clock) {
            Poll::Pending => return Poll::Pending,
            Poll::Ready(result) => result,
        };
        self.settings = None;
        Poll::Ready(result.map(|()| RadarConfig::DEFAULT))
    }

    /// Takes a trigger, with `ahead` also while the chirp of one other is pending; returns whether it was taken.
    pub fn trigger(&mut self, now: u64, deadline: (Micros, u64), ahead: bool) -> bool {
        if !ahead {
            self.chirps.clear();
        }
        if self.chirps.len() >= 2 {
            return false;
        }
        let times = Self::row_times(RadarConfig::DEFAULT.samples);
        let captured = now + u64::from(times.trigger_us) + CHIRP_US + u64::from(SLACK_US) / 2;
        let wire_free = self.chirps.back().and_then(|before| before.answer);
        let begins = captured.max(wire_free.unwrap_or(0));
        let lost = self.silent || self.losing > 0;
        self.losing = self.losing.saturating_sub(1);
        let answer = (!lost).then_some(begins + u64::from(times.answer_us));
        self.chirps.push_back(Request {
            answer,
            look: answer.unwrap_or(deadline.1),
            deadline: deadline.0,
        });
        true
    }

    /// Returns the answer to the oldest pending trigger: its chirp has arrived, or is lost at the timeout.
    pub fn poll(&mut self, now: u64, clock: Micros) -> Poll<Result<(), LinkError>> {
        let result = answer(self.chirps.front().copied(), now, clock);
        if result.is_ready() {
            self.chirps.pop_front();
            self.answered += u64::from(result == Poll::Ready(Ok(())));
        }
        result
    }

    /// Returns the first time after `seen` at which an answer arrives or a timeout ends, µs of the run.
    pub fn next_event(&self, seen: u64) -> u64 {
        let pending = self.chirps.iter().chain(&self.settings);
        let times = pending.map(|request| request.look);
        times.filter(|&at| at > seen).min().unwrap_or(u64::MAX)
    }
}

fn answer(request: Option<Request>, now: u64, clock: Micros) -> Poll<Result<(), LinkError>> {
    match request {
        Some(request) if request.answer.is_some_and(|at| now >= at) => Poll::Ready(Ok(())),
        Some(request) if !clock.reached(request.deadline) => Poll::Pending,
        _ => Poll::Ready(Err(LinkError::Timeout)),
    }
}
