//! One configuration for everything: what a recording, a command or the radar module may set.
//!
//! Values travel as fixed-point numbers (lengths in 0.01 mm, angles in 0.001°), so that a recording
//! replayed on the host and a command sent to the scanner mean exactly the same. [`to_fixed`] is
//! the one function that rounds to them. Defaults are the paper's (sections II-A, II-B, III).

use core::fmt;

/// Speed of light in vacuum, m/s.
pub const SPEED_OF_LIGHT: f32 = 299_792_458.0;

/// Fewest and most samples a chirp may have.
pub const SAMPLES: core::ops::RangeInclusive<u16> = 16..=256;

/// Most samples of one chirp, and the largest transform.
pub const MAX_SAMPLES: usize = 256;

/// A value that the scanner cannot work with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConfigError {
    /// The field, by the name that commands and messages use.
    pub field: &'static str,
    /// What was expected of it.
    pub expected: &'static str,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: expected {}", self.field, self.expected)
    }
}

impl core::error::Error for ConfigError {}

/// Fails with `field` and `expected` unless `ok`.
pub(crate) fn check(
    ok: bool,
    field: &'static str,
    expected: &'static str,
) -> Result<(), ConfigError> {
    if ok {
        Ok(())
    } else {
        Err(ConfigError { field, expected })
    }
}

/// What the radar module is set to: it decides what a chirp means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RadarConfig {
    /// Carrier (centre) frequency, kHz.
    pub carrier_khz: u32,
    /// Swept bandwidth B, kHz.
    pub bandwidth_khz: u32,
    /// Complex samples per chirp Ns, 16..=256; of a real chirp its pairs, half its values.
    pub samples: u16,
    /// Whether the module samples one channel and not I and Q: a chirp of 2 Ns real values
    /// x₀, x₁, … is carried as Ns pairs (x₀, x₁), (x₂, x₃), … in the place of I and Q.
    ///
    /// Bin k of its transform has k periods in the padded chirp, as bin k of a complex chirp has: the
    /// Ns bins below half the sampling rate have the range axis of Ns complex samples.
    pub real: bool,
}

impl Default for RadarConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl RadarConfig {
    /// The paper's (section II-A).
    pub const DEFAULT: Self = Self {
        carrier_khz: 94_000_000,
        bandwidth_khz: 10_000_000,
        samples: 200,
        real: false,
    };

    /// Checks that the buffers hold such a chirp and that it has a range axis.
    pub fn validate(&self) -> Result<(), ConfigError> {
        check(
            SAMPLES.contains(&self.samples),
            "samples",
            "16 to 256 samples per chirp",
        )?;
        check(
            self.bandwidth_khz > 0,
            "bandwidth",
            "a swept bandwidth above 0 Hz",
        )
    }

    /// Range resolution c / 2B in metres (eq. 1).
    pub fn range_resolution_m(&self) -> f32 {
        SPEED_OF_LIGHT / (2000.0 * self.bandwidth_khz.max(1) as f32)
    }

    /// The same with ranges larger by `scale` parts of a million: a sweep that is narrower than it is said to be.
    pub fn scaled(self, scale: i32) -> Self {
        Self {
            bandwidth_khz: (self.bandwidth_khz as f32 / (1.0 + scale as f32 * 1e-6)) as u32,
            ..self
        }
    }

    /// Length of the transform: the next power of two that holds a chirp.
    pub fn fft_len(&self) -> usize {
        usize::from(self.samples)
            .next_power_of_two()
            .clamp(16, MAX_SAMPLES)
    }

    /// Range from one bin of the zero-padded transform to the next, metres.
    pub fn bin_spacing_m(&self) -> f32 {
        self.range_resolution_m() * f32::from(self.samples) / self.fft_len() as f32
    }
}

/// The plane that the mirror sweeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plane {
    /// Angles from the horizontal, positive downwards, looking forward: stairs going up.
    #[default]
    Depth,
    /// Angles from straight down, positive towards the front: stairs going down (fig. 14).
    Height,
}

