//! The ground as a surface: log-likelihoods of its line if it goes on, ends, or carries an obstacle.
//!
//! S, the ground's power over the noise, falls with the range as (h - y)²/r⁵ times its reflectivity: the hidden state
//! of a Markov chain along the ground, which walks to neighbouring states and sometimes jumps. With E the likelihood
//! ratio of each cell by state, the forward recursion gives F(b), the log-likelihood of ground up to cell b; backward
//! recursions give that of a surface from a cell on. Relative to ground that goes on to the end of the range, in
//! nats:
//!
//! | hypothesis | log-likelihood |
//! |---|---|
//! | drop at b | F(b) + behind the edge: lower ground from the end of the edge's shadow on, or darkness, low objects, ground again |
//! | riser at b | F(b) + the ground's line around it; what is above it is left to the echoes |
//! | threshold at b | as a riser + ground again |

use super::lines::{CELLS, Lines};
use super::power::{DEPTHS_M, Power};
use crate::math;
use crate::params::ground_line::{
    AGAIN, ANY_DB, DARK_AT_RISER, FIRST_STATE_DB, HOLE_M, JUMPS, LIES_LOW, LOW_ENDS, LOWER, ODD,
    REFERENCE_M, STATE_DB, WALKS,
};

/// Number of slots into which the way ahead is divided for the results.
pub const SLOTS: usize = 48;
/// Length of a slot, metres; the first one begins at the mirror.
pub const SLOT_M: f32 = 0.05;
/// Minimum number of evaluated range cells; with fewer all hypotheses are equally likely.
const MIN_CELLS: usize = 10;
/// Number of states of the ground's reflectivity in the Markov chain.
const STATES: usize = 12;
/// Number of powers that a surface of unknown power may have, equally probable.
const ANY_POWERS: usize = 5;
/// Number of range cells before a riser that show it on the ground's line.
const BEFORE: usize = 3;
/// Number of range cells behind a riser that show it on the ground's line: double bounces.
const BEHIND: usize = 1;
/// Maximum distance by which the evidence for a riser may lie behind its place, half slots of 2.5 cm.
const SHOWS_BEHIND: usize = 3;
/// Range by which a range cell shows ground beyond its end, metres: half the window's main lobe.
const SPREAD_M: f32 = 0.02;
/// Exponent of the range r in the decline of the ground's power S, (h - y)²/r⁵.
const RANGE_POWER: f32 = 5.0;
/// Lower limit of the mirror's height above a surface, h − y, in the decline of the ground's power S, (h − y)²/r⁵, metres.
const MIN_HEIGHT_M: f32 = 0.03;
/// Lower limit of the range r in that decline of the ground's power, metres.
const MIN_RANGE_M: f32 = 0.3;

/// Log-likelihood ratios of a drop, a riser and a threshold (`bump`) in each slot to ground that goes on, nats; the
/// nearest slot first.
#[derive(Clone, Debug)]
pub struct Surfaces {
    drop: [f32; SLOTS],
    rise: [f32; SLOTS],
    bump: [f32; SLOTS],
}

impl Surfaces {
    /// Log-likelihood ratios without a map: every hypothesis is as likely as ground that goes on.
    pub const NOTHING: Self = Self {
        drop: [0.0; SLOTS],
        rise: [0.0; SLOTS],
        bump: [0.0; SLOTS],
    };

    /// Returns the log-likelihood ratio of ground that ends at a distance, metres; nats.
    pub fn drop_at(&self, x_m: f32) -> f32 {
        between(&self.drop, x_m)
    }

    /// Returns the log-likelihood ratio of a riser at a distance, metres; nats.
    pub fn rise_at(&self, x_m: f32) -> f32 {
        most(&self.rise, x_m)
    }

    /// Returns the log-likelihood ratio of a threshold at a distance, metres, with ground behind it; nats.
    pub fn bump_at(&self, x_m: f32) -> f32 {
        most(&self.bump, x_m)
    }
}

/// Returns the log-likelihood ratio at a distance, metres, interpolated between the middles of slots.
fn between(slots: &[f32; SLOTS], x_m: f32) -> f32 {
    let place = math::min(math::max(x_m / SLOT_M - 0.5, 0.0), (SLOTS - 1) as f32);
    let k = place as usize;
    let share = place - k as f32;
    let here = value(slots, k);
    here + share * (slots.get(k + 1).copied().unwrap_or(here) - here)
}

