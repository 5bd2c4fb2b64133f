//! `live PORT`: shows a scanner's reports in a terminal, or publishes them to Foxglove or ROS 2.

#[cfg(any(feature = "foxglove", feature = "ros2"))]
mod offered;
mod serving;
mod watching;

use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Result, bail};

use super::emit;
use crate::answer::Answer;
use crate::live::ports;
pub use watching::{Args, begin, show};

/// Shows the scanner at the port, or the demonstration; publishes it if a service is requested; lists the ports without
/// either.
pub fn run(args: &Args) -> Result<ExitCode> {
    let started = Instant::now();
    if let Some(served) = serving::run(args, started)? {
        return Ok(served);
    }
    let Some((source, state)) = watching::source(args, started)? else {
        return list();
    };
    let look = &mut |_: &Answer| ();
    watching::watch(args, (started, &source, state), look)
}

fn list() -> Result<ExitCode> {
    let ports = ports::list();
    if ports.is_empty() {
        bail!(
            "no serial port here. Is the adapter plugged in? `dmesg | tail` shows whether the system has detected it. Without hardware: `cargo sim live --demo recordings/stair_a`"
        );
    }
    emit(&format!(
        "serial ports:\n{ports}choose one: cargo sim live PORT\n"
    ));
    Ok(ExitCode::SUCCESS)
}
