//! The bit rate of the radar link: ports follow the rate that scanner and module agree on, and search for it if bytes
//! come but no frames, as after a break or if the recording begins after the agreement.

use stairscan::signal::radar::wire::LINK_BAUD;

use super::scans::Tap;
use crate::live::Ms;

/// Bit rates of the link, baud, in the order of the search.
const RATES: [u32; 3] = [LINK_BAUD, 3 * LINK_BAUD, 2 * LINK_BAUD];
/// Number of bytes without an intact frame that shows another rate: more than two of the longest frames (1,036 bytes).
const GARBAGE: usize = 2_500;
/// Same, for a link with little traffic: this number of bytes, and the time without an intact frame, ms.
const SOME_GARBAGE: (usize, Ms) = (16, 1_000);

/// Bit rate at which the ports of the link are read.
#[derive(Clone, Debug)]
pub struct Pace {
    /// The present rate, baud.
    pub baud: u32,
    /// The rate that scanner and module agreed on last, baud; `None` if no agreement was received.
    pub agreed: Option<u32>,
    /// Rates tried since the last intact frame, baud.
    pub tried: Vec<u32>,
    order: Vec<u32>,
    /// Number of bytes since the last intact frame or change of the rate, and the time of that.
    garbage: usize,
    since: Ms,
    frames: u64,
}

impl Pace {
    /// Begins at `baud`.
    pub fn new(baud: u32) -> Self {
        let other = (!RATES.contains(&baud)).then_some(baud);
        Self {
            baud,
            agreed: None,
            tried: vec![baud],
            order: RATES.into_iter().chain(other).collect(),
            garbage: 0,
            since: 0,
            frames: 0,
        }
    }

    /// Takes note of `count` bytes that `tap` received at `now`. Returns the rate to change to, if it is another.
    pub fn take(&mut self, now: Ms, count: usize, tap: &mut Tap) -> Option<u32> {
        self.garbage += count;
        if tap.frames() > self.frames {
            self.frames = tap.frames();
            (self.garbage, self.since) = (0, now);
            self.tried = vec![self.baud];
        }
        if let Some(mbaud) = tap.rate_set() {
            let agreed = u32::from(mbaud) * LINK_BAUD;
            self.agreed = Some(agreed);
            return (agreed != self.baud).then(|| self.change(now, agreed));
        }
        let (few, long) = SOME_GARBAGE;
        let slow = self.garbage >= few && now.saturating_sub(self.since) >= long;
        (self.garbage >= GARBAGE || slow).then(|| {
            let place = self.order.iter().position(|&rate| rate == self.baud);
            let next = place.map_or(0, |place| (place + 1) % self.order.len());
            self.change(now, self.order[next])
        })
    }

    fn change(&mut self, now: Ms, baud: u32) -> u32 {
        (self.baud, self.garbage, self.since) = (baud, 0, now);
        if !self.tried.contains(&baud) {
            self.tried.push(baud);
        }
        baud
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tap::scans::Wire;
    use stairscan::signal::radar::frame::{self, FrameKind, MAX_FRAME};

    fn frame(kind: FrameKind, payload: &[u8]) -> Vec<u8> {
        let mut out = heapless::Vec::<u8, MAX_FRAME>::new();
        frame::encode(kind, 7, payload, &mut out);
        out.to_vec()
    }

    #[test]
    fn an_agreement_is_followed_and_a_break_searched() {
        let (mut pace, mut tap) = (Pace::new(LINK_BAUD), Tap::default());
        let mut push = |now: Ms, bytes: &[u8]| {
            tap.push(now, Wire::Both, bytes);
            pace.take(now, bytes.len(), &mut tap)
        };
        let garbage = [0x55; 1_000];
        assert_eq!(push(0, &frame(FrameKind::Rate, &[3])), None);
        assert_eq!(push(1, &frame(FrameKind::RateSet, &[3])), Some(3_000_000));
        let chirp = frame(FrameKind::Chirp, &[1; 800]);
        assert_eq!(push(2, &chirp), None);
        // Back at 1 Mbaud: each rate in turn, until frames come.
        let found: Vec<_> = (0..6).filter_map(|k| push(3 + k, &garbage)).collect();
        assert_eq!(found, [2_000_000, 1_000_000]);
        for k in 0..4 {
            assert_eq!(push(20 + k, &[&garbage[..], &chirp].concat()), None);
        }
        // Few bytes.
        assert_eq!(push(500, &[0; 20]), None);
        assert_eq!(push(1_500, &[0]), Some(3_000_000));
    }
}
