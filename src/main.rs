//! The one image for the STM32F405; on a host it only says how to flash.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "stairscan is firmware: `cargo flash` writes it to the board, `cargo sim` replays it here"
    );
}

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
