//! The likeliest staircases of earlier scans, and the log-prior that they give to staircases of this scan.

use crate::answer::Direction;
use crate::math;
use crate::model::{Edge, MAX_STEPS, Staircase, View};
use crate::params::Numbers;
use crate::params::carried::{VIEW_MARGIN_M, VIEW_MARGIN_SHARE};
use crate::params::posterior::NEAREST_ECHO_M;
use heapless::Vec;

/// Maximum number of staircases that are carried on to the next scan.
const CARRIED: usize = 4;
/// Minimum distance of a riser that a scan can show, metres from the mirror: the minimum range of an echo.
const NEAREST_M: f32 = NEAREST_ECHO_M;

/// A staircase of this or an earlier scan with its weight relative to the others.
#[derive(Clone, Copy, Debug)]
pub struct Weighed {
    /// The staircase.
    pub staircase: Staircase,
    /// Log-weight of the staircase, nats; relative to the likeliest one where it is carried on from scan to scan.
    pub log_weight: f32,
}

/// Staircases of earlier scans at their present places, and those that this scan stores for the next one.
#[derive(Debug)]
pub struct CarriedHypotheses {
    past: Vec<Weighed, CARRIED>,
    present: Vec<Weighed, CARRIED>,
    /// Field of view of the scan before, from the chair's place at that scan, reduced by the margins near its limits.
    past_view: View,
    view: View,
    moved_m: f32,
    numbers: Numbers,
}

impl CarriedHypotheses {
    /// Returns a set without staircases.
    pub(super) const fn new(numbers: Numbers) -> Self {
        Self {
            past: Vec::new(),
            present: Vec::new(),
            past_view: View::NOTHING,
            view: View::NOTHING,
            moved_m: 0.0,
            numbers,
        }
    }

    /// Turns the stored staircases into carried ones, moved nearer by `moved_m` metres.
    #[inline(never)]
    pub(super) fn shift(&mut self, moved_m: f32) {
        self.past.clear();
        let present = core::mem::take(&mut self.present);
        for h in &present {
            let staircase = shifted(&h.staircase, -moved_m);
            if staircase.is_empty() || staircase.x(0) > NEAREST_M {
                // Cannot fail: there are as many as before.
                let _ = self.past.push(Weighed { staircase, ..*h });
            }
        }
    }

    /// Sets the fields of view of the scan before and of this one. The chair moved `moved_m` metres between them.
    pub(super) fn set_views(&mut self, past_view: View, view: View, moved_m: f32) {
        self.past_view = View {
            highest: VIEW_MARGIN_SHARE * past_view.highest,
            farthest_m: past_view.farthest_m - VIEW_MARGIN_M,
            ..past_view
        };
        self.view = view;
        self.moved_m = moved_m;
        self.present.clear();
    }

    pub(super) fn clear_carried(&mut self) {
        self.past.clear();
    }

    /// Whether no staircase was carried on.
    pub fn is_empty(&self) -> bool {
        self.past.is_empty()
    }

    /// Returns the number of carried staircases.
    pub fn len(&self) -> usize {
        self.past.len()
    }

    /// Returns carried staircase `k` up to its last step that is visible in this scan; none if no step is visible.
    #[inline(never)]
    pub fn staircase(&self, k: usize) -> Option<Staircase> {
        let mut s = self.past.get(k)?.staircase;
        let seen = edges(&s, &self.view);
        let last = seen.iter().rposition(|e| e.seen).map_or(0, |k| k + 1);
        s.steps = last as u8;
        (s.kind.direction() == Direction::Up && last > 0).then_some(s)
    }

    /// Returns the log-prior of a staircase from earlier scans, nats: at most 0, with a lower limit. A step that no
    /// earlier scan can have seen has no influence.
    #[inline(never)]
    pub fn log_prior(&self, s: &Staircase) -> f32 {
        if self.past.is_empty() {
            return 0.0;
        }
        let like = self
            .past
            .iter()
            .filter(|h| self.same_visible_steps(s, &h.staircase));
        let best = like
            .map(|h| h.log_weight)
            .fold(f32::NEG_INFINITY, math::max);
        math::max(
            self.numbers.carried_share * best,
            -self.numbers.carried_most_nats,
        )
    }

