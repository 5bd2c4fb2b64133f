//! Dimensions of an ascending flight: what each riser's own echoes say, weighed against the
//! regularity of the flight.

use super::evidence::{Evidence, Mark};
use super::search::{Flight, MAX_FLIGHT};
use crate::math::{self, RAD_PER_DEG};
use crate::stairs::{Direction, Outcome, Step};
use heapless::Vec;

/// A step's own departure from the straight flight, metres.
const TAU: f32 = 0.005;
/// A single riser higher than this is a box, metres.
const TOO_HIGH: f32 = 0.23;
/// A single riser lower than this is a threshold, metres.
const TOO_LOW: f32 = 0.07;
/// The model is not the whole truth.
const SIGMA: f32 = 1.2;
/// An echo no wider than this is a single scatterer.
const CLEAN: f32 = 1.176;
/// Closer than this to a flash an echo is pulled towards it, radians.
const HIDE: f32 = 7.4 * RAD_PER_DEG;

/// A measured value and its standard deviation.
#[derive(Clone, Copy, Debug, Default)]
struct Reading {
    value: f32,
    sigma: f32,
}

/// Weighted mean of readings.
#[derive(Clone, Copy, Debug, Default)]
struct Fusion {
    weight: f32,
    sum: f32,
}

impl Fusion {
    fn add(&mut self, reading: Reading) {
        let w = 1.0 / (reading.sigma * reading.sigma);
        self.weight += w;
        self.sum += w * reading.value;
    }
    fn mean(&self) -> f32 {
        if self.weight > 0.0 {
            self.sum / self.weight
        } else {
            0.0
        }
    }
}

/// What the echoes say about each riser.
struct Readings {
    x: [Option<f32>; MAX_FLIGHT],
    x_sigma: [f32; MAX_FLIGHT],
    overhangs: Vec<f32, MAX_FLIGHT>,
    levels: [Fusion; MAX_FLIGHT],
    slopes: Vec<Reading, MAX_FLIGHT>,
}

/// Height of a step's top edge from an echo near it. What is seen lies lower: the riser or the
/// tread's front pulls the echo down by an amount that depends on what else shines there.
fn top_level(m: &Mark, open: bool, flash: bool, hidden: bool) -> Reading {
    let clean = m.width < CLEAN;
    let (low, sigma) = match (open, flash || hidden, clean) {
        (true, true, _) => (0.022, 0.012),
        (true, false, true) => (0.006, 0.010),
        (true, false, false) => (0.009, 0.012),
        (false, _, _) if flash => (0.015, 0.012),
        (false, _, true) => (0.004, 0.008),
        (false, _, false) => (0.011, 0.013),
    };
    Reading {
        value: m.y + low,
        sigma: math::hypot(sigma, angle_error(m, 0.15, 0.5)),
    }
}

/// Height error of a mark from `fixed` degrees plus `noisy` degrees at 0 dB.
fn angle_error(m: &Mark, fixed: f32, noisy: f32) -> f32 {
    m.range * (fixed + noisy * amplitude(-m.db)) * RAD_PER_DEG
}

/// Amplitude ratio of `db` decibels.
pub fn amplitude(db: f32) -> f32 {
    math::exp2(db * (1.0 / 6.020_6))
}

fn strongest<'m>(marks: impl Iterator<Item = &'m Mark>) -> Option<&'m Mark> {
    marks.max_by(|a, b| a.db.total_cmp(&b.db))
}

/// Reads every riser's echoes, given the levels as known so far (`levels[k]` is the foot of riser k).
fn read(evidence: &Evidence, flight: &Flight, levels: &[f32]) -> Readings {
    let height = evidence.mount_height;
    let mut out = Readings {
        x: [None; MAX_FLIGHT],
        x_sigma: [0.015; MAX_FLIGHT],
        overhangs: Vec::new(),
        levels: [Fusion::default(); MAX_FLIGHT],
        slopes: Vec::new(),
    };
    for (i, link) in flight.chain.iter().enumerate() {
        let Some(column) = link
            .column
            .and_then(|c| evidence.columns.get(usize::from(c)))
        else {
            continue;
        };
        let members = evidence.marks.get(column.first..column.end).unwrap_or(&[]);
        let (base, top, x) = (levels[i], levels[i + 1], column.x);
        let flash = base - 0.02 < height && height < top + 0.03;
        let hidden = base > height - 0.01;
        let near = |m: &Mark, level: f32| (m.y - level).abs() < (2.5 * m.sigma).max(0.03);
        let is_corner =
            |m: &&Mark| !flight.open && !hidden && near(m, base) && m.y < base + 0.6 * (top - base);
        let is_flash = |m: &&Mark| flash && (m.y - height).abs() < 0.012 + 0.5 * m.sigma;
        let is_top = |m: &&Mark| near(m, top) && m.y > base + 0.4 * (top - base) && !is_flash(m);
        let corner = strongest(members.iter().filter(is_corner));
        let flashed = strongest(members.iter().filter(is_flash));
        let known = strongest(corner.into_iter().chain(flashed));
        let Some(all) = strongest(members.iter()) else {
            continue;
        };
        let riser_x = known.unwrap_or(all).x;
        out.x[i] = Some(riser_x);
        out.x_sigma[i] = if known.is_some() { 0.003 } else { 0.006 };
        if let Some(m) = corner
            && i > 0
            && !(flash && (height - base) / x < HIDE)
        {
            let clean = m.width < CLEAN;
            let (low, sigma) = if clean { (0.0, 0.003) } else { (0.008, 0.013) };
            out.levels[i - 1].add(Reading {
                value: m.y - low,
                sigma: math::hypot(sigma, angle_error(m, 0.1, 0.3)),
            });
        }
        if !hidden || flight.open {
            let tops = || members.iter().filter(is_top);
            let top_mark = if hidden {
                strongest(tops())
            } else {
                tops().max_by(|a, b| a.y.total_cmp(&b.y))
            };
            if let Some(m) = top_mark {
                let pulled = flash
                    && !flight.open
                    && flashed.is_some()
                    && (m.y - height).abs() / x < 0.5 * HIDE;
                if !pulled {
                    out.levels[i].add(top_level(m, flight.open, flash, hidden));
                }
                if known.is_some() {
                    let _ = out.overhangs.push(riser_x - m.x);
                }
            }
        }
        if hidden
            && !flight.open
            && let Some(before) = i.checked_sub(1).and_then(|j| out.x[j])
        {
            // The echo lies somewhere on the part of the riser that the last nosing leaves visible.
            let (q, f) = (riser_x / before, 0.5);
            let k = i as f32;
            let slope_gain = (1.0 - f) * q * k + f * (k + 1.0);
            let visible = height + (base - height) * q;
            if all.y > visible - 0.05 {
                let _ = out.slopes.push(Reading {
                    value: (all.y - (1.0 - f) * height * (1.0 - q)) / slope_gain,
                    sigma: (0.015 + 0.35 * (top - visible).max(0.05)) / slope_gain,
                });
            }
        }
    }
    out
}

