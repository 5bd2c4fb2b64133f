//! Tests of the command over pseudo-terminals.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};

use host_sim::emulate::Module;
use host_sim::playback::Playback;
use host_sim::recording::Recording;
use host_sim::setup::{self, Kind};
use host_sim::tap::scans::Wire;
use serialport::{SerialPort, TTYPort};
use stairscan::config::Config;
use stairscan::signal::radar::frame::{self, FrameKind, MAX_FRAME};

use super::bench::{read, scan};
use crate::common::{Scratch, sim};

/// Opens a pseudo-terminal: one end that waits for its reader, and the path of the other.
fn terminal() -> (TTYPort, TTYPort, String) {
    let (master, slave) = TTYPort::pair().unwrap();
    let path = slave.name().unwrap();
    // The copies, unlike the original pair, are closed in child processes.
    let (mut master, slave) = (
        master.try_clone_native().unwrap(),
        slave.try_clone_native().unwrap(),
    );
    master.set_timeout(Duration::from_secs(60)).unwrap();
    (master, slave, path)
}

/// Starts the program and waits until it listens.
fn listening(args: &[&str]) -> (Child, BufReader<ChildStderr>) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(args)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    stderr.read_line(&mut line).unwrap();
    assert!(line.starts_with("receiving"), "{line}");
    (child, stderr)
}

