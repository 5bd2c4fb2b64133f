//! The loader's sentence: what it executes, and how the slots stand, where that is not as it was.
//!
//! `$PSTR,LOADER,<slot, empty for none>,<execution on trial, 0: confirmed>,<state of slot A>,<state of slot B>*<CRC-32>`

use stairscan::crc;
use stairscan::scanner::handover::Handover;
use stairscan_boot::slot::{Mark, Slot};
use stairscan_boot::start::Start;

use super::ChipLoader;
use super::port::Port;

/// Longest sentence: two words of 16 bytes and less, a letter, a digit.
const LONGEST: usize = 80;

/// Whether anything is not as at the boot of a confirmed image, beside which there is none or an older one.
pub fn is_worth_telling(
    loader: &mut ChipLoader,
    start: Option<Start>,
    handed: Option<Handover>,
) -> bool {
    let Some(Start {
        slot, trial: None, ..
    }) = start
    else {
        return true;
    };
    let order = |mark| match mark {
        Mark::Confirmed(order) => Some(order),
        _ => None,
    };
    let other = loader.slots.mark(slot.other());
    let newer = order(other) > order(loader.slots.mark(slot));
    handed.is_some() || newer || matches!(other, Mark::Trial(_) | Mark::GivenUp)
}

/// Sends the sentence.
pub fn tell(loader: &mut ChipLoader, start: Option<Start>, port: &mut Port) {
    let [a, b] = Slot::BOTH.map(|slot| loader.word(slot));
    let slot = start.map_or("", |start| start.slot.as_str());
    let trial = match start.and_then(|start| start.trial) {
        None => "0",
        Some(1) => "1",
        Some(2) => "2",
        Some(_) => "3",
    };
    let mut line = [0; LONGEST];
    let parts = ["PSTR,LOADER,", slot, ",", trial, ",", a, ",", b];
    let all = parts.iter().flat_map(|part| part.bytes());
    let count = line.iter_mut().zip(all).map(|(to, from)| *to = from);
    let count = count.count();
    let body = line.get(..count).unwrap_or_default();
    let crc = crc::of_parts(&[body]);
    port.write(b"$");
    port.write(body);
    port.write(b"*");
    for nibble in (0..8).rev() {
        let digit = (crc >> (4 * nibble)) & 0xf;
        let letter = if digit < 10 { b'0' } else { b'A' - 10 };
        port.write(&[letter + digit as u8]);
    }
    port.write(b"\r\n");
}
