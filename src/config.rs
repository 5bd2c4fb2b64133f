//! Configuration of a scan: the settings of recordings, commands and radar module.
//!
//! Values are fixed-point numbers (lengths in 0.01 mm, angles in 0.001°), so that a recording replayed on the
//! host and a command to the scanner have exactly the same effect. [`to_fixed`] is the only function that
//! rounds to them. Defaults are the paper's (sections II-A, II-B, III).

pub use crate::setting::ConfigError;
pub(crate) use crate::setting::check;
use crate::setting::{settings, words};

/// Speed of light in vacuum, m/s.
pub const SPEED_OF_LIGHT: f32 = 299_792_458.0;

/// Permitted number of samples per chirp.
pub const SAMPLES: core::ops::RangeInclusive<u16> = 16..=256;

/// Maximum number of samples of one chirp, and size of the largest transform.
pub const MAX_SAMPLES: usize = 256;

settings! {
    /// Settings of the radar module, which define a chirp. Defaults: the paper's (section II-A).
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct RadarConfig
    parts {}
    rows {
        /// Carrier (centre) frequency.
        carrier_khz: u32 = 94_000_000, "radar-carrier" "kHz" [] Module;
        /// Swept bandwidth B.
        bandwidth_khz: u32 = 10_000_000, "radar-bandwidth" "kHz" [] Module;
        /// Complex samples per chirp Ns, 16 to 256; of a real chirp its pairs, half its values.
        samples: u16 = 200, "radar-samples" "" [] Module;
    }
    also {
        /// Whether the module samples one channel instead of I and Q. A chirp of 2 Ns real values x₀, x₁, … is
        /// then stored as Ns pairs (x₀, x₁), (x₂, x₃), … in place of I and Q.
        ///
        /// Bin k of its transform has k periods in the padded chirp, as bin k of a complex chirp has: the Ns
        /// bins below half the sampling rate have the range axis of Ns complex samples.
        real: bool = false;
    }
}

impl RadarConfig {
    /// Checks that the buffers can hold such a chirp and that it has a range axis.
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

    /// Returns the range resolution c / 2B, metres (eq. 1).
    pub fn range_resolution_m(&self) -> f32 {
        SPEED_OF_LIGHT / (2000.0 * self.bandwidth_khz.max(1) as f32)
    }

    /// Returns the carrier's wavelength, metres.
    pub fn wavelength_m(&self) -> f32 {
        SPEED_OF_LIGHT / (1000.0 * self.carrier_khz.max(1) as f32)
    }

    /// Returns the settings with ranges increased by `scale` parts per million: the module's bandwidth is
    /// smaller than its nominal value.
    pub fn scaled(self, scale: i32) -> Self {
        Self {
            bandwidth_khz: (self.bandwidth_khz as f32 / (1.0 + scale as f32 * 1e-6)) as u32,
            ..self
        }
    }

    /// Returns the length of the transform: the next power of two that holds a chirp.
    pub fn fft_len(&self) -> usize {
        usize::from(self.samples)
            .next_power_of_two()
            .clamp(16, MAX_SAMPLES)
    }

    /// Returns the range difference between bins of the zero-padded transform, metres.
    pub fn bin_spacing_m(&self) -> f32 {
        self.range_resolution_m() * f32::from(self.samples) / self.fft_len() as f32
    }
}

/// Plane in which the mirror turns the beam.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Plane {
    /// Angles from the horizontal, positive downwards, looking forward: stairs going up.
    #[default]
    Depth,
    /// Angles from straight down, positive towards the front: stairs going down (fig. 14).
    Height,
}

/// Planes of the scanner's scans: the setting `plane`.
///
/// A single scan is of one [`Plane`]. Under `both`, `scanner::planes` decides when a scan of the second one
/// follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Planes {
    /// Every scan in the depth plane.
    #[default]
    Depth,
    /// Every scan in the height plane.
    Height,
    /// The depth plane, and the height plane where a chair stands before a drop.
    Both,
}

words!(Planes: "depth" Planes::Depth, "height" Planes::Height, "both" Planes::Both);

impl Planes {
    /// Returns the plane of every scan that does not follow another: with `both` the depth plane.
    pub const fn first(self) -> Plane {
        match self {
            Self::Depth | Self::Both => Plane::Depth,
            Self::Height => Plane::Height,
        }
    }
}

impl From<Plane> for Planes {
    fn from(plane: Plane) -> Self {
        match plane {
            Plane::Depth => Self::Depth,
            Plane::Height => Self::Height,
        }
    }
}

impl Plane {
    /// Returns the plane's name in settings, sentences and recordings.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Height => "height",
        }
    }
}

