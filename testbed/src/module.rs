//! Radar module without a protocol: it answers requests at once, or in the time of a serial link.
//!
//! In: requests by the trait of radar modules, and the chirps of [`Echoes`]. Out: settings and chirps, with faults on
//! command: a module that is silent, chirps that are lost, error answers. Timeouts are those of the scanner's 32-bit clock,
//! as a real link's are.

use std::collections::VecDeque;
use std::task::Poll;

use stairscan::Iq;
use stairscan::config::RadarConfig;
use stairscan::signal::radar::module::RequestedSettings;
use stairscan::signal::radar::wire::{RowTimes, SLACK_US, Wire};
use stairscan::signal::radar::{LinkError, RadarModule};
use stairscan::time::Micros;

use super::shared::Shared;

/// Time from a query of the settings to the answer, µs: some hundred bytes, and the module's own time.
const SETTINGS_US: u64 = 3_000;
/// Duration of a chirp, µs: default of `chirp-duration`.
const CHIRP_US: u64 = 1_000;

/// Chirps of a module, and a test's view of the requests.
pub trait Echoes {
    /// Returns the module's settings; `None`: [`Module::radar`].
    fn radar(&self) -> Option<RadarConfig> {
        None
    }
    /// The module's settings are requested.
    fn programmed(&mut self) {}
    /// A chirp is triggered at shaft angle `angle`, 0.001°.
    fn triggered(&mut self, _angle: i32) {}
    /// Writes the chirp at shaft angle `angle`, 0.001°, to `samples`, or returns the error in its place.
    fn chirp(&mut self, _angle: i32, _samples: &mut [Iq]) -> Result<(), LinkError> {
        Ok(())
    }
}

/// Chirps that change no sample.
impl Echoes for () {}

/// A request whose answer is pending.
#[derive(Clone, Copy, Debug)]
struct Request {
    /// Shaft angle of a trigger, 0.001°.
    angle: i32,
    /// Time at which the answer arrives, µs; `None` if it is lost.
    answer: Option<u64>,
    /// Time at which the scanner's loop must look at this request, µs: that of its answer, or of its timeout.
    look: u64,
    deadline: Micros,
}

impl Request {
    /// Returns whether the answer has arrived at time `now`, µs, or an error at the timeout by the scanner's clock.
    fn poll(&self, now: u64, clock: Micros) -> Poll<Result<(), LinkError>> {
        match self.answer {
            Some(at) if now >= at => Poll::Ready(Ok(())),
            _ if !clock.reached(self.deadline) => Poll::Pending,
            _ => Poll::Ready(Err(LinkError::Timeout)),
        }
    }
}

/// The radar module at the other end of the link, and its pending answers.
#[derive(Clone, Debug)]
pub struct Module<E = ()> {
    /// Source of its chirps.
    pub echoes: E,
    /// Current time, µs.
    pub now: u64,
    /// Wire whose times the answers take.
    pub wire: Wire,
    /// Whether answers take time; else they are there at once.
    pub takes_time: bool,
    /// Settings in its answers; `None`: it does not answer requests for them.
    pub radar: Option<RadarConfig>,
    /// Whether it answers no request.
    pub silent: bool,
    /// Number of the next chirps that will be lost.
    pub losing: u32,
    /// Errors in place of the next chirps that arrive; `None` is a chirp.
    pub errors: VecDeque<Option<LinkError>>,
    /// Last settings requested from it.
    pub requested: RequestedSettings,
    /// Number of chirps that it has delivered.
    pub answered: u64,
    /// Whether it has answered since the test last set this to `false`.
    pub touched: bool,
    settings: Option<Request>,
    chirps: VecDeque<Request>,
}

impl<E: Echoes + Default> Default for Module<E> {
    fn default() -> Self {
        Self::new(E::default())
    }
}

impl<E: Echoes> Module<E> {
    /// Returns a module with default settings that answers at once.
    pub fn new(echoes: E) -> Self {
        Self {
            echoes,
            now: 0,
            wire: Wire::default(),
            takes_time: false,
            radar: Some(RadarConfig::DEFAULT),
            silent: false,
            losing: 0,
            errors: VecDeque::new(),
            requested: RequestedSettings::DEFAULT,
            answered: 0,
            touched: false,
            settings: None,
            chirps: VecDeque::new(),
        }
    }

