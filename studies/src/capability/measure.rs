//! Measures the scenes of a cell: each is simulated, scanned and swept by the scanner's own loop, and the answers are
//! classified.

use anyhow::{Context, Result};

use host_sim::recording::Recording;
use host_sim::replay::{self, Options};
use host_sim::scene::Scene;
use host_sim::scene::sequence::pushed;
use host_sim::sweeps::scenes::{self as guard, coarse, drive, sweeps_of};
use host_sim::sweeps::score::GuardAnswer;

use super::condition::{Setup, scene};
use super::outcome::{GuardOutcome, ScanOutcome};
use super::plan::Cell;
use super::standing;

/// Number of guard sweeps of a scene in which the chair stands: 0.8 s at ten sweeps a second.
pub const SWEEPS: usize = 8;

/// The outcomes of one scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneOutcome {
    /// Outcome of a full scan; `None` for a chair that drives.
    pub scan: Option<ScanOutcome>,
    /// Outcome of the guard sweeps.
    pub guard: GuardOutcome,
}

/// Simulates and classifies scene number `turn` of a cell.
///
/// # Errors
/// Names a scene that cannot be built or scanned.
pub fn measure(cell: &Cell, turn: usize, seed: u64) -> Result<SceneOutcome> {
    let setup = scene(cell.body, &cell.condition, turn, seed);
    let name = format!("{}_{seed}", cell.body.kind());
    let outcomes = match cell.condition.speed {
        0.0 => from_one_place(cell, setup, &name, seed),
        speed => driving(cell, setup, &name, (seed, speed)),
    };
    outcomes.with_context(|| format!("{name}: {:?}", cell.condition))
}

/// Simulates one full scan and [`SWEEPS`] guard sweeps of a chair that stands, and classifies the answers.
fn from_one_place(cell: &Cell, setup: Setup, name: &str, seed: u64) -> Result<SceneOutcome> {
    let Setup { spec, at_m } = setup;
    let recording = Scene::new(spec.clone())?.simulate(name, seed);
    let answer = replay::answer(&recording, &Options::default())?;
    let words = words(&standing::sweeps(spec, SWEEPS, name, seed)?)?;
    Ok(SceneOutcome {
        scan: Some(ScanOutcome::of(&answer, cell.body, at_m)),
        guard: GuardOutcome::of(&words, cell.body, &[at_m; SWEEPS]),
    })
}

/// Simulates the guard sweeps of a chair that approaches the body at `speed`, m/s, and classifies the answers. There is
/// no full scan.
fn driving(
    cell: &Cell,
    setup: Setup,
    name: &str,
    (seed, speed): (u64, f64),
) -> Result<SceneOutcome> {
    let drive = drive(seed, guard::SWEEPS, speed);
    let rows = {
        let mut spec = setup.spec.clone();
        coarse(&mut spec);
        Scene::new(spec)?.rows()
    };
    let way = drive.length_m(rows);
    let recording = sweeps_of(pushed(setup.spec, way), name, seed, &drive)?;
    let travel = &recording.meta.sequence.truth_travel_m;
    let places: Vec<f64> = travel.iter().map(|t| setup.at_m + way - t).collect();
    Ok(SceneOutcome {
        scan: None,
        guard: GuardOutcome::of(&words(&recording)?, cell.body, &places),
    })
}

/// Returns the scanner's answer to each guard sweep of a recording, in order.
fn words(recording: &Recording) -> Result<Vec<GuardAnswer>> {
    let words = replay::guarded(recording, &Options::default())?;
    Ok(words.iter().map(GuardAnswer::of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capability::body::Body;
    use crate::capability::condition::Condition;
    use crate::capability::plan::Series;

    fn cell(body: Body) -> Cell {
        Cell {
            number: 0,
            series: Series::Distance,
            body,
            condition: Condition {
                distance_m: 0.8,
                ground: Some("concrete"),
                ..Condition::REFERENCE
            },
            scenes: 1,
        }
    }

    #[test]
    fn plain_stairs_are_detected_by_scan_and_guard() {
        let found = measure(&cell(Body::Closed), 0, 5).unwrap();
        let scan = found.scan.unwrap();
        assert!(
            scan.detected && scan.ok && !scan.free_beyond_body,
            "{scan:?}"
        );
        let guard = found.guard;
        assert!(
            guard.named_at.is_some() && !guard.free_beyond_body,
            "{guard:?}"
        );
        assert_eq!(measure(&cell(Body::Closed), 0, 5).unwrap(), found);
    }
}
