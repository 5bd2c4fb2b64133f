//! Points of synthetic scans.

use super::*;
use crate::config::Config;
use crate::drive::ExpectedTravel;
use crate::params::Params;
use crate::signal::echoes::tests::{map, noise, uniform};
use crate::signal::echoes::{Echo, Echoes, FoundEchoes};
use crate::signal::grid::{PolarMap, two_way_sigma};
use crate::signal::range::FULL_SCALE;
use crate::signal::range::packed::Packed;
use core::f64::consts::{PI, TAU};
use core::ops::Deref;
use std::vec::Vec;

/// Level of the mean noise power in the synthetic scans, map units.
const NOISE: u8 = 80;
/// Amplitude of noise of mean power in mantissas.
const MANTISSA: f64 = 8.0;

/// A synthetic scan: its map, and its rows as complex numbers.
pub(crate) struct Seen {
    map: Box<PolarMap>,
    rows: Vec<Vec<Packed>>,
}

impl Deref for Seen {
    type Target = PolarMap;

    fn deref(&self) -> &PolarMap {
        &self.map
    }
}

impl Seen {
    /// Returns the scan whose map has the power `power`, and whose rows are `cell`; power 1 is the noise's.
    pub(crate) fn new(
        config: &Config,
        power: impl Fn(usize, usize) -> f64,
        cell: impl Fn(usize, usize) -> [f64; 2],
    ) -> Self {
        let map = map(config, |row, bin| {
            let level = f64::from(NOISE) + 8.0 * power(row, bin).log2();
            level.round().clamp(0.0, 255.0) as u8
        });
        let packed = |row, bin| {
            // The cast saturates.
            let [re, im] = cell(row, bin).map(|part| (MANTISSA * part).round() as i16);
            Packed::new(re, im)
        };
        let rows = (0..map.rows())
            .map(|row| (0..map.bins()).map(|bin| packed(row, bin)).collect())
            .collect();
        Self { map, rows }
    }

    /// Returns the coherent image, with the rows in either direction, each turned by the phase that `turn` gives.
    fn turned(
        &self,
        backwards: bool,
        referenced: bool,
        moving: bool,
        turn: impl Fn(usize) -> f64,
    ) -> Box<KeptImage> {
        let mut image = Box::new(KeptImage::new());
        image.begin(&self.map, &Config::default().radar);
        if moving {
            image.expect_motion(ExpectedTravel::default());
        }
        let last = self.rows.len().saturating_sub(1);
        for k in 0..=last {
            let row = if backwards { last - k } else { k };
            let mut bins = Vec::new();
            let mut coherent = self.coherent(row, turn(k), referenced, &mut bins);
            image.add(&self.map, row, &mut coherent);
        }
        image
    }

    /// Returns a row turned by a phase, with its bins in `bins`.
    fn coherent<'b>(
        &self,
        row: usize,
        turn: f64,
        referenced: bool,
        bins: &'b mut Vec<Packed>,
    ) -> CoherentRow<'b> {
        let units = (f64::from(NOISE) - f64::from(FULL_SCALE)) / 16.0;
        let (sin, cos) = turn.sin_cos();
        bins.extend(self.rows[row].iter().map(|x| {
            let (re, im) = (f64::from(x.re()), f64::from(x.im()));
            Packed::new(
                (re * cos - im * sin).round() as i16,
                (re * sin + im * cos).round() as i16,
            )
        }));
        CoherentRow {
            bins,
            unit: (units.exp2() / MANTISSA) as f32,
            referenced,
        }
    }

    /// Returns the coherent image, with the rows in either direction.
    fn image(&self, backwards: bool) -> Box<KeptImage> {
        self.turned(backwards, true, false, |_| 0.0)
    }

    /// Returns what the detection finds, with the rows in either direction.
    pub(crate) fn found(&self, config: &Config, backwards: bool) -> FoundEchoes {
        found(&mut self.image(backwards), self, config)
    }

    /// Returns the echoes of the scan.
    fn echoes(&self, config: &Config) -> Echoes {
        self.found(config, false).echoes
    }
}

