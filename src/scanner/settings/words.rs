//! Enumerated settings and the text of their values.

use super::motor::{Driver, Encoder, WireLevel};
use crate::drive::Mode;
use crate::setting::words;

/// A setting that is on or off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Switch {
    /// The function is on.
    #[default]
    On,
    /// The function is off.
    Off,
}

/// Direction of the mirror's sweeps, between the first and the last row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sweeping {
    /// The first scan from the first row to the last, the next one back, and so on.
    #[default]
    Both,
    /// Always from the first row to the last.
    Forward,
    /// Always from the last row to the first.
    Backward,
}

/// Motion of the mirror through the sector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SweepMode {
    /// The mirror stands still at each row's angle.
    Stop,
    /// The mirror turns at constant speed: faster, and on simulated scenes no less accurate.
    #[default]
    Continuous,
}

words!(Switch: "on" Switch::On, "off" Switch::Off);
words!(Sweeping: "both" Sweeping::Both, "down" Sweeping::Forward, "up" Sweeping::Backward);
words!(SweepMode: "stop" SweepMode::Stop, "continuous" SweepMode::Continuous);
words!(Driver: "step-dir" Driver::StepDir, "tmc2209" Driver::Tmc2209);
words!(Encoder: "none" Encoder::None, "as5600" Encoder::As5600);
words!(WireLevel: "low" WireLevel::Low, "high" WireLevel::High);
words!(Mode:
    "auto" Mode::Auto, "required" Mode::Required, "standing" Mode::Standing);
