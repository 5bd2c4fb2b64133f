//! Replays a recording: [`Scanner`], the firmware's own scanner code, with a simulated shaft, the
//! recording as the radar module and a buffer as the report UART.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use anyhow::{Context, Result, anyhow, bail, ensure};
use stairscan::Iq;
use stairscan::config::{Config, ConfigError};
use stairscan::drive::ExpectedTravel;
use stairscan::estimator::MappedScan;
use stairscan::motion::{Drive, Mode, Odometry, Track};
use stairscan::mount::Mounting;
use stairscan::params::Numbers;
use stairscan::pipeline::Pipeline;
use stairscan::report::Sentence;
use stairscan::scanner::{BytePort, DataPath, Hardware, LentParts, Micros, Reports, Scanner};
use stairscan::signal::image::KeptImage;
use stairscan::verdict::{Conditions, GuardResult, Outcome};

use crate::answer::Answer;
use crate::counted::counted;
use crate::guarded::Guarded;
use crate::live::lines::Splitter;
use crate::motion::inlet::Inlet;
use crate::motion::{Fault, MotionSentences, Timetable};
use crate::playback::{Playback, PlaybackLink, SimShaft};
use crate::recording::Recording;
use crate::setup::{self, Kind};
use crate::volatile::{Volatile, identity};

/// Default seed of the random numbers that draw the particles.
pub const SEED: u32 = 1;

/// Options of a replay of a recording.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Settings that are not in the recording: estimator, seed, CFAR, particles.
    pub config: Config,
    /// Number of scans to make; `None`: as many as the recording contains. A recording of one scan
    /// is repeated with alternating direction.
    pub scans: Option<u32>,
    /// Whether the mirror turns in the opposite direction to that of the recording.
    pub backwards: bool,
    /// Whether every scan of the recording is answered by a new scanner, without earlier scans.
    pub single: bool,
    /// Motion mode that applies without motion sentences; `None`: that of the recording.
    pub motion: Option<Mode>,
    /// Fault of the motion sentences; `None` for faultless ones.
    pub motion_fault: Option<Fault>,
    /// Whether motion sentences are sent with the triggers, as by `emulate`, instead of at the
    /// recording's times.
    pub by_trigger: bool,
    /// Tuned numbers of the scanner's stages.
    pub numbers: Numbers,
    /// Whether the coherent image is kept, too.
    pub coherent: bool,
}

impl Options {
    /// Returns the number of scans to make of `recording` with these options.
    ///
    /// # Errors
    /// A recording of several scans cannot be extended, and one with motion cannot be reversed.
    pub fn scans_of(&self, recording: &Recording) -> Result<usize> {
        let held = recording.scans();
        let scans = self.scans.map_or(held, |scans| scans as usize);
        ensure!(
            held == 1 || scans <= held,
            "{}: {}: the recording holds {held}",
            recording.name,
            counted(scans, "scan")
        );
        ensure!(
            held == 1 || !self.backwards,
            "{}: backwards: the recording holds {held} scans, each with its own way round",
            recording.name
        );
        Ok(scans)
    }
}

/// A scan that has just been answered, for observers.
#[derive(Clone, Copy)]
pub struct Scanned<'a> {
    /// The recording of which the scan is a part.
    recording: &'a Recording,
    /// Index of the scan in the recording, from 0.
    scan: usize,
    /// Configuration of the scanner for this scan.
    pub config: &'a Config,
    /// Polar map and estimator after this scan.
    pub pipeline: &'a Pipeline,
    /// Coherent image of this scan, before its echoes were found; `None` unless the options want it.
    pub image: Option<&'a KeptImage>,
    /// Motion of the chair during this scan, as the estimator used it.
    pub drive: Drive<'a>,
    /// The answer to this scan.
    pub answer: &'a Answer,
}

impl Scanned<'_> {
    /// Returns the scan as the estimator gets it.
    pub fn mapped(&self) -> MappedScan<'_> {
        MappedScan {
            map: self.pipeline.map(),
            found: self.pipeline.found(),
            config: self.config,
            number: self.answer.scan.scan,
            image: Some(self.pipeline.image()),
            drive: &self.drive,
        }
    }

    /// Returns this scan as a recording of its own.
    pub fn recording(&self) -> Recording {
        self.recording.scan(self.scan)
    }
}

/// Returns the answer to the first scan of a recording.
///
/// # Errors
/// The recording cannot be scanned; the message names the cause.
pub fn answer(recording: &Recording, options: &Options) -> Result<Answer> {
    let options = Options {
        scans: Some(1),
        ..*options
    };
    match answers(recording, &options, |_| ())?.pop() {
        Some(answer) => Ok(answer),
        None => bail!("{}: the scanner gave no answer", recording.name),
    }
}

