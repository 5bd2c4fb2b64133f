//! End of a scan or guard sweep: its outcome, and the sentences that report it.

use super::{Machine, POLL_US, ScannerState};
use crate::config::Planes;
use crate::drive::Retention;
use crate::report::GuardLine;
use crate::scanner::board::Board;
use crate::scanner::chain::DataPath;
use crate::scanner::keeper::ScanSettings;
use crate::scanner::parts::Parts;
use crate::scanner::planes::requests_height_plane;
use crate::scanner::reports::ReportProgress;
use crate::scanner::resets::SURVIVED_US;
use crate::scanner::settings::Switch;
use crate::scanner::sweep::Rows;
use crate::time::Micros;
use crate::verdict::{Conditions, GuardResult, Outcome, Reason, Reasons, Status};

// Out of line where `states` says why.
impl<H: Parts> Machine<'_, H> {
    /// Turns a finished scan into its outcome, or into settings for `calibrate`, and begins to report it.
    #[inline(never)]
    pub(super) fn conclude(&mut self, now: Micros, rows: Rows) {
        let aside = self.scan.is_other_plane();
        match aside {
            true => self.odometry.finish_aside(now),
            false => self.odometry.finish(now),
        }
        if let Some(task) = self.calibration.take() {
            self.calibrated(&rows, task);
            return self.resume(now);
        }
        let ScanSettings {
            motion,
            fusion,
            chirp_us,
            planes,
            ..
        } = self.scan;
        let conditions = Conditions {
            board: self.identity.health.degrading_faults(),
            configured: self.scan.configured,
            lost_rows: rows.lost > 0,
        };
        if let Some(reason) = rows.fault {
            return self.report_broken(reason, conditions, rows.lost);
        }
        let memory = match fusion {
            _ if aside => Retention::Aside,
            Switch::Off => Retention::Off,
            Switch::On if self.discard_evidence => Retention::Anew,
            Switch::On => Retention::Kept,
        };
        self.odometry.set_retention(memory);
        self.discard_evidence &= aside;
        let drive = self.odometry.drive(motion, chirp_us);
        let outcome = self.data.conclude(&drive, conditions);
        if outcome.status() != Status::Fault {
            self.answered = Some(now);
        }
        self.guard.note(now, &outcome);
        let may = planes == Planes::Both && !aside;
        let config = &self.settings.get().config;
        self.height_requested =
            may && requests_height_plane(config, &outcome, &drive, &self.data.numbers());
        self.enter_reporting(outcome, rows.lost, false);
    }

    /// Begins to report that a hardware fault prevented the scan or guard sweep, or ended it.
    // Out of line: its outcome would otherwise be on the stack beneath the estimator, beside the estimator's
    // own.
    #[inline(never)]
    pub(super) fn report_broken(&mut self, reason: Reason, conditions: Conditions, lost: u16) {
        if self.scan.guard {
            return self.enter_reporting_guard(&GuardResult::broken(reason), true);
        }
        let faults = Reasons::NONE.with(reason);
        self.enter_reporting(Outcome::broken(faults, conditions), lost, true);
    }

    /// Begins to report the result of a guard sweep; `broken` if a hardware fault prevented or ended it.
    pub(in crate::scanner) fn enter_reporting_guard(&mut self, word: &GuardResult, broken: bool) {
        self.reasons = word.reasons();
        self.state =
            ScannerState::ReportingGuard(GuardLine::new(self.guard.reported_sweep, word), broken);
    }

    /// Queues the sentence of a guard sweep once it fits, and continues.
    #[inline(never)]
    pub(super) fn report_guard(&mut self, now: Micros, line: GuardLine, broken: bool) {
        self.deadline = now.plus(POLL_US);
        if !self.reports.guard(line) {
            return;
        }
        self.forget_crashes(now, line.status == Status::Fault);
        if broken {
            self.enter_fault(now, true);
        } else {
            self.resume(now);
        }
    }

    fn enter_reporting(&mut self, outcome: Outcome, lost: u16, broken: bool) {
        self.reasons = outcome.reasons();
        self.reports.outcome = outcome;
        self.state = ScannerState::Reporting(ReportProgress {
            scan: self.scans,
            settings: self.scan.hash,
            plane: self.scan.reported_plane(),
            lost,
            broken,
            queued: 0,
        });
    }

    /// Queues the sentences of the answer as they fit, and continues when all are queued.
    #[inline(never)]
    pub(super) fn report(&mut self, now: Micros) {
        self.deadline = now.plus(POLL_US);
        let ScannerState::Reporting(telling) = &mut self.state else {
            return;
        };
        if !self.reports.queue_answer(telling) {
            return;
        }
        let broken = telling.broken;
        let fault = self.reports.outcome.status() == Status::Fault;
        self.forget_crashes(now, fault);
        if broken {
            self.enter_fault(now, true);
        } else {
            self.resume(now);
        }
    }

    /// Clears the count of crashes at the first scan or guard sweep without a fault that ends a minute or more
    /// ([`SURVIVED_US`]) after boot.
    fn forget_crashes(&mut self, now: Micros, fault: bool) {
        if !fault && self.booted.is_some_and(|at| now.since(at) >= SURVIVED_US) {
            self.booted = None;
            self.hardware.board.clear_crashes();
        }
    }
}
