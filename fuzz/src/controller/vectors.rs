//! Golden vectors: valid and invalid lines of every sentence and command, with the expected results.

use std::path::PathBuf;

use stairscan::answer::Direction;
use stairscan::config::Plane;
use stairscan::motion::Reading;
use stairscan::report::sentence::crc32;
use stairscan::report::{
    BootLine, CrashLine, CrashSite, DropLine, GuardLine, LiveLine, MaybeLine, ScanLine, Sentence,
    SlopeField, StepLine, Tenths, motion,
};
use stairscan::scanner::Settings;
use stairscan::scanner::command::framed;
use stairscan::verdict::{HazardKind, Reason, Reasons, Status};

use super::{Way, oracle, tables};

/// Returns the path of the file.
pub fn path() -> PathBuf {
    super::directory().join("vectors.tsv")
}

/// Returns the contents of the file.
pub fn text() -> String {
    let head = "# Way (R: report, C: command), line without its end, what is to be made of it.\n\
                # Made by `cargo run -p stairscan-fuzz --example controller -- --write`.\n";
    let rows = all().into_iter().map(|(way, line)| {
        let verdict = oracle::verdict(way, line.as_bytes());
        format!("{}\t{line}\t{verdict}\n", way.letter())
    });
    std::iter::once(head.to_owned()).chain(rows).collect()
}

/// Returns all lines.
pub fn all() -> Vec<(Way, String)> {
    let mut lines = Vec::new();
    let written = sentences().map(|sentence| sentence.write().trim_end().to_owned());
    lines.extend(written.map(|line| (Way::Report, line)));
    let bad = BAD_BODIES.iter().map(|body| closed(body));
    lines.extend(bad.map(|line| (Way::Report, line)));
    lines.extend(BAD_LINES.map(|line| (Way::Report, line.to_owned())));
    lines.extend(commands().into_iter().map(|line| (Way::Command, line)));
    lines
}

/// Returns the line with this text between `$` and `*`.
pub fn closed(body: &str) -> String {
    format!("${body}*{:08X}", crc32(body))
}

fn sentences() -> impl Iterator<Item = Sentence<'static>> {
    let scans = scans().into_iter().map(Sentence::Scan);
    let steps = steps().into_iter().map(Sentence::Step);
    let maybes = maybes().into_iter().map(Sentence::Maybe);
    let drops = drops().into_iter().map(Sentence::Drop);
    let halts = Reason::ALL.iter().map(|&reason| Sentence::Halt { reason });
    let rest = scans.chain(steps).chain(drops).chain(maybes).chain(halts);
    let lives = lives().into_iter().map(Sentence::Live);
    let guards = guards().into_iter().map(Sentence::Guard);
    rest.chain(lives).chain(guards).chain(texts())
}

fn lives() -> [LiveLine<'static>; 2] {
    let first = LiveLine {
        state: "self-test",
        scan: 0,
        uptime_ms: 200,
        age_ms: None,
        motion: "absent",
        motion_faults: 0,
        refused: 1,
        port_errors: 2,
        link_errors: 3,
    };
    let largest = LiveLine {
        state: "scanning",
        scan: u32::MAX,
        uptime_ms: u32::MAX,
        age_ms: Some(u32::MAX),
        motion: "good",
        motion_faults: u16::MAX,
        refused: u16::MAX,
        port_errors: u16::MAX,
        link_errors: u16::MAX,
    };
    [first, largest]
}

