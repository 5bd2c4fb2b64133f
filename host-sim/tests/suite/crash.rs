//! Tests of `crash` with files that are no image, and with sources that are neither a log nor a port. With the image
//! itself it is tested in `firmware`.

use std::fs;

use stairscan::report::{CrashLine, CrashSite, Sentence};

use crate::common::{Scratch, sim};

fn sentence() -> String {
    let crash = Sentence::Crash(CrashLine {
        cause: "panic",
        boot: 3,
        site: CrashSite {
            pc: Some(0x0802_1234),
            cfsr: Some(0),
            ..CrashSite::NONE
        },
    });
    crash.write().trim_end().to_owned()
}

/// Runs `crash`, which must fail, and returns its message.
fn refused(args: &[&str]) -> String {
    let output = sim(&[&["crash"], args].concat());
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{args:?}: {message}");
    message
}

/// Returns an ELF file for ARM without a section: its header.
fn other_program() -> Vec<u8> {
    const ARM: u8 = 40;
    let mut header = vec![0; 52];
    header[..7].copy_from_slice(b"\x7fELF\x01\x01\x01");
    // An executable file of version 1, its header's size and that of an entry of the table of sections.
    (header[16], header[18], header[20]) = (2, ARM, 1);
    (header[40], header[46]) = (52, 40);
    header
}

#[test]
fn an_elf_file_of_another_program_is_no_image() {
    let dir = Scratch::new("crash-elf");
    let other = dir.path().join("other");
    fs::write(&other, other_program()).unwrap();
    let here = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    for (elf, words) in [
        (env!("CARGO_BIN_EXE_host-sim"), "no ELF file for ARM"),
        (
            other.to_str().unwrap(),
            "no image of this scanner, which has a section .seal",
        ),
        (here, "no ELF file"),
        ("/no/such/image", "No such file or directory"),
    ] {
        let message = refused(&[elf, "--sentence", &sentence()]);
        let begins = message.starts_with(&format!("error: {elf}: "));
        assert!(begins && message.contains(words), "{message}");
    }
}
