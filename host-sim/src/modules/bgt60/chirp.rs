//! A chirp of the chip, as its registers program it.

/// What one chirp is programmed to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chirp {
    /// Frequency at the first sample, Hz.
    pub first_hz: f64,
    /// From one sample to the next, Hz.
    pub step_hz: f64,
    /// Where the ramp begins and ends.
    pub ramp_hz: [f64; 2],
    /// Samples.
    pub samples: usize,
    /// Samples a second.
    pub rate_hz: f64,
    /// From the frame's start to the last sample, seconds.
    pub duration_s: f64,
}

impl Chirp {
    /// Middle of the sweep within the samples.
    pub fn carrier_hz(&self) -> f64 {
        self.first_hz + self.bandwidth_hz() / 2.0
    }

    /// The sweep within the samples.
    pub fn bandwidth_hz(&self) -> f64 {
        self.step_hz * self.samples as f64
    }
}
