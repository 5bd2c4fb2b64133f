//! Kinds of data that a port has delivered since its last intact sentence, for messages about missing sentences.

use stairscan::report::{ParseError, Sentence};

use super::lines::Splitter;
use super::talker;
use super::trouble::UnexpectedData;

/// Kind of a line that is no intact sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Damaged,
    Unknown,
    Link,
    Noise,
    Others,
}

impl Kind {
    fn of(line: &str, error: ParseError) -> Self {
        // A field is only parsed after the checksum.
        if matches!(error, ParseError::Field(_)) {
            return Self::Unknown;
        }
        // Beginning of a frame of the radar link, as the reader shows it.
        if line.contains("SR\\x01") {
            return Self::Link;
        }
        if line.contains("PSTR,") {
            return Self::Damaged;
        }
        match 8 * line.matches("\\x").count() > line.len() {
            true => Self::Noise,
            false => Self::Others,
        }
    }
}

/// Lines of a port since its last intact sentence, by kind.
#[derive(Clone, Debug, Default)]
pub struct Arrived {
    /// Number of intact sentences since the port was opened.
    pub sentences: u64,
    /// Number of damaged sentences since the port was opened.
    pub damaged: u64,
    /// Number of lines of each kind since the last intact sentence, and the last one, or the last by which its device is
    /// recognised.
    counts: [(u64, String); 5],
    pending: String,
}

impl Arrived {
    /// Counts a line, and returns whether it is an intact sentence.
    pub fn line(&mut self, line: &str) -> bool {
        self.pending.clear();
        match Sentence::parse(line) {
            Ok(_) => {
                self.sentences += 1;
                self.counts = <[_; 5]>::default();
                true
            }
            Err(error) => {
                let kind = Kind::of(line, error);
                self.damaged += u64::from(kind == Kind::Damaged);
                let (count, last) = &mut self.counts[kind as usize];
                *count += 1;
                if talker::known(last).is_none() || talker::known(line).is_some() {
                    line.clone_into(last);
                }
                false
            }
        }
    }

    /// Notes the beginning of a line whose end is overdue.
    pub fn pending(&mut self, text: &str) {
        text.clone_into(&mut self.pending);
    }

    /// Returns the same with the line that `reader` has begun, if any.
    pub fn with_pending(&self, reader: &Splitter) -> Self {
        let mut arrived = self.clone();
        if let Some(text) = reader.pending() {
            arrived.pending(&text);
        }
        arrived
    }

    /// Returns, as text, what a log has that has no intact sentence.
    pub fn instead_of_sentences(&self) -> String {
        let what = self.kind().in_a_file();
        format!("no sentence of a scanner with a right CRC-32: {what}")
    }

    /// Returns the most frequent kind of data since the last intact sentence, [`UnexpectedData::Nothing`] or
    /// [`UnexpectedData::Silence`] if there are none.
    pub fn kind(&self) -> UnexpectedData<'_> {
        let kinds = [
            Kind::Damaged,
            Kind::Unknown,
            Kind::Link,
            Kind::Noise,
            Kind::Others,
        ];
        let counted = kinds.map(|kind| (self.counts[kind as usize].0, kind));
        let most = counted.into_iter().rev().max_by_key(|(count, _)| *count);
        let (kind, line) = match most {
            Some((1.., kind)) => (kind, &self.counts[kind as usize].1),
            _ if !self.pending.is_empty() => {
                (Kind::of(&self.pending, ParseError::Frame), &self.pending)
            }
            _ if self.sentences > 0 => return UnexpectedData::Silence,
            _ => return UnexpectedData::Nothing,
        };
        match kind {
            Kind::Damaged => UnexpectedData::Damaged,
            Kind::Unknown => UnexpectedData::Unknown(line),
            Kind::Link => UnexpectedData::Link,
            Kind::Noise => UnexpectedData::Noise,
            Kind::Others => UnexpectedData::Others(line),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(bytes: &[u8]) -> String {
        let (mut arrived, mut splitter) = (Arrived::default(), Splitter::default());
        for line in splitter.push(bytes) {
            arrived.line(&line);
        }
        format!("{:?}", arrived.with_pending(&splitter).kind())
    }

    fn framed(body: &str) -> String {
        format!(
            "${body}*{:08X}\r\n",
            stairscan::report::sentence::crc32(body)
        )
    }

    #[test]
    fn nothing_is_only_said_of_nothing() {
        assert_eq!(kind(b""), "Nothing");
        assert_eq!(kind(b"\r\n\r\n"), "Nothing");
        assert_eq!(kind(b"\xfe\x80\0"), "Noise");
        assert_eq!(kind(b"login: "), "Others(\"login: \")");
        assert_eq!(kind(b"\x80SR\x01\x02\x07\0\x04\0"), "Link");
        assert_eq!(kind(b"$PSTR,LIVE,sc"), "Damaged");
        // Its checksum is of two digits: no sentence of a scanner, and not a damaged one.
        assert!(kind(b"$GPGGA,1,2*47\r\n").starts_with("Others"));
        // A line that names no device does not hide the one that does.
        assert_eq!(
            kind(b"x\n$GPGGA,1,2*47\r\ny\n"),
            "Others(\"$GPGGA,1,2*47\")"
        );
        assert_eq!(kind(b"x\ny\n"), "Others(\"y\")");
        let done = framed("PSTR,DONE,stop");
        assert_eq!(kind(done.as_bytes()), "Silence");
        let (loader, noise) = (framed("PSTR,LOADER,,0,x"), b"\xf0\x82\xff\n");
        assert!(kind(loader.as_bytes()).starts_with("Unknown"));
        // Another speed, or another device, after sentences.
        assert_eq!(kind(&[done.as_bytes(), noise].concat()), "Noise");
        assert!(kind(format!("{done}{loader}").as_bytes()).starts_with("Unknown"));
    }
}
