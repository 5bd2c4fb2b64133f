//! Report sentences as a controller reads them: arbitrary text, line by line. A parsed sentence is written
//! as a line that parses to the same one.
//!
//! A line that begins with `!` gets the required frame and CRC.

use stairscan::report::Sentence;
use stairscan::report::sentence::crc32;

/// Processes the lines.
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

/// Returns the sentence with this text between `$` and `*`.
pub fn framed(body: &str) -> String {
    format!("${body}*{:08X}", crc32(body))
}

fn read(line: &str) {
    let Ok(sentence) = Sentence::parse(line) else {
        return;
    };
    let written = sentence.write();
    // Text that the scanner never writes may be too long for a line, or contain unprintable characters,
    // which are written as spaces.
    let text = line.trim_end_matches(['\r', '\n']);
    let plain = text.bytes().all(|b| matches!(b, b' '..=b'~'));
    if plain && line.len() <= written.len() {
        assert_eq!(Sentence::parse(&written), Ok(sentence), "{line}");
    }
}
