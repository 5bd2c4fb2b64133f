//! The chip's registers and what one chirp is made of.
//!
//! Names, fields and formulas are those of the data sheet (Infineon BGT60TR13C, V2.4.9, 2023-11-21), whose sections
//! stand in brackets. All times are counted in periods of its 80 MHz clock.

use crate::config::{RadarConfig, SAMPLES};

/// The chip's reference clock, MHz; the PLL's settings below hold for no other [3.4.2].
pub const CLOCK_MHZ: u32 = 80;

/// A register's address.
pub type Address = u8;

/// FRAME_START, resets, wake-up time [4.2].
pub const MAIN: Address = 0x00;
/// Sampling rate and conversion [4.3].
const ADC0: Address = 0x01;
/// Versions of the digital part and of the antennas [4.4].
pub const CHIP_ID: Address = 0x02;
/// PLL, analog part [4.6].
pub const PACR1: Address = 0x04;
/// PLL, analog part [4.7].
const PACR2: Address = 0x05;
/// SPI and FIFO [4.8].
pub const SFCTL: Address = 0x06;
/// Sensor ADC [4.9].
const SADC_CTRL: Address = 0x07;
/// What is on while idle [4.11].
const CSCI: Address = 0x0b;
/// What is on in a chirp: RF, baseband, gains [4.10].
const CSU1: Address = 0x10;
/// What is on in a chirp: blocks [4.11].
const CSC1: Address = 0x16;
/// Timing of a frame [4.12 to 4.15].
const CCR0: Address = 0x2c;
/// The first chirp's ramp and samples [4.16, 4.17].
const PLL1: Address = 0x30;
/// The FIFO's state [4.23].
pub const FSTAT: Address = 0x5f;

/// CHIP_ID of a BGT60TR13C [4.4].
pub const IDENTITY: u32 = 0x00_0303;

/// MAIN: starts a frame.
pub const FRAME_START: u32 = 1;
/// MAIN: all registers as after power-up.
pub const SW_RESET: u32 = 1 << 1;
/// MAIN: the FIFO is emptied, and the state machine goes to deep sleep [5.10].
pub const FIFO_RESET: u32 = 1 << 3;
/// MAIN but for those: both slow clocks as after reset, T_WU = (157 · 2^6 · 8 + 6 + 3) periods = 1.005 ms, for
/// the converter's band gap takes up to 1 ms [table 61].
pub const MAIN_AT_REST: u32 = 3 << 19 | 3 << 17 | 6 << 12 | 157 << 4;
const WAKE_UP: u32 = (157 << 6 << 3) + 9;

/// PACR1 as the vendor's own configurations have it: regulators at 1.6 and 1.55 V, band gap, charge pump at 200 µA,
/// loop filter and clock on, lock not waited for.
pub const PLL_ON: u32 = 0xe9_67fd;

/// FSTAT: an SPI command had a number of clocks that is none [5.8].
pub const CLOCK_ERROR: u32 = 1 << 17;
/// FSTAT: a burst was shorter or longer than announced [5.8].
pub const BURST_ERROR: u32 = 1 << 18;
/// FSTAT: more was read than there was.
pub const UNDERFLOW: u32 = 1 << 19;
/// FSTAT: the FIFO holds more words than SFCTL's CREF says.
pub const FILLED: u32 = 1 << 21;
/// FSTAT: more was sampled than fits.
pub const OVERFLOW: u32 = 1 << 23;
/// GSR0, the first byte of every answer: clock error, burst error, over- or underflow [4.24].
pub const GSR0_ERRORS: u8 = 0b1011;
/// GSR0: only over- or underflow.
pub const GSR0_FIFO: u8 = 0b1000;

