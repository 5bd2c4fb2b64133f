//! The horizon: probability that an answer is correct up to a distance, and the largest distance at which it is as
//! high as `ok` promises.
//!
//! The way ahead is divided into cells. Each cell has a hazard: the probability of the first error of the answer in
//! this cell, given none before. An error is a step that is missing, false, or off by more than its expanded
//! uncertainty. The hazard is a logistic function of the cell's [`Features`] with weights that `cargo study fit` counts
//! from simulated scans with known truth (a discrete-time survival model, Cox 1972). The product of the survival
//! probabilities of the cells, mapped to the measured frequency, is the probability of being correct.

use super::propose::scene::Scene;
use super::support::Support;
use crate::answer::{DropEdge, Step};
use crate::config::Plane;
use crate::estimate::{MAX_EXPANDED_M, expanded};
use crate::math;
use crate::model::cloud::{CELL_M, CELLS, FIRST_END_M};
use crate::model::{MIN_EXPANDED_M, Surfaces};
use crate::observer::trace::{Cell, Role};
use crate::params::Params;
use crate::params::counted;
use crate::params::fitted_for;
use crate::params::hazard::{
    FEATURES, Features, MAX_FEATURE_DB, MAX_FEATURE_NATS, MAX_FEATURE_SIGMAS, MAX_NEXT_FACE,
    MIN_FEATURE_MARGIN, NEAREST_END_M, TYPICAL_GOING_M, log_survival, probability,
};
use crate::params::posterior::{MIN_LOG_ODDS, TEN_DB};
use crate::past::CarriedOdds;
use crate::signal::grid::Geometry;
use crate::verdict::{MIN_HORIZON_M, Validity};

/// Minimum probability of being correct at which an answer is valid beyond the first metre. It leaves half of the
/// risk that the contract allows.
const RIGHT_UP_TO_HORIZON: f32 = 0.995;
/// Tolerance for the rounding of a cell's end, metres.
const ROUNDING_M: f32 = 1e-3;

/// Number of features of a cell behind the last step.
const BEHIND_FEATURES: usize = 7;
/// Number of features of a cell that holds a step.
const STEP_FEATURES: usize = 11;
/// Number of features of a cell before or between steps.
const BEFORE_FEATURES: usize = 9;
/// Number of features of a cell of an answer without steps.
const CLEAR_FEATURES: usize = 18;
/// Number of features that every cell has: instrument and whole scene.
const SCENE_FEATURES: usize = 5;
/// The feature vector is the concatenation of five groups, in this order: whole scene, answer without steps, before or
/// between steps, behind the last step, cell with a step.
const _: () = assert!(
    FEATURES == SCENE_FEATURES + CLEAR_FEATURES + BEFORE_FEATURES + BEHIND_FEATURES + STEP_FEATURES
);

/// Half the length of a way cell, metres.
const HALF_CELL_M: f32 = 0.5 * CELL_M;
/// Mounting height of the paper's instrument, metres above the ground: heights in features are relative to it.
const PAPER_MOUNT_M: f32 = 0.4;

/// Whether an echo with this role lies on a tread, on its end, or on the floor, so that the echo's height is that
/// surface's height.
fn shows_level(role: Role) -> bool {
    matches!(role, Role::Tread | Role::Edge)
}

/// Returns how much evidence is missing that the ground goes on, 0…1. `nats` is the log-likelihood ratio of ground that
/// goes on to ground that ends: 1 nat or more gives 0, 0 nats or less gives 1.
fn lack_of_evidence(nats: f32) -> f32 {
    1.0 - math::min(math::max(nats, 0.0), 1.0)
}

/// Features of the floor's echoes between the mirror and a given distance.
struct FloorEvidence {
    /// Distance from the last floor echo to the given distance, metres.
    since_last_m: f32,
    /// Largest distance between two neighbouring floor echoes, metres.
    largest_gap_m: f32,
    /// Number of floor echoes divided by 10.
    marks: f32,
}

