//! Range profile of one chirp with its threshold: for the command `profile`, plots and tests.

use super::log::{FINE, FULL_SCALE};
use crate::config::MAX_SAMPLES;
use crate::signal::grid::BinWindow;

/// Power, threshold and detections of every bin of one chirp's transform.
///
/// Logarithms count 1/256 octave of power; a tone at the converter's full scale has
/// [`FULL_SCALE`] · 32.
#[derive(Clone, Debug)]
pub struct Profile {
    pub(super) power: [i16; MAX_SAMPLES],
    pub(super) threshold: [i16; MAX_SAMPLES],
    /// CA-CFAR detections: bit k % 32 of word k / 32 belongs to the k-th kept bin.
    pub(super) detection_bits: [u32; MAX_SAMPLES / 32],
    /// Cells above their threshold that are removed as possible I/Q images, in the same order.
    pub(super) image_bits: [u32; MAX_SAMPLES / 32],
    points: usize,
    kept: BinWindow,
}

/// One detected echo of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Range, interpolated, in bins of the transform.
    pub bin: f32,
    /// Level relative to full scale, interpolated, dB.
    pub power_db: f32,
}

impl Default for Profile {
    fn default() -> Self {
        Self {
            power: [0; MAX_SAMPLES],
            threshold: [0; MAX_SAMPLES],
            detection_bits: [0; MAX_SAMPLES / 32],
            image_bits: [0; MAX_SAMPLES / 32],
            points: 0,
            kept: BinWindow::default(),
        }
    }
}

/// Returns a profile's level (1/256 octave) in decibels relative to the converter's full scale.
fn decibels(fine: f32) -> f32 {
    (fine - (i32::from(FULL_SCALE) * FINE) as f32) * (crate::math::DB_PER_OCTAVE / 256.0)
}

impl Profile {
    /// Clears the profile for `points` bins, of which `kept` are tested. The threshold of the others is
    /// `i16::MAX`.
    pub(super) fn clear(&mut self, points: usize, kept: BinWindow) {
        self.points = points.min(MAX_SAMPLES);
        self.kept = kept;
        self.detection_bits.fill(0);
        self.image_bits.fill(0);
        self.threshold.fill(i16::MAX);
    }

    /// Returns the number of bins of the transform.
    pub fn bins(&self) -> usize {
        self.points
    }

    /// Returns the bins that CA-CFAR tests. The others contain leakage, mirror and wrap-around.
    pub fn kept(&self) -> BinWindow {
        self.kept
    }

    /// Returns the power of every bin, 1/256 octave above the map's zero; a full-scale tone has [`FULL_SCALE`]
    /// · 32.
    pub fn power(&self) -> &[i16] {
        self.power.get(..self.points).unwrap_or(&[])
    }

    /// Returns the CA-CFAR threshold of every bin, 1/256 octave above the map's zero; `i16::MAX` for bins that
    /// are not tested.
    pub fn threshold(&self) -> &[i16] {
        self.threshold.get(..self.points).unwrap_or(&[])
    }

    /// Returns the power of `bin`, dB relative to full scale.
    pub fn power_db(&self, bin: usize) -> f32 {
        decibels(self.power.get(bin).map_or(0.0, |&p| f32::from(p)))
    }

    /// Returns the CA-CFAR threshold of `bin`, dB relative to full scale; `None` for a bin that is not tested.
    pub fn threshold_db(&self, bin: usize) -> Option<f32> {
        let &threshold = self.threshold.get(bin)?;
        (threshold != i16::MAX).then(|| decibels(f32::from(threshold)))
    }

    /// Returns whether `bin` is a detection: it exceeds its CA-CFAR threshold and is no possible I/Q image.
    pub fn is_hit(&self, bin: usize) -> bool {
        self.is_set(&self.detection_bits, bin)
    }

    /// Returns whether `bin` exceeds its CA-CFAR threshold, and is no detection because it may be the I/Q image of
    /// the echo at its negative frequency.
    pub fn is_image(&self, bin: usize) -> bool {
        self.is_set(&self.image_bits, bin)
    }

    fn is_set(&self, bits: &[u32], bin: usize) -> bool {
        bin.checked_sub(self.kept.first.into())
            .and_then(|k| Some(bits.get(k / 32)? >> (k % 32) & 1 != 0))
            .unwrap_or(false)
    }

    /// Returns the local maxima among the detections, nearest first. Each is interpolated between bins by the
    /// parabola through three logarithmic powers (a Hann window's main lobe in decibels is nearly a parabola).
    pub fn detections(&self) -> impl Iterator<Item = Detection> + '_ {
        let triples = self.power().windows(3).enumerate();
        triples.filter_map(|(before, triple)| {
            let &[left, peak, right] = triple else {
                return None;
            };
            // Of two equal neighbours the nearer one is taken.
            if !self.is_hit(before + 1) || left >= peak || right > peak {
                return None;
            }
            let [left, peak, right] = [left, peak, right].map(f32::from);
            let shift = 0.5 * (left - right) / (left - 2.0 * peak + right);
            Some(Detection {
                bin: (before + 1) as f32 + shift,
                power_db: decibels(peak - 0.25 * (left - right) * shift),
            })
        })
    }
}