/// T_START, from the state machine's signal to the ramp's beginning: 10 · 8 + 10 [4.13].
const START: u32 = 90;
/// T_PAEN, until the transmitter is on: 41 · 8, which is 3 µs within the ramp [4.15].
const POWER_ON: u32 = 328;
/// T_SSTART, from there to the first sample: 31 · 8 + 1, the longest there is [4.15]. The baseband's high pass of
/// 80 kHz has settled by then to an eighth, and the PLL has its 5 µs since the ramp began [table 54].
const SETTLE: u32 = 249;
/// From the ramp's beginning to the first sample.
pub const LEAD: u32 = POWER_ON + SETTLE - START;
/// The ramp goes on for so long behind the last sample, at least: T_ECM, 1 µs [3.4.1].
const TAIL: u32 = CLOCK_MHZ;
/// T_INIT0, 188 · 2^2 · 8 + 5, and T_INIT1, 150 · 8 + 3: 75 and 15 µs, as the PLL takes them typically [table 15]. The
/// converter's calibration, 1792 · 2 + 1569 periods behind 660 for its start, fits in [table 60].
const SETTLE_PLL: u32 = 6021 + 1203;

/// From FRAME_START to the first sample.
const AHEAD: u32 = WAKE_UP + SETTLE_PLL + POWER_ON + SETTLE;

/// Steps of the frequency, 2^20 of them to 8 · 80 MHz: 1024 steps are 625 kHz [3.4.2].
const STEPS: u32 = 1024;
const STEPS_KHZ: u32 = 625;
/// Where the steps are counted from: 96 · 8 · 80 MHz, kHz.
const ORIGIN_KHZ: u32 = 61_440_000;
/// The band that the PLL reaches, 58.0 to 63.5 GHz [table 54], in steps.
const BAND: [i32; 2] = [-5_636_096, 3_375_104];
/// Steps a period, at most: 20.9 GHz a millisecond (400 MHz a microsecond would be allowed, table 54). An echo from
/// 3.2 m then has 445 kHz, just below the least cutoff of the anti-alias filter, 450 kHz [table 58], and what is
/// farther away than half the default sampling rate shows, 500 kHz or 3.6 m, is damped as much as it can be.
const SLOPE: u32 = 427;
/// Periods that the samples take at most: 256 µs.
const LONGEST: u32 = 20_480;
/// The widest sweep within the samples, steps: 5.34 GHz. With lead and tail it fills the band but for 7 MHz at
/// either end.
const WIDEST: u32 = SLOPE * LONGEST;
const _: () =
    assert!(SLOPE * (LONGEST + LEAD + TAIL + 8) < (BAND[1] - BAND[0]) as u32 - 16 * STEPS);
/// Periods between samples: more than a conversion takes, 8 + 15 + 8 [8.5.4], and at most what the divider holds.
const DIVIDER: [u32; 2] = [32, 1023];
/// Pairs of samples unless others are wished for.
const PAIRS: u16 = 128;

/// Gains and power: least power, 18 dB in the first stage, 20 dB behind it, high pass at 80 kHz.
///
/// The least power is 15 dB below 4 dBm [table 55]: with a lens of 30 dBi that radiates 19 dBm, where 20 dBm are
/// allowed (ERC Recommendation 70-03, annex 1, 57 to 64 GHz). An edge of -20 dBsm at 1.5 m then fills some third of
/// the converter, lens losses left aside.
const CHANNEL: [u32; 3] = [
    // BBCHGLOB_EN, RX1MIX_EN, RX1LOBUF_EN, LO_DIST1_EN, LO_DIST2_EN, FDIV_EN, VCO_EN, TX_EN.
    1 << 20 | 1 << 13 | 1 << 12 | 1 << 11 | 1 << 10 | 1 << 6 | 1 << 4 | 1,
    // BBCH_SEL: channel 1; BB_RSTCNT: 1.6 µs; TEMP_MEAS_EN, MADC_EN, TX_DAC: 0.
    1 << 20 | 127 << 13 | 1 << 12 | 1 << 10,
    // HP_GAIN: 18 dB; VGA_GAIN1: 20 dB; HPF_SEL1: 80 kHz.
    1 << 20 | 4 << 2 | 3,
];