    /// Whether two staircases have the same steps, among those that were in view from the chair's earlier place.
    #[inline(never)]
    pub fn same_visible_steps(&self, a: &Staircase, b: &Staircase) -> bool {
        let (a, b) = (shifted(a, self.moved_m), shifted(b, self.moved_m));
        self.holds(&a, &b) && self.holds(&b, &a)
    }

    /// Whether an edge at distance `x_m` and height `y_m` of this scan, metres, was well in view from the chair's
    /// earlier place.
    pub(super) fn could_see(&self, x_m: f32, y_m: f32) -> bool {
        let s = Staircase::nothing().with(0, x_m + self.moved_m, y_m);
        edges(&s, &self.past_view).iter().any(|e| e.seen)
    }

    /// Whether `a` has every step of `b` that was well in view of the scan before.
    #[inline(never)]
    fn holds(&self, a: &Staircase, b: &Staircase) -> bool {
        let has = edges(a, &self.past_view);
        let wanted = edges(b, &self.past_view);
        let mut seen = wanted.iter().filter(|e| e.seen);
        seen.all(|e| {
            has.iter()
                .any(|other| (other.x_m - e.x_m).abs() <= self.numbers.same_step_m)
        })
    }

    /// Stores a staircase for the next scan, with its log-weight over this and all earlier scans, nats. If there is no
    /// room, it replaces the least likely one.
    #[inline(never)]
    pub(super) fn keep(&mut self, staircase: &Staircase, log_weight: f32) {
        let new = Weighed {
            staircase: *staircase,
            log_weight,
        };
        let same_step_m = self.numbers.same_step_m;
        let like = |h: &&mut Weighed| {
            let (a, b) = (&h.staircase, staircase);
            a.steps == b.steps && a.open == b.open && self_alike(a, b, same_step_m)
        };
        if let Some(h) = self.present.iter_mut().find(like) {
            if h.log_weight < log_weight {
                *h = new;
            }
            return;
        }
        if let Err(new) = self.present.push(new) {
            let least = self.present.iter_mut();
            let least = least.min_by(|a, b| a.log_weight.total_cmp(&b.log_weight));
            if let Some(h) = least.filter(|h| h.log_weight < log_weight) {
                *h = new;
            }
        }
    }

    /// Shifts the stored log-weights so that the likeliest has 0.
    pub(super) fn normalise(&mut self) {
        let weights = self.present.iter().map(|h| h.log_weight);
        let most = weights.fold(f32::NEG_INFINITY, math::max);
        for h in &mut self.present {
            h.log_weight -= most;
        }
    }
}

/// Returns the edges of a staircase, the nearest first, each with whether it is visible in `view`.
#[inline(never)]
fn edges(s: &Staircase, view: &View) -> Vec<Edge, MAX_STEPS> {
    let mut edges = Vec::new();
    for edge in s.edges(view) {
        // Cannot fail: a staircase has no more edges.
        let _ = edges.push(edge);
    }
    edges
}

/// Whether all risers of `a` have the same distances as those of `b`, to within `same_step_m`, metres.
fn self_alike(a: &Staircase, b: &Staircase, same_step_m: f32) -> bool {
    let places = a.x_m.iter().zip(&b.x_m).take(a.len());
    places
        .map(|(a, b)| (a - b).abs())
        .all(|off| off < same_step_m)
}

/// Returns the staircase as seen from `by_m` metres farther back: all its distances are larger by `by_m`.
#[inline(never)]
fn shifted(s: &Staircase, by_m: f32) -> Staircase {
    let mut out = *s;
    out.x_m.iter_mut().for_each(|x| *x += by_m);
    out.wall_m += by_m;
    out
}
