//! Fits the model of treads seen from above (height plane): rates of echoes, their SNR and heights, and echoes at the
//! treads' ends.

use crate::fit::portable::Portable as _;
use std::f64::consts::PI;

use rayon::prelude::*;
use stairscan::config::Plane;
use stairscan::model::treads::{Descending, LEVEL_DB, MAX_TREADS, height_density};
use stairscan::params::descent::{END_BEYOND_M, TREAD_OFF_M};
use stairscan::params::generative::{LEVELS, TreadEnd, TreadNumbers};
use stairscan::signal::echoes::Echo;

use super::climb::{Peak, Prior, from_means};
use super::estimate::Number;
use super::flights::MeasurementSample;

/// Width of a stretch of tread in which echoes are counted, degrees of the beam's angle.
const STRETCH_DEG: f64 = 2.0;
/// Maximum distance along a tread between its end and an echo that is counted as the end's, metres.
const WINDOW_M: f64 = 0.06;
/// Height difference to every tread beyond which an echo is background, metres.
const OTHER_M: f64 = 0.03;
/// Number of background echoes of each SNR class per square metre that is added to the counted ones, for objects that
/// no scene of the draw contains.
const UNKNOWN_PER_M2: f64 = 0.007;
/// Range from the mirror at which the visible area begins, metres.
const NEAREST_M: f64 = 0.25;
/// 98.5 % quantile of the magnitude of a normal variable.
const NORMAL_985: f64 = 2.432;
/// Degrees per radian.
const DEG_PER_RAD: f64 = 180.0 / PI;

/// A tread of a true staircase: its height above the ground, and the distances at which it begins to be visible and
/// ends, metres.
#[derive(Clone, Copy, Debug)]
struct TrueTread {
    y_m: f64,
    from_m: f64,
    to_m: f64,
}

/// A scan of the height plane with its true treads.
struct SeenScan<'s> {
    measurement_sample: &'s MeasurementSample,
    treads: Vec<TrueTread>,
    /// SNR of the scan's strongest echo, tens of dB over 30 dB.
    q: f64,
}

impl<'s> SeenScan<'s> {
    fn of(measurement_sample: &'s MeasurementSample) -> Self {
        let truth = &measurement_sample.truth;
        let mut edges: Vec<_> = truth.steps.iter().chain(&truth.uncounted).collect();
        edges.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
        let height_m = f64::from(measurement_sample.view.height_m);
        let (mut y_m, mut from_m) = (0.0, f64::NEG_INFINITY);
        let mut treads = Vec::new();
        for edge in edges {
            let to_m = edge.distance_m;
            treads.push(TrueTread { y_m, from_m, to_m });
            let deeper = (height_m - edge.height_m) / (height_m - y_m);
            from_m = if to_m < 0.0 { to_m } else { to_m * deeper };
            y_m = edge.height_m;
        }
        treads.push(TrueTread {
            y_m,
            from_m,
            to_m: f64::INFINITY,
        });
        let levels = measurement_sample
            .echoes
            .iter()
            .map(|e| f64::from(e.snr_db));
        Self {
            measurement_sample,
            treads,
            q: (levels.fold(0.0, f64::max) - 30.0) / 10.0,
        }
    }

    fn depth_m(&self, tread: &TrueTread) -> f64 {
        f64::from(self.measurement_sample.view.height_m) - tread.y_m
    }

    /// Returns the true tread that an echo lies on; `None` if it lies on none.
    fn tread_of(&self, e: &Echo) -> Option<&TrueTread> {
        let on = |t: &&TrueTread| {
            let (x_m, y_m) = (f64::from(e.x_m), f64::from(e.y_m));
            let inside = x_m > t.from_m - 2.0 * OTHER_M && x_m < t.to_m + 2.0 * OTHER_M;
            (y_m - t.y_m).abs() < f64::from(TREAD_OFF_M) && inside
        };
        self.treads.iter().find(on)
    }

    /// Whether an echo is background: its height is that of no tread.
    fn is_other(&self, e: &Echo) -> bool {
        let far = |t: &TrueTread| (f64::from(e.y_m) - t.y_m).abs() > OTHER_M;
        self.treads.iter().all(far)
    }

