//! Sentences out, commands in: everything that travels over the report UART.

pub mod sentence;
