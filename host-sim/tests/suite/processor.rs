//! Tests of the image's monitoring of processor, supply and its own integrity, in the emulator.

use std::fs;
use std::path::{Path, PathBuf};

use host_sim::emulate::session::Waits;
use host_sim::emulate::{Session, image, seal};
use host_sim::playback::Playback;
use host_sim::recording::Recording;
use object::read::{Object, ObjectSection};
use stairscan::config::Config;
use stairscan::report::{ScanLine, Sentence};
use stairscan::scanner::seal::{BLANK, SECTION};
use stairscan::verdict::{Reason, Status};

use crate::common::{Scratch, elf};

/// A changed copy of the image; the file is removed when it is dropped.
struct Copy(PathBuf);

impl Copy {
    /// Calls `change` with the bytes of a section in the file.
    fn of(elf: &Path, name: &str, section: &str, change: impl Fn(&mut [u8])) -> Self {
        let mut bytes = fs::read(elf).unwrap();
        let file = object::File::parse(&*bytes).unwrap();
        let (at, size) = file.section_by_name(section).unwrap().file_range().unwrap();
        change(&mut bytes[at as usize..(at + size) as usize]);
        let path = std::env::temp_dir().join(format!("stairscan-{name}-{}", std::process::id()));
        fs::write(&path, bytes).unwrap();
        Self(path)
    }
}

impl Drop for Copy {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

fn recording() -> Recording {
    let full = Recording::read(&image::workspace().join("recordings/empty")).unwrap();
    let rows: Vec<usize> = (0..full.chirps()).step_by(6).collect();
    let mut thin = full.clone();
    thin.meta.angles_deg = rows.iter().map(|&k| full.meta.angles_deg[k]).collect();
    let chirps = rows.iter().flat_map(|&k| full.chirp(k).unwrap().to_vec());
    thin.samples = chirps.collect();
    thin
}

fn head(sentences: &[String]) -> ScanLine {
    match Sentence::parse(&sentences[0]) {
        Ok(Sentence::Scan(scan)) => scan,
        other => panic!("{other:?} is no SCAN"),
    }
}

/// Exactly the bytes of one variable change. Without exactly one such variable nothing is written.
#[test]
fn a_patched_image_has_one_variable_changed() {
    let Some(elf) = elf() else { return };
    let dir = Scratch::new("patched-image");
    let to = dir.path().join("image");
    let whole = fs::read(elf).unwrap();
    let seal: &[&str] = &["seal", "SEAL"];
    for (symbol, size) in [
        (seal, 12),
        (&["nothing so named"], 16),
        (&["params", "UP"], 16),
    ] {
        let refused = image::patch(elf, &to, (symbol, size), |_| panic!("{symbol:?}"));
        let printed = format!("{:#}", refused.unwrap_err());
        assert!(
            printed.contains(symbol[0]) && printed.contains(&size.to_string()),
            "{printed}"
        );
        assert!(!to.exists());
    }
    image::patch(elf, &to, (seal, 16), |bytes| {
        bytes.iter_mut().for_each(|b| *b ^= 0xFF)
    })
    .unwrap();
    let patched = fs::read(&to).unwrap();
    assert_eq!(patched.len(), whole.len());
    let changed = whole.iter().zip(&patched).enumerate();
    let changed: Vec<usize> = changed
        .filter(|(_, (a, b))| a != b)
        .map(|(k, _)| k)
        .collect();
    let file = object::File::parse(&*whole).unwrap();
    let (at, size) = file.section_by_name(SECTION).unwrap().file_range().unwrap();
    let expected: Vec<usize> = (at as usize..(at + size) as usize).collect();
    assert_eq!(changed, expected);
}

/// With one bit of a constant or of the code changed, the image reports the damage repeatedly and never
/// moves. Without a seal it scans, but is never `ok`.
#[test]
fn a_damaged_image_never_scans_and_an_unsealed_one_is_never_ok() {
    let Some(elf) = elf() else {
        return;
    };
    let recording = recording();
    let playback = Playback::new(&recording, &Config::default()).unwrap();
    // These sections are not used before the image has been checked. The lowest byte of a word: an address there
    // still lies in the slot, so that the image can be signed.
    for (section, back) in [(".rodata", 4), (".data", 4), (".vector_table", 4)] {
        let damaged = Copy::of(elf, &format!("damaged{section}"), section, |bytes| {
            let at = bytes.len() - back;
            bytes[at] ^= 0x10;
        });
        let differs = seal::same(elf, &damaged.0).unwrap_err().to_string();
        assert!(
            differs.contains("differ in flash, first at 0x08"),
            "{differs}"
        );
        let mut session = Session::boot(&damaged.0, &playback).unwrap();
        session.set("internal-clock", "on").unwrap();
        session.set("fault-hold", "100000").unwrap();
        session.skip_lines();
        for _ in 0..2 {
            let scan = head(&session.scan().unwrap());
            assert_eq!((scan.scan, scan.status), (0, Status::Fault), "{section}");
            assert!(
                scan.reasons.has(Reason::ImageDamaged),
                "{section}: {scan:?}"
            );
        }
        assert_eq!(session.shaft.pulses(), 0, "moved");
    }
    let blank = Copy::of(elf, "blank", SECTION, |bytes| {
        let words = BLANK.map(u32::to_le_bytes);
        bytes.copy_from_slice(words.as_flattened());
    });
    let mut session = Session::boot(&blank.0, &playback).unwrap();
    session
        .configure(&playback.settings(), Waits::default())
        .unwrap();
    session.skip_lines();
    session.connect().unwrap();
    let scan = head(&session.scan().unwrap());
    assert_eq!((scan.scan, scan.status), (1, Status::Degraded));
    assert!(scan.reasons.has(Reason::ImageUnsealed), "{scan:?}");
    // Sealing changes only the blank seal.
    seal::seal(&blank.0).unwrap();
    assert!(fs::read(&blank.0).unwrap() == fs::read(elf).unwrap());
    assert!(seal::same(elf, &blank.0).unwrap() > 100_000);
}

/// Without its crystal the scanner does not move unless the internal oscillator is allowed. A falling supply
/// and a failing crystal end in the fault path.
#[test]
fn clock_and_supply_are_watched() {
    let Some(elf) = elf() else {
        return;
    };
    let recording = recording();
    let playback = Playback::new(&recording, &Config::default()).unwrap();
    let mut session = Session::boot(elf, &playback).unwrap();
    let scan = head(&session.scan().unwrap());
    assert_eq!((scan.scan, scan.status), (0, Status::Fault));
    assert!(scan.reasons.has(Reason::InternalClock), "{scan:?}");
    assert_eq!(session.shaft.pulses(), 0, "moved");
    /// Interrupt of the supply's voltage detector (RM0090, vector table).
    const PVD: u32 = 1;
    for (line, reset) in [(Some(PVD), ",supply,hsi-16,2,"), (None, ",clock,hsi-16,3,")] {
        session.interrupt(line).unwrap();
        session.next_halt().unwrap();
        let boot = session.wait_for("another boot", |s| matches!(s, Sentence::Boot { .. }));
        let boot = boot.unwrap();
        assert!(boot.contains(reset), "{boot}");
    }
}
