//! The search for the best flight among the columns: a beam search, face by face.
//!
//! Beginnings of flights grow by one face at a time, or by two of which the nearer one is inferred. After each round
//! only the best [`BEGINNINGS`] are kept. Worst case, in faces scored: columns × shapes in the first round, then
//! [`BEGINNINGS`] × columns for the second face, then [`BEGINNINGS`] × 2 for each further one.

use super::ascending::Ascending;
use super::stairs::{Flight, MAX_FLIGHT, regular};
use crate::math;
use crate::observer::trace::ChainLink;
use crate::params::Params;
use heapless::Vec;

/// Beam width: number of beginnings that are followed at a time. With half of it no recording's answer changes.
const BEGINNINGS: usize = 12;
/// Possible numbers of faces without an echo between two faces with one.
const SKIPPED: [usize; 2] = [0, 1];

/// The best beginnings of flights found so far in a round, in no order.
#[derive(Debug)]
struct BestPartialFlights {
    flights: Vec<Flight, BEGINNINGS>,
    /// Index of the flight of the lowest score, once the list is full.
    worst: usize,
}

impl BestPartialFlights {
    const fn new() -> Self {
        Self {
            flights: Vec::new(),
            worst: 0,
        }
    }

    /// Adds a flight. If the list is full, it replaces the worst one, provided that it is better.
    fn offer(&mut self, flight: &Flight) {
        if self.flights.is_full() {
            match self.flights.get_mut(self.worst) {
                Some(worst) if worst.score < flight.score => worst.clone_from(flight),
                _ => return,
            }
        } else {
            // Cannot fail: the list is not full.
            let _ = self.flights.push(flight.clone());
        }
        if self.flights.is_full() {
            let flights = self.flights.iter().enumerate();
            let worst = flights.min_by(|(_, a), (_, b)| a.score.total_cmp(&b.score));
            self.worst = worst.map_or(0, |(k, _)| k);
        }
    }
}

/// Working memory of a search: the beginnings of this round and of the next. It is too large for a small stack: the
/// caller provides it.
#[derive(Debug)]
pub struct Beam {
    now: BestPartialFlights,
    next: BestPartialFlights,
}

impl Beam {
    /// Returns the memory without beginnings.
    pub const fn new() -> Self {
        Self {
            now: BestPartialFlights::new(),
            next: BestPartialFlights::new(),
        }
    }
}

/// The search's results: the best flights, and the best of all.
#[derive(Debug)]
pub struct Proposals<'s, 'e> {
    /// The search with the best flight of each number of faces.
    pub search: Search<'s, 'e>,
    /// The best flight; `None` if no column can begin one.
    pub best: Option<Flight>,
}

impl<'s, 'e> Proposals<'s, 'e> {
    /// Returns the results of a search with this evaluator and this working memory.
    pub fn of(stairs: &'s Ascending<'e>, memory: &mut Beam) -> Self {
        let mut search = Search::new(stairs);
        let best = search.best(memory);
        Self { search, best }
    }
}

/// The search, and the best flights that it has found.
#[derive(Debug)]
pub struct Search<'s, 'e> {
    /// Evaluator of flights.
    pub stairs: &'s Ascending<'e>,
    /// The best flight of each number of faces (risers), in no order; filled by [`Search::best`].
    pub leaders: Vec<Flight, MAX_FLIGHT>,
}

impl<'s, 'e> Search<'s, 'e> {
    fn params(&self) -> &Params {
        self.stairs.scene().params
    }

    /// Returns the allowed numbers of faces without an echo between two faces with one.
    fn skipped(&self) -> impl Iterator<Item = usize> {
        let most = usize::from(self.params().rules.skipped_face);
        SKIPPED.into_iter().filter(move |skipped| *skipped <= most)
    }

    /// Returns a search that uses this evaluator.
    pub fn new(stairs: &'s Ascending<'e>) -> Self {
        Self {
            stairs,
            leaders: Vec::new(),
        }
    }

    /// Returns the best score of a flight with another number of faces than `faces`, nats; no stairs have the score 0.
    pub fn runner_up_score(&self, faces: usize) -> f32 {
        let others = self.leaders.iter().filter(|f| f.chain.len() != faces);
        others.map(|f| f.score).fold(0.0, math::max)
    }

    /// Runs the search, stores the leaders, and returns the best flight; none if no column can begin a flight.
    #[inline(never)]
    pub fn best(&mut self, memory: &mut Beam) -> Option<Flight> {
        let Beam { now, next } = memory;
        let (mut now, mut next) = (now, next);
        now.flights.clear();
        for (k, shape) in self.stairs.beginnings() {
            let mut flight = Flight {
                shape,
                ..Flight::default()
            };
            if self.extend(&mut flight, self.link(k)) {
                self.finish(&mut flight);
                now.offer(&flight);
            }
        }
        while !now.flights.is_empty() {
            next.flights.clear();
            for flight in &now.flights {
                if self.store_leader(flight) {
                    self.extend_landing(flight, next);
                }
                self.extend_by_next(flight, next);
            }
            core::mem::swap(&mut now, &mut next);
        }
        let best = self.leaders.iter();
        best.max_by(|a, b| a.score.total_cmp(&b.score)).cloned()
    }

