//! High-intensity cells of the map, around which the particles are drawn and by which they are weighted (paper
//! III-A).

use core::num::NonZeroU32;

use heapless::Vec;
use rand_core::Rng;

use super::particles::{Gaussian, PointParticle, UNITS_PER_CELL, uniform};
use crate::config::{MAX_MODES, ParticleConfig, Spread};
use crate::math;
use crate::signal::grid::{DB_PER_UNIT, PolarMap};

/// Maximum number of range bins of a row.
const MAX_BINS: usize = 256;

/// Maximum difference from the strongest cell's level at which a cell is of high intensity, dB. A nosing is about 10
/// dB weaker than the corner under it, and that of the first step, seen obliquely, is weaker still.
pub const HIGH_INTENSITY_DB: f32 = 25.0;

/// Level below the strongest echo at the same range at which an echo counts as that one's side lobe, dB. It keeps a
/// nosing 10 dB below its corner in the beam's main lobe, and removes the side lobes that make the corner of a bright
/// step look like a pillar.
const SIDE_LOBE_DB: f32 = 25.0;

/// Converts dB to map units (1/8 octave of power, 0.376 dB), rounded down.
const fn units(db: f32) -> u8 {
    (db / DB_PER_UNIT) as u8
}

/// Extreme levels of the map's cells and detections, map units, collected row by row during the scan, in any order of
/// the rows.
#[derive(Clone, Debug)]
pub struct MapLevels {
    /// Minimum level of all cells, the minimum received power, map units.
    floor: u8,
    /// Maximum level of all cells, map units.
    peak: u8,
    /// Maximum level of the cells with a CA-CFAR detection, map units.
    detection_peak: u8,
    /// Entry k: maximum level of the cells with a CA-CFAR detection in range bin k, map units.
    column_peak: [u8; MAX_BINS],
    /// Number of CA-CFAR detections of the map.
    detections: u32,
}

impl MapLevels {
    /// Returns the levels of a map without rows.
    pub const fn new() -> Self {
        Self {
            floor: u8::MAX,
            peak: 0,
            detection_peak: 0,
            column_peak: [0; MAX_BINS],
            detections: 0,
        }
    }

    /// Sets the levels to those of a map without rows, before a scan.
    pub fn clear(&mut self) {
        self.floor = u8::MAX;
        self.peak = 0;
        self.detection_peak = 0;
        self.column_peak.fill(0);
        self.detections = 0;
    }

    /// Returns the number of CA-CFAR detections of the map.
    pub fn hits(&self) -> u32 {
        self.detections
    }

    /// Updates the levels by the cells and detections of row `row` of `map`.
    pub fn add_row(&mut self, map: &PolarMap, row: usize) {
        for &cell in map.row(row) {
            self.floor = self.floor.min(cell);
            self.peak = self.peak.max(cell);
        }
        for (bin, cell) in map.detections(row) {
            self.detections += 1;
            self.detection_peak = self.detection_peak.max(cell);
            if let Some(peak) = self.column_peak.get_mut(bin) {
                *peak = cell.max(*peak);
            }
        }
    }

    /// Returns the level of the strongest detection within one range bin of `bin`, the width of a range lobe, map
    /// units; 0 without one.
    fn column(&self, bin: usize) -> u8 {
        let near = self.column_peak.get(bin.saturating_sub(1)..);
        near.unwrap_or(&[])
            .iter()
            .take(3)
            .copied()
            .max()
            .unwrap_or(0)
    }
}

impl Default for MapLevels {
    fn default() -> Self {
        Self::new()
    }
}

/// The map from which particles are weighted: raw, or with all cells below the CFAR threshold at the minimum received
/// power (paper III-C).
#[derive(Clone, Copy, Debug)]
pub struct IntensityMap<'a> {
    map: &'a PolarMap,
    levels: &'a MapLevels,
    cfar: bool,
}

impl<'a> IntensityMap<'a> {
    /// Returns the map from which particles are weighted: the CFAR map for the initial distribution `GmmCfar`, else the
    /// raw map; `levels` are those of `map`.
    pub fn new(map: &'a PolarMap, levels: &'a MapLevels, spread: Spread) -> Self {
        Self {
            map,
            levels,
            cfar: spread == Spread::GmmCfar,
        }
    }

    /// Returns the minimum level of a high-intensity cell, map units.
    fn min_high_intensity(&self) -> u8 {
        let peak = match self.cfar {
            true => self.levels.detection_peak,
            false => self.levels.peak,
        };
        peak.saturating_sub(units(HIGH_INTENSITY_DB)).max(1)
    }

    /// Returns the power above the minimum at a particle's place (angle, range), in map units of 1/8 octave. It is 0
    /// outside the map and, on the CFAR map, below the threshold and at side lobes.
    pub fn weight(&self, particle: &PointParticle) -> u16 {
        let Some((row, bin)) = particle.cell() else {
            return 0;
        };
        let cell = self.map.cell(row, bin);
        if self.cfar {
            let least = self.levels.column(bin).saturating_sub(units(SIDE_LOBE_DB));
            if cell < least || !self.map.is_detected(row, bin) {
                return 0;
            }
        }
        u16::from(cell.saturating_sub(self.levels.floor))
    }

