use std::fs;
use std::path::{Path, PathBuf};

use stairscan::Iq;

use super::keys::Given;
use super::*;
use crate::recording::Recording;
use crate::replay::Options;

fn repository(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../recordings")
        .join(name)
}

fn recorded(name: &str) -> Recording {
    Recording::read(&repository(name)).unwrap()
}

/// Temporary directory of one test.
struct Scratch(PathBuf);

impl Scratch {
    fn new(test: &str) -> Self {
        let dir = std::env::temp_dir().join(format!("stairscan-{test}-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        Self(dir)
    }

    fn put(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, bytes).unwrap();
        path
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn arrays_come_back_bit_for_bit() {
    let scratch = Scratch::new("npy");
    let recording = recorded("stair_a");
    for complex in [false, true] {
        let path = scratch.put("chirps.npy", &npy::write(&recording, complex));
        let source = Source {
            path,
            keys_of: Some(repository("stair_a")),
            ..Source::default()
        };
        let back = source.read("stair_a").unwrap();
        assert_eq!(back.samples, recording.samples);
        let (there, here) = (back.metadata_text(), recording.metadata_text());
        assert_eq!(there.unwrap(), here.unwrap());
        assert_eq!(npy::write(&back, complex), npy::write(&recording, complex));
    }
}

/// Real samples of a 12-bit converter, as frames of two receivers: the first of two chirps holds a tone of 7
/// cycles, which beats in bin 7 of the range profile.
#[test]
fn an_array_of_real_samples_is_a_recording_of_real_samples() {
    let scratch = Scratch::new("real");
    let code = |frame: u16, receiver: u16, n: u16| -> u16 {
        let turn = std::f64::consts::TAU * 7.0 * f64::from(n) / 64.0;
        let level = f64::from(1000 * receiver - 400 * receiver * frame);
        (2048.0 + level * turn.cos()).round() as u16
    };
    let places = (0..2).flat_map(|frame| (0..2).map(move |receiver| (frame, receiver)));
    let places = places.flat_map(|(frame, receiver)| (0..64).map(move |n| (frame, receiver, n)));
    let codes = places.map(|(frame, receiver, n)| code(frame, receiver, n));
    let header = "{'descr': '<u2', 'fortran_order': False, 'shape': (2, 2, 1, 64), }";
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.bytes().chain(codes.flat_map(u16::to_le_bytes)));
    let source = Source {
        path: scratch.put("radar.npy", &file),
        real: Some("frame,receiver=1,chirp,sample".parse().unwrap()),
        full_scale: Some(2048.0),
        given: Given {
            bandwidth_hz: Some(5.5e9),
            samples_per_chirp: Some(64),
            ..Given::default()
        },
        ..Source::default()
    };
    let made = source.read("radar").unwrap();
    assert_eq!((made.chirps(), made.meta.file_samples()), (2, 64));
    assert!(made.meta.real);
    let first = made.samples.first().unwrap();
    assert_eq!(first.i, 16 * 1000);
    let written = scratch.put("made.sigmf-meta", made.metadata_text().unwrap().as_bytes());
    scratch.put("made.sigmf-data", &made.sample_bytes());
    let back = Recording::read(&written).unwrap();
    assert_eq!(back.samples, made.samples);
    let profile = crate::commands::profile::profile(&back, &Default::default(), 0).unwrap();
    let strongest = profile.power_db.iter().enumerate();
    let strongest = strongest.max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
    assert_eq!(strongest.0, 7);
    // 20 lg (1000 / 2048).
    assert!((strongest.1 + 6.2).abs() < 0.2, "{strongest:?}");
    for (real, words) in [
        (None, "shape [2, 2, 1, 64]"),
        (Some("chirp,sample"), "4 axes, --real names 2"),
    ] {
        let wrong = Source {
            real: real.map(|axes| axes.parse().unwrap()),
            ..source.clone()
        };
        let error = format!("{:#}", wrong.read("x").unwrap_err());
        assert!(error.contains(words), "{error}");
    }
    let recording = Source {
        path: repository("stair_a"),
        ..source
    };
    let error = format!("{:#}", recording.read("x").unwrap_err());
    assert!(error.contains("expected .npy"), "{error}");
}

/// The scan of an array with all I, then all Q in its rows is that of the recording; taken for pairs, it is noticed.
#[test]
fn an_array_of_planes_is_a_scan() {
    let scratch = Scratch::new("planar");
    let recording = recorded("stair_a");
    let header = "{'descr': '<i2', 'fortran_order': False, 'shape': (281, 400), }";
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.bytes());
    for chirp in (0..281).filter_map(|k| recording.chirp(k)) {
        let numbers = chirp.iter().map(|s| s.i).chain(chirp.iter().map(|s| s.q));
        file.extend(numbers.flat_map(i16::to_le_bytes));
    }
    let source = Source {
        path: scratch.put("planar.npy", &file),
        keys_of: Some(repository("stair_a")),
        planar: true,
        ..Source::default()
    };
    let made = source.read("stair_a").unwrap();
    assert_eq!(made.samples, recording.samples);
    let warned =
        |recording: &Recording| stairscan_replay::convert::mirrored::warning(recording).unwrap();
    assert_eq!(warned(&made), None);
    let pairs = Source {
        planar: false,
        ..source.clone()
    };
    let warning = warned(&pairs.read("x").unwrap()).unwrap();
    assert!(warning.contains("--planar"), "{warning}");
    let other = Source {
        path: repository("stair_a"),
        ..source
    };
    let error = format!("{:#}", other.read("x").unwrap_err());
    assert!(
        error.contains("--planar") && error.contains("expected .npy"),
        "{error}"
    );
}

#[test]
fn keys_given_one_by_one_make_the_same_scan() {
    let scratch = Scratch::new("flags");
    let recording = recorded("stair_b");
    let angles: Vec<String> = recording
        .meta
        .angles_deg
        .iter()
        .map(f64::to_string)
        .collect();
    let mirror = recording.scan_setup().unwrap();
    let source = Source {
        path: scratch.put("chirps.npy", &npy::write(&recording, true)),
        angles: Some(scratch.put("angles.csv", angles.join("\n").as_bytes())),
        given: Given {
            bandwidth_hz: Some(recording.meta.bandwidth_hz),
            sample_rate_hz: recording.meta.sample_rate_hz,
            mirror_offset_m: Some(mirror.offset_m),
            beamwidth_deg: Some(mirror.beamwidth_deg),
            mount_height_m: Some(mirror.mount_height_m),
            scan_plane: Some("depth".into()),
            ..Given::default()
        },
        ..Source::default()
    };
    let made = source.read("stair_b").unwrap();
    let summary = |recording: &Recording| {
        crate::replay::answer(recording, &Options::default())
            .unwrap()
            .sentences
    };
    assert_eq!(summary(&made), summary(&recording));
    let fewer = Source {
        angles: Some(scratch.put("fewer.csv", b"1\n2\n")),
        ..source.clone()
    };
    let error = format!("{:#}", fewer.read("x").unwrap_err());
    assert!(
        error.contains("fewer.csv: 2 angles, expected 281: one a chirp of"),
        "{error}"
    );
    let twice = Source {
        angles: Some(scratch.put("twice.csv", "10\n".repeat(281).as_bytes())),
        ..source
    };
    let error = format!("{:#}", twice.read("x").unwrap_err());
    assert!(
        error.contains("chirps.npy: captures[1] stairscan:mirror_angle_deg"),
        "{error}"
    );
}

#[test]
fn sigmf_of_others_is_read_with_what_it_lacks() {
    let scratch = Scratch::new("sigmf");
    let recording = recorded("empty");
    let floats = recording.samples.iter().flat_map(|s| [s.i, s.q]);
    let floats: Vec<u8> = floats
        .flat_map(|v| (f32::from(v) / 32768.0).to_be_bytes())
        .collect();
    scratch.put("other.sigmf-data", &floats);
    let meta = r#"{"global": {"core:datatype": "cf32_be", "core:version": "1.0.0"},
                   "captures": [{"core:sample_start": 0, "core:frequency": 77e9}]}"#;
    let source = Source {
        path: scratch.put("other.sigmf-meta", meta.as_bytes()),
        ..Source::default()
    };
    let error = format!("{:#}", source.read("x").unwrap_err());
    assert!(error.contains("--samples-per-chirp"), "{error}");
    let given = Given {
        samples_per_chirp: Some(200),
        ..Given::default()
    };
    let source = Source { given, ..source };
    let error = format!("{:#}", source.read("x").unwrap_err());
    assert!(
        error.contains("stairscan:bandwidth_hz (--bandwidth-hz)"),
        "{error}"
    );
    let given = Given {
        bandwidth_hz: Some(4e9),
        ..source.given.clone()
    };
    let made = Source { given, ..source }.read("x").unwrap();
    assert_eq!(made.samples, recording.samples);
    assert_eq!((made.meta.carrier_hz, made.meta.bandwidth_hz), (77e9, 4e9));
}