/// How the scanner is mounted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MountConfig {
    /// Radar lens to mirror centre, 0.01 mm.
    pub mirror_offset: i32,
    /// Range at which the mirror's own echo was seen when the scanner was calibrated, 0.01 mm; 0 before
    /// that.
    pub mirror_echo: i32,
    /// Level of the mirror's own echo when the scanner was calibrated, 0.001 dB relative to full scale; 0 before
    /// that.
    pub mirror_level: i32,
    /// By how much ranges are larger than the module's bandwidth says, parts of a million: its sweep is narrower.
    pub range_scale: i32,
    /// Mirror centre above the surface that the wheelchair stands on, 0.01 mm.
    pub mount_height: i32,
    /// Full two-sided 3 dB width of the beam leaving the mirror, 0.001°.
    pub beamwidth: i32,
    /// The plane that the mirror sweeps.
    pub plane: Plane,
}

impl Default for MountConfig {
    fn default() -> Self {
        Self {
            mirror_offset: 22_000,
            mirror_echo: 0,
            mirror_level: 0,
            range_scale: 0,
            mount_height: 40_000,
            beamwidth: 5_000,
            plane: Plane::Depth,
        }
    }
}

impl MountConfig {
    /// Checks that the numbers describe a scanner that can exist.
    pub fn validate(&self) -> Result<(), ConfigError> {
        check(
            (0..=200_000).contains(&self.mirror_offset),
            "mirror-offset",
            "0 to 2 m in 0.01 mm",
        )?;
        check(
            (0..=200_000).contains(&self.mirror_echo),
            "mirror-echo",
            "0 to 2 m in 0.01 mm",
        )?;
        check(
            (-150_000..=0).contains(&self.mirror_level),
            "mirror-level",
            "-150 to 0 dB in 0.001",
        )?;
        check(
            (-100_000..=100_000).contains(&self.range_scale),
            "range-scale",
            "-100000 to 100000 parts of a million",
        )?;
        check(
            (1_000..=500_000).contains(&self.mount_height),
            "mount-height",
            "0.01 to 5 m in 0.01 mm",
        )?;
        check(
            (500..=30_000).contains(&self.beamwidth),
            "beamwidth",
            "0.5 to 30 degrees in 0.001",
        )
    }

    /// Radar lens to mirror centre, metres.
    pub fn mirror_offset_m(&self) -> f32 {
        self.mirror_offset as f32 * 1e-5
    }

    /// Mirror centre above the ground, metres.
    pub fn mount_height_m(&self) -> f32 {
        self.mount_height as f32 * 1e-5
    }

    /// Two-sided 3 dB beam width, radians.
    pub fn beamwidth_rad(&self) -> f32 {
        self.beamwidth as f32 * 1e-3 * crate::math::RAD_PER_DEG
    }
}

/// Most rows (angles) of one scan: those of a map with the fewest range bins.
pub const MAX_ROWS: usize = 8192;

/// The angles of one scan: `first`, `first + step`, ….
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SweepConfig {
    /// First angle, 0.001°.
    pub first_angle: i32,
    /// From one angle to the next, 0.001°.
    pub angle_step: i32,
    /// Number of angles.
    pub angle_count: u16,
}

impl Default for SweepConfig {
    fn default() -> Self {
        Self {
            first_angle: -20_000,
            angle_step: 250,
            angle_count: 281,
        }
    }
}

impl SweepConfig {
    /// Checks that the shaft can turn so far and that the map holds so many rows.
    pub fn validate(&self) -> Result<(), ConfigError> {
        check(
            (3..=MAX_ROWS as u16).contains(&self.angle_count),
            "angle-count",
            "3 to 8192 angles",
        )?;
        check(
            (10..=10_000).contains(&self.angle_step),
            "angle-step",
            "0.01 to 10 degrees in 0.001",
        )?;
        let last = i64::from(self.first_angle)
            + i64::from(self.angle_step) * (i64::from(self.angle_count) - 1);
        check(
            self.first_angle >= -170_000 && last <= 170_000,
            "first-angle",
            "a sweep within the 340 degrees of the shaft",
        )
    }

