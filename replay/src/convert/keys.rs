//! Keys of a recording that foreign samples lack, given one by one or taken from another recording.

use anyhow::{Result, ensure};
use serde_json::{Map, Value, json};

use crate::recording::standard::{self, FREQUENCY, START};

/// Keys given on the command line. Each stands in the place of one that the input may have.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Given {
    /// Swept bandwidth, Hz (stairscan:bandwidth_hz); the paper's radar: 10e9
    #[arg(long, value_name = "HZ", help_heading = "Keys of a recording")]
    pub bandwidth_hz: Option<f64>,
    /// Samples of one chirp (stairscan:samples_per_chirp), if the input does not contain it
    #[arg(long, value_name = "N", help_heading = "Keys of a recording")]
    pub samples_per_chirp: Option<usize>,
    /// Rate of the converter, Hz (core:sample_rate)
    #[arg(long, value_name = "HZ", help_heading = "Keys of a recording")]
    pub sample_rate_hz: Option<f64>,
    /// Centre frequency, Hz (core:frequency); without it 94e9
    #[arg(long, value_name = "HZ", help_heading = "Keys of a recording")]
    pub carrier_hz: Option<f64>,
    /// Radar lens to mirror centre, metres (stairscan:mirror_offset_m)
    #[arg(long, value_name = "M", help_heading = "Keys of a recording")]
    pub mirror_offset_m: Option<f64>,
    /// Full two-sided 3 dB width of the beam, degrees (stairscan:beamwidth_deg)
    #[arg(long, value_name = "DEG", help_heading = "Keys of a recording")]
    pub beamwidth_deg: Option<f64>,
    /// Mirror centre above the ground, metres (stairscan:mount_height_m)
    #[arg(long, value_name = "M", help_heading = "Keys of a recording")]
    pub mount_height_m: Option<f64>,
    /// depth: angles from the horizontal; height: from straight down (stairscan:scan_plane)
    #[arg(long, value_name = "PLANE", help_heading = "Keys of a recording")]
    pub scan_plane: Option<String>,
    /// Scans in the recording, one after the other (stairscan:scans)
    #[arg(long, value_name = "N", help_heading = "Keys of a recording")]
    pub scans: Option<u32>,
    /// Description (core:description)
    #[arg(long, value_name = "TEXT", help_heading = "Keys of a recording")]
    pub description: Option<String>,
}

const BANDWIDTH: (&str, &str) = ("stairscan:bandwidth_hz", "--bandwidth-hz");
pub(super) const SAMPLES: &str = "stairscan:samples_per_chirp";
const ANGLE: &str = "stairscan:mirror_angle_deg";
/// Keys of the mirror that a recording of a scan must have, with their options.
const MIRROR: [(&str, &str); 4] = [
    ("stairscan:mirror_offset_m", "--mirror-offset-m"),
    ("stairscan:beamwidth_deg", "--beamwidth-deg"),
    ("stairscan:mount_height_m", "--mount-height-m"),
    ("stairscan:scan_plane", "--scan-plane"),
];

impl Given {
    /// Returns the given keys and their values in the form of a recording's `global` object.
    fn global(&self) -> Vec<(&'static str, Value)> {
        let number = |value: Option<f64>| value.map(|v| json!(v));
        let keys = [
            (BANDWIDTH.0, number(self.bandwidth_hz)),
            ("core:sample_rate", number(self.sample_rate_hz)),
            (MIRROR[0].0, number(self.mirror_offset_m)),
            (MIRROR[1].0, number(self.beamwidth_deg)),
            (MIRROR[2].0, number(self.mount_height_m)),
            (MIRROR[3].0, self.scan_plane.as_ref().map(|v| json!(v))),
            ("stairscan:scans", self.scans.map(|v| json!(v))),
            (
                "core:description",
                self.description.as_ref().map(|v| json!(v)),
            ),
        ];
        keys.into_iter()
            .filter_map(|(key, value)| Some((key, value?)))
            .collect()
    }

    /// Whether any key of the recording is given on the command line.
    pub fn any(&self) -> bool {
        !self.global().is_empty() || self.carrier_hz.is_some() || self.samples_per_chirp.is_some()
    }

    /// Returns the metadata of a recording of `chirps` chirps of `samples` samples, complex or real: those of
    /// `base`, with the given keys and angles replacing its own.
    ///
    /// # Errors
    /// Names the keys that are missing, with their options.
    pub fn document(
        &self,
        base: &Value,
        (chirps, samples): (usize, usize),
        real: bool,
        angles: Option<&[f64]>,
    ) -> Result<Value> {
        let mut global = base["global"].as_object().cloned().unwrap_or_default();
        let datatype = if real { "ri16_le" } else { "ci16_le" };
        global.insert("core:datatype".into(), json!(datatype));
        global.insert("core:version".into(), json!("1.2.0"));
        global.insert(SAMPLES.into(), json!(samples));
        global.retain(|key, _| !standard::is_of_file(key));
        for (key, value) in self.global() {
            global.insert(key.into(), value);
        }
        let captures = self.captures(base, (chirps, samples), angles);
        let turns = captures.iter().any(|capture| capture.contains_key(ANGLE));
        complete(&global, turns)?;
        Ok(json!({"global": global, "captures": captures, "annotations": []}))
    }

