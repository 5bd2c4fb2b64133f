//! Polar map: one byte of logarithmic power per cell, and one bit for a CA-CFAR detection.
//!
//! Rows are shaft angles in the order of the schedule (for either sweep direction), columns are range bins. A
//! cell contains log2 of power in steps of an eighth octave (0.376 dB) above the reference of
//! [`crate::signal::range`]. The map must leave room for the rest in 128 KB of memory: cells and bits are
//! linear arrays without gaps, and angles are computed from the schedule.

use super::window::MAX_CELLS;
use super::{BinWindow, Geometry};
use crate::config::{Config, ConfigError, MAX_ROWS, check};
use crate::math;
use crate::schedule::Schedule;

/// Maximum number of range bins of a map.
pub const MAX_BINS: usize = 256;
/// Minimum number of range bins of a map that can be searched for echoes.
pub const MIN_BINS: usize = 8;
const _: () = assert!(MAX_ROWS == MAX_CELLS / MIN_BINS);
/// Number of words of the detection mask; one more than needed, so that any 32 bits are within two neighbouring
/// words.
const MASK_WORDS: usize = MAX_CELLS / 32 + 1;
/// Map units per octave of power.
pub const UNITS_PER_OCTAVE: u8 = 8;
/// 2^(k/8) for the map units of an octave, Q32.
pub const EIGHTHS: [u64; UNITS_PER_OCTAVE as usize] = [
    4_294_967_296,
    4_683_695_048,
    5_107_605_667,
    5_569_883_475,
    6_074_001_000,
    6_623_745_065,
    7_223_245_205,
    7_877_004_772,
];
/// Decibels per map unit.
pub const DB_PER_UNIT: f32 = 0.376_287_5;

/// One row of the map while it is being filled.
#[derive(Debug)]
pub struct Row<'a> {
    /// Logarithmic power, one byte per stored bin, map units of 1/8 octave.
    pub cells: &'a mut [u8],
    /// CA-CFAR detections: bit `b % 32` of word `b / 32` is set if stored bin `b` is one.
    pub mask: &'a mut [u32],
}

/// Polar map of a whole scan: level and CA-CFAR detection of each row and range bin.
#[derive(Clone, Debug)]
pub struct PolarMap {
    cells: [u8; MAX_CELLS],
    /// CA-CFAR detections: bit `k % 32` of word `k / 32` for cell k = row · bins + bin, so that rows of any
    /// length leave no gap.
    mask: [u32; MASK_WORDS],
    present: [u32; MAX_ROWS / 32],
    rows: usize,
    bins: usize,
    geometry: Geometry,
    schedule: Schedule,
}

impl PolarMap {
    /// Creates an empty map without rows; [`PolarMap::begin`] sets its shape.
    pub const fn new() -> Self {
        Self {
            cells: [0; MAX_CELLS],
            mask: [0; MASK_WORDS],
            present: [0; MAX_ROWS / 32],
            rows: 0,
            bins: 0,
            geometry: Geometry::EMPTY,
            schedule: Schedule::EMPTY,
        }
    }

    /// Clears the map and sets its shape to that of `config`'s scan.
    ///
    /// # Errors
    /// Returns the field that makes the scan larger than the map, or the sweep wider than the shaft can turn.
    pub fn begin(&mut self, config: &Config) -> Result<(), ConfigError> {
        let window = BinWindow::of_scan(config);
        let schedule = Schedule::new(config)?;
        let (rows, bins) = (
            usize::from(config.sweep.angle_count),
            usize::from(window.count),
        );
        check(
            (MIN_BINS..=MAX_BINS).contains(&bins),
            "bandwidth",
            "at least 8 range bins beyond the mirror",
        )?;
        check(
            rows * bins <= MAX_CELLS,
            "angle-count",
            "a map of 65536 cells at most",
        )?;
        let bin_m = config.radar.bin_spacing_m();
        self.rows = rows;
        self.bins = bins;
        self.schedule = schedule;
        self.geometry = Geometry {
            first_range_m: f32::from(window.first) * bin_m - config.mount.mirror_offset_m(),
            bin_m,
            mount_height_m: config.mount.mount_height_m(),
            step_rad: config.sweep.angle_step as f32 * 1e-3 * math::RAD_PER_DEG,
            beamwidth_rad: config.mount.beamwidth_rad(),
            plane: config.mount.plane.first(),
        };
        self.present.fill(0);
        self.cells.fill(0);
        self.mask.fill(0);
        Ok(())
    }

