//! The scanner's state machine over hardware that misbehaves on cue.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::task::Poll;

use stairscan::Iq;
use stairscan::answer::{Outcome, Reason, Reasons, Status};
use stairscan::config::{Config, ConfigError, RadarConfig};
use stairscan::drive::{Drive, Odometry};
use stairscan::report::command::Measure;
use stairscan::report::sentence::crc32;
use stairscan::report::{ScanLine, Sentence};
use stairscan::scan::settings::MotorConfig;
use stairscan::scan::{
    Board, BytePort, DataPath, Hardware, Identity, LinkError, Micros, Mirror, MirrorError, Motion,
    RadarLink, Scanner, Settings,
};

/// Everything outside the scanner, shared between its traits and the test.
#[derive(Default)]
struct World {
    typed: VecDeque<u8>,
    printed: Vec<u8>,
    port_stuck: bool,
    stopped: bool,
    // Mirror.
    homed: bool,
    enabled: bool,
    moving: u32,
    position: i32,
    stall: bool,
    no_home: bool,
    // Radar.
    radar: Option<RadarConfig>,
    errors: VecDeque<Option<LinkError>>,
    triggers: Vec<i32>,
    deadline: Micros,
    // Data.
    rows: Vec<u16>,
    lost: Vec<u16>,
    begun: Vec<u32>,
    arithmetic_broken: bool,
    row_worked_while_still: bool,
}

#[derive(Clone)]
struct Shared(Rc<RefCell<World>>);

impl Mirror for Shared {
    fn start_home(&mut self, _: &MotorConfig) {
        let mut w = self.0.borrow_mut();
        (w.enabled, w.moving, w.homed, w.position) = (true, 5, true, -23_467);
    }
    fn start_move(&mut self, position: i32, _: &MotorConfig) {
        let mut w = self.0.borrow_mut();
        assert!(w.enabled && w.homed, "moved without a driver or a home");
        (w.position, w.moving) = (position, 3);
    }
    fn poll(&mut self) -> Result<Motion, MirrorError> {
        let mut w = self.0.borrow_mut();
        if w.stall {
            (w.homed, w.enabled) = (false, false);
            return Err(MirrorError::Stall);
        }
        if w.no_home {
            w.homed = false;
            return Err(MirrorError::HomeNotFound);
        }
        w.moving = w.moving.saturating_sub(1);
        Ok(if w.moving > 0 {
            Motion::Moving
        } else {
            Motion::Still
        })
    }
    fn position(&self) -> i32 {
        self.0.borrow().position
    }
    fn homed(&self) -> bool {
        self.0.borrow().homed
    }
    fn disable(&mut self) {
        let mut w = self.0.borrow_mut();
        (w.homed, w.enabled) = (false, false);
    }
}

impl RadarLink for Shared {
    fn configure(&mut self, now: Micros, timeout_us: u32) {
        self.0.borrow_mut().deadline = now.plus(timeout_us);
    }
    fn poll_settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        let w = self.0.borrow();
        match w.radar {
            Some(radar) => Poll::Ready(Ok(radar)),
            None if now.reached(w.deadline) => Poll::Ready(Err(LinkError::Timeout)),
            None => Poll::Pending,
        }
    }
    fn trigger(&mut self, now: Micros, shaft_angle: i32, timeout_us: u32) {
        let mut w = self.0.borrow_mut();
        assert_eq!(w.moving, 0, "triggered while moving");
        w.triggers.push(shaft_angle);
        w.deadline = now.plus(timeout_us);
    }
    fn poll_chirp(&mut self, _: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        assert_eq!(samples.len(), 200);
        match self.0.borrow_mut().errors.pop_front().flatten() {
            None => Poll::Ready(Ok(())),
            Some(error) => Poll::Ready(Err(error)),
        }
    }
}

impl BytePort for Shared {
    fn read(&mut self) -> Option<u8> {
        self.0.borrow_mut().typed.pop_front()
    }
    fn write(&mut self, bytes: &[u8]) -> usize {
        let mut w = self.0.borrow_mut();
        let n = if w.port_stuck { 0 } else { bytes.len().min(7) };
        w.printed.extend(&bytes[..n]);
        n
    }
}

