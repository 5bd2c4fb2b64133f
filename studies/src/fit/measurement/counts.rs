//! Sufficient statistics of labelled scans for the measurement model.

use super::labels::{Hit, Level, Sample};
use stairscan::params::generative::{EXTENDED, POINTS};

/// A point feature (such as a corner or nosing) of a riser that was expected to be visible.
#[derive(Clone, Copy, Debug)]
pub struct DetectionTrial {
    /// Index of the feature's class in `POINT_NAMES`, such as corner or nosing.
    pub class: usize,
    /// Covariates of the feature's detection: 1; SNR predicted at its range from the scan's strongest echo, tens of dB
    /// over 30 dB; distance to the neighbouring feature, in resolution cells less one.
    pub on: [f64; 3],
    /// Whether the feature was detected, that is, has an echo.
    pub seen: bool,
}

/// Numbers of echoes of extended features (face, tread, floor, air, inside, noise) in one scan.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scan {
    /// SNR of the scan's strongest echo, tens of dB over 30 dB.
    pub q: f64,
    /// Number of echoes of each class.
    pub echoes: [f64; EXTENDED],
    /// Exposure of each class, for example metres of tread: the expected number of echoes is rate times exposure.
    pub exposure: [f64; EXTENDED],
}

/// Sufficient statistics of all labelled scans.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    /// For each class of point features: offset from its feature, and SNR with covariates, of every echo that is
    /// assigned to one.
    pub hits: [Vec<(Hit, Level)>; POINTS],
    /// For each riser: its point features that were expected to be visible.
    pub trials: Vec<Vec<DetectionTrial>>,
    /// For each riser: covariates of showing no echo (1; SNR predicted at its range, tens of dB over 30 dB; 1 if its
    /// foot is hidden, else 0; SNR of the riser before, tens of dB over 15 dB), and whether it shows none.
    pub risers: Vec<(Vec<f64>, bool)>,
    /// For each class of extended features and each of its echoes: SNR with covariates; distance from the surface, and
    /// the standard deviation of that due to the error of the echo's angle, metres.
    pub extended: [Vec<(Level, f64, f64)>; EXTENDED],
    /// Numbers of echoes of extended features in each scan.
    pub scans: Vec<Scan>,
}

impl Counts {
    /// Adds one scan: SNR of its strongest echo (tens of dB over 30 dB), its exposures of face, tread and floor, and
    /// its labelled samples.
    pub fn add(&mut self, q: f32, exposure: [f32; 3], samples: &[Sample]) {
        let mut scan = Scan {
            q: q.into(),
            exposure: [1.0; EXTENDED],
            ..Scan::default()
        };
        for (to, from) in scan.exposure.iter_mut().zip(exposure) {
            *to = from.into();
        }
        let mut features = Vec::new();
        for sample in samples {
            match *sample {
                Sample::Feature {
                    class,
                    q,
                    room,
                    hit,
                    ..
                } => {
                    let class = class as usize;
                    features.push(DetectionTrial {
                        class,
                        on: [1.0, q.into(), f64::from(room) - 1.0],
                        seen: hit.is_some(),
                    });
                    self.hits[class].extend(hit);
                }
                Sample::Riser {
                    q,
                    hidden,
                    before,
                    nothing,
                } => {
                    let hidden = f64::from(u8::from(hidden));
                    let on = vec![1.0, q.into(), hidden, before.into()];
                    self.risers.push((on, nothing));
                    self.trials.push(std::mem::take(&mut features));
                }
                Sample::Extended {
                    class,
                    level,
                    off_m,
                    noise_m,
                } => {
                    scan.echoes[class] += 1.0;
                    self.extended[class].push((level, off_m.into(), noise_m.into()));
                }
            }
        }
        self.scans.push(scan);
    }
}
