//! `bench`: counts the instructions of every stage in the emulator.

use std::fmt::Write as _;
use std::mem::offset_of;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result, anyhow, ensure};
use bench_image::header;
use serde_json::json;
use stairscan::config::Config;
use stairscan::params::{Params, Rules};
use stairscan::scanner::Settings;

use super::{Format, emit};
use crate::images;
use host_sim::budgets::{CHIRP, CHIRP_REAL, FFT256, FLASH, GUARD, POST, RAM};
use host_sim::emulate::image::{self, Image};
use host_sim::recording::{self, META_SUFFIX, Recording};
use host_sim::setup;

/// Arguments of `bench`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Recordings to scan for the worst case [default: those of the repository]
    recordings: Vec<PathBuf>,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Stages with the maximum number of instructions that each may take.
const BUDGETS: [(&str, u64); 5] = [
    ("fft256", FFT256),
    ("chirp", CHIRP),
    ("chirp_real", CHIRP_REAL),
    ("post", POST),
    ("guard", GUARD),
];

/// Stages with the descriptions that the table prints.
const MEANING: [(&str, &str); 16] = [
    (
        "fft256",
        "transform of 256 complex points, 16-bit block floating point",
    ),
    ("microfft_f32", "the same by microfft, f32"),
    ("levels", "chirp pass 1: mean, extremes"),
    (
        "window",
        "chirp pass 2: DC removal, window, first radix-4 stage",
    ),
    ("stages", "the other stages, into power"),
    ("cells", "logarithms"),
    ("cfar", "CA-CFAR"),
    (
        "chirp",
        "200 samples to finished map row, health included, worst row of all recordings",
    ),
    (
        "chirp_real",
        "400 real samples to finished map row, health not included",
    ),
    ("row", "chirp and the estimator's part, worst row"),
    (
        "post",
        "last row to last byte of the report, worst recording",
    ),
    (
        POST_STAGES[0],
        "of these: noise, echoes separated from side lobes and ghosts, positions",
    ),
    (
        POST_STAGES[1],
        "calibration, search for the best flight and its runners-up",
    ),
    (POST_STAGES[2], "dimensions, sigmas, status"),
    (POST_STAGES[3], "sentences"),
    (
        "guard",
        "last row of a guard sweep to its sentence, health included, worst sweep",
    ),
];

/// Stages of the processing after the last row, in the image's order of output.
const POST_STAGES: [&str; 4] = [
    "post/echoes",
    "post/search",
    "post/dimensions",
    "post/report",
];

/// Published numbers of instructions of other libraries for comparable stages: gcc 12 -O3, counted on the same
/// emulator.
const QUOTED: [(&str, u64); 5] = [
    ("CMSIS-DSP arm_cfft_q15, 256 points", 12_375),
    ("CMSIS-DSP arm_cfft_q31, 256 points", 21_755),
    ("CMSIS-DSP arm_cfft_f32, 256 points", 18_458),
    ("CMSIS-DSP arm_cmplx_mag_squared_q15, 256 points", 1_541),
    ("CMSIS-DSP arm_cmplx_mag_q15, 256 points", 16_017),
];

/// Name and number of instructions of each stage, followed by one `post/NAME` for each recording.
type Counts = Vec<(String, u64)>;

/// Numbers of instructions that one scan takes: for the worst chirp, for the worst row, and after the last row.
struct Scan {
    chirp: u64,
    row: u64,
    post: u64,
    /// Numbers of instructions of the stages [`POST_STAGES`], in their order.
    stages: Vec<u64>,
}

/// Counts the instructions of every stage and prints them; exit status 1 if one exceeds its budget.
pub fn run(args: &Args) -> Result<ExitCode> {
    let recordings = if args.recordings.is_empty() {
        recording::list(&image::workspace().join("recordings"))?
    } else {
        args.recordings.clone()
    };
    let counts = count(&recordings)?;
    let size = Image::read(&image::build(&[])?)?;
    match args.format {
        Format::Text => emit(&table(&counts, &size)),
        Format::Json => {
            let entry =
                |(stage, instructions)| json!({"stage": stage, "instructions": instructions});
            let array: Vec<_> = counts.iter().map(|(s, n)| (s, n)).map(entry).collect();
            emit(&format!("{}\n", json!(array)));
        }
    }
    let above = above_budget(&counts, &size);
    for line in &above {
        host_sim::note!("error: {line}");
    }
    Ok(ExitCode::from(u8::from(!above.is_empty())))
}

/// Returns the maximum number of instructions from the last row to the finished report, over all scans of the
/// recordings.
pub(super) fn worst_post(recordings: &[PathBuf]) -> Result<u64> {
    let counts = count(recordings)?;
    let post = counts.iter().find(|(stage, _)| stage == "post");
    post.map(|(_, n)| *n)
        .context("the bench image printed no `post`")
}

