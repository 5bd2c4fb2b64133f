//! The measurement model going up: likelihood of the scan's echoes, given a staircase.
//!
//! Point features (corners, nosings, flashes, edges) have one echo each, with a probability of detection. Extended
//! features (floor, treads, faces) and noise have echoes as a Poisson process. With b(z) the density of echo z from
//! everything but point features, and Λ the expected number of such echoes,
//!
//! ```text
//! ln p(Z) = Σ ln b(z) - Λ + Σ over risers ln( p₀ + (1 - p₀) (Π z_f - Π(1 - P_f)) / (1 - Π(1 - P_f)) )
//! z_f     = 1 - P_f + P_f Σ over echoes (1 - used) p_f(z) / b(z)
//! ```
//!
//! where p₀ is the probability that a riser has no echo at all: a riser that is detected has at least one. The share
//! `used` of an echo that was assigned to one feature is not available to the next.

use super::feature::{Class, FeaturePlace, Spot, excess_level};
use super::kinds::{drop, wall};
use super::normal::{above, ln, logistic, tailed};
use super::sight::sight_m;
use super::staircase::{Staircase, View};
use super::surfaces::Surfaces;
use crate::math;
use crate::params::Numbers;
use crate::params::generative::{EXTENDED, Extended, Generative, POINTS, Point};
pub use crate::params::image::LEAST_DB as MIN_DB;
use crate::params::posterior::{
    self, BEHIND_RISER_M, CLEAN_WIDTH, CROSS_GATE_M, FACE_REACH, MAX_P_DETECTED, MIN_P_DETECTED,
    NEAREST_ECHO_M, NOISE_EXTENT, RANGE_GATE_M, SECTOR_AREA_M2,
};
use crate::signal::echoes::Echo;
use crate::signal::grid::Geometry;
use crate::sort::shell_sort;
use heapless::Vec;

/// Maximum number of echoes in the model, the strongest: those of a staircase's features, and as many others.
pub const MAX_MODEL_ECHOES: usize = 32;
/// Maximum number of echoes near one riser that are assigned to its point features.
pub const NEAR: usize = 16;
/// 1 / √(2π).
const GAUSS: f32 = 0.398_942_3;
/// Minimum density of an echo, so that its logarithm is finite.
const MIN_DENSITY: f32 = 1e-12;
/// Minimum product of densities before its logarithm is taken, so that one more factor does not underflow.
const MIN_PRODUCT: f32 = 1e-16;

/// Suffix sums of a log-likelihood over the echoes, the nearest first: entry i is the sum over echo i and all farther
/// ones, the last entry 0.
pub type EchoSums = [f32; MAX_MODEL_ECHOES + 1];

/// An echo with its densities under the model.
#[derive(Clone, Copy, Debug, Default)]
pub struct ModelEcho {
    /// Horizontal distance of the echo from the mirror, metres.
    pub x_m: f32,
    /// Height of the echo above the ground, metres.
    pub y_m: f32,
    /// Range of the echo from the mirror, metres.
    pub range_m: f32,
    /// Standard deviation of the echo's position across the line of sight, metres.
    pub across_m: f32,
    /// Width of the echo's lobe over the angle above that of an undisturbed one, 0 to 0.5, in units of a point
    /// scatterer's.
    pub wide: f32,
    /// Power of the echo over the noise, dB.
    pub snr_db: f32,
    /// Densities of the echo that do not depend on the staircase, by class of extended feature.
    noise: f32,
    air: f32,
    inside: f32,
    tread: f32,
    floor: f32,
    face: f32,
    point: [f32; POINTS],
    /// Reciprocals of the standard deviations of the echo's distance perpendicular to tread, floor and face, per metre.
    per_tread: f32,
    per_floor: f32,
    per_face: f32,
}

