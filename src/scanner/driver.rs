//! Interface of the motor driver to the mirror, for drivers with more than STEP, DIR and EN.

use core::task::Poll;

use super::settings::MotorConfig;
use crate::time::Micros;

/// Error of a driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverError {
    /// The driver does not answer, or does not accept a write.
    Silent,
    /// The driver was reset and has lost its configuration.
    Reset,
    /// The driver has switched itself off, or reports a short circuit or undervoltage.
    Fault,
}

/// A driver that can be set up and read. No call waits: each proceeds as far as possible.
pub trait MotorDriver {
    /// Begins the set-up, whatever is under way.
    fn set_up(&mut self, motor: &MotorConfig);
    /// Begins a reading of the status, unless something is under way.
    fn read_status(&mut self);
    /// Continues the current activity; ready if there is none.
    fn poll(&mut self, now: Micros) -> Poll<Result<(), DriverError>>;
    /// Returns the time after EN for which no pulse may be sent, µs.
    fn tuning_us(&self) -> u32 {
        0
    }
}

impl<D: MotorDriver + ?Sized> MotorDriver for &mut D {
    fn set_up(&mut self, motor: &MotorConfig) {
        (**self).set_up(motor);
    }

    fn read_status(&mut self) {
        (**self).read_status();
    }

    fn poll(&mut self, now: Micros) -> Poll<Result<(), DriverError>> {
        (**self).poll(now)
    }

    fn tuning_us(&self) -> u32 {
        (**self).tuning_us()
    }
}

/// A driver without a UART: every request fails as silent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoUart;

impl MotorDriver for NoUart {
    fn set_up(&mut self, _: &MotorConfig) {}

    fn read_status(&mut self) {}

    fn poll(&mut self, _: Micros) -> Poll<Result<(), DriverError>> {
        Poll::Ready(Err(DriverError::Silent))
    }
}
