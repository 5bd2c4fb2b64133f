//! Tests of `doctor` over pseudo-terminals.

use std::process::Output;
use std::time::Duration;

use host_sim::live::pty::Pty;
use host_sim::recording::Recording;
use stairscan::report::{LiveLine, ScanLine, Sentence};
use stairscan::scanner::Settings;
use stairscan::verdict::{Outcome, Reason, Reasons, Status};

use crate::common::scanner::{Scanner, stair_a};
use crate::common::sim;

fn printed(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn doctor(path: &str, more: &[&str]) -> Output {
    sim(&[&["doctor", path], more].concat())
}

/// Asserts that the list contains this check with this result and text.
fn has(text: &str, check: &str, result: &str, words: &str) {
    let line = text
        .lines()
        .find(|line| line.starts_with(check))
        .unwrap_or_default();
    let rest = line[check.len().min(line.len())..].trim_start();
    assert!(
        rest.starts_with(result) && rest.contains(words),
        "{check}: {result}, {words}:\n{text}"
    );
}

fn line(sentence: &Sentence<'_>) -> String {
    sentence.write().trim_end().to_owned()
}

fn live(state: &str) -> String {
    line(&Sentence::Live(LiveLine {
        state,
        scan: 0,
        uptime_ms: 9_000,
        age_ms: None,
        motion: "absent",
        motion_faults: 0,
        refused: 0,
        port_errors: 0,
        link_errors: 0,
    }))
}

fn set_of(reasons: &[Reason]) -> Reasons {
    reasons
        .iter()
        .fold(Reasons::NONE, |set, &reason| set.with(reason))
}

/// A scanner in `state` that reports these reasons in reply to every scan and self-test.
fn telling(
    state: &'static str,
    number: u32,
    status: Status,
    reasons: &'static [Reason],
) -> Scanner {
    let head = move || {
        line(&Sentence::Scan(ScanLine {
            status,
            reasons: set_of(reasons),
            ..ScanLine::new(number, 0, &Outcome::silent(), 0)
        }))
    };
    let says = move || {
        format!(
            "{}\r\n{}",
            live(state),
            if state == "idle" { live(state) } else { head() }
        )
    };
    Scanner::scripted(says, move |typed| {
        let settings = Settings::default();
        let command = stairscan::scanner::command::parse(typed).map(|command| command.word());
        match (typed, command) {
            ("version", _) => vec![line(&Sentence::Config {
                key: "version",
                value: concat!(env!("CARGO_PKG_VERSION"), " scripted"),
            })],
            ("status", _) => vec![line(&Sentence::State {
                state,
                clock: "hse-168",
                scans: number,
                estimator: "likelihood",
                reasons: if state == "idle" {
                    Reasons::NONE
                } else {
                    set_of(reasons)
                },
                motion: "absent",
                motion_faults: 0,
                settings: 0,
            })],
            ("get", _) => {
                let printed = Settings::KEYS.iter().map(|key| {
                    let value = settings.get(key).unwrap();
                    line(&Sentence::Config { key, value: &value })
                });
                printed
                    .chain([line(&Sentence::Done { command: "get" })])
                    .collect()
            }
            ("get option-bytes", _) => vec![line(&Sentence::Config {
                key: "option-bytes",
                value: "unknown",
            })],
            (_, Ok("selftest")) if number == 0 => {
                let field = reasons[0].as_str();
                vec![line(&Sentence::Fail {
                    command: "selftest",
                    field,
                    expected: "a passed self-test",
                })]
            }
            (_, Ok("selftest")) => vec![line(&Sentence::Done {
                command: "selftest",
            })],
            (_, Ok("scan")) => vec![line(&Sentence::Done { command: "scan" }), head()],
            _ => Vec::new(),
        }
    })
}

#[test]
fn a_healthy_scanner_has_nothing_but_its_calibration_to_see_to() {
    let scanner = Scanner::plug_in(stair_a());
    let output = doctor(&scanner.path, &[]);
    let text = printed(&output);
    has(
        &text,
        "port",
        "ok",
        "sentences come and commands are answered",
    );
    has(
        &text,
        "firmware",
        "ok",
        concat!("version ", env!("CARGO_PKG_VERSION"), ", revision host"),
    );
    has(&text, "seal", "ok", "");
    has(&text, "chip", "ok", "clock host");
    has(&text, "motor", "ok", "step-dir");
    has(&text, "home switch", "ok", "home-angle -165 deg");
    has(&text, "encoder", "none fitted", "");
    has(
        &text,
        "radar module",
        "ok",
        "carrier 94 GHz, bandwidth 10 GHz, 200 samples",
    );
    has(&text, "signal", "ok", "");
    has(&text, "mirror echo", "warning", "calibrated range never");
    has(&text, "mount, floor", "warning", "mount-height 0.4 m");
    has(&text, "answer", "ok", "scan");
    assert_eq!(output.status.code(), Some(3), "{text}");
    // Each line of JSON is a check.
    let json = doctor(&scanner.path, &["--format", "json"]);
    let lines: Vec<serde_json::Value> = printed(&json)
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(lines.len(), 13);
    assert_eq!(lines[0]["result"], "ok");
    scanner.unplug();
}

/// The scanner detects a fault of its module's samples.
#[test]
fn a_module_without_signal_is_a_fault() {
    let mut recording: Recording = stair_a();
    recording
        .samples
        .iter_mut()
        .for_each(|sample| *sample = stairscan::Iq::default());
    let scanner = Scanner::plug_in(recording);
    let output = doctor(&scanner.path, &[]);
    let text = printed(&output);
    has(&text, "signal", "FAULT", "silent: No signal at all.");
    has(&text, "radar module", "ok", "");
    has(&text, "mirror echo", "not seen", "silent");
    has(&text, "mount, floor", "not seen", "");
    assert!(text.contains("-> The samples hold no signal"), "{text}");
    assert_eq!(output.status.code(), Some(1), "{text}");
    scanner.unplug();
}

#[test]
fn every_stage_at_which_a_scanner_stops_is_reported() {
    let cases: &[(&str, u32, &'static [Reason], &str, &str)] = &[
        (
            "fault",
            0,
            &[Reason::HomeNotFound],
            "home switch",
            "radar module",
        ),
        (
            "fault",
            0,
            &[Reason::LinkSilent],
            "radar module",
            "mirror echo",
        ),
        ("idle", 0, &[Reason::MotorDriver], "motor", "home switch"),
        ("fault", 0, &[Reason::InternalClock], "chip", "motor"),
        (
            "scanning",
            7,
            &[Reason::MirrorMissing],
            "mirror echo",
            "mount, floor",
        ),
    ];
    for &(state, number, reasons, broken, behind) in cases {
        let state: &'static str = match state {
            "fault" => "fault",
            "idle" => "idle",
            _ => "scanning",
        };
        let scanner = telling(state, number, Status::Fault, reasons);
        let output = doctor(&scanner.path, &[]);
        let text = printed(&output);
        has(&text, broken, "FAULT", reasons[0].meaning());
        has(&text, behind, "not seen", reasons[0].as_str());
        assert_eq!(output.status.code(), Some(1), "{text}");
        scanner.unplug();
    }
    let scanner = telling(
        "scanning",
        7,
        Status::Degraded,
        &[Reason::Mount, Reason::GainDrift, Reason::ImageUnsealed],
    );
    let text = printed(&doctor(&scanner.path, &[]));
    for (check, word) in [
        ("mount, floor", "mount:"),
        ("mirror echo", "gain-drift:"),
        ("seal", "image-unsealed:"),
    ] {
        has(&text, check, "warning", word);
    }
    scanner.unplug();
}

#[test]
fn a_scanner_that_stands_is_moved_only_if_it_may_be() {
    let scanner = telling("idle", 3, Status::Ok, &[]);
    let text = printed(&doctor(&scanner.path, &["--no-move"]));
    has(&text, "motor", "not seen", "");
    has(&text, "answer", "not seen", "no scan came");
    let text = printed(&doctor(&scanner.path, &[]));
    has(&text, "motor", "ok", "");
    has(&text, "answer", "ok", "scan 3");
    scanner.unplug();
}

#[test]
fn a_silent_port_and_one_that_is_not_there_are_reported() {
    let silent = Pty::new().unwrap();
    let output = doctor(&silent.path, &[]);
    let text = printed(&output);
    has(&text, "port", "FAULT", "sends nothing");
    has(&text, "motor", "not seen", "no sentences at the port");
    assert!(text.contains("-> Is the scanner powered?"), "{text}");
    assert_eq!(output.status.code(), Some(1));
    has(
        &printed(&doctor("/dev/no-such-port", &[])),
        "port",
        "FAULT",
        "no /dev/no-such-port",
    );
}

/// The scanner sends `LIVE` but does not receive: its own reports are still evaluated.
#[test]
fn a_scanner_that_does_not_hear_is_reported() {
    let scanner = Scanner::scripted(|| live("idle"), |_| Vec::new());
    let output = doctor(&scanner.path, &["--wait", "1"]);
    let text = printed(&output);
    has(&text, "port", "FAULT", "does not reply");
    assert!(text.contains("REPORT_RX"), "{text}");
    has(&text, "firmware", "not seen", "");
    assert_eq!(output.status.code(), Some(1));
    scanner.unplug();
}

#[test]
fn a_port_that_hangs_up_is_reported_with_what_was_seen() {
    let scanner = Scanner::scripted(
        || live("scanning"),
        |typed| match typed {
            "version" => vec![line(&Sentence::Config {
                key: "version",
                value: concat!(env!("CARGO_PKG_VERSION"), " scripted"),
            })],
            _ => Vec::new(),
        },
    );
    let path = scanner.path.clone();
    let asking = std::thread::spawn(move || doctor(&path, &[]));
    std::thread::sleep(Duration::from_millis(1_500));
    scanner.unplug();
    let output = asking.join().unwrap();
    let text = printed(&output);
    has(&text, "port", "FAULT", "has gone");
    has(&text, "firmware", "ok", "version 0.2.0");
    has(&text, "radar module", "not seen", "");
    assert_eq!(output.status.code(), Some(1));
}
