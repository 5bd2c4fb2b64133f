//! `faults --signs`: values of the health checks without faults. Their limits are chosen from these.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use anyhow::Result;
use rayon::prelude::*;
use stairscan::health::{CheckResult, Expected};
use stairscan::infer::Likelihood;
use stairscan::mount::{Calibration, GroundEvidence};
use stairscan::observer::{Event, Observer};
use stairscan::params::{Numbers, Params};
use stairscan::signal::echoes::Lobes;
use stairscan::verdict::Status;

use host_sim::inspect;
use host_sim::recording::Recording;
use host_sim::replay::{self, Options};

/// Quantiles, as fractions, of each health check's values that the table shows; 1 is the maximum.
const QUANTILES: [f64; 4] = [0.5, 0.95, 0.99, 1.0];

/// One health check's value in one scene, divided by the check's limit if that is positive, and whether the check
/// fails.
#[derive(Clone, Copy)]
struct CheckValue {
    value: f64,
    alarm: bool,
    /// Whether the scene's answer is `ok`, or would be without the reasons that failed health checks give.
    trusted: bool,
}

/// The estimator's parameters with the checks of ground, mounting and beam turned off.
const CHECKS_OFF: Params = Params {
    floor_elsewhere_nats: f32::MAX,
    calibration_strain: f32::MAX,
    beam_narrow: 0.0,
    beam_broad: f32::INFINITY,
    beam_broad_few: f32::INFINITY,
    ..Params::DEFAULT
};

/// Observer that keeps the results of the checks of ground, mounting and beam.
#[derive(Default)]
struct TraceObserver {
    floor: Option<GroundEvidence>,
    lobes: Option<Lobes>,
    calibration: Option<Calibration>,
}

impl Observer for TraceObserver {
    fn event(&mut self, event: Event<'_>) {
        match event {
            Event::Floor(floor) => self.floor = Some(floor),
            Event::Lobes(lobes) => self.lobes = Some(lobes),
            Event::Calibration(found) => self.calibration = Some(found),
            _ => {}
        }
    }
}

/// Returns name and value of every health check in the first scan of a recording.
fn of(recording: &Recording, options: &Options) -> Result<Vec<(String, CheckValue)>> {
    let first = Options {
        scans: Some(1),
        ..*options
    };
    let p = &Params::DEFAULT;
    let mut found = Vec::new();
    replay::answers(recording, &first, |scanned| {
        let (health, map) = (scanned.pipeline.health(), scanned.pipeline.map());
        let config = scanned.config;
        let mut witness = TraceObserver::default();
        let believing = Likelihood::with(Numbers::of(&CHECKS_OFF));
        let outcome = inspect::repeat_with(believing, scanned, &mut witness);
        let blind = health.fault(config.mount.mirror_offset > 0).is_some();
        let trusted = !blind && outcome.status() == Status::Ok;
        let mut add = |name: String, value: f64, alarm| {
            found.push((
                name,
                CheckValue {
                    value,
                    alarm,
                    trusted,
                },
            ));
        };
        health.report_checks(
            scanned.config,
            map,
            Expected::default(),
            &mut |sign: CheckResult| {
                let unit = f64::from(sign.limit.max(1));
                let value = f64::from(sign.value) / unit;
                add(
                    sign.reason.as_str().to_owned(),
                    value,
                    sign.value > sign.limit,
                );
            },
        );
        if let Some(floor) = witness.floor {
            let more = floor.other - floor.configured;
            let value = f64::from(more) / f64::from(p.floor_elsewhere_nats);
            add("mount, floor".to_owned(), value, !floor.in_place(p));
        }
        if let Some(found) = witness.calibration {
            let value = f64::from(found.chi_square) / f64::from(p.calibration_strain);
            add("mount, calibration".to_owned(), value, !found.fits(p));
        }
        if let Some(lobes) = witness.lobes {
            let [narrow, broad] = lobes.limits(p);
            let narrow = (1.0 - lobes.median) / (1.0 - narrow);
            let broad = (lobes.least - 1.0) / (broad - 1.0);
            let value = f64::from(narrow.max(broad));
            add("angle-jump, beam".to_owned(), value, !lobes.fit(p));
        }
    })?;
    Ok(found)
}

/// Returns the table of health checks: quantiles of their values, and numbers of failed checks, over all scenes and
/// over those with an `ok` answer.
pub fn table(recordings: &[Recording], options: &Options) -> Result<String> {
    let scenes: Vec<_> = recordings
        .par_iter()
        .map(|r| of(r, options))
        .collect::<Result<_>>()?;
    let mut checks: BTreeMap<String, Vec<CheckValue>> = BTreeMap::new();
    let mut doubted = 0;
    let mut trusted = 0;
    for scene in &scenes {
        let ok = scene.first().is_some_and(|(_, value)| value.trusted);
        trusted += u32::from(ok);
        doubted += u32::from(ok && scene.iter().any(|(_, value)| value.alarm));
        for (name, value) in scene {
            checks.entry(name.clone()).or_default().push(*value);
        }
    }
    let mut out = String::from(
        "| health check | scenes | median | 95 % | 99 % | maximum | failed | ok, 99 % | ok, maximum \
         | ok, failed |\n|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (name, scenes) in &checks {
        let values = |of: &dyn Fn(&CheckValue) -> bool| {
            let mut values: Vec<f64> = scenes.iter().filter(|s| of(s)).map(|s| s.value).collect();
            values.sort_by(f64::total_cmp);
            move |share: f64| {
                let place = (share * (values.len().saturating_sub(1)) as f64).ceil() as usize;
                values.get(place).copied().unwrap_or(0.0)
            }
        };
        let (all, ok) = (values(&|_| true), values(&|s| s.trusted));
        let _ = write!(out, "| {name} | {} |", scenes.len());
        for share in QUANTILES {
            let _ = write!(out, " {:.2} |", all(share));
        }
        let doubts = |trusted: bool| {
            scenes
                .iter()
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
        "\nValues relative to the limit. {trusted} of {} answers are ok, or would be without a \
         failed health check; {doubted} of them have a failed check.",
        scenes.len()
    );
    Ok(out)
}
