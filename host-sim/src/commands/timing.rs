//! `timing`: calculates the duration of a scan from the configuration.

pub mod guard;

use std::process::ExitCode;

use anyhow::{Result, anyhow};
use serde_json::{Map, Value, json};
use stairscan::scanner::pace::{Cruise, RowWork};
use stairscan::scanner::ramp::Ramp;
use stairscan::scanner::{Schedule, Settings};
use stairscan::signal::radar::any::row_times;
use stairscan::signal::radar::module::{ModuleKind, RequestedSettings};
use stairscan::signal::radar::wire::{RowTimes, SLACK_US, Wire};

use super::{Format, emit};
use crate::budgets::{CHIRP, POST};
use crate::setting_file::table;
use guard::ms;

/// Prints how long a scan takes, part by part: stopping at every angle and turning through them, at the
/// link's three rates, beside the chirps alone; then guard sweeps a second for each module.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Settings that differ from the defaults: KEY=VALUE with a unit, such as settle=3ms, or as a whole number as in the
    /// scanner's `set`
    #[arg(value_parser = parse_setting)]
    settings: Vec<(&'static str, String)>,
    /// Rates of the link, baud.
    #[arg(long, value_delimiter = ',', default_values_t = [1_000_000, 2_000_000, 3_000_000],
          value_parser = clap::value_parser!(u32).range(9_600..=12_000_000))]
    baud: Vec<u32>,
    /// The radar module accepts one request at a time, and none while it sends.
    #[arg(long)]
    one_at_a_time: bool,
    /// Chirps begin at an edge of the TRIG pin instead of the last byte of a trigger.
    #[arg(long)]
    pin: bool,
    /// Output format.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

fn parse_setting(text: &str) -> Result<(&'static str, String), String> {
    let (key, value) = text.split_once('=').ok_or("expected KEY=VALUE")?;
    let row = table::row(key.trim()).ok_or_else(|| format!("{key}: no such setting"))?;
    let value = value.trim();
    // A number alone counts in the unit of the scanner's command.
    let value = match value.parse::<i64>() {
        Ok(_) => value.to_owned(),
        Err(_) => row.without_unit(value)?,
    };
    Ok((row.key, value))
}

/// Clocks of the core per microsecond. The budgets count instructions; the Cortex-M4F executes at best one each
/// clock.
const CORE_MHZ: u64 = 168;
/// Speeds of a chair, m/s: beside stairs, and along a corridor.
const CHAIR: [f64; 2] = [0.2, 0.5];

/// Duration of a scan by parts, in the order of output; their sum is the duration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScanTime {
    /// Sweep mode, `stop` or `continuous`; `bound` for the lower bound.
    pub mode: &'static str,
    /// Value of the setting `module`; `None` if it has no effect.
    pub module: Option<&'static str>,
    /// Rate of the radar link, baud; `None` for SPI, and if it has no effect.
    pub baud: Option<u32>,
    /// Name and duration of each part, microseconds.
    pub parts: Vec<(&'static str, u64)>,
}

impl ScanTime {
    /// Returns the lower bound of a scan's duration: consecutive chirps without pauses.
    pub fn bound(settings: &Settings) -> Self {
        let rows = u64::from(settings.config.sweep.angle_count);
        let chirps = rows * u64::from(settings.capture_us());
        Self {
            mode: "bound",
            module: None,
            baud: None,
            parts: vec![("chirps", chirps)],
        }
    }

