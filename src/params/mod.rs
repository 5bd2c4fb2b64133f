//! Tuned numbers of the default estimator, in one table of one type.
//!
//! The table (`src/params/table.rs`) gives unit, meaning and origin of each number. `cargo study params` prints it;
//! with `--sensitivity` it also prints how the accuracy on tuning seeds changes with a fifth more or less of each
//! ([docs/generated/parameters.md](../../docs/generated/parameters.md)). Those of the posterior are constants ([`posterior`]). Numbers
//! that are in neither are derived, and stand beside their derivation.

pub mod carried;
pub mod counted;
mod entry;
pub mod fitted;
pub mod generative;
pub mod hazard;
pub mod measured;
pub mod posterior;
pub mod rules;
pub mod switches;
mod table;

pub use entry::{Entry, Origin};
pub use rules::{Rule, rules};
pub use switches::Rules;
pub use table::Params;

use crate::config::Plane;
use hazard::Weights;

/// Returns the horizon's weights for a plane, counted from simulated scans.
pub const fn fitted_for(plane: Plane) -> &'static Weights {
    match plane {
        Plane::Depth => &fitted::UP,
        Plane::Height => &fitted::DOWN,
    }
}

/// Returns the tuned numbers in use.
#[cfg(not(feature = "ablation"))]
pub const fn current() -> &'static Params {
    &Params::DEFAULT
}

#[cfg(all(feature = "ablation", target_os = "none"))]
pub use patched::current;
#[cfg(all(feature = "ablation", not(target_os = "none")))]
pub use replaced::{current, replace};

/// Replaceable numbers in an image for the emulator. The host writes other numbers into its ELF file in place of
/// `NUMBERS`, to measure the effect of each rule.
#[cfg(all(feature = "ablation", target_os = "none"))]
mod patched {
    use super::Params;
    use core::hint::black_box;

    static NUMBERS: Params = Params::DEFAULT;

    /// Returns the tuned numbers in use.
    pub fn current() -> &'static Params {
        // Keeps the compiler from using the static's initial value, which the host replaces.
        black_box(&NUMBERS)
    }
}

/// Replaceable numbers for the whole program, to measure the effect of each.
#[cfg(all(feature = "ablation", not(target_os = "none")))]
mod replaced {
    extern crate std;

    use super::Params;
    use std::sync::RwLock;

    static CURRENT: RwLock<&'static Params> = RwLock::new(&Params::DEFAULT);

    /// Returns the tuned numbers in use.
    pub fn current() -> &'static Params {
        // Cannot be poisoned: nothing panics while it is locked.
        CURRENT.read().map_or(&Params::DEFAULT, |params| *params)
    }

    /// Replaces the numbers for all threads. Estimators that are made later use them.
    pub fn replace(params: &'static Params) {
        if let Ok(mut current) = CURRENT.write() {
            *current = params;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_the_unit() {
        for entry in Params::TABLE {
            let suffix = match entry.unit {
                "dB" => "_db",
                "nats" => "_nats",
                "rad" => "_rad",
                "m" => "_m",
                _ => "",
            };
            assert!(
                entry.name.ends_with(suffix),
                "{} in {}",
                entry.name,
                entry.unit
            );
            assert!(!entry.meaning.trim().is_empty(), "{}", entry.name);
            let said = entry.origin == Origin::Hand || !entry.why.is_empty();
            assert!(said, "{} does not say where it comes from", entry.name);
        }
    }

    #[test]
    fn the_table_reads_and_writes_the_field_that_it_names() {
        for entry in Params::TABLE {
            let mut params = Params::DEFAULT;
            (entry.set)(&mut params, -12.5);
            assert_eq!((entry.get)(&params), -12.5, "{}", entry.name);
            (entry.set)(&mut params, (entry.get)(&Params::DEFAULT));
            assert_eq!(params, Params::DEFAULT, "{} changes another", entry.name);
        }
    }
}
