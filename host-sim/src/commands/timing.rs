//! `timing`: what a scan takes, computed from the configuration.

use std::process::ExitCode;

use anyhow::{Result, anyhow};
use stairscan::scan::frame::{HEADER, LINK_BAUD, TRAILER};
use stairscan::scan::ramp::Ramp;
use stairscan::scan::{Schedule, Settings};

use super::emit;
use crate::budgets::{CHIRP, POST};

/// Arguments of `timing`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Settings that differ from the defaults, as the image's `set` takes them: KEY=VALUE
    #[arg(value_parser = parse_setting)]
    settings: Vec<(String, String)>,
}

fn parse_setting(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("expected KEY=VALUE")?;
    Ok((key.to_owned(), value.to_owned()))
}

/// Bits of a byte on the wire: start, eight, stop.
const BITS: u64 = 10;

fn transfer_us(bytes: usize) -> u64 {
    bytes as u64 * BITS * 1_000_000 / u64::from(LINK_BAUD)
}

/// Times of one scan, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScanTime {
    /// Rows.
    pub rows: u64,
    /// Shortest and longest move from one row to the next.
    pub step: (u64, u64),
    /// All moves.
    pub moves: u64,
    /// Settling, once a row.
    pub settle: u64,
    /// Trigger frame on the wire.
    pub trigger: u64,
    /// Chirp frame on the wire.
    pub transfer: u64,
}

impl ScanTime {
    /// The times that `settings` make.
    pub fn new(settings: &Settings) -> Result<Self> {
        let schedule = Schedule::new(&settings.config).map_err(|e| anyhow!("{e}"))?;
        let ramp = Ramp {
            speed: settings.motor.speed,
            acceleration: settings.motor.acceleration,
        };
        let moves: Vec<u64> = (1..schedule.rows())
            .map(|row| {
                let way = schedule.position(row).abs_diff(schedule.position(row - 1));
                u64::from(ramp.duration_us(way))
            })
            .collect();
        let samples = usize::from(settings.config.radar.samples);
        let shortest = moves.iter().min().copied().unwrap_or(0);
        let longest = moves.iter().max().copied().unwrap_or(0);
        Ok(Self {
            rows: u64::from(schedule.rows()),
            step: (shortest, longest),
            moves: moves.iter().sum(),
            settle: u64::from(settings.timing.settle),
            trigger: transfer_us(HEADER + 4 + TRAILER),
            transfer: transfer_us(HEADER + 4 * samples + TRAILER),
        })
    }

    /// From the first trigger's settling to the last sample.
    pub fn total(&self) -> u64 {
        self.moves + self.rows * (self.settle + self.trigger + self.transfer)
    }
}

/// Clocks of the core in a microsecond. The budgets count instructions; one a clock is what the
/// Cortex-M4F does at best.
const CORE_MHZ: u64 = 168;

/// Prints the table.
pub fn run(args: &Args) -> Result<ExitCode> {
    let mut settings = Settings::default();
    for (key, value) in &args.settings {
        let known = Settings::key(key).ok_or_else(|| anyhow!("{key}: no such setting"))?;
        settings.set(known, value).map_err(|e| anyhow!("{e}"))?;
    }
    let time = ScanTime::new(&settings)?;
    let ms = |us: u64| us as f64 / 1000.0;
    let all = |us: u64| format!("{:>10.1}", ms(us * time.rows));
    let mut out = String::from("what                          a row, ms   a scan, ms\n");
    let mut line = |what: &str, row: String, scan: String| {
        out.push_str(&format!("{what:<28} {row:>10}   {scan:>10}\n"));
    };
    let (short, long) = time.step;
    line(
        "move",
        format!("{:.1}-{:.1}", ms(short), ms(long)),
        format!("{:.1}", ms(time.moves)),
    );
    line(
        "settle",
        format!("{:.1}", ms(time.settle)),
        all(time.settle),
    );
    line(
        "trigger on the wire",
        format!("{:.2}", ms(time.trigger)),
        all(time.trigger),
    );
    line(
        "chirp on the wire",
        format!("{:.2}", ms(time.transfer)),
        all(time.transfer),
    );
    let row = CHIRP / CORE_MHZ;
    line(
        "arithmetic (during the move)",
        format!("<{:.2}", ms(row)),
        "0.0".into(),
    );
    line(
        "last row to report",
        String::new(),
        format!("<{:.1}", ms(POST / CORE_MHZ)),
    );
    line("scan", String::new(), format!("{:.1}", ms(time.total())));
    out.push_str(&format!(
        "{} rows; the arithmetic's figures are its budgets at 168 MHz; the module's own chirp time \
         comes on top of each row\n",
        time.rows
    ));
    emit(&out);
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_scan_is_the_sum_of_its_parts() {
        let time = ScanTime::new(&Settings::default()).unwrap();
        // 200 samples of 4 bytes and 12 bytes around them, 10 bits each at 1 Mbaud.
        assert_eq!((time.rows, time.transfer, time.trigger), (281, 8_120, 160));
        // 35 or 36 microsteps at 50 turns/s²: 2 √(s / a).
        assert!((6_000..8_500).contains(&time.step.0), "{time:?}");
        let total = time.moves + 281 * (5_000 + 160 + 8_120);
        assert_eq!(time.total(), total);
        assert!((5_000_000..6_500_000).contains(&total), "{total}");
    }
}
