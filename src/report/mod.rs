//! Sentences out, motion in. Commands, which come over the same UART, are the scanner's: [`crate::scanner::command`].

pub mod motion;
pub mod sentence;

pub use sentence::{
    DropLine, GuardLine, Line, LiveLine, MaybeLine, ParseError, ScanLine, Sentence, StepLine,
    Tenths,
};
