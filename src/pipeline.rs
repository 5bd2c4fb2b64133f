//! All stages in one value: chirp, row of the map, health checks, estimator, outcome.

use crate::Iq;
use crate::answer::Answer;
use crate::config::{Config, ConfigError, MAX_SAMPLES};
use crate::drive::{Drive, ExpectedTravel, PhaseAgreement, Retention};
use crate::finder::StairFinder;
use crate::health::{Expected, Health};
use crate::mount::Mounting;
use crate::mount::command::calibrate;
use crate::observer::Observer;
use crate::params::Numbers;
use crate::past::History;
use crate::scanner::DataPath;
use crate::signal::echoes::FoundEchoes;
use crate::signal::grid::PolarMap;
use crate::signal::image::{ImageMemory, KeptImage};
use crate::signal::range::{Profile, RangeProcessor};
use crate::track::Track;
use crate::verdict::{
    Assessment, Conditions, Evidence, GuardEvidence, GuardResult, MotionQuality, Outcome,
};

/// Range processing, map, health and estimator: the scan state of the firmware.
///
/// A scan is [`DataPath::begin`], for each row its samples and [`DataPath::row`] (or [`DataPath::lost`]), and
/// [`DataPath::finish`]. Samples without any signal end in a fault:
///
/// ```
/// use stairscan::Iq;
/// use stairscan::verdict::{Reason, Status};
/// use stairscan::config::Config;
/// use stairscan::pipeline::Pipeline;
/// use stairscan::scanner::DataPath;
///
/// let config = Config::default();
/// let mut pipeline = Box::new(Pipeline::new());
/// pipeline.begin(&config, 1)?;
/// for row in 0..config.sweep.angle_count {
///     pipeline.samples().fill(Iq::new(0, 0));
///     pipeline.row(row);
/// }
/// let outcome = pipeline.finish();
/// assert_eq!(outcome.status(), Status::Fault);
/// assert!(outcome.reasons().has(Reason::Silent));
/// # Ok::<(), stairscan::config::ConfigError>(())
/// ```
///
/// `examples/recording_to_steps.rs` does the same with a recording.
#[derive(Debug)]
pub struct Pipeline {
    samples: [Iq; MAX_SAMPLES],
    config: Config,
    scan: u32,
    range: RangeProcessor,
    finder: StairFinder,
    health: Health,
    /// Evidence of earlier scans of the same scene.
    past: History,
    numbers: Numbers,
    /// Whether the present rows are a scan's, whose image is made; else a guard sweep's.
    imaging: bool,
}

/// Maximum interval between two guard sweeps whose evidence is combined, seconds: in a longer one a person may have
/// stepped into the way.
const GUARD_BREAK_S: f32 = 1.0;

/// Maximum memory of the scan state, with either estimator, bytes.
const BUDGET: usize = 104 * 1024 + size_of::<ImageMemory>();
const _: () = assert!(
    size_of::<Pipeline>() <= BUDGET,
    "scan state above its budget"
);

impl Pipeline {
    /// Creates a data path without a configuration; [`DataPath::begin`] sets one. All bits are zero, so that a
    /// static of this type takes no flash.
    pub const fn new() -> Self {
        Self::with(Numbers::DEFAULT)
    }

    /// Creates a data path as [`Pipeline::new`] does, whose stages have these tuned numbers.
    pub const fn with(numbers: Numbers) -> Self {
        Self {
            samples: [Iq { i: 0, q: 0 }; MAX_SAMPLES],
            config: Config::EMPTY,
            scan: 0,
            range: RangeProcessor::idle(),
            finder: StairFinder::new(numbers),
            health: Health::new(numbers),
            past: History::new(numbers),
            numbers,
            imaging: false,
        }
    }

    /// First part of [`DataPath::row`]: computes row `row` of the map from the chirp, and runs the health
    /// checks on it. The second part is [`Pipeline::complete`].
    pub fn process_row(&mut self, row: u16) {
        let Self {
            samples,
            config,
            range,
            finder,
            health,
            imaging,
            ..
        } = self;
        let chirp = samples.get(..chirp(samples, config)).unwrap_or(&[]);
        let kept = finder.write(row.into(), |mut cells| {
            // The chirp has the configured length.
            let Ok(stats) = range.process(chirp, &mut cells) else {
                return false;
            };
            let discarded = health.row(row, chirp, &stats, cells.cells);
            if discarded {
                // Interference is discarded: the row is set to zero.
                cells.cells.fill(0);
                cells.mask.fill(0);
            }
            !discarded
        });
        health.check_map_row(row, finder.map(), |bin| range.phasors(bin));
        if *imaging && kept == Some(true) {
            finder.add(row.into(), &mut range.coherent());
        }
    }

    /// Marks row `row` as final (received and processed by [`Pipeline::process_row`], or lost) and lets the estimator
    /// process it.
    pub fn complete(&mut self, row: u16) {
        self.finder.complete(row.into());
    }

