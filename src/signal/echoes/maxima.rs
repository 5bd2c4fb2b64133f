//! Local maxima of the filtered map, found row by row: candidates for echoes.

use crate::signal::grid::MAX_BINS;
use heapless::binary_heap::{BinaryHeap, Min};

/// Maximum number of maxima of a scan; the strongest are kept.
pub const MAX_MAXIMA: usize = 96;
/// Number of filtered rows held: a maximum is compared with two rows to each side, and with the bins beside it.
const WINDOW: usize = 5;
/// Number of rows from the newest one held to the one that is tested, in the middle of [`WINDOW`].
pub const MIDDLE: usize = WINDOW / 2;

/// One local maximum of the filtered map in one word: its level in the upper half, the number of its cell (row
/// · bins + bin) in the lower half. Words are ordered by level, and equal levels by cell, so that the order of
/// arrival has no influence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Maximum(u32);

impl Maximum {
    /// Creates a maximum of `level` (1/128 octave) at cell number `cell`, which fits 16 bits.
    fn new(level: u16, cell: usize) -> Self {
        Self(u32::from(level) << u16::BITS | (cell as u32 & u32::from(u16::MAX)))
    }

    /// Returns the filtered level, 1/128 octave.
    pub fn level(self) -> u16 {
        (self.0 >> u16::BITS) as u16
    }

    /// Returns row and range bin of the maximum in a map of `bins` bins.
    pub fn cell(self, bins: usize) -> (usize, usize) {
        let cell = usize::from(self.0 as u16);
        let row = cell.checked_div(bins).unwrap_or(0);
        (row, cell - row * bins)
    }
}

/// Last rows of the filtered map, and the maxima found so far.
#[derive(Debug)]
pub struct MaximaFinder {
    window: [[u16; MAX_BINS]; WINDOW],
    fed: usize,
    /// Maxima found so far, the weakest on top.
    found: BinaryHeap<Maximum, Min, MAX_MAXIMA>,
}

impl MaximaFinder {
    /// Empty, before the first row.
    pub const fn new() -> Self {
        Self {
            window: [[0; MAX_BINS]; WINDOW],
            fed: 0,
            found: BinaryHeap::new(),
        }
    }

    /// Prepares for the first row of a scan.
    pub fn begin(&mut self) {
        self.fed = 0;
        self.found.clear();
    }

    /// Returns the buffer for the next row's levels; [`MaximaFinder::advance`] then evaluates them.
    pub fn next_row(&mut self) -> &mut [u16; MAX_BINS] {
        &mut self.window[self.fed % WINDOW]
    }

    /// Searches for maxima of at least `least` (1/128 octave) in the row that is [`MIDDLE`] rows before the one
    /// just written. `row` is the number of the searched row in the map; `None` before the first such row.
    pub fn advance(&mut self, bins: usize, row: Option<usize>, least: u16) {
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
        for (bin, &far) in (1..).zip(rest) {
            let before = core::mem::replace(&mut near, level);
            let level = core::mem::replace(&mut level, far);
            if level < before || level < far || level < least {
                continue;
            }
            let lower = |line: &[u16; MAX_BINS]| {
                let around = line.get(bin - 1..bin + 2).unwrap_or(&[]);
                around.iter().all(|&other| other <= level)
            };
            if window.iter().all(lower) {
                keep(found, Maximum::new(level, row * bins + bin));
            }
        }
    }

    /// Removes and returns the weakest maximum, if there is one.
    pub fn pop_weakest(&mut self) -> Option<Maximum> {
        self.found.pop()
    }
}

/// Adds a maximum; without room for it, it replaces the weakest one if it is stronger.
fn keep(found: &mut BinaryHeap<Maximum, Min, MAX_MAXIMA>, maximum: Maximum) {
    if found.push(maximum).is_err()
        && let Some(mut weakest) = found.peek_mut()
        && *weakest < maximum
    {
        *weakest = maximum;
    }
}
