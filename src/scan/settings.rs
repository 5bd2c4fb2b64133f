//! Everything that a command may read or set, by key.
//!
//! | key | unit | meaning |
//! |---|---|---|
//! | `plane` | `depth`, `height` | plane that the mirror sweeps |
//! | `mirror-offset`, `mount-height` | 0.01 mm | how the scanner is mounted |
//! | `mirror-echo` | 0.01 mm | range of the mirror's own echo when it was calibrated; 0: never |
//! | `mirror-level` | 0.001 dB | level of that echo, relative to full scale, when it was calibrated; 0: never |
//! | `range-scale` | 1e-6 | by how much ranges are larger than the module's bandwidth says |
//! | `beamwidth` | 0.001° | full two-sided 3 dB width of the beam |
//! | `first-angle`, `angle-step` | 0.001° | angles of a scan |
//! | `angle-count` | | number of angles |
//! | `sweep` | `both`, `down`, `up` | which way the mirror goes; `both` alternates, without fly-back |
//! | `cfar-guard`, `cfar-training` | cells on each side | CA-CFAR |
//! | `cfar-false-alarm` | 1e-9 | probability of a false alarm |
//! | `cfar-near-margin` | 0.01 mm | what lies nearer behind the mirror is its own echo |
//! | `estimator` | name | what turns the map into steps |
//! | `seed` | | seed of the random numbers |
//! | `particles`, `modes`, `rounds` | | particle filter |
//! | `spread` | `uniform`, `gmm-raw`, `gmm-cfar` | how particles start |
//! | `mode-sigma` | 0.01 mm | standard deviation of a mode |
//! | `vigilance` | 0.001 | sensitivity ρ of the clustering |
//! | `radar-carrier`, `radar-bandwidth` | kHz | as the module says; read only |
//! | `radar-samples` | | likewise |
//! | `settle` | µs | from the end of a move to the trigger |
//! | `chirp-timeout`, `configure-timeout` | µs | for one answer of the radar module |
//! | `connect-timeout` | µs | for the module's first answer in a self-test |
//! | `retries` | | further triggers for a row whose chirp was lost |
//! | `max-lost` | rows | more make the scan a fault |
//! | `fault-hold` | µs | from a fault to the next self-test |
//! | `motion` | `auto`, `required`, `standing` | what holds without motion input ([`crate::drive`]) |
//! | `fusion` | `on`, `off` | whether earlier scans of the scene have a say ([`crate::fusion`]) |
//! | `chirp-duration` | µs | of a chirp's sweep: for what motion does to a range, and how long the mirror stands still, or mid chirp waits; 0: nothing is known of it |
//! | `motion-timeout` | µs | a motion sentence that is older says nothing any more |
//! | `home-angle` | 0.001° | shaft angle of the home switch |
//! | `speed`, `search-speed` | microsteps/s | top speed of moves; of the search for home |
//! | `acceleration` | microsteps/s² | of moves |
//! | `internal-clock` | `on`, `off` | whether to scan without the crystal |
//! | `sweep-mode` | `stop`, `continuous` | whether the mirror stops at every angle or, unless set otherwise, turns through them |
//! | `calibrated`, `calibrated-chip` | YYYYMMDD; | when the mounting was calibrated, and the CRC-32 of the number of the chip that did |
//!
//! How they become a hash and a record: [`super::record`]; how a record outlives the power: [`super::store`].

mod found;
mod slot;

use super::schedule::{MICROSTEPS_PER_TURN, SHAFT_LIMIT, Schedule};
use crate::config::{Config, ConfigError, check};
use crate::drive;
use crate::grid::BinWindow;
use crate::grid::MAX_CELLS;
use slot::Slot;
pub(crate) use slot::number;
pub use slot::{SweepMode, Sweeping, Switch, ValueText};

/// Longest time that can be set, microseconds: differences of [`super::Micros`] stay meaningful
/// with room for the retries on top.
pub const MAX_TIME: u32 = 600_000_000;

