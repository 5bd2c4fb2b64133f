//! Rate of guard sweeps for each radar module and link rate, with the parts of a sweep's duration.

use anyhow::{Result, anyhow};
use serde_json::{Map, Value, json};
use stairscan::config::Plane;
use stairscan::scanner::pace::{Cruise, RowWork};
use stairscan::scanner::{Schedule, Settings};
use stairscan::signal::radar::any::row_times;
use stairscan::signal::radar::module::{ModuleKind, RequestedSettings};
use stairscan::signal::radar::wire::{RowTimes, Wire};

/// Converts microseconds to milliseconds.
pub fn ms(us: u64) -> f64 {
    us as f64 / 1000.0
}

/// A radar module that requires a stop of the mirror at every row.
struct Stopping {
    name: &'static str,
    link: &'static str,
    /// Time from the trigger until the mirror may move on, microseconds.
    chirp_us: u64,
    /// Time from the end of `chirp_us` until the samples are read, microseconds; it overlaps with the move.
    read_us: u64,
}

/// Timing of a SiRad by the limits of docs/design/modules.md: it measures every 15.8 ms at best, and its answer takes 10.4 ms.
const SIRAD: Stopping = Stopping {
    name: "sirad",
    link: "1.0 Mbaud",
    chirp_us: 15_800,
    read_us: 10_400,
};

/// Period of consecutive guard sweeps: the sum of the durations of its parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GuardTime {
    /// Value of the setting `module`.
    pub module: &'static str,
    /// Link to the module and its rate, as text.
    pub link: String,
    /// Name and duration of each part, microseconds.
    pub parts: Vec<(&'static str, u64)>,
}

