//! A scanner under continuous operation: the bench runs the scanner's loop, sends it commands and reads its lines.

use std::cell::RefCell;
use std::rc::Rc;

use anyhow::{Context, Result, bail, ensure};
use stairscan::motion::Odometry;
use stairscan::pipeline::Pipeline;
use stairscan::report::{ScanLine, Sentence};
use stairscan::scanner::command::framed;
use stairscan::scanner::{Hardware, LentParts, Micros, Reports, Scanner, Settings};

use testbed::{Module, Port};

use super::stage::{Environment, Shaft, Shared};
use host_sim::volatile::{Volatile, identity};

/// Simulated time between two steps of the scanner's loop, µs: after one step the mirror has settled.
const STEP_US: u32 = 10_000;
/// Maximum number of steps of the loop until a command is answered, or a scan of the longest schedule reported,
/// including faults.
const PATIENCE: u32 = 200_000;

/// Memory that the scanner borrows: its pipeline, reports and odometry.
pub struct ScannerMemory {
    pipeline: Box<Pipeline>,
    reports: Reports,
    odometry: Odometry,
}

impl ScannerMemory {
    /// Creates the memory for a new scanner.
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

/// The report of one scan, received completely.
#[derive(Clone, Debug)]
pub struct ReportedScan {
    /// The `SCAN` sentence that begins the report.
    pub head: ScanLine,
    /// All sentences of the report, including the `SCAN` sentence, one line each.
    pub lines: Vec<String>,
}

/// Hardware of the scanner under test.
type Bench = Hardware<Shaft, Module<Shared>, testbed::Shared<Port>, Volatile>;

/// The scanner and its simulated environment.
pub struct ScannerBench<'a> {
    /// The scanner's simulated environment: radar module and mirror.
    pub stage: Rc<RefCell<Environment>>,
    port: testbed::Shared<Port>,
    scanner: Scanner<'a, (Bench, &'a mut Pipeline)>,
    now: Micros,
    /// The scan whose report has begun and is not yet complete.
    receiving: Option<ReportedScan>,
    to_come: u8,
    reported: Option<ReportedScan>,
    replies: Vec<String>,
}

impl<'a> ScannerBench<'a> {
    /// Creates a scanner that has just booted and is stopped.
    pub fn new(memory: &'a mut ScannerMemory, stage: Environment, settings: Settings) -> Self {
        let stage = Rc::new(RefCell::new(stage));
        let shared = Shared(stage.clone());
        let port = testbed::Shared::<Port>::default();
        let hardware = Hardware {
            mirror: Shaft::new(shared.clone()),
            link: Module::new(shared),
            port: port.clone(),
            board: Volatile::STOPPED,
        };
        let now = Micros(0);
        let lent = LentParts {
            reports: &mut memory.reports,
            odometry: &mut memory.odometry,
        };
        let data = &mut *memory.pipeline;
        Self {
            scanner: Scanner::new(hardware, data, lent, Some(settings), identity("soak"), now),
            stage,
            port,
            now,
            receiving: None,
            to_come: 0,
            reported: None,
            replies: Vec::new(),
        }
    }

    /// Returns the number of scans that the scanner has begun since boot.
    pub fn scans(&self) -> u32 {
        self.scanner.scans()
    }

    /// Runs one step of the scanner's loop and processes the lines that it has sent.
    ///
    /// # Errors
    /// A line that is not a sentence, or a missed deadline.
    pub fn step(&mut self) -> Result<()> {
        self.scanner.step(self.now);
        self.now = self.now.plus(STEP_US);
        let (state, healthy) = (self.scanner.state(), self.scanner.healthy(self.now));
        ensure!(healthy, "deadline missed in {state}");
        let lines = self.port.get().take_lines();
        lines.iter().try_for_each(|line| self.hear(line))
    }

    fn hear(&mut self, line: &str) -> Result<()> {
        match Sentence::parse(line).with_context(|| line.to_owned())? {
            Sentence::Scan(head) => {
                ensure!(self.receiving.is_none(), "{line}: within another scan");
                self.to_come = head.following();
                self.receiving = Some(ReportedScan {
                    head,
                    lines: vec![line.to_owned()],
                });
            }
            Sentence::Step(_) | Sentence::Drop(_) | Sentence::Maybe(_) => {
                let receiving = self.receiving.as_mut().context("a step of no scan")?;
                receiving.lines.push(line.to_owned());
                self.to_come = self.to_come.checked_sub(1).context("one step too many")?;
            }
            Sentence::Live(_) => {}
            _ => self.replies.push(line.to_owned()),
        }
        if self.to_come == 0 && self.receiving.is_some() {
            self.reported = self.receiving.take();
        }
        Ok(())
    }

    /// Returns the last completely reported scan, once; `None` if no other was reported since.
    pub fn take_report(&mut self) -> Option<ReportedScan> {
        self.reported.take()
    }

    /// Runs steps of the scanner's loop until `done` returns `true`.
    ///
    /// # Errors
    /// Those of [`ScannerBench::step`], or a timeout.
    pub fn until(&mut self, mut done: impl FnMut(&mut Self) -> bool) -> Result<()> {
        for _ in 0..PATIENCE {
            self.step()?;
            if done(self) {
                return Ok(());
            }
        }
        bail!("does not move in state {}", self.scanner.state())
    }

    /// Sends a line to the scanner without waiting for a reply.
    pub fn type_in(&mut self, line: &str) {
        self.port.get().type_in(line);
    }

    /// Sends a command. Returns whether it was executed and not refused. Earlier commands are answered
    /// first.
    ///
    /// # Errors
    /// Those of [`ScannerBench::until`].
    pub fn command(&mut self, command: &str) -> Result<bool> {
        self.until(|bench| bench.port.get().wires.incoming.is_empty())?;
        (0..100).try_for_each(|_| self.step())?;
        self.replies.clear();
        self.type_in(&framed(&[command]));
        let mut carried_out = false;
        self.until(|bench| {
            let answer = bench.replies.iter().find_map(|line| answer(line));
            carried_out = answer.unwrap_or(false);
            answer.is_some()
        })?;
        Ok(carried_out)
    }
}

/// Returns whether the command was executed, if the line is the reply to a command; else `None`.
fn answer(line: &str) -> Option<bool> {
    match Sentence::parse(line).ok()? {
        Sentence::Done { .. } | Sentence::Config { .. } | Sentence::State { .. } => Some(true),
        Sentence::Fail { .. } => Some(false),
        _ => None,
    }
}
