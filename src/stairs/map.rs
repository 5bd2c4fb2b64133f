//! The polar map: one byte of logarithmic power a cell, one bit for what CA-CFAR lets through.
//!
//! Rows are shaft angles in the order of the schedule (whichever way the mirror sweeps), columns
//! are range bins. A cell holds log2 of power in steps of an eighth octave (0.376 dB) above the
//! reference of [`crate::range`]. Bytes in one linear array are the only layout that leaves room
//! for anything else in 128 KB.

use crate::config::{Config, ConfigError, Plane, check};
use crate::math;
use crate::range::BinWindow;

/// Most rows that this map holds yet.
pub(crate) const MAX_ROWS: usize = 288;
/// Most cells of one map.
pub const MAX_CELLS: usize = 64 * 1024;
/// Words of the detection mask: each row begins a new word.
pub const MAX_MASK_WORDS: usize = MAX_ROWS * 8;
/// Decibels of one unit of a cell.
pub const DB_PER_UNIT: f32 = 0.376_287_5;

/// Where a map's cells lie in the sagittal plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Geometry {
    /// Range of the first stored bin from the mirror's centre, metres.
    pub first_range_m: f32,
    /// From one bin to the next, metres.
    pub bin_m: f32,
    /// Mirror centre above the ground, metres.
    pub mount_height_m: f32,
    /// From one scheduled angle to the next, radians.
    pub step_rad: f32,
    /// Two-sided 3 dB width of the beam, radians.
    pub beamwidth_rad: f32,
    /// The plane that the mirror sweeps.
    pub plane: Plane,
}

impl Geometry {
    /// Range from the mirror's centre of the (fractional) stored bin, metres.
    pub fn range_m(&self, bin: f32) -> f32 {
        self.first_range_m + bin * self.bin_m
    }

    /// Point at `range_m` from the mirror seen under `angle_rad`: (x, y) in metres, x forward from
    /// the mirror's centre, y up from the ground.
    pub fn point(&self, range_m: f32, angle_rad: f32) -> (f32, f32) {
        let (sin, cos) = math::sin_cos(angle_rad);
        match self.plane {
            Plane::Depth => (range_m * cos, self.mount_height_m - range_m * sin),
            Plane::Height => (range_m * sin, self.mount_height_m - range_m * cos),
        }
    }

    /// Range and angle under which the mirror sees the point (x, y).
    pub fn polar(&self, x: f32, y: f32) -> (f32, f32) {
        let down = self.mount_height_m - y;
        let angle = match self.plane {
            Plane::Depth => math::atan2(down, x),
            Plane::Height => math::atan2(x, down),
        };
        (math::hypot(x, down), angle)
    }
}

/// One row of the map while it is being filled.
#[derive(Debug)]
pub struct Row<'a> {
    /// Logarithmic power, one byte a stored bin.
    pub cells: &'a mut [u8],
    /// Detections, bit `b % 32` of word `b / 32` for stored bin `b`.
    pub mask: &'a mut [u32],
}

/// The whole scan in polar coordinates.
#[derive(Debug)]
pub struct PolarMap {
    cells: [u8; MAX_CELLS],
    mask: [u32; MAX_MASK_WORDS],
    angles: [f32; MAX_ROWS],
    present: [u32; MAX_ROWS / 32],
    rows: usize,
    bins: usize,
    geometry: Geometry,
}

impl PolarMap {
    /// An empty map without rows; [`PolarMap::begin`] shapes it.
    pub const fn new() -> Self {
        Self {
            cells: [0; MAX_CELLS],
            mask: [0; MAX_MASK_WORDS],
            angles: [0.0; MAX_ROWS],
            present: [0; MAX_ROWS / 32],
            rows: 0,
            bins: 0,
            geometry: Geometry {
                first_range_m: 0.0,
                bin_m: 0.0,
                mount_height_m: 0.0,
                step_rad: 0.0,
                beamwidth_rad: 0.0,
                plane: Plane::Depth,
            },
        }
    }