/// Position of a cell relative to the answer's steps.
#[derive(Clone, Copy, PartialEq, Eq)]
enum CellKind {
    /// The answer has no steps.
    Clear,
    /// The cell holds a step.
    Step,
    /// The cell lies before or between steps.
    Between,
    /// The cell lies behind the last step.
    Behind,
}

/// Inputs of the horizon: the answer's steps with the evidence for each, the echoes with their roles, margins over the
/// alternatives, and the geometry of the scan.
#[derive(Clone, Copy, Debug)]
pub struct HorizonInput<'a> {
    /// The scan's echoes as marks of the search, and their columns.
    pub scene: &'a Scene<'a>,
    /// Role of each mark, in the order of the scene's marks.
    pub roles: &'a [Role],
    /// Steps of the answer.
    pub steps: &'a [Step],
    /// Evidence for each step of the answer, in the order of the steps.
    pub supports: &'a [Support],
    /// Margin by the search, nats: score of the answer's flight less that of the runner-up. Without steps: score of the
    /// best flight, where level ground has the score 0.
    pub margin: f32,
    /// Whether the treads are open (no risers).
    pub open: bool,
    /// Geometry of the map: plane, mounting height, beam width, angles and ranges of its cells.
    pub geometry: &'a Geometry,
    /// Log-odds that the answer is first wrong in each way cell, by the posterior, nats.
    pub error_log_odds: [f32; CELLS],
    /// The drop that the answer reports, if any.
    pub drop: Option<DropEdge>,
    /// Log-likelihood ratios of a drop or a riser to ground that goes on, from the power along the ground's line.
    pub surfaces: &'a Surfaces,
}

