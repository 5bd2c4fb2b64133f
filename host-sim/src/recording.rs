//! Recorded scans: SigMF 1.2 pairs with the project's `stairscan:` keys.
//!
//! `NAME.sigmf-meta` is JSON, `NAME.sigmf-data` the interleaved little-endian 16-bit I and Q of one
//! chirp after another. A range profile needs only datatype, Ns and bandwidth, so recordings of
//! radars without a mirror are read too; what a scan needs beyond that is asked for by
//! [`Recording::scan_setup`]. Every refusal names file, key and what was expected.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail, ensure};
use serde_json::{Map, Value, json};
use stairscan::Iq;
use stairscan::config::{self, Plane};

/// Suffix of the metadata file.
pub const META_SUFFIX: &str = "sigmf-meta";
/// Suffix of the sample file.
pub const DATA_SUFFIX: &str = "sigmf-data";
/// Version of the `stairscan` extension that is written.
const EXTENSION_VERSION: &str = "1.0.0";
/// Carrier of recordings that do not say theirs, Hz (paper II-A).
const DEFAULT_CARRIER_HZ: f64 = 94e9;

/// A step of the truth that a simulated recording carries.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueStep {
    /// Horizontal distance from the mirror's centre to the foremost edge, metres.
    pub distance_m: f64,
    /// Height of the tread above the ground, metres.
    pub height_m: f64,
    /// Signal-to-noise ratio of its best cell, decibels.
    pub snr_db: Option<f64>,
}

/// What a perfect scanner would report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// `up`, `down` or `none`.
    pub direction: String,
    /// The steps in sight.
    pub steps: Vec<TrueStep>,
    /// Steps that exist but are out of sight, range or angles.
    pub uncounted: Vec<TrueStep>,
}

/// What a scan needs to know beyond the chirps.
#[derive(Clone, Debug, PartialEq)]
pub struct MirrorSetup {
    /// Radar lens to mirror centre, metres.
    pub offset_m: f64,
    /// Full two-sided 3 dB beam width, degrees.
    pub beamwidth_deg: f64,
    /// Mirror centre above the ground, metres.
    pub mount_height_m: f64,
    /// Plane of the scan.
    pub plane: Plane,
}

/// Everything a recording says about its samples.
#[derive(Clone, Debug)]
pub struct Metadata {
    /// `core:description`.
    pub description: String,
    /// ADC sample rate, Hz.
    pub sample_rate_hz: Option<f64>,
    /// Carrier (centre) frequency, Hz.
    pub carrier_hz: f64,
    /// Swept bandwidth B, Hz.
    pub bandwidth_hz: f64,
    /// Complex samples per chirp Ns.
    pub samples_per_chirp: usize,
    /// The mirror; `None` for other radars.
    pub mirror: Option<MirrorSetup>,
    /// Beam angle of each chirp, degrees; empty without a mirror.
    pub angles_deg: Vec<f64>,
    /// What is really there, if the recording says so.
    pub truth: Option<Truth>,
    /// Keys of `global` that are not ours, kept as they are.
    pub extra: Map<String, Value>,
}

/// One recording in memory.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Base name without suffix.
    pub name: String,
    /// The metadata.
    pub meta: Metadata,
    /// The samples of all chirps, one after another.
    pub samples: Vec<Iq>,
}

/// Path of the metadata file of `path`, given with or without a suffix.
pub fn meta_path(path: &Path) -> PathBuf {
    with_suffix(path, META_SUFFIX)
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    match path.extension().and_then(|e| e.to_str()) {
        Some(META_SUFFIX | DATA_SUFFIX) => path.with_extension(suffix),
        // Not `with_extension`: a dot within the name is no suffix.
        _ => PathBuf::from(format!("{}.{suffix}", path.display())),
    }
}

/// The recordings of a directory, sorted by name; an error if there are none.
pub fn list(dir: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(dir).with_context(|| format!("{}", dir.display()))?;
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.with_context(|| format!("{}", dir.display()))?.path();
        if path.extension().is_some_and(|e| e == META_SUFFIX) {
            found.push(path);
        }
    }
    ensure!(
        !found.is_empty(),
        "{}: holds no recording (*.{META_SUFFIX})",
        dir.display()
    );
    found.sort();
    Ok(found)
}

