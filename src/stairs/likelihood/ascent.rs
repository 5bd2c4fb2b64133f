//! Stairs going up, as the search sees them: risers one behind the other, each as high as the
//! others, closed or floating; and what else could stand there.

use super::echo::MAX_ECHOES;
use super::evidence::{COLUMN, Evidence, MAX_COLUMNS, Mark};
use super::levels::Reading;
use super::role::{Before, Riser, Role, irregularity};
use super::search::Flight;
use super::search::{Link, Stairs};
use super::trace::Explanation;
use crate::math;
use core::cell::RefCell;

/// What stands farther behind the last riser is no part of the flight, metres.
const LANDING: f32 = 0.55;
/// Heights of single things too tall to climb, metres.
const TALL: [f32; 6] = [0.25, 0.30, 0.36, 0.43, 0.60, 2.0];
/// Floating stairs are rarer than closed ones, nats: legs and boxes pass for a single floating
/// step, so it takes more than one to be believed.
const FLOATING: f32 = 3.0;
/// Riser heights tried, metres: closer together than an echo's height is known.
const RISES: [f32; 8] = [0.07, 0.09, 0.11, 0.13, 0.15, 0.17, 0.19, 0.21];
/// Riser heights around the winner's at which its likelihood is looked at.
const FINE: [f32; 11] = [
    -0.030, -0.024, -0.018, -0.012, -0.006, 0.0, 0.006, 0.012, 0.018, 0.024, 0.030,
];

/// What two flights of the same risers may differ in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shape {
    /// Height of one riser, metres.
    pub rise: f32,
    /// Whether there is nothing below the treads.
    pub open: bool,
}

/// Stairs going up.
#[derive(Debug)]
pub struct Ascent<'e> {
    evidence: &'e Evidence,
    /// Per column: the floor before it, which is the same for every first riser there.
    floors: [Before; MAX_COLUMNS],
    /// What lies behind risers, at the level looked at last.
    landing: RefCell<Landing>,
    /// Per column: by how much one tall thing farther than a landing behind it explains more than a
    /// ramp.
    walls: [f32; MAX_COLUMNS],
    null: f32,
}

/// Scores of landings at one level, by where they begin.
#[derive(Debug)]
struct Landing {
    level: f32,
    open: bool,
    /// Entry k: of all marks from number k on …
    sums: [f32; MAX_ECHOES + 1],
    /// … as far as they have been asked for: from this one on.
    known: usize,
}

impl Default for Landing {
    fn default() -> Self {
        Self {
            level: 0.0,
            open: false,
            sums: [0.0; MAX_ECHOES + 1],
            known: usize::MAX,
        }
    }
}

impl Landing {
    /// Score of the landing behind the last riser of a flight; none where what is seen of it
    /// depends on where the riser stands.
    fn look_up(&mut self, evidence: &Evidence, x: f32, level: f32, open: bool) -> Option<f32> {
        if level >= evidence.mount_height {
            return None;
        }
        let marks = evidence.marks.len();
        if self.level != level || self.open != open || self.known > marks {
            (self.level, self.open, self.known) = (level, open, marks);
            *self.sums.get_mut(marks)? = 0.0;
        }
        let first = evidence.first_beyond(x + COLUMN);
        if first < self.known {
            evidence.landings(level, open, &mut self.sums, first..self.known);
            self.known = first;
        }
        self.sums.get(first).copied()
    }
}

impl<'e> Ascent<'e> {
    /// Scores everything that is no stair.
    pub fn new(evidence: &'e Evidence) -> Self {
        let ramp = evidence.best_ramp();
        let mut floors = [Before::default(); MAX_COLUMNS];
        for (floor, column) in floors.iter_mut().zip(&evidence.columns) {
            *floor = evidence.tread(&Riser {
                previous_x: None,
                x: column.along,
                base: 0.0,
                top: 0.0,
                open: false,
            });
        }
        let mut ascent = Self {
            evidence,
            floors,
            landing: RefCell::new(Landing::default()),
            walls: [0.0; MAX_COLUMNS],
            null: ramp,
        };
        let mut tall = [0f32; MAX_COLUMNS];
        // A post shows no corner, a box or a wall does.
        for rise in TALL {
            for open in [false, true] {
                let columns = tall.iter_mut().zip(&evidence.columns).enumerate();
                for (k, (gain, column)) in columns.filter(|(_, (_, c))| c.begins) {
                    let link = Link {
                        along: column.along,
                        column: Some(k as u8),
                    };
                    *gain = math::max(*gain, ascent.whole(&[link], Shape { rise, open }));
                }
            }
        }
        for (wall, column) in ascent.walls.iter_mut().zip(&evidence.columns) {
            let columns = evidence.columns.iter().zip(&tall);
            let behind = columns.filter(|(c, _)| c.along > column.along + LANDING);
            *wall = behind.map(|(_, &gain)| gain).fold(0.0, math::max);
        }
        ascent.null = ramp + tall.iter().copied().fold(0.0, math::max);
        ascent
    }