    /// Returns the first time after `seen` at which an answer arrives or a timeout ends, µs.
    pub fn next_event(&self, seen: u64) -> u64 {
        let pending = self.chirps.iter().chain(&self.settings);
        let times = pending.map(|request| request.look);
        times.filter(|&at| at > seen).min().unwrap_or(u64::MAX)
    }

    fn request(&self, clock: Micros, timeout_us: u32, angle: i32, answer: Option<u64>) -> Request {
        Request {
            angle,
            answer,
            look: answer.unwrap_or(self.now + u64::from(timeout_us)),
            deadline: clock.plus(timeout_us),
        }
    }

    /// Adds a trigger behind those pending.
    fn fire(&mut self, clock: Micros, angle: i32, timeout_us: u32) {
        self.echoes.triggered(angle);
        let times = self.wire.row_times(RadarConfig::DEFAULT.samples);
        let arrives = if self.takes_time {
            let trigger_us = u64::from(times.trigger_us);
            let captured = self.now + trigger_us + CHIRP_US + u64::from(SLACK_US) / 2;
            let wire_free = self.chirps.back().and_then(|before| before.answer);
            captured.max(wire_free.unwrap_or(0)) + u64::from(times.answer_us)
        } else {
            self.now
        };
        let lost = self.silent || self.losing > 0;
        self.losing = self.losing.saturating_sub(1);
        let request = self.request(clock, timeout_us, angle, (!lost).then_some(arrives));
        self.chirps.push_back(request);
    }
}

impl<E: Echoes> RadarModule for Module<E> {
    fn program(&mut self, now: Micros, requested: &RequestedSettings, timeout_us: u32) {
        self.chirps.clear();
        self.requested = *requested;
        self.echoes.programmed();
        let delay = if self.takes_time { SETTINGS_US } else { 0 };
        let answer = (!self.silent).then_some(self.now + delay);
        self.settings = Some(self.request(now, timeout_us, 0, answer));
    }

    fn settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        let radar = self.echoes.radar().or(self.radar);
        let request = self.settings.map(|request| Request {
            answer: request.answer.filter(|_| radar.is_some()),
            ..request
        });
        let answer = request.map_or(Poll::Ready(Err(LinkError::Timeout)), |request| {
            request.poll(self.now, now)
        });
        if answer.is_ready() {
            self.settings = None;
            self.touched = true;
        }
        answer.map_ok(|()| radar.unwrap_or_default())
    }

    fn trigger(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        self.chirps.clear();
        self.fire(now, shaft_angle, timeout_us);
    }

    fn trigger_ahead(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) -> bool {
        if !self.wire.ahead || self.chirps.len() >= 2 {
            return false;
        }
        self.fire(now, shaft_angle, timeout_us);
        true
    }

    fn poll(&mut self, now: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        let Some(request) = self.chirps.front().copied() else {
            return Poll::Ready(Err(LinkError::Timeout));
        };
        let Poll::Ready(mut result) = request.poll(self.now, now) else {
            return Poll::Pending;
        };
        self.chirps.pop_front();
        self.touched = true;
        if result.is_ok() {
            result = match self.errors.pop_front().flatten() {
                Some(error) => Err(error),
                None => self.echoes.chirp(request.angle, samples),
            };
        }
        self.answered += u64::from(result.is_ok());
        Poll::Ready(result)
    }

    fn row_times(&self, samples: u16) -> Option<RowTimes> {
        Some(self.wire.row_times(samples))
    }
}

impl<T: RadarModule> RadarModule for Shared<T> {
    fn program(&mut self, now: Micros, requested: &RequestedSettings, timeout_us: u32) {
        self.get().program(now, requested, timeout_us);
    }

    fn settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        self.get().settings(now)
    }

    fn trigger(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        self.get().trigger(now, shaft_angle, timeout_us);
    }

    fn trigger_ahead(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) -> bool {
        self.get().trigger_ahead(now, shaft_angle, timeout_us)
    }

    fn poll(&mut self, now: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        self.get().poll(now, samples)
    }

    fn retry(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        self.get().retry(now, shaft_angle, timeout_us);
    }

    fn sent(&self) -> bool {
        self.get().sent()
    }

    fn waits(&self) -> bool {
        self.get().waits()
    }

    fn row_times(&self, samples: u16) -> Option<RowTimes> {
        self.get().row_times(samples)
    }
}