/// Waits and retries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// From the end of a move to the trigger, microseconds.
    pub settle: u32,
    /// From a trigger to the whole chirp, microseconds.
    pub chirp_timeout: u32,
    /// From a configure frame to its answer, microseconds.
    pub configure_timeout: u32,
    /// For the module's first answer in a self-test, microseconds: it may still be booting.
    pub connect_timeout: u32,
    /// Further triggers for a row whose chirp was lost.
    pub retries: u8,
    /// More lost rows than this make the scan a fault.
    pub max_lost: u16,
    /// From a fault to the next self-test, microseconds.
    pub fault_hold: u32,
    /// Duration of a chirp's sweep, microseconds.
    pub chirp_duration: u32,
    /// A motion sentence that is older says nothing any more, microseconds.
    pub motion_timeout: u32,
    /// Whether to scan from the internal oscillator: somebody knows that it is good enough.
    pub internal_clock: Switch,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            settle: 5_000,
            // 200 samples take 8.2 ms at 1 Mbaud; six times that is not a hiccup any more.
            chirp_timeout: 50_000,
            configure_timeout: 100_000,
            connect_timeout: 10_000_000,
            retries: 2,
            // A tenth of the paper's 281 rows.
            max_lost: 28,
            fault_hold: 2_000_000,
            // 200 samples at 200 kHz, as in the recordings.
            chirp_duration: 1_000,
            motion_timeout: drive::odometry::OLDEST_US,
            internal_clock: Switch::Off,
        }
    }
}

/// The mirror's motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotorConfig {
    /// Shaft angle at which the home switch closes on the slow approach, 0.001°.
    pub home_angle: i32,
    /// Top speed, microsteps/s.
    pub speed: u32,
    /// Acceleration, microsteps/s².
    pub acceleration: u32,
    /// Speed of the search for home, microsteps/s: the motor must be able to stop dead from it.
    pub search_speed: u32,
}

impl Default for MotorConfig {
    fn default() -> Self {
        Self {
            home_angle: -165_000,
            // One turn a second, reached within 20 ms.
            speed: 51_200,
            acceleration: 2_560_000,
            // 100 full steps a second: below the pull-in rate of any motor of this size.
            search_speed: 25_600,
        }
    }
}

/// When the scanner was calibrated, and which chip then belonged to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Calibrated {
    /// Year, month and day as one number: 20261122; 0: never.
    pub date: u32,
    /// CRC-32 of the chip's serial number.
    pub chip: u32,
}

impl Calibrated {
    /// Whether it may be that of the scanner with this chip.
    pub fn fits(&self, chip: u32) -> bool {
        self.date == 0 || self.chip == chip
    }
}

/// Everything that can be set.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// What a scan is.
    pub config: Config,
    /// Waits and retries.
    pub timing: Timing,
    /// The mirror's motor.
    pub motor: MotorConfig,
    /// Which way the mirror sweeps.
    pub sweeping: Sweeping,
    /// Whether the mirror stops at every angle.
    pub sweep_mode: SweepMode,
    /// What holds without motion input.
    pub motion: drive::Mode,
    /// Whether earlier scans have a say.
    pub fusion: Switch,
    /// When and where the mounting was calibrated.
    pub calibrated: Calibrated,
}

