//! Requests to a scanner at a serial port and its replies, one at a time; used by `settings` and `doctor`.

use std::collections::BTreeMap;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use stairscan::report::Sentence;
use stairscan::scanner::Settings;
use stairscan::scanner::command::framed;

use super::model::{Event, State};
use super::port::Source;
use super::trouble::Trouble;

/// Timeout of a reply: a `SCAN` with all its sentences takes 0.14 s at 115,200 baud.
const REPLY: Duration = Duration::from_secs(2);
/// Timeout of the first sentence; longer than the 2.5 s of [`State::strange`], which explains a silent port.
const FIRST: Duration = Duration::from_secs(4);
/// Number of attempts of a request without a reply.
const TRIES: u32 = 3;

/// An open port with a scanner.
#[derive(Debug)]
pub struct Talk {
    port: String,
    baud: u32,
    source: Source,
    state: State,
    started: Instant,
}

/// Fault of a port and its remedies, one line each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Broken {
    /// The fault.
    pub what: String,
    /// The remedies.
    pub help: Vec<String>,
}

impl std::fmt::Display for Broken {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.what)?;
        self.help
            .iter()
            .try_for_each(|line| write!(f, "\n  {line}"))
    }
}

impl std::error::Error for Broken {}

/// Reply to a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// Executed, with the value for a request of one.
    Good(String),
    /// Refused: the field and the expected value.
    Refused(String, String),
}

impl Talk {
    /// Opens `port` and waits for the scanner's first sentence.
    ///
    /// # Errors
    /// The port cannot be opened, or delivers no sentences; the message explains the cause.
    pub fn open(port: &str, baud: u32) -> Result<Self, Broken> {
        let started = Instant::now();
        let mut talk = Self {
            port: port.to_owned(),
            baud,
            source: Source::port(started, port, baud),
            state: State::new(port, baud),
            started,
        };
        match talk.next(FIRST)? {
            Some(_) => Ok(talk),
            None => Err(talk.silent()),
        }
    }

    /// Returns the baud rate.
    pub fn baud(&self) -> u32 {
        self.baud
    }

    /// Returns the state of the scanner, from its sentences.
    pub fn state(&self) -> &State {
        &self.state
    }

    fn now(&self) -> u64 {
        self.started.elapsed().as_millis() as u64
    }

