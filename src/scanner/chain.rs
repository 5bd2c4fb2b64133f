//! Interface of the data path, as the sweep drives it through one scan.

use crate::Iq;
use crate::config::{Config, ConfigError};
use crate::drive::{Drive, ExpectedTravel};
use crate::mount::Mounting;
use crate::params::Numbers;
use crate::verdict::{Conditions, GuardResult, Outcome};

/// Data path from samples to steps.
///
/// The sweep fills [`DataPath::samples`], has them processed by [`DataPath::row`] while the mirror moves on,
/// and requests the outcome after the last row. Rows may come in either direction.
pub trait DataPath {
    /// Begins scan number `scan` with the settings `config`: empties the map.
    fn begin(&mut self, config: &Config, scan: u32) -> Result<(), ConfigError>;
    /// Returns the buffer for the next chirp's samples; its length is set by the configuration.
    fn samples(&mut self) -> &mut [Iq];
    /// Processes the samples in the buffer as those of row `row`, an index of the map: they were received while
    /// the shaft was at the scheduled position of this row.
    fn row(&mut self, row: u16);
    /// Marks row `row` of the map as lost: no chirp was received for it in all attempts, or it could not be
    /// triggered in time.
    fn lost(&mut self, row: u16);
    /// Returns the outcome after the last row, from the chair's motion during the scan and the scan's
    /// conditions.
    fn conclude(&mut self, drive: &Drive<'_>, conditions: Conditions) -> Outcome;
    /// Returns the outcome as [`DataPath::conclude`] does, for a chair that is known to stand, under good
    /// conditions.
    fn finish(&mut self) -> Outcome {
        self.conclude(&Drive::STANDING, Conditions::GOOD)
    }
    /// Begins guard sweep number `sweep` with the settings `config`, as [`DataPath::begin`] begins a scan.
    ///
    /// # Errors
    /// Names the field of `config` that is not valid.
    fn begin_guard(&mut self, config: &Config, sweep: u32) -> Result<(), ConfigError>;
    /// Returns the result of a guard sweep after its last row, instead of [`DataPath::conclude`]: the free
    /// distance by this and the previous guard sweeps. Sweep number 1 of [`DataPath::begin_guard`] discards all
    /// previous ones.
    fn guard(&mut self, drive: &Drive<'_>, conditions: Conditions) -> GuardResult;
    /// Returns the mounting after the last row of a scan of a flat floor and a wall `wall_m` metres from the
    /// mirror, instead of [`DataPath::conclude`].
    ///
    /// # Errors
    /// Names the property of instrument or scene that is out of its limits.
    fn calibrate(&mut self, wall_m: f32) -> Result<Mounting, ConfigError>;
    /// States that from the next row on the chair may move until the end of the scan, and its travel.
    fn expect_motion(&mut self, _travel: ExpectedTravel) {}
    /// Returns the tuned numbers that the data path has.
    fn numbers(&self) -> Numbers {
        Numbers::DEFAULT
    }
    /// Runs the known-answer test of the arithmetic; returns whether it has passed.
    fn self_test(&mut self) -> bool;
}

// For a data path that is too large for the stack.
impl<D: DataPath + ?Sized> DataPath for &mut D {
    fn begin(&mut self, config: &Config, scan: u32) -> Result<(), ConfigError> {
        (**self).begin(config, scan)
    }

    fn samples(&mut self) -> &mut [Iq] {
        (**self).samples()
    }

    fn row(&mut self, row: u16) {
        (**self).row(row);
    }

    fn lost(&mut self, row: u16) {
        (**self).lost(row);
    }

    fn conclude(&mut self, drive: &Drive<'_>, conditions: Conditions) -> Outcome {
        (**self).conclude(drive, conditions)
    }

    fn begin_guard(&mut self, config: &Config, sweep: u32) -> Result<(), ConfigError> {
        (**self).begin_guard(config, sweep)
    }

    fn guard(&mut self, drive: &Drive<'_>, conditions: Conditions) -> GuardResult {
        (**self).guard(drive, conditions)
    }

    fn calibrate(&mut self, wall_m: f32) -> Result<Mounting, ConfigError> {
        (**self).calibrate(wall_m)
    }

    fn expect_motion(&mut self, travel: ExpectedTravel) {
        (**self).expect_motion(travel);
    }

    fn numbers(&self) -> Numbers {
        (**self).numbers()
    }

    fn self_test(&mut self) -> bool {
        (**self).self_test()
    }
}