/// The measurement model with the echoes of a scan.
pub struct Model<'p> {
    /// Echoes, the nearest first.
    pub echoes: Vec<ModelEcho, MAX_MODEL_ECHOES>,
    /// Log-likelihood ratios of a drop or a riser to ground that goes on, from the power along the ground's line.
    pub surfaces: Surfaces,
    /// Field of view of the scan.
    pub view: View,
    /// Height of the mirror above the ground, metres.
    pub height_m: f32,
    /// Strength of the scan: SNR of its strongest echo less 30 dB, in tens of dB.
    pub q: f32,
    /// Angle between two features from which on they have separate echoes, radians.
    pub beam_rad: f32,
    /// Range difference between two features from which on they have separate echoes, metres.
    pub cell_m: f32,
    /// Expected numbers of echoes in a scan of strength `q`, by class of extended feature (face, tread, floor, air,
    /// inside, noise), per metre or per scan.
    rates: [f32; EXTENDED],
    /// Parameters of the model, counted from simulated scans.
    pub g: &'p Generative,
    /// Tuned numbers.
    pub numbers: Numbers,
}

/// The most probable echo of a feature, as a reading of the feature's height.
#[derive(Clone, Copy, Debug)]
pub struct LevelReading<'e> {
    /// Most probable echo of the feature.
    pub echo: &'e ModelEcho,
    /// Height of the feature above the ground by this echo, metres.
    pub level_m: f32,
    /// Standard deviation of the feature's height, metres. It grows with the doubt that the echo is the feature's, and
    /// with the probability that its deviation comes from the density's tails.
    pub sigma_m: f32,
    /// Whether a flash beside the feature covers the feature's own echo, so that this echo is no measurement of its
    /// height.
    pub masked: bool,
}

/// Returns the density of an echo's SNR `snr_db`, per dB: normal with mean `mean` and standard deviation `sigma`, dB,
/// cut off at the detection threshold, with share `flat` evenly distributed.
pub fn level_density(snr_db: f32, mean: f32, sigma: f32, flat: f32) -> f32 {
    let z = (snr_db - mean) / sigma;
    let tail = math::max(
        above((MIN_DB - mean) / sigma),
        posterior::MIN_DETECTED_SHARE,
    );
    (1.0 - flat) * math::exp(-0.5 * z * z) * GAUSS / sigma / tail + flat / posterior::LEVELS_DB
}

impl<'p> Model<'p> {
    /// Returns the model without echoes.
    pub const fn empty(g: &'p Generative, numbers: Numbers) -> Self {
        Self {
            echoes: Vec::new(),
            surfaces: Surfaces::NOTHING,
            view: View::NOTHING,
            height_m: 0.0,
            q: 0.0,
            beam_rad: 0.0,
            cell_m: 0.0,
            rates: [0.0; EXTENDED],
            g,
            numbers,
        }
    }

    /// Returns the model with these echoes.
    pub fn new(
        echoes: &[Echo],
        view: View,
        geometry: &Geometry,
        g: &'p Generative,
        numbers: Numbers,
    ) -> Self {
        let mut model = Self::empty(g, numbers);
        model.set_echoes(echoes, view, geometry);
        model
    }

    /// Replaces the echoes by those of a scan, `echoes`, the strongest first, up to the maximum number.
    #[inline(never)]
    pub fn set_echoes(&mut self, echoes: &[Echo], view: View, geometry: &Geometry) {
        let strongest = echoes.iter().map(|e| e.snr_db).fold(0.0, math::max);
        self.view = view;
        self.height_m = view.height_m;
        self.q = (strongest - posterior::REFERENCE_DB) / posterior::TEN_DB;
        self.beam_rad = posterior::APART_BEAMS * geometry.beamwidth_rad;
        self.cell_m = posterior::APART_RANGE_M * geometry.bin_m / posterior::BIN_M;
        for (rate, p) in self.rates.iter_mut().zip(&self.g.extended) {
            *rate = math::exp(p.rate + p.rate_per_ten_db * self.q);
        }
        self.echoes.clear();
        for e in echoes.iter().filter(|e| e.range_m > NEAREST_ECHO_M) {
            let seen = self.model_echo(e);
            if self.echoes.push(seen).is_err() {
                break;
            }
        }
        // A fixed order: the rounding errors of sums depend on it.
        shell_sort(&mut self.echoes, |a, b| {
            a.x_m < b.x_m || a.x_m == b.x_m && a.y_m < b.y_m
        });
    }

