//! Every tuned number of the default estimator, in one table of one type.
//!
//! The table (`src/params/table.rs`) gives each its unit, its meaning and where it comes from;
//! `cargo sim params` prints it, and with `--sensitivity` what a fifth more or less of each does to
//! the accuracy on tuning seeds ([docs/parameters.md](../../docs/parameters.md)). Those of the posterior
//! are constants ([`posterior`]). What is in neither is derived, and stands beside its derivation.

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
pub use rules::{DOUBTS, Rule, rules};
pub use switches::Rules;
pub use table::Params;

use crate::config::Plane;
use hazard::Weights;

/// The verdict's numbers that were counted for scans of a plane.
pub const fn fitted_for(plane: Plane) -> &'static Weights {
    match plane {
        Plane::Depth => &fitted::UP,
        Plane::Height => &fitted::DOWN,
    }
}

/// The numbers that everything is worked off with.
#[cfg(not(feature = "ablation"))]
pub const fn current() -> &'static Params {
    &Params::DEFAULT
}

#[cfg(all(feature = "ablation", target_os = "none"))]
pub use patched::current;
#[cfg(all(feature = "ablation", not(target_os = "none")))]
pub use replaced::{current, replace};

/// Other numbers than those that are flashed, in an image for the emulator: the host writes them into its ELF file, in
/// place of `NUMBERS`, to count what each rule costs.
#[cfg(all(feature = "ablation", target_os = "none"))]
mod patched {
    use super::Params;
    use core::hint::black_box;

    static NUMBERS: Params = Params::DEFAULT;

    /// The numbers that everything is worked off with.
    pub fn current() -> &'static Params {
        // What the compiler knows of the static's value no longer holds when the image runs.
        black_box(&NUMBERS)
    }
}

/// Other numbers than those that are flashed, for the whole program: to measure what each is worth.
#[cfg(all(feature = "ablation", not(target_os = "none")))]
mod replaced {
    extern crate std;

    use super::Params;
    use std::sync::RwLock;

    static CURRENT: RwLock<&'static Params> = RwLock::new(&Params::DEFAULT);

    /// The numbers that everything is worked off with.
    pub fn current() -> &'static Params {
        // Nothing panics while it is locked.
        CURRENT.read().map_or(&Params::DEFAULT, |params| *params)
    }

    /// Puts other numbers in their place, for all threads; estimators that are made later use them.
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
