//! Files that the loader shares with the image (`src/board/`).

#[path = "../../../src/board/clock.rs"]
#[allow(
    dead_code,
    reason = "the image's own, of which the loader needs start and stop"
)]
pub mod clock;
#[path = "../../../src/board/controller.rs"]
pub mod controller;
#[path = "../../../src/board/delay.rs"]
pub mod delay;
#[path = "../../../src/board/flash.rs"]
#[allow(dead_code, reason = "of the driver the loader needs its traits")]
pub mod flash;
#[path = "../../../src/board/supply.rs"]
#[allow(
    dead_code,
    reason = "the image's own, of which the loader needs the detector"
)]
pub mod supply;
