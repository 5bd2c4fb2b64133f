//! Fits the parameters of the measurement model to the statistics of labelled echoes (maximum posterior).

use crate::fit::portable::Portable as _;
use std::f64::consts::TAU;

use super::labels::{Hit, Level};
use stairscan::model::{Class, MIN_DB};
use stairscan::params::generative::{EXTENDED, Extended, Generative, POINTS, Point};

use super::climb::{Peak, Prior, from_means};
use super::counts::{Counts, DetectionTrial, Scan};
use super::density::{above, level, log_tailed, tailed};
use super::prior::{START, floor, sigma};
use crate::fit::logistic;

/// Names of the classes of point features.
pub const POINT_NAMES: [&str; POINTS] = [
    "corner",
    "nosing",
    "flash",
    "top",
    "hidden",
    "edge below",
    "edge above",
];
/// Names of the classes of extended features.
pub const EXTENDED_NAMES: [&str; EXTENDED] = ["face", "tread", "floor", "air", "inside", "noise"];
/// Index of the class of noise, the last of the extended features.
const NOISE: usize = EXTENDED - 1;
/// Number of extended classes that lie on a surface: face, tread, floor. They are the first ones.
const SURFACES: usize = 3;
/// Weight of the uniform component in the distribution of the SNR of a point feature's echoes, as in the model.
const POINT_FLAT: f64 = 0.05;
/// Weight of the uniform component in the distribution of the SNR of each extended class's echoes, as in the model.
const EXTENDED_FLAT: [f64; EXTENDED] = [0.05, 0.002, 0.005, 0.05, 0.01, 0.0];
/// Variance of the visible ends of a hidden riser due to the beam, m², as in the model.
const SOFT_M2: f64 = 0.000_144;
/// Minimum visible height of a hidden riser, metres, as in the model.
const MIN_SPAN_M: f64 = 0.01;

/// A fitted parameter of the measurement model.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// Name of the parameter: those of its class and of its field.
    pub name: String,
    /// Fitted value, in the field's unit.
    pub value: f64,
    /// Standard error of the value.
    pub error: f64,
    /// Number of samples that it is fitted to.
    pub count: usize,
}

/// Collects the fitted parameters of one class.
struct ParameterLog<'n> {
    class: &'static str,
    count: usize,
    numbers: &'n mut Vec<Number>,
}

impl ParameterLog<'_> {
    fn number(&mut self, field: &str, value: f64, error: f64) -> f32 {
        self.numbers.push(Number {
            name: format!("{} {field}", self.class),
            value,
            error,
            count: self.count,
        });
        value as f32
    }

    /// Adds to the list a standard deviation with the lower bound `floor`, from the fitted excess over it (value,
    /// standard error), and returns the standard deviation. Excess and bound add as variances.
    fn spread(&mut self, field: &str, floor: f64, (over, error): (f64, f64)) -> f32 {
        let value = floor.hypot(over);
        self.number(field, value, error * over.abs() / value)
    }
}

impl Peak {
    fn of(&self, k: usize) -> (f64, f64) {
        (self.at[k], self.errors[k])
    }
}

fn around(mean: f32, sigma: f64) -> Prior {
    Prior {
        mean: mean.into(),
        sigma,
    }
}

/// Returns the prior of a standard deviation's excess over its lower bound `floor`, around that of `value`. Excess
/// and bound add as variances.
fn over(value: f32, floor: f64, sigma: f64) -> Prior {
    let value = f64::from(value);
    Prior {
        mean: (value * value - floor * floor).max(0.0).sqrt(),
        sigma,
    }
}

