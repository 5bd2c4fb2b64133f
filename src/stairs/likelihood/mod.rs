//! The default estimator: scatterers found by matched filter and particles, staircases weighed by
//! likelihood.
//!
//! | module | does |
//! |---|---|
//! | `beam` | matched filter along the angle, row by row |
//! | `candidate` | its local maxima, row by row |
//! | `noise` | noise and side-lobe level |
//! | `echo` | drops what noise or a stronger echo could have made |
//! | `scatterer` | a mode of particles for each: sub-cell place and covariance |
//! | `calibrate` | angle bias and mount height from the floor |
//! | `evidence` | columns of echoes, credibility |
//! | `role` | likelihood of a riser, a tread, a ramp |
//! | `search` | the best flight |
//! | `ascent`, `descent` | its dimensions |

// The stages are `inline(never)`: each has its working memory on a stack of 16 KB, and merged into
// one function they would hold all of it at the same time.

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
use echo::{Echo, MAX_ECHOES};
use evidence::{Evidence, Mark};
use search::{Beams, Flight, Search, Stairs};
use trace::{Explanation, Hypothesis, Observer, Scatterer, Stage};

use super::map::{Geometry, PolarMap};
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

/// The estimator: what it keeps during a scan, and after the last row the search's memory in the
/// same place.
#[derive(Debug)]
pub struct Likelihood(Phase);

#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "one after the other in the same memory is the point"
)]
enum Phase {
    Rows(Rows),
    Up(Beams<ascent::Shape>),
    Down(Beams<descent::Shape>),
}

/// What is worked out row by row.
#[derive(Debug)]
struct Rows {
    filter: beam::BeamFilter,
    finder: candidate::CandidateFinder,
    noise: noise::NoiseSamples,
    fed: usize,
    reversed: bool,
    /// Maxima below are not looked for.
    least: u16,
}

impl Default for Likelihood {
    fn default() -> Self {
        Self::new()
    }
}

impl Likelihood {
    /// Before the first scan.
    pub const fn new() -> Self {
        Self(Phase::Rows(Rows::new()))
    }

    /// Ready for the first row of the scan that `map` has been shaped for.
    pub fn begin(&mut self, map: &PolarMap) {
        if !matches!(self.0, Phase::Rows(_)) {
            *self = Self::new();
        }
        if let Phase::Rows(rows) = &mut self.0 {
            rows.begin(map);
        }
    }

    /// Takes in row `k` of the map. Rows come one after the other from either end; one whose chirp
    /// was lost comes too, empty as it is.
    pub fn row(&mut self, map: &PolarMap, k: usize) {
        if let Phase::Rows(rows) = &mut self.0 {
            rows.row(map, k);
        }
    }

    /// The answer, after the last row.
    pub fn finish(&mut self, map: &PolarMap, config: &Config, scan: u32) -> Outcome {
        self.finish_observed(map, config, scan, &mut ())
    }

    /// [`Likelihood::finish`], telling `observer` what it thinks.
    #[inline(never)]
    pub fn finish_observed(
        &mut self,
        map: &PolarMap,
        config: &Config,
        scan: u32,
        observer: &mut impl Observer,
    ) -> Outcome {
        let Phase::Rows(rows) = &mut self.0 else {
            return Outcome::fault(Reason::Silent);
        };
        let mut echoes = rows.echoes(map, config, scan, observer);
        let geometry = map.geometry();
        self.0 = match geometry.plane {
            Plane::Depth => Phase::Up(Beams::new()),
            Plane::Height => Phase::Down(Beams::new()),
        };
        let outcome = match &mut self.0 {
            Phase::Up(beams) => ascend(&mut echoes, geometry, beams, observer),
            Phase::Down(beams) => descend(&echoes, geometry, beams, observer),
            Phase::Rows(_) => Outcome::fault(Reason::Silent),
        };
        observer.done(Stage::Dimensions);
        if echoes.iter().any(|e| e.db >= SURE_DB) {
            outcome
        } else {
            Outcome::fault(Reason::NoEcho)
        }
    }
}

impl Rows {
    const fn new() -> Self {
        Self {
            filter: beam::BeamFilter::new(),
            finder: candidate::CandidateFinder::new(),
            noise: noise::NoiseSamples::new(),
            fed: 0,
            reversed: false,
            least: 0,
        }
    }

    fn begin(&mut self, map: &PolarMap) {
        self.filter.begin(map.geometry());
        self.finder.begin();
        self.noise.begin();
        self.fed = 0;
        self.reversed = false;
        self.least = 0;
    }

    fn row(&mut self, map: &PolarMap, k: usize) {
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
        if place(centre).checked_rem(spacing) == Some(spacing / 2) {
            let levels = levels.get(..map.bins()).unwrap_or(&[]);
            self.noise.add(levels, self.filter.gain());
        }
        let middle = centre
            .checked_sub(candidate::MIDDLE)
            .map(|m| place(m) as u16);
        self.finder.advance(map.bins(), middle, self.least);
    }

