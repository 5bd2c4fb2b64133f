//! Ground truth of a recording: steps and drops of the scene, for scores.

use anyhow::Result;
use serde_json::{Map, Value, json};

use super::keys::Keys;

/// A true step of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueStep {
    /// Horizontal distance from the mirror's centre to the step's foremost edge, metres.
    pub distance_m: f64,
    /// Height of the tread above the ground, metres.
    pub height_m: f64,
    /// Signal-to-noise ratio of the step's strongest cell, dB; `None` if the recording does not
    /// contain it.
    pub snr_db: Option<f64>,
}

/// A place where the ground ends or falls by more than 4 cm.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueDrop {
    /// Horizontal distance from the mirror's centre to the edge where the ground ends, metres.
    pub distance_m: f64,
    /// Depth of the next surface below the edge, metres; `None` if it is more than 1 m.
    pub depth_m: Option<f64>,
    /// Distance from the mirror's centre at which ground at the same height as before the edge continues, metres;
    /// `None` if it does not.
    pub far_m: Option<f64>,
}

/// Minimum depth of a fall of the ground that counts as a drop, metres.
const MIN_FALL_M: f64 = 0.04;

/// True content of a scene: the report of a perfect scanner.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// Direction of the steps: `up`, `down` or `none`.
    pub direction: String,
    /// Steps that an answer must report: in sight, range and angles.
    pub steps: Vec<TrueStep>,
    /// Steps that an answer need not report: out of sight, range or angles.
    pub uncounted: Vec<TrueStep>,
    /// Places where the ground ends or falls; `None` if the recording does not list them.
    pub drops: Option<Vec<TrueDrop>>,
}

/// Fault that was put into a recording on purpose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// Kind of fault, by name.
    pub kind: String,
    /// Whether the fault may cause an answer that is off by more than 3 cm or in the number of
    /// steps.
    pub misleading: bool,
    /// Other keys of the fault, kept unchanged.
    pub extra: Map<String, Value>,
}

impl Truth {
    /// Returns the distances at which the ground ends, metres: the listed drops, or without a list
    /// the uncounted edges that lead down, if there are no counted steps. Stairs down give their
    /// first edge.
    pub fn ground_ends(&self) -> Vec<f64> {
        if let Some(drops) = &self.drops {
            return drops.iter().map(|drop| drop.distance_m).collect();
        }
        if !self.steps.is_empty() {
            return Vec::new();
        }
        let mut edges = self.edges_down();
        edges.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
        let mut level_m = 0.0;
        edges.retain(|edge| {
            let stairs = level_m < 0.0 && edge.height_m < level_m;
            level_m = edge.height_m;
            !stairs
        });
        edges.iter().map(|edge| edge.distance_m).collect()
    }

    /// Whether the ground falls within `reach_m` of `distance_m` (both metres), at a listed drop
    /// or, without a list, at an uncounted edge that leads down.
    pub fn falls_near(&self, distance_m: f64, reach_m: f64) -> bool {
        let near = |at: f64| (at - distance_m).abs() <= reach_m;
        match self.drops {
            Some(_) => self.ground_ends().into_iter().any(near),
            None => self.edges_down().iter().any(|edge| near(edge.distance_m)),
        }
    }

    /// Returns the uncounted steps that lead down by more than [`MIN_FALL_M`].
    fn edges_down(&self) -> Vec<&TrueStep> {
        let down = |s: &&TrueStep| s.height_m < -MIN_FALL_M;
        self.uncounted.iter().filter(down).collect()
    }

    /// Returns the truth as a line of text, lengths in centimetres.
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

    /// Reads a truth from JSON; `place` is its key, for messages.
    pub(super) fn parse(value: &Value, place: &str) -> Result<Self> {
        const DIRECTION: &str = "\"up\", \"down\" or \"none\"";
        let truth = Keys::of(Some(value), place)?;
        truth.check_spelling(&["direction", "steps", "uncounted", "drops"])?;
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
                step.check_spelling(&["distance_m", "height_m", "snr_db"])?;
                Ok(TrueStep {
                    distance_m: step.number("distance_m", "metres", |_| true)?,
                    height_m: step.number("height_m", "metres", |_| true)?,
                    snr_db: step.optional("snr_db", "decibels", |_| true)?,
                })
            };
            list.iter().enumerate().map(parse).collect()
        };
        let drops = |list: &Value| -> Result<Vec<TrueDrop>> {
            let list = list
                .as_array()
                .ok_or_else(|| truth.wrong("drops", "an array of drops"))?;
            let parse = |(k, drop)| {
                let drop = Keys::of(Some(drop), &format!("{place} drops[{k}]"))?;
                drop.check_spelling(&["distance_m", "depth_m", "far_m"])?;
                let maybe = |key: &str| {
                    let json = drop.get(key).filter(|value| !value.is_null());
                    let number = json.map(|_| drop.number(key, "metres or null", |_| true));
                    number.transpose()
                };
                Ok(TrueDrop {
                    distance_m: drop.number("distance_m", "metres", |_| true)?,
                    depth_m: maybe("depth_m")?,
                    far_m: maybe("far_m")?,
                })
            };
            list.iter().enumerate().map(parse).collect()
        };
        Ok(Self {
            direction: direction.to_owned(),
            steps: steps("steps")?,
            uncounted: steps("uncounted")?,
            drops: truth.get("drops").map(drops).transpose()?,
        })
    }

    /// Returns the truth as JSON for the recording's metadata.
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
        let mut truth = json!({
            "direction": self.direction,
            "steps": steps(&self.steps),
            "uncounted": steps(&self.uncounted),
        });
        if let Some(drops) = &self.drops {
            let drop = |d: &TrueDrop| json!({"distance_m": d.distance_m, "depth_m": d.depth_m, "far_m": d.far_m});
            truth["drops"] = drops.iter().map(drop).collect();
        }
        truth
    }
}