/// Returns the maximum log-likelihood ratio at a distance, metres, and just behind it, up to 7.5 cm.
fn most(slots: &[f32; SLOTS], x_m: f32) -> f32 {
    let places = (0..=SHOWS_BEHIND).map(|k| between(slots, x_m + 0.5 * SLOT_M * k as f32));
    places.fold(f32::NEG_INFINITY, math::max)
}

/// Returns element `k`, or 0 beyond the end.
fn value(of: &[f32], k: usize) -> f32 {
    of.get(k).copied().unwrap_or(0.0)
}

/// Sets element `k`; does nothing beyond the end.
fn set(of: &mut [f32], k: usize, value: f32) {
    if let Some(place) = of.get_mut(k) {
        *place = value;
    }
}

/// Returns ln(e^a + e^b): the logarithm of the sum of two likelihoods.
#[inline(never)]
fn either(a: f32, b: f32) -> f32 {
    math::max(a, b) + math::ln(1.0 + math::exp(-(a - b).abs()))
}

/// One value (probability or likelihood ratio) for each reflectivity state, the weakest first.
type State = [f32; STATES];

/// Uniform prior of the states.
const EVEN: State = [1.0 / STATES as f32; STATES];

/// Advances the probabilities of the reflectivity states by one range cell.
fn walk(state: &mut State) {
    let jumps = JUMPS / STATES as f32 * state.iter().sum::<f32>();
    // Beyond the first and the last state lies the same once more.
    let mut old = [0.0; STATES + 2];
    let [first, inner @ .., last] = &mut old;
    inner.copy_from_slice(state);
    let [lowest, .., highest] = *state;
    (*first, *last) = (lowest, highest);
    for (new, [before, here, after]) in state.iter_mut().zip(old.array_windows()) {
        let walked = here + 0.5 * WALKS * (before + after - 2.0 * here);
        *new = (1.0 - JUMPS) * walked + jumps;
    }
}

/// Multiplies the probabilities of the reflectivity states by a cell's likelihood ratios and normalises them; returns
/// the logarithm of their sum before, nats.
fn weigh(state: &mut State, e: &State) -> f32 {
    state.iter_mut().zip(e).for_each(|(v, e)| *v *= e);
    let sum = math::max(state.iter().sum(), f32::MIN_POSITIVE);
    let per = 1.0 / sum;
    state.iter_mut().for_each(|v| *v *= per);
    math::ln(sum)
}

/// Power law by which a surface at one height returns less power S at greater ranges: proportional to (h - y)²/r⁵.
struct Decline {
    /// Factor (h - y)² of the power law, of the mirror's height in metres above the surface, as octaves of power: 2
    /// log2(h - y).
    height: f32,
    /// Power law's value for the ground at the range [`REFERENCE_M`], octaves of power: the state's power S refers to
    /// it.
    reference: f32,
}

impl Decline {
    /// Returns the power law of a surface `y_m` metres above the ground, seen from a mirror `mirror_m` metres above the
    /// ground.
    fn new(mirror_m: f32, y_m: f32) -> Self {
        let height = |h_m: f32| 2.0 * math::log2(math::max(h_m, MIN_HEIGHT_M));
        Self {
            height: height(mirror_m - y_m),
            reference: height(mirror_m) - RANGE_POWER * math::log2(REFERENCE_M),
        }
    }

    /// Returns the power S of the surface in the first (weakest) reflectivity state at a range, metres, dB over the
    /// noise.
    fn first_state_db(&self, range_m: f32) -> f32 {
        let here = self.height - RANGE_POWER * math::log2(math::max(range_m, MIN_RANGE_M));
        FIRST_STATE_DB + math::DB_PER_OCTAVE * (here - self.reference)
    }
}

/// One log-likelihood, nats, for each range cell, the nearest first. In sums up to a cell, entry k holds the cells
/// nearer than k; in sums from a cell on, entry k holds cell k and all farther ones.
type ByCell = [f32; CELLS + 1];

/// Working memory of the recursions.
#[derive(Debug)]
pub struct Recursions {
    /// Line powers of the map.
    pub lines: Lines,
    /// Likelihood ratios of the ground, by range cell and state, for the forward and the backward recursion.
    ratios: [State; CELLS],
    /// Log-likelihood of ground up to each range cell, nats.
    ground: ByCell,
    /// Log-likelihood of range cells that lie around a riser, summed up to each cell, nats.
    around: ByCell,
    /// Log-likelihood of a surface that goes on from each range cell to the last, nats.
    surface: ByCell,
    /// Log-likelihood of darkness, low objects or ground again, from each range cell to the last, nats.
    behind: ByCell,
    /// Log-likelihood, if an edge lies in a range cell, of everything behind it, nats, by range cell.
    drop: ByCell,
}

