use super::*;
use crate::answer::{DropEdge, PossibleStep, Step};
use crate::motion::Agreement;
use crate::verdict::{Assessment, Evidence, GuardResult, HazardKind, Validity};
use proptest::prelude::*;

fn boot() -> BootLine<'static> {
    BootLine {
        version: "0.1.0",
        revision: "abc",
        reset: "power",
        clock: "hse-168",
        boots: 12,
        settings: u32::MAX,
        serial: [1, 0x8000_0000, 0xfedc_ba98],
        ..BootLine::default()
    }
}

fn step() -> StepLine {
    StepLine {
        scan: 7,
        index: 2,
        count: 3,
        distance: Tenths(-5003),
        height: Tenths(1650),
        tread: None,
        riser: Some(Tenths(9)),
        distance_sigma: Tenths(12),
        height_sigma: Tenths(0),
        quality: 93,
    }
}

#[test]
fn a_step_reads_as_documented() {
    let line = Sentence::Step(step()).write();
    assert!(
        line.starts_with("$PSTR,STEP,7,2,3,-500.3,165.0,,0.9,1.2,0.0,93*"),
        "{line}"
    );
    assert!(line.ends_with("\r\n"));
}

#[test]
fn a_guard_sweep_reads_as_documented() {
    let line = Sentence::Guard(GuardLine {
        sweep: 7,
        status: Status::Ok,
        free: Some(Tenths(9_004)),
        hazard: HazardKind::Drop,
        confidence: 998,
        reasons: Reasons::NONE.with(Reason::ScanNearer),
    })
    .write();
    assert!(
        line.starts_with("$PSTR,GUARD,7,ok,900.4,drop,99.8,scan-nearer*"),
        "{line}"
    );
    let fault = GuardLine::new(8, &GuardResult::broken(Reason::MotorStall));
    let line = Sentence::Guard(fault).write();
    assert!(
        line.starts_with("$PSTR,GUARD,8,fault,,unknown,0.0,motor-stall*"),
        "{line}"
    );
}

#[test]
fn a_boot_reads_as_documented_and_that_of_an_older_firmware_too() {
    let older = "PSTR,BOOT,0.1.0,abc,power,hse-168,12,FFFFFFFF,0000000180000000FEDCBA98";
    let closed = |body: &str| format!("${body}*{:08X}", crc32(body));
    let plain = Sentence::Boot(boot());
    assert_eq!(Sentence::parse(&closed(older)), Ok(plain));
    assert_eq!(plain.write().trim_end(), closed(&format!("{older},,,,,,,")));
    let crashed = BootLine {
        reset: "panic",
        second_memory: "none",
        option_bytes: Some(0x0fff_aaed),
        crash: CrashSite {
            pc: Some(0x0802_1234),
            lr: Some(0x0802_0801),
            cfsr: Some(0x8200),
            address: None,
            place: Some(0x1234_abcd),
        },
        ..boot()
    };
    let tail = "none,0FFFAAED,08021234,08020801,00008200,,1234ABCD";
    let body = format!("{older},{tail}").replace(",power,", ",panic,");
    assert_eq!(Sentence::Boot(crashed).write().trim_end(), closed(&body));
    assert_eq!(Sentence::parse(&closed(&body)), Ok(Sentence::Boot(crashed)));
}

#[test]
fn a_crash_reads_as_documented() {
    let line = Sentence::Crash(CrashLine::NONE).write();
    assert!(line.starts_with("$PSTR,CRASH,none,0,,,,,*"), "{line}");
    let line = Sentence::Crash(CrashLine {
        cause: "memory-fault",
        boot: 7,
        site: CrashSite {
            cfsr: Some(0x92),
            address: Some(0x2000_001c),
            ..CrashSite::NONE
        },
    })
    .write();
    let expected = "$PSTR,CRASH,memory-fault,7,,,00000092,2000001C,*";
    assert!(line.starts_with(expected), "{line}");
}

#[test]
fn the_crc_is_the_one_that_everybody_has() {
    assert_eq!(crc32("123456789"), 0xCBF4_3926);
}

