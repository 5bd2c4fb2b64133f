//! Recordings in, answers out: reads recordings, replays them with the firmware's scanner code, scores the answers
//! against the ground truth, and makes report pages. On any target with an allocator and `std`: `web/` compiles it to
//! WebAssembly, `python/` and `host-sim/` rest on it.

pub mod answer;
pub mod coherent;
pub mod convert;
pub mod counted;
pub mod guarded;
pub mod html;
pub mod inspect;
pub mod limit;
pub mod live;
pub mod motion;
pub mod playback;
pub mod posterior;
pub mod recording;
pub mod replay;
pub mod score;
pub mod setup;
pub mod sweeps;
pub mod views;
pub mod volatile;
