//! `twins`: compares the DSP instructions with their portable definitions, in the emulator and on
//! the host.

use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use bench_image::arithmetic_check;
use stairscan::signal::range::packed::Portable;

use super::emit;
use crate::images;
use host_sim::emulate::image;

/// Processes the same 20,000 random and adversarial chirps three times: in the emulator with the DSP instructions and
/// with their portable definitions, on the host with the definitions. Any difference is an error.
pub fn run() -> Result<ExitCode> {
    let elf = image::build_bin("bench-image", "twins", &[])?;
    let directory = elf.with_extension("run");
    std::fs::create_dir_all(&directory).with_context(|| directory.display().to_string())?;
    let output = images::run(&elf, &directory, Duration::from_secs(300))?;
    let value = |name: &str| {
        let mut lines = output.lines().filter_map(|l| l.split_once(' '));
        lines.find(|(n, _)| *n == name).map(|(_, v)| v.to_owned())
    };
    let here = arithmetic_check::compare::<Portable, Portable>();
    let digest = format!("{:08x}", here.digest);
    ensure!(
        value("chirps") == Some(arithmetic_check::TOTAL.to_string()),
        "the image stopped early:\n{output}"
    );
    ensure!(
        value("mismatches").as_deref() == Some("0"),
        "instructions and definitions differ:\n{output}"
    );
    ensure!(
        value("digest").as_ref() == Some(&digest),
        "emulator and host differ: {digest} here\n{output}"
    );
    emit(&format!(
        "{} chirps: instructions, definitions and host give the same bits, digest {digest}\n",
        arithmetic_check::TOTAL
    ));
    Ok(ExitCode::SUCCESS)
}