    #[inline(never)]
    fn model_echo(&self, e: &Echo) -> ModelEcho {
        let [face, tread, floor, air, inside, noise] = &self.g.extended;
        let s = e.snr_db;
        let level = |x: &Extended, off: f32, flat: f32| {
            let mean = x.snr_db + x.snr_per_db * posterior::TEN_DB * self.q + off;
            math::exp(x.rate + x.rate_per_ten_db * self.q)
                * level_density(s, mean, x.snr_sigma_db, flat)
        };
        let far = math::max(e.x_m - posterior::FLOOR_M, -posterior::FLOOR_NEARER_M);
        let mut point = [0.0; POINTS];
        for (value, p) in point.iter_mut().zip(&self.g.points) {
            *value = level_density(
                s,
                self.level(p, e.range_m),
                p.snr_sigma_db,
                posterior::ANY_LEVEL,
            );
        }
        let across_m = e.range_m
            * math::hypot(
                posterior::ANGLE_SIGMAS * e.angle_sigma_rad,
                posterior::MIN_ANGLE_SIGMA_RAD,
            );
        let per_range = across_m / math::max(e.range_m, posterior::MIN_RANGE_M);
        let (up_m, along_m) = (per_range * e.x_m, per_range * (self.height_m - e.y_m));
        ModelEcho {
            x_m: e.x_m,
            y_m: e.y_m,
            range_m: e.range_m,
            across_m,
            wide: (e.width - CLEAN_WIDTH).clamp(0.0, 0.5),
            snr_db: s,
            noise: math::exp(noise.rate - (s - MIN_DB) / noise.snr_sigma_db)
                / (NOISE_EXTENT
                    * math::max(e.range_m, posterior::NOISE_RANGE_M)
                    * noise.snr_sigma_db),
            air: level(air, 0.0, posterior::ANY_LEVEL) / SECTOR_AREA_M2,
            inside: level(inside, 0.0, posterior::ANY_LEVEL_INSIDE) / SECTOR_AREA_M2,
            tread: GAUSS * level(tread, 0.0, posterior::ANY_LEVEL_TREAD),
            floor: GAUSS
                * level(
                    floor,
                    -posterior::FLOOR_FALL_DB * far,
                    posterior::ANY_LEVEL_FLOOR,
                )
                * math::exp(-posterior::FLOOR_FALL * far),
            face: GAUSS * posterior::FACES_PER_M * level(face, 0.0, posterior::ANY_LEVEL),
            point,
            per_tread: 1.0 / math::hypot(tread.off_sigma_m, up_m),
            per_floor: 1.0 / math::hypot(floor.off_sigma_m, up_m),
            per_face: 1.0 / math::hypot(face.off_sigma_m, along_m),
        }
    }

    fn level(&self, p: &Point, range_m: f32) -> f32 {
        p.snr_db + p.snr_per_db * posterior::TEN_DB * self.q
            - posterior::FADE_DB
                * core::f32::consts::LOG10_2
                * math::log2(math::max(range_m, posterior::FADE_FROM_M))
    }

    /// Returns the SNR at a range, metres, that the strongest echo predicts, less 30 dB, in tens of dB.
    pub fn expected_q(&self, range_m: f32) -> f32 {
        self.q
            - 2.0
                * core::f32::consts::LOG10_2
                * math::log2(math::max(range_m, posterior::FADE_FROM_M))
    }

