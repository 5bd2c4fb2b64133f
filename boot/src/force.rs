//! Whether the loader waits for a host although there is an image to execute, and for how long.
//!
//! Two things force it: a pin that is held, and three resets without a minute of operation between them, as those of a
//! confirmed image that crashes again and again. All of it is decided from what is known at a reset.

use stairscan::scanner::handover::Handover;
use stairscan::scanner::resets::Resets;

/// Resets, each less than a minute of operation after the one before, at which the loader waits.
pub const LIMIT: u32 = 3;
/// Time without a request until the loader gives up waiting, ms.
pub const SILENCE_MS: u32 = 60_000;
/// Time without a first request until the loader gives up waiting after three resets, ms.
pub const WINDOW_MS: u32 = 10_000;

/// Why the loader waits although there is an image to execute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Forced {
    /// The pin is held.
    Pin,
    /// Resets followed one another.
    Resets,
}

impl Forced {
    /// Its word in the sentence.
    pub const fn as_str(self) -> &'static str {
        match self {
            Forced::Pin => "pin",
            Forced::Resets => "resets",
        }
    }
}

/// Inputs of the decision at a reset: message, count of resets, pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AtReset {
    /// Message of image or loader from before the reset.
    pub handed: Option<Handover>,
    /// Number of resets before this one; `None` after a loss of power, or where they do not count.
    pub resets: Option<Resets>,
    /// Whether the pin is held.
    pub held: bool,
}

impl AtReset {
    /// Decides whether the loader waits, and returns the count to leave for the next reset. `trial`: whether an image on
    /// trial would be executed, which three resets roll back anyway.
    pub fn decide(self, trial: impl FnOnce() -> bool) -> (Option<Forced>, Option<Resets>) {
        match self.handed {
            // A reset that was asked for is none that counts.
            Some(Handover::Update | Handover::Confirm | Handover::Execute) => return (None, None),
            Some(Handover::Trial) | None => {}
        }
        if self.held {
            return (Some(Forced::Pin), None);
        }
        let count = self
            .resets
            .map_or(0, |Resets(count)| count.saturating_add(1));
        if count < LIMIT {
            (None, Some(Resets(count)))
        } else if trial() {
            (None, None)
        } else {
            (Some(Forced::Resets), None)
        }
    }
}

/// The time that the loader waits.
#[derive(Clone, Copy, Debug)]
pub struct Waiting {
    forced: Option<Forced>,
    /// Time since the last request, ms.
    pub silent_ms: u32,
    /// Time since the last request, or since the pin was released, ms.
    idle_ms: u32,
    asked: bool,
}

impl Waiting {
    /// The loader begins to wait.
    pub const fn new(forced: Option<Forced>) -> Self {
        Self {
            forced,
            silent_ms: 0,
            idle_ms: 0,
            asked: false,
        }
    }

    /// A millisecond has passed; `held`: whether the pin is held.
    pub fn tick(&mut self, held: bool) {
        self.silent_ms = self.silent_ms.saturating_add(1);
        self.idle_ms = match self.forced {
            Some(Forced::Pin) if held => 0,
            _ => self.idle_ms.saturating_add(1),
        };
    }

    /// A request has come.
    pub fn heard(&mut self) {
        (self.silent_ms, self.idle_ms, self.asked) = (0, 0, true);
    }

    /// Whether the loader gives up waiting.
    pub fn is_over(&self) -> bool {
        let limit = match self.forced {
            Some(Forced::Resets) if !self.asked => WINDOW_MS,
            _ => SILENCE_MS,
        };
        self.idle_ms > limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(resets: Option<Resets>) -> AtReset {
        AtReset {
            handed: None,
            resets,
            held: false,
        }
    }

    /// Resets in a row until the loader waits, from the count that is there first.
    fn until_forced(mut resets: Option<Resets>) -> u32 {
        for number in 0.. {
            let (forced, left) = at(resets).decide(|| false);
            if forced.is_some() {
                assert_eq!((forced, left), (Some(Forced::Resets), None));
                return number;
            }
            resets = left;
        }
        unreachable!()
    }

    #[test]
    fn power_on_is_no_reset_and_the_third_one_after_it_forces() {
        assert_eq!(until_forced(None), 3);
        // SRAM at power-on holds anything.
        let mut bits = 1_u32;
        for _ in 0..100_000 {
            let words = [(); 3].map(|()| {
                bits ^= bits << 13;
                bits ^= bits >> 17;
                bits ^= bits << 5;
                bits
            });
            let found = at(Resets::from_words(words)).decide(|| false);
            assert_eq!(found, (None, Some(Resets(0))), "{words:x?}");
        }
    }

    #[test]
    fn a_count_that_the_image_has_cleared_begins_anew() {
        assert_eq!(until_forced(Some(Resets(0))), 2, "three with this one");
        let (_, left) = at(Some(Resets(0))).decide(|| false);
        assert_eq!(left, Some(Resets(1)));
        assert_eq!(until_forced(Some(Resets(2))), 0);
        assert_eq!(until_forced(Some(Resets(u32::MAX))), 0);
    }

    #[test]
    fn a_reset_that_was_asked_for_forces_nothing() {
        for handed in [Handover::Update, Handover::Confirm, Handover::Execute] {
            let found = AtReset {
                handed: Some(handed),
                resets: Some(Resets(2)),
                held: true,
            };
            assert_eq!(found.decide(|| false), (None, None));
        }
        let crashed = AtReset {
            handed: Some(Handover::Trial),
            ..at(Some(Resets(0)))
        };
        assert_eq!(crashed.decide(|| false), (None, Some(Resets(1))));
    }

    #[test]
    fn an_image_on_trial_is_left_to_its_trial_but_not_by_the_pin() {
        assert_eq!(at(Some(Resets(2))).decide(|| true), (None, None));
        for resets in [None, Some(Resets(0)), Some(Resets(9))] {
            let held = AtReset {
                held: true,
                ..at(resets)
            };
            assert_eq!(held.decide(|| true), (Some(Forced::Pin), None));
        }
    }

    /// Milliseconds until the loader gives up; the pin is held for the first `held` of them.
    fn waits(waiting: &mut Waiting, held: u32) -> u32 {
        for ms in 0.. {
            if waiting.is_over() {
                return ms - 1;
            }
            waiting.tick(ms < held);
        }
        unreachable!()
    }

    #[test]
    fn it_waits_as_long_as_the_reason_lasts() {
        assert_eq!(waits(&mut Waiting::new(None), 0), SILENCE_MS);
        let mut window = Waiting::new(Some(Forced::Resets));
        assert_eq!(waits(&mut window, 0), WINDOW_MS);
        // A host that has begun has a minute again.
        let mut window = Waiting::new(Some(Forced::Resets));
        window.heard();
        assert_eq!(waits(&mut window, 0), SILENCE_MS);
        let mut pin = Waiting::new(Some(Forced::Pin));
        assert_eq!(waits(&mut pin, 200_000), 200_000 + SILENCE_MS);
        assert_eq!(pin.silent_ms, 200_001 + SILENCE_MS);
        // The pin counts only where it is why the loader waits.
        let mut window = Waiting::new(Some(Forced::Resets));
        assert_eq!(waits(&mut window, 200_000), WINDOW_MS);
    }
}