/// Fits the measurement model's parameters to the statistics of echoes that were labelled with the parameters `old`.
/// Returns them, also as a list with standard errors.
pub fn estimate(counts: &Counts, old: &Generative) -> (Generative, Vec<Number>) {
    let mut new = START;
    let mut numbers = Vec::new();
    let seen = trials(counts, old);
    for class in 0..POINTS {
        let hits = &counts.hits[class];
        let mut log = ParameterLog {
            class: POINT_NAMES[class],
            count: hits.len(),
            numbers: &mut numbers,
        };
        let start = &START.points[class];
        if class == Class::Hidden as usize {
            hidden(hits, &mut new, &mut log);
        } else {
            place(hits, start, &mut new.points[class], &mut log);
        }
        let p = &mut new.points[class];
        let levels = hits.iter().map(|h| &h.1);
        let priors = [start.snr_db, start.snr_per_db, start.snr_sigma_db];
        let floor = floor::POINT_DB;
        [p.snr_db, p.snr_per_db, p.snr_sigma_db] =
            levels_of(levels, priors, floor, POINT_FLAT, &mut log);
        if let Some(fit) = &seen[class] {
            log.count = fit.samples;
            let names = ["seen", "seen per 10 dB", "seen per room"];
            let mut weight = |k: usize| log.number(names[k], fit.weights[k], fit.errors[k]);
            (p.seen, p.seen_per_ten_db, p.seen_per_room) = (weight(0), weight(1), weight(2));
        }
    }
    for class in 0..EXTENDED {
        extended(counts, class, &mut new.extended[class], &mut numbers);
    }
    let fit = logistic::fit(&counts.risers, 4, sigma::ODDS);
    let mut log = ParameterLog {
        class: "riser",
        count: fit.samples,
        numbers: &mut numbers,
    };
    let names = [
        "nothing",
        "nothing per 10 dB",
        "nothing if hidden",
        "nothing per 10 dB before",
    ];
    for (k, name) in names.into_iter().enumerate() {
        new.hidden.nothing[k] = log.number(name, fit.weights[k], fit.errors[k]);
    }
    (new, numbers)
}

/// Fits mean and standard deviation of the offsets of a class's echoes from their feature, and sets them in `p`.
fn place(hits: &[(Hit, Level)], start: &Point, p: &mut Point, log: &mut ParameterLog<'_>) {
    let priors = [
        around(start.range_m, sigma::RANGE_M),
        over(start.range_sigma_m, floor::RANGE_M, sigma::RANGE_M),
        around(start.across_m, sigma::ACROSS_M),
        over(start.across_sigma_m, floor::ACROSS_M, sigma::ACROSS_M),
        around(start.across_per_width_m, sigma::WIDTH_M),
        over(start.sigma_per_width_m, floor::WIDTH_M, sigma::WIDTH_M),
    ];
    let peak = from_means(&priors, |x| {
        let vr = x[1] * x[1] + floor::RANGE_M * floor::RANGE_M;
        let least = floor::ACROSS_M * floor::ACROSS_M;
        let log = |(hit, _): &(Hit, Level)| {
            let (wide, noise) = (f64::from(hit.wide), f64::from(hit.noise_m));
            let dr = f64::from(hit.range_m) - x[0];
            let dc = f64::from(hit.across_m) - x[2] - x[4] * wide;
            let by_width = x[5].hypot(floor::WIDTH_M) * wide;
            let vc = x[3] * x[3] + least + by_width * by_width + noise * noise;
            log_tailed(dr * dr / vr + dc * dc / vc) - 0.5 * (vr * vc).ln_portable()
        };
        hits.iter().map(log).sum()
    });
    let number = |log: &mut ParameterLog<'_>, name, (value, error)| log.number(name, value, error);
    p.range_m = number(log, "range m", peak.of(0));
    p.range_sigma_m = log.spread("range sigma m", floor::RANGE_M, peak.of(1));
    p.across_m = number(log, "across m", peak.of(2));
    p.across_sigma_m = log.spread("across sigma m", floor::ACROSS_M, peak.of(3));
    p.across_per_width_m = number(log, "across per width m", peak.of(4));
    p.sigma_per_width_m = log.spread("sigma per width m", floor::WIDTH_M, peak.of(5));
}