impl Board for Shared {
    fn stopped(&self) -> bool {
        self.0.borrow().stopped
    }
    fn set_stopped(&mut self, stopped: bool) {
        self.0.borrow_mut().stopped = stopped;
    }
    fn measure(&self, _: Measure) -> u32 {
        4321
    }
}

struct Data(Shared, [Iq; 200]);

impl DataPath for Data {
    fn begin(&mut self, config: &Config, scan: u32) -> Result<(), ConfigError> {
        assert_eq!(Some(config.radar), self.0.0.borrow().radar);
        self.0.0.borrow_mut().begun.push(scan);
        Ok(())
    }
    fn samples(&mut self) -> &mut [Iq] {
        &mut self.1
    }
    fn row(&mut self, row: u16) {
        let mut w = self.0.0.borrow_mut();
        // Only the last row of a sweep has no move to hide behind.
        let last = (w.rows.len() + w.lost.len()) % 281 == 280;
        w.row_worked_while_still |= w.moving == 0 && !last;
        w.rows.push(row);
    }
    fn lost(&mut self, row: u16) {
        self.0.0.borrow_mut().lost.push(row);
    }
    fn conclude(&mut self, _: &Drive<'_>) -> Outcome {
        Outcome::clear()
    }
    fn self_test(&mut self) -> bool {
        !self.0.0.borrow().arithmetic_broken
    }
}

type TestScanner = Scanner<'static, Shared, Shared, Shared, Shared, Data>;

struct Bench {
    world: Shared,
    scanner: TestScanner,
    now: Micros,
}

const IDENTITY: Identity = Identity {
    version: "1.2.3",
    revision: "abcdef",
    reset: "power-on",
    clock: "hsi-16",
    reasons: Reasons::NONE,
};

impl Bench {
    fn new(prepare: impl FnOnce(&mut World)) -> Self {
        let mut world = World {
            radar: Some(RadarConfig::default()),
            ..World::default()
        };
        prepare(&mut world);
        let world = Shared(Rc::new(RefCell::new(world)));
        let hardware = Hardware {
            mirror: world.clone(),
            link: world.clone(),
            port: world.clone(),
            board: world.clone(),
        };
        // Leaked: the scanner borrows them for the whole test.
        let reports = Box::leak(Box::default());
        let data = Data(world.clone(), [Iq::default(); 200]);
        let now = Micros(u32::MAX - 1_000_000);
        let memory = (reports, Box::leak(Box::new(Odometry::new())));
        let scanner = Scanner::new(hardware, data, memory, Settings::default(), IDENTITY, now);
        Self {
            world,
            scanner,
            now,
        }
    }

    fn step(&mut self) {
        self.scanner.step(self.now);
        self.now = self.now.plus(1000);
        let healthy = self.scanner.healthy(self.now);
        assert!(healthy, "deadline missed in {}", self.scanner.state());
    }

    fn take_lines(&mut self) -> Vec<String> {
        let mut world = self.world.0.borrow_mut();
        let printed = std::mem::take(&mut world.printed);
        let (whole, rest) = match printed.iter().rposition(|&b| b == b'\n') {
            Some(end) => printed.split_at(end + 1),
            None => (&[][..], &printed[..]),
        };
        world.printed = rest.to_vec();
        let text = String::from_utf8(whole.to_vec()).unwrap();
        text.lines().map(String::from).collect()
    }

