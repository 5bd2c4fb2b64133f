//! Tuned numbers of the default estimator, in one table of one type.
//!
//! The table (`src/params/table.rs`) gives unit, meaning and origin of each number. `cargo study params` prints it;
//! with `--sensitivity` it also prints how the accuracy on tuning seeds changes with a fifth more or less of each
//! ([docs/generated/parameters.md](../../docs/generated/parameters.md)). Numbers that nothing changes at run time are
//! constants, in a file for each part of the program that uses them:
//!
//! | module | constants of |
//! |---|---|
//! | [`posterior`], [`descent`], [`drop_depth`] | the model of the echoes going up and going down, the prior and the answer |
//! | [`ground_line`] | the power along the ground's line |
//! | [`image`] | the points of the coherent image |
//! | [`hazard`], [`carried`] | the horizon, and the evidence of earlier scans |
//! | [`guard`], [`motion`], [`mounting`], [`health`] | guard, comparison of sweeps, calibration, health checks |
//!
//! The numbers of one kind of thing ahead stand in the file of the kind (`src/model/kinds`). All others are derived,
//! and stand beside their derivation.
//!
//! A stage gets the tuned numbers as [`Numbers`] when it is made.

pub mod carried;
pub mod counted;
pub mod descent;
pub mod drop_depth;
mod entry;
pub mod fitted;
pub mod generative;
pub mod ground_line;
pub mod guard;
pub mod hazard;
pub mod health;
pub mod image;
pub mod measured;
pub mod motion;
pub mod mounting;
mod numbers;
pub mod posterior;
pub mod rules;
pub mod switches;
mod table;

pub use entry::{Entry, Origin};
pub use numbers::Numbers;
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
