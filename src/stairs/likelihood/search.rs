//! The search for the best flight among the columns: riser by riser, a bounded number of
//! beginnings kept.
//!
//! A flight's score is a sum over its risers plus what lies behind the last one, so every beginning
//! is scored once, whatever follows. Beginnings grow by one riser (or by two, the nearer one
//! inferred) at a time; after each round only the best [`BEAM`] go on. What a flight would score if
//! it ended here needs the landing behind it: that depends on the column and the level alone and is
//! summed up once for each level. Worst case: [`MAX_COLUMNS`] x 24 first risers, then [`BEAM`] x
//! ([`MAX_COLUMNS`] + 8 x 2) further ones.

use super::evidence::{Evidence, MAX_COLUMNS};
use super::role::{Riser, irregularity};
use crate::math;
use heapless::Vec;

/// Most risers of a flight.
pub const MAX_FLIGHT: usize = 10;
/// Beginnings that are followed at a time.
const BEAM: usize = 32;
/// Distance from riser to riser in stairs that people use, metres.
const GOING: core::ops::RangeInclusive<f32> = 0.20..=0.44;
/// A riser may stand this far from where its predecessors lead, metres.
const TOLERANCE: f32 = 0.045;
/// A column's weight that makes up for standing 5 cm off that place.
const OFF_PLACE: f32 = 20.0;
/// What stands farther behind the last riser is no part of the flight, metres.
const LANDING: f32 = 0.55;
/// Heights of single things too tall to climb, metres.
const TALL: [f32; 9] = [0.25, 0.28, 0.32, 0.36, 0.40, 0.46, 0.55, 0.7, 2.0];
/// Riser heights tried, metres: closer together than an echo's height is known.
const RISES: [f32; 8] = [0.07, 0.09, 0.11, 0.13, 0.15, 0.17, 0.19, 0.21];
/// Riser heights around the winner's at which its likelihood is looked at.
const FINE: [f32; 11] = [
    -0.030, -0.024, -0.018, -0.012, -0.006, 0.0, 0.006, 0.012, 0.018, 0.024, 0.030,
];

/// One riser of a chain: its place, and the column that shows it unless it is inferred.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Link {
    /// Horizontal distance, metres.
    pub x: f32,
    /// Index of the column.
    pub column: Option<u8>,
}

/// Risers one behind the other.
pub type Chain = Vec<Link, MAX_FLIGHT>;

/// A flight, or the beginning of one.
#[derive(Clone, Debug, Default)]
pub struct Flight {
    /// Its risers.
    pub chain: Chain,
    /// Height of one riser, metres.
    pub rise: f32,
    /// Variance of the riser height over the likelihood, m².
    pub rise_variance: f32,
    /// Whether there is nothing below the treads.
    pub open: bool,
    /// Log-likelihood of its risers and treads.
    risers: f32,
    /// Log-likelihood ratio of the whole against everything that is no stair.
    pub score: f32,
}

/// The search's state.
#[derive(Debug)]
pub struct Search<'e> {
    evidence: &'e Evidence,
    /// Per column: by how much one tall thing there explains more than a ramp.
    tall: [f32; MAX_COLUMNS],
    /// Score of the best explanation without stairs.
    pub null: f32,
    /// Number of risers scored.
    pub scored: u32,
}

/// The best beginnings so far.
type Beam = Vec<Flight, BEAM>;

impl<'e> Search<'e> {
    /// Scores everything that is no stair.
    pub fn new(evidence: &'e Evidence) -> Self {
        let ramp = evidence.best_ramp();
        let mut search = Self {
            evidence,
            tall: [0.0; MAX_COLUMNS],
            null: ramp,
            scored: 0,
        };
        let mut best = 0f32;
        for rise in TALL {
            for open in [false, true] {
                for k in 0..evidence.columns.len() {
                    let gain = search.first(k, rise, open).score;
                    search.tall[k] = search.tall[k].max(gain);
                    best = best.max(gain);
                }
            }
        }
        search.null += best;
        search
    }

    /// The flight of one riser of height `rise` at a column.
    fn first(&mut self, column: usize, rise: f32, open: bool) -> Flight {
        let mut flight = Flight {
            rise,
            open,
            ..Flight::default()
        };
        self.step(&mut flight, self.link(column));
        flight.score = self.close(&flight);
        flight
    }

    fn link(&self, column: usize) -> Link {
        let x = self.evidence.columns.get(column).map_or(0.0, |c| c.x);
        Link {
            x,
            column: Some(column as u8),
        }
    }

    /// What a tall thing behind a flight that ends at `x` may explain of the rest.
    fn wall_behind(&self, x: f32) -> f32 {
        let columns = self.evidence.columns.iter().zip(&self.tall);
        columns
            .filter(|(c, _)| c.x > x + LANDING)
            .map(|(_, &g)| g)
            .fold(0.0, f32::max)
    }

