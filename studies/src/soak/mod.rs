//! Endurance test of one scanner over thousands of scans: changing scenes, faults of the instrument, lost chirps,
//! stalls, commands at any time. Every answer must equal that of a new pipeline with the same chirps, scan number
//! and settings. The memory of the process must not grow.
//!
//! A visit is one recording, scanned a few times forward and backward at standstill. It begins with `stop`, the
//! recording's settings, `selftest` and `start`, and may end in the middle of a scan.

mod bench;
pub mod days;
mod stage;

use std::rc::Rc;

use anyhow::{Result, ensure};
use stairscan::config::{Config, EstimatorKind};
use stairscan::motion::{Drive, Mode};
use stairscan::pipeline::Pipeline;
use stairscan::report::sentence::{ScanId, write_scan};
use stairscan::scanner::command::framed;
use stairscan::scanner::settings::SweepMode;
use stairscan::scanner::{DataPath, Settings};
use stairscan::verdict::{Conditions, Reason, Status};

use crate::faults;
use bench::{ReportedScan, ScannerBench, ScannerMemory};
use host_sim::random::Kind;
use host_sim::recording::Recording;
use host_sim::scene::maths::Random;
use host_sim::simulation::random_scan;
use stage::{Environment, Plan, ScanChirps};

/// Number of the test's stream of random numbers, separate from those of scenes and faults.
const STREAM: u64 = 0x534F_414B;
/// Maximum number of simulated recordings that are kept for further visits. Simulating one takes as long as about
/// twenty scans.
const MAX_RECORDINGS: usize = 12;
/// Number of visits after which a new recording is simulated, in place of the oldest if there are enough.
const RENEWAL_VISITS: u64 = 10;
/// Number of consecutive lost rows at the end of a scan for which the scanner reports a silent link.
const STREAK: usize = 8;
/// Commands that must not change the scanner in any of its states, some of them invalid.
const CHATTER: [&str; 9] = [
    "status",
    "version",
    "get",
    "get,mount-height",
    "set,seed,-1",
    "set,angle-count,2",
    "set,nothing,1",
    "scan",
    "hello",
];

/// Result of the endurance test: numbers of scans and commands, and the scans whose reports differ.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Number of reported scans.
    pub scans: u64,
    /// Numbers of completed scans with status `ok`, `degraded` and `fault`.
    pub statuses: [u64; 3],
    /// Number of scans that the scanner ended with a fault of the hardware: a stall, a silent link or too many lost
    /// rows.
    pub ended: u64,
    /// Number of completed scans with lost rows.
    pub lossy: u64,
    /// Number of scans ended by `stop`.
    pub stopped: u64,
    /// Number of scans of recordings with a fault of the instrument.
    pub faulty: u64,
    /// Number of commands without effect and settings sent.
    pub typed: u64,
    /// One text for each scan whose report differs from a new pipeline's.
    pub differing: Vec<String>,
    /// Maximum resident memory during the first and the second half of the scans, bytes; 0 if the system does not
    /// report it. It varies with the simulated recordings; a leak shows in the maxima.
    pub memory: [u64; 2],
}

/// Returns the resident memory of this process, bytes.
fn resident() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kib: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(1024 * kib)
}

/// Simulated recordings from which the visits choose.
struct Library {
    recordings: Vec<Recording>,
    visits: u64,
    next: u64,
}

impl Library {
    /// Returns a random recording, four times in ten with a fault of the instrument, and whether it has one.
    fn choose(&mut self, random: &mut Random) -> Result<(Recording, bool)> {
        if self.recordings.len() < MAX_RECORDINGS && self.visits >= self.recordings.len() as u64
            || self.visits.is_multiple_of(RENEWAL_VISITS)
        {
            let kind = Kind::ALL[random.index(Kind::ALL.len())];
            let recording = random_scan(kind, kind.variety(), self.next)?;
            self.next += 1;
            if self.recordings.len() == MAX_RECORDINGS {
                self.recordings.remove(0);
            }
            self.recordings.push(recording);
        }
        self.visits += 1;
        let clean = &self.recordings[random.index(self.recordings.len())];
        if random.chance(0.6) {
            return Ok((clean.clone(), false));
        }
        let fault = &faults::ALL[random.index(faults::ALL.len())];
        let strength = fault.strengths[random.index(fault.strengths.len())];
        Ok((fault.on(clean, strength, self.visits)?, true))
    }
}