/// Registers that are the same for every chirp, in the order in which they are written.
const FIXED: [(Address, u32); 13] = [
    (MAIN, MAIN_AT_REST),
    (PACR1, PLL_ON),
    // DTSEL 2, FSDNTMR 5, FSTDNEN 2, DIVEN, DIVSET 20.
    (PACR2, 2 << 18 | 5 << 8 | 2 << 6 | 1 << 5 | 20),
    // TC_TRIM 4, OVERS_CFG 3, SD_EN: its result is not read, but the state machine triggers it.
    (SADC_CTRL, 4 << 14 | 3 << 9 | 1 << 8),
    // As after reset, with the converter's band gap on.
    (CSCI, 0xb60 | 1 << 7),
    (CSU1, CHANNEL[0]),
    (CSU1 + 1, CHANNEL[1]),
    (CSU1 + 2, CHANNEL[2]),
    // BG_TMRF_EN, BG_EN, CS_EN: nothing isolated.
    (CSC1, 1 << 10 | 1 << 7 | 1 << 4),
    // TR_INIT1 150, REPT 15, CONT_MODE, TR_END 14.
    (CCR0, 150 << 14 | 15 << 10 | 1 << 9 | 14),
    // PD_MODE: idle; TR_START 10.
    (CCR0 + 1, 1 << 9 | 10),
    // MAX_FRAME_CNT 1: deep sleep behind each frame.
    (CCR0 + 2, 1),
    // TR_INIT0 188 · 2^2, TR_SSTART 31, TR_PAEN 41.
    (CCR0 + 3, 2 << 22 | 188 << 14 | 31 << 9 | 41),
];

/// Which bits of a register read back as they were written: the others are the state machine's, or one shot.
pub fn holds(address: Address) -> u32 {
    let other = match address {
        MAIN => 0xf,
        // OSCCLKEN, RFILTSEL.
        PACR1 => 1 << 23 | 1 << 10,
        // FSTDNEN, DIVEN.
        PACR2 => 0b111 << 5,
        _ => 0,
    };
    0xff_ffff & !other
}

/// One chirp: `2 · pairs` samples, `divider` periods apart, on a ramp of `slope` steps a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChirpShape {
    pub pairs: u16,
    divider: u32,
    slope: u32,
}

impl ChirpShape {
    /// The widest sweep with the usual number of samples.
    pub const DEFAULT: Self = Self {
        pairs: PAIRS,
        divider: LONGEST / (2 * PAIRS as u32),
        slope: SLOPE,
    };

    /// The chirp nearest to what is wished for. The slope is the steepest one unless the converter would be too
    /// slow, so that a range has the same beat frequency, and the same filters, whatever the bandwidth.
    pub fn of(bandwidth_khz: u32, pairs: u16) -> Self {
        let pairs = match pairs {
            0 => PAIRS,
            some => some.clamp(*SAMPLES.start(), *SAMPLES.end()),
        };
        let samples = 2 * u32::from(pairs);
        let steps = match bandwidth_khz.min(6_000_000) {
            0 => WIDEST,
            // In two steps that both fit into 32 bits.
            khz => (khz * 16 / STEPS_KHZ * (STEPS / 16)).min(WIDEST),
        };
        let divider = steps
            .div_ceil(SLOPE * samples)
            .clamp(DIVIDER[0], DIVIDER[1]);
        Self {
            pairs,
            divider,
            slope: (steps / (samples * divider)).clamp(1, SLOPE),
        }
    }

    /// Periods from the first sample to where one more would be.
    fn acquisition(&self) -> u32 {
        2 * u32::from(self.pairs) * self.divider
    }

    /// The ramp's length in units of 8 periods.
    fn ramp(&self) -> u32 {
        (LEAD + self.acquisition() + TAIL).div_ceil(8)
    }

    /// Where the ramp begins, steps: it lies in the middle of the band.
    fn start(&self) -> i32 {
        (BAND[0] + BAND[1] - (8 * self.ramp() * self.slope) as i32) / 2
    }

    /// From FRAME_START until all samples are in the FIFO, microseconds, rounded up.
    pub fn time_us(&self) -> u32 {
        (AHEAD + self.acquisition()).div_ceil(CLOCK_MHZ)
    }

    /// From FRAME_START to the first sample, microseconds, rounded up.
    pub fn ahead_us(&self) -> u32 {
        AHEAD.div_ceil(CLOCK_MHZ)
    }

    /// From the first sample to where one more would be, microseconds, rounded up.
    pub fn acquisition_us(&self) -> u32 {
        self.acquisition().div_ceil(CLOCK_MHZ)
    }

