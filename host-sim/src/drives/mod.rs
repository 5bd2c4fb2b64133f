//! Drives: a chair that drives through a random scene by the guard's free distance.
//!
//! A kind of scene, a seed and a number in; where and why the chair came to stand, or what it drove over, out. The loop is
//! closed: each chirp is simulated from where the chair is then ([`crate::scene::way`]), the scanner's own code sweeps
//! ([`scanner`]), a controller limits the joystick by the sentences ([`controller`], [`limit`]), and the chair follows its
//! commands ([`chair`], [`plan`]). [`outcome`] says what became of a drive, [`table`] counts.

pub mod chair;
pub mod controller;
pub mod course;
pub mod limit;
pub mod log;
pub mod outcome;
pub mod plan;
pub mod scanner;
pub mod table;
pub mod world;