    /// Returns the next intact sentence; `None` after `patience` without one.
    ///
    /// # Errors
    /// The port cannot be opened, or has disappeared.
    pub fn next(&mut self, patience: Duration) -> Result<Option<String>, Broken> {
        let until = Instant::now() + patience;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let (at, event) = match self.source.events.recv_timeout(left) {
                Ok(came) => came,
                Err(RecvTimeoutError::Timeout) => return Ok(None),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(self.failed(&Trouble::Other("reading ended".to_owned())));
                }
            };
            self.state.take(at, &event);
            match event {
                Event::Failed(trouble) => return Err(self.failed(&trouble)),
                Event::Line(line) if Sentence::parse(&line).is_ok() => return Ok(Some(line)),
                Event::Line(_) | Event::Opened => {}
            }
        }
    }

    fn failed(&self, trouble: &Trouble) -> Broken {
        let (what, mut help) = trouble.explain(&self.port);
        if matches!(trouble, Trouble::Unplugged(_)) {
            help = vec!["Plug it in again, and repeat the command.".to_owned()];
        }
        Broken { what, help }
    }

    /// Returns the cause of a missing reply.
    pub fn silent(&self) -> Broken {
        let (what, help) = match self.state.strange(self.now()) {
            Some(strange) => strange.explain(self.baud),
            None => (
                format!("{}: the scanner speaks, but does not answer", self.port),
                vec!["Is the wire to REPORT_RX (J2 pin 3) there?".to_owned()],
            ),
        };
        Broken { what, help }
    }

    /// Sends a line.
    pub fn send(&mut self, line: &str) {
        let now = self.now();
        self.state.sent(now, line);
        // `next` reports a thread that has ended.
        let _ = self.source.lines.send(line.to_owned());
    }

    /// Sends `line` and returns the first result of `take` for the sentences that follow. The line is repeated after
    /// a timeout.
    ///
    /// # Errors
    /// The port has disappeared, or [`TRIES`] attempts got no reply.
    fn ask<T>(
        &mut self,
        line: &str,
        mut take: impl FnMut(&Sentence<'_>) -> Option<T>,
    ) -> Result<T, Broken> {
        for _ in 0..TRIES {
            self.send(line);
            let until = Instant::now() + REPLY;
            while let Some(line) = self.next(until.saturating_duration_since(Instant::now()))? {
                if let Some(found) = Sentence::parse(&line)
                    .ok()
                    .and_then(|sentence| take(&sentence))
                {
                    return Ok(found);
                }
            }
        }
        Err(self.silent())
    }

    /// Sends a command, given by its words, with its CRC. Returns the reply.
    ///
    /// # Errors
    /// The port has disappeared, or there was no reply.
    pub fn command(&mut self, words: &[&str]) -> Result<Reply, Broken> {
        let line = framed(words).trim_end().to_owned();
        self.ask(&line, |sentence| reply(words, sentence))
    }

    /// Sends a command once, without repetition, with the timeout `patience`; `None` without a reply.
    ///
    /// # Errors
    /// The port has disappeared.
    pub fn slow_command(
        &mut self,
        words: &[&str],
        patience: Duration,
    ) -> Result<Option<Reply>, Broken> {
        self.send(framed(words).trim_end());
        let until = Instant::now() + patience;
        while let Some(line) = self.next(until.saturating_duration_since(Instant::now()))? {
            if let Some(found) = Sentence::parse(&line)
                .ok()
                .and_then(|sentence| reply(words, &sentence))
            {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    /// Returns version and revision of the firmware.
    ///
    /// # Errors
    /// The port has disappeared, or there was no reply.
    pub fn version(&mut self) -> Result<String, Broken> {
        self.ask("version", |sentence| match sentence {
            Sentence::Config {
                key: "version",
                value,
            } => Some((*value).to_owned()),
            _ => None,
        })
    }

    /// Returns the reply to `status`, as its line.
    ///
    /// # Errors
    /// The port has disappeared, or there was no reply.
    pub fn status(&mut self) -> Result<String, Broken> {
        self.ask("status", |sentence| match sentence {
            Sentence::State { .. } => Some(sentence.write().trim_end().to_owned()),
            _ => None,
        })
    }

    /// Returns all settings that the scanner reports, as commands write them. Damaged ones are requested again.
    ///
    /// # Errors
    /// The port has disappeared, or there was no reply.
    pub fn settings(&mut self) -> Result<BTreeMap<String, String>, Broken> {
        let mut told = BTreeMap::new();
        self.ask("get", |sentence| {
            if let Sentence::Config { key, value } = sentence {
                told.insert((*key).to_owned(), (*value).to_owned());
            }
            matches!(sentence, Sentence::Done { command: "get" }).then_some(())
        })?;
        let missing = Settings::KEYS
            .iter()
            .filter(|key| !told.contains_key(**key));
        for key in missing.copied().collect::<Vec<_>>() {
            let found = self.ask(&format!("get {key}"), |sentence| match sentence {
                Sentence::Config { key: k, value } if *k == key => Some(Some((*value).to_owned())),
                Sentence::Fail { command: "get", .. } => Some(None),
                _ => None,
            })?;
            // `None`: the firmware does not have this setting.
            found.map(|value| told.insert(key.to_owned(), value));
        }
        Ok(told)
    }
}

/// Returns the reply in `sentence` if it belongs to the command `words`.
fn reply(words: &[&str], sentence: &Sentence<'_>) -> Option<Reply> {
    match (words, sentence) {
        (["set", key, _], Sentence::Config { key: k, value }) if k == key => {
            Some(Reply::Good((*value).to_owned()))
        }
        ([word, ..], Sentence::Done { command }) if command == word => {
            Some(Reply::Good(String::new()))
        }
        (
            [word, ..],
            Sentence::Fail {
                command,
                field,
                expected,
            },
        ) if command == word || *command == "-" => {
            Some(Reply::Refused((*field).to_owned(), (*expected).to_owned()))
        }
        _ => None,
    }
}
