//! Evidence for each step, and the reasons that an answer is uncertain. They are information for people and logs, and
//! decide nothing ([`crate::verdict`]).

use super::propose::scene::Mark;
use crate::answer::Step;
use crate::estimate::Estimate;
use crate::math;
use crate::params::Params;
use crate::params::posterior::MIN_CONTRADICTING_ECHOES;
use crate::verdict::{Reason, Reasons};

/// Maximum quality of a step, per cent.
const FULL_QUALITY: f32 = 100.0;

/// Evidence for one step besides its dimensions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Support {
    /// SNR of the step's strongest echo, dB; `None` for an inferred step.
    pub snr_db: Option<f32>,
    /// SNR that a further riser behind this step would have at least, dB.
    pub next_db: f32,
    /// Whether nosing and riser of this step have separate echoes.
    pub overhang_seen: bool,
    /// Whether nosing and riser of any step of the flight have separate echoes.
    pub overhang_known: bool,
    /// Deviation of the height of the step's tread from a flight of equal rises, by the step's own echoes, times the
    /// probability that its riser or tread is irregular, metres.
    pub off: Estimate,
    /// Deviation of the step's place along the line of sight from that in a flight of equal goings, metres. Echoes
    /// measure it to millimetres.
    pub off_along_m: f32,
}

impl Support {
    /// Returns the detection quality of the step from its strongest echo, per cent; 0 without an echo.
    pub fn quality(&self, p: &Params) -> u8 {
        let share = |db: f32| (FULL_QUALITY * db / p.full_quality_db).clamp(1.0, FULL_QUALITY);
        self.snr_db.map_or(0, |db| share(db) as u8)
    }

    /// Whether the step's height or place clearly deviates from a flight of equal rises and goings.
    fn irregular(&self, p: &Params) -> bool {
        let high = self.off.value.abs() > p.irregular_m.max(2.0 * self.off.sigma());
        high || self.off_along_m.abs() > p.irregular_m
    }
}

/// Returns the SNR, dB, that a further riser or tread would have at least behind one with these marks (echoes in the
/// search): that of the strongest mark, less a fixed loss. Each mark comes with whether it is a flash.
pub fn next_db<'m>(marks: impl Iterator<Item = (&'m Mark, bool)>, p: &Params) -> f32 {
    let left = marks.map(|(m, flash)| m.snr_db - if flash { p.flash_fades_db } else { p.fades_db });
    left.fold(f32::NEG_INFINITY, math::max)
}

/// Returns the reasons that a flight with these steps is uncertain. `lead` is the margin over the runner-up outline,
/// nats; `against` are the echoes that contradict the flight.
pub fn reasons<'m>(
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
        // A next step that would be lost in the noise cannot be excluded.
        let fades = last && support.next_db < p.next_seen_db;
        if fades || support.snr_db.is_some_and(|db| db < p.weak_step_db) {
            reasons.add(Reason::WeakEchoes);
        }
        if support.irregular(p) {
            reasons.add(Reason::IrregularStep);
        }
    }
    if against.filter(|m| m.snr_db > p.in_the_way_db).count() >= MIN_CONTRADICTING_ECHOES {
        reasons.add(Reason::BlockedView);
    }
    reasons
}

/// Returns the reasons that an answer without stairs is uncertain. `odds` are the log-odds of the likeliest stairs
/// against ground without stairs, nats; `strongest_db` is the SNR of the strongest echo, dB.
pub fn reasons_without_steps(odds: f32, strongest_db: f32, p: &Params) -> Reasons {
    let mut reasons = Reasons::NONE;
    if odds > -p.clear_lead_nats {
        reasons.add(Reason::CloseRival);
    }
    if strongest_db < p.weak_step_db {
        reasons.add(Reason::WeakEchoes);
    }
    reasons
}