/// Fits the places of the echoes of hidden risers, a mixture of three (the lower end of the visible part, the top,
/// uniform between them), and sets them in `new`.
fn hidden(hits: &[(Hit, Level)], new: &mut Generative, log: &mut ParameterLog<'_>) {
    let class = Class::Hidden as usize;
    let (start, ends) = (&START.points[class], [START.hidden.low, START.hidden.top]);
    let rest = 1.0 - ends[0][0] - ends[1][0];
    // Shares as log-odds against the rest.
    let share = |k: usize| {
        around(
            f64::from(ends[k][0] / rest).ln_portable() as f32,
            sigma::ODDS,
        )
    };
    let priors = [
        around(start.range_m, sigma::RANGE_M),
        over(start.range_sigma_m, floor::RANGE_M, sigma::RANGE_M),
        over(start.sigma_per_width_m, floor::WIDTH_M, sigma::WIDTH_M),
        share(0),
        around(ends[0][1], sigma::ACROSS_M),
        over(ends[0][2], floor::HIDDEN_M, sigma::ACROSS_M),
        share(1),
        around(ends[1][1], sigma::ACROSS_M),
        over(ends[1][2], floor::HIDDEN_M, sigma::ACROSS_M),
    ];
    let shares = |x: &[f64]| {
        let (low, top) = (x[3].exp_portable(), x[6].exp_portable());
        let all = 1.0 + low + top;
        [low / all, top / all, 1.0 / all]
    };
    let peak = from_means(&priors, |x| {
        let shares = shares(x);
        let vr = x[1] * x[1] + floor::RANGE_M * floor::RANGE_M;
        let log = |(hit, _): &(Hit, Level)| {
            let noise = f64::from(hit.noise_m);
            let by_width = x[2].hypot(floor::WIDTH_M) * f64::from(hit.wide);
            let va = noise * noise + by_width * by_width;
            let [low, top] = hit.above_m.map(f64::from);
            let dx = f64::from(hit.range_m) - x[0];
            let end = |share: f64, dx: f64, above: f64, offset: f64, spread: f64| {
                let v = spread * spread + floor::HIDDEN_M * floor::HIDDEN_M + va;
                let y = (above - offset) / f64::from(hit.cos);
                share * tailed(dx * dx / vr + y * y / v, vr * v)
            };
            let soft = (SOFT_M2 + va).sqrt();
            let within = (above(-low / soft) - above(-top / soft)).max(0.0);
            let even = within / (low - top).max(MIN_SPAN_M);
            let face =
                shares[2] * even * log_tailed(dx * dx / vr).exp_portable() / (TAU * vr).sqrt();
            let at_low = end(shares[0], dx, low, x[4], x[5]);
            let at_top = end(shares[1], dx + f64::from(hit.over_m), top, x[7], x[8]);
            (at_low + at_top + face + f64::MIN_POSITIVE).ln_portable()
        };
        hits.iter().map(log).sum()
    });
    let p = &mut new.points[class];
    let (value, error) = peak.of(0);
    p.range_m = log.number("range m", value, error);
    p.range_sigma_m = log.spread("range sigma m", floor::RANGE_M, peak.of(1));
    p.sigma_per_width_m = log.spread("sigma per width m", floor::WIDTH_M, peak.of(2));
    (p.across_m, p.across_sigma_m) = (0.0, 0.0);
    let shares = shares(&peak.at);
    let ends = [("low", 3), ("top", 6)];
    for (k, (name, at)) in ends.into_iter().enumerate() {
        let error = shares[k] * (1.0 - shares[k]) * peak.errors[at];
        let share = log.number(&format!("{name} share"), shares[k], error);
        let (value, error) = peak.of(at + 1);
        let offset = log.number(&format!("{name} m"), value, error);
        let field = format!("{name} sigma m");
        let spread = log.spread(&field, floor::HIDDEN_M, peak.of(at + 2));
        let end = match k {
            0 => &mut new.hidden.low,
            _ => &mut new.hidden.top,
        };
        *end = [share, offset, spread];
    }
}

/// Returns three fitted parameters of the echoes' SNR: its mean where the scan's strongest echo has 30 dB, dB; its
/// slope, per dB of that echo; its standard deviation, dB, at least `floor`.
fn levels_of<'l>(
    levels: impl Iterator<Item = &'l Level>,
    start: [f32; 3],
    floor: f64,
    flat: f64,
    log: &mut ParameterLog<'_>,
) -> [f32; 3] {
    let levels: Vec<_> = levels.collect();
    let priors = [
        around(start[0], sigma::SNR_DB),
        around(start[1], sigma::SNR_PER_DB),
        over(start[2], floor, sigma::SNR_DB),
    ];
    let peak = from_means(&priors, |x| {
        let spread = x[2].hypot(floor);
        let log = |l: &&Level| {
            let mean = x[0] + x[1] * TEN_DB * f64::from(l.q) + f64::from(l.fade_db);
            level(l.snr_db.into(), mean, spread, flat).ln_portable()
        };
        levels.iter().map(log).sum()
    });
    [
        log.number("snr dB", peak.at[0], peak.errors[0]),
        log.number("snr per dB", peak.at[1], peak.errors[1]),
        log.spread("snr sigma dB", floor, peak.of(2)),
    ]
}

