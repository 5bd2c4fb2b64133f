//! The two slots: header, marks, payload.
//!
//! Marks stand between header and payload and are written once each, from blank; erasing the slot's first sector blanks
//! them. A mark that a power cut tears counts as set where it takes something away and as not set where it gives something:
//!
//! | offset | mark | set when | counts as set |
//! |---|---|---|---|
//! | 256 | complete | the payload has been received and is the one that was signed | not blank; header and payload are checked at every boot anyway |
//! | 272, 276, 280 | tried | the image is about to be executed without having been confirmed | not blank |
//! | 288, 296, 304, 312 | confirmed | the image's self-test has passed | a number and its complement: of two confirmed slots the one with the higher number runs |
//! | 320 | given up | somebody went back to the other slot | not blank |

use sha2::{Digest, Sha256};

use crate::header::{HASH, HEADER, Header, PAYLOAD};
use crate::key::Signatures;
use crate::refusal::{Flash, Refusal};

/// Boots of an image until it must have been confirmed.
pub const TRIES: u32 = 3;
/// Places for a confirmation, since a power cut may tear one.
const CONFIRMATIONS: u32 = 4;
const COMPLETE: u32 = 256;
const TRIED: u32 = 272;
const CONFIRMED: u32 = 288;
const GIVEN_UP: u32 = 320;
/// Word that is written for a mark without a value.
const MARK: [u8; 4] = [0; 4];
/// Bytes that are read at once.
const PIECE: usize = 256;

/// One of the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// The first.
    A,
    /// The second.
    B,
}

impl Slot {
    /// Both.
    pub const BOTH: [Self; 2] = [Self::A, Self::B];

    /// The other one.
    pub const fn other(self) -> Self {
        match self {
            Slot::A => Slot::B,
            Slot::B => Slot::A,
        }
    }

    /// Its letter.
    pub const fn as_str(self) -> &'static str {
        match self {
            Slot::A => "a",
            Slot::B => "b",
        }
    }
}

/// State of a slot by its marks, before header and payload are checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// There is no whole image.
    Incomplete,
    /// An image on trial, and how often it has been executed.
    Trial(u32),
    /// Confirmed, with a number that orders confirmations.
    Confirmed(u32),
    /// Given up by command.
    GivenUp,
}

/// Both slots in a flash that holds nothing else.
#[derive(Debug)]
pub struct Slots<F> {
    flash: F,
    /// Address of slot A, for headers.
    base: u32,
}

impl<F: Flash> Slots<F> {
    /// The slots in `flash`, which begins at address `base`.
    pub fn new(flash: F, base: u32) -> Self {
        const {
            assert!(4 % F::WRITE_SIZE == 0 && F::READ_SIZE == 1);
        }
        Self { flash, base }
    }

    /// The flash.
    pub fn flash_mut(&mut self) -> &mut F {
        &mut self.flash
    }

    /// Bytes of a slot.
    pub fn size(&self) -> u32 {
        self.flash.capacity() as u32 / 2
    }

    /// Bytes of a sector.
    pub fn sector(&self) -> u32 {
        F::ERASE_SIZE as u32
    }

    /// Offset of a slot in the flash.
    fn offset(&self, slot: Slot) -> u32 {
        match slot {
            Slot::A => 0,
            Slot::B => self.size(),
        }
    }

    /// Address of a slot.
    pub fn address(&self, slot: Slot) -> u32 {
        self.base + self.offset(slot)
    }

    /// Bytes from `at` within a slot on; a flash that cannot be read holds zeros.
    fn read<const N: usize>(&mut self, slot: Slot, at: u32) -> [u8; N] {
        let mut bytes = [0; N];
        let from = self.offset(slot) + at;
        match self.flash.read(from, &mut bytes) {
            Ok(()) => bytes,
            Err(_) => [0; N],
        }
    }

    /// The slot's header as it stands there.
    pub fn header(&mut self, slot: Slot) -> [u8; HEADER] {
        self.read(slot, 0)
    }

    fn is_marked(&mut self, slot: Slot, at: u32) -> bool {
        self.read::<4>(slot, at) != [0xff; 4]
    }

    /// Returns the state of the slot by its marks.
    pub fn mark(&mut self, slot: Slot) -> Mark {
        if self.is_marked(slot, GIVEN_UP) {
            return Mark::GivenUp;
        }
        let confirmed = (0..CONFIRMATIONS).find_map(|k| {
            let word = u64::from_le_bytes(self.read(slot, CONFIRMED + 8 * k));
            let (order, complement) = (word as u32, (word >> 32) as u32);
            (order == !complement).then_some(order)
        });
        if let Some(order) = confirmed {
            return Mark::Confirmed(order);
        }
        if !self.is_marked(slot, COMPLETE) {
            return Mark::Incomplete;
        }
        let tried = (0..TRIES).filter(|k| self.is_marked(slot, TRIED + 4 * k));
        Mark::Trial(tried.count() as u32)
    }

    /// Checks all of a slot: header, signature, payload.
    ///
    /// # Errors
    /// Why it must not be executed.
    pub fn verify(
        &mut self,
        slot: Slot,
        floor: u32,
        keys: &impl Signatures,
    ) -> Result<Header, Refusal> {
        let place = (self.address(slot), self.size());
        let header = Header::check(&self.header(slot), place, floor, keys)?;
        if self.hash(slot, header.length) == header.hash {
            Ok(header)
        } else {
            Err(Refusal::Damaged)
        }
    }

