//! Tests of the checks' evaluation.

use stairscan::report::ScanLine;
use stairscan::scanner::Settings;
use stairscan::scanner::option_bytes::OptionBytes;
use stairscan::verdict::Outcome;

use super::*;

fn scan(number: u32, status: Status, reasons: &[Reason]) -> ScanLine {
    ScanLine {
        status,
        reasons: reasons
            .iter()
            .fold(Reasons::NONE, |set, &reason| set.with(reason)),
        ..ScanLine::new(number, 0, &Outcome::silent(), 0)
    }
}

/// Returns the replies of a calibrated scanner whose last scan is `scan`.
fn evidence(scan: Option<ScanLine>) -> Evidence {
    let mut settings = Settings::default();
    for (key, value) in [
        ("mirror-echo", "22013"),
        ("mirror-level", "-20000"),
        ("calibrated", "20261122"),
    ] {
        settings.set(key, value).unwrap();
    }
    let settings = Settings::KEYS.iter().map(|key| {
        (
            (*key).to_owned(),
            settings.get(key).unwrap().as_str().to_owned(),
        )
    });
    Evidence {
        port: "/dev/ttyUSB0".to_owned(),
        baud: 115_200,
        version: Some(format!(
            "{} {}",
            env!("CARGO_PKG_VERSION"),
            stairscan::REVISION
        )),
        state: Some("scanning".to_owned()),
        clock: Some("hse-168".to_owned()),
        option_bytes: OptionBytes::of_register(0x0fee_bbe1),
        scan,
        settings: settings.collect(),
        ..Evidence::default()
    }
}

fn level_of(findings: &[Finding], check: Check) -> Level {
    findings
        .iter()
        .find(|finding| finding.check == check)
        .unwrap()
        .level
}

#[test]
fn a_healthy_scanner_is_well() {
    let findings = examine(&evidence(Some(scan(2, Status::Ok, &[Reason::WeakEchoes]))));
    assert_eq!(worst(&findings), Level::Absent, "{}", text(&findings));
    assert_eq!(level_of(&findings, Check::Encoder), Level::Absent);
}

/// A board as it comes from the chip's maker is a warning that says what to set; one that cannot be read is not seen.
#[test]
fn option_bytes_that_are_not_set_are_a_warning() {
    let of = |option_bytes| {
        examine(&Evidence {
            option_bytes,
            ..evidence(Some(scan(2, Status::Ok, &[])))
        })
    };
    let new = of(OptionBytes::of_register(0x0fff_aaed));
    assert_eq!(level_of(&new, Check::OptionBytes), Level::Warning);
    assert!(text(&new).contains("BOR_LEV=0 nWRP0=0 nWRP4=0"));
    let emulated = of(None);
    assert_eq!(level_of(&emulated, Check::OptionBytes), Level::Unseen);
    assert!(text(&emulated).contains("unknown"));
}

/// Every reason that degrades an answer gives a warning and a remedy.
#[test]
fn every_reason_shows_where_it_belongs_with_its_fix() {
    for &reason in Reason::ALL {
        let fault = reason.effects().contains(&ReasonEffect::Fault);
        let only_word = reason
            .effects()
            .iter()
            .all(|&effect| effect == ReasonEffect::Info);
        let (number, status) = match (fault, only_word) {
            (true, _) => (3, Status::Fault),
            (_, true) => (3, Status::Ok),
            _ => (3, Status::Degraded),
        };
        let findings = examine(&evidence(Some(scan(number, status, &[reason]))));
        let found = findings
            .iter()
            .find(|finding| finding.check == fixes::check(reason))
            .unwrap();
        let expected = match (fault, only_word) {
            (true, _) => Level::Fault,
            (_, true) => Level::Ok,
            _ => Level::Warning,
        };
        assert_eq!(found.level, expected, "{}", text(&findings));
        assert!(
            found.observed.contains(reason.meaning()),
            "{}",
            text(&findings)
        );
        assert_eq!(found.fixes.is_empty(), only_word, "{}", text(&findings));
    }
}