/// Writes the link's traffic to the ports to and from the module. `before` is called with the time of each piece.
fn feed<T: Copy>(
    traffic: &[(T, Wire, Vec<u8>)],
    [to, from]: [&mut TTYPort; 2],
    mut before: impl FnMut(T),
) {
    for (at, wire, bytes) in traffic {
        before(*at);
        let port = match wire {
            Wire::ToModule => &mut *to,
            Wire::FromModule | Wire::Both => &mut *from,
        };
        port.write_all(bytes).unwrap();
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Three ports: a receiver on each direction of the link, and the report port.
#[test]
fn three_ports_are_recorded() {
    let scanned = scan(&read("stair_a"), &Config::default(), 2, &[]);
    let dir = Scratch::new("record-ports");
    let output = dir.path().join("hall");
    let (mut to, _to, to_path) = terminal();
    let (mut from, _from, from_path) = terminal();
    let (mut report, _report, report_path) = terminal();
    let output = output.to_str().unwrap();
    let args = [
        "record",
        &to_path,
        &from_path,
        "-o",
        output,
        "--report",
        &report_path,
    ];
    let (mut child, mut stderr) = listening(&[&args[..], &["--ask", "--scans", "2"]].concat());
    let mut asked = [0; 5];
    report.read_exact(&mut asked).unwrap();
    assert_eq!(&asked, b"get\r\n");
    let mut lines = scanned.beside.lines.iter().peekable();
    feed(&scanned.traffic, [&mut to, &mut from], |at| {
        while let Some((_, line)) = lines.next_if(|(when, _)| *when <= at) {
            report.write_all(format!("{line}\r\n").as_bytes()).unwrap();
        }
    });
    for (_, line) in lines {
        report.write_all(format!("{line}\r\n").as_bytes()).unwrap();
    }
    let mut printed = String::new();
    child
        .stdout
        .take()
        .unwrap()
        .read_to_string(&mut printed)
        .unwrap();
    let mut notes = String::new();
    stderr.read_to_string(&mut notes).unwrap();
    assert!(child.wait().unwrap().success(), "{notes}");
    assert!(
        printed.contains("hall: 2 scans of 281 rows, -20.00° to 50.00°"),
        "{printed}"
    );
    assert!(
        printed.contains("the scanner's own sentences for 2 of 2 scans"),
        "{printed}{notes}"
    );
    let recording = Recording::read(output.as_ref()).unwrap();
    assert_eq!(recording.scans(), 2);
    let kept = std::fs::read_to_string(dir.path().join("hall.sentences")).unwrap();
    for line in scanned.answers.iter().flatten() {
        assert_eq!(
            kept.matches(line.as_str()).count(),
            2,
            "said and replayed: {line}"
        );
    }
}

/// Returns a frame of the link.
fn encoded(kind: FrameKind, payload: &[u8]) -> Vec<u8> {
    let mut out = heapless::Vec::<u8, MAX_FRAME>::new();
    frame::encode(kind, 9, payload, &mut out);
    out.to_vec()
}

/// Sends bytes of another speed until the reader's end of a terminal has the rate `baud`.
fn garbage_until(baud: u32, master: &mut TTYPort, slave: &TTYPort) {
    let until = Instant::now() + Duration::from_secs(60);
    while slave.baud_rate().unwrap() != baud {
        assert!(Instant::now() < until, "not at {baud} baud");
        master.write_all(&[0x55; 250]).unwrap();
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn the_links_rate_is_followed() {
    let scanned = scan(&read("stair_a"), &Config::default(), 1, &[]);
    let dir = Scratch::new("record-rate");
    let output = dir.path().join("hall");
    let (mut master, slave, path) = terminal();
    let output = output.to_str().unwrap();
    let (mut child, mut stderr) = listening(&["record", &path, "-o", output, "--scans", "3"]);
    let feed_scan = |master: &mut TTYPort| {
        for (_, _, bytes) in &scanned.traffic {
            master.write_all(bytes).unwrap();
        }
    };
    // At work at 2 Mbaud before the recording began.
    garbage_until(2_000_000, &mut master, &slave);
    feed_scan(&mut master);
    // An agreement.
    master.write_all(&encoded(FrameKind::Rate, &[3])).unwrap();
    master
        .write_all(&encoded(FrameKind::RateSet, &[3]))
        .unwrap();
    let until = Instant::now() + Duration::from_secs(60);
    while slave.baud_rate().unwrap() != 3_000_000 {
        assert!(Instant::now() < until, "not at 3 Mbaud");
        std::thread::sleep(Duration::from_millis(2));
    }
    feed_scan(&mut master);
    // A break: back at 1 Mbaud.
    garbage_until(1_000_000, &mut master, &slave);
    feed_scan(&mut master);
    master
        .write_all(&encoded(FrameKind::Configure, &[]))
        .unwrap();
    let mut notes = String::new();
    stderr.read_to_string(&mut notes).unwrap();
    assert!(child.wait().unwrap().success(), "{notes}");
    assert!(
        notes.contains("scanner and module go to 3000000 baud"),
        "{notes}"
    );
    let whole = notes.matches("scan: 281 rows, 0 of them lost").count();
    assert_eq!(whole, 3, "{notes}");
}

#[test]
fn a_rate_that_the_port_cannot_follow_is_named() {
    let dir = Scratch::new("record-deaf");
    let output = dir.path().join("hall");
    let (mut master, slave, path) = terminal();
    let (mut child, mut stderr) = listening(&["record", &path, "-o", output.to_str().unwrap()]);
    master
        .write_all(&encoded(FrameKind::RateSet, &[3]))
        .unwrap();
    for _ in 0..20 {
        master.write_all(&[0x55; 800]).unwrap();
        std::thread::sleep(Duration::from_millis(5));
    }
    drop((master, slave));
    let mut notes = String::new();
    stderr.read_to_string(&mut notes).unwrap();
    assert!(!child.wait().unwrap().success());
    assert!(
        notes.contains("--baud 3000000, or `set link-rate 1000000`"),
        "{notes}"
    );
}

#[test]
fn the_module_itself_is_asked() {
    let original = read("stair_a");
    let dir = Scratch::new("record-module");
    let output = dir.path().join("bench");
    let (mut master, _slave, path) = terminal();
    master.set_timeout(Duration::from_millis(5)).unwrap();
    let program = std::thread::spawn({
        let output = output.clone();
        move || sim(&["record", &path, "--module", "-o", output.to_str().unwrap()])
    });
    let playback = Playback::new(&original, &Config::default()).unwrap();
    let mut module = Module::new(&playback);
    module.get_ready();
    let mut buffer = [0; 256];
    while !program.is_finished() {
        if let Ok(count) = master.read(&mut buffer) {
            let (answer, _) = module.receive(&buffer[..count]);
            master.set_timeout(Duration::from_secs(10)).unwrap();
            master.write_all(&answer).unwrap();
            master.set_timeout(Duration::from_millis(5)).unwrap();
        }
    }
    let output_of = program.join().unwrap();
    let printed = String::from_utf8(output_of.stderr).unwrap();
    assert!(output_of.status.success(), "{printed}");
    assert!(
        printed.contains("assumed are plane depth, mirror offset 0.22 m"),
        "{printed}"
    );
    let recording = Recording::read(&output).unwrap();
    assert_eq!(recording.samples, original.samples);
    assert_eq!(recording.meta.angles_deg, original.meta.angles_deg);
}

#[test]
fn a_module_that_is_not_there_is_reported() {
    let dir = Scratch::new("record-no-module");
    let output = dir.path().join("bench");
    let (_master, _slave, path) = terminal();
    let output_of = sim(&["record", &path, "--module", "-o", output.to_str().unwrap()]);
    let printed = String::from_utf8(output_of.stderr).unwrap();
    assert!(!output_of.status.success());
    assert!(
        printed.contains("does not report its settings: nothing was received"),
        "{printed}"
    );
}

#[test]
fn what_cannot_be_recorded_is_explained() {
    let refused = |args: &[&str], words: &str| {
        let output = sim(args);
        let printed = String::from_utf8(output.stderr).unwrap();
        assert!(
            !output.status.success() && printed.contains(words),
            "{printed}"
        );
    };
    refused(
        &["record", "/dev/no-such-port", "-o", "x"],
        "no /dev/no-such-port",
    );
    refused(&["record", "-o", "x"], "PORT");
    let module = ["record", "a", "--module", "-o", "x", "--angles"];
    refused(
        &[&module[..], &["1:2"]].concat(),
        "expected FIRST:LAST:STEP",
    );
    let dir = Scratch::new("record-nothing");
    let output = dir.path().join("x");
    let (mut master, slave, path) = terminal();
    let (mut child, mut stderr) = listening(&["record", &path, "-o", output.to_str().unwrap()]);
    // Frames at another baud rate, and then the plug is pulled.
    master
        .write_all(&[b"SR\x01\x82".as_slice(), &[0x55; 2000]].concat())
        .unwrap();
    std::thread::sleep(Duration::from_millis(500));
    drop((master, slave));
    let mut printed = String::new();
    stderr.read_to_string(&mut printed).unwrap();
    assert!(!child.wait().unwrap().success());
    assert!(
        printed.contains("has gone") && printed.contains("1000000 baud"),
        "{printed}"
    );
    assert!(!output.with_extension("sigmf-meta").exists());
}

/// A program that is killed leaves every completed scan.
#[test]
fn a_killed_session_leaves_its_scans() {
    let original = read("stair_a");
    let scanned = scan(&original, &Config::default(), 2, &[]);
    let dir = Scratch::new("record-killed");
    let output = dir.path().join("hall");
    let (mut to, _to, to_path) = terminal();
    let (mut from, _from, from_path) = terminal();
    let output = output.to_str().unwrap();
    let args = ["record", &to_path, &from_path, "-o", output];
    let (mut child, mut stderr) = listening(&args);
    feed(&scanned.traffic, [&mut to, &mut from], |_| ());
    // The first line is printed when the first scan is complete.
    let mut line = String::new();
    stderr.read_line(&mut line).unwrap();
    assert!(line.starts_with("scan: 281 rows, 0 of them lost"), "{line}");
    child.kill().unwrap();
    child.wait().unwrap();
    let left = dir.path().join("hall.unfinished");
    let kept = Recording::read(&left.join("hall-scan0001")).unwrap();
    assert_eq!(kept.samples, original.samples);
    assert_eq!(kept.meta.angles_deg, original.meta.angles_deg);
    let replayed = sim(&["replay", left.to_str().unwrap(), "--format", "json"]);
    assert!(replayed.status.success());
    // The next session does not mix its scans with them.
    let again = sim(&args);
    let printed = String::from_utf8(again.stderr).unwrap();
    assert!(!again.status.success(), "{printed}");
    assert!(
        printed.contains("hall.unfinished: holds the scans of an interrupted session"),
        "{printed}"
    );
}

#[test]
fn the_demo_needs_no_hardware() {
    let dir = Scratch::new("record-demo");
    let output = dir.path().join("hall");
    let output = output.to_str().unwrap();
    let original = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/stair_a");
    let done = sim(&["record", "--demo", original, "-o", output]);
    let printed = String::from_utf8(done.stderr).unwrap();
    assert!(done.status.success(), "{printed}");
    let recording = Recording::read(output.as_ref()).unwrap();
    assert_eq!(recording.samples, read("stair_a").samples);
    let mut left: Vec<String> = std::fs::read_dir(dir.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    left.sort();
    assert_eq!(
        left,
        ["hall.sentences", "hall.sigmf-data", "hall.sigmf-meta"]
    );
    // Without `--force` none of them is replaced.
    let done = sim(&["record", "--demo", original, "-o", output]);
    let printed = String::from_utf8(done.stderr).unwrap();
    assert!(
        !done.status.success() && printed.contains("--force"),
        "{printed}"
    );
}

/// Without the report port guard sweeps are recognised by their angles, or by those that the user gives.
#[test]
fn guard_sweeps_are_stored_as_such_without_the_report_port() {
    let mut original = read("guard_kerb");
    for (given, shift) in [(None, 0.0), (Some("5:35:1"), -3.0)] {
        let angles = &mut original.meta.angles_deg;
        angles.iter_mut().for_each(|angle| *angle += shift);
        let scanned = scan(&original, &Config::default(), 3, &[]);
        let dir = Scratch::new("record-guard-port");
        let output = dir.path().join("hall");
        let output = output.to_str().unwrap();
        let (mut to, _to, to_path) = terminal();
        let (mut from, _from, from_path) = terminal();
        let args = ["record", &to_path, &from_path, "-o", output, "--scans", "2"];
        let more = given.iter().flat_map(|angles| ["--guard", angles]);
        let args: Vec<&str> = args.into_iter().chain(more).collect();
        let (mut child, mut stderr) = listening(&args);
        feed(&scanned.traffic, [&mut to, &mut from], |_| ());
        let mut notes = String::new();
        stderr.read_to_string(&mut notes).unwrap();
        assert!(child.wait().unwrap().success(), "{notes}");
        assert!(!notes.contains("stored as full scans"), "{notes}");
        let recording = Recording::read(output.as_ref()).unwrap();
        assert_eq!(setup::kind(&recording).unwrap(), Kind::Guard, "{notes}");
    }
}
