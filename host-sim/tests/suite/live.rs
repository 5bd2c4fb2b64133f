//! Tests of `live` over pseudo-terminals: a scanner reports, is unplugged and returns; wrong ports are
//! explained; the image in the emulator is observed.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use host_sim::emulate::Session;
use host_sim::emulate::image;
use host_sim::emulate::session::Waits;
use host_sim::live::model::{Entry, Link, State};
use host_sim::live::port::Source;
use host_sim::live::pty::Pty;
use host_sim::live::session::Session as Observed;
use host_sim::live::trouble::{Trouble, UnexpectedData};
use host_sim::live::{device, plain};
use host_sim::playback::Playback;
use host_sim::recording::Recording;
use host_sim::replay;
use stairscan::config::Config;

use crate::common::scanner::{Scanner, stair_a};
use crate::common::{Scratch, elf, sim};

/// Timeout of any action here, on a busy machine.
const PATIENCE: Duration = Duration::from_secs(180);
const BAUD: u32 = 115_200;

/// A live view of a port.
struct View {
    source: Source,
    state: State,
    started: Instant,
}

impl View {
    fn of(path: &str) -> Self {
        let started = Instant::now();
        Self {
            source: Source::port(started, path, BAUD),
            state: State::new(path, BAUD),
            started,
        }
    }

    fn now(&self) -> u64 {
        self.started.elapsed().as_millis() as u64
    }

    /// Processes events until `done`.
    fn until(&mut self, what: &str, done: impl Fn(&State, u64) -> bool) {
        while !done(&self.state, self.now()) {
            assert!(
                self.started.elapsed() < PATIENCE,
                "{what}: {:?}",
                self.state
            );
            let Ok((at, event)) = self.source.events.recv_timeout(Duration::from_millis(50)) else {
                continue;
            };
            self.state.take(at, &event);
        }
    }

    /// Sends a command and waits for its reply.
    fn ask(&mut self, line: &str) -> String {
        let now = self.now();
        self.state.sent(now, line);
        self.source.lines.send(line.to_owned()).unwrap();
        let replied = |state: &State, _| state.asked.as_ref().is_some_and(|a| a.reply.is_some());
        self.until(line, replied);
        self.state.asked.as_ref().unwrap().reply.clone().unwrap().1
    }

    fn steps(&self) -> Vec<String> {
        let answer = &self.state.answer.as_ref().unwrap().1;
        answer.sentences.clone()
    }
}

/// Returns the sentences of `replay` for the first scan.
fn replayed(recording: &Recording) -> Vec<String> {
    replay::answer(recording, &replay::Options::default())
        .unwrap()
        .sentences
}

#[test]
fn a_scanner_speaks_is_unplugged_and_comes_back() {
    let dir = Scratch::new("live-unplugged");
    let path = dir.path().join("port");
    let scanner = Scanner::plug_in(stair_a());
    symlink(&scanner.path, &path).unwrap();
    let mut view = View::of(path.to_str().unwrap());

    view.until("steps", |state, _| state.answer.is_some());
    assert_eq!(view.steps(), replayed(&stair_a()));
    view.until("LIVE", |state, _| state.pulse.is_some());
    let status = view.ask("status");
    assert!(status.starts_with("scanning, clock host"), "{status}");
    assert_eq!(
        view.ask("set seed 7"),
        "refused: crc: expected send $PSTC,set,seed,7*352B37A8"
    );
    assert_eq!(view.ask("$PSTC,set,seed,7*352B37A8"), "seed is 7");

    scanner.unplug();
    let gone = |state: &State, _| matches!(state.link, Link::Away(_, Trouble::Unplugged(_)));
    view.until("unplugged", gone);
    assert!(view.state.answer.is_some());
    assert!(!Path::new(&path).exists());

    let scanner = Scanner::plug_in(stair_a());
    fs::remove_file(&path).unwrap();
    symlink(&scanner.path, &path).unwrap();
    view.until("open again", |state, _| state.is_open());
    assert_eq!(view.state.reopened, 1);
    let back = view.now();
    view.until("steps again", |state, _| {
        state.answer.as_ref().is_some_and(|(at, _)| *at >= back)
    });
    assert_eq!(view.ask("stop"), "done");
    drop(view);
    scanner.unplug();
}

#[test]
fn wrong_ports_are_explained() {
    let mut view = View::of("/dev/no-such-port");
    let missing = |state: &State, _| matches!(state.link, Link::Away(_, Trouble::Missing(_)));
    view.until("a missing port", missing);

    let file = Scratch::new("live-wrong-port");
    let path = file.path().join("notes.txt");
    fs::write(&path, "no port").unwrap();
    let mut view = View::of(path.to_str().unwrap());
    view.until("a file", |state, _| {
        matches!(state.link, Link::Away(_, Trouble::NoPort))
    });

    let silent = Pty::new().unwrap();
    let mut view = View::of(&silent.path);
    view.until("nothing", |state, now| {
        state.unexpected_data(now) == Some(UnexpectedData::Nothing)
    });
    let mut busy = View::of(&silent.path);
    let locked = |state: &State, _| matches!(state.link, Link::Away(_, Trouble::Busy));
    busy.until("a port that somebody else holds", locked);

    let mut noisy = Pty::new().unwrap();
    let mut view = View::of(&noisy.path);
    view.until("open", |state, _| state.is_open());
    noisy.write(b"\x80\xf8\x00\xff\n\xe0~\x1c\n");
    view.until("noise", |state, now| {
        state.unexpected_data(now) == Some(UnexpectedData::Noise)
    });
}

