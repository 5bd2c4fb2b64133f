//! The tuned numbers of a stage, which the stage gets when it is made.

use super::Params;
use core::ops::Deref;

/// Tuned numbers of a stage, by reference: [`Params::DEFAULT`], or others in a study.
///
/// Without the feature `ablation` it has no size and the numbers are constants to the compiler. With it, all bits of
/// the default are zero, so that a static stage takes no flash.
#[derive(Clone, Copy, Debug, Default)]
pub struct Numbers {
    /// Other numbers than the default ones.
    #[cfg(feature = "ablation")]
    others: Option<&'static Params>,
}

impl Numbers {
    /// The default numbers.
    pub const DEFAULT: Self = Self {
        #[cfg(feature = "ablation")]
        others: None,
    };

    /// Returns other numbers than the default ones, to measure the effect of each.
    #[cfg(feature = "ablation")]
    pub const fn of(params: &'static Params) -> Self {
        Self {
            others: Some(params),
        }
    }

    /// Returns the numbers.
    #[cfg(not(feature = "ablation"))]
    pub const fn get(self) -> &'static Params {
        &Params::DEFAULT
    }

    /// Returns the numbers.
    #[cfg(feature = "ablation")]
    pub fn get(self) -> &'static Params {
        // The host may replace the initial value of a static in an image for the emulator. The compiler must not use
        // the value that it knows.
        #[cfg(target_os = "none")]
        let others = core::hint::black_box(self.others);
        #[cfg(not(target_os = "none"))]
        let others = self.others;
        others.unwrap_or(&Params::DEFAULT)
    }
}

impl Deref for Numbers {
    type Target = Params;

    fn deref(&self) -> &Params {
        self.get()
    }
}