impl Default for Recursions {
    fn default() -> Self {
        Self::new()
    }
}

impl Recursions {
    /// Returns empty memory.
    pub const fn new() -> Self {
        Self {
            lines: Lines::new(),
            ratios: [[0.0; STATES]; CELLS],
            ground: [0.0; CELLS + 1],
            around: [0.0; CELLS + 1],
            surface: [0.0; CELLS + 1],
            behind: [0.0; CELLS + 1],
            drop: [0.0; CELLS + 1],
        }
    }

    /// Evaluates all hypotheses into `out`, with lower ground at the first `depths` of [`DEPTHS_M`].
    #[inline(never)]
    pub fn weigh(&mut self, out: &mut Surfaces, depths: usize) {
        *out = Surfaces::NOTHING;
        if self.lines.cells().len() < MIN_CELLS {
            return;
        }
        let level = self.forward();
        self.backward(|r, b| r.ratios.get(b).copied().unwrap_or(EVEN));
        self.behind();
        self.risers(level, out);
        self.lower(depths);
        self.drops(level, out);
    }

    /// Forward recursion: the ground up to each cell, and the cells around a riser. Returns the log-likelihood of the
    /// whole ground.
    #[inline(never)]
    fn forward(&mut self) -> f32 {
        let (mut state, mut sum, mut around) = (EVEN, 0.0, 0.0);
        let decline = Decline::new(self.lines.height_m, 0.0);
        for b in 0..self.lines.cells().len() {
            let power = self.lines.ground(b);
            let ratio = self.likelihood(b, &decline, power);
            sum += weigh(&mut state, &ratio);
            walk(&mut state);
            if let Some(place) = self.ratios.get_mut(b) {
                *place = ratio;
            }
            around += math::ln(DARK_AT_RISER + (1.0 - DARK_AT_RISER) * self.any(&[power]));
            set(&mut self.ground, b + 1, sum);
            set(&mut self.around, b + 1, around);
        }
        sum
    }

    /// Backward recursion of a surface, with the likelihood ratios of a cell's states from `ratio`: fills `surface`.
    #[inline(never)]
    fn backward(&mut self, ratio: impl Fn(&Self, usize) -> State) {
        let n = self.lines.cells().len();
        let (mut state, mut sum) = (EVEN, 0.0);
        set(&mut self.surface, n, 0.0);
        for b in (0..n).rev() {
            sum += weigh(&mut state, &ratio(self, b));
            walk(&mut state);
            set(&mut self.surface, b, sum);
        }
    }

    /// Backward recursion behind an edge and its shadow, of darkness, low objects, or ground again: fills `behind`.
    #[inline(never)]
    fn behind(&mut self) {
        const STAYS: f32 = math::ln(1.0 - LIES_LOW - AGAIN);
        const BEGINS: f32 = math::ln(LIES_LOW);
        const ENDS: f32 = math::ln(LOW_ENDS);
        const GOES_ON: f32 = math::ln(1.0 - LOW_ENDS - AGAIN);
        const COMES: f32 = math::ln(AGAIN);
        let n = self.lines.cells().len();
        let (mut dark, mut low) = (0.0, 0.0);
        set(&mut self.behind, n, 0.0);
        for (b, cell) in self.lines.cells().iter().enumerate().rev() {
            let lies = math::ln(self.any(&cell.lower)) + low;
            let again = COMES + value(&self.surface, b);
            let next = either(either(STAYS + dark, BEGINS + lies), again);
            low = either(either(ENDS + dark, GOES_ON + lies), again);
            dark = next;
            set(&mut self.behind, b, dark);
        }
    }

    /// Writes the log-likelihood ratios of risers and thresholds into `out`. `level` is the log-likelihood of ground
    /// that goes on to the end of the range, nats.
    #[inline(never)]
    fn risers(&self, level: f32, out: &mut Surfaces) {
        let n = self.lines.cells().len();
        let (mut rise, mut bump) = (Slots::new(&mut out.rise), Slots::new(&mut out.bump));
        for b in 0..n {
            let x_m = self.lines.x_m(self.lines.range_m(b));
            let from = b.saturating_sub(BEFORE);
            let (to, again) = ((b + BEHIND).min(n), (b + BEHIND + BEFORE).min(n));
            let around = |to: usize| value(&self.around, to) - value(&self.around, from);
            let before = value(&self.ground, from) - level;
            rise.add(x_m, before + around(to));
            bump.add(x_m, before + around(again) + value(&self.surface, again));
        }
        rise.finish();
        bump.finish();
    }

