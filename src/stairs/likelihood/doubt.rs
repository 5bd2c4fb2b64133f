//! How far an answer can be trusted: `ok` only when the winner is clear and every step rests on its
//! own echoes.

use crate::stairs::{Outcome, Reason, Status};

/// Another number of steps within this score of the winner is a close rival, nats: e² to one.
const CLEAR: f32 = 2.0;
/// A step whose strongest echo is weaker rests on little, dB.
const WEAK_DB: f32 = 8.0;
/// Without stairs, the strongest echo of the scene must be at least this much for the view to be
/// worth anything, dB.
const VIEW_DB: f32 = 10.0;
/// A height that is known no better than this is none to rely on, metres: two standard deviations
/// are what a wheelchair must never be surprised by.
const UNSURE: f32 = 0.015;
/// A step this far off the others' line is one that a foot stumbles over, metres …
const IRREGULAR: f32 = 0.013;
/// … if the echoes are this sure of it, standard deviations.
const SURE: f32 = 2.0;
/// Echoes stronger than this that stand where the flight leaves no room are in the way, dB.
const IN_THE_WAY_DB: f32 = 12.0;
/// So many of them are more than chance.
const IN_THE_WAY: usize = 3;

/// What is known of one step beside its dimensions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Support {
    /// Its strongest echo, dB above the noise; none for an inferred step.
    pub db: Option<f32>,
    /// How far its own echoes put it off the straight flight, metres.
    pub off: f32,
    /// Standard deviation of that.
    pub off_sigma: f32,
    /// The same along the line of sight, where echoes are sure to millimetres.
    pub off_along: f32,
}

impl Support {
    /// How much of the step was seen: its strongest echo, full marks from 40 dB on.
    pub fn quality(&self) -> u8 {
        self.db.map_or(0, |db| (2.5 * db).clamp(1.0, 100.0) as u8)
    }

    /// Whether the step departs from the others for sure.
    fn irregular(&self) -> bool {
        let high = self.off.abs() > IRREGULAR.max(SURE * self.off_sigma);
        high || self.off_along.abs() > IRREGULAR
    }
}

/// Adds `reason` and makes an `ok` outcome `degraded`.
pub fn degrade(outcome: &mut Outcome, reason: Reason) {
    outcome.status = Status::Degraded;
    outcome.reasons.add(reason);
}

/// Judges a flight: `lead` is the winner's score less that of the next best explanation, `against`
/// the strength of each echo that contradicts it, dB.
pub fn judge(
    outcome: &mut Outcome,
    lead: f32,
    supports: &[Support],
    against: impl Iterator<Item = f32>,
) {
    if lead < CLEAR {
        degrade(outcome, Reason::CloseRival);
    }
    let unsure = outcome.steps.iter().any(|s| s.height_sigma_m > UNSURE);
    if unsure || supports.iter().any(|s| s.db.is_none()) {
        degrade(outcome, Reason::InferredStep);
    }
    if supports.iter().any(|s| s.db.is_some_and(|db| db < WEAK_DB)) {
        degrade(outcome, Reason::WeakEchoes);
    }
    if supports.iter().any(Support::irregular) {
        degrade(outcome, Reason::IrregularStep);
    }
    if against.filter(|&db| db > IN_THE_WAY_DB).count() >= IN_THE_WAY {
        degrade(outcome, Reason::BlockedView);
    }
}

/// Judges the answer that there are no stairs: `rival` is the best flight's score less what it
/// takes to count, `strongest` the strongest echo, dB.
pub fn judge_none(outcome: &mut Outcome, rival: f32, strongest: f32) {
    if rival > -CLEAR {
        degrade(outcome, Reason::CloseRival);
    }
    if strongest < VIEW_DB {
        degrade(outcome, Reason::WeakEchoes);
    }
}
