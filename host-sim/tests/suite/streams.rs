//! One reader of the report: each of the program's readers, and the C parser, take the same sentences from the same bytes.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Command, Stdio};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use anyhow::Result;
use host_sim::crash;
use host_sim::emulate::image::workspace;
use host_sim::live::lines::Splitter;
use host_sim::live::model::{Event, State};
use host_sim::live::port::Source;
use host_sim::live::pty::Pty;
use host_sim::tap::beside::Beside;
use host_sim::update::wire::{Link, Wire};
use stairscan::report::Sentence;
use stairscan::report::sentence::crc32;

use crate::common::scanner::Scanner;
use crate::common::{Scratch, sim, started};

const SCAN: &str = "$PSTR,SCAN,1,ok,up,3,0,,1000.0,98.9,0,100152FB,0*48425B4C";
const STEPS: [&str; 3] = [
    "$PSTR,STEP,1,1,3,500.5,165.4,279.5,165.4,1.5,3.7,100*2688B9C3",
    "$PSTR,STEP,1,2,3,780.0,330.7,280.6,165.3,1.5,13.6,100*252F41B4",
    "$PSTR,STEP,1,3,3,1060.7,495.1,,164.4,1.5,23.0,100*25D20E0E",
];

fn framed(body: &str) -> String {
    format!("${body}*{:08X}", crc32(body))
}

/// Returns the streams: name, bytes, and the sentences that they contain.
fn streams() -> Vec<(&'static str, Vec<u8>, Vec<String>)> {
    let all: Vec<String> = [SCAN]
        .iter()
        .chain(&STEPS)
        .map(|s| (*s).to_owned())
        .collect();
    let each = |before: &[u8], after: &[u8]| -> Vec<u8> {
        let line = |line: &String| [before, line.as_bytes(), after].concat();
        all.iter().flat_map(line).collect()
    };
    let whole = |name, bytes| (name, bytes, all.clone());
    let offer = framed("PSTR,FAIL,-,crc,send $PSTC,stop*1A2B3C4D");
    let with_offer = [all.clone(), vec![offer.clone()]].concat();
    let cut = [&b"$PSTR,LIVE,scanni"[..], &each(b"", b"\r\n")].concat();
    let noise = [&[b'U'; 700][..], &each(b"", b"\r\n")].concat();
    let loader = framed("PSTR,LOADER,a,0,x") + "\r\nSR\x01\x02\n";
    let nul_within = [
        SCAN.replace(",up", ",u\0p").as_bytes(),
        b"\n",
        &each(b"", b"\n"),
    ]
    .concat();
    vec![
        whole("CR LF", each(b"", b"\r\n")),
        whole("LF", each(b"", b"\n")),
        whole("CR", each(b"", b"\r")),
        whole("empty lines", each(b"\n\r", b"\r\n\r\n")),
        whole("NUL before each", each(b"\0", b"\r\n")),
        whole("a word before each", each(b"+GPSRD:", b"\r\n")),
        whole("a time before each", each(b"12:00:01.250 -> ", b"\r\n")),
        whole("a break before each", each(b"\xff\xfe\x80", b"\r\n")),
        whole(
            "a byte order mark",
            [&b"\xef\xbb\xbf"[..], &each(b"", b"\n")].concat(),
        ),
        whole("a cut-off line", cut),
        // Only the last line has an end.
        (
            "lost line ends",
            [each(b"", b""), b"\r\n".to_vec()].concat(),
            vec![STEPS[2].to_owned()],
        ),
        whole("noise without an end", noise),
        whole("NUL within a line", nul_within),
        whole(
            "another's sentences",
            [loader.as_bytes(), &each(b"", b"\r\n")].concat(),
        ),
        (
            "an offered sentence",
            [each(b"", b"\r\n"), format!("{offer}\r\n").into_bytes()].concat(),
            with_offer,
        ),
    ]
}

/// Port of the boot loader's link that delivers the bytes, and then nothing.
struct Canned(Vec<u8>);

impl Wire for Canned {
    fn receive(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let count = self.0.len().min(7);
        buffer[..count].copy_from_slice(&self.0[..count]);
        self.0.drain(..count);
        Ok(count)
    }

    fn send(&mut self, _: &[u8]) -> Result<()> {
        Ok(())
    }

    fn set_rate(&mut self, _: u32) -> Result<()> {
        Ok(())
    }
}

fn intact(lines: impl IntoIterator<Item = String>) -> Vec<String> {
    let is = |line: &String| Sentence::parse(line).is_ok();
    lines.into_iter().filter(is).collect()
}

/// `update`: the sentences between the loader's frames.
fn of_update(bytes: &[u8]) -> Vec<String> {
    let mut link = Link::new(Canned(bytes.to_vec()));
    let mut lines = Vec::new();
    link.until(Duration::from_millis(20), |line| {
        lines.push(line.to_owned());
        None::<()>
    })
    .unwrap();
    intact(lines)
}

/// `record --report`.
fn of_record(bytes: &[u8]) -> Vec<String> {
    let (mut beside, mut splitter) = (Beside::default(), Splitter::default());
    for piece in bytes.chunks(5) {
        for line in splitter.push(piece) {
            beside.line(0, &line);
        }
    }
    intact(beside.lines.into_iter().map(|(_, line)| line))
}