/// Returns random disturbances (lost chirps, a silent module, a stall) for a scan of `rows` rows; two scans in three
/// have none.
fn plan(random: &mut Random, rows: usize) -> Plan {
    let mut plan = Plan::default();
    match random.index(12) {
        0 => plan.lost.extend((0..3).map(|_| random.index(rows))),
        1 => plan.lost.extend((0..40).map(|_| random.index(rows))),
        2 => plan.silent_from = Some(random.index(rows)),
        3 => plan.stalls_at = Some(1 + random.index(rows - 1)),
        _ => {}
    }
    plan
}

/// The scanner under test and its expected state.
struct Soak<'a> {
    bench: ScannerBench<'a>,
    random: Random,
    tally: Tally,
    wanted: u64,
    /// Configuration that the scanner has been given by commands.
    config: Config,
}

/// Runs `scans` scans. `look` is called after each visit with the number of scans so far.
///
/// # Errors
/// A line that is not a sentence, a missed deadline, or a refused setting.
pub fn soak(scans: u64, seed: u64, mut look: impl FnMut(u64)) -> Result<Tally> {
    let mut random = Random::new(seed, STREAM);
    let mut library = Library {
        recordings: Vec::new(),
        visits: 0,
        next: 1_000 * (seed % 100_000),
    };
    let (first, _) = library.choose(&mut random)?;
    let first = Rc::new(ScanChirps::new(&first, &Config::default())?);
    let mut memory = ScannerMemory::new();
    let settings = Settings {
        motion: Mode::Standing,
        // The simulated shaft moves without delay.
        sweep_mode: SweepMode::Stop,
        ..Settings::default()
    };
    let mut soak = Soak {
        bench: ScannerBench::new(&mut memory, Environment::new(first), settings),
        random,
        tally: Tally::default(),
        wanted: scans,
        config: Config::default(),
    };
    while soak.tally.scans < scans {
        let (recording, faulty) = library.choose(&mut soak.random)?;
        // A fault may leave a bandwidth or a mounting that cannot be scanned.
        if let Ok(chirps) = ScanChirps::new(&recording, &Config::default()) {
            let before = soak.tally.scans;
            soak.visit(Rc::new(chirps))?;
            soak.tally.faulty += u64::from(faulty) * (soak.tally.scans - before);
        }
        let half = usize::from(soak.tally.scans > scans / 2);
        let peak = &mut soak.tally.memory[half];
        *peak = resident().unwrap_or(0).max(*peak);
        look(soak.tally.scans);
    }
    Ok(soak.tally)
}

