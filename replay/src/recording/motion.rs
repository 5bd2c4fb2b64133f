//! Motion of the chair during a recording, as measured by its own sensors.

use std::ops::Range;

/// Readings of the chair's own sensors, one value per chirp; empty if the recording has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// Forward travel of the chair since the first chirp, in the middle of each chirp, metres, with
    /// the odometer's errors.
    pub travel_m: Vec<f64>,
    /// Time of each chirp since the first one, seconds.
    pub time_s: Vec<f64>,
    /// Pitch of the chair at each chirp, nose up positive, degrees. A single value in the file
    /// applies to every chirp.
    pub pitch_deg: Vec<f64>,
}

impl Motion {
    /// Returns the readings of the chirps with the numbers `range`.
    pub(super) fn of(&self, range: Range<usize>) -> Self {
        let part = |values: &[f64]| values.get(range.clone()).unwrap_or_default().to_vec();
        Self {
            travel_m: part(&self.travel_m),
            time_s: part(&self.time_s),
            pitch_deg: part(&self.pitch_deg),
        }
    }

    /// Returns the mean pitch over the chirps `range`, degrees; `None` without readings.
    pub fn mean_pitch_deg(&self, range: Range<usize>) -> Option<f64> {
        let pitch = self.pitch_deg.get(range).filter(|p| !p.is_empty())?;
        Some(pitch.iter().sum::<f64>() / pitch.len() as f64)
    }
}
