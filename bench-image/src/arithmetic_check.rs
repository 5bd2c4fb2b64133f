//! Comparison of two arithmetics over random and adversarial chirps of all kinds of lengths, and a digest of
//! their rows.

use crc::{CRC_32_ISO_HDLC, Crc, Table};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use stairscan::Iq;
use stairscan::config::{CfarConfig, MountConfig, RadarConfig};
use stairscan::signal::grid::Row;
use stairscan::signal::range::packed::Arithmetic;
use stairscan::signal::range::{Processor, RowStats};

/// Chirp lengths, samples: each transform, full and zero-padded.
const LENGTHS: [u16; 10] = [200, 256, 129, 128, 100, 64, 50, 32, 17, 16];
/// Number of chirps of each length, for complex and for real samples.
const CHIRPS: usize = 1000;
/// Total number of chirps.
pub const TOTAL: usize = 2 * LENGTHS.len() * CHIRPS;

static CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISO_HDLC);

/// All results of one chirp.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Output {
    cells: [u8; 256],
    mask: [u32; 8],
    stats: RowStats,
}

impl Output {
    const fn new() -> Self {
        Self {
            cells: [0; 256],
            mask: [0; 8],
            stats: RowStats::EMPTY,
        }
    }

    fn fill<A: Arithmetic>(&mut self, processor: &mut Processor<A>, chirp: &[Iq]) {
        let bins = usize::from(processor.kept().count);
        let mut row = Row {
            cells: self.cells.get_mut(..bins).unwrap_or(&mut []),
            mask: self.mask.get_mut(..bins.div_ceil(32)).unwrap_or(&mut []),
        };
        self.stats = processor.process(chirp, &mut row).unwrap_or_default();
    }

    fn digest(&self, crc: &mut crc::Digest<'_, u32, Table<16>>) {
        crc.update(&self.cells);
        for word in self.mask {
            crc.update(&word.to_le_bytes());
        }
        let s = self.stats;
        for value in [s.saturated, s.swing, s.detections, s.mirror_place as u16] {
            crc.update(&value.to_le_bytes());
        }
        crc.update(&[s.mirror_echo, s.image, s.self_echo, s.before_window]);
        for x in [s.mean, s.extremes[0], s.extremes[1]] {
            crc.update(&x.i.to_le_bytes());
            crc.update(&x.q.to_le_bytes());
        }
    }
}

/// Fills `chirp` with the `n`-th test pattern.
fn provoke(chirp: &mut [Iq], n: usize, random: &mut Xoshiro128PlusPlus) {
    let rails = [i16::MIN, i16::MAX, -i16::MAX, 0];
    let word = random.next_u32();
    let any = Iq::new(word as i16, (word >> 16) as i16);
    let shift = word % 16;
    for (k, x) in chirp.iter_mut().enumerate() {
        let word = random.next_u32();
        let rail = |bits: u32| rails.get(bits as usize % 4).copied().unwrap_or(0);
        let alternating = if k % 2 == 0 { i16::MIN } else { i16::MAX };
        *x = match n % 8 {
            // Noise of any strength, on any offset.
            0 | 1 => Iq::new(word as i16 >> shift, (word >> 16) as i16 >> shift),
            2 => Iq::new(
                any.i.saturating_add(word as i16 >> shift),
                any.q.saturating_add((word >> 16) as i16 >> shift),
            ),
            // Full-scale values: at random, alternating, and constant.
            3 => Iq::new(rail(word), rail(word >> 2)),
            4 => Iq::new(
                alternating,
                if n % 16 < 8 {
                    alternating
                } else {
                    !alternating
                },
            ),
            5 => Iq::new(rail(n as u32 >> 3), rail(n as u32 >> 5)),
            // One impulse, and a step.
            6 => {
                if k == n % chirp_len(n) {
                    any
                } else {
                    Iq::default()
                }
            }
            _ => {
                if k < n % 256 {
                    any
                } else {
                    Iq::new(i16::MAX, i16::MIN)
                }
            }
        };
    }
}

/// Returns the number of samples among which the impulse of the `n`-th chirp is placed.
fn chirp_len(n: usize) -> usize {
    1 + n % 200
}

/// Result of a run over all chirps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Comparison {
    /// Number of chirps whose rows differ.
    pub mismatches: u32,
    /// CRC-32 over the first arithmetic's rows.
    pub digest: u32,
}

/// Processes all chirps with both arithmetics.
pub fn compare<A: Arithmetic, B: Arithmetic>() -> Comparison {
    let mut random = Xoshiro128PlusPlus::seed_from_u64(6);
    let (mut first, mut second) = (Processor::<A>::idle(), Processor::<B>::idle());
    let (mut a, mut b) = (Output::new(), Output::new());
    let mut crc = CRC.digest();
    let mut mismatches = 0;
    let mount = MountConfig {
        mirror_offset: 0,
        ..MountConfig::default()
    };
    let cfar = CfarConfig {
        near_margin: 0,
        ..CfarConfig::default()
    };
    let mut buffer = [Iq::default(); 256];
    for (samples, real) in [false, true]
        .into_iter()
        .flat_map(|real| LENGTHS.map(|n| (n, real)))
    {
        let radar = RadarConfig {
            samples,
            real,
            ..RadarConfig::default()
        };
        let ready = first.configure(&radar, &mount, &cfar).is_ok()
            && second.configure(&radar, &mount, &cfar).is_ok();
        let chirp = buffer.get_mut(..samples.into()).unwrap_or(&mut []);
        for n in 0..CHIRPS {
            provoke(chirp, n, &mut random);
            a.fill(&mut first, chirp);
            b.fill(&mut second, chirp);
            mismatches += u32::from(a != b || !ready);
            a.digest(&mut crc);
        }
    }
    Comparison {
        mismatches,
        digest: crc.finalize(),
    }
}
