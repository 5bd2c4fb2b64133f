//! Tests the whole pipeline on the repository's recordings against their ground truth
//! (`scenes/*.toml`).

use std::path::Path;

use stairscan::Iq;
use stairscan::answer::Direction;
use stairscan::config::{Config, EstimatorKind, MountConfig, Planes};
use stairscan::pipeline::Pipeline;
use stairscan::scanner::DataPath;
use stairscan::verdict::{Outcome, Status};

/// Returns the samples of a recording in `recordings/`: 281 chirps of 200.
fn chirps(name: &str) -> Vec<Vec<Iq>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("recordings/{name}.sigmf-data"));
    let bytes = std::fs::read(path).unwrap();
    let part = |b: &[u8]| i16::from_le_bytes([b[0], b[1]]);
    let samples: Vec<Iq> = bytes
        .chunks(4)
        .map(|b| Iq::new(part(&b[..2]), part(&b[2..])))
        .collect();
    let chirps: Vec<Vec<Iq>> = samples.chunks(200).map(<[Iq]>::to_vec).collect();
    assert_eq!(chirps.len(), 281);
    chirps
}

fn config(estimator: EstimatorKind) -> Config {
    Config {
        estimator,
        seed: 1,
        ..Config::default()
    }
}

fn descending() -> Config {
    let mount = MountConfig {
        plane: Planes::Height,
        mount_height: 120_000,
        ..MountConfig::default()
    };
    Config {
        mount,
        ..config(EstimatorKind::default())
    }
}

/// Scans with the rows in the given order.
fn scan(name: &str, config: &Config, order: impl Iterator<Item = u16>) -> Outcome {
    let chirps = chirps(name);
    let mut pipeline = Box::new(Pipeline::new());
    pipeline.begin(config, 1).unwrap();
    for row in order {
        pipeline
            .samples()
            .copy_from_slice(&chirps[usize::from(row)]);
        pipeline.row(row);
    }
    pipeline.finish()
}

/// Asserts that every true step is found within 10 cm in distance and 4 cm in height, that nothing
/// else is reported, and that no error exceeds six standard deviations.
fn is_exact(outcome: &Outcome, direction: Direction, truth: &[(f32, f32)]) {
    assert_ne!(outcome.status(), Status::Fault, "{outcome:?}");
    assert_eq!(outcome.answer.direction, direction, "{outcome:?}");
    assert_eq!(outcome.answer.steps.len(), truth.len(), "{outcome:?}");
    for (step, &(distance, height)) in outcome.answer.steps.iter().zip(truth) {
        let (d, h) = (step.distance_m - distance, step.height_m - height);
        assert!(
            d.abs() < 0.10 && d.abs() < 6.0 * step.distance_sigma_m,
            "{step:?}: {d}"
        );
        assert!(
            h.abs() < 0.04 && h.abs() < 6.0 * step.height_sigma_m,
            "{step:?}: {h}"
        );
    }
}

const STAIR_A: [(f32, f32); 3] = [(0.50, 0.165), (0.78, 0.33), (1.06, 0.495)];

#[test]
fn the_paper_s_three_staircases() {
    let config = config(EstimatorKind::default());
    let b = [(0.50, 0.172), (0.795, 0.344), (1.09, 0.516)];
    let c = [(0.50, 0.178), (0.775, 0.356), (1.05, 0.534)];
    for (name, truth) in [("stair_a", STAIR_A), ("stair_b", b), ("stair_c", c)] {
        is_exact(&scan(name, &config, 0..281), Direction::Up, &truth);
    }
}

#[test]
fn treads_and_risers_lie_between_the_steps() {
    let outcome = scan("stair_a", &config(EstimatorKind::default()), 0..281);
    let mut before = 0.0;
    for (k, step) in outcome.answer.steps.iter().enumerate() {
        let next = outcome
            .answer
            .steps
            .get(k + 1)
            .map(|next| next.distance_m - step.distance_m);
        assert_eq!(step.tread_m, next);
        assert_eq!(step.riser_m, Some(step.height_m - before));
        before = step.height_m;
    }
}

#[test]
fn stairs_down() {
    let truth = [(-0.06, -0.16), (0.24, -0.32), (0.54, -0.48), (0.84, -0.64)];
    is_exact(
        &scan("descending", &descending(), 0..281),
        Direction::Down,
        &truth,
    );
}

#[test]
fn an_empty_room_is_clear() {
    let outcome = scan("empty", &config(EstimatorKind::default()), 0..281);
    let answer = &outcome.answer;
    assert_eq!((answer.direction, answer.steps.len()), (Direction::None, 0));
    assert_ne!(outcome.status(), Status::Fault);
    assert!(
        outcome.horizon_m().is_some_and(|end| end > 0.0),
        "{outcome:?}"
    );
}

#[test]
fn either_way_of_the_sweep_gives_the_same_bits() {
    for estimator in EstimatorKind::ALL {
        for name in ["stair_a", "stair_c", "empty"] {
            let config = config(*estimator);
            let there = scan(name, &config, 0..281);
            let back = scan(name, &config, (0..281).rev());
            assert_eq!(there, back, "{name} with {estimator:?}");
        }
    }
    let there = scan("descending", &descending(), 0..281);
    assert_eq!(there, scan("descending", &descending(), (0..281).rev()));
}

#[test]
fn blind_scanners_say_so() {
    let config = config(EstimatorKind::default());
    let mut pipeline = Box::new(Pipeline::new());
    for sample in [Iq::new(0, 0), Iq::new(123, -5), Iq::new(32767, -32768)] {
        pipeline.begin(&config, 1).unwrap();
        for row in 0..281 {
            pipeline.samples().fill(sample);
            pipeline.row(row);
        }
        let outcome = pipeline.finish();
        assert_eq!(outcome.status(), Status::Fault, "{sample:?}");
        assert!(outcome.answer.steps.is_empty() && !outcome.reasons().is_empty());
    }
}

#[test]
fn a_pipeline_starts_each_scan_afresh() {
    let config = config(EstimatorKind::default());
    let mut pipeline = Box::new(Pipeline::new());
    let mut outcomes = Vec::new();
    for name in ["stair_a", "stair_b", "stair_a"] {
        let chirps = chirps(name);
        pipeline.begin(&config, 1).unwrap();
        for row in 0..281 {
            pipeline
                .samples()
                .copy_from_slice(&chirps[usize::from(row)]);
            pipeline.row(row);
        }
        outcomes.push(pipeline.finish());
    }
    assert_eq!(outcomes[0], outcomes[2]);
    assert_ne!(outcomes[0], outcomes[1]);
}
