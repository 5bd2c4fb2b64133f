//! The measurement model: how likely the scan's echoes are if a staircase stands there.
//!
//! Echoes come from point features (corners, nosings, flashes, edges), each seen with a probability,
//! and as a Poisson process from extended ones (floor, treads, faces) and from noise. With b(z) the
//! density of echo z from everything that is no point feature, and Λ how many such are expected,
//!
//! ```text
//! ln p(Z) = Σ ln b(z) - Λ + Σ over risers ln( p₀ + (1 - p₀) (Π z_f - Π(1 - P_f)) / (1 - Π(1 - P_f)) )
//! z_f     = 1 - P_f + P_f Σ over echoes (1 - used) p_f(z) / b(z)
//! ```
//!
//! where p₀ is the probability that a riser shows nothing at all: one that is seen shows at least
//! one echo. What one feature has claimed of an echo, the next one cannot have.

use super::staircase::{Kind, Staircase, View};
use crate::echoes::{Echo, MAX_ECHOES};
use crate::grid::Geometry;
use crate::math;
use crate::params::generative::{Extended, Generative, POINTS, Point};
use crate::sort::shell_sort;
use heapless::Vec;

/// Classes of point features.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    Corner,
    Nosing,
    Flash,
    Top,
    Hidden,
    EdgeBelow,
    EdgeAbove,
}

/// Below this level no echo is detected, dB.
const LEAST_DB: f32 = 2.8;
/// Width of a clean lobe, in units of a point scatterer's.
const CLEAN_WIDTH: f32 = 1.03;
/// Area that is scanned, m².
const AREA_M2: f32 = 4.4;
/// Extent of the scan: range in metres times angle in radians.
const EXTENT: f32 = 3.3;
/// Echoes so far behind a riser still belong to the tread before it, metres.
const BEHIND_M: f32 = 0.02;
/// Range gate of a feature, metres.
const GATE_M: f32 = 0.06;
/// Cross gate, metres.
const CROSS_GATE_M: f32 = 0.20;
/// Echoes near one riser.
const NEAR: usize = 16;
/// Thickness of an open tread, metres.
const THICK_M: f32 = 0.045;
/// A face must show this much about the mirror's height to flash, metres.
const FRESNEL_M: f32 = 0.04;
/// Below a brink echoes are so many times as dense as in the air.
const BELOW: f32 = 3.0;
/// 1 / √(2π).
const GAUSS: f32 = 0.398_942_3;
/// Least density, so that its logarithm is finite.
const LEAST: f32 = 1e-12;

/// An echo as the model sees it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    pub x_m: f32,
    pub y_m: f32,
    range_m: f32,
    across_m: f32,
    wide: f32,
    pub snr_db: f32,
    /// Densities that do not depend on the staircase.
    noise: f32,
    air: f32,
    inside: f32,
    tread: f32,
    floor: f32,
    face: f32,
    point: [f32; POINTS],
}

/// The echoes of a scan under the model.
pub struct Model<'p> {
    pub echoes: Vec<Seen, MAX_ECHOES>,
    /// What can be seen.
    pub view: View,
    /// Mirror above the ground, metres.
    height_m: f32,
    /// Strongest echo over 30 dB, tens of dB.
    q: f32,
    beam_rad: f32,
    cell_m: f32,
    g: &'p Generative,
}

/// The point features of one riser: class, place, room around it.
type Places = Vec<(Class, f32, f32, f32), 3>;

/// What the echo that is a feature says.
#[derive(Clone, Copy, Debug)]
pub struct Best {
    /// Where it is, metres.
    pub x_m: f32,
    /// How high the feature is, metres, …
    pub level_m: f32,
    /// … and its standard deviation.
    pub sigma_m: f32,
}

fn logistic(x: f32) -> f32 {
    1.0 / (1.0 + math::exp(-x))
}

/// Upper tail of the normal distribution.
pub fn above(z: f32) -> f32 {
    logistic(-1.702 * z)
}

fn ln(x: f32) -> f32 {
    core::f32::consts::LN_2 * math::log2(x)
}

/// A Gaussian with wide tails, not normalised by its standard deviations.
fn tailed(z2: f32) -> f32 {
    if z2 > 120.0 {
        return 1e-9;
    }
    let wide = 1.0 / (1.0 + z2 / 128.0);
    let wide = wide * wide;
    0.92 * math::exp(-0.5 * z2) + 0.005 * wide * wide
}

