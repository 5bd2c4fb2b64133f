//! Converts Python's `Config` to a recording's metadata and the scanner's configuration, and back.
//!
//! Python's names contain the unit. The scanner's settings are fixed-point numbers, rounded by the firmware's
//! function.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};
use stairscan::config::{Config, Plane, to_fixed};
use stairscan::scanner::Settings;
use stairscan_replay::playback::Playback;
use stairscan_replay::recording::Recording;
use stairscan_replay::replay::Options;

use crate::refusals::refused;

/// Type of a setting's value.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// One of several words.
    Word,
    /// A whole number.
    Count,
    /// A multiple of 1/n of Python's unit.
    Fixed(f64),
}
use Kind::{Count, Fixed, Word};

/// Settings of the scanner that a recording contains: name in Python, key in commands.
const OF_RECORDING: &[(&str, &str, Kind)] = &[
    ("plane", "plane", Word),
    ("mirror_offset_m", "mirror-offset", Fixed(1e5)),
    ("mount_height_m", "mount-height", Fixed(1e5)),
    ("beamwidth_deg", "beamwidth", Fixed(1e3)),
    ("first_angle_deg", "first-angle", Fixed(1e3)),
    ("angle_step_deg", "angle-step", Fixed(1e3)),
];

/// Settings of the scanner that no recording contains.
const OF_SCANNER: &[(&str, &str, Kind)] = &[
    ("mirror_echo_m", "mirror-echo", Fixed(1e5)),
    ("mirror_level_db", "mirror-level", Fixed(1e3)),
    ("range_scale_ppm", "range-scale", Count),
    ("cfar_guard_cells", "cfar-guard", Count),
    ("cfar_training_cells", "cfar-training", Count),
    ("cfar_false_alarm", "cfar-false-alarm", Fixed(1e9)),
    ("cfar_near_margin_m", "cfar-near-margin", Fixed(1e5)),
    ("particles", "particles", Count),
    ("modes", "modes", Count),
    ("spread", "spread", Word),
    ("rounds", "rounds", Count),
    ("mode_sigma_m", "mode-sigma", Fixed(1e5)),
    ("vigilance", "vigilance", Fixed(1e3)),
    ("estimator", "estimator", Word),
    ("seed", "seed", Count),
];

/// Maximum number of scans in one call, as in `cargo sim replay --scans`.
const MOST_SCANS: u32 = 1000;

/// Contents of Python's `Config`.
pub struct Given {
    /// The settings that no recording contains.
    pub config: Config,
    bandwidth_hz: f64,
    carrier_hz: f64,
    sample_rate_hz: Option<f64>,
    real: bool,
    plane: String,
    mirror_offset_m: f64,
    mount_height_m: f64,
    beamwidth_deg: f64,
}

/// Returns the value of `name`.
fn item<'py, T: FromPyObjectOwned<'py>>(
    dict: &Bound<'py, PyDict>,
    name: &str,
    expected: &str,
) -> PyResult<T> {
    let found = dict.get_item(name)?;
    let found = found.ok_or_else(|| refused(&format!("config.{name}: missing")))?;
    found.extract().map_err(|_| {
        let shown = found.repr().map(|text| text.to_string());
        let shown = shown.unwrap_or_default();
        refused(&format!(
            "config.{name}: found {shown}, expected {expected}"
        ))
    })
}

fn number(dict: &Bound<'_, PyDict>, name: &str) -> PyResult<f64> {
    let value: f64 = item(dict, name, "a number")?;
    if value.is_finite() {
        return Ok(value);
    }
    Err(refused(&format!(
        "config.{name}: found {value}, expected a finite number"
    )))
}

/// Returns the value of a setting in the notation of commands.
fn command(dict: &Bound<'_, PyDict>, name: &str, kind: Kind) -> PyResult<(String, String)> {
    Ok(match kind {
        Word => {
            let word: String = item(dict, name, "a word")?;
            (word.clone(), format!("{word:?}"))
        }
        Count => {
            let count: i64 = item(dict, name, "a whole number")?;
            (count.to_string(), count.to_string())
        }
        Fixed(per) => {
            let value = number(dict, name)?;
            let fixed = to_fixed(value, 1.0 / per).map(|fixed| fixed.to_string());
            // A value that does not fit is outside of every limit.
            (fixed.unwrap_or("-".to_owned()), value.to_string())
        }
    })
}