    /// SHA-256 of a payload.
    fn hash(&mut self, slot: Slot, length: u32) -> [u8; HASH] {
        let mut hash = Sha256::new();
        let mut at = 0;
        while at < length {
            let piece: [u8; PIECE] = self.read(slot, PAYLOAD + at);
            let count = (length - at).min(PIECE as u32);
            hash.update(piece.get(..count as usize).unwrap_or_default());
            at += count;
        }
        hash.finalize().into()
    }

    /// Writes to a slot and reads back.
    fn put(&mut self, slot: Slot, at: u32, bytes: &[u8]) -> Result<(), Refusal> {
        let from = self.offset(slot) + at;
        self.flash.write(from, bytes).map_err(Into::into)?;
        let mut same = true;
        for (k, piece) in (0_u32..).zip(bytes.chunks(PIECE)) {
            let back: [u8; PIECE] = self.read(slot, at + k * PIECE as u32);
            same &= back.starts_with(piece);
        }
        if same { Ok(()) } else { Err(Refusal::Flash) }
    }

    /// Notes one more execution of an image on trial.
    ///
    /// # Errors
    /// The note does not stand: then it must not be executed, or its trial would never end.
    pub fn try_once(&mut self, slot: Slot) -> Result<(), Refusal> {
        let free = (0..TRIES).find(|k| !self.is_marked(slot, TRIED + 4 * k));
        let free = free.ok_or(Refusal::Request)?;
        self.put(slot, TRIED + 4 * free, &MARK)
    }

    /// Confirms a slot with a number above that of the other one.
    ///
    /// # Errors
    /// The confirmation does not stand.
    pub fn confirm(&mut self, slot: Slot) -> Result<(), Refusal> {
        let order = match self.mark(slot.other()) {
            Mark::Confirmed(other) => other.saturating_add(1),
            _ => 1,
        };
        let free = (0..CONFIRMATIONS)
            .find(|k| self.read::<8>(slot, CONFIRMED + 8 * k) == [0xff; 8])
            .ok_or(Refusal::Flash)?;
        let word = u64::from(order) | u64::from(!order) << 32;
        self.put(slot, CONFIRMED + 8 * free, &word.to_le_bytes())
    }

    /// Gives a slot up for good.
    ///
    /// # Errors
    /// The mark does not stand.
    pub fn give_up(&mut self, slot: Slot) -> Result<(), Refusal> {
        self.put(slot, GIVEN_UP, &MARK)
    }

    /// Marks a slot's image as complete, which puts it on trial.
    ///
    /// # Errors
    /// The mark does not stand.
    pub fn complete(&mut self, slot: Slot) -> Result<(), Refusal> {
        self.put(slot, COMPLETE, &MARK)
    }

    /// Erases all of a slot, the sector with its header first, and writes another header.
    ///
    /// # Errors
    /// The flash fails.
    pub fn begin(&mut self, slot: Slot, header: &[u8; HEADER]) -> Result<(), Refusal> {
        for sector in 0..self.size() / self.sector() {
            self.erase(slot, sector)?;
        }
        self.put(slot, 0, header)
    }

    fn erase(&mut self, slot: Slot, sector: u32) -> Result<(), Refusal> {
        let from = self.offset(slot) + sector * self.sector();
        let erased = self.flash.erase(from, from + self.sector());
        erased.map_err(Into::into)
    }

    /// Writes a piece of a payload.
    ///
    /// # Errors
    /// The flash fails.
    pub fn write(&mut self, slot: Slot, at: u32, bytes: &[u8]) -> Result<(), Refusal> {
        self.put(slot, PAYLOAD + at, bytes)
    }

    /// Where a payload of `length` bytes whose header stands already goes on after a power cut: at a sector's beginning,
    /// which is erased again together with the one behind, since a write or an erasure may have been cut there. `None`
    /// where nothing would be gained.
    ///
    /// # Errors
    /// The flash fails.
    pub fn resume(&mut self, slot: Slot, length: u32) -> Result<Option<u32>, Refusal> {
        let sector = self.sector();
        let mut at = PAYLOAD + length;
        // Back from the end to the last byte that is not blank.
        while at > PAYLOAD && self.read::<4>(slot, at - 4) == [0xff; 4] {
            at -= 4;
        }
        let last = at.saturating_sub(1) / sector;
        if last == 0 {
            return Ok(None);
        }
        for sector in last..(last + 2).min(self.size() / sector) {
            self.erase(slot, sector)?;
        }
        Ok(Some(last * sector - PAYLOAD))
    }
}

/// The beginning of a slot whose image somebody wrote with a debug probe: its header, complete and confirmed, with a number
/// that orders confirmations.
pub fn factory(header: &[u8; HEADER], order: u32) -> [u8; PAYLOAD as usize] {
    let mut bytes = [0xff; PAYLOAD as usize];
    let confirmed = (u64::from(order) | u64::from(!order) << 32).to_le_bytes();
    let parts: [(usize, &[u8]); 3] = [
        (0, header),
        (COMPLETE as usize, &MARK),
        (CONFIRMED as usize, &confirmed),
    ];
    for (at, part) in parts {
        let places = bytes.iter_mut().skip(at);
        places.zip(part).for_each(|(to, from)| *to = *from);
    }
    bytes
}
