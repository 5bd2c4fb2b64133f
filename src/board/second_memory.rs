//! The chip's second memory, 64 KB beside the 128 KB that the image is linked for: found, tested, handed out once.
//!
//! One image runs on chips with it at either address, and on chips without it. An address without memory answers with
//! a bus fault, which [`super::probe`] survives; what answers is tested by the march of [`super::march`] before
//! anything is kept there. The memory protection unit closes the CCM unless the test has passed.

use stairscan::scanner::SecondMemory;

/// Number of 32-bit words of a second memory: 64 KB, those of an image.
pub use stairscan::signal::image::WORDS;

/// Addresses at which chips of the family have a second memory, in the order of the search.
const PLACES: [(SecondMemory, u32); 2] = [
    // Core-coupled memory of the STM32F405, 407, 415, 417, 427 and 429 (RM0090 2.3.1).
    (SecondMemory::Ccm, 0x1000_0000),
    // SRAM3 of the STM32F427 and 429 behind SRAM1 and SRAM2; the emulator's SRAM extends over it, too.
    (SecondMemory::Sram3, 0x2002_0000),
];

/// The addresses of a second memory as the search sees them.
pub trait Candidates {
    /// Allows or forbids accesses to the memory at this address, where the memory protection unit closes it.
    fn open(&mut self, address: u32, open: bool);
    /// Whether a word at this address can be read.
    fn responds(&mut self, address: u32) -> bool;
    /// Whether all words from this address on keep what is written to them; their content is lost.
    fn is_sound(&mut self, address: u32) -> bool;
}

/// Searches for a second memory; returns its state, and the address of a sound one, which stays open.
pub fn search(memory: &mut impl Candidates) -> (SecondMemory, Option<u32>) {
    let mut found = SecondMemory::None;
    for (kind, address) in PLACES {
        memory.open(address, true);
        let last = address + 4 * (WORDS as u32 - 1);
        if memory.responds(address) && memory.responds(last) {
            if memory.is_sound(address) {
                return (kind, Some(address));
            }
            found = SecondMemory::Damaged;
        }
        memory.open(address, false);
    }
    (found, None)
}

#[cfg(target_os = "none")]
mod chip {
    use cortex_m::peripheral::MPU;
    use stairscan::scanner::SecondMemory;

    use super::super::march::{self, ONE_BACKGROUND};
    use super::super::{probe, protection};
    use super::{Candidates, WORDS, search};

    /// The candidates behind the memory protection unit.
    struct ClosedMemory {
        mpu: MPU,
        /// Number of backgrounds of the march test.
        backgrounds: usize,
    }

    impl Candidates for ClosedMemory {
        fn open(&mut self, address: u32, open: bool) {
            protection::open(&self.mpu, address, open);
        }

        fn responds(&mut self, address: u32) -> bool {
            probe::read(address).is_some()
        }

        fn is_sound(&mut self, address: u32) -> bool {
            // SAFETY: both ends of the range respond, the linker places nothing there (`memory.x`), and the reference
            // to it does not exist yet.
            unsafe { march::is_sound(address as *mut u32, WORDS as u32, self.backgrounds) }
        }
    }

    /// Searches for the second memory; returns its state, and its words if it is sound. Interrupts must be enabled
    /// ([`probe::read`]). On the internal oscillator one background of the march is tested instead of all six: 0.1 s
    /// instead of 0.6 s.
    // Out of line: the stack of the search is free again before the scanner begins.
    #[inline(never)]
    pub fn find(
        mpu: MPU,
        internal_clock: bool,
    ) -> (SecondMemory, Option<&'static mut [u32; WORDS]>) {
        let backgrounds = match internal_clock {
            true => ONE_BACKGROUND,
            false => march::BACKGROUNDS.len(),
        };
        let (state, address) = search(&mut ClosedMemory { mpu, backgrounds });
        let words = address.map(|address| {
            // SAFETY: sound memory of this size, every word of which the test has written, aligned, and used by nothing
            // else. The peripheral that this function consumes exists once, and so does the reference.
            unsafe { &mut *(address as *mut [u32; WORDS]) }
        });
        (state, words)
    }
}

#[cfg(target_os = "none")]
pub use chip::find;

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::vec::Vec;

    /// Addresses that respond, addresses of memory that is defective, and addresses that are open.
    struct Chip {
        responding: Vec<u32>,
        defective: Vec<u32>,
        open: BTreeSet<u32>,
    }

    impl Candidates for Chip {
        fn open(&mut self, address: u32, open: bool) {
            match open {
                true => assert!(self.open.insert(address)),
                false => assert!(self.open.remove(&address)),
            }
        }

        fn responds(&mut self, address: u32) -> bool {
            assert!(
                self.open.contains(&(address & !0xffff)),
                "{address:x} is closed"
            );
            self.responding.contains(&address)
        }

        fn is_sound(&mut self, address: u32) -> bool {
            assert!(self.open.contains(&address));
            !self.defective.contains(&address)
        }
    }

    const CCM: u32 = 0x1000_0000;
    const SRAM3: u32 = 0x2002_0000;

    fn searched(places: &[u32], defective: &[u32]) -> (SecondMemory, Option<u32>, Vec<u32>) {
        let ends = places.iter().flat_map(|&at| [at, at + 0xfffc]);
        let mut chip = Chip {
            responding: ends.collect(),
            defective: defective.to_vec(),
            open: BTreeSet::new(),
        };
        let (state, address) = search(&mut chip);
        (state, address, chip.open.into_iter().collect())
    }

    #[test]
    fn each_chip_has_its_memory_and_nothing_else_stays_open() {
        use SecondMemory as M;
        let open = |at: u32| (Some(at), Vec::from([at]));
        for (places, defective, state, (address, left_open)) in [
            (&[CCM][..], &[][..], M::Ccm, open(CCM)),
            (&[SRAM3], &[], M::Sram3, open(SRAM3)),
            (&[CCM, SRAM3], &[], M::Ccm, open(CCM)),
            (&[CCM, SRAM3], &[CCM], M::Sram3, open(SRAM3)),
            (&[CCM], &[CCM], M::Damaged, (None, Vec::new())),
            (&[CCM, SRAM3], &[CCM, SRAM3], M::Damaged, (None, Vec::new())),
            (&[], &[], M::None, (None, Vec::new())),
        ] {
            let found = searched(places, defective);
            assert_eq!(
                found,
                (state, address, left_open),
                "{places:x?} {defective:x?}"
            );
        }
    }

    #[test]
    fn half_a_memory_is_none() {
        let mut chip = Chip {
            responding: Vec::from([CCM, SRAM3 + 0xfffc]),
            defective: Vec::new(),
            open: BTreeSet::new(),
        };
        assert_eq!(search(&mut chip), (SecondMemory::None, None));
    }

    #[test]
    fn the_linker_places_nothing_there() {
        let memory = include_str!("memory.x");
        assert!(memory.contains("RAM : ORIGIN = 0x200048A0, LENGTH = 110K - 192"));
        // End of the message to the boot loader, behind that region.
        assert_eq!(0x2000_48A0 + 110 * 1024 - 192 + 32, SRAM3);
    }
}
