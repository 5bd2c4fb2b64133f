//! Deterministic mutations: one seed gives the same sequence of inputs on every host.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Maximum length of an input, bytes.
const LONGEST: usize = 4096;
/// Bytes and words with a high chance of errors: limits of types, signs, separators.
const ODD: [&[u8]; 12] = [
    &[0],
    &[0xFF],
    &[0x7F],
    &[0x80],
    &[0xFF, 0xFF, 0xFF, 0x7F],
    &[0, 0, 0, 0x80],
    b",",
    b"\n",
    b"-",
    b"nan",
    b"1e300",
    b"99999999999999999999",
];

/// Source of mutated inputs.
#[derive(Clone, Debug)]
pub struct Mutator<'a> {
    corpus: &'a [Vec<u8>],
    random: Xoshiro128PlusPlus,
}

impl<'a> Mutator<'a> {
    /// Mutates `corpus`.
    pub fn new(corpus: &'a [Vec<u8>], seed: u64) -> Self {
        let random = Xoshiro128PlusPlus::seed_from_u64(seed);
        Self { corpus, random }
    }

    /// Returns a random number below `end`; 0 if `end` is 0.
    fn below(&mut self, end: usize) -> usize {
        let wide = u64::from(self.random.next_u32()) * end as u64;
        (wide >> 32) as usize
    }

    /// Returns the next input: one of the corpus with one to eight changes.
    pub fn input(&mut self) -> Vec<u8> {
        let chosen = self.below(self.corpus.len());
        let mut bytes = self.corpus.get(chosen).cloned().unwrap_or_default();
        for _ in 0..=self.below(8) {
            self.change(&mut bytes);
        }
        bytes.truncate(LONGEST);
        bytes
    }

    fn change(&mut self, bytes: &mut Vec<u8>) {
        let at = self.below(bytes.len());
        let length = 1 + self.below(16);
        let end = (at + length).min(bytes.len());
        match self.below(8) {
            0 | 1 if !bytes.is_empty() => bytes[at] ^= 1 << self.below(8),
            2 if !bytes.is_empty() => bytes[at] = self.random.next_u32() as u8,
            3 => drop(bytes.drain(at..end)),
            4 => {
                let again = bytes[at..end].to_vec();
                let to = self.below(bytes.len() + 1);
                bytes.splice(to..to, again);
            }
            5 => {
                let odd = ODD[self.below(ODD.len())];
                let end = (at + odd.len() * self.below(2)).min(bytes.len());
                bytes.splice(at..end, odd.iter().copied());
            }
            6 => {
                // The end of another input.
                let other = self.below(self.corpus.len());
                let other = self.corpus.get(other).map_or(&[][..], Vec::as_slice);
                let from = self.below(other.len());
                bytes.splice(at.., other[from..].iter().copied());
            }
            _ => {
                let fresh: Vec<u8> = (0..length).map(|_| self.random.next_u32() as u8).collect();
                bytes.splice(at..at, fresh);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_seed_is_one_row_of_inputs_and_nothing_stays_as_it_is() {
        let corpus = [b"status\n".to_vec(), b"get,seed\n".to_vec()];
        let row = |seed| -> Vec<Vec<u8>> {
            let mut mutator = Mutator::new(&corpus, seed);
            (0..200).map(|_| mutator.input()).collect()
        };
        assert_eq!(row(1), row(1));
        assert_ne!(row(1), row(2));
        let changed = row(1)
            .iter()
            .filter(|input| !corpus.contains(input))
            .count();
        assert!(changed > 190, "{changed}");
    }

    #[test]
    fn an_empty_corpus_still_gives_inputs() {
        let mut mutator = Mutator::new(&[], 1);
        assert!((0..50).any(|_| !mutator.input().is_empty()));
    }
}