/// Checks behind the stage at which the scanner stopped are not reported as good.
#[test]
fn what_was_not_reached_is_not_seen() {
    let stopped = |number, reason| examine(&evidence(Some(scan(number, Status::Fault, &[reason]))));
    let findings = stopped(0, Reason::HomeNotFound);
    assert_eq!(level_of(&findings, Check::Chip), Level::Ok);
    for check in [
        Check::Motor,
        Check::Module,
        Check::Signal,
        Check::MirrorEcho,
        Check::Mount,
        Check::Seal,
    ] {
        assert_eq!(
            level_of(&findings, check),
            Level::Unseen,
            "{}",
            text(&findings)
        );
    }
    let findings = stopped(0, Reason::LinkSilent);
    for check in [Check::Motor, Check::Home] {
        assert_eq!(level_of(&findings, check), Level::Ok, "{}", text(&findings));
    }
    assert_eq!(level_of(&findings, Check::Module), Level::Fault);
    assert_eq!(level_of(&findings, Check::MirrorEcho), Level::Unseen);
    let findings = stopped(4, Reason::Silent);
    assert_eq!(level_of(&findings, Check::Module), Level::Ok);
    for check in [Check::MirrorEcho, Check::Mount] {
        assert_eq!(
            level_of(&findings, check),
            Level::Unseen,
            "{}",
            text(&findings)
        );
    }
    let findings = stopped(4, Reason::MirrorMissing);
    assert_eq!(level_of(&findings, Check::Signal), Level::Ok);
    assert_eq!(level_of(&findings, Check::Mount), Level::Unseen);
    for reason in [Reason::Supply, Reason::SelfTest, Reason::ImageDamaged] {
        let findings = stopped(0, reason);
        assert_eq!(
            level_of(&findings, Check::Motor),
            Level::Unseen,
            "{}",
            text(&findings)
        );
    }
}

#[test]
fn nothing_is_made_of_nothing() {
    let findings = examine(&Evidence {
        settings: Default::default(),
        version: None,
        clock: None,
        ..evidence(None)
    });
    for check in [
        Check::Firmware,
        Check::Chip,
        Check::Motor,
        Check::Module,
        Check::Mount,
        Check::Answer,
    ] {
        assert_eq!(
            level_of(&findings, check),
            Level::Unseen,
            "{}",
            text(&findings)
        );
    }
    // A passed self-test gives more information.
    let findings = examine(&Evidence {
        passed: true,
        ..evidence(None)
    });
    assert_eq!(level_of(&findings, Check::Home), Level::Ok);
    assert_eq!(level_of(&findings, Check::Module), Level::Ok);
    assert_eq!(level_of(&findings, Check::Signal), Level::Unseen);
    // So does a fault reported by `status`.
    let status_reasons = Reasons::NONE.with(Reason::MotorStall);
    let findings = examine(&Evidence {
        status_reasons,
        ..evidence(None)
    });
    assert_eq!(level_of(&findings, Check::Motor), Level::Fault);
    assert_eq!(level_of(&findings, Check::Home), Level::Unseen);
}

#[test]
fn what_is_to_be_seen_to_is_a_warning() {
    let ok = || evidence(Some(scan(2, Status::Ok, &[])));
    let level = |evidence: Evidence, check| level_of(&examine(&evidence), check);
    assert_eq!(
        level(Evidence { damaged: 1, ..ok() }, Check::Port),
        Level::Warning
    );
    assert_eq!(
        level(
            Evidence {
                counters: [0, 0, 0, 2],
                ..ok()
            },
            Check::Module
        ),
        Level::Warning
    );
    assert_eq!(
        level(
            Evidence {
                version: Some("9.9.9 abc".to_owned()),
                ..ok()
            },
            Check::Firmware
        ),
        Level::Warning
    );
    assert_eq!(
        level(
            Evidence {
                clock: Some("hsi-16".to_owned()),
                ..ok()
            },
            Check::Chip
        ),
        Level::Warning
    );
    let uncalibrated = [
        ("mirror-echo", "0", Check::MirrorEcho),
        ("calibrated", "0", Check::Mount),
        ("encoder", "as5600", Check::Encoder),
    ];
    for (key, value, check) in uncalibrated {
        let mut evidence = ok();
        evidence.settings.insert(key.to_owned(), value.to_owned());
        assert_eq!(level(evidence, check), Level::Warning, "{key}");
    }
}

/// Compares the checklist of a scanner with default settings, never calibrated, with `list.txt`, to which
/// docs/user/live.md links.
#[test]
fn the_list_is_the_kept_one() {
    let mut evidence = evidence(Some(scan(1, Status::Ok, &[])));
    for key in ["mirror-echo", "mirror-level", "calibrated"] {
        evidence.settings.insert(key.to_owned(), "0".to_owned());
    }
    let list = text(&examine(&evidence)).replace(stairscan::REVISION, "4b9a883");
    assert_eq!(list, include_str!("list.txt"));
}