impl HorizonInput<'_> {
    /// Returns the way cells with their features, the nearest first; `validity` fills in their probabilities.
    pub fn cells(&self) -> impl Iterator<Item = Cell> + '_ {
        (0..CELLS).map(|k| {
            let end_m = FIRST_END_M + CELL_M * k as f32;
            let start_m = if k == 0 {
                f32::NEG_INFINITY
            } else {
                end_m - CELL_M
            };
            Cell {
                end_m,
                features: self.features(k, start_m, end_m),
                past: None,
                p_correct: 0.0,
                required: 0.0,
            }
        })
    }

    /// Returns index, step and support of the first step whose error would lie in the cell from `start_m` to `end_m`,
    /// metres.
    fn step_in(&self, start_m: f32, end_m: f32) -> Option<(usize, &Step, &Support)> {
        let pairs = self.steps.iter().zip(self.supports).enumerate();
        let mut within = pairs.filter(|(_, (s, _))| {
            let earliest_m = s.distance_m - MIN_EXPANDED_M;
            earliest_m > start_m && earliest_m <= end_m
        });
        within.next().map(|(k, (step, support))| (k, step, support))
    }

    /// Returns the SNR of the strongest echo between two horizontal distances, metres, whose role `is` accepts, tens of
    /// dB, at most [`MAX_FEATURE_DB`]; 0 for none.
    #[inline(never)]
    fn strongest(&self, from_m: f32, to_m: f32, is: &dyn Fn(Role) -> bool) -> f32 {
        let marks = &self.scene.marks;
        let (first, end) = match self.geometry.plane {
            // In the depth plane, marks are sorted by distance.
            Plane::Depth => (
                self.scene.first_beyond(from_m),
                self.scene.first_beyond(to_m),
            ),
            Plane::Height => (0, marks.len()),
        };
        let pairs = marks.iter().zip(self.roles);
        let pairs = pairs.take(end).skip(first);
        let within = pairs.filter(|(m, role)| m.x_m > from_m && m.x_m <= to_m && is(**role));
        let strongest = within.map(|(m, _)| m.snr_db).fold(0.0, math::max);
        math::min(strongest, MAX_FEATURE_DB) / TEN_DB
    }

    /// Returns the features of way cell `number`, which reaches from `start_m` to `end_m`, metres.
    #[inline(never)]
    fn features(&self, number: usize, start_m: f32, end_m: f32) -> Features {
        let error_odds = self.error_log_odds.get(number).copied().unwrap_or(0.0);
        let so_far = self
            .error_log_odds
            .iter()
            .take(number + 1)
            .copied()
            .fold(MIN_LOG_ODDS, math::max);
        let mut out = FeatureWriter {
            features: [0.0; FEATURES],
            written: 0,
        };
        let (from, to) = (start_m + MIN_EXPANDED_M, end_m + MIN_EXPANDED_M);
        let unexplained = |role: Role| role == Role::Stray || role.contradicts();
        let level = self.strongest(from - CELL_M, to + CELL_M, &shows_level);
        let stray = self.strongest(from, to, &unexplained);
        let stray_so_far = self.strongest(f32::NEG_INFINITY, to, &unexplained);
        let stray_beyond = self.strongest(to, f32::INFINITY, &unexplained);
        let last = self.steps.last();
        let lead = self.margin.clamp(-MAX_FEATURE_NATS, MAX_FEATURE_NATS);
        let step = self.step_in(start_m, end_m);
        let inside = last.is_some_and(|s| s.distance_m > from);
        let kind = match (self.steps.is_empty(), step.is_some(), inside) {
            (true, ..) => CellKind::Clear,
            (_, true, _) => CellKind::Step,
            (.., true) => CellKind::Between,
            _ => CellKind::Behind,
        };
        // Instrument and whole scene.
        out.put([
            1.0,
            end_m,
            self.scene.mount_height_m - PAPER_MOUNT_M,
            self.strongest(f32::NEG_INFINITY, f32::INFINITY, &|_| true),
            so_far,
        ]);
        out.put_if(kind == CellKind::Clear, || {
            let floor = self.floor(to);
            let ends = |x_m: f32| {
                self.surfaces
                    .drop_at(x_m)
                    .clamp(-MAX_FEATURE_NATS, MAX_FEATURE_NATS)
            };
            let [gap, later] = [to - HALF_CELL_M, to].map(ends);
            let mut columns = self.scene.columns.iter();
            let begins = columns.any(|c| c.begins && c.along_m > from && c.along_m <= to);
            [
                level,
                f32::from(level <= 0.0),
                stray,
                stray_so_far,
                stray_beyond,
                math::max(lead, MIN_FEATURE_MARGIN),
                self.strongest(to, f32::INFINITY, &shows_level),
                floor.since_last_m,
                floor.largest_gap_m,
                floor.marks,
                f32::from(begins),
                level - self.strongest(from - TYPICAL_GOING_M, from, &shows_level),
                error_odds,
                gap,
                math::max(gap, 0.0),
                later,
                lack_of_evidence(-ends(to + CELL_M)),
                f32::from(end_m < NEAREST_END_M),
            ]
        });
        out.put_if(kind == CellKind::Between, || {
            self.before(from, to, level, stray, error_odds)
        });
        out.put_if(kind == CellKind::Behind, || {
            self.behind(from, to, level, stray, error_odds)
        });
        out.put_if(kind == CellKind::Step, || match step {
            Some((k, step, support)) => self.of_step(k, step, support, stray_so_far, error_odds),
            None => [0.0; STEP_FEATURES],
        });
        out.features
    }

    /// Returns the features of the floor's echoes between the mirror and the distance `to`, metres.
    fn floor(&self, to: f32) -> FloorEvidence {
        let p = self.scene.params;
        let mut floor = FloorEvidence {
            since_last_m: 0.0,
            largest_gap_m: 0.0,
            marks: 0.0,
        };
        let mut last = p.nearest_riser_m;
        for (m, role) in self.scene.marks.iter().zip(self.roles) {
            let on_floor = *role == Role::Tread && m.x_m <= to && m.snr_db > p.floor_least_db;
            if on_floor && m.x_m > last {
                floor.largest_gap_m = math::max(floor.largest_gap_m, m.x_m - last);
                floor.marks += 1.0 / TEN_DB;
                last = m.x_m;
            }
        }
        floor.since_last_m = math::max(to - last, 0.0);
        floor
    }

    /// Returns the SNR, tens of dB, of the strongest echo that has the role `wanted` and is near a step; 0 for none.
    fn strongest_near(&self, step: &Step, wanted: Role) -> f32 {
        let reach = self.scene.params.column_m + MIN_EXPANDED_M;
        let near = (step.distance_m - reach, step.distance_m + reach);
        self.strongest(near.0, near.1, &|role| role == wanted)
    }

    /// Returns the features of a way cell before or between steps. `from` and `to` are the cell's ends plus 3 cm,
    /// metres; `level` is the SNR of the strongest echo of a tread near the cell, `stray` that of the strongest
    /// unexplained echo in it, tens of dB; `error_odds` are the log-odds that the answer is first wrong in the cell,
    /// nats.
    fn before(
        &self,
        from: f32,
        to: f32,
        level: f32,
        stray: f32,
        error_odds: f32,
    ) -> [f32; BEFORE_FEATURES] {
        let next = self
            .steps
            .iter()
            .enumerate()
            .find(|(_, s)| s.distance_m > to);
        let Some((k, next)) = next else {
            return [0.0; BEFORE_FEATURES];
        };
        let goings = (next.distance_m - 0.5 * (from + to)) / math::max(self.going(), CELL_M);
        let place = math::max(1.0 - (goings - 1.0).abs(), 0.0);
        let first = f32::from(k == 0);
        // The error of a step that is nearer than reported lies in the cell before the step's own.
        let near = f32::from(next.distance_m - to < CELL_M);
        let known = self.supports.get(k).is_some_and(|s| s.overhang_known);
        [
            1.0,
            level,
            stray,
            first * place,
            first * place * self.strongest_near(next, Role::Corner),
            f32::from(from < self.scene.params.nearest_riser_m),
            first * f32::from(self.steps.len() == 1),
            near * f32::from(known),
            error_odds,
        ]
    }

    /// Returns the mean going of the answer's steps from edge to edge, metres; with fewer than two steps that of usual
    /// stairs.
    fn going(&self) -> f32 {
        let spans = self.steps.len().saturating_sub(1);
        match (self.steps.first(), self.steps.last()) {
            (Some(first), Some(last)) if spans > 0 => {
                (last.distance_m - first.distance_m) / spans as f32
            }
            _ => TYPICAL_GOING_M,
        }
    }

    /// Returns the mean rise (or fall) of the answer's steps, metres; at least 0.
    fn rise(&self) -> f32 {
        let last = self.steps.last().map_or(0.0, |s| s.height_m.abs());
        last / self.steps.len().max(1) as f32
    }

    /// Returns the features of a way cell behind the last step. `from` and `to` are the cell's ends plus 3 cm, metres;
    /// `level` is the SNR of the strongest echo of a tread near the cell, `stray` that of the strongest unexplained
    /// echo in it, tens of dB; `error_odds` are the log-odds that the answer is first wrong in the cell, nats.
    fn behind(
        &self,
        from: f32,
        to: f32,
        level: f32,
        stray: f32,
        error_odds: f32,
    ) -> [f32; BEHIND_FEATURES] {
        let (Some(last), Some(support)) = (self.steps.last(), self.supports.last()) else {
            return [0.0; BEHIND_FEATURES];
        };
        let goings = (0.5 * (math::max(from, last.distance_m) + to) - last.distance_m)
            / math::max(self.going(), CELL_M);
        let next = math::max(1.0 - (goings - 1.0).abs(), 0.0);
        let next_db = (support.next_db / TEN_DB).clamp(-1.0, MAX_NEXT_FACE);
        let lead = self.margin.clamp(0.0, MAX_FEATURE_NATS);
        [
            next,
            next_db * next,
            level,
            stray,
            lead,
            self.steps.len() as f32,
            error_odds,
        ]
    }

    /// Returns the features of a way cell that holds step `k`. `stray_so_far` is the SNR of the strongest unexplained
    /// echo up to the cell's end, tens of dB; `error_odds` are the log-odds that the answer is first wrong in the cell,
    /// nats.
    fn of_step(
        &self,
        k: usize,
        step: &Step,
        support: &Support,
        stray_so_far: f32,
        error_odds: f32,
    ) -> [f32; STEP_FEATURES] {
        let distance_z = MIN_EXPANDED_M / step.distance_sigma_m;
        [
            1.0,
            math::min(distance_z, MAX_FEATURE_SIGMAS),
            support.snr_db.unwrap_or(0.0).clamp(0.0, MAX_FEATURE_DB) / TEN_DB,
            self.margin.clamp(0.0, MAX_FEATURE_NATS),
            f32::from(self.open),
            k as f32,
            stray_so_far,
            math::min(
                (step.riser_m.unwrap_or(0.0) - self.rise()).abs() / MIN_EXPANDED_M,
                2.0,
            ),
            f32::from(support.overhang_seen),
            f32::from(support.overhang_known),
            error_odds,
        ]
    }
}

