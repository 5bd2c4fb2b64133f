//! The simulated radar module: answers the link's frames from a recording, and injects faults on request.

use std::str::FromStr;

use anyhow::{Context, Result, bail};
use indicatif::ProgressBar;
use stairscan::Iq;
use stairscan::config::RadarConfig;
use stairscan::signal::radar::frame::{self, Ability, Decoder, FrameKind, MAX_FRAME, Progress};

use crate::playback::{Playback, Player};

/// Kind of fault of the radar module that is injected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InjectedFault {
    /// The chirp is not sent.
    Lost,
    /// One bit of the chirp is wrong.
    Corrupt,
    /// The previous chirp is sent again before the right one.
    Repeat,
    /// The chirp arrives after the scanner's timeout, when it is requested again.
    Late,
    /// The module reports a hardware failure.
    Error,
    /// Nothing is sent from the fault's first row on.
    Silent,
    /// The module reports settings that no scanner can work with.
    Config,
}

/// An injected fault and its rows, in text form `KIND[@ROW[-LAST]][xTIMES]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Kind of fault.
    pub kind: InjectedFault,
    /// First and last row, by their trigger angles, counted from 0 in the order of the triggers.
    pub rows: (u32, u32),
    /// Number of consecutive triggers at each of these rows that fail.
    pub times: u32,
}

impl FromStr for Fault {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let expected = || {
            format!(
                "fault {text}: expected KIND[@ROW[-LAST]][xTIMES] with KIND one of lost, corrupt, \
                 repeat, late, error, silent, config"
            )
        };
        let kinds = [
            ("lost", InjectedFault::Lost),
            ("corrupt", InjectedFault::Corrupt),
            ("repeat", InjectedFault::Repeat),
            ("late", InjectedFault::Late),
            ("error", InjectedFault::Error),
            ("silent", InjectedFault::Silent),
            ("config", InjectedFault::Config),
        ];
        let found = kinds.iter().find(|(name, _)| text.starts_with(name));
        let &(name, kind) = found.with_context(expected)?;
        let (place, times) = match text[name.len()..].split_once('x') {
            Some((place, times)) => (place, times.parse().with_context(expected)?),
            None => (&text[name.len()..], 1),
        };
        let rows = match place
            .strip_prefix('@')
            .map(|p| p.split_once('-').unwrap_or((p, p)))
        {
            Some((first, last)) => (
                first.parse().with_context(expected)?,
                last.parse().with_context(expected)?,
            ),
            None if place.is_empty() => (0, 0),
            None => bail!(expected()),
        };
        Ok(Self { kind, rows, times })
    }
}

/// A trigger of a chirp, as received from the scanner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trigger {
    /// Angle of the shaft, 0.001°.
    pub shaft_angle: i32,
    /// Number of previous consecutive triggers at this angle.
    pub attempt: u32,
}

/// The simulated radar module at the far end of the link.
#[derive(Debug)]
pub struct Module<'a> {
    player: Player<'a>,
    radar: RadarConfig,
    ability: Ability,
    /// Number of chirps per row of the recording.
    chirps: u8,
    /// Number of chirps per row that the scanner requested last.
    asked: u8,
    decoder: Decoder,
    /// Whether the handshake is answered; false while it is withheld.
    ready: bool,
    kept_back: Option<u16>,
    faults: Vec<Fault>,
    rows: u32,
    /// Progress bar that is advanced with every triggered row.
    bar: ProgressBar,
    last: Option<Trigger>,
    last_chirp: Vec<u8>,
    late: Vec<u8>,
    silent: bool,
    /// Number of damaged frames received from the scanner.
    garbage: u32,
}

fn encode(kind: FrameKind, sequence: u16, payload: &[u8]) -> Vec<u8> {
    let mut out = heapless::Vec::<u8, MAX_FRAME>::new();
    frame::encode(kind, sequence, payload, &mut out);
    out.to_vec()
}

