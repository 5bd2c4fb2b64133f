//! A new image comes in: requests of the host, carried out on the spare slot one by one, and the answer to each.
//!
//! Nothing waits here, and nothing is remembered that flash does not hold but how far the payload has come: a broken
//! transfer goes on where it broke, after a loss of power at the beginning of a sector.

use embedded_storage::nor_flash::NorFlash;
use stairscan::scanner::option_bytes::OptionBytes;

use crate::frame::{Frame, Kind};
use crate::header::{HEADER, Header, NAME};
use crate::key::{KEY_ID, Signatures};
use crate::refusal::{Flash, Refusal};
use crate::slot::{Mark, Slot};
use crate::start::Loader;

/// Version of the protocol between loader and host. The greeting `hello` carries the host's in one byte, none for version 1;
/// the answer is in the lower one of both, so that each side may be older than the other.
pub const PROTOCOL: u8 = 2;
/// First version whose [`Info`] ends with the option bytes.
const WITH_OPTION_BYTES: u8 = 2;
/// Bytes of a word for a slot's state.
const WORD: usize = 16;
/// Bytes that [`Info`] has of each slot.
const OF_SLOT: usize = WORD + NAME + 4;
/// Bytes of [`Info`] in version 1.
const INFO_1: usize = 24 + 2 * OF_SLOT;
/// Bytes of [`Info`].
pub const INFO: usize = INFO_1 + 4;
/// Longest answer.
pub const LONGEST: usize = INFO;

/// Action of the chip after an answer has been sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Nothing.
    None,
    /// Goes on at another rate, baud.
    Rate(u32),
    /// Resets itself.
    Reset,
}

/// An answer's payload.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    bytes: [u8; LONGEST],
    count: usize,
}

impl Answer {
    /// Its bytes.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.count).unwrap_or_default()
    }

    fn new(parts: &[&[u8]]) -> Self {
        let mut bytes = [0; LONGEST];
        let all = parts.iter().copied().flatten();
        let count = bytes.iter_mut().zip(all).map(|(to, from)| *to = *from);
        let count = count.count();
        Self { bytes, count }
    }

    fn code(done: Result<(), Refusal>) -> Self {
        Self::new(&[&[done.map_or_else(|refusal| refusal as u8, |()| 0)]])
    }
}

/// A slot as the host shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlotInfo {
    /// State, or why it is not executed.
    pub word: [u8; WORD],
    /// Version in words of what its header names.
    pub name: [u8; NAME],
    /// Number of what its header names.
    pub number: u32,
}

/// The loader's description of itself, the answer to `hello`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Info {
    /// Version of the protocol.
    pub protocol: u8,
    /// The slot that a new image goes to, 0 or 1.
    pub spare: u8,
    /// Fastest rate that it knows, in units of 100 kbaud; 0: none but the first.
    pub fastest: u8,
    /// Whether the trusted key is the development key, which everybody has.
    pub development: bool,
    /// The chip.
    pub chip: u32,
    /// Bytes of a slot.
    pub size: u32,
    /// The anti-rollback counter.
    pub floor: u32,
    /// First bytes of the trusted key.
    pub key_id: [u8; KEY_ID],
    /// Both slots.
    pub slots: [SlotInfo; 2],
    /// The chip's option bytes; `None` if they are unknown.
    pub option_bytes: Option<OptionBytes>,
}

impl Info {
    /// Its bytes.
    fn answer(&self) -> Answer {
        let numbers = [self.chip, self.size, self.floor].map(u32::to_le_bytes);
        let [a, b] = &self.slots;
        let flags = [
            self.protocol,
            self.spare,
            self.fastest,
            self.development.into(),
        ];
        let option_bytes = self.option_bytes.map_or(0, OptionBytes::bits).to_le_bytes();
        let behind: &[u8] = match self.protocol {
            WITH_OPTION_BYTES.. => &option_bytes,
            _ => &[],
        };
        Answer::new(&[
            &flags,
            numbers.as_flattened(),
            &self.key_id,
            &a.word,
            &a.name,
            &a.number.to_le_bytes(),
            &b.word,
            &b.name,
            &b.number.to_le_bytes(),
            behind,
        ])
    }