#[test]
fn every_sentence_survives_the_way_out_and_back() {
    let reasons = Reasons::NONE
        .with(Reason::LostRows)
        .with(Reason::WeakEchoes);
    let scan = ScanLine {
        scan: u32::MAX,
        status: Status::Degraded,
        direction: Direction::Up,
        steps: 3,
        lost_rows: 12,
        reasons,
        horizon: Some(Tenths(13_000)),
        confidence: Some(987),
        possible_steps: 2,
        settings: 0x0123_abcd,
        drops: 1,
        plane: None,
        ground: None,
    };
    for sentence in [
        Sentence::Scan(scan),
        Sentence::Step(step()),
        Sentence::Drop(DropLine {
            scan: 3,
            distance: Tenths(9_123),
            distance_sigma: Tenths(151),
            depth: Some(Tenths(1_800)),
            probability: 974,
        }),
        Sentence::Drop(DropLine {
            depth: None,
            ..DropLine::default()
        }),
        Sentence::Maybe(MaybeLine {
            scan: 3,
            index: 1,
            count: 2,
            distance: Tenths(12_345),
            height: Tenths(-1_000),
            probability: 53,
        }),
        Sentence::Guard(GuardLine {
            sweep: u32::MAX,
            status: Status::Ok,
            free: Some(Tenths(12_345)),
            hazard: HazardKind::Obstacle,
            confidence: 998,
            reasons,
        }),
        Sentence::Guard(GuardLine::new(7, &GuardResult::broken(Reason::MotorStall))),
        Sentence::Boot(boot()),
        Sentence::Crash(CrashLine::NONE),
        Sentence::Crash(CrashLine {
            cause: "panic",
            boot: u32::MAX,
            site: CrashSite {
                lr: Some(u32::MAX),
                place: Some(7),
                ..CrashSite::NONE
            },
        }),
        Sentence::Boot(BootLine {
            second_memory: "ccm-64",
            option_bytes: Some(0x0fff_aaed),
            crash: CrashSite {
                pc: Some(0x0802_1234),
                address: Some(0),
                ..CrashSite::NONE
            },
            ..boot()
        }),
        Sentence::State {
            state: "idle",
            clock: "hsi-16",
            scans: 0,
            estimator: "paper",
            reasons,
            motion: "good",
            motion_faults: 3,
            settings: 7,
        },
        Sentence::Live(LiveLine {
            state: "self-test",
            scan: u32::MAX,
            uptime_ms: u32::MAX,
            age_ms: Some(u32::MAX),
            motion: "disordered",
            motion_faults: u16::MAX,
            refused: u16::MAX,
            port_errors: u16::MAX,
            link_errors: u16::MAX,
        }),
        Sentence::Live(LiveLine {
            state: "idle",
            scan: 0,
            uptime_ms: 200,
            age_ms: None,
            motion: "absent",
            motion_faults: 0,
            refused: 1,
            port_errors: 2,
            link_errors: 3,
        }),
        Sentence::Config {
            key: "seed",
            value: "-12",
        },
        Sentence::Done { command: "scan" },
        Sentence::Fail {
            command: "set",
            field: "seed",
            expected: "send $PSTC,set,seed,7*01234567",
        },
        Sentence::Halt {
            reason: Reason::Crash,
        },
    ] {
        assert_eq!(Sentence::parse(&sentence.write()), Ok(sentence));
    }
}

#[test]
fn text_cannot_break_the_frame() {
    let line = Sentence::Fail {
        command: "a,b*c$\n",
        field: "é",
        expected: "x",
    }
    .write();
    let back = Sentence::Fail {
        command: "a b c  ",
        field: " ",
        expected: "x",
    };
    assert_eq!(Sentence::parse(&line), Ok(back));
}

#[test]
fn an_overlong_line_is_cut_and_still_closed() {
    let long = "x".repeat(500);
    let line = Sentence::Config {
        key: "k",
        value: &long,
    }
    .write();
    assert_eq!(line.len(), MAX_SENTENCE);
    assert!(matches!(
        Sentence::parse(&line),
        Ok(Sentence::Config { .. })
    ));
}

