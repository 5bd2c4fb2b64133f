//! Linker script of the loader, and the public key that it trusts.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

/// The key that is trusted where nobody names another one: everybody has its secret half.
const DEVELOPMENT: &str = "keys/development.pub";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=memory.x");
    println!("cargo::rerun-if-env-changed=STAIRSCAN_UPDATE_KEY");
    let here =
        PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR"));
    let development = read(&here.join(DEVELOPMENT));
    let key = match env::var_os("STAIRSCAN_UPDATE_KEY") {
        // Relative to the workspace, where `cargo` is called.
        Some(path) => read(&here.join("..").join(path)),
        None => development.clone(),
    };
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let text = format!(
        "/// The key that is trusted.\npub const TRUSTED: [u8; 32] = {key:?};\n\
         /// Whether it is the development key.\npub const DEVELOPMENT: bool = {};\n",
        key == development
    );
    fs::write(out.join("trusted.rs"), text).expect("OUT_DIR can be written");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        fs::copy("memory.x", out.join("memory.x")).expect("memory.x can be copied");
        let search = format!("-L{}", out.display());
        for arg in [&*search, "--nmagic", "-Tlink.x", "--emit-relocs"] {
            println!("cargo::rustc-link-arg-bin=stairscan-boot={arg}");
        }
    }
}

/// A public key's bytes: `stairscan public key <64 hex digits>`.
fn read(path: &Path) -> Vec<u8> {
    println!("cargo::rerun-if-changed={}", path.display());
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let hex = text
        .lines()
        .find_map(|line| line.strip_prefix("stairscan public key "));
    let hex = hex.filter(|hex| hex.len() == 64 && hex.is_ascii());
    let hex = hex.unwrap_or_else(|| panic!("{}: no public key", path.display()));
    let byte = |k: usize| u8::from_str_radix(&hex[2 * k..2 * k + 2], 16);
    let key: Result<Vec<u8>, _> = (0..32).map(byte).collect();
    key.unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}
