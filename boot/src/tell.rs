//! The loader's sentence: what it executes, and how the slots stand, where that is not as it was.
//!
//! `$PSTR,LOADER,<slot, empty for none>,<execution on trial, 0: confirmed>,<state of slot A>,<state of slot B>*<CRC-32>`;
//! where it waits although there is an image, with a last field that says why.

use embedded_storage::nor_flash::NorFlash;
use stairscan::crc;
use stairscan::scanner::handover::Handover;

use crate::force::Forced;
use crate::key::Signatures;
use crate::refusal::Flash;
use crate::slot::{Mark, Slot};
use crate::start::{Loader, Start};

/// Longest sentence: two words of 16 bytes and less, one of 6, a letter, a digit, frame and line end.
const LONGEST: usize = 80;

/// A sentence with its frame and line end.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    bytes: [u8; LONGEST],
    count: usize,
}

impl Line {
    /// Its bytes.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.count).unwrap_or_default()
    }

    fn push(&mut self, bytes: &[u8]) {
        let places = self.bytes.iter_mut().skip(self.count);
        places.zip(bytes).for_each(|(to, from)| *to = *from);
        self.count += bytes.len();
    }
}

/// Returns the sentence, unless a confirmed image is executed beside which there is none or an older one: nothing has changed
/// then, and checking the other slot, too, would take time.
pub fn sentence<F: Flash, G: NorFlash, K: Signatures>(
    loader: &mut Loader<F, G, K>,
    start: Option<Start>,
    handed: Option<Handover>,
    forced: Option<Forced>,
) -> Option<Line> {
    if let Some(Start {
        slot, trial: None, ..
    }) = start
    {
        let order = |mark| match mark {
            Mark::Confirmed(order) => Some(order),
            _ => None,
        };
        let other = loader.slots.mark(slot.other());
        let newer = order(other) > order(loader.slots.mark(slot));
        let known = newer || matches!(other, Mark::Trial(_) | Mark::GivenUp);
        if matches!(handed, None | Some(Handover::Execute)) && !known {
            return None;
        }
    }
    let [a, b] = Slot::BOTH.map(|slot| loader.word(slot));
    let slot = start.map_or("", |start| start.slot.as_str());
    let trial = match start.and_then(|start| start.trial) {
        None => "0",
        Some(1) => "1",
        Some(2) => "2",
        Some(_) => "3",
    };
    let mut line = Line {
        bytes: [0; LONGEST],
        count: 0,
    };
    let why = forced.map_or("", Forced::as_str);
    let parted = if why.is_empty() { "" } else { "," };
    for part in [
        "$PSTR,LOADER,",
        slot,
        ",",
        trial,
        ",",
        a,
        ",",
        b,
        parted,
        why,
    ] {
        line.push(part.as_bytes());
    }
    let crc = crc::of_parts(&[line.bytes().get(1..).unwrap_or_default()]);
    line.push(b"*");
    for nibble in (0..8).rev() {
        let digit = (crc >> (4 * nibble)) & 0xf;
        let letter = if digit < 10 { b'0' } else { b'A' - 10 };
        line.push(&[letter + digit as u8]);
    }
    line.push(b"\r\n");
    Some(line)
}
