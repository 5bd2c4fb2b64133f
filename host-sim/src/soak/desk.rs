//! A scanner under continuous operation: runs its loop, sends commands, reads its lines.

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

/// Time between two steps of the loop; the mirror has settled by then.
const STEP_US: u32 = 10_000;
/// Maximum number of steps until a command is answered, or a scan of the longest schedule reported,
/// including faults.
const PATIENCE: u32 = 200_000;

/// Memory that the scanner borrows.
pub struct ScannerMemory {
    pipeline: Box<Pipeline>,
    reports: Reports,
    odometry: Odometry,
}

impl ScannerMemory {
    /// Memory for a new scanner.
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

/// A reported scan.
#[derive(Clone, Debug)]
pub struct Told {
    /// Its head.
    pub head: ScanLine,
    /// All of its lines, including the head.
    pub lines: Vec<String>,
}

/// The scanner and its simulated environment.
pub struct Desk<'a> {
    /// The simulated environment.
    pub stage: Rc<RefCell<Stage>>,
    scanner: Scanner<'a, Shaft, Link, Shared, Volatile, &'a mut Pipeline>,
    now: Micros,
    /// The scan that is being reported.
    telling: Option<Told>,
    to_come: u8,
    told: Option<Told>,
    replies: Vec<String>,
}

impl<'a> Desk<'a> {
    /// A scanner that has just booted and is stopped.
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

    /// Runs one step and processes its output.
    ///
    /// # Errors
    /// A line that is not a sentence, or a missed deadline.
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

    /// Takes the last reported scan.
    pub fn told(&mut self) -> Option<Told> {
        self.told.take()
    }

    /// Runs steps until `done`.
    ///
    /// # Errors
    /// Those of [`Desk::step`], or a timeout.
    pub fn until(&mut self, mut done: impl FnMut(&mut Self) -> bool) -> Result<()> {
        for _ in 0..PATIENCE {
            self.step()?;
            if done(self) {
                return Ok(());
            }
        }
        bail!("stands still in state {}", self.scanner.state())
    }

    /// Sends a line without waiting for a reply.
    pub fn type_in(&mut self, line: &str) {
        self.stage.borrow_mut().typed.extend(line.bytes());
    }

    /// Sends a command. Returns whether it was executed and not refused. Earlier commands are answered
    /// first.
    ///
    /// # Errors
    /// Those of [`Desk::until`].
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

/// Returns whether the command was executed if a line is a reply to one.
fn answer(line: &str) -> Option<bool> {
    match Sentence::parse(line).ok()? {
        Sentence::Done { .. } | Sentence::Config { .. } | Sentence::State { .. } => Some(true),
        Sentence::Fail { .. } => Some(false),
        _ => None,
    }
}