impl Settings {
    /// Every key, in the order in which `get` lists them.
    pub const KEYS: &'static [&'static str] = &[
        "plane",
        "mirror-offset",
        "mirror-echo",
        "mirror-level",
        "range-scale",
        "mount-height",
        "beamwidth",
        "first-angle",
        "angle-step",
        "angle-count",
        "sweep",
        "cfar-guard",
        "cfar-training",
        "cfar-false-alarm",
        "cfar-near-margin",
        "estimator",
        "seed",
        "particles",
        "modes",
        "spread",
        "rounds",
        "mode-sigma",
        "vigilance",
        "radar-carrier",
        "radar-bandwidth",
        "radar-samples",
        "settle",
        "chirp-timeout",
        "configure-timeout",
        "connect-timeout",
        "retries",
        "max-lost",
        "fault-hold",
        "motion",
        "fusion",
        "chirp-duration",
        "motion-timeout",
        "home-angle",
        "speed",
        "acceleration",
        "search-speed",
        "internal-clock",
        "calibrated",
        "calibrated-chip",
        "sweep-mode",
    ];

    fn slot(&mut self, key: &str) -> Option<Slot<'_>> {
        let (config, timing, motor) = (&mut self.config, &mut self.timing, &mut self.motor);
        Some(match key {
            "plane" => Slot::Plane(&mut config.mount.plane),
            "mirror-offset" => Slot::I32(&mut config.mount.mirror_offset),
            "mirror-echo" => Slot::I32(&mut config.mount.mirror_echo),
            "mirror-level" => Slot::I32(&mut config.mount.mirror_level),
            "range-scale" => Slot::I32(&mut config.mount.range_scale),
            "mount-height" => Slot::I32(&mut config.mount.mount_height),
            "beamwidth" => Slot::I32(&mut config.mount.beamwidth),
            "first-angle" => Slot::I32(&mut config.sweep.first_angle),
            "angle-step" => Slot::I32(&mut config.sweep.angle_step),
            "angle-count" => Slot::U16(&mut config.sweep.angle_count),
            "sweep" => Slot::Sweeping(&mut self.sweeping),
            "cfar-guard" => Slot::U8(&mut config.cfar.guard),
            "cfar-training" => Slot::U8(&mut config.cfar.training),
            "cfar-false-alarm" => Slot::Nano(&mut config.cfar.false_alarm),
            "cfar-near-margin" => Slot::I32(&mut config.cfar.near_margin),
            "estimator" => Slot::Estimator(&mut config.estimator),
            "seed" => Slot::U32(&mut config.seed),
            "particles" => Slot::U16(&mut config.particles.particles),
            "modes" => Slot::U8(&mut config.particles.modes),
            "spread" => Slot::Spread(&mut config.particles.spread),
            "rounds" => Slot::U8(&mut config.particles.rounds),
            "mode-sigma" => Slot::I32(&mut config.particles.mode_sigma),
            "vigilance" => Slot::U16(&mut config.particles.vigilance),
            "radar-carrier" => Slot::Module32(&mut config.radar.carrier_khz),
            "radar-bandwidth" => Slot::Module32(&mut config.radar.bandwidth_khz),
            "radar-samples" => Slot::Module16(&mut config.radar.samples),
            "settle" => Slot::U32(&mut timing.settle),
            "chirp-timeout" => Slot::U32(&mut timing.chirp_timeout),
            "configure-timeout" => Slot::U32(&mut timing.configure_timeout),
            "connect-timeout" => Slot::U32(&mut timing.connect_timeout),
            "retries" => Slot::U8(&mut timing.retries),
            "max-lost" => Slot::U16(&mut timing.max_lost),
            "fault-hold" => Slot::U32(&mut timing.fault_hold),
            "motion" => Slot::Motion(&mut self.motion),
            "fusion" => Slot::Switch(&mut self.fusion),
            "chirp-duration" => Slot::U32(&mut timing.chirp_duration),
            "motion-timeout" => Slot::U32(&mut timing.motion_timeout),
            "home-angle" => Slot::I32(&mut motor.home_angle),
            "speed" => Slot::U32(&mut motor.speed),
            "acceleration" => Slot::U32(&mut motor.acceleration),
            "search-speed" => Slot::U32(&mut motor.search_speed),
            "internal-clock" => Slot::Switch(&mut timing.internal_clock),
            "calibrated" => Slot::U32(&mut self.calibrated.date),
            "calibrated-chip" => Slot::U32(&mut self.calibrated.chip),
            "sweep-mode" => Slot::SweepMode(&mut self.sweep_mode),
            _ => return None,
        })
    }

    /// The key as it stands in [`Settings::KEYS`].
    pub fn key(text: &str) -> Option<&'static str> {
        Self::KEYS.iter().copied().find(|key| *key == text)
    }

    /// The value of `key`.
    pub fn get(&self, key: &str) -> Option<ValueText> {
        let mut copy = *self;
        copy.slot(key).map(|slot| slot.text())
    }

    /// Every value to the last bit, in the order of the keys: what a record holds.
    #[inline(never)]
    pub fn words(&self) -> [u32; Self::KEYS.len()] {
        let mut copy = *self;
        let mut words = [0; Self::KEYS.len()];
        for (word, key) in words.iter_mut().zip(Self::KEYS) {
            *word = copy.slot(key).map_or(0, |slot| slot.word());
        }
        words
    }

    /// Takes back what [`Settings::words`] gave; `None` where a value is not valid.
    pub fn from_words(words: &[u32; Self::KEYS.len()]) -> Option<Self> {
        let mut settings = Self::default();
        for (&word, key) in words.iter().zip(Self::KEYS) {
            settings.slot(key)?.restore(word)?;
        }
        settings.validate().ok()?;
        Some(settings)
    }

    /// Sets `key`; an error leaves everything as it was.
    pub fn set(&mut self, key: &'static str, value: &str) -> Result<(), ConfigError> {
        let mut next = *self;
        let expected = "a key of the configuration";
        let slot = next.slot(key).ok_or(ConfigError {
            field: key,
            expected,
        })?;
        slot.write(key, value)?;
        next.validate()?;
        *self = next;
        Ok(())
    }

    /// Checks every field by itself and that shaft and map hold such a scan.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.config.validate()?;
        Schedule::new(&self.config)?;
        self.check_map()?;
        self.check_timing()?;
        self.check_motor()
    }

    /// The map must hold the scan that the radar module's present settings make.
    fn check_map(&self) -> Result<(), ConfigError> {
        let window = BinWindow::of_scan(&self.config);
        let cells = usize::from(window.count) * usize::from(self.config.sweep.angle_count);
        check(
            window.count >= 8,
            "radar-bandwidth",
            "at least 8 range bins beyond the mirror",
        )?;
        check(
            cells <= MAX_CELLS,
            "angle-count",
            "a map of 65536 cells at most",
        )
    }

    fn check_timing(&self) -> Result<(), ConfigError> {
        let timing = &self.timing;
        let times = [
            ("settle", timing.settle),
            ("chirp-timeout", timing.chirp_timeout),
            ("configure-timeout", timing.configure_timeout),
            ("connect-timeout", timing.connect_timeout),
            ("fault-hold", timing.fault_hold),
            ("motion-timeout", timing.motion_timeout),
        ];
        for (key, time) in times {
            check(
                (100..=MAX_TIME).contains(&time),
                key,
                "100 to 600000000 microseconds",
            )?;
        }
        check(
            timing.chirp_duration <= 1_000_000,
            "chirp-duration",
            "0 to 1000000 microseconds",
        )?;
        check(timing.retries <= 10, "retries", "0 to 10")
    }

    fn check_motor(&self) -> Result<(), ConfigError> {
        let motor = &self.motor;
        let turn = MICROSTEPS_PER_TURN as u32;
        check(
            (-SHAFT_LIMIT..=SHAFT_LIMIT).contains(&motor.home_angle),
            "home-angle",
            "-170000 to 170000",
        )?;
        check(
            (100..=2 * turn).contains(&motor.speed),
            "speed",
            "100 to 102400 microsteps/s",
        )?;
        check(
            (800..=turn).contains(&motor.search_speed),
            "search-speed",
            "800 to 51200 microsteps/s",
        )?;
        check(
            (1_000..=100_000_000).contains(&motor.acceleration),
            "acceleration",
            "1000 to 100000000 microsteps/s2",
        )
    }
}

#[cfg(test)]
mod tests;
