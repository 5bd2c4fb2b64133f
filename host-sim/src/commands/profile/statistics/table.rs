//! Statistics as JSON and as text. A value that does not exist is null, or `-` with the reason.

use std::f64::consts::LN_2;
use std::fmt::Write as _;

use serde_json::{Value, json};

use super::{Echo, Statistics};

/// Returns a value with `digits` decimals, or `-`.
fn shown(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".into(), |v| format!("{v:.digits$}"))
}

/// Returns a value with its sign and one decimal, or `-`.
fn signed(value: Option<f64>) -> String {
    value.map_or("-".into(), |v| format!("{v:+.1}"))
}

impl Statistics {
    /// Returns the statistics of the chirps as one JSON object.
    pub fn json(&self) -> Value {
        let echo = |echo: &Echo| {
            json!({
                "name": echo.name, "range_m": echo.range_m, "power_db": echo.power_db,
                "over_noise_db": echo.over_noise_db, "noise_db": echo.noise_db,
                "phase_rad": echo.phase_rad, "phase_of_noise_rad": echo.phase_of_noise_rad,
                "frames_rad": echo.frames_rad, "level_db": echo.level_db,
            })
        };
        let noise = self.noise.as_ref().map(|noise| {
            json!({
                "bins": noise.bins, "range_m": noise.range_m, "power_db": noise.power_db,
                "mean_over_median": noise.mean_over_median, "above": noise.above,
                "correlation": noise.correlation, "correlation_by_window": self.window,
                "correlation_of_chirps": noise.chirps,
            })
        });
        json!({
            "chirps": self.chirps, "frame": self.frame, "noise": noise,
            "echoes": self.echoes.iter().map(echo).collect::<Vec<_>>(),
            "leakage_end_m": self.leakage_end_m, "near_noise_db": self.near_noise_db,
        })
    }

    /// Returns the statistics of the recording `name` as a table of text.
    pub fn text(&self, name: &str) -> String {
        let frames = self.chirps / self.frame;
        let mut out = format!(
            "{name}: {} chirps, {frames} frames of {}\n\n",
            self.chirps, self.frame
        );
        match &self.noise {
            None => out.push_str("noise: no bin holds noise alone\n"),
            Some(noise) => {
                let [near, far] = noise.range_m;
                let [one, two] = noise.correlation.map(|c| shown(c, 3));
                let [by_one, by_two] = self.window;
                let _ = write!(
                    out,
                    "noise of {} bins, {near:.2} to {far:.2} m          theory\n\
                     \x20 power of a bin, dBFS              {:>7}\n\
                     \x20 mean over median of power         {:>7}     {:.3}\n\
                     \x20 above 4.6 times the mean, %       {:>7}     1.00\n\
                     \x20 correlation of bins 1 apart       {one:>7}     {by_one:.3}\n\
                     \x20 correlation of bins 2 apart       {two:>7}     {by_two:.3}\n\
                     \x20 correlation of successive chirps  {:>7}     0.000\n",
                    noise.bins,
                    shown(noise.power_db, 1),
                    shown(noise.mean_over_median, 3),
                    1.0 / LN_2,
                    shown(noise.above.map(|share| 100.0 * share), 2),
                    shown(noise.chirps, 3)
                );
            }
        }
        let _ = write!(
            out,
            "\x20 next to the leakage, dB over that  {:>7}      0.0\n\
             leakage less than 10 dB over the noise from {} m on\n",
            signed(self.near_noise_db),
            shown(self.leakage_end_m, 3),
        );
        out.push_str(
            "\n                 range  power  over    noise    phase, rad rms        frame to frame\n\
             \x20                m      dBFS   noise   there    chirps    by noise    rad rms   dB rms\n",
        );
        for echo in &self.echoes {
            let _ = writeln!(
                out,
                "{:15} {:6.3} {:>6} {:>6} {:>7}   {:>8}  {:>8}    {:>8} {:>8}",
                echo.name,
                echo.range_m,
                shown(echo.power_db, 1),
                shown(echo.over_noise_db, 1),
                signed(echo.noise_db),
                shown(echo.phase_rad, 5),
                shown(echo.phase_of_noise_rad, 5),
                shown(echo.frames_rad, 5),
                shown(echo.level_db, 3),
            );
        }
        for reason in self.reasons() {
            let _ = write!(out, "\n- {reason}");
        }
        if !out.ends_with('\n') {
            out.push('\n');
        }
        out
    }

    /// Returns what is missing for each kind of value that does not exist.
    fn reasons(&self) -> Vec<String> {
        let mut reasons = Vec::new();
        let mut say = |is_missing: bool, reason: String| {
            if is_missing {
                reasons.push(reason);
            }
        };
        let noise = self.noise.as_ref();
        let still = noise
            .is_some_and(|noise| noise.chirps.is_none() || noise.mean_over_median.is_none())
            || self.near_noise_db.is_none();
        say(
            still,
            "noise: the chirps are the same, expected noise that varies".into(),
        );
        for (correlation, apart) in noise.into_iter().flat_map(|n| n.correlation).zip(1..) {
            let reason = format!("bins {apart} apart: no two without an echo, and with noise");
            say(correlation.is_none() && !still, reason);
        }
        let missing =
            |value: fn(&Echo) -> Option<f64>| self.echoes.iter().any(|e| value(e).is_none());
        let few = self.frame < 3;
        say(
            few && missing(|e| e.phase_rad),
            format!(
                "phase, chirps: a frame has {} chirps, expected 3",
                self.frame
            ),
        );
        let single = self.chirps < 2 * self.frame;
        say(
            single && !self.echoes.is_empty(),
            "frame to frame: a single frame, expected two (--frame N)".into(),
        );
        let powerless = missing(|e| e.power_db)
            || !few && missing(|e| e.phase_rad)
            || !single && missing(|e| e.level_db);
        say(powerless, "echoes: no power in the bin".into());
        reasons
    }
}
