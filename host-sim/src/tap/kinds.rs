//! Tells the guard's sweeps from full scans in the traffic of a radar link.
//!
//! The link transmits both in the same frames. They differ in their angles, which are settings of the scanner, and in
//! its sentences: `GUARD` follows a guard sweep, `SCAN` a full scan. The angles decide where the scanner has reported
//! its settings or the user has given them, else the sentences, else the angles by the default settings. What these
//! three leave open is not known.

use stairscan::config::{Plane, SweepConfig};
use stairscan::scanner::settings::GuardConfig;

use super::beside::Beside;
use super::mounting::Mounting;
use super::scans::Scan;
use super::sweep::{self, Sweep};
use crate::live::Ms;
use crate::setup::Kind;

/// Maximum delay of a `GUARD` sentence after its last row, ms: 5 ms (design contract), 6 ms on the wire, and a margin
/// for a busy host.
const WORD_MS: Ms = 100;

/// Returns the kind of a scan by its angles, `None` if they do not show it, and the schedule behind the angles, `None`
/// if they follow none. Without reported or given schedules the default ones are compared.
pub fn by_angles(scan: &Scan, mounting: &Mounting) -> (Option<Kind>, Option<Sweep>) {
    let plane = mounting.setup.plane;
    let angles: Vec<i32> = scan.rows.iter().map(|row| row.angle).collect();
    let whole =
        |known: SweepConfig, plane| sweep::follows(&known, &angles, plane).filter(Sweep::is_whole);
    let full = mounting.sweep.and_then(|known| whole(known, plane));
    // A guard sweep is in the depth plane only.
    let guard = mounting.guard.and_then(|known| whole(known, Plane::Depth));
    match (full, guard) {
        (Some(full), None) => return (Some(Kind::Scans), Some(full)),
        (None, Some(guard)) => return (Some(Kind::Guard), Some(guard)),
        (Some(full), Some(_)) => return (None, Some(full)),
        (None, None) => {}
    }
    let reported = (mounting.sweep)
        .and_then(|known| sweep::follows(&known, &angles, plane))
        .filter(Sweep::is_dense);
    let found = reported.or_else(|| sweep::schedule(&angles, plane));
    let usual = GuardConfig::default().sweep();
    let kind = if mounting.guard.is_some() || whole(SweepConfig::default(), plane).is_some() {
        Some(Kind::Scans)
    } else {
        whole(usual, Plane::Depth).map(|_| Kind::Guard)
    };
    (kind, found)
}

/// Returns the name of a scan of this kind.
pub fn name(kind: Kind) -> &'static str {
    match kind {
        Kind::Scans => "scan",
        Kind::Guard => "guard sweep",
    }
}

/// Returns the kind of the scans of a recording; `None` if it is not known. `by_angles` and `times` are those of the
/// recording, `mounting` that with which it was collected.
pub fn kind(
    (by_angles, times): (Option<Kind>, &[(Ms, Ms)]),
    mounting: &Mounting,
    beside: &Beside,
) -> Option<Kind> {
    let known = by_angles.filter(|_| mounting.guard.is_some());
    known.or_else(|| reported(times, beside)).or(by_angles)
}

/// Returns the kind of the scans of a recording by the sentences that followed them: the one of more of its scans;
/// `None` without sentences, or with equal numbers.
fn reported(times: &[(Ms, Ms)], beside: &Beside) -> Option<Kind> {
    let follows_guard = |&(first, last): &(Ms, Ms)| {
        // The sentence of the sweep before may arrive as late as this one's first rows.
        let due = first.midpoint(last)..=last + WORD_MS;
        let mut lines = beside.lines.iter();
        lines.any(|(at, line)| due.contains(at) && line.starts_with("$PSTR,GUARD,"))
    };
    let next = |k: usize| times.get(k + 1).map(|times| times.1);
    let follows_scan = |(k, times): &(usize, &(Ms, Ms))| beside.answer(times.1, next(*k)).is_some();
    let guard = times.iter().filter(|times| follows_guard(times)).count();
    let scans = times.iter().enumerate().filter(follows_scan).count();
    match guard.cmp(&scans) {
        std::cmp::Ordering::Greater => Some(Kind::Guard),
        std::cmp::Ordering::Less => Some(Kind::Scans),
        std::cmp::Ordering::Equal => None,
    }
}

/// Returns the note on recordings, by name, whose kind is not known and that are therefore stored as full scans; `None`
/// without one.
pub fn doubt(names: &[&str]) -> Option<String> {
    let words = |sweep: SweepConfig| {
        let degrees = |angle: i32| f64::from(angle) / 1000.0;
        let last = sweep.angle(sweep.angle_count.saturating_sub(1));
        let [first, last, step] = [sweep.first_angle, last, sweep.angle_step].map(degrees);
        format!("{first}:{last}:{step}")
    };
    let [scan, guard] = [SweepConfig::default(), GuardConfig::default().sweep()].map(words);
    (!names.is_empty()).then(|| {
        format!(
            "{}: stored as full scans, which the link does not tell from guard sweeps, and the angles are the defaults of \
             neither ({scan} and {guard}). If they are guard sweeps, add \"stairscan:mode\": \"guard\" to \"global\" of \
             .sigmf-meta; of another recording --report PORT shows the kind, or --guard FIRST:LAST:STEP with the guard's angles",
            names.join(", ")
        )
    })
}
