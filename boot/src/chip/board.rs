//! Files that the loader shares with the image (`src/board/`).

#[path = "../../../src/board/clock.rs"]
#[allow(
    dead_code,
    reason = "the image's own, of which the loader needs the start"
)]
pub mod clock;
#[path = "../../../src/board/delay.rs"]
pub mod delay;
