//! Builder of a sentence's line.

use super::frame::{Line, MAX_SENTENCE, PREFIX, Tenths, crc32};
use crate::setting::hex;
use crate::verdict::Reasons;

/// Builds one line field by field. A line that would be too long is truncated; the CRC still covers what is
/// left.
pub struct Writer {
    line: Line,
}

impl Writer {
    /// Number of bytes reserved for `*`, the CRC and the line end.
    const TAIL: usize = 11;
    /// Number of bytes reserved for the fields after a scan's reasons: horizon, confidence, number of maybes,
    /// settings, number of drops, plane, and slope.
    const AFTER_REASONS: usize = 57;

    pub fn new(name: &str) -> Self {
        Self::behind(PREFIX, name)
    }

    /// Begins the sentence `name` with another prefix than the scanner's own `$PSTR,`.
    #[inline(never)]
    pub fn behind(prefix: &str, name: &str) -> Self {
        let mut writer = Self { line: Line::new() };
        writer.raw(prefix);
        writer.raw(name);
        writer
    }

    // Out of line: the image's flash is short, and a sentence takes milliseconds on the wire.
    #[inline(never)]
    fn push(&mut self, c: char) {
        if self.line.len() + Self::TAIL < MAX_SENTENCE {
            let _ = self.line.push(c);
        }
    }

    #[inline(never)]
    fn raw(&mut self, text: &str) {
        text.chars().for_each(|c| self.push(c));
    }

    /// Appends a field of free text; characters that would break the frame become spaces.
    #[inline(never)]
    pub fn text(mut self, text: &str) -> Self {
        self.push(',');
        for c in text.chars() {
            let plain = (' '..='~').contains(&c) && !matches!(c, ',' | '*' | '$');
            self.push(if plain { c } else { ' ' });
        }
        self
    }

    #[inline(never)]
    fn digits(&mut self, mut value: u32) {
        let mut reversed = [b'0'; 10];
        let mut count = 0;
        for slot in &mut reversed {
            *slot = b'0' + (value % 10) as u8;
            value /= 10;
            count += 1;
            if value == 0 {
                break;
            }
        }
        for &digit in reversed.iter().take(count).rev() {
            self.push(char::from(digit));
        }
    }

    #[inline(never)]
    pub fn number(mut self, value: u32) -> Self {
        self.push(',');
        self.digits(value);
        self
    }

    /// Appends a field with a whole number and its sign, or an empty field for `None`.
    #[inline(never)]
    pub fn integer(mut self, value: Option<i32>) -> Self {
        self.push(',');
        if let Some(value) = value {
            if value < 0 {
                self.push('-');
            }
            self.digits(value.unsigned_abs());
        }
        self
    }

    #[inline(never)]
    pub fn length(mut self, value: Option<Tenths>) -> Self {
        self.push(',');
        if let Some(Tenths(tenths)) = value {
            if tenths < 0 {
                self.push('-');
            }
            let magnitude = tenths.unsigned_abs();
            self.digits(magnitude / 10);
            self.push('.');
            self.digits(magnitude % 10);
        }
        self
    }

    #[inline(never)]
    pub fn reasons(mut self, reasons: Reasons) -> Self {
        self.push(',');
        let mut first = true;
        for reason in reasons.iter() {
            // The fields that follow must fit, too. The rarest reasons are last and are left out first.
            let length = self.line.len() + 1 + reason.as_str().len();
            if length + Self::AFTER_REASONS + Self::TAIL > MAX_SENTENCE {
                break;
            }
            if !first {
                self.push('+');
            }
            first = false;
            self.raw(reason.as_str());
        }
        self
    }

    /// Appends a field of words, eight hex digits each, without separators.
    #[inline(never)]
    pub fn hex(mut self, words: &[u32]) -> Self {
        self.push(',');
        for &word in words {
            if self.line.len() + 8 + Self::TAIL <= MAX_SENTENCE {
                push_hex(&mut self.line, word);
            }
        }
        self
    }

    /// Appends a field of one word, eight hex digits, or an empty field for `None`.
    pub fn word(self, word: Option<u32>) -> Self {
        match word {
            Some(word) => self.hex(&[word]),
            None => self.text(""),
        }
    }

    /// Appends the last field of a sentence, which may be a line of its own with commas.
    #[inline(never)]
    pub fn rest(mut self, text: &str) -> Self {
        self.push(',');
        for c in text.chars() {
            self.push(if (' '..='~').contains(&c) { c } else { ' ' });
        }
        self
    }

    #[inline(never)]
    pub fn finish(mut self) -> Line {
        let crc = crc32(self.line.get(1..).unwrap_or(""));
        let _ = self.line.push('*');
        push_hex(&mut self.line, crc);
        let _ = self.line.push_str("\r\n");
        self.line
    }
}

/// Appends `word` as eight upper-case hex digits, the highest first.
fn push_hex(line: &mut Line, word: u32) {
    let _ = line.push_str(&hex(word));
}
