//! The topics of a live source, and what is published on each while somebody subscribes.
//!
//! | topic | schema | holds |
//! |---|---|---|
//! | those of [`Topic`] | as in MCAP files | a message a scan |
//! | `/stairscan/map` | `sensor_msgs/msg/Image` | the polar map of a scan |
//! | `/stairscan/chirp` | JSON | one chirp as recorded |

use anyhow::Result;
use serde_json::{Value, json};
use stairscan::signal::grid::PolarMap;

use crate::convert::messages::{Channel, FRAME, Topic, header};
use crate::convert::ros::{Image, encoded};
use crate::convert::scans::Scan;
use crate::recording::Recording;

/// One topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// A topic of MCAP files.
    Scan(Topic),
    /// The polar map.
    Map,
    /// Raw chirps.
    Chirp,
}

impl Stream {
    /// Topics of a recording.
    pub const OF_RECORDINGS: [Self; 8] = [
        Self::Scan(Topic::Answer),
        Self::Scan(Topic::Echoes),
        Self::Scan(Topic::Stairs),
        Self::Scan(Topic::Status),
        Self::Scan(Topic::Staircase),
        Self::Scan(Topic::Free),
        Self::Map,
        Self::Chirp,
    ];
    /// Topics of a report port, whose sentences hold neither echoes nor samples.
    pub const OF_PORTS: [Self; 5] = [
        Self::Scan(Topic::Answer),
        Self::Scan(Topic::Stairs),
        Self::Scan(Topic::Status),
        Self::Scan(Topic::Staircase),
        Self::Scan(Topic::Free),
    ];

    /// Name and schema.
    pub fn channel(self) -> Channel {
        match self {
            Self::Scan(topic) => topic.channel(),
            Self::Map => Channel::ros::<Image>("/stairscan/map"),
            Self::Chirp => Channel::json("/stairscan/chirp", "stairscan.Chirp", &chirp_schema()),
        }
    }
}

/// Where messages go.
pub trait Outlet {
    /// Whether somebody subscribes to it now.
    fn wanted(&self, stream: Stream) -> bool;
    /// Takes an encoded message that belongs to `stamp_ns`, nanoseconds since 1970.
    fn publish(&self, stream: Stream, message: &[u8], stamp_ns: u64);
    /// Name of the frame of coordinates.
    fn frame(&self) -> String {
        FRAME.to_owned()
    }
}

/// An outlet that is open to others until it is stopped.
pub trait Service: Outlet {
    /// Where others find it, in words.
    fn place(&self) -> String;
    /// The warning that belongs to it.
    fn warning(&self) -> Option<String>;
    /// Ends it in good order.
    fn stop(self: Box<Self>);
}

/// Publishes those messages of a scan that are wanted.
///
/// # Errors
/// None that these messages can bring about.
pub fn publish_scan(outlet: &dyn Outlet, scan: &Scan) -> Result<()> {
    let frame = outlet.frame();
    for topic in Topic::ALL {
        let stream = Stream::Scan(topic);
        if outlet.wanted(stream)
            && let Some(message) = topic.message(scan, &frame)?
        {
            outlet.publish(stream, &message, scan.stamp_ns);
        }
    }
    Ok(())
}

/// A polar map as a picture: a row an angle, a column a range bin, a byte a cell.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Picture {
    /// Range bins.
    pub width: usize,
    /// The rows one after the other, in the map's units; zeros where a row was lost.
    pub cells: Vec<u8>,
}

impl Picture {
    /// The cells of `map`.
    pub fn of(map: &PolarMap) -> Self {
        let width = map.bins();
        let mut cells = Vec::with_capacity(map.rows() * width);
        for row in 0..map.rows() {
            if map.present(row) {
                cells.extend(map.row(row));
            }
            cells.resize((row + 1) * width, 0);
        }
        Self { width, cells }
    }

    /// The message.
    fn image(&self, stamp_ns: u64, frame: &str) -> Image {
        Image {
            header: header(stamp_ns, frame),
            height: (self.cells.len() / self.width.max(1)) as u32,
            width: self.width as u32,
            encoding: "mono8".to_owned(),
            is_bigendian: 0,
            step: self.width as u32,
            data: self.cells.clone(),
        }
    }
}

/// Publishes the picture of a map if it is wanted.
///
/// # Errors
/// None that this message can bring about.
pub fn publish_map(outlet: &dyn Outlet, picture: &Picture, stamp_ns: u64) -> Result<()> {
    if outlet.wanted(Stream::Map) {
        let image = picture.image(stamp_ns, &outlet.frame());
        outlet.publish(Stream::Map, &encoded(&image)?, stamp_ns);
    }
    Ok(())
}

/// Publishes chirp `k` (from 0) of a recording if it is wanted. `scan` is the number that the scan's answer has.
pub fn publish_chirp(
    outlet: &dyn Outlet,
    recording: &Recording,
    (scan, k): (&Value, usize),
    stamp_ns: u64,
) {
    if !outlet.wanted(Stream::Chirp) {
        return;
    }
    let samples = recording.chirp(k).unwrap_or_default();
    let message = json!({
        "recording": recording.name,
        "scan": scan,
        "chirp": k,
        "angle_deg": recording.meta.angles_deg.get(k),
        "i": samples.iter().map(|s| s.i).collect::<Vec<_>>(),
        "q": samples.iter().map(|s| s.q).collect::<Vec<_>>(),
    });
    outlet.publish(Stream::Chirp, message.to_string().as_bytes(), stamp_ns);
}

fn chirp_schema() -> Value {
    let samples = json!({"type": "array", "items": {"type": "integer"}});
    json!({
        "title": "stairscan.Chirp",
        "type": "object",
        "properties": {
            "recording": {"type": "string"},
            "scan": {"type": "integer"},
            "chirp": {"type": "integer"},
            "angle_deg": {"type": ["number", "null"]},
            "i": samples,
            "q": samples,
        },
    })
}