    /// Steps until a sentence satisfies `wanted`; everything printed up to it.
    fn until(&mut self, wanted: impl Fn(&Sentence<'_>) -> bool) -> Vec<String> {
        let mut lines = Vec::new();
        for _ in 0..40_000 {
            self.step();
            lines.extend(self.take_lines());
            if lines.iter().any(|l| wanted(&Sentence::parse(l).unwrap())) {
                return lines;
            }
        }
        panic!(
            "never came; state {}, lines {lines:#?}",
            self.scanner.state()
        );
    }

    fn scan(&mut self) -> ScanLine {
        let lines = self.until(|s| matches!(s, Sentence::Scan(_)));
        lines
            .iter()
            .find_map(|line| match Sentence::parse(line) {
                Ok(Sentence::Scan(scan)) => Some(scan),
                _ => None,
            })
            .unwrap()
    }

    fn type_line(&mut self, line: &str) {
        let bytes = format!("{line}\r\n");
        self.world.0.borrow_mut().typed.extend(bytes.bytes());
    }

    /// The one sentence that answers a command.
    fn ask(&mut self, line: &str) -> String {
        self.type_line(line);
        let is_answer = |s: &Sentence<'_>| {
            !matches!(
                s,
                Sentence::Scan(_) | Sentence::Step(_) | Sentence::Boot { .. }
            )
        };
        let lines = self.until(is_answer);
        let answers: Vec<String> = lines
            .into_iter()
            .filter(|l| is_answer(&Sentence::parse(l).unwrap()))
            .collect();
        assert_eq!(answers.len(), 1, "{answers:?}");
        let body = answers[0].trim_start_matches("$PSTR,");
        body.rsplit_once('*').unwrap().0.into()
    }
}

#[test]
fn starts_by_itself_and_sweeps_both_ways_over_the_same_positions() {
    let mut bench = Bench::new(|_| ());
    let lines = bench.until(|s| matches!(s, Sentence::Scan(_)));
    let boot = "$PSTR,BOOT,1.2.3,abcdef,power-on,hsi-16*";
    assert!(lines[0].starts_with(boot), "{lines:?}");
    bench.scan();
    let world = bench.world.0.borrow();
    assert_eq!(world.begun[..2], [1, 2]);
    let forward: Vec<u16> = (0..281).collect();
    assert_eq!(world.rows[..281], forward[..]);
    let backward: Vec<u16> = (0..281).rev().collect();
    assert_eq!(world.rows[281..562], backward[..]);
    let mut back = world.triggers[281..562].to_vec();
    back.reverse();
    assert_eq!(world.triggers[..281], back[..]);
    assert!(
        !world.row_worked_while_still,
        "a chirp was worked off outside the move"
    );
}

#[test]
fn a_lost_row_is_told_and_many_are_a_fault() {
    let lost = Some(LinkError::Timeout);
    // The second row comes at the second attempt, the fourth never.
    let mut bench = Bench::new(|w| w.errors = [None, lost, None, None, lost, lost, lost].into());
    let scan = bench.scan();
    let degraded = (Status::Degraded, 1, Reasons::NONE.with(Reason::LostRows));
    assert_eq!((scan.status, scan.lost_rows, scan.reasons), degraded);
    assert_eq!(bench.world.0.borrow().lost, [3]);
    let scan = bench.scan();
    assert_eq!((scan.scan, scan.status, scan.lost_rows), (2, Status::Ok, 0));

    // Every third row is lost: never eight together, but more than 28.
    let pattern = [lost, lost, lost, None, None];
    let mut bench = Bench::new(|w| w.errors = pattern.into_iter().cycle().take(500).collect());
    let scan = bench.scan();
    assert_eq!((scan.status, scan.lost_rows), (Status::Fault, 29));
    assert!(scan.reasons.has(Reason::TooManyLost));
    assert!(
        !bench.world.0.borrow().enabled,
        "the driver stays off in a fault"
    );
    bench.world.0.borrow_mut().errors.clear();
    assert_eq!(bench.scan().status, Status::Ok);
}

#[test]
fn a_link_that_falls_silent_ends_the_scan_and_recovers() {
    for (error, reason) in [
        (LinkError::Timeout, Reason::LinkSilent),
        (LinkError::Sequence, Reason::LinkSilent),
        (LinkError::Module(2), Reason::ModuleError),
    ] {
        let mut bench = Bench::new(|w| w.errors = vec![Some(error); 24].into());
        let scan = bench.scan();
        assert_eq!(
            (scan.scan, scan.status, scan.lost_rows),
            (1, Status::Fault, 8)
        );
        assert!(scan.reasons.has(reason), "{error:?}");
        let scan = bench.scan();
        assert_eq!((scan.scan, scan.status), (2, Status::Ok));
    }
}