    /// Returns the density of an echo before riser `k` (or on the landing) from everything but point features, per m²
    /// and dB.
    #[inline(never)]
    pub fn background(&self, s: &Staircase, k: usize, e: &ModelEcho) -> f32 {
        math::max(self.parts(s, k, e).iter().sum(), MIN_DENSITY)
    }

    /// Returns the density of an echo before riser `k` (or on the landing), per m² and dB, by class: face, tread,
    /// floor, air, inside, noise.
    #[inline]
    pub fn parts(&self, s: &Staircase, k: usize, e: &ModelEcho) -> [f32; EXTENDED] {
        if let Some(end_m) = s.kind.end_m()
            && e.x_m > end_m
        {
            return [0.0, 0.0, 0.0, drop::density(e.air), 0.0, e.noise];
        }
        let base = self.base(s, k, e.x_m);
        let edge = if k > 0 { s.x(k - 1) } else { f32::INFINITY };
        let low = sight_m(self.height_m, e.x_m, base, edge);
        let mut inside =
            above((e.y_m - low + posterior::INSIDE_M) / (posterior::INSIDE_SIGMA_M + e.across_m));
        if s.open && k > 0 {
            inside *= posterior::INSIDE_OPEN;
        }
        let mut parts = [
            0.0,
            0.0,
            0.0,
            (1.0 - inside) * e.air,
            inside * e.inside,
            e.noise,
        ];
        let [on_face, on_tread, on_floor, ..] = &mut parts;
        if k > 0 && base < self.height_m {
            let z = (e.y_m - base) * e.per_tread;
            *on_tread = e.tread * tailed(z * z) * e.per_tread;
        }
        if k == 0 || s.open {
            let z = (e.y_m - if k == 0 { base } else { 0.0 }) * e.per_floor;
            let share = if k == 0 { 1.0 } else { posterior::FLOOR_UNDER };
            *on_floor = share * e.floor * tailed(z * z) * e.per_floor;
        }
        // Faces of the riser before and of this one.
        for i in k.saturating_sub(1)..s.len().min(k + 1) {
            let z = (e.x_m - (s.x(i) - posterior::FACE_BEFORE * s.overhang_m)) * e.per_face;
            if z * z <= FACE_REACH {
                let (b, t) = self.face_span(s, i);
                *on_face += Self::face(e, z * z, b, t);
            }
        }
        if s.wall_m.is_finite() && k == s.len() {
            *on_face += wall::density(e.face, e.x_m - s.wall_m, e.y_m, base);
        }
        parts
    }

    /// Returns the height above the ground, metres, of the surface at distance `x`, metres, on the tread before riser
    /// `k` (or on a ramp).
    pub fn base(&self, s: &Staircase, k: usize, x: f32) -> f32 {
        s.kind.height_m(x, s.level(k))
    }

    /// Returns the density, per m² and dB, of an echo as part of a face from height `b` to height `t` above the ground,
    /// metres. `z2` is the echo's squared deviation from the face, in squared standard deviations.
    fn face(e: &ModelEcho, z2: f32, b: f32, t: f32) -> f32 {
        if t <= b + posterior::MIN_FACE_M {
            return 0.0;
        }
        let soft = posterior::FACE_END_SIGMA_M + e.across_m;
        let within = above((b - e.y_m) / soft) - above((t - e.y_m) / soft);
        e.face * math::max(within, 0.0) * tailed(z2) * e.per_face
    }

    /// Returns the log-likelihood, nats, of the echoes before riser `k` (or on the landing) and of their number,
    /// without point features.
    pub fn tread(&self, s: &Staircase, k: usize) -> f32 {
        self.within(s, k, f32::NEG_INFINITY, f32::INFINITY) - self.expected(s, k)
    }

