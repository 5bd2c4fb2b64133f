//! Runs firmware images that end by themselves, such as benchmarks, in the emulator.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};

use host_sim::console::busy;
use host_sim::emulate::tools::{EMULATOR, Tool};

/// Runs an image that ends by itself, in `directory`, for `limit` at most; returns its output (by
/// semihosting).
///
/// The time in the emulator is the number of instructions, one each nanosecond (`-icount shift=0`).
pub fn run(elf: &Path, directory: &Path, limit: Duration) -> Result<String> {
    Tool::Emulator.need()?;
    let log = directory.join("output");
    let file = std::fs::File::create(&log).with_context(|| log.display().to_string())?;
    let mut child = Command::new(EMULATOR)
        .current_dir(directory)
        .args([
            "-machine",
            "netduinoplus2",
            "-nographic",
            "-monitor",
            "none",
        ])
        .args(["-serial", "none", "-icount", "shift=0"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(elf)
        .stdin(Stdio::null())
        .stdout(file.try_clone()?)
        .stderr(file)
        .spawn()
        .context(EMULATOR)?;
    let what = elf.file_name().unwrap_or_default().to_string_lossy();
    let bar = busy(&format!(
        "{what} in the emulator, {} s at most",
        limit.as_secs()
    ));
    let deadline = Instant::now() + limit;
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if Instant::now() > deadline {
            child.kill()?;
            child.wait()?;
            bail!("{}: no end after {} s", elf.display(), limit.as_secs());
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    bar.finish_and_clear();
    let output = std::fs::read_to_string(&log)?;
    ensure!(status.success(), "{}: {status}\n{output}", elf.display());
    Ok(output)
}
