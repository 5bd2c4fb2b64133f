//! A scanner that goes on and on: stepped, typed at, and read.

use std::cell::RefCell;
use std::rc::Rc;

use anyhow::{Context, Result, bail, ensure};
use stairscan::motion::Odometry;
use stairscan::pipeline::Pipeline;
use stairscan::report::{ScanLine, Sentence};
use stairscan::scanner::command::framed;
use stairscan::scanner::{Hardware, Micros, Reports, Scanner, Settings};

use super::stage::{Link, Shaft, Shared, Stage};
use crate::volatile::{Volatile, identity};

/// Time from step to step: any mirror has come to rest.
const STEP_US: u32 = 10_000;
/// Steps within which a command is answered, or a scan of the longest schedule told, faults included.
const PATIENCE: u32 = 200_000;

/// What the scanner borrows.
pub struct ScannerMemory {
    pipeline: Box<Pipeline>,
    reports: Reports,
    odometry: Odometry,
}

impl ScannerMemory {
    /// For a scanner that has not begun.
    pub fn new() -> Self {
        Self {
            pipeline: Box::new(Pipeline::new()),
            reports: Reports::new(),
            odometry: Odometry::new(),
        }
    }
}

impl Default for ScannerMemory {
    fn default() -> Self {
        Self::new()
    }
}

/// A scan as it was told.
#[derive(Clone, Debug)]
pub struct Told {
    /// Its head.
    pub head: ScanLine,
    /// All of its lines.
    pub lines: Vec<String>,
}

/// The scanner and its stage.
pub struct Desk<'a> {
    /// What stands before it.
    pub stage: Rc<RefCell<Stage>>,
    scanner: Scanner<'a, Shaft, Link, Shared, Volatile, &'a mut Pipeline>,
    now: Micros,
    /// The scan that is being told.
    telling: Option<Told>,
    to_come: u8,
    told: Option<Told>,
    replies: Vec<String>,
}

impl<'a> Desk<'a> {
    /// A scanner that has just booted, and stands.
    pub fn new(memory: &'a mut ScannerMemory, stage: Stage, settings: Settings) -> Self {
        let stage = Rc::new(RefCell::new(stage));
        let shared = Shared(stage.clone());
        let hardware = Hardware {
            mirror: Shaft::new(shared.clone()),
            link: Link::new(shared.clone()),
            port: shared,
            board: Volatile::STOPPED,
        };
        let now = Micros(0);
        let lent = (&mut memory.reports, &mut memory.odometry);
        let data = &mut *memory.pipeline;
        Self {
            scanner: Scanner::new(hardware, data, lent, Some(settings), identity("soak"), now),
            stage,
            now,
            telling: None,
            to_come: 0,
            told: None,
            replies: Vec::new(),
        }
    }

    /// Number of scans begun.
    pub fn scans(&self) -> u32 {
        self.scanner.scans()
    }

    /// One step, and what it has brought.
    ///
    /// # Errors
    /// Names a line that is no sentence, or a missed deadline.
    pub fn step(&mut self) -> Result<()> {
        self.scanner.step(self.now);
        self.now = self.now.plus(STEP_US);
        let (state, healthy) = (self.scanner.state(), self.scanner.healthy(self.now));
        ensure!(healthy, "deadline missed in {state}");
        let printed = std::mem::take(&mut self.stage.borrow_mut().printed);
        let text = String::from_utf8(printed)?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        text[..whole].lines().try_for_each(|line| self.hear(line))?;
        let mut stage = self.stage.borrow_mut();
        stage.printed.extend(text[whole..].bytes());
        Ok(())
    }

    fn hear(&mut self, line: &str) -> Result<()> {
        match Sentence::parse(line).with_context(|| line.to_owned())? {
            Sentence::Scan(head) => {
                ensure!(self.telling.is_none(), "{line}: within another scan");
                self.to_come = head.following();
                self.telling = Some(Told {
                    head,
                    lines: vec![line.to_owned()],
                });
            }
            Sentence::Step(_) | Sentence::Drop(_) | Sentence::Maybe(_) => {
                let telling = self.telling.as_mut().context("a step of no scan")?;
                telling.lines.push(line.to_owned());
                self.to_come = self.to_come.checked_sub(1).context("one step too many")?;
            }
            Sentence::Live(_) => {}
            _ => self.replies.push(line.to_owned()),
        }
        if self.to_come == 0 && self.telling.is_some() {
            self.told = self.telling.take();
        }
        Ok(())
    }

    /// The scan that was told last, if nobody has asked for it yet.
    pub fn told(&mut self) -> Option<Told> {
        self.told.take()
    }

    /// Steps until `done`.
    ///
    /// # Errors
    /// As [`Desk::step`], or that it did not come about.
    pub fn until(&mut self, mut done: impl FnMut(&mut Self) -> bool) -> Result<()> {
        for _ in 0..PATIENCE {
            self.step()?;
            if done(self) {
                return Ok(());
            }
        }
        bail!("stands still in state {}", self.scanner.state())
    }

    /// Types what is to be answered some time, or not at all.
    pub fn type_in(&mut self, line: &str) {
        self.stage.borrow_mut().typed.extend(line.bytes());
    }

    /// Whether a command is carried out: its answer is no refusal. What was asked before is answered first.
    ///
    /// # Errors
    /// As [`Desk::until`].
    pub fn command(&mut self, command: &str) -> Result<bool> {
        self.until(|desk| desk.stage.borrow().typed.is_empty())?;
        (0..100).try_for_each(|_| self.step())?;
        self.replies.clear();
        self.type_in(&framed(&[command]));
        let mut carried_out = false;
        self.until(|desk| {
            let answer = desk.replies.iter().find_map(|line| answer(line));
            carried_out = answer.unwrap_or(false);
            answer.is_some()
        })?;
        Ok(carried_out)
    }
}

/// Whether a line answers a command, and whether it was carried out.
fn answer(line: &str) -> Option<bool> {
    match Sentence::parse(line).ok()? {
        Sentence::Done { .. } | Sentence::Config { .. } | Sentence::State { .. } => Some(true),
        Sentence::Fail { .. } => Some(false),
        _ => None,
    }
}
