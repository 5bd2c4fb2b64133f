//! The pipeline with arbitrary chirps. In every case an answer contains only finite numbers, a fault no
//! steps, an `ok` a horizon, and its sentences can be parsed.
//!
//! The input begins with a set-up (eight bytes, [`setup`]) and a number of points, each four bytes: distance
//! and height from the mirror in cm (u8, i8), level in dB below full scale (u8), and the phase increment
//! from row to row (u8). Every row contains the points according to the beam. The rest are operations on
//! rows, one after the other; those of the second scan follow those of the first:
//!
//! | byte | arguments | operation on the row |
//! |---|---|---|
//! | 0 | | unchanged |
//! | 1 | u8 | leaves this number of rows unchanged |
//! | 2 | | lost |
//! | 3 | i16, i16 | contains only this sample |
//! | 4 | count, bytes | contains these samples repeatedly |
//! | 5 | u16, u16 | adds a tone: phase increment a sample, amplitude |
//! | 6 | | equals the previous row |
//! | 7 | u8 | shifts every sample left by this, wrapping |

use stairscan::Iq;
use stairscan::answer::{Answer, DropEdge};
use stairscan::config::{Config, EstimatorKind, Planes};
use stairscan::motion::{Drive, Mode};
use stairscan::pipeline::Pipeline;
use stairscan::report::Sentence;
use stairscan::report::sentence::{ScanId, write_scan};
use stairscan::scanner::{DataPath, Settings};
use stairscan::verdict::{Conditions, Outcome, Status};

use crate::input::Input;

/// Speed of light, m/s.
const LIGHT: f32 = 299_792_458.0;

/// Flag in the number of rows: real-valued samples.
const REAL: u16 = 1 << 15;

/// A point scatterer.
struct Point {
    angle: f32,
    range: f32,
    amplitude: f32,
    turn: f32,
}

/// Returns the configuration from eight bytes: samples, bandwidth (50 MHz), rows (u16; the top bit selects
/// real samples), step (0.01°), plane, estimator and CFAR (bits), mirror offset (cm), mount height (cm).
pub fn setup(input: &mut Input<'_>) -> Config {
    let mut config = Config::default();
    config.radar.samples = u16::from(input.byte()) + 1;
    config.radar.bandwidth_khz = 50_000 * (u32::from(input.byte()) + 1);
    let rows = input.short();
    config.radar.real = rows & REAL != 0;
    config.sweep.angle_count = (rows & !REAL) % 400;
    config.sweep.angle_step = 10 * i32::from(input.byte());
    let bits = input.byte();
    if bits & 1 != 0 {
        config.mount.plane = Planes::Height;
    }
    if bits & 2 != 0 {
        config.estimator = EstimatorKind::Paper;
    }
    config.cfar.guard = bits >> 2 & 7;
    config.cfar.training = 1 + (bits >> 5);
    config.mount.mirror_offset = 1000 * i32::from(input.byte());
    config.mount.mount_height = 1000 * i32::from(input.byte());
    config
}

fn points(input: &mut Input<'_>) -> Vec<Point> {
    let count = usize::from(input.byte()).min(24);
    (0..count)
        .map(|_| {
            let (x, y) = (
                f32::from(input.byte()) / 100.0,
                f32::from(input.byte() as i8) / 100.0,
            );
            Point {
                angle: (-y).atan2(x),
                range: x.hypot(y),
                amplitude: 32767.0 * 10_f32.powf(-f32::from(input.byte()) / 20.0),
                turn: f32::from(input.byte()) / 40.0,
            }
        })
        .collect()
}

/// Adds the echoes of the points in row `row`.
fn show(points: &[Point], config: &Config, row: u16, chirp: &mut [Iq]) {
    let depth = config.mount.plane == Planes::Depth;
    let angle = (config.sweep.angle(row) as f32 / 1000.0).to_radians();
    let angle = if depth {
        angle
    } else {
        core::f32::consts::FRAC_PI_2 - angle
    };
    let half = config.mount.beamwidth_rad() / 2.0;
    let offset = config.mount.mirror_offset_m();
    let seen: Vec<(f32, f32, f32)> = points
        .iter()
        .map(|p| {
            let off = (angle - p.angle) / half;
            let beat =
                2.0 * (p.range + offset) * 1000.0 * config.radar.bandwidth_khz as f32 / LIGHT;
            // Two-way gain, each way 3 dB down at half of the beamwidth.
            let gain = (-core::f32::consts::LN_2 * off * off).exp();
            (p.amplitude * gain, beat, p.turn * f32::from(row))
        })
        .filter(|seen| seen.0 > 0.3)
        .collect();
    let samples = chirp.len() as f32;
    for (n, sample) in chirp.iter_mut().enumerate() {
        let (mut i, mut q) = (0.0, 0.0);
        for &(amplitude, beat, turn) in &seen {
            let (sin, cos) = (core::f32::consts::TAU * beat * n as f32 / samples + turn).sin_cos();
            i += amplitude * cos;
            q += amplitude * sin;
        }
        // Casts saturate, like a converter.
        *sample = Iq::new(i as i16, q as i16);
    }
}