#[test]
fn a_scan_with_every_reason_keeps_what_follows_them() {
    let mut reasons = Reasons::NONE;
    Reason::ALL.iter().for_each(|&reason| reasons.add(reason));
    let written = ScanLine {
        scan: u32::MAX,
        status: Status::Degraded,
        direction: Direction::None,
        steps: 16,
        lost_rows: 8192,
        reasons,
        horizon: Some(Tenths(-1_000_000)),
        confidence: Some(1000),
        possible_steps: u8::MAX,
        settings: u32::MAX,
        drops: u8::MAX,
        plane: Some(crate::config::Plane::Height),
        ground: Some(SlopeField {
            from: Tenths(-20_000),
            rise: Tenths(-10_000),
        }),
    };
    let line = Sentence::Scan(written).write();
    let Ok(Sentence::Scan(read)) = Sentence::parse(&line) else {
        panic!("{line}");
    };
    assert!(read.reasons.has(Reason::LostRows) && !read.reasons.has(Reason::Crash));
    let all = ScanLine { reasons, ..read };
    assert_eq!(all, written);
}

/// Body of a boot sentence of an older firmware.
const BOOT: &str = "PSTR,BOOT,1,2,3,4,5,00000000,000000000000000000000000";

#[test]
fn garbled_lines_are_refused() {
    let line = Sentence::Step(step()).write();
    assert_eq!(
        Sentence::parse(&line.replace("165.0", "165.1")),
        Err(ParseError::Crc)
    );
    assert_eq!(Sentence::parse("PSTR,SCAN"), Err(ParseError::Frame));
    let closed = |body: &str| format!("${body}*{:08X}", crc32(body));
    for (body, field) in [
        ("PSTR,SCAN,1,fine,none,0,0,", "status"),
        ("PSTR,SCAN,1,ok,none,0,0,because", "reasons"),
        ("PSTR,SCAN,1,ok,none,0,0,,", "confidence"),
        ("PSTR,SCAN,1,ok,none,0,0,,far,", "horizon"),
        ("PSTR,SCAN,1,ok,none,0,0,,1000.0,100.1", "confidence"),
        ("PSTR,SCAN,1,ok,none,0,0,,1000.0,99.1,", "maybes"),
        ("PSTR,SCAN,1,ok,none,0,0,,1000.0,99.1,0", "settings"),
        ("PSTR,SCAN,1,ok,none,0,0,,1000.0,99.1,0,0123456", "settings"),
        (
            "PSTR,SCAN,1,ok,none,0,0,,1000.0,99.1,0,+1234567",
            "settings",
        ),
        (
            "PSTR,SCAN,1,ok,none,0,0,,1000.0,99.1,0,012345678",
            "settings",
        ),
        ("PSTR,SCAN,1,ok,none,0,0,,1000.0,99.1,0,01234567", "drops"),
        ("PSTR,SCAN,1,ok,none,0,0,,1000.0,99.1,0,01234567,", "drops"),
        (
            "PSTR,SCAN,1,ok,none,0,0,,1000.0,99.1,0,01234567,256",
            "drops",
        ),
        (
            "PSTR,SCAN,1,ok,none,0,0,,1000.0,99.1,0,01234567,0,",
            "plane",
        ),
        (
            "PSTR,SCAN,1,ok,none,0,0,,1000.0,99.1,0,01234567,0,both",
            "plane",
        ),
        (
            "PSTR,SCAN,1,ok,none,0,0,,1000.0,99.1,0,01234567,0,depth,",
            "slope-from",
        ),
        ("PSTR,DROP,x,900.0,10.0,,97.0", "scan"),
        ("PSTR,DROP,1,,10.0,,97.0", "distance"),
        ("PSTR,DROP,1,900.0,,,97.0", "distance-sigma"),
        ("PSTR,DROP,1,900.0,10.0,deep,97.0", "depth"),
        ("PSTR,DROP,1,900.0,10.0,,", "probability"),
        ("PSTR,DROP,1,900.0,10.0,,100.1", "probability"),
        ("PSTR,DROP,1,900.0,10.0,180.0,97.0,1", "end"),
        ("PSTR,GUARD,-1,ok,900.0,none,99.9,", "sweep"),
        ("PSTR,GUARD,1,fine,900.0,none,99.9,", "status"),
        ("PSTR,GUARD,1,ok,far,none,99.9,", "free"),
        ("PSTR,GUARD,1,ok,900.0,,99.9,", "ending"),
        ("PSTR,GUARD,1,ok,900.0,step,99.9,", "ending"),
        ("PSTR,GUARD,1,ok,900.0,none,,", "confidence"),
        ("PSTR,GUARD,1,ok,900.0,none,100.1,", "confidence"),
        ("PSTR,GUARD,1,ok,900.0,none,99.9,tired", "reasons"),
        ("PSTR,GUARD,1,ok,900.0,none,99.9", "reasons"),
        ("PSTR,GUARD,1,ok,900.0,none,99.9,,", "end"),
        ("PSTR,BOOT,1,2,3,4,5,00000000,00000000", "serial"),
        (&format!("{BOOT},"), "option-bytes"),
        (&format!("{BOOT},none,,,,,"), "place"),
        (&format!("{BOOT},none,1,,,,,"), "option-bytes"),
        (&format!("{BOOT},none,,,,0000000G,,"), "cfsr"),
        (&format!("{BOOT},none,,,,,,,"), "end"),
        ("PSTR,CRASH,panic,-1,,,,,", "boot"),
        ("PSTR,CRASH,panic,1,,,,", "place"),
        ("PSTR,FAIL,set,crc", "expected"),
        // A framing character is invalid in a field, even if the CRC fits.
        ("PSTR,CONF,plane,dep*th", "value"),
        ("PSTR,CONF,$plane,depth", "key"),
        ("PSTR,DONE,start*00000000", "command"),
        ("PSTR,FAIL,se$t,crc,any", "command"),
        ("PSTR,STEP,1,1,1,+1.0,2.0,,,1.0,1.0,50", "distance"),
        ("PSTR,STEP,1,1,1,1.0,99999999999.0,,,1.0,1.0,50", "height"),
        ("PSTR,NOPE", "name"),
    ] {
        assert_eq!(
            Sentence::parse(&closed(body)),
            Err(ParseError::Field(field)),
            "{body}"
        );
    }
}

