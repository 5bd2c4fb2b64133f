//! One setting: its row in the table of all, and its value as text and as a record's word.
//!
//! A row stands where the field is declared, in `settings!`: from it come the field, its default, key, unit,
//! limits, meaning, and whether it enters the hash. It is apart from [`crate::config`] because the radar module's
//! and the motor's settings are declared with them.

use core::fmt;

/// A value that the scanner cannot work with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConfigError {
    /// The field, by the name that commands and messages use.
    pub field: &'static str,
    /// What was expected of it.
    pub expected: &'static str,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: expected {}", self.field, self.expected)
    }
}

impl core::error::Error for ConfigError {}

/// Fails with `field` and `expected` unless `ok`.
pub(crate) fn check(
    ok: bool,
    field: &'static str,
    expected: &'static str,
) -> Result<(), ConfigError> {
    if ok {
        Ok(())
    } else {
        Err(ConfigError { field, expected })
    }
}

/// What a setting acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    /// What comes of a scan: it enters the hash.
    Answer,
    /// How fast, how patiently and with what hardware a scan is made, or who calibrated it.
    Pace,
    /// Nothing: the radar module says it at every scan, and no command sets it.
    Module,
}

/// The table's row of one setting, but for its meaning, which the image leaves out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SettingRow {
    /// Its name in commands.
    pub key: &'static str,
    /// Its unit; empty for words and mere numbers. Only the table in `docs/hardware.md` needs it.
    #[cfg(test)]
    pub unit: &'static str,
    /// Smallest and largest value.
    pub limits: (i64, i64),
    /// The values that it may have, for messages.
    pub expected: &'static str,
    /// What it acts on.
    pub effect: Effect,
}

impl SettingRow {
    /// Fails unless `value` is within the limits.
    pub fn check(&self, value: &dyn Value) -> Result<(), ConfigError> {
        let (least, most) = self.limits;
        check(
            (least..=most).contains(&value.number()),
            self.key,
            self.expected,
        )
    }

    /// Reads `text` into `value`.
    pub fn read(&self, value: &mut dyn Value, text: &str) -> Result<(), ConfigError> {
        let (field, mut expected) = (self.key, self.expected);
        if self.effect == Effect::Module {
            expected = "nothing: the radar module sets it";
        } else if value.read(text).is_some() {
            return Ok(());
        }
        Err(ConfigError { field, expected })
    }
}

/// A value as text: a word or a number.
pub type ValueText = heapless::String<16>;

/// Writes a number digit by digit, without `core::fmt`.
pub(crate) fn number(value: i64) -> ValueText {
    let mut text = ValueText::new();
    if value < 0 {
        let _ = text.push('-');
    }
    let mut rest = value.unsigned_abs();
    let mut digits = heapless::Vec::<u8, 20>::new();
    loop {
        let _ = digits.push(b'0' + (rest % 10) as u8);
        rest /= 10;
        if rest == 0 {
            break;
        }
    }
    for &digit in digits.iter().rev() {
        let _ = text.push(char::from(digit));
    }
    text
}

/// The value of a setting.
pub(crate) trait Value {
    /// As a number in its unit: what the limits are for. A word is its place in the list of its kind, from 0.
    fn number(&self) -> i64;
    /// As text.
    fn text(&self) -> ValueText {
        number(self.number())
    }
    /// Takes what [`Value::text`] gives; `None`, and nothing changed, for anything else.
    fn read(&mut self, text: &str) -> Option<()>;
    /// Every bit of it.
    fn word(&self) -> u32 {
        self.number() as u32
    }
    /// Takes back what [`Value::word`] gave; `None` for what it never gives.
    fn restore(&mut self, word: u32) -> Option<()>;
}

/// The type of a setting.
pub(crate) trait Setting: Value + Sized {
    /// What a row without limits expects.
    const EXPECTED: &'static str = "a whole number within its type";
    /// All bits zero.
    const EMPTY: Self;
}

