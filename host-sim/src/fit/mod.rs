//! Counts the verdict's hazards from scans with known truth.
//!
//! Each scan gives its cells up to the first one in which its answer goes wrong: what the estimator
//! knew of each, and whether it was that one. Their logistic regression is the hazard; a second one,
//! on other scenes, maps what the hazards add up to onto how often answers were right.

pub mod logistic;
mod table;

use anyhow::Result;
use stairscan::config::Plane;
use stairscan::flight::trace::Cell;
use stairscan::observer::{Event, Observer};
use stairscan::params::hazard::{FEATURES, Weights};

use crate::answer::Answer;
use crate::inspect;
use crate::recording::{Recording, Truth};
use crate::replay::{self, Options};
use crate::scene::random::Kind;
use crate::score;
use logistic::Fit;

pub use table::write;

/// How far a feature's weight is taken to lie from 0 before anything is counted: standard deviation,
/// log-odds. Features are of the order of 1, and e³ is a strong effect.
const PRIOR_SIGMA: f64 = 3.0;

/// The forms that a chair meets every day.
const COMMON: [Kind; 7] = [
    Kind::Ascending,
    Kind::None,
    Kind::Uneven,
    Kind::Soft,
    Kind::Landing,
    Kind::Beside,
    Kind::Clutter,
];

/// What one scan teaches.
#[derive(Clone, Debug)]
pub struct Lesson {
    /// The recording's name.
    pub name: String,
    /// What the mirror sweeps.
    pub plane: Plane,
    /// The cells of the way ahead, the nearest first …
    pub cells: Vec<Cell>,
    /// … and which of them is the first with an error.
    pub wrong: Option<usize>,
}

/// Listens for cells.
#[derive(Default)]
struct Listener(Vec<Cell>);

impl Observer for Listener {
    fn event(&mut self, event: Event<'_>) {
        if let Event::Cell(cell) = event {
            self.0.push(*cell);
        }
    }
}

/// What the first scan of a recording teaches; nothing if it is a `fault` or has no truth.
///
/// # Errors
/// Names what in the recording no scan can be made of.
pub fn lesson(recording: &Recording) -> Result<Option<Lesson>> {
    let options = Options {
        scans: Some(1),
        ..Options::default()
    };
    let mut lesson = None;
    replay::answers(recording, &options, |scanned| {
        let mut listener = Listener::default();
        let scan = scanned.answer.scan.scan;
        let (map, drive) = (scanned.pipeline.map(), &scanned.drive);
        inspect::repeat(map, scanned.config, scan, drive, &mut listener);
        if let Some(truth) = &scanned.recording().meta.truth
            && !scanned.answer.is_fault()
        {
            let cells = listener.0;
            let wrong = first_wrong(scanned.answer, truth, &cells);
            lesson = Some(Lesson {
                name: recording.name.clone(),
                plane: scanned.config.mount.plane,
                cells,
                wrong,
            });
        }
    })?;
    Ok(lesson)
}

/// The first cell in which an answer goes wrong.
fn first_wrong(answer: &Answer, truth: &Truth, cells: &[Cell]) -> Option<usize> {
    cells
        .iter()
        .position(|cell| score::wrong_up_to(answer, truth, cell.end_m.into()))
}

/// The hazards of one plane, with the standard errors of their weights.
pub fn hazards(lessons: &[&Lesson]) -> Fit {
    let mut rows = Vec::new();
    for lesson in lessons {
        let until = lesson.wrong.map_or(lesson.cells.len(), |k| k + 1);
        for (k, cell) in lesson.cells.iter().take(until).enumerate() {
            let features = cell.features.iter().map(|&f| f64::from(f)).collect();
            rows.push((features, lesson.wrong == Some(k)));
        }
    }
    logistic::fit(&rows, FEATURES, PRIOR_SIGMA)
}

/// Log-odds of being right that the hazards give for each cell of a lesson, and whether the answer
/// was right up to there.
fn odds(lesson: &Lesson, weights: &Weights) -> Vec<(f64, bool)> {
    let mut log_right = 0.0;
    let cells = lesson.cells.iter().enumerate().map(|(k, cell)| {
        log_right += f64::from(weights.log_survival(&cell.features));
        let log_wrong = (-log_right.exp_m1()).max(f64::from(f32::EPSILON)).ln();
        (log_right - log_wrong, lesson.wrong.is_none_or(|w| w > k))
    });
    cells.collect()
}

/// An `ok` reaches at least this far, metres: design contract; and what rounding leaves of it.
const OK_REACH_M: f32 = 0.999;

/// What a threshold of probability does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    /// The probability.
    pub from: f32,
    /// Answers that it makes `ok`.
    pub ok: usize,
    /// Of these, those that are wrong up to their horizon.
    pub wrong: usize,
}

/// The least probability with which none of the `ok` answers to common forms is wrong. Over all kinds
/// a few in a hundred `ok` answers are, whatever the threshold: what the model cannot see in odd forms.
pub fn threshold(lessons: &[&Lesson], weights: &Weights) -> Threshold {
    let common = |l: &&&Lesson| {
        COMMON
            .iter()
            .any(|kind| l.name.starts_with(&kind.to_string()))
    };
    let lessons: Vec<&Lesson> = lessons.iter().filter(common).copied().collect();
    let courses: Vec<Vec<(f32, f32, bool)>> = lessons.iter().map(|l| course(l, weights)).collect();
    let judge = |from: f32| {
        let ends = courses
            .iter()
            .filter_map(|c| c.iter().rfind(|cell| cell.1 >= from));
        let ok: Vec<_> = ends.filter(|(end, ..)| *end >= OK_REACH_M).collect();
        Threshold {
            from,
            ok: ok.len(),
            wrong: ok.iter().filter(|(.., right)| !right).count(),
        }
    };
    // In thousandths, from above to the first wrong one.
    let mut best = Threshold {
        from: 2.0,
        ok: 0,
        wrong: 0,
    };
    for thousandths in (900..1000_u16).rev() {
        let now = judge(f32::from(thousandths) / 1000.0);
        if now.wrong > 0 {
            break;
        }
        if now.ok > 0 {
            best = now;
        }
    }
    best
}

/// Of each cell of a lesson: where it ends, the probability that the answer is right up to there,
/// and whether it is.
fn course(lesson: &Lesson, weights: &Weights) -> Vec<(f32, f32, bool)> {
    let mut log_right = 0.0;
    let cells = lesson.cells.iter().enumerate().map(|(k, cell)| {
        log_right += weights.log_survival(&cell.features);
        let right = lesson.wrong.is_none_or(|w| w > k);
        (cell.end_m, weights.probability(log_right), right)
    });
    cells.collect()
}

/// Slope and offset that take the hazards' log-odds to how often answers were right.
pub fn calibration(lessons: &[&Lesson], weights: &Weights) -> Fit {
    let pairs = lessons.iter().flat_map(|lesson| odds(lesson, weights));
    let rows: Vec<(Vec<f64>, bool)> = pairs.map(|(x, right)| (vec![x, 1.0], right)).collect();
    logistic::fit(&rows, 2, PRIOR_SIGMA)
}
