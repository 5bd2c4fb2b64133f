//! Place of a chair (time, travel and pitch) as measured by its own sensors.

/// Readings of the chair's sensors when a chirp is fired.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Time since the first chirp, seconds.
    pub time_s: f64,
    /// Forward travel since the first chirp by the odometer, metres.
    pub travel_m: f64,
    /// Pitch by the inclinometer, nose up positive, degrees.
    pub pitch_deg: f64,
}
