//! Input of the report port: arbitrary bytes, each line parsed as a command. A changed setting is valid
//! and reads back with its value. A refused one changes nothing.
//!
//! A line that begins with `!` gets the required frame and CRC, so that mutations of its text are not
//! rejected by the CRC.

use stairscan::report::sentence::crc32;
use stairscan::scanner::Settings;
use stairscan::scanner::command::{self, Command, LineReader, ParserEvent};

/// Processes the lines.
pub fn run(data: &[u8]) {
    let mut reader = LineReader::default();
    let mut settings = Settings::default();
    for line in data.split_inclusive(|&b| b == b'\n') {
        let framed = framed(line);
        for &byte in framed.as_deref().unwrap_or(line) {
            if reader.push(byte) == ParserEvent::Line {
                carry_out(reader.line(), &mut settings);
            }
        }
    }
}

/// Returns a line of text after `!` within `$PSTC,` and its CRC.
pub fn framed(line: &[u8]) -> Option<Vec<u8>> {
    let text = str::from_utf8(line.strip_prefix(b"!")?).ok()?;
    let body = format!("PSTC,{}", text.trim_end_matches(['\r', '\n']));
    Some(format!("${body}*{:08X}\n", crc32(&body)).into_bytes())
}

fn carry_out(line: &str, settings: &mut Settings) {
    let before = *settings;
    match command::parse(line) {
        Ok(Command::Set(key, value)) => match settings.set(key, value) {
            Ok(()) => {
                assert_eq!(settings.validate(), Ok(()), "{line}");
                let told = settings.get(key).expect("a key that can be set");
                let mut again = before;
                assert_eq!(again.set(key, &told), Ok(()), "{line}");
                // A probability is a float in 1e-9; all other values are exact.
                assert!(key == "cfar-false-alarm" || again == *settings, "{line}");
            }
            Err(error) => {
                assert_eq!(before, *settings, "{line}");
                assert!(!error.expected.is_empty());
            }
        },
        Ok(Command::Get(key)) => assert!(settings.get(key).is_some(), "{line}"),
        Ok(_) => {}
        Err(bad) => assert!(!bad.error.field.is_empty() && !bad.error.expected.is_empty()),
    }
}
