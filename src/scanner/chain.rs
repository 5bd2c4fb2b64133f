//! The data's way through one scan, as the sweep drives it.

use crate::Iq;
use crate::config::{Config, ConfigError};
use crate::drive::Drive;
use crate::mount::Mounting;
use crate::verdict::{Conditions, GuardWord, Outcome};

/// From samples to steps: what a scan does with its chirps.
///
/// The sweep fills [`DataPath::samples`], has them worked off by [`DataPath::row`] while the mirror
/// moves on, and asks for the outcome after the last row. Rows may come in either direction.
pub trait DataPath {
    /// Empties the map for scan number `scan` of `config`.
    fn begin(&mut self, config: &Config, scan: u32) -> Result<(), ConfigError>;
    /// Where the next chirp's samples go: as many as the configuration says.
    fn samples(&mut self) -> &mut [Iq];
    /// Works off the samples as row `row`, seen while the shaft stood on its microstep.
    fn row(&mut self, row: u16);
    /// Row `row` is lost: its chirp did not come after all retries.
    fn lost(&mut self, row: u16);
    /// The steps, after the last row, with what is known of the chair's motion meanwhile and of the scan's conditions.
    fn conclude(&mut self, drive: &Drive<'_>, conditions: Conditions) -> Outcome;
    /// The same for a chair that is known to stand, under good conditions.
    fn finish(&mut self) -> Outcome {
        self.conclude(&Drive::STANDING, Conditions::GOOD)
    }
    /// [`DataPath::begin`] of guard sweep number `sweep`.
    ///
    /// # Errors
    /// Names the field that does not fit.
    fn begin_guard(&mut self, config: &Config, sweep: u32) -> Result<(), ConfigError>;
    /// The word of a guard sweep, after its last row, instead of [`DataPath::conclude`]: how far the ground is free by it
    /// and by the guard sweeps before, of which number 1, as [`DataPath::begin_guard`] has it, forgets all others.
    fn guard(&mut self, drive: &Drive<'_>, conditions: Conditions) -> GuardWord;
    /// How the scanner is mounted, after the last row of a scan of a flat floor and a wall `wall_m` from the
    /// mirror, instead of [`DataPath::conclude`].
    ///
    /// # Errors
    /// Says what of instrument or scene is not as it must be.
    fn calibrate(&mut self, wall_m: f32) -> Result<Mounting, ConfigError>;
    /// Whether a known-answer chirp comes out of the arithmetic as it must.
    fn self_test(&mut self) -> bool;
}

/// So that a data path too large for the stack can stay where it is.
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

    fn guard(&mut self, drive: &Drive<'_>, conditions: Conditions) -> GuardWord {
        (**self).guard(drive, conditions)
    }

    fn calibrate(&mut self, wall_m: f32) -> Result<Mounting, ConfigError> {
        (**self).calibrate(wall_m)
    }

    fn self_test(&mut self) -> bool {
        (**self).self_test()
    }
}
