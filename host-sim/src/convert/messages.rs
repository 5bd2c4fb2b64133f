//! Messages of a scan, for MCAP files, `live --foxglove` and `live --ros2`.
//!
//! | topic | schema | content |
//! |---|---|---|
//! | `/stairscan/answer` | JSON | output of `replay --format json` |
//! | `/stairscan/echoes` | `sensor_msgs/msg/PointCloud2` | the echoes with their errors |
//! | `/stairscan/stairs` | `visualization_msgs/msg/MarkerArray` | steps, 2σ, horizon, possible steps |
//! | `/stairscan/status` | `diagnostic_msgs/msg/DiagnosticArray` | status, with the text of each reason |
//! | `/stairscan/staircase` | `stairscan_msgs/msg/Staircase` | the answer with covariances |
//! | `/stairscan/free` | `std_msgs/msg/Float32` | free distance, metres; 0 if none is reported; of guard sweeps, too |
//! | `/stairscan/guard` | JSON | a guard sweep, as `replay --format json` prints it |
//!
//! Frame `stairscan`: x forward, y to the left, z up, metres. Its origin lies on the ground under
//! the mirror's centre at the scan's last row. The radar measures one plane, y = 0; the drawn width
//! has no meaning.

use anyhow::Result;
use plotters::style::RGBColor;
use serde_json::{Value, json};

use super::ros::{
    Colour, DiagnosticArray, DiagnosticStatus, Float32, Header, KeyValue, Marker, MarkerArray,
    Message, Point, PointCloud2, PointField, Pose, Time, definition, encoded,
};
use super::scans::Scan;
use super::staircase::{Staircase, across, free_m, level, number};
use super::tables::SCAN;
use crate::plots::colour;

/// Default name of the frame of all coordinates: x forward, y to the left, z up, with the origin on the ground under
/// the mirror.
pub const FRAME: &str = "stairscan";
/// Depth of a drawn step whose tread was not measured, metres.
const TREAD_M: f64 = 0.28;
/// Width of drawn lines, metres.
const LINE_M: f64 = 0.01;
/// Height of letters and size of spheres, metres.
const LETTER_M: f64 = 0.06;
/// Fields of an echo in the point cloud besides its place, named as by `inspect --format json`.
const FIELDS: [&str; 6] = [
    "snr_db",
    "range_m",
    "range_sigma_m",
    "angle_deg",
    "angle_sigma_deg",
    "width",
];
/// Datatype code, and length in bytes, of a 32-bit floating-point field of the point cloud.
const FLOAT32: (u8, u32) = (7, 4);

/// A topic with its schema, as MCAP files and servers declare it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Name of the topic.
    pub topic: &'static str,
    /// Name of the schema.
    pub schema: &'static str,
    /// Encoding of the schema: `ros2msg` or `jsonschema`.
    pub schema_encoding: &'static str,
    /// The schema itself.
    pub definition: String,
    /// Encoding of the messages: `cdr` or `json`.
    pub encoding: &'static str,
}

impl Channel {
    /// Creates a topic with ROS 2 messages.
    pub(crate) fn ros<M: Message>(topic: &'static str) -> Self {
        Self {
            topic,
            schema: M::NAME,
            schema_encoding: "ros2msg",
            definition: definition::<M>(),
            encoding: "cdr",
        }
    }

    /// Creates a topic with JSON objects.
    pub fn json(topic: &'static str, name: &'static str, schema: &Value) -> Self {
        Self {
            topic,
            schema: name,
            schema_encoding: "jsonschema",
            definition: schema.to_string(),
            encoding: "json",
        }
    }
}

/// Topics of a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topic {
    /// The answer as JSON.
    Answer,
    /// The echoes as a point cloud.
    Echoes,
    /// The stairs as markers.
    Stairs,
    /// Status and reasons as diagnostics.
    Status,
    /// The answer with covariances, as a message of its own type.
    Staircase,
    /// The free distance.
    Free,
}

