//! The image's drivers, as the tests on the board use them: the same files as in the image.
#![no_std]
#![cfg(target_os = "none")]

#[path = "../../src/board/clock.rs"]
pub mod clock;
#[path = "../../src/board/controller.rs"]
pub mod controller;
#[path = "../../src/board/delay.rs"]
pub mod delay;
#[path = "../../src/board/flash.rs"]
pub mod flash;
#[path = "../../src/board/motor.rs"]
pub mod motor;
#[path = "../../src/board/settings_flash.rs"]
pub mod settings_flash;
#[path = "../../src/board/time.rs"]
pub mod time;
