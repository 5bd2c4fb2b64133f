//! Proposal of stairs going down: levels of echoes, one below the other, taken for treads.
//!
//! In: the echoes of the height plane. Out: weighted hypotheses. Levels are grouped from the strongest echo down.
//! Chains of levels grow tread by tread (a beam search), and those whose echoes a staircase of these levels explains
//! best are kept. A tread without echoes may lie between two levels, or below the last. Each chain and each of its
//! beginnings is a hypothesis, weighted by [`crate::model::treads`].

use crate::infer::variants::Hypothesis;
use crate::math;
use crate::model::Staircase;
use crate::model::kinds::without_edges;
use crate::model::prior::prior;
use crate::model::treads::{Descending, MAX_TREADS, TreadAt, Treads};
use crate::params::descent::{
    ALIKE_M, BELOW_GROUND_M, FIRST_RISES_M, ROW_M, ROW_SIGMAS, SKIPPED_ALIKE_M,
};
use crate::signal::echoes::{Echo, MAX_ECHOES};
use crate::sort::shell_sort;
use heapless::Vec;

/// Maximum number of distinct heights at which echoes suggest a tread.
const LEVELS: usize = 16;
/// Beam width of the search: number of chains of treads that grow by one more tread at a time.
const GROWING: usize = 6;
/// Maximum number of chains of treads that are weighted as hypotheses, with all their beginnings.
const WEIGHED: usize = 6;
/// Candidate tread of stairs going down.
#[derive(Clone, Copy, Debug)]
struct LevelRow {
    /// Height of the tread, metres; negative below the ground.
    y_m: f32,
    /// Log-likelihood ratio of a tread at that height to none, nats.
    nats: f32,
}

/// Candidate treads of stairs going down, the highest first.
type LevelRows = Vec<LevelRow, LEVELS>;

/// Chain of treads one below the other, each as an index into [`LevelRows`]; [`UNSEEN`] stands for a tread without
/// echoes between two others.
#[derive(Clone, Debug, Default, PartialEq)]
struct LevelChain {
    rows: Vec<u8, MAX_TREADS>,
    /// Height above the ground of the chain's lowest tread, metres; negative, and 0 for an empty chain.
    last_m: f32,
    /// Sum of the log-likelihood ratios of the chain's treads to none, nats.
    nats: f32,
}

/// Index in a chain of treads that stands for a tread without echoes.
const UNSEEN: u8 = u8::MAX;
const _: () = assert!(LEVELS < UNSEEN as usize);

impl LevelChain {
    /// Returns the mean rise of the chain's treads, metres; none without treads.
    fn rise_m(&self) -> Option<f32> {
        let count = self.rows.len();
        (count > 0).then(|| -self.last_m / count as f32)
    }

    /// Returns the chain with one more tread, index `row` in the list of candidates, directly below the last one or with a tread without echoes between. Returns `None` for rises that stairs
    /// do not have.
    fn with(&self, row: usize, LevelRow { y_m, nats }: LevelRow) -> Option<Self> {
        let rise_m = self.last_m - y_m;
        let skipped = match self.rise_m() {
            None if FIRST_RISES_M.contains(&rise_m) => false,
            None if FIRST_RISES_M.contains(&(0.5 * rise_m)) => true,
            Some(usual_m) if (rise_m - usual_m).abs() < ALIKE_M => false,
            Some(usual_m) if (rise_m - 2.0 * usual_m).abs() < SKIPPED_ALIKE_M => true,
            _ => return None,
        };
        let mut out = self.clone();
        if skipped {
            out.rows.push(UNSEEN).ok()?;
        }
        out.rows.push(row as u8).ok()?;
        out.last_m = y_m;
        out.nats += nats;
        Some(out)
    }

    /// Returns the treads of the chain, from the top down, and below the last one more without echoes, at the mean
    /// rise.
    fn treads(&self, levels: &LevelRows) -> Treads {
        let mut treads = Treads::new();
        let level = |row: u8| levels.get(usize::from(row)).map(|level| level.y_m);
        let mut before_m = 0.0;
        for (k, &row) in self.rows.iter().enumerate() {
            let next = self.rows.get(k + 1).and_then(|row| level(*row));
            let y_m = level(row).or(next.map(|next_m| 0.5 * (before_m + next_m)));
            before_m = y_m.unwrap_or(before_m);
            // Cannot fail: a chain has no more rows than there is room for.
            let _ = treads.push(TreadAt {
                y_m: before_m,
                has_echoes: row != UNSEEN,
            });
        }
        if let Some(rise_m) = self.rise_m() {
            // Left out where there is no room.
            let _ = treads.push(TreadAt {
                y_m: self.last_m - rise_m,
                has_echoes: false,
            });
        }
        treads
    }
}

