//! Every tuned number of the default estimator, in one table of one type.
//!
//! The table (`src/params/table.rs`) gives each its unit, its meaning and where it comes from;
//! `cargo sim params` prints it, and with `--sensitivity` what a fifth more or less of each does to
//! the accuracy on tuning seeds ([docs/parameters.md](../../docs/parameters.md)). What is not in it
//! is derived, and stands beside its derivation.

pub mod fitted;
pub mod hazard;
mod table;

pub use table::Params;

/// Where a number comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// It follows from physics, from another number or from the instrument.
    Derived,
    /// It is what stairs, wheelchairs or building codes are like.
    Custom,
    /// It was set by hand while watching the accuracy on tuning seeds.
    Hand,
}

impl Origin {
    /// Its name in a table.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Derived => "derived",
            Self::Custom => "custom",
            Self::Hand => "by hand",
        }
    }
}

/// One number of the table.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// What it belongs to.
    pub group: &'static str,
    /// Its field in [`Params`].
    pub name: &'static str,
    /// Its unit; empty for a mere number.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
    /// Where it comes from …
    pub origin: Origin,
    /// … in words; empty where the origin says it all.
    pub why: &'static str,
    /// Reads it.
    pub get: fn(&Params) -> f32,
    /// Changes it.
    pub set: fn(&mut Params, f32),
}

/// Makes the type, its default and its table of one list.
macro_rules! params {
    ($($group:literal { $(
        #[doc = $meaning:literal]
        $name:ident = $value:expr, $unit:literal, $origin:ident $(, $why:literal)?;
    )* })*) => {
        /// The numbers; lengths in metres, angles in radians, as their names say.
        #[derive(Clone, Debug, PartialEq)]
        pub struct Params { $($(
            #[doc = $meaning]
            pub $name: f32,
        )*)* }

        impl Params {
            /// What is flashed.
            pub const DEFAULT: Self = Self { $($($name: $value,)*)* };

            /// Every number with what is known of it, in the order of the stages that use it.
            pub const TABLE: &'static [Entry] = &[$($(Entry {
                group: $group,
                name: stringify!($name),
                unit: $unit,
                meaning: $meaning,
                origin: Origin::$origin,
                why: concat!($($why)?),
                get: |params| params.$name,
                set: |params, value| params.$name = value,
            },)*)*];
        }
    };
}
use params;

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