    /// Calls `fill` to write row `k`, marks the row as received, and returns the result of `fill`; `None`
    /// beyond the last row, without calling `fill`.
    ///
    /// ```
    /// use stairscan::config::Config;
    /// use stairscan::signal::grid::PolarMap;
    ///
    /// let mut map = Box::new(PolarMap::new());
    /// map.begin(&Config::default())?;
    /// // Row 100 with one cell that CA-CFAR let through: bin 40.
    /// map.fill(100, |row| {
    ///     row.cells[40] = 200;
    ///     row.mask[40 / 32] |= 1 << (40 % 32);
    /// });
    /// assert!(map.present(100) && !map.present(101));
    /// assert_eq!(map.detections(100).collect::<Vec<_>>(), [(40, 200)]);
    /// // There are 281 rows.
    /// assert_eq!(map.fill(281, |_| ()), None);
    /// # Ok::<(), stairscan::config::ConfigError>(())
    /// ```
    pub fn fill<R>(&mut self, k: usize, fill: impl FnOnce(Row<'_>) -> R) -> Option<R> {
        if k >= self.rows {
            return None;
        }
        let cells = self.cells.get_mut(k * self.bins..)?.get_mut(..self.bins)?;
        let mut words = [0; MAX_BINS / 32];
        let mask = words.get_mut(..self.bins.div_ceil(32))?;
        let filled = fill(Row { cells, mask });
        *self.present.get_mut(k / 32)? |= 1 << (k % 32);
        self.pack(k, &words);
        Some(filled)
    }

    /// Stores the detections of row `k` in the mask, between those of its neighbours: bit b % 32 of
    /// `words[b / 32]` is bin b.
    fn pack(&mut self, k: usize, words: &[u32]) {
        for (first, &word) in (0..self.bins).step_by(32).zip(words) {
            let (at, shift) = self.bit(k, first);
            let kept = u64::from(self.bits_from(first));
            let Some([low, high]) = self.mask.get_mut(at..).and_then(|m| m.first_chunk_mut())
            else {
                return;
            };
            let both = u64::from(*low) | u64::from(*high) << 32;
            let both = both & !(kept << shift) | (u64::from(word) & kept) << shift;
            (*low, *high) = (both as u32, (both >> 32) as u32);
        }
    }

    /// Returns the index of the mask's word and of the bit in it for a cell.
    fn bit(&self, row: usize, bin: usize) -> (usize, usize) {
        let cell = row * self.bins + bin;
        (cell / 32, cell % 32)
    }

    /// Returns a word in which bit k is set if a row has a bin `bin` + k, for k = 0…31.
    fn bits_from(&self, bin: usize) -> u32 {
        match self.bins.saturating_sub(bin) {
            0 => 0,
            left if left < 32 => (1 << left) - 1,
            _ => u32::MAX,
        }
    }

    /// Returns the detections of 32 bins of a row: bit k is that of bin `bin` + k.
    fn detection_bits(&self, row: usize, bin: usize) -> u32 {
        let (at, shift) = self.bit(row, bin);
        let words = self.mask.get(at..).and_then(|m| m.first_chunk());
        let Some(&[low, high]) = words.filter(|_| row < self.rows) else {
            return 0;
        };
        let both = u64::from(low) | u64::from(high) << 32;
        (both >> shift) as u32 & self.bits_from(bin)
    }

    /// Returns the number of rows (angles).
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Returns the number of stored range bins.
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// Returns the geometry of the cells.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Returns the cells of row `k`; empty beyond the last.
    pub fn row(&self, k: usize) -> &[u8] {
        if k >= self.rows {
            return &[];
        }
        self.cells
            .get(k * self.bins..(k + 1) * self.bins)
            .unwrap_or(&[])
    }

    /// Returns the level of a cell, map units; 0 outside the map.
    pub fn cell(&self, row: usize, bin: usize) -> u8 {
        self.row(row).get(bin).copied().unwrap_or(0)
    }

    /// Returns the cells from `bin` of row `row` to the end of the map, row after row; `None` beyond the last.
    pub fn from(&self, row: usize, bin: usize) -> Option<&[u8]> {
        let (first, end) = (row * self.bins + bin, self.rows * self.bins);
        self.cells.get(first..end)
    }

    /// Returns whether the cell is a CA-CFAR detection; false outside the map.
    pub fn is_detected(&self, row: usize, bin: usize) -> bool {
        self.detection_bits(row, bin) & 1 != 0
    }

    /// Returns the number of rows among `rows` that have a detection at bin `bin` or beside it.
    pub fn rows_detected(&self, rows: core::ops::Range<usize>, bin: usize) -> usize {
        let (first, beside) = (bin.saturating_sub(1), if bin == 0 { 0b011 } else { 0b111 });
        rows.filter(|&row| self.detection_bits(row, first) & beside != 0)
            .count()
    }

    /// Returns the detections of row `k`: bin and level, map units.
    #[inline(always)]
    pub fn detections(&self, k: usize) -> impl Iterator<Item = (usize, u8)> {
        let cells = self.row(k);
        (0..cells.len()).step_by(32).flat_map(move |first| {
            Bits(self.detection_bits(k, first))
                .filter_map(move |bit| Some((first + bit, *cells.get(first + bit)?)))
        })
    }

    /// Returns the cells with a detection in row `a` or in row `b`: bin, level in `a` and in `b`, map units.
    #[inline(always)]
    pub fn detections_of(&self, a: usize, b: usize) -> impl Iterator<Item = (usize, u8, u8)> {
        let (cells_a, cells_b) = (self.row(a), self.row(b));
        let words = self.words_of(a).zip(self.words_of(b));
        let firsts = (0..cells_a.len()).step_by(32);
        firsts.zip(words).flat_map(move |(first, (a, b))| {
            let bits = Bits((a | b) & self.bits_from(first));
            bits.filter_map(move |bit| {
                let bin = first + bit;
                Some((bin, *cells_a.get(bin)?, *cells_b.get(bin)?))
            })
        })
    }

    /// Returns the mask's words from row `k` on, shifted so that bit 0 of the first word is the row's first
    /// cell.
    fn words_of(&self, k: usize) -> impl Iterator<Item = u32> {
        let (at, shift) = self.bit(k, 0);
        let words = self.mask.get(at..).unwrap_or(&[]).windows(2);
        words.map(move |pair| match pair {
            // Part of the upper word: none if the row begins at a word.
            &[low, high] => low >> shift | (high << 1) << (31 - shift),
            _ => 0,
        })
    }

    /// Returns whether row `k`'s chirp was received.
    pub fn present(&self, k: usize) -> bool {
        self.present
            .get(k / 32)
            .is_some_and(|word| word & (1 << (k % 32)) != 0)
    }

    /// Returns the beam angle of row `k`, radians below the horizontal (depth plane) or forward from straight down
    /// (height plane): that of the motor's microstep at which the row is observed.
    pub fn angle_rad(&self, k: usize) -> f32 {
        self.schedule.row_angle_rad(k as u16)
    }
}

/// Iterator over the set bits of a word, lowest first.
struct Bits(u32);

impl Iterator for Bits {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let bit = self.0.trailing_zeros() as usize;
        self.0 &= self.0 - 1;
        Some(bit)
    }
}

