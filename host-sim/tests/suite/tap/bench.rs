//! A scanner on the host with the real link's frames, and a tap on them.

use host_sim::emulate::{Fault, Module, image};
use host_sim::live::lines::Splitter;
use host_sim::playback::{Playback, SimShaft};
use host_sim::recording::Recording;
use host_sim::replay;
use host_sim::setup::{self, Kind};
use host_sim::tap::beside::{self, Beside, MountingArgs};
use host_sim::tap::gather::{Gather, Part};
use host_sim::tap::scans::{Tap, Wire};
use host_sim::volatile::{Volatile, identity};
use stairscan::config::Config;
use stairscan::motion::{Mode, Odometry};
use stairscan::pipeline::Pipeline;
use stairscan::report::Sentence;
use stairscan::scanner::{Hardware, LentParts, Micros, Reports, Scanner};
use stairscan::signal::radar::FrameLink;
use testbed::port::{Device, Wires};
use testbed::{Port, Shared};

use crate::common::Scratch;

/// Traffic of the link in order, with times, ms.
pub type Traffic = Vec<(u64, Wire, Vec<u8>)>;

pub fn read(name: &str) -> Recording {
    Recording::read(&image::workspace().join("recordings").join(name)).unwrap()
}

/// The radar module at the end of the link, and a record of all bytes.
pub struct Recorded<'a> {
    module: Module<'a>,
    traffic: Traffic,
}

impl Recorded<'_> {
    /// Adds bytes at time `now` to the record; those of one direction make one entry.
    fn record(&mut self, now: u64, wire: Wire, bytes: &[u8]) {
        match self.traffic.last_mut() {
            Some((at, last, before)) if *at == now && *last == wire => before.extend(bytes),
            _ => self.traffic.push((now, wire, bytes.to_vec())),
        }
    }
}

impl Device for Recorded<'_> {
    fn receive(&mut self, byte: u8, at: u64, wires: &mut Wires) {
        self.record(at, Wire::ToModule, &[byte]);
        let (answer, _) = self.module.receive(&[byte]);
        if !answer.is_empty() {
            self.record(at, Wire::FromModule, &answer);
        }
        wires.send(at, &answer);
    }
}

/// Reports of a scanner in some scans or guard sweeps over the real link's frames, and the traffic of the link.
pub struct Scanned {
    pub beside: Beside,
    pub answers: Vec<Vec<String>>,
    pub traffic: Traffic,
}

pub fn scan(recording: &Recording, base: &Config, scans: usize, faults: &[&str]) -> Scanned {
    // A scanner without a setting for the chair's motion.
    let mut playback = Playback::new(recording, base)
        .unwrap()
        .with_mode(Mode::Auto);
    let guard = setup::kind(recording).unwrap() == Kind::Guard;
    if guard {
        playback = playback.guarding();
    }
    let mut module = Module::new(&playback);
    module.get_ready();
    let faults: Vec<Fault> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
    module.set_faults(&faults);
    let line = Shared::new(Port::new(Recorded {
        module,
        traffic: Vec::new(),
    }));
    let port = Shared::<Port>::default();
    port.get().type_in("get\r\n");
    if guard {
        port.get().type_in("guard on\r\n");
    }
    let mut pipeline = Box::new(Pipeline::new());
    let (mut reports, mut odometry) = (Reports::new(), Odometry::new());
    let hardware = Hardware {
        mirror: SimShaft::default(),
        link: FrameLink::new(line.clone()),
        port: port.clone(),
        board: Volatile::SCANNING,
    };
    let mut scanner = Scanner::new(
        hardware,
        &mut *pipeline,
        LentParts {
            reports: &mut reports,
            odometry: &mut odometry,
        },
        Some(playback.settings()),
        identity("host"),
        Micros(0),
    );
    let (mut beside, mut splitter) = (Beside::default(), Splitter::default());
    let mut answers: Vec<Vec<String>> = Vec::new();
    let done = |answers: &[Vec<String>]| {
        answers.len() == scans
            && match Sentence::parse(&answers[scans - 1][0]) {
                Ok(Sentence::Scan(head)) => {
                    answers[scans - 1].len() > usize::from(head.following())
                }
                Ok(Sentence::Guard(_)) => true,
                _ => panic!("no SCAN or GUARD"),
            }
    };
    let mut now = 0;
    while !done(&answers) {
        now += 1;
        assert!(now < 1_000_000, "no answer");
        line.get().wires.now = now;
        scanner.step(Micros(1_000 * now as u32));
        for said in splitter.push(&std::mem::take(&mut port.get().device)) {
            beside.line(now, &said);
            match Sentence::parse(&said).unwrap() {
                Sentence::Scan(_) | Sentence::Guard(_) => answers.push(vec![said]),
                Sentence::Step(_) | Sentence::Drop(_) | Sentence::Maybe(_) => {
                    answers.last_mut().unwrap().push(said)
                }
                _ => {}
            }
        }
    }
    drop(scanner);
    let traffic = std::mem::take(&mut line.get().device.traffic);
    Scanned {
        beside,
        answers,
        traffic,
    }
}

/// Returns the recordings that a tap makes from `traffic`, with its notes.
pub fn tapped(scanned: &Scanned, traffic: &Traffic) -> (Vec<Part>, Vec<String>, Tap) {
    let mut tap = Tap::default();
    for (at, wire, bytes) in traffic {
        tap.push(*at, *wire, bytes);
    }
    tap.end();
    let (mounting, doubt) = beside::mounting(&MountingArgs::default(), &scanned.beside);
    assert_eq!(doubt, None, "the scanner has told how it is mounted");
    let mut gather = Gather::new("tap", mounting);
    while let Some(scan) = tap.scan() {
        gather.take(&scan);
    }
    let notes = gather.notes.clone();
    (gather.parts(), notes, tap)
}

/// Returns the sentences of replay for a recording that was written and read again.
pub fn replayed(test: &str, part: &Part, scanned: &Scanned) -> (Recording, Vec<Vec<String>>) {
    let dir = Scratch::new(test);
    let path = dir.path().join("tap");
    part.recording.write(&path).unwrap();
    let recording = Recording::read(&path).unwrap();
    let (config, mode, word) = beside::as_scanner(&Config::default(), &scanned.beside);
    assert_eq!(word, "auto");
    let options = replay::Options {
        config,
        motion: Some(mode),
        ..replay::Options::default()
    };
    let answers = replay::answers(&recording, &options, |_| ()).unwrap();
    (
        recording,
        answers.into_iter().map(|a| a.sentences).collect(),
    )
}
