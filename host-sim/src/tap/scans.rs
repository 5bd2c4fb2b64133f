//! Assembles requests to the radar module and its answers into scans, row by row.

use std::collections::VecDeque;
use std::fmt;

use stairscan::Iq;
use stairscan::config::RadarConfig;

use super::listen::{LinkEvent, Listener};
use crate::live::Ms;
use crate::live::arrived::Arrived;
use crate::live::lines::Splitter;

/// Maximum number of answers that are stored until their requests are read. The ports are read one
/// after the other, and a busy machine may read one of them half a second late.
const MAX_UNMATCHED: usize = 64;
/// Time after which an answer is no longer assigned to a request, ms: sequence numbers repeat.
const WAITS: Ms = 1_000;

/// A trigger (the scanner's request for a chirp), with the radar module's answer.
#[derive(Clone, Debug)]
struct Asked {
    sequence: u16,
    /// Shaft angle in the trigger, 0.001°.
    angle: i32,
    at: Ms,
    answer: Option<LinkEvent>,
}

/// A scan that is being received: a request for the module's settings, and the triggers up to the
/// next such request.
#[derive(Clone, Debug)]
struct Draft {
    /// Sequence number of the settings request; `None` if the tap began during the scan.
    question: Option<u16>,
    /// Number of chirps per row that the scanner requested.
    chirps: u8,
    radar: Option<RadarConfig>,
    /// Module settings valid before this scan, used if its own are not received.
    before: Option<RadarConfig>,
    triggers: Vec<Asked>,
}

/// One row of a scan: shaft angle and chirp.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Angle of the shaft, 0.001°.
    pub angle: i32,
    /// Time of the row's last trigger, ms since the session began.
    pub at: Ms,
    /// The chirp that the scanner received; `None` if the tap did not receive it completely.
    pub chirp: Option<Vec<Iq>>,
}

/// Numbers of triggers without a usable chirp during a scan, by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// Number of triggers without an undamaged answer.
    pub unanswered: u32,
    /// Number of triggers that the module answered with an error.
    pub refused: u32,
    /// Number of chirps whose number of samples differs from that in the module's settings.
    pub misshapen: u32,
}

impl fmt::Display for Losses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            unanswered,
            refused,
            misshapen,
        } = self;
        write!(
            f,
            "{unanswered} triggers without an intact answer, {refused} errors of the module, {misshapen} chirps \
             of a wrong length"
        )
    }
}

/// A scan as received by the tap.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// Settings of the module; `None` if they have never been received.
    pub radar: Option<RadarConfig>,
    /// Whether the module's settings were received in this scan; otherwise they are those of an
    /// earlier one.
    pub settings_heard: bool,
    /// Number of chirps per row that the scanner requested.
    pub chirps: u8,
    /// Whether the scan's beginning, the request for settings, was received.
    pub begun: bool,
    /// The scan's rows, in the order of their triggers.
    pub rows: Vec<Row>,
    /// Numbers of triggers without a usable chirp.
    pub losses: Losses,
}

impl Scan {
    /// Returns the rows with a chirp, and their samples.
    pub fn received(&self) -> impl Iterator<Item = (&Row, &[Iq])> {
        let rows = self.rows.iter();
        rows.filter_map(|row| Some((row, row.chirp.as_deref()?)))
    }

    /// Returns the number of rows without a chirp.
    pub fn lost(&self) -> usize {
        self.rows.len() - self.received().count()
    }
}

/// Wire on which bytes were received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wire {
    /// The wire from scanner to module.
    ToModule,
    /// The wire from module to scanner.
    FromModule,
    /// Both directions on one port, because the link is half-duplex.
    Both,
}

/// Receives the bytes of a radar link and assembles them into scans.
#[derive(Debug, Default)]
pub struct Tap {
    wires: [Listener; 3],
    drafts: VecDeque<Draft>,
    unmatched: VecDeque<(Ms, u16, LinkEvent)>,
    /// The last settings that the radar module reported; `None` before its first report.
    radar: Option<RadarConfig>,
    /// Number of answers discarded so far because their requests were not received.
    unmatched_count: u32,
    done: VecDeque<Scan>,
    /// Time at which the last frame was received, ms.
    received: Option<Ms>,
    frames: u64,
    /// Bit rate that the module has confirmed, until [`Tap::rate_set`] takes it, Mbaud.
    rate: Option<u8>,
    /// Lines that were received before the first frame, if this is another port.
    reader: Splitter,
    arrived: Arrived,
}

