//! Parser of the comma-separated fields of a sentence.

use core::fmt;

use super::frame::Tenths;
use crate::config::Plane;
use crate::verdict::{Reason, Reasons};

/// Reason why a line is not a valid sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParseError {
    /// The line does not begin with `$PSTR`, has no `*`, or has a byte that is not printable ASCII.
    Frame,
    /// The line's CRC-32 is wrong.
    Crc,
    /// The field of this name is missing or malformed.
    Field(&'static str),
}

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ParseError::Frame => f.write_str("not a $PSTR sentence"),
            ParseError::Crc => f.write_str("CRC-32 is wrong"),
            ParseError::Field(field) => write!(f, "field {field} is missing or malformed"),
        }
    }
}

impl core::error::Error for ParseError {}

/// Fields of one sentence that have not been parsed yet, from left to right.
pub struct Fields<'a>(pub core::str::Split<'a, [char; 1]>);

impl<'a> Fields<'a> {
    pub fn text(&mut self, field: &'static str) -> Result<&'a str, ParseError> {
        // A field with a framing character is invalid even if the CRC fits: two sentences that ran into each
        // other are no sentence.
        let framing = |text: &&str| text.bytes().any(|b| matches!(b, b'$' | b'*'));
        let text = self.0.next().filter(|text| !framing(text));
        text.ok_or(ParseError::Field(field))
    }

    pub fn number<T: core::str::FromStr>(&mut self, field: &'static str) -> Result<T, ParseError> {
        self.text(field)?
            .parse()
            .map_err(|_| ParseError::Field(field))
    }

    /// Parses the next field as `N` words of eight hex digits each, without separators; errors name `field`.
    pub fn hex<const N: usize>(&mut self, field: &'static str) -> Result<[u32; N], ParseError> {
        let malformed = ParseError::Field(field);
        let mut rest = self.text(field)?;
        let mut words = [0; N];
        for word in &mut words {
            let (digits, more) = rest.split_at_checked(8).ok_or(malformed)?;
            if !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
                return Err(malformed);
            }
            *word = u32::from_str_radix(digits, 16).map_err(|_| malformed)?;
            rest = more;
        }
        if rest.is_empty() {
            Ok(words)
        } else {
            Err(malformed)
        }
    }

    /// Returns whether no field remains.
    pub fn ended(&self) -> bool {
        self.0.clone().next().is_none()
    }

    /// Parses the plane of a scan, which may be missing at the end of a sentence, or empty before further fields.
    pub fn last_plane(&mut self) -> Result<Option<Plane>, ParseError> {
        let mut rest = self.0.clone();
        match (rest.next(), rest.next()) {
            (None, _) => Ok(None),
            (Some(""), Some(_)) => self.text("plane").map(|_| None),
            _ => {
                let planes = [Plane::Depth, Plane::Height];
                self.word("plane", &planes, |plane| plane.as_str())
                    .map(Some)
            }
        }
    }

    /// Parses the next field as one word of eight hex digits, such as the hash of settings; errors name `field`.
    pub fn hash(&mut self, field: &'static str) -> Result<u32, ParseError> {
        let [word] = self.hex(field)?;
        Ok(word)
    }

    /// Parses the next field as one word of eight hex digits, or an empty field as `None`; errors name `field`.
    pub fn optional_hash(&mut self, field: &'static str) -> Result<Option<u32>, ParseError> {
        match self.0.clone().next() {
            Some("") => self.text(field).map(|_| None),
            _ => self.hash(field).map(Some),
        }
    }

    pub fn word<T: Copy>(
        &mut self,
        field: &'static str,
        all: &[T],
        name: impl Fn(T) -> &'static str,
    ) -> Result<T, ParseError> {
        let text = self.text(field)?;
        all.iter()
            .copied()
            .find(|&t| name(t) == text)
            .ok_or(ParseError::Field(field))
    }

    pub fn length(&mut self, field: &'static str) -> Result<Option<Tenths>, ParseError> {
        let text = self.text(field)?;
        if text.is_empty() {
            return Ok(None);
        }
        let malformed = ParseError::Field(field);
        let (sign, digits) = match text.strip_prefix('-') {
            Some(rest) => (-1, rest),
            None => (1, text),
        };
        let (whole, tenth) = digits.split_once('.').ok_or(malformed)?;
        if tenth.len() != 1
            || whole.is_empty()
            || !digits.bytes().all(|b| b.is_ascii_digit() || b == b'.')
        {
            return Err(malformed);
        }
        let whole: i32 = whole.parse().map_err(|_| malformed)?;
        let tenth: i32 = tenth.parse().map_err(|_| malformed)?;
        let value = whole
            .checked_mul(10)
            .and_then(|v| v.checked_add(tenth))
            .ok_or(malformed)?;
        Ok(Some(Tenths(sign * value)))
    }

    pub fn reasons(&mut self, field: &'static str) -> Result<Reasons, ParseError> {
        let text = self.text(field)?;
        let mut reasons = Reasons::NONE;
        for word in text.split('+').filter(|w| !w.is_empty()) {
            let reason = Reason::ALL.iter().find(|r| r.as_str() == word);
            reasons.add(*reason.ok_or(ParseError::Field(field))?);
        }
        Ok(reasons)
    }
}