    /// Fills `drop`: sums the likelihoods of darkness and of lower ground, at the first `depths` depths, behind an edge
    /// in each cell.
    #[inline(never)]
    fn lower(&mut self, depths: usize) {
        const HIDDEN: f32 = math::ln(1.0 - LOWER);
        const EACH: f32 = math::ln(LOWER / DEPTHS_M.len() as f32);
        let n = self.lines.cells().len();
        let h = self.lines.height_m;
        for b in 0..n {
            let x_m = self.lines.x_m(self.lines.range_m(b));
            let again = self.lines.at(math::hypot(x_m + HOLE_M, h));
            let hidden = HIDDEN + value(&self.behind, again);
            set(&mut self.drop, b, hidden);
        }
        for (k, depth_m) in DEPTHS_M.into_iter().enumerate().take(depths) {
            let decline = Decline::new(h, -depth_m);
            self.backward(|r, b| r.likelihood(b, &decline, r.lines.lower(b, k)));
            for b in 0..n {
                let shadow = self.lines.at(self.lines.range_m(b) * (h + depth_m) / h);
                let lower = EACH + value(&self.surface, shadow);
                let sum = either(value(&self.drop, b), lower);
                set(&mut self.drop, b, sum);
            }
        }
    }

    /// Writes the log-likelihood ratios of drops into `out`. `level` is the log-likelihood of ground that goes on to
    /// the end of the range, nats.
    #[inline(never)]
    fn drops(&self, level: f32, out: &mut Surfaces) {
        let mut drop = Slots::new(&mut out.drop);
        for b in 0..self.lines.cells().len() {
            let x_m = self.lines.x_m(self.lines.range_m(b) - SPREAD_M);
            drop.add(x_m, value(&self.ground, b) + value(&self.drop, b) - level);
        }
        drop.finish();
    }

    /// Returns the likelihood ratio of a surface in range cell `b` to none, by reflectivity state, from the `power`
    /// along the surface's line; `decline` is its power law.
    #[inline(never)]
    fn likelihood(&self, b: usize, decline: &Decline, power: Power) -> State {
        let mut db = decline.first_state_db(self.lines.range_m(b));
        let shown = power.shown();
        let mut e = [1.0; STATES];
        for e in &mut e {
            *e = self.lines.ratio(shown, db);
            db += STATE_DB;
        }
        let odd = ODD / STATES as f32 * e.iter().sum::<f32>();
        e.iter_mut().for_each(|e| *e = (1.0 - ODD) * *e + odd);
        e
    }

    /// Returns the likelihood ratio to none of a surface of unknown power that lies on one of several lines, it is
    /// unknown on which, from the `powers` along these lines.
    #[inline(never)]
    fn any(&self, powers: &[Power]) -> f32 {
        let mut sum = 0.0;
        for power in powers {
            let shown = power.shown();
            // A line that is not seen says nothing, of any power.
            if !shown.is_seen() {
                sum += ANY_POWERS as f32;
                continue;
            }
            for k in 0..ANY_POWERS {
                sum += self.lines.ratio(shown, ANY_DB * k as f32);
            }
        }
        sum / (ANY_POWERS * powers.len()) as f32
    }
}

/// Writer of log-likelihood ratios by slot, from those of range cells, the nearest cell first.
struct Slots<'a> {
    values: &'a mut [f32; SLOTS],
    first: Option<(usize, f32)>,
    last: Option<usize>,
}

impl<'a> Slots<'a> {
    fn new(values: &'a mut [f32; SLOTS]) -> Self {
        Self {
            values,
            first: None,
            last: None,
        }
    }

    /// Adds a range cell's value at distance `x_m`, metres: a slot has the maximum of its cells.
    fn add(&mut self, x_m: f32, value: f32) {
        // `as` saturates.
        let slot = (x_m / SLOT_M) as usize;
        self.first.get_or_insert((slot, value));
        if slot >= self.values.len() {
            return;
        }
        let before = self
            .last
            .map(|last| (last, self.values.get(last).copied().unwrap_or(value)));
        let value = match before {
            Some((last, before)) if last == slot => math::max(before, value),
            _ => value,
        };
        // Slots in which no cell lies are as likely as the next one.
        let from = before.map_or(slot, |(last, _)| (last + 1).min(slot));
        if let Some(slots) = self.values.get_mut(from..=slot) {
            slots.fill(value);
        }
        self.last = Some(slot);
    }

