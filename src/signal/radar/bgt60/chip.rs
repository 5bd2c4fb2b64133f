//! Registers of the chip, and the parameters of a chirp.
//!
//! Names, fields and formulas are those of the data sheet (Infineon BGT60TR13C, V2.4.9, 2023-11-21), whose
//! sections are in brackets. All times are in periods of its 80 MHz clock.

use crate::config::{RadarConfig, SAMPLES};

/// Reference clock of the chip, MHz; the PLL settings in this file are valid for no other [3.4.2].
pub const CLOCK_MHZ: u32 = 80;

/// Address of a register of 24 bits.
pub type Address = u8;

/// Main register: FRAME_START, resets, wake-up time [4.2].
pub const MAIN: Address = 0x00;
/// Register of the converter: sampling rate and conversion [4.3].
const ADC0: Address = 0x01;
/// Register with the versions of the digital part and of the antennas [4.4].
pub const CHIP_ID: Address = 0x02;
/// First register of the PLL's analog part [4.6].
pub const PACR1: Address = 0x04;
/// Second register of the PLL's analog part [4.7].
const PACR2: Address = 0x05;
/// Register of SPI and FIFO settings [4.8].
pub const SFCTL: Address = 0x06;
/// Register of the sensor ADC [4.9].
const SADC_CTRL: Address = 0x07;
/// Register of the blocks that are on while the chip is idle [4.11].
const CSCI: Address = 0x0b;
/// First of three registers of RF, baseband and gains during a chirp [4.10].
const CSU1: Address = 0x10;
/// Register of the blocks that are on during a chirp [4.11].
const CSC1: Address = 0x16;
/// First of four registers of a frame's timing [4.12 to 4.15].
const CCR0: Address = 0x2c;
/// First register of the ramp and samples of the first chirp [4.16, 4.17].
const PLL1: Address = 0x30;
/// Register with the state of the FIFO [4.23].
pub const FSTAT: Address = 0x5f;

/// Value of the register CHIP_ID of a BGT60TR13C [4.4].
pub const IDENTITY: u32 = 0x00_0303;

/// Bit of MAIN that starts a frame.
pub const FRAME_START: u32 = 1;
/// Bit of MAIN that sets all registers to their values after power-up.
pub const SW_RESET: u32 = 1 << 1;
/// Bit of MAIN that empties the FIFO and puts the state machine into deep sleep [5.10].
pub const FIFO_RESET: u32 = 1 << 3;
/// Value of MAIN without frame start and resets: both slow clocks as after reset, T_WU =
/// `157 · 2^6 · 8 + 6 + 3` periods of 80 MHz = 1.005 ms, because the converter's band gap takes up to 1 ms
/// [table 61].
pub const MAIN_AT_REST: u32 = 3 << 19 | 3 << 17 | 6 << 12 | 157 << 4;
const WAKE_UP: u32 = (157 << 6 << 3) + 9;

/// Value of PACR1 as in the vendor's own configurations: regulators at 1.6 and 1.55 V, band gap, charge pump at
/// 200 µA, loop filter and clock on, without waiting for lock.
pub const PLL_ON: u32 = 0xe9_67fd;

/// Bit of FSTAT: an SPI command had an invalid number of clocks [5.8].
pub const CLOCK_ERROR: u32 = 1 << 17;
/// Bit of FSTAT: a burst was shorter or longer than announced [5.8].
pub const BURST_ERROR: u32 = 1 << 18;
/// Bit of FSTAT: underflow, a read from the empty FIFO.
pub const UNDERFLOW: u32 = 1 << 19;
/// Bit of FSTAT: the FIFO holds more words than its threshold, the field CREF of SFCTL.
pub const FILLED: u32 = 1 << 21;
/// Bit of FSTAT: overflow, more samples than the FIFO holds.
pub const OVERFLOW: u32 = 1 << 23;
/// Bits of GSR0, the first byte of every answer: clock error, burst error, overflow or underflow [4.24].
pub const GSR0_ERRORS: u8 = 0b1011;
/// Bit of GSR0, the first byte of every answer: overflow or underflow of the FIFO.
pub const GSR0_FIFO: u8 = 0b1000;

