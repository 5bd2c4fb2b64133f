//! Parser of the SiRad's byte stream. It stores no frame, only the value being received.
//!
//! | frame | binary | text |
//! |---|---|---|
//! | raw | `AA AA BB CC`, `M`, u16 counter, u16 n, n × i16, CR LF; little-endian | `!M`, TAB counter, TAB n, n × TAB value, CR LF; decimal |
//! | status | | `!U`, format, gain, then in hexadecimal digits 4 accuracy, 4 greatest range, 4 ramp time, 4 bandwidth, 4 time, CR LF |
//! | error | | `!E`, flags in hexadecimal digits, CR LF |
//! | system info | | `!I`, text, CR LF |
//!
//! n is the number of values, I and Q counted separately: a sample is I, then Q. All other bytes are skipped.

use crate::config::MAX_SAMPLES;

const SYNC: u32 = 0xAAAA_BBCC;
/// Maximum number of values of a raw frame, I and Q counted separately.
const MAX_VALUES: u16 = 2 * MAX_SAMPLES as u16;
/// Maximum length of a text frame that is parsed, except raw frames.
const MAX_TEXT_LENGTH: u16 = 100;
/// Position of the bandwidth in a status frame, characters after its letter.
const BANDWIDTH: core::ops::Range<u16> = 14..18;

/// Event that a received byte completes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReaderEvent {
    /// A value of the raw frame: its index from 0 (I, Q, I, Q …), and the value.
    Value(u16, i16),
    /// End of a raw frame.
    Raw {
        /// Counter of the frame.
        counter: u16,
        /// Number of its values.
        count: u16,
    },
    /// Invalid bytes after the beginning of a raw frame.
    Broken,
    /// A status frame: the bandwidth in steps of 2 MHz, negative for a downward ramp.
    Bandwidth(i16),
    /// An error frame: its flags.
    Error(u32),
    /// The module's info, in answer to a request.
    Info,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum ReaderState {
    #[default]
    Hunt,
    Head,
    Data,
    End,
    Table,
    Status,
    Error,
    Info,
}

/// Parser of bytes into [`ReaderEvent`]s.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reader {
    state: ReaderState,
    /// The last four bytes, the latest in the lowest bits.
    recent: u32,
    /// Number of bytes, values or characters in this part of the frame so far.
    at: u16,
    /// Number that is being received, from its bytes or digits so far.
    number: u32,
    /// Whether the value has a digit.
    digits: bool,
    /// Whether the value has a minus sign.
    minus: bool,
    /// Counter of the raw frame (`counter`), and its number of values (`count`), as given in its head.
    counter: u16,
    count: u16,
}

impl Reader {
    /// Initial state, before any frame.
    pub const fn new() -> Self {
        Self {
            state: ReaderState::Hunt,
            recent: 0,
            at: 0,
            number: 0,
            digits: false,
            minus: false,
            counter: 0,
            count: 0,
        }
    }

    /// Returns whether a raw frame has begun.
    pub fn in_raw(&self) -> bool {
        matches!(
            self.state,
            ReaderState::Data | ReaderState::End | ReaderState::Table
        )
    }

    /// Takes the next byte. Returns the event that it completes, if any.
    pub fn push(&mut self, byte: u8) -> Option<ReaderEvent> {
        let before = self.recent;
        self.recent = before << 8 | u32::from(byte);
        match self.state {
            ReaderState::Hunt => {
                self.hunt(before, byte);
                None
            }
            ReaderState::Head => self.head(byte),
            ReaderState::Data => self.data(),
            ReaderState::End => self.end(byte),
            ReaderState::Table => self.table(byte),
            ReaderState::Status | ReaderState::Error | ReaderState::Info => self.text(byte),
        }
    }

    fn hunt(&mut self, before: u32, byte: u8) {
        let state = match (before, byte) {
            (SYNC, b'M') => ReaderState::Head,
            (_, letter) if before as u8 == b'!' => match letter {
                b'M' => ReaderState::Table,
                b'U' => ReaderState::Status,
                b'E' => ReaderState::Error,
                b'I' => ReaderState::Info,
                _ => return,
            },
            _ => return,
        };
        self.enter(state);
    }

