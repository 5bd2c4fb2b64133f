//! The other side of the scanner: recordings, scenes, replay, scores, pictures.

pub mod answer;
pub mod budgets;
pub mod commands;
pub mod convert;
pub mod emulate;
pub mod faults;
pub mod film;
pub mod fit;
pub mod html;
pub mod images;
pub mod inspect;
pub mod live;
pub mod motion;
pub mod playback;
pub mod plots;
pub mod posterior;
pub mod recording;
pub mod replay;
pub mod scene;
pub mod score;
pub mod seeds;
pub mod setup;
pub mod soak;
pub mod tap;
pub mod volatile;