    /// Completes the slots: those nearer than all cells take the first cell's value, those beyond them 0, as ground
    /// that goes on.
    fn finish(self) {
        let (first, value) = self.first.unwrap_or_default();
        self.values.iter_mut().take(first).for_each(|v| *v = value);
        if let Some(last) = self.last.and_then(|last| self.values.get_mut(last)) {
            // Not all of it was looked at.
            *last = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::Slope;
    use crate::config::Config;
    use crate::model::chart::Chart;
    use crate::model::{SAME_M, Staircase};
    use crate::motion::{Drive, Input, MotionCompensation, RowPose, Track};
    use crate::signal::echoes::tests::{map, scene};
    use crate::signal::grid::PolarMap;

    const NOISE: f32 = 80.0;

    /// Returns a map of ground, points 1 cm apart from 0.25 m to `end_m` without `hole`, `db` over the noise at 0.5 m
    /// and 2 dB weaker every 10 cm; then of `lower` ground, given as (beginning, depth), metres.
    fn ground(
        end_m: f32,
        hole: core::ops::Range<f32>,
        db: f64,
        lower: Option<(f32, f32)>,
    ) -> std::boxed::Box<PolarMap> {
        let places = |from_m: f32| (0..240).map(move |k| from_m + 0.01 * k as f32);
        let shown = places(0.25)
            .filter(|x| *x < end_m && !hole.contains(x))
            .map(|x| (x, 0.0));
        let lower = lower
            .into_iter()
            .flat_map(|(again_m, depth_m)| places(again_m).map(move |x| (x, -depth_m)));
        let points: std::vec::Vec<_> = shown
            .chain(lower)
            .map(|(x, y)| (x, y, db - 20.0 * (f64::from(x) - 0.5)))
            .collect();
        scene(&Config::default(), &points)
    }

    fn chart(map: &PolarMap) -> Chart<'_> {
        Chart {
            bend: Slope::LEVEL,
            map,
            noise: NOISE,
            bias_rad: 0.0,
            height_m: 0.0,
            image: None,
            ride: None,
        }
    }

    fn weighed(chart: &Chart<'_>) -> Surfaces {
        let mut surfaces = Surfaces::NOTHING;
        let mut recursions = std::boxed::Box::new(Recursions::new());
        recursions.lines.look(chart);
        recursions.weigh(&mut surfaces, DEPTHS_M.len());
        surfaces
    }

    /// Returns the likeliest place of a drop, metres, and its log-likelihood ratio to ground that goes on, nats.
    fn end(surfaces: &Surfaces) -> (f32, f32) {
        let places = (0..SLOTS).map(|k| (k as f32 + 0.5) * SLOT_M);
        let nats = places.map(|x| (x, surfaces.drop_at(x)));
        nats.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
    }

    #[test]
    fn visible_ground_has_no_likely_drop_or_riser() {
        let surfaces = weighed(&chart(&ground(2.5, 0.0..0.0, 15.0, None)));
        for x_m in [0.4, 0.6, 0.8, 1.0] {
            let reported = (surfaces.drop_at(x_m), surfaces.rise_at(x_m));
            assert!(
                reported.0 < -5.0 && reported.1 < -5.0,
                "{x_m}: {reported:?}"
            );
        }
    }

    #[test]
    fn end_of_the_grounds_line_is_the_likeliest_drop() {
        for end_m in [0.62, 0.81, 0.97] {
            let surfaces = weighed(&chart(&ground(end_m, 0.0..0.0, 15.0, None)));
            let (x_m, nats) = end(&surfaces);
            // As near as the contract lets a reported drop cover a true one.
            assert!(
                (x_m - end_m).abs() < SAME_M && nats > 1.0,
                "{end_m}: {x_m} {nats}"
            );
            assert!(surfaces.drop_at(end_m - 0.2) < nats - 5.0);
        }
    }

    #[test]
    fn lower_ground_behind_an_edge_raises_the_likelihood_of_a_drop() {
        let of = |hole, lower| weighed(&chart(&ground(2.5, hole, 15.0, lower)));
        let (_, alone) = end(&of(0.8..3.0, None));
        let (x_m, lower) = end(&of(0.8..3.0, Some((1.1, 0.11))));
        assert!(
            (x_m - 0.8).abs() < 0.06 && lower > alone,
            "{x_m} {lower} {alone}"
        );
        let hole = of(0.8..1.1, None);
        let (before, at, behind) = (hole.drop_at(0.6), hole.drop_at(0.8), hole.drop_at(1.0));
        assert!(
            at > -4.0 && at > before + 5.0 && at > behind - 2.0,
            "{before} {at} {behind}"
        );
    }

    #[test]
    fn something_that_stands_on_the_ground_is_no_drop() {
        let places = (0..75).map(|k| (0.25 + 0.01 * k as f32, 0.0));
        let face = (0..20).map(|k| (1.0, 0.01 * k as f32));
        let ground = places.map(|(x, y)| (x, y, 15.0 - 20.0 * (f64::from(x) - 0.5)));
        let points: std::vec::Vec<_> = ground.chain(face.map(|(x, y)| (x, y, 20.0))).collect();
        let surfaces = weighed(&chart(&scene(&Config::default(), &points)));
        let riser = surfaces.rise_at(1.0);
        assert!(
            riser > 3.0 && riser > surfaces.drop_at(1.0),
            "{riser} {:?}",
            end(&surfaces)
        );
        assert!(riser > surfaces.rise_at(0.7) + 5.0);
    }

    #[test]
    fn slots_between_two_cells_are_as_likely_as_the_farther_one() {
        let mut values = [0.0; SLOTS];
        let mut slots = Slots::new(&mut values);
        for (x_m, value) in [(0.12, -3.0), (0.13, -2.0), (0.27, -5.0), (0.41, -1.0)] {
            slots.add(x_m, value);
        }
        slots.finish();
        // Nearer than all cells as in the first one; the last slot was not looked at as a whole.
        let expected = [-3.0, -3.0, -2.0, -5.0, -5.0, -5.0, -1.0, -1.0, 0.0_f32];
        assert!(
            values
                .iter()
                .zip(expected)
                .all(|(v, e)| (v - e).abs() < 1e-6),
            "{values:?}"
        );
    }

    #[test]
    fn map_without_power_gives_no_likely_drop() {
        let surfaces = weighed(&chart(&scene(&Config::default(), &[])));
        // Half of the reflectivities would show: so much it costs that none does.
        let (x_m, nats) = end(&surfaces);
        assert!(x_m < 0.5 && nats < 5.0, "{x_m} {nats}");
        assert!(surfaces.drop_at(1.0) < 2.0);
        assert!(Staircase::nothing().ground_line(&surfaces).abs() < 1e-6);
    }

    #[test]
    fn lost_and_saturated_rows_give_finite_ratios() {
        let mut blank = PolarMap::new();
        blank.begin(&Config::default()).unwrap();
        let full = map(&Config::default(), |_, _| u8::MAX);
        let empty = map(&Config::default(), |_, _| 0);
        let finite = |surfaces: &Surfaces| {
            let all = surfaces
                .drop
                .iter()
                .chain(&surfaces.rise)
                .chain(&surfaces.bump);
            all.copied().all(f32::is_finite)
        };
        for map in [&blank, &*full, &*empty] {
            assert!(finite(&weighed(&chart(map))));
        }
        for (bias_rad, height_m) in [(f32::NAN, 0.0), (9.0, 0.0), (0.0, f32::NAN), (-9.0, 5.0)] {
            let chart = Chart {
                bend: Slope::LEVEL,
                bias_rad,
                height_m,
                ..chart(&full)
            };
            assert!(finite(&weighed(&chart)), "{bias_rad} {height_m}");
        }
    }

    #[test]
    fn drop_distance_is_compensated_for_the_chairs_travel() {
        let map = ground(1.15, 0.0..0.0, 15.0, None);
        let mut track = Track::new();
        track.begin(map.rows() as u16);
        for row in 0..map.rows() as u16 {
            let place = RowPose {
                time_s: 0.005 * f32::from(row),
                // All of the way is made behind the row that looks at the end of the ground.
                travel_m: if row < 220 { 0.0 } else { 0.2 },
                pitch_rad: 0.0,
            };
            track.add(row, place);
        }
        let config = Config::default();
        let drive = Drive {
            input: Input::Good,
            track: Some(&track),
            ..Drive::STANDING
        };
        let ride = MotionCompensation::of(&drive, &config.radar);
        let (x_m, nats) = end(&weighed(&Chart {
            bend: Slope::LEVEL,
            ride,
            ..chart(&map)
        }));
        assert!((x_m - 0.95).abs() < 0.06 && nats > 2.0, "{x_m} {nats}");
    }
}
