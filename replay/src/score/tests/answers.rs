//! Answers for the tests of scores and pictures: `host-sim` has this file by its path.

use crate::answer::Answer;
use stairscan::answer::Direction;
use stairscan::report::{ScanLine, StepLine, Tenths};
use stairscan::verdict::{Outcome, Reasons, Status};

/// Returns an answer with a status and these steps: distance and height, 0.1 mm.
pub fn answer(status: Status, steps: &[(i32, i32)]) -> Answer {
    let step = |&(distance, height): &(i32, i32)| StepLine {
        distance: Tenths(distance),
        height: Tenths(height),
        distance_sigma: Tenths(50),
        height_sigma: Tenths(50),
        ..StepLine::default()
    };
    Answer {
        part: None,
        horizon_m: None,
        recording: "echo".into(),
        sentences: Vec::new(),
        scan: ScanLine {
            status,
            direction: match steps {
                [] => Direction::None,
                _ => Direction::Up,
            },
            steps: steps.len() as u8,
            reasons: Reasons::NONE,
            ..ScanLine::new(1, 0, &Outcome::silent(), 0)
        },
        steps: steps.iter().map(step).collect(),
        drop: None,
        maybes: Vec::new(),
    }
}
