//! Local maxima of the image that wait for their turn, the strongest first.

use crate::math;
use crate::signal::echoes::MAX_ECHOES;
use heapless::Vec;

/// Maximum number of maxima that wait, three for each echo; the strongest are kept.
const MAX_WAITING: usize = 3 * MAX_ECHOES;
/// Units of a level per octave of power, and octave at which they begin.
const LEVELS_PER_OCTAVE: f32 = 256.0;
const FIRST_OCTAVE: f32 = -80.0;

/// Place of a cell in the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Node of the angle.
    pub node: usize,
    /// Stored bin of the range.
    pub bin: usize,
}

/// The maxima, each in one word: level, node, bin. Words are ordered by level, and equal levels by cell, so that the order
/// of arrival has no influence.
#[derive(Clone, Debug)]
pub struct Waiting(Vec<u32, MAX_WAITING>);

/// Returns the word of a maximum.
fn word(level: u16, place: Place) -> u32 {
    // Nodes and bins are at most 256.
    u32::from(level) << 16 | (place.node as u32 & 0xff) << 8 | place.bin as u32 & 0xff
}

impl Waiting {
    /// Returns an empty queue.
    pub const fn new() -> Self {
        Self(Vec::new())
    }

    /// Returns the level of a power.
    pub fn level(power: f32) -> u16 {
        let octaves = math::log2(math::max(power, f32::MIN_POSITIVE)) - FIRST_OCTAVE;
        // The cast saturates.
        (octaves * LEVELS_PER_OCTAVE) as u16
    }

    /// Adds a maximum, or changes the level of one that waits already. Without room it replaces the weakest one if it is
    /// stronger.
    pub fn push(&mut self, level: u16, place: Place) {
        let word = word(level, place);
        if let Some(known) = self.0.iter_mut().find(|other| (**other ^ word) << 16 == 0) {
            *known = word;
        } else if self.0.push(word).is_err()
            && let Some(weakest) = self.0.iter_mut().min()
        {
            *weakest = (*weakest).max(word);
        }
    }

    /// Removes and returns the strongest maximum.
    pub fn pop(&mut self) -> Option<(u16, Place)> {
        // No two words are equal.
        let (at, &word) = self.0.iter().enumerate().max_by_key(|(_, word)| **word)?;
        let last = self.0.pop()?;
        if let Some(place) = self.0.get_mut(at) {
            *place = last;
        }
        let place = Place {
            node: (word >> 8 & 0xff) as usize,
            bin: (word & 0xff) as usize,
        };
        Some(((word >> 16) as u16, place))
    }
}