/// Decibels per unit of the covariates in tens of dB.
const TEN_DB: f64 = 10.0;

/// Fits the log-odds of detection of each class of point features; `None` for a class without samples.
///
/// The model requires that a riser which shows anything shows at least one feature. Risers without a
/// detected feature are therefore left out, and each of the others is weighted for those that are
/// left out: risers with the same probabilities of detection of which all features stay undetected. A
/// riser with a single feature carries no information here.
fn trials(counts: &Counts, old: &Generative) -> Vec<Option<logistic::LogisticFit>> {
    let mut rows = vec![Vec::new(); POINTS];
    for riser in counts.trials.iter().filter(|r| r.len() > 1) {
        if riser.iter().all(|f| !f.seen) {
            continue;
        }
        let unseen: f64 = riser.iter().map(|f| 1.0 - probability(f, old)).product();
        for f in riser {
            rows[f.class].push((f.on.to_vec(), f.seen, 1.0));
            rows[f.class].push((f.on.to_vec(), false, unseen / (1.0 - unseen)));
        }
    }
    let fit = |rows: &Vec<_>| (!rows.is_empty()).then(|| logistic::weighted(rows, 3, sigma::ODDS));
    rows.iter().map(fit).collect()
}

fn probability(f: &DetectionTrial, g: &Generative) -> f64 {
    let p = &g.points[f.class];
    let weights = [p.seen, p.seen_per_ten_db, p.seen_per_room].map(f64::from);
    let odds: f64 = weights.iter().zip(&f.on).map(|(w, x)| w * x).sum();
    (1.0 / (1.0 + (-odds).exp_portable())).clamp(MIN_DETECTION, MAX_DETECTION)
}

/// Minimum probability of detection, as in the model.
const MIN_DETECTION: f64 = 0.02;
/// Maximum probability of detection, as in the model.
const MAX_DETECTION: f64 = 0.985;

/// Fits the rate of the echoes of a class of extended features, their SNR and their distances from the surface, and
/// sets the results in `p`.
fn extended(counts: &Counts, class: usize, p: &mut Extended, numbers: &mut Vec<Number>) {
    let (start, samples) = (&START.extended[class], &counts.extended[class]);
    let mut log = ParameterLog {
        class: EXTENDED_NAMES[class],
        count: samples.len(),
        numbers,
    };
    let priors = match class {
        NOISE => vec![around(start.rate, sigma::RATE)],
        _ => vec![
            around(start.rate, sigma::RATE),
            around(start.rate_per_ten_db, sigma::RATE_PER_TEN_DB),
        ],
    };
    let peak = from_means(&priors, |x| {
        let log = |s: &Scan| {
            let log_rate = x[0] + x.get(1).map_or(0.0, |per| per * s.q);
            s.echoes[class] * log_rate - s.exposure[class] * log_rate.exp_portable()
        };
        counts.scans.iter().map(log).sum()
    });
    p.rate = log.number("rate", peak.at[0], peak.errors[0]);
    if class == NOISE {
        let above = samples.iter().map(|s| f64::from(s.0.snr_db - MIN_DB));
        let count = samples.len().max(1) as f64;
        let mean = (above.sum::<f64>() / count).max(floor::NOISE_DB);
        p.snr_sigma_db = log.number("snr sigma dB", mean, mean / count.sqrt());
        return;
    }
    p.rate_per_ten_db = log.number("rate per 10 dB", peak.at[1], peak.errors[1]);
    let levels = samples.iter().map(|s| &s.0);
    let (floor, flat) = (floor::EXTENDED_DB, EXTENDED_FLAT[class]);
    let priors = [start.snr_db, start.snr_per_db, start.snr_sigma_db];
    [p.snr_db, p.snr_per_db, p.snr_sigma_db] = levels_of(levels, priors, floor, flat, &mut log);
    if class < SURFACES {
        let prior = over(start.off_sigma_m, floor::OFF_M, sigma::ACROSS_M);
        let peak = from_means(&[prior], |x| {
            let log = |s: &(Level, f64, f64)| {
                let v = x[0] * x[0] + floor::OFF_M * floor::OFF_M + s.2 * s.2;
                log_tailed(s.1 * s.1 / v) - 0.5 * v.ln_portable()
            };
            samples.iter().map(log).sum()
        });
        p.off_sigma_m = log.spread("off sigma m", floor::OFF_M, peak.of(0));
    }
}
