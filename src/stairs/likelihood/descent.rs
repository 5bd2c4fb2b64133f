//! Descending, height plane: the roles of depth and height exchanged. Treads face the mirror, so a
//! tread is a row of echoes at one level; an edge is where a row ends and where the shadow on the
//! next one begins.

use super::ascent::amplitude;
use super::echo::{Echo, MAX_ECHOES};
use super::evidence::credibility;
use crate::math::{self, RAD_PER_DEG};
use crate::stairs::{Direction, Outcome, Step};
use heapless::Vec;

const ON_TREAD: f32 = 2.0;
const AT_EDGE: f32 = 3.5;
const FLASH: f32 = 4.5;
const STRAY: f32 = 0.5;
const INSIDE: f32 = 2.0;
const STEP: f32 = 1.2;
const UNSEEN: f32 = 0.7;
const ACCEPT: f32 = 2.0;
const SHORT: f32 = 0.018;
const SPREAD: f32 = 0.015;
const TAU: f32 = 0.005;
const MOST: usize = 5;

#[derive(Clone, Copy, Debug, Default)]
struct Spot {
    x: f32,
    y: f32,
    w: f32,
    sx: f32,
    sy: f32,
}

struct Down {
    spots: Vec<Spot, MAX_ECHOES>,
    height: f32,
    scored: u32,
}

impl Down {
    fn flight(&mut self, d1: f32, going: f32, rise: f32, n: usize) -> f32 {
        self.scored += 1;
        let h = self.height;
        let mut total = 0.0;
        let mut seen = [0f32; 8];
        for e in &self.spots {
            let mut best = -STRAY;
            let mut low = if n == 0 { 0.0 } else { -1e9f32 };
            for (k, seen) in seen.iter_mut().enumerate().take(n + 1) {
                let lv = -(k as f32) * rise;
                let start = d1 + (k as f32 - 1.0) * going;
                let a = if k == 0 {
                    -9.0
                } else if start < 0.0 {
                    start
                } else {
                    start * (h - lv) / (h - lv - rise)
                };
                let b = if k == n { 9.0 } else { d1 + k as f32 * going };
                let z = (e.y - lv) / e.sy;
                if a - 1.5 * e.sx < e.x && e.x < b + 1.5 * e.sx {
                    low = low.max(lv);
                    let mut g = ON_TREAD - 0.5 * z * z;
                    if a < 0.03 && b > -0.03 && e.x.abs() < 0.02 + 1.5 * e.sx {
                        g = g.max(FLASH - 0.5 * z * z);
                    }
                    if k < n {
                        let q =
                            (e.x - b + SHORT) * (e.x - b + SHORT) / (e.sx * e.sx + SPREAD * SPREAD);
                        g = g.max(AT_EDGE - 0.5 * z * z - 0.5 * q);
                    }
                    if g > 0.0 && g * e.w > *seen {
                        *seen = g * e.w;
                    }
                    best = best.max(g);
                }
            }
            if best <= 0.0 && e.y < low - 0.02 - 3.0 * e.sy {
                best = -INSIDE;
            }
            total += best * e.w;
        }
        for &s in &seen[1..=n] {
            total -= STEP + if s < 0.3 { UNSEEN } else { 0.0 };
        }
        if n > 0 {
            let q = (2.0 * rise + going - 0.63) / 0.03;
            total -= 0.5 * q * q;
        }
        total
    }
}

