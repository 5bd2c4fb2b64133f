//! Schedule of angles, mirror motor, and the loop that ties them to the stages.
//!
//! The scanner is a polled state machine: [`Scanner::step`] never waits, so that a command is
//! answered during a scan, the watchdog sees every state's own deadline, and a chirp is on the wire and worked
//! off while the mirror moves to the next angle. Hardware comes in behind four narrow traits
//! ([`Mirror`], [`RadarModule`](crate::signal::radar::RadarModule), [`BytePort`], [`Board`]) and time as an argument, so the code
//! that scans on the chip is the code that runs in the emulator and behind `replay`.
//!
//! | module | what it does |
//! |---|---|
//! | [`time`] | microseconds that wrap |
//! | [`settings`] | configuration, time-outs and motor data, by key |
//! | [`record`] | settings as text: their hash, and what a record of them holds |
//! | [`seal`] | a checksum over the whole image |
//! | [`store`] | settings that outlive the power: records in two sectors of flash |
//! | [`schedule`] | which microstep belongs to which row |
//! | [`mirror`] | the mirror as the sweep sees it; homing over any step generator |
//! | [`driver`] | the motor's driver as the mirror sees it |
//! | [`tmc2209`] | that driver's wire and registers |
//! | [`encoder`] | an absolute encoder on the mirror's shaft: AS5600 over I²C |
//! | [`ramp`] | acceleration-limited moves: the time from one step to the next |
//! | [`pulser`] | STEP/DIR/EN over embedded-hal pins |
//! | [`board`] | the report port, what survives a reset, who the firmware is |
//! | [`chain`] | the data's way: samples, map, estimator |
//! | [`pace`] | how fast a mirror that does not stop may turn |
//! | [`sweep`] | one scan: move, settle, trigger, receive, retry; or all rows in passing |
//! | [`outbox`] | sentences on their way out |
//! | [`scanner`] | boot, self-test, idle, scanning, reporting, fault; commands |

pub mod board;
pub mod chain;
pub mod driver;
pub mod encoder;
pub mod mirror;
pub mod outbox;
pub mod pace;
pub mod pulser;
pub mod ramp;
pub mod record;
pub mod scanner;
pub mod schedule;
pub mod seal;
pub mod settings;
pub mod store;
pub mod sweep;
pub mod time;
pub mod tmc2209;

pub use board::{Board, BytePort, Hardware, Identity};
pub use chain::DataPath;
pub use mirror::{Mirror, MirrorError, Motion};
pub use scanner::{Reports, Scanner};
pub use schedule::{MICROSTEPS_PER_TURN, Schedule};
pub use settings::Settings;
pub use time::Micros;
