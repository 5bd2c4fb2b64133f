//! Splits the bytes of a port into lines.

/// Maximum length of a line, bytes; longer ones are cut. A sentence has at most 224 bytes, so that a longer line
/// is noise or from another device.
const LONGEST: usize = 512;

/// Collects received bytes into lines.
#[derive(Clone, Debug, Default)]
pub struct Splitter {
    partial: Vec<u8>,
}

impl Splitter {
    /// Returns the lines that `bytes` complete, without line ends. Bytes that are not printable ASCII are shown
    /// as `\xNN`.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<String> {
        let mut lines = Vec::new();
        for &byte in bytes {
            if matches!(byte, b'\r' | b'\n') {
                lines.extend(self.take());
                continue;
            }
            self.partial.push(byte);
            if self.partial.len() == LONGEST {
                lines.extend(self.take());
            }
        }
        lines
    }

    /// Removes and returns the beginning of a line whose end has not been received; `None` if there is none.
    pub fn take(&mut self) -> Option<String> {
        let bytes = std::mem::take(&mut self.partial);
        (!bytes.is_empty()).then(|| shown(&bytes))
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
        assert_eq!(splitter.take().as_deref(), Some("x\\xff"));
        assert_eq!(splitter.take(), None);
        let noise = splitter.push(&[b'U'; 2 * LONGEST]);
        assert_eq!(
            noise.iter().map(String::len).collect::<Vec<_>>(),
            [LONGEST, LONGEST]
        );
    }
}