#[test]
fn a_module_that_never_answers_is_scan_0_and_is_asked_again() {
    let mut bench = Bench::new(|w| w.radar = None);
    let scan = bench.scan();
    assert_eq!((scan.scan, scan.status), (0, Status::Fault));
    assert!(scan.reasons.has(Reason::LinkSilent));
    assert!(!bench.world.0.borrow().enabled);
    assert!(bench.ask("status").starts_with("STAT,fault,hsi-16,0,"));
    bench.world.0.borrow_mut().radar = Some(RadarConfig::default());
    let scan = bench.scan();
    assert_eq!((scan.scan, scan.status), (1, Status::Ok));
}

#[test]
fn a_module_set_to_something_impossible_is_a_fault_and_commands_still_work() {
    let wrong = RadarConfig {
        samples: 257,
        ..RadarConfig::default()
    };
    let mut bench = Bench::new(|w| w.radar = Some(wrong));
    let scan = bench.scan();
    assert_eq!((scan.scan, scan.status), (1, Status::Fault));
    assert!(scan.reasons.has(Reason::ModuleConfig));
    assert_eq!(bench.ask("set seed 9"), "CONF,seed,9");
    bench.world.0.borrow_mut().radar = Some(RadarConfig::default());
    assert_eq!(bench.scan().status, Status::Ok);
}

#[test]
fn motor_and_arithmetic_faults_leave_the_driver_off() {
    type Break = fn(&mut World, bool);
    let cases: [(Break, Reason); 3] = [
        (|w, on| w.stall = on, Reason::MotorStall),
        (|w, on| w.no_home = on, Reason::HomeNotFound),
        (|w, on| w.arithmetic_broken = on, Reason::SelfTest),
    ];
    for (set, reason) in cases {
        let mut bench = Bench::new(|w| set(w, true));
        let scan = bench.scan();
        assert_eq!((scan.scan, scan.status), (0, Status::Fault));
        assert!(scan.reasons.has(reason));
        assert!(!bench.world.0.borrow().enabled);
        set(&mut bench.world.0.borrow_mut(), false);
        assert_eq!(bench.scan().status, Status::Ok);
    }
    let mut bench = Bench::new(|_| ());
    bench.scan();
    bench.world.0.borrow_mut().stall = true;
    let scan = bench.scan();
    assert_eq!((scan.scan, scan.status), (2, Status::Fault));
    assert!(scan.reasons.has(Reason::MotorStall));
    bench.world.0.borrow_mut().stall = false;
    assert_eq!(bench.scan().scan, 3);
}

#[test]
fn commands_answer_during_a_scan_and_the_scan_goes_on() {
    let mut bench = Bench::new(|_| ());
    for _ in 0..200 {
        bench.step();
    }
    assert_eq!(bench.scanner.state(), "scanning");
    assert!(bench.ask("status").starts_with("STAT,scanning,hsi-16,1,"));
    assert_eq!(bench.ask("version"), "CONF,version,1.2.3 abcdef");
    assert_eq!(bench.ask("get,angle-step"), "CONF,angle-step,250");
    assert_eq!(bench.ask("get stack-used"), "CONF,stack-used,4321");
    assert_eq!(bench.ask("set,angle-count,100"), "CONF,angle-count,100");
    assert_eq!(bench.ask("scan"), "FAIL,scan,state,idle: stop first");
    assert_eq!(
        bench.ask("selftest"),
        "FAIL,selftest,state,idle: stop first"
    );
    let refused = "FAIL,set,angle-count,3 to 8192 angles";
    assert_eq!(bench.ask("set,angle-count,9999"), refused);
    // Some rows more cost the farthest bins; so many would leave none 2 m away.
    let refused = "FAIL,set,angle-count,a map of 65536 cells at most";
    assert_eq!(bench.ask("set,angle-count,720"), refused);
    assert!(bench.ask("hello").starts_with("FAIL,-,command,"));
    assert!(
        bench
            .ask(&"z".repeat(500))
            .starts_with("FAIL,-,line,at most 96")
    );
    assert!(
        bench
            .ask("\u{1}\u{ff}\u{0}")
            .starts_with("FAIL,-,line,printable")
    );
    assert_eq!(bench.scanner.state(), "scanning");
    bench.scan();
    let rows = |bench: &Bench| bench.world.0.borrow().rows.len();
    assert_eq!(rows(&bench), 281, "the running scan keeps its settings");
    bench.scan();
    assert_eq!(rows(&bench), 381);
}

