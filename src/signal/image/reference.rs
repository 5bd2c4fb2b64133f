//! A chirp's spectrum, brought to the phase of the mirror's own echo.

use crate::signal::range::packed::Packed;

/// Kept bins of one chirp's spectrum with the phase that the chirp began with taken out.
#[derive(Debug)]
pub struct CoherentRow<'a> {
    /// The kept bins, mantissas of 16 bits.
    pub bins: &'a mut [Packed],
    /// Amplitude of a mantissa of 1: a full-scale tone has amplitude 1.
    pub unit: f32,
    /// Whether the mirror's echo gave the phase. Without a mirror the phase of each row follows from the row before.
    pub referenced: bool,
}
