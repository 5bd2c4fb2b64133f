//! Metadata of a recording, read from and written to SigMF's JSON.

use anyhow::{Result, anyhow, ensure};
use serde_json::{Map, Value, json};
use stairscan::config::{self, Plane};

use super::captures::{self, PITCH, TIME, TRAVEL};
use super::keys::Keys;
use super::motion::Motion;
use super::standard;
use super::truth::{Disturbance, Truth};

/// Version of the `stairscan` extension that is written.
const EXTENSION_VERSION: &str = "1.0.0";
/// Maximum number of scans of one recording.
const MAX_SCANS: f64 = 10_000.0;

/// Maximum number of chirps per row: that of the scanner's setting `chirps-per-row`.
pub const MAX_CHIRPS: u8 = 32;

/// Installation parameters of the scanner.
#[derive(Clone, Debug, PartialEq)]
pub struct MirrorSetup {
    /// Distance from the radar lens to the mirror's centre, metres.
    pub offset_m: f64,
    /// Full beam width between the one-way 3 dB points, degrees.
    pub beamwidth_deg: f64,
    /// Height of the mirror's centre above the ground, metres.
    pub mount_height_m: f64,
    /// Plane that the beam sweeps, which defines the zero of the angles.
    pub plane: Plane,
}

/// Number of scans of a recording, and the ground truth of each.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence {
    /// Number of consecutive scans, alternately forward and backward. At least 1.
    pub scans: usize,
    /// Ground truth of each scan, with distances from the mirror at the end of that scan; empty if
    /// the recording has none.
    pub truth: Vec<Truth>,
    /// True travel at the end of each scan, metres; empty if the recording has none.
    pub truth_travel_m: Vec<f64>,
}

impl Default for Sequence {
    fn default() -> Self {
        Self {
            scans: 1,
            truth: Vec::new(),
            truth_travel_m: Vec::new(),
        }
    }
}

/// All metadata of a recording.
#[derive(Clone, Debug, Default)]
pub struct Metadata {
    /// Free text of `core:description`.
    pub description: String,
    /// ADC sample rate, Hz: complex samples per second, or single values per second for real
    /// samples.
    pub sample_rate_hz: Option<f64>,
    /// Carrier (centre) frequency, Hz.
    pub carrier_hz: f64,
    /// Swept bandwidth B, Hz.
    pub bandwidth_hz: f64,
    /// Number of complex samples per chirp, Ns; for real samples the number of pairs, half of the
    /// number in the file.
    pub samples_per_chirp: usize,
    /// Number of chirps whose mean each row's samples are; `None` stands for one.
    pub chirps_per_row: Option<u8>,
    /// Whether the samples are real: two consecutive values take the place of I and Q.
    pub real: bool,
    /// Mirror and mounting; `None` for radars without a mirror.
    pub mirror: Option<MirrorSetup>,
    /// Beam angle of each chirp from the plane's zero (horizontal, or straight down), degrees;
    /// empty without a mirror.
    pub angles_deg: Vec<f64>,
    /// Readings of the chair's sensors at each chirp.
    pub motion: Motion,
    /// Number of scans, and the truth of each if there are several.
    pub sequence: Sequence,
    /// Ground truth, with distances from the mirror at the first chirp; `None` if the recording has
    /// none.
    pub truth: Option<Truth>,
    /// Fault put into the recording on purpose; `None` if the metadata state none.
    pub disturbance: Option<Disturbance>,
    /// Optional extensions of the recording other than the project's own, as `core:extensions` lists them.
    pub extensions: Vec<Value>,
    /// Other keys of `global`, kept unchanged.
    pub extra: Map<String, Value>,
}

/// Datatypes (`core:datatype`) that are read, as messages name them.
const DATATYPES: &str = "\"ci16_le\", or \"ri16_le\" of real samples";
const CHIRPS_PER_ROW: &str = "stairscan:chirps_per_row";
const SCANS: &str = "stairscan:scans";
const TRUTH_SCANS: &str = "stairscan:truth_scans";
const TRUTH_TRAVEL: &str = "stairscan:truth_travel_m";

