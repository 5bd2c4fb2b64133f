//! `stairscan_msgs/msg/Staircase`: the ROS 2 message with an answer and its covariances.
//!
//! Each step is a line with two ends and a covariance, as published by packages that model stairs
//! from depth cameras. The definitions are the files of `ros2/stairscan_msgs/`, from which ROS 2
//! builds the package.

use serde::Serialize;
use serde_json::Value;
use stairscan::answer::Direction;
use stairscan::verdict::Status;

use super::ros::{HEADER, Header, Message, POINT, Point, TIME};
use super::scans::Scan;

/// Half width of drawn steps across the way, metres.
pub const HALF_WIDTH_M: f64 = 0.4;

const STEP: &str = include_str!("../../../ros2/stairscan_msgs/msg/Step.msg");
const DROP: &str = include_str!("../../../ros2/stairscan_msgs/msg/Drop.msg");

/// One reported step, as a line from end to end across the way.
#[derive(Clone, Debug, Serialize)]
struct Step {
    start: Point,
    end: Point,
    covariance: [f64; 9],
    tread: f64,
    riser: f64,
    quality: f64,
}

/// The edge of a reported drop.
#[derive(Clone, Debug, Serialize)]
struct Drop {
    edge: Point,
    covariance: [f64; 9],
    depth: f64,
    probability: f64,
}

/// The answer of a scan, as the message that ROS 2 receives.
#[derive(Clone, Debug, Serialize)]
pub struct Staircase {
    header: Header,
    scan: u32,
    status: u8,
    direction: i8,
    reasons: Vec<String>,
    steps: Vec<Step>,
    drops: Vec<Drop>,
    horizon: f64,
    free: f64,
    confidence: f64,
    lost_rows: u32,
}

impl Message for Staircase {
    const NAME: &'static str = "stairscan_msgs/msg/Staircase";
    const FIELDS: &'static str = include_str!("../../../ros2/stairscan_msgs/msg/Staircase.msg");
    const PARTS: &'static [(&'static str, &'static str)] = &[
        HEADER,
        TIME,
        ("stairscan_msgs/Step", STEP),
        POINT,
        ("stairscan_msgs/Drop", DROP),
    ];
}

impl Staircase {
    /// Converts the answer of a scan.
    pub fn of(header: &Header, scan: &Scan) -> Self {
        let (answer, json) = (&scan.answer, &scan.json);
        let steps = json["steps"].as_array().map_or(&[][..], Vec::as_slice);
        Self {
            header: header.clone(),
            scan: json["scan"].as_u64().unwrap_or(0) as u32,
            status: level(answer.scan.status),
            direction: match answer.scan.direction {
                Direction::Up => 1,
                Direction::Down => -1,
                Direction::None => 0,
            },
            reasons: (answer.scan.reasons.iter())
                .map(|reason| reason.as_str().to_owned())
                .collect(),
            steps: steps.iter().map(Step::of).collect(),
            drops: Some(&json["drop"])
                .filter(|drop| drop.is_object())
                .map(Drop::of)
                .into_iter()
                .collect(),
            horizon: number(json, "horizon_m"),
            free: free_m(json),
            confidence: number(json, "confidence"),
            lost_rows: json["lost_rows"].as_u64().unwrap_or(0) as u32,
        }
    }
}

impl Step {
    fn of(step: &Value) -> Self {
        let [start, end] = across(number(step, "distance_m"), number(step, "height_m"));
        Self {
            start,
            end,
            covariance: covariance(
                number(step, "distance_sigma_m"),
                number(step, "height_sigma_m"),
            ),
            tread: number(step, "tread_m"),
            riser: number(step, "riser_m"),
            quality: number(step, "quality"),
        }
    }
}

impl Drop {
    fn of(drop: &Value) -> Self {
        Self {
            edge: Point {
                x: number(drop, "distance_m"),
                ..Point::default()
            },
            covariance: covariance(number(drop, "distance_sigma_m"), 0.0),
            depth: number(drop, "depth_m"),
            probability: number(drop, "probability"),
        }
    }
}

/// Returns the number of a status, as in this message and in diagnostics: `ok` 0, `degraded` 1, `fault` 2.
pub fn level(status: Status) -> u8 {
    match status {
        Status::Ok => 0,
        Status::Degraded => 1,
        Status::Fault => 2,
    }
}

/// Returns the free distance of an answer or a guard sweep as JSON, metres; 0 if none is reported, so that no comparison
/// takes the way to be free.
pub fn free_m(json: &Value) -> f64 {
    json["free_m"].as_f64().unwrap_or(0.0)
}

/// Returns the number at `key` of a JSON object; NaN if it is `null`.
pub fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or(f64::NAN)
}

/// Returns the left and the right end, metres, of a line across the way at distance `x` and height `z`.
pub fn across(x: f64, z: f64) -> [Point; 2] {
    [HALF_WIDTH_M, -HALF_WIDTH_M].map(|y| Point { x, y, z })
}

/// Returns the covariance matrix of x, y and z, m², row by row, from the standard deviations of x and z, metres.
fn covariance(sigma_x: f64, sigma_z: f64) -> [f64; 9] {
    let mut matrix = [0.0; 9];
    matrix[0] = sigma_x * sigma_x;
    matrix[8] = sigma_z * sigma_z;
    matrix
}
