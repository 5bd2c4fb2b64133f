//! MCAP files: a set of [messages](super::messages) per scan, for Foxglove, Rerun and the tools of
//! ROS 2.

use std::collections::BTreeMap;
use std::io::Cursor;

use anyhow::{Context, Result};
use mcap::WriteOptions;
use mcap::records::MessageHeader;

use super::messages::{FRAME, Topic};
use super::scans::Scan;

/// Returns the MCAP file of these scans.
///
/// # Errors
/// None: writing to memory does not fail.
pub fn write(scans: &[Scan]) -> Result<Vec<u8>> {
    let options = WriteOptions::new()
        .compression(None)
        // Not "ros2", which allows no JSON messages besides its own.
        .profile("")
        .library(concat!("stairscan ", env!("CARGO_PKG_VERSION")));
    let mut file = options.create(Cursor::new(Vec::new()))?;
    let mut topics = Vec::new();
    for topic in Topic::ALL {
        let of = topic.channel();
        let definition = of.definition.as_bytes();
        let schema = file.add_schema(of.schema, of.schema_encoding, definition)?;
        let channel = file.add_channel(schema, of.topic, of.encoding, &BTreeMap::new())?;
        topics.push((topic, channel));
    }
    for (k, scan) in scans.iter().enumerate() {
        for &(topic, channel_id) in &topics {
            let Some(message) = topic.message(scan, FRAME)? else {
                continue;
            };
            let header = MessageHeader {
                channel_id,
                sequence: k as u32,
                log_time: scan.stamp_ns,
                publish_time: scan.stamp_ns,
            };
            file.write_to_known_channel(&header, &message)?;
        }
    }
    file.finish().context("MCAP")?;
    Ok(file.into_inner().into_inner())
}