    /// Returns the area of the visible part of the plane, m².
    fn area_m2(&self) -> f64 {
        let view = &self.measurement_sample.view;
        let angle = f64::from(view.highest).atan() - f64::from(view.lowest).atan();
        let far_m = f64::from(view.farthest_m);
        0.5 * angle * (far_m * far_m - NEAREST_M * NEAREST_M)
    }
}

/// A stretch of tread in one scan: covariates of its rate of echoes (as in [`TreadNumbers::rate`]), its length, its
/// number of echoes.
struct Stretch {
    on: [f64; 4],
    length_m: f64,
    echoes: f64,
}

/// Statistics that the parameters of the tread model are fitted to.
#[derive(Default)]
struct TreadCounts {
    stretches: Vec<Stretch>,
    /// By class of SNR (1 dB each): number of echoes on treads, and number in the background.
    levels: [[f64; 2]; LEVELS],
    area_m2: f64,
    /// For each echo on a tread: its height less the tread's, and the standard deviation of that due to the error of
    /// the echo's angle, metres.
    heights: Vec<(f64, f64)>,
    /// For an end behind the mirror, an end ahead, a start behind, a start ahead: number of treads, and for each echo
    /// near the end its distance from it along the tread, the standard deviation of that from the angle's noise, both
    /// in metres, and the rate of echoes there, per metre.
    ends: [(f64, Vec<[f64; 3]>); 4],
}

fn on(q: f64, angle_deg: f64) -> [f64; 4] {
    let angle = angle_deg.abs() / 10.0;
    [1.0, q, angle, angle * q]
}

fn rate(weights: &[f64], on: &[f64; 4]) -> f64 {
    let sum: f64 = weights.iter().zip(on).map(|(w, x)| w * x).sum();
    sum.exp_portable()
}

fn gauss(x: f64, sigma: f64) -> f64 {
    let z = x / sigma;
    (-0.5 * z * z).exp_portable() / (sigma * (2.0 * PI).sqrt())
}

fn level(e: &Echo) -> usize {
    ((e.snr_db / LEVEL_DB).round() as usize).min(LEVELS - 1)
}

