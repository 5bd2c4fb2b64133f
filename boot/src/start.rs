//! Which slot is executed: a function of what stands in flash, and of what the image asked for before the reset.

use embedded_storage::nor_flash::NorFlash;

use crate::floor::Floor;
use crate::key::Signatures;
use crate::refusal::{Flash, Refusal};
use crate::slot::{Mark, Slot, Slots, TRIES};

/// The loader's memory: both slots, the counter, and the key that is trusted.
#[derive(Debug)]
pub struct Loader<F, G, K> {
    /// The slots.
    pub slots: Slots<F>,
    /// The anti-rollback counter.
    pub floor: Floor<G>,
    /// The key that is trusted.
    pub keys: K,
}

/// Request of the image before it reset the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asked {
    /// Nothing.
    Nothing,
    /// To be confirmed: its self-test has passed.
    Confirm,
}

/// An image whose signature and hash have been checked at this boot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Start {
    /// Its slot.
    pub slot: Slot,
    /// Address of its vector table.
    pub vectors: u32,
    /// Which execution on trial this is, from 1 on; `None` once it has been confirmed.
    pub trial: Option<u32>,
}

impl<F: Flash, G: NorFlash, K: Signatures> Loader<F, G, K> {
    /// Decides what is executed: first an image on trial, then the one that was confirmed last, then the other one.
    /// `None`: neither slot holds an image that may be executed.
    pub fn start(&mut self, asked: Asked) -> Option<Start> {
        if asked == Asked::Confirm {
            self.confirm();
        }
        self.trial().or_else(|| self.confirmed())
    }

    /// Address of a slot's vector table, where all of the slot holds.
    fn vectors(&mut self, slot: Slot) -> Result<(u32, u32), Refusal> {
        let floor = self.floor.get();
        let header = self.slots.verify(slot, floor, &self.keys)?;
        let vectors = self.slots.address(slot) + crate::header::PAYLOAD;
        Ok((vectors, header.number))
    }

    /// Confirms the image on trial that has been executed.
    fn confirm(&mut self) {
        for slot in Slot::BOTH {
            let tried = matches!(self.slots.mark(slot), Mark::Trial(1..));
            if tried && self.vectors(slot).is_ok() {
                // Where it does not stand, the trial goes on.
                let _ = self.slots.confirm(slot);
            }
        }
    }

    /// Whether an image on trial would be executed next.
    pub fn has_trial(&mut self) -> bool {
        let mut slots = Slot::BOTH.into_iter();
        slots.any(|slot| self.on_trial(slot).is_some())
    }

    /// Number of executions of the image on trial in a slot, and address of its vector table; `None` where there is none
    /// that may be executed once more.
    fn on_trial(&mut self, slot: Slot) -> Option<(u32, u32)> {
        let Mark::Trial(tried @ 0..TRIES) = self.slots.mark(slot) else {
            return None;
        };
        let (vectors, _) = self.vectors(slot).ok()?;
        Some((tried, vectors))
    }

    fn trial(&mut self) -> Option<Start> {
        Slot::BOTH.into_iter().find_map(|slot| {
            let (tried, vectors) = self.on_trial(slot)?;
            self.slots.try_once(slot).ok()?;
            Some(Start {
                slot,
                vectors,
                trial: Some(tried + 1),
            })
        })
    }

    fn confirmed(&mut self) -> Option<Start> {
        let order = |mark| match mark {
            Mark::Confirmed(order) => Some(order),
            _ => None,
        };
        let [a, b] = Slot::BOTH.map(|slot| order(self.slots.mark(slot)));
        let both = if b > a {
            [(Slot::B, b), (Slot::A, a)]
        } else {
            [(Slot::A, a), (Slot::B, b)]
        };
        let found = both.into_iter().find_map(|(slot, order)| {
            let (vectors, number) = order.and_then(|_| self.vectors(slot).ok())?;
            Some((slot, vectors, number))
        });
        let (slot, vectors, number) = found?;
        // Missing only where the power went right behind the confirmation.
        self.floor.raise(number);
        Some(Start {
            slot,
            vectors,
            trial: None,
        })
    }

    /// The slot that a new image goes to: never the one that would be executed.
    pub fn spare(&mut self) -> Slot {
        match self.confirmed() {
            Some(running) => running.slot.other(),
            // Neither: an image for slot A is what a debug probe writes, too.
            None => Slot::A,
        }
    }

    /// Gives up the image that was confirmed last, where the other slot holds one that was confirmed before and may be
    /// executed.
    ///
    /// # Errors
    /// [`Refusal::NoWayBack`], or the flash fails.
    pub fn back(&mut self) -> Result<Slot, Refusal> {
        let running = self.confirmed().ok_or(Refusal::NoWayBack)?.slot;
        let other = running.other();
        let confirmed = matches!(self.slots.mark(other), Mark::Confirmed(_));
        if !confirmed || self.vectors(other).is_err() {
            return Err(Refusal::NoWayBack);
        }
        self.slots.give_up(running)?;
        Ok(other)
    }

    /// Word for a slot's state: of its mark, or why it is not executed.
    pub fn word(&mut self, slot: Slot) -> &'static str {
        let mark = self.slots.mark(slot);
        match (mark, self.vectors(slot)) {
            (Mark::GivenUp, _) => "given-up",
            (_, Err(refusal)) if mark != Mark::Incomplete => refusal.as_str(),
            (Mark::Incomplete, _) if self.slots.header(slot).starts_with(&[0xff; 4]) => "empty",
            (Mark::Incomplete, _) => "incomplete",
            (Mark::Trial(TRIES..), _) => "failed",
            (Mark::Trial(_), _) => "trial",
            (Mark::Confirmed(_), _) => "confirmed",
        }
    }
}
