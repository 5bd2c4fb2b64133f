//! The mirror's motor and its driver, and which of their values fit together.

use crate::config::{ConfigError, check};
use crate::scan::ramp::Ramp;
use crate::scan::schedule::{MICROSTEPS_PER_TURN, SHAFT_LIMIT};

/// What the motor's driver is told, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Driver {
    /// Pulses and direction only, whatever it is.
    #[default]
    StepDir,
    /// Besides, a TMC2209 is set up and read over its wire ([`crate::scan::tmc2209`]).
    Tmc2209,
}

/// Level of a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireLevel {
    /// Ground.
    Low,
    /// 3.3 V.
    High,
}

/// The absolute encoder on the mirror's shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoder {
    /// There is none.
    #[default]
    None,
    /// An AS5600 ([`crate::scan::encoder::as5600`]).
    As5600,
}

/// What is known of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncoderConfig {
    /// Which one it is.
    pub kind: Encoder,
    /// What it reads at home, 0.001°; negative: not known.
    pub home: i32,
}

impl Default for EncoderConfig {
    fn default() -> Self {
        Self {
            kind: Encoder::None,
            home: -1,
        }
    }
}

/// The driver between board and motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriverConfig {
    /// What it is.
    pub kind: Driver,
    /// Level of EN that switches it on.
    pub enable_level: WireLevel,
    /// Level of STALL that is a stall.
    pub stall_level: WireLevel,
    /// STEP is high, and low, for so long at least, microseconds.
    pub pulse_width: u8,
    /// Its threshold of a stall, SGTHRS; 0: none is reported.
    pub stall_threshold: u8,
    /// Its own microsteps of one turn.
    pub microsteps: u16,
    /// Current of a phase, mA rms.
    pub current: u16,
    /// From EN to the first pulse, microseconds.
    pub enable_wake: u16,
}

/// Most microsteps a turn that a driver may have: those that all positions are counted in.
pub const FINEST: u16 = MICROSTEPS_PER_TURN as u16;
const _: () = assert!(FINEST as i32 == MICROSTEPS_PER_TURN);

/// Full steps of a turn: a motor of 1.8°.
const FULL_STEPS: u16 = 200;

impl DriverConfig {
    /// Microsteps a turn are a multiple of it, so that a microstep is a ratio of small numbers.
    const GRAIN: u16 = 100;

    /// How many of its own microsteps are how many of [`MICROSTEPS_PER_TURN`], exactly: both so small
    /// that some turns fit 32 bits.
    pub fn ratio(&self) -> (i32, i32) {
        let own = i32::from(self.microsteps / Self::GRAIN);
        (own, MICROSTEPS_PER_TURN / i32::from(Self::GRAIN))
    }

    /// Clocks for which the interrupt that began a pulse waits before it ends it; the interval to the next
    /// pulse is programmed so much shorter. STEP is high for some clocks by itself: what computes that
    /// interval has a division of 14 clocks (PM0214, 3.10) and some ten other instructions at least.
    pub fn held_clocks(&self, core_hz: u32) -> u32 {
        const COMPUTING: u32 = 24;
        (u32::from(self.pulse_width) * (core_hz / MILLION)).saturating_sub(COMPUTING)
    }

    fn validate(&self) -> Result<(), ConfigError> {
        /// An interrupt waits for the pulse to end, and the report port's next byte for the interrupt:
        /// 87 µs at most.
        const WIDEST: u8 = 50;
        /// Longest time to wake, µs: such drivers take some ms (DRV8825, sleep: 1.7 ms), and homing's
        /// deadline has a second to spare.
        const LONGEST_WAKE: u16 = 60_000;
        /// Currents that a TMC2209 can be set to with 0.11 Ω, mA rms ([`crate::scan::tmc2209`]).
        const CURRENT: core::ops::RangeInclusive<u16> = 100..=1_767;
        let microsteps = self.microsteps;
        check(
            (FULL_STEPS..=FINEST).contains(&microsteps) && microsteps.is_multiple_of(Self::GRAIN),
            "microsteps-per-turn",
            "a multiple of 100 from 200 to 51200",
        )?;
        check(
            self.kind == Driver::StepDir || self.halvings().is_some(),
            "microsteps-per-turn",
            "51200, or its half, ... down to 200, with tmc2209",
        )?;
        check(
            (1..=WIDEST).contains(&self.pulse_width),
            "pulse-width",
            "1 to 50 microseconds",
        )?;
        check(
            self.enable_wake <= LONGEST_WAKE,
            "enable-wake",
            "0 to 60000 microseconds",
        )?;
        check(
            CURRENT.contains(&self.current),
            "motor-current",
            "100 to 1767 mA rms",
        )
    }

