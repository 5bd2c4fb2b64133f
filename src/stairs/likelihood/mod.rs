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
mod dimension;
mod doubt;
mod echo;
mod evidence;
mod levels;
mod noise;
mod role;
mod scatterer;
mod search;
pub mod trace;

#[cfg(test)]
mod tests;

use ascent::Ascent;
use descent::Descent;
use dimension::Sized;
use echo::Echo;
use evidence::{Evidence, Mark};
use search::{Flight, Search, Stairs};
use trace::{Explanation, Hypothesis, Observer, Scatterer};

use super::map::PolarMap;
use super::{Outcome, Reason};
use crate::config::{Config, Plane};
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;

/// Most range bins of a map.
pub const MAX_BINS: usize = 256;
/// Score, nats, from which a flight going up counts …
const ACCEPT_UP: f32 = 1.5;
/// … and one going down.
const ACCEPT_DOWN: f32 = 2.0;
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
        self.finder.advance(map.bins(), middle);
    }

    /// The answer, after the last row.
    pub fn finish(&mut self, map: &PolarMap, config: &Config, scan: u32) -> Outcome {
        self.finish_observed(map, config, scan, &mut ())
    }

    /// [`Likelihood::finish`], telling `observer` what it thinks.
    pub fn finish_observed(
        &mut self,
        map: &PolarMap,
        config: &Config,
        scan: u32,
        observer: &mut impl Observer,
    ) -> Outcome {
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
        observer.noise(noise);
        let background = echo::Background {
            floors: &floors,
            noise,
            gain: self.filter.gain(),
        };
        let seed = u64::from(config.seed) << 32 | u64::from(scan);
        let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed);
        let mut echoes = echo::select(map, self.finder.sorted(), &background, config, &mut rng);
        let geometry = map.geometry();
        let outcome = match geometry.plane {
            Plane::Depth => {
                let found = calibrate::calibrate(&mut echoes, geometry);
                observer.calibration(found.bias_rad, found.height_m);
                let evidence = Evidence::risers(&echoes, geometry.mount_height_m);
                ascend(&evidence, &echoes, found.bias_sigma, observer)
            }
            Plane::Height => {
                let evidence = Evidence::treads(&echoes, geometry.mount_height_m);
                descend(&evidence, &echoes, observer)
            }
        };
        if echoes.iter().any(|e| e.db >= SURE_DB) {
            outcome
        } else {
            Outcome::fault(Reason::NoEcho)
        }
    }
}

/// The best stairs going up, if they explain the echoes better than everything else.
fn ascend(
    evidence: &Evidence,
    echoes: &[Echo],
    bias_sigma: f32,
    observer: &mut impl Observer,
) -> Outcome {
    let ascent = Ascent::new(evidence);
    let mut search = Search::new(&ascent);
    let best = search.best().map(|mut flight| {
        let (rise, score) = ascent.rise(&flight);
        flight.score = score;
        (flight, rise)
    });
    let winner = best
        .as_ref()
        .filter(|(flight, _)| flight.score >= ACCEPT_UP);
    tell(&search, winner.map(|w| &w.0), echoes, observer);
    let sized = winner.map(|(f, rise)| dimension::ascending(evidence, f, *rise, bias_sigma));
    conclude(&search, best.as_ref().map(|b| &b.0), sized, ACCEPT_UP)
}

/// The same for stairs going down.
fn descend(evidence: &Evidence, echoes: &[Echo], observer: &mut impl Observer) -> Outcome {
    let descent = Descent::new(evidence);
    let mut search = Search::new(&descent);
    let best = search.best();
    let winner = best.as_ref().filter(|flight| flight.score >= ACCEPT_DOWN);
    tell(&search, winner, echoes, observer);
    let sized = winner.map(|flight| dimension::descending(&descent, flight));
    conclude(&search, best.as_ref(), sized, ACCEPT_DOWN)
}

/// The outcome and what it is worth: of a flight that was accepted and sized, or of none.
fn conclude<S: Stairs>(
    search: &Search<'_, S>,
    best: Option<&Flight<S::Shape>>,
    sized: Option<Sized>,
    accept: f32,
) -> Outcome {
    let marks = &search.stairs().evidence().marks;
    match (best, sized) {
        (Some(best), Some(mut sized)) if !sized.supports.is_empty() => {
            let role = |m: &&Mark| search.stairs().role(m, &best.chain, best.shape);
            let against = marks.iter().filter(|m| role(m).contradicts()).map(|m| m.db);
            let lead = best.score - search.rival(best.chain.len()).max(accept);
            doubt::judge(&mut sized.outcome, lead, &sized.supports, against);
            sized.outcome
        }
        (best, sized) => {
            // A flight that was accepted and then found to be a box or a threshold is no rival.
            let score = best.filter(|_| sized.is_none()).map(|b| b.score - accept);
            let strongest = marks.iter().map(|m| m.db).fold(0.0, f32::max);
            let mut outcome = Outcome::clear();
            doubt::judge_none(&mut outcome, score.unwrap_or(f32::NEG_INFINITY), strongest);
            outcome
        }
    }
}

/// Tells the observer each scatterer's role, and every explanation with its score.
fn tell<S: Stairs>(
    search: &Search<'_, S>,
    winner: Option<&Flight<S::Shape>>,
    echoes: &[Echo],
    observer: &mut impl Observer,
) {
    let stairs = search.stairs();
    for (k, &echo) in (0..).zip(echoes) {
        let mark = stairs.evidence().marks.iter().find(|m| m.echo == k);
        let role = mark
            .zip(winner)
            .map(|(m, w)| stairs.role(m, &w.chain, w.shape));
        let role = role.unwrap_or_default();
        observer.scatterer(&Scatterer { echo, role });
    }
    observer.hypothesis(&Hypothesis {
        explanation: Explanation::NoStairs,
        faces: &[],
        score: 0.0,
        winner: winner.is_none(),
    });
    for flight in search.leaders() {
        observer.hypothesis(&Hypothesis {
            explanation: S::explanation(flight.shape),
            faces: &flight.chain,
            score: flight.score,
            winner: winner.is_some_and(|w| w.chain.len() == flight.chain.len()),
        });
    }
}
