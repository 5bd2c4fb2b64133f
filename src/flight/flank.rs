//! An edge on the flank of a stronger echo.
//!
//! A corner or a flash outshines the edge above it by some 20 to 35 dB, so that the edge makes no maximum
//! of the filtered map, or one that side lobes could have made. But nothing stands above the edge: beyond
//! the flank of the stronger echo's lobe, whose shape is known, the power along the riser is the edge's.
//! The map itself is read there, row by row where the riser crosses it, its lobe being narrower than the
//! filtered one. Where power exceeds the flank for most of a lobe's width, the logarithm less the lobe's
//! parabola is a straight line whose slope says where the edge is.

use crate::echoes::{Ride, two_way_sigma};
use crate::estimate::Estimate;
use crate::grid::{DB_PER_UNIT, PolarMap};
use crate::math;
use crate::params::Params;
use heapless::Vec;

/// Curvature of the two-way beam in logarithmic power, dB: 10 lg e / 2 over its variance.
const BEAM_DB: f32 = 2.171_472_4;
/// Points a standard deviation of the two-way beam at most.
const POINTS_PER_SIGMA: f32 = 8.0;
/// Most points: the reach of [`FARTHEST`] beams and what is needed below.
const MOST: usize = 64;
/// Standard deviations of the two-way beam above the stronger echo that are looked at.
const FARTHEST: f32 = 6.0;
/// So far below the stronger echo's place its peak is looked for, standard deviations.
const BELOW: f32 = 0.4;

/// What the map is read with.
#[derive(Clone, Copy, Debug)]
pub struct Chart<'m> {
    /// The map.
    pub map: &'m PolarMap,
    /// Mean noise, map units.
    pub noise: f32,
    /// Native range resolution c/2B, metres.
    pub resolution_m: f32,
    /// Error of the shaft's angle, taken off, radians.
    pub bias_rad: f32,
    /// Error of heights, taken off, metres.
    pub height_m: f32,
    /// How the chair went meanwhile, if it is known.
    pub ride: Option<Ride<'m>>,
}

/// Power over noise at one place of the riser.
#[derive(Clone, Copy, Debug)]
struct FlankSample {
    /// Angle below the stronger echo, standard deviations of the two-way beam; negative above it.
    t: f32,
    power: f32,
}

/// Weighted sums of a straight line.
#[derive(Clone, Copy, Debug, Default)]
struct LineSums {
    one: f32,
    t: f32,
    tt: f32,
    z: f32,
    tz: f32,
    zz: f32,
}

impl LineSums {
    fn add(&mut self, weight: f32, t: f32, z: f32) {
        self.one += weight;
        self.t += weight * t;
        self.tt += weight * t * t;
        self.z += weight * z;
        self.tz += weight * t * z;
        self.zz += weight * z * z;
    }

    /// Slope, sum of squared offsets, mean squared residual.
    fn fit(&self) -> (f32, f32, f32) {
        let one = math::max(self.one, f32::MIN_POSITIVE);
        let tt = math::max(self.tt - self.t * self.t / one, f32::MIN_POSITIVE);
        let tz = self.tz - self.t * self.z / one;
        let zz = self.zz - self.z * self.z / one;
        let slope = tz / tt;
        (slope, tt, math::max(zz - slope * tz, 0.0) / one)
    }
}