/// Runs the bench image over the recordings, and returns the instructions of every stage.
fn count(recordings: &[PathBuf]) -> Result<Counts> {
    let read = recordings.iter().map(|path| Recording::read(path));
    let read: Vec<Recording> = read.collect::<Result<_>>()?;
    let bench = Bench::new(&read, &[])?;
    let (counts, scans) = read_output(&bench.run(&bench.elf)?, bench.count)?;
    Ok(summed(counts, &scans, &bench.names))
}

/// The bench image as built, with the scans that it reads.
struct Bench {
    elf: PathBuf,
    scans: Vec<u8>,
    /// Names of the scans in their order; guard sweeps have none.
    names: Vec<String>,
    /// Number of scans, including guard sweeps.
    count: usize,
}

impl Bench {
    /// Encodes all scans of the recordings, then builds the image. A scan that the image could not process is an error
    /// here, because the image cannot report it.
    fn new(recordings: &[Recording], features: &[&str]) -> Result<Self> {
        let (mut scans, mut names, mut count) = (Vec::new(), Vec::new(), 0);
        for recording in recordings {
            for scan in 0..recording.scans() {
                let config = append(&mut scans, recording, scan)?;
                count += 1;
                if config.sweep.angle_count > header::MAX_SWEEP_ROWS {
                    names.push(recording.scan(scan).name);
                }
            }
        }
        let elf = image::build_bin("bench-image", "stages", features)?;
        Ok(Self {
            elf,
            scans,
            names,
            count,
        })
    }

    /// Runs `elf`, the image or a patched copy of it, over the scans, and returns its output.
    fn run(&self, elf: &Path) -> Result<String> {
        let directory = elf.with_extension("run");
        std::fs::create_dir_all(&directory).with_context(|| directory.display().to_string())?;
        recording::write_whole(&directory.join("scans"), &self.scans)?;
        images::run(elf, &directory, Duration::from_secs(600))
    }
}

/// Counts the instructions of an image whose parameters the host replaces.
pub(super) struct Cost(Bench);

impl Cost {
    /// Builds the image for all scans of these recordings.
    pub(super) fn new(recordings: &[Recording]) -> Result<Self> {
        Bench::new(recordings, &["ablation"]).map(Self)
    }

    /// Returns the instructions from the last row to the last byte of the report for each scan, with these
    /// parameters.
    pub(super) fn post(&self, params: &Params) -> Result<Vec<u64>> {
        let Self(bench) = self;
        let elf = bench.elf.with_extension("ablated");
        let variable = (&["patched", "NUMBERS"][..], size_of::<Params>());
        image::patch(&bench.elf, &elf, variable, |bytes| {
            for number in Params::TABLE {
                let value = (number.get)(params).to_le_bytes();
                bytes[number.offset..][..value.len()].copy_from_slice(&value);
            }
            for switch in Rules::SWITCHES {
                let at = offset_of!(Params, rules) + switch.offset;
                bytes[at] = u8::from((switch.is_on)(&params.rules));
            }
        })?;
        let (_, scans) = read_output(&bench.run(&elf)?, bench.count)?;
        Ok(scans.iter().map(|scan| scan.post).collect())
    }
}

/// Appends scan `scan` of a recording to `scans` in the bench image's input format, and returns its configuration.
fn append(scans: &mut Vec<u8>, recording: &Recording, scan: usize) -> Result<Config> {
    let (config, schedule) = setup::config(recording, scan, &Config::default())?;
    let settings = Settings {
        config,
        ..Settings::default()
    };
    settings
        .validate()
        .map_err(|e| anyhow!("{}.{META_SUFFIX}: {e}", recording.name))?;
    ensure!(
        config.sweep.angle_step < 1 << 16,
        "{}: angles too far apart",
        recording.name
    );
    scans.extend(header::encode(&config));
    for slot in schedule.chirps {
        let chirp = slot
            .and_then(|k| recording.chirp(k))
            .ok_or_else(|| anyhow!("{}: a chirp is missing", recording.name))?;
        for x in chirp {
            scans.extend(x.i.to_le_bytes());
            scans.extend(x.q.to_le_bytes());
        }
    }
    Ok(config)
}

