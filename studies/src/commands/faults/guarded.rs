//! Applies every fault of the instrument to guard sweeps that are correct without it.
//!
//! A fault is drawn once for a recording and applied to each of its sweeps in the same way.

use std::path::Path;

use anyhow::{Context, Result};
use stairscan::verdict::Status;

use super::fate::{Clean, Fate, Run, SEEDS};
use crate::faults::Fault;
use crate::harness;
use host_sim::guarded::Guarded;
use host_sim::recording::{self, Recording};
use host_sim::replay::{self, Options};
use host_sim::seeds::Draw;
use host_sim::setup::{self, Kind as Scans};
use host_sim::sweeps::scenes::{self, Kind};
use host_sim::sweeps::score::{self, GuardAnswer, Scored};
use host_sim::sweeps::{ground, truth};

/// Returns the recordings of guard sweeps to which faults may be applied: `scenes` simulated ones of each kind, or
/// those in a directory.
fn whole(on: Option<&Path>, (draw, scenes): (Draw, u64)) -> Result<Vec<Recording>> {
    if let Some(dir) = on {
        let read = |path| Recording::read(path);
        let all: Vec<Recording> = recording::list(dir)?
            .iter()
            .map(|path| read(path))
            .collect::<Result<_>>()?;
        let guard = |r: &Recording| setup::kind(r).is_ok_and(|kind| kind == Scans::Guard);
        return Ok(all.into_iter().filter(guard).collect());
    }
    let of = |kind: Kind| {
        let seeds = kind.seeds(draw).take(scenes as usize);
        seeds.map(move |seed| (kind, seed)).collect::<Vec<_>>()
    };
    let jobs: Vec<(Kind, u64)> = Kind::ALL.into_iter().flat_map(of).collect();
    harness::each(&jobs, |(kind, seed)| scenes::recording(*kind, *seed))
}

/// Scores the answers to a recording's guard sweeps against its ground truth.
fn scored(recording: &Recording, words: &[Guarded]) -> Result<Scored> {
    let truth = truth::read(recording)?.unwrap_or_default();
    let words: Vec<GuardAnswer> = words.iter().map(GuardAnswer::of).collect();
    let ground_echo_range_m = ground::of(recording)?;
    Ok(score::recording(
        &recording.name,
        &words,
        &truth,
        &ground_echo_range_m,
    ))
}

/// Returns the recordings whose sweeps are `ok` at least once and never wrong.
pub fn clean(on: Option<&Path>, scenes: (Draw, u64), options: &Options) -> Result<Clean> {
    let whole = whole(on, scenes)?;
    let judged = harness::each(&whole, |recording| {
        let found = scored(recording, &replay::guarded(recording, options)?)?;
        let ok = found.sweeps.iter().any(score::Sweep::ok);
        Ok((
            ok,
            ok && !found.sweeps.iter().any(score::Sweep::free_beyond_hazard),
        ))
    })?;
    let (all, ok) = (whole.len(), judged.iter().filter(|(ok, _)| *ok).count());
    let right = whole
        .into_iter()
        .zip(&judged)
        .filter(|(_, (_, right))| *right);
    let recordings: Vec<Recording> = right.map(|(recording, _)| recording).collect();
    Ok(Clean {
        mirror_echoes: vec![0; recordings.len()],
        recordings,
        ok,
        all,
    })
}

/// Applies one fault to each sweep of a recording. Returns the outcome of every sweep from the third on; none if the
/// fault cannot be applied to guard sweeps.
pub fn one(
    (fault, strength): (&Fault, f64),
    recording: &Recording,
    number: usize,
    options: &Options,
) -> Result<Vec<Run>> {
    let Some(faulty) = on(fault, strength, recording, SEEDS + number as u64)? else {
        return Ok(Vec::new());
    };
    let context = || format!("{} {strength} on {}", fault.name, recording.name);
    let words = replay::guarded(&faulty, options).with_context(context)?;
    let found = scored(&faulty, &words)?;
    let run = |sweep: &score::Sweep| {
        let word = &words[sweep.number - 1].line;
        let named = fault.reasons.iter().any(|reason| word.reasons.has(*reason));
        let fate = match (sweep.answer.status, sweep.free_beyond_hazard()) {
            (Status::Fault, _) => Fate::Fault,
            (Status::Degraded, _) if named => Fate::Named,
            (Status::Degraded, _) => Fate::Unnamed,
            (Status::Ok, true) => Fate::Wrong,
            (Status::Ok, false) => Fate::Right,
        };
        let words = format!("{} {strength} {}: {}", fault.name, fault.unit, sweep.text());
        Run { fate, named, words }
    };
    Ok(found.sweeps.iter().map(run).collect())
}

/// Returns the recording with the same fault applied to each of its sweeps; `None` if the fault removes rows or shifts
/// some of them against the others, since the scanner would then guard with its own angles.
fn on(fault: &Fault, strength: f64, recording: &Recording, seed: u64) -> Result<Option<Recording>> {
    let mut faulty = recording.clone();
    faulty.samples.clear();
    faulty.meta.angles_deg.clear();
    for sweep in 0..recording.scans() {
        let clean = recording.scan(sweep);
        let one = fault.on(&clean, strength, seed)?;
        let (angles, clean) = (&one.meta.angles_deg, &clean.meta.angles_deg);
        let mut off = angles.iter().zip(clean).map(|(a, b)| a - b);
        let first = off.next().unwrap_or_default();
        if angles.len() != clean.len() || off.any(|off| (off - first).abs() > 1e-9) {
            return Ok(None);
        }
        faulty.meta.angles_deg.extend(angles);
        faulty.samples.extend_from_slice(&one.samples);
        // A fault of the mounting is in the metadata, for all sweeps.
        faulty.meta.mirror.clone_from(&one.meta.mirror);
        faulty.meta.bandwidth_hz = one.meta.bandwidth_hz;
    }
    Ok(Some(faulty))
}