    /// Returns the memory of the coherent image, to be lent at boot.
    pub fn memory_mut(&mut self) -> &mut ImageMemory {
        self.finder.image_mut().memory_mut()
    }

    /// Returns the coherent image: of the rows so far, and after the answer what is left without the echoes.
    pub fn image(&self) -> &KeptImage {
        self.finder.image()
    }

    /// Returns the echoes of the last scan, and its noise.
    pub fn found(&self) -> &FoundEchoes {
        self.finder.found()
    }

    /// Returns the map of the last scan.
    pub fn map(&self) -> &PolarMap {
        self.finder.map()
    }

    /// Concludes the scan as [`DataPath::conclude`] does, and passes intermediate results to `observer`.
    // Not inlined: else the stack would hold a second outcome beneath the estimator.
    #[inline(never)]
    pub fn conclude_observed(
        &mut self,
        drive: &Drive<'_>,
        conditions: Conditions,
        observer: &mut dyn Observer,
    ) -> Outcome {
        let mut outcome = Outcome::silent();
        let mut evidence = Evidence {
            unusable: self.health.fault(self.config.mount.mirror_offset > 0),
            conditions,
            ..Evidence::default()
        };
        if evidence.unusable.is_none() {
            let expected = Expected {
                moving: drive.known().is_some_and(|track| self.moves(track)),
                uncalibrated: false,
            };
            evidence.health_faults =
                self.health
                    .failed_checks(&self.config, self.finder.map(), expected);
            let well = evidence.health_faults.is_empty();
            evidence.assessment = self.estimate(drive, well, observer, &mut outcome.answer);
        }
        outcome.decide(&evidence);
        outcome
    }

    /// Lets the estimator fill `answer`, and returns the evidence for its status. `well`: whether all health
    /// checks passed.
    fn estimate(
        &mut self,
        drive: &Drive<'_>,
        well: bool,
        observer: &mut dyn Observer,
        answer: &mut Answer,
    ) -> Option<Assessment> {
        let drive = Drive {
            // Evidence of a scan with failed health checks is not kept.
            memory: match drive.memory {
                Retention::Aside => Retention::Aside,
                memory if well => memory,
                _ => Retention::Off,
            },
            phases: self.phases(drive),
            ..*drive
        };
        let past = match drive.memory {
            Retention::Aside => {
                self.past.skip_scan(self.scan);
                None
            }
            _ => Some(&mut self.past),
        };
        self.finder
            .finish(&self.config, self.scan, &drive, past, observer, answer)
    }

    /// Prepares range processing and health checks for the chirps of a scan or guard sweep. Returns the configuration
    /// for all later stages: its bandwidth is the calibrated one.
    fn ready(&mut self, config: &Config, scan: u32) -> Result<Config, ConfigError> {
        let config = Config {
            radar: config.radar.scaled(config.mount.range_scale),
            ..*config
        };
        self.range.configure_scan(&config)?;
        self.scan = scan;
        self.health = Health::new(self.numbers);
        self.config = config;
        Ok(config)
    }

    /// Returns the evidence for the result of the last guard sweep: its health checks, and the free ground by this
    /// sweep and those before it.
    #[inline(never)]
    fn guard_evidence(&mut self, drive: &Drive<'_>, conditions: Conditions) -> GuardEvidence {
        let mut evidence = GuardEvidence {
            unusable: self.health.fault(self.config.mount.mirror_offset > 0),
            motion: MotionQuality::of(drive),
            conditions,
            ..GuardEvidence::default()
        };
        if evidence.unusable.is_some() {
            return evidence;
        }
        // Motion is expected: a guard sweep is so short that the travel during it does not matter.
        let expected = Expected {
            moving: true,
            uncalibrated: false,
        };
        let map = self.finder.map();
        evidence.health_faults = self.health.failed_checks(&self.config, map, expected);
        let echo_found = self.health.has_echo(map);
        if self.scan == 1 || drive.since_s.is_some_and(|s| s > GUARD_BREAK_S) {
            self.finder.reset_guard();
        }
        let ground = self.finder.guard(&self.config, drive);
        // The average over rows and sweeps shows the ground even if no single cell exceeds the noise enough.
        evidence.echo_found = echo_found || ground.is_some_and(|ground| ground.free_m > 0.0);
        evidence.ground = ground;
        evidence
    }

    /// Returns whether the echoes' phases agree with the motion input of the last scan.
    pub fn phases(&self, drive: &Drive<'_>) -> PhaseAgreement {
        let mirror = self.config.mount.mirror_offset > 0;
        let known = drive.known().filter(|_| mirror);
        known.map_or(PhaseAgreement::Unknown, |track| {
            let (map, radar) = (self.finder.map(), &self.config.radar);
            self.health.phases(track, map, radar)
        })
    }