/// Returns the answers to all scans, in order. `look` is called after each scan, with its answer,
/// map and estimator.
///
/// # Errors
/// The recording cannot be scanned; the message names the cause.
pub fn answers(
    recording: &Recording,
    options: &Options,
    mut look: impl FnMut(&Scanned<'_>),
) -> Result<Vec<Answer>> {
    setup::full_scans(recording)?;
    let scans = options.scans_of(recording)?;
    // A scan of a sequence was not necessarily made at standstill.
    let mode = options.motion.unwrap_or(setup::mode(recording));
    let options = &Options {
        motion: Some(mode),
        ..*options
    };
    if !options.single || recording.scans() == 1 {
        return follow(recording, options, scans, look);
    }
    let mut answers = Vec::new();
    // All scans are checked, so that an error in the last one is reported before the first is scanned.
    Playback::new(recording, &options.config)?;
    for scan in 0..scans {
        let alone = recording.scan(scan);
        let part = |answer: &Answer| Answer {
            recording: recording.name.clone(),
            part: Some(scan as u32 + 1),
            ..answer.clone()
        };
        let answer = follow(&alone, options, 1, |scanned| {
            let answer = &part(scanned.answer);
            look(&Scanned { answer, ..*scanned });
        })?;
        answers.extend(answer.iter().map(part));
    }
    Ok(answers)
}

/// The scanner's data path, which also stores the motion used for its last answer: when the answer is
/// reported, the scanner is already at its next scan.
struct DataPathWithMotion {
    pipeline: Box<Pipeline>,
    image: Option<Box<KeptImage>>,
    drive: Drive<'static>,
    track: Option<Track>,
}

impl DataPathWithMotion {
    fn drive(&self) -> Drive<'_> {
        Drive {
            track: self.track.as_ref(),
            ..self.drive
        }
    }
}

impl DataPath for DataPathWithMotion {
    fn begin(&mut self, config: &Config, scan: u32) -> std::result::Result<(), ConfigError> {
        self.pipeline.begin(config, scan)
    }

    fn begin_guard(&mut self, config: &Config, sweep: u32) -> std::result::Result<(), ConfigError> {
        self.pipeline.begin_guard(config, sweep)
    }

    fn samples(&mut self) -> &mut [Iq] {
        self.pipeline.samples()
    }

    fn row(&mut self, row: u16) {
        self.pipeline.row(row);
    }

    fn lost(&mut self, row: u16) {
        self.pipeline.lost(row);
    }

    fn conclude(&mut self, drive: &Drive<'_>, conditions: Conditions) -> Outcome {
        self.track = drive.track.cloned();
        self.drive = Drive {
            track: None,
            phases: self.pipeline.phases(drive),
            ..*drive
        };
        if let Some(image) = &mut self.image {
            (**image).clone_from(self.pipeline.image());
        }
        self.pipeline.conclude(drive, conditions)
    }

    fn guard(&mut self, drive: &Drive<'_>, conditions: Conditions) -> GuardResult {
        self.pipeline.guard(drive, conditions)
    }

    fn calibrate(&mut self, wall_m: f32) -> std::result::Result<Mounting, ConfigError> {
        self.pipeline.calibrate(wall_m)
    }

    fn expect_motion(&mut self, travel: ExpectedTravel) {
        self.pipeline.expect_motion(travel);
    }

    fn numbers(&self) -> Numbers {
        self.pipeline.numbers()
    }

    fn self_test(&mut self) -> bool {
        self.pipeline.self_test()
    }
}

/// Runs one scanner over `scans` scans and returns their answers; `look` is called after each scan.
fn follow(
    recording: &Recording,
    options: &Options,
    scans: usize,
    mut look: impl FnMut(&Scanned<'_>),
) -> Result<Vec<Answer>> {
    let playback = playback(recording, options)?;
    let mut answers = Vec::new();
    run(recording, options, &playback, scans, |data, sentences| {
        let scan = answers.len();
        let answer = Answer {
            part: (recording.scans() > 1).then_some(scan as u32 + 1),
            ..Answer::parse(&recording.name, sentences)?
        };
        look(&Scanned {
            recording,
            scan: scan % recording.scans(),
            config: playback.config_of(scan),
            pipeline: &data.pipeline,
            image: data.image.as_deref(),
            drive: data.drive(),
            answer: &answer,
        });
        answers.push(answer);
        Ok(())
    })?;
    Ok(answers)
}

/// Returns the answers to all guard sweeps of a recording, in order.
///
/// # Errors
/// The recording cannot be swept; the message names the cause.
pub fn guarded(recording: &Recording, options: &Options) -> Result<Vec<Guarded>> {
    let sweeps = options.scans_of(recording)?;
    let options = &Options {
        motion: Some(options.motion.unwrap_or(setup::mode(recording))),
        ..*options
    };
    let mut words = Vec::new();
    let mut part = |recording: &Recording, sweeps, first| {
        let playback = playback(recording, options)?.guarding();
        run(recording, options, &playback, sweeps, |_, sentences| {
            words.extend(Guarded::parse(first, sentences)?);
            Ok(())
        })
    };
    if options.single && recording.scans() > 1 {
        (0..sweeps).try_for_each(|sweep| part(&recording.scan(sweep), 1, sweep))?;
    } else {
        part(recording, sweeps, 0)?;
    }
    let name = |word: Guarded| Guarded {
        recording: recording.name.clone(),
        ..word
    };
    Ok(words.into_iter().map(name).collect())
}

/// Returns the playback of a recording with these options.
fn playback<'a>(recording: &'a Recording, options: &Options) -> Result<Playback<'a>> {
    let mut playback = Playback::new(recording, &options.config)?;
    if let Some(mode) = options.motion {
        playback = playback.with_mode(mode);
    }
    if options.backwards {
        playback = playback.reversed();
    }
    if options.by_trigger {
        playback = playback.by_trigger();
    }
    Ok(playback)
}