fn chirp_payload(samples: &[Iq]) -> Vec<u8> {
    samples
        .iter()
        .flat_map(|s| [s.i.to_le_bytes(), s.q.to_le_bytes()])
        .flatten()
        .collect()
}

impl<'a> Module<'a> {
    /// Creates a module that plays `playback`. It withholds the answer to the handshake until [`Self::get_ready`].
    pub fn new(playback: &'a Playback<'a>) -> Self {
        Self {
            player: Player::new(playback),
            radar: playback.radar(),
            ability: Ability {
                ahead: true,
                adds: playback.chirps() > 1,
                ..Ability::NONE
            },
            chirps: playback.chirps(),
            asked: 1,
            decoder: Decoder::new(),
            ready: false,
            kept_back: None,
            faults: Vec::new(),
            rows: 0,
            bar: ProgressBar::hidden(),
            last: None,
            last_chirp: Vec::new(),
            late: Vec::new(),
            silent: false,
            garbage: 0,
        }
    }

    /// Returns the module with other abilities; without them it captures ahead, at 1 Mbaud.
    pub fn with_ability(self, ability: Ability) -> Self {
        Self { ability, ..self }
    }

    /// Returns the module's abilities.
    pub fn ability(&self) -> Ability {
        self.ability
    }

    /// Sets a progress bar that is advanced with every triggered row.
    pub fn watch(&mut self, bar: ProgressBar) {
        self.bar = bar;
    }

    /// Sets the faults that are injected from now on; rows are counted from the next trigger.
    pub fn set_faults(&mut self, faults: &[Fault]) {
        self.faults = faults.to_vec();
        self.rows = 0;
        self.last = None;
        self.silent = false;
        self.late.clear();
    }

    /// Answers the handshake from now on. Returns the answer that was withheld so far, empty if there is none.
    pub fn get_ready(&mut self) -> Vec<u8> {
        self.ready = true;
        self.kept_back
            .take()
            .map_or(Vec::new(), |s| self.settings(s))
    }

    /// Returns the number of damaged frames received from the scanner.
    pub fn garbage(&self) -> u32 {
        self.garbage
    }

    /// Processes bytes from the scanner. Returns the bytes of the answers, and the scanner's requests.
    pub fn receive(&mut self, bytes: &[u8]) -> (Vec<u8>, Vec<Request>) {
        let (mut out, mut requests) = (Vec::new(), Vec::new());
        for &byte in bytes {
            match self.decoder.push(byte) {
                Ok(Progress::Partial) => {}
                Ok(Progress::Complete) => {
                    let Some(frame) = self.decoder.frame() else {
                        continue;
                    };
                    let angle = <[u8; 4]>::try_from(frame.payload).map(i32::from_le_bytes);
                    let (kind, sequence) = (frame.kind, frame.sequence);
                    match (kind, angle) {
                        (FrameKind::Configure | FrameKind::Program, _) => {
                            self.asked = frame::requested_chirps(frame.payload).unwrap_or(1);
                            requests.push(Request::Configure);
                            out.extend(self.configure(sequence));
                        }
                        (FrameKind::Trigger, Ok(angle)) => {
                            let trigger = self.count(angle);
                            requests.push(Request::Trigger(trigger));
                            out.extend(self.chirp(sequence, trigger));
                        }
                        (FrameKind::Rate, _) if self.has_rate(frame.payload) => {
                            requests.push(Request::Rate(frame.payload[0]));
                            out.extend(encode(FrameKind::RateSet, sequence, frame.payload));
                        }
                        _ => out.extend(encode(FrameKind::Error, sequence, &[3])),
                    }
                }
                Err(_) => self.garbage += 1,
            }
        }
        (out, requests)
    }

    /// Whether a rate frame's payload is a rate that the module supports.
    fn has_rate(&self, payload: &[u8]) -> bool {
        matches!(payload, [rate] if (1..=self.ability.fastest).contains(rate))
    }

