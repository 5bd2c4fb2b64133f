//! Tests of messages and their times, with a clock that does not wait and an outlet that stores everything.

use std::cell::RefCell;
use std::net::SocketAddr;

use crate::convert::messages::{FRAME, Topic};
use crate::convert::scans::{self, SECOND_NS};
use crate::emulate::image::workspace;
use crate::recording::Recording;
use crate::replay::Options;
use serde_json::Value;

use super::address;
use super::frames::Frames;
use super::player::{self, Clock};
use super::streams::{Outlet, Stream};

/// Start time of the playback, nanoseconds since 1970.
const BEGIN_NS: u64 = 1_700_000_000 * SECOND_NS;

/// An outlet that stores the messages of the subscribed topics.
struct Kept {
    subscribed: Vec<Stream>,
    messages: RefCell<Vec<(Stream, Vec<u8>, u64)>>,
}

impl Kept {
    fn subscribed(streams: &[Stream]) -> Self {
        Self {
            subscribed: streams.to_vec(),
            messages: RefCell::default(),
        }
    }

    /// Returns the messages of a topic with their timestamps.
    fn of(&self, stream: Stream) -> Vec<(Vec<u8>, u64)> {
        let messages = self.messages.borrow();
        let mine = messages.iter().filter(|(of, ..)| *of == stream);
        mine.map(|(_, message, stamp)| (message.clone(), *stamp))
            .collect()
    }
}

impl Outlet for Kept {
    fn wanted(&self, stream: Stream) -> bool {
        self.subscribed.contains(&stream)
    }

    fn publish(&self, stream: Stream, message: &[u8], stamp_ns: u64) {
        assert!(self.wanted(stream), "{stream:?} was published for nobody");
        let kept = (stream, message.to_vec(), stamp_ns);
        self.messages.borrow_mut().push(kept);
    }
}

/// A clock that jumps to each requested time, up to an end time.
struct Hurried {
    now_ns: u64,
    end_ns: u64,
}

impl Clock for Hurried {
    fn now_ns(&self) -> u64 {
        self.now_ns
    }

    fn wait_until(&mut self, ns: u64) -> bool {
        assert!(ns >= self.now_ns, "time runs back");
        self.now_ns = ns;
        ns <= self.end_ns
    }
}

fn stair_a() -> Recording {
    Recording::read(&workspace().join("recordings/stair_a")).unwrap()
}

/// Plays `recording` for `seconds` and returns the messages of `streams`.
fn played(recording: &Recording, seconds: f64, streams: &[Stream]) -> Kept {
    let kept = Kept::subscribed(streams);
    let mut clock = Hurried {
        now_ns: BEGIN_NS,
        end_ns: BEGIN_NS + (seconds * SECOND_NS as f64) as u64,
    };
    let options = Options::default();
    player::play(recording.clone(), &options, &kept, &mut clock, &mut |_| ()).unwrap();
    kept
}

/// Two passes: the messages are those of MCAP files, at times that go on.
#[test]
fn a_recording_is_played_over_and_over_with_the_messages_of_mcap_files() {
    let recording = stair_a();
    let kept = played(&recording, 2.0, &Stream::OF_RECORDINGS);
    let scan = scans::of(&recording, &Options::default(), false).unwrap();
    for (pass, begin_ns) in [BEGIN_NS, BEGIN_NS + SECOND_NS].into_iter().enumerate() {
        let mut scan = scan[0].clone();
        scan.stamp_ns += begin_ns;
        for topic in Topic::ALL {
            let (message, stamp_ns) = &kept.of(Stream::Scan(topic))[pass];
            assert_eq!(*stamp_ns, begin_ns + SECOND_NS);
            let expected = topic.message(&scan, FRAME).unwrap().unwrap();
            assert!(*message == expected, "{topic:?} of pass {pass}");
        }
    }
    assert_eq!(kept.of(Stream::Map).len(), 2);
    assert_eq!(kept.of(Stream::Chirp).len(), 2 * recording.chirps());
}

#[test]
fn nothing_is_made_that_nobody_subscribes_to() {
    let recording = stair_a();
    let answers = Stream::Scan(Topic::Answer);
    let kept = played(&recording, 1.0, &[answers]);
    assert_eq!(kept.messages.borrow().len(), 1);
    assert!(played(&recording, 1.0, &[]).messages.borrow().is_empty());
}

#[test]
fn chirps_come_one_by_one_at_their_times_with_their_samples() {
    let mut recording = stair_a();
    recording.meta.motion.time_s = (0..281).map(|k| 3.0 + 0.01 * f64::from(k)).collect();
    // A pass takes 2.8 s and a pause of 1 s.
    let kept = played(
        &recording,
        3.9,
        &[Stream::Chirp, Stream::Scan(Topic::Answer)],
    );
    let chirps = kept.of(Stream::Chirp);
    assert!(chirps.len() > 281, "{}", chirps.len());
    for (k, (message, stamp_ns)) in chirps[..281].iter().enumerate() {
        assert_eq!(*stamp_ns, BEGIN_NS + 10_000_000 * k as u64);
        let json: Value = serde_json::from_slice(message).unwrap();
        assert_eq!(json["chirp"], k);
        assert_eq!(json["angle_deg"], recording.meta.angles_deg[k]);
        let samples = recording.chirp(k).unwrap();
        for (part, value) in [("i", samples[7].i), ("q", samples[7].q)] {
            assert_eq!(json[part][7], value);
            assert_eq!(json[part].as_array().unwrap().len(), samples.len());
        }
    }
    assert_eq!(chirps[281].1, BEGIN_NS + 3_800_000_000);
    let answers = kept.of(Stream::Scan(Topic::Answer));
    assert_eq!(answers.len(), 1);
    assert_eq!(answers[0].1, BEGIN_NS + 2_800_000_000);
}

