//! Score of a flight going up: risers of equal height one behind the other, closed or open.

use super::roles::{Riser, Roles};
use super::scene::{MAX_COLUMNS, Mark, Scene};
use super::stairs::{Flight, FlightShape};
use crate::estimate::Estimate;
use crate::infer::gauss::TreadLevels;
use crate::math;
use crate::observer::trace::{ChainLink, Role};
use crate::params::posterior::Limits;
use crate::signal::echoes::MAX_ECHOES;
use core::cell::RefCell;
use core::ops::Range;

/// Riser heights of the search, metres: spaced closer than the accuracy of an echo's height, from a kerb to the
/// highest riser that is built.
const RISES_M: [f32; 11] = [
    0.07, 0.09, 0.11, 0.13, 0.15, 0.17, 0.19, 0.21, 0.235, 0.26, 0.29,
];
/// Offsets from the best flight's riser height at which its likelihood is evaluated, metres: three times finer than
/// [`RISES_M`], over one and a half of its steps to each side.
const FINE_RISES_M: [f32; 11] = [
    -0.030, -0.024, -0.018, -0.012, -0.006, 0.0, 0.006, 0.012, 0.018, 0.024, 0.030,
];

/// Returns riser `k` of a chain of faces, whose foot and top are at heights `levels_m`, metres above the ground.
fn riser_between(chain: &[ChainLink], open: bool, k: usize, levels_m: Limits) -> Riser {
    let at = |k: usize| chain.get(k).map(|l| l.along_m);
    Riser {
        previous_m: k.checked_sub(1).and_then(at),
        along_m: at(k).unwrap_or(f32::INFINITY),
        base_m: levels_m.low,
        top_m: levels_m.high,
        open,
    }
}

/// Returns riser `k`, counted from 0, of a flight of regular rises.
pub fn riser(chain: &[ChainLink], shape: FlightShape, k: usize) -> Riser {
    let base_m = k as f32 * shape.rise_m;
    riser_between(
        chain,
        shape.open,
        k,
        Limits::new(base_m, base_m + shape.rise_m),
    )
}

/// Returns riser `k`, counted from 0, of a chain of faces whose treads have the heights `levels`; behind its last
/// riser, the landing.
pub fn riser_at(chain: &[ChainLink], open: bool, levels: &TreadLevels, k: usize) -> Riser {
    let level = |k: usize| levels.get(k).map(|l| l.height.value);
    let base_m = k.checked_sub(1).and_then(level).unwrap_or(0.0);
    let top_m = chain.get(k).and(level(k)).unwrap_or(base_m);
    riser_between(chain, open, k, Limits::new(base_m, top_m))
}

/// Returns the index of the riser that a mark (an echo in the search) lies near or before; beyond the last riser, that
/// of the landing. `column_m` is the half-width of a riser's column of echoes, metres.
pub fn riser_of(m: &Mark, chain: &[ChainLink], column_m: f32) -> usize {
    let behind = |l: &&ChainLink| l.along_m < m.x_m - column_m;
    chain.iter().take_while(behind).count()
}

/// Returns the role of each mark (an echo in the search), in the marks' order, under a flight whose treads have the
/// heights `levels`.
pub fn roles_by(scene: &Scene<'_>, flight: &Flight, levels: &TreadLevels) -> Roles {
    let mut roles = Roles::new();
    for m in &scene.marks {
        let k = riser_of(m, &flight.chain, scene.params.column_m);
        let riser = riser_at(&flight.chain, flight.shape.open, levels, k);
        // Cannot fail: there is one role for each mark.
        let _ = roles.push(scene.role(m, &riser));
    }
    roles
}

/// Score of the tread before a riser.
#[derive(Clone, Copy, Debug, Default)]
struct TreadScore {
    /// Search score of the marks (echoes) on the tread, nats.
    score: f32,
    /// SNR of the strongest echo on the tread near the riser, dB.
    strongest_db: f32,
}

