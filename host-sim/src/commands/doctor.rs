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
const DOUBTFUL: u8 = 3;

/// Arguments of `doctor`.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Asks version, status and settings and listens to a scan. A scanner that stands is told to run its self-test and
to scan twice, so that the mirror moves; --no-move leaves that out. Only what the scanner says is judged: `not seen`
is no `ok`. Exit status: 0 all well, 1 a fault, 3 a warning or something that could not be seen."
)]
pub struct Args {
    /// The report port, such as /dev/ttyUSB0
    port: String,
    /// Do not move the mirror of a scanner that stands
    #[arg(long)]
    no_move: bool,
    /// Wait so many seconds for a scan
    #[arg(long, default_value_t = 45, value_parser = clap::value_parser!(u32).range(1..=3_600))]
    wait: u32,
    /// Speed of the port; the scanner's is 115200
    #[arg(long, default_value_t = REPORT_BAUD, value_parser = clap::value_parser!(u32).range(50..=4_000_000))]
    baud: u32,
    /// For people or for programs
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Collects the replies, evaluates them, prints the list.
pub fn run(args: &Args) -> Result<ExitCode> {
    let findings = match Talk::open(&args.port, args.baud) {
        Err(broken) => doctor::unusable(&broken),
        Ok(mut talk) => {
            eprintln!("asking, and listening to a scan");
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
        Level::Unseen | Level::Warning => ExitCode::from(DOUBTFUL),
        Level::Fault => ExitCode::FAILURE,
    })
}

/// Formats a finding as a line of JSON.
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
