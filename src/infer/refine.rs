//! Refinement of a hypothesis: its levels are fitted by the Gaussian mixture over regular and irregular flights, its
//! places and its overhang are set to those of the echoes.

use super::gauss::{self, TreadLevels};
use super::readings::Readings;
use crate::estimate::Estimate;
use crate::math;
use crate::model::{Model, Staircase};
use crate::params::Params;

/// Number of rounds, each of which assigns echoes to features and fits the treads' heights. There is more than one,
/// since the assignment depends on the heights.
const ROUNDS: usize = 2;

/// Results of a refinement.
#[derive(Clone, Debug, Default)]
pub struct Refinement {
    /// Heights of the treads.
    pub levels: TreadLevels,
    /// Measurements of each riser from its own echoes, of the last round.
    pub readings: Readings,
}

/// Fits heights of treads, distances of risers and overhang of a hypothesis to its echoes, writes them to `s`, and the
/// heights with their standard deviations, and the measurements of the last round, to `out`. `rise` is the riser height as
/// known apart from these echoes, metres.
#[inline(never)]
pub fn refine(
    model: &Model<'_>,
    s: &mut Staircase,
    rise: Estimate,
    p: &Params,
    out: &mut Refinement,
) {
    let Refinement { levels, readings } = out;
    for _ in 0..ROUNDS {
        model.readings(s, readings);
        place(s, readings);
        let steps = readings.faces.iter().map(|face| face.level);
        let mut known = readings.rise;
        known.add(rise);
        gauss::fit(steps, known.mean(), p, levels);
        let n = s.len();
        for (top, level) in s.top_m.iter_mut().zip(levels.iter()).take(n) {
            *top = level.height.value;
        }
    }
}

/// Sets the risers' distances and the overhang of `s` to those of their echoes; without an echo they stay.
fn place(s: &mut Staircase, readings: &Readings) {
    let (mut overhang_m, mut overhangs) = (0.0, 0.0);
    for (place, face) in s.x_m.iter_mut().zip(&readings.faces) {
        if let (Some(foot), Some(edge)) = (face.foot_m, face.edge_m) {
            overhang_m += math::max(foot - edge, 0.0);
            overhangs += 1.0;
        }
        let before_m = if s.open { 0.0 } else { s.overhang_m };
        let riser = face.foot_m.or(face.edge_m.map(|x| x + before_m));
        *place = riser.unwrap_or(*place);
    }
    if overhangs > 0.0 && !s.open {
        s.overhang_m = overhang_m / overhangs;
    }
}
