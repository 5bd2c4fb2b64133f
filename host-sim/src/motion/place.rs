//! A chair's place by its own sensors.

/// Where a chair says that it is when a chirp is fired.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Since the first chirp, seconds.
    pub time_s: f64,
    /// By the odometer, metres.
    pub travel_m: f64,
    /// By the inclinometer, degrees.
    pub pitch_deg: f64,
}
