//! Report sentences as a controller reads them: any text, each line by itself. What is read is written again
//! as a line that reads as the same.
//!
//! A line that begins with `!` gets the frame and the CRC that it needs.

use stairscan::report::Sentence;
use stairscan::report::sentence::crc32;

/// Reads the lines.
pub fn run(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    for line in text.split('\n') {
        match line.strip_prefix('!') {
            Some(body) => read(&framed(body)),
            None => read(line),
        }
    }
}

/// The sentence with this text between `$` and `*`.
pub fn framed(body: &str) -> String {
    format!("${body}*{:08X}", crc32(body))
}

fn read(line: &str) {
    let Ok(sentence) = Sentence::parse(line) else {
        return;
    };
    let written = sentence.write();
    // Text that the scanner never writes may be longer than a line of its own, or hold what is not printed;
    // such is written as spaces.
    let text = line.trim_end_matches(['\r', '\n']);
    let plain = text.bytes().all(|b| matches!(b, b' '..=b'~'));
    if plain && line.len() <= written.len() {
        assert_eq!(Sentence::parse(&written), Ok(sentence), "{line}");
    }
}
