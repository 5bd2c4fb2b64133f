//! The topics of a live source. A message is published only while there is a subscriber.
//!
//! | topic | schema | content |
//! |---|---|---|
//! | those of [`Topic`] | as in MCAP files | a message per scan |
//! | `/stairscan/map` | `sensor_msgs/msg/Image` | the polar map of a scan |
//! | `/stairscan/chirp` | JSON | one chirp as recorded |

use anyhow::Result;
use serde_json::{Value, json};
use stairscan::signal::grid::PolarMap;

use crate::convert::messages::{Channel, FRAME, Topic, header};
use crate::convert::ros::{Image, encoded};
use crate::convert::scans::Scan;
use crate::recording::Recording;

/// One topic of a live source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// A topic of MCAP files, with one message per scan.
    Scan(Topic),
    /// The polar map of a scan, as an image.
    Map,
    /// Raw chirps, one message each.
    Chirp,
}

impl Stream {
    /// Topics that a recording can supply.
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
    /// Topics that a report port can supply; its sentences contain neither echoes nor samples.
    pub const OF_PORTS: [Self; 5] = [
        Self::Scan(Topic::Answer),
        Self::Scan(Topic::Stairs),
        Self::Scan(Topic::Status),
        Self::Scan(Topic::Staircase),
        Self::Scan(Topic::Free),
    ];

    /// Returns the topic's name and the schema of its messages.
    pub fn channel(self) -> Channel {
        match self {
            Self::Scan(topic) => topic.channel(),
            Self::Map => Channel::ros::<Image>("/stairscan/map"),
            Self::Chirp => Channel::json("/stairscan/chirp", "stairscan.Chirp", &chirp_schema()),
        }
    }
}

/// Sink of messages: a server, a node or a test.
pub trait Outlet {
    /// Whether a topic has a subscriber.
    fn wanted(&self, stream: Stream) -> bool;
    /// Publishes an encoded message on a topic with the timestamp `stamp_ns`, nanoseconds since
    /// 1970.
    fn publish(&self, stream: Stream, message: &[u8], stamp_ns: u64);
    /// Returns the name of the coordinate frame to which the coordinates in messages refer.
    fn frame(&self) -> String {
        FRAME.to_owned()
    }
}

/// A sink of messages to which other programs can connect.
pub trait Service: Outlet {
    /// Returns the address at which other programs connect, as text.
    fn place(&self) -> String;
    /// Returns a warning if other machines can connect.
    fn warning(&self) -> Option<String>;
    /// Ends the service.
    fn stop(self: Box<Self>);
}

/// Publishes the messages of a scan on those topics that have a subscriber.
///
/// # Errors
/// None with these messages.
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

/// A polar map as an image: one row of pixels for each angle, one column for each range bin, one
/// byte for each cell.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Picture {
    /// Number of range bins, the width of the image in pixels.
    pub width: usize,
    /// Power of the cells, row by row, in steps of 1/8 octave of power (0.376 dB); 0 in lost rows.
    pub cells: Vec<u8>,
}

impl Picture {
    /// Returns the image of a polar map.
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

    /// Returns the image as a ROS 2 message of type `sensor_msgs/msg/Image`.
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

/// Publishes a map's image if there is a subscriber.
///
/// # Errors
/// None with this message.
pub fn publish_map(outlet: &dyn Outlet, picture: &Picture, stamp_ns: u64) -> Result<()> {
    if outlet.wanted(Stream::Map) {
        let image = picture.image(stamp_ns, &outlet.frame());
        outlet.publish(Stream::Map, &encoded(&image)?, stamp_ns);
    }
    Ok(())
}

/// Publishes chirp `k` (from 0) of a recording if there is a subscriber. `scan` is the scan's
/// number in its answer.
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
