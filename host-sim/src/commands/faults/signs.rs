//! `faults --signs`: values of the health checks without faults. Their limits are chosen from these.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use anyhow::Result;
use rayon::prelude::*;
use stairscan::health::{Expected, Sign};
use stairscan::infer::Likelihood;
use stairscan::mount::{Calibration, Floor};
use stairscan::observer::{Event, Observer};
use stairscan::params::Params;
use stairscan::signal::echoes::Lobes;
use stairscan::verdict::Status;

use crate::inspect;
use crate::recording::Recording;
use crate::replay::{self, Options};

/// Quantiles in the table.
const QUANTILES: [f64; 4] = [0.5, 0.95, 0.99, 1.0];

/// One health check's value in one scene, relative to the limit if that is positive.
#[derive(Clone, Copy)]
struct Seen {
    value: f64,
    alarm: bool,
    /// Whether the answer is `ok`, or would be without the reasons of the instrument.
    trusted: bool,
}

/// The estimator's parameters with the checks of ground, mounting and beam turned off.
const BELIEVING: Params = Params {
    floor_elsewhere: f32::MAX,
    floor_alone: f32::MAX,
    calibration_strain: f32::MAX,
    beam_narrow: 0.0,
    beam_broad: f32::INFINITY,
    beam_broad_few: f32::INFINITY,
    ..Params::DEFAULT
};

/// Observer of the checks of ground, mounting and beam.
#[derive(Default)]
struct Witness {
    floor: Option<Floor>,
    lobes: Option<Lobes>,
    calibration: Option<Calibration>,
}

impl Observer for Witness {
    fn event(&mut self, event: Event<'_>) {
        match event {
            Event::Floor(floor) => self.floor = Some(floor),
            Event::Lobes(lobes) => self.lobes = Some(lobes),
            Event::Calibration(found) => self.calibration = Some(found),
            _ => {}
        }
    }
}

/// Returns all values of one scene.
fn of(recording: &Recording, options: &Options) -> Result<Vec<(String, Seen)>> {
    let first = Options {
        scans: Some(1),
        ..*options
    };
    let p = &Params::DEFAULT;
    let mut found = Vec::new();
    replay::answers(recording, &first, |scanned| {
        let (health, map) = (scanned.pipeline.health(), scanned.pipeline.map());
        let (config, scan) = (scanned.config, scanned.answer.scan.scan);
        let mut seen = Witness::default();
        let believing = Likelihood::with(&BELIEVING);
        let drive = &scanned.drive;
        let outcome = inspect::repeat_with(believing, map, config, scan, drive, &mut seen);
        let blind = health.verdict(config.mount.mirror_offset > 0).is_some();
        let trusted = !blind && outcome.status() == Status::Ok;
        let mut add = |name: String, value: f64, alarm| {
            found.push((
                name,
                Seen {
                    value,
                    alarm,
                    trusted,
                },
            ));
        };
        health.signs(
            scanned.config,
            map,
            Expected::default(),
            &mut |sign: Sign| {
                let unit = f64::from(sign.limit.max(1));
                let value = f64::from(sign.seen) / unit;
                add(
                    sign.reason.as_str().to_owned(),
                    value,
                    sign.seen > sign.limit,
                );
            },
        );
        if let Some(floor) = seen.floor {
            let more = floor.elsewhere - floor.here;
            let value = f64::from(more) / f64::from(p.floor_elsewhere);
            add("mount, floor".to_owned(), value, !floor.in_place(p));
        }
        if let Some(found) = seen.calibration {
            let value = f64::from(found.strain) / f64::from(p.calibration_strain);
            add("mount, calibration".to_owned(), value, !found.fits(p));
        }
        if let Some(lobes) = seen.lobes {
            let [narrow, broad] = lobes.limits(p);
            let narrow = (1.0 - lobes.median) / (1.0 - narrow);
            let broad = (lobes.least - 1.0) / (broad - 1.0);
            let value = f64::from(narrow.max(broad));
            add("angle-jump, beam".to_owned(), value, !lobes.fit(p));
        }
    })?;
    Ok(found)
}

/// Returns the text table.
pub fn table(recordings: &[Recording], options: &Options) -> Result<String> {
    let scenes: Vec<_> = recordings
        .par_iter()
        .map(|r| of(r, options))
        .collect::<Result<_>>()?;
    let mut signs: BTreeMap<String, Vec<Seen>> = BTreeMap::new();
    let mut doubted = 0;
    let mut trusted = 0;
    for scene in &scenes {
        let ok = scene.first().is_some_and(|(_, seen)| seen.trusted);
        trusted += u32::from(ok);
        doubted += u32::from(ok && scene.iter().any(|(_, seen)| seen.alarm));
        for (name, seen) in scene {
            signs.entry(name.clone()).or_default().push(*seen);
        }
    }
    let mut out = String::from(
        "| sign | scenes | median | 95 % | 99 % | most | doubted | ok, 99 % | ok, most | ok, doubted |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (name, seen) in &signs {
        let values = |of: &dyn Fn(&Seen) -> bool| {
            let mut values: Vec<f64> = seen.iter().filter(|s| of(s)).map(|s| s.value).collect();
            values.sort_by(f64::total_cmp);
            move |share: f64| {
                let place = (share * (values.len().saturating_sub(1)) as f64).ceil() as usize;
                values.get(place).copied().unwrap_or(0.0)
            }
        };
        let (all, ok) = (values(&|_| true), values(&|s| s.trusted));
        let _ = write!(out, "| {name} | {} |", seen.len());
        for share in QUANTILES {
            let _ = write!(out, " {:.2} |", all(share));
        }
        let doubts = |trusted: bool| {
            seen.iter()
                .filter(|s| s.alarm && (s.trusted || !trusted))
                .count()
        };
        let _ = writeln!(
            out,
            " {} | {:.2} | {:.2} | {} |",
            doubts(false),
            ok(0.99),
            ok(1.0),
            doubts(true)
        );
    }
    let _ = writeln!(
        out,
        "\nShares of the limit. {trusted} of {} answers are ok or would be but for a doubt, {doubted} of \
         them are doubted.",
        scenes.len()
    );
    Ok(out)
}