impl Chart<'_> {
    /// Standard deviation of the two-way beam, radians.
    pub fn sigma_rad(&self) -> f32 {
        two_way_sigma(self.map.geometry().beamwidth_rad)
    }

    /// Power over the mean noise where row `row` crosses an upright line at `x_m`.
    fn power(&self, row: usize, x_m: f32, p: &Params) -> f32 {
        let geometry = self.map.geometry();
        let cos = math::sin_cos(self.map.angle_rad(row) - self.bias_rad).1;
        let at =
            (x_m / math::max(cos, f32::MIN_POSITIVE) - geometry.first_range_m) / geometry.bin_m;
        if at < 0.0 {
            return 0.0;
        }
        let bin = math::floor(at);
        let share = at - bin;
        let bin = bin as usize;
        if bin.saturating_add(1) >= self.map.bins() {
            return 0.0;
        }
        let cell = |bin| f32::from(self.map.cell(row, bin));
        let chord = cell(bin) * (1.0 - share) + cell(bin + 1) * share;
        // Between two cells the range lobe stands above its chord.
        let bins = geometry.bin_m / self.resolution_m;
        let arch_db = p.range_curvature_db * bins * bins * share * (1.0 - share);
        math::power_ratio((chord - self.noise) * DB_PER_UNIT + arch_db)
    }

    /// The points along an upright line at `x_m` from above an echo at `angle_rad` down to it. They are filled in
    /// where they stay: a second list of them would not fit the stack.
    fn points(&self, points: &mut Vec<FlankSample, MOST>, x_m: f32, angle_rad: f32, p: &Params) {
        let sigma_rad = self.sigma_rad();
        let step_rad = math::max(self.map.geometry().step_rad, f32::MIN_POSITIVE);
        let stride = math::ceil(sigma_rad / (POINTS_PER_SIGMA * step_rad));
        let first = angle_rad - FARTHEST * sigma_rad + self.bias_rad - self.map.angle_rad(0);
        // `as` saturates.
        let first = math::ceil(first / step_rad) as usize;
        for row in
            (first.max(1)..self.map.rows().saturating_sub(1)).step_by((stride as usize).max(1))
        {
            let t = (self.map.angle_rad(row) - self.bias_rad - angle_rad) / sigma_rad;
            if t > BELOW {
                break;
            }
            let at = |row| self.power(row, x_m, p);
            let beside = 0.5 * (at(row - 1) + at(row + 1));
            let power = 0.5 * (at(row) + beside);
            if points.push(FlankSample { t, power }).is_err() {
                break;
            }
        }
    }

    /// Height of the edge above an echo at (`x_m`, `y_m`), if it shows on that one's flank.
    #[inline(never)]
    pub fn edge_above(&self, x_m: f32, y_m: f32, p: &Params) -> Option<Estimate> {
        let height_m = self.map.geometry().mount_height_m - self.height_m;
        let angle_rad = math::atan2(height_m - y_m, x_m);
        let mut points = Vec::new();
        self.points(&mut points, x_m, angle_rad, p);
        let peak = points.iter().filter(|q| q.t > -BELOW);
        let peak = peak.map(|q| q.power).fold(0.0, math::max);
        let least = math::max(
            math::power_ratio(p.flank_noise_db),
            peak * math::power_ratio(-p.flank_side_lobes_db),
        );
        let exceeds = |q: &FlankSample| {
            let lobe = peak * math::power_ratio(-BEAM_DB * q.t * q.t);
            q.t < 0.0
                && q.power > least
                && q.power > (lobe + 1.0) * math::power_ratio(p.flank_excess_db)
        };
        let run = longest(&points, exceeds);
        let (first, last) = (run.first()?, run.last()?);
        let highest = run.iter().map(|q| q.power).fold(0.0, math::max);
        if last.t - first.t < p.flank_span || highest > peak * math::power_ratio(-p.flank_weaker_db)
        {
            return None;
        }
        let mut line = LineSums::default();
        for q in run.iter().take_while(|q| q.t < first.t + p.flank_top_span) {
            let variance_db = p.flank_model_db * p.flank_model_db
                + p.flank_speckle_db * p.flank_speckle_db / q.power;
            let level_db = math::DB_PER_OCTAVE * math::log2(q.power);
            line.add(1.0 / variance_db, q.t, level_db + BEAM_DB * q.t * q.t);
        }
        let (slope, squares, residual) = line.fit();
        let t = slope / (2.0 * BEAM_DB);
        let apart = (-p.flank_farthest..-p.flank_nearest).contains(&t);
        if !apart || residual > p.flank_residual_db * p.flank_residual_db {
            return None;
        }
        let (sin, cos) = math::sin_cos(angle_rad + t * self.sigma_rad());
        let per_sigma_m = x_m * self.sigma_rad() / (cos * cos);
        let noise_m = per_sigma_m / (2.0 * BEAM_DB * math::sqrt(squares));
        Some(Estimate::new(
            height_m - x_m * sin / cos + p.flank_low_m,
            math::hypot(noise_m, p.flank_sigma_m),
        ))
    }
}

