//! Checks of everything that the scanner reports, against the simulated time and the plan.
//!
//! In: lines with the time of their last byte, and the disturbances of the plan. Out: failed checks, each with day,
//! time and sentence, and the counts and gaps of the summary.

use stairscan::report::{GuardLine, LiveLine, ScanLine, Sentence};
use stairscan::verdict::{Reason, Reasons, Status};

use super::gaps::{Gap, Instant};

/// Longest permitted gap between two `LIVE` sentences, µs: without one for half a second a scanner counts as dead
/// (docs/user/report.md).
const LIVE_GAP_US: u64 = 500_000;
/// Longest permitted delay from the uptime or age that a `LIVE` sentence states to its last byte, µs: a report of some
/// sentences and an answer's time.
const LIVE_LATE_US: u64 = 300_000;
/// Rounding of the times in `LIVE`, µs: whole milliseconds, of two counters.
const ROUNDING_US: u64 = 2_000;
/// Longest gap between two guard sweeps, µs: the default `guard-rate` of 7 a second, and a fifth more for sentences
/// and result.
const SWEEP_GAP_US: u64 = 1_200_000 / 7;
/// Longest permitted time from the end of a fault's cause to the first answer, µs, by default settings: `fault-hold` 2
/// s, the self-test's time limit for homing 7 s, a query of the module 0.2 s, and a scan that stops at every angle 4 s
/// (docs/generated/benchmarks.md).
const RECOVERY_US: u64 = 13_200_000;
/// Time after a disturbance within which `LIVE`'s error counters may still grow, µs: timeouts of chirps and motion
/// sentences, and `LIVE`'s period.
const ECHO_US: u64 = 3_000_000;
/// Maximum number of failed checks whose texts are kept; further ones are only counted.
const KEPT: usize = 100;
/// Time after a full scan within which guard sweeps may report its hazard (reason `ScanNearer`), µs: 5 s
/// (docs/design/guard.md) and a sentence's delay.
const SCAN_COUNTS_US: u64 = 5_500_000;

/// State of the motion input that a `LIVE` sentence is expected to report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExpectedInput {
    /// Good: at least two sentences in order, the last one recent.
    Good,
    /// Not good: the last sentence is too old.
    Stale,
    /// Either: between two sentences after a disturbance.
    Any,
}

/// Numbers of sentences and planned faults in a run.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    /// Number of reported scans.
    pub scans: u64,
    /// Number of reported guard sweeps.
    pub sweeps: u64,
    /// Number of `LIVE` sentences.
    pub live: u64,
    /// Number of all sentences.
    pub sentences: u64,
    /// Number of planned faults.
    pub faults: u64,
    /// Number of planned faults after which the scanner answered again by itself.
    pub recovered: u64,
}

/// Error counters of the last `LIVE` sentence, which count since boot.
#[derive(Clone, Copy, Debug, Default)]
struct Counters {
    motion_faults: u16,
    refused: u16,
    link_errors: u16,
}

/// A planned fault.
#[derive(Clone, Copy, Debug)]
struct Fault {
    /// Time at which the fault's cause has ended; `None` while it lasts.
    cleared: Option<Instant>,
    /// Whether a scan or guard sweep has reported the fault; results without a fault before that are older than the
    /// fault.
    reported: bool,
}