/// Whole numbers; `$wide` is as wide as a record's word and of the same sign.
macro_rules! integers {
    ($($type:ident $wide:ident),*) => { $(
        impl Value for $type {
            fn number(&self) -> i64 {
                i64::from(*self)
            }
            fn read(&mut self, text: &str) -> Option<()> {
                *self = text.parse::<i64>().ok()?.try_into().ok()?;
                Some(())
            }
            fn restore(&mut self, word: u32) -> Option<()> {
                *self = (word as $wide).try_into().ok()?;
                Some(())
            }
        }
        impl Setting for $type {
            const EMPTY: Self = 0;
        }
    )* };
}
integers!(u8 u32, u16 u32, u32 u32, i32 i32);

/// Denominator of the fractions that text holds.
const BILLION: f32 = 1e9;

/// A probability, as text in 1e-9.
impl Value for f32 {
    fn number(&self) -> i64 {
        i64::from((*self * BILLION + 0.5) as u32)
    }
    fn read(&mut self, text: &str) -> Option<()> {
        let mut nano = 0u32;
        nano.read(text)?;
        *self = nano as f32 * 1e-9;
        Some(())
    }
    fn word(&self) -> u32 {
        self.to_bits()
    }
    fn restore(&mut self, word: u32) -> Option<()> {
        *self = f32::from_bits(word);
        Some(())
    }
}

impl Setting for f32 {
    const EMPTY: Self = 0.0;
}

/// A value that is one of a few words.
pub(crate) trait Word: Copy + PartialEq + 'static {
    /// The words in the order of their places; the first is the value of zero bits.
    const WORDS: &'static [(&'static str, Self)];
    /// The words, for messages.
    const ONE_OF: &'static str;
}

impl<T: Word> Value for T {
    fn number(&self) -> i64 {
        let place = T::WORDS.iter().position(|(_, value)| value == self);
        place.unwrap_or(0) as i64
    }
    fn text(&self) -> ValueText {
        let found = T::WORDS.iter().find(|(_, value)| value == self);
        let word = found.map_or("", |(word, _)| word);
        ValueText::try_from(word).unwrap_or_default()
    }
    fn read(&mut self, text: &str) -> Option<()> {
        *self = T::WORDS.iter().find(|(word, _)| *word == text)?.1;
        Some(())
    }
    fn restore(&mut self, word: u32) -> Option<()> {
        *self = T::WORDS.get(word as usize)?.1;
        Some(())
    }
}

impl<T: Word> Setting for T {
    const EXPECTED: &'static str = T::ONE_OF;
    const EMPTY: Self = T::WORDS[0].1;
}

/// Gives the values of a type their words.
macro_rules! words {
    ($type:ty: $first:literal $value:expr $(, $word:literal $other:expr)*) => {
        impl $crate::setting::Word for $type {
            const WORDS: &'static [(&'static str, Self)] = &[($first, $value) $(, ($word, $other))*];
            const ONE_OF: &'static str = concat!($first $(, " or ", $word)*);
        }
    };
}
pub(crate) use words;

words!(bool: "off" false, "on" true);