impl Recording {
    /// Reads the pair that `path` names, with or without a suffix.
    pub fn read(path: &Path) -> Result<Self> {
        let meta_file = with_suffix(path, META_SUFFIX);
        let text =
            fs::read_to_string(&meta_file).with_context(|| format!("{}", meta_file.display()))?;
        let document: Value = serde_json::from_str(&text)
            .map_err(|e| anyhow!("{}: {}", meta_file.display(), explain_syntax(&text, &e)))?;
        let meta = parse_meta(&document).with_context(|| format!("{}", meta_file.display()))?;
        let data_file = with_suffix(path, DATA_SUFFIX);
        let samples = read_samples(&data_file, &meta)?;
        let name = meta_file
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        Ok(Self {
            name,
            meta,
            samples,
        })
    }

    /// The samples of chirp `k`.
    pub fn chirp(&self, k: usize) -> Option<&[Iq]> {
        let ns = self.meta.samples_per_chirp;
        self.samples.get(k.checked_mul(ns)?..)?.get(..ns)
    }

    /// Number of chirps.
    pub fn chirps(&self) -> usize {
        self.samples.len() / self.meta.samples_per_chirp.max(1)
    }

    /// The mirror's set-up, or which key is missing for a scan.
    pub fn scan_setup(&self) -> Result<&MirrorSetup> {
        let meta = &self.meta;
        let mirror = meta.mirror.as_ref().ok_or_else(|| {
            anyhow!(
                "{}.{META_SUFFIX}: global stairscan:mirror_offset_m, beamwidth_deg, mount_height_m \
                 and scan_plane: missing, a scan needs them",
                self.name
            )
        })?;
        ensure!(
            !meta.angles_deg.is_empty(),
            "{}.{META_SUFFIX}: captures stairscan:mirror_angle_deg: missing, a scan needs one a chirp",
            self.name
        );
        Ok(mirror)
    }

    /// Writes the pair that `path` names. Both files appear whole or not at all.
    pub fn write(&self, path: &Path) -> Result<()> {
        let bytes: Vec<u8> = self
            .samples
            .iter()
            .flat_map(|s| {
                let ([a, b], [c, d]) = (s.i.to_le_bytes(), s.q.to_le_bytes());
                [a, b, c, d]
            })
            .collect();
        let mut text = serde_json::to_string(&self.document())?;
        text.push('\n');
        write_whole(&with_suffix(path, DATA_SUFFIX), &bytes)?;
        write_whole(&with_suffix(path, META_SUFFIX), text.as_bytes())
    }

    /// The metadata as SigMF writes it.
    fn document(&self) -> Value {
        let meta = &self.meta;
        let mut global = Map::new();
        global.insert("core:datatype".into(), json!("ci16_le"));
        global.insert("core:version".into(), json!("1.2.0"));
        if let Some(rate) = meta.sample_rate_hz {
            global.insert("core:sample_rate".into(), json!(rate));
        }
        global.insert("core:num_channels".into(), json!(1));
        global.insert("core:description".into(), json!(meta.description));
        global.insert(
            "core:extensions".into(),
            json!([{"name": "stairscan", "version": EXTENSION_VERSION, "optional": false}]),
        );
        global.insert("stairscan:bandwidth_hz".into(), json!(meta.bandwidth_hz));
        global.insert(
            "stairscan:samples_per_chirp".into(),
            json!(meta.samples_per_chirp),
        );
        if let Some(mirror) = &meta.mirror {
            global.insert("stairscan:mirror_offset_m".into(), json!(mirror.offset_m));
            global.insert(
                "stairscan:beamwidth_deg".into(),
                json!(mirror.beamwidth_deg),
            );
            global.insert(
                "stairscan:mount_height_m".into(),
                json!(mirror.mount_height_m),
            );
            let plane = match mirror.plane {
                Plane::Depth => "depth",
                Plane::Height => "height",
            };
            global.insert("stairscan:scan_plane".into(), json!(plane));
        }
        if let Some(truth) = &meta.truth {
            global.insert("stairscan:truth".into(), truth_json(truth));
        }
        for (key, value) in &meta.extra {
            global.entry(key.clone()).or_insert_with(|| value.clone());
        }
        let captures: Vec<Value> = (0..self.chirps())
            .map(|k| {
                let mut capture = json!({
                    "core:sample_start": k * meta.samples_per_chirp,
                    "core:frequency": meta.carrier_hz,
                });
                if let Some(angle) = meta.angles_deg.get(k) {
                    capture["stairscan:mirror_angle_deg"] = json!(angle);
                }
                capture
            })
            .collect();
        json!({"global": global, "captures": captures, "annotations": []})
    }
}

