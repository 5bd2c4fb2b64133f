//! Elementary functions with the same result on every host: those of `libm` instead of the platform's, which differ
//! in the last bit.

/// Elementary functions by `libm`.
pub trait Portable {
    /// `e^self`.
    fn exp_portable(self) -> f64;
    /// `e^self - 1`.
    fn exp_m1_portable(self) -> f64;
    /// Natural logarithm.
    fn ln_portable(self) -> f64;
    /// `ln(1 + self)`.
    fn ln_1p_portable(self) -> f64;
}

impl Portable for f64 {
    fn exp_portable(self) -> f64 {
        libm::exp(self)
    }

    fn exp_m1_portable(self) -> f64 {
        libm::expm1(self)
    }

    fn ln_portable(self) -> f64 {
        libm::log(self)
    }

    fn ln_1p_portable(self) -> f64 {
        libm::log1p(self)
    }
}