/// Returns what the detection finds in an image of `map`.
fn found(image: &mut KeptImage, map: &PolarMap, config: &Config) -> FoundEchoes {
    let mut found = FoundEchoes::NONE;
    image.finish();
    image.detect(map, config, &mut found);
    found
}

/// Returns the echoes of an image of `map`.
fn echoes(image: &mut KeptImage, map: &PolarMap, config: &Config) -> Echoes {
    found(image, map, config).echoes
}

/// Returns a scan of point scatterers (x, y, dB above the noise) with noise.
pub(crate) fn scene(config: &Config, points: &[(f32, f32, f64)]) -> Seen {
    drawn(config, points, 7)
}

/// Returns a scan of point scatterers (x, y, dB above the noise), with the noise of a seed.
fn drawn(config: &Config, points: &[(f32, f32, f64)], seed: u64) -> Seen {
    passed(config, points, seed, |_| 0.0)
}

/// Returns the scan of [`drawn`] by a chair whose travel at a row is `travel_m`, metres.
fn passed(
    config: &Config,
    points: &[(f32, f32, f64)],
    seed: u64,
    travel_m: impl Fn(usize) -> f32,
) -> Seen {
    let mut blank = Box::new(PolarMap::new());
    blank.begin(config).unwrap();
    let geometry = *blank.geometry();
    // Two-way pattern in voltage.
    let sigma = f64::from(two_way_sigma(geometry.beamwidth_rad)) * core::f64::consts::SQRT_2;
    let native = f64::from(geometry.bin_m / config.radar.range_resolution_m());
    let per_metre = 2.0 * TAU / f64::from(config.radar.wavelength_m());
    let places = |row: usize| -> Vec<[f64; 4]> {
        let place = |(&(x, y, db), k): (&(f32, f32, f64), usize)| {
            let (first, _) = geometry.polar(x, y);
            let (range, angle) = geometry.polar(x - travel_m(row), y);
            let bin = (range - geometry.first_range_m) / geometry.bin_m;
            let phase = TAU * uniform(k, 1, seed) + per_metre * f64::from(range - first);
            [bin.into(), angle.into(), db, phase]
        };
        points.iter().zip(1..).map(place).collect()
    };
    let places: Vec<Vec<[f64; 4]>> = (0..blank.rows()).map(places).collect();
    // Amplitude of a point in a cell, and its offset in native bins.
    let amplitude = |row: usize, bin: usize, [at, a, db, _]: [f64; 4]| {
        let off = (bin as f64 - at) * native;
        let turn = (f64::from(blank.angle_rad(row)) - a) / sigma;
        (
            10f64.powf(db / 20.0) * hann(off) * (-0.5 * turn * turn).exp(),
            off,
        )
    };
    // The map's levels leave out how the points interfere, so that a row of points is a surface without speckle.
    let power = |row: usize, bin: usize| {
        let sizes = places[row]
            .iter()
            .map(|&place| amplitude(row, bin, place).0);
        noise(row, bin, seed) + sizes.map(|size| size * size).sum::<f64>()
    };
    let noise: Vec<Vec<[f64; 2]>> = (0..blank.rows())
        .map(|row| windowed_noise(row, blank.bins(), config, seed))
        .collect();
    Seen::new(config, power, |row, bin| {
        let mut cell = noise[row][bin];
        for &place in &places[row] {
            let (size, off) = amplitude(row, bin, place);
            let (sin, cos) = (place[3] - PI * off).sin_cos();
            cell = [cell[0] + size * cos, cell[1] + size * sin];
        }
        cell
    })
}

/// Returns white noise behind a Hann window and the transform, of power 1 in each of `bins` bins.
fn windowed_noise(row: usize, bins: usize, config: &Config, seed: u64) -> Vec<[f64; 2]> {
    let (samples, points) = (usize::from(config.radar.samples), config.radar.fft_len());
    let window = |n: usize| 1.0 - (TAU * n as f64 / samples as f64).cos();
    // The sum of the window's squares is 1.5 samples.
    let unit = 1.0 / (1.5 * samples as f64).sqrt();
    let values: Vec<[f64; 2]> = (0..samples)
        .map(|n| {
            let size = unit * window(n) * noise(row, n, seed).sqrt();
            let (sin, cos) = (TAU * uniform(row, n, seed + 1)).sin_cos();
            [size * cos, size * sin]
        })
        .collect();
    let phasors: Vec<(f64, f64)> = (0..points)
        .map(|k| (-TAU * k as f64 / points as f64).sin_cos())
        .collect();
    let bin = |bin: usize| {
        let terms = values.iter().enumerate().map(|(n, [re, im])| {
            let (sin, cos) = phasors[bin * n % points];
            [re * cos - im * sin, re * sin + im * cos]
        });
        terms.fold([0.0; 2], |sum, term| [sum[0] + term[0], sum[1] + term[1]])
    };
    (0..bins).map(bin).collect()
}

