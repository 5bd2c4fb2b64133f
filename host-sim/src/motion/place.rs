//! A chair's place as measured by its own sensors.

/// Sensor readings when a chirp is fired.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Time since the first chirp, seconds.
    pub time_s: f64,
    /// Travel by the odometer, metres.
    pub travel_m: f64,
    /// Pitch by the inclinometer, degrees.
    pub pitch_deg: f64,
}
