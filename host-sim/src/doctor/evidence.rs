//! Collects the replies of a scanner, from which the checks are evaluated.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use stairscan::report::{ScanLine, Sentence};
use stairscan::scanner::option_bytes::OptionBytes;
use stairscan::verdict::{Reason, Reasons};

use crate::live::talk::{PortFault, Reply, Talk};

/// Maximum duration of homing and self-test, including the module's first answer within
/// `connect-timeout`.
const SELF_TEST: Duration = Duration::from_secs(60);

/// Replies of a scanner to the requests of `doctor`.
#[derive(Clone, Debug, Default)]
pub struct Evidence {
    /// Name of the serial port.
    pub port: String,
    /// Baud rate of the serial port.
    pub baud: u32,
    /// Cause for which the port failed or replies are missing; `None` if all came.
    pub broken: Option<PortFault>,
    /// Number of damaged lines received.
    pub damaged: u64,
    /// Version and revision of the firmware; `None` without a reply.
    pub version: Option<String>,
    /// State of the scanner, such as `idle`; `None` without a reply.
    pub state: Option<String>,
    /// Clock source of the core, as reported; `None` without a reply.
    pub clock: Option<String>,
    /// The chip's option bytes; `None` without a reply, or if the scanner cannot read them.
    pub option_bytes: Option<OptionBytes>,
    /// Reasons (codes of conditions that degrade or prevent an answer) in the scanner's reply to `status`.
    pub status_reasons: Reasons,
    /// Whether the self-test has passed since the port was opened.
    pub passed: bool,
    /// Head of the last scan's answer; `None` without one.
    pub scan: Option<ScanLine>,
    /// All settings by name, in the notation of commands.
    pub settings: BTreeMap<String, String>,
    /// Counters of the last `LIVE` sentence: faults of the motion input, refused lines, damaged
    /// bytes of the port, errors of the radar link.
    pub counters: [u16; 4],
}

impl Evidence {
    /// Returns the value of a setting in the notation of commands; `None` if it was not reported.
    pub fn setting(&self, key: &str) -> Option<&str> {
        self.settings.get(key).map(String::as_str)
    }

    /// Sends the requests and returns the replies. `moves` permits self-test and scans of a stopped
    /// scanner; `patience` is the timeout of a scan.
    pub fn gather(talk: &mut Talk, port: &str, moves: bool, patience: Duration) -> Self {
        let mut evidence = Self {
            port: port.to_owned(),
            baud: talk.baud(),
            ..Self::default()
        };
        evidence.broken = evidence.ask(talk, moves, patience).err();
        let state = talk.state();
        evidence.counters = state.pulse.as_ref().map_or([0; 4], |pulse| pulse.counters);
        evidence.damaged = state.damaged();
        evidence
    }

    fn ask(&mut self, talk: &mut Talk, moves: bool, patience: Duration) -> Result<(), PortFault> {
        let answered = self.questions(talk);
        if let Err(broken) = answered {
            // Without the wire to the scanner its own sentences are still received; a port that has disappeared
            // delivers nothing.
            let _ = self.scans(talk, patience);
            return Err(broken);
        }
        match self.state.as_deref() {
            Some("idle") if moves => self.command_motion(talk, patience)?,
            Some("idle") => {}
            // It has already reported the cause.
            Some("fault") if !self.status_reasons.is_empty() => {}
            _ => self.scans(talk, patience)?,
        }
        // After the scan, since the settings include the module's.
        self.settings = talk.settings()?;
        Ok(())
    }

    fn questions(&mut self, talk: &mut Talk) -> Result<(), PortFault> {
        self.version = Some(talk.version()?);
        self.option_bytes = talk.option_bytes()?;
        let line = talk.status()?;
        if let Ok(Sentence::State {
            state,
            clock,
            reasons,
            ..
        }) = Sentence::parse(&line)
        {
            (self.state, self.clock) = (Some(state.to_owned()), Some(clock.to_owned()));
            self.status_reasons = reasons;
        }
        Ok(())
    }

    /// Runs self-test and scans on a stopped scanner.
    fn command_motion(&mut self, talk: &mut Talk, patience: Duration) -> Result<(), PortFault> {
        match talk.slow_command(&["selftest"], SELF_TEST)? {
            Some(Reply::Good(_)) => self.passed = true,
            Some(Reply::Refused(field, _)) => {
                let reason = Reason::ALL.iter().find(|reason| reason.as_str() == field);
                reason
                    .into_iter()
                    .for_each(|&reason| self.status_reasons.add(reason));
                return Ok(());
            }
            None => return Ok(()),
        }
        self.status_reasons = Reasons::NONE;
        // Without a second sweep the standstill of the chair is not confirmed.
        for _ in 0..2 {
            talk.slow_command(&["scan"], Duration::from_secs(2))?;
            self.scan_head(talk, patience)?;
            if !self.unconfirmed() {
                break;
            }
        }
        Ok(())
    }

    /// Waits for scans of a running scanner.
    fn scans(&mut self, talk: &mut Talk, patience: Duration) -> Result<(), PortFault> {
        self.scan_head(talk, patience)?;
        if self.unconfirmed() {
            self.scan_head(talk, patience)?;
        }
        Ok(())
    }

    fn unconfirmed(&self) -> bool {
        let unconfirmed = |scan: ScanLine| scan.reasons.has(Reason::Unconfirmed);
        self.scan.is_some_and(unconfirmed)
    }

    /// Waits for the head of a scan's answer, and stores it.
    fn scan_head(&mut self, talk: &mut Talk, patience: Duration) -> Result<(), PortFault> {
        let until = Instant::now() + patience;
        while let Some(line) = talk.next(until.saturating_duration_since(Instant::now()))? {
            if let Ok(Sentence::Scan(head)) = Sentence::parse(&line) {
                self.scan = Some(head);
                return Ok(());
            }
        }
        Ok(())
    }
}