impl Soak<'_> {
    /// Makes a visit: gives the scanner the recording's settings, scans the recording up to four times, and may leave
    /// it in the middle of another scan.
    fn visit(&mut self, chirps: Rc<ScanChirps>) -> Result<()> {
        self.begin(&chirps)?;
        ensure!(self.bench.command("start")?, "start: refused");
        let times = 1 + self.random.index(4) as u64;
        for _ in 0..times.min(self.wanted - self.tally.scans) {
            self.scan(&chirps)?;
        }
        if self.random.chance(0.3) {
            // The next `stop` falls in the middle of a scan.
            let before = self.bench.scans();
            let steps = self.random.index(1200);
            (0..steps).try_for_each(|_| self.bench.step())?;
            self.tally.stopped += u64::from(self.bench.scans() > before || steps > 0);
        }
        Ok(())
    }

    /// Begins a visit: stops the scanner, exchanges the recording, and sends its settings with a random seed and
    /// estimator.
    fn begin(&mut self, chirps: &Rc<ScanChirps>) -> Result<()> {
        ensure!(self.bench.command("stop")?, "stop: refused");
        // The previous scan is discarded.
        self.bench.take_report();
        {
            let mut stage = self.bench.stage.borrow_mut();
            stage.chirps = chirps.clone();
            stage.plan = plan(&mut self.random, chirps.rows());
            stage.shown.clear();
        }
        self.config = Config {
            seed: self.random.index(1 << 20) as u32,
            estimator: self.estimator(),
            ..chirps.config
        };
        let wanted = Settings {
            config: self.config,
            ..Settings::default()
        };
        // With the old module's settings some values that fit the new ones may be refused.
        for last in [false, true] {
            for key in own_keys() {
                let value = wanted.get(key).unwrap_or_default();
                let set = format!("set,{key},{value}");
                ensure!(
                    self.bench.command(&set)? || !last,
                    "{}: {set}: refused",
                    chirps.name
                );
                self.tally.typed += 1;
            }
            ensure!(self.bench.command("selftest")?, "selftest: refused");
        }
        Ok(())
    }

    fn estimator(&mut self) -> EstimatorKind {
        let kinds = EstimatorKind::ALL;
        match self.random.chance(0.15) {
            true => kinds[self.random.index(kinds.len())],
            false => EstimatorKind::default(),
        }
    }

    /// Runs one scan and compares its report. During the scan it sends commands without effect, and sometimes the seed
    /// for the next scan.
    fn scan(&mut self, chirps: &ScanChirps) -> Result<()> {
        let begun = |bench: &mut ScannerBench<'_>| !bench.stage.borrow().shown.is_empty();
        self.bench.until(begun)?;
        let number = self.bench.scans();
        let (plan, config) = (self.bench.stage.borrow().plan.clone(), self.config);
        for _ in 0..self.random.index(3) {
            let line = CHATTER[self.random.index(CHATTER.len())];
            self.bench.type_in(&framed(&[line]));
            self.tally.typed += 1;
        }
        if self.random.chance(0.1) {
            self.bench.type_in("\u{1}~~~~\r\n$PSTC,stop*00000000\r\n");
        }
        if self.random.chance(0.3) {
            self.config.seed = self.random.index(1 << 20) as u32;
            let seed = self.config.seed.to_string();
            self.bench.type_in(&framed(&["set", "seed", &seed]));
            self.tally.typed += 1;
        }
        let mut reported = None;
        self.bench.until(|bench| {
            reported = bench.take_report();
            reported.is_some()
        })?;
        let shown = std::mem::take(&mut self.bench.stage.borrow_mut().shown);
        self.bench.stage.borrow_mut().plan = self::plan(&mut self.random, chirps.rows());
        if let Some(reported) = reported {
            self.compare(chirps, (number, &config), &plan, (&shown, &reported));
        }
        Ok(())
    }

    /// Counts a scan, and records its report in the tally if it differs from the expected one.
    fn compare(
        &mut self,
        chirps: &ScanChirps,
        (number, config): (u32, &Config),
        plan: &Plan,
        (shown, reported): (&[(usize, bool)], &ReportedScan),
    ) {
        self.tally.scans += 1;
        let lost = shown.iter().filter(|(_, came)| !came).count();
        let last = shown.iter().rev().take(STREAK);
        let silent = last.filter(|(_, came)| !came).count() == STREAK;
        let whole = shown.len() == chirps.rows() && plan.stalls_at.is_none() && !silent;
        let expected = if whole && lost <= usize::from(Settings::default().timing.max_lost) {
            self.tally.lossy += u64::from(lost > 0);
            self.tally.statuses[reported.head.status as usize] += 1;
            fresh(
                chirps,
                config,
                ScanId {
                    scan: number,
                    settings: reported.head.settings,
                },
                shown,
            )
        } else {
            self.tally.ended += 1;
            let reasons = reported.head.reasons;
            let hardware = [Reason::MotorStall, Reason::LinkSilent, Reason::TooManyLost];
            let named = hardware.iter().any(|&reason| reasons.has(reason));
            let right =
                reported.head.status == Status::Fault && named && reported.head.scan == number;
            if right {
                reported.lines.clone()
            } else {
                vec!["a fault of the hardware".into()]
            }
        };
        if expected != reported.lines {
            let line = format!(
                "scan {number} of {}: reported {}, expected {}",
                chirps.name,
                reported.lines.join(" "),
                expected.join(" ")
            );
            self.tally.differing.push(line);
        }
    }
}

/// Returns the names of the settings that are sent in a visit: those of [`Config`] without the radar module's.
fn own_keys() -> impl Iterator<Item = &'static &'static str> {
    Config::KEYS.iter().filter(|key| !key.starts_with("radar-"))
}

/// Returns the lines that a new pipeline reports for the same rows. `shown` are the rows in their order, and whether their chirps were received.
fn fresh(chirps: &ScanChirps, config: &Config, id: ScanId, shown: &[(usize, bool)]) -> Vec<String> {
    let mut pipeline = Box::new(Pipeline::new());
    if let Err(error) = pipeline.begin(config, id.scan) {
        return vec![error.to_string()];
    }
    let mut lost = 0;
    for &(row, came) in shown {
        let samples = pipeline.samples();
        match chirps
            .chirp(row)
            .filter(|chirp| came && chirp.len() == samples.len())
        {
            Some(chirp) => {
                samples.copy_from_slice(chirp);
                pipeline.row(row as u16);
            }
            None => {
                pipeline.lost(row as u16);
                lost += 1;
            }
        }
    }
    let conditions = Conditions {
        lost_rows: lost > 0,
        ..Conditions::GOOD
    };
    let outcome = pipeline.conclude(&Drive::STANDING, conditions);
    let mut lines = Vec::new();
    write_scan(id, lost, &outcome, |line| {
        lines.push(line.trim_end().to_owned())
    });
    lines
}
