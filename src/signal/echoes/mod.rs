//! Detection of echoes in the polar map: point scatterers, with positions finer than a cell.
//!
//! | module | from → to |
//! |---|---|
//! | `angle_filter` | rows of the map → rows filtered along the angle |
//! | `maxima` | filtered rows → the strongest local maxima |
//! | `noise` | filtered rows → noise, and the level to which side lobes raise each range bin |
//! | `lobe` | levels around a maximum → position within the cell, variance, width |
//! | `ghosts` | levels of the artefacts of a strong echo, one function per artefact |
//! | `beam` | widths of strong echoes → whether the mirror's step is as configured |
//! | `place` | echoes from a chair that moves → as seen from the mirror at the last row |
//! | `echo` | one point scatterer |
//! | `detect` | maxima → echoes that need a scatterer of their own |

mod angle_filter;
mod beam;
mod detect;
mod echo;
mod ghosts;
mod lobe;
mod maxima;
mod noise;
mod place;

#[cfg(test)]
pub(crate) mod tests;

use crate::config::Config;
use crate::drive::Drive;
use crate::params::Params;
use crate::signal::grid::PolarMap;
pub use angle_filter::two_way_sigma;
pub use beam::Lobes;
pub use echo::{Echo, Echoes, MAX_ECHOES};
pub use lobe::ScattererMotion;
pub use place::MotionCompensation;
pub(crate) use place::row_of;

impl Default for Collector {
    fn default() -> Self {
        Self::new()
    }
}

/// Detector of echoes, fed row by row during the scan.
#[derive(Debug)]
pub struct Collector {
    filter: angle_filter::AngleFilter,
    finder: maxima::MaximaFinder,
    noise: noise::NoiseSamples,
    fed: usize,
    reversed: bool,
    /// Minimum level of a maximum, 1/128 octave; lower ones are not searched.
    least: u16,
}

impl Collector {
    /// Empty, before the first scan.
    pub const fn new() -> Self {
        Self {
            filter: angle_filter::AngleFilter::new(),
            finder: maxima::MaximaFinder::new(),
            noise: noise::NoiseSamples::new(),
            fed: 0,
            reversed: false,
            least: 0,
        }
    }

    /// Prepares for the first row of the scan that `map` has been shaped for.
    pub fn begin(&mut self, map: &PolarMap) {
        self.filter.begin(map.geometry());
        self.finder.begin();
        self.noise.begin();
        self.fed = 0;
        self.reversed = false;
        self.least = 0;
    }

    /// Takes row `k` of the map. Rows come one after the other from either end.
    pub fn row(&mut self, map: &PolarMap, k: usize) {
        if self.fed == 0 {
            self.reversed = k > 0;
        }
        self.push(map, map.row(k));
    }

    /// Passes the cells of one row to the angle filter, and the filtered row to the noise samples and the
    /// search for maxima.
    fn push(&mut self, map: &PolarMap, row: &[u8]) {
        let last = map.rows().saturating_sub(1);
        let (fed, reversed) = (self.fed, self.reversed);
        let place = |arrival: usize| {
            let arrival = arrival.min(last);
            if reversed { last - arrival } else { arrival }
        };
        let levels = self.finder.next_row();
        let delayed = |back: usize| map.row(place(fed.saturating_sub(back)));
        self.filter.feed(row, delayed, &mut levels[..]);
        self.fed += 1;
        let Some(centre) = fed.checked_sub(self.filter.lag()) else {
            return;
        };
        let spacing = (self.filter.lag() + 1).max(map.rows().div_ceil(noise::MAX_SAMPLES));
        if place(centre).checked_rem(spacing) == Some(spacing / 2) {
            let levels = levels.get(..map.bins()).unwrap_or(&[]);
            self.noise.add(levels, self.filter.gain());
        }
        let middle = centre.checked_sub(maxima::MIDDLE).map(place);
        self.finder.advance(map.bins(), middle, self.least);
    }

    /// Detects the echoes after the last row and writes them to `echoes` (too large for a small stack). Returns
    /// the noise: median of the filtered map without the filter's gain, map units.
    #[inline(never)]
    pub fn finish(
        &mut self,
        map: &PolarMap,
        config: &Config,
        params: &Params,
        drive: &Drive<'_>,
        echoes: &mut Echoes,
    ) -> f32 {
        let end = if self.reversed {
            0
        } else {
            map.rows().saturating_sub(1)
        };
        // After the last row time is short, so maxima at noise level are skipped from here on. The noise
        // samples still to come move the median by less than the spare decibel. In a narrow sector one sample
        // is one of few, and sweeps of the two directions would find different maxima, so the noise must be
        // settled.
        if let Some(noise) = self.noise.median().filter(|_| self.noise.settled()) {
            self.least = detect::least_level(noise, self.filter.gain(), 1.0, params);
        }
        // Rows beyond the last one are assumed to be equal to it.
        for _ in 0..self.filter.lag() {
            self.push(map, map.row(end));
        }
        let noise = self.noise.median().unwrap_or(0.0);
        let background = detect::Background {
            samples: &self.noise,
            noise,
            gain: self.filter.gain(),
        };
        let ride = MotionCompensation::of(drive, &config.radar);
        let ride = ride.as_ref();
        detect::detect(
            map,
            &mut self.finder,
            &background,
            config,
            ride,
            params,
            echoes,
        );
        noise
    }
}