impl Topic {
    /// All topics, in the order in which a scan's messages are written.
    pub const ALL: [Self; 6] = [
        Self::Answer,
        Self::Echoes,
        Self::Stairs,
        Self::Status,
        Self::Staircase,
        Self::Free,
    ];

    /// Returns the topic's name, schema and encoding.
    pub fn channel(self) -> Channel {
        match self {
            Self::Answer => Channel::json("/stairscan/answer", "stairscan.Answer", &schema()),
            Self::Echoes => Channel::ros::<PointCloud2>("/stairscan/echoes"),
            Self::Stairs => Channel::ros::<MarkerArray>("/stairscan/stairs"),
            Self::Status => Channel::ros::<DiagnosticArray>("/stairscan/status"),
            Self::Staircase => Channel::ros::<Staircase>("/stairscan/staircase"),
            Self::Free => Channel::ros::<Float32>("/stairscan/free"),
        }
    }

    /// Returns the topic's encoded message for a scan, with the scan's time and the frame's name; `None` if the scan
    /// has none.
    ///
    /// # Errors
    /// None: encoding these messages does not fail.
    pub fn message(self, scan: &Scan, frame: &str) -> Result<Option<Vec<u8>>> {
        let header = header(scan.stamp_ns, frame);
        Ok(Some(match self {
            Self::Answer => scan.json.to_string().into_bytes(),
            Self::Echoes => match &scan.echoes {
                Some(list) => encoded(&cloud(&header, list))?,
                None => return Ok(None),
            },
            Self::Stairs => encoded(&MarkerArray {
                markers: markers(&header, &scan.json),
            })?,
            Self::Status => encoded(&diagnostics(&header, scan))?,
            Self::Staircase => encoded(&Staircase::of(&header, scan))?,
            Self::Free => free_message(&scan.json)?,
        }))
    }
}

/// Returns the encoded message with the free distance of an answer or a guard sweep as JSON.
///
/// # Errors
/// None: encoding it does not fail.
pub fn free_message(json: &Value) -> Result<Vec<u8>> {
    encoded(&Float32 {
        data: free_m(json) as f32,
    })
}

/// Returns the topic of guard sweeps.
pub fn sweeps_channel() -> Channel {
    let optional = json!({"type": ["number", "null"]});
    let schema = json!({
        "title": "stairscan.GuardSweep",
        "type": "object",
        "properties": {
            "recording": {"type": "string"},
            "guard": {"type": "integer"},
            "status": {"type": "string", "enum": ["ok", "degraded", "fault"]},
            "free_m": optional,
            "what": {"type": "string"},
            "confidence": {"type": "number"},
            "reasons": {"type": "array", "items": {"type": "string"}},
        },
    });
    Channel::json("/stairscan/guard", "stairscan.GuardSweep", &schema)
}

/// Returns the header of a message with this time stamp, nanoseconds since 1970, and this frame's name.
pub(crate) fn header(stamp_ns: u64, frame: &str) -> Header {
    Header {
        stamp: Time::from_nanos(stamp_ns),
        frame_id: frame.to_owned(),
    }
}