    fn captures(
        &self,
        base: &Value,
        (chirps, samples): (usize, usize),
        angles: Option<&[f64]>,
    ) -> Vec<Map<String, Value>> {
        let own = base["captures"].as_array().map_or(&[][..], Vec::as_slice);
        let own: Vec<_> = own.iter().filter_map(Value::as_object).cloned().collect();
        let first = own.first().cloned().unwrap_or_default();
        let start = first.get(START).and_then(Value::as_u64).unwrap_or(0);
        let mut captures = match angles {
            // The captures' other keys per chirp still apply.
            Some(_) if own.len() != chirps => vec![first; chirps],
            None if own.is_empty() => vec![Map::new()],
            _ => own,
        };
        for (k, capture) in captures.iter_mut().enumerate() {
            if let Some(own) = capture.get(START).and_then(Value::as_u64) {
                capture.insert(START.into(), json!(own.saturating_sub(start)));
            }
            if let Some(angle) = angles.and_then(|angles| angles.get(k)) {
                capture.insert(START.into(), json!(k * samples));
                capture.insert(ANGLE.into(), json!(angle));
            }
            if let Some(carrier) = self.carrier_hz {
                capture.insert(FREQUENCY.into(), json!(carrier));
            }
        }
        captures
    }
}

/// Returns the metadata of an input with the keys of the recording `base`: the standard's keys of the input stay, because
/// they describe its samples, and all others are those of `base`.
pub(super) fn merged(own: &Value, base: Option<&Value>) -> Value {
    let Some(base) = base else {
        return own.clone();
    };
    let mut merged = base.clone();
    let empty = Map::new();
    for (key, value) in own["global"].as_object().unwrap_or(&empty) {
        if key.starts_with("core:") || base["global"].get(key).is_none() {
            merged["global"][key] = value.clone();
        }
    }
    if let (Some(carrier), Some(captures)) = (
        own["captures"][0].get(FREQUENCY),
        merged["captures"].as_array_mut(),
    ) {
        for capture in captures {
            capture[FREQUENCY] = carrier.clone();
        }
    }
    merged
}

/// Returns an error for metadata without a key that every recording needs, or with only a part of the mirror's keys.
/// With `turns`, the chirps have angles, so that all of the mirror's keys are needed.
fn complete(global: &Map<String, Value>, turns: bool) -> Result<()> {
    let missing = |keys: &[(&str, &str)]| -> Vec<String> {
        let absent = keys.iter().filter(|(key, _)| !global.contains_key(*key));
        absent
            .map(|(key, flag)| format!("{key} ({flag})"))
            .collect()
    };
    let of_mirror = missing(&MIRROR);
    let mut all = missing(&[BANDWIDTH]);
    // A range profile needs no mirror. A part of its keys is a mistake.
    if turns || of_mirror.len() < MIRROR.len() {
        all.extend(of_mirror);
        if !turns {
            all.push(format!("{ANGLE} (--angles FILE)"));
        }
    }
    ensure!(all.is_empty(), "missing: {}", all.join(", "));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given() -> Given {
        Given {
            bandwidth_hz: Some(10e9),
            ..Given::default()
        }
    }

    #[test]
    fn what_is_missing_is_named_with_its_flag() {
        let error = Given::default()
            .document(&Value::Null, (2, 16), false, None)
            .unwrap_err();
        let message = error.to_string();
        assert_eq!(message, "missing: stairscan:bandwidth_hz (--bandwidth-hz)");
        let angles = [0.0, 1.0];
        let error = given()
            .document(&Value::Null, (2, 16), false, Some(&angles))
            .unwrap_err();
        let message = error.to_string();
        assert!(
            MIRROR
                .iter()
                .all(|(key, flag)| message.contains(key) && message.contains(flag)),
            "{message}"
        );
        let height = Given {
            mount_height_m: Some(0.4),
            ..given()
        };
        let message = height
            .document(&Value::Null, (2, 16), false, None)
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("--angles") && !message.contains("mount-height"),
            "{message}"
        );
    }

    #[test]
    fn what_is_given_stands_in_the_place_of_what_was_there() {
        let base = json!({
            "global": {"core:datatype": "cf32_le", "core:sha512": "…", "stairscan:bandwidth_hz": 1.0, "x:y": 1},
            "captures": [{"core:frequency": 77e9, "stairscan:time_s": 0.0}],
        });
        let document = given().document(&base, (2, 16), false, None).unwrap();
        let global = &document["global"];
        assert_eq!(global["core:datatype"], "ci16_le");
        assert_eq!(global["stairscan:bandwidth_hz"], 10e9);
        assert_eq!(
            (&global["x:y"], &global["core:sha512"]),
            (&json!(1), &Value::Null)
        );
        assert_eq!(document["captures"][0]["core:frequency"], 77e9);
    }
}