    /// Returns the log-likelihood of the echoes before riser `k` (or on the landing) that lie between two distances,
    /// metres; nats, without point features.
    #[inline(never)]
    pub fn within(&self, s: &Staircase, k: usize, from_m: f32, to_m: f32) -> f32 {
        let start = k.checked_sub(1).map_or(f32::NEG_INFINITY, |k| s.x(k));
        let from = math::max(start + BEHIND_RISER_M, from_m);
        let to = math::min(s.x(k) + BEHIND_RISER_M, to_m);
        let (mut total, mut product) = (0.0, 1.0);
        for e in self.between(from, to) {
            product *= self.background(s, k, e);
            // One logarithm for many factors: none of them is less than `MIN_DENSITY`.
            if !(MIN_PRODUCT..1.0 / MIN_PRODUCT).contains(&product) {
                total += ln(product);
                product = 1.0;
            }
        }
        total + ln(product)
    }

    /// Returns the suffix sums of the log-likelihoods of all echoes on the tread before riser `k`, wherever the tread
    /// begins.
    #[inline(never)]
    pub fn sums(&self, s: &Staircase, k: usize) -> EchoSums {
        let mut sums = [0.0; MAX_MODEL_ECHOES + 1];
        let mut sum = 0.0;
        let places = sums.iter_mut().zip(&self.echoes);
        for (place, e) in places.rev() {
            sum += ln(self.background(s, k, e));
            *place = sum;
        }
        sums
    }

    /// Returns the index of the first echo beyond a distance, metres.
    pub fn first_beyond(&self, x_m: f32) -> usize {
        self.echoes.partition_point(|e| e.x_m <= x_m)
    }

    /// Returns the expected number of echoes on the tread before riser `k` and on its face.
    pub fn expected(&self, s: &Staircase, k: usize) -> f32 {
        let exposure = self.exposure(s, k);
        exposure.iter().zip(&self.rates).map(|(e, r)| e * r).sum()
    }

    /// Returns the exposure of face, tread and floor before riser `k`: for each, the expected number of echoes divided
    /// by its rate.
    pub fn exposure(&self, s: &Staircase, k: usize) -> [f32; 3] {
        let n = s.len();
        let mut out = [0.0; posterior::SURFACES];
        let [face, tread, floor] = &mut out;
        if k == 0 {
            let mut end = posterior::FLOOR_ENDS_M;
            if n == 0 {
                end = math::min(end, s.wall_m);
            }
            if let Some(end_m) = s.kind.end_m() {
                end = math::min(end, end_m);
            }
            if !s.open {
                end = math::min(end, s.x(0));
            }
            let reach = |x: f32| math::exp(-posterior::FLOOR_FALL * (x - posterior::FLOOR_M));
            *floor = (reach(posterior::FLOOR_BEGINS_M)
                - reach(math::max(end, posterior::FLOOR_BEGINS_M)))
                / posterior::FLOOR_FALL;
        } else if s.level(k) < self.height_m {
            let x = s.x(k - 1);
            let next = if k < n {
                s.x(k)
            } else {
                math::min(x + posterior::LAST_TREAD_M, posterior::LAST_TREAD_ENDS_M)
            };
            *tread = math::max(next - x, 0.0);
        }
        if k < n {
            let (b, t) = self.face_span(s, k);
            if t > b && self.in_scan(s.x(k), t) {
                *face = posterior::FACES_PER_M * (t - b);
            }
        }
        out
    }

    /// Returns the echoes beyond `from` and up to `to`, distances in metres.
    pub fn between(&self, from: f32, to: f32) -> &[ModelEcho] {
        let first = self.echoes.partition_point(|e| e.x_m <= from);
        let end = self.echoes.partition_point(|e| e.x_m <= to);
        self.echoes.get(first..end).unwrap_or(&[])
    }

    /// Returns the log-likelihood ratio of riser `k`'s point features against none, nats; `k` may be the wall behind
    /// the last riser.
    pub fn riser(&self, s: &Staircase, k: usize) -> f32 {
        let places = self.places(s, k);
        if places.is_empty() {
            return 0.0;
        }
        self.points(s, k, k >= s.len(), &places)
    }

