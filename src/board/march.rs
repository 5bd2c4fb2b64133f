//! Memory test at boot, before any data is kept in it: March C-, word by word.
//!
//! March C- detects every stuck cell, every address that selects another cell or none, and every cell that
//! changes with another one, between any two words. Within a word it detects what the backgrounds distinguish:
//! with six of them any two of the 32 bits differ in at least one.

use core::hint::black_box;

/// Memory of 32-bit words for the march test.
pub trait WordMemory {
    /// Returns the number of words.
    fn count(&self) -> u32;
    /// Returns word `k`.
    fn read(&self, k: u32) -> u32;
    /// Writes word `k`.
    fn write(&mut self, k: u32, word: u32);
}

/// Words that the march test writes: any two of the 32 bits differ in at least one of these.
pub const BACKGROUNDS: [u32; 6] = [
    0,
    0x5555_5555,
    0x3333_3333,
    0x0f0f_0f0f,
    0x00ff_00ff,
    0x0000_ffff,
];

/// Runs the march test; returns whether every word stores what is written to it and nothing else. The previous
/// content is lost.
// Out of line, like the functions it calls: it is called for several ranges.
#[inline(never)]
pub fn march(memory: &mut impl WordMemory) -> bool {
    march_with(memory, BACKGROUNDS.len())
}

/// Number of backgrounds with which the march test still detects every defect between two words and every stuck bit,
/// but not every pair of coupled bits in one word.
pub const ONE_BACKGROUND: usize = 1;

/// Runs the march test as [`march`] does, with the first `backgrounds` of [`BACKGROUNDS`].
fn march_with(memory: &mut impl WordMemory, backgrounds: usize) -> bool {
    let mut words = BACKGROUNDS.iter().take(backgrounds);
    words.all(|&word| march_over(memory, word))
}

/// Runs March C- over one background: write; twice upwards read and invert; twice downwards read and invert;
/// read.
#[inline(never)]
fn march_over(memory: &mut impl WordMemory, word: u32) -> bool {
    // The result of this first pass is ignored: the content is unknown.
    read_and_invert(memory, !word, false);
    [
        (word, false),
        (!word, false),
        (word, true),
        (!word, true),
        (word, false),
    ]
    .iter()
    .all(|&(from, down)| read_and_invert(memory, from, down))
}

/// Reads each word, which must be `from`, and inverts it; returns whether all were right.
#[inline(never)]
fn read_and_invert(memory: &mut impl WordMemory, from: u32, down: bool) -> bool {
    let count = memory.count();
    let (mut k, step) = if down {
        (count, u32::MAX)
    } else {
        (u32::MAX, 1)
    };
    let mut wrong = 0;
    for _ in 0..count {
        // Prevents unrolling, which would make the code ten times as long.
        k = black_box(k.wrapping_add(step));
        wrong |= memory.read(k) ^ from;
        memory.write(k, !from);
    }
    wrong == 0
}

/// Returns whether every word stores each of its bits, for words that must not be lost: each is restored before
/// the next one is touched. Coupling between words is not detected.
pub fn each_keeps(memory: &mut impl WordMemory) -> bool {
    (0..memory.count()).all(|k| {
        let before = memory.read(k);
        let keeps = [before, !before, before].iter().all(|&word| {
            memory.write(k, word);
            memory.read(k) == word
        });
        memory.write(k, before);
        keeps
    })
}

#[cfg(target_os = "none")]
mod chip {
    use super::{WordMemory, each_keeps, march, march_with};
    use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

    /// Range of RAM under test: first address, and number of 32-bit words.
    struct Range {
        from: *mut u32,
        count: u32,
    }

    impl Range {
        fn between(from: *const u32, to: *const u32) -> Self {
            Self {
                from: from.cast_mut(),
                count: (to as u32).saturating_sub(from as u32) / 4,
            }
        }
    }

    impl WordMemory for Range {
        fn count(&self) -> u32 {
            self.count
        }

        fn read(&self, k: u32) -> u32 {
            // SAFETY: within the range, which is RAM that is not in use yet (`__pre_init`, `is_sound`).
            unsafe { self.from.add(k as usize).read_volatile() }
        }