/// Keys of `global` that [`Metadata`] keeps unchanged and other modules read.
const ELSEWHERE: [&str; 2] = ["stairscan:mode", "stairscan:truth_guard"];

/// Keys of `global` that have fields in [`Metadata`].
const KEYS: &[&str] = &[
    "core:datatype",
    "core:version",
    "core:sample_rate",
    "core:num_channels",
    "core:description",
    "core:extensions",
    "stairscan:bandwidth_hz",
    "stairscan:samples_per_chirp",
    CHIRPS_PER_ROW,
    "stairscan:mirror_offset_m",
    "stairscan:beamwidth_deg",
    "stairscan:mount_height_m",
    "stairscan:scan_plane",
    "stairscan:truth",
    SCANS,
    TRUTH_SCANS,
    TRUTH_TRAVEL,
    PITCH,
    "stairscan:disturbance",
];

impl Metadata {
    /// Reads the metadata from the document of a metadata file.
    ///
    /// # Errors
    /// Names the key and the expected value.
    pub(super) fn parse(document: &Value) -> Result<Self> {
        let global = Keys::of(document.get("global"), "global")?;
        global.check_spelling(&[KEYS, &ELSEWHERE].concat())?;
        let real = match global.text("core:datatype", DATATYPES)? {
            "ci16_le" => false,
            "ri16_le" => true,
            _ => return Err(global.wrong("core:datatype", DATATYPES)),
        };
        standard::check(document)?;
        let samples_per_chirp = samples_per_chirp(&global, real)?;
        // The fixed-point configuration holds bandwidths from 1 kHz to 4 THz.
        let bandwidth_hz = global.number(
            "stairscan:bandwidth_hz",
            "a swept bandwidth from 1 kHz to 2 THz, in Hz",
            |v| (1e3..=2e12).contains(&v),
        )?;
        let sequence = Sequence::parse(&global)?;
        let pitch = captures::pitch(&global)?;
        let values = samples_per_chirp * values_per_sample(real);
        let captures = captures::parse(document, values, sequence.scans, pitch)?;
        let description = global.get("core:description").and_then(Value::as_str);
        let truth = global.get("stairscan:truth");
        let truth = truth.map(|value| Truth::parse(value, "global stairscan:truth"));
        let disturbance = global.get("stairscan:disturbance");
        Ok(Self {
            description: description.unwrap_or("").to_owned(),
            sample_rate_hz: global
                .optional("core:sample_rate", "a rate above 0 Hz", |v| v > 0.0)?,
            carrier_hz: captures.carrier_hz,
            bandwidth_hz,
            samples_per_chirp,
            chirps_per_row: chirps_per_row(&global)?,
            real,
            mirror: MirrorSetup::parse(&global)?,
            angles_deg: captures.angles_deg,
            motion: captures.motion,
            sequence,
            truth: truth.transpose()?,
            disturbance: disturbance.map(Disturbance::parse).transpose()?,
            extensions: (global.get("core:extensions").into_iter())
                .flat_map(standard::other_extensions)
                .cloned()
                .collect(),
            extra: global
                .object
                .iter()
                .filter(|(key, _)| !KEYS.contains(&key.as_str()) && !standard::is_of_file(key))
                .map(|(key, value)| (key.clone(), value.clone()))
                .collect(),
        })
    }

    /// Returns the number of samples of a chirp in the sample file: complex samples, or real
    /// values.
    pub fn file_samples(&self) -> usize {
        self.samples_per_chirp * values_per_sample(self.real)
    }

    /// Returns the SigMF document of a recording with `chirps` chirps.
    pub(super) fn document(&self, chirps: usize) -> Value {
        let captures: Vec<Value> = (0..chirps).map(|k| self.capture(k)).collect();
        json!({"global": self.global(), "captures": captures, "annotations": []})
    }