/// Runs one scanner over `scans` scans or guard sweeps. `on_scan` is called with the sentences that
/// answer each.
fn run(
    recording: &Recording,
    options: &Options,
    playback: &Playback<'_>,
    scans: usize,
    mut on_scan: impl FnMut(&DataPathWithMotion, Vec<String>) -> Result<()>,
) -> Result<()> {
    let name = &recording.name;
    let guard = playback.kind() == Kind::Guard;
    let mut settings = playback.settings();
    let timetable = match playback.motion() {
        Some(source) => Some(Timetable::by_trigger(source)),
        None => MotionSentences::new(recording, options.motion_fault).map(Timetable::new),
    };
    let timetable = timetable.map(|table| Rc::new(RefCell::new(table)));
    if timetable.is_some() && !options.by_trigger {
        // The timetable contains the settling of the mirror.
        settings.timing.settle = SHORTEST_SETTLE_US;
    }
    let data = DataPathWithMotion {
        image: options.coherent.then(Box::default),
        pipeline: Box::new(Pipeline::with(options.numbers)),
        drive: Drive::STANDING,
        track: None,
    };
    let mut reports = Reports::new();
    let mut odometry = Odometry::new();
    let hardware = Hardware {
        mirror: SimShaft::default(),
        link: PlaybackLink::new(playback, timetable.clone()),
        port: Console::new(Inlet::new(timetable.clone())),
        board: Volatile::SCANNING,
    };
    let mut now = Micros(0);
    let mut scanner = Scanner::new(
        hardware,
        data,
        LentParts {
            reports: &mut reports,
            odometry: &mut odometry,
        },
        // The recording contains the mounting of its scanner.
        Some(settings),
        identity("host"),
        now,
    );
    settings.validate().map_err(|e| anyhow!("{name}: {e}"))?;
    if guard {
        scanner.port_mut().inlet.type_in(b"guard on\n");
    }
    let (mut done, mut commanded) = (0, 0);
    // About five steps a row; the limit is only for a scanner that never answers.
    let rows = usize::from(settings.config.sweep.angle_count) + 64;
    for _ in 0..64 * rows * scans {
        scanner.step(now);
        now = match &timetable {
            Some(table) => table.borrow_mut().step(now),
            None => now.plus(STEP_US),
        };
        let begun = if guard {
            scanner.sweeps()
        } else {
            scanner.scans()
        };
        if begun as usize > commanded {
            // Commands during a scan apply to the next one.
            let commands = playback.commands_after(commanded);
            scanner.port_mut().inlet.set(&commands);
            commanded += 1;
        }
        let sentences = scanner
            .port_mut()
            .take_scan()
            .with_context(|| name.clone())?;
        let Some(sentences) = sentences else {
            continue;
        };
        on_scan(scanner.data(), sentences)?;
        done += 1;
        if done == scans {
            return Ok(());
        }
    }
    bail!("{name}: the scanner gave no answer")
}

/// Time between two steps of the scanner without a timetable, µs; the mirror has settled by then.
const STEP_US: u32 = 10_000;
/// Minimum settling time of the mirror that can be set, µs.
pub const SHORTEST_SETTLE_US: u32 = 100;

/// The report port of the simulated scanner: typed input, and output read line by line.
#[derive(Default)]
pub struct Console {
    /// Motion sentences and commands that the scanner reads.
    pub inlet: Inlet,
    reader: Splitter,
    lines: VecDeque<String>,
    /// Sentences of the current answer, and the number of those that are still missing.
    scan: Vec<String>,
    to_come: u8,
}

impl BytePort for Console {
    fn read(&mut self) -> Option<u8> {
        self.inlet.read()
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        self.lines.extend(self.reader.push(bytes));
        bytes.len()
    }
}

impl Console {
    /// Creates a report port with the input `inlet`.
    pub fn new(inlet: Inlet) -> Self {
        Self {
            inlet,
            ..Self::default()
        }
    }

    /// Returns the sentences that answer a scan when all have been written; `None` until then.
    pub fn take_scan(&mut self) -> Result<Option<Vec<String>>> {
        while let Some(line) = self.lines.pop_front() {
            match Sentence::parse(&line)? {
                Sentence::Scan(head) => self.to_come = head.following(),
                Sentence::Step(_) | Sentence::Drop(_) | Sentence::Maybe(_) => {
                    self.to_come = self.to_come.saturating_sub(1);
                }
                Sentence::Guard(_) => return Ok(Some(vec![line])),
                Sentence::Fail { .. } => bail!("the scanner refuses a setting: {line}"),
                _ => continue,
            }
            self.scan.push(line);
            if self.to_come == 0 {
                return Ok(Some(std::mem::take(&mut self.scan)));
            }
        }
        Ok(None)
    }
}