/// Writer that appends groups of features. The features of groups that do not apply to a cell stay 0.
struct FeatureWriter {
    features: Features,
    written: usize,
}

impl FeatureWriter {
    fn put<const N: usize>(&mut self, values: [f32; N]) {
        let places = self.features.iter_mut().skip(self.written);
        places.zip(values).for_each(|(place, value)| *place = value);
        self.written += N;
    }

    fn put_if<const N: usize>(&mut self, applies: bool, values: impl FnOnce() -> [f32; N]) {
        if applies {
            self.put(values());
        } else {
            self.written += N;
        }
    }
}

/// Returns the horizon up to which an answer is valid, with its confidence: the far end of the last way cell up to
/// which the probability of being correct is high enough. `outlook` is the evidence of earlier scans; `each` is called
/// with every cell, the nearest first.
#[inline(never)]
pub fn validity(
    ground: &HorizonInput<'_>,
    mut outlook: Option<&mut CarriedOdds>,
    each: &mut dyn FnMut(&Cell),
) -> Validity {
    let weights = fitted_for(ground.geometry.plane);
    let mut log_right = 0.0;
    let mut valid_to = Validity::NONE;
    let mut reach = HorizonAccumulator::new(ground.steps, ground.drop);
    for (k, mut cell) in ground.cells().enumerate() {
        if reach.ends_before(cell.end_m) {
            break;
        }
        let odds = weights.log_odds(&cell.features);
        if let Some(outlook) = &mut outlook {
            let step = ground.step_in(cell.end_m - CELL_M, cell.end_m);
            let step = step.map(|(_, step, _)| step);
            let last_m = ground.steps.last().map(|s| s.distance_m - MIN_EXPANDED_M);
            let behind = last_m.is_none_or(|last| last <= cell.end_m - CELL_M);
            cell.past = outlook.features(k, odds, step, behind);
        }
        let (odds, maps, ok_from) = match &cell.past {
            None => (odds, &weights.maps, &weights.ok_from),
            Some(past) => {
                let table = &counted::UP;
                (table.log_odds(past), &table.maps, &table.ok_from)
            }
        };
        log_right += log_survival(odds);
        let stairs = !ground.steps.is_empty();
        cell.p_correct = probability(maps, log_right, stairs);
        let [clear_from, stairs_from] = *ok_from;
        let ok_from = if stairs { stairs_from } else { clear_from };
        cell.required = reach.required_probability(cell.end_m, ok_from);
        each(&cell);
        let valid = reach.add_cell(cell.end_m, cell.p_correct, ok_from);
        if valid || cell.end_m < MIN_HORIZON_M + 0.5 * CELL_M {
            valid_to.confidence = cell.p_correct;
        }
    }
    valid_to.horizon_m = reach.horizon_m(ground.scene.params);
    valid_to.first_step = reach.first_step();
    valid_to
}