impl Tap {
    /// Processes bytes received on `wire` at `now`, ms.
    pub fn push(&mut self, now: Ms, wire: Wire, bytes: &[u8]) {
        if self.received.is_none() {
            for line in self.reader.push(bytes) {
                self.arrived.line(&line);
            }
        }
        for (sequence, received) in self.wires[wire as usize].push(bytes) {
            self.received = Some(now);
            self.frames += 1;
            match received {
                LinkEvent::RateSet(rate) => {
                    self.rate = Some(rate);
                    continue;
                }
                LinkEvent::Configure(chirps) => self.begin(Some(sequence), chirps),
                LinkEvent::Trigger(angle) => self.trigger(now, sequence, angle),
                answer => {
                    if let Some(answer) = self.answer(sequence, answer) {
                        self.keep_unmatched(now, sequence, answer);
                    }
                    continue;
                }
            }
            // Its answer may have been read before it.
            self.expire_unmatched(now);
            if let Some(place) = self
                .unmatched
                .iter()
                .position(|unmatched| unmatched.1 == sequence)
                && let Some((_, sequence, answer)) = self.unmatched.remove(place)
            {
                self.answer(sequence, answer);
            }
        }
    }

    /// Removes and returns the oldest complete scan; `None` if there is none.
    pub fn scan(&mut self) -> Option<Scan> {
        self.done.pop_front()
    }

    /// Completes all scans that are being received, because no more data will come.
    pub fn end(&mut self) {
        while let Some(draft) = self.drafts.pop_front() {
            self.finish(draft);
        }
    }

    /// Returns the time at which the last frame was received, ms.
    pub fn received(&self) -> Option<Ms> {
        self.received
    }

    /// Returns the number of intact frames received on all wires.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Returns the bit rate, Mbaud, that the module has confirmed since the last call; `None` without a confirmation.
    pub fn rate_set(&mut self) -> Option<u8> {
        self.rate.take()
    }

    /// Returns what was received before the first frame.
    pub fn arrived(&self) -> Arrived {
        self.arrived.with_pending(&self.reader)
    }

    /// Returns the number of damaged frames on all wires.
    pub fn damaged(&self) -> u32 {
        self.wires.iter().map(|wire| wire.damaged).sum()
    }

    /// Returns the number of answers whose requests were not received.
    pub fn unmatched_count(&self) -> u32 {
        self.unmatched_count + self.unmatched.len() as u32
    }

    fn trigger(&mut self, now: Ms, sequence: u16, angle: i32) {
        if self.drafts.is_empty() {
            // The tap began during a scan.
            self.begin(None, 1);
        }
        if let Some(draft) = self.drafts.back_mut() {
            draft.triggers.push(Asked {
                sequence,
                angle,
                at: now,
                answer: None,
            });
        }
    }

    fn begin(&mut self, question: Option<u16>, chirps: u8) {
        self.drafts.push_back(Draft {
            question,
            chirps,
            radar: None,
            before: self.radar,
            triggers: Vec::new(),
        });
    }

    fn keep_unmatched(&mut self, now: Ms, sequence: u16, answer: LinkEvent) {
        self.expire_unmatched(now);
        if self.unmatched.len() == MAX_UNMATCHED {
            self.unmatched.pop_front();
            self.unmatched_count += 1;
        }
        self.unmatched.push_back((now, sequence, answer));
    }

    /// Discards and counts answers whose requests have not been received within [`WAITS`].
    fn expire_unmatched(&mut self, now: Ms) {
        let late = |unmatched: &mut (Ms, u16, LinkEvent)| now.saturating_sub(unmatched.0) > WAITS;
        while self.unmatched.pop_front_if(late).is_some() {
            self.unmatched_count += 1;
        }
    }

    /// Assigns an answer to the request with this sequence number; returns the answer if there is
    /// no such request.
    fn answer(&mut self, sequence: u16, answer: LinkEvent) -> Option<LinkEvent> {
        for (place, draft) in self.drafts.iter_mut().enumerate().rev() {
            if draft.question == Some(sequence) {
                if let LinkEvent::Settings(radar) = answer {
                    draft.radar = Some(radar);
                    self.radar = Some(radar);
                }
            } else if let Some(asked) = draft
                .triggers
                .iter_mut()
                .rev()
                .find(|a| a.sequence == sequence)
            {
                asked.answer = Some(answer);
            } else {
                continue;
            }
            // The module answers in order: the scans before are complete.
            for draft in self.drafts.drain(..place).collect::<Vec<_>>() {
                self.finish(draft);
            }
            return None;
        }
        Some(answer)
    }

    /// Completes a scan that was being received. A settings request without triggers does not
    /// belong to a scan: it is a self-test or a repeated request.
    fn finish(&mut self, draft: Draft) {
        if draft.triggers.is_empty() {
            return;
        }
        let radar = draft.radar.or(draft.before);
        let samples = radar.map(|radar| usize::from(radar.samples));
        let mut losses = Losses::default();
        let mut rows: Vec<Row> = Vec::new();
        for asked in draft.triggers {
            let chirp = match asked.answer {
                Some(LinkEvent::Chirp(chirp)) if samples.is_none_or(|n| n == chirp.len()) => {
                    Some(chirp)
                }
                Some(LinkEvent::Chirp(_)) => count(&mut losses.misshapen),
                Some(LinkEvent::Error(_)) => count(&mut losses.refused),
                _ => count(&mut losses.unanswered),
            };
            let row = Row {
                angle: asked.angle,
                at: asked.at,
                chirp,
            };
            match rows.last_mut() {
                // A retry: the previous answer was rejected or late.
                Some(last) if last.angle == row.angle => *last = row,
                _ => rows.push(row),
            }
        }
        self.done.push_back(Scan {
            chirps: draft.chirps,
            radar,
            settings_heard: draft.radar.is_some(),
            begun: draft.question.is_some(),
            rows,
            losses,
        });
    }
}

