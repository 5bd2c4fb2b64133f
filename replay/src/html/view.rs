//! Collects the data that a page shows of a recording.

use anyhow::Result;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use stairscan::config::{EstimatorKind, Plane};
use stairscan::scanner::Settings;
use stairscan::signal::grid::{DB_PER_UNIT, PolarMap};
use stairscan::signal::range::FULL_SCALE;
use stairscan::verdict::Status;

use super::index::{Entry, Rank};
use crate::answer::Answer;
use crate::coherent::CoherentView;
use crate::counted::counted;
use crate::inspect::Inspection;
use crate::playback::Playback;
use crate::recording::{Recording, TrueStep, Truth};
use crate::replay::{self, Options, Scanned};
use crate::score;
use crate::setup::{self, Kind};
use crate::sweeps::score::GuardAnswer;
use crate::sweeps::strip::{self, StripLayout};
use crate::sweeps::{self, truth};
use crate::views::true_edges;

/// Returns the page's entry for a recording that could not be read or scanned; `why` is shown in
/// its place.
pub fn failed(name: &str, why: &str) -> Entry {
    Entry {
        data: json!({"name": name, "error": why, "scans": []}),
        rank: Rank::Unreadable,
    }
}

/// Returns the page's entry for a recording: its scans and the scanner's answers.
///
/// # Errors
/// The recording cannot be scanned; the message names the cause.
pub fn entry(recording: &Recording, options: &Options) -> Result<Entry> {
    if setup::kind(recording)? == Kind::Guard {
        return guard(recording, options);
    }
    Ok(scanned(recording, options)?.0)
}

/// Returns the page's entry for a recording of guard sweeps: a plot of the free distance over time.
fn guard(recording: &Recording, options: &Options) -> Result<Entry> {
    let words = replay::guarded(recording, options)?;
    let truth = truth::read(recording)?;
    let worst = words
        .iter()
        .map(|word| word.line.status)
        .max_by_key(|status| match status {
            Status::Ok => 0,
            Status::Degraded => 1,
            Status::Fault => 2,
        });
    let status = worst.unwrap_or(Status::Fault);
    let answers: Vec<GuardAnswer> = words.iter().map(GuardAnswer::of).collect();
    let ground_echo_range_m = sweeps::ground::of(recording).unwrap_or_default();
    let scored = truth.as_ref().map(|truth| {
        sweeps::score::recording(&recording.name, &answers, truth, &ground_echo_range_m)
    });
    let wrong = scored.map(|scored| {
        scored
            .sweeps
            .iter()
            .filter(|sweep| sweep.free_beyond_hazard())
            .count()
    });
    let judged = wrong.map_or(String::new(), |n| {
        format!(", {n} ok and wrong from the third on")
    });
    let rank = match (status, wrong) {
        (_, Some(1..)) => Rank::OkAndWrong,
        (Status::Fault, _) => Rank::Fault,
        (Status::Degraded, _) => Rank::Degraded,
        (Status::Ok, _) => Rank::Ok,
    };
    let data = json!({
        "name": recording.name,
        "description": recording.meta.description,
        "disturbance": recording.meta.disturbance.as_ref().map(|d| d.kind.clone()),
        "scans": [],
        "guard": {
            "status": status.as_str(),
            "summary": format!("{}{judged}", counted(words.len(), "guard sweep")),
            "sentences": words.iter().map(|word| &word.sentence).collect::<Vec<_>>(),
            "strip": strip::svg(&words, truth.as_ref(), &StripLayout::WIDE),
            "narrow": strip::svg(&words, truth.as_ref(), &StripLayout::NARROW),
        },
    });
    Ok(Entry { data, rank })
}

/// Returns the page's entry for a recording, and the scanner's answers.
///
/// # Errors
/// The recording cannot be scanned; the message names the cause.
pub fn scanned(recording: &Recording, options: &Options) -> Result<(Entry, Vec<Answer>)> {
    let settings = Playback::new(recording, &options.config)?.settings();
    let options = &Options {
        coherent: true,
        ..*options
    };
    let mut scans = Vec::new();
    let answers = replay::answers(recording, options, |scanned| scans.push(scan(scanned)))?;
    let worst = scans.iter().map(|(_, rank)| *rank).min();
    let rank = worst.unwrap_or(Rank::Unreadable);
    let values: Vec<Value> = Settings::KEYS
        .iter()
        .filter_map(|key| Some(json!([key, settings.get(key)?.as_str()])))
        .collect();
    let scans: Vec<Value> = scans.into_iter().map(|(value, _)| value).collect();
    let meta = &recording.meta;
    let entry = Entry {
        data: json!({
            "name": recording.name,
            "description": meta.description,
            "disturbance": meta.disturbance.as_ref().map(|d| d.kind.clone()),
            "settings": values,
            "scans": scans,
        }),
        rank,
    };
    Ok((entry, answers))
}

/// Returns the page's data for a single answer from a report port, without map and ground truth.
pub fn answered(answer: &Answer) -> Value {
    let reasons = answer.scan.reasons.iter();
    let reasons: Vec<Value> = reasons.map(|r| json!([r.as_str(), r.meaning()])).collect();
    let evaluation = json!({
        "summary": answer.summary(),
        "sentences": answer.sentences,
        "why": reasons,
    });
    joined(answer.json(), evaluation)
}

