//! Scenes of a cell into outcomes: simulated, scanned and swept by the scanner's own loop.

use anyhow::{Context, Result};

use crate::recording::Recording;
use crate::replay::{self, Options};
use crate::scene::Scene;
use crate::scene::sequence::{Approach, pushed};
use crate::setup;
use crate::sweeps::scenes::{self as guard, coarse, drive, sweeps_of};
use crate::sweeps::score::Word;

use super::condition::{Setup, scene};
use super::outcome::{GuardOutcome, ScanOutcome};
use super::plan::Cell;

/// Guard sweeps of a chair that stands: a second.
pub const SWEEPS: usize = 8;
/// From row to row and from sweep to sweep, seconds: that of the random guard recordings.
const ROW_S: f64 = 0.0028;
const SWEEP_S: f64 = 0.1;

/// The outcomes of one scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Of a full scan; `None` from a chair that drives.
    pub scan: Option<ScanOutcome>,
    /// Of guard sweeps.
    pub guard: GuardOutcome,
}

/// Simulates and judges scene number `turn` of a cell.
///
/// # Errors
/// Names a scene that cannot be built or scanned.
pub fn seen(cell: &Cell, turn: usize, seed: u64) -> Result<Seen> {
    let setup = scene(cell.body, &cell.condition, turn, seed);
    let name = format!("{}_{seed}", cell.body.kind());
    let outcomes = match cell.condition.speed {
        0.0 => standing(cell, setup, &name, seed),
        speed => driving(cell, setup, &name, (seed, speed)),
    };
    outcomes.with_context(|| format!("{name}: {:?}", cell.condition))
}

/// One scan, and a second of guard sweeps.
fn standing(cell: &Cell, setup: Setup, name: &str, seed: u64) -> Result<Seen> {
    let Setup { mut spec, at_m } = setup;
    let recording = Scene::new(spec.clone())?.simulate(name, seed);
    let answer = replay::answer(&recording, &Options::default())?;
    coarse(&mut spec);
    let sweeps = sweeps_from_one_place(&Scene::new(spec)?, name, seed)?;
    let words = words(&sweeps)?;
    Ok(Seen {
        scan: Some(ScanOutcome::of(&answer, cell.body, at_m)),
        guard: GuardOutcome::of(&words, cell.body, &[at_m; SWEEPS]),
    })
}

/// Guard sweeps of a chair that stands: the same surfaces, new noise for every row.
fn sweeps_from_one_place(scene: &Scene, name: &str, seed: u64) -> Result<Recording> {
    let mut stay = Approach::new(seed, SWEEPS, 0.0);
    for stop in &mut stay.stops {
        (stop.travel_m, stop.rocking_deg) = ([0.0; 2], 0.0);
    }
    let mut recording = scene.simulate_approach(name, seed, &stay)?;
    let rows = scene.rows();
    let time = |k: usize| (k / rows) as f64 * SWEEP_S + (k % rows) as f64 * ROW_S;
    recording.meta.motion.time_s = (0..SWEEPS * rows).map(time).collect();
    setup::mark_guard(&mut recording);
    Ok(recording)
}

/// Guard sweeps of a chair that comes to the body from farther away.
fn driving(cell: &Cell, setup: Setup, name: &str, (seed, speed): (u64, f64)) -> Result<Seen> {
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
    Ok(Seen {
        scan: None,
        guard: GuardOutcome::of(&words(&recording)?, cell.body, &places),
    })
}

/// The words on the sweeps of a recording.
fn words(recording: &Recording) -> Result<Vec<Word>> {
    let words = replay::guarded(recording, &Options::default())?;
    Ok(words.iter().map(Word::of).collect())
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
        let found = seen(&cell(Body::Closed), 0, 5).unwrap();
        let scan = found.scan.unwrap();
        assert!(scan.detected && scan.ok && !scan.beyond, "{scan:?}");
        let guard = found.guard;
        assert!(guard.named_at.is_some() && !guard.beyond, "{guard:?}");
        assert_eq!(seen(&cell(Body::Closed), 0, 5).unwrap(), found);
    }

    #[test]
    fn a_chair_that_stands_sees_the_same_ground_in_new_noise() {
        let mut setup = scene(Body::Level, &Condition::REFERENCE, 2, 7);
        coarse(&mut setup.spec);
        let scene = Scene::new(setup.spec).unwrap();
        let recording = sweeps_from_one_place(&scene, "level", 7).unwrap();
        assert_eq!(recording.scans(), SWEEPS);
        let [first, third] = [0, 2].map(|k| recording.scan(k).samples);
        assert_ne!(first, third);
        let power = |v: &[stairscan::Iq], w: &[stairscan::Iq]| {
            let terms = v.iter().zip(w);
            terms.map(|(a, b)| f64::from(a.re) * f64::from(b.re)).sum::<f64>()
        };
        let alike = power(&first, &third) / power(&first, &first);
        assert!(alike > 0.95, "{alike}");
    }
}