/// Checks of the scanner's sentences, with the failed ones and the statistics of the run.
#[derive(Debug, Default)]
pub struct Watch {
    /// Texts of the first hundred failed checks, in order.
    pub failures: Vec<String>,
    /// Number of failed checks beyond those in `failures`.
    pub dropped: u64,
    /// Numbers of sentences and planned faults in the run.
    pub counts: Counts,
    /// Largest gap between two `LIVE` sentences.
    pub live_gap: Gap,
    /// Largest gap between two guard sweeps that no scan, command or fault separates.
    pub sweep_gap: Gap,
    /// Longest time from the end of a fault's cause to the next answer.
    pub recovery: Gap,
    /// Lines received that are replies to commands or boot sentences, in order, for the plan to read.
    pub replies: Vec<String>,
    booted: u64,
    last_live: Option<Instant>,
    last_sweep: Option<Instant>,
    last_scan: Option<u64>,
    counters: Counters,
    scan: u32,
    /// Number of scans since the last reported one that a command may have ended without a report; as many scan numbers
    /// may be missing.
    unreported: u32,
    sweep: u32,
    /// Whether the guard may have been switched on since its last sweep, so that sweep number 1 may follow.
    anew: bool,
    /// Number of sentences of the last reported scan that are still to come.
    following: u8,
    fault: Option<Fault>,
    /// Time from which on gaps between guard sweeps are checked, µs of the run: no listing of settings delays them.
    steady_from: u64,
    /// Times, µs of the run, up to which the counts of link errors, motion faults and refused lines may grow, and up to
    /// which `LIVE` may be missing.
    link_until: u64,
    motion_until: u64,
    lines_until: u64,
    silent_until: u64,
}

impl Watch {
    /// Adds a failed check.
    pub fn fail(&mut self, at: Instant, message: &str, line: &str) {
        if self.failures.len() < KEPT {
            self.failures.push(format!("{at}: {message}: {line}"));
        } else {
            self.dropped += 1;
        }
    }

    /// Resets what is expected of sentence numbers and counters, after a reset of the scanner at `now`.
    pub fn boot(&mut self, now: Instant) {
        self.booted = now.at;
        self.last_live = Some(now);
        self.last_sweep = None;
        self.last_scan = None;
        self.counters = Counters::default();
        (self.scan, self.sweep, self.unreported) = (0, 0, 0);
        (self.anew, self.following) = (true, 0);
        self.fault = None;
        self.motion_disturbed(now.at);
    }

    /// Notes that a command has ended the present scan or sweep.
    pub fn ends_scan(&mut self) {
        self.unreported += 1;
        self.following = 0;
        self.guard_anew();
    }

    /// Announces that the guard is switched on or off: its sweep number may begin at 1, and the gap to the next sweep
    /// is not checked.
    pub fn guard_anew(&mut self) {
        (self.anew, self.last_sweep) = (true, None);
    }

    /// Announces a pause between guard sweeps: a full scan, or another command.
    pub fn pauses_sweeps(&mut self) {
        self.last_sweep = None;
    }

    /// Announces a listing of all settings up to `until`, which other sentences wait for.
    pub fn listing_until(&mut self, until: u64) {
        self.steady_from = until;
    }

    /// Announces that the plan's fault of the hardware begins.
    pub fn fault_begins(&mut self) {
        self.counts.faults += 1;
        self.fault = Some(Fault {
            cleared: None,
            reported: false,
        });
        self.link_until = u64::MAX;
    }

    /// Announces that the cause of the planned fault has ended.
    pub fn fault_ends(&mut self, now: Instant) {
        if let Some(fault) = &mut self.fault {
            fault.cleared = Some(now);
        }
        self.link_until = now.at + ECHO_US;
    }

    /// Whether a planned fault has begun and no answer has come since its cause ended.
    pub fn is_faulty(&self) -> bool {
        self.fault.is_some()
    }

    /// Announces that single chirps are lost from `now` on.
    pub fn chirps_lost(&mut self, now: u64) {
        self.link_until = self.link_until.max(now + ECHO_US);
    }

    /// Announces that motion sentences end or come again.
    pub fn motion_sends(&mut self, now: u64, on: bool) {
        self.motion_until = if on { now + ECHO_US } else { u64::MAX };
    }

    /// Announces that motion sentences are missing up to `until`.
    pub fn motion_disturbed(&mut self, until: u64) {
        self.motion_until = self.motion_until.max(until.saturating_add(ECHO_US));
    }

