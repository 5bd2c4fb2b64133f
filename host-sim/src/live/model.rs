//! What is known of the scanner, from the sentences that have come. Pure: time is an argument.

use std::collections::VecDeque;

use stairscan::report::{LiveLine, ParseError, ScanLine, Sentence};
use stairscan::verdict::Reason;

use super::Ms;
use super::guard::Guard;
use super::trouble::{Strange, Trouble};
use crate::answer::Answer;

/// Without an intact sentence for so long the scanner or the line is dead (docs/controller.md).
pub const SILENCE: Ms = 500;
/// An answer that is older says nothing any more (docs/controller.md).
pub const OLDEST: Ms = 17_000;
/// An open port that has given no sentence for so long is explained: a scanner boots in 1.6 s.
const PATIENCE: Ms = 2_500;
/// A command is answered at once, but for those that move the mirror.
const REPLY: Ms = 2_000;
/// Homing, self-test and a scan.
const LONG_REPLY: Ms = 60_000;
/// Lines that are kept to be looked at.
const KEPT: usize = 2_000;
/// Lines by which one scrolls.
pub const PAGE: usize = 5;

/// What happened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// The port is open.
    Opened,
    /// It cannot be opened, or went away.
    Failed(Trouble),
    /// A line has come in.
    Line(String),
}

/// How the port fares.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Link {
    /// Not opened yet.
    Opening,
    /// Open since then.
    Open(Ms),
    /// Not there since then.
    Away(Ms, Trouble),
}

/// Which way a line went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// From the scanner, intact.
    In,
    /// From the scanner, and no sentence.
    Damaged,
    /// To the scanner.
    Out,
    /// A remark.
    Note,
}

/// A line and when it came or went.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// When.
    pub at: Ms,
    /// Which way.
    pub way: Way,
    /// What.
    pub text: String,
}

/// How far the answer that is shown can be believed as regards its age.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// It is the present one.
    Fresh,
    /// The port is gone.
    Unplugged,
    /// The port is there, and no sentence has come for so long, ms.
    Silent(Ms),
    /// The scanner has restarted since.
    Restarted,
    /// It is older than any controller may act on.
    Old,
}

/// The last `LIVE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pulse {
    /// When it came.
    pub at: Ms,
    /// State of the scanner.
    pub state: String,
    /// The scan that began last.
    pub scan: u32,
    /// Time since boot, ms.
    pub uptime_ms: u32,
    /// Age of the last answer that is no fault, ms.
    pub age_ms: Option<u32>,
    /// What the motion input is.
    pub motion: String,
    /// Faults of the motion input, refused lines, damaged bytes of the port, errors of the radar link.
    pub counters: [u16; 4],
}

/// The last command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asked {
    /// When it was sent.
    pub at: Ms,
    /// What was sent.
    pub text: String,
    /// What came back and when, and whether it is no refusal.
    pub reply: Option<(Ms, String, bool)>,
}

impl Asked {
    /// The command's word.
    fn word(&self) -> &str {
        let body = self.text.strip_prefix("$PSTC,").unwrap_or(&self.text);
        body.split([',', ' ', '*'])
            .find(|word| !word.is_empty())
            .unwrap_or("")
    }

    /// Whether an answer should have come by `now`.
    pub fn overdue(&self, now: Ms) -> bool {
        let patience = match self.word() {
            "selftest" | "calibrate" | "save" => LONG_REPLY,
            _ => REPLY,
        };
        self.reply.is_none() && now.saturating_sub(self.at) > patience
    }
}

/// What has come since the port was opened.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Tally {
    sentences: u64,
    /// Begin like sentences.
    damaged: u64,
    /// Do not, and are text; the last one.
    others: u64,
    other: String,
    noise: u64,
}

