//! What the table says of each number, and the macro that makes type, default and table of one list.

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

/// One number of a table `P`.
#[derive(Clone, Copy, Debug)]
pub struct Entry<P> {
    /// What it belongs to.
    pub group: &'static str,
    /// Its field.
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
    pub get: fn(&P) -> f32,
    /// Changes it.
    pub set: fn(&mut P, f32),
    /// Where it stands in `P`, bytes; alike on host and chip.
    pub offset: usize,
}

/// Makes the type, its default and its table of one list.
macro_rules! params {
    ($($group:literal { $(
        #[doc = $meaning:literal]
        $name:ident = $value:expr, $unit:literal, $origin:ident $(, $why:literal)?;
    )* })*) => {
        /// The numbers; lengths in metres, angles in radians, as their names say.
        #[derive(Clone, Debug, PartialEq)]
        #[repr(C)]
        pub struct Params { $($(
            #[doc = $meaning]
            pub $name: f32,
        )*)*
            /// Switches of the rules.
            pub rules: Rules,
        }

        impl Params {
            /// What is flashed.
            pub const DEFAULT: Self = Self { $($($name: $value,)*)* rules: Rules::ALL };

            /// Every number with what is known of it, in the order of the stages that use it.
            pub const TABLE: &'static [Entry<Self>] = &[$($(Entry {
                group: $group,
                name: stringify!($name),
                unit: $unit,
                meaning: $meaning,
                origin: Origin::$origin,
                why: concat!($($why)?),
                get: |params| params.$name,
                set: |params, value| params.$name = value,
                offset: core::mem::offset_of!(Self, $name),
            },)*)*];
        }
    };
}
pub(super) use params;