/// Returns the response of a Hann window at an offset of native bins.
fn hann(native: f64) -> f64 {
    let left = 1.0 - native * native;
    match native.abs() {
        x if x < 1e-9 => 1.0,
        _ if left.abs() < 1e-9 => 0.5,
        x => (PI * x).sin() / (PI * x * left),
    }
}

/// Standardised errors of range and angle over many draws have unit variance: σ is that of the noise.
#[test]
fn an_echo_lies_where_its_scatterer_is_and_says_how_sure() {
    let config = Config::default();
    for (x, y, db) in [(0.8, 0.1, 3.0), (1.31, 0.3, 12.0), (1.7, -0.1, 20.0)] {
        let mut squares = [0.0f32; 2];
        const DRAWS: u64 = 40;
        for seed in 0..DRAWS {
            let scan = drawn(&config, &[(x, y, db)], 100 + 2 * seed);
            let echo = scan.echoes(&config)[0];
            let (range, angle) = scan.geometry().polar(x, y);
            let z = [
                (echo.range_m - range) / echo.range_sigma_m,
                (echo.angle_rad - angle) / echo.angle_sigma_rad,
            ];
            squares = [0, 1].map(|k| squares[k] + z[k] * z[k] / DRAWS as f32);
            assert!((echo.snr_db - db as f32).abs() < 4.0, "{echo:?}");
        }
        for square in squares {
            assert!((0.3..1.7).contains(&square), "{db} dB: {squares:?}");
        }
    }
}

#[test]
fn the_order_of_the_rows_makes_no_difference() {
    let config = Config::default();
    let scan = scene(&config, &[(0.8, 0.0, 30.0), (1.2, 0.3, 10.0)]);
    let [there, back] =
        [false, true].map(|backwards| echoes(&mut scan.image(backwards), &scan, &config));
    assert_eq!(there, back);
}

/// Distance within which an echo is that of a point, metres.
fn has(echoes: &Echoes, x: f32, y: f32) -> bool {
    echoes
        .iter()
        .any(|e| (e.x_m - x).abs() < 0.02 && (e.y_m - y).abs() < 0.03)
}

#[test]
fn an_edge_beside_a_flash_is_seen() {
    let config = Config::default();
    // The edge is 16 dB weaker, and 5 degrees above the flash at the same distance.
    let (x, flash, edge) = (1.06, 0.4, 0.493);
    let scan = scene(&config, &[(x, flash, 45.0), (x, edge, 29.0)]);
    let found = scan.echoes(&config);
    assert!(has(&found, x, flash) && has(&found, x, edge), "{found:?}");
    // What the subtraction leaves is no echo.
    assert!(found.len() <= 4, "{found:?}");
}

#[test]
fn the_errors_of_a_strong_echo_are_no_echoes() {
    let config = Config::default();
    let alone = scene(&config, &[(0.9, 0.0, 50.0)]);
    let found = alone.echoes(&config);
    assert!(found.len() <= 2, "{found:?}");
    // Side lobes at the same range, 32 dB down; a skirt in the same beam, 42 dB down.
    let (range, angle) = alone.geometry().polar(0.9, 0.0);
    let at = |range: f32, angle: f32| alone.geometry().point(range, angle);
    let (lobe, skirt) = (at(range, angle - 0.5), at(range + 0.06, angle));
    let scan = scene(
        &config,
        &[
            (0.9, 0.0, 50.0),
            (lobe.0, lobe.1, 18.0),
            (skirt.0, skirt.1, 8.0),
        ],
    );
    let found = scan.echoes(&config);
    assert!(
        !has(&found, lobe.0, lobe.1) && !has(&found, skirt.0, skirt.1),
        "{found:?}"
    );
}