    /// Announces that the scanner gets a line that it must refuse.
    pub fn line_refused(&mut self, now: u64) {
        self.lines_until = now + ECHO_US;
    }

    /// Announces that the loop was blocked up to `now` for an erasure.
    pub fn blocked(&mut self, now: Instant) {
        self.silent_until = now.at + LIVE_GAP_US;
        self.motion_disturbed(now.at);
    }

    /// Checks the times of sentences that must come without a command: `LIVE`, and the first answer after a fault.
    pub fn pass(&mut self, now: Instant) {
        let live = self.last_live.map_or(0, |last| last.at);
        if now.at > live + LIVE_GAP_US && now.at > self.silent_until {
            self.fail(now, "no LIVE for half a second", "none");
            self.last_live = Some(now);
        }
        if let Some(Fault {
            cleared: Some(cleared),
            ..
        }) = self.fault
            && now.at > cleared.at + RECOVERY_US
        {
            self.fail(now, "no answer after the fault has ended", "none");
            self.fault = None;
        }
    }

    /// Checks one line that the scanner has sent. `input` returns the expected state of the motion input at a time
    /// since boot, µs; `answered` is the time of the last answer.
    pub fn hear(
        &mut self,
        now: Instant,
        line: &str,
        answered: Option<u64>,
        input: impl Fn(u64) -> ExpectedInput,
    ) {
        self.counts.sentences += 1;
        let sentence = match Sentence::parse(line) {
            Ok(sentence) => sentence,
            Err(error) => return self.fail(now, &error.to_string(), line),
        };
        match sentence {
            Sentence::Live(live) => {
                if let Err(message) = self.live(now, &live, answered, input) {
                    self.fail(now, &message, line);
                }
            }
            Sentence::Scan(scan) => self.scan(now, &scan, line),
            Sentence::Guard(guard) => self.guard(now, &guard, line),
            Sentence::Step(step) => self.follows(now, step.scan, line),
            Sentence::Drop(drop) => self.follows(now, drop.scan, line),
            Sentence::Maybe(maybe) => self.follows(now, maybe.scan, line),
            _ => self.replies.push(line.to_owned()),
        }
    }

    fn live(
        &mut self,
        now: Instant,
        live: &LiveLine<'_>,
        answered: Option<u64>,
        input: impl Fn(u64) -> ExpectedInput,
    ) -> Result<(), String> {
        self.counts.live += 1;
        if let Some(last) = self.last_live.replace(now)
            && now.at > self.silent_until
        {
            self.live_gap.add(last, now);
        }
        let queued = u64::from(live.uptime_ms) * 1_000;
        let elapsed = now.at - self.booted;
        if queued > elapsed || queued + LIVE_LATE_US < elapsed {
            return Err(format!("uptime is not {} ms", elapsed / 1_000));
        }
        let age = answered.map(|at| (now.at - at) / 1_000);
        let late_ms = (LIVE_LATE_US + ROUNDING_US) / 1_000;
        let right = match (age, live.age_ms.map(u64::from)) {
            (None, None) => true,
            (Some(age), Some(reported)) => reported <= age && reported + late_ms >= age,
            // The answer was given, and this sentence was queued before it.
            (Some(age), None) => age <= late_ms,
            (None, Some(_)) => false,
        };
        // The sentence may have been queued before the newest answer.
        if !right && age.is_none_or(|age| age > late_ms) {
            return Err(format!("age is not {age:?} ms"));
        }
        if live.scan != self.scan && live.scan.wrapping_sub(self.scan) > 1 + self.unreported {
            return Err(format!("scan is neither {} nor the next", self.scan));
        }
        match (input(queued), live.motion) {
            (ExpectedInput::Good, "good") | (ExpectedInput::Any, _) => {}
            (ExpectedInput::Stale, state) if state != "good" => {}
            (expected, _) => return Err(format!("motion input is {expected:?}")),
        }
        self.counters(now.at, live)
    }

