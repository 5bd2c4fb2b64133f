//! Whether processor, memory, clock and supply are fit to scan.

use crate::scanner::settings::{Settings, Switch};
use crate::verdict::{Reason, Reasons};

/// Why no scan may be made, if so: each of these holds until a reset, but for the internal oscillator, which
/// a setting allows.
pub(super) fn unfit(standing: Reasons, settings: &Settings) -> Option<Reason> {
    const FAULTS: [Reason; 4] = [
        Reason::ImageDamaged,
        Reason::MemoryDamaged,
        Reason::Supply,
        Reason::InternalClock,
    ];
    let allowed = settings.timing.internal_clock == Switch::On;
    let counts =
        |reason: Reason| standing.has(reason) && !(allowed && reason == Reason::InternalClock);
    FAULTS.into_iter().find(|&reason| counts(reason))
}

/// Why no answer may be `ok`.
pub(super) fn doubts(standing: Reasons) -> Reasons {
    match standing.has(Reason::ImageUnsealed) {
        true => Reasons::NONE.with(Reason::ImageUnsealed),
        false => Reasons::NONE,
    }
}
