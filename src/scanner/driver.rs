//! Interface of the motor driver to the mirror, for drivers with more than STEP, DIR and EN.

use core::task::Poll;

use super::settings::MotorConfig;
use crate::time::Micros;

/// Error of a motor driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverError {
    /// The driver does not answer, or does not accept a write.
    Silent,
    /// The driver was reset and has lost its configuration.
    Reset,
    /// The driver has switched itself off, or reports a short circuit or undervoltage.
    Fault,
}

/// A motor driver that can be configured and read. No call waits: each proceeds as far as possible.
pub trait MotorDriver {
    /// Begins to configure the driver as `motor` requests, even if a set-up or a reading is under way.
    fn set_up(&mut self, motor: &MotorConfig);
    /// Begins to read the driver's status, unless a set-up or a reading is under way.
    fn read_status(&mut self);
    /// Continues the set-up or reading; returns its result when it ends. Ready at once if none is under way.
    fn poll(&mut self, now: Micros) -> Poll<Result<(), DriverError>>;
    /// Returns the time after EN has switched the driver on in which no STEP pulse may be sent, µs.
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

/// Stand-in for a driver without a UART: every poll fails with [`DriverError::Silent`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoUart;

impl MotorDriver for NoUart {
    fn set_up(&mut self, _: &MotorConfig) {}

    fn read_status(&mut self) {}

    fn poll(&mut self, _: Micros) -> Poll<Result<(), DriverError>> {
        Poll::Ready(Err(DriverError::Silent))
    }
}
