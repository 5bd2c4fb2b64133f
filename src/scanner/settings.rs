//! All settings that commands read or set, by key.
//!
//! Each setting is one row where its structure is declared with `settings!` ([`crate::setting`]): here, in
//! [`crate::config`], [`crate::signal::radar::module`], `motor` and `guard`. `docs/user/hardware.md` has all rows as
//! one table. [`super::record`] turns them into a hash and a record; [`super::store`] saves a record in flash.

mod found;
mod guard;
mod motor;
mod words;

use super::planes::check_planes;
use crate::config::{Config, ConfigError, SAMPLES, check};
use crate::motion;
use crate::schedule::SHAFT_LIMIT;
pub use crate::setting::ValueText;
pub(crate) use crate::setting::number;
use crate::setting::{SettingRow, Value, settings};
use crate::signal::grid::BinWindow;
use crate::signal::grid::MAX_CELLS;
use crate::signal::radar::module::RequestedSettings;
pub use guard::GuardConfig;
pub use motor::{
    Driver, DriverConfig, Encoder, EncoderConfig, MAX_MICROSTEPS, MotorConfig, WireLevel,
};
pub use words::{SweepMode, Sweeping, Switch};

/// Largest maximum of a setting that is a time, µs: differences of [`super::Micros`] stay unambiguous, with room
/// for the retries.
pub const MAX_TIME: u32 = 600_000_000;
// The limits in the table are literals, since messages are made of them.
const _: () = assert!(MAX_TIME == 600_000_000 && SHAFT_LIMIT == 170_000);
// A stale input stays stale.
const _: () = assert!(MAX_TIME < crate::time::MAX_AGE_US);

/// One turn of the shaft, 0.001°.
const TURN: u32 = 360_000;
/// Minimum of `microsteps-per-turn` in continuous mode: one of these is then four of 51,200 a turn, so that no
/// row's position is passed by more than the three at which its trigger is still in time.
const MIN_STEPS_IN_PASSING: u32 = 12_800;

settings! {
    /// Waits and retries.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct Timing
    parts {}
    rows {
        /// Settling time before the trigger.
        settle: u32 = 5_000, "settle" "us" [100 to 600_000_000] Operation;
        // 200 samples take 8.2 ms at 1 Mbaud; six times that is more than a delay of the scanner's own.
        /// Timeout of a chirp.
        chirp_timeout: u32 = 50_000, "chirp-timeout" "us" [100 to 600_000_000] Operation;
        /// Timeout of the radar module's answer to a configure frame.
        configure_timeout: u32 = 100_000, "configure-timeout" "us" [100 to 600_000_000] Operation;
        /// Timeout of the module's first answer in a self-test, which includes its boot.
        connect_timeout: u32 = 10_000_000, "connect-timeout" "us" [100 to 600_000_000] Operation;
        /// Maximum number of retries of a row.
        retries: u8 = 2, "retries" "triggers" [0 to 10] Operation;
        // A tenth of the paper's 281 rows.
        /// Maximum number of lost rows of a scan; more are a fault.
        max_lost: u16 = 28, "max-lost" "rows" [0 to 65_535] Operation;
        /// Delay from a fault to the next self-test.
        fault_hold: u32 = 2_000_000, "fault-hold" "us" [100 to 600_000_000] Operation;
        // 200 samples at 200 kHz, as in the recordings.
        /// Duration of a chirp; sets the range shift by motion and the time for which the mirror stands; 0: unknown.
        chirp_duration: u32 = 1_000, "chirp-duration" "us" [0 to 1_000_000] Answer;
        /// Age beyond which a motion sentence is stale.
        motion_timeout: u32 = motion::odometry::MAX_AGE_US, "motion-timeout" "us" [100 to 600_000_000] Answer;
        /// Whether to scan from the internal oscillator if the crystal fails.
        internal_clock: Switch = Switch::Off, "internal-clock" "" [] Operation;
    }
    also {}
}

settings! {
    /// Date of the calibration, and the chip that it belongs to.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct Calibrated
    parts {}
    rows {
        /// Year, month and day of the mounting's calibration as one number, YYYYMMDD; 0: never.
        date: u32 = 0, "calibrated" "" [] Operation;
        /// CRC-32 of the number of the chip that calibrated it.
        chip: u32 = 0, "calibrated-chip" "" [] Operation;
    }
    also {}
}

impl Calibrated {
    /// Whether the calibration may belong to the scanner whose chip's number has the CRC-32 `chip`; always
    /// without a calibration.
    pub fn fits(&self, chip: u32) -> bool {
        self.date == 0 || self.chip == chip
    }
}

