//! Synthetic maps for the tests of other modules.

use crate::config::Config;
use crate::signal::grid::PolarMap;

/// Returns a map of `config` whose cells are `cell(row, bin)`.
pub fn map(config: &Config, cell: impl Fn(usize, usize) -> u8) -> Box<PolarMap> {
    let mut map = Box::new(PolarMap::new());
    map.begin(config).unwrap();
    for k in 0..map.rows() {
        map.fill(k, |row| {
            for (bin, value) in row.cells.iter_mut().enumerate() {
                *value = cell(k, bin);
            }
        })
        .unwrap();
    }
    map
}

/// Returns a number evenly distributed between 0 and 1, always the same for the same cell and seed.
pub fn uniform(row: usize, bin: usize, seed: u64) -> f64 {
    let mut h = (row as u64 * 1009 + bin as u64 + 1) ^ seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    for _ in 0..3 {
        h ^= h >> 31;
        h = h.wrapping_mul(0xBF58_476D_1CE4_E5B9);
    }
    ((h >> 11) as f64 + 0.5) / (1u64 << 53) as f64
}

/// Returns the power of exponentially distributed noise of mean 1, always the same for the same cell and seed.
pub fn noise(row: usize, bin: usize, seed: u64) -> f64 {
    -uniform(row, bin, seed).ln()
}
