//! Logs of sentences: recorded without a terminal, and read again by every command that takes them.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use stairscan::report::sentence::crc32;

use crate::common::scanner::Scanner;
use crate::common::{Scratch, sim, started};

const ANSWER: [&str; 4] = [
    "$PSTR,SCAN,1,ok,up,3,0,,1000.0,98.9,0,100152FB,0*48425B4C",
    "$PSTR,STEP,1,1,3,500.5,165.4,279.5,165.4,1.5,3.7,100*2688B9C3",
    "$PSTR,STEP,1,2,3,780.0,330.7,280.6,165.3,1.5,13.6,100*252F41B4",
    "$PSTR,STEP,1,3,3,1060.7,495.1,,164.4,1.5,23.0,100*25D20E0E",
];

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Runs the program, which must succeed, and returns what it printed.
fn printed(args: &[&str]) -> String {
    let output = sim(args);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{args:?}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// Writes a log of two answers with times before the lines, noise and a byte order mark.
fn log(dir: &Path) -> std::path::PathBuf {
    let line = |at: &str, line: &str| format!("[2026-11-27 09:00:0{at}] {line}\r\n");
    let answer = |at: &str| -> String { ANSWER.iter().map(|text| line(at, text)).collect() };
    let log = format!("\u{feff}{}login:\n{}", answer("0.500"), answer("1.250"));
    let path = dir.join("logger.log");
    fs::write(&path, log).unwrap();
    path
}

/// Starts `live PORT --record DIR` without a terminal.
fn recording(port: &Path, dir: &Path) -> Child {
    started(&["live", text(port), "--record", text(dir)])
}

#[test]
fn live_records_without_a_terminal_and_its_file_is_read() {
    let dir = Scratch::new("logs-live");
    let (port, kept) = (dir.path().join("port"), dir.path().join("kept"));
    // Of a service that starts before its port is there, no file remains.
    assert!(!recording(&port, &kept).wait().unwrap().success());
    assert_eq!(fs::read_dir(&kept).unwrap().count(), 0);
    let scanner = Scanner::scripted(|| format!("\0{}", ANSWER.join("\r\n")), |_| Vec::new());
    symlink(&scanner.path, &port).unwrap();
    let child = recording(&port, &kept);
    let file = kept.join("live-001.txt");
    let until = Instant::now() + Duration::from_secs(60);
    while fs::read_to_string(&file).map_or(0, |text| text.matches(ANSWER[3]).count()) < 2 {
        assert!(Instant::now() < until, "nothing is recorded");
        std::thread::sleep(Duration::from_millis(10));
    }
    let stopped = Command::new("kill").arg(child.id().to_string()).status();
    assert!(stopped.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let lines = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{lines}");
    assert!(lines.starts_with("ok: 3 steps up"), "{lines}");
    assert!(lines.contains("recorded in"), "{lines}");
    scanner.unplug();

    let answers = printed(&["replay", "--log", text(&file), "--format", "json"]);
    assert!(answers.lines().count() >= 2 && answers.contains("\"status\":\"ok\""));
    let page = dir.path().join("page.html");
    printed(&["report", text(&kept), "-o", text(&page)]);
    let page = fs::read_to_string(page).unwrap();
    assert!(page.contains("\"name\":\"live-001.txt\""));
}

#[test]
fn a_loggers_file_is_converted_and_reported() {
    let dir = Scratch::new("logs-convert");
    let log = log(dir.path());
    let out = |name: &str| dir.path().join(name);
    let (answers, steps, mcap) = (out("answers.csv"), out("steps.csv"), out("scans.mcap"));
    printed(&[
        "convert",
        text(&log),
        "-o",
        text(&answers),
        "--table",
        "answers",
    ]);
    printed(&["convert", text(&log), "-o", text(&steps)]);
    printed(&["convert", text(&log), "-o", text(&mcap)]);
    let rows = |path: &Path| -> Vec<Vec<String>> {
        let mut csv = csv::Reader::from_path(path).unwrap();
        csv.records()
            .map(|row| row.unwrap().iter().map(str::to_owned).collect())
            .collect()
    };
    let answers = rows(&answers);
    assert_eq!(answers.len(), 2);
    assert_eq!(answers[0][..4], ["1795770000.500", "logger.log", "1", "ok"]);
    assert_eq!(answers[1][0], "1795770001.250");
    let steps = rows(&steps);
    assert_eq!(steps.len(), 6, "one a step");
    assert_eq!(steps[5].last().unwrap(), "1795770001.250");
    let file = fs::read(mcap).unwrap();
    let stamps: Vec<u64> = mcap::MessageStream::new(&file)
        .unwrap()
        .map(|message| message.unwrap())
        .filter(|message| message.channel.topic == "/stairscan/answer")
        .map(|message| message.log_time)
        .collect();
    assert_eq!(
        stamps,
        [1_795_770_000_500_000_000, 1_795_770_001_250_000_000]
    );
    let output = sim(&["convert", text(&log), "-o", text(&out("x.npy"))]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        error.contains("logger.log: a log has sentences only"),
        "{error}"
    );
}

#[test]
fn the_page_of_a_log_shows_answers_and_faults_over_time() {
    let dir = Scratch::new("logs-page");
    let log = log(dir.path());
    let framed = |body: &str| format!("${body}*{:08X}\n", stairscan::report::sentence::crc32(body));
    let more = framed("PSTR,SCAN,2,fault,none,0,0,no-echo,,,0,01234567,0") + "$PSTR,SC\n";
    let times = more
        .lines()
        .map(|line| format!("[2026-11-27 09:00:04.000] {line}\n"));
    let text_of = fs::read_to_string(&log).unwrap() + &times.collect::<String>();
    fs::write(&log, text_of).unwrap();
    let page = dir.path().join("page.html");
    printed(&["report", text(&log), "-o", text(&page)]);
    let page = fs::read_to_string(page).unwrap();
    let data = page.split_once("type=\"application/json\">").unwrap().1;
    let data = data.split_once("</script>").unwrap().0;
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    let log = &data["logs"][0];
    let answers = log["answers"].as_array().unwrap();
    let brief = |k: usize| {
        (
            answers[k]["at"].as_u64(),
            answers[k]["status"].as_str().unwrap(),
        )
    };
    assert_eq!(
        [brief(0), brief(1), brief(2)],
        [(Some(0), "ok"), (Some(750), "ok"), (Some(3_500), "fault")]
    );
    assert_eq!(answers[0]["free_m"], 0.5005);
    let events: Vec<&str> = (log["events"].as_array().unwrap().iter())
        .map(|event| event[1].as_str().unwrap())
        .collect();
    assert_eq!(
        events,
        ["damaged", "silence", "silence", "fault", "damaged"]
    );
    assert_eq!(log["begun_ms"], 1_795_770_000_500_u64);
}

/// A log with guard sweeps only, of which the third fails.
const SWEEPS: [&str; 3] = [
    "PSTR,GUARD,7,ok,1000.0,rise,99.8,",
    "PSTR,GUARD,8,degraded,912.5,unknown,97.3,lost-rows+weak-echoes",
    "PSTR,GUARD,9,fault,,unknown,0.0,motor-stall",
];

#[test]
fn a_log_of_guard_sweeps_becomes_a_table_and_messages() {
    let dir = Scratch::new("logs-sweeps");
    let [log, table, other] =
        ["guard.log", "sweeps.csv", "sweeps.mcap"].map(|name| dir.path().join(name));
    let lines = SWEEPS.iter().zip([100, 350, 600]);
    let lines = lines.map(|(body, at)| format!("{at} < ${body}*{:08X}\n", crc32(body)));
    fs::write(&log, lines.collect::<String>()).unwrap();
    let convert = ["convert", text(&log), "--table", "sweeps", "-o"];
    let said = printed(&[&convert[..], &[text(&table)]].concat());
    assert!(said.ends_with("rows of 3 guard sweeps\n"), "{said}");
    assert_eq!(
        fs::read_to_string(&table).unwrap(),
        "time_s,recording,sweep,status,free_m,ending,confidence,reasons\n\
         0.100,guard.log,7,ok,1.0,rise,0.998,\n\
         0.350,guard.log,8,degraded,0.9125,unknown,0.973,lost-rows weak-echoes\n\
         0.600,guard.log,9,fault,,unknown,0.0,motor-stall\n"
    );
    let refused = |args: &[&str], part: &str| {
        let output = sim(args);
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(
            !output.status.success() && error.contains(part),
            "{args:?} {error}"
        );
    };
    let recording = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/stair_a");
    refused(
        &[&convert[..], &[text(&other)]].concat(),
        "--table sweeps: expected .csv",
    );
    // Without the option, it is named.
    refused(&["convert", text(&log), "-o", "x.csv"], "--table sweeps");
    let said = printed(&["convert", text(&log), "-o", text(&other)]);
    assert!(said.ends_with("messages of 3 guard sweeps\n"), "{said}");
    let file = fs::read(&other).unwrap();
    let messages = mcap::MessageStream::new(&file).unwrap();
    let messages: Vec<_> = messages.map(Result::unwrap).collect();
    let of = |topic: &str| {
        let of = messages.iter().filter(|m| m.channel.topic == topic);
        of.map(|m| (m.log_time / 1_000_000, m.data.to_vec()))
            .collect::<Vec<_>>()
    };
    let [guard, free] = ["/stairscan/guard", "/stairscan/free"].map(of);
    let sweep: serde_json::Value = serde_json::from_slice(&guard[1].1).unwrap();
    assert_eq!((guard[1].0, &sweep["free_m"]), (350, &0.9125.into()));
    // 0 without a free distance; four bytes before it say how numbers are written.
    let free: Vec<f32> = free
        .iter()
        .map(|(_, data)| f32::from_le_bytes(data[4..8].try_into().unwrap()))
        .collect();
    assert_eq!(free, [1.0, 0.9125, 0.0]);
    refused(
        &["convert", recording, "--table", "sweeps", "-o", "x.csv"],
        "expected a log of sentences",
    );
    let answers = self::log(dir.path());
    refused(
        &[
            "convert",
            text(&answers),
            "--table",
            "sweeps",
            "-o",
            "x.csv",
        ],
        "no guard sweep",
    );
}

#[test]
fn a_log_is_played_at_its_speed() {
    let dir = Scratch::new("logs-play");
    let log = log(dir.path());
    let begun = Instant::now();
    let lines = printed(&["live", "--play", text(&log)]);
    assert!(begun.elapsed() >= Duration::from_millis(750));
    assert_eq!(lines.matches("ok: 3 steps up").count(), 2, "{lines}");
    let recording = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/stair_a");
    let output = sim(&["live", "--play", recording]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(error.contains("expected --foxglove or --ros2"), "{error}");
}

#[test]
fn what_is_no_log_is_explained() {
    let dir = Scratch::new("logs-none");
    let path = dir.path().join("boot.txt");
    for (bytes, part) in [
        (&b""[..], "it is empty"),
        (b"hello\n", "it holds text of another device: hello"),
        (b"U-Boot 2024\n", "it holds text of the boot loader U-Boot"),
    ] {
        fs::write(&path, bytes).unwrap();
        for args in [
            ["replay", "--log"],
            ["report", "-o=x.html"],
            ["convert", "-o=x.csv"],
        ] {
            let output = sim(&[&args[..], &[text(&path)]].concat());
            let error = String::from_utf8(output.stderr).unwrap();
            assert!(
                error.contains("boot.txt") && error.contains(part),
                "{args:?} {error}"
            );
        }
    }
}

/// A file that is missing is named as missing, with the system's reason, and one of another kind as what it is.
#[test]
fn what_stands_in_place_of_a_log_is_named() {
    let dir = Scratch::new("logs-other");
    let path = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (missing, notes, array) = (path("nofile"), path("notes.md"), path("chirps.npy"));
    fs::write(&notes, "# nothing\n").unwrap();
    fs::write(&array, "").unwrap();
    let recording = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/stair_a");
    for (file, part) in [
        (&*missing, "No such file or directory"),
        (text(dir.path()), "a directory, expected a log of sentences"),
        (&notes, "it holds text of another device: # nothing"),
        (&array, "a .npy, expected a log of sentences"),
    ] {
        for args in [
            &["replay", "--log", file][..],
            &["live", "--play", file],
            &["live", "--foxglove", "--play", file],
        ] {
            let output = Command::new(env!("CARGO_BIN_EXE_host-sim"))
                .args(args)
                // A build of the service would end here.
                .env("CARGO", "/no/cargo")
                .output()
                .unwrap();
            let error = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(1), "{args:?}: {error}");
            let begins = error.starts_with(&format!("error: {file}: "));
            assert!(begins && error.contains(part), "{args:?}: {error}");
        }
    }
    let refused = |args: &[&str], part: &str| {
        let output = sim(args);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{args:?}: {error}");
        assert!(error.contains(part), "{args:?}: {error}");
    };
    refused(
        &["replay", "--log", recording],
        "a recording, expected a log",
    );
    let page = path("page.html");
    // Beside a log, too.
    let answers = text(&self::log(dir.path())).to_owned();
    for (file, part) in [
        (&*missing, "No such file"),
        (recording, "stair_a: a recording"),
    ] {
        refused(&["report", &answers, file, "-o", &page], part);
    }
}
