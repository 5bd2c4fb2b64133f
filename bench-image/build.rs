//! Build script: passes cortex-m-rt's linker script to the linker for the chip; does nothing for a host. The
//! memory map is the firmware's own, which the library's build script provides.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
    }
}