#[test]
fn a_sentence_is_printable_and_its_crc_hex_digits() {
    let closed = |body: &str| format!("${body}*{:08X}", crc32(body));
    for body in [
        "PSTR,CONF,key,\u{e9}",
        "PSTR,CONF,key,a\rb",
        "PSTR,DONE,\u{7f}",
    ] {
        assert_eq!(
            Sentence::parse(&closed(body)),
            Err(ParseError::Frame),
            "{body}"
        );
    }
    let body = (0..).map(|k| format!("PSTR,CONF,seed,{k}"));
    let body = body
        .into_iter()
        .find(|body| crc32(body) >> 28 == 0)
        .unwrap();
    let line = closed(&body);
    assert!(Sentence::parse(&line).is_ok(), "{line}");
    let signed = line.replace("*0", "*+");
    assert_eq!(Sentence::parse(&signed), Err(ParseError::Crc), "{signed}");
}

#[test]
fn nonsense_lengths_saturate() {
    assert_eq!(Tenths::from_metres(f32::NAN), Tenths(0));
    assert_eq!(Tenths::from_metres(f32::INFINITY), Tenths(1_000_000));
    assert_eq!(Tenths::from_metres(-0.000_05), Tenths(-1));
}

#[test]
fn a_fault_carries_no_steps() {
    let mut outcome = Outcome::silent();
    let _ = outcome.answer.steps.push(Step::default());
    let mut lines = 0;
    write_scan(ScanId::FIRST, 0, &outcome, |line| {
        lines += 1;
        assert!(line.contains("SCAN,1,fault,none,0,0,silent"), "{line}");
    });
    assert_eq!(lines, 1);
}

/// An `ok` answer with a step, a drop and a possible step.
fn with_drop() -> Outcome {
    let mut outcome = Outcome::silent();
    let valid = Some(Validity {
        horizon_m: 1.3,
        confidence: 0.995,
        first_step: 0.99,
    });
    let sight = Assessment {
        echo_found: true,
        valid,
        ..Assessment::nothing(Agreement::STANDING)
    };
    outcome.answer.drop = Some(DropEdge {
        distance_m: 0.912_34,
        distance_sigma_m: 0.015_1,
        depth_m: Some(0.18),
        probability: 0.9738,
    });
    let _ = outcome.answer.steps.push(Step::default());
    let _ = outcome.answer.possible_steps.push(PossibleStep::default());
    outcome.decide(&Evidence {
        assessment: Some(sight),
        ..Evidence::default()
    });
    outcome
}