fn scans() -> Vec<ScanLine> {
    let ok = ScanLine {
        scan: 1,
        status: Status::Ok,
        direction: Direction::Up,
        steps: 3,
        lost_rows: 0,
        reasons: Reasons::NONE,
        horizon: Some(Tenths(10_000)),
        confidence: Some(989),
        possible_steps: 1,
        settings: 0x4285_B47E,
        drops: 0,
        plane: None,
        ground: None,
    };
    let every = Reason::ALL
        .iter()
        .fold(Reasons::NONE, |set, &r| set.with(r));
    let largest = ScanLine {
        scan: u32::MAX,
        steps: u8::MAX,
        lost_rows: u16::MAX,
        reasons: every,
        horizon: Some(Tenths(-1_000_000)),
        confidence: Some(1000),
        possible_steps: u8::MAX,
        settings: u32::MAX,
        drops: u8::MAX,
        plane: Some(Plane::Height),
        ground: Some(SlopeField {
            from: Tenths(-20_000),
            rise: Tenths(-10_000),
        }),
        ..ok
    };
    let degraded = |reasons| ScanLine {
        status: Status::Degraded,
        direction: Direction::Down,
        reasons,
        horizon: Some(Tenths(0)),
        confidence: Some(0),
        settings: 0,
        ..ok
    };
    let fault = ScanLine {
        status: Status::Fault,
        direction: Direction::None,
        steps: 0,
        reasons: Reasons::NONE.with(Reason::NoEcho),
        horizon: None,
        confidence: None,
        possible_steps: 0,
        ..ok
    };
    let each = Reason::ALL.iter().map(|&r| degraded(Reasons::NONE.with(r)));
    let pair = Reasons::NONE
        .with(Reason::WeakEchoes)
        .with(Reason::Unconfirmed);
    let clear = ScanLine {
        direction: Direction::None,
        steps: 0,
        possible_steps: 0,
        ..ok
    };
    let plane = Some(Plane::Depth);
    let drop = ScanLine {
        drops: 1,
        plane,
        ..clear
    };
    let ground = Some(SlopeField {
        from: Tenths(2_900),
        rise: Tenths(-560),
    });
    let sloping = [clear, drop].map(|head| ScanLine { ground, ..head });
    let fixed = [ok, clear, drop, largest, fault, degraded(pair)];
    let fixed = fixed.into_iter().chain(sloping);
    fixed.chain(each).collect()
}

fn steps() -> Vec<StepLine> {
    let step = StepLine {
        scan: 1,
        index: 1,
        count: 3,
        distance: Tenths(5005),
        height: Tenths(1654),
        tread: Some(Tenths(2795)),
        riser: Some(Tenths(1654)),
        distance_sigma: Tenths(15),
        height_sigma: Tenths(37),
        quality: 100,
    };
    let extreme = |tenths| StepLine {
        scan: u32::MAX,
        index: u8::MAX,
        count: u8::MAX,
        distance: Tenths(tenths),
        height: Tenths(tenths),
        tread: None,
        riser: Some(Tenths(tenths)),
        distance_sigma: Tenths(tenths),
        height_sigma: Tenths(tenths),
        quality: u8::MAX,
    };
    let drop = StepLine {
        distance: Tenths(-5),
        height: Tenths(-1700),
        tread: None,
        riser: None,
        quality: 0,
        ..step
    };
    let extremes = [0, 1, -1, 10, 1_000_000, -1_000_000, i32::MAX, -i32::MAX].map(extreme);
    [step, drop].into_iter().chain(extremes).collect()
}

fn drops() -> Vec<DropLine> {
    let drop = DropLine {
        scan: 7,
        distance: Tenths(9_123),
        distance_sigma: Tenths(151),
        depth: Some(Tenths(1_800)),
        probability: 974,
    };
    let extreme = |tenths| DropLine {
        scan: u32::MAX,
        distance: Tenths(tenths),
        distance_sigma: Tenths(tenths),
        depth: None,
        probability: 1000,
    };
    let extremes = [0, -1, i32::MAX, -i32::MAX].map(extreme);
    std::iter::once(drop).chain(extremes).collect()
}

fn maybes() -> [MaybeLine; 2] {
    let maybe = MaybeLine {
        scan: 7,
        index: 1,
        count: 6,
        distance: Tenths(12_345),
        height: Tenths(-1_000),
        probability: 53,
    };
    let sure = MaybeLine {
        probability: 1000,
        ..maybe
    };
    [maybe, sure]
}

