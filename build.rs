//! Linker script and git revision for the image.

use std::env;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=memory.x");
    revision();
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::copy("memory.x", out.join("memory.x")).expect("memory.x can be copied");
    println!("cargo::rustc-link-search={}", out.display());
    // The relocations stay in the file (not in flash) for `cargo sim budget`, which reads from them
    // who may panic.
    for arg in ["--nmagic", "-Tlink.x", "-Tdefmt.x", "--emit-relocs"] {
        println!("cargo::rustc-link-arg-bin=stairscan={arg}");
    }
}

/// The revision goes into the first sentence after boot. Without git it is `unknown`, and a build
/// from a changed tree says so.
fn revision() {
    for path in [".git/HEAD", ".git/index"] {
        if PathBuf::from(path).exists() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    let described = Command::new("git")
        .args([
            "describe",
            "--always",
            "--dirty",
            "--abbrev=12",
            "--exclude=*",
        ])
        .output()
        .ok()
        .filter(|output| output.status.success())
        .and_then(|output| String::from_utf8(output.stdout).ok());
    let revision = described.as_deref().map_or("unknown", str::trim);
    println!("cargo::rustc-env=STAIRSCAN_REVISION={revision}");
}
