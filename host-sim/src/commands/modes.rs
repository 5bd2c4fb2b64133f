//! `modes`: compares the two sweep modes on the same scenes.

use std::process::ExitCode;

use anyhow::{Result, anyhow, ensure};
use serde_json::{Value, json};
use stairscan::config::Config;
use stairscan::scanner::pace::Cruise;
use stairscan::scanner::{MICROSTEPS_PER_TURN, Schedule, Settings};
use stairscan::signal::radar::wire::Wire;

use super::{Format, emit, harness};
use crate::replay::{self, Options};
use crate::scene::command::scan_of;
use crate::scene::maths::Random;
use crate::scene::random::{Kind, random_with};
use crate::score::{self, SceneScore, SetScore};
use crate::seeds::Draw;

/// Random stream from which the phase of a shaft's vibration is drawn.
const PHASES: u64 = 0x4D4F_4445;
/// Maximum loss of exactly answered scenes by the continuous sweep, as a fraction of all scenes.
const COUNTS: f64 = 0.01;
/// Maximum relative increase of the median error of a step's distance or height by the continuous sweep: 0.1 is 10 %.
const ERRORS: f64 = 0.10;

/// Scans the same scenes with a mirror that stops at every angle and with one that turns, smear and vibration
/// included, and compares the answers.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Draw of the scenes
    #[arg(long, value_enum, default_value_t = Draw::Validation)]
    draw: Draw,
    /// Kind of the scenes
    #[arg(long, default_value_t = Kind::Ascending)]
    kind: Kind,
    /// Number of scenes
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    scenes: u32,
    /// Rate of the link, which limits the mirror's speed, baud
    #[arg(long, default_value_t = 2_000_000, value_parser = clap::value_parser!(u32).range(9_600..=12_000_000))]
    baud: u32,
    /// Amplitude of the shaft's vibration while it turns, degrees
    #[arg(long, default_value_t = 0.05)]
    vibration: f64,
    /// Fail if continuous sweeping is worse by more than 1 % of exact counts or 10 % of the median errors
    #[arg(long)]
    check: bool,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Returns the speed of the mirror in a continuous sweep with the default settings, degrees/s.
///
/// # Errors
/// The link is too slow for a continuous sweep.
pub fn speed_deg_s(baud: u32) -> Result<f64> {
    let settings = Settings::default();
    let schedule = Schedule::new(&settings.config).map_err(|e| anyhow!("{e}"))?;
    let wire = Wire {
        baud,
        ahead: true,
        pin: false,
    };
    let times = wire.row_times(settings.config.radar.samples);
    let cruise = Cruise::new(&settings, &schedule, times);
    let cruise = cruise.ok_or_else(|| anyhow!("--baud {baud}: too slow for a continuous sweep"))?;
    Ok(f64::from(cruise.speed) * 360.0 / f64::from(MICROSTEPS_PER_TURN))
}

/// Motion of a continuously turning mirror: its speed, degrees/s, and the amplitude of the shaft's vibration, degrees.
type Turning = (f64, f64);

/// Scans and scores one scene with a mirror that turns, or that stops at every angle if `turning` is `None`.
fn one(kind: Kind, seed: u64, turning: Option<Turning>) -> Result<SceneScore> {
    let mut spec = random_with(kind, kind.variety(), seed);
    if let Some((speed, vibration)) = turning {
        spec.mirror.turn_deg_s = speed;
        spec.mirror.vibration_deg = vibration;
        spec.mirror.vibration_phase_deg = Random::new(seed, PHASES).between(0.0, 360.0);
    }
    let recording = scan_of(spec, &format!("{kind}_{seed:03}"), seed)?;
    let truth = recording.meta.truth.clone().unwrap_or_default();
    let options = Options {
        config: Config {
            seed: 1,
            ..Config::default()
        },
        ..Options::default()
    };
    Ok(score::scene(&replay::answer(&recording, &options)?, &truth))
}

/// Scores of the same scenes in both sweep modes.
pub struct Comparison {
    /// Scores with a mirror that stops at every angle.
    pub stop: SetScore,
    /// Scores with a mirror that turns continuously.
    pub continuous: SetScore,
}

