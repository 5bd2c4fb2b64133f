//! Elementary functions that come out the same on every host: those of `libm` in place of the platform's, whose last
//! bit differs.

/// Elementary functions by `libm`.
pub trait Portable {
    /// e to its power.
    fn exp_portable(self) -> f64;
    /// e to its power, less 1.
    fn exp_m1_portable(self) -> f64;
    /// Natural logarithm.
    fn ln_portable(self) -> f64;
    /// Natural logarithm of 1 and it.
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
