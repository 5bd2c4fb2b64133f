//! State of scanner and port, from the events of the port. Pure: time is an argument.

use std::collections::VecDeque;

use stairscan::report::{LiveLine, ScanLine, Sentence};
use stairscan::verdict::Reason;

use super::Ms;
use super::arrived::Arrived;
use super::guard::{Guard, SweepHistory};
use super::trouble::{Trouble, UnexpectedData};
use crate::answer::Answer;
use crate::counted::counted;

/// Time without an intact sentence after which the scanner or the line is considered dead, ms
/// (docs/user/controller.md).
pub const SILENCE: Ms = 500;
/// Maximum age of an answer, ms; an older one is stale (docs/user/controller.md).
pub const OLDEST: Ms = 17_000;
/// Time without a sentence after which an open port is reported as silent, ms; a scanner boots in 1.6 s.
const TIMEOUT: Ms = 2_500;
/// Timeout of a command's reply, ms; commands that may move the mirror have a longer one.
const REPLY: Ms = 2_000;
/// Timeout of commands whose reply takes long (`selftest`, `calibrate`, `save`), ms.
const LONG_REPLY: Ms = 60_000;
/// Maximum number of lines that are kept in the log.
const MAX_LOG: usize = 2_000;
/// Number of log lines to scroll at once.
pub const PAGE: usize = 5;

/// Event of a port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// The port is open.
    Opened,
    /// The port cannot be opened, or has disappeared.
    Failed(Trouble),
    /// A line was received.
    Line(String),
    /// The beginning of a line was received; its end is overdue.
    Pending(String),
}

/// State of the port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Link {
    /// The port has not been opened yet.
    Opening,
    /// The port is open since this time, ms after the session's beginning.
    Open(Ms),
    /// The port is absent since this time, ms after the session's beginning; with the cause.
    Away(Ms, Trouble),
}

/// Direction of a line of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// From the scanner, an intact sentence.
    In,
    /// From the scanner, not an intact sentence.
    Damaged,
    /// To the scanner.
    Out,
    /// A remark of this program.
    Note,
}

/// A line of the log of received and sent lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Time at which the line arrived or was sent, ms since the session began.
    pub at: Ms,
    /// Direction of the line, or remark.
    pub way: Way,
    /// Text of the line.
    pub text: String,
}

/// Validity of the displayed answer with regard to its age.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Validity {
    /// The answer is not stale.
    Fresh,
    /// The port has disappeared.
    Unplugged,
    /// The port is open, but no sentence has been received for this time, ms.
    Silent(Ms),
    /// The scanner has restarted since the answer.
    Restarted,
    /// The answer is older than the maximum age that a chair's controller accepts.
    Old,
}

/// Contents of the last `LIVE` sentence, which the scanner sends five times a second.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pulse {
    /// Time of arrival, ms since the session began.
    pub at: Ms,
    /// State of the scanner, as its `LIVE` sentence names it.
    pub state: String,
    /// Number of the scan that began last.
    pub scan: u32,
    /// Time since boot, ms.
    pub uptime_ms: u32,
    /// Time since the last row of the last scan without a fault, ms; `None` before that.
    pub age_ms: Option<u32>,
    /// State of the motion input, as the `LIVE` sentence names it.
    pub motion: String,
    /// Counters: faults of the motion input; refused lines; damaged bytes of the report port; errors of the radar
    /// link.
    pub counters: [u16; 4],
}

/// The last command that was sent to the scanner.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PendingCommand {
    /// Time at which the command was sent, ms since the session began.
    pub at: Ms,
    /// The line that was sent.
    pub text: String,
    /// The scanner's reply: time of arrival, ms since the session began, text, and whether it is not a refusal. `None`
    /// before the reply arrives.
    pub reply: Option<(Ms, String, bool)>,
}

impl PendingCommand {
    /// Returns the command's name, without the sentence's frame (`$`, checksum) and without arguments.
    fn word(&self) -> &str {
        let body = self.text.strip_prefix("$PSTC,").unwrap_or(&self.text);
        body.split([',', ' ', '*'])
            .find(|word| !word.is_empty())
            .unwrap_or("")
    }