impl Disturbance {
    pub(super) fn parse(value: &Value) -> Result<Self> {
        let object = Keys::of(Some(value), "global stairscan:disturbance")?;
        object.check_spelling(&["kind", "harmful"])?;
        let kind = object.text("kind", "the disturbance's name")?.to_owned();
        let misleading = object
            .get("harmful")
            .and_then(Value::as_bool)
            .ok_or_else(|| object.wrong("harmful", "true or false"))?;
        let mut extra = object.object.clone();
        extra.retain(|key, _| key != "kind" && key != "harmful");
        Ok(Self {
            kind,
            misleading,
            extra,
        })
    }

    pub(super) fn json(&self) -> Value {
        let mut object = Map::new();
        object.insert("kind".into(), json!(self.kind));
        object.insert("harmful".into(), json!(self.misleading));
        object.extend(self.extra.clone());
        Value::Object(object)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(value: &Value) -> Result<Truth> {
        Truth::parse(value, "global stairscan:truth")
    }

    #[test]
    fn listed_drops_survive_the_way_out_and_back() {
        let json = json!({
            "direction": "none",
            "steps": [],
            "uncounted": [],
            "drops": [
                {"distance_m": 1.5, "depth_m": null, "far_m": 2.0},
                {"distance_m": 0.8, "depth_m": 0.18, "far_m": null},
            ],
        });
        let truth = read(&json).unwrap();
        assert_eq!(truth.ground_ends(), [1.5, 0.8]);
        assert_eq!(truth.json(), json);
        let bad = json!({"direction": "none", "drops": [{"distance_m": 1.5, "far_m": "far"}]});
        let error = read(&bad).unwrap_err().to_string();
        assert!(error.contains("drops[0] far_m"), "{error}");
    }

    #[test]
    fn misspelt_keys_are_refused_with_their_place() {
        let refused = |value: Value| read(&value).unwrap_err().to_string();
        assert_eq!(
            refused(json!({"direction": "none", "step": []})),
            "global stairscan:truth step: no such key, expected steps"
        );
        let step = json!({"distance_m": 0.8, "height_m": 0.17, "snr_bd": 12.0});
        assert_eq!(
            refused(json!({"direction": "up", "steps": [step]})),
            "global stairscan:truth steps[0] snr_bd: no such key, expected snr_db"
        );
        let drop = json!({"distance_m": 0.8, "dept_m": 0.2});
        assert_eq!(
            refused(json!({"direction": "none", "drops": [drop]})),
            "global stairscan:truth drops[0] dept_m: no such key, expected depth_m"
        );
    }

    #[test]
    fn where_drops_are_not_listed_edges_that_lead_down_tell_them() {
        let edges = |edges: &[(f64, f64)], steps: &[(f64, f64)]| {
            let list = |edges: &[(f64, f64)]| -> Vec<Value> {
                let edge = |&(x, y): &(f64, f64)| json!({"distance_m": x, "height_m": y});
                edges.iter().map(edge).collect()
            };
            let json = json!({"direction": "none", "steps": list(steps), "uncounted": list(edges)});
            read(&json).unwrap()
        };
        // Stairs down, two holes, a fall that is no drop, and a riser.
        let stairs = edges(&[(1.1, -0.34), (0.8, -0.17)], &[]);
        assert_eq!(stairs.ground_ends(), [0.8]);
        assert!(stairs.falls_near(1.15, 0.1) && !stairs.falls_near(0.95, 0.1));
        assert_eq!(
            edges(&[(0.8, -0.5), (1.4, -0.3)], &[]).ground_ends(),
            [0.8, 1.4]
        );
        assert!(
            edges(&[(0.8, -0.03), (1.4, 0.3)], &[])
                .ground_ends()
                .is_empty()
        );
        assert!(
            edges(&[(0.8, -0.5)], &[(0.5, 0.17)])
                .ground_ends()
                .is_empty()
        );
    }
}
