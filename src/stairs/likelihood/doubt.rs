//! How far an answer can be trusted: `ok` only when the winner is clear and every step rests on its
//! own echoes.

use super::evidence::Mark;
use crate::math;
use crate::stairs::{Outcome, Reason, Status};

/// Another number of steps within this score of the winner is a close rival, nats: e² to one.
const CLEAR: f32 = 2.0;
/// A step whose strongest echo is weaker rests on little, dB.
const WEAK_DB: f32 = 8.0;
/// Weaker than this a further step would not have been seen, dB.
const SEEN_DB: f32 = 5.0;
/// From one face to the next the echoes get weaker by as much, dB …
const FADES_DB: f32 = 6.0;
/// … and by as much from one that looks straight at the mirror.
const FLASH_FADES_DB: f32 = 25.0;
/// Without stairs, the strongest echo of the scene must be at least this much for the view to be
/// worth anything, dB.
const VIEW_DB: f32 = 10.0;
/// A height that is known no better than this is none to rely on, metres: two standard deviations
/// are what a wheelchair must never be surprised by.
const UNSURE: f32 = 0.015;
/// A last riser that looks straight at the mirror hides its edge by its flash: if all steps before
/// it were measured and none seems to be odd, the flight's regularity may stand in for that one
/// edge, to this.
const UNSURE_LAST: f32 = 0.025;
/// A step whose expected departure is larger may be odd, metres: a tenth of what an odd one shows.
const REGULAR: f32 = 0.002;
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
    /// How strong the next face would be at least, dB.
    pub next_db: f32,
    /// Whether it shows its face, and the flash of that hides its edge.
    pub flashes: bool,
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

/// How strong a face behind one with these marks would be at least, dB.
pub fn next_db(marks: &[Mark], is_flash: impl Fn(&Mark) -> bool) -> f32 {
    let fades = |m: &Mark| {
        if is_flash(m) {
            FLASH_FADES_DB
        } else {
            FADES_DB
        }
    };
    let left = marks.iter().map(|m| m.db - fades(m));
    left.fold(f32::NEG_INFINITY, math::max)
}

/// Adds `reason` and makes an `ok` outcome `degraded`.
pub fn degrade(outcome: &mut Outcome, reason: Reason) {
    outcome.status = Status::Degraded;
    outcome.reasons.add(reason);
}

/// Whether an echo that contradicts the flight is too strong for chance.
pub fn in_the_way(mark: &Mark) -> bool {
    mark.db > IN_THE_WAY_DB
}

/// Judges a flight: `lead` is the winner's score less that of the next best explanation, `against`
/// the number of echoes that contradict it and are [`in_the_way`].
#[inline(never)]
pub fn judge(outcome: &mut Outcome, lead: f32, supports: &[Support], against: usize) {
    let mut reasons = outcome.reasons;
    if lead < CLEAR {
        reasons.add(Reason::CloseRival);
    }
    let regular = supports.iter().all(|s| s.off.abs() < REGULAR);
    for (k, (step, support)) in (1..).zip(outcome.steps.iter().zip(supports)) {
        let last = k == supports.len();
        let flash = last && k > 1 && support.flashes && regular;
        let known = if flash { UNSURE_LAST } else { UNSURE };
        if support.db.is_none() || step.height_sigma_m > known {
            reasons.add(Reason::InferredStep);
        }
        // Where the next step would be lost in the noise, nobody knows whether there is one.
        let fades = last && support.next_db < SEEN_DB;
        if fades || support.db.is_some_and(|db| db < WEAK_DB) {
            reasons.add(Reason::WeakEchoes);
        }
        if support.irregular() {
            reasons.add(Reason::IrregularStep);
        }
    }
    if against >= IN_THE_WAY {
        reasons.add(Reason::BlockedView);
    }
    outcome.reasons = reasons;
    if !reasons.is_empty() {
        outcome.status = Status::Degraded;
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
