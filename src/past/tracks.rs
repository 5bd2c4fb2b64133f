//! Steps from scan to scan: each step's place and level, combined over scans with correlated errors.
//!
//! The error of a reading resembles that of the reading before: the same face reflects in the same way. The
//! correlation r falls with the displacement between them, so the errors are a Gauss-Markov chain (Gelb, *Applied
//! Optimal Estimation*, ch. 3). The mean has variance v, the next reading has variance u, and the covariance of their
//! errors is q. The optimal combination is
//!
//! ```text
//! w  = (v - q) / (v + u - 2 q)                 of the reading, 0…1
//! v' = (1 - w)² v + w² u + 2 w (1 - w) q       variance of the new mean
//! q' = ((1 - w) q + w u) r √(u' / u)           its covariance with the next reading
//! ```

use crate::answer::Step;
use crate::estimate::Estimate;
use crate::math;
use crate::model::MAX_STEPS;
use crate::motion::same_place_m;
use crate::params::Numbers;
use crate::params::carried::{Correlation, MAX_READING_SIGMAS};
use crate::params::counted;
use crate::params::motion::{ODOMETER_SCALE_ERROR, ODOMETER_WANDER_M};
use heapless::Vec;

/// Weighted mean over scans of one length of a step, its distance or its height above the ground, metres.
#[derive(Clone, Copy, Debug)]
struct Mean {
    value: f32,
    variance: f32,
    /// Covariance of the mean's error with the error of the last reading that was taken into it, m².
    covariance: f32,
    /// Variance of the last reading that was taken into the mean, m².
    last: f32,
}

impl Mean {
    fn first(reading: Estimate) -> Self {
        let variance = math::max(reading.variance, f32::MIN_POSITIVE);
        Self {
            value: reading.value,
            variance,
            covariance: variance,
            last: variance,
        }
    }

    /// Returns the mean with one more reading, whose error has correlation `correlation` with the last one's.
    #[inline(never)]
    fn with(&self, reading: Estimate, correlation: f32) -> Self {
        let (v, u) = (
            self.variance,
            math::max(reading.variance, f32::MIN_POSITIVE),
        );
        let q = correlation * self.covariance * math::sqrt(u / self.last);
        let spread = math::max(v + u - 2.0 * q, f32::MIN_POSITIVE);
        let w = ((v - q) / spread).clamp(0.0, 1.0);
        let off = reading.value - self.value;
        // A difference beyond the limit enlarges the variance (Birge 1932).
        let excess = math::max(
            off * off / (MAX_READING_SIGMAS * MAX_READING_SIGMAS * (v + u)),
            1.0,
        );
        let rest = 1.0 - w;
        Self {
            value: self.value + w * off,
            variance: excess * (rest * rest * v + w * w * u + 2.0 * w * rest * q),
            covariance: rest * q + w * u,
            last: u,
        }
    }

    /// Returns the mean with one more reading, with a variance as if both errors were fully correlated. A hidden
    /// overhang makes the same error of a nosing's place from every distance.
    fn with_correlated(&self, reading: Estimate, correlation: f32) -> Self {
        let mut out = self.with(reading, correlation);
        let off = reading.value - self.value;
        let w = if off == 0.0 {
            1.0
        } else {
            (out.value - self.value) / off
        };
        let sigma_m = (1.0 - w) * math::sqrt(self.variance) + w * reading.sigma();
        out.variance = math::max(out.variance, sigma_m * sigma_m);
        out
    }
}

/// A step that was reported in several scans: its distance and its height above the ground, combined.
#[derive(Clone, Copy, Debug)]
struct StepTrack {
    place: Mean,
    level: Mean,
}

/// Steps of earlier scans at their present places; after [`Tracks::combine`], the steps of this scan.
#[derive(Debug)]
pub struct Tracks {
    past: Vec<StepTrack, MAX_STEPS>,
    moved_m: f32,
    /// Displacement of the chair during this scan, metres.
    moved_during_scan_m: f32,
    /// Maximum distance between a step of this scan and the same step of earlier scans, metres; none if none is the
    /// same.
    off_m: Option<f32>,
    numbers: Numbers,
}

