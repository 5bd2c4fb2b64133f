//! A scanner on the host with the real link's frames, and a tap on them.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use host_sim::emulate::{Fault, Module, image};
use host_sim::live::lines::Splitter;
use host_sim::playback::{Playback, SimShaft};
use host_sim::recording::Recording;
use host_sim::replay;
use host_sim::tap::beside::{self, Beside, Said};
use host_sim::tap::gather::{Gather, Part};
use host_sim::tap::scans::{Tap, Wire};
use host_sim::volatile::{Volatile, identity};
use stairscan::config::Config;
use stairscan::motion::{Mode, Odometry};
use stairscan::pipeline::Pipeline;
use stairscan::report::Sentence;
use stairscan::scanner::{BytePort, Hardware, Micros, Reports, Scanner};
use stairscan::signal::radar::FrameLink;

use crate::common::Scratch;

/// Traffic of the link in order, with times, ms.
pub type Traffic = Vec<(u64, Wire, Vec<u8>)>;

pub fn read(name: &str) -> Recording {
    Recording::read(&image::workspace().join("recordings").join(name)).unwrap()
}

/// The link: a radar module at its end, and a record of all bytes.
pub struct Line<'a> {
    module: Module<'a>,
    answers: VecDeque<u8>,
    traffic: Traffic,
    now: u64,
}

/// The scanner's end of the link.
pub struct LinkPort<'a>(Rc<RefCell<Line<'a>>>);

impl BytePort for LinkPort<'_> {
    fn read(&mut self) -> Option<u8> {
        self.0.borrow_mut().answers.pop_front()
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        let mut line = self.0.borrow_mut();
        let now = line.now;
        line.traffic.push((now, Wire::ToModule, bytes.to_vec()));
        let (answer, _) = line.module.receive(bytes);
        if !answer.is_empty() {
            line.traffic.push((now, Wire::FromModule, answer.clone()));
        }
        line.answers.extend(answer);
        bytes.len()
    }
}

/// The scanner's report port, which also takes commands.
#[derive(Default)]
pub struct Console {
    typed: VecDeque<u8>,
    said: Vec<u8>,
}

impl BytePort for Console {
    fn read(&mut self) -> Option<u8> {
        self.typed.pop_front()
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        self.said.extend(bytes);
        bytes.len()
    }
}

/// Reports of a scanner in some scans over the real link's frames, and the traffic of the link.
pub struct Scanned {
    pub beside: Beside,
    pub answers: Vec<Vec<String>>,
    pub traffic: Traffic,
}

pub fn scan(recording: &Recording, base: &Config, scans: usize, faults: &[&str]) -> Scanned {
    // A scanner without a setting for the chair's motion.
    let playback = Playback::new(recording, base)
        .unwrap()
        .with_mode(Mode::Auto);
    let mut module = Module::new(&playback);
    module.get_ready();
    let faults: Vec<Fault> = faults.iter().map(|fault| fault.parse().unwrap()).collect();
    module.set_faults(&faults);
    let line = Rc::new(RefCell::new(Line {
        module,
        answers: VecDeque::new(),
        traffic: Vec::new(),
        now: 0,
    }));
    let mut pipeline = Box::new(Pipeline::new());
    let (mut reports, mut odometry) = (Reports::new(), Odometry::new());
    let hardware = Hardware {
        mirror: SimShaft::default(),
        link: FrameLink::new(LinkPort(line.clone())),
        port: Console {
            typed: b"get\r\n".iter().copied().collect(),
            said: Vec::new(),
        },
        board: Volatile::SCANNING,
    };
    let mut scanner = Scanner::new(
        hardware,
        &mut *pipeline,
        (&mut reports, &mut odometry),
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
                _ => panic!("no SCAN"),
            }
    };
    let mut now = 0;
    while !done(&answers) {
        now += 1;
        assert!(now < 1_000_000, "no answer");
        line.borrow_mut().now = now;
        scanner.step(Micros(1_000 * now as u32));
        for said in splitter.push(&std::mem::take(&mut scanner.port_mut().said)) {
            beside.line(now, &said);
            match Sentence::parse(&said).unwrap() {
                Sentence::Scan(_) => answers.push(vec![said]),
                Sentence::Step(_) | Sentence::Drop(_) | Sentence::Maybe(_) => {
                    answers.last_mut().unwrap().push(said)
                }
                _ => {}
            }
        }
    }
    drop(scanner);
    let traffic = std::mem::take(&mut line.borrow_mut().traffic);
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
    let (mounting, doubt) = beside::mounting(&Said::default(), &scanned.beside);
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