/// The longest stretch of points that exceed; the last of several as long.
fn longest(points: &[FlankSample], exceeds: impl Fn(&FlankSample) -> bool) -> &[FlankSample] {
    // `chunk_by` would do, but for its path to a panic.
    let (mut best, mut rest): (&[FlankSample], _) = (&[], points);
    while let Some(first) = rest.first() {
        let same = exceeds(first);
        let len = rest.iter().take_while(|p| exceeds(p) == same).count();
        let Some((run, behind)) = rest.split_at_checked(len) else {
            break;
        };
        if same && len >= best.len() {
            best = run;
        }
        rest = behind;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;
    use crate::echoes::tests::{map, noise};

    /// Noise of the maps made here, map units.
    const NOISE: u8 = 80;
    const X_M: f32 = 1.2;

    /// A riser at [`X_M`] with echoes at `(height, dB over the noise, phase)`, which beat.
    fn riser(points: &[(f32, f64, f64)], seed: u64) -> Box<PolarMap> {
        let config = Config::default();
        let mut blank = Box::new(PolarMap::new());
        blank.begin(&config).unwrap();
        let geometry = *blank.geometry();
        let sigma = f64::from(two_way_sigma(geometry.beamwidth_rad));
        let native = f64::from(config.radar.range_resolution_m());
        map(&config, |row, bin| {
            let angle = f64::from(blank.angle_rad(row));
            let range = f64::from(geometry.range_m(bin as f32));
            let (mut re, mut im) = (0.0, 0.0);
            for &(y, db, phase) in points {
                let (r, a) = geometry.polar(X_M, y);
                let bins = (range - f64::from(r)) / native;
                let turn = (angle - f64::from(a)) / sigma;
                let level_db = db - 6.0 * bins * bins - 2.171_472_4 * turn * turn;
                let amplitude = 10f64.powf(level_db / 20.0);
                re += amplitude * phase.cos();
                im += amplitude * phase.sin();
            }
            let phase = core::f64::consts::TAU * noise(row, bin, seed ^ 99);
            let receiver = noise(row, bin, seed).sqrt();
            re += receiver * phase.cos();
            im += receiver * phase.sin();
            let level = f64::from(NOISE) + 8.0 * (re * re + im * im).log2();
            level.round().clamp(0.0, 255.0) as u8
        })
    }

    fn edge(map: &PolarMap, y_m: f32) -> Option<Estimate> {
        let chart = Chart {
            map,
            noise: NOISE.into(),
            resolution_m: Config::default().radar.range_resolution_m(),
            bias_rad: 0.0,
            height_m: 0.0,
            ride: None,
        };
        chart.edge_above(X_M, y_m, &Params::DEFAULT)
    }

    #[test]
    fn an_edge_above_a_corner_is_where_it_is_whatever_their_phases() {
        let (mut within, mut seen, mut worst) = (0, 0, 0f32);
        let trials = 60;
        for k in 0..trials {
            let top_m = 0.15 + 0.09 + 0.0005 * k as f32;
            let phase = 0.9 * f64::from(k);
            let map = riser(&[(0.15, 46.0, 0.0), (top_m, 24.0, phase)], k.into());
            let Some(edge) = edge(&map, 0.15) else {
                continue;
            };
            seen += 1;
            let off = edge.value - top_m;
            within += u32::from(off.abs() < 2.0 * edge.sigma());
            worst = worst.max(off.abs());
        }
        assert!(seen * 10 >= trials * 8, "{seen} of {trials} seen");
        assert!(
            within * 100 >= seen * 93,
            "{within} of {seen} within two sigma"
        );
        assert!(worst < 0.035, "{worst}");
    }

    #[test]
    fn a_corner_alone_shows_no_edge() {
        for seed in 0..20 {
            let map = riser(&[(0.15, 46.0, 0.0)], seed);
            assert_eq!(edge(&map, 0.15), None);
        }
    }

    #[test]
    fn what_side_lobes_could_make_is_no_edge() {
        // Too weak, too far away, or as strong as another place of the same face.
        for (top_m, db) in [(0.25, 11.0), (0.34, 24.0), (0.25, 47.0)] {
            let map = riser(&[(0.15, 46.0, 0.0), (top_m, db, 1.0)], 3);
            assert_eq!(edge(&map, 0.15), None, "{top_m} m, {db} dB");
        }
    }

    #[test]
    fn beyond_the_map_there_is_nothing() {
        let map = riser(&[(0.15, 46.0, 0.0)], 1);
        for (x_m, y_m) in [(9.0, 0.1), (0.01, 0.0), (-1.0, 0.2), (f32::NAN, 0.1)] {
            let chart = Chart {
                map: &map,
                noise: 80.0,
                resolution_m: 0.015,
                bias_rad: 0.0,
                height_m: 0.0,
                ride: None,
            };
            assert_eq!(chart.edge_above(x_m, y_m, &Params::DEFAULT), None);
        }
    }
}
