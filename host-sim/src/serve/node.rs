//! The ROS 2 node: the crate `ros2-client` as a [`Service`].
//!
//! Messages are passed on as encoded, under the names of their types. There is no second set of structures.

use std::cell::RefCell;
use std::net::{Ipv4Addr, UdpSocket};
use std::thread::JoinHandle;

use anyhow::{Context as _, Result, anyhow};
use ros2_client::dds::rustdds::DomainParticipantBuilder;
use ros2_client::qos::{Durability, History};
use ros2_client::{
    Context, MessageTypeName, Name, Node, NodeName, NodeOptions, ParameterValue, Publisher,
    QosProfile,
};
use serde::ser::{Serialize, SerializeTuple as _, Serializer};

use super::address;
use super::frames::Frames;
use super::streams::{Outlet, Service, Stream};
use crate::convert::messages::{FRAME, Topic};
use crate::convert::ros::{ENCAPSULATION, Message, TfMessage, encoded};

/// Name of the ROS 2 node.
const NODE: &str = "stairscan";
/// Number of messages that a publisher keeps for readers that have not acknowledged them.
const DEPTH: usize = 10;
/// Topic of diagnostics that ROS 2's own tools display.
const DIAGNOSTICS: &str = "/diagnostics";
/// Names of the node's parameters: the names of the coordinate frames, and the place of the
/// mirror's centre, metres.
const FRAME_ID: &str = "frame_id";
const BASE_FRAME_ID: &str = "base_frame_id";
const MOUNT: [&str; 3] = ["mount_x", "mount_y", "mount_height"];
/// Maximum length of a coordinate frame's name, bytes.
const LONGEST_NAME: usize = 100;
/// Maximum distance of the mirror from the chair's origin, metres.
const FARTHEST_M: f64 = 100.0;

/// A message already encoded, without its encapsulation header, which the writer adds.
struct Body(Vec<u8>);

impl Serialize for Body {
    /// Passes the encoded bytes on, without a length before them.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        for byte in &self.0 {
            tuple.serialize_element(byte)?;
        }
        tuple.end()
    }
}

/// A ROS 2 node with one publisher for each topic.
pub struct RosNode {
    // Dropped before the node, whose end ends the spinner.
    publishers: Vec<(Stream, Publisher<Body>)>,
    transforms: Publisher<Body>,
    node: Node,
    spinner: JoinHandle<()>,
    /// The frames in the last published transforms; `None` before the first.
    published: RefCell<Option<Frames>>,
    interface: Ipv4Addr,
}

impl RosNode {
    /// Joins `domain` on `interface` and offers those of `streams` for which ROS 2 has a type.
    ///
    /// # Errors
    /// The domain cannot be joined; the message names interface and domain.
    pub fn start(
        interface: Ipv4Addr,
        domain: u16,
        streams: &[Stream],
        mount_height_m: f64,
    ) -> Result<Self> {
        let mut node = join(interface, domain, mount_height_m)
            .with_context(|| format!("--ros2 {interface}, domain {domain}"))?;
        let mut publishers = Vec::new();
        for &stream in streams {
            for topic in topics(stream) {
                let kind = stream.channel().schema;
                publishers.push((stream, publisher(&mut node, topic, kind, &live())?));
            }
        }
        let kept = live()
            .durability(Durability::TransientLocal)
            .history(History::KeepLast { depth: 1 });
        let transforms = publisher(&mut node, "/tf_static", TfMessage::NAME, &kept)?;
        let spinning = node.spinner()?.spin();
        let spinner = std::thread::spawn(move || {
            if let Err(error) = futures_executor::block_on(spinning) {
                crate::note!("error: --ros2: the node's parameters are not served: {error}");
            }
        });
        let started = Self {
            publishers,
            transforms,
            node,
            spinner,
            published: RefCell::default(),
            interface,
        };
        started.publish_frames(0)?;
        Ok(started)
    }

    /// Returns place and names of the coordinate frames according to the node's parameters.
    fn frames(&self) -> Frames {
        let text = |name: &str| match self.node.get_parameter(name) {
            Some(ParameterValue::String(text)) => text,
            _ => String::new(),
        };
        let number = |name: &str| match self.node.get_parameter(name) {
            Some(ParameterValue::Double(number)) => number,
            _ => 0.0,
        };
        Frames {
            frame: text(FRAME_ID),
            base: text(BASE_FRAME_ID),
            mount: MOUNT.map(number),
        }
    }

    /// Publishes the transforms of the coordinate frames if they have changed.
    fn publish_frames(&self, stamp_ns: u64) -> Result<()> {
        let frames = self.frames();
        let mut published = self.published.borrow_mut();
        if published.as_ref() != Some(&frames) {
            send(&self.transforms, &encoded(&frames.message(stamp_ns))?);
            *published = Some(frames);
        }
        Ok(())
    }
}

