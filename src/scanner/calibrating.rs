//! Command `calibrate`: a scan of a floor and a wall becomes the settings of the mounting.

use super::states::{Activity, Machine};
use crate::config::ConfigError;
use crate::crc;
use crate::scanner::board::Board;
use crate::scanner::chain::DataPath;
use crate::scanner::command::CalibrationRequest;
use crate::scanner::mirror::Mirror;
use crate::scanner::parts::Parts;
use crate::scanner::settings;
use crate::scanner::sweep::Rows;
use crate::time::Micros;

impl<H: Parts> Machine<'_, H> {
    /// Executes `calibrate`: begins a scan if the scanner is idle or in a fault; when the scan has ended,
    /// [`Machine::calibrated`] makes settings of it.
    #[inline(never)]
    pub fn calibrate(&mut self, now: Micros, task: CalibrationRequest) {
        if !self.stands() {
            return self.refuse_calibration(ConfigError {
                field: "state",
                expected: "idle: stop first",
            });
        }
        // Plane and mirror offset cannot be measured, and height and angle only close to their set values.
        match self.settings.fit_to_save() {
            Ok(()) => {
                self.calibration = Some(task);
                self.begin(now, Activity::Once);
            }
            Err(error) => self.refuse_calibration(error),
        }
    }

    /// Handles the finished scan of `calibrate`: sets and saves the settings of the mounting, or reports an error
    /// and changes nothing.
    #[inline(never)]
    pub(super) fn calibrated(&mut self, rows: &Rows, task: CalibrationRequest) {
        match self.take_calibration(rows, task) {
            Ok(()) => self.reports.done("calibrate"),
            Err(error) => self.refuse_calibration(error),
        }
    }

    fn take_calibration(
        &mut self,
        rows: &Rows,
        task: CalibrationRequest,
    ) -> Result<(), ConfigError> {
        if rows.lost > 0 || rows.fault.is_some() {
            return Err(ConfigError {
                field: "rows",
                expected: "a scan without lost rows or faults",
            });
        }
        let found = self.data.calibrate(f32::from(task.wall_mm) / 1e3)?;
        let mut settings = *self.settings.get();
        settings.calibrate(&found);
        settings.calibrated.date = task.date;
        settings.calibrated.chip = crc::of_words(&self.identity.serial);
        if let Some(reading) = self.hardware.mirror.home_reading() {
            settings.motor.encoder.home = reading;
        }
        settings.validate()?;
        let saved = self.hardware.board.save(&settings);
        saved.map_err(|error| ConfigError {
            field: "flash",
            expected: error.expected(),
        })?;
        self.change("mount-height", &settings)?;
        // The home position now has another angle.
        self.hardware.mirror.disable();
        let scale = settings::number(i64::from(settings.config.mount.range_scale));
        self.reports.value("range-scale", &scale);
        Ok(())
    }

    pub(super) fn refuse_calibration(&mut self, error: ConfigError) {
        self.reports
            .refuse("calibrate", error.field, error.expected);
    }
}
