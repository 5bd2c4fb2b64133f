//! Echoes of synthetic maps. The maps are also used by tests of other modules.

use super::angle_filter::{self, AngleFilter};
use super::lobe::{self, Lobe, Responses};
use super::*;
use crate::config::Config;
use crate::drive::Drive;
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
    let sigma = f64::from(angle_filter::two_way_sigma(geometry.beamwidth_rad));
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

#[test]
fn the_filter_is_two_boxes_whichever_way_the_rows_come() {
    let config = Config::default();
    let map = map(&config, |row, bin| 60 + ((row * 37 + bin * 11) % 90) as u8);
    let last = map.rows() - 1;
    let bins = map.bins();
    let run = |backwards: bool| {
        let place = |k: usize| {
            if backwards {
                last - k.min(last)
            } else {
                k.min(last)
            }
        };
        let mut filter = AngleFilter::new();
        filter.begin(map.geometry());
        let mut rows = Vec::new();
        for k in 0..=last + filter.lag() {
            let mut levels = vec![0; bins];
            filter.feed(
                map.row(place(k)),
                |back| map.row(place(k - back)),
                &mut levels,
            );
            rows.push(levels);
        }
        let mut rows = rows.split_off(filter.lag());
        if backwards {
            rows.reverse();
        }
        (rows, filter.gain())
    };
    let (forward, gain) = run(false);
    assert_eq!(forward, run(true).0);
    // Against the definition in f64, at several positions away from the ends.
    let box_rows = angle_filter::box_rows(map.geometry()) as isize;
    for (row, bin) in [(40, 3), (100, 77), (200, 150), (250, 210)] {
        let mut sum = 0.0;
        for offset in 1 - box_rows..box_rows {
            let cell = map.cell((row as isize + offset) as usize, bin);
            sum += (box_rows - offset.abs()) as f64 * (f64::from(cell) / 8.0).exp2();
        }
        let level = f64::from(forward[row][bin]) - f64::from(gain);
        let expected = 128.0 * (sum / (box_rows * box_rows) as f64).log2();
        assert!((level - expected).abs() < 3.0, "{level} for {expected}");
    }
}

#[test]
fn a_patch_is_the_filter_worked_out_again() {
    let config = Config::default();
    let map = map(&config, |row, bin| 70 + ((row * 53 + bin * 29) % 100) as u8);
    let mut filter = AngleFilter::new();
    filter.begin(map.geometry());
    let mut rows = Vec::new();
    for k in 0..map.rows() {
        let mut levels = vec![0; map.bins()];
        filter.feed(map.row(k), |back| map.row(k - back), &mut levels);
        rows.push(levels);
    }
    let patch = angle_filter::patch(&map, 120, 50);
    for (levels, bin) in patch.iter().zip(49usize..) {
        for (level, row) in levels.iter().zip([117usize, 118, 120, 122, 123]) {
            assert_eq!(*level, rows[row + filter.lag()][bin]);
        }
    }
}

#[test]
fn an_echo_that_cfar_lets_through_is_no_oscillator_noise() {
    let config = Config::default();
    // A corner, and a scatterer 41 dB below it in the same direction at a greater range.
    let (x, y) = (0.8, 0.0);
    let far = |r: f32| (r * x, 0.4 - r * 0.4);
    let (fx, fy) = far(1.8);
    let seen = |hit: bool| {
        let mut map = scene(&config, &[(x, y, 56.0), (fx, fy, 15.0)]);
        let (range, angle) = map.geometry().polar(fx, fy);
        let bin = ((range - map.geometry().range_m(0.0)) / map.geometry().bin_m) as usize;
        let row = (0..map.rows()).find(|&k| map.angle_rad(k) > angle).unwrap();
        for k in row - 2..=row + 2 {
            map.fill(k, |row| row.mask[bin / 32] |= u32::from(hit) << (bin % 32));
        }
        let mut collector = Collector::new();
        collector.begin(&map);
        for k in 0..map.rows() {
            collector.row(&map, k);
        }
        let mut echoes = Echoes::new();
        collector.finish(
            &map,
            &config,
            &Params::DEFAULT,
            &Drive::STANDING,
            &mut echoes,
        );
        echoes
            .iter()
            .any(|e| (e.x_m - fx).abs() < 0.02 && (e.y_m - fy).abs() < 0.02)
    };
    assert!(seen(true) && !seen(false));
}

