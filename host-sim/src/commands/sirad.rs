//! `sirad CAPTURE…`: processes captures of a SiRad with the firmware's protocol driver and range
//! processing.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::task::Poll;

use anyhow::{Context, Result, anyhow, bail, ensure};
use serde_json::json;
use stairscan::Iq;
use stairscan::config::{CfarConfig, MountConfig, RadarConfig};
use stairscan::scanner::Micros;
use stairscan::signal::radar::module::{LinkError, ModuleKind, RequestedSettings};
use stairscan::signal::radar::sirad::SiRad;
use stairscan::signal::range::{Profile, RangeProcessor};

use super::{Format, emit};
use crate::captures::sirad::Capture;
use crate::counted::counted;
use crate::modules::sirad::SiRadPort;

/// Simulated time between two polls of the module, µs; `TIMEOUT_US` is the timeout of an answer.
const STEP_US: u32 = 1_000;
const TIMEOUT_US: u32 = 500_000;

/// Arguments of `sirad`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// .mat or .json file as described in docs/design/modules.md, or the bytes received from a SiRad's port
    #[arg(required = true)]
    captures: Vec<PathBuf>,
    /// Swept bandwidth of a capture that does not contain it, MHz
    #[arg(long, default_value_t = 6_000, value_parser = clap::value_parser!(u32).range(2..=7_000))]
    bandwidth: u32,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Content of a capture, as the scanner's driver and range processing evaluate it.
struct Found {
    radar: RadarConfig,
    swept_khz: u32,
    chirps: usize,
    /// Range, metres, and power, dB relative to full scale, of each chirp's strongest echo, nearest first; chirps
    /// without an echo are left out.
    echoes: Vec<(f32, f32)>,
}

impl Found {
    /// Returns range, metres, and power, dB relative to full scale, of the echo with the median range; `None` without
    /// echoes.
    fn median(&self) -> Option<(f32, f32)> {
        self.echoes.get(self.echoes.len() / 2).copied()
    }
}

/// A simulated module that plays a capture, with the scanner's driver.
struct Player<'a> {
    module: SiRad,
    port: SiRadPort<'a>,
    now: u32,
}

impl Player<'_> {
    fn wait<T>(
        &mut self,
        mut poll: impl FnMut(&mut SiRad, &mut SiRadPort<'_>, Micros) -> Poll<Result<T, LinkError>>,
    ) -> Result<T> {
        loop {
            self.now = self.now.wrapping_add(STEP_US);
            let answer = poll(&mut self.module, &mut self.port, Micros(self.now));
            if let Poll::Ready(answer) = answer {
                return answer.map_err(|error| anyhow!("no answer: {error:?}"));
            }
        }
    }

    fn program(&mut self, requested: &RequestedSettings) -> Result<RadarConfig> {
        (self.module).program(&mut self.port, Micros(self.now), requested, TIMEOUT_US);
        self.wait(|module, port, now| module.settings(port, now))
    }

    fn chirp(&mut self, samples: &mut [Iq]) -> Result<()> {
        (self.module).trigger(&mut self.port, Micros(self.now), 0, TIMEOUT_US);
        self.wait(|module, port, now| module.poll(port, now, samples))
    }
}

/// Processes the chirps of a capture as the scanner would from the module that made it.
fn look(path: &Path, bandwidth_mhz: u32) -> Result<Found> {
    let capture = Capture::read(path)?;
    let swept_khz = capture.bandwidth_khz.unwrap_or(1_000 * bandwidth_mhz);
    let requested = RequestedSettings {
        kind: ModuleKind::SiRad,
        bandwidth_khz: swept_khz,
        samples: capture.samples() as u16,
        ..RequestedSettings::default()
    };
    // The first measurement is used to detect the module's settings.
    let mut chirps = capture
        .chirps
        .iter()
        .take(1)
        .chain(&capture.chirps)
        .cloned();
    let mut player = Player {
        module: SiRad::new(),
        port: SiRadPort::new(Box::new(move |_| chirps.next())),
        now: 0,
    };
    let radar = player.program(&requested)?;
    let mount = MountConfig {
        mirror_offset: 0,
        ..MountConfig::default()
    };
    let mut range = RangeProcessor::new(&radar, &mount, &CfarConfig::default())
        .map_err(|error| anyhow!("{error}"))?;
    let (mut profile, mut echoes) = (Profile::default(), Vec::new());
    let mut samples = vec![Iq::default(); radar.samples.into()];
    for _ in &capture.chirps {
        player.chirp(&mut samples)?;
        range.profile(&samples, &mut profile)?;
        let strongest = profile
            .detections()
            .max_by(|a, b| a.power_db.total_cmp(&b.power_db));
        echoes.extend(strongest.map(|echo| (echo.bin * radar.bin_spacing_m(), echo.power_db)));
    }
    echoes.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(Found {
        radar,
        swept_khz,
        chirps: capture.chirps.len(),
        echoes,
    })
}

/// Prints for each capture its settings and the median of the strongest echoes.
pub fn run(args: &Args) -> Result<ExitCode> {
    ensure!(!args.captures.is_empty(), "no capture");
    for path in &args.captures {
        let name = path.display().to_string();
        let found = look(path, args.bandwidth).with_context(|| name.clone())?;
        if found.echoes.is_empty() && args.captures.len() == 1 {
            bail!("{name}: no echo beyond the leakage");
        }
        emit(&match args.format {
            Format::Text => text(&name, &found),
            Format::Json => lines(&name, &found),
        });
    }
    Ok(ExitCode::SUCCESS)
}

fn text(name: &str, found: &Found) -> String {
    let ghz = |khz: u32| f64::from(khz) / 1e6;
    let mut out = format!(
        "{name}: {} of {} samples, {:.3} GHz swept, {:.3} sampled: ",
        counted(found.chirps, "chirp"),
        found.radar.samples,
        ghz(found.swept_khz),
        ghz(found.radar.bandwidth_khz),
    );
    let _ = match found.median() {
        Some((range, power)) => writeln!(
            out,
            "strongest echo {range:.3} m, {power:.0} dB, in {} of them",
            found.echoes.len()
        ),
        None => writeln!(out, "no echo"),
    };
    out
}

fn lines(name: &str, found: &Found) -> String {
    let median = found.median();
    let object = json!({
        "capture": name,
        "chirps": found.chirps,
        "samples": found.radar.samples,
        "swept_hz": 1e3 * f64::from(found.swept_khz),
        "bandwidth_hz": 1e3 * f64::from(found.radar.bandwidth_khz),
        "with_echo": found.echoes.len(),
        "range_m": median.map(|(range, _)| range),
        "power_db": median.map(|(_, power)| power),
    });
    format!("{object}\n")
}