fn guards() -> Vec<GuardLine> {
    let every = Reason::ALL
        .iter()
        .fold(Reasons::NONE, |set, &r| set.with(r));
    let guard = |hazard| GuardLine {
        sweep: 7,
        status: Status::Ok,
        free: Some(Tenths(9_004)),
        hazard,
        confidence: 998,
        reasons: Reasons::NONE,
    };
    let ok = guard(HazardKind::None);
    let nearer = GuardLine {
        reasons: Reasons::NONE.with(Reason::ScanNearer),
        ..guard(HazardKind::Drop)
    };
    let degraded = GuardLine {
        status: Status::Degraded,
        free: Some(Tenths(0)),
        confidence: 0,
        reasons: every,
        ..guard(HazardKind::Unknown)
    };
    let fault = GuardLine {
        sweep: u32::MAX,
        status: Status::Fault,
        free: None,
        reasons: Reasons::NONE.with(Reason::MotorStall),
        ..degraded
    };
    let extreme = |tenths| GuardLine {
        free: Some(Tenths(tenths)),
        confidence: 1000,
        ..ok
    };
    let extremes = [-1, i32::MAX, -i32::MAX].map(extreme);
    let each = HazardKind::ALL.map(guard);
    let fixed = [nearer, degraded, fault];
    each.into_iter().chain(fixed).chain(extremes).collect()
}

fn texts() -> Vec<Sentence<'static>> {
    let reasons = Reasons::NONE.with(Reason::LinkSilent);
    let state = |state, reasons, motion| Sentence::State {
        state,
        clock: "hsi-16",
        scans: 12,
        estimator: "likelihood",
        reasons,
        motion,
        motion_faults: u16::MAX,
        settings: 7,
    };
    let boot = BootLine {
        version: "0.1.0",
        revision: "abcdef0",
        reset: "power",
        clock: "hse-168",
        boots: 1,
        settings: 0x00AB_CDEF,
        serial: [0, 0x8000_0000, u32::MAX],
        ..BootLine::default()
    };
    vec![
        Sentence::Boot(boot),
        Sentence::Boot(BootLine {
            reset: "panic",
            second_memory: "ccm-64",
            option_bytes: Some(0x0FFF_AAED),
            crash: CrashSite {
                pc: Some(0),
                lr: Some(u32::MAX),
                cfsr: Some(0x8200),
                address: Some(0x8000_0000),
                place: Some(1),
            },
            ..boot
        }),
        Sentence::Crash(CrashLine::NONE),
        Sentence::Crash(CrashLine {
            cause: "memory-fault",
            boot: u32::MAX,
            site: CrashSite {
                cfsr: Some(0x92),
                address: Some(0x2000_001C),
                ..CrashSite::NONE
            },
        }),
        state("idle", Reasons::NONE, "absent"),
        state("fault", reasons, "disordered"),
        Sentence::Config {
            key: "mirror-offset",
            value: "22000",
        },
        Sentence::Config { key: "", value: "" },
        Sentence::Done { command: "start" },
        Sentence::Fail {
            command: "-",
            field: "crc",
            expected: "* and eight hex digits at the end",
        },
        Sentence::Fail {
            command: "set",
            field: "crc",
            expected: "send $PSTC,set,seed,7*352B37A8",
        },
    ]
}