/// Density of a level, cut off at the detection threshold, with a flat share.
fn level_density(snr_db: f32, mean: f32, sigma: f32, flat: f32) -> f32 {
    let z = (snr_db - mean) / sigma;
    let tail = math::max(above((LEAST_DB - mean) / sigma), 0.02);
    (1.0 - flat) * math::exp(-0.5 * z * z) * GAUSS / sigma / tail + flat / 50.0
}

impl<'p> Model<'p> {
    /// Takes in the echoes.
    pub fn new(echoes: &[Echo], view: View, geometry: &Geometry, g: &'p Generative) -> Self {
        let strongest = echoes.iter().map(|e| e.snr_db).fold(0.0, math::max);
        let mut model = Self {
            echoes: Vec::new(),
            view,
            height_m: view.height_m,
            q: (strongest - 30.0) / 10.0,
            beam_rad: 0.9 * geometry.beamwidth_rad,
            cell_m: 0.02 * geometry.bin_m / 0.0117,
            g,
        };
        for e in echoes.iter().filter(|e| e.range_m > 0.12) {
            let _ = model.echoes.push(model.seen(e));
        }
        shell_sort(&mut model.echoes, |a, b| a.x_m < b.x_m);
        model
    }

    fn seen(&self, e: &Echo) -> Seen {
        let [face, tread, floor, air, inside, noise] = &self.g.extended;
        let s = e.snr_db;
        let level = |x: &Extended, off: f32, flat: f32| {
            let mean = x.snr_db + x.snr_per_db * 10.0 * self.q + off;
            math::exp(x.rate + x.rate_per_ten_db * self.q)
                * level_density(s, mean, x.snr_sigma_db, flat)
        };
        let far = math::max(e.x_m - 0.6, -0.4);
        let mut point = [0.0; POINTS];
        for (value, p) in point.iter_mut().zip(&self.g.points) {
            *value = level_density(s, self.level(p, e.range_m), p.snr_sigma_db, 0.05);
        }
        Seen {
            x_m: e.x_m,
            y_m: e.y_m,
            range_m: e.range_m,
            across_m: e.range_m * math::hypot(1.5 * e.angle_sigma_rad, 0.0015),
            wide: (e.width - CLEAN_WIDTH).clamp(0.0, 0.5),
            snr_db: s,
            noise: math::exp(noise.rate - (s - LEAST_DB) / noise.snr_sigma_db)
                / (EXTENT * math::max(e.range_m, 0.1) * noise.snr_sigma_db),
            air: level(air, 0.0, 0.05) / AREA_M2,
            inside: level(inside, 0.0, 0.01) / AREA_M2,
            tread: level(tread, 0.0, 0.002),
            floor: level(floor, -8.0 * far, 0.005) * math::exp(-1.5 * far),
            face: 10.0 * level(face, 0.0, 0.05),
            point,
        }
    }

    fn level(&self, p: &Point, range_m: f32) -> f32 {
        p.snr_db + p.snr_per_db * 10.0 * self.q
            - 20.0 * core::f32::consts::LOG10_2 * math::log2(math::max(range_m, 0.3))
    }

    /// Level that the strongest echo predicts at a range, tens of dB over 30 dB.
    fn expected_q(&self, range_m: f32) -> f32 {
        self.q - 2.0 * core::f32::consts::LOG10_2 * math::log2(math::max(range_m, 0.3))
    }

    fn in_scan(&self, x: f32, y: f32) -> bool {
        let slope = (y - self.height_m) / math::max(x, 0.02);
        slope < self.view.highest
            && slope > self.view.lowest
            && math::hypot(x, y - self.height_m) < self.view.farthest_m
    }

    /// Lowest height that can be seen at `x` where the level is `base` behind an edge at `edge`.
    fn sight(&self, x: f32, base: f32, edge: f32) -> f32 {
        if base > self.height_m && edge.is_finite() && edge > 0.0 {
            self.height_m + (base - self.height_m) * x / math::max(edge, 0.05)
        } else {
            base
        }
    }

    /// Lower and upper end of what can be seen of riser `k`'s face.
    fn face_span(&self, s: &Staircase, k: usize) -> (f32, f32) {
        let (top, base) = (s.level(k + 1), s.level(k));
        if s.open {
            return (top - THICK_M, top);
        }
        let edge = if k > 0 { s.x(k - 1) } else { f32::INFINITY };
        (self.sight(s.x(k), base, edge), top)
    }