/// Metadata of `stair_a` by another program: `global` beyond datatype and rate, and the first capture's start.
fn foreign(global: &str, start: usize) -> String {
    format!(
        r#"{{"global": {{"core:datatype": "ci16_le", "core:sample_rate": 200000, {global}}},
            "captures": [{{"core:sample_start": {start}}}], "annotations": [{{"core:sample_start": 0}}]}}"#
    )
}

#[test]
fn a_first_capture_may_begin_late() {
    let scratch = Scratch::new("late");
    let recording = recorded("stair_a");
    let given = Given {
        bandwidth_hz: Some(10e9),
        samples_per_chirp: Some(200),
        ..Given::default()
    };
    // 800 samples of something else before the recording's.
    let data = [&[1; 3200], &recording.sample_bytes()[..]].concat();
    scratch.put("late.sigmf-data", &data);
    let read = |global: &str, start| {
        let source = Source {
            path: scratch.put("late.sigmf-meta", foreign(global, start).as_bytes()),
            given: given.clone(),
            ..Source::default()
        };
        source.read("x").map_err(|error| format!("{error:#}"))
    };
    for (global, start) in [(r#""x:y": 1"#, 800), (r#""core:offset": 1000"#, 1800)] {
        let made = read(global, start).unwrap();
        assert_eq!(made.samples, recording.samples, "{global}");
        assert!(!made.metadata_text().unwrap().contains("core:offset"));
    }
    assert_eq!(read(r#""core:offset": 1000"#, 1000).unwrap().chirps(), 285);
    let error = read(r#""core:offset": 1000"#, 800).unwrap_err();
    assert!(
        error.contains("captures[0] core:sample_start: found 800, expected 1000"),
        "{error}"
    );
    let error = read(r#""core:sha512": "00""#, 800).unwrap_err();
    assert!(error.contains("core:sha512"), "{error}");
    let error = read(&format!(r#""core:sha512": "{}""#, "0".repeat(128)), 800).unwrap_err();
    assert!(error.contains("the samples' checksum is"), "{error}");
    // A recording that is complete otherwise: read as it is, the start is named; `convert` leaves out what is before.
    let keys = r#""stairscan:bandwidth_hz": 1e10, "stairscan:samples_per_chirp": 200"#;
    let path = scratch.put("late.sigmf-meta", foreign(keys, 800).as_bytes());
    let error = format!("{:#}", Recording::read(&path).unwrap_err());
    assert!(
        error.contains("captures[0] core:sample_start: found 800, expected 0"),
        "{error}"
    );
    let source = Source {
        path,
        ..Source::default()
    };
    assert_eq!(source.read("x").unwrap().samples, recording.samples);
}

#[test]
fn keys_of_a_recording_are_all_taken_and_the_input_keeps_its_author() {
    let scratch = Scratch::new("keys-of");
    let recording = recorded("stair_a");
    let global =
        r#""core:author": "A. Author", "core:license": "CC0-1.0", "core:description": "mine""#;
    scratch.put("foreign.sigmf-data", &recording.sample_bytes());
    let source = Source {
        path: scratch.put("foreign.sigmf-meta", foreign(global, 0).as_bytes()),
        keys_of: Some(repository("stair_a")),
        ..Source::default()
    };
    let made = source.read("x").unwrap();
    assert_eq!((made.chirps(), &made.samples), (281, &recording.samples));
    assert_eq!(made.meta.angles_deg, recording.meta.angles_deg);
    assert_eq!(made.meta.extra["core:author"], "A. Author");
    assert_eq!(made.meta.extra["core:license"], "CC0-1.0");
    assert_eq!(made.meta.description, "mine");
}

#[test]
fn a_byte_order_mark_is_no_part_of_a_text() {
    let scratch = Scratch::new("mark");
    let recording = recorded("stair_a");
    scratch.put("bom.sigmf-data", &recording.sample_bytes());
    let marked = format!("\u{feff}{}", recording.metadata_text().unwrap());
    let path = scratch.put("bom.sigmf-meta", marked.as_bytes());
    assert_eq!(Recording::read(&path).unwrap().samples, recording.samples);
    let parsed = Recording::parse("bom", &marked, &recording.sample_bytes()).unwrap();
    assert_eq!(parsed.samples, recording.samples);
    let source = |keys_of| Source {
        path: path.clone(),
        keys_of,
        ..Source::default()
    };
    for keys_of in [None, Some(path.clone())] {
        assert_eq!(
            source(keys_of).read("x").unwrap().samples,
            recording.samples
        );
    }
    scratch.put("bom.sigmf-meta", b"\xff\xfe{\0}\0");
    let error = format!("{:#}", Recording::read(&path).unwrap_err());
    assert!(
        error.contains("bom.sigmf-meta: the byte order mark of UTF-16"),
        "{error}"
    );
    let error = format!("{:#}", source(None).read("x").unwrap_err());
    assert!(
        error.contains("bom.sigmf-meta: the byte order mark of UTF-16"),
        "{error}"
    );
}

/// Real samples of another program: 16 bits as in a recording, here big-endian and without keys.
#[test]
fn real_samples_of_others_are_read() {
    let scratch = Scratch::new("real-sigmf");
    let recording = recorded("stair_a");
    let data = recording.samples.iter().flat_map(|s| [s.i, s.q]);
    let data: Vec<u8> = data.flat_map(i16::to_be_bytes).collect();
    scratch.put("real.sigmf-data", &data);
    let meta = foreign(r#""x:y": 1"#, 0).replace("ci16_le", "ri16_be");
    let source = Source {
        path: scratch.put("real.sigmf-meta", meta.as_bytes()),
        given: Given {
            bandwidth_hz: Some(10e9),
            samples_per_chirp: Some(400),
            ..Given::default()
        },
        ..Source::default()
    };
    let made = source.read("x").unwrap();
    assert!(made.meta.real);
    assert_eq!((made.chirps(), made.meta.file_samples()), (281, 400));
    assert_eq!(made.samples, recording.samples);
}

#[test]
fn a_capture_is_read_with_its_setup() {
    let scratch = Scratch::new("dca");
    // Two lanes, one receiver: I I Q Q.
    let words = |chirp: &[Iq]| -> Vec<u8> {
        let pairs = chirp.as_chunks::<2>().0.iter();
        pairs
            .flat_map(|[a, b]| [a.i, b.i, a.q, b.q])
            .flat_map(i16::to_le_bytes)
            .collect()
    };
    let recording = recorded("stair_c");
    let chirps = (0..recording.chirps()).filter_map(|k| recording.chirp(k));
    let file: Vec<u8> = chirps.flat_map(words).collect();
    let source = Source {
        path: scratch.put("adc_data.bin", &file),
        keys_of: Some(repository("stair_c")),
        ..Source::default()
    };
    let error = format!("{:#}", source.read("x").unwrap_err());
    assert!(
        error.contains("adc_data.toml") && error.contains("--setup"),
        "{error}"
    );
    let setup = "adc_bits = 16\nlanes = 2\nreceivers = 1\nreceiver = 0\nsamples_per_chirp = 200\n\
                 chirps_per_frame = 1\ncomplex = true\n";
    scratch.put("adc_data.toml", setup.as_bytes());
    assert_eq!(source.read("x").unwrap().samples, recording.samples);
}

#[test]
fn tables_say_what_the_json_says() {
    let scans = scans::of(&recorded("stair_a"), &Options::default(), true).unwrap();
    let read = |table| {
        let bytes = tables::write(&scans, table).unwrap();
        let mut csv = csv::Reader::from_reader(&bytes[..]);
        let head = csv.headers().unwrap().clone();
        let rows: Vec<_> = csv.records().map(Result::unwrap).collect();
        (head, rows)
    };
    let (head, rows) = read(tables::Table::Steps);
    let steps = scans[0].json["steps"].as_array().unwrap();
    assert_eq!(rows.len(), steps.len());
    for (row, step) in rows.iter().zip(steps) {
        let column = head
            .iter()
            .position(|name| name == "distance_sigma_m")
            .unwrap();
        assert_eq!(row[column], step["distance_sigma_m"].to_string());
    }
    let (_, echoes) = read(tables::Table::Echoes);
    assert_eq!(echoes.len(), scans[0].echoes.as_ref().unwrap().len());
    let (_, cells) = read(tables::Table::Map);
    assert_eq!(cells.len(), scans[0].cells.len());
    assert!(cells.len() > 50_000);
}

/// A drop is in every row of the table, and among the markers.
#[test]
fn a_drop_stands_in_table_and_markers() {
    let mut scans = scans::of(&recorded("stair_a"), &Options::default(), false).unwrap();
    let bare = mcap::write(&scans, &[]).unwrap();
    scans[0].json["drop"] = serde_json::json!({
        "distance_m": 1.5,
        "distance_sigma_m": 0.02,
        "depth_m": null,
        "probability": 0.974,
    });
    let bytes = tables::write(&scans, tables::Table::Steps).unwrap();
    let mut csv = csv::Reader::from_reader(&bytes[..]);
    let head = csv.headers().unwrap().clone();
    let column = |name: &str| head.iter().position(|n| n == name).unwrap();
    let rows: Vec<_> = csv.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 3);
    for row in rows {
        assert_eq!(&row[column("drop_distance_m")], "1.5");
        assert_eq!(&row[column("drop_depth_m")], "");
        assert_eq!(row[column("free_m")], scans[0].json["free_m"].to_string());
    }
    let with = mcap::write(&scans, &[]).unwrap();
    let has = |file: &[u8]| file.windows(12).any(|w| w == b"drop 3 sigma");
    assert!(has(&with) && !has(&bare));
}

/// A fault has a row in the table although it has no steps.
#[test]
fn a_scan_without_steps_has_a_row() {
    let scans = scans::of(&recorded("empty"), &Options::default(), false).unwrap();
    let text = String::from_utf8(tables::write(&scans, tables::Table::Steps).unwrap()).unwrap();
    assert_eq!(text.lines().count(), 2, "{text}");
    assert!(
        text.lines().last().unwrap().starts_with("empty,1,"),
        "{text}"
    );
}

#[test]
fn the_same_recording_gives_the_same_file_with_times_of_its_own() {
    let recording = recorded("stair_a");
    let scans = || scans::of(&recording, &Options::default(), false).unwrap();
    let (once, again) = (
        mcap::write(&scans(), &[]).unwrap(),
        mcap::write(&scans(), &[]).unwrap(),
    );
    assert!(once == again);
    assert_eq!(scans()[0].stamp_ns, 1_000_000_000);
    let mut timed = recording.clone();
    timed.meta.motion.time_s = (0..281).map(|k| 0.005 * f64::from(k)).collect();
    let scans = scans::of(&timed, &Options::default(), false).unwrap();
    assert_eq!(scans[0].stamp_ns, 1_400_000_000);
}

#[test]
fn a_file_that_is_none_is_named_once() {
    for name in ["/nowhere/x.npy", "/nowhere/x.bin", "/nowhere/x"] {
        let source = Source {
            path: name.into(),
            ..Source::default()
        };
        let error = format!("{:#}", source.read("x").unwrap_err());
        assert_eq!(error.matches("/nowhere/x").count(), 1, "{error}");
    }
}

/// Metadata keep JSON's shortest decimals; a quick parser would read this number with another last
/// bit.
#[test]
fn metadata_comes_back_to_the_last_bit() {
    let mut recording = recorded("stair_a");
    let height = 1.0380971953742097;
    recording.meta.mirror.as_mut().unwrap().mount_height_m = height;
    let text = recording.metadata_text().unwrap();
    let data: Vec<u8> = (recording.samples.iter())
        .flat_map(|s| [s.i, s.q])
        .flat_map(i16::to_le_bytes)
        .collect();
    let back = Recording::parse("stair_a", &text, &data).unwrap();
    assert_eq!(back.scan_setup().unwrap().mount_height_m, height);
    assert_eq!(back.metadata_text().unwrap(), text);
}
