//! A chirp of the BGT60TR13C as its registers program it.

/// Parameters of a chirp: frequencies, samples and duration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chirp {
    /// Frequency at the first sample, Hz.
    pub first_hz: f64,
    /// Frequency step from one sample to the next, Hz.
    pub step_hz: f64,
    /// Frequencies at the beginning and the end of the ramp, Hz.
    pub ramp_hz: [f64; 2],
    /// Number of samples of the chirp.
    pub samples: usize,
    /// Sample rate of the converter, Hz.
    pub rate_hz: f64,
    /// Time from the start of the frame to the last sample, seconds.
    pub duration_s: f64,
}

impl Chirp {
    /// Returns the frequency in the middle between the first and the last sample, Hz.
    pub fn carrier_hz(&self) -> f64 {
        self.first_hz + self.bandwidth_hz() / 2.0
    }

    /// Returns the swept bandwidth within the samples, Hz.
    pub fn bandwidth_hz(&self) -> f64 {
        self.step_hz * self.samples as f64
    }
}
