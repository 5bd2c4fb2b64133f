//! Local maxima of the filtered map, found row by row: the places where a mode of particles starts.

use super::MAX_BINS;
use heapless::Vec;

/// Most candidates of a scan: the strongest are kept.
pub const MAX_CANDIDATES: usize = 96;
/// Rows held: a maximum stands out over two rows to each side, and over the bins beside it …
const WINDOW: usize = 5;
/// … and this one is in the middle.
pub const MIDDLE: usize = WINDOW / 2;

/// One local maximum of the filtered map, in one word: level, row, bin. So the stronger is the
/// larger, and ties go by place: the order of arrival does not matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Candidate(u32);

impl Candidate {
    /// A level has 12 bits, and a row no more.
    fn new(level: u16, row: u16, bin: u8) -> Self {
        Self(u32::from(level) << 20 | u32::from(row) << 8 | u32::from(bin))
    }

    /// Filtered level, 1/128 octave.
    pub fn level(self) -> u16 {
        (self.0 >> 20) as u16
    }

    /// Row of the map.
    pub fn row(self) -> u16 {
        (self.0 >> 8 & 0xfff) as u16
    }

    /// Stored range bin.
    pub fn bin(self) -> u8 {
        self.0 as u8
    }
}

/// The last rows of the filtered map and the maxima found so far.
#[derive(Debug)]
pub struct CandidateFinder {
    window: [[u16; MAX_BINS]; WINDOW],
    fed: usize,
    /// Once it is full, a heap with the weakest on top.
    found: Vec<Candidate, MAX_CANDIDATES>,
}

impl CandidateFinder {
    /// Nothing found yet.
    pub const fn new() -> Self {
        Self {
            window: [[0; MAX_BINS]; WINDOW],
            fed: 0,
            found: Vec::new(),
        }
    }

    /// Ready for a scan's first row.
    pub fn begin(&mut self) {
        self.fed = 0;
        self.found.clear();
    }

    /// Where the next row's levels go; [`CandidateFinder::advance`] then looks at them.
    pub fn next_row(&mut self) -> &mut [u16; MAX_BINS] {
        &mut self.window[self.fed % WINDOW]
    }

    /// Looks for maxima of `least` or more in the row [`MIDDLE`] before the one just written. `row`
    /// is that middle row's place in the map if there is one yet.
    pub fn advance(&mut self, bins: usize, row: Option<u16>, least: u16) {
        self.fed += 1;
        let Some(row) = row.filter(|_| self.fed >= WINDOW) else {
            return;
        };
        let Self { window, fed, found } = self;
        let Some(middle) = window.get((*fed + WINDOW - 1 - MIDDLE) % WINDOW) else {
            return;
        };
        let Some(&[mut near, mut level, ref rest @ ..]) = middle.get(..bins) else {
            return;
        };
        for (bin, &far) in (1u8..).zip(rest) {
            let before = core::mem::replace(&mut near, level);
            let level = core::mem::replace(&mut level, far);
            if level < before || level < far || level < least {
                continue;
            }
            let at = usize::from(bin) - 1..usize::from(bin) + 2;
            let lower = |line: &[u16; MAX_BINS]| {
                let around = line.get(at.clone()).unwrap_or(&[]);
                around.iter().all(|&other| other <= level)
            };
            if window.iter().all(lower) {
                keep(found, Candidate::new(level, row, bin));
            }
        }
    }

    /// The candidates from `least` on, strongest first.
    pub fn sorted(&mut self, least: u16) -> &[Candidate] {
        self.found.retain(|c| c.level() >= least);
        heapify(&mut self.found);
        for end in (1..self.found.len()).rev() {
            if let Ok([top, last]) = self.found.get_disjoint_mut([0, end]) {
                core::mem::swap(top, last);
            }
            sift_down(self.found.get_mut(..end).unwrap_or(&mut []), 0);
        }
        &self.found
    }
}

/// Adds a candidate, in place of the weakest if there is no room.
fn keep(found: &mut Vec<Candidate, MAX_CANDIDATES>, candidate: Candidate) {
    if found.push(candidate).is_ok() {
        if found.is_full() {
            heapify(found);
        }
        return;
    }
    if let Some(weakest) = found.first_mut()
        && *weakest < candidate
    {
        *weakest = candidate;
        sift_down(found, 0);
    }
}

/// Makes a heap of the candidates, the weakest on top.
fn heapify(found: &mut [Candidate]) {
    for k in (0..found.len() / 2).rev() {
        sift_down(found, k);
    }
}

/// Lets candidate `k` sink below the weaker ones under it.
#[inline(never)]
fn sift_down(found: &mut [Candidate], mut k: usize) {
    let Some(&sinking) = found.get(k) else { return };
    loop {
        let mut child = 2 * k + 1;
        let weakest = match found.get(child..) {
            Some(&[near, far, ..]) if far < near => {
                child += 1;
                far
            }
            Some(&[near, ..]) => near,
            _ => sinking,
        };
        let risen = weakest < sinking;
        if let Some(place) = found.get_mut(k) {
            *place = if risen { weakest } else { sinking };
        }
        if !risen {
            return;
        }
        k = child;
    }
}
