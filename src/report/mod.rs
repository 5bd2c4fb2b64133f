//! Sentences out, commands and motion in: everything that travels over the report UART.

pub mod command;
pub mod motion;
pub mod sentence;

pub use sentence::{Line, LiveLine, MaybeLine, ParseError, ScanLine, Sentence, StepLine, Tenths};