    /// Returns the duration of a scan with a mirror that stops at every row; the answer to a chirp is transmitted while
    /// the mirror moves on.
    pub fn stop(settings: &Settings, schedule: &Schedule, wire: Wire) -> Self {
        let ramp = settings.motor.ramp();
        let rows = u64::from(schedule.rows());
        let settle = u64::from(settings.timing.settle);
        let chirp = u64::from(settings.capture_us());
        let trigger = u64::from(wire.trigger_us());
        let answer = u64::from(wire.chirp_us(settings.config.radar.samples)) + CHIRP / CORE_MHZ;
        // Without the chirp's duration its end is known only from its answer.
        let slack = match chirp {
            0 => answer,
            _ => u64::from(SLACK_US),
        };
        let (mut moves, mut waits) = (0, 0);
        for row in 1..schedule.rows() {
            let way = schedule.position(row).abs_diff(schedule.position(row - 1));
            let moving = u64::from(ramp.duration_us(way));
            moves += moving;
            waits += answer.saturating_sub(slack + moving + settle);
        }
        // There is no move after the last row.
        waits += answer.saturating_sub(slack);
        Self {
            mode: "stop",
            module: Some("pstr"),
            baud: Some(wire.baud),
            parts: vec![
                ("move", moves),
                ("settle", rows * settle),
                ("trigger on the wire", rows * trigger),
                ("chirp", rows * (chirp + slack)),
                ("chirp on the wire, beyond the moves", waits),
            ],
        }
    }

    /// Returns the duration of a scan with a turning mirror and rows over the link `wire`; `None` if the shaft has no
    /// room for acceleration and deceleration.
    pub fn continuous(settings: &Settings, schedule: &Schedule, wire: Wire) -> Option<Self> {
        let times = wire.row_times(settings.config.radar.samples);
        let time = Self::passing(settings, schedule, ("pstr", times))?;
        Some(Self {
            baud: Some(wire.baud),
            ..time
        })
    }

    /// Returns the duration of a scan with a turning mirror and a BGT60TR13C on SPI; `None` if the shaft has no room
    /// for acceleration and deceleration.
    fn chip(settings: &Settings, schedule: &Schedule) -> Option<Self> {
        let requested = RequestedSettings {
            kind: ModuleKind::Bgt60,
            ..settings.module
        };
        let times = row_times(&requested, settings.config.radar.samples);
        let times = times.filter(|_| requested.chirps_fit())?;
        Self::passing(settings, schedule, ("bgt60", times))
    }