impl Default for PolarMap {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Returns a map of this number of rows and bins, with the default radar.
    fn map(rows: u16, bins: u16) -> Box<PolarMap> {
        let mut config = Config::default();
        config.sweep.angle_count = rows;
        config.sweep.first_angle = -170_000;
        config.sweep.angle_step = 40;
        let all = BinWindow::new(&config.radar, &config.mount, &config.cfar).count;
        let bin = config.radar.bin_spacing_m();
        config.cfar.near_margin += (f32::from(all - bins) * bin * 1e5) as i32;
        let mut map = Box::new(PolarMap::new());
        map.begin(&config).unwrap();
        assert_eq!((map.rows(), map.bins()), (rows.into(), bins.into()));
        map
    }

    #[test]
    fn any_grid_of_65536_cells_is_taken_and_no_larger_one() {
        for (rows, bins) in [(8192, 8), (321, 190), (281, 208), (4096, 16), (1985, 33)] {
            let mut map = map(rows, bins);
            let last = usize::from(rows) - 1;
            assert_eq!(map.fill(last, |row| row.cells.len()), Some(bins.into()));
            assert!(map.present(last) && map.fill(last + 1, |_| ()).is_none());
        }
        let mut config = Config::default();
        config.sweep.angle_count = 500;
        assert_eq!(
            PolarMap::new().begin(&config).unwrap_err().field,
            "angle-count"
        );
    }

