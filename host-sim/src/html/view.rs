//! What a page shows of a recording.

use anyhow::Result;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use stairscan::answer::Status;
use stairscan::config::{EstimatorKind, Plane};
use stairscan::grid::{DB_PER_UNIT, PolarMap};
use stairscan::range::FULL_SCALE;
use stairscan::scan::Settings;

use super::index::{Entry, Rank};
use crate::answer::Answer;
use crate::inspect::Inspection;
use crate::playback::Playback;
use crate::recording::{Recording, TrueStep, Truth};
use crate::replay::{self, Options, Scanned};
use crate::score;

/// A recording that could not be read or scanned, and why.
pub fn failed(name: &str, why: &str) -> Entry {
    Entry {
        data: json!({"name": name, "error": why, "scans": []}),
        rank: Rank::Unreadable,
    }
}

/// A recording with its scans, each as the scanner answers it.
///
/// # Errors
/// Names what in the recording no scan can be made of.
pub fn entry(recording: &Recording, options: &Options) -> Result<Entry> {
    let settings = Playback::new(recording, &options.config)?.settings();
    let mut scans = Vec::new();
    replay::answers(recording, options, |scanned| scans.push(scan(scanned)))?;
    let worst = scans.iter().map(|(_, rank)| *rank).min();
    let rank = worst.unwrap_or(Rank::Unreadable);
    let values: Vec<Value> = Settings::KEYS
        .iter()
        .filter_map(|key| Some(json!([key, settings.get(key)?.as_str()])))
        .collect();
    let scans: Vec<Value> = scans.into_iter().map(|(value, _)| value).collect();
    let meta = &recording.meta;
    Ok(Entry {
        data: json!({
            "name": recording.name,
            "description": meta.description,
            "disturbance": meta.disturbance.as_ref().map(|d| d.kind.clone()),
            "settings": values,
            "scans": scans,
        }),
        rank,
    })
}

/// One scan, and how bad it is.
fn scan(scanned: &Scanned<'_>) -> (Value, Rank) {
    let answer = scanned.answer;
    let alone = scanned.recording();
    let truth = alone.meta.truth.as_ref();
    let map = scanned.pipeline.map();
    let config = scanned.config;
    let inspected = (config.estimator == EstimatorKind::Likelihood && !answer.is_fault())
        .then(|| Inspection::of(map, config, answer.scan.scan, &scanned.drive));
    let verdict = truth.map(|truth| score::scene(answer, truth));
    let rank = rank(answer, verdict.as_ref().map(|v| v.wrong));
    let reasons: Vec<Value> = answer
        .scan
        .reasons
        .iter()
        .map(|r| json!([r.as_str(), r.meaning()]))
        .collect();
    let mut value = answer.json();
    let extra = json!({
        "summary": answer.summary(),
        "sentences": answer.sentences,
        "why": reasons,
        "truth": truth.map(true_steps),
        "exact": verdict.as_ref().map(|v| v.exact),
        "wrong": verdict.as_ref().map(|v| v.wrong),
        "map": polar(map, config.mount.mirror_offset_m()),
        "inspection": inspected.map(|i| i.json(answer)),
    });
    if let (Some(value), Value::Object(extra)) = (value.as_object_mut(), extra) {
        value.extend(extra);
    }
    (value, rank)
}

fn rank(answer: &Answer, wrong: Option<bool>) -> Rank {
    match (answer.scan.status, wrong == Some(true)) {
        (Status::Fault, _) => Rank::Fault,
        (Status::Ok, true) => Rank::OkAndWrong,
        (Status::Degraded, true) => Rank::Wrong,
        (Status::Degraded, false) => Rank::Degraded,
        (Status::Ok, false) => Rank::Ok,
    }
}

fn true_steps(truth: &Truth) -> Value {
    let list = |steps: &[TrueStep]| -> Vec<Value> {
        let step = |s: &TrueStep| json!({"distance_m": s.distance_m, "height_m": s.height_m, "snr_db": s.snr_db});
        steps.iter().map(step).collect()
    };
    json!({
        "direction": truth.direction,
        "steps": list(&truth.steps),
        "uncounted": list(&truth.uncounted),
    })
}

/// The polar map: a byte a cell, and a bit a cell for what CA-CFAR lets through, row by row.
fn polar(map: &PolarMap, mirror_offset_m: f32) -> Value {
    let geometry = map.geometry();
    let (rows, bins) = (map.rows(), map.bins());
    let mut cells = Vec::with_capacity(rows * bins);
    let mut hits = vec![0u8; (rows * bins).div_ceil(8)];
    for row in 0..rows {
        cells.extend_from_slice(map.row(row));
        for bin in (0..bins).filter(|&bin| map.hit(row, bin)) {
            let k = row * bins + bin;
            hits[k / 8] |= 1 << (k % 8);
        }
    }
    json!({
        "rows": rows,
        "bins": bins,
        "first_range_m": geometry.first_range_m,
        "bin_m": geometry.bin_m,
        "mirror_offset_m": mirror_offset_m,
        "mount_height_m": geometry.mount_height_m,
        "first_angle_rad": map.angle_rad(0),
        "step_rad": geometry.step_rad,
        "depth": geometry.plane == Plane::Depth,
        "db_per_unit": DB_PER_UNIT,
        "full_scale": FULL_SCALE,
        "cells": STANDARD.encode(&cells),
        "hits": STANDARD.encode(&hits),
    })
}