    /// How often 256 microsteps of a full step are halved to come to its own; `None` where they never do.
    pub fn halvings(&self) -> Option<u32> {
        let times = (FINEST / self.microsteps.max(1)).trailing_zeros();
        (FINEST >> times == self.microsteps).then_some(times)
    }
}

impl Default for DriverConfig {
    fn default() -> Self {
        Self {
            kind: Driver::StepDir,
            enable_level: WireLevel::Low,
            stall_level: WireLevel::High,
            // A DRV8825 needs 1.9 µs, an A4988 1 µs, a TMC2209 0.1 µs (their data sheets).
            pulse_width: 2,
            stall_threshold: 0,
            microsteps: FINEST,
            // Half of what motors of this size (NEMA 14 and 17) are made for.
            current: 600,
            // What an A4988 takes to wake from sleep (data sheet); a TMC2209 is waited for longer.
            enable_wake: 1_000,
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
    /// Whether the home switch is looked for again at the end of every sweep that ends on its side.
    pub home_check: bool,
    /// What drives it.
    pub driver: DriverConfig,
    /// What sees its shaft.
    pub encoder: EncoderConfig,
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
            // Not every mounting has the switch near the sector.
            home_check: false,
            driver: DriverConfig::default(),
            encoder: EncoderConfig::default(),
        }
    }
}

impl MotorConfig {
    /// Checks every field by itself, and pulses against speeds.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let turn = MICROSTEPS_PER_TURN as u32;
        check(
            (-SHAFT_LIMIT..=SHAFT_LIMIT).contains(&self.home_angle),
            "home-angle",
            "-170000 to 170000",
        )?;
        check(
            (100..=2 * turn).contains(&self.speed),
            "speed",
            "100 to 102400 microsteps/s",
        )?;
        check(
            (800..=turn).contains(&self.search_speed),
            "search-speed",
            "800 to 51200 microsteps/s",
        )?;
        check(
            (1_000..=100_000_000).contains(&self.acceleration),
            "acceleration",
            "1000 to 100000000 microsteps/s2",
        )?;
        self.driver.validate()?;
        check(
            (-1..360_000).contains(&self.encoder.home),
            "encoder-home",
            "0 to 359999, or -1",
        )?;
        check(
            self.busiest() <= MILLION,
            "pulse-width",
            "half of a step at top speed, or less",
        )
    }

    /// How moves between rows are made.
    pub fn ramp(&self) -> Ramp {
        Ramp {
            speed: self.speed,
            acceleration: self.acceleration,
        }
    }

    /// By when a look at the home switch has ended, microseconds from its beginning: a turn, which is more
    /// than any way there, and two slow approaches over 2° each, with the way back between them.
    pub fn cross_bound_us(&self) -> u32 {
        /// Microsteps of two degrees.
        const TWO_DEGREES: u32 = MICROSTEPS_PER_TURN as u32 / 180;
        let fast = self.ramp().bound_us(MICROSTEPS_PER_TURN as u32);
        let slow = TWO_DEGREES.saturating_mul(MILLION) / (self.search_speed / 8).max(1);
        let back = self.ramp().bound_us(TWO_DEGREES);
        fast.saturating_add(2 * slow).saturating_add(back)
    }

    /// How long STEP is high and low in a second at top speed where both are as short as may be,
    /// microseconds.
    fn busiest(&self) -> u32 {
        let (own, of) = self.driver.ratio();
        let fastest = self.speed.max(self.search_speed);
        let steps = fastest.saturating_mul(own as u32).div_ceil(of as u32);
        steps.saturating_mul(2 * u32::from(self.driver.pulse_width))
    }
}

/// Microseconds of a second.
const MILLION: u32 = 1_000_000;
