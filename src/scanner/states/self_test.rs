//! Self-test of the scanner: arithmetic, homing of the mirror, then radar module.

use core::task::Poll;

use super::{Activity, Machine, POLL_US, ScannerState, Test};
use crate::config::ConfigError;
use crate::scanner::board::Board;
use crate::scanner::chain::DataPath;
use crate::scanner::mirror::{Mirror, Motion};
use crate::scanner::parts::Parts;
use crate::scanner::sweep::{link_reason, mirror_reason};
use crate::schedule::MICROSTEPS_PER_TURN;
use crate::signal::radar::module::RadarModule;
use crate::time::Micros;
use crate::verdict::{Reason, Reasons};

// Out of line where `states` says why.
impl<H: Parts> Machine<'_, H> {
    #[inline(never)]
    pub(super) fn self_test(&mut self, now: Micros, test: Test, errand: Activity) {
        match test {
            Test::Arithmetic => {
                if let Some(unfit) = self.identity.health.fault(self.settings.get()) {
                    return self.fail_test(now, unfit, errand);
                }
                if !self.data.self_test() {
                    return self.fail_test(now, Reason::SelfTest, errand);
                }
                self.hardware.mirror.start_home(&self.settings.get().motor);
                self.state = ScannerState::SelfTest(Test::Home, errand);
                self.deadline = now.plus(self.home_bound_us());
            }
            Test::Home => match self.hardware.mirror.poll(now) {
                Err(error) => self.fail_test(now, mirror_reason(error), errand),
                Ok(Motion::Moving) => {}
                Ok(Motion::Still) => {
                    let until = now.plus(self.settings.get().timing.connect_timeout);
                    self.ask(now, until, errand);
                }
            },
            Test::Link { until, again } => self.test_link(now, until, again, errand),
        }
    }

    /// Returns the time limit of homing, µs: three turns at search speed and a second. Homing takes at most a
    /// turn to the switch, and a few short moves at an eighth of the speed.
    fn home_bound_us(&self) -> u32 {
        let speed = self.settings.get().motor.search_speed.max(1);
        let seconds = 3 * MICROSTEPS_PER_TURN as u32 / speed + 1;
        seconds.saturating_mul(1_000_000)
    }

    fn ask(&mut self, now: Micros, until: Micros, errand: Activity) {
        let timeout = self.settings.get().timing.configure_timeout;
        let requested = &self.settings.get().module;
        self.hardware.link.program(now, requested, timeout);
        let test = Test::Link { until, again: None };
        self.state = ScannerState::SelfTest(test, errand);
        self.deadline = now.plus(timeout).plus(POLL_US);
    }

    fn test_link(&mut self, now: Micros, until: Micros, again: Option<Micros>, errand: Activity) {
        if let Some(again) = again {
            if now.reached(again) {
                self.ask(now, until, errand);
            }
            return;
        }
        // The module may be booting for seconds; a stall in that time is still reported.
        if let Err(error) = self.hardware.mirror.poll(now) {
            return self.fail_test(now, mirror_reason(error), errand);
        }
        let Poll::Ready(answer) = self.hardware.link.settings(now) else {
            return;
        };
        self.link_errors = (self.link_errors).saturating_add(answer.is_err().into());
        match answer {
            Ok(radar) => {
                self.connected = true;
                // The scan checks whether these settings are usable; it queries them again.
                self.settings.adopt(radar);
                self.passed(now, errand);
            }
            Err(error) if now.reached(until) => self.fail_test(now, link_reason(error), errand),
            Err(_) => {
                // A query that failed at once is repeated only after a pause.
                let pause = now.plus(self.settings.get().timing.configure_timeout);
                let again = Some(pause);
                self.state = ScannerState::SelfTest(Test::Link { until, again }, errand);
                self.deadline = pause.plus(POLL_US);
            }
        }
    }

    fn passed(&mut self, now: Micros, errand: Activity) {
        self.hardware.board.self_test_passed();
        match errand {
            Activity::Once => self.begin(now, errand),
            Activity::Guard | Activity::Resume => self.resume(now),
            Activity::Answer => {
                self.reports.done("selftest");
                self.reasons = Reasons::NONE;
                self.resume(now);
            }
        }
    }

    /// Handles a self-test that has failed for `reason`; it is reported as scan 0 without an answer.
    pub(super) fn fail_test(&mut self, now: Micros, reason: Reason, errand: Activity) {
        if self.calibration.take().is_some() {
            self.refuse_calibration(ConfigError {
                field: reason.as_str(),
                expected: "a passed self-test",
            });
        }
        if errand == Activity::Answer {
            self.reports
                .refuse("selftest", reason.as_str(), "a passed self-test");
        }
        self.reasons = match self.scans {
            // The cause of the reset is reported until the first scan.
            0 => self.identity.reasons().with(reason),
            _ => Reasons::NONE.with(reason),
        };
        self.enter_fault(now, false);
    }
}
