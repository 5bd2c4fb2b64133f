//! The other side of the scanner: recordings, scenes, replay, scores, pictures.

pub mod answer;
pub mod recording;
pub mod scene;
pub mod score;
pub mod setup;
