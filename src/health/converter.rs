//! Check of the analogue-to-digital converter by the raw samples of each chirp: stuck bits, repeated chirps, offset
//! drift and clipping.

use super::check::{CheckResult, PER_CENT};
use crate::Iq;
use crate::params::health::MAX_CLIPPED_ROWS;
use crate::params::{Numbers, Params};
use crate::signal::range::RowStats;
use crate::verdict::Reason;

/// Number of earlier chirps that a chirp is compared with.
const HASHES: usize = 16;
/// Row interval of the clipping check, which needs a pass of its own over the samples: one row in eight.
const CLIP_ROWS: u32 = 8;
/// Sample interval of the checks for stuck bits and repeated chirps: a working bit changes in any eighth of a
/// chirp's samples.
const BIT_STRIDE: usize = 8;
/// Sample interval of the clipping check: every fourth sample of a chirp is compared.
const STRIDE: usize = 4;
/// Odd factor of the multiplicative hash of a chirp (Knuth, The Art of Computer Programming 3, 6.4: 2^32 by the golden
/// ratio).
const HASH_FACTOR: u32 = 0x9E37_79B9;
/// Full scale of I and of Q, units of a sample (16-bit signed).
const FULL_SCALE: f32 = 32_768.0;
/// Number of bits of I or Q within the 32-bit word that holds both.
const HALF_BITS: u32 = 16;
/// Mask of I within the 32-bit word that holds I and Q.
const LOW_HALF: u32 = 0xFFFF;

/// State of the checks of the analogue-to-digital converter over one scan.
#[derive(Clone, Debug)]
pub struct Converter {
    rows: u32,
    /// Number of rows in whose chirp a bit of I or Q never changed though a lower bit did.
    stuck: u32,
    /// Number of rows whose chirp has the same hash as one of the [`HASHES`] chirps before.
    stale: u32,
    hashes: [u32; HASHES],
    /// Minimum and maximum over the rows of a chirp's mean (its offset), each as [I, Q], units of a sample.
    least: [i16; 2],
    most: [i16; 2],
    /// Number of rows checked for clipping, and number of those whose I or Q is clipped.
    clipping_rows: u32,
    clipped: u32,
    numbers: Numbers,
}

/// Returns the stuck bits of a chirp, I in the low half and Q in the high half: those that did not change between its
/// samples though a lower one did. In `changed` the bits are set that differ between any two samples. The lowest bits
/// may rest, as they do in a converter of fewer bits.
fn stuck_bits(changed: u32) -> u32 {
    let half = |bits: u32| {
        let lowest = bits & bits.wrapping_neg();
        // All bits from the lowest changing one upwards; none if no bit changes.
        let live = lowest.wrapping_neg() & LOW_HALF;
        live & !bits
    };
    half(changed & LOW_HALF) | half(changed >> HALF_BITS) << HALF_BITS
}

/// Counts, among every [`STRIDE`]th sample, those equal to the chirp's minimum and those equal to its maximum, and
/// returns the larger number; `part` selects I or Q.
fn at_extremes(chirp: &[Iq], [low, high]: [Iq; 2], part: impl Fn(&Iq) -> i16) -> u32 {
    let (low, high) = (part(&low), part(&high));
    let mut counts = [0u32; 2];
    for x in chirp.iter().step_by(STRIDE).map(part) {
        counts[0] += u32::from(x == low);
        counts[1] += u32::from(x == high);
    }
    counts[0].max(counts[1])
}

impl Converter {
    /// Returns the state before a scan's first chirp. All bits are zero, so that a static of this type takes no flash.
    pub const fn new(numbers: Numbers) -> Self {
        Self {
            rows: 0,
            stuck: 0,
            stale: 0,
            hashes: [0; HASHES],
            least: [0; 2],
            most: [0; 2],
            clipping_rows: 0,
            clipped: 0,
            numbers,
        }
    }

    /// Adds one row to the checks: its chirp, and the chirp's statistics.
    pub fn row(&mut self, chirp: &[Iq], stats: &RowStats) {
        let (mut set, mut clear, mut hash) = (0u32, u32::MAX, 0u32);
        for x in chirp.iter().step_by(BIT_STRIDE) {
            let bits = u32::from(x.i as u16) | u32::from(x.q as u16) << HALF_BITS;
            set |= bits;
            clear &= bits;
            hash = hash.wrapping_mul(HASH_FACTOR) ^ bits;
        }
        self.stuck += u32::from(stuck_bits(set & !clear) != 0);
        let known = usize::try_from(self.rows).unwrap_or(HASHES).min(HASHES);
        self.stale += u32::from(self.hashes.iter().take(known).any(|&h| h == hash));
        if let Some(place) = self.hashes.get_mut(self.rows as usize % HASHES) {
            *place = hash;
        }
        let mean = [stats.mean.i, stats.mean.q];
        if self.rows == 0 {
            (self.least, self.most) = (mean, mean);
        }
        for (k, &mean) in mean.iter().enumerate() {
            if let (Some(least), Some(most)) = (self.least.get_mut(k), self.most.get_mut(k)) {
                *least = (*least).min(mean);
                *most = (*most).max(mean);
            }
        }
        // Offset against the rows of the noise histogram, so that no row has the cost of both.
        if self.rows % CLIP_ROWS == CLIP_ROWS / 2 {
            self.clipping_rows += 1;
            // I and Q alternate.
            let count = if self.clipping_rows.is_multiple_of(2) {
                at_extremes(chirp, stats.extremes, |x| x.q)
            } else {
                at_extremes(chirp, stats.extremes, |x| x.i)
            };
            let share = STRIDE as u32 * count * SHARE;
            self.clipped += u32::from(share > clipped(&self.numbers) * chirp.len() as u32);
        }
        self.rows += 1;
    }