    #[test]
    fn a_rows_angle_is_the_shafts() {
        let mut map = PolarMap::new();
        map.begin(&Config::default()).unwrap();
        for k in 0..281 {
            let scheduled = (-20.0 + 0.25 * k as f32).to_radians();
            assert!((map.angle_rad(k) - scheduled).abs() < 6.2e-5, "row {k}");
        }
        assert_ne!(map.angle_rad(1), (-19.75_f32).to_radians());
    }

    #[test]
    fn rows_that_cfar_lets_through_are_counted_beside_a_bin_too() {
        let mut map = map(281, 200);
        for (row, bin) in [(10, 31), (11, 32), (12, 33), (13, 34), (20, 0), (21, 1)] {
            map.fill(row, |row| row.mask[bin / 32] |= 1 << (bin % 32));
        }
        assert_eq!(map.rows_detected(5..15, 32), 3);
        assert_eq!(map.rows_detected(11..15, 32), 2);
        assert_eq!(map.rows_detected(0..40, 0), 2);
        assert_eq!(map.rows_detected(0..40, 2), 1);
        assert_eq!(map.rows_detected(0..400, 250), 0);
    }

    proptest! {
        #[test]
        fn detections_are_kept_bit_by_bit(
            (rows, bins) in (3_u16..40, 8_u16..=200),
            hits in proptest::collection::btree_set((0_usize..40, 0_usize..200), 0..200),
        ) {
            let mut map = map(rows, bins);
            for row in 0..map.rows() {
                map.fill(row, |cells| {
                    // Bits that range processing leaves beyond the last bin must not reach the next row.
                    let last = cells.mask.len() - 1;
                    let used = u32::from(bins) % 32;
                    cells.mask[last] = if used > 0 { u32::MAX << used } else { 0 };
                    for &(_, bin) in hits.iter().filter(|h| h.0 == row && h.1 < bins.into()) {
                        cells.mask[bin / 32] |= 1 << (bin % 32);
                    }
                });
            }
            for row in 0..map.rows() {
                let wanted: Vec<usize> = (0..map.bins()).filter(|&b| hits.contains(&(row, b))).collect();
                let found: Vec<usize> = map.detections(row).map(|h| h.0).collect();
                prop_assert_eq!(&found, &wanted);
                for bin in 0..map.bins() {
                    prop_assert_eq!(map.is_detected(row, bin), wanted.contains(&bin));
                }
            }
        }
    }
}