/// Bodies with a correct CRC that are no sentence, or not in the scanner's canonical form.
const BAD_BODIES: &[&str] = &[
    "",
    "PSTR",
    "PSTR,",
    "PSTC,SCAN",
    "PSTR,scan",
    "PSTR,NOPE,1",
    "PSTR,SCAN",
    "PSTR,SCAN,+1,ok,none,00,0,++weak-echoes+weak-echoes+,-0.0,000.0,0,abcdefAB,0",
    "PSTR,SCAN,-1,ok,none,0,0,,,,0,00000000,0",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,00000000,0,",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,00000000,0,,290.0",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,00000000,0,,,-56.0",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,00000000,0,,290.0,",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,00000000,0,,290.0,-56.0,",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,00000000,0,height,290.0,-56.0",
    "PSTR,SCAN,4294967296,ok,none,0,0,,,,0,00000000,0",
    "PSTR,SCAN,1,OK,none,0,0,,,,0,00000000,0",
    "PSTR,SCAN,1,,none,0,0,,,,0,00000000,0",
    "PSTR,SCAN,1,ok,left,0,0,,,,0,00000000,0",
    "PSTR,SCAN,1,ok,none,256,0,,,,0,00000000,0",
    "PSTR,SCAN,1,ok,none,0,65536,,,,0,00000000,0",
    "PSTR,SCAN,1,ok,none,0,0,tired,,,0,00000000,0",
    "PSTR,SCAN,1,ok,none,0,0,lost-rows+,1000,,0,00000000,0",
    "PSTR,SCAN,1,ok,none,0,0,,1000.00,,0,00000000,0",
    "PSTR,SCAN,1,ok,none,0,0,,.5,,0,00000000,0",
    "PSTR,SCAN,1,ok,none,0,0,,+1.0,,0,00000000,0",
    "PSTR,SCAN,1,ok,none,0,0,,214748364.8,,0,00000000,0",
    "PSTR,SCAN,1,ok,none,0,0,,,100.1,0,00000000,0",
    "PSTR,SCAN,1,ok,none,0,0,,,-0.1,0,00000000,0",
    "PSTR,SCAN,1,ok,none,0,0,,,,,00000000,0",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,0000000,0",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,+0000000,0",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,0000000G,0",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,00000000,0,",
    "PSTR,STEP,1,1,1,,2.0,,,1.0,1.0,50",
    "PSTR,STEP,1,1,1,1.0,,,,1.0,1.0,50",
    "PSTR,STEP,1,1,1,1.0,2.0,,,,1.0,50",
    "PSTR,STEP,1,1,1,1.0,2.0,,,1.0,,50",
    "PSTR,STEP,1,1,1,1.0,2.0,,,1.0,1.0",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,00000000",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,00000000,",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,00000000,256",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,00000000,0,both",
    "PSTR,SCAN,1,ok,none,0,0,,,,0,00000000,0,depth,",
    "PSTR,DROP",
    "PSTR,DROP,1,,1.0,,97.0",
    "PSTR,DROP,1,900.0,,,97.0",
    "PSTR,DROP,1,900.0,1.0,deep,97.0",
    "PSTR,DROP,1,900.0,1.0,,",
    "PSTR,DROP,1,900.0,1.0,,100.1",
    "PSTR,DROP,1,900.0,1.0,,97.0,",
    "PSTR,MAYBE,1,1,1,1.0,2.0,",
    "PSTR,GUARD",
    "PSTR,GUARD,-1,ok,900.0,none,99.9,",
    "PSTR,GUARD,1,fine,900.0,none,99.9,",
    "PSTR,GUARD,1,ok,far,none,99.9,",
    "PSTR,GUARD,1,ok,900.0,,99.9,",
    "PSTR,GUARD,1,ok,900.0,step,99.9,",
    "PSTR,GUARD,1,ok,900.0,none,,",
    "PSTR,GUARD,1,ok,900.0,none,100.1,",
    "PSTR,GUARD,1,ok,900.0,none,99.9",
    "PSTR,GUARD,1,ok,900.0,none,99.9,tired",
    "PSTR,GUARD,1,ok,900.0,none,99.9,,",
    "PSTR,BOOT,1,2,3,4,5,00000000,00000000000000000000000",
    "PSTR,BOOT,1,2,3,4,5,00000000,000000000000000000000000",
    "PSTR,BOOT,1,2,3,4,5,00000000,000000000000000000000000,",
    "PSTR,BOOT,1,2,3,4,5,00000000,000000000000000000000000,,,,,,",
    "PSTR,BOOT,1,2,3,4,5,00000000,000000000000000000000000,,1,,,,,",
    "PSTR,BOOT,1,2,3,4,5,00000000,000000000000000000000000,n*ne,,,,,,",
    "PSTR,BOOT,1,2,3,4,5,00000000,000000000000000000000000,none,0000000g,,,,,",
    "PSTR,BOOT,1,2,3,4,5,00000000,000000000000000000000000,none,,,,abcdefAB,,",
    "PSTR,BOOT,1,2,3,4,5,00000000,000000000000000000000000,none,,,,,,,",
    "PSTR,CRASH",
    "PSTR,CRASH,panic,-1,,,,,",
    "PSTR,CRASH,panic,1,,,,",
    "PSTR,CRASH,panic,1,,,,,,",
    "PSTR,STAT,idle,hse-168,1,paper,,good,1",
    "PSTR,LIVE,idle,1,2,+3,good,0,0,0,0",
    "PSTR,LIVE,idle,1,2,4294967296,good,0,0,0,0",
    "PSTR,LIVE,idle,1,2,3,good,0,65536,0,0",
    "PSTR,LIVE,idle,1,2,3,good,0,0,0",
    "PSTR,CONF,plane,dep*th",
    "PSTR,CONF,$plane,depth",
    "PSTR,DONE",
    "PSTR,DONE,",
    "PSTR,FAIL,set,crc",
    "PSTR,FAIL,set,crc,",
    "PSTR,FAIL,set,crc,a,b,,$*",
    "PSTR,HALT,",
    "PSTR,HALT,lost-rows+crash",
];

