//! Settings of the mirror's motor, its driver and its encoder, and checks of their combinations.

use crate::config::{ConfigError, check};
use crate::scanner::ramp::Ramp;
use crate::schedule::{MICROSTEPS_PER_TURN, Ratio};
use crate::setting::settings;

/// Control interface of the motor's driver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Driver {
    /// STEP and DIR only, with any driver.
    #[default]
    StepDir,
    /// In addition, a TMC2209 is set up and read over its UART ([`crate::scanner::tmc2209`]).
    Tmc2209,
}

/// Logic level of a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireLevel {
    /// Ground level.
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
    /// An AS5600 ([`crate::scanner::encoder::as5600`]).
    As5600,
}

settings! {
    /// Settings of the encoder.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct EncoderConfig
    parts {}
    rows {
        /// Absolute encoder on the mirror's shaft.
        kind: Encoder = Encoder::None, "encoder" "" [] Operation;
        /// Reading of the encoder at home, from calibration; -1: unknown.
        home: i32 = -1, "encoder-home" "0.001 deg" [-1 to 359_999] Operation;
    }
    also {}
}

settings! {
    /// Settings of the driver between board and motor.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct DriverConfig
    parts {}
    rows {
        /// Control of the motor driver: STEP/DIR only, or also over its UART.
        kind: Driver = Driver::StepDir, "driver" "" [] Operation;
        /// Microsteps per turn of the driver; every other setting counts 51,200 a turn.
        microsteps: u16 = MAX_MICROSTEPS, "microsteps-per-turn" "microsteps" [200 to 51_200] Answer;
        /// Active level of EN.
        enable_level: WireLevel = WireLevel::Low, "enable-level" "" [] Operation;
        /// Active level of STALL.
        stall_level: WireLevel = WireLevel::High, "stall-level" "" [] Operation;
        // A DRV8825 needs 1.9 µs, an A4988 1 µs, a TMC2209 0.1 µs (their data sheets). The interrupt lasts
        // as long as the pulse, and it delays the reading of the report port, whose next byte comes after 87 µs.
        /// Minimum high and low time of STEP.
        pulse_width: u8 = 2, "pulse-width" "us" [1 to 50] Operation;
        // Wake-up time of an A4988 from sleep (data sheet); for a TMC2209 the wait is longer. Such drivers take
        // some ms (DRV8825, sleep: 1.7 ms), and homing's deadline has a second to spare.
        /// Wake-up time of the driver after EN.
        enable_wake: u16 = 1_000, "enable-wake" "us" [0 to 60_000] Operation;
        // Half of the rated current of motors of this size (NEMA 14 and 17). The limits are those of a TMC2209
        // with 0.11 Ω (`crate::scanner::tmc2209`).
        /// Current of a phase, rms, with `tmc2209`.
        current: u16 = 600, "motor-current" "mA" [100 to 1_767] Operation;
        /// SGTHRS of the `tmc2209`, its stall threshold; 0: off.
        stall_threshold: u8 = 0, "stall-threshold" "" [] Operation;
    }
    also {}
}

/// Maximum microsteps a turn of a driver: the unit in which all positions are counted.
pub const MAX_MICROSTEPS: u16 = MICROSTEPS_PER_TURN as u16;
const _: () = assert!(MAX_MICROSTEPS as i32 == MICROSTEPS_PER_TURN);

impl DriverConfig {
    /// Number of which `microsteps-per-turn` must be a multiple, so that the ratio of microsteps has small
    /// numbers.
    const GRAIN: u16 = 100;

    /// Returns the exact ratio of the driver's own microsteps to [`MICROSTEPS_PER_TURN`]: numerator and
    /// denominator are so small that some turns fit into 32 bits.
    pub fn ratio(&self) -> Ratio {
        Ratio {
            numerator: i32::from(self.microsteps / Self::GRAIN),
            denominator: MICROSTEPS_PER_TURN / i32::from(Self::GRAIN),
        }
    }

