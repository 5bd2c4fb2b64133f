//! A tap on the radar link: records the traffic between scanner and module.
//!
//! | module | what it is |
//! |---|---|
//! | [`listen`] | decodes frames from the bytes of a direction, also damaged ones |
//! | [`nothing`] | why there is no scan, from what was received |
//! | [`pace`] | the bit rate of the link, which the ports follow |
//! | [`scans`] | assembles requests and answers into scans, row by row |
//! | [`sweep`] | finds the schedule of angles behind the triggers |
//! | [`kinds`] | tells guard sweeps from full scans |
//! | [`mounting`] | properties of the scanner that the link does not transmit |
//! | [`gather`] | collects scans into recordings, within the limits of the format |
//! | [`beside`] | the scanner's report port meanwhile: its answers and settings |
//! | [`unfinished`] | completed scans, kept in case the session is interrupted |
//! | [`demo`] | a simulated module at a pseudo-terminal |
//! | [`ask`] | acquires scans from a module; this program takes the scanner's place |
//!
//! No data are invented: a row whose chirp was not received completely is missing in the recording, and
//! reported.

pub mod ask;
pub mod beside;
pub mod demo;
pub mod gather;
pub mod kinds;
pub mod listen;
pub mod mounting;
pub mod nothing;
pub mod pace;
pub mod scans;
pub mod sweep;
pub mod unfinished;
