//! A chirp of the chip as programmed by its registers.

/// Parameters of a programmed chirp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chirp {
    /// Frequency at the first sample, Hz.
    pub first_hz: f64,
    /// Frequency step from one sample to the next, Hz.
    pub step_hz: f64,
    /// Frequencies at the beginning and the end of the ramp, Hz.
    pub ramp_hz: [f64; 2],
    /// Number of samples.
    pub samples: usize,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Time from the frame's start to the last sample, seconds.
    pub duration_s: f64,
}

impl Chirp {
    /// Returns the middle of the sweep within the samples, Hz.
    pub fn carrier_hz(&self) -> f64 {
        self.first_hz + self.bandwidth_hz() / 2.0
    }

    /// Returns the bandwidth of the sweep within the samples, Hz.
    pub fn bandwidth_hz(&self) -> f64 {
        self.step_hz * self.samples as f64
    }
}
