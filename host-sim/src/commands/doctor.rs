//! `doctor PORT`: checks a scanner from its own reports.

use std::process::ExitCode;
use std::time::Duration;

use anyhow::Result;
use serde_json::json;

use super::{Format, emit};
use crate::doctor::evidence::Evidence;
use crate::doctor::{self, Finding, Level};
use crate::live::talk::Talk;
use crate::live::trouble::REPORT_BAUD;

/// Exit status if a check needs attention or could not be made.
const WARNING_STATUS: u8 = 3;

/// Arguments of `doctor`.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Reads version, status and settings, and waits for a scan. An idle scanner is commanded to run its self-test and
two scans, so that the mirror moves; --no-move prevents that. Checks use only what the scanner reports: `not seen`
is not `ok`. Exit status: 0 all ok, 1 a fault, 3 a warning or a check that could not be made."
)]
pub struct Args {
    /// The report port, such as /dev/ttyUSB0
    port: String,
    /// Do not move the mirror of an idle scanner
    #[arg(long)]
    no_move: bool,
    /// Timeout of a scan, seconds
    #[arg(long, default_value_t = 45, value_parser = clap::value_parser!(u32).range(1..=3_600))]
    wait: u32,
    /// Baud rate of the port; the scanner uses 115200
    #[arg(long, default_value_t = REPORT_BAUD, value_parser = clap::value_parser!(u32).range(50..=4_000_000))]
    baud: u32,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Collects a scanner's replies, evaluates them, and prints the list of findings.
pub fn run(args: &Args) -> Result<ExitCode> {
    let findings = match Talk::open(&args.port, args.baud) {
        Err(broken) => doctor::unusable(&broken),
        Ok(mut talk) => {
            crate::note!("reading settings, waiting for a scan");
            let patience = Duration::from_secs(args.wait.into());
            doctor::examine(&Evidence::gather(
                &mut talk,
                &args.port,
                !args.no_move,
                patience,
            ))
        }
    };
    match args.format {
        Format::Text => emit(&doctor::text(&findings)),
        Format::Json => findings.iter().for_each(|finding| emit(&line(finding))),
    }
    Ok(match doctor::worst(&findings) {
        Level::Ok | Level::Absent => ExitCode::SUCCESS,
        Level::Unseen | Level::Warning => ExitCode::from(WARNING_STATUS),
        Level::Fault => ExitCode::FAILURE,
    })
}

/// Formats the finding of one check as a line of JSON.
fn line(finding: &Finding) -> String {
    let Finding {
        check,
        level,
        observed,
        fixes,
    } = finding;
    let object = json!({
        "check": check.as_str(),
        "result": level.as_str(),
        "observed": observed,
        "fixes": fixes,
    });
    format!("{object}\n")
}