    /// Checks the error counters since boot in a `LIVE` sentence: they never fall, and grow only after an announced
    /// disturbance.
    fn counters(&mut self, now: u64, live: &LiveLine<'_>) -> Result<(), String> {
        let counters = Counters {
            motion_faults: live.motion_faults,
            refused: live.refused,
            link_errors: live.link_errors,
        };
        let before = std::mem::replace(&mut self.counters, counters);
        for (name, was, is, until) in [
            (
                "faults of the motion input",
                before.motion_faults,
                live.motion_faults,
                self.motion_until,
            ),
            (
                "refused lines",
                before.refused,
                live.refused,
                self.lines_until,
            ),
            (
                "link errors",
                before.link_errors,
                live.link_errors,
                self.link_until,
            ),
            ("port errors", 0, live.port_errors, 0),
        ] {
            if is < was || (is > was && now > until) {
                return Err(format!("{name} from {was} to {is}"));
            }
        }
        Ok(())
    }

    fn scan(&mut self, now: Instant, scan: &ScanLine, line: &str) {
        if self.following > 0 {
            self.fail(now, "within another scan", line);
        }
        self.following = scan.following();
        self.last_sweep = None;
        if !self.result(now, scan.status, scan.reasons) {
            self.fail(now, "a fault that was not planned", line);
        }
        // Number 0 is a failed self-test.
        if scan.scan == 0 {
            return;
        }
        self.counts.scans += 1;
        let step = scan.scan.wrapping_sub(self.scan);
        if step == 0 || step > 1 + self.unreported {
            let message = format!("{} does not follow scan {}", scan.scan, self.scan);
            self.fail(now, &message, line);
        }
        (self.scan, self.unreported) = (scan.scan, 0);
        if scan.status != Status::Fault {
            self.last_scan = Some(now.at);
        }
    }

    fn follows(&mut self, now: Instant, scan: u32, line: &str) {
        match self.following.checked_sub(1) {
            Some(rest) if scan == self.scan => self.following = rest,
            _ => self.fail(now, "belongs to no scan", line),
        }
    }

    fn guard(&mut self, now: Instant, guard: &GuardLine, line: &str) {
        self.counts.sweeps += 1;
        let next = guard.sweep == self.sweep.wrapping_add(1);
        let first = self.anew && guard.sweep == 1;
        if !next && !first {
            let message = format!("does not follow guard sweep {}", self.sweep);
            self.fail(now, &message, line);
        }
        (self.sweep, self.anew) = (guard.sweep, self.anew && guard.sweep != 1);
        if !self.result(now, guard.status, guard.reasons) {
            self.fail(now, "a fault that was not planned", line);
        }
        let scanned = self
            .last_scan
            .is_some_and(|at| now.at < at + SCAN_COUNTS_US);
        if guard.reasons.has(Reason::ScanNearer) && !scanned {
            self.fail(now, "no recent scan", line);
        }
        if guard.status == Status::Fault {
            self.last_sweep = None;
            return;
        }
        if let Some(last) = self.last_sweep.replace(now)
            && last.at >= self.steady_from
        {
            self.sweep_gap.add(last, now);
            if now.at - last.at > SWEEP_GAP_US {
                let message = format!("{} ms after the one before", (now.at - last.at) / 1_000);
                self.fail(now, &message, line);
            }
        }
    }

    /// Evaluates status and reasons of a scan or guard sweep against the planned fault; returns `false` for a fault
    /// that was not planned.
    fn result(&mut self, now: Instant, status: Status, reasons: Reasons) -> bool {
        if status == Status::Fault && reasons.has(Reason::NoEcho) {
            return true;
        }
        let Some(fault) = &mut self.fault else {
            return status != Status::Fault;
        };
        if status == Status::Fault {
            fault.reported = true;
        } else if let (true, Some(cleared)) = (fault.reported, fault.cleared) {
            self.recovery.add(cleared, now);
            self.counts.recovered += 1;
            self.fault = None;
        }
        true
    }
}
