//! The targets. Each describes its input and the properties that it checks.

pub mod bgt60;
pub mod commands;
pub mod files;
pub mod motion;
pub mod pipeline;
pub mod radar_link;
pub mod recordings;
pub mod scanner;
pub mod scenes;
pub mod sentences;
pub mod sirad;
pub mod update;
