//! A recording of one scan to steps: the library's pipeline, chirp after chirp.
//!
//! ```sh
//! cargo run --example recording_to_steps recordings/stair_a
//! ```
//!
//! The recording is a SigMF pair: `NAME.sigmf-meta` says how the scanner was mounted and under which
//! angle each chirp was taken, `NAME.sigmf-data` holds their samples. What is read here is the least
//! that a scan needs; host-sim's `recording` module reads all of the format, checks it and names
//! what is wrong.

use std::error::Error;
use std::fs;

use serde_json::Value;
use stairscan::Iq;
use stairscan::config::{Config, Planes, to_fixed};
use stairscan::pipeline::Pipeline;
use stairscan::scanner::DataPath;

/// Units of the configuration's fixed-point numbers.
const METRES: f64 = 1e-5;
const DEGREES: f64 = 1e-3;

/// The number `value[key]`.
fn number(value: &Value, key: &str) -> Result<f64, String> {
    value[key]
        .as_f64()
        .ok_or(format!("{key}: expected a number"))
}

/// The number `value[key]` as the configuration carries it.
fn fixed(value: &Value, key: &str, unit: f64) -> Result<i32, String> {
    to_fixed(number(value, key)?, unit).ok_or(format!("{key}: too large"))
}

/// The configuration that the metadata describe.
fn config(meta: &Value) -> Result<Config, Box<dyn Error>> {
    let (global, captures) = (&meta["global"], &meta["captures"]);
    let angle = |k: usize| fixed(&captures[k], "stairscan:mirror_angle_deg", DEGREES);
    let mut config = Config::default();
    config.radar.bandwidth_khz = (number(global, "stairscan:bandwidth_hz")? / 1e3) as u32;
    config.radar.samples = number(global, "stairscan:samples_per_chirp")? as u16;
    config.mount.mirror_offset = fixed(global, "stairscan:mirror_offset_m", METRES)?;
    config.mount.mount_height = fixed(global, "stairscan:mount_height_m", METRES)?;
    config.mount.beamwidth = fixed(global, "stairscan:beamwidth_deg", DEGREES)?;
    config.mount.plane = match global["stairscan:scan_plane"].as_str() {
        Some("depth") => Planes::Depth,
        Some("height") => Planes::Height,
        _ => return Err("stairscan:scan_plane: expected depth or height".into()),
    };
    config.sweep.first_angle = angle(0)?;
    config.sweep.angle_step = angle(1)? - angle(0)?;
    config.sweep.angle_count = captures.as_array().map_or(0, Vec::len).try_into()?;
    config.validate()?;
    Ok(config)
}

/// Interleaved little-endian 16-bit I and Q.
fn samples(bytes: &[u8]) -> Vec<Iq> {
    let (quads, _) = bytes.as_chunks();
    let sample = |&[i0, i1, q0, q1]: &[u8; 4]| {
        Iq::new(i16::from_le_bytes([i0, i1]), i16::from_le_bytes([q0, q1]))
    };
    quads.iter().map(sample).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let name = std::env::args().nth(1);
    let name = name.ok_or("usage: recording_to_steps RECORDING (without suffix)")?;
    let file = |suffix: &str| {
        let path = format!("{name}.sigmf-{suffix}");
        fs::read(&path).map_err(|error| format!("{path}: {error}"))
    };
    let config = config(&serde_json::from_slice(&file("meta")?)?)?;
    let samples = samples(&file("data")?);
    let per_chirp = usize::from(config.radar.samples);
    let rows = config.sweep.angle_count;
    if samples.len() != per_chirp * usize::from(rows) {
        return Err(format!("{name}: {} samples, not {rows} chirps", samples.len()).into());
    }

    // 90 KB: on the chip a static, here better not on the stack.
    let mut pipeline = Box::new(Pipeline::new());
    pipeline.begin(&config, 1)?;
    for (row, chirp) in (0..rows).zip(samples.chunks(per_chirp)) {
        pipeline.samples().copy_from_slice(chirp);
        pipeline.row(row);
    }
    let outcome = pipeline.finish();

    let (status, direction) = (outcome.status().as_str(), outcome.answer.direction.as_str());
    println!(
        "{status}, direction {direction}, {} steps",
        outcome.answer.steps.len()
    );
    for reason in outcome.reasons().iter() {
        println!("because: {}", reason.as_str());
    }
    for (k, step) in (1..).zip(&outcome.answer.steps) {
        println!(
            "step {k}: distance {:.3} m ± {:.3}, height {:.3} m ± {:.3} (1σ), quality {} %",
            step.distance_m,
            step.distance_sigma_m,
            step.height_m,
            step.height_sigma_m,
            step.quality
        );
    }
    Ok(())
}