    /// Returns the number of core clocks for which the interrupt that began a STEP pulse waits before it ends it;
    /// the interval to the next pulse is programmed shorter by as many. STEP is high for some clocks anyway: the
    /// computation of that interval has a division of 14 clocks (PM0214, 3.10) and at least some ten other
    /// instructions.
    pub fn held_clocks(&self, core_hz: u32) -> u32 {
        const COMPUTING: u32 = 24;
        (u32::from(self.pulse_width) * (core_hz / MILLION)).saturating_sub(COMPUTING)
    }

    fn validate(&self) -> Result<(), ConfigError> {
        check(
            self.microsteps.is_multiple_of(Self::GRAIN),
            "microsteps-per-turn",
            "a multiple of 100 from 200 to 51200",
        )?;
        check(
            self.kind == Driver::StepDir || self.mres().is_some(),
            "microsteps-per-turn",
            "51200, or its half, ... down to 200, with tmc2209",
        )
    }

    /// Returns the TMC2209's MRES: how often 256 microsteps of a full step must be halved to get the microsteps
    /// of the driver; `None` if they never do.
    pub fn mres(&self) -> Option<u32> {
        let times = (MAX_MICROSTEPS / self.microsteps.max(1)).trailing_zeros();
        (MAX_MICROSTEPS >> times == self.microsteps).then_some(times)
    }
}

settings! {
    /// The mirror's motor.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct MotorConfig
    parts {
        /// Driver of the motor.
        driver: DriverConfig;
        /// Encoder on its shaft.
        encoder: EncoderConfig;
    }
    rows {
        /// Shaft angle at which the home switch closes on the slow approach.
        home_angle: i32 = -165_000, "home-angle" "0.001 deg" [-170_000 to 170_000] Answer;
        // One turn a second, reached within 20 ms.
        /// Top speed of moves.
        speed: u32 = 51_200, "speed" "microsteps/s" [100 to 102_400] Operation;
        /// Acceleration of moves.
        acceleration: u32 = 2_560_000, "acceleration" "microsteps/s2" [1_000 to 100_000_000] Operation;
        // 100 full steps a second: below the pull-in rate of any motor of this size.
        /// Speed of the search for home, from which the motor must be able to stop without a ramp.
        search_speed: u32 = 25_600, "search-speed" "microsteps/s" [800 to 51_200] Operation;
        // In some mountings the switch is far from the sector.
        /// Whether the home switch is checked at the end of every sweep that ends on its side.
        home_check: bool = false, "home-check" "" [] Operation;
    }
    also {}
}

impl MotorConfig {
    /// Checks `microsteps-per-turn` with this driver, and `pulse-width` against the speeds.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.driver.validate()?;
        check(
            self.pulse_time_per_second_us() <= MILLION,
            "pulse-width",
            "half of a step at top speed, or less",
        )
    }

    /// Returns the ramp of moves between rows.
    pub fn ramp(&self) -> Ramp {
        Ramp {
            speed: self.speed,
            acceleration: self.acceleration,
        }
    }

    /// Returns the time limit of a check of the home switch, µs: a turn, which is more than any way to it, and
    /// two slow approaches over 2° each, with the way back between them.
    pub fn cross_bound_us(&self) -> u32 {
        /// Two degrees, microsteps.
        const TWO_DEGREES: u32 = MICROSTEPS_PER_TURN as u32 / 180;
        let fast = self.ramp().bound_us(MICROSTEPS_PER_TURN as u32);
        let slow = TWO_DEGREES.saturating_mul(MILLION) / (self.search_speed / 8).max(1);
        let back = self.ramp().bound_us(TWO_DEGREES);
        fast.saturating_add(2 * slow).saturating_add(back)
    }

    /// Returns the minimum time that the high and low times of all STEP pulses of a second take at top speed, µs:
    /// for each pulse twice `pulse-width`.
    fn pulse_time_per_second_us(&self) -> u32 {
        let Ratio {
            numerator: own,
            denominator: of,
        } = self.driver.ratio();
        let fastest = self.speed.max(self.search_speed);
        let steps = fastest.saturating_mul(own as u32).div_ceil(of as u32);
        steps.saturating_mul(2 * u32::from(self.driver.pulse_width))
    }
}

/// Microseconds in a second.
const MILLION: u32 = 1_000_000;
