//! The boot loader of the STM32F405; on a host it only says how to get it onto the board.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod chip;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("stairscan-boot is firmware: `cargo board` writes it to the board, before the image");
}
