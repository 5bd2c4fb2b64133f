//! Test bench of the scanner: runs its loop, types, and reads its output.

use std::cell::RefCell;
use std::rc::Rc;

use host_sim::volatile::identity;
use stairscan::report::Sentence;
use stairscan::scanner::encoder::EncodedMirror;
use stairscan::scanner::mirror::Stepper;
use stairscan::scanner::settings::SweepMode;
use stairscan::scanner::{Hardware, LentParts, Micros, Scanner, Settings};
use stairscan::signal::radar::FrameLink;
use stairscan::verdict::{Reasons, Status};

use testbed::{Board, Motor, Port};

use super::world::{Module, RADAR, Rows, Shared, World};

/// Number of angles of a scan.
const ANGLES: u16 = 5;
/// Maximum number of steps for a healthy scanner to home, configure its module and scan, including
/// the hold of a previous fault.
const PATIENCE: u32 = 4_000;
/// Number of attempts: settings made for another module may prevent some defaults in the first one.
const ROUNDS: u32 = 3;

type Mirror = EncodedMirror<Stepper<testbed::Shared<Motor>>, Shared>;
type Link = FrameLink<testbed::Shared<Port<Module>>>;
type Parts<'a> = Scanner<
    'a,
    (
        Hardware<Mirror, Link, testbed::Shared<Port>, testbed::Shared<Board>>,
        Rows,
    ),
>;

/// Scanner and environment, and the scanner's output.
pub struct Bench<'a> {
    world: Shared,
    /// Report port.
    pub port: testbed::Shared<Port>,
    /// Board, whose flash may be broken.
    pub board: testbed::Shared<Board>,
    /// Port of the radar module, and the module.
    pub link: testbed::Shared<Port<Module>>,
    scanner: Parts<'a>,
    now: Micros,
    /// Number of the last reported scan.
    scan: u32,
    to_come: u8,
    last: Option<(Status, Reasons)>,
}

fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.config.radar = RADAR;
    settings.config.sweep.angle_count = ANGLES;
    // The simulated shaft passes the whole sector in one step.
    settings.sweep_mode = SweepMode::Stop;
    assert_eq!(settings.validate(), Ok(()));
    settings
}

impl<'a> Bench<'a> {
    /// A scanner that has just booted.
    pub fn new(lent: LentParts<'a>) -> Self {
        let world = Shared(Rc::new(RefCell::new(World::new())));
        let port = testbed::Shared::<Port>::default();
        let link = testbed::Shared::new(Port::new(Module::new(&world)));
        let board = testbed::Shared::<Board>::default();
        let hardware = Hardware {
            mirror: EncodedMirror::new(Stepper::new(world.0.borrow().motor.clone()), world.clone()),
            link: FrameLink::new(link.clone()),
            port: port.clone(),
            board: board.clone(),
        };
        let now = Micros(u32::MAX - 1_000_000);
        let data = Rows::new(world.clone());
        Self {
            scanner: Scanner::new(
                hardware,
                data,
                lent,
                Some(settings()),
                identity("fuzz"),
                now,
            ),
            world,
            port,
            board,
            link,
            now,
            scan: 0,
            to_come: 0,
            last: None,
        }
    }

    /// Changes the environment.
    pub fn world(&mut self, mut change: impl FnMut(&mut World)) {
        change(&mut self.world.0.borrow_mut());
    }

    /// Types bytes.
    pub fn type_in(&mut self, bytes: &[u8]) {
        self.port.get().type_in(bytes);
    }

    /// Advances the time by `ms` in one step.
    pub fn jump(&mut self, ms: u16) {
        self.now = self.now.plus(1000 * u32::from(ms));
        self.step();
    }

    /// Runs `count` steps of one ms.
    pub fn steps(&mut self, count: u32) {
        (0..count).for_each(|_| self.step());
    }

    fn step(&mut self) {
        self.world(World::turn);
        self.scanner.step(self.now);
        self.now = self.now.plus(1000);
        if self.scanner.state() == "fault" {
            assert!(
                !self.world.0.borrow().motor.get().enabled,
                "the driver is on in a fault"
            );
        }
        self.read();
    }

    /// Parses the output.
    fn read(&mut self) {
        let lines = self.port.get().take_lines();
        for line in &lines {
            self.hear(Sentence::parse(line).unwrap_or_else(|e| panic!("{e:?}: {line}")));
        }
    }

    fn hear(&mut self, sentence: Sentence<'_>) {
        match sentence {
            Sentence::Scan(head) => {
                assert_eq!(self.to_come, 0, "a scan within another one");
                assert!(
                    head.scan == 0 || head.scan > self.scan,
                    "scan {} again",
                    head.scan
                );
                assert!(head.status != Status::Fault || head.steps == 0);
                self.scan = self.scan.max(head.scan);
                self.to_come = head.following();
                self.last = Some((head.status, head.reasons));
            }
            Sentence::Step(_) | Sentence::Drop(_) | Sentence::Maybe(_) => {
                self.to_come = self.to_come.checked_sub(1).expect("a step of no scan");
            }
            _ => {}
        }
    }

    /// Checks that without faults the default settings lead to scans that are `ok`.
    pub fn recovers(&mut self) {
        self.world(World::heal);
        self.port.get().wires.room = usize::MAX;
        self.board.get().break_flash(false);
        self.link.get().device.framed.fault = None;
        for _ in 0..ROUNDS {
            // The first line end completes a partially typed line.
            self.tell("\n");
            self.tell("stop");
            let wanted = settings();
            for _ in 0..2 {
                for key in Settings::KEYS
                    .iter()
                    .filter(|key| !key.starts_with("radar-"))
                {
                    let value = wanted.get(key).expect("a key");
                    self.tell(&format!("set,{key},{value}"));
                }
            }
            self.last = None;
            self.tell("start");
            for _ in 0..PATIENCE {
                self.step();
                assert!(self.scanner.healthy(self.now), "{}", self.scanner.state());
                if self.last.is_some_and(|(status, _)| status == Status::Ok) {
                    return;
                }
            }
        }
        panic!(
            "no scan that is ok; {}, {:?}",
            self.scanner.state(),
            self.last
        );
    }

    /// Sends a command and waits for the reply.
    fn tell(&mut self, command: &str) {
        let framed = super::super::commands::framed(format!("!{command}").as_bytes());
        self.type_in(&framed.unwrap_or_default());
        self.steps(3);
    }
}