impl Outlet for RosNode {
    fn wanted(&self, stream: Stream) -> bool {
        let mut mine = self.publishers.iter().filter(|(of, _)| *of == stream);
        mine.any(|(_, publisher)| publisher.get_subscription_count(&self.node) > 0)
    }

    fn publish(&self, stream: Stream, message: &[u8], stamp_ns: u64) {
        if let Err(error) = self.publish_frames(stamp_ns) {
            crate::note!("error: {error:#}");
        }
        for (of, publisher) in &self.publishers {
            if *of == stream {
                send(publisher, message);
            }
        }
    }

    fn frame(&self) -> String {
        self.frames().frame
    }
}

impl Service for RosNode {
    fn place(&self) -> String {
        format!(
            "ROS 2: node {} on {}, domain {}",
            self.node.fully_qualified_name(),
            self.interface,
            self.node.domain_id()
        )
    }

    fn warning(&self) -> Option<String> {
        address::interface_warning(self.interface)
    }

    /// Removes publishers and node from the ROS 2 graph, and waits until that is done.
    fn stop(self: Box<Self>) {
        let Self {
            publishers,
            transforms,
            node,
            spinner,
            ..
        } = *self;
        drop((publishers, transforms, node));
        if spinner.join().is_err() {
            crate::note!("error: --ros2: the thread of the node's parameters failed");
        }
    }
}

/// Returns the QoS profile of measurements: reliable, without history for readers that join later.
fn live() -> QosProfile {
    QosProfile::publisher_default().history(History::KeepLast { depth: DEPTH })
}

/// Returns the ROS 2 topics of a stream; empty if ROS 2 has no type for its messages.
fn topics(stream: Stream) -> Vec<&'static str> {
    let channel = stream.channel();
    if channel.encoding != "cdr" {
        return Vec::new();
    }
    let more = (stream == Stream::Scan(Topic::Status)).then_some(DIAGNOSTICS);
    std::iter::once(channel.topic).chain(more).collect()
}

/// Creates the node in its domain, with its parameters.
fn join(interface: Ipv4Addr, domain: u16, mount_height_m: f64) -> Result<Node> {
    // The participant itself would continue without an interface.
    UdpSocket::bind((interface, 0)).context("no interface of this machine")?;
    let mut participant = DomainParticipantBuilder::new(domain);
    if !interface.is_unspecified() {
        participant = participant.with_only_networks([interface]);
    }
    let context = Context::from_domain_participant(participant.build()?)?;
    let [x, y, height] = MOUNT;
    let options = NodeOptions::new()
        .declare_parameter(FRAME_ID, ParameterValue::String(FRAME.to_owned()))
        .declare_parameter(
            BASE_FRAME_ID,
            ParameterValue::String("base_link".to_owned()),
        )
        .declare_parameter(x, ParameterValue::Double(0.0))
        .declare_parameter(y, ParameterValue::Double(0.0))
        .declare_parameter(height, ParameterValue::Double(mount_height_m))
        .parameter_validator(Box::new(valid));
    let node = context.new_node(NodeName::new("/", NODE)?, options);
    node.map_err(|error| anyhow!("{error:?}"))
}

/// Checks the value of a parameter of the node; the error describes the expected value.
fn valid(name: &str, value: &ParameterValue) -> Result<(), String> {
    match value {
        ParameterValue::String(text) => {
            let letters = text
                .chars()
                .all(|c| c.is_ascii_alphanumeric() || "_/-.".contains(c));
            let fits = (1..=LONGEST_NAME).contains(&text.len());
            (letters && fits && !text.starts_with('/'))
                .then_some(())
                .ok_or_else(|| {
                    format!(
                        "{name}: expected 1 to {LONGEST_NAME} letters, digits, _, -, . and / without a leading /"
                    )
                })
        }
        ParameterValue::Double(number) => (number.abs() <= FARTHEST_M)
            .then_some(())
            .ok_or_else(|| format!("{name}: expected at most {FARTHEST_M} m")),
        _ => Ok(()),
    }
}

/// Creates a publisher of messages of the type `PACKAGE/msg/TYPE`.
fn publisher(
    node: &mut Node,
    topic: &str,
    kind: &str,
    qos: &QosProfile,
) -> Result<Publisher<Body>> {
    let (package, name) = kind.split_once("/msg/").context("no message of ROS 2")?;
    let topic = node.create_topic(
        &Name::parse(topic)?,
        MessageTypeName::new(package, name),
        qos,
    )?;
    Ok(node.create_publisher(&topic, None)?)
}

/// Sends an encoded message. If the writer's queue is full the message is lost, with a message on stderr.
fn send(publisher: &Publisher<Body>, message: &[u8]) {
    let body = message.get(ENCAPSULATION.len()..).unwrap_or_default();
    if publisher.publish(Body(body.to_vec())).is_err() {
        crate::note!("error: --ros2: a message was lost: a reader has not taken the last {DEPTH}");
    }
}