    /// Reads it; `None` where its length or version is none of the known ones.
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        let length = match *bytes.first()? {
            1 => INFO_1,
            PROTOCOL => INFO,
            _ => return None,
        };
        (bytes.len() == length).then_some(())?;
        let (bytes, behind) = bytes.split_first_chunk::<INFO_1>()?;
        let behind = behind.first_chunk();
        let &[protocol, spare, fastest, development, ..] = bytes;
        let word = |at: usize| {
            let found = bytes.get(at..).and_then(|rest| rest.first_chunk());
            found.map_or(0, |word| u32::from_le_bytes(*word))
        };
        let slot = |at: usize| {
            let rest = bytes.get(at..)?;
            Some(SlotInfo {
                word: *rest.first_chunk()?,
                name: *rest.get(WORD..)?.first_chunk()?,
                number: word(at + WORD + NAME),
            })
        };
        Some(Self {
            protocol,
            spare,
            fastest,
            development: development != 0,
            chip: word(4),
            size: word(8),
            floor: word(12),
            key_id: *bytes.get(16..)?.first_chunk()?,
            slots: [slot(24)?, slot(24 + OF_SLOT)?],
            option_bytes: OptionBytes::of_register(
                behind.map_or(0, |word| u32::from_le_bytes(*word)),
            ),
        })
    }
}

/// An image that is coming in.
#[derive(Clone, Copy, Debug)]
struct Taking {
    slot: Slot,
    header: [u8; HEADER],
    length: u32,
    next: u32,
}

/// The loader's end of an update.
#[derive(Debug)]
pub struct Receiver {
    taking: Option<Taking>,
    /// As in [`Info`].
    pub fastest: u8,
    /// As in [`Info`].
    pub development: bool,
    /// As in [`Info`].
    pub option_bytes: Option<OptionBytes>,
}

impl Receiver {
    /// Nothing is coming in.
    pub const fn new(fastest: u8, development: bool) -> Self {
        Self {
            taking: None,
            fastest,
            development,
            option_bytes: None,
        }
    }

    /// Carries out a request; `None` for what is none, such as the echo of an answer.
    pub fn handle<F: Flash, G: NorFlash, K: Signatures>(
        &mut self,
        frame: Frame<'_>,
        loader: &mut Loader<F, G, K>,
    ) -> Option<(Answer, Effect)> {
        let after = |done: Result<(), Refusal>, effect| match done {
            Ok(()) => (Answer::code(done), effect),
            Err(_) => (Answer::code(done), Effect::None),
        };
        Some(match Kind::from_byte(frame.kind)? {
            Kind::Hello => {
                let version = frame
                    .payload
                    .first()
                    .map_or(1, |&host| host.clamp(1, PROTOCOL));
                (self.info(version, loader).answer(), Effect::None)
            }
            Kind::Rate => {
                let baud = frame.payload.first_chunk().map(|b| u32::from_le_bytes(*b));
                let known = baud.filter(|&baud| self.has_rate(baud));
                let done = known.map(|_| ()).ok_or(Refusal::Request);
                after(done, Effect::Rate(known.unwrap_or_default()))
            }
            Kind::Begin => (place(self.begin(frame.payload, loader)), Effect::None),
            Kind::Data => (place(self.data(frame.payload, loader)), Effect::None),
            Kind::Finish => after(self.finish(loader), Effect::Reset),
            Kind::Boot => after(Ok(()), Effect::Reset),
            Kind::Back => after(loader.back().map(|_| ()), Effect::Reset),
        })
    }

    /// Whether a rate is one of the multiples of 1 Mbaud that the chip's clock makes exactly, or the first one.
    fn has_rate(&self, baud: u32) -> bool {
        let fast = baud.is_multiple_of(1_000_000) && baud / 100_000 <= self.fastest.into();
        baud == FIRST_BAUD || (fast && baud > 0)
    }

