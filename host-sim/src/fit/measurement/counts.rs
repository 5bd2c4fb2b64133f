//! What labelled scans give to count.

use super::labels::{Hit, Level, Sample};
use stairscan::params::generative::{EXTENDED, POINTS};

/// A point feature that could have been seen.
#[derive(Clone, Copy, Debug)]
pub struct Chance {
    /// Its class.
    pub class: usize,
    /// What its being seen depends on: one, predicted level (tens of dB over 30 dB), room less one cell.
    pub on: [f64; 3],
    /// Whether it was.
    pub seen: bool,
}

/// How many echoes of extended features a scan showed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scan {
    /// Its strongest echo, tens of dB over 30 dB.
    pub q: f64,
    /// Echoes by class …
    pub echoes: [f64; EXTENDED],
    /// … and what they are counted by: metres of tread, and so on.
    pub exposure: [f64; EXTENDED],
}

/// All that was labelled.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    /// Echoes of each class of point features.
    pub hits: [Vec<(Hit, Level)>; POINTS],
    /// The features of each riser.
    pub chances: Vec<Vec<Chance>>,
    /// What a riser's showing nothing depends on, and whether it did.
    pub risers: Vec<(Vec<f64>, bool)>,
    /// Level, place off the surface and its own error, by class of extended features.
    pub extended: [Vec<(Level, f64, f64)>; EXTENDED],
    /// The scans.
    pub scans: Vec<Scan>,
}

impl Counts {
    /// Adds one scan: its strongest echo, how much of face, tread and floor it shows, its samples.
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