#[test]
fn a_drop_stands_between_steps_and_maybes() {
    let outcome = with_drop();
    let mut lines = std::vec::Vec::new();
    write_scan(
        ScanId {
            scan: 7,
            settings: 0,
        },
        0,
        &outcome,
        |line| lines.push(line.clone()),
    );
    assert_eq!(lines.len(), 4);
    assert!(
        lines[0].contains(",1300.0,99.5,1,00000000,1*"),
        "{}",
        lines[0]
    );
    assert!(lines[1].starts_with("$PSTR,STEP,7,1,1,"), "{}", lines[1]);
    assert!(
        lines[2].starts_with("$PSTR,DROP,7,912.3,15.1,180.0,97.4*"),
        "{}",
        lines[2]
    );
    assert!(lines[3].starts_with("$PSTR,MAYBE,7,1,1,"), "{}", lines[3]);
    let Ok(Sentence::Scan(head)) = Sentence::parse(&lines[0]) else {
        panic!("{}", lines[0]);
    };
    assert_eq!((head.drops, head.following()), (1, 3));
    let Ok(Sentence::Drop(reported)) = Sentence::parse(&lines[2]) else {
        panic!("{}", lines[2]);
    };
    let edge = reported.edge();
    assert!((edge.distance_m - 0.9123).abs() < 1e-6 && edge.depth_m == Some(0.18));
    assert!((edge.nearest_m() - 0.867).abs() < 1e-6 && edge.probability == 0.974);
}

#[test]
fn a_fault_carries_no_drop() {
    let mut outcome = with_drop();
    outcome.decide(&Evidence::default());
    let mut lines = 0;
    write_scan(ScanId::FIRST, 0, &outcome, |line| {
        lines += 1;
        assert!(line.contains(",0,00000000,0*"), "{line}");
    });
    assert_eq!(lines, 1);
}

proptest! {
    #[test]
    fn any_bytes_are_parsed_or_refused(line in ".{0,200}") {
        let _ = Sentence::parse(&line);
    }

    #[test]
    fn any_length_survives(tenths in -1_000_000i32..=1_000_000) {
        let line = Sentence::Step(StepLine { distance: Tenths(tenths), ..step() }).write();
        match Sentence::parse(&line) {
            Ok(Sentence::Step(back)) => prop_assert_eq!(back.distance, Tenths(tenths)),
            other => prop_assert!(false, "{:?}", other),
        }
    }
}

/// Fields of a slope are optional, both or none, with the plane or an empty field before them.
#[test]
fn a_slope_of_the_ground_ends_the_head() {
    let outcome = Outcome::silent();
    let ground = Some(SlopeField {
        from: Tenths(2_900),
        rise: Tenths(-560),
    });
    for plane in [None, Some(crate::config::Plane::Depth)] {
        let head = Sentence::Scan(ScanLine {
            plane,
            ground,
            ..ScanLine::new(7, 0, &outcome, 0)
        });
        let line = head.write();
        assert!(line.contains(",290.0,-56.0*"), "{line}");
        assert_eq!(Sentence::parse(&line), Ok(head));
    }
    for (fields, wrong) in [
        ("", "plane"),
        (",290.0", "slope"),
        (",,-56.0", "slope-from"),
        (",290.0,", "slope"),
        (",290.0,-56.0,", "end"),
    ] {
        let body = std::format!("PSTR,SCAN,7,fault,none,0,0,,,,0,00000000,0,{fields}");
        let line = std::format!("${body}*{:08X}", crc32(&body));
        assert_eq!(
            Sentence::parse(&line),
            Err(ParseError::Field(wrong)),
            "{line}"
        );
    }
}

/// The field for the plane is optional, and a sentence with or without it is parsed as it was written.
#[test]
fn only_a_scanner_of_both_planes_tells_the_plane() {
    use crate::config::Plane;
    let outcome = Outcome::silent();
    let reported = |plane| {
        Sentence::Scan(ScanLine {
            plane,
            ..ScanLine::new(7, 0, &outcome, 0)
        })
    };
    for (plane, end) in [
        (None, ",0*"),
        (Some(Plane::Depth), ",0,depth*"),
        (Some(Plane::Height), ",0,height*"),
    ] {
        let line = reported(plane).write();
        assert!(line.contains(end), "{line}");
        assert_eq!(Sentence::parse(&line), Ok(reported(plane)));
    }
}
