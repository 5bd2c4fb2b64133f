//! Requests to a scanner at a serial port and its replies, one at a time; used by `settings` and `doctor`.

use std::collections::BTreeMap;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use stairscan::report::Sentence;
use stairscan::scanner::Settings;
use stairscan::scanner::command::{Measure, framed};
use stairscan::scanner::option_bytes::OptionBytes;

use super::model::{Event, State};
use super::port::Source;
use super::trouble::Trouble;

/// Timeout of a reply: a `SCAN` with all its sentences takes 0.14 s at 115,200 baud.
const REPLY: Duration = Duration::from_secs(2);
/// Timeout of the first sentence; longer than the 2.5 s of [`State::unexpected_data`], which explains a silent port.
const FIRST: Duration = Duration::from_secs(4);
/// Number of attempts of a request without a reply.
const TRIES: u32 = 3;

/// Connection to a scanner at an open serial port.
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
pub struct PortFault {
    /// Description of the fault.
    pub what: String,
    /// Remedies, one line each.
    pub help: Vec<String>,
}

impl std::fmt::Display for PortFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.what)?;
        self.help
            .iter()
            .try_for_each(|line| write!(f, "\n  {line}"))
    }
}

impl std::error::Error for PortFault {}

/// Reply to a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// The command was executed; with the new value for `set`, and an empty text for other commands.
    Good(String),
    /// The command was refused; with the name of the wrong field and its expected value.
    Refused(String, String),
}

impl Talk {
    /// Opens `port` and waits for the scanner's first sentence.
    ///
    /// # Errors
    /// The port cannot be opened, or delivers no sentences; the message explains the cause.
    pub fn open(port: &str, baud: u32) -> Result<Self, PortFault> {
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
            None => Err(talk.no_reply_cause()),
        }
    }

    /// Returns the baud rate at which the port is open.
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
    pub fn next(&mut self, patience: Duration) -> Result<Option<String>, PortFault> {
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
                Event::Line(_) | Event::Pending(_) | Event::Opened => {}
            }
        }
    }

    fn failed(&self, trouble: &Trouble) -> PortFault {
        let (what, mut help) = trouble.explain(&self.port);
        if matches!(trouble, Trouble::Unplugged(_)) {
            help = vec!["Plug it in again, and repeat the command.".to_owned()];
        }
        PortFault { what, help }
    }

    /// Returns the cause of a missing reply and its remedies, from the data received so far.
    pub fn no_reply_cause(&self) -> PortFault {
        let (what, help) = match self.state.unexpected_data(self.now()) {
            Some(unexpected_data) => unexpected_data.explain(self.baud),
            None => (
                format!(
                    "{}: the scanner sends sentences but does not reply",
                    self.port
                ),
                self.no_reply_help(),
            ),
        };
        PortFault { what, help }
    }

    /// Returns the remedies for a scanner that sends sentences but does not reply.
    fn no_reply_help(&self) -> Vec<String> {
        let wire = "Is the wire to REPORT_RX (J2 pin 3) connected?".to_owned();
        let damaged = self.state.damaged();
        let lost =
            format!("{damaged} sentences were received damaged: its reply may be among them.");
        let some = (damaged > 0).then_some(lost);
        some.into_iter().chain([wire]).collect()
    }

    /// Sends a line to the scanner; does not wait for a reply.
    pub fn send(&mut self, line: &str) {
        let now = self.now();
        self.state.sent(now, line);
        // `next` reports a thread that has ended.
        let _ = self.source.lines.send(line.to_owned());
    }

    /// Sends `line` and returns the first result of `take` for the sentences that follow. After a timeout the line is
    /// sent again.
    ///
    /// # Errors
    /// The port has disappeared, or [`TRIES`] attempts got no reply.
    fn ask<T>(
        &mut self,
        line: &str,
        mut take: impl FnMut(&Sentence<'_>) -> Option<T>,
    ) -> Result<T, PortFault> {
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
        Err(self.no_reply_cause())
    }

    /// Sends a command, given by its words, with its CRC, and again after a timeout. Returns the reply.
    ///
    /// # Errors
    /// The port has disappeared, or there was no reply.
    pub fn command(&mut self, words: &[&str]) -> Result<Reply, PortFault> {
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
    ) -> Result<Option<Reply>, PortFault> {
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
    pub fn version(&mut self) -> Result<String, PortFault> {
        self.ask("version", |sentence| match sentence {
            Sentence::Config {
                key: "version",
                value,
            } => Some((*value).to_owned()),
            _ => None,
        })
    }

    /// Returns the chip's option bytes; `None` if the firmware does not know them, or cannot read them.
    ///
    /// # Errors
    /// The port has disappeared, or there was no reply.
    pub fn option_bytes(&mut self) -> Result<Option<OptionBytes>, PortFault> {
        let key = Measure::OptionBytes.key();
        self.ask(&format!("get {key}"), |sentence| match sentence {
            Sentence::Config { key: k, value } if *k == key => {
                let bits = u32::from_str_radix(value, 16).unwrap_or(0);
                Some(OptionBytes::of_register(bits))
            }
            Sentence::Fail { command: "get", .. } => Some(None),
            _ => None,
        })
    }

    /// Returns the scanner's reply to `version`: the line of its `CONF` sentence.
    ///
    /// # Errors
    /// The port has disappeared, or there was no reply.
    pub fn version_line(&mut self) -> Result<String, PortFault> {
        self.ask("version", |sentence| {
            let version = matches!(sentence, Sentence::Config { key: "version", .. });
            version.then(|| sentence.write().trim_end().to_owned())
        })
    }

    /// Returns the scanner's reply to `crash?`: the line of its `CRASH` sentence.
    ///
    /// # Errors
    /// The port has disappeared, or there was no reply, as of a firmware without this command.
    pub fn crash(&mut self) -> Result<String, PortFault> {
        self.ask("crash?", |sentence| match sentence {
            Sentence::Crash(_) => Some(sentence.write().trim_end().to_owned()),
            _ => None,
        })
    }

    /// Returns the scanner's reply to `status`: the line of its `STAT` sentence.
    ///
    /// # Errors
    /// The port has disappeared, or there was no reply.
    pub fn status(&mut self) -> Result<String, PortFault> {
        self.ask("status", |sentence| match sentence {
            Sentence::State { .. } => Some(sentence.write().trim_end().to_owned()),
            _ => None,
        })
    }

    /// Returns all settings that the scanner reports, by key, with values as in commands. Settings whose sentences
    /// were damaged are requested again.
    ///
    /// # Errors
    /// The port has disappeared, or there was no reply.
    pub fn settings(&mut self) -> Result<BTreeMap<String, String>, PortFault> {
        let mut values = BTreeMap::new();
        self.ask("get", |sentence| {
            if let Sentence::Config { key, value } = sentence {
                values.insert((*key).to_owned(), (*value).to_owned());
            }
            matches!(sentence, Sentence::Done { command: "get" }).then_some(())
        })?;
        let missing = Settings::KEYS
            .iter()
            .filter(|key| !values.contains_key(**key));
        for key in missing.copied().collect::<Vec<_>>() {
            let found = self.ask(&format!("get {key}"), |sentence| match sentence {
                Sentence::Config { key: k, value } if *k == key => Some(Some((*value).to_owned())),
                Sentence::Fail { command: "get", .. } => Some(None),
                _ => None,
            })?;
            // `None`: the firmware does not have this setting.
            found.map(|value| values.insert(key.to_owned(), value));
        }
        Ok(values)
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