    #[inline(never)]
    fn points(&self, s: &Staircase, k: usize, wall: bool, places: &[FeaturePlace]) -> f32 {
        let mut used = [0f32; NEAR];
        let (mut gone, mut found) = (1.0f32, 0.0f32);
        let mut odds = 0.0;
        let x = if wall { s.wall_m } else { s.x(k) };
        let near = self.between(x - posterior::RISER_BEFORE_M, x + posterior::RISER_BEHIND_M);
        let mut backgrounds = [0f32; NEAR];
        for (i, place) in places.iter().enumerate() {
            let Some(p) = self.g.points.get(place.class as usize) else {
                continue;
            };
            let q = self.expected_q(place.range_m);
            let least = match place.class {
                Class::Flash if wall => wall::FLASHES,
                Class::Flash
                | Class::Corner
                | Class::Nosing
                | Class::Top
                | Class::Hidden
                | Class::EdgeBelow
                | Class::EdgeAbove => MIN_P_DETECTED,
            };
            let room = place.separation_cells - 1.0;
            let seen = logistic(p.seen + p.seen_per_ten_db * q + p.seen_per_room * room)
                .clamp(least, MAX_P_DETECTED);
            if i == 0 {
                let [a, b, c, d] = self.g.hidden.nothing;
                let hidden = if place.class == Class::Hidden { c } else { 0.0 };
                odds = a + b * q + hidden + d * excess_level(self.level_before(s, k));
            }
            let mut gains = [0f32; NEAR];
            let mut sum = 0.0;
            let echoes = near.iter().zip(&mut gains).zip(&used).zip(&mut backgrounds);
            for (((e, gain), used), b) in echoes {
                let density = self.density(s, k, place, p, e);
                if density > 0.0 {
                    if *b <= 0.0 {
                        *b = self.background_near(s, k, e);
                    }
                    *gain = seen * density / *b * (1.0 - used);
                    sum += *gain;
                }
            }
            let z = 1.0 - seen + sum;
            gone *= 1.0 - seen;
            found += ln(z);
            for (used, gain) in used.iter_mut().zip(&gains) {
                *used = math::min(
                    *used + posterior::MAX_USED_SHARE * gain / z,
                    posterior::MAX_USED_SHARE,
                );
            }
        }
        let nothing = if wall { wall::HIDDEN } else { logistic(odds) };
        let left = math::exp(-found.min(posterior::MAX_FOUND_LLR));
        let share = nothing * left + (1.0 - nothing) * (1.0 - gone * left) / (1.0 - gone);
        found + ln(math::max(share, MIN_DENSITY))
    }

    /// Returns the density, per m² and dB, of an echo near riser `k`, before or behind it, from everything but point
    /// features.
    fn background_near(&self, s: &Staircase, k: usize, e: &ModelEcho) -> f32 {
        let tread = if e.x_m > s.x(k) + BEHIND_RISER_M {
            k + 1
        } else {
            k
        };
        self.background(s, tread.min(s.len()), e)
    }