    fn passing(
        settings: &Settings,
        schedule: &Schedule,
        (module, times): (&'static str, RowTimes),
    ) -> Option<Self> {
        let cruise = Cruise::new(settings, schedule, times, RowWork::Scan)?;
        let (start, end) = cruise.ends(schedule, false);
        let ramp = Ramp {
            speed: cruise.speed,
            acceleration: settings.motor.acceleration,
        };
        let turn = u64::from(ramp.duration_us(start.abs_diff(end)));
        let rows = u64::from(schedule.rows() - 1) * u64::from(cruise.period_us);
        let ramps = turn.saturating_sub(rows);
        // The last row is half of the ramps' travel before the end; its answer may take longer.
        let chirp = times.chirp_us.unwrap_or(settings.capture_us());
        let answer = u64::from(chirp) / 2 + u64::from(times.answer_us) + CHIRP / CORE_MHZ;
        Some(Self {
            mode: "continuous",
            module: Some(module),
            baud: None,
            parts: vec![
                ("rows in passing", rows),
                ("ramps, and to come to rest", ramps),
                (
                    "last chirp on the wire, beyond the ramp",
                    answer.saturating_sub(ramps / 2),
                ),
            ],
        })
    }

    /// Returns the duration of the scan, from the first move to the last sample, microseconds.
    pub fn total(&self) -> u64 {
        self.parts.iter().map(|(_, us)| us).sum()
    }

    fn json(&self) -> Value {
        let part = |(name, us): &(&str, u64)| ((*name).to_owned(), json!(ms(*us)));
        let parts: Map<String, Value> = self.parts.iter().map(part).collect();
        json!({
            "mode": self.mode,
            "module": self.module,
            "baud": self.baud,
            "scan_ms": ms(self.total()),
            "parts": parts,
            "travel_mm": { "0.2": travel_mm(self, CHAIR[0]), "0.5": travel_mm(self, CHAIR[1]) },
        })
    }

    fn text(&self) -> String {
        let at = match (self.baud, self.module) {
            (Some(baud), _) => format!("{:.1} Mbaud", f64::from(baud) / 1e6),
            (None, Some(module)) => format!("{module}, SPI"),
            (None, None) => "chirps alone".into(),
        };
        let [slow, fast] = CHAIR.map(|speed| travel_mm(self, speed) / 10.0);
        let mut out = format!(
            "{:<11} {:<12} {:>9.1} {:>13.1} {:>12.1}\n",
            self.mode,
            at,
            ms(self.total()),
            slow,
            fast
        );
        for (name, us) in &self.parts {
            out.push_str(&format!("  {name:<42} {:>9.1}\n", ms(*us)));
        }
        out
    }
}

/// Returns the distance that a chair at `speed` (m/s) travels during a scan, mm, rounded to 0.1 mm.
fn travel_mm(time: &ScanTime, speed: f64) -> f64 {
    (ms(time.total()) * speed * 10.0).round() / 10.0
}

/// Returns the durations of a scan: the lower bound, each sweep mode at each rate of the link, and SPI.
///
/// # Errors
/// No scan is possible with the settings; the message names the cause.
pub fn modes(settings: &Settings, wires: &[Wire]) -> Result<Vec<ScanTime>> {
    let schedule = Schedule::new(&settings.config).map_err(|e| anyhow!("{e}"))?;
    let mut times = vec![ScanTime::bound(settings)];
    times.extend(
        wires
            .iter()
            .map(|&w| ScanTime::stop(settings, &schedule, w)),
    );
    times.extend(
        wires
            .iter()
            .filter_map(|&w| ScanTime::continuous(settings, &schedule, w)),
    );
    times.extend(ScanTime::chip(settings, &schedule));
    Ok(times)
}

/// Prints the durations of scans and guard sweeps with the given settings.
pub fn run(args: &Args) -> Result<ExitCode> {
    let mut settings = Settings::default();
    for (key, value) in &args.settings {
        settings.set(key, value).map_err(|e| anyhow!("{e}"))?;
    }
    let (ahead, pin) = (!args.one_at_a_time, args.pin);
    let wire = |&baud| Wire { baud, ahead, pin };
    let wires: Vec<Wire> = args.baud.iter().map(wire).collect();
    let times = modes(&settings, &wires)?;
    let sweeps = guard::sweeps(&settings, &wires)?;
    if args.format == Format::Json {
        times
            .iter()
            .for_each(|time| emit(&format!("{}\n", time.json())));
        sweeps
            .iter()
            .for_each(|sweep| emit(&format!("{}\n", sweep.json())));
        return Ok(ExitCode::SUCCESS);
    }
    let mut out = String::from("mode        link           scan, ms  at 0.2 m/s, cm  at 0.5, cm\n");
    times.iter().for_each(|time| out.push_str(&time.text()));
    if !times.iter().any(|time| time.mode == "continuous") {
        out.push_str(
            "continuous: no room for its ramps, or too slow; the scanner stops at every angle\n",
        );
    }
    out.push_str(&format!(
        "{}{} rows; centimetres are what a chair travels meanwhile. A row's arithmetic, {:.2} ms at \
         most at 168 MHz, overlaps the transfer; the report follows within {:.1} ms of the last \
         row.\n",
        match settings.module.chirps {
            1 => String::new(),
            chirps => format!("{chirps} chirps per row, which bgt60 and sirad cannot add. "),
        },
        settings.config.sweep.angle_count,
        ms(CHIRP / CORE_MHZ),
        ms(POST / CORE_MHZ)
    ));
    out.push('\n');
    out += &guard::text(&settings, &sweeps);
    emit(&out);
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(one_at_a_time: bool) -> Vec<ScanTime> {
        let wires = [1_000_000, 2_000_000, 3_000_000].map(|baud| Wire {
            baud,
            ahead: !one_at_a_time,
            pin: false,
        });
        modes(&Settings::default(), &wires).unwrap()
    }

    fn total(times: &[ScanTime], mode: &str, baud: u32) -> u64 {
        let found = times
            .iter()
            .find(|t| t.mode == mode && t.baud == Some(baud));
        found.unwrap().total()
    }

    #[test]
    fn a_setting_is_given_with_its_unit_or_as_the_scanner_counts_it() {
        for (text, key, value) in [
            ("settle=3000", "settle", "3000"),
            ("settle=3ms", "settle", "3000"),
            ("settle = 0.003 s", "settle", "3000"),
            ("guard-last=44°", "guard-last", "44000"),
            ("mount-height=43cm", "mount-height", "43000"),
            ("link-rate=2Mbaud", "link-rate", "2000000"),
            ("speed=360deg/s", "speed", "51200"),
            ("sweep-mode=stop", "sweep-mode", "stop"),
        ] {
            assert_eq!(parse_setting(text), Ok((key, value.to_owned())), "{text}");
        }
        for (text, part) in [
            ("settle", "expected KEY=VALUE"),
            ("setle=3ms", "setle: no such setting"),
            (
                "settle=3cm",
                "settle: found \"3cm\", expected a number and its unit (s, ms",
            ),
            (
                "settle=0.5us",
                "settle: found \"0.5us\", expected a whole number of us",
            ),
        ] {
            let error = parse_setting(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
    }

    #[test]
    fn scans_take_no_longer_than_they_may() {
        let times = times(false);
        assert_eq!(times[0].total(), 281_000);
        assert!(total(&times, "stop", 1_000_000) <= 3_900_000, "{times:?}");
        assert!(
            total(&times, "continuous", 2_000_000) <= 1_300_000,
            "{times:?}"
        );
    }

    /// Compares the calculated durations with those measured by the simulated bench in `src/scanner/sweep/tests`, where
    /// steps, bytes and arithmetic take time.
    #[test]
    fn they_are_those_of_the_sweep_over_simulated_time() {
        let times = times(false);
        for (mode, baud, ms) in MEASURED {
            let computed = self::ms(total(&times, mode, baud));
            // The simulated scan begins with a short move.
            assert!(
                (0.96..=1.0).contains(&(computed / ms)),
                "{mode} {baud}: {computed}, not {ms}"
            );
        }
    }

    const MEASURED: [(&str, u32, f64); 4] = [
        ("stop", 1_000_000, 3_716.4),
        ("continuous", 1_000_000, 2_420.5),
        ("continuous", 2_000_000, 1_222.3),
        ("continuous", 3_000_000, 835.2),
    ];

    #[test]
    fn a_chirp_of_unknown_length_is_waited_for() {
        let mut settings = Settings::default();
        settings.timing.chirp_duration = 0;
        let wire = Wire::default();
        let times = modes(&settings, &[wire]).unwrap();
        // Moves, settling, triggers and transmitted chirps in sequence.
        let all = total(&times, "stop", wire.baud);
        assert!((5_600_000..5_800_000).contains(&all), "{all}");
    }

    #[test]
    fn several_chirps_per_row_take_their_time() {
        let mut settings = Settings::default();
        let wire = Wire {
            baud: 3_000_000,
            ahead: true,
            pin: false,
        };
        let one = modes(&settings, &[wire]).unwrap();
        settings.set("chirps-per-row", "16").unwrap();
        let many = modes(&settings, &[wire]).unwrap();
        assert_eq!(many[0].total(), 16 * one[0].total());
        for mode in ["stop", "continuous"] {
            let longer = total(&many, mode, wire.baud) - total(&one, mode, wire.baud);
            let rows = 281 * 15_000;
            // With stops the answer overlaps with the moves either way; in passing it takes 2.7 ms of a row.
            assert!(
                (rows - 281 * 2_000..rows + rows / 10).contains(&longer),
                "{mode}: {longer}"
            );
        }
        assert!(!many.iter().any(|time| time.module == Some("bgt60")));
    }

    #[test]
    fn json_has_a_line_for_each_mode() {
        for time in times(true) {
            let line = time.json();
            let parts = line["parts"].as_object().unwrap();
            let sum: f64 = parts.values().map(|v| v.as_f64().unwrap()).sum();
            assert!((sum - line["scan_ms"].as_f64().unwrap()).abs() < 1e-6);
            assert!(line["mode"].is_string());
        }
    }
}