/// T_START, from the state machine's start of the chirp to the beginning of the ramp, periods of 80 MHz:
/// `10 · 8 + 10` [4.13].
const START: u32 = 90;
/// T_PAEN, from the state machine's start of the chirp until the transmitter is on, periods of 80 MHz: 41 · 8,
/// which is 3 µs after the beginning of the ramp [4.15].
const POWER_ON: u32 = 328;
/// T_SSTART, from switching on the transmitter to the first sample, periods of 80 MHz: 31 · 8 + 1 (3.1 µs), the
/// maximum [4.15]. The transient of the baseband's 80 kHz high pass has then decayed to an eighth, and the PLL
/// has had its 5 µs since the beginning of the ramp [table 54].
const SETTLE: u32 = 249;
/// Time from the beginning of the ramp to the first sample, periods of 80 MHz.
pub const LEAD: u32 = POWER_ON + SETTLE - START;
/// Minimum duration of the ramp after the last sample, periods of 80 MHz: T_ECM, 1 µs [3.4.1].
const TAIL: u32 = CLOCK_MHZ;
/// Settling time before the chirp, periods of 80 MHz: T_INIT0, 188 · 2^2 · 8 + 5, and T_INIT1, 150 · 8 + 3.
/// They are 75 and 15 µs, the PLL's typical settling times [table 15]. The converter's calibration, 1792 · 2 +
/// 1569 periods after 660 for its start, takes less [table 60].
const SETTLE_PLL: u32 = 6021 + 1203;

/// Time from FRAME_START to the first sample, periods of 80 MHz.
const AHEAD: u32 = WAKE_UP + SETTLE_PLL + POWER_ON + SETTLE;

/// Number of the PLL's frequency steps in 625 kHz: 2^20 steps are 8 · 80 MHz [3.4.2].
const STEPS: u32 = 1024;
const STEPS_KHZ: u32 = 625;
/// Frequency of the PLL's step 0: 96 · 8 · 80 MHz, kHz.
const ORIGIN_KHZ: u32 = 61_440_000;
/// Band of the PLL, 58.0 to 63.5 GHz [table 54], frequency steps from [`ORIGIN_KHZ`]: lower and upper end.
const BAND: [i32; 2] = [-5_636_096, 3_375_104];
/// Maximum slope of the ramp, frequency steps (0.61 kHz) per period of 80 MHz: 20.9 GHz per millisecond (400
/// MHz per microsecond is permitted, table 54). An echo at 3.2 m then has 445 kHz, just below the minimum
/// cutoff of the anti-alias filter, 450 kHz [table 58]. Echoes beyond half the default sampling rate (500 kHz,
/// 3.6 m) have the maximum possible attenuation.
const SLOPE: u32 = 427;
/// Maximum duration of a chirp's samples, periods of 80 MHz: 256 µs.
const LONGEST: u32 = 20_480;
/// Maximum bandwidth within a chirp's samples, frequency steps: 5.34 GHz. With lead and tail it fills the band
/// except 7 MHz at either end.
const WIDEST: u32 = SLOPE * LONGEST;
const _: () =
    assert!(SLOPE * (LONGEST + LEAD + TAIL + 8) < (BAND[1] - BAND[0]) as u32 - 16 * STEPS);
/// Minimum and maximum number of periods of 80 MHz between samples: more than a conversion takes, 8 + 15 + 8
/// [8.5.4], and at most the divider's maximum.
const DIVIDER: [u32; 2] = [32, 1023];
/// Default number of pairs of real samples in a chirp.
const PAIRS: u16 = 128;

/// Values of CSU1 and the two registers after it, gains and power: minimum power, 18 dB in the first stage, 20
/// dB in the second, high pass at 80 kHz.
///
/// The minimum power is 15 dB below 4 dBm [table 55]. With a lens of 30 dBi the radiated power is 19 dBm EIRP;
/// 20 dBm are permitted (ERC Recommendation 70-03, annex 1, 57 to 64 GHz). An edge of -20 dBsm at 1.5 m then
/// drives the converter to about a third of full scale, without lens losses.
const CHANNEL: [u32; 3] = [
    // BBCHGLOB_EN, RX1MIX_EN, RX1LOBUF_EN, LO_DIST1_EN, LO_DIST2_EN, FDIV_EN, VCO_EN, TX_EN.
    1 << 20 | 1 << 13 | 1 << 12 | 1 << 11 | 1 << 10 | 1 << 6 | 1 << 4 | 1,
    // BBCH_SEL: channel 1; BB_RSTCNT: 1.6 µs; TEMP_MEAS_EN, MADC_EN, TX_DAC: 0.
    1 << 20 | 127 << 13 | 1 << 12 | 1 << 10,
    // HP_GAIN: 18 dB; VGA_GAIN1: 20 dB; HPF_SEL1: 80 kHz.
    1 << 20 | 4 << 2 | 3,
];

/// Registers with the same value for every chirp, as address and value in the order of writing.
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
    // MAX_FRAME_CNT 1: deep sleep after each frame.
    (CCR0 + 2, 1),
    // TR_INIT0 188 · 2^2, TR_SSTART 31, TR_PAEN 41.
    (CCR0 + 3, 2 << 22 | 188 << 14 | 31 << 9 | 41),
];