    /// Calls `each` with every point feature of riser `k` and its most probable echo, if one is more probable than
    /// not.
    #[inline(never)]
    pub fn features(
        &self,
        s: &Staircase,
        k: usize,
        mut each: impl FnMut(Class, &LevelReading<'_>),
    ) {
        let near = self.between(
            s.x(k) - posterior::RISER_BEFORE_M,
            s.x(k) + posterior::RISER_BEHIND_M,
        );
        let flash = self.flash(near);
        for place in &self.places(s, k) {
            let Some(p) = self.g.points.get(place.class as usize) else {
                continue;
            };
            let mut best = (1.0, None);
            // The flash's echo cannot be that of the edge above it.
            let taken = flash.filter(|_| place.class == Class::Top);
            for e in near {
                if taken.is_some_and(|flash| core::ptr::eq(flash, e)) {
                    continue;
                }
                let density = self.density(s, k, place, p, e);
                if density > 0.0 {
                    let odds = density / self.background_near(s, k, e);
                    if odds > best.0 {
                        best = (odds, Some(e));
                    }
                }
            }
            if let (odds, Some(echo)) = best {
                let lever = math::max(echo.x_m, posterior::MIN_RANGE_M) / echo.range_m;
                let off_m = p.across_m + p.across_per_width_m * echo.wide;
                let wide = math::hypot(p.sigma_per_width_m * echo.wide, echo.across_m);
                let sigma_m = math::hypot(p.across_sigma_m, wide) / lever;
                let share = self.core(place, p, echo) * odds / (1.0 + odds);
                let reading = LevelReading {
                    echo,
                    level_m: echo.y_m - off_m / lever,
                    sigma_m: sigma_m / math::sqrt(math::max(share, posterior::MIN_PROBABILITY)),
                    masked: self.numbers.rules.masks
                        && flash.is_some_and(|flash| self.masks(flash, place.class, echo)),
                };
                each(place.class, &reading);
            }
        }
    }

    /// Returns the strongest echo of `near` at the mirror's height: the flash of a face at right angles to the line of
    /// sight.
    fn flash<'e>(&self, near: &'e [ModelEcho]) -> Option<&'e ModelEcho> {
        let level = near
            .iter()
            .filter(|e| (e.y_m - self.height_m).abs() < posterior::FLASH_WITHIN_M);
        level.reduce(|a, b| if b.snr_db > a.snr_db { b } else { a })
    }

    /// Whether a flash covers the own echo of a feature of this class. Echo `e` beside it is then the flash's flank,
    /// and no reading of the feature's height.
    fn masks(&self, flash: &ModelEcho, class: Class, e: &ModelEcho) -> bool {
        let cross = self.cross_m2(Spot::new(e.x_m, e.y_m), Spot::new(flash.x_m, flash.y_m));
        let apart = (cross / (e.range_m * flash.range_m)).abs() / self.beam_rad;
        match class {
            Class::Corner => {
                apart < posterior::MASKS_CORNER
                    && flash.snr_db > e.snr_db - posterior::MASKS_WEAKER_DB
            }
            Class::Nosing => apart < posterior::MASKS_EDGE,
            Class::Flash | Class::Top | Class::Hidden | Class::EdgeBelow | Class::EdgeAbove => {
                false
            }
        }
    }

    /// Returns the share of the Gaussian core, rather than its heavy tails, in the density of an echo as a point
    /// feature.
    fn core(&self, place: &FeaturePlace, p: &Point, e: &ModelEcho) -> f32 {
        let (z2, root) = self.deviation(place, p, e, 0.0);
        let (odd_z2, odd_root) = self.deviation(place, p, e, self.numbers.odd_rise_sigma_m);
        let odd = posterior::ODD_ODDS * math::exp(-0.5 * odd_z2) * root / odd_root;
        let core = posterior::CORE_SHARE * (math::exp(-0.5 * z2) + odd);
        core / (tailed(z2) + posterior::CORE_SHARE * odd)
    }

    /// Returns the density of an echo as one of riser `k`'s point features, of class `p` at `place`, per m² and dB; 0
    /// far from it.
    #[inline(never)]
    pub fn density(
        &self,
        s: &Staircase,
        k: usize,
        place: &FeaturePlace,
        p: &Point,
        e: &ModelEcho,
    ) -> f32 {
        let density = if place.class == Class::Hidden {
            self.hidden(s, k, e, place.x_m)
        } else {
            let (z2, root) = self.deviation(place, p, e, 0.0);
            if z2 <= posterior::POINT_REACH {
                tailed(z2) * GAUSS * GAUSS / root
            } else {
                0.0
            }
        };
        if density <= 0.0 {
            return 0.0;
        }
        density * e.point.get(place.class as usize).copied().unwrap_or(0.0)
    }

    /// Returns the squared deviation of an echo from the expected place of a point feature, in squared standard
    /// deviations, and the root of the product of both variances, m². The deviation is infinite outside the gates.
    /// `level_sigma_m` is the standard deviation of the feature's height, metres.
    fn deviation(
        &self,
        place: &FeaturePlace,
        p: &Point,
        e: &ModelEcho,
        level_sigma_m: f32,
    ) -> (f32, f32) {
        let dr = e.range_m - place.range_m - p.range_m;
        if dr.abs() > RANGE_GATE_M {
            return (f32::INFINITY, 1.0);
        }
        let across =
            self.cross_m2(Spot::new(place.x_m, place.y_m), Spot::new(e.x_m, e.y_m)) / place.range_m;
        let dc = across - p.across_m - p.across_per_width_m * e.wide;
        if dc.abs() > CROSS_GATE_M {
            return (f32::INFINITY, 1.0);
        }
        let wide = p.sigma_per_width_m * e.wide;
        let vr = p.range_sigma_m * p.range_sigma_m;
        let level = level_sigma_m * place.x_m / place.range_m;
        let vc = p.across_sigma_m * p.across_sigma_m
            + wide * wide
            + e.across_m * e.across_m
            + level * level;
        (dr * dr / vr + dc * dc / vc, math::sqrt(vr * vc))
    }

    /// Returns the density, per m², of an echo as the visible part of riser `k`, whose foot is hidden; `x` is the
    /// riser's distance, metres.
    fn hidden(&self, s: &Staircase, k: usize, e: &ModelEcho, x: f32) -> f32 {
        let (low, top) = self.face_span(s, k);
        if (e.x_m - x).abs() > posterior::HIDDEN_X_M
            || e.y_m < low - posterior::HIDDEN_Y_M
            || e.y_m > top + posterior::HIDDEN_Y_M
        {
            return 0.0;
        }
        let Some(p) = self.g.points.get(Class::Hidden as usize) else {
            return 0.0;
        };
        let g = &self.g.hidden;
        let ca = e.x_m / e.range_m;
        let wide = p.sigma_per_width_m * e.wide;
        let va = e.across_m * e.across_m + wide * wide;
        let dx = (e.x_m - x) * ca - p.range_m;
        let over = dx + s.overhang_m * ca;
        let vr = p.range_sigma_m * p.range_sigma_m;
        let mut total = 0.0;
        for ([share, off, sigma], at, dx) in [(g.low, low, dx), (g.top, top, over)] {
            let v = sigma * sigma + va;
            let y = (e.y_m - at - off) / ca;
            total += share * tailed(dx * dx / vr + y * y / v) * GAUSS * GAUSS / math::sqrt(vr * v);
        }
        let soft = math::sqrt(posterior::HIDDEN_END_M2 + va);
        let within = above((low - e.y_m) / soft) - above((top - e.y_m) / soft);
        let even = math::max(within, 0.0) / math::max(top - low, posterior::MIN_FACE_M);
        total + (1.0 - g.low[0] - g.top[0]) * even * tailed(dx * dx / vr) * GAUSS / math::sqrt(vr)
    }

    /// Returns the log-likelihood of riser `k` with the tread before it, nats.
    pub fn riser_log_likelihood(&self, s: &Staircase, k: usize) -> f32 {
        self.tread(s, k)
            + self.riser(s, k)
            + if k == 0 {
                s.ground_line(&self.surfaces)
            } else {
                0.0
            }
    }

    /// Returns the log-likelihood of the whole staircase, nats.
    pub fn log_likelihood(&self, s: &Staircase) -> f32 {
        (0..=s.len()).map(|k| self.riser_log_likelihood(s, k)).sum()
    }
}