/// Accumulator of the horizon over the cells. Up to the minimum horizon the answer is valid where the probability of
/// being correct reaches the `ok` threshold of its type. Beyond, it must also reach the higher probability that the
/// contract requires of each answer.
#[derive(Clone, Copy, Debug)]
pub struct HorizonAccumulator<'a> {
    steps: &'a [Step],
    /// Nearest place where the ground may end, by the reported drop, metres; infinite without one.
    end_m: f32,
    /// Minimum horizon of an `ok` answer, metres. It is moved to a step that is so near that an error of millimetres
    /// would decide whether the step counts.
    least_m: f32,
    valid_m: f32,
    /// Probability that the answer is correct up to and including its first step, as far as cells were taken in.
    first_step: f32,
}

impl<'a> HorizonAccumulator<'a> {
    /// Returns the state before the first cell, for an answer with these steps and this drop.
    pub fn new(steps: &'a [Step], drop: Option<DropEdge>) -> Self {
        let mut least_m = MIN_HORIZON_M;
        for step in steps {
            if ambiguous(least_m, step) {
                least_m = step.distance_m;
            }
        }
        Self {
            steps,
            end_m: drop.map_or(f32::INFINITY, |drop| drop.nearest_m()),
            least_m,
            valid_m: f32::NEG_INFINITY,
            first_step: 1.0,
        }
    }

