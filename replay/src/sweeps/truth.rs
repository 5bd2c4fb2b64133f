//! Ground truth of guard sweeps in a recording: the key `stairscan:truth_guard`.

use anyhow::{Result, anyhow};
use serde_json::{Value, json};
use stairscan::verdict::HazardKind;

use crate::recording::Recording;
use crate::setup;

/// Key of a recording's metadata that lists the first hazard of each sweep.
const KEY: &str = "stairscan:truth_guard";
/// Maximum distance of a hazard that counts, metres from the mirror: the recordings' profile.
const FARTHEST_M: f64 = 2.5;

/// The first place on the way that a chair must not drive into or over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hazard {
    /// Distance of the hazard from the mirror, metres.
    pub at_m: f64,
    /// Kind of hazard: `Rise`, `Drop` or `Obstacle`.
    pub kind: HazardKind,
}

/// The first hazard of each sweep, its distance from the mirror at the end of that sweep; `None`
/// for a sweep without one.
pub type Truth = Vec<Option<Hazard>>;

/// Returns the nearest of `hazards` that is still ahead after `travel_m` metres, with its distance
/// from there; `None` if none is within 2.5 m. Distances in `hazards` are from the mirror at the
/// first row.
pub fn first(hazards: &[Hazard], travel_m: f64) -> Option<Hazard> {
    let ahead = hazards.iter().map(|hazard| Hazard {
        at_m: hazard.at_m - travel_m,
        ..*hazard
    });
    ahead
        .filter(|hazard| (0.0..=FARTHEST_M).contains(&hazard.at_m))
        .min_by(|a, b| a.at_m.total_cmp(&b.at_m))
}

/// Marks a recording as guard sweeps and writes `truth` into its metadata.
pub fn write(recording: &mut Recording, truth: &Truth) {
    let one = |hazard: &Option<Hazard>| {
        json!({
            "hazard_m": hazard.map(|h| (1e5 * h.at_m).round() / 1e5),
            "hazard": hazard.map(|h| h.kind.as_str()),
        })
    };
    setup::mark_guard(recording);
    let list = truth.iter().map(one).collect();
    recording.meta.extra.insert(KEY.into(), list);
}

/// Returns the truth of a recording's sweeps; `None` if its metadata have none.
///
/// # Errors
/// Names the key and the expected value.
pub fn read(recording: &Recording) -> Result<Option<Truth>> {
    let Some(list) = recording.meta.extra.get(KEY) else {
        return Ok(None);
    };
    let sweeps = recording.scans();
    let wrong = || {
        anyhow!(
            "{}: global {KEY}: expected {sweeps} objects with hazard_m and hazard, a number with rise, drop or \
             obstacle, or both null",
            recording.name
        )
    };
    let list = list.as_array().filter(|list| list.len() == sweeps);
    let parsed = list.ok_or_else(wrong)?.iter().map(parse);
    parsed
        .collect::<Option<Truth>>()
        .map(Some)
        .ok_or_else(wrong)
}

/// Reads one sweep's hazard; the inner `None` is a sweep without a hazard, the outer `None` a value
/// of another form.
fn parse(value: &Value) -> Option<Option<Hazard>> {
    let (at, kind) = (value.get("hazard_m")?, value.get("hazard")?);
    if at.is_null() && kind.is_null() {
        return Some(None);
    }
    let at_m = at.as_f64().filter(|at_m| at_m.is_finite())?;
    let kind = kind.as_str()?;
    let known = [HazardKind::Rise, HazardKind::Drop, HazardKind::Obstacle];
    let kind = known.into_iter().find(|known| known.as_str() == kind)?;
    Some(Some(Hazard { at_m, kind }))
}

#[cfg(test)]
mod tests {
    use super::*;

    const RISE: Hazard = Hazard {
        at_m: 1.2,
        kind: HazardKind::Rise,
    };

    fn sweeps(count: usize) -> Recording {
        let mut recording = Recording {
            name: "sweeps".into(),
            meta: crate::recording::Metadata::default(),
            samples: Vec::new(),
        };
        recording.meta.sequence.scans = count;
        recording
    }

    #[test]
    fn the_nearest_hazard_ahead_counts() {
        let wall = Hazard {
            at_m: 2.8,
            kind: HazardKind::Obstacle,
        };
        let all = [wall, RISE];
        let found = first(&all, 0.3).unwrap();
        assert!((found.at_m - 0.9).abs() < 1e-12 && found.kind == HazardKind::Rise);
        // The chair has passed the rise.
        assert_eq!(first(&all, 1.3).unwrap().kind, HazardKind::Obstacle);
        assert_eq!(first(&[wall], 0.0), None);
    }

    #[test]
    fn what_is_written_is_read() {
        let mut recording = sweeps(2);
        assert_eq!(read(&recording).unwrap(), None);
        let truth = vec![None, Some(RISE)];
        write(&mut recording, &truth);
        assert_eq!(read(&recording).unwrap(), Some(truth));
        assert_eq!(recording.meta.extra["stairscan:mode"], "guard");
    }

    #[test]
    fn wrong_truths_are_refused() {
        for (key, sweeps_of) in [
            (json!([{"hazard_m": 1.0, "hazard": "rise"}]), 2),
            (json!([{"hazard_m": null, "hazard": "rise"}]), 1),
            (json!([{"hazard_m": 1.0, "hazard": "cliff"}]), 1),
            (json!("none"), 1),
        ] {
            let mut recording = sweeps(sweeps_of);
            recording.meta.extra.insert(KEY.into(), key);
            let error = read(&recording).unwrap_err().to_string();
            assert!(error.contains(KEY), "{error}");
        }
    }
}