    /// Calls `take` with the row and bin of each high-intensity cell, row by row.
    fn each_high_intensity(&self, take: &mut dyn FnMut(usize, usize)) {
        let bright = self.min_high_intensity();
        for row in 0..self.map.rows() {
            if self.cfar {
                let cells = self.map.detections(row).filter(|&(_, cell)| cell >= bright);
                cells.for_each(|(bin, _)| take(row, bin));
            } else {
                let cells = self.map.row(row).iter().enumerate();
                cells
                    .filter(|(_, cell)| **cell >= bright)
                    .for_each(|(bin, _)| take(row, bin));
            }
        }
    }

    /// Draws `config`'s number of modes: Gaussians around random high-intensity cells, all equally likely. It returns
    /// none if there is no such cell.
    ///
    /// Systematic sampling (one random offset, then equal distances) spreads the modes over all high-intensity
    /// places. Independent draws would sometimes miss one.
    pub fn modes(&self, config: &ParticleConfig, rng: &mut impl Rng) -> Vec<Gaussian, MAX_MODES> {
        let mut count = 0_u32;
        self.each_high_intensity(&mut |_, _| count += 1);
        let offset = uniform(rng, count);
        let number = u32::from(config.modes).min(MAX_MODES as u32);
        let number = NonZeroU32::new(number).unwrap_or(NonZeroU32::MIN);
        let mut modes = Vec::new();
        // The k-th mode is at the cell of rank (offset + k count) / number.
        let mut below = offset;
        let mut until_next = below / number;
        self.each_high_intensity(&mut |row, bin| {
            while until_next == 0 && modes.len() < number.get() as usize {
                if modes.push(self.gaussian(config, row, bin)).is_err() {
                    return;
                }
                below = below % number + count;
                until_next = below / number;
            }
            until_next = until_next.saturating_sub(1);
        });
        modes
    }

    /// Returns a mode around the cell (`row`, `bin`), as wide across the beam as along it, in particle coordinates.
    fn gaussian(&self, config: &ParticleConfig, row: usize, bin: usize) -> Gaussian {
        let geometry = self.map.geometry();
        let unit = f32::from(UNITS_PER_CELL);
        let sigma_m = config.mode_sigma as f32 * 1e-5;
        let range = geometry.range_m(bin as f32).max(geometry.bin_m);
        // `as` saturates, and converts NaN to 0.
        Gaussian {
            mean: [row, bin].map(|k| (k as f32 * unit) as i16),
            sigma: [
                (unit * sigma_m / (range * geometry.step_rad)) as u16,
                (unit * sigma_m / geometry.bin_m) as u16,
            ],
        }
    }