    /// Puts one more riser on a flight; its score then lacks what lies behind.
    fn step(&mut self, flight: &mut Flight, link: Link) {
        self.scored += 1;
        let k = flight.chain.len() as f32;
        let previous_x = flight.chain.last().map(|l| l.x);
        flight.risers += self.evidence.riser(&Riser {
            previous_x,
            x: link.x,
            base: k * flight.rise,
            top: (k + 1.0) * flight.rise,
            open: flight.open,
        });
        if let [.., a, b] = flight.chain.as_slice() {
            flight.risers -= irregularity(a.x, b.x, link.x);
        }
        // Callers leave room.
        let _ = flight.chain.push(link);
    }

    /// Log-likelihood ratio of the flight if it ends here.
    fn close(&self, flight: &Flight) -> f32 {
        let Some(last) = flight.chain.last() else {
            return 0.0;
        };
        let level = flight.chain.len() as f32 * flight.rise;
        let landing = self.evidence.landing(Some(last.x), level, flight.open);
        flight.risers + landing + self.wall_behind(last.x) - self.null
    }

    /// The best flight.
    pub fn best(&mut self) -> Option<Flight> {
        let mut best: Option<Flight> = None;
        let mut beam = Beam::new();
        let columns = self.evidence.columns.len();
        for rise in RISES {
            for open in [false, true] {
                for k in 0..columns {
                    let flight = self.first(k, rise, open);
                    keep(&mut beam, flight);
                }
            }
        }
        while !beam.is_empty() {
            let leader = beam.iter().max_by(|a, b| a.score.total_cmp(&b.score));
            if let Some(leader) = leader
                && best.as_ref().is_none_or(|b| leader.score > b.score)
            {
                best = Some(leader.clone());
            }
            let mut next = Beam::new();
            for flight in &beam {
                self.grow(flight, &mut next);
            }
            beam = next;
        }
        let mut best = best?;
        self.refine(&mut best);
        Some(best)
    }

    /// Follows a flight to its next risers.
    fn grow(&mut self, flight: &Flight, next: &mut Beam) {
        let [first, rest @ ..] = flight.chain.as_slice() else {
            return;
        };
        let Some(last) = rest.last() else {
            // The second riser fixes the direction: any column that stairs may have there.
            for c in 0..self.evidence.columns.len() {
                let link = self.link(c);
                for skipped in [0usize, 1] {
                    let going = (link.x - first.x) / (skipped + 1) as f32;
                    if GOING.contains(&going) {
                        self.grow_to(flight, link, going, skipped, next);
                    }
                }
            }
            return;
        };
        let going = (last.x - first.x) / rest.len() as f32;
        for skipped in [0usize, 1] {
            let aim = last.x + (skipped + 1) as f32 * going;
            if let Some(c) = self.near(aim) {
                let link = self.link(c);
                let going = (link.x - last.x) / (skipped + 1) as f32;
                self.grow_to(flight, link, going, skipped, next);
                break;
            }
        }
    }

    /// Adds `link`, and `skipped` risers before it, to a copy of the flight.
    fn grow_to(
        &mut self,
        flight: &Flight,
        link: Link,
        going: f32,
        skipped: usize,
        next: &mut Beam,
    ) {
        if flight.chain.len() + skipped >= MAX_FLIGHT {
            return;
        }
        let mut flight = flight.clone();
        for k in 0..skipped {
            let x = link.x - (skipped - k) as f32 * going;
            // The riser between may have a column near where it should stand.
            let between = self
                .near(x)
                .map_or(Link { x, column: None }, |c| self.link(c));
            self.step(&mut flight, between);
        }
        self.step(&mut flight, link);
        flight.score = self.close(&flight);
        keep(next, flight);
    }

    /// The weightiest column within the tolerance of `x`.
    fn near(&self, x: f32) -> Option<usize> {
        let columns = self.evidence.columns.iter().enumerate();
        let near = columns.filter(|(_, c)| (c.x - x).abs() < TOLERANCE);
        let key = |weight: f32, at: f32| weight - OFF_PLACE * (at - x).abs();
        near.max_by(|(_, a), (_, b)| key(a.weight, a.x).total_cmp(&key(b.weight, b.x)))
            .map(|(k, _)| k)
    }

    /// Mean and variance of the winner's riser height over its likelihood.
    fn refine(&mut self, best: &mut Flight) {
        let mut scores = [0f32; FINE.len()];
        for (score, offset) in scores.iter_mut().zip(FINE) {
            let mut flight = Flight {
                rise: best.rise + offset,
                open: best.open,
                ..Flight::default()
            };
            for &link in &best.chain {
                self.step(&mut flight, link);
            }
            *score = self.close(&flight);
        }
        let top = scores.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let (mut sum, mut mean, mut square) = (0.0, 0.0, 0.0);
        for (score, offset) in scores.iter().zip(FINE) {
            let p = math::exp(score - top);
            sum += p;
            mean += p * offset;
            square += p * offset * offset;
        }
        mean /= sum;
        best.score = top;
        best.rise += mean;
        best.rise_variance = (square / sum - mean * mean).max(0.0);
    }
}

/// Adds a flight to the beam, in place of the worst if there is no room.
fn keep(beam: &mut Beam, flight: Flight) {
    if let Err(flight) = beam.push(flight) {
        let worst = beam.iter_mut().min_by(|a, b| a.score.total_cmp(&b.score));
        if let Some(worst) = worst
            && worst.score < flight.score
        {
            *worst = flight;
        }
    }
}