/// Adds a chain to a list of the best chains; in a full list, it replaces the worst one if it is better.
fn offer<const N: usize>(best: &mut Vec<LevelChain, N>, chain: LevelChain) {
    let Err(chain) = best.push(chain) else { return };
    let worst = best.iter_mut().min_by(|a, b| a.nats.total_cmp(&b.nats));
    if let Some(worst) = worst
        && worst.nats < chain.nats
    {
        *worst = chain;
    }
}

/// Returns the heights at which echoes suggest treads below the ground, metres, negative, each with the log-likelihood
/// ratio of a tread there to none, nats; the highest first.
#[inline(never)]
fn levels(model: &Descending, echoes: &[Echo]) -> LevelRows {
    let mut taken = [false; MAX_ECHOES];
    let mut levels = LevelRows::new();
    for centre in echoes {
        let row_m = math::max(
            ROW_M,
            ROW_SIGMAS * math::sqrt(model.height_variance(centre)),
        );
        let near = |e: &Echo| (e.y_m - centre.y_m).abs() < row_m;
        let of = echoes.iter().zip(&mut taken).filter(|(e, _)| near(e));
        let (mut weight, mut sum, mut fresh) = (0.0, 0.0, true);
        for (e, taken) in of {
            // The strongest echoes come first.
            fresh &= !(core::ptr::eq(e, centre) && *taken);
            *taken = true;
            let w = 1.0 / model.height_variance(e);
            weight += w;
            sum += w * e.y_m;
        }
        if fresh && centre.y_m < -BELOW_GROUND_M {
            let y_m = sum / weight;
            // A level that finds no room is weaker than all others.
            let _ = levels.push(LevelRow {
                y_m,
                nats: model.unlimited_tread_llr(y_m),
            });
        }
    }
    shell_sort(&mut levels, |a, b| a.y_m > b.y_m);
    levels
}

/// Returns the chains of treads with the largest sums of log-likelihood ratios, sorted by the indices of their treads
/// in `levels`, the candidate treads, the highest first.
#[inline(never)]
fn chains(levels: &LevelRows) -> Vec<LevelChain, WEIGHED> {
    let mut best = Vec::new();
    let mut now: Vec<LevelChain, GROWING> = Vec::new();
    let mut next = Vec::new();
    let _ = now.push(LevelChain::default());
    while !now.is_empty() {
        next.clear();
        for chain in &now {
            let below = levels.iter().enumerate();
            let below = below.filter(|(_, level)| level.y_m < chain.last_m);
            for grown in below.filter_map(|(row, level)| chain.with(row, *level)) {
                offer(&mut next, grown.clone());
                offer(&mut best, grown);
            }
        }
        core::mem::swap(&mut now, &mut next);
    }
    // Neighbours share their first levels, whose edges are then evaluated once.
    shell_sort(&mut best, |a, b| a.rows < b.rows);
    best
}

/// Calls `each` with every hypothesis and its weight: chains of levels with their beginnings and one more tread,
/// ground without stairs, and the likeliest ramp.
#[inline(never)]
pub fn propose(model: &mut Descending, echoes: &[Echo], each: &mut dyn FnMut(Hypothesis)) {
    let levels = levels(model, echoes);
    let chains = chains(&levels);
    let mut before: &[u8] = &[];
    for chain in &chains {
        let treads = chain.treads(&levels);
        model.evaluate(&treads);
        let known = before.iter().zip(&chain.rows);
        let known = known.take_while(|(a, b)| a == b).count();
        before = &chain.rows;
        for count in known + 1..=treads.len() {
            let weighed = model.weigh(count);
            let treads = treads.iter().take(count).enumerate();
            let edges = treads.map(|(k, t)| (weighed.edge_m + k as f32 * weighed.going_m, t.y_m));
            each(Hypothesis::weighed(
                Staircase::descent(edges),
                weighed.log_weight,
            ));
        }
    }
    model.evaluate(&[]);
    let ground = model.weigh(0).log_weight;
    each(Hypothesis::weighed(Staircase::nothing(), ground));
    let level = prior(&Staircase::nothing());
    let mut best: Option<Hypothesis> = None;
    for kind in without_edges() {
        let s = Staircase::of(kind);
        let log_weight = model.ground(kind) + prior(&s) - level;
        let new = Hypothesis::weighed(s, log_weight);
        best = Some(best.map_or(new, |best| best.likelier(new)));
    }
    if let Some(best) = best {
        each(best);
    }
}
