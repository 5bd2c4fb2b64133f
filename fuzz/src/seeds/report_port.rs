//! Lines of the report port: commands, sentences, motion.

use super::counted;
use stairscan::answer::{Direction, DropEdge, PossibleStep, Step};
use stairscan::motion::Agreement;
use stairscan::report::sentence::{ScanId, write_scan};
use stairscan::report::{BootLine, CrashSite, LiveLine, Sentence};
use stairscan::scanner::Settings;
use stairscan::verdict::{Assessment, Conditions, Evidence, Outcome, Reason, Reasons, Validity};

/// Example of a settings hash.
const HASH: u32 = 0xDD17_E165;

pub(super) fn commands() -> Vec<(&'static str, Vec<u8>)> {
    let settings = Settings::default();
    let each = |before: &str| -> Vec<u8> {
        let line = |key: &&str| {
            format!(
                "{before}set,{key},{}\n",
                settings.get(key).unwrap_or_default()
            )
        };
        Settings::KEYS
            .iter()
            .map(line)
            .collect::<String>()
            .into_bytes()
    };
    let words =
        "save\nstart\nstop\nscan\nstatus\r\nversion\nselftest\nget\nget,seed\nget stack-used\n";
    let wrong = "set\nset,seed\nset,seed,-1\nset,nothing,1\nget,\nset,plane,sideways\nhello\nset,seed,1,2\n\
                 $PSTC,stop*00000000\n$PSTC\n$*\n";
    let extremes = "!set,first-angle,-170000\n!set,angle-count,8192\n!set,angle-step,10000\n\
                    !set,cfar-false-alarm,500000000\n!set,mirror-offset,200000\n!set,settle,600000000\n!save\n";
    let motion = "!MOTION,7,123.4,-250\n!MOTION,65535,-2147483.6,\n!MOTION,1,x,45001\n";
    vec![
        ("words", words.into()),
        ("settings", each("")),
        ("framed-settings", each("!")),
        ("wrong", wrong.into()),
        ("extremes", extremes.into()),
        ("motion", motion.into()),
        (
            "long",
            [vec![b'z'; 200], b"\nstatus\n\x01\xFF\0\nstop\n".to_vec()].concat(),
        ),
    ]
}