fn count<T>(counter: &mut u32) -> Option<T> {
    *counter += 1;
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use stairscan::signal::radar::frame::{self, Ability, FrameKind, MAX_FRAME};

    const RADAR: RadarConfig = RadarConfig {
        carrier_khz: 94_000_000,
        bandwidth_khz: 10_000_000,
        samples: 16,
        real: false,
    };

    fn hear(tap: &mut Tap, at: Ms, kind: FrameKind, sequence: u16, payload: &[u8]) {
        let mut out = heapless::Vec::<u8, MAX_FRAME>::new();
        frame::encode(kind, sequence, payload, &mut out);
        tap.push(at, Wire::Both, &out);
    }

    fn settings(tap: &mut Tap, at: Ms, sequence: u16, radar: &RadarConfig) {
        hear(tap, at, FrameKind::Configure, sequence, &[]);
        hear(
            tap,
            at,
            FrameKind::Settings,
            sequence,
            &frame::settings_payload(radar, Ability::NONE),
        );
    }

    fn trigger(tap: &mut Tap, at: Ms, sequence: u16, angle: i32) {
        hear(tap, at, FrameKind::Trigger, sequence, &angle.to_le_bytes());
    }

    /// Feeds `tap` with a chirp all of whose samples are `value`.
    fn chirp(tap: &mut Tap, at: Ms, sequence: u16, value: u8) {
        hear(tap, at, FrameKind::Chirp, sequence, &[value; 64]);
    }

    fn values(scan: &Scan) -> Vec<Option<i16>> {
        let first = |row: &Row| row.chirp.as_ref().map(|chirp| chirp[0].i & 0xFF);
        scan.rows.iter().map(first).collect()
    }

    #[test]
    fn the_last_attempt_at_a_row_counts() {
        let mut tap = Tap::default();
        settings(&mut tap, 0, 1, &RADAR);
        // Late: the scanner had already repeated the request.
        trigger(&mut tap, 1, 2, 0);
        trigger(&mut tap, 2, 3, 0);
        chirp(&mut tap, 3, 2, 2);
        chirp(&mut tap, 4, 3, 3);
        // Late, and then nothing: the scanner had given the row up.
        trigger(&mut tap, 5, 4, 250);
        trigger(&mut tap, 6, 5, 250);
        chirp(&mut tap, 7, 4, 4);
        trigger(&mut tap, 8, 6, 500);
        hear(&mut tap, 9, FrameKind::Error, 6, &[2]);
        trigger(&mut tap, 10, 7, 750);
        hear(&mut tap, 11, FrameKind::Chirp, 7, &[7; 60]);
        tap.end();
        let scan = tap.scan().unwrap();
        assert_eq!(values(&scan), [Some(3), None, None, None]);
        let expected = Losses {
            unanswered: 1,
            refused: 1,
            misshapen: 1,
        };
        assert_eq!((scan.losses, scan.lost(), tap.scan()), (expected, 3, None));
    }

    #[test]
    fn a_number_that_comes_again_gets_no_old_chirp() {
        let mut tap = Tap::default();
        settings(&mut tap, 0, 1, &RADAR);
        // Its request was not received.
        chirp(&mut tap, 10, 7, 99);
        trigger(&mut tap, 5_000, 7, 0);
        tap.end();
        assert_eq!(values(&tap.scan().unwrap()), [None]);
        assert_eq!(tap.unmatched_count(), 1);
    }

    #[test]
    fn settings_that_were_not_heard_are_those_before_never_those_after() {
        let other = RadarConfig {
            bandwidth_khz: 5_000_000,
            ..RADAR
        };
        let mut tap = Tap::default();
        hear(&mut tap, 0, FrameKind::Configure, 1, &[]);
        trigger(&mut tap, 1, 2, 0);
        settings(&mut tap, 2, 3, &RADAR);
        trigger(&mut tap, 3, 4, 0);
        hear(&mut tap, 4, FrameKind::Configure, 5, &[]);
        trigger(&mut tap, 5, 6, 0);
        settings(&mut tap, 6, 7, &other);
        tap.end();
        let received: Vec<_> = std::iter::from_fn(|| tap.scan())
            .map(|scan| (scan.radar, scan.settings_heard))
            .collect();
        assert_eq!(
            received,
            [(None, false), (Some(RADAR), true), (Some(RADAR), false)]
        );
    }
}