/// Scans `scenes` scenes in both sweep modes and scores the answers.
///
/// # Errors
/// A scene cannot be scanned; the message names it.
pub fn compare(draw: Draw, kind: Kind, scenes: u32, turning: Turning) -> Result<Comparison> {
    let seeds: Vec<u64> = draw.seeds().take(scenes as usize).collect();
    let both = |&seed: &u64| Ok((one(kind, seed, None)?, one(kind, seed, Some(turning))?));
    let scored: Vec<(SceneScore, SceneScore)> = harness::each(&seeds, both)?;
    let (stop, continuous): (Vec<_>, Vec<_>) = scored.into_iter().unzip();
    Ok(Comparison {
        stop: SetScore::new("stop", stop.iter()),
        continuous: SetScore::new("continuous", continuous.iter()),
    })
}

/// Returns the median errors of the steps' distances and heights, metres; NaN without a matched step.
fn medians(set: &SetScore) -> [f64; 2] {
    [set.distance[0], set.height[0]].map(|s| s.map_or(f64::NAN, |s| s.median))
}

impl Comparison {
    /// Returns the degradation by the continuous sweep against the stopping one: exact scenes lost, as a fraction of
    /// all; relative increase of the median error of distance; that of height.
    pub fn worse(&self) -> [f64; 3] {
        let scenes = self.stop.scenes.max(1) as f64;
        let exact = |set: &SetScore| set.exact.hits as f64;
        let lost = (exact(&self.stop) - exact(&self.continuous)) / scenes;
        let (a, b) = (medians(&self.stop), medians(&self.continuous));
        [lost, b[0] / a[0] - 1.0, b[1] / a[1] - 1.0]
    }

    /// Whether the degradation by the continuous sweep is within the limits: 1 % of the scenes, and 10 % of each median
    /// error.
    pub fn holds(&self) -> bool {
        let [lost, distance, height] = self.worse();
        // NaN, without a single match, does not pass.
        lost <= COUNTS && distance <= ERRORS && height <= ERRORS
    }

    fn text(&self) -> String {
        let mut out = String::from(
            "mode        exact      ok   ok & wrong   median error, mm: distance   height\n",
        );
        for set in [&self.stop, &self.continuous] {
            let [distance, height] = medians(set);
            out.push_str(&format!(
                "{:<11} {:>5}  {:>6}  {:>11}  {:>26.2}  {:>7.2}\n",
                set.name,
                set.exact.hits,
                set.ok.hits,
                set.ok_and_wrong.hits,
                1e3 * distance,
                1e3 * height
            ));
        }
        let [lost, distance, height] = self.worse().map(|share| 100.0 * share);
        out.push_str(&format!(
            "continuous: {lost:+.1} % of all scenes less exact (limit 1), median errors \
             {distance:+.1} % and {height:+.1} % (limit 10): {}\n",
            if self.holds() { "no worse" } else { "worse" }
        ));
        out
    }

    fn json(&self) -> Value {
        json!({
            "stop": self.stop.json(),
            "continuous": self.continuous.json(),
            "worse": { "exact": self.worse()[0], "distance": self.worse()[1], "height": self.worse()[2] },
            "holds": self.holds(),
        })
    }
}

/// Compares the sweep modes and prints the scores.
pub fn run(args: &Args) -> Result<ExitCode> {
    ensure!(
        (0.0..=1.0).contains(&args.vibration),
        "--vibration: {}: expected 0 to 1 degree",
        args.vibration
    );
    let speed = speed_deg_s(args.baud)?;
    let found = compare(args.draw, args.kind, args.scenes, (speed, args.vibration))?;
    match args.format {
        Format::Json => emit(&format!("{}\n", found.json())),
        Format::Text => emit(&format!(
            "{} {} scenes, seeds from {} on; turning at {speed:.1} degrees/s ({} baud), vibration of {} degrees\n{}",
            args.scenes,
            args.kind,
            args.draw.seeds().start,
            args.baud,
            args.vibration,
            found.text()
        )),
    }
    Ok(match args.check && !found.holds() {
        true => ExitCode::FAILURE,
        false => ExitCode::SUCCESS,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_faster_the_wire_the_faster_the_mirror() {
        let [one, two, three] = [1_000_000, 2_000_000, 3_000_000].map(|b| speed_deg_s(b).unwrap());
        assert!((28.0..30.0).contains(&one), "{one}");
        assert!((57.0..60.0).contains(&two), "{two}");
        assert!((84.0..90.0).contains(&three), "{three}");
        assert!(speed_deg_s(9_600).is_err());
    }

    #[test]
    fn what_vibrates_too_much_is_rated_worse() {
        let compare = |vibration| {
            let turning = (speed_deg_s(2_000_000).unwrap(), vibration);
            compare(Draw::Tuning, Kind::Ascending, 3, turning).unwrap()
        };
        let wild = compare(1.0);
        assert!(!wild.holds(), "{}", wild.text());
    }
}