/// Writes a file under a temporary name and renames it, so that it is never seen half-written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".part");
    let part = path.with_file_name(name);
    let written = fs::write(&part, bytes).and_then(|()| fs::rename(&part, path));
    written.map_err(|e| {
        let _ = fs::remove_file(&part);
        anyhow!("{}: {e}", path.display())
    })
}

fn truth_json(truth: &Truth) -> Value {
    let steps = |steps: &[TrueStep]| -> Vec<Value> {
        steps
            .iter()
            .map(|s| {
                let mut step = json!({"distance_m": s.distance_m, "height_m": s.height_m});
                if let Some(snr) = s.snr_db {
                    step["snr_db"] = json!(snr);
                }
                step
            })
            .collect()
    };
    json!({
        "direction": truth.direction,
        "steps": steps(&truth.steps),
        "uncounted": steps(&truth.uncounted),
    })
}

/// Where JSON stops making sense, with the key before that place: a NaN has no other name.
fn explain_syntax(text: &str, error: &serde_json::Error) -> String {
    let before: usize = text
        .lines()
        .take(error.line().saturating_sub(1))
        .map(|l| l.len() + 1)
        .sum();
    let head = text
        .get(..(before + error.column()).min(text.len()))
        .unwrap_or(text);
    let key = head
        .rfind("\":")
        .and_then(|end| head[..end].rfind('"').map(|start| &head[start + 1..end]));
    match key {
        Some(key) => format!("near key {key}: {error}"),
        None => format!("no JSON: {error}"),
    }
}

/// A JSON object's members, with the path to it for messages.
struct Keys<'a> {
    object: &'a Map<String, Value>,
    place: String,
}

impl<'a> Keys<'a> {
    fn of(value: Option<&'a Value>, place: &str) -> Result<Self> {
        let object = value
            .and_then(Value::as_object)
            .ok_or_else(|| anyhow!("{place}: missing or no object, expected a JSON object"))?;
        Ok(Self {
            object,
            place: place.to_owned(),
        })
    }

    fn get(&self, key: &str) -> Option<&'a Value> {
        self.object.get(key)
    }

    fn wrong(&self, key: &str, expected: &str) -> anyhow::Error {
        match self.object.get(key) {
            None => anyhow!("{} {key}: missing, expected {expected}", self.place),
            Some(found) => {
                let mut found = found.to_string();
                if found.len() > 40 {
                    found = found.chars().take(40).chain("…".chars()).collect();
                }
                anyhow!("{} {key}: found {found}, expected {expected}", self.place)
            }
        }
    }

    fn number(&self, key: &str, expected: &str, ok: impl Fn(f64) -> bool) -> Result<f64> {
        self.get(key)
            .and_then(Value::as_f64)
            .filter(|v| v.is_finite() && ok(*v))
            .ok_or_else(|| self.wrong(key, expected))
    }

    fn optional(&self, key: &str, expected: &str, ok: impl Fn(f64) -> bool) -> Result<Option<f64>> {
        self.get(key)
            .map(|_| self.number(key, expected, ok))
            .transpose()
    }

    fn text(&self, key: &str, expected: &str) -> Result<&'a str> {
        self.get(key)
            .and_then(Value::as_str)
            .ok_or_else(|| self.wrong(key, expected))
    }
}