#[test]
fn noise_alone_gives_few_weak_echoes() {
    let config = Config::default();
    let counts: Vec<usize> = (0..10)
        .map(|seed| {
            let found = drawn(&config, &[], 500 + 2 * seed).echoes(&config);
            assert!(
                found
                    .iter()
                    .all(|e| e.snr_db < Params::DEFAULT.sure_echo_db),
                "{found:?}"
            );
            found.len()
        })
        .collect();
    let all: usize = counts.iter().sum();
    assert!(all <= 45, "{counts:?}");
}

#[test]
fn a_drive_turns_all_phases_and_hides_nothing() {
    let config = Config::default();
    let scan = scene(&config, &[(0.8, 0.0, 25.0), (1.2, 0.25, 20.0)]);
    for change in [0.0, 0.05, 0.6, 2.0, 3.1, -1.3] {
        let mut image = scan.turned(false, true, true, |k| change * k as f64);
        let found = echoes(&mut image, &scan, &config);
        assert!(
            has(&found, 0.8, 0.0) && has(&found, 1.2, 0.25),
            "{change}: {found:?}"
        );
        assert!(found[0].snr_db > 23.0, "{change}: {found:?}");
    }
}

/// At 1.6 mm a row a scatterer walks through two bins while it is in the beam.
#[test]
fn a_drive_leaves_scatterers_where_they_were_in_their_rows() {
    let config = Config::default();
    let points = [(1.1, 0.0, 30.0), (1.5, 0.3, 25.0), (2.4, 0.2, 25.0)];
    for (backwards, per_row_m) in [(false, 1.6e-3), (true, 1.6e-3), (false, -1e-3)] {
        let since = |row: usize| if backwards { 280 - row } else { row } as f32;
        let scan = passed(&config, &points, 7, |row| per_row_m * since(row));
        let mut image = Box::new(KeptImage::new());
        image.begin(&scan, &config.radar);
        for k in 0..281 {
            let row = if backwards { 280 - k } else { k };
            image.expect_motion(ExpectedTravel {
                since_first_m: per_row_m * k as f32,
                step_m: 0.0,
            });
            image.add(
                &scan,
                row,
                &mut scan.coherent(row, 0.0, true, &mut Vec::new()),
            );
        }
        let found = echoes(&mut image, &scan, &config);
        for (x, y, db) in points {
            // The row whose beam meets the point while the chair drives on.
            let row = (0..40).fold(140.0f32, |row, _| {
                let x = x - per_row_m * since(row as usize);
                let angle_rad = scan.geometry().polar(x, y).1;
                let next = (angle_rad - scan.angle_rad(0)) / scan.geometry().step_rad;
                0.5 * (row + next)
            });
            let seen = x - per_row_m * since(row as usize);
            let near = |e: &&Echo| (e.x_m - seen).abs() < 0.01 && (e.y_m - y).abs() < 0.02;
            let echo = found.iter().find(near);
            let echo = echo.unwrap_or_else(|| panic!("{seen}, {backwards}: {found:?}"));
            assert!(echo.snr_db > db as f32 - 3.0, "{echo:?}");
        }
        assert!(found.len() <= 8, "{found:?}");
    }
}

#[test]
fn without_a_mirror_each_row_has_its_phase_by_the_row_before() {
    let config = Config::default();
    let scan = scene(&config, &[(0.8, 0.0, 30.0)]);
    let begun = |k: usize| TAU * uniform(k, 0, 3);
    let seen = |referenced| {
        echoes(
            &mut scan.turned(false, referenced, false, begun),
            &scan,
            &config,
        )
    };
    let (with, without) = (seen(false), seen(true));
    assert!(with[0].snr_db > 28.0, "{with:?}");
    assert!(
        without.first().is_none_or(|e| e.snr_db < 25.0),
        "{without:?}"
    );
}