pub fn assemble(echoes: &[Echo], height: f32) -> (Outcome, f32) {
    let mut down = Down {
        spots: Vec::new(),
        height,
        scored: 0,
    };
    for e in echoes.iter().filter(|e| e.y < 0.06 && e.db > 3.0) {
        let (sin, cos) = math::sin_cos(e.angle_rad);
        let angle = (0.2 + amplitude(-e.db)) * RAD_PER_DEG;
        let _ = down.spots.push(Spot {
            x: e.x,
            y: e.y,
            w: credibility(e.db),
            sx: math::hypot(0.012, e.range_m * cos * angle),
            sy: math::hypot(0.004, e.range_m * sin.abs() * angle),
        });
    }
    let mut null = down.flight(0.0, 0.3, 0.15, 0);
    for slope in 1..13 {
        for o in 0..3 {
            let tan = (slope as f32 * RAD_PER_DEG).tan_();
            let mut t = 0.0;
            for e in &down.spots {
                let z = (e.y + (e.x + 0.1 * o as f32).max(0.0) * tan) / e.sy;
                t += e.w * (ON_TREAD - 0.5 * z * z).max(-STRAY);
            }
            null = null.max(t);
        }
    }
    let mut up: Vec<f32, MAX_ECHOES> = down
        .spots
        .iter()
        .filter(|e| e.y.abs() < 0.03 && e.x < 0.1)
        .map(|e| e.x)
        .collect();
    up.sort_unstable_by(f32::total_cmp);
    let mut edges: Vec<f32, 8> = Vec::new();
    for &x in up.iter().rev().take(2) {
        let _ = edges.push(x);
    }
    for x in [-0.2, -0.15, -0.1, -0.05, 0.0] {
        let _ = edges.push(x);
    }
    let mut best = (-1e9f32, 0.0f32, 0.0f32, 0.0f32, 0usize);
    for &d1 in &edges {
        for r in 0..24 {
            let rise = 0.10 + 0.005 * r as f32;
            for g in 0..20 {
                let going = 0.20 + 0.01 * g as f32;
                for n in 1..=MOST {
                    let v = down.flight(d1, going, rise, n);
                    if v > best.0 {
                        best = (v, d1, going, rise, n);
                    }
                }
            }
        }
    }
    let score = best.0 - null;
    let (_, _, _, rise, n) = best;
    if score < ACCEPT || n < 1 {
        return (Outcome::clear(), score);
    }
    let mut top = -1e9f32;
    let mut s = [0f32; 6];
    for turn in 0..2 {
        for a in 0..30 {
            let d1 = -0.26 + 0.01 * a as f32;
            for g in 0..20 {
                let going = 0.20 + 0.01 * g as f32;
                let v = down.flight(d1, going, rise, n);
                if turn == 0 {
                    top = top.max(v);
                } else {
                    let q = math::exp(v - top);
                    for (s, t) in
                        s.iter_mut()
                            .zip([1.0, d1, going, d1 * d1, going * going, d1 * going])
                    {
                        *s += q * t;
                    }
                }
            }
        }
    }
    let p = s.map(|v| v / s[0]);
    let (d1, going) = (p[1], p[2]);
    let mut outcome = Outcome::clear();
    outcome.direction = Direction::Down;
    let (mut m, mut v) = ([0f32; 8], [f32::INFINITY; 8]);
    for k in 1..=n {
        let a = d1 + (k as f32 - 1.0) * going;
        let b = if k < n { d1 + k as f32 * going } else { 9.0 };
        let (mut q, mut qy) = (0.0, 0.0);
        for e in &down.spots {
            if (e.y + k as f32 * rise).abs() < 0.015 + 2.5 * e.sy
                && e.x > a - 0.02
                && e.x < b + 0.03 + e.sx
            {
                let w = e.w / (e.sy * e.sy);
                q += w;
                qy += w * e.y;
            }
        }
        if q > 0.0 {
            m[k - 1] = qy / q;
            v[k - 1] = (1.0 / q).max(0.003 * 0.003);
        }
    }
    let pr = 1.0 / (0.02f32 * 0.02);
    let (mut num, mut den) = (-pr * rise, pr);
    for k in 0..n {
        let i = (k + 1) as f32;
        let w = 1.0 / (v[k] + TAU * TAU);
        num += w * i * m[k];
        den += w * i * i;
    }
    let rho = num / den;
    for k in 0..n {
        let i = (k + 1) as f32;
        let gain = TAU * TAU / (v[k] + TAU * TAU);
        let h = i * rho + gain * (m[k] - i * rho);
        let sh =
            math::sqrt((1.0 - gain) * TAU * TAU + ((1.0 - gain) * i) * ((1.0 - gain) * i) / den);
        let f = k as f32;
        let var = (p[3] - d1 * d1) + 2.0 * f * (p[5] - d1 * going) + f * f * (p[4] - going * going);
        let _ = outcome.steps.push(Step {
            distance_m: d1 + going * f,
            height_m: h,
            tread_m: None,
            riser_m: None,
            distance_sigma_m: 0.6 * math::sqrt(var.max(0.0) + 0.008 * 0.008),
            height_sigma_m: sh.max(0.003),
            quality: 50,
        });
    }
    (outcome, score)
}

trait Tan {
    fn tan_(self) -> f32;
}
impl Tan for f32 {
    fn tan_(self) -> f32 {
        let (s, c) = math::sin_cos(self);
        s / c
    }
}