settings! {
    /// Mounting of the scanner.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct MountConfig
    parts {}
    rows {
        /// Plane of the scans; `both`: the depth plane, and the height plane where the chair stands before a drop.
        plane: Planes = Planes::Depth, "plane" "" [] Answer;
        /// Distance from the radar lens to the mirror centre.
        mirror_offset: i32 = 22_000, "mirror-offset" "0.01 mm" [0 to 200_000] Answer;
        /// Range of the mirror's own echo at calibration; 0: not calibrated.
        mirror_echo: i32 = 0, "mirror-echo" "0.01 mm" [0 to 200_000] Answer;
        /// Level of that echo at calibration, relative to full scale; 0: not calibrated.
        mirror_level: i32 = 0, "mirror-level" "0.001 dB" [-150_000 to 0] Answer;
        /// Relative error of the range scale: the module's bandwidth is smaller than its nominal value.
        range_scale: i32 = 0, "range-scale" "1e-6" [-100_000 to 100_000] Answer;
        /// Height of the mirror centre above the ground.
        mount_height: i32 = 40_000, "mount-height" "0.01 mm" [1_000 to 500_000] Answer;
        /// Full two-sided 3 dB width of the beam leaving the mirror.
        beamwidth: i32 = 5_000, "beamwidth" "0.001 deg" [500 to 30_000] Answer;
    }
    also {}
}

impl MountConfig {
    /// Returns the distance from radar lens to mirror centre, metres.
    pub fn mirror_offset_m(&self) -> f32 {
        self.mirror_offset as f32 * 1e-5
    }

    /// Returns the height of the mirror centre above the ground, metres.
    pub fn mount_height_m(&self) -> f32 {
        self.mount_height as f32 * 1e-5
    }

    /// Returns the two-sided 3 dB beamwidth, radians.
    pub fn beamwidth_rad(&self) -> f32 {
        self.beamwidth as f32 * 1e-3 * crate::math::RAD_PER_DEG
    }
}

/// Maximum number of rows (angles) of one scan: that of a map with the minimum number of range bins.
pub const MAX_ROWS: usize = 8192;

settings! {
    /// Angles of one scan: `first`, `first + step`, ….
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct SweepConfig
    parts {}
    rows {
        /// First angle of a scan.
        first_angle: i32 = -20_000, "first-angle" "0.001 deg" [-170_000 to 170_000] Answer;
        /// Angle step of a scan.
        angle_step: i32 = 250, "angle-step" "0.001 deg" [10 to 10_000] Answer;
        /// Number of angles.
        angle_count: u16 = 281, "angle-count" "angles" [3 to 8_192] Answer;
    }
    also {}
}

impl SweepConfig {
    /// Checks that the settings are within their limits and that the shaft can reach the last angle.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.limits()?;
        let last = i64::from(self.first_angle)
            + i64::from(self.angle_step) * (i64::from(self.angle_count) - 1);
        check(
            last <= 170_000,
            "first-angle",
            "a sweep within the 340 degrees of the shaft",
        )
    }

    /// Returns the scheduled beam angle of row `k`, 0.001°.
    pub fn angle(&self, k: u16) -> i32 {
        self.first_angle
            .saturating_add(self.angle_step.saturating_mul(i32::from(k)))
    }
}

settings! {
    /// Cell-averaging constant-false-alarm-rate detection (paper III-C).
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct CfarConfig
    parts {}
    rows {
        /// Number of guard cells on each side of the cell under test.
        guard: u8 = 3, "cfar-guard" "cells" [0 to 16] Answer;
        /// Number of training cells on each side, beyond the guard cells.
        training: u8 = 8, "cfar-training" "cells" [1 to 32] Answer;
        /// Probability of false alarm per cell.
        false_alarm: f32 = 1.7e-4, "cfar-false-alarm" "1e-9" [1 to 500_000_000] Answer;
        /// Width of the excluded range beyond the mirror, which contains its own echo.
        near_margin: i32 = 15_000, "cfar-near-margin" "0.01 mm" [0 to 200_000] Answer;
    }
    also {}
}

/// Initial distribution of the particles before the first resampling (paper III-A).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spread {
    /// Uniform over the map.
    Uniform,
    /// Gaussian modes around high-intensity cells of the raw map.
    GmmRaw,
    /// Gaussian modes around high-intensity cells of the CFAR map.
    #[default]
    GmmCfar,
}

impl Spread {
    /// Returns the paper's number of resampling rounds for this distribution: 15, 5 and 2.
    pub const fn rounds(self) -> u8 {
        match self {
            Spread::Uniform => 15,
            Spread::GmmRaw => 5,
            Spread::GmmCfar => 2,
        }
    }
}

/// Maximum number of particles of one scan.
pub const MAX_PARTICLES: usize = 1000;
/// Maximum number of Gaussian modes in the particles' initial distribution.
pub const MAX_MODES: usize = 32;

words!(Spread: "uniform" Spread::Uniform, "gmm-raw" Spread::GmmRaw, "gmm-cfar" Spread::GmmCfar);

