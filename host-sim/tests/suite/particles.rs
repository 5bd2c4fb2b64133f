//! Tests the contribution of the particles: without them the answers are different and worse.

use std::path::Path;

use host_sim::inspect::repeat_with;
use host_sim::random::Kind;
use host_sim::recording::Recording;
use host_sim::replay::{self, Options};
use host_sim::scene::Scene;
use host_sim::seeds::TUNING;
use host_sim::simulation::random_scan;
use stairscan::infer::Likelihood;
use stairscan::motion::Drive;
use stairscan::observer::{Event, Observer};
use stairscan::params::hazard::Features;
use stairscan::verdict::Outcome;

/// Scenes in which the search alone finds a flight with a wrong number of steps.
const CONFUSED: [(Kind, u64); 9] = [
    (Kind::Ascending, 5_041),
    (Kind::Ascending, 5_042),
    (Kind::Open, 5_048),
    (Kind::Uneven, 5_018),
    (Kind::Uneven, 5_031),
    (Kind::Irregular, 5_024),
    (Kind::Irregular, 5_036),
    (Kind::Irregular, 5_041),
    (Kind::Irregular, 5_048),
];
/// Minimum number of these scenes that are correct only with the particles.
const SETTLED: usize = 5;

/// An answer, and the verdict's features of each cell of the path.
struct Answered {
    outcome: Outcome,
    cells: Vec<Features>,
}

/// A scan's answers with the particles and without.
struct Pair {
    with: Answered,
    without: Answered,
}

/// Observer that collects the verdict's features.
#[derive(Default)]
struct Cells(Vec<Features>);

impl Observer for Cells {
    fn event(&mut self, event: Event<'_>) {
        if let Event::Cell(cell) = event {
            self.0.push(cell.features);
        }
    }
}

fn pair(recording: &Recording) -> Pair {
    let options = Options {
        scans: Some(1),
        ..Options::default()
    };
    let mut pair = None;
    replay::answers(recording, &options, |scanned| {
        let answer = |estimator| {
            let (map, config) = (scanned.pipeline.map(), scanned.config);
            let mut cells = Cells::default();
            Answered {
                outcome: repeat_with(estimator, map, config, 1, &Drive::STANDING, &mut cells),
                cells: cells.0,
            }
        };
        pair = Some(Pair {
            with: answer(Likelihood::new()),
            without: answer(Likelihood::new().without_particles()),
        });
    })
    .unwrap();
    pair.unwrap()
}

#[test]
fn the_particles_settle_how_many_steps_there_are() {
    let mut settled = Vec::new();
    let (mut right, mut right_without) = (0, 0);
    for (kind, seed) in CONFUSED {
        assert!(TUNING.contains(&seed));
        let recording = random_scan(kind, kind.variety(), seed).unwrap();
        let steps = recording.meta.truth.as_ref().unwrap().steps.len();
        let pair = pair(&recording);
        let printed = (
            pair.with.outcome.answer.steps.len(),
            pair.without.outcome.answer.steps.len(),
        );
        right += usize::from(printed.0 == steps);
        right_without += usize::from(printed.1 == steps);
        if printed.0 == steps && printed.1 != steps {
            settled.push((kind, seed));
        }
    }
    assert!(settled.len() >= SETTLED, "only {settled:?}");
    assert!(right >= right_without + SETTLED, "{right} {right_without}");
}

/// Ramps and rough ground in which the search finds a flight from scattered weak echoes.
#[test]
fn the_particles_take_no_ramp_for_stairs() {
    for seed in [6_011, 6_012, 6_092, 6_172, 6_252, 6_291, 6_456, 6_493] {
        assert!(TUNING.contains(&seed));
        let recording = random_scan(Kind::None, Kind::None.variety(), seed).unwrap();
        let outcome = pair(&recording).with.outcome;
        assert!(
            outcome.answer.steps.is_empty(),
            "{seed}: {:?}",
            outcome.answer.steps
        );
    }
}

/// The wall's corner and specular reflection, merged at that distance, resemble those of one more
/// riser.
#[test]
fn a_wall_behind_a_flight_is_no_step_behind_a_landing() {
    let scene = Scene::parse(
        "[[stairs]]\ndistance_m = 0.7\ncount = 3\nrise_m = 0.12\ngoing_m = 0.377\nmaterial = \"concrete\"\n\
         [[floor]]\nmaterial = \"concrete\"\n[[wall]]\nat_m = 2.411\nmaterial = \"concrete\"\n",
    );
    let recording = scene.unwrap().simulate("wall", 3);
    let outcome = pair(&recording).with.outcome;
    assert_eq!(outcome.answer.steps.len(), 3, "{:?}", outcome.answer.steps);
}

#[test]
fn the_particles_tell_the_verdict_what_they_doubt() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
    for name in ["stair_a", "stair_b", "stair_c", "empty"] {
        let Pair { with, without } = pair(&Recording::read(&root.join(name)).unwrap());
        // The steps are clear, and the same; the particles provide their probability of error.
        assert_eq!(
            with.outcome.answer.steps.len(),
            without.outcome.answer.steps.len()
        );
        let differ = with
            .cells
            .iter()
            .zip(&without.cells)
            .filter(|(a, b)| a != b);
        assert!(differ.count() > with.cells.len() / 2, "{name}");
        assert!(without.outcome.answer.possible_steps.is_empty(), "{name}");
    }
}

/// Downward flights are only searched for; there are no particles.
#[test]
fn going_down_there_are_none() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
    let Pair { with, without } = pair(&Recording::read(&root.join("descending")).unwrap());
    assert_eq!(with.outcome, without.outcome);
    assert_eq!(with.cells, without.cells);
}