/// Returns a JSON object with the members of both objects.
fn joined(mut value: Value, more: Value) -> Value {
    if let (Some(value), Value::Object(more)) = (value.as_object_mut(), more) {
        value.extend(more);
    }
    value
}

/// Returns the page's data for one scan, and its rank.
fn scan(scanned: &Scanned<'_>) -> (Value, Rank) {
    let answer = scanned.answer;
    let alone = scanned.recording();
    let truth = alone.meta.truth.as_ref();
    let map = scanned.pipeline.map();
    let config = scanned.config;
    let inspected = (config.estimator == EstimatorKind::Likelihood && !answer.is_fault())
        .then(|| Inspection::of(scanned));
    let verdict = truth.map(|truth| score::scene(answer, truth));
    let rank = rank(answer, verdict.as_ref().map(|v| v.wrong));
    let inspection = inspected.map(|i| i.json(answer));
    let seen = json!({
        "truth": truth.map(true_steps),
        "exact": verdict.as_ref().map(|v| v.exact),
        "wrong": verdict.as_ref().map(|v| v.wrong),
        "flaws": verdict.as_ref().map(|v| v.flaws.clone()),
        "map": polar(map, config.mount.mirror_offset_m()),
        "coherent": CoherentView::of(scanned).map(|view| coherent(&view)),
        "rivals": inspection.as_ref().map(rivals),
        "inspection": inspection,
    });
    (joined(answered(answer), seen), rank)
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

/// Maximum difference, in distance and in height, between edges of the same hypothesis, metres.
const SAME_M: f64 = 0.05;

/// Minimum posterior probability, 0…1, at which a hypothesis that the search has not scored is
/// listed.
const MIN_PROBABILITY: f64 = 0.01;

/// Lists every hypothesis once, with the search's score and with the posterior probability; either
/// is left out if not known.
fn rivals(inspection: &Value) -> Vec<Value> {
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let mut all = list(&inspection["explanations"]);
    let scored = all.len();
    for hypothesis in list(&inspection["posterior"]["hypotheses"]) {
        let free = |r: &&mut Value| r.get("probability").is_none();
        let mut rivals = all[..scored].iter_mut().filter(free);
        match rivals.find(|r| same(&r["edges"], &hypothesis["edges"])) {
            Some(rival) => rival["probability"] = hypothesis["probability"].clone(),
            None if hypothesis["probability"].as_f64() >= Some(MIN_PROBABILITY) => {
                all.push(hypothesis)
            }
            None => {}
        }
    }
    all
}

/// Whether two hypotheses have the same number of edges, and each pair is within [`SAME_M`].
fn same(a: &Value, b: &Value) -> bool {
    let (Some(a), Some(b)) = (a.as_array(), b.as_array()) else {
        return false;
    };
    let near = |a: &Value, b: &Value| {
        ["distance_m", "height_m"].iter().all(|key| {
            let [a, b] = [a, b].map(|edge| edge[key].as_f64().unwrap_or(f64::NAN));
            (a - b).abs() <= SAME_M
        })
    };
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| near(a, b))
}

fn true_steps(truth: &Truth) -> Value {
    let list = |steps: &[TrueStep]| -> Vec<Value> {
        let step = |s: &TrueStep| json!({"distance_m": s.distance_m, "height_m": s.height_m, "snr_db": s.snr_db});
        steps.iter().map(step).collect()
    };
    let edge = |&(x, y): &(f64, f64)| json!({"distance_m": x, "height_m": y});
    json!({
        "direction": truth.direction,
        // Edges of the ground. With hidden steps left out, a hole would not be shown where the
        // level falls back.
        "edges": true_edges(truth).iter().map(edge).collect::<Vec<_>>(),
        "steps": list(&truth.steps),
        "uncounted": list(&truth.uncounted),
    })
}

/// Row interval of the coherent image on the page: a lobe is wider by far.
const COHERENT_ROWS: usize = 2;

/// Returns the coherent image as JSON: its rows and their interval, noise, and one byte for each cell in base64.
fn coherent(view: &CoherentView) -> Value {
    let map = view.map();
    let rows = (0..map.rows()).step_by(COHERENT_ROWS);
    let cells: Vec<u8> = rows.clone().flat_map(|k| map.row(k)).copied().collect();
    json!({
        "rows": rows.len(),
        "step_rad": COHERENT_ROWS as f32 * map.geometry().step_rad,
        "noise_dbfs": 10.0 * view.noise.log10(),
        "cells": STANDARD.encode(&cells),
    })
}

/// Returns the polar map as JSON, row by row and in base64: one byte for each cell, and one bit for
/// each cell that passes the CA-CFAR.
fn polar(map: &PolarMap, mirror_offset_m: f32) -> Value {
    let geometry = map.geometry();
    let (rows, bins) = (map.rows(), map.bins());
    let mut cells = Vec::with_capacity(rows * bins);
    let mut hits = vec![0u8; (rows * bins).div_ceil(8)];
    for row in 0..rows {
        cells.extend_from_slice(map.row(row));
        for bin in (0..bins).filter(|&bin| map.is_detected(row, bin)) {
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
