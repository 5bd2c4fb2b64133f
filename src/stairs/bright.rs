//! Where the map is bright: what the particles are drawn around and weighed with (paper III-A).

use heapless::Vec;
use rand_core::Rng;

use super::map::{DB_PER_UNIT, PolarMap};
use super::particles::{Gaussian, Particle, UNITS_PER_CELL, uniform};
use crate::config::{MAX_MODES, ParticleConfig, Spread};
use crate::math;

/// Most bins of one row.
const MAX_BINS: usize = 256;

/// Cells down to this far below the strongest are high-intensity places, decibels.
const HIGH_INTENSITY_DB: f32 = 20.0;

/// Echoes this far below the strongest at their own range cannot be told from what the beam's
/// side lobes make of it, decibels: a nosing 10 dB below the corner under it, seen from 3 dB
/// (one-way) beside the beam's axis, is 16 dB below.
const SIDE_LOBE_DB: f32 = 20.0;

/// `db` in units of a cell.
const fn units(db: f32) -> u8 {
    (db / DB_PER_UNIT) as u8
}

/// The map's levels, gathered row by row while the scan goes on; the order of the rows does not
/// matter.
#[derive(Clone, Debug)]
pub struct Levels {
    /// Least cell of all: the minimum received power.
    floor: u8,
    /// Strongest cell of all.
    peak: u8,
    /// Strongest cell that CA-CFAR let through.
    hit_peak: u8,
    /// The same for each range bin.
    column_peak: [u8; MAX_BINS],
    /// Number of cells that CA-CFAR let through.
    hits: u32,
}

impl Levels {
    /// Levels of a map without rows.
    pub const fn new() -> Self {
        Self {
            floor: u8::MAX,
            peak: 0,
            hit_peak: 0,
            column_peak: [0; MAX_BINS],
            hits: 0,
        }
    }

    /// Forgets all rows.
    pub fn clear(&mut self) {
        self.floor = u8::MAX;
        self.peak = 0;
        self.hit_peak = 0;
        self.column_peak.fill(0);
        self.hits = 0;
    }

    /// Number of cells that CA-CFAR let through.
    pub fn hits(&self) -> u32 {
        self.hits
    }

    /// Takes row `row` of `map` in.
    pub fn add_row(&mut self, map: &PolarMap, row: usize) {
        for &cell in map.row(row) {
            self.floor = self.floor.min(cell);
            self.peak = self.peak.max(cell);
        }
        for (bin, cell) in map.hits(row) {
            self.hits += 1;
            self.hit_peak = self.hit_peak.max(cell);
            if let Some(peak) = self.column_peak.get_mut(bin) {
                *peak = cell.max(*peak);
            }
        }
    }

    /// Strongest hit within one bin of `bin`, the width of a range lobe.
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

impl Default for Levels {
    fn default() -> Self {
        Self::new()
    }
}

/// The map as the particles see it: raw, or with everything below the CFAR threshold at the
/// minimum received power (paper III-C).
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    map: &'a PolarMap,
    levels: &'a Levels,
    cfar: bool,
}

impl<'a> Field<'a> {
    /// The field that `spread` starts from; `levels` are those of `map`.
    pub fn new(map: &'a PolarMap, levels: &'a Levels, spread: Spread) -> Self {
        Self {
            map,
            levels,
            cfar: spread == Spread::GmmCfar,
        }
    }

    /// Least level of a high-intensity cell.
    fn bright(&self) -> u8 {
        let peak = match self.cfar {
            true => self.levels.hit_peak,
            false => self.levels.peak,
        };
        peak.saturating_sub(units(HIGH_INTENSITY_DB)).max(1)
    }

    /// Power above the minimum at a particle's place (angle, range), units of a cell; 0 outside
    /// the map and, on the CFAR map, below the threshold and where only a side lobe is.
    pub fn weight(&self, particle: &Particle) -> u16 {
        let Some((row, bin)) = particle.cell() else {
            return 0;
        };
        let cell = self.map.cell(row, bin);
        if self.cfar {
            let least = self.levels.column(bin).saturating_sub(units(SIDE_LOBE_DB));
            if cell < least || !self.map.hit(row, bin) {
                return 0;
            }
        }
        u16::from(cell.saturating_sub(self.levels.floor))
    }

    /// Whether a particle lies in a high-intensity cell.
    pub fn is_bright(&self, particle: &Particle) -> bool {
        particle.cell().is_some_and(|(row, bin)| {
            self.map.cell(row, bin) >= self.bright() && (!self.cfar || self.map.hit(row, bin))
        })
    }

    /// Calls `take` with the row and bin of each high-intensity cell, row by row.
    fn each_bright(&self, mut take: impl FnMut(usize, usize)) {
        let bright = self.bright();
        for row in 0..self.map.rows() {
            if self.cfar {
                let cells = self.map.hits(row).filter(|&(_, cell)| cell >= bright);
                cells.for_each(|(bin, _)| take(row, bin));
            } else {
                let cells = self.map.row(row).iter().enumerate();
                cells
                    .filter(|(_, cell)| **cell >= bright)
                    .for_each(|(bin, _)| take(row, bin));
            }
        }
    }

    /// Draws `config`'s number of modes: Gaussians around randomly chosen high-intensity cells,
    /// each as likely as the other. None when there is no such cell.
    ///
    /// One random offset and equal distances from then on (systematic sampling) spread the modes
    /// over all bright places, where independent draws would now and then leave one out.
    pub fn modes(&self, config: &ParticleConfig, rng: &mut impl Rng) -> Vec<Gaussian, MAX_MODES> {
        let mut count = 0_u32;
        self.each_bright(|_, _| count += 1);
        let offset = uniform(rng, count);
        let number = u32::from(config.modes).clamp(1, MAX_MODES as u32);
        let mut modes = Vec::new();
        // The k-th mode stands on the cell of rank (offset + k count) / number.
        let mut below = offset;
        let mut until_next = below / number;
        self.each_bright(|row, bin| {
            while until_next == 0 && modes.len() < number as usize {
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

    /// A mode around the cell (`row`, `bin`): as wide across the beam as along it.
    fn gaussian(&self, config: &ParticleConfig, row: usize, bin: usize) -> Gaussian {
        let geometry = self.map.geometry();
        let unit = f32::from(UNITS_PER_CELL);
        let sigma_m = config.mode_sigma as f32 * 1e-5;
        let range = geometry.range_m(bin as f32).max(geometry.bin_m);
        // `as` saturates, and makes 0 of what is not a number.
        Gaussian {
            mean: [row, bin].map(|k| (k as f32 * unit) as i16),
            sigma: [
                (unit * sigma_m / (range * geometry.step_rad)) as u16,
                (unit * sigma_m / geometry.bin_m) as u16,
            ],
        }
    }

    /// A place somewhere on the map, each area of the sagittal plane as likely as the other.
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
