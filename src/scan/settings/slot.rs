//! One setting while it is read or written: as text for people, as a word for records.

use super::motor::{Driver, Encoder, WireLevel};
use crate::config::{ConfigError, EstimatorKind, Plane, Spread};
use crate::drive;
use crate::radar::module::ModuleKind;

/// Something that is on or off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Switch {
    /// It works.
    #[default]
    On,
    /// It does not.
    Off,
}

/// Which way the mirror sweeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sweeping {
    /// The first scan from the first row to the last, the next one back, and so on.
    #[default]
    Both,
    /// Always from the first row to the last.
    Forward,
    /// Always from the last row to the first.
    Backward,
}

/// How the mirror gets through the angles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SweepMode {
    /// It stands still at each of them.
    Stop,
    /// It turns at constant speed: no less accurate (docs/benchmarks.md), and faster.
    #[default]
    Continuous,
}

/// A value that is one of a few words.
trait Word: Copy + PartialEq + 'static {
    const WORDS: &'static [(&'static str, Self)];
    const EXPECTED: &'static str;

    fn word(self) -> &'static str {
        let found = Self::WORDS.iter().find(|(_, value)| *value == self);
        found.map_or("", |(word, _)| word)
    }

    fn read(text: &str) -> Option<Self> {
        let found = Self::WORDS.iter().find(|(word, _)| *word == text);
        found.map(|(_, value)| *value)
    }
}

impl Word for Plane {
    const WORDS: &'static [(&'static str, Self)] =
        &[("depth", Plane::Depth), ("height", Plane::Height)];
    const EXPECTED: &'static str = "depth or height";
}

impl Word for Spread {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("uniform", Spread::Uniform),
        ("gmm-raw", Spread::GmmRaw),
        ("gmm-cfar", Spread::GmmCfar),
    ];
    const EXPECTED: &'static str = "uniform or gmm-raw or gmm-cfar";
}

impl Word for Sweeping {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("both", Sweeping::Both),
        ("down", Sweeping::Forward),
        ("up", Sweeping::Backward),
    ];
    const EXPECTED: &'static str = "both or down or up";
}

impl Word for SweepMode {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("stop", SweepMode::Stop),
        ("continuous", SweepMode::Continuous),
    ];
    const EXPECTED: &'static str = "stop or continuous";
}

impl Word for ModuleKind {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("pstr", ModuleKind::Pstr),
        ("sirad", ModuleKind::SiRad),
        ("bgt60", ModuleKind::Bgt60),
    ];
    const EXPECTED: &'static str = "pstr or sirad or bgt60";
}

impl Word for bool {
    const WORDS: &'static [(&'static str, Self)] = &[("on", true), ("off", false)];
    const EXPECTED: &'static str = "on or off";
}

impl Word for Driver {
    const WORDS: &'static [(&'static str, Self)] =
        &[("step-dir", Driver::StepDir), ("tmc2209", Driver::Tmc2209)];
    const EXPECTED: &'static str = "step-dir or tmc2209";
}

impl Word for Encoder {
    const WORDS: &'static [(&'static str, Self)] =
        &[("none", Encoder::None), ("as5600", Encoder::As5600)];
    const EXPECTED: &'static str = "none or as5600";
}

impl Word for WireLevel {
    const WORDS: &'static [(&'static str, Self)] =
        &[("low", WireLevel::Low), ("high", WireLevel::High)];
    const EXPECTED: &'static str = "low or high";
}

impl Word for drive::Mode {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("auto", drive::Mode::Auto),
        ("required", drive::Mode::Required),
        ("standing", drive::Mode::Standing),
    ];
    const EXPECTED: &'static str = "auto or required or standing";
}

impl Word for Switch {
    const WORDS: &'static [(&'static str, Self)] = &[("on", Switch::On), ("off", Switch::Off)];
    const EXPECTED: &'static str = "on or off";
}

