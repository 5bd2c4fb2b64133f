//! The staircases that earlier scans found likeliest, and what their word counts in this one.

use crate::math;
use crate::model::{Edge, GroundKind, MAX_STEPS, Staircase, View};
use crate::params::current;
use heapless::Vec;

/// So many are carried on.
const CARRIED: usize = 4;
/// Nearer to the mirror no riser can be told, metres.
const NEAREST_M: f32 = 0.12;
/// What lies this near to the edge of what is seen may be seen or not: metres, and share of the slope.
const MARGIN_M: f32 = 0.15;
/// See [`MARGIN_M`].
const MARGIN_SHARE: f32 = 0.9;

/// A staircase with its weight among others.
#[derive(Clone, Copy, Debug)]
pub struct Weighed {
    /// The staircase.
    pub staircase: Staircase,
    /// Logarithm of its weight. Of those that are carried on, the likeliest has 0.
    pub log_weight: f32,
}

/// Those of earlier scans, in the place where they stand now, and those that this one is for.
#[derive(Debug)]
pub struct Hypotheses {
    past: Vec<Weighed, CARRIED>,
    present: Vec<Weighed, CARRIED>,
    /// What could be seen from where the chair was, well within the edge; and now.
    then: View,
    now: View,
    moved_m: f32,
}

impl Hypotheses {
    /// None.
    pub(super) const fn new() -> Self {
        Self {
            past: Vec::new(),
            present: Vec::new(),
            then: View::NOTHING,
            now: View::NOTHING,
            moved_m: 0.0,
        }
    }

    /// What the scan before was for becomes what is carried to this one, `moved_m` metres on.
    #[inline(never)]
    pub(super) fn go(&mut self, moved_m: f32) {
        self.past.clear();
        let present = core::mem::take(&mut self.present);
        for h in &present {
            let staircase = shifted(&h.staircase, -moved_m);
            if staircase.is_empty() || staircase.x(0) > NEAREST_M {
                // As many as there were.
                let _ = self.past.push(Weighed { staircase, ..*h });
            }
        }
    }

    /// What could be seen where the chair was `moved_m` metres before, and what can now.
    pub(super) fn seen_from(&mut self, then: View, now: View, moved_m: f32) {
        self.then = View {
            highest: MARGIN_SHARE * then.highest,
            farthest_m: then.farthest_m - MARGIN_M,
            ..then
        };
        self.now = now;
        self.moved_m = moved_m;
        self.present.clear();
    }

    pub(super) fn drop_past(&mut self) {
        self.past.clear();
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.past.is_empty()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.past.len()
    }

    /// One of them as far as it can be seen from here; none if it has no steps.
    #[inline(never)]
    pub fn staircase(&self, k: usize) -> Option<Staircase> {
        let mut s = self.past.get(k)?.staircase;
        let seen = edges(&s, &self.now);
        let last = seen.iter().rposition(|e| e.seen).map_or(0, |k| k + 1);
        s.steps = last as u8;
        (s.kind == GroundKind::Stairs && last > 0).then_some(s)
    }

    /// What earlier scans say for a staircase, nats: at most 0, and no less than the bound. A step that
    /// none of them can have seen is neither for nor against it.
    #[inline(never)]
    pub fn word(&self, s: &Staircase) -> f32 {
        if self.past.is_empty() {
            return 0.0;
        }
        let like = self.past.iter().filter(|h| self.alike(s, &h.staircase));
        let best = like
            .map(|h| h.log_weight)
            .fold(f32::NEG_INFINITY, math::max);
        math::max(current().carried_share * best, -current().carried_most_nats)
    }

    /// Whether two staircases have the same steps, as far as these could be seen from where the chair
    /// was.
    #[inline(never)]
    pub fn alike(&self, a: &Staircase, b: &Staircase) -> bool {
        let (a, b) = (shifted(a, self.moved_m), shifted(b, self.moved_m));
        self.holds(&a, &b) && self.holds(&b, &a)
    }

    /// Whether an edge at a place of this scan could be seen well from where the chair was.
    pub(super) fn could_see(&self, x_m: f32, y_m: f32) -> bool {
        let s = Staircase::nothing().with(0, x_m + self.moved_m, y_m);
        edges(&s, &self.then).iter().any(|e| e.seen)
    }

    /// Whether `a` has every step of `b` that could be seen well.
    #[inline(never)]
    fn holds(&self, a: &Staircase, b: &Staircase) -> bool {
        let has = edges(a, &self.then);
        let wanted = edges(b, &self.then);
        let mut seen = wanted.iter().filter(|e| e.seen);
        seen.all(|e| {
            has.iter()
                .any(|other| (other.x_m - e.x_m).abs() <= current().same_step_m)
        })
    }

    /// This scan and all before are for a staircase by so many nats.
    #[inline(never)]
    pub(super) fn keep(&mut self, staircase: &Staircase, log_weight: f32) {
        let new = Weighed {
            staircase: *staircase,
            log_weight,
        };
        let like = |h: &&mut Weighed| {
            let (a, b) = (&h.staircase, staircase);
            a.steps == b.steps && a.open == b.open && self_alike(a, b)
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

    /// All of this scan's are there: the likeliest counts 0.
    pub(super) fn normalise(&mut self) {
        let weights = self.present.iter().map(|h| h.log_weight);
        let most = weights.fold(f32::NEG_INFINITY, math::max);
        for h in &mut self.present {
            h.log_weight -= most;
        }
    }
}

/// The edges of a staircase.
#[inline(never)]
fn edges(s: &Staircase, view: &View) -> Vec<Edge, MAX_STEPS> {
    let mut edges = Vec::new();
    for edge in s.edges(view) {
        // As many as a staircase has.
        let _ = edges.push(edge);
    }
    edges
}

/// Whether the risers stand in the same places.
fn self_alike(a: &Staircase, b: &Staircase) -> bool {
    let places = a.x_m.iter().zip(&b.x_m).take(a.len());
    places
        .map(|(a, b)| (a - b).abs())
        .all(|off| off < current().same_step_m)
}

/// The staircase as it is seen from `by_m` farther back.
#[inline(never)]
fn shifted(s: &Staircase, by_m: f32) -> Staircase {
    let mut out = *s;
    out.x_m.iter_mut().for_each(|x| *x += by_m);
    out.wall_m += by_m;
    out
}