    fn settings(&self, sequence: u16) -> Vec<u8> {
        let mut radar = self.radar;
        if self.faults.iter().any(|f| f.kind == InjectedFault::Config) {
            radar.samples = 257;
        }
        let payload = frame::settings_payload(&radar, self.ability);
        encode(FrameKind::Settings, sequence, &payload)
    }

    /// Returns the index of the chirp for `shaft_angle` (0.001°) in the current scan.
    pub fn number(&self, shaft_angle: i32) -> Option<usize> {
        self.player.number(shaft_angle)
    }

    /// Returns the number of scans with at least one requested chirp.
    pub fn begun(&self) -> usize {
        self.player.begun()
    }

    fn configure(&mut self, sequence: u16) -> Vec<u8> {
        self.radar = self.player.configure();
        if !self.ready {
            self.kept_back = Some(sequence);
            return Vec::new();
        }
        if self.silent || self.fault(0, 0) == Some(InjectedFault::Silent) {
            return Vec::new();
        }
        self.settings(sequence)
    }

    /// Counts a trigger's row, and returns the trigger with its attempt.
    fn count(&mut self, shaft_angle: i32) -> Trigger {
        let attempt = match self.last {
            Some(last) if last.shaft_angle == shaft_angle => last.attempt + 1,
            Some(_) => {
                self.rows += 1;
                self.bar.inc(1);
                0
            }
            None => 0,
        };
        let trigger = Trigger {
            shaft_angle,
            attempt,
        };
        self.last = Some(trigger);
        trigger
    }

    fn fault(&self, row: u32, attempt: u32) -> Option<InjectedFault> {
        let here = |f: &&Fault| {
            let open = f.kind == InjectedFault::Silent;
            row >= f.rows.0 && (open || (row <= f.rows.1 && attempt < f.times))
        };
        self.faults.iter().find(here).map(|f| f.kind)
    }

    fn chirp(&mut self, sequence: u16, trigger: Trigger) -> Vec<u8> {
        let mut out = std::mem::take(&mut self.late);
        let Some(samples) = self.player.trigger(trigger.shaft_angle) else {
            return out;
        };
        let mut chirp = match self.asked == self.chirps {
            true => encode(FrameKind::Chirp, sequence, &chirp_payload(samples)),
            // Not ready: the recording has rows of another number of chirps.
            false => encode(FrameKind::Error, sequence, &[1]),
        };
        let before = std::mem::replace(&mut self.last_chirp, chirp.clone());
        let fault = self.fault(self.rows, trigger.attempt);
        self.silent |= fault == Some(InjectedFault::Silent);
        if self.silent {
            return out;
        }
        match fault {
            Some(InjectedFault::Lost) => chirp.clear(),
            Some(InjectedFault::Corrupt) => {
                let middle = chirp.len() / 2;
                chirp[middle] ^= 0x10;
            }
            Some(InjectedFault::Repeat) => out.extend(before),
            Some(InjectedFault::Late) => self.late = std::mem::take(&mut chirp),
            Some(InjectedFault::Error) => chirp = encode(FrameKind::Error, sequence, &[2]),
            _ => {}
        }
        out.extend(chirp);
        out
    }
}

/// Request of the scanner to the radar module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Request of the module's settings.
    Configure,
    /// Request of a chirp.
    Trigger(Trigger),
    /// Request of a bit rate of the wire, Mbaud.
    Rate(u8),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_parse() {
        let fault = |text: &str| text.parse::<Fault>().unwrap();
        let lost = Fault {
            kind: InjectedFault::Lost,
            rows: (10, 12),
            times: 3,
        };
        assert_eq!(fault("lost@10-12x3"), lost);
        assert_eq!(fault("late@7").rows, (7, 7));
        assert_eq!(fault("silent").rows, (0, 0));
        assert_eq!(fault("config").kind, InjectedFault::Config);
        for bad in ["", "loss", "lost@", "lost@x3", "lost10", "lost@1xq"] {
            let error = bad.parse::<Fault>().unwrap_err();
            assert!(error.to_string().contains("expected KIND"), "{bad}");
        }
    }
}