    fn info<F: Flash, G: NorFlash, K: Signatures>(
        &self,
        protocol: u8,
        loader: &mut Loader<F, G, K>,
    ) -> Info {
        let mut slot = |slot| {
            let word = padded(loader.word(slot));
            let header = Header::parse(&loader.slots.header(slot)).ok();
            SlotInfo {
                word,
                name: header.map_or([0; NAME], |header| header.name),
                number: header.map_or(0, |header| header.number),
            }
        };
        let slots = [slot(Slot::A), slot(Slot::B)];
        Info {
            protocol,
            spare: (loader.spare() == Slot::B).into(),
            fastest: self.fastest,
            development: self.development,
            chip: crate::layout::CHIP,
            size: loader.slots.size(),
            floor: loader.floor.get(),
            key_id: loader.keys.key_id(),
            slots,
            option_bytes: self.option_bytes,
        }
    }

    /// A header: checked, its signature too, before a byte of flash is touched. Returns the offset of the next byte.
    fn begin<F: Flash, G: NorFlash, K: Signatures>(
        &mut self,
        payload: &[u8],
        loader: &mut Loader<F, G, K>,
    ) -> Result<u32, Refusal> {
        let offered: &[u8; HEADER] = payload.try_into().map_err(|_| Refusal::NoImage)?;
        let slot = loader.spare();
        let place = (loader.slots.address(slot), loader.slots.size());
        let header = Header::check(offered, place, loader.floor.get(), &loader.keys)?;
        if let Some(taking) = self.taking
            && (taking.slot, &taking.header) == (slot, offered)
        {
            return Ok(taking.next);
        }
        self.taking = None;
        let stands = &loader.slots.header(slot) == offered;
        let next = match stands && loader.slots.mark(slot) == Mark::Incomplete {
            true => loader.slots.resume(slot, header.length)?,
            false => None,
        };
        let next = match next {
            Some(next) => next,
            None => {
                loader.slots.begin(slot, offered)?;
                0
            }
        };
        self.taking = Some(Taking {
            slot,
            header: *offered,
            length: header.length,
            next,
        });
        Ok(next)
    }

    /// A piece of the payload. One that comes twice, or from elsewhere, is answered by the offset of the next byte.
    fn data<F: Flash, G: NorFlash, K: Signatures>(
        &mut self,
        payload: &[u8],
        loader: &mut Loader<F, G, K>,
    ) -> Result<u32, Refusal> {
        let taking = self.taking.as_mut().ok_or(Refusal::Request)?;
        let (offset, bytes) = payload.split_first_chunk().ok_or(Refusal::Request)?;
        if u32::from_le_bytes(*offset) != taking.next {
            return Ok(taking.next);
        }
        let left = (taking.length - taking.next) as usize;
        if bytes.len() > left || !bytes.len().is_multiple_of(4) {
            return Err(Refusal::TooLong);
        }
        let written = loader.slots.write(taking.slot, taking.next, bytes);
        taking.next += bytes.len() as u32;
        let next = taking.next;
        if written.is_err() {
            // Words that may hold something are not written again: the next beginning erases them.
            self.taking = None;
        }
        written.map(|()| next)
    }

    fn finish<F: Flash, G: NorFlash, K: Signatures>(
        &mut self,
        loader: &mut Loader<F, G, K>,
    ) -> Result<(), Refusal> {
        let taking = self.taking.ok_or(Refusal::Request)?;
        if taking.next != taking.length {
            return Err(Refusal::CutOff);
        }
        self.taking = None;
        let floor = loader.floor.get();
        let verified = loader.slots.verify(taking.slot, floor, &loader.keys);
        if let Err(refusal) = verified {
            // So that the same header does not resume what is damaged.
            let _ = loader.slots.give_up(taking.slot);
            return Err(refusal);
        }
        loader.slots.complete(taking.slot)
    }
}

/// The rate that both ends begin with.
pub const FIRST_BAUD: u32 = 115_200;

/// Code and offset of an answer.
fn place(done: Result<u32, Refusal>) -> Answer {
    let code = done.map_or_else(|refusal| refusal as u8, |_| 0);
    Answer::new(&[&[code], &done.unwrap_or(0).to_le_bytes()])
}

/// A word with zeros behind it.
fn padded<const N: usize>(word: &str) -> [u8; N] {
    let mut bytes = [0; N];
    bytes
        .iter_mut()
        .zip(word.bytes())
        .for_each(|(to, from)| *to = from);
    bytes
}