pub(super) fn sentences() -> Vec<(&'static str, Vec<u8>)> {
    let sight = Assessment {
        echo_found: true,
        valid: Some(Validity {
            horizon_m: 1.2,
            confidence: 0.993,
            first_step: 0.99,
        }),
        ..Assessment::nothing(Agreement::STANDING)
    };
    let evidence = Evidence {
        assessment: Some(sight),
        ..Evidence::default()
    };
    let mut outcome = Outcome::silent();
    outcome.decide(&evidence);
    outcome.answer.direction = Direction::Up;
    for k in 1..=3 {
        let step = Step {
            distance_m: 0.5 + 0.28 * k as f32,
            height_m: 0.17 * k as f32,
            distance_sigma_m: 0.0015,
            height_sigma_m: 0.004,
            quality: 100,
            ..Step::default()
        };
        // The list has room for sixteen.
        let _ = outcome.answer.steps.push(step);
    }
    outcome.answer.link();
    let mut degraded = outcome.clone();
    degraded.decide(&Evidence {
        health_faults: Reasons::NONE.with(Reason::Moving).with(Reason::Mount),
        ..evidence
    });
    let fault = Outcome::broken(Reasons::NONE.with(Reason::NoEcho), Conditions::GOOD);
    let maybe = PossibleStep {
        distance_m: 1.5,
        height_m: -0.1,
        probability: 0.2,
    };
    let _ = degraded.answer.possible_steps.push(maybe);
    degraded.answer.drop = Some(DropEdge {
        distance_m: 1.45,
        distance_sigma_m: 0.015,
        depth_m: Some(0.18),
        probability: 0.974,
    });
    // Without CRC and line end, so that changes of the text are not rejected by the CRC.
    let bare = |line: &str| {
        let body = line
            .trim_start_matches('$')
            .split('*')
            .next()
            .unwrap_or_default();
        format!("!{body}\n")
    };
    let lines = |outcome: &Outcome, lost: u16| {
        let mut text = String::new();
        write_scan(
            ScanId {
                scan: 7,
                settings: HASH,
            },
            lost,
            outcome,
            |line| text += &bare(line),
        );
        text.into_bytes()
    };
    let mut whole = Vec::new();
    write_scan(
        ScanId {
            scan: 1,
            settings: HASH,
        },
        0,
        &outcome,
        |line| whole.extend(line.as_bytes()),
    );
    let others = [
        Sentence::Boot(BootLine {
            version: "0.1.0",
            revision: "abcdef",
            reset: "power-on",
            clock: "hse-168",
            boots: 3,
            serial: [0x0033_0047, 0x3439_5110, 0x3530_3834],
            settings: HASH,
            second_memory: "ccm-64",
            option_bytes: Some(0x0fff_aaed),
            crash: CrashSite {
                pc: Some(0x0802_1234),
                lr: Some(0x0802_0801),
                cfsr: Some(0x8200),
                address: Some(0x4002_3c00),
                place: Some(HASH),
            },
        }),
        Sentence::State {
            state: "scanning",
            clock: "hsi-16",
            scans: 12,
            estimator: "likelihood",
            reasons: Reasons::NONE.with(Reason::LinkSilent),
            motion: "good",
            motion_faults: 3,
            settings: HASH,
        },
        Sentence::Live(LiveLine {
            state: "scanning",
            scan: 12,
            uptime_ms: 90_600,
            age_ms: Some(731),
            motion: "good",
            motion_faults: 3,
            refused: 1,
            port_errors: 0,
            link_errors: 2,
        }),
        Sentence::Config {
            key: "seed",
            value: "1",
        },
        Sentence::Done { command: "start" },
        Sentence::Fail {
            command: "set",
            field: "seed",
            expected: "a value",
        },
        Sentence::Halt {
            reason: Reason::MotorStall,
        },
    ];
    let others: String = others.iter().map(|s| bare(&s.write())).collect();
    vec![
        ("scan", lines(&outcome, 0)),
        ("degraded", lines(&degraded, 3)),
        ("fault", lines(&fault, 0)),
        ("framed", whole),
        ("others", others.into_bytes()),
    ]
}

pub(super) fn motion() -> Vec<(&'static str, Vec<u8>)> {
    let reading = |more: u8, travel: i16, pitch: i16| {
        let ([a, b], [c, d]) = (travel.to_le_bytes(), pitch.to_le_bytes());
        vec![1, more, a, b, c, d]
    };
    let begin = vec![2, 12, 0];
    let rows = |count| [3, 5, 46, 0].repeat(count);
    let good: Vec<u8> = (0..6)
        .flat_map(|k| [reading(1, 30, k), rows(2)].concat())
        .collect();
    let drive = |middle: Vec<u8>| {
        [
            reading(1, 0, 0),
            begin.clone(),
            good.clone(),
            middle,
            good.clone(),
            vec![4],
        ]
        .concat()
    };
    let text = [
        vec![0],
        counted(b"MOTION,7,123.4,-250"),
        vec![0],
        counted(b"MOTION,8,125.0,"),
    ]
    .concat();
    vec![
        ("two-scans", [drive(Vec::new()), drive(Vec::new())].concat()),
        ("late", drive(vec![5, 0xFF, 0x0F])),
        ("jump", drive(reading(1, 30_000, 4_000))),
        ("disordered", drive(reading(0xFF, 0, 0))),
        ("garbled", drive(vec![7])),
        ("text", [text, begin.clone(), rows(12), vec![4]].concat()),
        ("hours", drive(vec![6, 0xFF, 0xFF, 0xFF, 0x7F])),
    ]
}
