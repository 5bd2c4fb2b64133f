//! Builds the model's staircase from a scene with ground truth.

use stairscan::infer::weight;
use stairscan::model::{GroundKind, Model, Staircase, View};
use stairscan::params::Numbers;
use stairscan::params::generative::Generative;
use stairscan::signal::echoes::Echo;
use stairscan::signal::grid::Geometry;

use host_sim::recording::Truth;
use host_sim::scene::spec::{SceneSpec, Way};

/// Properties of a flight that are in its scene but not in the ground truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Build {
    /// Whether the risers are open.
    pub open: bool,
    /// Overhang of the nosings in front of their risers, metres.
    pub overhang_m: f32,
}

impl Build {
    /// Returns the properties of a scene's flights going up; `None` if they differ or there are none.
    pub fn of(scene: &SceneSpec) -> Option<Self> {
        let up = scene.stairs.iter().filter(|s| s.direction == Way::Up);
        let mut builds = up.map(|s| Self {
            open: s.open,
            overhang_m: s.nosing_m as f32,
        });
        let first = builds.next()?;
        builds.all(|build| build == first).then_some(first)
    }

    /// Returns all combinations of open or closed risers and overhang that are tried where a scene's are not known.
    fn all() -> Vec<Self> {
        let closed = (0..=OVERHANGS).map(|k| Self {
            open: false,
            overhang_m: OVERHANG_STEP_M * f32::from(k),
        });
        let open = Self {
            open: true,
            overhang_m: 0.0,
        };
        closed.chain([open]).collect()
    }
}

/// Number of overhangs that are tried besides none: up to 6 cm.
const OVERHANGS: u8 = 12;
/// Step between the overhangs that are tried, metres.
const OVERHANG_STEP_M: f32 = 0.005;
/// Maximum number of walls that are tried, at the distances of the strongest echoes.
const WALLS: usize = 3;
/// Distance within which two echoes are those of one wall, metres.
const SAME_WALL_M: f32 = 0.05;
/// Minimum distance of a wall behind the last riser, metres: the shortest landing.
const LANDING_M: f32 = 0.28;
/// Minimum SNR of an echo that may be a wall's, dB.
const WALL_DB: f32 = 8.0;
/// Distances at which the ramps that are tried begin, metres.
const RAMPS_FROM_M: [f32; 3] = [0.4, 0.8, 1.2];
/// Slopes of the ramps that are tried: from 1:16 to more than a chair can climb.
const SLOPES: [f32; 4] = [0.06, 0.09, 0.13, 0.18];
/// Heights above the ground of the thresholds and boxes that are tried, metres.
const THINGS_M: [f32; 5] = [0.015, 0.03, 0.3, 0.5, 0.8];
/// Height above the ground up to which such an object is a threshold, metres; higher ones are boxes.
const THRESHOLD_M: f32 = 0.1;

/// Returns the most likely staircase with the true steps. Open risers, overhang, wall and objects are tried where the
/// truth does not contain them. `None` if the model cannot represent the truth: a step goes down or below the ground.
pub fn most_likely_staircase(
    model: &Model<'_>,
    truth: &Truth,
    build: Option<Build>,
) -> Option<Staircase> {
    let mut steps: Vec<(f32, f32)> = truth
        .steps
        .iter()
        .chain(&truth.uncounted)
        .map(|s| (s.distance_m as f32, s.height_m as f32))
        .collect();
    steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    if steps.iter().any(|s| s.1 <= 0.0) {
        return None;
    }
    let bare = match steps.is_empty() {
        true => non_step_candidates(model),
        false => build
            .map_or_else(Build::all, |build| vec![build])
            .iter()
            .map(|build| flight(&steps, *build))
            .collect(),
    };
    let walls = walls(model);
    let all = bare.iter().flat_map(|s| {
        let last = s.len().checked_sub(1).map_or(0.0, |k| s.x(k));
        let ramp = matches!(s.kind, GroundKind::Ramp { .. });
        let fits = move |w: &&f32| **w > last + LANDING_M && !ramp;
        let with = move |wall_m: &f32| Staircase {
            wall_m: *wall_m,
            ..*s
        };
        [*s].into_iter().chain(walls.iter().filter(fits).map(with))
    });
    all.map(|s| (weight(model, &s), s))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|best| best.1)
}

fn flight(steps: &[(f32, f32)], build: Build) -> Staircase {
    let mut s = Staircase::nothing();
    for (k, &(x_m, top_m)) in steps.iter().enumerate() {
        s = s.with(k, x_m + build.overhang_m, top_m);
    }
    s.open = build.open;
    s.overhang_m = build.overhang_m;
    s
}

/// Returns the horizontal distances of the strongest echoes, candidates for a wall, metres, the strongest first.
fn walls(model: &Model<'_>) -> Vec<f32> {
    let mut echoes: Vec<_> = model.echoes.iter().filter(|e| e.snr_db > WALL_DB).collect();
    echoes.sort_by(|a, b| b.snr_db.total_cmp(&a.snr_db));
    let mut walls: Vec<f32> = Vec::new();
    for e in echoes {
        if walls.len() < WALLS && walls.iter().all(|w| (w - e.x_m).abs() > SAME_WALL_M) {
            walls.push(e.x_m);
        }
    }
    walls
}

/// Returns the candidates for a scene without steps: level ground, ramps, thresholds and boxes.
fn non_step_candidates(model: &Model<'_>) -> Vec<Staircase> {
    let mut all = vec![Staircase::nothing()];
    for from_m in RAMPS_FROM_M {
        all.extend(SLOPES.map(|slope| Staircase::ramp(from_m, slope)));
    }
    for x_m in walls(model) {
        for height_m in THINGS_M {
            let mut thing = Staircase::nothing().with(0, x_m, height_m);
            thing.kind = match height_m < THRESHOLD_M {
                true => GroundKind::Threshold,
                false => GroundKind::Box,
            };
            all.push(thing);
        }
    }
    all
}

/// One scan as a training sample for the measurement model.
#[derive(Clone, Debug)]
pub struct MeasurementSample {
    /// Name of the scan's recording.
    pub name: String,
    /// Echoes of the scan, calibrated on the ground.
    pub echoes: Vec<Echo>,
    /// Geometry of the scan's polar map.
    pub geometry: Geometry,
    /// Field of view of the scan.
    pub view: View,
    /// Ground truth of the scene.
    pub truth: Truth,
    /// Whether the flight's risers are open, and its overhang, if known.
    pub build: Option<Build>,
}

impl MeasurementSample {
    /// Returns the likelihood model of the echoes with the parameters `g`.
    pub fn model<'g>(&self, g: &'g Generative) -> Model<'g> {
        Model::new(&self.echoes, self.view, &self.geometry, g, Numbers::DEFAULT)
    }
}