        fn write(&mut self, k: u32, word: u32) {
            // SAFETY: as above.
            unsafe { self.from.add(k as usize).write_volatile(word) }
        }
    }

    /// Runs the march test with `backgrounds` words over `count` words from `from` on; returns whether it has passed.
    ///
    /// # Safety
    /// The range is memory that nothing else uses.
    pub unsafe fn is_sound(from: *mut u32, count: u32, backgrounds: usize) -> bool {
        march_with(&mut Range { from, count }, backgrounds)
    }

    /// Value of the word `MARCHED` in uninitialised RAM after a memory test that has passed.
    const PASSED: u32 = 0x5061_7373;
    /// Bytes below the stack's top that the march test leaves out, for its own stack frames of some 100 bytes.
    const FRAMES: u32 = 512;

    // SAFETY: the start-up code leaves the section unchanged, and any bits are a valid word.
    #[unsafe(link_section = ".uninit.MARCHED")]
    static MARCHED: AtomicU32 = AtomicU32::new(0);

    unsafe extern "C" {
        static mut _stack_start: u32;
        static mut _stack_bottom: u32;
        static mut _ram_start: u32;
        static mut _ram_end: u32;
        static mut __suninit: u32;
        static mut __euninit: u32;
    }

    /// Tests the memory. The start-up code calls this before it initialises any memory: only the stack's
    /// uppermost words and the retained state (`.uninit`) hold data.
    // SAFETY: the name is that of the start-up code's hook, which has this signature. It runs before statics
    // are initialised and uses only `MARCHED`, which is never initialised.
    #[unsafe(no_mangle)]
    unsafe extern "C" fn __pre_init() {
        let stack = (&raw const _stack_start).wrapping_byte_sub(FRAMES as usize);
        let (kept, behind) = (&raw const __suninit, &raw const __euninit);
        let passed = march(&mut Range::between(&raw const _stack_bottom, stack))
            && march(&mut Range::between(&raw const _ram_start, kept))
            && march(&mut Range::between(behind, &raw const _ram_end))
            && each_keeps(&mut Range::between(kept, behind));
        MARCHED.store(if passed { PASSED } else { 0 }, Relaxed);
    }

    /// Returns whether the memory test at this boot has passed; only the first call tells, any later one returns
    /// `false`.
    pub fn passed() -> bool {
        MARCHED.swap(0, Relaxed) == PASSED
    }
}