/// Indices that divide the marks, which are sorted by distance, into those on the tread before a riser, near it, and
/// behind it.
#[derive(Clone, Copy, Debug, Default)]
struct Span {
    /// First mark that does not lie on the tread before the riser.
    before: u8,
    /// First mark near the riser.
    first: u8,
    /// First mark on the next tread.
    end: u8,
}

const _: () = assert!(MAX_ECHOES <= u8::MAX as usize);

impl Span {
    fn of(scene: &Scene<'_>, along_m: f32) -> Self {
        let (first, end) = scene.near_range(along_m);
        let before = scene.first_beyond(along_m - scene.params.column_m);
        Self {
            before: before as u8,
            first: first as u8,
            end: end as u8,
        }
    }
}

/// Evaluator of the scores of flights going up, on the echoes of one scan.
#[derive(Debug)]
pub struct Ascending<'e> {
    scene: &'e Scene<'e>,
    /// Indices of the marks near each column.
    spans: [Span; MAX_COLUMNS],
    /// Score of the floor before each column, which is the same for every first riser there.
    floors: [TreadScore; MAX_COLUMNS],
    /// Cache of the landing's score, at the height above the ground that was evaluated last.
    landing: RefCell<Landing>,
    null: f32,
}

/// Cache of the scores of landings at one height above the ground, by the mark (echo) with which they begin.
#[derive(Debug)]
struct Landing {
    level_m: f32,
    open: bool,
    /// Entry k is the score of all marks from index k on, nats; the last one is 0.
    sums: [f32; MAX_ECHOES + 1],
    /// First entry of `sums` that is valid.
    known: usize,
}

impl Default for Landing {
    fn default() -> Self {
        Self {
            level_m: 0.0,
            open: false,
            sums: [0.0; MAX_ECHOES + 1],
            known: usize::MAX,
        }
    }
}

impl Landing {
    /// Returns the score, nats, of the landing behind the last riser of a flight, from mark `first` on. It returns none
    /// where the riser's place decides which echoes of the landing are visible.
    fn look_up(
        &mut self,
        scene: &Scene<'_>,
        first: usize,
        level_m: f32,
        open: bool,
    ) -> Option<f32> {
        if level_m >= scene.mount_height_m {
            return None;
        }
        let marks = scene.marks.len();
        if self.level_m != level_m || self.open != open || self.known > marks {
            (self.level_m, self.open, self.known) = (level_m, open, marks);
            *self.sums.get_mut(marks)? = 0.0;
        }
        if first < self.known {
            self.extend(scene, first..self.known);
            self.known = first;
        }
        self.sums.get(first).copied()
    }

    /// Fills the sums of `range` from its last mark to its first; the sums behind it are valid.
    fn extend(&mut self, scene: &Scene<'_>, range: Range<usize>) {
        let landing = Riser::landing(None, self.level_m, self.open);
        let mut sum = self.sums.get(range.end).copied().unwrap_or(0.0);
        let marks = scene.marks.get(range.clone()).unwrap_or(&[]);
        let places = self.sums.get_mut(range).unwrap_or(&mut []);
        for (place, mark) in places.iter_mut().zip(marks).rev() {
            sum += scene.on_tread(mark, &landing).1;
            *place = sum;
        }
    }
}

impl<'e> Ascending<'e> {
    /// Returns the evaluator, with the score of level ground and, for each column, its marks and the score of the floor
    /// before it.
    #[inline(never)]
    pub fn new(scene: &'e Scene<'e>) -> Self {
        let mut ascending = Self {
            scene,
            spans: [Span::default(); MAX_COLUMNS],
            floors: [TreadScore::default(); MAX_COLUMNS],
            landing: RefCell::new(Landing::default()),
            null: scene.level_ground_score(),
        };
        let nearest = scene.first_beyond(scene.params.nearest_riser_m);
        for (k, column) in scene.columns.iter().enumerate() {
            let span = Span::of(scene, column.along_m);
            let riser = Riser {
                along_m: column.along_m,
                ..Riser::landing(None, 0.0, false)
            };
            let floor = ascending.tread(&riser, nearest..usize::from(span.before));
            let places = ascending.floors.get_mut(k).zip(ascending.spans.get_mut(k));
            if let Some(place) = places {
                (*place.0, *place.1) = (floor, span);
            }
        }
        ascending
    }

