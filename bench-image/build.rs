//! Hands the linker cortex-m-rt's script; nothing on a host. The memory map is the firmware's own,
//! found where the library's build script put it.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
    }
}
