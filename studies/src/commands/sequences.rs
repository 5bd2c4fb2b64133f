//! `sequences`: measures the improvement of the answers from scan to scan while the chair moves, over
//! simulated sequences. With `--faults` it measures the effect of faults of the motion input, and with
//! `--fit` it fits the parameters of carrying evidence from scan to scan.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::ValueEnum;

use super::emit;
use crate::fit::sequences::{self, SequenceSamples};
use crate::harness;
use host_sim::answer::Answer;
use host_sim::emulate::image::workspace;
use host_sim::motion::Fault;
use host_sim::output::Overwrite;
use host_sim::random::Kind;
use host_sim::recording::{self, Recording};
use host_sim::replay::{self, Options};
use host_sim::scene::sequence::Approach;
use host_sim::score::{self, SceneScore, SetScore};
use host_sim::seeds::Draw;
use host_sim::simulation::{random_approach, random_drive};

/// Arguments of `sequences`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Draw of the scenes
    #[arg(long, value_enum, default_value_t)]
    draw: Draw,
    /// Number of approaches, and of drives
    #[arg(long, default_value_t = 100)]
    count: u64,
    /// Apply every fault of the motion sentences to `--count` sequences, alternately approaches and drives
    #[arg(long, conflicts_with = "fit")]
    faults: bool,
    /// Use the recordings of these directories in place of simulated sequences
    #[arg(long, value_name = "DIR", num_args = 1..)]
    on: Vec<PathBuf>,
    /// Fit hazards and correlations to sequences of tuning seeds, calibrate them on validation seeds, and write the
    /// firmware's table
    #[arg(long, conflicts_with = "draw")]
    fit: bool,
    /// With --fit and --on: the recordings for calibration
    #[arg(long, value_name = "DIR", num_args = 1.., requires = "on", requires = "fit")]
    calibrate_on: Vec<PathBuf>,
    /// Output file of --fit; without it the firmware's source, which takes --force
    #[arg(short, long, value_name = "FILE", requires = "fit")]
    output: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Motion of the chair in a sequence of scans.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    /// Stops for each scan: number of scans, distance between stops, metres.
    Stops(usize, f64),
    /// Drives during the scans: number of scans, speed, m/s, duration of a scan, s.
    Drives(usize, f64, f64),
}

/// Number of scans of a simulated sequence: `[0]` of an approach with stops, `[1]` of a drive.
const SCANS: [usize; 2] = [5, 4];
/// Distance between the stops of an approach, metres.
const STEP_M: f64 = 0.1;
/// Speeds of drives, m/s, each with the duration of a scan, s. With 5.7 s at the highest speed the stairs would be out
/// of sight at the beginning.
const DRIVES: [(f64, f64); 8] = [
    (0.05, 1.3),
    (0.05, 5.7),
    (0.1, 1.3),
    (0.1, 5.7),
    (0.2, 1.3),
    (0.15, 5.7),
    (0.3, 1.3),
    (0.5, 1.3),
];
/// Kinds of scenes that the simulated sequences use in turn: common stairs, and scenes without stairs. A more frequent
/// kind is listed repeatedly.
const KINDS: [Kind; 10] = [
    Kind::Ascending,
    Kind::Ascending,
    Kind::Ascending,
    Kind::Uneven,
    Kind::Uneven,
    Kind::None,
    Kind::Soft,
    Kind::Landing,
    Kind::Beside,
    Kind::Clutter,
];

/// A sequence to simulate or to read, with the sets of the table to which its scans belong.
struct Job {
    /// Name of the set of sequences; each scan belongs to the table's row with this name and the scan's number.
    set: String,
    /// Name of a further row of the table, to which all scans of the sequence belong; `None` if there is none.
    speed: Option<String>,
    source: Source,
}

enum Source {
    Drawn(Kind, u64, Way),
    Read(PathBuf),
}

impl Job {
    fn recording(&self) -> Result<Recording> {
        match &self.source {
            Source::Drawn(kind, seed, Way::Stops(scans, step)) => {
                let approach = Approach::new(*seed, *scans, *step);
                random_approach(*kind, kind.variety(), *seed, &approach)
            }
            Source::Drawn(kind, seed, Way::Drives(scans, speed, scan_s)) => {
                let way = (*scans, *speed, Some(*scan_s));
                random_drive(*kind, kind.variety(), *seed, way)
            }
            Source::Read(path) => Recording::read(path),
        }
    }
}

