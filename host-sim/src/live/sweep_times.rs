//! True rate of a simulated scanner's guard sweeps: each begins at its time in the recording.

use std::task::Poll;

use stairscan::Iq;
use stairscan::config::RadarConfig;
use stairscan::scanner::Micros;
use stairscan::scanner::settings::GuardConfig;
use stairscan::signal::radar::module::RequestedSettings;
use stairscan::signal::radar::{LinkError, RadarModule};

use crate::playback::PlaybackLink;
use crate::recording::Recording;

/// Times at which the sweeps of a recording begin.
#[derive(Clone, Debug)]
pub struct SweepTimes {
    /// Time of each sweep's first row since that of the first sweep, µs.
    starts_us: Vec<u64>,
    /// Interval between sweeps beyond the recording's last, µs.
    interval_us: u64,
}

impl SweepTimes {
    /// Returns the times of `recording`; at the guard's default rate where it has none.
    pub fn new(recording: &Recording) -> Self {
        let times = recording.meta.motion.time_s.iter();
        let begins = times.step_by(recording.chirps_per_scan().max(1));
        let mut starts_us = Vec::new();
        let mut first = None;
        for &time_s in begins {
            let since = time_s - *first.get_or_insert(time_s);
            starts_us.push((1e6 * since.max(0.0)).round() as u64);
        }
        let default_us = 1_000_000 / u64::from(GuardConfig::default().rate.max(1));
        let interval_us = match starts_us[..] {
            [.., before, last] => last - before.min(last),
            _ => default_us,
        };
        Self {
            starts_us,
            interval_us,
        }
    }

    /// Returns the time of sweep `sweep` (from 0) after the first one, µs.
    pub fn start_us(&self, sweep: usize) -> u64 {
        let known = self.starts_us.get(sweep).copied();
        known.unwrap_or_else(|| {
            let last = self.starts_us.len().saturating_sub(1);
            let begun = self.starts_us.get(last).copied().unwrap_or(0);
            begun + (sweep - last) as u64 * self.interval_us
        })
    }
}

/// A radar link whose sweeps begin at their times: it holds back the module's settings, with which each sweep begins.
#[derive(Debug)]
pub struct PacedLink<'a> {
    link: PlaybackLink<'a>,
    times: Option<SweepTimes>,
    /// Time of the first sweep.
    begun: Option<Micros>,
    /// Number of sweeps of which a chirp was triggered, and whether the current one is among them.
    sweeps: usize,
    triggered: bool,
}

impl<'a> PacedLink<'a> {
    /// Creates the link to `link`; without times it holds nothing back.
    pub fn new(link: PlaybackLink<'a>, times: Option<SweepTimes>) -> Self {
        Self {
            link,
            times,
            begun: None,
            sweeps: 0,
            triggered: false,
        }
    }

    /// Whether the next sweep must not begin yet at `now`.
    fn is_early(&self, now: Micros) -> bool {
        let (Some(times), Some(begun)) = (&self.times, self.begun) else {
            return false;
        };
        // The clock wraps, as the chip's.
        u64::from(now.0.wrapping_sub(begun.0)) < times.start_us(self.sweeps)
    }
}

impl RadarModule for PacedLink<'_> {
    fn program(&mut self, now: Micros, settings: &RequestedSettings, timeout_us: u32) {
        self.sweeps += usize::from(std::mem::take(&mut self.triggered));
        self.link.program(now, settings, timeout_us);
    }

    fn settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        match self.is_early(now) {
            true => Poll::Pending,
            false => self.link.settings(now),
        }
    }

    fn trigger(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        self.begun.get_or_insert(now);
        self.triggered = true;
        self.link.trigger(now, shaft_angle, timeout_us);
    }

    fn poll(&mut self, now: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        self.link.poll(now, samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulate::image;

    #[test]
    fn sweeps_begin_as_recorded_and_go_on_at_that_rate() {
        let path = image::workspace().join("recordings/guard_kerb");
        let mut recording = Recording::read(&path).unwrap();
        let times = SweepTimes::new(&recording);
        let starts = [0, 1, 5, 6, 8].map(|sweep| times.start_us(sweep));
        assert_eq!(starts, [0, 184_000, 920_000, 1_104_000, 1_472_000]);
        // Without times: the default rate, 7 sweeps a second.
        recording.meta.motion.time_s.clear();
        let times = SweepTimes::new(&recording);
        assert_eq!([0, 7].map(|sweep| times.start_us(sweep)), [0, 999_999]);
    }
}
