//! Power of a range cell along lines of surfaces, in one byte each.

use crate::math;

/// Depths below the ground of the lines of lower ground, metres: from the smallest drop that matters to a wheelchair
/// to a step.
pub const DEPTHS_M: [f32; 4] = [0.05, 0.08, 0.12, 0.17];

/// Power of a range cell along one line of a surface, quantised.
#[derive(Clone, Copy, Debug, Default)]
pub struct Power {
    /// Mean power t over the noise as raised by leakage, quarters of a decibel above [`Power::MIN_DB`]; 0 where the
    /// line is not seen.
    pub(super) t: u8,
    /// Factor by which leakage of other rows increases the noise's power, quarters of a decibel; 0 for none.
    pub(super) leaks: u8,
}

impl Power {
    /// Quantisation steps of power and leakage per decibel.
    const PER_DB: f32 = 4.0;
    /// Lower limit of the quantised power t, dB over the noise.
    const MIN_DB: f32 = -12.0;
    /// Nats per decibel: ln 10 / 10.
    const NATS_PER_DB: f32 = core::f32::consts::LN_10 / 10.0;

    /// Returns the quantised power `t`, over a noise that leakage has raised by the ratio `leaks`.
    pub(super) fn new(t: f32, leaks: f32) -> Self {
        let db = |ratio: f32| math::DB_PER_OCTAVE * math::log2(math::max(ratio, f32::MIN_POSITIVE));
        // `as` saturates.
        Self {
            t: math::max(math::round((db(t) - Self::MIN_DB) * Self::PER_DB), 1.0) as u8,
            leaks: math::round(db(leaks) * Self::PER_DB) as u8,
        }
    }

    /// Power of a line that is not seen.
    pub(super) const DARK: Self = Self { t: 0, leaks: 0 };

    /// Returns the stronger of two line powers.
    pub(super) fn brighter(self, other: Self) -> Self {
        if other.t > self.t { other } else { self }
    }

    /// Returns power and leakage in floating point.
    pub fn shown(self) -> Shown {
        let t_db = Self::MIN_DB + f32::from(self.t) * (1.0 / Self::PER_DB);
        let ln_t = t_db * Self::NATS_PER_DB;
        Shown {
            t: if self.t == 0 { 0.0 } else { math::exp(ln_t) },
            ln_t,
            leaks_db: f32::from(self.leaks) * (1.0 / Self::PER_DB),
        }
    }
}

/// Power of a range cell along one line, and its leakage, in floating point.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// Mean power t, as a ratio to the noise with its leakage; 0 where the line is not seen.
    pub(super) t: f32,
    pub(super) ln_t: f32,
    pub(super) leaks_db: f32,
}

impl Shown {
    /// Returns whether the line is seen.
    pub fn is_seen(self) -> bool {
        self.t > 0.0
    }
}

/// Powers over the noise of a range cell along the lines of the ground and of lower ground.
#[derive(Clone, Copy, Debug)]
pub struct RangeCell {
    /// Power over the noise along the strongest of three lines: at the ground's height, slightly below and slightly
    /// above it.
    pub ground: Power,
    /// Powers over the noise along the lines of lower ground, in the order of their depths [`DEPTHS_M`].
    pub lower: [Power; DEPTHS_M.len()],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_keep_a_quarter_of_a_decibel() {
        for t in [0.1_f32, 0.7, 1.0, 3.0, 40.0] {
            let shown = Power::new(t, 2.0).shown();
            let off_db = 10.0 * (shown.t / t).log10();
            assert!(
                off_db.abs() < 0.13 && (shown.leaks_db - 3.0).abs() < 0.13,
                "{t}: {off_db}"
            );
            assert!((shown.ln_t - shown.t.ln()).abs() < 1e-5);
        }
        assert!(Power::default().shown().t <= 0.0);
    }
}