/// Returns for each of `count` seeds an approach and a drive, and for every third seed also a sequence at standstill.
fn jobs(draw: Draw, count: u64) -> Vec<Job> {
    let mut jobs = Vec::new();
    let seeds = draw.seeds().start..draw.seeds().start + count;
    for (k, seed) in seeds.enumerate() {
        let kind = KINDS[k % KINDS.len()];
        let mut add = |set: &str, speed, way| {
            let source = Source::Drawn(kind, seed, way);
            let set = set.into();
            jobs.push(Job { set, speed, source });
        };
        add("approach", None, Way::Stops(SCANS[0], STEP_M));
        if k % 3 == 0 {
            add("standing", None, Way::Stops(SCANS[0], 0.0));
        }
        let (speed, scan_s) = DRIVES[(k / KINDS.len() + k) % DRIVES.len()];
        let row = Some(format!("{speed} m/s, {scan_s} s"));
        add("drive", row, Way::Drives(SCANS[1], speed, scan_s));
    }
    jobs
}

fn read(directories: &[PathBuf]) -> Result<Vec<Job>> {
    let mut jobs = Vec::new();
    for directory in directories {
        let set = directory.file_name().unwrap_or_default().to_string_lossy();
        for path in recording::list(directory)? {
            jobs.push(Job {
                set: set.clone().into_owned(),
                speed: None,
                source: Source::Read(path),
            });
        }
    }
    Ok(jobs)
}

/// Applies `make` to each sequence in parallel; returns the results in order.
fn in_parallel<R: Send>(
    jobs: &[Job],
    make: impl Fn(&Job, &Recording) -> Result<R> + Send + Sync,
) -> Result<Vec<R>> {
    harness::each(jobs, |job| make(job, &job.recording()?))
}

/// Fits the table of combined scans, or measures the answers to sequences, and prints the result.
pub fn run(args: &Args) -> Result<ExitCode> {
    if args.fit {
        return fit(args);
    }
    let jobs = match args.on.is_empty() {
        true => jobs(args.draw, args.count),
        false => read(&args.on)?,
    };
    if args.faults {
        return faults(jobs, args.count);
    }
    let scored = in_parallel(&jobs, |_, recording| scores(recording))?;
    let mut out = String::new();
    for single in [false, true] {
        let _ = writeln!(
            out,
            "{}\n",
            match single {
                false => "each scan with the evidence of earlier scans",
                true => "each scan by itself",
            }
        );
        let mut sets: Vec<(String, Vec<SceneScore>)> = Vec::new();
        for (job, [fused, alone]) in jobs.iter().zip(&scored) {
            let scores = if single { alone } else { fused };
            for (k, score) in scores.iter().enumerate() {
                let by_scan = Some(format!("{}, scan {}", job.set, k + 1));
                for name in by_scan.into_iter().chain(job.speed.clone()) {
                    match sets.iter_mut().find(|(set, _)| *set == name) {
                        Some((_, scores)) => scores.push(score.clone()),
                        None => sets.push((name, vec![score.clone()])),
                    }
                }
            }
        }
        sets.sort_by(|a, b| a.0.cmp(&b.0));
        let mut sets: Vec<SetScore> = sets
            .iter()
            .map(|(name, scores)| SetScore::new(name, scores.iter()))
            .collect();
        let all = scored.iter().flat_map(|s| s[usize::from(single)].iter());
        sets.push(SetScore::new("all", all));
        out.push_str(&score::table(&sets));
        out.push('\n');
    }
    emit(&out);
    Ok(ExitCode::SUCCESS)
}

/// Scores the scans of a recording twice: with the evidence of earlier scans, then each by itself.
fn scores(recording: &Recording) -> Result<[Vec<SceneScore>; 2]> {
    let judge = |single: bool| {
        let options = Options {
            single,
            ..Options::default()
        };
        judged(recording, &options)
    };
    Ok([judge(false)?, judge(true)?])
}

