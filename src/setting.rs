//! One setting: its row in the table of all settings, and its value as text and as a 32-bit word of a stored
//! record.
//!
//! A row is declared with its field in `settings!`, which makes from it the field, default, key, unit, limits,
//! meaning, and whether it enters the hash. This module is separate from [`crate::config`] because the settings
//! of the radar module and the motor use it, too.

use core::fmt;

/// Error for a value that is out of its range, or that the scanner cannot use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConfigError {
    /// The field, by the name that commands and messages use.
    pub field: &'static str,
    /// Permitted values, for the message.
    pub expected: &'static str,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: expected {}", self.field, self.expected)
    }
}

impl core::error::Error for ConfigError {}

/// Returns an error with `field` and `expected` unless `ok`.
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

/// Effect of a setting on a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    /// Changes the answer of a scan: it enters the hash.
    Answer,
    /// Changes the answer of a scan; a value of 1 is left out of the hash, which is then that of earlier firmware.
    AnswerUnlessOne,
    /// Changes speed, timeouts or hardware of a scan, or states who calibrated it.
    Operation,
    /// None: the radar module reports the value at every scan, and no command sets it.
    Module,
}

/// Row of one setting in the table of all settings, without its meaning, which is not part of the image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SettingRow {
    /// Name of the setting in commands.
    pub key: &'static str,
    /// Unit of the setting; empty for words and dimensionless numbers. Only the table in `docs/user/hardware.md` needs it.
    #[cfg(test)]
    pub unit: &'static str,
    /// Minimum and maximum of the setting's value as a whole number of its unit.
    pub limits: (i64, i64),
    /// Permitted values of the setting as text, for messages.
    pub expected: &'static str,
    /// Effect of the setting on a scan.
    pub effect: Effect,
}

impl SettingRow {
    /// Checks that `value` is within the limits.
    pub fn check(&self, value: &dyn Value) -> Result<(), ConfigError> {
        let (least, most) = self.limits;
        check(
            (least..=most).contains(&value.number()),
            self.key,
            self.expected,
        )
    }

    /// Parses `text` into `value`. An error names the setting and its permitted values; settings of the radar module
    /// accept none.
    pub fn read(&self, value: &mut dyn Value, text: &str) -> Result<(), ConfigError> {
        let (field, mut expected) = (self.key, self.expected);
        if self.effect == Effect::Module {
            expected = "no value: reported by the radar module";
        } else if value.read(text).is_some() {
            return Ok(());
        }
        Err(ConfigError { field, expected })
    }
}

/// A value as text: a word or a number.
pub type ValueText = heapless::String<16>;

/// Formats a number digit by digit, without `core::fmt`.
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

/// Formats a word as eight upper-case hex digits, the highest first.
pub(crate) fn hex(word: u32) -> ValueText {
    let mut text = ValueText::new();
    for shift in (0..8).rev() {
        let digit = (word >> (4 * shift)) as u8 & 15;
        let first = if digit < 10 { b'0' } else { b'A' - 10 };
        let _ = text.push(char::from(first + digit));
    }
    text
}

/// The value of a setting, with its forms as number, text and 32-bit word.
pub(crate) trait Value {
    /// Returns the value as a number in its unit, to which the limits apply; for a word its index, from 0.
    fn number(&self) -> i64;
    /// Returns the value as text.
    fn text(&self) -> ValueText {
        number(self.number())
    }
    /// Parses the text of [`Value::text`]; `None`, without a change, for any other text.
    fn read(&mut self, text: &str) -> Option<()>;
    /// Returns the value as a 32-bit word of a record, without loss.
    fn word(&self) -> u32 {
        self.number() as u32
    }
    /// Restores the value from [`Value::word`]; `None` for a word that it never returns.
    fn restore(&mut self, word: u32) -> Option<()>;
}

/// The type of a setting.
pub(crate) trait Setting: Value + Sized {
    /// Permitted values of a setting without limits, as text for messages.
    const EXPECTED: &'static str = "a whole number within its type";
    /// Value of the setting whose bits are all zero.
    const EMPTY: Self;
}

/// Implements the traits of a setting for whole numbers; `$wide` is the 32-bit type of the same sign.
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

/// Number of the units of a probability's text, 1e-9, in a probability of 1.
const BILLION: f32 = 1e9;

/// A setting that is a probability; its text is in units of 1e-9.
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
    /// Words in the order of their indices; the first one has all bits zero.
    const WORDS: &'static [(&'static str, Self)];
    /// List of the words, for messages.
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

/// Assigns words to the values of a type.
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
/// - `parts`: nested structures of settings, whose rows come first;
/// - `rows`: `field: type = default, "key" "unit" [smallest to largest] Effect;` below the setting's meaning;
/// - `also`: other fields.
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
            /// Keys of all settings, in the order of the command `get`.
            pub const KEYS: &'static [&'static str] =
                &$crate::setting::joined::<{ Self::COUNT }>(&[$(<$inner>::KEYS,)* Self::OWN_KEYS]);

            /// Every setting at its default.
            pub const DEFAULT: Self = Self {
                $($part: <$inner>::DEFAULT,)*
                $($field: $default,)*
                $($also: $value,)*
            };

            /// All bits zero, no valid configuration: initial value of statics before the first scan.
            pub const EMPTY: Self = Self {
                $($part: <$inner>::EMPTY,)*
                $($field: <$type as $crate::setting::Setting>::EMPTY,)*
                $($also: <$kind as $crate::setting::Setting>::EMPTY,)*
            };

            /// Calls `see` with every setting's row and value, in the order of the keys.
            // Not inlined: inlined into each of its callers, with what they do, a hundred settings take 20 KB
            // of flash.
            #[inline(never)]
            pub(crate) fn see(&self, see: &mut dyn FnMut(&'static $crate::setting::SettingRow, &dyn $crate::setting::Value)) {
                $( self.$part.see(see); )*
                $( {
                    const ROW: $crate::setting::SettingRow =
                        $crate::setting::settings!(@row $type, $key $unit [$($least $most)?] $effect);
                    see(&ROW, &self.$field);
                } )*
            }

            /// Calls `see` with every setting's row and value, which may be changed.
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

            /// Calls `see` with every setting's meaning, in the order of the keys.
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

/// Concatenates lists of keys at compile time; `N` is their total number.
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
