//! Passes the memory map and the linker scripts of start-up code and test harness to the linker for the chip.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=memory.x");
    // The harness's macro asks for it.
    println!("cargo::rustc-check-cfg=cfg(rust_analyzer)");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        let here = std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR");
        for arg in [&format!("-L{here}"), "-Tlink.x", "-Tembedded-test.x"] {
            println!("cargo::rustc-link-arg-tests={arg}");
        }
    }
}
