//! Synthetic maps for the tests of other modules.

use crate::config::Config;
use crate::signal::grid::{PolarMap, two_way_sigma};
use std::vec::Vec;

/// Level of the mean noise power in the synthetic maps, map units.
const NOISE: u8 = 80;

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

/// Returns a map of point scatterers (x, y, dB above the noise) with noise.
pub fn scene(config: &Config, points: &[(f32, f32, f64)]) -> Box<PolarMap> {
    let mut blank = Box::new(PolarMap::new());
    blank.begin(config).unwrap();
    let geometry = *blank.geometry();
    let sigma = f64::from(two_way_sigma(geometry.beamwidth_rad));
    let native = f64::from(config.radar.range_resolution_m());
    let places: Vec<(f64, f64, f64)> = points
        .iter()
        .map(|&(x, y, db)| {
            let (range, angle) = geometry.polar(x, y);
            (range.into(), angle.into(), db)
        })
        .collect();
    map(config, |row, bin| {
        let angle = f64::from(blank.angle_rad(row));
        let range = f64::from(geometry.range_m(bin as f32));
        let mut power = noise(row, bin, 7);
        for &(r, a, db) in &places {
            let bins = (range - r) / native;
            let turn = (angle - a) / sigma;
            let response = (-6.0 * bins * bins).max(-45.0);
            power += 10f64.powf((db + response) / 10.0) * (-0.5 * turn * turn).exp();
        }
        (f64::from(NOISE) + 8.0 * power.log2())
            .round()
            .clamp(0.0, 255.0) as u8
    })
}