/// Returns the JSON schema of an answer.
fn schema() -> Value {
    let (number, optional) = (
        json!({"type": "number"}),
        json!({"type": ["number", "null"]}),
    );
    let list = |keys: &[(&str, &Value)]| {
        let properties: serde_json::Map<String, Value> = keys
            .iter()
            .map(|(key, kind)| ((*key).to_owned(), (*kind).clone()))
            .collect();
        json!({"type": "array", "items": {"type": "object", "properties": properties}})
    };
    let steps = list(&[
        ("distance_m", &number),
        ("height_m", &number),
        ("tread_m", &optional),
        ("riser_m", &optional),
        ("distance_sigma_m", &number),
        ("height_sigma_m", &number),
        ("quality", &number),
    ]);
    let maybe = list(&[
        ("distance_m", &number),
        ("height_m", &number),
        ("probability", &number),
    ]);
    let drop = json!({"type": ["object", "null"], "properties": {
        "distance_m": number,
        "distance_sigma_m": number,
        "depth_m": optional,
        "probability": number,
    }});
    json!({
        "title": "stairscan.Answer",
        "type": "object",
        "properties": {
            "recording": {"type": "string"},
            "scan": {"type": "integer"},
            "status": {"type": "string", "enum": ["ok", "degraded", "fault"]},
            "direction": {"type": "string", "enum": ["up", "down", "none"]},
            "steps": steps,
            "drop": drop,
            "horizon_m": optional,
            "free_m": optional,
            "confidence": optional,
            "maybe": maybe,
            "ground": {"type": "array", "items": {"type": "array", "items": number}},
            "lost_rows": {"type": "integer"},
            "reasons": {"type": "array", "items": {"type": "string"}},
        },
    })
}

/// Returns the echoes as a point cloud, with values rounded from the JSON to 32-bit floating point.
fn cloud(header: &Header, echoes: &[Value]) -> PointCloud2 {
    let (datatype, length) = FLOAT32;
    let names = ["x", "y", "z"].into_iter().chain(FIELDS).chain(["against"]);
    let fields: Vec<PointField> = (0..)
        .zip(names)
        .map(|(k, name)| PointField {
            name: name.to_owned(),
            offset: k * length,
            datatype,
            count: 1,
        })
        .collect();
    let mut data = Vec::new();
    for echo in echoes {
        let against = f64::from(u8::from(echo["against"] == true));
        let place = [number(echo, "x_m"), 0.0, number(echo, "y_m")];
        let rest = FIELDS.iter().map(|key| number(echo, key));
        for value in place.into_iter().chain(rest).chain([against]) {
            data.extend((value as f32).to_le_bytes());
        }
    }
    let point_step = fields.len() as u32 * length;
    PointCloud2 {
        header: header.clone(),
        height: 1,
        width: echoes.len() as u32,
        fields,
        is_bigendian: false,
        point_step,
        row_step: data.len() as u32,
        data,
        is_dense: true,
    }
}

fn shade(RGBColor(r, g, b): RGBColor) -> Colour {
    let part = |v: u8| f32::from(v) / 255.0;
    Colour {
        r: part(r),
        g: part(g),
        b: part(b),
        a: 1.0,
    }
}

fn at(x: f64, z: f64) -> Point {
    Point { x, y: 0.0, z }
}

/// Returns a marker of lines between each two points (first and second, third and fourth, …), in one colour.
fn lines(header: &Header, name: &str, id: usize, colour: RGBColor, points: Vec<Point>) -> Marker {
    Marker {
        scale: Point {
            x: LINE_M,
            ..Point::default()
        },
        color: shade(colour),
        points,
        ..Marker::new(header, name, id, Marker::LINE_LIST)
    }
}

/// Returns the markers of an answer's steps, horizon, drop and possible steps. The first marker deletes those of
/// earlier scans.
fn markers(header: &Header, json: &Value) -> Vec<Marker> {
    let list = |key: &str| json[key].as_array().map_or(&[][..], Vec::as_slice);
    let clear = Marker {
        action: Marker::DELETE_ALL,
        ..Marker::new(header, "", 0, Marker::LINE_LIST)
    };
    let mut markers = vec![clear];
    let steps = list("steps");
    let mut below = 0.0;
    for (k, step) in steps.iter().enumerate() {
        let next = steps.get(k + 1).map(|next| number(next, "distance_m"));
        markers.extend(drawn(header, k + 1, step, below, next));
        below = number(step, "height_m");
    }
    if let Some(x) = json["horizon_m"].as_f64().filter(|x| *x > 0.0) {
        let line = across(x, 0.0).to_vec();
        markers.push(lines(header, "horizon", 1, colour::MEASURED, line));
    }
    if json["drop"].is_object() {
        markers.extend(edge(header, &json["drop"]));
    }
    for (k, maybe) in list("maybe").iter().enumerate() {
        markers.push(Marker {
            pose: Pose::at(at(number(maybe, "distance_m"), number(maybe, "height_m"))),
            scale: Point {
                x: LETTER_M,
                y: LETTER_M,
                z: LETTER_M,
            },
            color: shade(colour::TRUE),
            ..Marker::new(header, "maybe", k + 1, Marker::SPHERE)
        });
    }
    markers
}