    /// Adds a face to a flight. Returns whether there was room for it.
    fn extend(&self, flight: &mut Flight, link: ChainLink) -> bool {
        flight.faces += self.stairs.face(&flight.chain, link, flight.shape);
        flight.chain.push(link).is_ok()
    }

    /// Sets a flight's score as if it ended with its last face.
    fn finish(&self, flight: &mut Flight) {
        let behind = self.stairs.behind(&flight.chain, flight.shape);
        flight.score = flight.faces + behind - self.stairs.null();
    }

    /// Stores a flight as a leader if it is the best of its number of faces so far, and returns whether it is.
    fn store_leader(&mut self, flight: &Flight) -> bool {
        let same = |f: &&mut Flight| f.chain.len() == flight.chain.len();
        match self.leaders.iter_mut().find(same) {
            Some(leader) if leader.score >= flight.score => return false,
            Some(leader) => leader.clone_from(flight),
            // Cannot fail: there is room for every length.
            None => drop(self.leaders.push(flight.clone())),
        }
        true
    }

    fn link(&self, column: usize) -> ChainLink {
        let columns = &self.stairs.scene().columns;
        ChainLink {
            along_m: columns.get(column).map_or(0.0, |c| c.along_m),
            column: Some(column as u8),
        }
    }

    /// Extends a flight by its next face, at the mean spacing of its faces, or by two faces of which the nearer one is
    /// inferred, and offers the result to the next round.
    fn extend_by_next(&self, flight: &Flight, next: &mut BestPartialFlights) {
        let Some(last) = flight.chain.last() else {
            return;
        };
        let (spacing, _) = regular(&flight.chain, self.params().most_going_m);
        if spacing <= 0.0 {
            return self.extend_second(flight, *last, next);
        }
        for skipped in self.skipped() {
            let aim = last.along_m + (skipped + 1) as f32 * spacing;
            if let Some(link) = self.near(aim) {
                let spacing = (link.along_m - last.along_m) / (skipped + 1) as f32;
                self.extend_to(flight, link, spacing, skipped, next);
                break;
            }
        }
    }

    /// Extends a flight by the first face of a second flight, behind a landing, and offers the result to the next
    /// round.
    fn extend_landing(&self, flight: &Flight, next: &mut BestPartialFlights) {
        let p = self.params();
        let Some(last) = flight.chain.last() else {
            return;
        };
        if regular(&flight.chain, p.most_going_m).1 > 0 {
            return;
        }
        for c in 0..self.stairs.scene().columns.len() {
            let link = self.link(c);
            let away_m = link.along_m - last.along_m;
            if away_m > p.most_going_m && away_m < p.longest_landing_m {
                self.extend_to(flight, link, away_m, 0, next);
            }
        }
    }

    /// Extends a first face by a second one, any column at a possible going, and offers the results to the next round.
    fn extend_second(&self, flight: &Flight, first: ChainLink, next: &mut BestPartialFlights) {
        let p = self.params();
        for c in 0..self.stairs.scene().columns.len() {
            let link = self.link(c);
            for skipped in self.skipped() {
                let spacing = (link.along_m - first.along_m) / (skipped + 1) as f32;
                if (p.least_going_m..=p.most_going_m).contains(&spacing) {
                    self.extend_to(flight, link, spacing, skipped, next);
                }
            }
        }
    }

    /// Adds face `link`, and before it `skipped` faces without an echo, to a copy of a flight, and offers it to the
    /// next round. `spacing` is the distance of the faces, metres.
    fn extend_to(
        &self,
        flight: &Flight,
        link: ChainLink,
        spacing: f32,
        skipped: usize,
        next: &mut BestPartialFlights,
    ) {
        let mut flight = flight.clone();
        if skipped > 0 {
            let along_m = link.along_m - spacing;
            // The face between may have a column near its expected place.
            if !self.extend(&mut flight, self.at(along_m)) {
                return;
            }
        }
        if self.extend(&mut flight, link) {
            self.finish(&mut flight);
            next.offer(&flight);
        }
    }

    /// Returns a face at a distance, metres: at the column near it, or, if there is none, at the distance without a
    /// column.
    pub fn at(&self, along_m: f32) -> ChainLink {
        self.near(along_m).unwrap_or(ChainLink {
            along_m,
            column: None,
        })
    }

    /// Returns the column of the largest credibility within the tolerance of a distance, metres, as a face.
    fn near(&self, along: f32) -> Option<ChainLink> {
        let scene = self.stairs.scene();
        let tolerance = self.params().riser_tolerance_m;
        let columns = scene.columns.iter().enumerate();
        let near = columns.filter(|(_, column)| (column.along_m - along).abs() < tolerance);
        let best = near.max_by(|a, b| a.1.credibility.total_cmp(&b.1.credibility));
        best.map(|(k, _)| self.link(k))
    }
}