/// The keys of `global` that [`Metadata`] holds in fields of its own.
const KNOWN: &[&str] = &[
    "core:datatype",
    "core:version",
    "core:sample_rate",
    "core:num_channels",
    "core:description",
    "core:extensions",
    "stairscan:bandwidth_hz",
    "stairscan:samples_per_chirp",
    "stairscan:mirror_offset_m",
    "stairscan:beamwidth_deg",
    "stairscan:mount_height_m",
    "stairscan:scan_plane",
    "stairscan:truth",
];

fn parse_meta(document: &Value) -> Result<Metadata> {
    let global = Keys::of(document.get("global"), "global")?;
    let datatype = global.text("core:datatype", "\"ci16_le\"")?;
    if datatype != "ci16_le" {
        return Err(global.wrong("core:datatype", "\"ci16_le\""));
    }
    if let Some(channels) = global.get("core:num_channels")
        && channels.as_u64() != Some(1)
    {
        return Err(global.wrong("core:num_channels", "1"));
    }
    let range = (
        f64::from(*config::SAMPLES.start()),
        f64::from(*config::SAMPLES.end()),
    );
    let samples_per_chirp = global.number(
        "stairscan:samples_per_chirp",
        "a whole number from 16 to 256",
        |v| v.fract() == 0.0 && v >= range.0 && v <= range.1,
    )? as usize;
    // 1 kHz and 4 THz bound what the fixed-point configuration holds.
    let bandwidth_hz = global.number(
        "stairscan:bandwidth_hz",
        "a swept bandwidth from 1 kHz to 2 THz, in Hz",
        |v| (1e3..=2e12).contains(&v),
    )?;
    let captures = parse_captures(document, samples_per_chirp)?;
    Ok(Metadata {
        description: global
            .get("core:description")
            .and_then(Value::as_str)
            .unwrap_or("")
            .to_owned(),
        sample_rate_hz: global.optional("core:sample_rate", "a rate above 0 Hz", |v| v > 0.0)?,
        carrier_hz: captures.carrier_hz,
        bandwidth_hz,
        samples_per_chirp,
        mirror: parse_mirror(&global)?,
        angles_deg: captures.angles_deg,
        truth: global.get("stairscan:truth").map(parse_truth).transpose()?,
        extra: global
            .object
            .iter()
            .filter(|(key, _)| !KNOWN.contains(&key.as_str()))
            .map(|(key, value)| (key.clone(), value.clone()))
            .collect(),
    })
}

/// The mirror's keys: all of them or none.
fn parse_mirror(global: &Keys<'_>) -> Result<Option<MirrorSetup>> {
    let keys = [
        "mirror_offset_m",
        "beamwidth_deg",
        "mount_height_m",
        "scan_plane",
    ];
    if !keys
        .iter()
        .any(|key| global.get(&format!("stairscan:{key}")).is_some())
    {
        return Ok(None);
    }
    let plane = match global.text("stairscan:scan_plane", "\"depth\" or \"height\"")? {
        "depth" => Plane::Depth,
        "height" => Plane::Height,
        _ => return Err(global.wrong("stairscan:scan_plane", "\"depth\" or \"height\"")),
    };
    let length = |key, expected, low: f64, high: f64| {
        global.number(key, expected, move |v| (low..=high).contains(&v))
    };
    Ok(Some(MirrorSetup {
        offset_m: length("stairscan:mirror_offset_m", "0 to 2 metres", 0.0, 2.0)?,
        beamwidth_deg: length("stairscan:beamwidth_deg", "0.5 to 30 degrees", 0.5, 30.0)?,
        mount_height_m: length("stairscan:mount_height_m", "0.01 to 5 metres", 0.01, 5.0)?,
        plane,
    }))
}

struct Captures {
    carrier_hz: f64,
    angles_deg: Vec<f64>,
}