settings! {
    /// All settings.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Settings
    parts {
        /// Configuration of a scan.
        config: Config;
        /// Waits and retries.
        timing: Timing;
        /// The mirror's motor.
        motor: MotorConfig;
        /// When and where the mounting was calibrated.
        calibrated: Calibrated;
        /// Type of the radar module, and its requested settings.
        module: RequestedSettings;
        /// The guard's sweep.
        guard: GuardConfig;
    }
    rows {
        /// Direction of the mirror's sweeps; `both` alternates, without fly-back.
        sweeping: Sweeping = Sweeping::Both, "sweep" "" [] Answer;
        /// Whether the mirror stops at every angle or turns continuously.
        sweep_mode: SweepMode = SweepMode::Continuous, "sweep-mode" "" [] Operation;
        /// Mode of the motion input (docs/design/motion.md).
        motion: motion::Mode = motion::Mode::Auto, "motion" "" [] Answer;
        /// Whether the evidence of earlier scans of the scene is used (docs/design/motion.md).
        fusion: Switch = Switch::On, "fusion" "" [] Answer;
    }
    also {}
}

impl Settings {
    /// Returns the key `text` as it stands in [`Settings::KEYS`]; `None` if no setting has it.
    pub fn key(text: &str) -> Option<&'static str> {
        Self::KEYS.iter().copied().find(|key| *key == text)
    }

    /// Returns the value of setting `key` as text; `None` if there is no such setting.
    pub fn get(&self, key: &str) -> Option<ValueText> {
        let mut found = None;
        self.see(&mut |row, value| {
            if row.key == key {
                found = Some(value.text());
            }
        });
        found
    }

    /// Returns the values of all settings in the order of the keys, each as a 32-bit word without rounding, as a
    /// stored record has them.
    pub fn words(&self) -> [u32; Self::KEYS.len()] {
        let mut words = [0; Self::KEYS.len()];
        let mut places = words.iter_mut();
        self.see(&mut |_, value| {
            if let Some(place) = places.next() {
                *place = value.word();
            }
        });
        words
    }

    /// Restores settings from [`Settings::words`]; `None` if a value is not valid.
    pub fn from_words(words: &[u32; Self::KEYS.len()]) -> Option<Self> {
        let mut settings = Self::default();
        let mut words = words.iter();
        let mut valid = true;
        settings.each(&mut |_, value: &mut dyn Value| {
            valid &= words
                .next()
                .is_some_and(|&word| value.restore(word).is_some());
        });
        (valid && settings.validate().is_ok()).then_some(settings)
    }

    /// Sets the setting `key` to `value`; on an error all settings keep their values.
    pub fn set(&mut self, key: &'static str, value: &str) -> Result<(), ConfigError> {
        let mut next = *self;
        let mut read = Err(ConfigError {
            field: key,
            expected: "a key of the configuration",
        });
        next.each(&mut |row: &SettingRow, place: &mut dyn Value| {
            if row.key == key {
                read = row.read(place, value);
            }
        });
        read?;
        next.validate()?;
        *self = next;
        Ok(())
    }

    /// Checks the limits of every setting, and that shaft, map, module, motor and guard permit these settings
    /// together.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.limits()?;
        self.config.validate()?;
        check_planes(&self.config)?;
        self.check_map()?;
        self.check_module()?;
        self.motor.validate()?;
        self.guard.validate()?;
        check(
            !self.motor.home_check || self.sweeping != Sweeping::Forward,
            "home-check",
            "off with sweep down, which never ends on the switch's side",
        )?;
        self.check_microsteps()
    }

    /// Returns the time for which the radar module captures a row, that of all its chirps, µs; 0: unknown.
    pub fn capture_us(&self) -> u32 {
        let chirps = u32::from(self.module.chirps);
        self.timing.chirp_duration.saturating_mul(chirps)
    }

    /// Returns the timeout of a row's samples, µs: `chirp-timeout`, and the time of the chirps after the first.
    pub fn row_timeout_us(&self) -> u32 {
        let more = self.capture_us().saturating_sub(self.timing.chirp_duration);
        self.timing.chirp_timeout.saturating_add(more).min(MAX_TIME)
    }

    /// Checks that the map has room for a scan with the radar module's current samples and bandwidth.
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

    /// Checks that rows are not closer together than the driver's own microsteps, and that in continuous mode one
    /// of these is within the tolerance of a row's position, three microsteps of 51,200 a turn.
    fn check_microsteps(&self) -> Result<(), ConfigError> {
        const KEY: &str = "microsteps-per-turn";
        let microsteps = u32::from(self.motor.driver.microsteps);
        if microsteps == u32::from(MAX_MICROSTEPS) {
            return Ok(());
        }
        let step = self.config.sweep.angle_step.unsigned_abs();
        check(
            microsteps.saturating_mul(step) >= TURN,
            KEY,
            "a microstep of at most angle-step",
        )?;
        check(
            self.sweep_mode == SweepMode::Stop || microsteps >= MIN_STEPS_IN_PASSING,
            KEY,
            "12800 or more, or sweep-mode stop",
        )
    }

    fn check_module(&self) -> Result<(), ConfigError> {
        let RequestedSettings {
            kind,
            samples,
            baud,
            ..
        } = self.module;
        let (configure, chirp) = kind.min_timeouts_us();
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
            self.module.chirps_fit(),
            "chirps-per-row",
            "1: this module's driver cannot add chirps",
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