#[test]
fn a_grid_of_other_rows_is_scanned_whole() {
    let mut bench = Bench::new(|w| w.stopped = true);
    for set in [
        "cfar-near-margin,40000",
        "first-angle,-20000",
        "angle-count,321",
    ] {
        assert_eq!(bench.ask(&format!("set,{set}")), format!("CONF,{set}"));
    }
    bench.ask("start");
    assert_eq!(bench.scan().status, Status::Ok);
    let rows: Vec<u16> = (0..321).collect();
    assert_eq!(bench.world.0.borrow().rows[..321], rows[..]);
}

#[test]
fn listing_is_complete_even_through_a_slow_port() {
    let mut bench = Bench::new(|w| w.stopped = true);
    bench.type_line("get");
    let lines = bench.until(|s| matches!(s, Sentence::Done { command: "get" }));
    let keys = lines.iter().filter(|l| l.contains(",CONF,")).count();
    assert_eq!(keys, Settings::KEYS.len());
}

#[test]
fn stop_survives_a_reset_and_single_scans_return_to_idle() {
    let mut bench = Bench::new(|_| ());
    bench.scan();
    assert_eq!(bench.ask("stop"), "DONE,stop");
    assert!(bench.world.0.borrow().stopped);
    let mut bench = Bench::new(|w| w.stopped = true);
    for _ in 0..1000 {
        bench.step();
    }
    assert_eq!(bench.scanner.state(), "idle");
    assert!(!bench.world.0.borrow().enabled, "nothing moves by itself");
    assert_eq!(bench.ask("selftest"), "DONE,selftest");
    assert_eq!(bench.ask("scan"), "DONE,scan");
    assert_eq!(bench.scan().scan, 1);
    for _ in 0..100 {
        bench.step();
    }
    assert_eq!(bench.scanner.state(), "idle");
    assert_eq!(bench.ask("start"), "DONE,start");
    assert_eq!(bench.scan().scan, 2);
    assert_eq!(bench.scan().scan, 3);
    let body = "PSTC,stop";
    let framed = format!("${body}*{:08X}", crc32(body));
    assert_eq!(bench.ask(&framed), "DONE,stop");
}

#[test]
fn a_failed_self_test_answers_its_command() {
    let mut bench = Bench::new(|w| {
        w.stopped = true;
        w.no_home = true;
    });
    assert_eq!(
        bench.ask("selftest"),
        "FAIL,selftest,home-not-found,a test that passes"
    );
    assert_eq!(bench.scan().scan, 0);
    bench.world.0.borrow_mut().no_home = false;
    for _ in 0..5000 {
        bench.step();
    }
    assert_eq!(
        bench.scanner.state(),
        "idle",
        "a stopped scanner does not start by itself"
    );
}

#[test]
fn a_port_that_takes_nothing_stops_neither_scan_nor_watchdog() {
    let mut bench = Bench::new(|w| w.port_stuck = true);
    for _ in 0..60_000 {
        bench.step();
    }
    let scans = bench.scanner.scans();
    assert!(scans > 2);
    bench.world.0.borrow_mut().port_stuck = false;
    assert_eq!(bench.scan().scan, 1);
}