/// Applies the next operation to a row. Returns false if the row is lost.
fn spoil(input: &mut Input<'_>, left: &mut u8, chirp: &mut [Iq], before: &[Iq]) -> bool {
    if *left > 0 {
        *left -= 1;
        return true;
    }
    match input.byte() % 8 {
        1 => *left = input.byte(),
        2 => return false,
        3 => chirp.fill(Iq::new(input.short() as i16, input.short() as i16)),
        4 => {
            let (pairs, _) = input.counted().as_chunks::<4>();
            if !pairs.is_empty() {
                for (sample, [a, b, c, d]) in chirp.iter_mut().zip(pairs.iter().cycle()) {
                    *sample = Iq::new(i16::from_le_bytes([*a, *b]), i16::from_le_bytes([*c, *d]));
                }
            }
        }
        5 => {
            let (turn, amplitude) = (f32::from(input.short()) / 65536.0, f32::from(input.short()));
            for (n, sample) in chirp.iter_mut().enumerate() {
                let (sin, cos) = (core::f32::consts::TAU * turn * n as f32).sin_cos();
                sample.i = sample.i.saturating_add((amplitude * cos) as i16);
                sample.q = sample.q.saturating_add((amplitude * sin) as i16);
            }
        }
        6 => chirp.copy_from_slice(before),
        7 => {
            let by = u32::from(input.byte()) % 16;
            for sample in chirp.iter_mut() {
                *sample = Iq::new(sample.i << by, sample.q << by);
            }
        }
        _ => {}
    }
    true
}

fn check(outcome: &Outcome, config: &Config) {
    let fault = outcome.status() == Status::Fault;
    assert!(!fault || outcome.answer == Answer::NONE, "{outcome:?}");
    assert!(
        !fault || !outcome.reasons().is_empty(),
        "a fault without a reason"
    );
    for step in &outcome.answer.steps {
        let lengths = [
            step.distance_m,
            step.height_m,
            step.distance_sigma_m,
            step.height_sigma_m,
        ];
        assert!(
            lengths.iter().all(|v| v.is_finite() && v.abs() < 1e3),
            "{step:?}"
        );
        assert!(
            step.distance_sigma_m >= 0.0 && step.height_sigma_m >= 0.0,
            "{step:?}"
        );
        assert!(step.tread_m.is_none_or(|v| v >= 0.0), "{step:?}");
    }
    let probability = |p: f32| (0.0..=1.0).contains(&p);
    assert!(outcome.confidence().is_none_or(probability), "{outcome:?}");
    assert!(
        outcome
            .answer
            .possible_steps
            .iter()
            .all(|m| probability(m.probability)),
        "{outcome:?}"
    );
    let drop = outcome.answer.drop.as_ref();
    let sound = |d: &DropEdge| {
        let lengths = [d.distance_m, d.distance_sigma_m, d.depth_m.unwrap_or(0.0)];
        lengths.iter().all(|v| v.is_finite() && v.abs() < 1e3)
            && d.distance_sigma_m >= 0.0
            && probability(d.probability)
    };
    assert!(drop.is_none_or(sound), "{outcome:?}");
    let free = |m: f32| outcome.horizon_m().is_some_and(|h| (0.0..=h).contains(&m));
    assert!(outcome.free_m().is_none_or(free), "{outcome:?}");
    let least = drop.map_or(1.0, |drop| drop.nearest_m().min(1.0));
    let is_valid = outcome
        .horizon_m()
        .is_some_and(|h| h.is_finite() && h > 0.0 && h >= least);
    let likelihood = config.estimator == EstimatorKind::Likelihood;
    assert!(
        outcome.status() != Status::Ok || !likelihood || is_valid,
        "{outcome:?}"
    );
    write_scan(ScanId::FIRST, 0, outcome, |line| {
        Sentence::parse(line).unwrap_or_else(|e| panic!("{e:?}: {line}"));
    });
}

/// Scans twice, forward and backward.
pub fn run(data: &[u8]) {
    let mut input = Input(data);
    let config = setup(&mut input);
    let points = points(&mut input);
    // The scanner does not scan with settings that it refuses.
    let settings = Settings {
        config,
        ..Settings::default()
    };
    if settings.validate().is_err() {
        return;
    }
    let mut pipeline = Box::new(Pipeline::new());
    let mut left = 0;
    for scan in 1..=2 {
        pipeline.begin(&config, scan).expect("valid settings");
        let rows = config.sweep.angle_count;
        let mut before = vec![Iq::default(); pipeline.samples().len()];
        for k in 0..rows {
            let row = if scan == 1 { k } else { rows - 1 - k };
            show(&points, &config, row, pipeline.samples());
            if spoil(&mut input, &mut left, pipeline.samples(), &before) {
                before.copy_from_slice(pipeline.samples());
                pipeline.row(row);
            } else {
                pipeline.lost(row);
            }
        }
        let drive = Drive {
            mode: if scan == 1 {
                Mode::Standing
            } else {
                Mode::Auto
            },
            ..Drive::STANDING
        };
        check(&pipeline.conclude(&drive, Conditions::GOOD), &config);
    }
}
