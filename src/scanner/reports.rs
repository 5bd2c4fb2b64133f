//! What the scanner says: which sentences tell a scan, a state, the answer to a command.

use crate::config::Plane;
use crate::port::BytePort;
use crate::report::sentence::{MAX_SENTENCE, of_scan};
use crate::report::{GuardLine, LiveLine, ScanLine, Sentence};
use crate::scanner::board::Identity;
use crate::scanner::command;
use crate::scanner::outbox::Outbox;
use crate::verdict::{Conditions, Outcome, Reasons};

/// The last scan's answer and the sentences that wait for the port: some 3 KB.
#[derive(Debug)]
pub struct Reports {
    outbox: Outbox,
    /// The last scan's answer.
    pub(super) outcome: Outcome,
}

/// How far the sentences of a scan have got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Telling {
    /// Number of the scan.
    pub scan: u32,
    /// Hash of the settings that it was made with.
    pub settings: u32,
    /// The plane that it was made in, where settings alone do not say it.
    pub plane: Option<Plane>,
    /// Rows that were lost.
    pub lost: u16,
    /// Whether hardware ended the scan, or did not let it begin.
    pub broken: bool,
    /// Sentences queued so far.
    pub queued: u8,
}

impl Reports {
    /// Nothing to say yet.
    pub const fn new() -> Self {
        Self {
            outbox: Outbox::new(),
            outcome: Outcome::silent(),
        }
    }

    /// Whether another sentence fits.
    pub(super) fn has_room(&self) -> bool {
        self.outbox.has_room()
    }

    /// Hands over what the port takes.
    pub(super) fn pump(&mut self, port: &mut impl BytePort) {
        self.outbox.pump(port);
    }

    /// The answer to a command: done.
    pub(super) fn done(&mut self, command: &str) {
        self.outbox.push(&Sentence::Done { command });
    }

    /// The answer to a command that is refused.
    #[inline(never)]
    pub(super) fn refuse(&mut self, command: &str, field: &str, expected: &str) {
        self.outbox.push(&Sentence::Fail {
            command,
            field,
            expected,
        });
    }

    /// The answer to a command that only counts inside a sentence: that sentence, to be sent instead.
    #[inline(never)]
    pub(super) fn offer(&mut self, command: &str, parts: &[&str]) {
        let framed = command::framed(parts);
        let mut expected = heapless::String::<{ MAX_SENTENCE + 5 }>::new();
        for part in ["send ", framed.strip_suffix("\r\n").unwrap_or("")] {
            let _ = expected.push_str(part);
        }
        self.refuse(command, "crc", &expected);
    }

    /// The answer to a question for a value.
    #[inline(never)]
    pub(super) fn value(&mut self, key: &str, value: &str) {
        self.outbox.push(&Sentence::Config { key, value });
    }

    /// The answer to `version`.
    pub(super) fn version(&mut self, identity: &Identity) {
        let mut value = heapless::String::<64>::new();
        for part in [identity.version, " ", identity.revision] {
            // A revision that does not fit is left away.
            let _ = value.push_str(part);
        }
        self.value("version", &value);
    }

    /// The answer to `status`.
    pub(super) fn status(&mut self, status: &Sentence<'_>) {
        self.outbox.push(status);
    }

    /// How the scanner fares, where nothing else waits for the port; whether that was so.
    #[inline(never)]
    pub(super) fn live(&mut self, live: LiveLine<'_>) -> bool {
        self.outbox.is_empty() && self.outbox.push(&Sentence::Live(live))
    }

    /// The first sentence after boot.
    pub(super) fn boot(&mut self, identity: &Identity, settings: u32) {
        self.outbox.push(&Sentence::Boot {
            version: identity.version,
            revision: identity.revision,
            reset: identity.reset,
            clock: identity.clock,
            boots: identity.boots,
            settings,
            serial: identity.serial,
        });
    }

    /// A failed self-test, told as scan 0; false when there is no room yet.
    pub(super) fn failed_test(&mut self, reasons: Reasons, settings: u32) -> bool {
        let failed = Outcome::broken(reasons, Conditions::GOOD);
        self.outbox
            .push(&Sentence::Scan(ScanLine::new(0, 0, &failed, settings)))
    }

    /// The word of a guard sweep; false when there is no room yet.
    #[inline(never)]
    pub(super) fn guard(&mut self, line: GuardLine) -> bool {
        self.outbox.push(&Sentence::Guard(line))
    }

    /// Queues the answer's sentences as they fit; true when all are queued.
    pub(super) fn tell(&mut self, telling: &mut Telling) -> bool {
        let of = (telling.scan, telling.settings);
        while let Some(mut sentence) = of_scan(of, telling.lost, &self.outcome, telling.queued) {
            if let Sentence::Scan(head) = &mut sentence {
                head.plane = telling.plane;
            }
            if !self.outbox.push(&sentence) {
                return false;
            }
            telling.queued = telling.queued.saturating_add(1);
        }
        true
    }
}

impl Default for Reports {
    fn default() -> Self {
        Self::new()
    }
}
