//! Decodes frames from the bytes of one direction of the radar link, or of both directions in turn.

use stairscan::Iq;
use stairscan::config::RadarConfig;
use stairscan::signal::radar::frame::{self, Decoder, Frame, FrameKind, Progress};

/// Content of a frame received from the radar link.
#[derive(Clone, Debug, PartialEq)]
pub enum LinkEvent {
    /// From the scanner: request for the module's settings, also one that changes them; with the chirps per row.
    Configure(u8),
    /// From the scanner: request for a chirp at this shaft angle, 0.001°.
    Trigger(i32),
    /// From the module: the bit rate of all following bytes, Mbaud.
    RateSet(u8),
    /// From the module: its settings.
    Settings(RadarConfig),
    /// From the module: the samples of a chirp.
    Chirp(Vec<Iq>),
    /// From the module: an error, with its code.
    Error(u8),
    /// A frame whose payload does not fit its type.
    Malformed,
}

impl LinkEvent {
    /// Returns a frame's content; `None` for a request of another bit rate, which does not belong to a scan.
    fn of(frame: &Frame<'_>) -> Option<Self> {
        let payload = frame.payload;
        let received = match frame.kind {
            FrameKind::Rate => return None,
            FrameKind::RateSet => payload.first().map(|rate| Self::RateSet(*rate)),
            FrameKind::Configure => Some(Self::Configure(1)),
            FrameKind::Program => frame::requested_chirps(payload).map(Self::Configure),
            FrameKind::Trigger => {
                let angle = <[u8; 4]>::try_from(payload).ok();
                angle.map(|angle| Self::Trigger(i32::from_le_bytes(angle)))
            }
            FrameKind::Settings => {
                frame::parse_settings(payload).map(|(radar, _)| Self::Settings(radar))
            }
            FrameKind::Chirp => {
                let mut samples = vec![Iq::default(); payload.len() / 4];
                frame::parse_chirp(payload, &mut samples).then_some(Self::Chirp(samples))
            }
            FrameKind::Error => payload.first().map(|code| Self::Error(*code)),
        };
        Some(received.unwrap_or(Self::Malformed))
    }
}

/// Finds the frames in a stream of bytes.
///
/// The scanner's own [`Decoder`] is reset with every request. A tap cannot do that, since it may
/// receive the two directions one after the other. When a frame turns out to be damaged, the
/// listener searches for another frame within its bytes, so that a few lost bytes cost only the
/// frame that they were lost from.
#[derive(Debug, Default)]
pub struct Listener {
    decoder: Decoder,
    /// Received bytes that belong to no complete frame yet.
    pending: Vec<u8>,
    /// Number of the pending bytes that the decoder has processed.
    seen: usize,
    /// Number of damaged frames found so far, including bytes that looked like the beginning of
    /// one.
    pub damaged: u32,
}

impl Listener {
    /// Adds bytes, and returns the frames that they complete, each with its sequence number.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<(u16, LinkEvent)> {
        self.pending.extend(bytes);
        let mut received = Vec::new();
        while let Some(&byte) = self.pending.get(self.seen) {
            self.seen += 1;
            match self.decoder.push(byte) {
                Ok(Progress::Partial) => self.forget_garbage(),
                Ok(Progress::Complete) => {
                    let frame = self.decoder.frame();
                    received.extend(
                        frame.and_then(|frame| Some((frame.sequence, LinkEvent::of(&frame)?))),
                    );
                    self.skip(self.seen);
                }
                Err(_) => {
                    self.damaged += 1;
                    self.skip(self.beginning() + 1);
                }
            }
        }
        received
    }

    /// Returns the offset in `pending` of the frame that the decoder has rejected.
    fn beginning(&self) -> usize {
        let magic = self.pending.windows(2).position(|two| two == b"SR");
        magic.unwrap_or(0)
    }

    /// Drops the first `count` pending bytes and decodes the rest again.
    fn skip(&mut self, count: usize) {
        self.pending.drain(..count.min(self.pending.len()));
        self.seen = 0;
        self.decoder.reset();
    }

    /// Drops the pending bytes if none of them can begin a frame.
    fn forget_garbage(&mut self) {
        let begun = self.pending.windows(2).any(|two| two == b"SR");
        if !begun && self.seen == self.pending.len() && self.pending.last() != Some(&b'S') {
            self.pending.clear();
            self.seen = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use stairscan::signal::radar::frame::MAX_FRAME;

    fn frame(kind: FrameKind, sequence: u16, payload: &[u8]) -> Vec<u8> {
        let mut out = heapless::Vec::<u8, MAX_FRAME>::new();
        frame::encode(kind, sequence, payload, &mut out);
        out.to_vec()
    }

    #[test]
    fn lost_bytes_cost_one_frame() {
        let chirp = |k: u16| frame(FrameKind::Chirp, k, &[k as u8; 80]);
        for lost in [1, 10, 60] {
            let mut bytes = chirp(1);
            bytes.truncate(92 - lost);
            for k in 2..6 {
                bytes.extend(chirp(k));
            }
            let mut listener = Listener::default();
            let received = listener.push(&bytes);
            let numbers: Vec<u16> = received.iter().map(|h| h.0).collect();
            assert_eq!(numbers, [2, 3, 4, 5], "{lost} bytes lost");
            assert!(listener.damaged > 0);
        }
    }

    proptest! {
        #[test]
        fn frames_are_found_however_the_bytes_are_cut(
            cuts in proptest::collection::vec(1_usize..40, 1..60),
            garbage in proptest::collection::vec(any::<u8>(), 0..60),
        ) {
            let mut bytes = Vec::new();
            for k in 0..8 {
                bytes.extend(&garbage);
                bytes.extend(frame(FrameKind::Trigger, k, &1000_i32.to_le_bytes()));
            }
            // Padding that completes a frame which garbage seemed to begin.
            bytes.extend([0; MAX_FRAME]);
            let mut listener = Listener::default();
            let mut received = Vec::new();
            let (mut at, mut cut) = (0, cuts.iter().cycle());
            while at < bytes.len() {
                let end = (at + cut.next().unwrap()).min(bytes.len());
                received.extend(listener.push(&bytes[at..end]));
                at = end;
            }
            let triggers = received.iter().filter(|h| h.1 == LinkEvent::Trigger(1000)).count();
            prop_assert_eq!(triggers, 8);
        }
    }
}
