//! Sums across the swept plane, over the columns and patches of a facet or edge that the beam
//! lights.

use core::f64::consts::PI;

use num_complex::Complex64;

use super::facets::Columns;
use super::geometry::Lateral;
use super::maths::{cis, cis_all};
use super::sight::Shade;
use super::view::View;

/// Combined echo of several columns of a facet or edge.
#[derive(Clone, Copy, Default)]
pub struct Strip {
    /// Complex √σ of the strip if its surface has unit strength per metre: sum of the columns' phase factors, gains and
    /// widths.
    pub sum: Complex64,
    /// Effective width that the two-way beam lights, in terms of power, metres.
    pub lit: f64,
    /// Additional range relative to the column in the profile's plane, metres.
    pub farther: f64,
}

/// Maximum range difference of columns that are summed into one strip, metres: a seventh of the finest range
/// resolution. Only a beam with yaw needs more than one strip.
const STRIP: f64 = 2e-3;

/// Number of columns that are computed at once.
pub const BLOCK: usize = 32;

/// Minimum power of a strip relative to the strongest one; weaker strips are left out.
const DARK: f64 = 1e-6;

/// Geometry across the plane of a scatterer: its extent, the lengths of the way out and back, and the forward
/// components of the directions in which these leave the scanner.
pub struct Across<'a> {
    /// Extent across the plane.
    pub lateral: &'a Lateral,
    /// Lengths of the way out and back, metres.
    pub legs: [f64; 2],
    /// Forward components of the unit vectors of the way out and the way back, seen from the scanner.
    pub forward: [f64; 2],
}

/// Width across the plane of a patch of a facet that scatters as one, metres. It is narrow enough
/// that the wave front turns by at most half a wave over a patch at the beam's edge.
pub const PATCH: f64 = 8e-3;

/// A block of neighbouring columns.
#[derive(Default)]
struct Block {
    /// Offsets of the columns from the plane, metres.
    places: [f64; BLOCK],
    /// Cosines and sines of the columns' two-way phases.
    phasors: ([f64; BLOCK], [f64; BLOCK]),
    /// Two-way amplitude gains times widths, metres.
    weights: [f64; BLOCK],
    /// Squares of the two-way amplitude gains times widths, metres.
    lit: [f64; BLOCK],
    /// Additional range of the columns relative to that in the profile's plane, metres.
    farther: [f64; BLOCK],
}

impl Block {
    /// Adds the first `count` columns to their strips, except those that `hidden` says are not in sight.
    fn add_to(&self, strips: &mut Vec<Strip>, count: usize, hidden: impl Fn(f64) -> bool) {
        let (cosines, sines) = &self.phasors;
        let mut sum = Strip::default();
        let mut current = usize::MAX;
        for i in 0..count {
            if hidden(self.places[i]) {
                continue;
            }
            let strip = (self.farther[i] / STRIP) as u32 as usize;
            if strip != current {
                if let Some(strip) = strips.get_mut(current) {
                    *strip = sum;
                }
                if strips.len() <= strip {
                    strips.resize(strip + 1, Strip::default());
                }
                (current, sum) = (strip, strips[strip]);
            }
            let weight = self.weights[i];
            sum.sum += Complex64::new(cosines[i] * weight, sines[i] * weight);
            sum.lit += self.lit[i];
            sum.farther += self.farther[i] * self.lit[i];
        }
        if let Some(strip) = strips.get_mut(current) {
            *strip = sum;
        }
    }
}