impl GuardTime {
    /// Returns the period of guard sweeps with a turning mirror; `None` if the shaft has no room for the ramps.
    /// `settings` contain the guard's angles.
    fn passing(
        settings: &Settings,
        schedule: &Schedule,
        (module, link): (&'static str, String),
        times: RowTimes,
    ) -> Option<Self> {
        let cruise = Cruise::new(settings, schedule, times, RowWork::Guard)?;
        let sweep = u64::from(cruise.sweep_us(&settings.motor, schedule));
        let rows = u64::from(schedule.rows().saturating_sub(1)) * u64::from(cruise.period_us);
        // Acceleration and deceleration, at either end.
        let ramp =
            2_000_000 * u64::from(cruise.speed) / u64::from(settings.motor.acceleration.max(1));
        let ramps = if settings.motor.acceleration == 0 {
            0
        } else {
            ramp
        };
        Some(Self {
            module,
            link,
            parts: vec![
                ("rows in passing", rows),
                ("ramps", ramps),
                (
                    "beside the sector: calm, trigger, chirp",
                    sweep.saturating_sub(rows + ramps),
                ),
            ],
        })
    }

    /// Returns the period of guard sweeps with a mirror that stops at every row. The next sweep begins at the row at
    /// which the last one ended.
    fn stopping(settings: &Settings, schedule: &Schedule, module: &Stopping) -> Self {
        let (ramp, rows) = (settings.motor.ramp(), u64::from(schedule.rows()));
        let moves = (1..schedule.rows()).map(|row| {
            let way = schedule.position(row).abs_diff(schedule.position(row - 1));
            u64::from(ramp.duration_us(way))
        });
        let settle = u64::from(settings.timing.settle);
        let (mut moving, mut waits) = (0, module.read_us);
        for us in moves {
            moving += us;
            waits += module.read_us.saturating_sub(us + settle);
        }
        Self {
            module: module.name,
            link: format!("{}, with stops", module.link),
            parts: vec![
                ("move", moving),
                ("settle", rows * settle),
                ("chirp", rows * module.chirp_us),
                ("samples on the wire, beyond the moves", waits),
            ],
        }
    }

    /// Returns the period of the guard sweeps, microseconds.
    pub fn total(&self) -> u64 {
        self.parts.iter().map(|(_, us)| us).sum()
    }

    /// Returns the rate of the guard sweeps, 1/s.
    pub fn rate(&self) -> f64 {
        1e6 / self.total().max(1) as f64
    }

    /// Returns the durations of the sweep's parts as one JSON object.
    pub fn json(&self) -> Value {
        let part = |(name, us): &(&str, u64)| ((*name).to_owned(), json!(ms(*us)));
        json!({
            "mode": "guard",
            "module": self.module,
            "link": self.link,
            "sweep_ms": ms(self.total()),
            "sweeps_a_second": (10.0 * self.rate()).round() / 10.0,
            "parts": self.parts.iter().map(part).collect::<Map<String, Value>>(),
        })
    }

    fn text(&self) -> String {
        let mut out = format!(
            "{:<11} {:<22} {:>9.1} {:>11.1}\n",
            self.module,
            self.link,
            ms(self.total()),
            self.rate()
        );
        for (name, us) in &self.parts {
            out += &format!("  {name:<42} {:>9.1}\n", ms(*us));
        }
        out
    }
}

/// Returns the durations of a guard sweep for every module at every rate of its link.
///
/// # Errors
/// No guard sweep is possible with the settings; the message names the cause.
pub fn sweeps(settings: &Settings, wires: &[Wire]) -> Result<Vec<GuardTime>> {
    let mut settings = *settings;
    settings.config.sweep = settings.guard.sweep();
    let schedule = Schedule::in_plane(settings.config.sweep, Plane::Depth);
    let schedule = schedule.map_err(|e| anyhow!("guard: {e}"))?;
    let samples = settings.config.radar.samples;
    let serial = wires.iter().map(|wire| {
        let link = format!("{:.1} Mbaud", f64::from(wire.baud) / 1e6);
        (("pstr", link), wire.row_times(samples))
    });
    let requested = RequestedSettings {
        kind: ModuleKind::Bgt60,
        ..settings.module
    };
    let chip = row_times(&requested, samples).filter(|_| requested.chirps_fit());
    let chip = chip.map(|times| (("bgt60", "SPI".into()), times));
    let mut times: Vec<GuardTime> = serial
        .chain(chip)
        .filter_map(|(names, times)| GuardTime::passing(&settings, &schedule, names, times))
        .collect();
    if requested.chirps_fit() {
        times.push(GuardTime::stopping(&settings, &schedule, &SIRAD));
    }
    Ok(times)
}

/// Returns the durations of guard sweeps as a table of text.
pub fn text(settings: &Settings, times: &[GuardTime]) -> String {
    let mut out = String::from("guard with  link                   sweep, ms  sweeps a second\n");
    out.extend(times.iter().map(GuardTime::text));
    let (rows, least) = (settings.guard.sweep().angle_count, settings.guard.rate);
    out + &format!(
        "{rows} rows; `guard on` requires guard-rate, {least} sweeps a second, and is refused below \
         it unless it is 0. Ramps depend on acceleration; the settling time is the mirror's, not \
         the module's.\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the rate of guard sweeps with a module at 3 Mbaud, or over SPI, 1/s.
    fn rate(settings: &Settings, module: &str) -> f64 {
        let wire = Wire {
            baud: 3_000_000,
            ahead: true,
            pin: false,
        };
        let times = sweeps(settings, &[wire]).unwrap();
        let found = times.iter().find(|time| time.module == module);
        found.unwrap().rate()
    }

    #[test]
    fn the_own_link_sweeps_eight_times_a_second_with_ramps_that_are_short_enough() {
        let mut settings = Settings::default();
        settings.motor.acceleration = 4_000_000;
        assert!(
            rate(&settings, "pstr") >= 8.0,
            "{}",
            rate(&settings, "pstr")
        );
    }

    #[test]
    fn a_mirror_that_stops_is_limited_by_moves_and_settling() {
        let mut settings = Settings::default();
        let slow = rate(&settings, "sirad");
        settings.timing.settle = 100;
        assert!(rate(&settings, "sirad") > 1.1 * slow, "{slow}");
        assert!(slow < 2.0);
    }

    #[test]
    fn a_chip_on_spi_sweeps_in_passing() {
        let mut settings = Settings::default();
        settings.motor.acceleration = 4_000_000;
        assert!(rate(&settings, "bgt60") >= 8.0);
        (settings.motor.speed, settings.motor.acceleration) = (60_000, 8_000_000);
        assert!(rate(&settings, "bgt60") >= 10.0);
    }

    #[test]
    fn several_chirps_per_row_slow_the_guard_down() {
        let mut settings = Settings::default();
        let one = rate(&settings, "pstr");
        settings.set("chirps-per-row", "16").unwrap();
        let sixteen = rate(&settings, "pstr");
        assert!((1.0..0.4 * one).contains(&sixteen), "{one} {sixteen}");
    }

    #[test]
    fn parts_add_up() {
        let wires = [1_000_000, 3_000_000].map(|baud| Wire {
            baud,
            ahead: true,
            pin: false,
        });
        let times = sweeps(&Settings::default(), &wires).unwrap();
        assert_eq!(times.len(), 4);
        for time in &times {
            let sum: u64 = time.parts.iter().map(|(_, us)| us).sum();
            assert_eq!(sum, time.total());
            assert!((time.json()["sweep_ms"].as_f64().unwrap() - ms(sum)).abs() < 1e-9);
        }
    }
}
