//! Commands `guard` and `watch`: repeated coarse sweeps of the ground ahead, with full scans in between.

use super::guard::{GuardMode, fit};
use super::states::Machine;
use crate::config::ConfigError;
use crate::scanner::chain::DataPath;
use crate::scanner::parts::Parts;
use crate::scanner::settings::Settings;
use crate::scanner::sweep::Rows;
use crate::signal::radar::any::row_times;
use crate::signal::radar::module::RadarModule;
use crate::time::Micros;
use crate::verdict::{Conditions, GuardResult};

impl<H: Parts> Machine<'_, H> {
    /// Executes `guard` and `watch`: switches guard sweeps on or off.
    #[inline(never)]
    pub fn guard(&mut self, now: Micros, on: bool, mode: GuardMode) {
        let command = match mode {
            GuardMode::Watch => "watch",
            _ => "guard",
        };
        if !on {
            self.guard.mode = GuardMode::Off;
            return self.reports.done(command);
        }
        if let Err(error) = self.fit_to_guard(self.settings.get()) {
            return self.reports.refuse(command, error.field, error.expected);
        }
        if !self.guard.is_on() {
            self.guard.sweep = 0;
        }
        self.guard.mode = mode;
        self.guard.hazard_scanned = false;
        self.reports.done(command);
        self.wake(now);
    }

    /// Checks whether the scanner can guard with these settings.
    #[inline(never)]
    pub(super) fn fit_to_guard(&self, settings: &Settings) -> Result<(), ConfigError> {
        let samples = settings.config.radar.samples;
        // Before the module has answered, its requested settings are assumed.
        let times = match self.connected {
            true => self.hardware.link.row_times(samples),
            false => row_times(&settings.module, samples),
        };
        fit(settings, times)
    }

    /// Switches the guard off because of `error`, and reports it.
    pub(super) fn end_guard(&mut self, now: Micros, error: ConfigError) {
        self.guard.mode = GuardMode::Off;
        self.reports.refuse("guard", error.field, error.expected);
        self.resume(now);
    }

    /// Turns a finished guard sweep into its result, which the hazard of the last full scan limits, and reports
    /// it.
    #[inline(never)]
    pub(super) fn guarded(&mut self, now: Micros, rows: Rows) {
        self.odometry.finish_guard(now);
        self.guard.mirror_moving = true;
        let conditions = Conditions {
            board: self.identity.health.degrading_faults(),
            configured: self.scan.configured,
            lost_rows: rows.lost > 0,
        };
        let drive = self.odometry.drive(self.scan.motion, self.scan.chirp_us);
        let mut word = match rows.fault {
            Some(reason) => GuardResult::broken(reason),
            None => self.data.guard(&drive, conditions),
        };
        let moved_m = self.odometry.since_scan_m().unwrap_or(0.0);
        self.guard.compare(now, moved_m, &mut word);
        let within_m = self.settings.get().guard.watch_m();
        self.guard.watch(&word, &drive, within_m);
        self.enter_reporting_guard(&word, rows.fault.is_some());
    }
}
