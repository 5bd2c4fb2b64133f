//! Build script: passes cortex-m-rt's linker script and the memory map to the linker for the chip; does nothing
//! for a host.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=memory.x");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        let here = std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR");
        println!("cargo:rustc-link-arg-bins=-L{here}");
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
    }
}