/// `live`, and by the same port `settings` and `doctor`: the answers are complete, too.
fn of_live(bytes: &[u8], expected: usize) -> (Vec<String>, u64) {
    let mut pty = Pty::new().unwrap();
    let (started, mut state) = (Instant::now(), State::new("p", 115_200));
    let source = Source::port(started, &pty.path, 115_200);
    let mut lines = Vec::new();
    while started.elapsed() < Duration::from_secs(20) && lines.len() < expected {
        let (at, event) = match source.events.recv_timeout(Duration::from_millis(100)) {
            Ok(came) => came,
            Err(RecvTimeoutError::Timeout) => continue,
            Err(error) => panic!("{error}"),
        };
        state.take(at, &event);
        match event {
            Event::Opened => pty.write(bytes),
            Event::Line(line) => lines.extend(intact([line])),
            _ => {}
        }
    }
    (lines, state.answers)
}

/// Returns the C parser's sentences and answers.
fn of_c(program: &std::path::Path, bytes: &[u8]) -> Vec<String> {
    let mut child = Command::new(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(bytes).unwrap();
    let out = child.wait_with_output().unwrap();
    let text = String::from_utf8(out.stdout).unwrap();
    text.lines().map(str::to_owned).collect()
}

const MAIN: &str = r#"
#include <stdio.h>
#include "stairscan.h"
int main(void) {
    static stairscan_t scanner;
    stairscan_rules_t rules = stairscan_default_rules();
    char line[STAIRSCAN_MAX_SENTENCE + 1];
    size_t length;
    int byte;
    stairscan_init(&scanner, &rules);
    while ((byte = getchar()) != EOF) {
        length = scanner.length;
        for (size_t k = 0; k < length; k++) line[k] = scanner.line[k];
        switch (stairscan_take(&scanner, (char)byte, 0, 0)) {
        case STAIRSCAN_SENTENCE: case STAIRSCAN_ANSWER: printf("%.*s\n", (int)length, line); break;
        default: break;
        }
    }
    return 0;
}
"#;

#[test]
fn every_reader_takes_the_same_sentences() {
    let dir = Scratch::new("streams");
    let (source, program) = (dir.path().join("main.c"), dir.path().join("main"));
    std::fs::write(&source, MAIN).unwrap();
    let controller = workspace().join("controller");
    let built = Command::new("cc")
        .arg("-I")
        .arg(&controller)
        .args([&source, &controller.join("stairscan.c")])
        .arg("-o")
        .arg(&program)
        .status()
        .unwrap();
    assert!(built.success());
    let all = 1 + STEPS.len();
    for (name, bytes, sentences) in streams() {
        assert_eq!(of_c(&program, &bytes), sentences, "{name}: C");
        assert_eq!(of_update(&bytes), sentences, "{name}: update");
        assert_eq!(of_record(&bytes), sentences, "{name}: record");
        let whole = u64::from(sentences.len() >= all);
        let live = of_live(&bytes, sentences.len());
        assert_eq!(live, (sentences.clone(), whole), "{name}: live");
        let crash = crash::report::last(&bytes).unwrap_err().to_string();
        let plural = if sentences.len() == 1 { "" } else { "s" };
        let expected = format!("no crash in {} sentence{plural}:", sentences.len());
        assert!(crash.starts_with(&expected), "{name}: {crash}");
    }
}

/// A receiver's sentences, the second cut off, and a line by which it is not recognised.
const GPS: &str = "$GNRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*74\r\n\
    $GPGGA,123519,4807.038,N,01131.\r\n+GPSRD:0";
const NAMED: &str = "a GPS receiver (NMEA 0183, talker GP)";

#[test]
fn every_reader_names_the_device_that_sends_in_place_of_a_scanner() {
    let dir = Scratch::new("streams-gps");
    let path = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (settings, recording) = (path("a.toml"), path("a"));
    let plugged = || Scanner::scripted(|| GPS.to_owned(), |_| Vec::new());
    // `update` waits a minute for a reset: its reason is a test of update/client.rs.
    let commands = [&["doctor"][..], &["settings", "--get", &settings]];
    for args in commands {
        let gps = plugged();
        let output = sim(&[args, &[&gps.path]].concat());
        let all = [&output.stdout[..], &output.stderr].concat();
        let text = String::from_utf8_lossy(&all);
        assert!(!output.status.success(), "{args:?}");
        assert!(text.contains(NAMED), "{args:?}: {text}");
        assert!(!text.contains("another device"), "{args:?}: {text}");
        gps.unplug();
    }
    let gps = plugged();
    let port = gps.path.clone();
    let mut live = started(&["live", &port]);
    let lines = BufReader::new(live.stdout.take().unwrap()).lines();
    let mut lines = lines.map_while(Result::ok);
    assert!(lines.any(|line| line.contains(NAMED)), "live");
    live.kill().unwrap();
    live.wait().unwrap();

    let mut record = started(&["record", &port, "-o", &recording]);
    std::thread::sleep(Duration::from_secs(3));
    gps.unplug();
    let mut text = String::new();
    let errors = record.stderr.take().unwrap();
    BufReader::new(errors).read_to_string(&mut text).unwrap();
    assert!(!record.wait().unwrap().success());
    assert!(text.contains(NAMED), "record: {text}");
}