/// The map's cells as `convert --table map` writes them.
#[test]
fn the_picture_of_the_map_holds_its_cells() {
    let recording = stair_a();
    let kept = played(&recording, 1.0, &[Stream::Map]);
    let (message, _) = &kept.of(Stream::Map)[0];
    let cells = &scans::of(&recording, &Options::default(), true).unwrap()[0].cells;
    let data = &message[message.len() - cells.len()..];
    for (pixel, cell) in data.iter().zip(cells) {
        use stairscan::signal::grid::DB_PER_UNIT;
        use stairscan::signal::range::FULL_SCALE;
        let power_db = (f32::from(*pixel) - f32::from(FULL_SCALE)) * DB_PER_UNIT;
        assert_eq!(power_db, cell.power_db);
    }
}

#[test]
fn a_recording_that_no_scan_can_be_made_of_is_refused() {
    let mut recording = stair_a();
    recording.meta.mirror = None;
    let kept = Kept::subscribed(&[]);
    let mut clock = Hurried {
        now_ns: 0,
        end_ns: 0,
    };
    let options = Options::default();
    let error = player::play(recording, &options, &kept, &mut clock, &mut |_| ());
    assert!(error.is_err());
}

#[test]
fn addresses_are_read_and_bad_ones_explained() {
    let read = |text| address::parse(text).map(|address| address.to_string());
    for (text, expected) in [
        (address::DEFAULT, "127.0.0.1:8765"),
        ("9000", "127.0.0.1:9000"),
        ("localhost:80", "127.0.0.1:80"),
        ("0.0.0.0:8765", "0.0.0.0:8765"),
        ("[::1]:8765", "[::1]:8765"),
    ] {
        assert_eq!(read(text).unwrap(), expected);
    }
    for text in [
        "",
        "/dev/ttyUSB0",
        "127.0.0.1",
        "127.0.0.1:65536",
        "here:1",
        "-1",
    ] {
        let error = read(text).unwrap_err();
        assert!(error.contains("127.0.0.1:8765"), "{text}: {error}");
    }
    let warned = |text: &str| address::warning(text.parse::<SocketAddr>().unwrap()).is_some();
    assert!(warned("0.0.0.0:1") && warned("192.0.2.1:1") && warned("[::]:1"));
    assert!(!warned("127.0.0.1:1") && !warned("127.9.9.9:1") && !warned("[::1]:1"));
}

#[test]
fn a_place_that_is_taken_is_reported_with_its_address() {
    let address: SocketAddr = address::parse("9000").unwrap();
    let taken = std::io::Error::from(std::io::ErrorKind::AddrInUse);
    let text = address::trouble(address, &taken);
    assert!(
        text.starts_with("--foxglove 127.0.0.1:9000: in use"),
        "{text}"
    );
}

#[test]
fn interfaces_and_domains_are_read_and_bad_ones_explained() {
    assert!(address::interface("localhost").unwrap().is_loopback());
    assert!(address::interface("0.0.0.0").unwrap().is_unspecified());
    for text in ["", "/dev/ttyUSB0", "127.0.0.1:7400", "eth0", "::1"] {
        let error = address::interface(text).unwrap_err();
        assert!(error.contains("IPv4 address"), "{text}: {error}");
    }
    let warned = |text: &str| address::interface_warning(text.parse().unwrap()).is_some();
    assert!(warned("0.0.0.0") && warned("192.0.2.1") && !warned("127.0.0.1"));
    assert_eq!(address::domain(Some(7), Some("9")), Ok(7));
    assert_eq!(address::domain(None, Some("9")), Ok(9));
    assert_eq!(address::domain(None, Some("")), Ok(0));
    assert_eq!(address::domain(None, None), Ok(0));
    for text in ["233", "-1", "one", "65536"] {
        let error = address::domain(None, Some(text)).unwrap_err();
        assert!(
            error.starts_with(&format!("ROS_DOMAIN_ID={text}: ")) && error.contains("232"),
            "{error}"
        );
    }
}

#[test]
fn the_frame_of_coordinates_lies_on_the_ground_below_the_mirror() {
    let frames = Frames {
        frame: "front".to_owned(),
        base: "chair".to_owned(),
        mount: [0.3, -0.1, 0.45],
    };
    let [mirror, ground] = &frames.message(SECOND_NS).transforms[..] else {
        panic!("two transforms");
    };
    assert_eq!(mirror.header.frame_id, "chair");
    assert_eq!(mirror.child_frame_id, "front_mirror");
    assert_eq!(ground.header.frame_id, mirror.child_frame_id);
    assert_eq!(ground.child_frame_id, "front");
    let [up, down] = [mirror, ground].map(|part| part.transform.position);
    assert_eq!([up.x, up.y, up.z], frames.mount);
    assert_eq!([down.x, down.y, down.z], [0.0, 0.0, -0.45]);
}