/// Sets one of the scanner's settings, unless it is unchanged: the text of a command may have a lower resolution than
/// a default.
fn set(
    settings: &mut Settings,
    dict: &Bound<'_, PyDict>,
    (name, key, kind): (&str, &'static str, Kind),
) -> PyResult<()> {
    let (text, shown) = command(dict, name, kind)?;
    if settings.get(key).is_some_and(|now| now.as_str() == text) {
        return Ok(());
    }
    settings.set(key, &text).map_err(|error| {
        refused(&format!(
            "config.{name}: found {shown}, expected {}",
            error.expected
        ))
    })
}

impl Given {
    /// Parses the contents of `Config`.
    ///
    /// # Errors
    /// A field is invalid; the message names it, the value and the expected value.
    pub fn of(dict: &Bound<'_, PyDict>) -> PyResult<Self> {
        let mut settings = Settings::default();
        for row in OF_SCANNER {
            set(&mut settings, dict, *row)?;
        }
        Ok(Self {
            config: settings.config,
            bandwidth_hz: number(dict, "bandwidth_hz")?,
            carrier_hz: number(dict, "carrier_hz")?,
            sample_rate_hz: item(dict, "sample_rate_hz", "a number or None")?,
            real: item(dict, "real", "True or False")?,
            plane: item(dict, "plane", "\"depth\" or \"height\"")?,
            mirror_offset_m: number(dict, "mirror_offset_m")?,
            mount_height_m: number(dict, "mount_height_m")?,
            beamwidth_deg: number(dict, "beamwidth_deg")?,
        })
    }

    /// Returns the metadata of a recording with `chirps` chirps of `samples` pairs, in the file's format.
    pub fn document(&self, chirps: usize, samples: usize, angles_deg: &[f64]) -> Value {
        let (datatype, values) = match self.real {
            false => ("ci16_le", samples),
            true => ("ri16_le", 2 * samples),
        };
        let capture = |k: usize| {
            let mut capture = json!({
                "core:sample_start": k * values,
                "core:frequency": self.carrier_hz,
            });
            if let Some(angle) = angles_deg.get(k) {
                capture["stairscan:mirror_angle_deg"] = json!(angle);
            }
            capture
        };
        let mut document = json!({
            "global": {
                "core:datatype": datatype,
                "core:version": "1.2.0",
                "stairscan:bandwidth_hz": self.bandwidth_hz,
                "stairscan:samples_per_chirp": values,
                "stairscan:mirror_offset_m": self.mirror_offset_m,
                "stairscan:beamwidth_deg": self.beamwidth_deg,
                "stairscan:mount_height_m": self.mount_height_m,
                "stairscan:scan_plane": self.plane,
            },
            "captures": (0..chirps).map(capture).collect::<Vec<_>>(),
        });
        if let Some(rate) = self.sample_rate_hz {
            document["global"]["core:sample_rate"] = json!(rate);
        }
        document
    }
}

/// Converts a configuration to Python's names.
pub fn to_python<'py>(
    py: Python<'py>,
    config: &Config,
    sample_rate_hz: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("bandwidth_hz", f64::from(config.radar.bandwidth_khz) * 1e3)?;
    dict.set_item("carrier_hz", f64::from(config.radar.carrier_khz) * 1e3)?;
    dict.set_item("sample_rate_hz", sample_rate_hz)?;
    dict.set_item("real", config.radar.real)?;
    let settings = Settings {
        config: *config,
        ..Settings::default()
    };
    for (name, key, kind) in OF_RECORDING.iter().chain(OF_SCANNER) {
        let text = settings.get(key).unwrap_or_default();
        match kind {
            Word => dict.set_item(name, text.as_str())?,
            Count => dict.set_item(name, text.parse::<i64>().unwrap_or_default())?,
            Fixed(per) => {
                dict.set_item(name, text.parse::<f64>().unwrap_or(f64::NAN) / per)?;
            }
        }
    }
    Ok(dict)
}

/// Returns the configuration of a recording's first scan; `None` if it cannot be scanned.
pub fn of_recording<'py>(
    py: Python<'py>,
    recording: &Recording,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let Ok(playback) = Playback::new(recording, &Config::default()) else {
        return Ok(None);
    };
    to_python(py, playback.config(), recording.meta.sample_rate_hz).map(Some)
}

/// Returns the angle of each chirp, degrees. It includes the chair's pitch if the recording contains the pitch but no
/// travel, as in [`stairscan_replay::setup::schedule`].
pub fn angles_deg(recording: &Recording) -> Vec<f64> {
    let (meta, motion) = (&recording.meta, &recording.meta.motion);
    let mut angles = meta.angles_deg.clone();
    if !motion.travel_m.is_empty() || angles.is_empty() {
        return angles;
    }
    let height = (meta.mirror.as_ref()).is_some_and(|m| m.plane == Plane::Height);
    let sign = if height { 1.0 } else { -1.0 };
    for scan in 0..recording.scans() {
        let range = recording.chirps_of(scan);
        let Some(pitch) = motion.mean_pitch_deg(range.clone()) else {
            continue;
        };
        let part = angles.get_mut(range).unwrap_or_default();
        part.iter_mut().for_each(|angle| *angle += sign * pitch);
    }
    angles
}

/// Returns the options of `replay` from its keyword arguments.
///
/// # Errors
/// An argument is invalid; the message names it, the value and the expected value.
pub fn options(dict: &Bound<'_, PyDict>) -> PyResult<Options> {
    let mut settings = Settings::default();
    for name in ["estimator", "seed", "motion"] {
        let kind = if name == "seed" { Count } else { Word };
        if dict.get_item(name)?.is_some_and(|value| !value.is_none()) {
            set(&mut settings, dict, (name, name, kind)).map_err(|e| bare(dict.py(), e))?;
        }
    }
    let motion = dict.get_item("motion")?.filter(|motion| !motion.is_none());
    let flag = |name| item(dict, name, "True or False").map_err(|e| bare(dict.py(), e));
    let expected = format!("1 to {MOST_SCANS}, or None");
    let scans: Option<u32> = item(dict, "scans", &expected).map_err(|e| bare(dict.py(), e))?;
    if let Some(scans) = scans.filter(|scans| !(1..=MOST_SCANS).contains(scans)) {
        let message = format!("scans: found {scans}, expected {expected}");
        return Err(refused(&message));
    }
    Ok(Options {
        config: settings.config,
        scans,
        backwards: flag("backwards")?,
        single: flag("single")?,
        motion: motion.map(|_| settings.motion),
        ..Options::default()
    })
}

/// Converts the message for an argument that is not a field of `Config`.
fn bare(py: Python<'_>, error: PyErr) -> PyErr {
    refused(&error.value(py).to_string().replacen("config.", "", 1))
}