    /// Whether a cell that ends at `end_m`, metres, reaches beyond the nearest place where the ground may end. The
    /// drop's own standard deviation covers the errors from there on.
    pub fn ends_before(&self, end_m: f32) -> bool {
        end_m > self.end_m
    }

    /// Returns the minimum probability at which an answer is valid up to the end of a cell, `end_m`, metres. `ok_from`
    /// is the threshold of `ok` for this type of answer.
    fn required_probability(&self, end_m: f32, ok_from: f32) -> f32 {
        if end_m < self.least_m + CELL_M - ROUNDING_M {
            ok_from
        } else {
            math::max(ok_from, RIGHT_UP_TO_HORIZON)
        }
    }

    /// Takes in the next cell: its end, metres; the probability that the answer is correct up to there; the threshold
    /// of `ok`. Returns whether the answer is valid up to there.
    pub fn add_cell(&mut self, end_m: f32, p_correct: f32, ok_from: f32) -> bool {
        let begins_m = end_m - CELL_M - MIN_EXPANDED_M;
        if self.steps.first().is_some_and(|s| s.distance_m > begins_m) {
            self.first_step = p_correct;
        }
        let valid = p_correct >= self.required_probability(end_m, ok_from);
        if valid {
            self.valid_m = end_m;
        }
        valid
    }

    /// Returns the probability that the answer is correct up to and including its first step; 1 without steps.
    pub fn first_step(&self) -> f32 {
        self.first_step
    }

    /// Returns the horizon, metres. It ends before the first step that is too uncertain to count as measured, and not
    /// so near any other step that a permitted error would decide whether that step counts.
    pub fn horizon_m(&self, p: &Params) -> f32 {
        // If all cells before the drop are valid, the horizon is the drop's nearest possible place: the drop's own
        // standard deviation covers the errors in the cell that holds it.
        let to_the_end = self.valid_m + CELL_M > self.end_m - ROUNDING_M;
        let valid_m = if to_the_end { self.end_m } else { self.valid_m };
        let mut horizon_m = math::max(valid_m, 0.0);
        if p.rules.measured_to {
            horizon_m = measured_to(horizon_m, self.steps);
        }
        if p.rules.clear_of_steps {
            horizon_m = clear_of(horizon_m, self.steps);
        }
        horizon_m
    }
}