settings! {
    /// Particle filter and clustering of the paper.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ParticleConfig
    parts {}
    rows {
        /// Number of particles N.
        particles: u16 = 1_000, "particles" "particles" [10 to 1_000] Answer;
        /// Number of Gaussian modes M.
        modes: u8 = 10, "modes" "modes" [1 to 32] Answer;
        /// Initial distribution of the particles.
        spread: Spread = Spread::GmmCfar, "spread" "" [] Answer;
        /// Number of resampling rounds.
        rounds: u8 = 2, "rounds" "rounds" [1 to 50] Answer;
        /// Standard deviation of a mode.
        mode_sigma: i32 = 8_000, "mode-sigma" "0.01 mm" [100 to 100_000] Answer;
        /// Clustering sensitivity ρ: the vigilance of Fuzzy ART.
        vigilance: u16 = 500, "vigilance" "0.001" [0 to 1_000] Answer;
    }
    also {}
}

const _: () = assert!(MAX_ROWS == 8_192 && MAX_PARTICLES == 1_000 && MAX_MODES == 32);

/// Estimator that turns the map into steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EstimatorKind {
    /// Scatterers by matched filter, staircases by likelihood and particles.
    #[default]
    Likelihood,
    /// The paper's estimator: particles, clusters, top particle with the 3 dB beam correction.
    #[cfg(feature = "paper")]
    Paper,
}

impl EstimatorKind {
    /// All estimators.
    pub const ALL: &'static [EstimatorKind] = &[
        EstimatorKind::Likelihood,
        #[cfg(feature = "paper")]
        EstimatorKind::Paper,
    ];

    /// Returns the estimator's name in commands and options.
    pub const fn as_str(self) -> &'static str {
        match self {
            EstimatorKind::Likelihood => "likelihood",
            #[cfg(feature = "paper")]
            EstimatorKind::Paper => "paper",
        }
    }

    /// Returns the estimator of this name; `None` if there is none.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.as_str() == name)
    }
}

impl crate::setting::Word for EstimatorKind {
    const WORDS: &'static [(&'static str, Self)] = &[
        (Self::Likelihood.as_str(), Self::Likelihood),
        #[cfg(feature = "paper")]
        (Self::Paper.as_str(), Self::Paper),
    ];
    #[cfg(feature = "paper")]
    const ONE_OF: &'static str = "likelihood or paper";
    #[cfg(not(feature = "paper"))]
    const ONE_OF: &'static str = "likelihood";
}

settings! {
    /// Configuration of a scan.
    ///
    /// ```
    /// use stairscan::config::{Config, Planes, to_fixed};
    ///
    /// // The paper's scanner on a pole, looking down: lengths in 0.01 mm, angles in 0.001°.
    /// let mut config = Config::default();
    /// config.mount.plane = Planes::Height;
    /// config.mount.mount_height = to_fixed(1.2, 1e-5).unwrap();
    /// assert!(config.validate().is_ok());
    ///
    /// config.sweep.angle_step = 0;
    /// assert_eq!(config.validate().unwrap_err().field, "angle-step");
    /// ```
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Config
    parts {
        /// Mounting of the scanner.
        mount: MountConfig;
        /// Angles of a scan.
        sweep: SweepConfig;
        /// Detection in range.
        cfar: CfarConfig;
        /// Particle filter of the paper.
        particles: ParticleConfig;
        /// Radar module.
        radar: RadarConfig;
    }
    rows {
        /// Method that turns the map into steps.
        estimator: EstimatorKind = EstimatorKind::Likelihood, "estimator" "" [] Answer;
        /// Seed of the particles' random numbers; the scan's number is mixed in.
        seed: u32 = 0, "seed" "" [] Answer;
    }
    also {}
}

impl Config {
    /// Checks every setting against its limits, the chirp against the buffers, and the last angle against the shaft's
    /// reach. Whether the map can hold the scan is checked where the map is shaped.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.radar.validate()?;
        self.limits()?;
        self.sweep.validate()
    }
}

/// Converts `value` to a whole number of `unit`s (both in the same physical unit), rounded half away from zero.
/// Every length and angle of a recording becomes a command's fixed-point number by this function.
///
/// Returns `None` if the value is not finite or does not fit.
pub fn to_fixed(value: f64, unit: f64) -> Option<i32> {
    let scaled = value / unit;
    let limit = f64::from(i32::MAX);
    if !(-limit..=limit).contains(&scaled) {
        return None;
    }
    Some((scaled + if scaled < 0.0 { -0.5 } else { 0.5 }) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_ends_within_the_shaft() {
        let sweep = |first_angle, angle_step, angle_count| {
            let sweep = SweepConfig {
                first_angle,
                angle_step,
                angle_count,
            };
            sweep.validate().map_err(|error| error.field)
        };
        assert_eq!(sweep(100_000, 1_000, 71), Ok(()));
        assert_eq!(sweep(100_000, 1_000, 72), Err("first-angle"));
        assert_eq!(sweep(-170_000, 10_000, 35), Ok(()));
    }

    #[test]
    fn estimators_are_found_by_their_names() {
        for &kind in EstimatorKind::ALL {
            assert_eq!(EstimatorKind::from_name(kind.as_str()), Some(kind));
        }
        assert_eq!(EstimatorKind::from_name("likelihoods"), None);
    }
}
