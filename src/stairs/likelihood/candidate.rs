//! Local maxima of the filtered map, found row by row: the places where a mode of particles starts.

use super::MAX_BINS;
use crate::stairs::particles::shell_sort;
use heapless::Vec;

/// Most candidates of a scan: the strongest are kept.
pub const MAX_CANDIDATES: usize = 96;
/// Rows held: a maximum stands out over two rows to each side, and over the bins beside it …
const WINDOW: usize = 5;
/// … and this one is in the middle.
pub const MIDDLE: usize = WINDOW / 2;

/// One local maximum of the filtered map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Candidate {
    /// Filtered level, 1/128 octave.
    pub level: u16,
    /// Row of the map.
    pub row: u16,
    /// Stored range bin.
    pub bin: u8,
}

impl Candidate {
    /// Order of strength; ties go by place, so that the order of arrival does not matter.
    pub fn key(&self) -> (u16, u16, u8) {
        (self.level, self.row, self.bin)
    }
}

/// The last rows of the filtered map and the maxima found so far.
#[derive(Debug)]
pub struct CandidateFinder {
    window: [[u16; MAX_BINS]; WINDOW],
    fed: usize,
    found: Vec<Candidate, MAX_CANDIDATES>,
    weakest: usize,
}

impl CandidateFinder {
    /// Nothing found yet.
    pub const fn new() -> Self {
        Self {
            window: [[0; MAX_BINS]; WINDOW],
            fed: 0,
            found: Vec::new(),
            weakest: 0,
        }
    }

    /// Ready for a scan's first row.
    pub fn begin(&mut self) {
        self.fed = 0;
        self.found.clear();
        self.weakest = 0;
    }

    /// Where the next row's levels go; [`CandidateFinder::advance`] then looks at them.
    pub fn next_row(&mut self) -> &mut [u16; MAX_BINS] {
        &mut self.window[self.fed % WINDOW]
    }

    /// Looks for maxima in the row [`MIDDLE`] before the one just written. `row` is that middle
    /// row's place in the map if there is one yet.
    pub fn advance(&mut self, bins: usize, row: Option<u16>) {
        self.fed += 1;
        let Some(row) = row.filter(|_| self.fed >= WINDOW) else {
            return;
        };
        let Some(middle) = self.window.get((self.fed + WINDOW - 1 - MIDDLE) % WINDOW) else {
            return;
        };
        let middle = *middle;
        for (bin, cells) in (1u8..).zip(middle.get(..bins).unwrap_or(&[]).windows(3)) {
            let &[near, level, far] = cells else { return };
            if level < near || level < far {
                continue;
            }
            let at = usize::from(bin) - 1..usize::from(bin) + 2;
            let lower = |line: &[u16; MAX_BINS]| {
                let around = line.get(at.clone()).unwrap_or(&[]);
                around.iter().all(|&other| other <= level)
            };
            if self.window.iter().all(lower) {
                self.keep(Candidate { level, row, bin });
            }
        }
    }

    /// Adds a candidate, in place of the weakest if there is no room.
    fn keep(&mut self, candidate: Candidate) {
        if self.found.push(candidate).is_ok() {
            if self.found.is_full() {
                self.find_weakest();
            }
            return;
        }
        if let Some(weakest) = self.found.get_mut(self.weakest)
            && weakest.key() < candidate.key()
        {
            *weakest = candidate;
            self.find_weakest();
        }
    }

    fn find_weakest(&mut self) {
        let weakest = self.found.iter().enumerate().min_by_key(|(_, c)| c.key());
        self.weakest = weakest.map_or(0, |(k, _)| k);
    }

    /// The candidates, strongest first.
    pub fn sorted(&mut self) -> &[Candidate] {
        shell_sort(&mut self.found, |c| core::cmp::Reverse(c.key()));
        self.weakest = self.found.len().saturating_sub(1);
        &self.found
    }
}