/// What is known.
#[derive(Clone, Debug)]
pub struct State {
    /// What the port is called.
    pub port: String,
    /// What hangs there, where that is known beforehand.
    pub about: String,
    /// Whether the scanner is an image in an emulator, where a scan takes longer than an answer may be old.
    pub emulated: bool,
    /// Its speed; 0 where it has none.
    pub baud: u32,
    /// How it fares.
    pub link: Link,
    /// The last whole answer, and when it came.
    pub answer: Option<(Ms, Answer)>,
    /// Whole answers so far.
    pub answers: u64,
    /// The guard's sweeps, once one has come.
    pub guard: Option<Guard>,
    /// The last sign of life.
    pub pulse: Option<Pulse>,
    /// The last command.
    pub asked: Option<Asked>,
    /// The last lines, oldest first.
    pub log: VecDeque<Entry>,
    /// Lines of the log that are newer than the last one shown.
    pub hidden: usize,
    /// Times that the port was opened again.
    pub reopened: u32,
    coming: Option<(ScanLine, Vec<String>)>,
    heard: Option<Ms>,
    restarted: bool,
    tally: Tally,
}

impl State {
    /// Before the port is opened.
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
            pulse: None,
            asked: None,
            log: VecDeque::new(),
            hidden: 0,
            reopened: 0,
            coming: None,
            heard: None,
            restarted: false,
            tally: Tally::default(),
        }
    }

    /// The same with a word on what hangs at the port.
    pub fn about(self, about: String) -> Self {
        Self { about, ..self }
    }

    /// The same of an image in an emulator.
    pub fn emulated(self) -> Self {
        Self {
            emulated: true,
            ..self
        }
    }

    /// Takes what happened at `now`.
    pub fn take(&mut self, now: Ms, event: &Event) {
        match event {
            Event::Opened => {
                self.reopened +=
                    u32::from(matches!(self.link, Link::Away(_, Trouble::Unplugged(_))));
                self.link = Link::Open(now);
                self.tally = Tally::default();
                self.note(now, "the port is open");
            }
            Event::Failed(trouble) => self.fail(now, trouble),
            Event::Line(line) => self.line(now, line),
        }
    }

    /// A command has gone out at `now`.
    pub fn sent(&mut self, now: Ms, line: &str) {
        self.keep(now, Way::Out, line);
        self.asked = Some(Asked {
            at: now,
            text: line.to_owned(),
            reply: None,
        });
    }

    /// A remark among the lines.
    pub fn note(&mut self, now: Ms, text: &str) {
        self.keep(now, Way::Note, text);
    }

    fn keep(&mut self, at: Ms, way: Way, text: &str) {
        if self.log.len() == KEPT {
            self.log.pop_front();
        }
        let text = text.to_owned();
        self.log.push_back(Entry { at, way, text });
        // The lines that are looked at stay where they are.
        if self.hidden > 0 {
            self.hidden = (self.hidden + 1).min(self.log.len() - 1);
        }
    }

    /// Goes a page back in the log.
    pub fn older(&mut self) {
        self.hidden = (self.hidden + PAGE).min(self.log.len().saturating_sub(1));
    }

    /// Goes a page on in the log.
    pub fn newer(&mut self) {
        self.hidden = self.hidden.saturating_sub(PAGE);
    }

    fn fail(&mut self, now: Ms, trouble: &Trouble) {
        self.coming = None;
        match &mut self.link {
            // That it cannot be opened again yet is known: it was pulled out then.
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
        match Sentence::parse(line) {
            Ok(sentence) => {
                self.tally.sentences += 1;
                self.heard = Some(now);
                // Five and ten a second would leave room for nothing else.
                if !matches!(sentence, Sentence::Live(_) | Sentence::Guard(_)) {
                    self.keep(now, Way::In, line);
                }
                self.sentence(now, line, &sentence);
            }
            Err(error) => {
                self.count(line, error);
                self.keep(now, Way::Damaged, line);
            }
        }
    }

    fn count(&mut self, line: &str, error: ParseError) {
        let noise = line.matches("\\x").count();
        if error != ParseError::Frame || line.contains("$PSTR") {
            self.tally.damaged += 1;
        } else if 8 * noise > line.len() {
            self.tally.noise += 1;
        } else {
            self.tally.others += 1;
            line.clone_into(&mut self.tally.other);
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
                let guard = Guard::after(self.guard.as_ref(), now, *sweep);
                if guard.is_news(self.guard.as_ref()) {
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
            Sentence::Config { key, value } => {
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
                    "{state}, clock {clock}, {scans} scans, {estimator}. {}",
                    why.join(" ")
                );
                self.reply(now, "status", text.trim_end(), true);
            }
        }
    }

    /// A further sentence of the scan that is coming in; of another one it voids what has come.
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
            // The self-test at boot, before the emulated module is connected.
            Ok(answer) if self.emulated && answer.scan.scan == 0 => {}
            Ok(answer) => {
                self.answer = Some((now, answer));
                self.answers += 1;
                self.restarted = false;
            }
            Err(error) => self.note(
                now,
                &format!("an answer that contradicts itself: {error:#}"),
            ),
        }
    }

    fn live(&mut self, now: Ms, live: &LiveLine<'_>) {
        let before = self.pulse.as_ref().map(|pulse| pulse.uptime_ms);
        // A boot whose sentence was lost.
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

    /// Something that answers the command that was sent last; `command` is empty where it does not say which.
    fn reply(&mut self, now: Ms, command: &str, text: &str, good: bool) {
        let Some(asked) = &mut self.asked else { return };
        let mine = command.is_empty() || command == "-" || command == asked.word();
        // These answer with several lines, of which the last one says that it is done.
        let goes_on = matches!(asked.word(), "get" | "calibrate");
        if mine && (goes_on || asked.reply.is_none()) {
            asked.reply = Some((now, text.to_owned(), good));
        }
    }

    /// How old the answer is at `now`, ms: from its last row where the scanner says so, else from when it came.
    pub fn age(&self, now: Ms) -> Option<Ms> {
        let (came, answer) = self.answer.as_ref()?;
        let told = self
            .pulse
            .as_ref()
            .filter(|pulse| pulse.at >= *came && !answer.is_fault());
        let told =
            told.and_then(|pulse| Some(u64::from(pulse.age_ms?) + now.saturating_sub(pulse.at)));
        Some(told.unwrap_or(now.saturating_sub(*came)))
    }

    /// Whether the answer is the present one.
    pub fn standing(&self, now: Ms) -> Standing {
        let silence = now.saturating_sub(self.heard.unwrap_or(0));
        match self.link {
            Link::Away(..) => Standing::Unplugged,
            _ if self.restarted => Standing::Restarted,
            _ if silence > SILENCE => Standing::Silent(silence),
            _ if !self.emulated && self.age(now).is_some_and(|age| age > OLDEST) => Standing::Old,
            _ => Standing::Fresh,
        }
    }

    /// What the open port gives instead of sentences, if it has had time to give one.
    pub fn strange(&self, now: Ms) -> Option<Strange<'_>> {
        let Link::Open(since) = self.link else {
            return None;
        };
        let heard = self.heard.map_or(since, |heard| heard.max(since));
        if now.saturating_sub(heard) < PATIENCE {
            return None;
        }
        let Tally {
            sentences,
            damaged,
            others,
            noise,
            ref other,
        } = self.tally;
        Some(match damaged.max(others).max(noise) {
            _ if sentences > 0 => Strange::Silence,
            0 => Strange::Nothing,
            most if most == damaged => Strange::Damaged,
            most if most == noise => Strange::Noise,
            _ => Strange::Others(other),
        })
    }

    /// Sentences that have come damaged since the port was opened.
    pub fn damaged(&self) -> u64 {
        self.tally.damaged
    }

    /// Whether commands can be sent.
    pub fn is_open(&self) -> bool {
        matches!(self.link, Link::Open(_))
    }
}