#[test]
fn a_missing_port_is_named_without_a_terminal_and_ports_are_listed() {
    let output = sim(&["live", "/dev/no-such-port"]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("no /dev/no-such-port"), "{error}");
    let output = sim(&["live"]);
    let printed = [output.stdout, output.stderr].concat();
    let printed = String::from_utf8(printed).unwrap();
    assert!(printed.contains("serial port"), "{printed}");
}

/// Ends the emulator's thread, after a failure as well.
struct EndOnDrop<'a>(&'a AtomicBool);

impl Drop for EndOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// The firmware image, observed over a pseudo-terminal.
#[test]
fn the_image_in_the_emulator_is_watched() {
    let Some(elf) = elf() else {
        return;
    };
    let recording = stair_a();
    let playback = Playback::new(&recording, &Config::default()).unwrap();
    let pty = Pty::new().unwrap();
    let mut view = View::of(&pty.path);
    let ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let emulator = scope.spawn(|| {
            let mut session = Session::boot(elf, &playback).unwrap();
            session.watch(pty);
            session
                .configure(&playback.settings(), Waits::default())
                .unwrap();
            session.connect().unwrap();
            session.follow(recording.scans(), &ended).unwrap();
        });
        // The emulator ends also if the following code fails.
        let end = EndOnDrop(&ended);
        let scanned = |state: &State, _| {
            let halted = |entry: &Entry| entry.text.contains(",HALT,");
            assert!(
                !state.log.iter().any(halted),
                "the image crashed: {state:?}"
            );
            let answer = state.answer.as_ref().map(|(_, answer)| answer);
            answer.is_some_and(|answer| answer.scan.scan > 0)
        };
        view.until("steps", scanned);
        assert_eq!(view.steps(), replayed(&recording));
        view.until("LIVE", |state, _| state.pulse.is_some());
        assert!(view.ask("status").contains("clock hsi-16"));
        drop(end);
        emulator.join().unwrap();
    });
    let gone = |state: &State, _| matches!(state.link, Link::Away(_, Trouble::Unplugged(_)));
    view.until("unplugged", gone);
}

/// A terminal that hangs up ends the program instead of causing a busy loop.
/// The sweeps of `recordings/guard_kerb` begin every 184 ms.
#[test]
fn guard_sweeps_of_a_demo_come_at_their_true_rate_a_line_each() {
    let recording = Recording::read(&image::workspace().join("recordings/guard_kerb")).unwrap();
    let started = Instant::now();
    let source = Source::run(started, move |inside| {
        let cable = &mut device::Direct::new(inside);
        device::run(&recording, &Config::default(), cable).unwrap();
    });
    let mut session = Observed {
        state: State::new("demo", 0),
        keep: None,
        look: &mut |_| (),
    };
    let (mut lines, stop) = (Vec::new(), AtomicBool::new(false));
    let mut print = |line: &str| {
        lines.push((started.elapsed(), line.to_owned()));
        stop.store(lines.len() == 6, Ordering::Relaxed);
    };
    plain::run(started, &source, &mut session, &stop, &mut print).unwrap();
    for (k, (_, line)) in lines.iter().enumerate() {
        assert!(line.contains(" ok free 0."), "{line}");
        assert!(line.contains(&format!(", sweep {}", k + 1)), "{line}");
    }
    // Five intervals are 0.92 s; late by a sweep's delay on a busy machine.
    let took = lines[5].0 - lines[0].0;
    let true_rate = Duration::from_millis(750)..Duration::from_millis(1_200);
    assert!(true_rate.contains(&took), "{took:?}: {lines:?}");
    assert!(lines[5].1.ends_with(" a second"), "{lines:?}");
}

#[test]
fn a_terminal_that_hung_up_ends_the_program() {
    let (mut master, slave) = {
        let (master, slave) = serialport::TTYPort::pair().unwrap();
        // The program does not inherit copies.
        (
            master.try_clone_native().unwrap(),
            slave.try_clone_native().unwrap(),
        )
    };
    let path = serialport::SerialPort::name(&slave).unwrap();
    let terminal = || {
        let file = fs::File::options().read(true).write(true).open(&path);
        std::process::Stdio::from(file.unwrap())
    };
    let size = std::process::Command::new("stty")
        .args(["rows", "30", "cols", "100"])
        .stdin(terminal())
        .status();
    assert!(size.unwrap().success());
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(["live", "/dev/no-such-port"])
        .stdin(terminal())
        .stdout(terminal())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut seen = Vec::new();
    let mut buffer = [0; 4096];
    let begun = Instant::now();
    while !String::from_utf8_lossy(&seen).contains("no-such-port") {
        assert!(begun.elapsed() < PATIENCE, "nothing is drawn");
        if let Ok(count) = std::io::Read::read(&mut master, &mut buffer) {
            seen.extend(&buffer[..count]);
        }
    }
    // While the program waits for a key.
    std::thread::sleep(Duration::from_millis(700));
    drop((master, slave));
    let hung_up = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if hung_up.elapsed() > Duration::from_secs(20) {
            child.kill().unwrap();
            panic!("it goes on without a terminal");
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    let mut printed = String::new();
    std::io::Read::read_to_string(&mut child.stderr.take().unwrap(), &mut printed).unwrap();
    assert_eq!(status.code(), Some(1), "{printed}");
    assert!(printed.contains("the terminal was closed"), "{printed}");
}