    /// Scheduled angle of row `k`, 0.001°.
    pub fn angle(&self, k: u16) -> i32 {
        self.first_angle
            .saturating_add(self.angle_step.saturating_mul(i32::from(k)))
    }
}

/// Cell-averaging constant-false-alarm-rate detection (paper III-C).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CfarConfig {
    /// Guard cells on each side of the cell under test.
    pub guard: u8,
    /// Training cells on each side, beyond the guard cells.
    pub training: u8,
    /// Probability that a cell holding nothing but noise is taken for a target.
    pub false_alarm: f32,
    /// Ranges up to this much beyond the mirror are its own echo, 0.01 mm.
    pub near_margin: i32,
}

impl Default for CfarConfig {
    fn default() -> Self {
        Self {
            guard: 3,
            training: 8,
            false_alarm: 1.7e-4,
            near_margin: 15_000,
        }
    }
}

impl CfarConfig {
    /// Checks that there is something to average and a threshold to compute.
    pub fn validate(&self) -> Result<(), ConfigError> {
        check(
            (1..=32).contains(&self.training),
            "cfar-training",
            "1 to 32 cells on each side",
        )?;
        check(self.guard <= 16, "cfar-guard", "0 to 16 cells on each side")?;
        check(
            self.false_alarm >= 1e-9 && self.false_alarm <= 0.5,
            "cfar-false-alarm",
            "a probability from 1e-9 to 0.5",
        )?;
        check(
            (0..=200_000).contains(&self.near_margin),
            "cfar-near-margin",
            "0 to 2 m in 0.01 mm",
        )
    }
}

/// How particles are spread before the first resampling (paper III-A).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spread {
    /// Evenly over the map.
    Uniform,
    /// Gaussian modes around high-intensity cells of the raw map.
    GmmRaw,
    /// Gaussian modes around high-intensity cells of the CFAR map.
    #[default]
    GmmCfar,
}

impl Spread {
    /// The paper's number of resampling rounds for this spread: 15, 5 and 2.
    pub const fn rounds(self) -> u8 {
        match self {
            Spread::Uniform => 15,
            Spread::GmmRaw => 5,
            Spread::GmmCfar => 2,
        }
    }
}

/// Most particles of one scan.
pub const MAX_PARTICLES: usize = 1000;
/// Most Gaussian modes.
pub const MAX_MODES: usize = 32;

/// The paper's particle filter and clustering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleConfig {
    /// Particles N.
    pub particles: u16,
    /// Gaussian modes M.
    pub modes: u8,
    /// How they start.
    pub spread: Spread,
    /// Resampling rounds.
    pub rounds: u8,
    /// Standard deviation of a mode, 0.01 mm.
    pub mode_sigma: i32,
    /// Clustering sensitivity ρ, 0…1 in 0.001: the vigilance of Fuzzy ART.
    pub vigilance: u16,
}

impl Default for ParticleConfig {
    fn default() -> Self {
        Self {
            particles: 1000,
            modes: 10,
            spread: Spread::GmmCfar,
            rounds: 2,
            mode_sigma: 8_000,
            vigilance: 500,
        }
    }
}

impl ParticleConfig {
    /// Checks the numbers against the buffers.
    pub fn validate(&self) -> Result<(), ConfigError> {
        check(
            (10..=MAX_PARTICLES as u16).contains(&self.particles),
            "particles",
            "10 to 1000 particles",
        )?;
        check(
            (1..=MAX_MODES as u8).contains(&self.modes),
            "modes",
            "1 to 32 modes",
        )?;
        check(
            (1..=50).contains(&self.rounds),
            "rounds",
            "1 to 50 resampling rounds",
        )?;
        check(
            (100..=100_000).contains(&self.mode_sigma),
            "mode-sigma",
            "0.001 to 1 m in 0.01 mm",
        )?;
        check(self.vigilance <= 1000, "vigilance", "0 to 1 in 0.001")
    }
}

