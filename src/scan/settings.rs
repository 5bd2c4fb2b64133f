//! Everything that a command may read or set, by key.
//!
//! | key | unit | meaning |
//! |---|---|---|
//! | `plane` | `depth`, `height` | plane that the mirror sweeps |
//! | `mirror-offset`, `mount-height` | 0.01 mm | how the scanner is mounted |
//! | `mirror-echo` | 0.01 mm | range of the mirror's own echo when it was calibrated; 0: never |
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
//! | `chirp-duration` | µs | of a chirp's sweep, for what motion does to a range |
//! | `home-angle` | 0.001° | shaft angle of the home switch |
//! | `speed`, `search-speed` | microsteps/s | top speed of moves; of the search for home |
//! | `acceleration` | microsteps/s² | of moves |

use super::schedule::{MICROSTEPS_PER_TURN, SHAFT_LIMIT, Schedule};
use crate::config::{Config, ConfigError, EstimatorKind, Plane, Spread, check};
use crate::drive;
use crate::grid::BinWindow;
use crate::grid::MAX_CELLS;

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

/// Which way the mirror sweeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sweeping {
    /// The first scan from the first row to the last, the next one back, and so on.
    #[default]
    Both,
    /// Always from the first row to the last.
    Forward,
    /// Always from the last row to the first.
    Backward,
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
    /// What holds without motion input.
    pub motion: drive::Mode,
    /// Whether earlier scans have a say.
    pub fusion: Switch,
}

/// Something that is on or off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Switch {
    /// It works.
    #[default]
    On,
    /// It does not.
    Off,
}

/// A value that is one of a few words.
trait Word: Copy + PartialEq + 'static {
    const WORDS: &'static [(&'static str, Self)];
    const EXPECTED: &'static str;

    fn word(self) -> &'static str {
        let found = Self::WORDS.iter().find(|(_, value)| *value == self);
        found.map_or("", |(word, _)| word)
    }

    fn read(text: &str) -> Option<Self> {
        let found = Self::WORDS.iter().find(|(word, _)| *word == text);
        found.map(|(_, value)| *value)
    }
}

impl Word for Plane {
    const WORDS: &'static [(&'static str, Self)] =
        &[("depth", Plane::Depth), ("height", Plane::Height)];
    const EXPECTED: &'static str = "depth or height";
}

impl Word for Spread {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("uniform", Spread::Uniform),
        ("gmm-raw", Spread::GmmRaw),
        ("gmm-cfar", Spread::GmmCfar),
    ];
    const EXPECTED: &'static str = "uniform or gmm-raw or gmm-cfar";
}

impl Word for Sweeping {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("both", Sweeping::Both),
        ("down", Sweeping::Forward),
        ("up", Sweeping::Backward),
    ];
    const EXPECTED: &'static str = "both or down or up";
}

impl Word for drive::Mode {
    const WORDS: &'static [(&'static str, Self)] = &[
        ("auto", drive::Mode::Auto),
        ("required", drive::Mode::Required),
        ("standing", drive::Mode::Standing),
    ];
    const EXPECTED: &'static str = "auto or required or standing";
}

impl Word for Switch {
    const WORDS: &'static [(&'static str, Self)] = &[("on", Switch::On), ("off", Switch::Off)];
    const EXPECTED: &'static str = "on or off";
}

