//! The search for the best flight among the columns: face by face, a bounded number of beginnings
//! kept.
//!
//! Going up, the faces that look at the mirror are risers one behind the other; going down they are
//! treads one below the other. [`Stairs`] knows the difference, the search does not. A flight's
//! score is a sum over its faces plus what lies behind the last one, so every beginning is scored
//! once, whatever follows. Beginnings grow by one face (or by two, the nearer one inferred) at a
//! time; after each round only the best [`BEAM`] go on.
//!
//! Worst case, in faces scored: columns × shapes at first, then [`BEAM`] × columns for the second
//! face, then [`BEAM`] × 2 for each further one.

use super::evidence::{Evidence, Mark};
use super::role::Role;
use super::trace::Explanation;
use crate::math;
use heapless::Vec;

/// Most faces of a flight.
pub const MAX_FLIGHT: usize = 10;
/// Beginnings that are followed at a time.
const BEAM: usize = 16;
/// A column's weight that makes up for standing 5 cm off its place.
const OFF_PLACE: f32 = 20.0;

/// One face of a chain: its place, and the column that shows it unless it is inferred.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Link {
    /// Along the line of sight, metres.
    pub along: f32,
    /// Index of the column.
    pub column: Option<u8>,
}

/// Faces one behind the other.
pub type Chain = Vec<Link, MAX_FLIGHT>;

/// A kind of stairs: how well a flight of it explains the echoes.
pub trait Stairs {
    /// What two flights of the same chain may differ in.
    type Shape: Copy + Default + core::fmt::Debug;
    /// Distance from face to face in stairs that people use, metres.
    const SPACING: core::ops::RangeInclusive<f32>;
    /// A face may stand this far from where its predecessors lead, metres.
    const TOLERANCE: f32;

    /// The echoes.
    fn evidence(&self) -> &Evidence;
    /// Number of shapes to try.
    const SHAPES: usize;

    /// Shape number `index` of those worth a try for a flight whose first face is `first`.
    fn shape(&self, first: Link, index: usize) -> Option<Self::Shape>;
    /// Log-likelihood that `next` adds to the chain.
    fn face(&self, chain: &[Link], next: Link, shape: Self::Shape) -> f32;
    /// Log-likelihood of everything behind the last face.
    fn behind(&self, chain: &[Link], shape: Self::Shape) -> f32;
    /// Log-likelihood of the best explanation without stairs.
    fn null(&self) -> f32;
    /// What a mark is taken for if the flight is true.
    fn role(&self, mark: &Mark, chain: &[Link], shape: Self::Shape) -> Role;
    /// The flight in words.
    fn explanation(shape: Self::Shape) -> Explanation;

    /// Log-likelihood ratio of a whole flight against everything that is no stair.
    fn whole(&self, chain: &[Link], shape: Self::Shape) -> f32 {
        let faces = (0..chain.len()).filter_map(|k| {
            let (before, rest) = chain.split_at_checked(k)?;
            Some(self.face(before, *rest.first()?, shape))
        });
        faces.sum::<f32>() + self.behind(chain, shape) - self.null()
    }
}

/// A flight, or the beginning of one.
#[derive(Debug, Default)]
pub struct Flight<S> {
    /// Its faces.
    pub chain: Chain,
    /// Its shape.
    pub shape: S,
    /// Log-likelihood of its faces.
    faces: f32,
    /// Log-likelihood ratio of the whole against everything that is no stair.
    pub score: f32,
}

impl<S: Copy + Default> Clone for Flight<S> {
    fn clone(&self) -> Self {
        let mut flight = Self::default();
        flight.copy(self);
        flight
    }
}

impl<S: Copy> Flight<S> {
    /// Becomes like another flight; only the faces that it has are copied.
    fn copy(&mut self, other: &Self) {
        self.chain.clear();
        // As many as there is room for.
        let _ = self.chain.extend_from_slice(&other.chain);
        (self.shape, self.faces, self.score) = (other.shape, other.faces, other.score);
    }
}

/// The best beginnings so far.
#[derive(Debug)]
struct Beam<S> {
    flights: Vec<Flight<S>, BEAM>,
    /// Once there is no more room: which is the worst.
    worst: usize,
}

impl<S: Copy + Default> Beam<S> {
    const fn new() -> Self {
        Self {
            flights: Vec::new(),
            worst: 0,
        }
    }

    /// Takes a flight in, in place of the worst if there is no room; not if it is no better.
    fn offer(&mut self, flight: &Flight<S>) {
        let taken = self.flights.len();
        let full = self.flights.push(Flight::default()).is_err();
        let place = if full { self.worst } else { taken };
        let Some(place) = self.flights.get_mut(place) else {
            return;
        };
        if full && place.score >= flight.score {
            return;
        }
        place.copy(flight);
        if self.flights.is_full() {
            let (mut worst, mut least) = (0, f32::INFINITY);
            for (k, flight) in self.flights.iter().enumerate() {
                if flight.score < least {
                    (worst, least) = (k, flight.score);
                }
            }
            self.worst = worst;
        }
    }
}

/// Working memory of a search: the beginnings that are followed, and those that they lead to. Too
/// large for a small stack, so it comes from outside.
#[derive(Debug)]
pub struct Beams<S> {
    now: Beam<S>,
    next: Beam<S>,
}

impl<S: Copy + Default> Beams<S> {
    /// Without beginnings.
    pub const fn new() -> Self {
        Self {
            now: Beam::new(),
            next: Beam::new(),
        }
    }
}

/// The search's state.
#[derive(Debug)]
pub struct Search<'s, S: Stairs> {
    stairs: &'s S,
    /// The best flight of each number of faces.
    leaders: Vec<Flight<S::Shape>, MAX_FLIGHT>,
}