    /// Whether the command's reply is overdue at `now`, ms since the session began.
    pub fn overdue(&self, now: Ms) -> bool {
        let patience = match self.word() {
            "selftest" | "calibrate" | "save" => LONG_REPLY,
            _ => REPLY,
        };
        self.reply.is_none() && now.saturating_sub(self.at) > patience
    }
}

/// State of a session: port, scanner, last answer, log.
#[derive(Clone, Debug)]
pub struct State {
    /// Name of the port.
    pub port: String,
    /// Description of the device at the port; empty if it is not known.
    pub about: String,
    /// Whether the scanner is an image in an emulator. A scan then takes longer than the maximum age of an
    /// answer.
    pub emulated: bool,
    /// Baud rate of the port; 0 if it has none.
    pub baud: u32,
    /// State of the port.
    pub link: Link,
    /// The last complete answer, with its time of arrival, ms since the session began; `None` before the first.
    pub answer: Option<(Ms, Answer)>,
    /// Number of complete answers received.
    pub answers: u64,
    /// State of the guard; `None` before the first guard sweep.
    pub guard: Option<Guard>,
    /// The last guard sweeps, also those before a restart, and the watch distance.
    pub sweeps: SweepHistory,
    /// Contents of the last `LIVE` sentence.
    pub pulse: Option<Pulse>,
    /// The last command that was sent.
    pub asked: Option<PendingCommand>,
    /// The last lines received and sent, oldest first.
    pub log: VecDeque<Entry>,
    /// Number of log lines that are newer than the last one shown: 0 unless the user has scrolled back.
    pub hidden: usize,
    /// Number of times that the port was reopened.
    pub reopened: u32,
    coming: Option<(ScanLine, Vec<String>)>,
    heard: Option<Ms>,
    restarted: bool,
    arrived: Arrived,
}

impl State {
    /// Creates the state before the port is opened.
    pub fn new(port: &str, baud: u32) -> Self {
        Self {
            port: port.to_owned(),
            about: String::new(),
            emulated: false,
            baud,
            link: Link::Opening,
            answer: None,
            answers: 0,
            guard: None,
            sweeps: SweepHistory::default(),
            pulse: None,
            asked: None,
            log: VecDeque::new(),
            hidden: 0,
            reopened: 0,
            coming: None,
            heard: None,
            restarted: false,
            arrived: Arrived::default(),
        }
    }

    /// Returns the state with a description of the device at the port.
    pub fn about(self, about: String) -> Self {
        Self { about, ..self }
    }

    /// Returns the state with the scanner marked as an image in an emulator.
    pub fn emulated(self) -> Self {
        Self {
            emulated: true,
            ..self
        }
    }

    /// Processes an event at `now`.
    pub fn take(&mut self, now: Ms, event: &Event) {
        match event {
            Event::Opened => {
                self.reopened +=
                    u32::from(matches!(self.link, Link::Away(_, Trouble::Unplugged(_))));
                self.link = Link::Open(now);
                self.arrived = Arrived::default();
                self.note(now, "the port is open");
            }
            Event::Failed(trouble) => self.fail(now, trouble),
            Event::Line(line) => self.line(now, line),
            Event::Pending(text) => self.arrived.pending(text),
        }
    }

    /// Registers a command that was sent at `now`.
    pub fn sent(&mut self, now: Ms, line: &str) {
        self.keep(now, Way::Out, line);
        self.asked = Some(PendingCommand {
            at: now,
            text: line.to_owned(),
            reply: None,
        });
    }

    /// Adds a remark to the log.
    pub fn note(&mut self, now: Ms, text: &str) {
        self.keep(now, Way::Note, text);
    }