impl Tracks {
    /// Returns a set without steps.
    pub(super) const fn new(numbers: Numbers) -> Self {
        Self {
            past: Vec::new(),
            moved_m: 0.0,
            moved_during_scan_m: 0.0,
            off_m: None,
            numbers,
        }
    }

    /// Whether steps were reported before, and each is at its expected place.
    pub(super) fn confirmed(&self) -> bool {
        self.off_m
            .is_some_and(|off| off <= same_place_m(self.moved_m))
    }

    /// Moves the steps nearer by the chair's displacement `moved_m` since the scan before, metres.
    /// `moved_during_scan_m` is its displacement during this scan, metres.
    pub(super) fn shift(&mut self, moved_m: f32, moved_during_scan_m: f32) {
        self.moved_m = moved_m;
        self.moved_during_scan_m = moved_during_scan_m;
        for track in &mut self.past {
            track.place.value -= moved_m;
        }
    }

    pub(super) fn clear_carried(&mut self) {
        self.past.clear();
        self.off_m = None;
    }

    /// Returns distance and height of each step that was reported before, metres, as seen from the chair's present
    /// place.
    pub fn reported_steps(&self) -> impl Iterator<Item = (f32, f32)> + Clone + '_ {
        self.past.iter().map(|t| (t.place.value, t.level.value))
    }

    /// Returns the track of a step, if a step within `same_step_m` of it was reported before.
    #[inline(never)]
    fn of(&self, step: &Step) -> Option<&StepTrack> {
        let off = |t: &StepTrack| (t.place.value - step.distance_m).abs();
        let same_step_m = self.numbers.same_step_m;
        let near = self.past.iter().filter(|t| off(t) <= same_step_m);
        near.min_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// Returns the error of the odometer's displacement, metres, estimated from the steps that were reported before.
    #[inline(never)]
    fn odometer_error(&self, steps: &[Step]) -> Estimate {
        let sigma_m = math::hypot(ODOMETER_SCALE_ERROR * self.moved_m, ODOMETER_WANDER_M);
        let mut weight = 1.0 / (sigma_m * sigma_m);
        let mut sum = 0.0;
        for step in steps {
            if let Some(track) = self.of(step) {
                let spread = track.place.variance + step.distance_sigma_m * step.distance_sigma_m;
                weight += 1.0 / spread;
                sum += (step.distance_m - track.place.value) / spread;
            }
        }
        Estimate {
            value: sum / weight,
            variance: 1.0 / weight,
        }
    }

    /// Combines the steps of this scan with their tracks: `steps` receives the combined distances, heights and standard
    /// deviations, and the tracks become those of `steps`.
    #[inline(never)]
    pub fn combine(&mut self, steps: &mut [Step]) {
        let off = |s: &Step| Some((self.of(s)?.place.value - s.distance_m).abs());
        let off_m = steps.iter().filter_map(off).reduce(math::max);
        self.off_m = off_m;
        let slip = self.odometer_error(steps);
        for track in &mut self.past {
            track.place.value += slip.value;
            track.place.variance += slip.variance;
        }
        let mut present = Vec::new();
        let correlation = |c: &Correlation| c.after(self.moved_m);
        let correlations = (correlation(&counted::PLACES), correlation(&counted::LEVELS));
        for step in steps {
            let rode_m = ODOMETER_SCALE_ERROR * self.moved_during_scan_m;
            let place_m = math::hypot(step.distance_sigma_m, rode_m);
            let place = Estimate::new(step.distance_m, place_m);
            let level = Estimate::new(step.height_m, step.height_sigma_m);
            let mut track = StepTrack {
                place: Mean::first(place),
                level: Mean::first(level),
            };
            if let Some(past) = self.of(step) {
                track = StepTrack {
                    place: past.place.with_correlated(place, correlations.0),
                    level: past.level.with(level, correlations.1),
                };
                step.distance_m = track.place.value;
                step.distance_sigma_m = math::sqrt(track.place.variance);
                step.height_m = track.level.value;
                step.height_sigma_m = math::sqrt(track.level.variance);
            }
            // Cannot fail: an answer in this plane has no more steps.
            let _ = present.push(track);
        }
        self.past = present;
    }
}