/// Parses the image's output for `scans` scans: `STAGE COUNT` lines; for each scan a line `scan CHIRP ROW POST`,
/// followed by the counts of the stages after the last row, or `sweep COUNT` for a guard sweep, of which the maximum is
/// used.
fn read_output(output: &str, scans: usize) -> Result<(Counts, Vec<Scan>)> {
    let (mut counts, mut read, mut sweeps) = (Counts::new(), Vec::new(), Vec::new());
    for line in output.lines() {
        let mut words = line.split_whitespace();
        let name = words.next().unwrap_or_default();
        let numbers: Vec<u64> = words.map_while(|w| w.parse().ok()).collect();
        match (name, &numbers[..]) {
            ("scan", &[chirp, row, post, ref stages @ ..]) if stages.len() == POST_STAGES.len() => {
                let stages = stages.to_vec();
                read.push(Scan {
                    chirp,
                    row,
                    post,
                    stages,
                });
            }
            ("sweep", &[number]) => sweeps.push(number),
            (_, &[number]) => counts.push((name.to_owned(), number)),
            _ => return Err(anyhow!("the bench image printed `{line}`")),
        }
    }
    ensure!(
        read.len() + sweeps.len() == scans && counts.iter().any(|(s, _)| s == "fft256"),
        "the bench image stopped early:\n{output}"
    );
    if let Some(worst) = sweeps.into_iter().max() {
        counts.push(("guard".to_owned(), worst));
    }
    Ok((counts, read))
}

/// Returns the instruction counts of single stages, with the maximum over all scans added, and the count after the last
/// row for each scan.
fn summed(mut counts: Counts, scans: &[Scan], names: &[String]) -> Counts {
    let worst = |part: fn(&Scan) -> u64| scans.iter().map(part).max().unwrap_or(0);
    if let Some((_, chirp)) = counts.iter_mut().find(|(s, _)| s == "chirp") {
        *chirp = worst(|s| s.chirp).max(*chirp);
    }
    counts.push(("row".to_owned(), worst(|s| s.row)));
    counts.push(("post".to_owned(), worst(|s| s.post)));
    if let Some(scan) = scans.iter().max_by_key(|s| s.post) {
        let stages = POST_STAGES.iter().zip(&scan.stages);
        counts.extend(stages.map(|(name, &count)| ((*name).to_owned(), count)));
    }
    let each = names.iter().zip(scans);
    counts.extend(each.map(|(name, scan)| (format!("post/{name}"), scan.post)));
    counts
}

/// Returns one message for each stage whose instructions, and each kind of memory whose size, exceed the budget; empty
/// if all are within it.
fn above_budget(counts: &Counts, size: &Image) -> Vec<String> {
    let mut above = Vec::new();
    for (stage, most) in BUDGETS {
        for (_, n) in counts.iter().filter(|(s, n)| s == stage && *n > most) {
            above.push(format!("{stage}: {n} instructions, at most {most} allowed"));
        }
    }
    for (what, bytes, most) in [("flash", size.flash, FLASH), ("static RAM", size.ram, RAM)] {
        if bytes > most {
            above.push(format!("{what}: {bytes} bytes, at most {most} allowed"));
        }
    }
    above
}

/// Returns the counts of the stages and the sizes of the image's sections as a table of text.
fn table(counts: &Counts, size: &Image) -> String {
    let mut text = String::from("stage               instructions   at most\n");
    for (stage, count) in counts {
        let most = BUDGETS.iter().find(|(s, _)| s == stage);
        let most = most.map_or(String::new(), |(_, n)| n.to_string());
        let meaning = MEANING.iter().find(|(s, _)| s == stage).map_or("", |m| m.1);
        let _ = writeln!(text, "{stage:<20}{count:>12}{most:>10}   {meaning}");
    }
    text.push_str("\nquoted figures of other libraries, gcc 12 -O3 on the same emulator\n");
    for (peer, count) in QUOTED {
        let _ = writeln!(text, "{count:>32}             {peer}");
    }
    text.push_str("\nsection                    bytes\n");
    for (section, bytes) in &size.sections {
        let _ = writeln!(text, "{section:<20}{bytes:>12}");
    }
    let _ = writeln!(text, "{:<20}{:>12}{FLASH:>10}", "flash", size.flash);
    let _ = writeln!(text, "{:<20}{:>12}{RAM:>10}", "static RAM", size.ram);
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_scan_counts() {
        let names = ["a".to_owned(), "b".to_owned()];
        let (counts, scans) = read_output(
            "fft256 9\nchirp 20\nscan 21 30 40 1 2 3 4\nscan 19 35 39 4 3 2 1\n",
            names.len(),
        )
        .unwrap();
        let counts = summed(counts, &scans, &names);
        let of = |stage: &str| counts.iter().find(|(s, _)| s == stage).unwrap().1;
        assert_eq!(
            (of("chirp"), of("row"), of("post"), of("post/b")),
            (21, 35, 40, 39)
        );
        assert_eq!(
            (of("post/echoes"), of("post/report")),
            (1, 4),
            "the worst's"
        );
        let refused = |output: &str| read_output(output, names.len()).is_err();
        assert!(refused("fft256 9\nscan 1 2 3 4 5 6 7\n"));
        assert!(refused("fft256 9\nscan 1 2 3\nscan 1 2 3\n"));
        assert!(refused("qemu: fatal\n"));
    }
}
