//! Entry of the table of tuned numbers, and the macro that makes type, default and table from one list.

/// Origin of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Follows from physics, from another number or from the instrument.
    Derived,
    /// Taken from stairs, wheelchairs or building codes as they are.
    Custom,
    /// Tuned by hand for accuracy on tuning seeds.
    Hand,
}

impl Origin {
    /// Returns its name in a table.
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
    /// Stage to which it belongs.
    pub group: &'static str,
    /// Name of its field.
    pub name: &'static str,
    /// Unit; empty for a dimensionless number.
    pub unit: &'static str,
    /// Meaning.
    pub meaning: &'static str,
    /// Origin.
    pub origin: Origin,
    /// Explanation of the origin; empty where none is needed.
    pub why: &'static str,
    /// Returns its value.
    pub get: fn(&P) -> f32,
    /// Sets its value.
    pub set: fn(&mut P, f32),
    /// Offset of the field in `P`, bytes; equal on host and chip.
    pub offset: usize,
}

/// Makes the type, its default and its table from one list.
macro_rules! params {
    ($($group:literal { $(
        #[doc = $meaning:literal]
        $name:ident = $value:expr, $unit:literal, $origin:ident $(, $why:literal)?;
    )* })*) => {
        /// Tuned numbers; lengths in metres, angles in radians, as their names say.
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
            /// Values in the released firmware.
            pub const DEFAULT: Self = Self { $($($name: $value,)*)* rules: Rules::ALL };

            /// All numbers with their descriptions, in the order of the stages that use them.
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
