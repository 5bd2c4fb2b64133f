//! Sentences of the report UART from the scanner, and the motion sentence to it. Commands on the same UART:
//! [`crate::scanner::command`].

pub mod motion;
pub mod sentence;

pub use sentence::{
    BootLine, CrashLine, CrashSite, DropLine, GuardLine, Line, LiveLine, MaybeLine, ParseError,
    ScanLine, Sentence, SlopeField, StepLine, Tenths,
};
