//! What each step rests on, and what is weak about an answer: words for people and logs, which decide nothing
//! ([`crate::verdict`]).

use super::propose::scene::Mark;
use crate::answer::Step;
use crate::estimate::Estimate;
use crate::math;
use crate::params::Params;
use crate::verdict::{Reason, Reasons};

/// So many echoes that stand where a flight leaves no room are more than chance.
const IN_THE_WAY: usize = 3;
/// Full marks of a step's quality, per cent.
const FULL_QUALITY: f32 = 100.0;

/// What is known of one step beside its dimensions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Support {
    /// Its strongest echo, dB above the noise; none for an inferred step.
    pub snr_db: Option<f32>,
    /// How strong the next face would be at least, dB.
    pub next_db: f32,
    /// Whether it shows how far its nosing stands before its riser.
    pub overhang_seen: bool,
    /// Whether any step of the flight does.
    pub overhang_known: bool,
    /// How far its own echoes put it off the straight flight, metres.
    pub off: Estimate,
    /// The same along the line of sight, where echoes are sure to millimetres.
    pub off_along_m: f32,
}

impl Support {
    /// How much of the step was seen, per cent: by its strongest echo.
    pub fn quality(&self, p: &Params) -> u8 {
        let share = |db: f32| (FULL_QUALITY * db / p.full_quality_db).clamp(1.0, FULL_QUALITY);
        self.snr_db.map_or(0, |db| share(db) as u8)
    }

    /// Whether the step departs from the others for sure.
    fn irregular(&self, p: &Params) -> bool {
        let high = self.off.value.abs() > p.irregular_m.max(2.0 * self.off.sigma());
        high || self.off_along_m.abs() > p.irregular_m
    }
}

/// How strong a face behind one with these marks would be at least, dB; each mark comes with
/// whether it is a flash.
pub fn next_db<'m>(marks: impl Iterator<Item = (&'m Mark, bool)>, p: &Params) -> f32 {
    let left = marks.map(|(m, flash)| m.snr_db - if flash { p.flash_fades_db } else { p.fades_db });
    left.fold(f32::NEG_INFINITY, math::max)
}

/// Returns what is weak about a flight with these steps: `lead` says how much likelier it is than the next best outline,
/// nats; `against` are the echoes that contradict it.
pub fn judge<'m>(
    steps: &[Step],
    lead: f32,
    supports: &[Support],
    against: impl Iterator<Item = &'m Mark>,
    p: &Params,
) -> Reasons {
    let mut reasons = Reasons::NONE;
    if lead < p.clear_lead_nats {
        reasons.add(Reason::CloseRival);
    }
    for (k, (step, support)) in (1..).zip(steps.iter().zip(supports)) {
        let last = k == supports.len();
        if support.snr_db.is_none() || step.height_sigma_m > p.sure_height_m {
            reasons.add(Reason::InferredStep);
        }
        // Where the next step would be lost in the noise, nobody knows whether there is one.
        let fades = last && support.next_db < p.next_seen_db;
        if fades || support.snr_db.is_some_and(|db| db < p.weak_step_db) {
            reasons.add(Reason::WeakEchoes);
        }
        if support.irregular(p) {
            reasons.add(Reason::IrregularStep);
        }
    }
    if against.filter(|m| m.snr_db > p.in_the_way_db).count() >= IN_THE_WAY {
        reasons.add(Reason::BlockedView);
    }
    reasons
}

/// Returns what is weak about the answer that there are no stairs: `odds` are log-odds of the likeliest
/// stairs against that, nats; `strongest_db` the strongest echo.
pub fn judge_none(odds: f32, strongest_db: f32, p: &Params) -> Reasons {
    let mut reasons = Reasons::NONE;
    if odds > -p.clear_lead_nats {
        reasons.add(Reason::CloseRival);
    }
    if strongest_db < p.weak_step_db {
        reasons.add(Reason::WeakEchoes);
    }
    reasons
}