impl View<'_> {
    /// Returns the tangent of the angle beside the profile's plane up to which the beam lights surfaces.
    pub fn lateral_reach(&self) -> f64 {
        self.beam.lateral_reach() + libm::tan(self.world.yaw).abs()
    }

    /// Sums the echoes of a scatterer's columns across the plane, strip by strip. `paths` returns, for a block of
    /// columns, the additional two-way path relative to a flat surface, metres, from the first column's index and the
    /// columns' places beside the plane. `hidden` tells whether the column at a place is out of sight.
    pub fn across(
        &self,
        a: &Across,
        paths: impl Fn(i64, &[f64; BLOCK]) -> [f64; BLOCK],
        hidden: impl Fn(f64) -> bool,
    ) -> Vec<Strip> {
        let [out, back] = a.legs;
        let columns = Columns::new(a.lateral, out.min(back) * self.lateral_reach());
        let bend = 0.5 * (1.0 / out + 1.0 / back);
        let (sin, cos) = libm::sincos(self.world.yaw);
        // Angle between a column's ray and the swept plane.
        let aside = |leg: usize| (cos / a.legs[leg], -a.forward[leg] * sin);
        let light = self
            .beam
            .lateral_pair([aside(0), aside(1)], columns.spacing);
        let tilt = self.wavenumber * bend * columns.spacing;
        // Without yaw, the beam ends before the ranges of its columns differ.
        let stretch = if sin == 0.0 { 0.0 } else { 0.5 * bend };
        let mut strips: Vec<Strip> = Vec::new();
        for first in (columns.low..columns.high).step_by(BLOCK) {
            let mut block = Block {
                places: core::array::from_fn(|i| columns.centre(first + i as i64)),
                ..Block::default()
            };
            let gains: [f64; BLOCK] = light.gains(block.places[0]);
            let mut phases = paths(first, &block.places);
            for (i, z) in block.places.iter().enumerate() {
                phases[i] = self.wavenumber * (z * z * bend + phases[i]);
                let turn = tilt * z;
                block.weights[i] = gains[i] * columns.spacing * (1.0 - turn * turn / 6.0).max(0.0);
                block.lit[i] = gains[i] * gains[i] * columns.spacing;
                block.farther[i] = stretch * z * z;
            }
            block.phasors = cis_all(&phases);
            let count = (columns.high - first).min(BLOCK as i64) as usize;
            block.add_to(&mut strips, count, &hidden);
        }
        // Unlit strips give no echo. A surface that lies in no column stays as one strip without
        // power.
        let brightest = strips.iter().map(|s| s.lit).fold(0.0, f64::max);
        strips.retain(|s| sin == 0.0 || s.lit > DARK * brightest);
        if strips.is_empty() {
            strips.push(Strip::default());
        }
        for s in &mut strips {
            s.sum /= PI.sqrt();
            s.farther /= s.lit.max(f64::MIN_POSITIVE);
        }
        strips
    }

    /// Returns the number of patches of a facet that the beam lights at a distance of `r` metres.
    pub fn patch_count(&self, r: f64) -> usize {
        2 * (r * self.lateral_reach() / PATCH) as usize + 1
    }

    /// Returns √σ of the diffuse scatterers of a facet, strip by strip. `draw` returns the scatterers patch by patch
    /// from the middle outwards, so that a wider or narrower view draws the same ones. The facet lies `r` metres away,
    /// in a direction with the forward component `forward`; `direct` is the shade on it.
    pub fn patches(
        &self,
        lateral: &Lateral,
        (r, forward): (f64, f64),
        direct: &Shade,
        mut draw: impl FnMut() -> Complex64,
    ) -> Vec<Strip> {
        let (sin, cos) = libm::sincos(self.world.yaw);
        let mut strips: Vec<Strip> = Vec::new();
        for k in 0..self.patch_count(r) as i64 {
            let z = PATCH * ((k + 1) / 2) as f64 * if k % 2 == 0 { 1.0 } else { -1.0 };
            let scatterer = draw();
            if direct.covers(z) || (z - lateral.centre).abs() > lateral.half {
                continue;
            }
            let gain = self.beam.lateral(z * cos / r - forward * sin).powi(2);
            let farther = if sin == 0.0 { 0.0 } else { 0.5 * z * z / r };
            let strip = (farther / STRIP) as usize;
            if strips.len() <= strip {
                strips.resize(strip + 1, Strip::default());
            }
            strips[strip].sum += scatterer * gain * cis(self.wavenumber * z * z / r);
            strips[strip].lit += gain * gain;
            strips[strip].farther += farther * gain * gain;
        }
        strips.retain(|s| s.lit > DARK);
        for s in &mut strips {
            s.farther /= s.lit;
        }
        strips
    }
}
