//! How far an answer vouches for itself: the probability that nothing is wrong with it up to a
//! distance, and the largest distance at which that is still what `ok` promises.
//!
//! The way ahead is cut into cells. Each has a hazard: the probability that the answer goes wrong
//! there though it was right up to there, because a step is missing, made up, or more than 3 cm off.
//! It is the logistic function of what the estimator knows of the cell (its [`Features`]) with
//! weights that `cargo sim fit` counts from simulated scans with known truth (a discrete-time
//! survival model, Cox 1972). The product of what is left over the cells is the probability.

use super::roles::Role;
use super::scene::{Mark, Scene};
use super::verdict::Support;
use crate::answer::Step;
use crate::fitted;
use crate::grid::Geometry;
use crate::math;

/// Cells ahead, for each plane.
pub const CELLS: usize = 29;
/// Where the first cell ends, metres from the mirror …
const FIRST_END_M: f32 = -0.3;
/// … and how long each further one is.
const CELL_M: f32 = 0.1;
/// By so much a step may be off and still be right: design contract of `ok`, metres.
pub const RIGHT_M: f32 = 0.03;
/// An `ok` vouches for at least this much of the way, metres: design contract.
pub const LEAST_HORIZON_M: f32 = 1.0;
/// Number of features of a cell.
pub const FEATURES: usize = 48;

/// What the estimator knows of a cell.
pub type Features = [f32; FEATURES];

/// One cell of the way ahead.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Where it ends, metres from the mirror.
    pub end_m: f32,
    /// What is known of it.
    pub features: Features,
}

/// Everything that an answer rests on.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// The echoes …
    pub scene: &'a Scene<'a>,
    /// … and what each was taken for.
    pub roles: &'a [Role],
    /// The steps …
    pub steps: &'a [Step],
    /// … and what each rests on.
    pub supports: &'a [Support],
    /// The winner's score less that of the next best explanation; without steps, the best flight's
    /// score less what it takes to count, nats.
    pub lead: f32,
    /// Whether the treads float.
    pub open: bool,
    /// Whether the mirror looks down over an edge.
    pub down: bool,
    /// The instrument.
    pub geometry: &'a Geometry,
}

