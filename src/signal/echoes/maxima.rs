//! Local maxima of the filtered map, found row by row: where an echo may be.

use crate::signal::grid::MAX_BINS;
use heapless::binary_heap::{BinaryHeap, Min};

/// Most maxima of a scan: the strongest are kept.
pub const MAX_MAXIMA: usize = 96;
/// Rows held: a maximum stands out over two rows to each side, and over the bins beside it …
const WINDOW: usize = 5;
/// … and this one is in the middle.
pub const MIDDLE: usize = WINDOW / 2;

/// One local maximum of the filtered map in one word: level, then cell. So the stronger is the
/// larger, and ties go by place: the order of arrival does not matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Maximum(u32);

impl Maximum {
    /// A map has no more cells than 16 bits tell apart.
    fn new(level: u16, cell: usize) -> Self {
        Self(u32::from(level) << u16::BITS | (cell as u32 & u32::from(u16::MAX)))
    }

    /// Filtered level, 1/128 octave.
    pub fn level(self) -> u16 {
        (self.0 >> u16::BITS) as u16
    }

    /// Row and range bin of a map with so many `bins`.
    pub fn cell(self, bins: usize) -> (usize, usize) {
        let cell = usize::from(self.0 as u16);
        let row = cell.checked_div(bins).unwrap_or(0);
        (row, cell - row * bins)
    }
}

/// The last rows of the filtered map and the maxima found so far.
#[derive(Debug)]
pub struct MaximaFinder {
    window: [[u16; MAX_BINS]; WINDOW],
    fed: usize,
    /// The weakest on top.
    found: BinaryHeap<Maximum, Min, MAX_MAXIMA>,
}

impl MaximaFinder {
    /// Nothing found yet.
    pub const fn new() -> Self {
        Self {
            window: [[0; MAX_BINS]; WINDOW],
            fed: 0,
            found: BinaryHeap::new(),
        }
    }

    /// Ready for a scan's first row.
    pub fn begin(&mut self) {
        self.fed = 0;
        self.found.clear();
    }

    /// Where the next row's levels go; [`MaximaFinder::advance`] then looks at them.
    pub fn next_row(&mut self) -> &mut [u16; MAX_BINS] {
        &mut self.window[self.fed % WINDOW]
    }

    /// Looks for maxima of `least` or more in the row [`MIDDLE`] before the one just written. `row`
    /// is that middle row's place in the map if there is one yet.
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

    /// Takes the weakest maximum out, if there is any.
    pub fn pop_weakest(&mut self) -> Option<Maximum> {
        self.found.pop()
    }
}

/// Adds a maximum, in place of the weakest if there is no room.
fn keep(found: &mut BinaryHeap<Maximum, Min, MAX_MAXIMA>, maximum: Maximum) {
    if found.push(maximum).is_err()
        && let Some(mut weakest) = found.peek_mut()
        && *weakest < maximum
    {
        *weakest = maximum;
    }
}