/// The steps of a flight.
pub fn dimension(evidence: &Evidence, flight: &Flight) -> Outcome {
    let n = flight.chain.len();
    let mut levels = [0f32; MAX_FLIGHT + 1];
    for (k, level) in levels.iter_mut().enumerate() {
        *level = k as f32 * flight.rise;
    }
    if n == 1 && flight.rise < TOO_LOW {
        return Outcome::clear();
    }
    let mut sigmas = [0f32; MAX_FLIGHT];
    let mut readings = read(evidence, flight, &levels);
    for turn in 0..2 {
        if turn > 0 {
            readings = read(evidence, flight, &levels);
        }
        // A straight flight of slope rho from the floor, each step free to depart from it by TAU.
        let prior = 1.0 / (2.0 * flight.rise_variance + 0.01 * 0.01);
        let (mut sum, mut weight) = (prior * flight.rise, prior);
        for slope in &readings.slopes {
            let w = 1.0 / (slope.sigma * slope.sigma);
            sum += w * slope.value;
            weight += w;
        }
        let freedom = |f: &Fusion| {
            if f.weight > 0.0 {
                1.0 / (1.0 / f.weight + TAU * TAU)
            } else {
                0.0
            }
        };
        for (k, fusion) in readings.levels.iter().enumerate().take(n) {
            let i = (k + 1) as f32;
            sum += freedom(fusion) * i * fusion.mean();
            weight += freedom(fusion) * i * i;
        }
        let rho = sum / weight;
        for (k, fusion) in readings.levels.iter().enumerate().take(n) {
            let i = (k + 1) as f32;
            let gain = TAU * TAU * freedom(fusion);
            levels[k + 1] = i * rho + gain * (fusion.mean() - i * rho);
            let lean = (1.0 - gain) * i;
            sigmas[k] = SIGMA * math::sqrt((1.0 - gain) * TAU * TAU + lean * lean / weight);
        }
    }
    if n == 1 && levels[1] > TOO_HIGH {
        return Outcome::clear();
    }
    place(flight, &readings, &levels, &sigmas)
}

/// Horizontal places: nosing overhang taken off, unseen risers put on the line of the others.
fn place(flight: &Flight, readings: &Readings, levels: &[f32], sigmas: &[f32]) -> Outcome {
    let n = flight.chain.len();
    let mut overhangs = readings.overhangs.clone();
    overhangs.sort_unstable_by(f32::total_cmp);
    let count = overhangs.len();
    let median = if count > 0 {
        0.5 * (overhangs[(count - 1) / 2] + overhangs[count / 2])
    } else {
        0.0
    };
    let overhang = if median > 0.005 && !flight.open {
        median
    } else {
        0.0
    };
    let unsure = if count == 0 && !flight.open {
        0.008
    } else {
        0.0
    };
    let line = fit_line(&readings.x[..n]);
    let mut outcome = Outcome::clear();
    outcome.direction = Direction::Up;
    for k in 0..n {
        let x = readings.x[k].unwrap_or(line.0 + line.1 * k as f32);
        let _ = outcome.steps.push(Step {
            distance_m: x - overhang,
            height_m: levels[k + 1],
            tread_m: None,
            riser_m: None,
            distance_sigma_m: math::hypot(readings.x_sigma[k], unsure),
            height_sigma_m: sigmas[k].max(0.003),
            quality: 50,
        });
    }
    outcome
}

/// Least-squares line through the values that are there, over their index.
fn fit_line(values: &[Option<f32>]) -> (f32, f32) {
    let (mut n, mut sk, mut skk, mut sv, mut skv) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        if let Some(v) = value {
            let k = k as f32;
            n += 1.0;
            sk += k;
            skk += k * k;
            sv += v;
            skv += k * v;
        }
    }
    let det: f32 = n * skk - sk * sk;
    if det.abs() < 1e-6 {
        return (if n > 0.0 { sv / n } else { 0.0 }, 0.0);
    }
    let slope = (n * skv - sk * sv) / det;
    ((sv - slope * sk) / n, slope)
}