    /// Density of an echo before riser `k` from everything that is no point feature.
    fn background(&self, s: &Staircase, k: usize, e: &Seen) -> f32 {
        let [face, tread, floor, ..] = &self.g.extended;
        let mut base = s.level(k);
        let edge = if k > 0 { s.x(k - 1) } else { f32::INFINITY };
        if s.kind == Kind::Ramp {
            base = s.slope * math::max(e.x_m - s.wall_m, 0.0);
        }
        let low = self.sight(e.x_m, base, edge);
        let mut inside = above((e.y_m - low + 0.015) / (0.012 + e.across_m));
        if s.open && k > 0 {
            inside *= 0.35;
        }
        let gone = s.kind == Kind::Drop && e.x_m > s.wall_m;
        if gone {
            inside = 0.0;
        }
        let mut total = e.noise + (1.0 - inside) * e.air + inside * e.inside;
        let lever = e.across_m * e.x_m / math::max(e.range_m, 0.05);
        if k > 0 && base < self.height_m {
            let sigma = math::hypot(tread.off_sigma_m, lever);
            let z = (e.y_m - base) / sigma;
            total += e.tread * tailed(z * z) * GAUSS / sigma;
        }
        if gone {
            total += BELOW * e.air;
        } else if k == 0 || s.open {
            let sigma = math::hypot(floor.off_sigma_m, lever);
            let z = (e.y_m - if k == 0 { base } else { 0.0 }) / sigma;
            let share = if k == 0 { 1.0 } else { 0.3 };
            total += share * e.floor * tailed(z * z) * GAUSS / sigma;
        }
        for i in [k.checked_sub(1), Some(k)].into_iter().flatten() {
            if i >= s.len() {
                continue;
            }
            let (b, t) = self.face_span(s, i);
            total += self.face(face, e, s.x(i) - 0.3 * s.overhang_m, b, t);
        }
        if s.wall().is_finite() && k == s.len() && e.y_m > base - 0.03 {
            let z = (e.x_m - s.wall()) / 0.008;
            if z * z < 60.0 {
                total += 0.25 * e.face * tailed(z * z) * GAUSS / 0.008;
            }
        }
        math::max(total, LEAST)
    }

    /// Density as part of a face at `x` from `b` to `t`.
    fn face(&self, p: &Extended, e: &Seen, x: f32, b: f32, t: f32) -> f32 {
        if t <= b + 0.01 {
            return 0.0;
        }
        let lever = e.across_m * (self.height_m - e.y_m) / math::max(e.range_m, 0.05);
        let sigma = math::hypot(p.off_sigma_m, lever);
        let z = (e.x_m - x) / sigma;
        if z * z > 100.0 {
            return 0.0;
        }
        let soft = 0.008 + e.across_m;
        let within = above((b - e.y_m) / soft) - above((t - e.y_m) / soft);
        e.face * math::max(within, 0.0) * tailed(z * z) * GAUSS / sigma
    }

    /// Log-likelihood of the echoes before riser `k` (or of the landing), and of their number.
    pub fn tread(&self, s: &Staircase, k: usize) -> f32 {
        let [face, tread, floor, ..] = &self.g.extended;
        let rate = |p: &Extended| math::exp(p.rate + p.rate_per_ten_db * self.q);
        let n = s.len();
        let start = k.checked_sub(1).map_or(f32::NEG_INFINITY, |k| s.x(k));
        let mut total = 0.0;
        for e in self.between(start + BEHIND_M, s.x(k) + BEHIND_M) {
            total += ln(self.background(s, k, e));
        }
        if k == 0 {
            let mut end = 2.2;
            if s.kind != Kind::Ramp && n == 0 {
                end = math::min(end, s.wall_m);
            }
            if !s.open {
                end = math::min(end, s.x(0));
            }
            let reach = |x: f32| math::exp(-1.5 * (x - 0.6));
            total -= rate(floor) * (reach(0.34) - reach(math::max(end, 0.34))) / 1.5;
        } else if s.level(k) < self.height_m {
            let x = s.x(k - 1);
            let next = if k < n {
                s.x(k)
            } else {
                math::min(x + 0.6, 2.4)
            };
            total -= rate(tread) * math::max(next - x, 0.0);
        }
        if k < n {
            let (b, t) = self.face_span(s, k);
            if t > b && self.in_scan(s.x(k), t) {
                total -= rate(face) * 10.0 * (t - b);
            }
        }
        total
    }

    fn between(&self, from: f32, to: f32) -> &[Seen] {
        let first = self.echoes.partition_point(|e| e.x_m <= from);
        let end = self.echoes.partition_point(|e| e.x_m <= to);
        self.echoes.get(first..end).unwrap_or(&[])
    }

    /// Log-likelihood ratio of riser `k`'s point features against none; `k` may be the wall behind
    /// the last one.
    pub fn riser(&self, s: &Staircase, k: usize) -> f32 {
        let places = self.places(s, k);
        if places.is_empty() {
            return 0.0;
        }
        self.points(s, k, k >= s.len(), &places)
    }