    fn global(&self) -> Map<String, Value> {
        let mut global = Map::new();
        let mut put = |key: &str, value: Value| global.insert(key.into(), value);
        let datatype = if self.real { "ri16_le" } else { "ci16_le" };
        put("core:datatype", json!(datatype));
        put("core:version", json!("1.2.0"));
        if let Some(rate) = self.sample_rate_hz {
            put("core:sample_rate", json!(rate));
        }
        put("core:num_channels", json!(1));
        put("core:description", json!(self.description));
        let own = json!({"name": "stairscan", "version": EXTENSION_VERSION, "optional": false});
        let extensions: Vec<Value> = [own].into_iter().chain(self.extensions.clone()).collect();
        put("core:extensions", json!(extensions));
        put("stairscan:bandwidth_hz", json!(self.bandwidth_hz));
        put("stairscan:samples_per_chirp", json!(self.file_samples()));
        if let Some(chirps) = self.chirps_per_row {
            put(CHIRPS_PER_ROW, json!(chirps));
        }
        if let Some(mirror) = &self.mirror {
            put("stairscan:mirror_offset_m", json!(mirror.offset_m));
            put("stairscan:beamwidth_deg", json!(mirror.beamwidth_deg));
            put("stairscan:mount_height_m", json!(mirror.mount_height_m));
            let plane = match mirror.plane {
                Plane::Depth => "depth",
                Plane::Height => "height",
            };
            put("stairscan:scan_plane", json!(plane));
        }
        if self.sequence.scans > 1 {
            put(SCANS, json!(self.sequence.scans));
        }
        if let Some(pitch) = self.steady_pitch() {
            put(PITCH, json!(pitch));
        }
        if let Some(truth) = &self.truth {
            put("stairscan:truth", truth.json());
        }
        if !self.sequence.truth_travel_m.is_empty() {
            put(TRUTH_TRAVEL, json!(self.sequence.truth_travel_m));
        }
        if !self.sequence.truth.is_empty() {
            let truth: Vec<Value> = self.sequence.truth.iter().map(Truth::json).collect();
            put(TRUTH_SCANS, json!(truth));
        }
        if let Some(disturbance) = &self.disturbance {
            put("stairscan:disturbance", disturbance.json());
        }
        for (key, value) in &self.extra {
            global.entry(key.clone()).or_insert_with(|| value.clone());
        }
        global
    }

    fn capture(&self, k: usize) -> Value {
        let mut capture = json!({
            "core:sample_start": k * self.file_samples(),
            "core:frequency": self.carrier_hz,
        });
        let motion = &self.motion;
        let pitch: &[f64] = match self.steady_pitch() {
            Some(_) => &[],
            None => &motion.pitch_deg,
        };
        for (key, values) in [
            ("stairscan:mirror_angle_deg", &self.angles_deg[..]),
            (TIME, &motion.time_s),
            (TRAVEL, &motion.travel_m),
            (PITCH, pitch),
        ] {
            if let Some(value) = values.get(k) {
                capture[key] = json!(value);
            }
        }
        capture
    }

    /// Returns the chair's pitch in degrees if it is the same at every chirp, so that it can be
    /// written once; else `None`.
    fn steady_pitch(&self) -> Option<f64> {
        let pitch = &self.motion.pitch_deg;
        let first = *pitch.first()?;
        pitch.iter().all(|p| *p == first).then_some(first)
    }
}

/// Returns the number of the file's samples in one [`stairscan::Iq`]: two real ones, or one complex
/// one.
fn values_per_sample(real: bool) -> usize {
    1 + usize::from(real)
}

/// Returns the number of complex samples, or of pairs of real ones, per chirp.
fn samples_per_chirp(global: &Keys<'_>, real: bool) -> Result<usize> {
    let values = values_per_sample(real) as f64;
    let range = f64::from(*config::SAMPLES.start())..=f64::from(*config::SAMPLES.end());
    let expected = match real {
        false => "a whole number from 16 to 256",
        true => "an even number of real samples from 32 to 512",
    };
    let samples = global.number("stairscan:samples_per_chirp", expected, |v| {
        (v / values).fract() == 0.0 && range.contains(&(v / values))
    })?;
    Ok((samples / values) as usize)
}