/// Returns the markers of a drop: a line across the way, and its 3σ band on the ground.
fn edge(header: &Header, drop: &Value) -> [Marker; 2] {
    let (x, sigma) = (number(drop, "distance_m"), number(drop, "distance_sigma_m"));
    let band = [x - 3.0 * sigma, x + 3.0 * sigma].map(|x| across(x, 0.0));
    let [near, far] = band;
    let around = vec![
        near[0], near[1], far[0], far[1], near[0], far[0], near[1], far[1],
    ];
    [
        lines(
            header,
            "drop",
            1,
            colour::CONCLUDED,
            across(x, 0.0).to_vec(),
        ),
        lines(header, "drop 3 sigma", 1, colour::MEASURED, around),
    ]
}

/// Returns the markers of step `k`, from the height `below` of its foot to the distance `next` of the next step: its
/// edges, a cross of ±2σ, and its distance and height as text.
fn drawn(header: &Header, k: usize, step: &Value, below: f64, next: Option<f64>) -> [Marker; 3] {
    let (x, z) = (number(step, "distance_m"), number(step, "height_m"));
    let end = next.unwrap_or(x + step["tread_m"].as_f64().unwrap_or(TREAD_M));
    let [foot, top] = [across(x, below), across(x, z)];
    let back = across(end, z);
    let mut edges = vec![foot[0], foot[1], top[0], top[1], back[0], back[1]];
    for side in 0..2 {
        edges.extend([foot[side], top[side], top[side], back[side]]);
    }
    let (along, up) = (
        2.0 * number(step, "distance_sigma_m"),
        2.0 * number(step, "height_sigma_m"),
    );
    let cross = vec![
        at(x - along, z),
        at(x + along, z),
        at(x, z - up),
        at(x, z + up),
    ];
    let text = format!(
        "{k}: {:.1} cm, {:.1} ± {:.1} cm high",
        100.0 * x,
        100.0 * z,
        100.0 * up
    );
    [
        lines(header, "steps", k, colour::CONCLUDED, edges),
        lines(header, "2 sigma", k, colour::MEASURED, cross),
        Marker {
            pose: Pose::at(at(x, z + LETTER_M)),
            scale: Point {
                z: LETTER_M,
                ..Point::default()
            },
            color: shade(colour::CONCLUDED),
            text,
            ..Marker::new(header, "numbers", k, Marker::TEXT)
        },
    ]
}

/// Returns the diagnostics of a scan: its status, and every reason with its meaning.
fn diagnostics(header: &Header, scan: &Scan) -> DiagnosticArray {
    let (answer, json) = (&scan.answer, &scan.json);
    let pair = |key: &str, value: &str| KeyValue {
        key: key.to_owned(),
        value: value.to_owned(),
    };
    let mut values: Vec<KeyValue> = (SCAN.iter().chain(&["free_m", "lost_rows"]))
        .map(|key| match &json[*key] {
            Value::String(text) => pair(key, text),
            other => pair(key, &other.to_string()),
        })
        .collect();
    values.push(pair("steps", &answer.steps.len().to_string()));
    values.extend(
        answer
            .scan
            .reasons
            .iter()
            .map(|r| pair(r.as_str(), r.meaning())),
    );
    DiagnosticArray {
        header: header.clone(),
        status: vec![DiagnosticStatus {
            level: level(answer.scan.status),
            name: "stairscan: scan".to_owned(),
            message: answer.summary(),
            hardware_id: answer.recording.clone(),
            values,
        }],
    }
}