    /// The point features that riser `k` may show: class, place, room around it.
    fn places(&self, s: &Staircase, k: usize) -> Places {
        let mut places = Places::new();
        let h = self.height_m;
        let (x, b) = (s.x(k), s.level(k));
        let wall = k >= s.len();
        let x = if wall { s.wall() } else { x };
        if wall && !x.is_finite() {
            return places;
        }
        let mut push = |class, x, y, room| {
            if self.in_scan(x, y) {
                let _ = places.push((class, x, y, room));
            }
        };
        if wall {
            let b = if s.open { 0.0 } else { b };
            if b < h - 0.005 {
                push(Class::Corner, x, b, 2.0);
                push(Class::Flash, x, h, 2.0);
            }
        } else {
            let t = s.level(k + 1);
            if s.open {
                let class = if t < h {
                    Class::EdgeBelow
                } else {
                    Class::EdgeAbove
                };
                push(class, x, t, 2.0);
            } else if b < h - 0.005 {
                if t > h {
                    push(Class::Corner, x, b, self.room(x, b, x, h));
                    let margin = math::min(t - h, h - b) / FRESNEL_M;
                    push(Class::Flash, x, h, math::min(margin, 2.0));
                    if t > h + 0.01 {
                        let room = self.room(x - s.overhang_m, t, x, h);
                        push(Class::Top, x - s.overhang_m, t, room);
                    }
                } else {
                    let room = self.room(x, b, x - s.overhang_m, t);
                    push(Class::Corner, x, b, room);
                    push(Class::Nosing, x - s.overhang_m, t, room);
                }
            } else {
                let (low, top) = self.face_span(s, k);
                if top > low {
                    push(
                        Class::Hidden,
                        x,
                        0.5 * (low + top),
                        math::min((top - low) / 0.05, 2.0),
                    );
                }
            }
        }
        places
    }

    /// Of each point feature of riser `k`: the echo that most likely is it, if one more likely is than
    /// not.
    pub fn features(&self, s: &Staircase, k: usize, mut each: impl FnMut(Class, &Best)) {
        let near = self.between(s.x(k) - 0.12, s.x(k) + 0.10);
        for (class, x, y, _) in self.places(s, k) {
            let Some(p) = self.g.points.get(class as usize) else {
                continue;
            };
            let range = math::hypot(x, y - self.height_m);
            let mut best = (1.0, None);
            for e in near {
                let density = match class {
                    Class::Hidden => self.hidden(s, k, e, x),
                    _ => self.point(p, e, x, y, range),
                };
                if density > 0.0 {
                    let level = e.point.get(class as usize).copied().unwrap_or(0.0);
                    let tread = if e.x_m > s.x(k) + BEHIND_M { k + 1 } else { k };
                    let odds = density * level / self.background(s, tread.min(s.len()), e);
                    if odds > best.0 {
                        best = (odds, Some(e));
                    }
                }
            }
            if let (_, Some(e)) = best {
                let lever = math::max(e.x_m, 0.05) / e.range_m;
                let off = p.across_m + p.across_per_width_m * e.wide;
                let wide = p.sigma_per_width_m * e.wide;
                let variance =
                    p.across_sigma_m * p.across_sigma_m + wide * wide + e.across_m * e.across_m;
                each(
                    class,
                    &Best {
                        x_m: e.x_m,
                        level_m: e.y_m - off / lever,
                        sigma_m: math::sqrt(variance) / lever,
                    },
                );
            }
        }
    }

    /// Distance of two features in beams and range cells.
    fn room(&self, x: f32, y: f32, other_x: f32, other_y: f32) -> f32 {
        let range = math::hypot(x, y - self.height_m);
        let cross = (x * (other_y - self.height_m) - (y - self.height_m) * other_x)
            / math::max(range, 0.05);
        let other = math::hypot(other_x, other_y - self.height_m);
        let angle = cross / math::max(range, 0.05) / self.beam_rad;
        math::min(math::hypot(angle, (other - range) / self.cell_m), 2.0)
    }