impl Ground<'_> {
    /// The cells of the way ahead, the nearest first.
    pub fn cells(&self) -> impl Iterator<Item = Cell> {
        (0..CELLS).map(|k| {
            let end_m = FIRST_END_M + CELL_M * k as f32;
            let start_m = if k == 0 { f32::NEG_INFINITY } else { end_m - CELL_M };
            Cell {
                end_m,
                features: self.features(start_m, end_m),
            }
        })
    }

    /// Number and support of the step whose error would show in a cell.
    fn step_in(&self, start_m: f32, end_m: f32) -> Option<(usize, &Step, &Support)> {
        let pairs = self.steps.iter().zip(self.supports).enumerate();
        let mut within = pairs.filter(|(_, (s, _))| {
            let shows = s.distance_m - RIGHT_M;
            shows > start_m && shows <= end_m
        });
        within.next().map(|(k, (step, support))| (k, step, support))
    }

    /// The strongest echo at a distance that has one of the wanted roles, tens of dB; 0 for none.
    fn strongest(&self, from_m: f32, to_m: f32, is: impl Fn(&Mark, Role) -> bool) -> f32 {
        let pairs = self.scene.marks.iter().zip(self.roles);
        let within = pairs.filter(|(m, role)| m.x_m > from_m && m.x_m <= to_m && is(m, **role));
        let strongest = within.map(|(m, _)| m.snr_db).fold(0.0, math::max);
        math::min(strongest, MOST_DB) / TEN_DB
    }

    /// What is known of the cell between two distances.
    fn features(&self, start_m: f32, end_m: f32) -> Features {
        let mut out = Writer::default();
        let (from, to) = (start_m + RIGHT_M, end_m + RIGHT_M);
        let unexplained = |_: &Mark, role: Role| role == Role::Stray || role.contradicts();
        let shows_level = |_: &Mark, role: Role| matches!(role, Role::Tread | Role::Edge);
        let level = self.strongest(from - CELL_M, to + CELL_M, shows_level);
        let stray = self.strongest(from, to, unexplained);
        let stray_so_far = self.strongest(f32::NEG_INFINITY, to, unexplained);
        let stray_beyond = self.strongest(to, f32::INFINITY, unexplained);
        let last = self.steps.iter().zip(self.supports).last();
        let lead = self.lead.clamp(-MOST_NATS, MOST_NATS);
        let step = self.step_in(start_m, end_m);
        let inside = last.is_some_and(|(s, _)| s.distance_m > from);
        let kind = match (self.steps.is_empty(), step.is_some(), inside) {
            (true, ..) => Kind::Clear,
            (_, true, _) => Kind::Step,
            (.., true) => Kind::Between,
            _ => Kind::Behind,
        };
        // The instrument and the scene as a whole.
        out.put([
            1.0,
            end_m,
            self.geometry.bin_m / PAPER_BIN_M - 1.0,
            self.geometry.beamwidth_rad / PAPER_BEAM_RAD - 1.0,
            self.scene.mount_height_m - PAPER_MOUNT_M,
            self.strongest(f32::NEG_INFINITY, f32::INFINITY, |_, _| true),
        ]);
        out.put_if(kind == Kind::Clear, || {
            [
                1.0,
                level,
                f32::from(level <= 0.0),
                stray,
                stray_so_far,
                stray_beyond,
                lead,
                math::max(lead, -2.0),
                self.strongest(to, f32::INFINITY, shows_level),
            ]
        });
        out.put_if(kind == Kind::Between, || {
            let first = self.steps.first().is_some_and(|s| s.distance_m > to);
            [1.0, f32::from(first), level, stray, stray_so_far, lead]
        });
        out.put_if(kind == Kind::Behind, || self.behind(from, to, level, stray));
        out.put_if(kind == Kind::Step, || match step {
            Some((k, step, support)) => self.of_step(k, step, support, stray, stray_so_far),
            None => [0.0; STEP_FEATURES],
        });
        out.features
    }

    /// What is known of a cell behind the last step.
    fn behind(&self, from: f32, to: f32, level: f32, stray: f32) -> [f32; BEHIND_FEATURES] {
        let (Some(last), Some(support)) = (self.steps.last(), self.supports.last()) else {
            return [0.0; BEHIND_FEATURES];
        };
        let first = self.steps.first().map_or(last.distance_m, |s| s.distance_m);
        let spans = self.steps.len().saturating_sub(1);
        let going = match spans {
            0 => TYPICAL_GOING_M,
            n => (last.distance_m - first) / n as f32,
        };
        let goings = (0.5 * (math::max(from, last.distance_m) + to) - last.distance_m)
            / math::max(going, CELL_M);
        let next = math::max(1.0 - (goings - 1.0).abs(), 0.0);
        let hidden = f32::from(last.height_m > self.scene.mount_height_m);
        let next_db = (support.next_db / TEN_DB).clamp(-1.0, 2.0 + 1.0);
        let shows_level = |_: &Mark, role: Role| matches!(role, Role::Tread | Role::Edge);
        let beyond = self.strongest(to, f32::INFINITY, shows_level);
        let lead = self.lead.clamp(0.0, MOST_NATS);
        [
            1.0,
            next,
            f32::from(goings > 1.5),
            next_db,
            next_db * next,
            level,
            beyond,
            stray,
            hidden,
            lead,
            level * next,
            self.steps.len() as f32,
        ]
    }

    /// What is known of a cell that holds step `k`.
    fn of_step(
        &self,
        k: usize,
        step: &Step,
        support: &Support,
        stray: f32,
        stray_so_far: f32,
    ) -> [f32; STEP_FEATURES] {
        let height_z = RIGHT_M / step.height_sigma_m;
        let distance_z = RIGHT_M / step.distance_sigma_m;
        let hidden = step.height_m > self.scene.mount_height_m;
        [
            1.0,
            math::min(height_z, 2.0),
            math::min(height_z, 2.0 + 2.0),
            math::min(distance_z, 2.0 + 2.0),
            f32::from(support.snr_db.is_none()),
            support.snr_db.unwrap_or(0.0).clamp(0.0, MOST_DB) / TEN_DB,
            math::min((support.off.value / RIGHT_M).abs(), 2.0),
            math::min((support.off_along_m / RIGHT_M).abs(), 2.0),
            self.lead.clamp(0.0, MOST_NATS),
            f32::from(self.steps.len() == 1),
            f32::from(self.open),
            f32::from(hidden) + f32::from(support.flashes),
            k as f32,
            stray,
            stray_so_far,
        ]
    }
}

/// How far up the probability of being right stays at what `ok` promises.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vouch {
    /// Up to this distance from the mirror, metres; none if not even the nearest.
    pub horizon_m: Option<f32>,
    /// Probability that nothing is wrong up to there, or up to [`LEAST_HORIZON_M`] if that is
    /// farther.
    pub confidence: f32,
}