/// Angles and carrier; without any angle the captures say nothing about chirps (another radar's).
fn parse_captures(document: &Value, samples_per_chirp: usize) -> Result<Captures> {
    const ANGLE: &str = "stairscan:mirror_angle_deg";
    let none = Vec::new();
    let captures = match document.get("captures") {
        None => &none,
        Some(value) => value
            .as_array()
            .ok_or_else(|| anyhow!("captures: expected a JSON array"))?,
    };
    let mut result = Captures {
        carrier_hz: DEFAULT_CARRIER_HZ,
        angles_deg: Vec::new(),
    };
    let with_angles = captures.iter().any(|c| c.get(ANGLE).is_some());
    for (k, capture) in captures.iter().enumerate() {
        let capture = Keys::of(Some(capture), &format!("captures[{k}]"))?;
        let carrier = capture.optional("core:frequency", "a frequency above 0 Hz", |v| v > 0.0)?;
        result.carrier_hz = if k == 0 {
            carrier.unwrap_or(DEFAULT_CARRIER_HZ)
        } else {
            result.carrier_hz
        };
        if !with_angles {
            continue;
        }
        let start = k * samples_per_chirp;
        if capture.get("core:sample_start").and_then(Value::as_u64) != Some(start as u64) {
            let expected =
                format!("{start} (one chirp of {samples_per_chirp} samples after another)");
            return Err(capture.wrong("core:sample_start", &expected));
        }
        let angle = capture.number(ANGLE, "a finite angle within ±170 degrees", |v| {
            v.abs() <= 170.0
        })?;
        let in_order = match result.angles_deg[..] {
            [] => true,
            [last] => angle != last,
            [.., before, last] => (angle - last) * (last - before) > 0.0,
        };
        if !in_order {
            return Err(capture.wrong(ANGLE, "angles strictly in order, without repetition"));
        }
        result.angles_deg.push(angle);
    }
    Ok(result)
}

fn parse_truth(value: &Value) -> Result<Truth> {
    let truth = Keys::of(Some(value), "global stairscan:truth")?;
    let direction = truth.text("direction", "\"up\", \"down\" or \"none\"")?;
    if !["up", "down", "none"].contains(&direction) {
        return Err(truth.wrong("direction", "\"up\", \"down\" or \"none\""));
    }
    let steps = |key: &str| -> Result<Vec<TrueStep>> {
        let Some(list) = truth.get(key) else {
            return Ok(Vec::new());
        };
        let list = list
            .as_array()
            .ok_or_else(|| truth.wrong(key, "an array of steps"))?;
        let parse = |(k, step)| {
            let step = Keys::of(Some(step), &format!("global stairscan:truth {key}[{k}]"))?;
            Ok(TrueStep {
                distance_m: step.number("distance_m", "metres", |_| true)?,
                height_m: step.number("height_m", "metres", |_| true)?,
                snr_db: step.optional("snr_db", "decibels", |_| true)?,
            })
        };
        list.iter().enumerate().map(parse).collect()
    };
    Ok(Truth {
        direction: direction.to_owned(),
        steps: steps("steps")?,
        uncounted: steps("uncounted")?,
    })
}

fn read_samples(path: &Path, meta: &Metadata) -> Result<Vec<Iq>> {
    let context = || format!("{}", path.display());
    let found = fs::metadata(path).with_context(context)?.len();
    let chirp = 4 * meta.samples_per_chirp as u64;
    let chirps = meta.angles_deg.len() as u64;
    if chirps > 0 && found != chirps * chirp {
        bail!(
            "{}: {found} bytes, expected {} ({chirps} captures of {} samples of 4 bytes)",
            path.display(),
            chirps * chirp,
            meta.samples_per_chirp
        );
    }
    if found == 0 || !found.is_multiple_of(chirp) {
        bail!(
            "{}: {found} bytes, expected whole chirps of {} samples (stairscan:samples_per_chirp) of 4 bytes",
            path.display(),
            meta.samples_per_chirp
        );
    }
    let bytes = fs::read(path).with_context(context)?;
    ensure!(
        bytes.len() as u64 == found,
        "{}: changed while it was read",
        path.display()
    );
    let sample = |b: &[u8]| {
        Iq::new(
            i16::from_le_bytes([b[0], b[1]]),
            i16::from_le_bytes([b[2], b[3]]),
        )
    };
    Ok(bytes.chunks_exact(4).map(sample).collect())
}