    fn points(
        &self,
        s: &Staircase,
        k: usize,
        wall: bool,
        places: &[(Class, f32, f32, f32)],
    ) -> f32 {
        let mut used = [0f32; NEAR];
        let (mut gone, mut found) = (1.0f32, 0.0f32);
        let mut odds = 0.0;
        let x = if wall { s.wall_m } else { s.x(k) };
        let near = self.between(x - 0.12, x + 0.10);
        let mut backgrounds = [0f32; NEAR];
        for (i, &(class, fx, fy, room)) in places.iter().enumerate() {
            let Some(p) = self.g.points.get(class as usize) else {
                continue;
            };
            let range = math::hypot(fx, fy - self.height_m);
            let q = self.expected_q(range);
            let seen = logistic(p.seen + p.seen_per_ten_db * q + p.seen_per_room * (room - 1.0))
                .clamp(0.02, 0.985);
            if i == 0 {
                let [a, b, c, d] = self.g.hidden.nothing;
                let hidden = if class == Class::Hidden { c } else { 0.0 };
                odds = a + b * q + hidden + d * (math::min(self.shown(s, k), 35.0) - 15.0) * 0.1;
            }
            let mut gains = [0f32; NEAR];
            let mut sum = 0.0;
            let echoes = near.iter().zip(&mut gains).zip(&used).zip(&mut backgrounds);
            for (((e, gain), used), b) in echoes {
                let density = match class {
                    Class::Hidden => self.hidden(s, k, e, fx),
                    _ => self.point(p, e, fx, fy, range),
                };
                if density > 0.0 {
                    let level = e.point.get(class as usize).copied().unwrap_or(0.0);
                    let tread = if e.x_m > s.x(k) + BEHIND_M { k + 1 } else { k };
                    if *b <= 0.0 {
                        *b = self.background(s, tread.min(s.len()), e);
                    }
                    *gain = seen * density * level / *b * (1.0 - used);
                    sum += *gain;
                }
            }
            let z = 1.0 - seen + sum;
            gone *= 1.0 - seen;
            found += ln(z);
            for (used, gain) in used.iter_mut().zip(&gains) {
                *used = math::min(*used + 0.999 * gain / z, 0.999);
            }
        }
        let nothing = if wall { 0.3 } else { logistic(odds) };
        let left = math::exp(-found.min(80.0));
        let share = nothing * left + (1.0 - nothing) * (1.0 - gone * left) / (1.0 - gone);
        found + ln(math::max(share, LEAST))
    }

    /// Level of the riser before, its flash apart, dB.
    fn shown(&self, s: &Staircase, k: usize) -> f32 {
        if k == 0 || k >= s.len() {
            return 15.0;
        }
        let x = s.x(k - 1);
        let near = self.between(x - 0.025, x + 0.025).iter();
        let apart = near.filter(|e| (e.y_m - self.height_m).abs() > 0.03);
        apart.map(|e| e.snr_db).fold(3.0, math::max)
    }

    /// Density of an echo as a point feature, levels apart.
    fn point(&self, p: &Point, e: &Seen, x: f32, y: f32, range: f32) -> f32 {
        let dr = e.range_m - range - p.range_m;
        if dr.abs() > GATE_M {
            return 0.0;
        }
        let across = (x * (e.y_m - self.height_m) - (y - self.height_m) * e.x_m) / range;
        let dc = across - p.across_m - p.across_per_width_m * e.wide;
        if dc.abs() > CROSS_GATE_M {
            return 0.0;
        }
        let wide = p.sigma_per_width_m * e.wide;
        let vr = p.range_sigma_m * p.range_sigma_m;
        let vc = p.across_sigma_m * p.across_sigma_m + wide * wide + e.across_m * e.across_m;
        let z2 = dr * dr / vr + dc * dc / vc;
        if z2 > 100.0 {
            return 0.0;
        }
        tailed(z2) * GAUSS * GAUSS / math::sqrt(vr * vc)
    }

    /// Density of an echo as what can be seen of a riser whose foot is hidden.
    fn hidden(&self, s: &Staircase, k: usize, e: &Seen, x: f32) -> f32 {
        let (low, top) = self.face_span(s, k);
        if (e.x_m - x).abs() > 0.08 || e.y_m < low - 0.12 || e.y_m > top + 0.12 {
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
        let soft = math::sqrt(0.000_144 + va);
        let within = above((low - e.y_m) / soft) - above((top - e.y_m) / soft);
        let even = math::max(within, 0.0) / math::max(top - low, 0.01);
        total + (1.0 - g.low[0] - g.top[0]) * even * tailed(dx * dx / vr) * GAUSS / math::sqrt(vr)
    }

    /// Log-likelihood of riser `k` with the tread before it.
    pub fn step(&self, s: &Staircase, k: usize) -> f32 {
        self.tread(s, k) + self.riser(s, k)
    }

    /// Log-likelihood of the whole.
    pub fn whole(&self, s: &Staircase) -> f32 {
        (0..=s.len()).map(|k| self.step(s, k)).sum()
    }
}
