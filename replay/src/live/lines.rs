//! The reader of the report: splits the bytes of a port or a log into lines, by the rules of `controller/stairscan.c`.
//!
//! CR or LF ends a line; `$` begins one anew, except after a space in a sentence: `FAIL` offers a command's whole
//! sentence there. So a byte before `$`, noise, or a line without its end costs that line only; [`NO_END`] then follows
//! it.

use stairscan::report::sentence::MAX_SENTENCE;

/// Mark of a line that begins like a sentence and has no end, so that it is none.
pub const NO_END: &str = "…";

/// Collects received bytes into lines.
#[derive(Clone, Debug, Default)]
pub struct Splitter {
    partial: Vec<u8>,
}

impl Splitter {
    /// Returns the lines that `bytes` complete, without line ends: sentences, and separately whatever is between them. A
    /// line that is longer than a sentence is cut. Bytes that are not printable ASCII are shown as `\xNN`.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<String> {
        let mut lines = Vec::new();
        for &byte in bytes {
            match byte {
                b'\r' | b'\n' => {
                    lines.extend(self.take());
                    continue;
                }
                b'$' if !self.continues() => {
                    let begun = self.partial.first() == Some(&b'$');
                    let end = if begun { NO_END } else { "" };
                    lines.extend(self.take().map(|line| line + end));
                }
                _ => {}
            }
            self.partial.push(byte);
            if self.partial.len() > MAX_SENTENCE {
                lines.extend(self.take());
            }
        }
        lines
    }

    /// Whether a `$` continues the line.
    fn continues(&self) -> bool {
        self.partial.first() == Some(&b'$') && self.partial.last() == Some(&b' ')
    }

    /// Returns the beginning of a line whose end has not been received; `None` if there is none.
    pub fn pending(&self) -> Option<String> {
        (!self.partial.is_empty()).then(|| shown(&self.partial))
    }

    /// Removes and returns the beginning of a line whose end has not been received; `None` if there is none.
    pub fn take(&mut self) -> Option<String> {
        let pending = self.pending();
        self.partial.clear();
        pending
    }
}

/// Returns `bytes` as text; those that are not printable ASCII as `\xNN`.
fn shown(bytes: &[u8]) -> String {
    let mut text = String::new();
    for &byte in bytes {
        match byte {
            b' '..=b'~' => text.push(char::from(byte)),
            _ => text.push_str(&format!("\\x{byte:02x}")),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_whole_however_they_were_cut() {
        let mut splitter = Splitter::default();
        assert_eq!(splitter.push(b"\r\nab"), Vec::<String>::new());
        assert_eq!(splitter.push(b"c\r\nd\n\nx\xff"), ["abc", "d"]);
        assert_eq!(splitter.pending().as_deref(), Some("x\\xff"));
        assert_eq!(splitter.take().as_deref(), Some("x\\xff"));
        assert_eq!(splitter.take(), None);
        let noise = splitter.push(&[b'U'; 2 * MAX_SENTENCE + 2]);
        let lengths: Vec<usize> = noise.iter().map(String::len).collect();
        assert_eq!(lengths, [MAX_SENTENCE + 1; 2]);
    }

    #[test]
    fn a_dollar_begins_anew_unless_fail_offers_a_sentence() {
        let offer = "$PSTR,FAIL,-,crc,send $PSTC,stop*1";
        let lines = |text: &str| Splitter::default().push(text.as_bytes());
        assert_eq!(lines("\0$a\n"), ["\\x00", "$a"]);
        assert_eq!(lines("at 12.5 $a$b\r"), ["at 12.5 ", "$a…", "$b"]);
        assert_eq!(lines(&format!("{offer}\n$c\n")), [offer, "$c"]);
    }
}