    /// Empties the map and gives it the shape of `config`'s scan.
    pub fn begin(&mut self, config: &Config) -> Result<(), ConfigError> {
        let window = BinWindow::new(&config.radar, &config.mount, &config.cfar);
        let (rows, bins) = (
            usize::from(config.sweep.angle_count),
            usize::from(window.count),
        );
        check(
            bins >= 8,
            "bandwidth",
            "at least 8 range bins beyond the mirror",
        )?;
        check(
            rows <= MAX_ROWS && rows * bins <= MAX_CELLS,
            "angle-count",
            "a map of 65536 cells at most",
        )?;
        let bin_m = config.radar.bin_spacing_m();
        self.rows = rows;
        self.bins = bins;
        self.geometry = Geometry {
            first_range_m: f32::from(window.first) * bin_m - config.mount.mirror_offset_m(),
            bin_m,
            mount_height_m: config.mount.mount_height_m(),
            step_rad: config.sweep.angle_step as f32 * 1e-3 * math::RAD_PER_DEG,
            beamwidth_rad: config.mount.beamwidth_rad(),
            plane: config.mount.plane,
        };
        self.present.fill(0);
        for (k, angle) in self.angles.iter_mut().take(rows).enumerate() {
            *angle = config.sweep.angle(k as u16) as f32 * 1e-3 * math::RAD_PER_DEG;
        }
        self.cells.fill(0);
        self.mask.fill(0);
        Ok(())
    }

    /// Row `k`, to be filled at the angle that the shaft really has; `None` beyond the last.
    pub fn row_mut(&mut self, k: usize, angle_rad: f32) -> Option<Row<'_>> {
        if k >= self.rows {
            return None;
        }
        *self.angles.get_mut(k)? = angle_rad;
        *self.present.get_mut(k / 32)? |= 1 << (k % 32);
        let words = self.words();
        let cells = self.cells.get_mut(k * self.bins..)?.get_mut(..self.bins)?;
        let mask = self.mask.get_mut(k * words..)?.get_mut(..words)?;
        Some(Row { cells, mask })
    }

    /// Number of rows (angles).
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of stored range bins.
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// Where the cells lie.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Words of one row's mask.
    fn words(&self) -> usize {
        self.bins.div_ceil(32)
    }

    /// The bytes of row `k`; empty beyond the last.
    pub fn row(&self, k: usize) -> &[u8] {
        if k >= self.rows {
            return &[];
        }
        self.cells
            .get(k * self.bins..(k + 1) * self.bins)
            .unwrap_or(&[])
    }

    /// The detection mask of row `k`; empty beyond the last.
    pub fn mask(&self, k: usize) -> &[u32] {
        if k >= self.rows {
            return &[];
        }
        let words = self.words();
        self.mask.get(k * words..(k + 1) * words).unwrap_or(&[])
    }

    /// Logarithmic power of a cell; 0 outside the map.
    pub fn cell(&self, row: usize, bin: usize) -> u8 {
        self.row(row).get(bin).copied().unwrap_or(0)
    }

    /// The cells from `bin` of row `row` on, row after row; `None` beyond the last.
    pub fn from(&self, row: usize, bin: usize) -> Option<&[u8]> {
        let (first, end) = (row * self.bins + bin, self.rows * self.bins);
        self.cells.get(first..end)
    }

    /// Whether CA-CFAR let the cell through; false outside the map.
    pub fn hit(&self, row: usize, bin: usize) -> bool {
        self.mask(row)
            .get(bin / 32)
            .is_some_and(|word| word & (1 << (bin % 32)) != 0)
    }

    /// In how many of `rows` CA-CFAR let a cell through at `bin` or beside it.
    pub fn rows_hit(&self, rows: core::ops::Range<usize>, bin: usize) -> usize {
        let words = self.words();
        let mask = self.mask.get(rows.start * words..).unwrap_or(&[]);
        // The three bits, and where they begin: they may reach into the next word.
        let (first, three) = (bin.saturating_sub(1), if bin == 0 { 0b011 } else { 0b111 });
        let hit = |row: &&[u32]| {
            let at = |k: usize| u64::from(row.get(k).copied().unwrap_or(0));
            let both = at(first / 32) | at(first / 32 + 1) << 32;
            both >> (first % 32) & three != 0
        };
        let rows = mask.chunks(words.max(1)).take(rows.len());
        rows.filter(hit).count()
    }

    /// The cells of row `k` that CA-CFAR let through: bin and logarithmic power.
    pub fn hits(&self, k: usize) -> impl Iterator<Item = (usize, u8)> {
        let cells = self.row(k);
        let words = self.mask(k).iter().zip(cells.chunks(32)).enumerate();
        words.flat_map(|(w, (&word, cells))| {
            Bits(word).filter_map(move |bit| Some((32 * w + bit, *cells.get(bit)?)))
        })
    }

    /// Whether row `k`'s chirp arrived.
    pub fn present(&self, k: usize) -> bool {
        self.present
            .get(k / 32)
            .is_some_and(|word| word & (1 << (k % 32)) != 0)
    }

    /// The shaft's angle of row `k`, radians.
    pub fn angle_rad(&self, k: usize) -> f32 {
        self.angles.get(k).copied().unwrap_or(0.0)
    }
}

/// The set bits of a word, lowest first.
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
