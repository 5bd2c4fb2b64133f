//! Scans of an animation: position of the mirror, echoes and answer of each.

use stairscan::config::{EstimatorKind, Plane};

use crate::answer::Answer;
use crate::inspect::Inspection;
use crate::recording::{Recording, Truth};
use crate::replay::Scanned;
use crate::views::Point;

/// An echo: `at` is its horizontal distance from the mirror and its height above the ground,
/// metres, `snr_db` its signal-to-noise ratio.
#[derive(Clone, Copy, Debug)]
pub(super) struct Echo {
    pub(super) at: Point,
    pub(super) snr_db: f64,
}

/// One scan of an animation: the mirror's position, the echoes and the answer.
#[derive(Clone, Debug)]
pub(super) struct Shot {
    /// Travel of the mirror since the first scan, metres.
    pub(super) travel_m: f64,
    /// First and last angle of the beam, degrees below the horizontal.
    pub(super) sweep_deg: (f64, f64),
    pub(super) answer: Answer,
    pub(super) echoes: Vec<Echo>,
}

/// The scans of a recording to be animated, in order.
#[derive(Clone, Debug, Default)]
pub struct Film {
    pub(super) name: String,
    pub(super) mount_height_m: f64,
    pub(super) shots: Vec<Shot>,
    /// Ground truth, with distances from the mirror at the first scan; `None` if the recording has
    /// none.
    pub(super) truth: Option<Truth>,
}

/// Returns the travel of the mirror at the end of scan `k` (from 0), metres: the true one if the
/// recording has it, else the odometer's, else 0.
fn travel_m(recording: &Recording, k: usize) -> f64 {
    let sequence = &recording.meta.sequence;
    let last = recording.chirps_of(k).end.saturating_sub(1);
    let measured = recording.meta.motion.travel_m.get(last);
    let travel = sequence.truth_travel_m.get(k).or(measured);
    travel.copied().unwrap_or(0.0)
}

impl Film {
    /// Creates the animation of `recording`, without scans so far.
    pub fn new(recording: &Recording) -> Self {
        Self {
            name: recording.name.clone(),
            mount_height_m: recording
                .meta
                .mirror
                .as_ref()
                .map_or(0.0, |mirror| mirror.mount_height_m),
            shots: Vec::new(),
            truth: recording.truth(0).cloned(),
        }
    }

    /// Adds the next scan, with its echoes as the default estimator places them.
    pub fn take(&mut self, recording: &Recording, scanned: &Scanned<'_>) {
        let answer = scanned.answer;
        let scan = answer.scan_of_recording();
        let angles = scanned.recording().meta.angles_deg;
        let ends = angles.first().zip(angles.last());
        // In the height plane angles are measured from straight down.
        let below = |angle: f64| match scanned.config.mount.plane.first() {
            Plane::Depth => angle,
            Plane::Height => 90.0 - angle,
        };
        let seen = scanned.config.estimator == EstimatorKind::Likelihood && !answer.is_fault();
        let mut echoes = Vec::new();
        if seen {
            let inspection = Inspection::of(scanned);
            let scatterers = &inspection.view().scatterers;
            echoes.extend(scatterers.iter().map(|s| Echo {
                at: s.at,
                snr_db: s.snr_db,
            }));
        }
        self.shots.push(Shot {
            travel_m: travel_m(recording, scan) - travel_m(recording, 0),
            sweep_deg: ends.map_or((0.0, 0.0), |(&first, &last)| (below(first), below(last))),
            answer: answer.clone(),
            echoes,
        });
    }
}