    /// Calls `each` with the results of the four checks: stuck bits, repeated chirps, offset drift, clipping.
    pub fn report_checks(&self, each: &mut dyn FnMut(CheckResult)) {
        let mut check = |reason, value, limit| {
            each(CheckResult {
                reason,
                value,
                limit,
            });
        };
        check(Reason::AdcBit, self.stuck as i32, stuck_rows(&self.numbers));
        check(Reason::StaleChirp, self.stale as i32, 0);
        let walked = self
            .most
            .iter()
            .zip(&self.least)
            .map(|(&most, &least)| i32::from(most) - i32::from(least))
            .fold(0, i32::max);
        check(Reason::DcDrift, walked, max_offset_drift(&self.numbers));
        let clipped = PER_CENT * self.clipped / self.clipping_rows.max(1);
        check(Reason::Clipped, clipped as i32, MAX_CLIPPED_ROWS);
    }
}

/// Fractions of one in which the share of a chirp's samples at its extreme is counted.
const SHARE: u32 = 1000;
/// Returns the maximum share of a chirp's samples, in 1/[`SHARE`], that may equal the chirp's own minimum or maximum; a
/// chirp with more is clipped.
fn clipped(p: &Params) -> u32 {
    (p.clipped_share * SHARE as f32) as u32
}
/// Returns the maximum number of rows of a scan that may have a stuck bit by chance.
fn stuck_rows(p: &Params) -> i32 {
    p.lame_rows as i32
}
/// Returns the maximum drift of the offset (mean of I or of Q) during a scan, units of a sample.
fn max_offset_drift(p: &Params) -> i32 {
    (p.offset_walk * FULL_SCALE) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sin_cos;
    use crate::verdict::Reasons;

    /// A chirp of 200 samples: a strong tone with noise of a few units.
    fn chirp(row: u32) -> Vec<Iq> {
        let mut state = row.wrapping_mul(747_796_405).wrapping_add(1);
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 26) as i16 - 32
        };
        (0..200)
            .map(|n| {
                let (s, c) = sin_cos(0.047 * n as f32);
                Iq::new((9000.0 * c) as i16 + noise(), (9000.0 * s) as i16 + noise())
            })
            .collect()
    }

    fn stats(chirp: &[Iq]) -> RowStats {
        let ends = |of: fn(&Iq) -> i16| {
            let all = || chirp.iter().map(of);
            (
                all().min().unwrap(),
                all().max().unwrap(),
                all().map(i32::from).sum::<i32>() / 200,
            )
        };
        let (i, q) = (ends(|x| x.i), ends(|x| x.q));
        RowStats {
            mean: Iq::new(i.2 as i16, q.2 as i16),
            extremes: [Iq::new(i.0, q.0), Iq::new(i.1, q.1)],
            ..RowStats::default()
        }
    }

    fn failed_checks(change: impl Fn(u32, &mut Vec<Iq>)) -> Reasons {
        let mut converter = Converter::new(Numbers::DEFAULT);
        for row in 0..64 {
            let mut chirp = chirp(row);
            change(row, &mut chirp);
            converter.row(&chirp, &stats(&chirp));
        }
        let mut doubts = Reasons::NONE;
        converter.report_checks(&mut |check| {
            if check.value > check.limit {
                doubts.add(check.reason);
            }
        });
        doubts
    }

    #[test]
    fn a_good_converter_raises_no_doubt() {
        assert_eq!(failed_checks(|_, _| ()), Reasons::NONE);
        // A 12-bit converter.
        let coarse = |_, chirp: &mut Vec<Iq>| chirp.iter_mut().for_each(|x| x.i &= !15);
        assert_eq!(failed_checks(coarse), Reasons::NONE);
    }

    #[test]
    fn every_bit_between_others_is_missed() {
        for bit in 1..16 {
            for high in [false, true] {
                let stuck = |_, chirp: &mut Vec<Iq>| {
                    for x in chirp {
                        x.q = if high {
                            x.q | 1 << bit
                        } else {
                            x.q & !(1 << bit)
                        };
                    }
                };
                assert!(failed_checks(stuck).has(Reason::AdcBit), "bit {bit} {high}");
            }
        }
    }

    #[test]
    fn stale_cut_and_walking_chirps_are_reported() {
        let again = |row, chirp: &mut Vec<Iq>| {
            if row == 40 {
                *chirp = super::tests::chirp(33);
            }
        };
        assert_eq!(failed_checks(again), Reasons::NONE.with(Reason::StaleChirp));
        let cut = |_, chirp: &mut Vec<Iq>| {
            chirp.iter_mut().for_each(|x| x.i = x.i.clamp(-7000, 7000));
        };
        assert_eq!(failed_checks(cut), Reasons::NONE.with(Reason::Clipped));
        let walks = |row, chirp: &mut Vec<Iq>| {
            chirp.iter_mut().for_each(|x| x.q += 250 * row as i16);
        };
        // An offset beyond the swing also leaves the sign bit unchanged.
        assert!(failed_checks(walks).has(Reason::DcDrift));
    }
}
