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
//! | `module` | `pstr`, `sirad`, `bgt60` | which radar module hangs on the scanner |
//! | `module-bandwidth` | kHz | swept bandwidth that the module is to be set to; 0: as it is |
//! | `module-samples` | | samples per chirp, likewise |
//! | `link-rate` | baud | fastest rate that the wire may be raised to: 1000000, 2000000 or 3000000 |
//! | `trigger-pin` | `on`, `off` | whether chirps begin at an edge of TRIG, where the module can |
//! | `driver` | `step-dir`, `tmc2209` | whether the motor's driver is told by STEP and DIR only, or set up and read over its wire ([`super::tmc2209`]) |
//! | `microsteps-per-turn` | | the driver's own; every other setting counts 51,200 a turn |
//! | `enable-level`, `stall-level` | `high`, `low` | level of EN that switches the driver on; level of STALL that is a stall |
//! | `pulse-width` | µs | STEP is high, and low, for so long at least |
//! | `enable-wake` | µs | from EN to the first pulse |
//! | `motor-current` | mA rms | of a phase, with `tmc2209` |
//! | `stall-threshold` | | SGTHRS of the `tmc2209`; 0: it reports no stalls |
//! | `home-check` | `on`, `off` | whether the mirror looks for the home switch again behind every sweep that ends on its side |
//! | `encoder` | `none`, `as5600` | which absolute encoder is on the mirror's shaft ([`super::encoder`]) |
//! | `encoder-home` | 0.001° | what it reads at home, as calibration has found it; -1: not known |
//! | `calibrated`, `calibrated-chip` | YYYYMMDD; | when the mounting was calibrated, and the CRC-32 of the number of the chip that did |
//!
//! How they become a hash and a record: [`super::record`]; how a record outlives the power: [`super::store`].

mod found;
mod motor;
mod slot;

use super::schedule::Schedule;
use crate::config::{Config, ConfigError, SAMPLES, check};
use crate::drive;
use crate::grid::BinWindow;
use crate::grid::MAX_CELLS;
use crate::radar::module::Wish;
pub use motor::{Driver, DriverConfig, Encoder, EncoderConfig, FINEST, MotorConfig, WireLevel};
use slot::Slot;
pub(crate) use slot::number;
pub use slot::{SweepMode, Sweeping, Switch, ValueText};

/// Longest time that can be set, microseconds: differences of [`super::Micros`] stay meaningful
/// with room for the retries on top.
pub const MAX_TIME: u32 = 600_000_000;

/// More bandwidth than any module within the radar bands has, kHz.
const MAX_BANDWIDTH_KHZ: u32 = 100_000_000;
/// A turn, 0.001°.
const TURN: u32 = 360_000;
/// Fewest microsteps a turn in passing: one of them is then four of 51,200, and no row's place is
/// passed by more than the three at which its trigger still counts.
const LEAST_IN_PASSING: u32 = 12_800;

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
    /// Which radar module, and what it is to be set to.
    pub module: Wish,
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
        "module",
        "module-bandwidth",
        "module-samples",
        "link-rate",
        "trigger-pin",
        "driver",
        "microsteps-per-turn",
        "enable-level",
        "stall-level",
        "pulse-width",
        "enable-wake",
        "motor-current",
        "stall-threshold",
        "home-check",
        "encoder",
        "encoder-home",
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
            "module" => Slot::Module(&mut self.module.kind),
            "module-bandwidth" => Slot::U32(&mut self.module.bandwidth_khz),
            "module-samples" => Slot::U16(&mut self.module.samples),
            "link-rate" => Slot::U32(&mut self.module.baud),
            "trigger-pin" => Slot::Present(&mut self.module.pin),
            "driver" => Slot::Driver(&mut motor.driver.kind),
            "microsteps-per-turn" => Slot::U16(&mut motor.driver.microsteps),
            "enable-level" => Slot::Level(&mut motor.driver.enable_level),
            "stall-level" => Slot::Level(&mut motor.driver.stall_level),
            "pulse-width" => Slot::U8(&mut motor.driver.pulse_width),
            "enable-wake" => Slot::U16(&mut motor.driver.enable_wake),
            "motor-current" => Slot::U16(&mut motor.driver.current),
            "stall-threshold" => Slot::U8(&mut motor.driver.stall_threshold),
            "home-check" => Slot::Present(&mut motor.home_check),
            "encoder" => Slot::Encoder(&mut motor.encoder.kind),
            "encoder-home" => Slot::I32(&mut motor.encoder.home),
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
        self.check_module()?;
        self.motor.validate()?;
        check(
            !self.motor.home_check || self.sweeping != Sweeping::Forward,
            "home-check",
            "off with sweep down, which never ends on the switch's side",
        )?;
        self.check_microsteps()
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

    /// Rows must not stand closer together than the driver's own microsteps; and a sweep that does not
    /// stop looks for each row's place within three microsteps of 51,200.
    fn check_microsteps(&self) -> Result<(), ConfigError> {
        const KEY: &str = "microsteps-per-turn";
        let microsteps = u32::from(self.motor.driver.microsteps);
        if microsteps == u32::from(FINEST) {
            return Ok(());
        }
        let step = self.config.sweep.angle_step.unsigned_abs();
        check(
            microsteps.saturating_mul(step) >= TURN,
            KEY,
            "microsteps that are no larger than angle-step",
        )?;
        check(
            self.sweep_mode == SweepMode::Stop || microsteps >= LEAST_IN_PASSING,
            KEY,
            "12800 or more, or sweep-mode stop",
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

    fn check_module(&self) -> Result<(), ConfigError> {
        let Wish {
            kind,
            bandwidth_khz,
            samples,
            baud,
            ..
        } = self.module;
        let (configure, chirp) = kind.patience_us();
        check(
            self.timing.configure_timeout >= configure,
            "configure-timeout",
            "400000 or more with a SiRad",
        )?;
        check(
            self.timing.chirp_timeout >= chirp,
            "chirp-timeout",
            "100000 or more with a SiRad",
        )?;
        check(
            bandwidth_khz <= MAX_BANDWIDTH_KHZ,
            "module-bandwidth",
            "0 to 100000000 kHz",
        )?;
        check(
            samples == 0 || SAMPLES.contains(&samples),
            "module-samples",
            "0, or 16 to 256",
        )?;
        check(
            matches!(baud, 1_000_000 | 2_000_000 | 3_000_000),
            "link-rate",
            "1000000, 2000000 or 3000000",
        )
    }
}

#[cfg(test)]
mod tests;