    /// Returns the indices of the marks near a riser.
    fn span(&self, link: &ChainLink) -> Span {
        let known = link.column.and_then(|c| self.spans.get(usize::from(c)));
        known
            .copied()
            .unwrap_or_else(|| Span::of(self.scene, link.along_m))
    }

    /// Returns the tread before a riser, or the landing, scored over the marks of `range`.
    fn tread(&self, riser: &Riser, range: Range<usize>) -> TreadScore {
        let (scene, p) = (self.scene, self.scene.params);
        let (mut total, mut strongest_db) = (0.0, p.tread_background_db);
        for m in scene.marks.get(range).unwrap_or(&[]) {
            let (role, gain) = scene.on_tread(m, riser);
            total += gain;
            let on_level = (m.y_m - riser.base_m).abs() < 2.0 * m.y_sigma_m;
            if role == Role::Tread && on_level && m.x_m > riser.along_m - p.corner_before_m {
                strongest_db = math::max(strongest_db, m.snr_db);
            }
        }
        TreadScore {
            score: total,
            strongest_db,
        }
    }

    /// Returns the score of one riser with `marks` near it and the tread `before` it, nats.
    fn riser(&self, riser: &Riser, marks: &[Mark], before: TreadScore) -> f32 {
        let (scene, p) = (self.scene, self.scene.params);
        let mut total = before.score - p.step_nats;
        // Only the best echo in each role counts.
        let (mut corner, mut top, mut edge) = (0.0f32, 0.0f32, 0.0f32);
        let mut corner_db = f32::NEG_INFINITY;
        for m in marks {
            let fit = scene.on_riser(m, riser);
            edge = math::max(edge, fit.edge);
            if let Some((_, gain)) = fit.other {
                total += gain;
            } else if fit.corner > fit.top && fit.corner > corner {
                corner = fit.corner;
                corner_db = m.snr_db;
            } else if fit.top > top {
                top = fit.top;
            } else if fit.corner <= 0.0 && fit.top <= 0.0 {
                total -= p.stray_nats * m.credibility;
            }
        }
        let corner_shows = !riser.open && !scene.hides_foot(riser);
        if corner_shows && corner < p.seen_nats {
            total -= p.no_corner_nats;
        }
        if edge < p.seen_nats {
            total -= p.no_edge_nats;
        }
        if corner > p.seen_nats && corner_db > before.strongest_db + p.corner_outshines_db {
            total += p.bright_corner_nats;
        }
        total + corner + top
    }

    /// Returns the cost, nats, of a landing between the chain and a face `next`; 0 without one. A single riser behind a
    /// landing is usually a wall and costs more; a second riser behind it refunds the difference.
    fn landing_cost(&self, chain: &[ChainLink], next: ChainLink) -> f32 {
        let p = self.scene.params;
        let behind_landing = |a: &ChainLink, b: &ChainLink| b.along_m - a.along_m > p.most_going_m;
        match chain {
            [.., last] if behind_landing(last, &next) => p.lone_nats,
            [.., before, last] if behind_landing(before, last) => -p.lone_nats,
            _ => 0.0,
        }
    }

