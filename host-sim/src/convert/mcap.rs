//! MCAP files: a set of [messages](super::messages) per scan and per guard sweep, for Foxglove, Rerun and the tools of
//! ROS 2.

use std::collections::BTreeMap;
use std::io::Cursor;

use anyhow::{Context, Result};
use mcap::WriteOptions;
use mcap::records::MessageHeader;

use super::messages::{Channel, FRAME, Topic, free_message, sweeps_channel};
use super::scans::Scan;
use crate::guarded::Guarded;

/// Returns the MCAP file of these scans and guard sweeps, each sweep with its time, ns. Messages stand in the order of time.
///
/// # Errors
/// None: writing to memory does not fail.
pub fn write(scans: &[Scan], sweeps: &[(u64, Guarded)]) -> Result<Vec<u8>> {
    let options = WriteOptions::new()
        .compression(None)
        // Not "ros2", which allows no JSON messages besides its own.
        .profile("")
        .library(concat!("stairscan ", env!("CARGO_PKG_VERSION")));
    let mut file = options.create(Cursor::new(Vec::new()))?;
    let mut add = |of: &Channel| {
        let definition = of.definition.as_bytes();
        let schema = file.add_schema(of.schema, of.schema_encoding, definition)?;
        file.add_channel(schema, of.topic, of.encoding, &BTreeMap::new())
    };
    let mut topics = Vec::new();
    for topic in Topic::ALL {
        topics.push((topic, add(&topic.channel())?));
    }
    let mut messages = Vec::new();
    for &(topic, id) in &topics {
        for (k, scan) in scans.iter().enumerate() {
            if let Some(message) = topic.message(scan, FRAME)? {
                messages.push((header(id, k, scan.stamp_ns), message));
            }
        }
    }
    // Without sweeps the file has no topic of them.
    if !sweeps.is_empty() {
        let guard = add(&sweeps_channel())?;
        for (k, (stamp_ns, sweep)) in sweeps.iter().enumerate() {
            let json = sweep.json();
            for &(_, free) in topics.iter().filter(|(topic, _)| *topic == Topic::Free) {
                messages.push((header(free, k, *stamp_ns), free_message(&json)?));
            }
            messages.push((header(guard, k, *stamp_ns), json.to_string().into_bytes()));
        }
    }
    // Stable: the messages of one time keep the order of the topics.
    messages.sort_by_key(|(header, _)| header.log_time);
    for (header, message) in &messages {
        file.write_to_known_channel(header, message)?;
    }
    file.finish().context("MCAP")?;
    Ok(file.into_inner().into_inner())
}

/// Returns the header of message `k` of a channel, with its time, ns.
fn header(channel_id: u16, k: usize, stamp_ns: u64) -> MessageHeader {
    MessageHeader {
        channel_id,
        sequence: k as u32,
        log_time: stamp_ns,
        publish_time: stamp_ns,
    }
}
