//! Sufficient statistics of labelled scans for the measurement model.

use super::labels::{Hit, Level, Sample};
use stairscan::params::generative::{EXTENDED, POINTS};

/// A point feature that was expected to be visible.
#[derive(Clone, Copy, Debug)]
pub struct Chance {
    /// Its class.
    pub class: usize,
    /// Covariates of its detection: 1, predicted level (tens of dB over 30 dB), distance to its
    /// neighbour in resolution cells less one.
    pub on: [f64; 3],
    /// Whether it was detected.
    pub seen: bool,
}

/// Numbers of echoes of extended features in a scan.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scan {
    /// Its strongest echo, tens of dB over 30 dB.
    pub q: f64,
    /// Echoes by class.
    pub echoes: [f64; EXTENDED],
    /// Exposure by class, for example metres of tread.
    pub exposure: [f64; EXTENDED],
}

/// Statistics of all labelled scans.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    /// Echoes of each class of point features.
    pub hits: [Vec<(Hit, Level)>; POINTS],
    /// Point features of each riser.
    pub chances: Vec<Vec<Chance>>,
    /// For each riser: covariates of showing no echo, and whether it shows none.
    pub risers: Vec<(Vec<f64>, bool)>,
    /// By class of extended features: level, distance from the surface and its standard deviation.
    pub extended: [Vec<(Level, f64, f64)>; EXTENDED],
    /// The scans.
    pub scans: Vec<Scan>,
}

impl Counts {
    /// Adds one scan: its strongest echo, its exposures of face, tread and floor, its samples.
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
                    features.push(Chance {
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
                    self.chances.push(std::mem::take(&mut features));
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
