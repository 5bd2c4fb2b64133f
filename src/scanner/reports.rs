//! Outgoing sentences of a scan, a state, or the answer to a command.

use crate::config::Plane;
use crate::port::BytePort;
use crate::report::sentence::{MAX_SENTENCE, ScanId, of_scan};
use crate::report::{BootLine, CrashLine, CrashSite, GuardLine, LiveLine, ScanLine, Sentence};
use crate::scanner::board::BootInfo;
use crate::scanner::command;
use crate::scanner::outbox::Outbox;
use crate::verdict::{Conditions, Outcome, Reasons};

/// The last scan's answer and the queue of sentences to the report port: some 3 KB.
#[derive(Debug)]
pub struct Reports {
    outbox: Outbox,
    /// The last scan's answer.
    pub(super) outcome: Outcome,
}

/// Progress in queueing the sentences of a scan's answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ReportProgress {
    /// Number of the scan.
    pub scan: u32,
    /// Hash of the scan's settings.
    pub settings: u32,
    /// Plane of the scan for the sentence `SCAN`; `None` if the settings alone determine it.
    pub plane: Option<Plane>,
    /// Number of rows whose chirp was lost.
    pub lost: u16,
    /// Whether a hardware fault ended the scan or prevented it.
    pub broken: bool,
    /// Number of sentences queued so far.
    pub queued: u8,
}

impl Reports {
    /// Creates an empty queue without an answer.
    pub const fn new() -> Self {
        Self {
            outbox: Outbox::new(),
            outcome: Outcome::silent(),
        }
    }

    /// Whether another sentence fits into the queue.
    pub(super) fn has_room(&self) -> bool {
        self.outbox.has_room()
    }

    /// Whether the port has taken all queued sentences.
    pub(super) fn all_sent(&self) -> bool {
        self.outbox.is_empty()
    }

    /// Hands over as many queued bytes as the port takes, without waiting.
    pub(super) fn pump(&mut self, port: &mut impl BytePort) {
        self.outbox.pump(port);
    }

    /// Queues `DONE`: `command` has been executed.
    pub(super) fn done(&mut self, command: &str) {
        self.outbox.push(&Sentence::Done { command });
    }

    /// Queues `FAIL`: `command` is refused, since `field` is not as `expected`.
    #[inline(never)]
    pub(super) fn refuse(&mut self, command: &str, field: &str, expected: &str) {
        self.outbox.push(&Sentence::Fail {
            command,
            field,
            expected,
        });
    }

    /// Refuses a command without a frame that must have one: queues `FAIL` with the framed sentence of `parts`,
    /// to be sent instead.
    #[inline(never)]
    pub(super) fn offer(&mut self, command: &str, parts: &[&str]) {
        let framed = command::framed(parts);
        let mut expected = heapless::String::<{ MAX_SENTENCE + 5 }>::new();
        for part in ["send ", framed.strip_suffix("\r\n").unwrap_or("")] {
            let _ = expected.push_str(part);
        }
        self.refuse(command, "crc", &expected);
    }

    /// Queues `CONF` with `key` and `value`, the answer to `get` and `set`.
    #[inline(never)]
    pub(super) fn value(&mut self, key: &str, value: &str) {
        self.outbox.push(&Sentence::Config { key, value });
    }

    /// Queues `CONF` with version and git revision of the firmware, the answer to `version`.
    pub(super) fn version(&mut self, identity: &BootInfo) {
        let mut value = heapless::String::<64>::new();
        for part in [identity.version, " ", identity.revision] {
            // A revision that does not fit is left out.
            let _ = value.push_str(part);
        }
        self.value("version", &value);
    }

    /// Queues `status`, the sentence that answers the command `status`.
    pub(super) fn status(&mut self, status: &Sentence<'_>) {
        self.outbox.push(status);
    }

    /// Queues the sentence `LIVE` if nothing else waits for the port; returns whether it was queued.
    #[inline(never)]
    pub(super) fn live(&mut self, live: LiveLine<'_>) -> bool {
        self.outbox.is_empty() && self.outbox.push(&Sentence::Live(live))
    }

    /// Queues the sentence `BOOT`; `settings` is the hash of the settings in force, `last` the last crash. Its place
    /// is reported if it ended the boot before this one.
    pub(super) fn boot(&mut self, identity: &BootInfo, settings: u32, last: CrashLine<'static>) {
        let just_now = last.boot != 0 && last.boot.saturating_add(1) == identity.boots;
        self.outbox.push(&Sentence::Boot(BootLine {
            version: identity.version,
            revision: identity.revision,
            reset: identity.reset,
            clock: identity.clock,
            boots: identity.boots,
            settings,
            serial: identity.serial,
            second_memory: identity.second_memory.as_str(),
            option_bytes: identity.option_bytes,
            crash: if just_now { last.site } else { CrashSite::NONE },
        }));
    }

    /// Queues `CRASH` with the last crash, the answer to `crash?`.
    #[inline(never)]
    pub(super) fn crash(&mut self, last: CrashLine<'static>) {
        self.outbox.push(&Sentence::Crash(last));
    }

    /// Queues the reasons of a failed self-test as the sentence `SCAN` of scan 0; returns `false` if there is no
    /// room yet.
    pub(super) fn failed_test(&mut self, reasons: Reasons, settings: u32) -> bool {
        let failed = Outcome::broken(reasons, Conditions::GOOD);
        self.outbox
            .push(&Sentence::Scan(ScanLine::new(0, 0, &failed, settings)))
    }

    /// Queues the sentence `GUARD` of a guard sweep; returns `false` if there is no room yet.
    #[inline(never)]
    pub(super) fn guard(&mut self, line: GuardLine) -> bool {
        self.outbox.push(&Sentence::Guard(line))
    }

    /// Queues the sentences of the answer as they fit; returns `true` when all are queued.
    pub(super) fn queue_answer(&mut self, progress: &mut ReportProgress) -> bool {
        let id = ScanId {
            scan: progress.scan,
            settings: progress.settings,
        };
        while let Some(mut sentence) = of_scan(id, progress.lost, &self.outcome, progress.queued) {
            if let Sentence::Scan(head) = &mut sentence {
                head.plane = progress.plane;
            }
            if !self.outbox.push(&sentence) {
                return false;
            }
            progress.queued = progress.queued.saturating_add(1);
        }
        true
    }
}

impl Default for Reports {
    fn default() -> Self {
        Self::new()
    }
}