    /// Returns whether the chair moved along `track` by more than a standing chair's limits, `stood_m` and `stood_rad`.
    fn moves(&self, track: &Track) -> bool {
        track.moves(self.numbers.stood_m, self.numbers.stood_rad)
    }

    /// Returns the health checks of the last scan.
    pub fn health(&self) -> &Health {
        &self.health
    }
}

impl Default for Pipeline {
    fn default() -> Self {
        Self::new()
    }
}

/// Returns the number of samples of a chirp of `config`, at most the size of the buffer.
fn chirp(samples: &[Iq; MAX_SAMPLES], config: &Config) -> usize {
    samples.len().min(usize::from(config.radar.samples))
}

impl DataPath for Pipeline {
    fn begin(&mut self, config: &Config, scan: u32) -> Result<(), ConfigError> {
        let config = &self.ready(config, scan)?;
        self.imaging = true;
        self.finder.begin(config)
    }

    fn begin_guard(&mut self, config: &Config, sweep: u32) -> Result<(), ConfigError> {
        let config = &self.ready(config, sweep)?;
        self.imaging = false;
        self.finder.begin_guard(config)
    }

    fn samples(&mut self) -> &mut [Iq] {
        let count = chirp(&self.samples, &self.config);
        self.samples.get_mut(..count).unwrap_or(&mut [])
    }

    fn row(&mut self, row: u16) {
        self.process_row(row);
        self.complete(row);
    }

    fn lost(&mut self, row: u16) {
        self.complete(row);
    }

    fn conclude(&mut self, drive: &Drive<'_>, conditions: Conditions) -> Outcome {
        self.conclude_observed(drive, conditions, &mut ())
    }

    #[inline(never)]
    fn guard(&mut self, drive: &Drive<'_>, conditions: Conditions) -> GuardResult {
        let evidence = self.guard_evidence(drive, conditions);
        let word = GuardResult::new(&evidence);
        // Evidence of a sweep with failed health checks is not kept.
        if evidence.unusable.is_some() || !evidence.health_faults.is_empty() {
            self.finder.reset_guard();
        }
        word
    }

    #[inline(never)]
    fn calibrate(&mut self, wall_m: f32) -> Result<Mounting, ConfigError> {
        let (config, health) = (&self.config, &self.health);
        let expected = Expected {
            moving: false,
            uncalibrated: true,
        };
        let failed = health.failed_checks(config, self.finder.map(), expected);
        let verdict = health.fault(config.mount.mirror_offset > 0);
        if let Some(reason) = verdict.or(failed.first()) {
            return Err(ConfigError {
                field: reason.as_str(),
                expected: "an instrument without failed health checks",
            });
        }
        let (mirror, echoes) = (
            health.mirror_seen(config),
            &self.finder.detect(config).echoes,
        );
        calibrate(echoes, config, mirror, wall_m, &self.numbers).map_err(|refusal| ConfigError {
            field: "scene",
            expected: refusal.expected(),
        })
    }

    fn numbers(&self) -> Numbers {
        self.numbers
    }

    fn expect_motion(&mut self, travel: ExpectedTravel) {
        self.finder.image_mut().expect_motion(travel);
    }

    fn self_test(&mut self) -> bool {
        self.finder.image().is_possible() && known_answer(&mut self.range).unwrap_or(false)
    }
}

/// Processes two tones of known range and power with FFT and CFAR. Returns `Some(true)` if detections, ranges
/// and powers are as expected.
fn known_answer(range: &mut RangeProcessor) -> Option<bool> {
    let config = Config::default();
    range
        .configure(&config.radar, &config.mount, &config.cfar)
        .ok()?;
    let mut chirp = [Iq::default(); 200];
    for (n, sample) in (0_u16..).zip(&mut chirp) {
        // The strong tone: half a turn a sample, native bin 100 of 200, exact in any arithmetic. The weak one:
        // a quarter turn a sample, 20 dB weaker; it must be detected beside the strong one.
        let strong = if n & 1 == 0 { 8000 } else { -8000 };
        let (i, q) = [(800, 0), (0, 800), (-800, 0), (0, -800)][usize::from(n & 3)];
        *sample = Iq::new(strong + i, q);
    }
    let mut profile = Profile::default();
    range.profile(&chirp, &mut profile).ok()?;
    // Bin and level of each tone, dB: amplitudes 800 and 8000 of 32768.
    let mut expected: &[(f32, f32)] = &[(64.0, -32.2), (128.0, -12.2)];
    for found in profile.detections() {
        match expected {
            [(bin, db), rest @ ..]
                if (found.bin - bin).abs() < 0.1 && (found.power_db - db).abs() < 0.5 =>
            {
                expected = rest;
            }
            // Without noise, only rounding of the transform remains to be detected.
            _ if found.power_db < -85.0 => {}
            _ => return Some(false),
        }
    }
    Some(expected.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_known_answer_is_known() {
        assert_eq!(known_answer(&mut RangeProcessor::idle()), Some(true));
    }
}
