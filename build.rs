//! Linker script and git revision for the image.

use std::env;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=src/board/memory.x");
    println!("cargo::rerun-if-changed=src/board/demo.x");
    revision();
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    fs::copy("src/board/memory.x", out.join("memory.x")).expect("memory.x can be copied");
    // The image's alone: the loader, which rests on the library, has a memory map of its own.
    println!("cargo::rustc-link-arg-bin=stairscan=-L{}", out.display());
    // The relocations stay in the file (not in flash) for `cargo study budget`, which reads from them
    // who may panic.
    for arg in ["--nmagic", "-Tlink.x", "-Tdefmt.x", "--emit-relocs"] {
        println!("cargo::rustc-link-arg-bin=stairscan={arg}");
    }
    if env::var_os("CARGO_FEATURE_DEMO").is_some() {
        fs::copy("src/board/demo.x", out.join("demo.x")).expect("demo.x can be copied");
        println!("cargo::rustc-link-arg-bin=stairscan=-Tdemo.x");
    }
}

/// The revision goes into the first sentence after boot. Without git it is `unknown`, and a build
/// from changed sources says so.
fn revision() {
    // HEAD and its log change with every commit and checkout, the index with every `git add` and many a `git status`:
    // that would rebuild everything for the same revision.
    let git_files = ["HEAD", "logs/HEAD"].map(|name| git(&["rev-parse", "--git-path", name]));
    let sources = ["src", "Cargo.toml", "Cargo.lock"].map(|name| Some(name.to_owned()));
    for path in git_files.into_iter().chain(sources).flatten() {
        // A path that is not there would rerun this every time.
        if PathBuf::from(&path).exists() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    let described = git(&[
        "describe",
        "--always",
        "--dirty",
        "--abbrev=12",
        "--exclude=*",
    ]);
    let revision = described.as_deref().unwrap_or("unknown");
    println!("cargo::rustc-env=STAIRSCAN_REVISION={revision}");
}

/// What git prints, trimmed.
fn git(args: &[&str]) -> Option<String> {
    let output = Command::new("git").args(args).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