    fn keep(&mut self, at: Ms, way: Way, text: &str) {
        if self.log.len() == MAX_LOG {
            self.log.pop_front();
        }
        let text = text.to_owned();
        self.log.push_back(Entry { at, way, text });
        // The displayed lines stay in place while the user scrolls.
        if self.hidden > 0 {
            self.hidden = (self.hidden + 1).min(self.log.len() - 1);
        }
    }

    /// Scrolls the log back by a page.
    pub fn older(&mut self) {
        self.hidden = (self.hidden + PAGE).min(self.log.len().saturating_sub(1));
    }

    /// Scrolls the log forward by a page.
    pub fn newer(&mut self) {
        self.hidden = self.hidden.saturating_sub(PAGE);
    }

    fn fail(&mut self, now: Ms, trouble: &Trouble) {
        self.coming = None;
        match &mut self.link {
            // An unplugged port also cannot be opened: the first cause is kept.
            Link::Away(_, Trouble::Unplugged(_)) if matches!(trouble, Trouble::Missing(_)) => {}
            Link::Away(_, before) if before == trouble => {}
            Link::Away(_, before) => *before = trouble.clone(),
            _ => {
                self.link = Link::Away(now, trouble.clone());
                let (what, _) = trouble.explain(&self.port);
                self.note(now, &what);
            }
        }
    }

    fn line(&mut self, now: Ms, line: &str) {
        self.arrived.line(line);
        match Sentence::parse(line) {
            Ok(sentence) => {
                self.heard = Some(now);
                // `LIVE` (five a second) and `GUARD` (ten) would fill the log.
                if !matches!(sentence, Sentence::Live(_) | Sentence::Guard(_)) {
                    self.keep(now, Way::In, line);
                }
                self.sentence(now, line, &sentence);
            }
            Err(_) => self.keep(now, Way::Damaged, line),
        }
    }

    fn sentence(&mut self, now: Ms, line: &str, sentence: &Sentence<'_>) {
        match sentence {
            Sentence::Scan(head) => {
                self.coming = Some((*head, vec![line.to_owned()]));
                self.complete(now);
            }
            Sentence::Step(step) => self.belongs(now, step.scan, line),
            Sentence::Drop(drop) => self.belongs(now, drop.scan, line),
            Sentence::Maybe(maybe) => self.belongs(now, maybe.scan, line),
            Sentence::Guard(sweep) => {
                let guard = Guard::after(self.guard.as_ref(), now, *sweep, self.sweeps.watch_m());
                self.sweeps.push(&guard);
                if guard.has_changed(self.guard.as_ref()) {
                    self.keep(now, Way::In, line);
                }
                self.guard = Some(guard);
            }
            Sentence::Live(live) => self.live(now, live),
            Sentence::Boot { .. } | Sentence::Halt { .. } => {
                self.coming = None;
                self.restarted = true;
                self.pulse = None;
                self.guard = None;
            }
            Sentence::Crash(crash) if crash.boot == 0 => {
                self.reply(now, "crash?", "no crash since power-on", true);
            }
            Sentence::Crash(crash) => {
                let text = format!("{} in boot {}", crash.cause, crash.boot);
                self.reply(now, "crash?", &text, true);
            }
            Sentence::Config { key, value } => {
                self.sweeps.configure(key, value);
                self.reply(now, "", &format!("{key} is {value}"), true)
            }
            Sentence::Done { command } => self.reply(now, command, "done", true),
            Sentence::Fail {
                command,
                field,
                expected,
            } => {
                let text = format!("refused: {field}: expected {expected}");
                self.reply(now, command, &text, false);
            }
            Sentence::State {
                state,
                clock,
                scans,
                estimator,
                reasons,
                ..
            } => {
                let why: Vec<_> = reasons.iter().map(Reason::meaning).collect();
                let text = format!(
                    "{state}, clock {clock}, {}, {estimator}. {}",
                    counted(*scans, "scan"),
                    why.join(" ")
                );
                self.reply(now, "status", text.trim_end(), true);
            }
        }
    }

