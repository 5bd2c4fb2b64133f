//! The motor's driver as the mirror sees it, where it has more than STEP, DIR and EN.

use core::task::Poll;

use super::settings::MotorConfig;
use crate::time::Micros;

/// What can be wrong with a driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverError {
    /// It does not answer, or does not take what it is told.
    Silent,
    /// It has been reset and no longer knows what it was told.
    Reset,
    /// It has switched itself off, or reports a short circuit or too little voltage.
    Fault,
}

/// A driver that can be set up and read. Nothing here waits: each call gets as far as it can.
pub trait MotorDriver {
    /// Begins to set it up, whatever was under way.
    fn set_up(&mut self, motor: &MotorConfig);
    /// Begins to read its status, unless something is under way.
    fn look(&mut self);
    /// Goes on with what was begun; ready where nothing is under way.
    fn poll(&mut self, now: Micros) -> Poll<Result<(), DriverError>>;
    /// How long after EN it must be left alone before the first pulse, microseconds.
    fn tuning_us(&self) -> u32 {
        0
    }
}

impl<D: MotorDriver + ?Sized> MotorDriver for &mut D {
    fn set_up(&mut self, motor: &MotorConfig) {
        (**self).set_up(motor);
    }

    fn look(&mut self) {
        (**self).look();
    }

    fn poll(&mut self, now: Micros) -> Poll<Result<(), DriverError>> {
        (**self).poll(now)
    }

    fn tuning_us(&self) -> u32 {
        (**self).tuning_us()
    }
}

/// No wire leads to the driver: whoever asks for one gets no answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoWire;

impl MotorDriver for NoWire {
    fn set_up(&mut self, _: &MotorConfig) {}

    fn look(&mut self) {}

    fn poll(&mut self, _: Micros) -> Poll<Result<(), DriverError>> {
        Poll::Ready(Err(DriverError::Silent))
    }
}