    /// What a scatterer of its own explains, after the last row; the noise goes to `observer`.
    fn echoes(
        &mut self,
        map: &PolarMap,
        config: &Config,
        scan: u32,
        observer: &mut impl Observer,
    ) -> heapless::Vec<Echo, MAX_ECHOES> {
        let end = if self.reversed {
            0
        } else {
            map.rows().saturating_sub(1)
        };
        // What noise makes need not be looked for now that there is no time left; the last sample
        // of it, still to come, moves the noise by less than the decibel that is left to it.
        const STILL_TO_COME_DB: f32 = 1.0;
        if let Some(noise) = self.noise.median() {
            self.least = echo::least(noise, self.filter.gain(), STILL_TO_COME_DB);
        }
        // What lies beyond the last row is taken to be like it.
        for _ in 0..self.filter.lag() {
            self.push(map, map.row(end));
        }
        observer.done(Stage::Rows);
        let mut floors = [0; MAX_BINS];
        let noise = self.noise.medians(&mut floors);
        observer.noise(noise);
        let background = echo::Background {
            floors: &floors,
            noise,
            gain: self.filter.gain(),
        };
        let seed = u64::from(config.seed) << 32 | u64::from(scan);
        let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed);
        let candidates = self
            .finder
            .sorted(echo::least(noise, self.filter.gain(), 0.0));
        echo::select(map, candidates, &background, config, &mut rng, observer)
    }
}

/// The best stairs going up, if they explain the echoes better than everything else.
#[inline(never)]
fn ascend(
    echoes: &mut [Echo],
    geometry: &Geometry,
    beams: &mut Beams<ascent::Shape>,
    observer: &mut impl Observer,
) -> Outcome {
    let found = calibrate::calibrate(echoes, geometry);
    observer.calibration(found.bias_rad, found.height_m);
    let mut evidence = Evidence::new(geometry.mount_height_m);
    evidence.risers(echoes);
    let evidence = &evidence;
    let ascent = Ascent::new(evidence);
    let mut search = Search::new(&ascent);
    let best = search.best(beams).map(|mut flight| {
        let (rise, score) = ascent.rise(&flight);
        flight.score = score;
        (flight, rise)
    });
    observer.done(Stage::Search);
    let winner = best
        .as_ref()
        .filter(|(flight, _)| flight.score >= ACCEPT_UP);
    tell(&search, winner.map(|w| &w.0), echoes, observer);
    let sized = winner.map(|(f, rise)| dimension::ascending(evidence, f, *rise, found.bias_sigma));
    conclude(&search, best.as_ref().map(|b| &b.0), sized, ACCEPT_UP)
}

/// The same for stairs going down.
#[inline(never)]
fn descend(
    echoes: &[Echo],
    geometry: &Geometry,
    beams: &mut Beams<descent::Shape>,
    observer: &mut impl Observer,
) -> Outcome {
    let mut evidence = Evidence::new(geometry.mount_height_m);
    evidence.treads(echoes);
    let evidence = &evidence;
    let descent = Descent::new(evidence);
    let mut search = Search::new(&descent);
    let best = search.best(beams);
    observer.done(Stage::Search);
    let winner = best.as_ref().filter(|flight| flight.score >= ACCEPT_DOWN);
    tell(&search, winner, echoes, observer);
    let sized = winner.map(|flight| dimension::descending(&descent, flight));
    conclude(&search, best.as_ref(), sized, ACCEPT_DOWN)
}

/// The outcome and what it is worth: of a flight that was accepted and sized, or of none.
#[inline(never)]
fn conclude<S: Stairs>(
    search: &Search<'_, S>,
    best: Option<&Flight<S::Shape>>,
    sized: Option<Sized>,
    accept: f32,
) -> Outcome {
    let marks = &search.stairs().evidence().marks;
    match (best, sized) {
        (Some(best), Some(mut sized)) if !sized.supports.is_empty() => {
            let role = |m: &Mark| search.stairs().role(m, &best.chain, best.shape);
            let against = marks
                .iter()
                .filter(|m| doubt::in_the_way(m) && role(m).contradicts());
            let lead = best.score - search.rival(best.chain.len()).max(accept);
            doubt::judge(&mut sized.outcome, lead, &sized.supports, against.count());
            sized.outcome
        }
        (best, sized) => {
            // A flight that was accepted and then found to be a box or a threshold is no rival.
            let score = best.filter(|_| sized.is_none()).map(|b| b.score - accept);
            let strongest = marks.iter().map(|m| m.db).fold(0.0, f32::max);
            let mut outcome = sized.map_or(Outcome::clear(), |s| s.outcome);
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
    if !observer.listens() {
        return;
    }
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
