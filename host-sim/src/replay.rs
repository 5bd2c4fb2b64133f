//! The scanner's own loop over a recording: [`Scanner`] with a simulated shaft, the recording as
//! the radar module and a buffer as the report UART.

use anyhow::{Result, bail};
use stairscan::config::Config;
use stairscan::pipeline::Pipeline;
use stairscan::report::command::Measure;
use stairscan::report::{Sentence, StepLine};
use stairscan::scan::settings::Sweeping;
use stairscan::scan::{Board, BytePort, Hardware, Identity, Micros, Reports, Scanner, Settings};
use stairscan::stairs::Reasons;

use crate::answer::Answer;
use crate::playback::{Playback, PlaybackLink, SimShaft};
use crate::recording::Recording;

/// How to scan.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// What the recording does not bring: estimator, seed, CFAR, particles.
    pub config: Config,
    /// Scans one after the other, each the other way round.
    pub scans: u32,
    /// Begin at the last angle.
    pub backwards: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            config: Config::default(),
            scans: 1,
            backwards: false,
        }
    }
}

/// The first scan's answer.
pub fn answer(recording: &Recording, options: &Options) -> Result<Answer> {
    let mut answers = answers(
        recording,
        &Options {
            scans: 1,
            ..*options
        },
        |_, _| (),
    )?;
    match answers.pop() {
        Some(answer) => Ok(answer),
        None => bail!("{}: the scanner gave no answer", recording.name),
    }
}

/// The answers of `options.scans` scans. With each of them `look` sees map and estimator.
pub fn answers(
    recording: &Recording,
    options: &Options,
    mut look: impl FnMut(&Pipeline, &Answer),
) -> Result<Vec<Answer>> {
    let playback = Playback::new(recording, &options.config)?;
    let settings = Settings {
        config: *playback.config(),
        sweeping: Sweeping::Both,
        ..Settings::default()
    };
    let settings = match options.backwards {
        true => Settings {
            sweeping: Sweeping::Backward,
            ..settings
        },
        false => settings,
    };
    let mut pipeline = Box::new(Pipeline::new());
    let mut reports = Reports::new();
    let hardware = Hardware {
        mirror: SimShaft::default(),
        link: PlaybackLink::new(&playback),
        port: Console::default(),
        board: Desk,
    };
    let mut now = Micros(0);
    let data = &mut *pipeline;
    let mut scanner = Scanner::new(hardware, data, &mut reports, settings, IDENTITY, now);
    let mut answers = Vec::new();
    // Some five steps a row; the bound only guards against a scanner that never answers.
    let bound = 64 * (u32::from(settings.config.sweep.angle_count) + 64) * options.scans;
    for _ in 0..bound {
        scanner.step(now);
        now = now.plus(STEP_US);
        let Some(sentences) = scanner.port_mut().take_scan()? else {
            continue;
        };
        let answer = Answer::parse(&recording.name, sentences)?;
        look(scanner.data(), &answer);
        answers.push(answer);
        if answers.len() as u32 == options.scans {
            return Ok(answers);
        }
    }
    bail!("{}: the scanner gave no answer", recording.name)
}

/// Time that passes from step to step: any mirror has come to rest.
const STEP_US: u32 = 10_000;

const IDENTITY: Identity = Identity {
    version: env!("CARGO_PKG_VERSION"),
    revision: "host",
    reset: "none",
    clock: "host",
    reasons: Reasons::NONE,
};

/// The board under `replay`: nothing survives it.
struct Desk;

impl Board for Desk {
    fn stopped(&self) -> bool {
        false
    }

    fn set_stopped(&mut self, _: bool) {}

    fn measure(&self, _: Measure) -> u32 {
        0
    }
}

/// The report UART, read line by line.
#[derive(Default)]
struct Console {
    line: Vec<u8>,
    scan: Vec<String>,
}

impl BytePort for Console {
    fn read(&mut self) -> Option<u8> {
        None
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        self.line.extend(bytes);
        bytes.len()
    }
}

impl Console {
    /// The sentences of a scan once all of them have come.
    fn take_scan(&mut self) -> Result<Option<Vec<String>>> {
        while let Some(end) = self.line.iter().position(|&b| b == b'\n') {
            let line: Vec<u8> = self.line.drain(..=end).collect();
            let line = String::from_utf8(line)?.trim_end().to_owned();
            let complete = match Sentence::parse(&line)? {
                Sentence::Scan(head) => head.steps == 0,
                Sentence::Step(StepLine { index, count, .. }) => index == count,
                _ => continue,
            };
            self.scan.push(line);
            if complete {
                return Ok(Some(std::mem::take(&mut self.scan)));
            }
        }
        Ok(None)
    }
}