/// Which estimator turns the map into steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EstimatorKind {
    /// Scatterers by matched filter and particles, staircases by likelihood.
    #[default]
    Likelihood,
    /// The paper's: particles, clusters, top particle with the 3 dB beam correction.
    #[cfg(feature = "paper")]
    Paper,
}

impl EstimatorKind {
    /// Every estimator.
    pub const ALL: &'static [EstimatorKind] = &[
        EstimatorKind::Likelihood,
        #[cfg(feature = "paper")]
        EstimatorKind::Paper,
    ];

    /// The name that commands and options use.
    pub const fn as_str(self) -> &'static str {
        match self {
            EstimatorKind::Likelihood => "likelihood",
            #[cfg(feature = "paper")]
            EstimatorKind::Paper => "paper",
        }
    }

    /// The estimator of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.as_str() == name)
    }
}

/// Everything that can be set.
///
/// ```
/// use stairscan::config::{Config, Plane, to_fixed};
///
/// // The paper's scanner on a pole, looking down: lengths in 0.01 mm, angles in 0.001°.
/// let mut config = Config::default();
/// config.mount.plane = Plane::Height;
/// config.mount.mount_height = to_fixed(1.2, 1e-5).unwrap();
/// assert!(config.validate().is_ok());
///
/// config.sweep.angle_step = 0;
/// assert_eq!(config.validate().unwrap_err().field, "angle-step");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Config {
    /// The radar module.
    pub radar: RadarConfig,
    /// How the scanner is mounted.
    pub mount: MountConfig,
    /// The angles of a scan.
    pub sweep: SweepConfig,
    /// Detection in range.
    pub cfar: CfarConfig,
    /// The paper's particle filter.
    pub particles: ParticleConfig,
    /// From map to steps.
    pub estimator: EstimatorKind,
    /// Seed of the particles' random numbers; the scan's number is mixed in.
    pub seed: u32,
}

impl Config {
    /// No configuration at all: every bit zero, valid for nothing. What statics hold before the
    /// first scan.
    pub const EMPTY: Self = Self {
        radar: RadarConfig {
            carrier_khz: 0,
            bandwidth_khz: 0,
            samples: 0,
            real: false,
        },
        mount: MountConfig {
            mirror_offset: 0,
            mirror_echo: 0,
            mirror_level: 0,
            range_scale: 0,
            mount_height: 0,
            beamwidth: 0,
            plane: Plane::Depth,
        },
        sweep: SweepConfig {
            first_angle: 0,
            angle_step: 0,
            angle_count: 0,
        },
        cfar: CfarConfig {
            guard: 0,
            training: 0,
            false_alarm: 0.0,
            near_margin: 0,
        },
        particles: ParticleConfig {
            particles: 0,
            modes: 0,
            spread: Spread::Uniform,
            rounds: 0,
            mode_sigma: 0,
            vigilance: 0,
        },
        estimator: EstimatorKind::ALL[0],
        seed: 0,
    };

    /// Checks every field, and that the map holds such a scan.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.radar.validate()?;
        self.mount.validate()?;
        self.sweep.validate()?;
        self.cfar.validate()?;
        self.particles.validate()
    }
}

/// Rounds `value` to whole `unit`s (both in the same physical unit), half away from zero: the one
/// way in which a metre or degree of a recording becomes the fixed-point number of a command.
///
/// `None` when the value is not finite or does not fit.
pub fn to_fixed(value: f64, unit: f64) -> Option<i32> {
    let scaled = value / unit;
    let limit = f64::from(i32::MAX);
    if !(-limit..=limit).contains(&scaled) {
        return None;
    }
    Some((scaled + if scaled < 0.0 { -0.5 } else { 0.5 }) as i32)
}
