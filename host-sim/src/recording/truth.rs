//! What is really there, as far as a recording says so.

use anyhow::Result;
use serde_json::{Map, Value, json};

use super::keys::Keys;

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

/// What is wrong with a recording that was spoilt on purpose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// Its name.
    pub kind: String,
    /// Whether who believes the recording is off by more than 3 cm or in the count.
    pub harmful: bool,
    /// What else it says, kept as it is.
    pub extra: Map<String, Value>,
}

impl Truth {
    /// Where the ground ends though there are no steps to count, metres.
    pub fn drops(&self) -> impl Iterator<Item = f64> {
        let drops = self.uncounted.iter().filter(|s| s.height_m < 0.0);
        let none = self.steps.is_empty();
        drops.filter(move |_| none).map(|s| s.distance_m)
    }

    /// In words, lengths in centimetres.
    pub fn summary(&self) -> String {
        let place =
            |s: &TrueStep| format!("{:.1} / {:.1}", 100.0 * s.distance_m, 100.0 * s.height_m);
        let places: Vec<_> = self.steps.iter().map(place).collect();
        let unseen = match self.uncounted.len() {
            0 => String::new(),
            n => format!(", {n} more out of sight"),
        };
        match places.len() {
            0 => format!("no steps in sight{unseen}"),
            n => {
                let (steps, way) = (if n == 1 { "step" } else { "steps" }, &self.direction);
                format!(
                    "{n} {steps} {way}, distance / height {} cm{unseen}",
                    places.join(", ")
                )
            }
        }
    }

    /// Reads a truth that stands at `place`.
    pub(super) fn parse(value: &Value, place: &str) -> Result<Self> {
        const DIRECTION: &str = "\"up\", \"down\" or \"none\"";
        let truth = Keys::of(Some(value), place)?;
        let direction = truth.text("direction", DIRECTION)?;
        if !["up", "down", "none"].contains(&direction) {
            return Err(truth.wrong("direction", DIRECTION));
        }
        let steps = |key: &str| -> Result<Vec<TrueStep>> {
            let Some(list) = truth.get(key) else {
                return Ok(Vec::new());
            };
            let list = list
                .as_array()
                .ok_or_else(|| truth.wrong(key, "an array of steps"))?;
            let parse = |(k, step)| {
                let step = Keys::of(Some(step), &format!("{place} {key}[{k}]"))?;
                Ok(TrueStep {
                    distance_m: step.number("distance_m", "metres", |_| true)?,
                    height_m: step.number("height_m", "metres", |_| true)?,
                    snr_db: step.optional("snr_db", "decibels", |_| true)?,
                })
            };
            list.iter().enumerate().map(parse).collect()
        };
        Ok(Self {
            direction: direction.to_owned(),
            steps: steps("steps")?,
            uncounted: steps("uncounted")?,
        })
    }

    /// The truth as a recording writes it.
    pub(super) fn json(&self) -> Value {
        let steps = |steps: &[TrueStep]| -> Vec<Value> {
            let step = |s: &TrueStep| {
                let mut step = json!({"distance_m": s.distance_m, "height_m": s.height_m});
                if let Some(snr) = s.snr_db {
                    step["snr_db"] = json!(snr);
                }
                step
            };
            steps.iter().map(step).collect()
        };
        json!({
            "direction": self.direction,
            "steps": steps(&self.steps),
            "uncounted": steps(&self.uncounted),
        })
    }
}

impl Disturbance {
    pub(super) fn parse(value: &Value) -> Result<Self> {
        let object = Keys::of(Some(value), "global stairscan:disturbance")?;
        let kind = object.text("kind", "the disturbance's name")?.to_owned();
        let harmful = object
            .get("harmful")
            .and_then(Value::as_bool)
            .ok_or_else(|| object.wrong("harmful", "true or false"))?;
        let mut extra = object.object.clone();
        extra.retain(|key, _| key != "kind" && key != "harmful");
        Ok(Self {
            kind,
            harmful,
            extra,
        })
    }

    pub(super) fn json(&self) -> Value {
        let mut object = Map::new();
        object.insert("kind".into(), json!(self.kind));
        object.insert("harmful".into(), json!(self.harmful));
        object.extend(self.extra.clone());
        Value::Object(object)
    }
}