/// Returns a mask of the bits of a register that read back as written; the others belong to the state machine
/// or clear themselves.
pub fn readback_mask(address: Address) -> u32 {
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

/// One chirp: `2 · pairs` samples, `divider` periods of 80 MHz apart, on a ramp of `slope` frequency steps per
/// period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChirpShape {
    pub pairs: u16,
    divider: u32,
    slope: u32,
}

impl ChirpShape {
    /// Chirp with the maximum bandwidth and the default number of samples.
    pub const DEFAULT: Self = Self {
        pairs: PAIRS,
        divider: LONGEST / (2 * PAIRS as u32),
        slope: SLOPE,
    };

    /// Returns the chirp nearest to the requested one (0: the default). The slope is the maximum, unless the
    /// converter would be too slow. A range therefore has the same beat frequency, and the same filters apply,
    /// for any bandwidth.
    pub fn of(bandwidth_khz: u32, pairs: u16) -> Self {
        let pairs = match pairs {
            0 => PAIRS,
            some => some.clamp(*SAMPLES.start(), *SAMPLES.end()),
        };
        let samples = 2 * u32::from(pairs);
        let steps = match bandwidth_khz.min(6_000_000) {
            0 => WIDEST,
            // Two factors, so that the product fits 32 bits.
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

    /// Returns the duration of the samples, periods of 80 MHz: from the first one to the time of one more after
    /// the last.
    fn acquisition(&self) -> u32 {
        2 * u32::from(self.pairs) * self.divider
    }

    /// Returns the length of the ramp, units of 8 periods of 80 MHz.
    fn ramp(&self) -> u32 {
        (LEAD + self.acquisition() + TAIL).div_ceil(8)
    }

    /// Returns the frequency at the beginning of the ramp, steps from [`ORIGIN_KHZ`]; the ramp lies in the
    /// middle of the band.
    fn start(&self) -> i32 {
        (BAND[0] + BAND[1] - (8 * self.ramp() * self.slope) as i32) / 2
    }

    /// Returns the time from FRAME_START until all samples are in the FIFO, microseconds, rounded up.
    pub fn time_us(&self) -> u32 {
        (AHEAD + self.acquisition()).div_ceil(CLOCK_MHZ)
    }

    /// Returns the time from FRAME_START to the first sample, microseconds, rounded up.
    pub fn ahead_us(&self) -> u32 {
        AHEAD.div_ceil(CLOCK_MHZ)
    }

    /// Returns the duration of the samples, microseconds, rounded up.
    pub fn acquisition_us(&self) -> u32 {
        self.acquisition().div_ceil(CLOCK_MHZ)
    }

    /// Returns the value of SFCTL: CREF one below the number of a chirp's words, MISO changing with the falling
    /// edge, which suits clocks below 25 MHz, and reserved bits as after reset.
    pub fn fifo(&self) -> u32 {
        14 << 19 | 1 << 13 | (u32::from(self.pairs) - 1)
    }

    /// Returns address and value of the `k`-th register to be written; `None` after the last.
    pub fn register(&self, k: u8) -> Option<(Address, u32)> {
        let own = [
            (SFCTL, self.fifo()),
            // TRACK_CFG 1, STC 1 (100 ns), BG_TC_TRIM 4.
            (ADC0, self.divider << 14 | 1 << 9 | 1 << 6 | 4 << 2),
            (PLL1, self.start() as u32 & 0xff_ffff),
            (PLL1 + 1, self.slope),
            (PLL1 + 2, self.ramp()),
            (PLL1 + 3, 2 * u32::from(self.pairs)),
            // PD_MODE: idle; CONT_MODE, SH_EN, single.
            (PLL1 + 7, 1 << 9 | 1 << 8 | 1 << 4),
        ];
        own.into_iter().chain(FIXED).nth(usize::from(k))
    }

    /// Returns the radar settings of the chirp: the bandwidth within its samples, not of the whole ramp.
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

/// Converts frequency steps to kHz, rounded down.
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
        for (requested, pairs, least) in [(4_000_000, 128, 0.99), (2_500_000, 200, 0.99)] {
            let radar = ChirpShape::of(requested, pairs).radar();
            let share = f64::from(radar.bandwidth_khz) / f64::from(requested);
            assert!((least..=1.0).contains(&share), "{radar:?}");
        }
        let widest = ChirpShape::of(0, 0).radar();
        assert_eq!(ChirpShape::of(0, 0), ChirpShape::DEFAULT);
        assert_eq!(ChirpShape::of(u32::MAX, 128), ChirpShape::DEFAULT);
        assert_eq!((widest.samples, widest.bandwidth_khz), (128, 5_337_500));
        assert!((60_750_000..60_850_000).contains(&widest.carrier_khz));
    }
}