    /// Mean and standard deviation of the riser height over its likelihood, the chain given, and
    /// the highest score among them.
    pub fn rise(&self, flight: &Flight<Shape>) -> (Reading, f32) {
        let shape = flight.shape;
        let scores = FINE.map(|offset| {
            self.whole(
                &flight.chain,
                Shape {
                    rise: shape.rise + offset,
                    ..shape
                },
            )
        });
        let top = scores.iter().copied().fold(f32::NEG_INFINITY, math::max);
        let (mut sum, mut mean, mut square) = (0.0, 0.0, 0.0);
        for (score, offset) in scores.iter().zip(FINE) {
            let p = math::exp(score - top);
            sum += p;
            mean += p * offset;
            square += p * offset * offset;
        }
        mean /= sum;
        let value = shape.rise + mean;
        let sigma = math::sqrt(square / sum - mean * mean);
        (Reading { value, sigma }, top)
    }
}

impl Stairs for Ascent<'_> {
    type Shape = Shape;
    const SPACING: core::ops::RangeInclusive<f32> = 0.20..=0.44;
    const TOLERANCE: f32 = 0.045;
    const SHAPES: usize = 2 * RISES.len();

    fn evidence(&self) -> &Evidence {
        self.evidence
    }

    fn shape(&self, _first: Link, index: usize) -> Option<Shape> {
        let rise = *RISES.get(index / 2)?;
        let open = index % 2 == 1;
        Some(Shape { rise, open })
    }

    fn face(&self, chain: &[Link], next: Link, shape: Shape) -> f32 {
        let k = chain.len() as f32;
        let riser = Riser {
            previous_x: chain.last().map(|l| l.along),
            x: next.along,
            base: k * shape.rise,
            top: (k + 1.0) * shape.rise,
            open: shape.open,
        };
        let floor = next.column.filter(|_| chain.is_empty());
        let floor = floor.and_then(|c| self.floors.get(usize::from(c)));
        let before = floor
            .copied()
            .unwrap_or_else(|| self.evidence.tread(&riser));
        let gain = self.evidence.riser(&riser, before);
        match chain {
            [.., a, b] => gain - irregularity(a.along, b.along, next.along),
            [_] => gain,
            [] if shape.open => gain - FLOATING,
            [] => gain,
        }
    }

    fn behind(&self, chain: &[Link], shape: Shape) -> f32 {
        let Some(last) = chain.last() else { return 0.0 };
        let level = chain.len() as f32 * shape.rise;
        let cached = self
            .landing
            .try_borrow_mut()
            .ok()
            .and_then(|mut cache| cache.look_up(self.evidence, last.along, level, shape.open));
        let landing =
            cached.unwrap_or_else(|| self.evidence.landing(Some(last.along), level, shape.open));
        // Flights end at columns.
        let wall = last.column.and_then(|c| self.walls.get(usize::from(c)));
        landing + wall.copied().unwrap_or(0.0)
    }

    fn null(&self) -> f32 {
        self.null
    }

    fn role(&self, mark: &Mark, chain: &[Link], shape: Shape) -> Role {
        let k = chain
            .iter()
            .take_while(|l| l.along < mark.x - COLUMN)
            .count();
        let previous_x = k.checked_sub(1).and_then(|k| chain.get(k)).map(|l| l.along);
        let x = chain.get(k).map_or(f32::INFINITY, |l| l.along);
        let base = k as f32 * shape.rise;
        let riser = Riser {
            previous_x,
            x,
            base,
            top: base + shape.rise,
            open: shape.open,
        };
        self.evidence.role(mark, &riser, mark.x > x - COLUMN)
    }

    fn explanation(shape: Shape) -> Explanation {
        Explanation::Up {
            rise_m: shape.rise,
            open: shape.open,
        }
    }
}