/// One setting while it is read or written.
pub(super) enum Slot<'a> {
    U8(&'a mut u8),
    U16(&'a mut u16),
    U32(&'a mut u32),
    I32(&'a mut i32),
    /// A probability in 1e-9.
    Nano(&'a mut f32),
    Plane(&'a mut Plane),
    Spread(&'a mut Spread),
    Sweeping(&'a mut Sweeping),
    SweepMode(&'a mut SweepMode),
    Module(&'a mut ModuleKind),
    /// Something that is on or off, as a truth value.
    Present(&'a mut bool),
    Driver(&'a mut Driver),
    Level(&'a mut WireLevel),
    Encoder(&'a mut Encoder),
    Motion(&'a mut drive::Mode),
    Switch(&'a mut Switch),
    Estimator(&'a mut EstimatorKind),
    /// What the radar module says.
    Module16(&'a mut u16),
    /// Likewise.
    Module32(&'a mut u32),
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

fn word(text: &str) -> ValueText {
    let mut value = ValueText::new();
    let _ = value.push_str(text);
    value
}

fn write_number<T: TryFrom<i64>>(
    slot: &mut T,
    field: &'static str,
    text: &str,
) -> Result<(), ConfigError> {
    let expected = "a whole number within its type";
    let value: i64 = text.parse().map_err(|_| ConfigError { field, expected })?;
    *slot = T::try_from(value).map_err(|_| ConfigError { field, expected })?;
    Ok(())
}

fn write_word<T: Word>(slot: &mut T, field: &'static str, text: &str) -> Result<(), ConfigError> {
    let expected = T::EXPECTED;
    *slot = T::read(text).ok_or(ConfigError { field, expected })?;
    Ok(())
}

impl Slot<'_> {
    pub fn text(&self) -> ValueText {
        match self {
            Slot::U8(v) => number(i64::from(**v)),
            Slot::U16(v) => number(i64::from(**v)),
            Slot::U32(v) => number(i64::from(**v)),
            Slot::I32(v) => number(i64::from(**v)),
            Slot::Nano(v) => number(i64::from((**v * 1e9 + 0.5) as u32)),
            Slot::Plane(v) => word(v.word()),
            Slot::Spread(v) => word(v.word()),
            Slot::Sweeping(v) => word(v.word()),
            Slot::SweepMode(v) => word(v.word()),
            Slot::Module(v) => word(v.word()),
            Slot::Present(v) => word(v.word()),
            Slot::Driver(v) => word(v.word()),
            Slot::Level(v) => word(v.word()),
            Slot::Encoder(v) => word(v.word()),
            Slot::Motion(v) => word(v.word()),
            Slot::Switch(v) => word(v.word()),
            Slot::Estimator(v) => word(v.as_str()),
            Slot::Module16(v) => number(i64::from(**v)),
            Slot::Module32(v) => number(i64::from(**v)),
        }
    }

    pub fn write(self, field: &'static str, text: &str) -> Result<(), ConfigError> {
        match self {
            Slot::U8(v) => write_number(v, field, text),
            Slot::U16(v) => write_number(v, field, text),
            Slot::U32(v) => write_number(v, field, text),
            Slot::I32(v) => write_number(v, field, text),
            Slot::Nano(v) => {
                let mut nano = 0_u32;
                write_number(&mut nano, field, text)?;
                *v = nano as f32 * 1e-9;
                Ok(())
            }
            Slot::Plane(v) => write_word(v, field, text),
            Slot::Spread(v) => write_word(v, field, text),
            Slot::Sweeping(v) => write_word(v, field, text),
            Slot::SweepMode(v) => write_word(v, field, text),
            Slot::Module(v) => write_word(v, field, text),
            Slot::Present(v) => write_word(v, field, text),
            Slot::Driver(v) => write_word(v, field, text),
            Slot::Level(v) => write_word(v, field, text),
            Slot::Encoder(v) => write_word(v, field, text),
            Slot::Motion(v) => write_word(v, field, text),
            Slot::Switch(v) => write_word(v, field, text),
            Slot::Estimator(v) => {
                let expected = "the name of an estimator";
                *v = EstimatorKind::from_name(text).ok_or(ConfigError { field, expected })?;
                Ok(())
            }
            Slot::Module16(_) | Slot::Module32(_) => Err(ConfigError {
                field,
                expected: "nothing: the radar module sets it",
            }),
        }
    }

    /// Every bit of the value: a number as it is, a word as its place among its kind.
    pub fn word(&self) -> u32 {
        match self {
            Slot::U8(v) => u32::from(**v),
            Slot::U16(v) | Slot::Module16(v) => u32::from(**v),
            Slot::U32(v) | Slot::Module32(v) => **v,
            Slot::I32(v) => **v as u32,
            Slot::Nano(v) => v.to_bits(),
            Slot::Plane(v) => place(**v),
            Slot::Spread(v) => place(**v),
            Slot::Sweeping(v) => place(**v),
            Slot::SweepMode(v) => place(**v),
            Slot::Module(v) => place(**v),
            Slot::Present(v) => place(**v),
            Slot::Driver(v) => place(**v),
            Slot::Level(v) => place(**v),
            Slot::Encoder(v) => place(**v),
            Slot::Motion(v) => place(**v),
            Slot::Switch(v) => place(**v),
            Slot::Estimator(v) => {
                EstimatorKind::ALL.iter().position(|k| k == *v).unwrap_or(0) as u32
            }
        }
    }

    /// Takes back what [`Slot::word`] gave; `None` for what it never gives.
    pub fn restore(self, word: u32) -> Option<()> {
        match self {
            Slot::U8(v) => *v = word.try_into().ok()?,
            Slot::U16(v) | Slot::Module16(v) => *v = word.try_into().ok()?,
            Slot::U32(v) | Slot::Module32(v) => *v = word,
            Slot::I32(v) => *v = word as i32,
            Slot::Nano(v) => *v = f32::from_bits(word),
            Slot::Plane(v) => *v = at_place(word)?,
            Slot::Spread(v) => *v = at_place(word)?,
            Slot::Sweeping(v) => *v = at_place(word)?,
            Slot::SweepMode(v) => *v = at_place(word)?,
            Slot::Module(v) => *v = at_place(word)?,
            Slot::Present(v) => *v = at_place(word)?,
            Slot::Driver(v) => *v = at_place(word)?,
            Slot::Level(v) => *v = at_place(word)?,
            Slot::Encoder(v) => *v = at_place(word)?,
            Slot::Motion(v) => *v = at_place(word)?,
            Slot::Switch(v) => *v = at_place(word)?,
            Slot::Estimator(v) => *v = *EstimatorKind::ALL.get(word as usize)?,
        }
        Some(())
    }
}

/// Where a word stands among its kind.
fn place<T: Word>(value: T) -> u32 {
    let found = T::WORDS.iter().position(|(_, v)| *v == value);
    found.unwrap_or(0) as u32
}

/// What stands there.
fn at_place<T: Word>(place: u32) -> Option<T> {
    T::WORDS.get(place as usize).map(|(_, value)| *value)
}