/// Returns the largest error of a step's distance that is still correct, metres.
fn permitted_m(step: &Step) -> f32 {
    math::min(expanded(step.distance_sigma_m), MAX_EXPANDED_M)
}

/// Whether an error that the answer permits decides if a step lies within a horizon, metres. A step counts from 3 cm before
/// it on.
fn ambiguous(horizon_m: f32, step: &Step) -> bool {
    (horizon_m - (step.distance_m - MIN_EXPANDED_M)).abs() < permitted_m(step)
}

/// Returns a horizon, metres, that ends before the first step whose expanded uncertainty is too large for a measured
/// step.
fn measured_to(horizon_m: f32, steps: &[Step]) -> f32 {
    let vague =
        |s: &&Step| expanded(math::max(s.distance_sigma_m, s.height_sigma_m)) > MAX_EXPANDED_M;
    let first = steps.iter().find(vague);
    first.map_or(horizon_m, |s| {
        math::min(horizon_m, s.distance_m - MIN_EXPANDED_M)
    })
}

/// Returns a horizon, metres, moved nearer where it would end so close to a step that an error within its uncertainty
/// decides whether the step lies within it.
fn clear_of(horizon_m: f32, steps: &[Step]) -> f32 {
    let mut clear_m = horizon_m;
    for step in steps.iter().rev() {
        if ambiguous(clear_m, step) {
            clear_m = step.distance_m - MIN_EXPANDED_M - permitted_m(step);
        }
    }
    math::max(clear_m, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Returns the horizon where each cell up to `valid_m` is valid and none beyond, and the ground ends at `at_m`.
    fn horizon_m(valid_m: f32, at_m: f32) -> f32 {
        let drop = DropEdge {
            distance_m: at_m,
            ..DropEdge::default()
        };
        let mut reach = HorizonAccumulator::new(&[], Some(drop));
        for k in 0..CELLS {
            let end_m = FIRST_END_M + CELL_M * k as f32;
            if reach.ends_before(end_m) {
                break;
            }
            reach.add_cell(end_m, if end_m < valid_m { 1.0 } else { 0.0 }, 0.99);
        }
        reach.horizon_m(&Params::DEFAULT)
    }

    #[test]
    fn the_first_step_is_as_sure_as_the_cell_that_holds_it() {
        let first_step = |distance_m: Option<f32>| {
            let step = |distance_m| Step {
                distance_m,
                ..Step::default()
            };
            let steps: Vec<Step> = distance_m.into_iter().map(step).collect();
            let mut reach = HorizonAccumulator::new(&steps, None);
            for k in 0..CELLS {
                reach.add_cell(FIRST_END_M + CELL_M * k as f32, 1.0 - 0.01 * k as f32, 0.99);
            }
            reach.first_step()
        };
        // Cell 19 ends at 1.6 m. A step's distance may be off by 3 cm and still be correct.
        for (distance_m, cell) in [(1.52, 19), (1.56, 19), (1.58, 20), (1.62, 20)] {
            let wanted = 1.0 - 0.01 * cell as f32;
            assert!(
                (first_step(Some(distance_m)) - wanted).abs() < 1e-6,
                "{distance_m}"
            );
        }
        assert!(first_step(None) >= 1.0);
    }

    #[test]
    fn a_horizon_ends_at_a_drop_if_all_before_it_is_valid() {
        for at_m in [0.05, 0.42, 0.63, 0.98] {
            assert!((horizon_m(9.0, at_m) - at_m).abs() < 1e-3, "{at_m}");
        }
    }

    #[test]
    fn a_drop_makes_nothing_valid_before_it() {
        assert!((horizon_m(0.45, 0.98) - 0.4).abs() < 1e-3);
        for at_m in [0.05, 0.09, 0.63] {
            assert!(horizon_m(-9.0, at_m) < 1e-6, "{at_m}");
        }
    }
}
