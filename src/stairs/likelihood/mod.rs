//! The default estimator: scatterers found by matched filter and particles, staircases weighed by
//! likelihood.
//!
//! | module | does |
//! |---|---|
//! | [`beam`] | matched filter along the angle, row by row |
//! | [`candidate`] | its local maxima, row by row |
//! | [`noise`] | noise and side-lobe level |
//! | [`echo`] | drops what noise or a stronger echo could have made |
//! | [`scatterer`] | a mode of particles for each: sub-cell place and covariance |
//! | [`calibrate`] | angle bias and mount height from the floor |
//! | [`evidence`] | columns of echoes, credibility |
//! | [`role`] | likelihood of a riser, a tread, a ramp |
//! | [`search`] | the best flight |
//! | [`ascent`], [`descent`] | its dimensions |

mod ascent;
mod beam;
mod calibrate;
mod candidate;
mod descent;
mod echo;
mod evidence;
mod noise;
mod role;
mod scatterer;
mod search;

use super::map::PolarMap;
use super::{Outcome, Reason};
use crate::config::{Config, Plane};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;

/// Most range bins of a map.
pub const MAX_BINS: usize = 256;
/// Score, nats, from which a flight counts.
const ACCEPT: f32 = 1.5;
/// An echo that noise alone does not make in a whole scan, dB.
const SURE_DB: f32 = 4.5;

/// What the estimator keeps during a scan.
#[derive(Debug)]
pub struct Likelihood {
    filter: beam::BeamFilter,
    finder: candidate::CandidateFinder,
    noise: noise::NoiseSamples,
    fed: usize,
    reversed: bool,
}

impl Default for Likelihood {
    fn default() -> Self {
        Self::new()
    }
}

impl Likelihood {
    /// Before the first scan.
    pub const fn new() -> Self {
        Self {
            filter: beam::BeamFilter::new(),
            finder: candidate::CandidateFinder::new(),
            noise: noise::NoiseSamples::new(),
            fed: 0,
            reversed: false,
        }
    }

    /// Ready for the first row of the scan that `map` has been shaped for.
    pub fn begin(&mut self, map: &PolarMap) {
        self.filter.begin(map.geometry());
        self.finder.begin();
        self.noise.begin();
        self.fed = 0;
        self.reversed = false;
    }

    /// Takes in row `k` of the map. Rows come one after the other from either end; one whose chirp
    /// was lost comes too, empty as it is.
    pub fn row(&mut self, map: &PolarMap, k: usize) {
        if self.fed == 0 {
            self.reversed = k > 0;
        }
        self.push(map, map.row(k));
    }

    /// Feeds one row to filter, noise and finder.
    fn push(&mut self, map: &PolarMap, row: &[u8]) {
        let last = map.rows().saturating_sub(1);
        let (fed, reversed) = (self.fed, self.reversed);
        let place = |arrival: usize| {
            let arrival = arrival.min(last);
            if reversed { last - arrival } else { arrival }
        };
        let levels = self.finder.next_row();
        let delayed = |back: usize| map.row(place(fed - back));
        self.filter.feed(row, delayed, &mut levels[..]);
        self.fed += 1;
        let Some(centre) = fed.checked_sub(self.filter.lag()) else {
            return;
        };
        let spacing = (self.filter.lag() + 1).max(map.rows().div_ceil(noise::MAX_SAMPLES));
        if place(centre) % spacing == spacing / 2 {
            self.noise.add(&levels[..], self.filter.gain());
        }
        let middle = centre
            .checked_sub(candidate::MIDDLE)
            .map(|m| place(m) as u16);
        self.finder.advance(map.bins(), middle, reversed);
    }

    /// The answer, after the last row.
    pub fn finish(&mut self, map: &PolarMap, config: &Config, scan: u32) -> Outcome {
        let end = if self.reversed {
            0
        } else {
            map.rows().saturating_sub(1)
        };
        // What lies beyond the last row is taken to be like it.
        for _ in 0..self.filter.lag() {
            self.push(map, map.row(end));
        }
        let mut floors = [0; MAX_BINS];
        let noise = self.noise.medians(map.bins(), &mut floors);
        let seed = u64::from(config.seed) << 32 | u64::from(scan);
        let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed);
        let background = echo::Background {
            floors: &floors,
            noise,
            gain: self.filter.gain(),
        };
        let mut echoes = echo::select(map, self.finder.sorted(), &background, config, &mut rng);
        if !echoes.iter().any(|e| e.db >= SURE_DB) {
            return Outcome::fault(Reason::NoEcho);
        }
        let geometry = map.geometry();
        if geometry.plane == Plane::Height {
            return descent::assemble(&echoes, geometry.mount_height_m).0;
        }
        calibrate::calibrate(&mut echoes, geometry);
        let evidence = evidence::Evidence::new(&echoes, geometry.mount_height_m);
        match search::Search::new(&evidence).best() {
            Some(flight) if flight.score >= ACCEPT => ascent::dimension(&evidence, &flight),
            _ => Outcome::clear(),
        }
    }
}