#[test]
fn an_echo_lies_where_its_scatterer_is_and_says_how_sure() {
    let config = Config::default();
    for (x, y, db) in [(0.8, 0.1, 20.0), (1.3, 0.3, 30.0), (1.7, -0.1, 40.0)] {
        let map = scene(&config, &[(x, y, db)]);
        let mut collector = Collector::new();
        collector.begin(&map);
        for k in 0..map.rows() {
            collector.row(&map, k);
        }
        let mut echoes = Echoes::new();
        collector.finish(
            &map,
            &config,
            &Params::DEFAULT,
            &Drive::STANDING,
            &mut echoes,
        );
        let echo = echoes[0];
        let (range, angle) = map.geometry().polar(x, y);
        // Cells are rounded to 0.38 dB: some 0.2 mm and 0.02 degrees of a strong echo.
        let (range_off, angle_off) = (echo.range_m - range, echo.angle_rad - angle);
        assert!(
            range_off.abs() < 3.0 * echo.range_sigma_m + 3e-4,
            "{echo:?}"
        );
        assert!(
            angle_off.abs() < 3.0 * echo.angle_sigma_rad + 6e-4,
            "{echo:?}"
        );
        assert!(
            echo.range_sigma_m < 5e-4 && echo.angle_sigma_rad < 4e-3,
            "{echo:?}"
        );
        assert!((echo.width - 1.0).abs() < 0.1, "{echo:?}");
    }
}

/// The levels of a sheared Gaussian lobe against the closed form, numerically.
#[test]
fn a_sheared_lobe_gives_its_place_back() {
    let config = Config::default();
    let map = map(&config, |_, _| 80);
    let resolution = config.radar.range_resolution_m();
    let params = &Params::DEFAULT;
    let standing = Responses::new(&map, resolution, params);
    let geometry = map.geometry();
    let sigma = f64::from(angle_filter::two_way_sigma(geometry.beamwidth_rad) / geometry.step_rad);
    let bins = f64::from(geometry.bin_m / resolution);
    let range = f64::from(lobe::GAUSSIAN_DB / params.range_curvature_db) / (bins * bins);
    for (walk_bins, steps) in [(0.0, 1.0), (-0.08, 0.98), (0.08, 1.05), (-0.3, 1.2)] {
        let walk = ScattererMotion {
            bins: walk_bins,
            steps,
        };
        let (row, bin) = (0.8, -0.3);
        let level = |d: f64, b: f64| {
            let filtered: f64 = (-60..=60)
                .map(|u| {
                    let u = f64::from(u);
                    let filter = (d - row - u) / sigma;
                    let beam = u * f64::from(steps) / sigma;
                    let off = b - bin - f64::from(walk_bins) * u;
                    (-0.5 * (filter * filter + beam * beam + off * off / range)).exp()
                })
                .sum();
            (10.0 * filtered.log10() / f64::from(angle_filter::LEVEL_DB) + 20_000.0).round() as u16
        };
        let patch = angle_filter::PATCH_BINS
            .map(|b| angle_filter::PATCH_ROWS.map(|d| level(f64::from(d), f64::from(b))));
        let lobe = Lobe::new(&patch, &standing.of_motion(walk), 30.0, params);
        let found = [lobe.row.value - row as f32, lobe.bin.value - bin as f32];
        assert!(
            found[0].abs() < 0.06 && found[1].abs() < 0.02,
            "{walk:?}: {found:?}"
        );
        assert!((lobe.width - 1.0).abs() < 0.06, "{walk:?}: {}", lobe.width);
    }
}