    /// Returns a random place on the map, evenly distributed over the area of the sagittal plane: angle and range,
    /// units of 1/64 cell.
    pub fn anywhere(&self, rng: &mut impl Rng) -> [i16; 2] {
        let geometry = self.map.geometry();
        let unit = f32::from(UNITS_PER_CELL);
        let near = geometry.range_m(-0.5);
        let far = geometry.range_m(self.map.bins() as f32 - 0.5);
        let share = uniform(rng, 1 << 24) as f32 / (1 << 24) as f32;
        let range = math::sqrt(near * near + share * (far * far - near * near));
        let bin = (range - geometry.first_range_m) / geometry.bin_m;
        let row = uniform(rng, self.map.rows() as u32 * UNITS_PER_CELL as u32);
        let first = -i32::from(UNITS_PER_CELL) / 2;
        [(row as i32 + first) as i16, (bin * unit) as i16]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;
    use rand_core::SeedableRng;
    use rand_xoshiro::Xoshiro128PlusPlus;

    /// The default scan with cells of level 40 and these detections: row, range bin, level in map units.
    fn scan(hits: &[(usize, usize, u8)]) -> (PolarMap, MapLevels) {
        let mut map = PolarMap::new();
        map.begin(&Config::default()).unwrap();
        let mut levels = MapLevels::new();
        for row in 0..map.rows() {
            map.fill(row, |cells| {
                cells.cells.fill(40);
                for &(_, bin, level) in hits.iter().filter(|h| h.0 == row) {
                    cells.cells[bin] = level;
                    cells.mask[bin / 32] |= 1 << (bin % 32);
                }
            });
            levels.add_row(&map, row);
        }
        (map, levels)
    }

    fn at(row: i16, bin: i16) -> PointParticle {
        PointParticle {
            at: [row * UNITS_PER_CELL, bin * UNITS_PER_CELL],
            ..PointParticle::default()
        }
    }

    fn rng(seed: u64) -> Xoshiro128PlusPlus {
        Xoshiro128PlusPlus::seed_from_u64(seed)
    }

    #[test]
    fn weights_are_decibels_above_the_minimum_where_something_was_detected() {
        let below = units(SIDE_LOBE_DB);
        let (map, levels) = scan(&[(10, 20, 200), (99, 21, 200 - below), (50, 20, 199 - below)]);
        assert_eq!(levels.hits(), 3);
        let cfar = IntensityMap::new(&map, &levels, Spread::GmmCfar);
        assert_eq!(cfar.weight(&at(10, 20)), 160);
        assert_eq!(cfar.weight(&at(99, 21)), 160 - u16::from(below));
        assert_eq!(cfar.weight(&at(50, 20)), 0, "a side lobe");
        assert_eq!(cfar.weight(&at(10, 19)), 0, "below the threshold");
        assert_eq!(cfar.weight(&at(-1, 20)), 0, "outside");
        assert_eq!(cfar.weight(&at(10, 400)), 0, "outside");
        let raw = IntensityMap::new(&map, &levels, Spread::GmmRaw);
        assert_eq!(raw.weight(&at(50, 20)), 159 - u16::from(below));
        assert_eq!(raw.weight(&at(10, 19)), 0, "the minimum itself");
    }

    #[test]
    fn each_bright_cell_is_as_likely_as_the_other() {
        let bright: std::vec::Vec<(usize, usize, u8)> =
            (0..25).map(|k| (7 * k, 5 * k, 200 - k as u8)).collect();
        let dim = [(200, 3, 200 - units(HIGH_INTENSITY_DB) - 1)];
        let (map, levels) = scan(&[&bright[..], &dim[..]].concat());
        let field = IntensityMap::new(&map, &levels, Spread::GmmCfar);
        let config = ParticleConfig::default();
        let mut drawn = [0_u32; 25];
        let runs = 5000;
        let mut rng = rng(4);
        for _ in 0..runs {
            let modes = field.modes(&config, &mut rng);
            assert_eq!(modes.len(), 10);
            for mode in &modes {
                let [row, bin] = mode.mean.map(|c| usize::from(c as u16 / 64));
                assert_eq!((row % 7, bin), (0, row / 7 * 5));
                drawn[row / 7] += 1;
            }
        }
        for n in drawn {
            let share = f64::from(n) / f64::from(runs);
            assert!((share - 10.0 / 25.0).abs() < 0.03, "{share}");
        }
    }

    #[test]
    fn modes_are_as_wide_across_the_beam_as_along_it() {
        let (map, levels) = scan(&[(100, 60, 200)]);
        let field = IntensityMap::new(&map, &levels, Spread::GmmCfar);
        let config = ParticleConfig::default();
        let modes = field.modes(&config, &mut rng(1));
        assert_eq!(modes.len(), 10, "a single cell takes all modes");
        let geometry = map.geometry();
        let [rows, bins] = modes[0].sigma.map(|s| f32::from(s) / 64.0);
        assert!((bins * geometry.bin_m - 0.08).abs() < 2e-4);
        assert!((rows * geometry.step_rad * geometry.range_m(60.0) - 0.08).abs() < 2e-4);
    }

    #[test]
    fn without_detections_there_are_no_modes() {
        let (map, levels) = scan(&[]);
        let field = IntensityMap::new(&map, &levels, Spread::GmmCfar);
        let modes = field.modes(&ParticleConfig::default(), &mut rng(1));
        assert!(modes.is_empty());
    }

    #[test]
    fn anywhere_is_everywhere_alike() {
        let (map, levels) = scan(&[]);
        let field = IntensityMap::new(&map, &levels, Spread::Uniform);
        let geometry = map.geometry();
        let mut rng = rng(9);
        let (mut nearer, mut upper) = (0, 0);
        let n = 20_000;
        // Radius within which half of the area of a ring lies.
        let (near, far) = (
            geometry.range_m(-0.5),
            geometry.range_m(map.bins() as f32 - 0.5),
        );
        let middle = ((near * near + far * far) / 2.0).sqrt();
        for _ in 0..n {
            let particle = PointParticle {
                at: field.anywhere(&mut rng),
                ..PointParticle::default()
            };
            let (row, bin) = particle.cell().expect("within the map");
            assert!(row < map.rows() && bin < map.bins());
            nearer += u32::from(geometry.range_m(f32::from(particle.at[1]) / 64.0) < middle);
            upper += u32::from(row < map.rows() / 2);
        }
        assert!(nearer.abs_diff(n / 2) < 300 && upper.abs_diff(n / 2) < 350);
    }

    #[test]
    fn the_order_of_rows_does_not_matter() {
        let (map, levels) = scan(&[(10, 20, 200), (99, 21, 100)]);
        let mut reverse = MapLevels::new();
        (0..map.rows()).rev().for_each(|k| reverse.add_row(&map, k));
        assert_eq!(format!("{levels:?}"), format!("{reverse:?}"));
    }
}