/// Declares a structure of settings:
///
/// - `parts`: structures of settings within it, whose rows come first;
/// - `rows`: `field: type = default, "key" "unit" [smallest to largest] Effect;` under the setting's meaning;
/// - `also`: what is no setting.
///
/// Lengths are in 0.01 mm and angles in 0.001° throughout.
macro_rules! settings {
    (
        $(#[$of_type:meta])*
        pub struct $name:ident
        parts { $( $(#[$of_part:meta])* $part:ident: $inner:ty; )* }
        rows { $(
            $(#[doc = $meaning:literal])+
            $field:ident: $type:ty = $default:expr,
                $key:literal $unit:literal [$($least:literal to $most:literal)?] $effect:ident;
        )* }
        also { $( $(#[$of_also:meta])* $also:ident: $kind:ty = $value:expr; )* }
    ) => {
        $(#[$of_type])*
        pub struct $name {
            $( $(#[$of_part])* pub $part: $inner, )*
            $( $(#[doc = $meaning])+ pub $field: $type, )*
            $( $(#[$of_also])* pub $also: $kind, )*
        }

        impl $name {
            const OWN_KEYS: &'static [&'static str] = &[$($key),*];
            const COUNT: usize = Self::OWN_KEYS.len() $(+ <$inner>::KEYS.len())*;
            /// Every key, in the order in which `get` lists them.
            pub const KEYS: &'static [&'static str] =
                &$crate::setting::joined::<{ Self::COUNT }>(&[$(<$inner>::KEYS,)* Self::OWN_KEYS]);

            /// Every setting at its default.
            pub const DEFAULT: Self = Self {
                $($part: <$inner>::DEFAULT,)*
                $($field: $default,)*
                $($also: $value,)*
            };

            /// Every bit zero, valid for nothing: what statics hold before the first scan.
            pub const EMPTY: Self = Self {
                $($part: <$inner>::EMPTY,)*
                $($field: <$type as $crate::setting::Setting>::EMPTY,)*
                $($also: <$kind as $crate::setting::Setting>::EMPTY,)*
            };

            /// Hands every setting's row and value to `see`, in the order of the keys.
            // Out of line: inlined into each of its callers, with what they do, a hundred settings take 20 KB of flash.
            #[inline(never)]
            pub(crate) fn see(&self, see: &mut dyn FnMut(&'static $crate::setting::SettingRow, &dyn $crate::setting::Value)) {
                $( self.$part.see(see); )*
                $( {
                    const ROW: $crate::setting::SettingRow =
                        $crate::setting::settings!(@row $type, $key $unit [$($least $most)?] $effect);
                    see(&ROW, &self.$field);
                } )*
            }

            /// The same, with values that may be changed.
            #[inline(never)]
            pub(crate) fn each(&mut self, see: &mut dyn FnMut(&'static $crate::setting::SettingRow, &mut dyn $crate::setting::Value)) {
                $( self.$part.each(see); )*
                $( {
                    const ROW: $crate::setting::SettingRow =
                        $crate::setting::settings!(@row $type, $key $unit [$($least $most)?] $effect);
                    see(&ROW, &mut self.$field);
                } )*
            }

            /// Checks every setting against its limits.
            pub fn limits(&self) -> Result<(), $crate::setting::ConfigError> {
                let mut found = Ok(());
                self.see(&mut |row, value| {
                    if found.is_ok() {
                        found = row.check(value);
                    }
                });
                found
            }

            /// Hands every key's meaning to `see`, in the order of the keys.
            #[cfg(test)]
            pub(crate) fn meanings(see: &mut dyn FnMut(&'static str)) {
                $( <$inner>::meanings(see); )*
                $( see(concat!($($meaning),+)); )*
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self::DEFAULT
            }
        }
    };
    (@row $type:ty, $key:literal $unit:literal [$($least:literal $most:literal)?] $effect:ident) => {
        $crate::setting::SettingRow {
            key: $key,
            #[cfg(test)]
            unit: $unit,
            limits: $crate::setting::settings!(@limits $($least $most)?),
            expected: $crate::setting::settings!(@expected $type, $unit $(, $least $most)?),
            effect: $crate::setting::Effect::$effect,
        }
    };
    (@limits) => { (i64::MIN, i64::MAX) };
    (@limits $least:literal $most:literal) => { ($least, $most) };
    (@expected $type:ty, $unit:literal) => { <$type as $crate::setting::Setting>::EXPECTED };
    (@expected $type:ty, $unit:literal, $least:literal $most:literal) => {
        concat!($least, " to ", $most, " (", $unit, ")")
    };
}
pub(crate) use settings;

/// Joins lists of `N` keys together, at compile time.
pub(crate) const fn joined<const N: usize>(parts: &[&[&'static str]]) -> [&'static str; N] {
    let (mut all, mut at, mut part) = ([""; N], 0, 0);
    while part < parts.len() {
        let mut k = 0;
        while k < parts[part].len() {
            all[at] = parts[part][k];
            (at, k) = (at + 1, k + 1);
        }
        part += 1;
    }
    all
}