impl TreadCounts {
    /// Collects the statistics of all scans, except for the echoes at the treads' ends.
    fn of(scans: &[SeenScan<'_>]) -> Self {
        let mut counts = Self::default();
        for scan in scans {
            let view = &scan.measurement_sample.view;
            counts.area_m2 += scan.area_m2();
            for tread in &scan.treads {
                counts.exposed(scan, tread, (view.lowest.into(), view.highest.into()));
            }
            for e in &scan.measurement_sample.echoes {
                if let Some(tread) = scan.tread_of(e) {
                    counts.levels[level(e)][0] += 1.0;
                    let arc_m = f64::from(e.range_m * e.angle_sigma_rad);
                    let noise_m = arc_m * f64::from(e.angle_rad).sin().abs();
                    counts.heights.push((f64::from(e.y_m) - tread.y_m, noise_m));
                } else if scan.is_other(e) {
                    counts.levels[level(e)][1] += 1.0;
                }
            }
        }
        counts
    }

    /// Adds the visible stretches of a tread. `lowest` and `highest` limit the view: tangents of the beam's angle from
    /// straight down.
    fn exposed(&mut self, scan: &SeenScan<'_>, tread: &TrueTread, (lowest, highest): (f64, f64)) {
        let depth_m = scan.depth_m(tread);
        let from = (tread.from_m / depth_m).max(lowest).atan() * DEG_PER_RAD;
        let to = (tread.to_m / depth_m).min(highest).atan() * DEG_PER_RAD;
        let mut angle_deg = from;
        while angle_deg < to {
            let end_deg = (angle_deg + STRETCH_DEG).min(to);
            let place = |angle_deg: f64| depth_m * (angle_deg / DEG_PER_RAD).tan();
            let echoes = scan.measurement_sample.echoes.iter().filter(|e| {
                let here = f64::from(e.angle_rad) * DEG_PER_RAD;
                let off_m = (f64::from(e.y_m) - tread.y_m).abs();
                (angle_deg..end_deg).contains(&here) && off_m < f64::from(TREAD_OFF_M)
            });
            self.stretches.push(Stretch {
                on: on(scan.q, 0.5 * (angle_deg + end_deg)),
                length_m: place(end_deg) - place(angle_deg),
                echoes: echoes.count() as f64,
            });
            angle_deg = end_deg;
        }
    }

    /// Adds the echoes near the ends of a scan's treads. `rates` are the weights of the fitted rate of echoes along a
    /// tread.
    fn look_at_ends(&mut self, scan: &SeenScan<'_>, rates: &[f64]) {
        for pair in scan.treads.windows(2) {
            let [upper, lower] = pair else { continue };
            let ahead = usize::from(upper.to_m >= 0.0);
            for (k, tread) in [(ahead, upper), (2 + ahead, lower)] {
                self.ends[k].0 += 1.0;
                for e in &scan.measurement_sample.echoes {
                    let x_m = f64::from(e.x_m);
                    let on_m = if k < 2 {
                        tread.to_m - x_m
                    } else {
                        x_m - tread.from_m
                    };
                    let off_m = (f64::from(e.y_m) - tread.y_m).abs();
                    if on_m.abs() < WINDOW_M && off_m < f64::from(TREAD_OFF_M) {
                        let angle_deg = f64::from(e.angle_rad) * DEG_PER_RAD;
                        let arc_m = f64::from(e.range_m * e.angle_sigma_rad);
                        let noise_m = arc_m * f64::from(e.angle_rad).cos();
                        let here = rate(rates, &on(scan.q, angle_deg));
                        self.ends[k].1.push([on_m, noise_m, here]);
                    }
                }
            }
        }
    }
}

/// Collects the fitted parameters with names and standard errors.
struct Listed {
    numbers: Vec<Number>,
}

impl Listed {
    fn take(&mut self, names: &[&str], of: &str, peak: &Peak, count: usize) {
        for ((field, value), error) in names.iter().zip(&peak.at).zip(&peak.errors) {
            self.numbers.push(Number {
                name: format!("{of} {field}"),
                value: *value,
                error: *error,
                count,
            });
        }
    }
}

/// Wide priors of the weights of the rate of echoes (see [`TreadNumbers::rate`]), from the antenna's lobes and
/// building practice.
const RATES: [Prior; 4] = [
    prior(2.0, 1.0),
    prior(0.0, 1.0),
    prior(-0.3, 1.0),
    prior(0.0, 1.0),
];
/// Prior of the natural logarithm of the standard deviation of tread echoes' heights in millimetres; as wide as
/// [`RATES`].
const HEIGHT: Prior = prior(1.0, 1.0);
/// Priors for the echoes at a tread's end: logarithm of their number; their place along the tread, centimetres;
/// logarithm of the place's standard deviation in centimetres. As wide as [`RATES`].
const END: [Prior; 3] = [prior(-1.0, 1.0), prior(0.0, 1.0), prior(-0.5, 0.5)];

const fn prior(mean: f64, sigma: f64) -> Prior {
    Prior { mean, sigma }
}

/// Fits the tread model to scans of the height plane. Returns its parameters, also as a list with standard errors.
pub fn measure(measurement_samples: &[MeasurementSample]) -> (TreadNumbers, Vec<Number>) {
    let below = measurement_samples.iter();
    let below =
        below.filter(|measurement_sample| measurement_sample.geometry.plane == Plane::Height);
    let scans: Vec<_> = below.map(SeenScan::of).collect();
    let mut counts = TreadCounts::of(&scans);
    let mut listed = Listed {
        numbers: Vec::new(),
    };
    let rates = from_means(&RATES, |weights| {
        let each = counts.stretches.iter().map(|s| {
            let expected = s.length_m * rate(weights, &s.on);
            s.echoes * expected.max(f64::MIN_POSITIVE).ln_portable() - expected
        });
        each.sum()
    });
    let names = [
        "rate",
        "rate_per_ten_db",
        "rate_per_ten_deg",
        "rate_per_both",
    ];
    listed.take(&names, "treads", &rates, counts.stretches.len());
    for scan in &scans {
        counts.look_at_ends(scan, &rates.at);
    }
    let height = from_means(&[HEIGHT], |log| {
        let sigma_m = 0.001 * log[0].exp_portable();
        let each = counts.heights.iter().map(|&(off_m, noise_m)| {
            let density = height_density(off_m as f32, sigma_m.hypot(noise_m) as f32);
            f64::from(density).max(f64::MIN_POSITIVE).ln_portable()
        });
        each.sum()
    });
    listed.take(
        &["ln height_sigma_mm"],
        "treads",
        &height,
        counts.heights.len(),
    );
    let mut ends =
        counts
            .ends
            .iter()
            .zip(["end behind", "end ahead", "start behind", "start ahead"]);
    let mut end = || {
        let Some(((treads, echoes), name)) = ends.next() else {
            return TreadEnd {
                number: 0.0,
                off_m: 0.0,
                sigma_m: 0.01,
            };
        };
        let peak = from_means(&END, |p| end_log_likelihood(p, *treads, echoes));
        listed.take(
            &["ln number", "off_cm", "ln sigma_cm"],
            name,
            &peak,
            echoes.len(),
        );
        TreadEnd {
            number: peak.at[0].exp_portable() as f32,
            off_m: (0.01 * peak.at[1]) as f32,
            sigma_m: (0.01 * peak.at[2].exp_portable()) as f32,
        }
    };
    let (ends, starts) = ([end(), end()], [end(), end()]);
    let mut numbers = TreadNumbers {
        rate: [0, 1, 2, 3].map(|k| rates.at[k] as f32),
        ratio_m2: counts.ratios(),
        height_sigma_m: (0.001 * height.at[0].exp_portable()) as f32,
        ends,
        starts,
        edge_sigma_scale: 1.0,
    };
    numbers.edge_sigma_scale = edge_sigma_scale(&scans, numbers) as f32;
    (numbers, listed.numbers)
}

/// Returns the factor by which the errors of placed edges exceed their stated σ: the 98.5 % quantile of the
/// errors divided by σ, over that of a normal distribution: half of what `ok` permits. Beyond it lie edges that were
/// mistaken for another's. The model with `numbers` places the edges, given the true heights
/// of the treads.
fn edge_sigma_scale(scans: &[SeenScan<'_>], numbers: TreadNumbers) -> f64 {
    // `Descending` keeps the reference.
    let numbers: &'static TreadNumbers = Box::leak(Box::new(numbers));
    let of = |scan: &SeenScan<'_>| {
        let mut model = Descending::new(numbers);
        model.set_echoes(
            &scan.measurement_sample.echoes,
            scan.measurement_sample.view,
        );
        let below = scan.treads.iter().skip(1).take(MAX_TREADS);
        let treads: Vec<_> = below.map(|t| model.tread(t.y_m as f32)).collect();
        model.evaluate(&treads);
        let edges = scan.treads.iter().take(treads.len()).enumerate();
        let errors = edges.map(|(k, upper)| {
            let place = model.place(treads.len(), k);
            (f64::from(place.value) - upper.to_m) / f64::from(place.sigma())
        });
        errors.map(f64::abs).collect::<Vec<_>>()
    };
    let mut errors: Vec<f64> = scans.par_iter().flat_map_iter(of).collect();
    errors.sort_by(f64::total_cmp);
    let within = errors.get((errors.len() * 985).div_ceil(1000).saturating_sub(1));
    within.map_or(1.0, |z| z / NORMAL_985)
}

/// Log-likelihood of the echoes near an end: the rate of the tread up to it plus the echoes of the end itself. `p`
/// holds the parameters of [`END`], `echoes` distance, standard deviation (metres) and rate as in [`TreadCounts`].
fn end_log_likelihood(p: &[f64], treads: f64, echoes: &[[f64; 3]]) -> f64 {
    let (number, off_m) = (p[0].exp_portable(), 0.01 * p[1]);
    let sigma_m = 0.01 * p[2].exp_portable();
    let each = echoes.iter().map(|&[on_m, noise_m, rate]| {
        let sigma_m = sigma_m.hypot(noise_m);
        let on = 1.0 / (1.0 + (-1.702 * (on_m + f64::from(END_BEYOND_M)) / sigma_m).exp_portable());
        let density = rate * on + number * gauss(on_m - off_m, sigma_m);
        density.max(1e-12).ln_portable()
    });
    each.sum::<f64>() - treads * number
}

impl TreadCounts {
    /// Returns for each class of SNR (1 dB) its share of the echoes on treads, divided by its number of background
    /// echoes per square metre, m².
    fn ratios(&self) -> [f32; LEVELS] {
        let on: f64 = self.levels.iter().map(|[on, _]| on).sum();
        self.levels.map(|[tread, other]| {
            let share = tread / on.max(1.0);
            let others = other / self.area_m2.max(f64::MIN_POSITIVE) + UNKNOWN_PER_M2;
            (share / others) as f32
        })
    }
}