    /// Adds a sentence to the scan that is being received; a sentence of another scan discards that one.
    fn belongs(&mut self, now: Ms, scan: u32, line: &str) {
        if let Some((head, lines)) = &mut self.coming {
            if head.scan == scan {
                lines.push(line.to_owned());
            } else {
                self.coming = None;
            }
        }
        self.complete(now);
    }

    fn complete(&mut self, now: Ms) {
        let whole = |(head, lines): &mut (ScanLine, Vec<String>)| {
            lines.len() > usize::from(head.following())
        };
        let Some((_, lines)) = self.coming.take_if(whole) else {
            return;
        };
        match Answer::parse(&self.port, lines) {
            // Fault of the self-test at boot, before the emulated module is connected.
            Ok(answer) if self.emulated && answer.scan.scan == 0 => {}
            Ok(answer) => {
                self.answer = Some((now, answer));
                self.answers += 1;
                self.restarted = false;
            }
            Err(error) => self.note(now, &format!("an inconsistent answer: {error:#}")),
        }
    }

    fn live(&mut self, now: Ms, live: &LiveLine<'_>) {
        let before = self.pulse.as_ref().map(|pulse| pulse.uptime_ms);
        // A restart whose `BOOT` sentence was lost.
        self.restarted |= before.is_some_and(|before| live.uptime_ms < before);
        self.pulse = Some(Pulse {
            at: now,
            state: live.state.to_owned(),
            scan: live.scan,
            uptime_ms: live.uptime_ms,
            age_ms: live.age_ms,
            motion: live.motion.to_owned(),
            counters: [
                live.motion_faults,
                live.refused,
                live.port_errors,
                live.link_errors,
            ],
        });
    }

    /// Stores a reply to the last command; `command` is empty if the reply does not name it.
    fn reply(&mut self, now: Ms, command: &str, text: &str, good: bool) {
        let Some(asked) = &mut self.asked else { return };
        let mine = command.is_empty() || command == "-" || command == asked.word();
        // These commands reply with several lines; the last one is the final reply.
        let goes_on = matches!(asked.word(), "get" | "calibrate");
        if mine && (goes_on || asked.reply.is_none()) {
            asked.reply = Some((now, text.to_owned(), good));
        }
    }

    /// Returns the age of the answer at `now`, ms: the time since its last row if `LIVE` reports that, else since its
    /// arrival.
    pub fn age(&self, now: Ms) -> Option<Ms> {
        let (came, answer) = self.answer.as_ref()?;
        let reported = self
            .pulse
            .as_ref()
            .filter(|pulse| pulse.at >= *came && !answer.is_fault());
        let reported = reported
            .and_then(|pulse| Some(u64::from(pulse.age_ms?) + now.saturating_sub(pulse.at)));
        Some(reported.unwrap_or(now.saturating_sub(*came)))
    }

    /// Returns the validity of the displayed answer at `now`.
    pub fn standing(&self, now: Ms) -> Validity {
        let silence = now.saturating_sub(self.heard.unwrap_or(0));
        match self.link {
            Link::Away(..) => Validity::Unplugged,
            _ if self.restarted => Validity::Restarted,
            _ if silence > SILENCE => Validity::Silent(silence),
            _ if !self.emulated && self.age(now).is_some_and(|age| age > OLDEST) => Validity::Old,
            _ => Validity::Fresh,
        }
    }

    /// Returns the kind of data that the open port delivers instead of sentences; `None` while there are sentences,
    /// or if the time is too short to judge.
    pub fn unexpected_data(&self, now: Ms) -> Option<UnexpectedData<'_>> {
        let Link::Open(since) = self.link else {
            return None;
        };
        let heard = self.heard.map_or(since, |heard| heard.max(since));
        if now.saturating_sub(heard) < TIMEOUT {
            return None;
        }
        Some(self.arrived.kind())
    }

    /// Number of damaged sentences since the port was opened.
    pub fn damaged(&self) -> u64 {
        self.arrived.damaged
    }

    /// Whether commands can be sent.
    pub fn is_open(&self) -> bool {
        matches!(self.link, Link::Open(_))
    }
}
