//! A mirror shaft without a motor, for simulated scanners and the demo image.

use super::mirror::{Mirror, MirrorError, Motion};
use super::settings::MotorConfig;
use crate::time::Micros;

/// A mirror shaft that reaches each commanded position at once.
#[derive(Clone, Copy, Debug, Default)]
pub struct SimShaft {
    position: i32,
    homed: bool,
}

impl Mirror for SimShaft {
    fn start_home(&mut self, _: &MotorConfig) {
        *self = Self {
            position: 0,
            homed: true,
        };
    }

    fn start_move(&mut self, position: i32, _: &MotorConfig) {
        self.position = position;
    }

    fn poll(&mut self, _: Micros) -> Result<Motion, MirrorError> {
        if self.homed {
            Ok(Motion::Still)
        } else {
            Err(MirrorError::NotHomed)
        }
    }

    fn position(&self) -> i32 {
        self.position
    }

    fn homed(&self) -> bool {
        self.homed
    }

    fn disable(&mut self) {
        self.homed = false;
    }
}
