//! Local maxima of the filtered map, found row by row: the places where a mode of particles starts.

use super::MAX_BINS;
use heapless::Vec;

/// Most candidates of a scan: the strongest are kept.
pub const MAX_CANDIDATES: usize = 128;
/// Rows held: a maximum is looked at together with three rows to each side …
const WINDOW: usize = 7;
/// … and this one in the middle.
pub const MIDDLE: usize = WINDOW / 2;
/// A maximum stands out over this many rows to each side, and over the bins beside it.
const NEIGHBOURS: usize = 2;
/// Rows of a patch, relative to its middle.
pub const PATCH_ROWS: [i8; 5] = [-3, -2, 0, 2, 3];
/// Bins of a patch, relative to its middle.
pub const PATCH_BINS: [i8; 3] = [-1, 0, 1];

/// Levels around a maximum relative to it, 1/32 octave (saturated), [row][bin].
pub type Patch = [[i8; PATCH_BINS.len()]; PATCH_ROWS.len()];
/// Levels (1/128 octave) to one unit of a patch.
const PATCH_SHIFT: u32 = 2;
/// Decibels of one unit of a patch.
pub const PATCH_DB: f32 = super::beam::LEVEL_DB * (1 << PATCH_SHIFT) as f32;

/// One local maximum of the filtered map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Candidate {
    /// Filtered level, 1/128 octave.
    pub level: u16,
    /// Row of the map.
    pub row: u16,
    /// Stored range bin.
    pub bin: u8,
    /// The filtered map around it.
    pub patch: Patch,
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
    /// row's place in the map if there is one yet, `reversed` whether rows come from the last to
    /// the first.
    pub fn advance(&mut self, bins: usize, row: Option<u16>, reversed: bool) {
        self.fed += 1;
        let Some(row) = row.filter(|_| self.fed >= WINDOW) else {
            return;
        };
        // Lines in the order of the map's rows, whichever way they came.
        let line = |k: usize| {
            let age = if reversed { k } else { WINDOW - 1 - k };
            (self.fed + WINDOW - 1 - age) % WINDOW
        };
        let order: [usize; WINDOW] = core::array::from_fn(line);
        for bin in 1..bins.min(MAX_BINS).saturating_sub(1) {
            let middle = &self.window[order[MIDDLE]];
            let level = middle[bin];
            if level < middle[bin - 1] || level < middle[bin + 1] {
                continue;
            }
            let around = MIDDLE - NEIGHBOURS..=MIDDLE + NEIGHBOURS;
            let highest = order[around].iter().all(|&k| {
                let line = &self.window[k];
                line[bin - 1] <= level && line[bin] <= level && line[bin + 1] <= level
            });
            if highest {
                let value = |i: usize, j: usize| {
                    let line =
                        &self.window[order[MIDDLE.wrapping_add_signed(PATCH_ROWS[i].into())]];
                    let at = line[bin.wrapping_add_signed(PATCH_BINS[j].into())];
                    {
                        let relative = (i32::from(at) - i32::from(level) + 2) >> PATCH_SHIFT;
                        relative.clamp(-128, 127) as i8
                    }
                };
                let patch = core::array::from_fn(|i| core::array::from_fn(|j| value(i, j)));
                self.keep(Candidate {
                    level,
                    row,
                    bin: bin as u8,
                    patch,
                });
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
        self.found
            .sort_unstable_by_key(|c| core::cmp::Reverse(c.key()));
        self.weakest = self.found.len().saturating_sub(1);
        &self.found
    }
}