impl<'s, S: Stairs> Search<'s, S> {
    /// A search among `stairs`.
    pub fn new(stairs: &'s S) -> Self {
        Self {
            stairs,
            leaders: Vec::new(),
        }
    }

    /// What is searched.
    pub fn stairs(&self) -> &'s S {
        self.stairs
    }

    /// The best flight of each number of faces, once [`Search::best`] has run.
    pub fn leaders(&self) -> &[Flight<S::Shape>] {
        &self.leaders
    }

    /// The best score of a flight with another number of faces; no stairs at all counts 0.
    pub fn rival(&self, faces: usize) -> f32 {
        let others = self.leaders.iter().filter(|f| f.chain.len() != faces);
        others.map(|f| f.score).fold(0.0, math::max)
    }

    /// The best flight.
    #[inline(never)]
    pub fn best(&mut self, beams: &mut Beams<S::Shape>) -> Option<Flight<S::Shape>> {
        let Beams { now, next } = beams;
        let (mut now, mut next) = (now, next);
        now.flights.clear();
        let mut flight = Flight::default();
        for index in 0..S::SHAPES {
            for (k, column) in self.stairs.evidence().columns.iter().enumerate() {
                let first = self.link(k);
                let shape = self.stairs.shape(first, index).filter(|_| column.begins);
                let Some(shape) = shape else { continue };
                flight.chain.clear();
                (flight.shape, flight.faces) = (shape, 0.0);
                if self.extend(&mut flight, first) {
                    self.finish(&mut flight);
                    now.offer(&flight);
                }
            }
        }
        while !now.flights.is_empty() {
            next.flights.clear();
            for flight in &now.flights {
                self.lead(flight);
                self.grow(flight, next);
            }
            core::mem::swap(&mut now, &mut next);
        }
        let best = self
            .leaders
            .iter()
            .max_by(|a, b| a.score.total_cmp(&b.score));
        best.cloned()
    }

    /// Adds a face to a flight; whether there was room for it.
    fn extend(&self, flight: &mut Flight<S::Shape>, link: Link) -> bool {
        flight.faces += self.stairs.face(&flight.chain, link, flight.shape);
        flight.chain.push(link).is_ok()
    }

    /// Scores a flight as if it ended with its last face.
    fn finish(&self, flight: &mut Flight<S::Shape>) {
        let behind = self.stairs.behind(&flight.chain, flight.shape);
        flight.score = flight.faces + behind - self.stairs.null();
    }

    /// Remembers a flight if it is the best of its length.
    fn lead(&mut self, flight: &Flight<S::Shape>) {
        let same = |f: &&mut Flight<S::Shape>| f.chain.len() == flight.chain.len();
        match self.leaders.iter_mut().find(same) {
            Some(leader) if leader.score >= flight.score => {}
            Some(leader) => *leader = flight.clone(),
            // There is room for every length.
            None => drop(self.leaders.push(flight.clone())),
        }
    }

    fn link(&self, column: usize) -> Link {
        let columns = &self.stairs.evidence().columns;
        let along = columns.get(column).map_or(0.0, |c| c.along);
        Link {
            along,
            column: Some(column as u8),
        }
    }

    /// Follows a flight to its next faces.
    fn grow(&self, flight: &Flight<S::Shape>, next: &mut Beam<S::Shape>) {
        let [first, rest @ ..] = flight.chain.as_slice() else {
            return;
        };
        let mut grown = flight.clone();
        let mut grow_to = |link: Link, spacing: f32, skipped: usize| {
            grown.chain.truncate(flight.chain.len());
            grown.faces = flight.faces;
            self.grow_to(&mut grown, link, spacing, skipped, next);
        };
        let Some(last) = rest.last() else {
            // The second face fixes the direction: any column that stairs may have there.
            for c in 0..self.stairs.evidence().columns.len() {
                let link = self.link(c);
                for skipped in [0usize, 1] {
                    let spacing = (link.along - first.along) / (skipped + 1) as f32;
                    if S::SPACING.contains(&spacing) {
                        grow_to(link, spacing, skipped);
                    }
                }
            }
            return;
        };
        let spacing = (last.along - first.along) / rest.len() as f32;
        for skipped in [0usize, 1] {
            let aim = last.along + (skipped + 1) as f32 * spacing;
            if let Some(link) = self.near(aim) {
                let spacing = (link.along - last.along) / (skipped + 1) as f32;
                grow_to(link, spacing, skipped);
                break;
            }
        }
    }

    /// Adds `link`, and `skipped` faces before it, to a flight and offers it.
    fn grow_to(
        &self,
        flight: &mut Flight<S::Shape>,
        link: Link,
        spacing: f32,
        skipped: usize,
        next: &mut Beam<S::Shape>,
    ) {
        if skipped > 0 {
            let along = link.along - spacing;
            // A face between may have a column near where it should stand.
            let between = self.near(along).unwrap_or(Link {
                along,
                column: None,
            });
            if !self.extend(flight, between) {
                return;
            }
        }
        if self.extend(flight, link) {
            self.finish(flight);
            next.offer(flight);
        }
    }

    /// The weightiest column within the tolerance of a place.
    fn near(&self, along: f32) -> Option<Link> {
        let mut best = (f32::NEG_INFINITY, None);
        for (k, column) in self.stairs.evidence().columns.iter().enumerate() {
            let off = column.along - along;
            if off >= S::TOLERANCE {
                break;
            }
            if off > -S::TOLERANCE {
                let worth = column.weight - OFF_PLACE * off.abs();
                if worth >= best.0 {
                    best = (worth, Some(k));
                }
            }
        }
        best.1.map(|k| self.link(k))
    }
}