/// Scores the scans of a recording in their order, each against its own ground truth.
fn judged(recording: &Recording, options: &Options) -> Result<Vec<SceneScore>> {
    let answers: Vec<Answer> = replay::answers(recording, options, |_| ())?;
    let pairs = answers.iter().zip(&recording.meta.sequence.truth);
    Ok(pairs.map(|(a, t)| score::scene(a, t)).collect())
}

/// Scores `count` of the sequences in which the chair moves, with each fault of the motion input and without any, and
/// prints the table.
fn faults(jobs: Vec<Job>, count: u64) -> Result<ExitCode> {
    let moves =
        |job: &Job| !matches!(job.source, Source::Drawn(_, _, Way::Stops(_, step)) if step == 0.0);
    let moving = jobs.into_iter().filter(moves);
    // Each seed has an approach and a drive: alternately one of them is used. All recordings are used.
    let some = |(k, job): (usize, Job)| {
        let read = matches!(job.source, Source::Read(_));
        (read || k % 4 == 0 || k % 4 == 3).then_some(job)
    };
    let mut chosen: Vec<Job> = moving.enumerate().filter_map(some).collect();
    chosen.truncate(count as usize);
    let kinds: Vec<Option<Fault>> = std::iter::once(None)
        .chain(Fault::value_variants().iter().copied().map(Some))
        .collect();
    let judged = in_parallel(&chosen, |_, recording| {
        let with = |motion_fault: &Option<Fault>| {
            let options = Options {
                motion_fault: *motion_fault,
                ..Options::default()
            };
            judged(recording, &options)
        };
        kinds.iter().map(with).collect::<Result<Vec<_>>>()
    })?;
    let name = |fault: &Option<Fault>| {
        let value = fault.as_ref().and_then(ValueEnum::to_possible_value);
        value.map_or("none".into(), |v| v.get_name().to_owned())
    };
    let set = |(k, fault): (usize, &Option<Fault>)| {
        let scores = judged.iter().flat_map(|runs| runs[k].iter());
        SetScore::new(&name(fault), scores)
    };
    let mut sets: Vec<SetScore> = kinds.iter().enumerate().map(set).collect();
    let faulty = judged.iter().flat_map(|runs| runs[1..].iter().flatten());
    sets.push(SetScore::new("all faults", faulty));
    let runs = chosen.len() * (kinds.len() - 1);
    emit(&format!(
        "{} sequences, each with every fault: {runs} runs\n\n{}",
        chosen.len(),
        score::table(&sets)
    ));
    Ok(ExitCode::SUCCESS)
}

/// Fits hazards and correlations for combining scans, prints the fit, and writes the firmware's table.
fn fit(args: &Args) -> Result<ExitCode> {
    let path = match &args.output {
        Some(path) => path.clone(),
        None => workspace().join("src/params/counted.rs"),
    };
    let outputs = args.overwrite.reading::<&PathBuf>([]);
    outputs.check(&path)?;
    let parts = match args.on.is_empty() {
        true => [
            jobs(Draw::Tuning, args.count),
            jobs(Draw::Validation, args.count),
        ],
        false => [read(&args.on)?, read(&args.calibrate_on)?],
    };
    let mut sequence_samples = Vec::new();
    for jobs in &parts {
        let each = in_parallel(jobs, |_, recording| sequences::sequence_samples(recording))?;
        let mut all = SequenceSamples::default();
        for one in each {
            all.samples.extend(one.samples);
            all.pairs.extend(one.pairs);
        }
        sequence_samples.push(all);
    }
    let [training, calibration] = &sequence_samples[..] else {
        return Ok(ExitCode::FAILURE);
    };
    let correlations = sequences::correlations(&training.pairs);
    let counted = sequences::count(&training.samples, &calibration.samples);
    emit(&format!(
        "places, levels: {correlations:?} of {} pairs\n{}",
        training.pairs.len(),
        counted.log
    ));
    let text = sequences::write(&counted.table, &correlations);
    outputs.write(&path, text.as_bytes())?;
    emit(&format!("written\n  {}\n", path.display()));
    Ok(ExitCode::SUCCESS)
}