/// Nothing here is strong enough to show in two rows by how much it turned.
#[test]
fn faint_echoes_of_a_drive_add_up_by_the_odometer() {
    let config = Config::default();
    let points = [(0.9, 0.0, 7.0), (1.5, 0.3, 7.0)];
    let per_row_m = 0.7e-3;
    let scan = passed(&config, &points, 7, |row| per_row_m * row as f32);
    let strongest = |reported: f32| {
        let mut image = Box::new(KeptImage::new());
        image.begin(&scan, &config.radar);
        for row in 0..281 {
            // Lost rows: the odometer goes on.
            image.expect_motion(ExpectedTravel {
                since_first_m: reported * row as f32,
                step_m: if row == 0 { 0.0 } else { reported },
            });
            if row % 16 != 9 {
                let mut bins = Vec::new();
                image.add(&scan, row, &mut scan.coherent(row, 0.0, true, &mut bins));
            }
        }
        echoes(&mut image, &scan, &config)
            .first()
            .map_or(0.0, |e| e.snr_db)
    };
    // 2 % off, as odometers are.
    for reported in [per_row_m, 1.02 * per_row_m] {
        let db = strongest(reported);
        assert!((4.0..10.0).contains(&db), "{db}");
    }
    let db = strongest(0.0);
    assert!(db < 4.0, "{db}");
}

/// Returns the looks of an image at the ground's line, at these distances from the mirror, metres.
fn looks(config: &Config, scan: &Seen, places_m: impl Iterator<Item = f32>) -> Vec<Look> {
    let mut image = scan.image(false);
    let found = found(&mut image, scan, config);
    let cleaned = image.cleaned(scan, config, &found);
    let geometry = scan.geometry();
    let look = |x_m: f32| {
        let (range_m, angle_rad) = geometry.polar(x_m, 0.0);
        let bin = ((range_m - geometry.first_range_m) / geometry.bin_m).round() as usize;
        cleaned.look(bin, angle_rad).unwrap()
    };
    places_m.map(look).collect()
}

#[test]
fn a_surface_without_echoes_shows_noise_of_mean_one() {
    let config = Config::default();
    let mut looks_at_noise = Vec::new();
    for seed in 0..6 {
        let places_m = (0..40).map(|k| 0.4 + 0.035 * k as f32);
        looks_at_noise.extend(looks(&config, &drawn(&config, &[], seed), places_m));
    }
    let mean =
        looks_at_noise.iter().map(|look| look.power).sum::<f32>() / looks_at_noise.len() as f32;
    // 240 looks of an exponential distribution: four standard deviations.
    assert!((mean - 1.0).abs() < 0.26, "{mean}");
    assert!(looks_at_noise.iter().all(|look| look.background < 1.01));
}

#[test]
fn a_surface_shows_its_own_echoes_that_clean_took_out() {
    let config = Config::default();
    for db in [10.0, 25.0, 45.0] {
        let scan = scene(&config, &[(0.8, 0.0, db)]);
        let [look] = looks(&config, &scan, core::iter::once(0.8))[..] else {
            panic!("one look");
        };
        let expected_db = db as f32 + 11.8;
        // Beside it, the sweep's errors are 40 dB weaker.
        assert!(look.power > 1e3 || db < 25.0, "{look:?}");
        let seen_db = 10.0 * (look.power * look.background).log10();
        // The nearest bin, and the map's coarse levels.
        assert!(
            (seen_db - expected_db).abs() < 1.5,
            "{db}: {seen_db} of {expected_db}"
        );
    }
}

#[test]
fn an_echo_elsewhere_raises_the_background_of_a_surface_and_not_its_power() {
    let config = Config::default();
    let (range_m, _) = drawn(&config, &[], 1).geometry().polar(0.8, 0.0);
    // At the ground's range, 12 degrees above its line.
    let angle_rad = (0.4 / range_m).asin() - 12f32.to_radians();
    let above = (
        range_m * angle_rad.cos(),
        0.4 - range_m * angle_rad.sin(),
        50.0,
    );
    let mut powers = 0.0;
    for seed in 0..40 {
        let scan = drawn(&config, &[above], seed);
        let look = looks(&config, &scan, core::iter::once(0.8))[0];
        // Side lobes 30 dB below 61.8 dB.
        assert!((look.background.log10() - 3.18).abs() < 0.2, "{look:?}");
        powers += look.power / 40.0;
    }
    assert!(powers < 1.5, "{powers}");
}
