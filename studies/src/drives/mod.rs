//! Drives: a chair that drives through a random scene by the guard's free distance.
//!
//! In: a kind of scene, a seed and a number. Out: where and why the chair stopped, or what it drove
//! over. The simulation is closed-loop. Each chirp is simulated from the chair's present position
//! ([`host_sim::scene::way`]), the scanner's own code evaluates the sweep ([`scanner`]), a controller
//! limits the joystick by the sentences ([`controller`], [`stairscan_replay::limit`]), and the chair follows its
//! commands ([`chair`], [`plan`]). [`outcome`] classifies a drive, and [`table`] counts the
//! classes.

pub mod chair;
pub mod controller;
pub mod course;
pub mod log;
pub mod outcome;
pub mod plan;
pub mod scanner;
pub mod table;
pub mod world;