    /// SFCTL: CREF one below a chirp's words, and MISO with the falling edge, which suits clocks below 25 MHz. The
    /// reserved bits as after reset.
    pub fn fifo(&self) -> u32 {
        14 << 19 | 1 << 13 | (u32::from(self.pairs) - 1)
    }

    /// The registers to be written, in their order; none behind the last.
    pub fn register(&self, k: u8) -> Option<(Address, u32)> {
        let own = [
            (SFCTL, self.fifo()),
            // TRACK_CFG 1, STC 1 (100 ns), BG_TC_TRIM 4.
            (ADC0, self.divider << 14 | 1 << 9 | 1 << 6 | 4 << 2),
            (PLL1, self.start() as u32 & 0xff_ffff),
            (PLL1 + 1, self.slope),
            (PLL1 + 2, self.ramp()),
            (PLL1 + 3, 2 * u32::from(self.pairs)),
            // PD_MODE: idle; CONT_MODE, SH_EN, once.
            (PLL1 + 7, 1 << 9 | 1 << 8 | 1 << 4),
        ];
        own.into_iter().chain(FIXED).nth(usize::from(k))
    }

    /// What the chirp means: the sweep within its samples, not the whole ramp.
    pub fn radar(&self) -> RadarConfig {
        let middle = self.start() + ((LEAD + self.acquisition() / 2) * self.slope) as i32;
        RadarConfig {
            carrier_khz: ORIGIN_KHZ.saturating_add_signed(khz(middle)),
            bandwidth_khz: khz((self.acquisition() * self.slope) as i32) as u32,
            samples: self.pairs,
            real: true,
        }
    }
}

/// Steps of the frequency in kHz, rounded down.
fn khz(steps: i32) -> i32 {
    let (whole, rest) = (
        steps.div_euclid(STEPS as i32),
        steps.rem_euclid(STEPS as i32),
    );
    whole * STEPS_KHZ as i32 + rest * STEPS_KHZ as i32 / STEPS as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_those_of_the_data_sheet() {
        // Section 3.4.2, example 1: 58 GHz is AA0000, two's complement of 24 bits.
        assert_eq!(BAND[0] as u32 & 0xff_ffff, 0xaa_0000);
        assert_eq!(ORIGIN_KHZ as i32 + khz(BAND[0]), 58_000_000);
        assert_eq!(ORIGIN_KHZ as i32 + khz(BAND[1]), 63_500_000);
        // Its ramp of 360 · 8 periods of 3128 steps ends at 63.4984375 GHz.
        let end = BAND[0] + 360 * 8 * 3128;
        assert_eq!(ORIGIN_KHZ as i32 + khz(end), 63_498_437);
    }

    #[test]
    fn every_ramp_stays_in_the_band_and_every_field_in_its_register() {
        for pairs in 16..=256 {
            for bandwidth_khz in (0..7_000_000).step_by(111_111) {
                let shape = ChirpShape::of(bandwidth_khz, pairs);
                let end = shape.start() + (8 * shape.ramp() * shape.slope) as i32;
                assert!(BAND[0] < shape.start() && end < BAND[1], "{shape:?}");
                assert!(DIVIDER[0] <= shape.divider && shape.divider <= DIVIDER[1]);
                assert!(shape.ramp() < 1 << 14);
                let radar = shape.radar();
                assert!(radar.validate().is_ok() && radar.real);
                assert!(shape.time_us() < 1_370, "{}", shape.time_us());
            }
        }
    }

    #[test]
    fn bandwidth_comes_as_near_as_the_slope_can_be_set() {
        for (wish, pairs, least) in [(4_000_000, 128, 0.99), (2_500_000, 200, 0.99)] {
            let radar = ChirpShape::of(wish, pairs).radar();
            let share = f64::from(radar.bandwidth_khz) / f64::from(wish);
            assert!((least..=1.0).contains(&share), "{radar:?}");
        }
        let widest = ChirpShape::of(0, 0).radar();
        assert_eq!(ChirpShape::of(0, 0), ChirpShape::DEFAULT);
        assert_eq!(ChirpShape::of(u32::MAX, 128), ChirpShape::DEFAULT);
        assert_eq!((widest.samples, widest.bandwidth_khz), (128, 5_337_500));
        assert!((60_750_000..60_850_000).contains(&widest.carrier_khz));
    }
}