    fn enter(&mut self, state: ReaderState) {
        (self.state, self.at) = (state, 0);
        (self.number, self.digits, self.minus) = (0, false, false);
    }

    /// Ends the frame with `event`.
    fn leave(&mut self, event: ReaderEvent) -> Option<ReaderEvent> {
        self.state = ReaderState::Hunt;
        Some(event)
    }

    /// Ends a raw frame of `count` values.
    fn leave_raw(&mut self, count: u16) -> Option<ReaderEvent> {
        self.leave(ReaderEvent::Raw {
            counter: self.counter,
            count,
        })
    }

    fn head(&mut self, byte: u8) -> Option<ReaderEvent> {
        self.number = self.number >> 8 | u32::from(byte) << 24;
        self.at += 1;
        if self.at < 4 {
            return None;
        }
        (self.counter, self.count) = (self.number as u16, (self.number >> 16) as u16);
        if self.count > MAX_VALUES {
            return self.leave_raw(self.count);
        }
        self.enter(if self.count == 0 {
            ReaderState::End
        } else {
            ReaderState::Data
        });
        None
    }

    fn data(&mut self) -> Option<ReaderEvent> {
        let (at, odd) = (self.at / 2, self.at % 2 == 1);
        self.at += 1;
        if !odd {
            return None;
        }
        // The low byte was received first.
        let value = (self.recent as u16).swap_bytes() as i16;
        if at + 1 == self.count {
            self.enter(ReaderState::End);
        }
        Some(ReaderEvent::Value(at, value))
    }

    fn end(&mut self, byte: u8) -> Option<ReaderEvent> {
        self.at += 1;
        match (self.at, byte) {
            (1, b'\r') => None,
            (2, b'\n') => self.leave_raw(self.count),
            _ => self.leave(ReaderEvent::Broken),
        }
    }

    fn table(&mut self, byte: u8) -> Option<ReaderEvent> {
        match byte {
            b'-' if !self.digits => self.minus = true,
            b'0'..=b'9' => {
                let digit = u32::from(byte - b'0');
                self.number = (self.number * 10 + digit).min(0xFFFF);
                self.digits = true;
            }
            b'\t' | b'\r' if self.digits => return self.cell(),
            b'\t' | b'\r' => {}
            b'\n' if self.at == self.count.saturating_add(2) => {
                return self.leave_raw(self.count);
            }
            _ => return self.leave(ReaderEvent::Broken),
        }
        None
    }

    /// Ends a number of a raw frame in text form: the counter, the number of values, or a value, which is
    /// returned as an event.
    fn cell(&mut self) -> Option<ReaderEvent> {
        let number = self.number;
        let limited = number.min(0x7FFF) as i16;
        let value = if self.minus { -limited } else { limited };
        let at = self.at;
        self.enter(ReaderState::Table);
        self.at = at.saturating_add(1);
        match at {
            0 => self.counter = number as u16,
            1 => self.count = number as u16,
            2.. if self.count <= MAX_VALUES && at - 2 < self.count => {
                return Some(ReaderEvent::Value(at - 2, value));
            }
            _ => return self.leave_raw(self.count.max(at - 1)),
        }
        None
    }

    fn text(&mut self, byte: u8) -> Option<ReaderEvent> {
        if byte == b'\n' {
            let event = match self.state {
                ReaderState::Error if self.digits => ReaderEvent::Error(self.number),
                ReaderState::Status if self.at > BANDWIDTH.end => {
                    ReaderEvent::Bandwidth(self.number as i16)
                }
                ReaderState::Info => ReaderEvent::Info,
                _ => {
                    self.state = ReaderState::Hunt;
                    return None;
                }
            };
            return self.leave(event);
        }
        let wanted = self.state == ReaderState::Error || BANDWIDTH.contains(&self.at);
        if wanted && let Some(digit) = char::from(byte).to_digit(16) {
            self.number = self.number << 4 | digit;
            self.digits = true;
        }
        self.at += 1;
        if self.at > MAX_TEXT_LENGTH {
            self.state = ReaderState::Hunt;
        }
        None
    }
}