/// Lines without a frame, or with a wrong CRC.
const BAD_LINES: [&str; 9] = [
    "",
    "$",
    "*",
    "$*",
    "PSTR,DONE,start*00000000",
    "$PSTR,DONE,start",
    "$PSTR,DONE,start*0000000",
    "$PSTR,DONE,start*00000000",
    "$PSTR,DONE,start*000000000",
];

fn commands() -> Vec<String> {
    let words = [
        "start",
        "stop",
        "scan",
        "status",
        "version",
        "crash?",
        "crash-clear",
        "selftest",
        "save",
        "update",
        "reset",
        "get",
    ];
    let mut lines: Vec<String> = words.map(str::to_owned).to_vec();
    let sentence = |words: &[&str]| framed(words).trim_end().to_owned();
    lines.extend(words.map(|word| sentence(&[word])));
    for key in Settings::KEYS {
        lines.push(format!("get {key}"));
        lines.push(sentence(&["set", key, "1"]));
    }
    lines.extend(tables::measures().iter().map(|key| sentence(&["get", key])));
    for (sequence, travel, pitch) in [
        (7, 1234, Some(-250)),
        (0, 0, None),
        (u16::MAX, i32::MAX, Some(45_000)),
        (1, -i32::MAX, Some(-45_000)),
    ] {
        let reading = Reading {
            sequence,
            travel,
            pitch,
        };
        lines.push(motion::write(&reading).trim_end().to_owned());
    }
    for word in ["guard", "watch"] {
        lines.extend(["on", "off", "", "On"].map(|switch| sentence(&[word, switch])));
        lines.push(format!("{word} on"));
        lines.push(format!("{word} on off"));
        lines.push(word.to_owned());
    }
    lines.extend(CALIBRATIONS.map(|words| sentence(&words)));
    lines.extend(BAD_COMMANDS.map(str::to_owned));
    let bodies = [
        "XXXX,start",
        "PSTC,",
        "PSTC",
        "PSTC,set,seed,7*",
        "PSTC,$start",
        "PSTC,MOTIONS,1,2.0,3",
        "PSTC,MOTION",
        "PSTC,MOTION,65536,2.0,3",
        "PSTC,MOTION,+1,2.0,+3",
        "PSTC,MOTION,1,,3",
        "PSTC,MOTION,1,2,3",
        "PSTC,MOTION,1,2.0",
        "PSTC,MOTION,1,2.0,1.5",
        "PSTC,MOTION,1,2.0,-0",
        "PSTC,MOTION,1,2.0,-+1",
        "PSTC,MOTION,1,2.0,45001",
        "PSTC,MOTION,1,2.0,3,4",
    ];
    lines.extend(bodies.map(closed));
    lines
}

const CALIBRATIONS: [[&str; 3]; 8] = [
    ["calibrate", "1500", "20261122"],
    ["calibrate", "+0", "99991231"],
    ["calibrate", "-0", "20000101"],
    ["calibrate", "-1", "20261122"],
    ["calibrate", "65536", "20261122"],
    ["calibrate", "1500", "20261301"],
    ["calibrate", "1500", "20261200"],
    ["calibrate", "1500", "4294967296"],
];

const BAD_COMMANDS: [&str; 18] = [
    "",
    " ,, status , ",
    "Start",
    "startle",
    "start now",
    "get nothing",
    "get seed 1",
    "set",
    "set stack-used 1",
    "set seed",
    "set seed 1 2",
    "calibrate",
    "calibrate 1500 20261122 1",
    "MOTION,1,2.0,3",
    "$PSTC,start",
    "$PSTC,start*00000000",
    "$PSTC,MOTION,1,2.0,3*00000000",
    "0123456789012345678901234567890123456789012345678901234567890123456789012345678901234567890123456",
];
