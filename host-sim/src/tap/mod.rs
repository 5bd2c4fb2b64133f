//! A tap on the radar link: what scanner and module say to each other becomes a recording.
//!
//! | module | what it is |
//! |---|---|
//! | [`listen`] | bytes of a direction into frames, however damaged |
//! | [`scans`] | requests and answers into scans, row by row |
//! | [`sweep`] | the schedule of angles that the triggers were made for |
//! | [`gather`] | scans into recordings, as the format allows |
//! | [`beside`] | what the scanner said meanwhile: its answers and settings |
//! | [`unfinished`] | scans that have ended, kept in case the session is cut off |
//! | [`demo`] | a module without hardware, at a pseudo-terminal |
//! | [`ask`] | the module itself on a port: this program asks in the scanner's place |
//!
//! Nothing is ever made up: a row whose chirp the tap did not hear whole is missing in the recording, and told.

pub mod ask;
pub mod beside;
pub mod demo;
pub mod gather;
pub mod listen;
pub mod scans;
pub mod sweep;
pub mod unfinished;
