//! The Gaussian over a hypothesis's continuous part, updated analytically: given which echo is which
//! feature, levels are linear in riser height and each step's departure from it.

use super::feature::Class;
use super::model::Model;
use super::staircase::{MAX_STEPS, Sigmas, Staircase};
use crate::math;

/// Each step departs from a regular flight by this much, metres.
const DEPARTS_M: f32 = 0.005;
/// The riser height is known before by this much, metres.
const RISE_SIGMA_M: f32 = 0.02;
/// Rounds: which echo is which feature depends on the levels.
const ROUNDS: usize = 2;

/// Weighted sum of readings of one level.
#[derive(Clone, Copy, Default)]
struct LevelSum {
    weight: f32,
    sum: f32,
}

impl LevelSum {
    fn add(&mut self, value: f32, sigma_m: f32) {
        let weight = 1.0 / (sigma_m * sigma_m);
        self.weight += weight;
        self.sum += weight * value;
    }
}

/// The hypothesis with its levels, places and overhang moved to where the echoes put them, and the
/// levels' standard deviations.
#[inline(never)]
pub fn refine(model: &Model<'_>, start: &Staircase) -> (Staircase, Sigmas) {
    let mut s = *start;
    let mut sigmas = [RISE_SIGMA_M; MAX_STEPS];
    let rise_m = start.rise();
    for _ in 0..ROUNDS {
        let mut levels = [LevelSum::default(); MAX_STEPS];
        let (mut overhang, mut overhangs) = (0.0, 0.0);
        for k in 0..s.len() {
            let mut x = (None, None);
            model.features(&s, k, |class, best| {
                let at = match class {
                    Class::Corner => k.checked_sub(1),
                    Class::Flash | Class::Hidden => None,
                    _ => Some(k),
                };
                if let Some(place) = at.and_then(|k| levels.get_mut(k)) {
                    place.add(best.level_m, best.sigma_m);
                }
                match class {
                    Class::Corner | Class::Flash | Class::Hidden => x.0 = x.0.or(Some(best.x_m)),
                    _ => x.1 = Some(best.x_m),
                }
            });
            if let (Some(riser), Some(nosing)) = x {
                overhang += math::max(riser - nosing, 0.0);
                overhangs += 1.0;
            }
            let riser =
                x.0.or(x.1.map(|x| if s.open { x } else { x + s.overhang_m }));
            if let (Some(place), Some(x)) = (s.x_m.get_mut(k), riser) {
                *place = x;
            }
        }
        if overhangs > 0.0 && !s.open {
            s.overhang_m = overhang / overhangs;
        }
        regular(&mut s, &mut sigmas, &levels, rise_m);
    }
    (s, sigmas)
}

/// Levels by the readings and the flight's regularity.
fn regular(s: &mut Staircase, sigmas: &mut Sigmas, levels: &[LevelSum; MAX_STEPS], rise_m: f32) {
    let own = DEPARTS_M * DEPARTS_M;
    let known = 1.0 / (RISE_SIGMA_M * RISE_SIGMA_M);
    let (mut weight, mut sum) = (known, known * rise_m);
    let n = s.len();
    for (k, level) in (1u8..).map(f32::from).zip(levels.iter().take(n)) {
        if level.weight > 0.0 {
            let w = 1.0 / (1.0 / level.weight + own);
            weight += w * k * k;
            sum += w * k * level.sum / level.weight;
        }
    }
    let rise = sum / weight;
    let places = s.top_m.iter_mut().zip(sigmas).zip(levels).take(n);
    for (k, ((top, sigma), level)) in (1u8..).map(f32::from).zip(places) {
        let share = own * level.weight / (1.0 + own * level.weight);
        let reading = if level.weight > 0.0 {
            level.sum / level.weight
        } else {
            0.0
        };
        *top = (1.0 - share) * k * rise + share * reading;
        let rest = (1.0 - share) * k;
        *sigma = math::sqrt((1.0 - share) * own + rest * rest / weight);
    }
}
