//! The program's commands, one module each.

pub mod ablate;
pub mod accuracy;
pub mod bench;
pub mod budget;
pub mod capability;
pub mod coherent;
pub mod compare;
pub mod drives;
pub mod faults;
pub mod fit;
pub mod guard;
pub mod hardware;
pub mod params;
pub mod reasons;
pub mod sbom;
pub mod sequences;
pub mod shift;
pub mod snr;
pub mod soak;
pub mod table1;
pub mod twins;

use anyhow::{Result, ensure};
use host_sim::seeds::Draw;

pub use host_sim::commands::{
    Format, Settings, busy, emit, full_scans, progress, progress_aside, recordings, timing,
};

/// Checks that `option` does not list `what`, results of the reporting draw.
///
/// # Errors
/// It lists them; names a draw to use instead.
fn may_list(option: &str, list: bool, what: &str, draw: Draw) -> Result<()> {
    ensure!(
        !(list && draw == Draw::Reporting),
        "{option}: the {what} of the draw {} must not be inspected; --draw {} has others like them",
        Draw::Reporting,
        Draw::Tuning
    );
    Ok(())
}

/// Returns `text`, then, if `list` has entries, the heading and the entries.
fn with_list(text: String, heading: &str, list: &[String]) -> String {
    match list {
        [] => text,
        _ => format!("{text}\n{heading}:\n\n- {}\n", list.join("\n- ")),
    }
}
