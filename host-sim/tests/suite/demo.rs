//! Tests of the demo image in the emulator: the scanner's loop over a recording in flash.

use std::fs;
use std::time::{Duration, Instant};

use host_sim::emulate::image;
use host_sim::emulate::qemu::{Qemu, read_some};
use host_sim::emulate::tools::Tool;
use host_sim::replay::{Options, SEED, answers};
use host_sim::update::keys;
use host_sim::update::package::Package;
use stairscan::report::Sentence;

use crate::common::scanner::stair_a;
use crate::common::tools;

/// Timeout of the demo's scans in the emulator, on the host's clock.
const PATIENCE: Duration = Duration::from_secs(180);

/// Returns the sentences of the report port, without `LIVE`, from the boot to the scan after the first `scans`.
fn reported(emulator: &mut Qemu, scans: usize) -> Vec<String> {
    let (until, mut text) = (Instant::now() + PATIENCE, Vec::new());
    loop {
        let mut buffer = [0; 4096];
        let count = read_some(&mut emulator.report, &mut buffer).unwrap();
        text.extend(&buffer[..count]);
        let whole = String::from_utf8_lossy(&text).into_owned();
        let lines = whole.split_inclusive('\n').filter(|l| l.ends_with('\n'));
        let lines = lines.map(|line| line.trim_end().to_owned());
        let sentences: Vec<String> = lines
            .filter(|line| !matches!(Sentence::parse(line), Ok(Sentence::Live(_))))
            .collect();
        let is_scan = |line: &&String| matches!(Sentence::parse(line), Ok(Sentence::Scan(_)));
        if sentences.iter().filter(is_scan).count() > scans {
            return sentences;
        }
        assert!(Instant::now() < until, "{sentences:?}");
        emulator.check().unwrap();
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// From power-on, with no radar module, motor or boot loader: the sentences of both directions are those of `replay`, to the byte.
/// No loader takes such an image.
#[test]
fn the_demo_image_reports_what_replay_reports() {
    if !tools(&[Tool::Target, Tool::Emulator]) {
        return;
    }
    let elf = image::build(&["demo"]).unwrap();
    let mut emulator = Qemu::start_alone(&elf).unwrap();
    const SCANS: u32 = 2;
    let sentences = reported(&mut emulator, SCANS as usize);
    let version = concat!("$PSTR,BOOT,", env!("CARGO_PKG_VERSION"), "-demo,");
    assert!(sentences[0].starts_with(version), "{sentences:?}");
    let mut options = Options {
        scans: Some(SCANS),
        ..Options::default()
    };
    // As by the command `replay`.
    options.config.seed = SEED;
    let answers = answers(&stair_a(), &options, |_| ()).unwrap();
    let expected: Vec<String> = answers.into_iter().flat_map(|a| a.sentences).collect();
    assert_eq!(sentences[1..=expected.len()], expected);
    let document = fs::read_to_string(image::workspace().join("docs/user/build.md")).unwrap();
    assert!(document.contains(&expected[..4].join("\n")), "{expected:?}");

    let refused = Package::sign(&elf, 0, &keys::development().unwrap());
    let refused = format!("{:#}", refused.unwrap_err());
    assert!(refused.contains("0x08000000"), "{refused}");
}