/// Returns the number of chirps per row; `None` if it is not stated.
fn chirps_per_row(global: &Keys<'_>) -> Result<Option<u8>> {
    let expected = "a whole number of chirps from 1 to 32";
    let chirps = global.optional(CHIRPS_PER_ROW, expected, |v| {
        v.fract() == 0.0 && (1.0..=f64::from(MAX_CHIRPS)).contains(&v)
    })?;
    Ok(chirps.map(|v| v as u8))
}

impl Sequence {
    fn parse(global: &Keys<'_>) -> Result<Self> {
        let expected = "a whole number of scans from 1 to 10000";
        let scans = global.optional(SCANS, expected, |v| {
            v.fract() == 0.0 && (1.0..=MAX_SCANS).contains(&v)
        })?;
        let scans = scans.unwrap_or(1.0) as usize;
        let travel = global.list(TRUTH_TRAVEL, "one travel in metres a scan", scans)?;
        let travel = travel.unwrap_or_default().iter().enumerate().map(|(k, v)| {
            let metres = v.as_f64().filter(|v| v.is_finite());
            metres.ok_or_else(|| {
                anyhow!("global {TRUTH_TRAVEL}[{k}]: found {v}, expected a finite travel in metres")
            })
        });
        let truth = global.list(TRUTH_SCANS, "one truth a scan", scans)?;
        let truth = truth.unwrap_or_default().iter().enumerate();
        let truth = truth.map(|(k, v)| Truth::parse(v, &format!("global {TRUTH_SCANS}[{k}]")));
        Ok(Self {
            scans,
            truth: truth.collect::<Result<_>>()?,
            truth_travel_m: travel.collect::<Result<_>>()?,
        })
    }
}

/// Limits of a number that a recording states of its mirror: in words, least and greatest.
pub struct KeyLimits {
    /// The limits with their unit, as errors name them.
    pub expected: &'static str,
    least: f64,
    most: f64,
}

impl KeyLimits {
    /// Whether a recording can have the number.
    pub fn hold(&self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }
}

impl MirrorSetup {
    /// Limits of the distance from the radar's lens to the mirror.
    pub const OFFSET: KeyLimits = KeyLimits {
        expected: "0 to 2 metres",
        least: 0.0,
        most: 2.0,
    };
    /// Limits of the beam's full width.
    pub const BEAMWIDTH: KeyLimits = KeyLimits {
        expected: "0.5 to 30 degrees",
        least: 0.5,
        most: 30.0,
    };
    /// Limits of the mirror's height above the ground.
    pub const MOUNT_HEIGHT: KeyLimits = KeyLimits {
        expected: "0.01 to 5 metres",
        least: 0.01,
        most: 5.0,
    };

    /// Reads the mirror's four keys; `None` without any of them, an error if only some are there.
    fn parse(global: &Keys<'_>) -> Result<Option<Self>> {
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
        let within = |key, limits: KeyLimits| {
            global.number(key, limits.expected, move |value| limits.hold(value))
        };
        Ok(Some(Self {
            offset_m: within("stairscan:mirror_offset_m", Self::OFFSET)?,
            beamwidth_deg: within("stairscan:beamwidth_deg", Self::BEAMWIDTH)?,
            mount_height_m: within("stairscan:mount_height_m", Self::MOUNT_HEIGHT)?,
            plane,
        }))
    }
}

/// Returns the mirror and mounting; an error for a recording without a mirror or without angles.
pub(super) fn mirror<'a>(meta: &'a Metadata, file: &str) -> Result<&'a MirrorSetup> {
    let mirror = meta.mirror.as_ref().ok_or_else(|| {
        anyhow!(
            "{file}: global stairscan:mirror_offset_m, beamwidth_deg, mount_height_m and \
             scan_plane: missing, a scan needs them"
        )
    })?;
    ensure!(
        !meta.angles_deg.is_empty(),
        "{file}: captures stairscan:mirror_angle_deg: missing, a scan needs one a chirp"
    );
    Ok(mirror)
}