/// One setting while it is read or written.
enum Slot<'a> {
    U8(&'a mut u8),
    U16(&'a mut u16),
    U32(&'a mut u32),
    I32(&'a mut i32),
    /// A probability in 1e-9.
    Nano(&'a mut f32),
    Plane(&'a mut Plane),
    Spread(&'a mut Spread),
    Sweeping(&'a mut Sweeping),
    Motion(&'a mut drive::Mode),
    Switch(&'a mut Switch),
    Estimator(&'a mut EstimatorKind),
    /// What the radar module says.
    ReadOnly(u32),
}

/// A value as text: a word or a number.
pub type ValueText = heapless::String<16>;

/// Writes a number digit by digit, without `core::fmt`.
#[inline(never)]
pub(crate) fn number(value: i64) -> ValueText {
    let mut text = ValueText::new();
    if value < 0 {
        let _ = text.push('-');
    }
    let mut rest = value.unsigned_abs();
    let mut digits = heapless::Vec::<u8, 20>::new();
    loop {
        let _ = digits.push(b'0' + (rest % 10) as u8);
        rest /= 10;
        if rest == 0 {
            break;
        }
    }
    for &digit in digits.iter().rev() {
        let _ = text.push(char::from(digit));
    }
    text
}

fn word(text: &str) -> ValueText {
    let mut value = ValueText::new();
    let _ = value.push_str(text);
    value
}

fn write_number<T: TryFrom<i64>>(
    slot: &mut T,
    field: &'static str,
    text: &str,
) -> Result<(), ConfigError> {
    let expected = "a whole number within its type";
    let value: i64 = text.parse().map_err(|_| ConfigError { field, expected })?;
    *slot = T::try_from(value).map_err(|_| ConfigError { field, expected })?;
    Ok(())
}

fn write_word<T: Word>(slot: &mut T, field: &'static str, text: &str) -> Result<(), ConfigError> {
    let expected = T::EXPECTED;
    *slot = T::read(text).ok_or(ConfigError { field, expected })?;
    Ok(())
}

impl Slot<'_> {
    fn text(&self) -> ValueText {
        match self {
            Slot::U8(v) => number(i64::from(**v)),
            Slot::U16(v) => number(i64::from(**v)),
            Slot::U32(v) => number(i64::from(**v)),
            Slot::I32(v) => number(i64::from(**v)),
            Slot::Nano(v) => number(i64::from((**v * 1e9 + 0.5) as u32)),
            Slot::Plane(v) => word(v.word()),
            Slot::Spread(v) => word(v.word()),
            Slot::Sweeping(v) => word(v.word()),
            Slot::Motion(v) => word(v.word()),
            Slot::Switch(v) => word(v.word()),
            Slot::Estimator(v) => word(v.as_str()),
            Slot::ReadOnly(v) => number(i64::from(*v)),
        }
    }

    fn write(self, field: &'static str, text: &str) -> Result<(), ConfigError> {
        match self {
            Slot::U8(v) => write_number(v, field, text),
            Slot::U16(v) => write_number(v, field, text),
            Slot::U32(v) => write_number(v, field, text),
            Slot::I32(v) => write_number(v, field, text),
            Slot::Nano(v) => {
                let mut nano = 0_u32;
                write_number(&mut nano, field, text)?;
                *v = nano as f32 * 1e-9;
                Ok(())
            }
            Slot::Plane(v) => write_word(v, field, text),
            Slot::Spread(v) => write_word(v, field, text),
            Slot::Sweeping(v) => write_word(v, field, text),
            Slot::Motion(v) => write_word(v, field, text),
            Slot::Switch(v) => write_word(v, field, text),
            Slot::Estimator(v) => {
                let expected = "the name of an estimator";
                *v = EstimatorKind::from_name(text).ok_or(ConfigError { field, expected })?;
                Ok(())
            }
            Slot::ReadOnly(_) => Err(ConfigError {
                field,
                expected: "nothing: the radar module sets it",
            }),
        }
    }
}

impl Settings {
    /// Every key, in the order in which `get` lists them.
    pub const KEYS: &'static [&'static str] = &[
        "plane",
        "mirror-offset",
        "mirror-echo",
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
        "home-angle",
        "speed",
        "acceleration",
        "search-speed",
    ];

    fn slot(&mut self, key: &str) -> Option<Slot<'_>> {
        let (config, timing, motor) = (&mut self.config, &mut self.timing, &mut self.motor);
        Some(match key {
            "plane" => Slot::Plane(&mut config.mount.plane),
            "mirror-offset" => Slot::I32(&mut config.mount.mirror_offset),
            "mirror-echo" => Slot::I32(&mut config.mount.mirror_echo),
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
            "radar-carrier" => Slot::ReadOnly(config.radar.carrier_khz),
            "radar-bandwidth" => Slot::ReadOnly(config.radar.bandwidth_khz),
            "radar-samples" => Slot::ReadOnly(u32::from(config.radar.samples)),
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
            "home-angle" => Slot::I32(&mut motor.home_angle),
            "speed" => Slot::U32(&mut motor.speed),
            "acceleration" => Slot::U32(&mut motor.acceleration),
            "search-speed" => Slot::U32(&mut motor.search_speed),
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
        ];
        for (key, time) in times {
            check(
                (100..=MAX_TIME).contains(&time),
                key,
                "100 to 600000000 microseconds",
            )?;
        }
        check(
            (1..=1_000_000).contains(&timing.chirp_duration),
            "chirp-duration",
            "1 to 1000000 microseconds",
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
mod tests {
    use super::*;

    #[test]
    fn every_key_reads_back_what_it_says() {
        let mut settings = Settings::default();
        for &key in Settings::KEYS {
            let text = settings.get(key).unwrap();
            let before = settings;
            match settings.set(key, &text) {
                Ok(()) => assert_eq!(settings.get(key).unwrap(), text, "{key}"),
                Err(error) => assert!(key.starts_with("radar-"), "{error}"),
            }
            if key != "cfar-false-alarm" {
                assert_eq!(before, settings, "{key}");
            }
            let error = settings.set(key, "x7").unwrap_err();
            assert_eq!(error.field, key);
        }
        assert_eq!(settings.get("nonsense"), None);
    }

    fn bins(settings: &Settings) -> u16 {
        let config = &settings.config;
        BinWindow::new(&config.radar, &config.mount, &config.cfar).count
    }

    #[test]
    fn every_grid_of_as_many_cells_as_the_map_has_is_accepted() {
        let mut settings = Settings::default();
        let whole = MAX_CELLS / usize::from(bins(&settings));
        settings.set("angle-count", &whole.to_string()).unwrap();
        // More rows leave out the farthest bins, as long as 2 m are left.
        let most = (whole..).find(|rows| {
            let rows = settings.set("angle-count", &rows.to_string());
            rows.is_err()
        });
        let most = most.unwrap();
        assert!((whole + 50..2 * whole).contains(&most), "{most}");
        let refused = settings.set("angle-count", &most.to_string());
        assert_eq!(refused.unwrap_err().field, "angle-count");
        // 321 rows of 190 bins.
        settings.set("cfar-near-margin", "40000").unwrap();
        settings.set("angle-count", "321").unwrap();
        assert!(bins(&settings) >= 190, "{}", bins(&settings));
        // The other extreme: 327 degrees, eight bins to a row.
        settings.config.radar.samples = 20;
        settings.config.radar.bandwidth_khz = 2_342_000;
        assert_eq!(bins(&settings), 8);
        settings.set("first-angle", "-164000").unwrap();
        settings.set("angle-step", "40").unwrap();
        settings.set("angle-count", "8192").unwrap();
    }

    #[test]
    fn a_refused_value_changes_nothing() {
        let mut settings = Settings::default();
        let before = settings;
        for (key, value, field) in [
            ("angle-count", "2", "angle-count"),
            ("angle-count", "8193", "angle-count"),
            ("angle-count", "70000", "angle-count"),
            ("first-angle", "169000", "first-angle"),
            ("settle", "5", "settle"),
            ("seed", "-1", "seed"),
            ("plane", "sideways", "plane"),
            ("chirp-timeout", "600000001", "chirp-timeout"),
        ] {
            assert_eq!(settings.set(key, value).unwrap_err().field, field);
            assert_eq!(settings, before);
        }
        settings.set("seed", "4294967295").unwrap();
        settings.set("first-angle", "-15000").unwrap();
        assert_eq!(settings.config.sweep.first_angle, -15_000);
    }
}