#[cfg(target_os = "none")]
pub use chip::{is_sound, passed};

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Defect of the bit, word or address at which the simulated memory is faulty.
    #[derive(Clone, Copy, Debug)]
    enum Defect {
        None,
        /// A bit always reads as this value.
        Stuck(bool),
        /// A bit cannot change to this value.
        Slow(bool),
        /// A bit's change to this value inverts another bit, given by word and bit.
        Inverts(bool, (u32, u32)),
        /// A bit's change to this value forces another bit, given by word and bit, to the second value.
        Forces(bool, (u32, u32), bool),
        /// While a bit has this value another bit, given by word and bit, reads as the second value.
        Holds(bool, (u32, u32), bool),
        /// A write to the word goes to the word of this index as well.
        Both(u32),
        /// The word's address selects the word of this index instead.
        Other(u32),
    }

    struct Memory {
        words: Vec<u32>,
        at: (u32, u32),
        defect: Defect,
    }

    const COUNT: u32 = 13;

    impl Memory {
        fn new(at: (u32, u32), defect: Defect) -> Self {
            let words = (0..COUNT).map(|k| k.wrapping_mul(0x9e37_79b9)).collect();
            Self { words, at, defect }
        }

        fn bit(&self, (k, bit): (u32, u32)) -> bool {
            self.words[k as usize] >> bit & 1 == 1
        }

        fn put(&mut self, (k, bit): (u32, u32), value: bool) {
            let word = &mut self.words[k as usize];
            *word = *word & !(1 << bit) | u32::from(value) << bit;
        }

        fn place(&self, k: u32) -> u32 {
            match self.defect {
                Defect::Other(other) if k == self.at.0 => other,
                _ => k,
            }
        }
    }

    impl WordMemory for Memory {
        fn count(&self) -> u32 {
            COUNT
        }

        fn read(&self, k: u32) -> u32 {
            let mut word = self.words[self.place(k) as usize];
            let mut shows = |(at, bit): (u32, u32), value: bool| {
                if at == k {
                    word = word & !(1 << bit) | u32::from(value) << bit;
                }
            };
            match self.defect {
                Defect::Stuck(value) => shows(self.at, value),
                Defect::Holds(when, victim, value) if self.bit(self.at) == when => {
                    shows(victim, value);
                }
                _ => {}
            }
            word
        }

        fn write(&mut self, k: u32, word: u32) {
            let before = self.bit(self.at);
            let place = self.place(k);
            self.words[place as usize] = word;
            if let Defect::Both(other) = self.defect
                && k == self.at.0
            {
                self.words[other as usize] = word;
            }
            let after = self.bit(self.at);
            if before == after {
                return;
            }
            match self.defect {
                Defect::Slow(to) if after == to => self.put(self.at, before),
                Defect::Inverts(to, victim) if after == to => {
                    let value = self.bit(victim);
                    self.put(victim, !value);
                }
                Defect::Forces(to, victim, value) if after == to => self.put(victim, value),
                _ => {}
            }
        }
    }

    #[test]
    fn sound_memory_passes() {
        assert!(march(&mut Memory::new((3, 7), Defect::None)));
        let mut memory = Memory::new((3, 7), Defect::None);
        let before = memory.words.clone();
        assert!(each_keeps(&mut memory));
        assert_eq!(memory.words, before, "nothing is lost");
    }

    #[test]
    fn a_bit_that_sticks_or_changes_no_more_is_found_anywhere() {
        for at in (0..COUNT).flat_map(|k| [0, 1, 13, 31].map(|bit| (k, bit))) {
            for value in [false, true] {
                for defect in [Defect::Stuck(value), Defect::Slow(value)] {
                    assert!(!march(&mut Memory::new(at, defect)), "{at:?} {defect:?}");
                    let kept = each_keeps(&mut Memory::new(at, defect));
                    assert!(!kept, "{at:?} {defect:?}");
                }
            }
        }
    }

    #[test]
    fn words_that_change_one_another_are_found() {
        for (from, to) in [(0, 12), (12, 0), (5, 6), (6, 5)] {
            for (bit, other) in [(0, 0), (0, 1), (31, 4), (17, 17)] {
                let (at, victim) = ((from, bit), (to, other));
                for when in [false, true] {
                    let mut defects = Vec::from([Defect::Inverts(when, victim)]);
                    for value in [false, true] {
                        defects.push(Defect::Forces(when, victim, value));
                        defects.push(Defect::Holds(when, victim, value));
                    }
                    for defect in defects {
                        assert!(!march(&mut Memory::new(at, defect)), "{at:?} {defect:?}");
                    }
                }
            }
            for defect in [Defect::Both(to), Defect::Other(to)] {
                assert!(
                    !march(&mut Memory::new((from, 0), defect)),
                    "{from} {defect:?}"
                );
            }
        }
    }

    #[test]
    fn one_background_finds_stuck_bits_and_words_that_change_one_another() {
        let one = |at, defect| march_with(&mut Memory::new(at, defect), ONE_BACKGROUND);
        assert!(one((3, 7), Defect::None));
        for value in [false, true] {
            assert!(!one((12, 31), Defect::Stuck(value)));
            assert!(!one((0, 0), Defect::Slow(value)));
            assert!(!one((5, 3), Defect::Inverts(value, (9, 3))));
            assert!(!one((9, 3), Defect::Inverts(value, (5, 4))));
        }
        for other in [0, 12] {
            assert!(!one((6, 0), Defect::Both(other)));
            assert!(!one((6, 0), Defect::Other(other)));
        }
    }

    #[test]
    fn bits_of_one_word_that_hold_one_another_are_found() {
        for (bit, other) in (0..32).flat_map(|a| (0..32).map(move |b| (a, b))) {
            if bit == other {
                continue;
            }
            for (when, value) in [(false, false), (false, true), (true, false), (true, true)] {
                let defect = Defect::Holds(when, (4, other), value);
                assert!(
                    !march(&mut Memory::new((4, bit), defect)),
                    "{bit} {defect:?}"
                );
            }
        }
    }
}