    /// Returns the riser height of a flight's chain averaged over its likelihood, metres, and the highest score, nats.
    #[inline(never)]
    pub fn rise(&self, flight: &Flight) -> (Estimate, f32) {
        let shape = flight.shape;
        let at = |offset: f32| {
            let rise_m = shape.rise_m + offset;
            self.whole(&flight.chain, FlightShape { rise_m, ..shape })
        };
        let scores = FINE_RISES_M.map(at);
        let top = scores.iter().copied().fold(f32::NEG_INFINITY, math::max);
        let (mut sum, mut mean, mut square) = (0.0, 0.0, 0.0);
        for (score, offset) in scores.iter().zip(FINE_RISES_M) {
            let weight = math::exp(score - top);
            sum += weight;
            mean += weight * offset;
            square += weight * offset * offset;
        }
        mean /= sum;
        let rise = Estimate {
            value: shape.rise_m + mean,
            variance: math::max(square / sum - mean * mean, 0.0),
        };
        (rise, top)
    }
}

impl Ascending<'_> {
    /// Returns the marks and columns that are evaluated.
    pub fn scene(&self) -> &Scene<'_> {
        self.scene
    }

    /// Returns the index of each column at which a flight may begin, with each shape: riser height, open or closed.
    pub fn beginnings(&self) -> impl Iterator<Item = (usize, FlightShape)> {
        let shapes = RISES_M.into_iter();
        let shapes =
            shapes.flat_map(|rise_m| [false, true].map(|open| FlightShape { rise_m, open }));
        // Grouped by shape, so that the landing's score is cached for flights of one level.
        shapes.flat_map(|shape| {
            let columns = self.scene.columns.iter().enumerate();
            columns
                .filter(|(_, column)| column.begins)
                .map(move |(k, _)| (k, shape))
        })
    }

    /// Returns the score that face `next`, with the tread before it, adds to the chain, nats.
    pub fn face(&self, chain: &[ChainLink], next: ChainLink, shape: FlightShape) -> f32 {
        let riser = Riser {
            along_m: next.along_m,
            ..riser(chain, shape, chain.len())
        };
        let span = self.span(&next);
        let floor = next.column.filter(|_| chain.is_empty());
        let floor = floor.and_then(|c| self.floors.get(usize::from(c)));
        let before = floor.copied().unwrap_or_else(|| {
            let from = match chain.last() {
                Some(last) => usize::from(self.span(last).end),
                None => (self.scene).first_beyond(self.scene.params.nearest_riser_m),
            };
            self.tread(&riser, from..usize::from(span.before))
        });
        let near = usize::from(span.first)..usize::from(span.end);
        let near = self.scene.marks.get(near).unwrap_or(&[]);
        self.riser(&riser, near, before) - self.landing_cost(chain, next)
    }

    /// Returns the score of the echoes behind the last face of a chain, nats.
    pub fn behind(&self, chain: &[ChainLink], shape: FlightShape) -> f32 {
        let Some(last) = chain.last() else { return 0.0 };
        let level_m = chain.len() as f32 * shape.rise_m;
        let first = usize::from(self.span(last).end);
        let cache = self.landing.try_borrow_mut();
        let cached = cache
            .ok()
            .and_then(|mut cache| cache.look_up(self.scene, first, level_m, shape.open));
        let landing = Riser::landing(Some(last.along_m), level_m, shape.open);
        let marks = first..self.scene.marks.len();
        cached.unwrap_or_else(|| self.tread(&landing, marks).score)
    }

    /// Returns the search's score of level ground, from which the scores of flights count, nats.
    pub fn null(&self) -> f32 {
        self.null
    }

    /// Returns the role of a mark (an echo in the search) under the flight with these faces, riser height and build
    /// (open or closed).
    pub fn role(&self, mark: &Mark, chain: &[ChainLink], shape: FlightShape) -> Role {
        let k = riser_of(mark, chain, self.scene.params.column_m);
        self.scene.role(mark, &riser(chain, shape, k))
    }

    /// Returns the score of the whole flight with these faces, riser height and build, less that of level ground, nats.
    pub fn whole(&self, chain: &[ChainLink], shape: FlightShape) -> f32 {
        let faces = (0..chain.len()).filter_map(|k| {
            let (before, rest) = chain.split_at_checked(k)?;
            Some(self.face(before, *rest.first()?, shape))
        });
        faces.sum::<f32>() + self.behind(chain, shape) - self.null()
    }
}
