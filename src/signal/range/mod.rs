//! From chirp to one row of the map: DC removal, window, FFT, power, CA-CFAR (paper II-A, III-C).
//!
//! | pass | reads | does | module |
//! |---|---|---|---|
//! | 1 | chirp | mean, extremes, saturation | `window` |
//! | 2 | chirp | DC removal, normalisation, Hann window, first radix-4 stage | `window` |
//! | 3… | buffers | the other stages, the last straight into power | `fft` |
//! | last | power | logarithm, CA-CFAR | `log`, `cfar` |
//!
//! Arithmetic is 16-bit block floating point: the chirp's swing decides a power of two before the
//! window, and each stage decides from its input's magnitude how far it scales down. The exponent
//! is carried along, so that a weak chirp keeps its bits and cells of all chirps compare.
//!
//! # Logarithmic power
//! A cell counts 1/8 octave of power (0.376 dB). Its reference is the converter's full scale: a
//! tone of amplitude 32768 in a bin's middle gives [`FULL_SCALE`] = 247; √2 times that (both
//! parts at full scale) gives 255; 0 is 93 dB below full scale, near the rounding of a 16-bit
//! converter seen through the transform. Profiles count 1/256 octave on the same scale.

pub mod cfar;
pub mod fft;
pub mod log;
pub mod packed;
mod profile;
mod real;
pub mod window;

#[cfg(test)]
mod tests;

use core::fmt;

pub use profile::{Detection, Profile};

use crate::Iq;
use crate::config::{
    CfarConfig, Config, ConfigError, MAX_SAMPLES, MountConfig, RadarConfig, check,
};
use crate::math;
use crate::signal::grid::{BinWindow, Row};
use cfar::Cfar;
use core::marker::PhantomData;
use log::FINE;
pub use log::FULL_SCALE;
use packed::{Arithmetic, Bin, Native, Packed};
use window::{ChirpLevels, Window};

/// Half width of the window's main lobe in native range bins.
const LOBE_BINS: f32 = 2.0;
/// Bins beyond those of the mirror's echo that its lobe may still reach.
const NEAR_GAP_BINS: u16 = 1;
/// What an I/Q imbalance leaves of an echo at its negative frequency is weaker than this power of
/// two (30 dB): a hit must be stronger.
const IMAGE_SHIFT: u32 = 10;

/// What one chirp tells beside its row: the health of radar and mirror.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RowStats {
    /// Samples whose I or Q stands at full scale.
    pub saturated: u16,
    /// Largest distance of any I or Q from its mean: at most 1 when the converter is silent.
    pub swing: u16,
    /// Means of I and Q.
    pub mean: Iq,
    /// Least and greatest I and Q.
    pub extremes: [Iq; 2],
    /// Logarithmic power of the mirror's own echo, map units; 0 without a mirror.
    pub mirror_echo: u8,
    /// Where it peaks within the bins in which it is looked for, 1/16 bin from its place by the
    /// mirror's offset.
    pub mirror_place: i16,
    /// Logarithmic power at the mirror's negative frequency, where an unlike I and Q show it again.
    pub image: u8,
    /// Logarithmic power of the strongest of what the scanner shows of itself: leakage or mirror.
    pub inside: u8,
    /// Logarithmic power of what stands between the mirror's echo and the first kept bin.
    pub near: u8,
    /// Cells that CA-CFAR let through.
    pub hits: u16,
}

impl RowStats {
    /// Before the first chirp.
    pub const EMPTY: Self = Self {
        saturated: 0,
        swing: 0,
        mean: Iq { i: 0, q: 0 },
        extremes: [Iq { i: 0, q: 0 }; 2],
        mirror_echo: 0,
        mirror_place: 0,
        image: 0,
        inside: 0,
        near: 0,
        hits: 0,
    };
}

/// A chirp that has not the configured number of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChirpLength {
    /// Samples of the chirp.
    pub got: usize,
    /// Samples per chirp of the configuration.
    pub expected: usize,
}

impl fmt::Display for ChirpLength {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { got, expected } = self;
        write!(f, "chirp: expected {expected} samples, got {got}")
    }
}

impl core::error::Error for ChirpLength {}

/// Turns chirps into rows of the map, with this target's arithmetic.
///
/// ```
/// use stairscan::Iq;
/// use stairscan::config::Config;
/// use stairscan::signal::range::{Profile, RangeProcessor};
///
/// let config = Config::default();
/// let mut range = RangeProcessor::new(&config.radar, &config.mount, &config.cfar)?;
/// // A quarter turn a sample: native bin 50 of 200 (0.75 m), bin 64 of the transform of 256 points.
/// let chirp: Vec<Iq> = (0..200)
///     .map(|n| [(3000, 0), (0, 3000), (-3000, 0), (0, -3000)][n % 4])
///     .map(|(i, q)| Iq::new(i, q))
///     .collect();
/// let mut profile = Profile::default();
/// range.profile(&chirp, &mut profile)?;
/// let strongest = profile
///     .detections()
///     .max_by(|a, b| a.power_db.total_cmp(&b.power_db))
///     .unwrap();
/// assert!((strongest.bin - 64.0).abs() < 0.1);
/// // 20 lg (3000 / 32768).
/// assert!((strongest.power_db + 20.8).abs() < 0.2);
/// // Chirps of another length are refused.
/// assert!(range.profile(&chirp[..100], &mut profile).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type RangeProcessor = Processor<Native>;

/// Turns chirps into rows of the map. Some 6 KB: window, thresholds, transform buffers.
#[derive(Clone, Debug)]
pub struct Processor<A> {
    front_end: FrontEnd,
    kept: BinWindow,
    /// Bins around the mirror's echo …
    mirror: BinWindow,
    /// … its place by the mirror's offset, 1/16 bin …
    mirror_at: i32,
    /// … those of its image at its negative frequency …
    image: BinWindow,
    /// … all up to its end but the first, which holds no echo …
    inside: BinWindow,
    /// … and those from its end to the kept ones.
    near: BinWindow,
    /// 1/256 octaves from log2 of a mantissa's power to the reference, but for gain and exponent.
    offset: i32,
    cfar: Cfar,
    power: [u32; MAX_SAMPLES],
    arithmetic: PhantomData<A>,
}

impl<A: Arithmetic> Processor<A> {
    /// A processor that refuses every chirp, until [`Processor::configure`] shapes it: for
    /// statics, where a value as large as this must not pass over the stack.
    pub const fn idle() -> Self {
        Self {
            front_end: FrontEnd {
                points: 0,
                window: Window::empty(),
                buffers: [[Packed::ZERO; MAX_SAMPLES]; 2],
            },
            kept: BinWindow { first: 0, count: 0 },
            mirror: BinWindow { first: 0, count: 0 },
            mirror_at: 0,
            image: BinWindow { first: 0, count: 0 },
            inside: BinWindow { first: 0, count: 0 },
            near: BinWindow { first: 0, count: 0 },
            offset: 0,
            cfar: Cfar::empty(),
            power: [0; MAX_SAMPLES],
            arithmetic: PhantomData,
        }
    }

    /// A processor for this radar, mount and detection.
    ///
    /// # Errors
    /// Names the first field that is out of its range, or the bandwidth when no range bin is left
    /// beyond the near limit.
    pub fn new(
        radar: &RadarConfig,
        mount: &MountConfig,
        cfar: &CfarConfig,
    ) -> Result<Self, ConfigError> {
        let mut processor = Self::idle();
        processor.configure(radar, mount, cfar)?;
        Ok(processor)
    }

    /// Takes another configuration; on an error the old one stays.
    ///
    /// # Errors
    /// Those of [`Processor::new`].
    pub fn configure(
        &mut self,
        radar: &RadarConfig,
        mount: &MountConfig,
        cfar: &CfarConfig,
    ) -> Result<(), ConfigError> {
        let kept = BinWindow::new(radar, mount, cfar);
        self.set(radar, mount, cfar, kept)
    }

    /// The same for a scan, whose map may not hold every bin.
    ///
    /// # Errors
    /// Those of [`Processor::new`].
    pub fn configure_scan(&mut self, config: &Config) -> Result<(), ConfigError> {
        let kept = BinWindow::of_scan(config);
        self.set(&config.radar, &config.mount, &config.cfar, kept)
    }

    fn set(
        &mut self,
        radar: &RadarConfig,
        mount: &MountConfig,
        cfar: &CfarConfig,
        kept: BinWindow,
    ) -> Result<(), ConfigError> {
        radar.validate()?;
        mount.limits()?;
        cfar.limits()?;
        check(
            kept.count > 0,
            "bandwidth",
            "range bins beyond the mirror and the near margin",
        )?;
        self.mirror = mirror_bins(radar, mount);
        self.mirror_at = math::round(16.0 * mount.mirror_offset_m() / radar.bin_spacing_m()) as i32;
        let end = self.mirror.first + self.mirror.count;
        let window = |first: u16, end: u16| BinWindow {
            first,
            count: end.saturating_sub(first),
        };
        // Bin k's negative frequency is bin N - k.
        let mirrored = |bin: u16| (radar.fft_len() as u16).saturating_sub(bin);
        self.image = match self.mirror.count {
            // Real samples have no negative frequencies.
            _ if radar.real => BinWindow::default(),
            0 => BinWindow::default(),
            _ => window(mirrored(end) + 1, mirrored(self.mirror.first) + 1),
        };
        self.inside = window(1, end);
        self.near = window(end + NEAR_GAP_BINS, kept.first);
        let FrontEnd { points, window, .. } = &mut self.front_end;
        *points = radar.fft_len();
        match radar.real {
            false => window.shape(radar.samples.into(), *points),
            true => window.shape_real(radar.samples.into(), *points),
        }
        let reference = 512.0 * (math::log2(window.sum()) - 17.0);
        self.offset = i32::from(FULL_SCALE) * FINE - math::round(reference) as i32;
        self.kept = kept;
        self.cfar.shape(cfar, kept, window);
        Ok(())
    }

    /// The bins that rows keep.
    pub fn kept(&self) -> BinWindow {
        self.kept
    }

    /// Works one chirp off into one row of the map; cells beyond the kept bins stay as they are.
    ///
    /// # Errors
    /// A chirp of the wrong length leaves the row untouched.
    pub fn process(&mut self, chirp: &[Iq], row: &mut Row<'_>) -> Result<RowStats, ChirpLength> {
        let (levels, offset) = self.measure(chirp)?;
        let power = self.power.get(..self.front_end.points).unwrap_or(&[]);
        log::fill_cells(self.kept.of(power), offset, row.cells);
        self.cfar.detect::<A>(self.kept.of(power), row.mask);
        let hits = self.keep(power, row.mask);
        let cell = |p: u32| log::to_cell(log::log2_fine(p) + offset);
        let strongest = |bins: BinWindow| bins.of(power).iter().copied().max().map_or(0, cell);
        Ok(RowStats {
            saturated: levels.saturated,
            swing: levels.swing.min(u32::from(u16::MAX)) as u16,
            mean: levels.mean(),
            extremes: levels.extremes,
            mirror_echo: strongest(self.mirror),
            mirror_place: self.mirror_place(offset),
            image: strongest(self.image),
            inside: strongest(self.inside),
            near: strongest(self.near),
            hits,
        })
    }

    /// The complex values of stored bin `bin` and of the mirror's echo in the chirp that was processed
    /// last, to compare their phases; their scale is that chirp's own.
    pub fn phasors(&self, bin: u8) -> [[f32; 2]; 2] {
        let [data, spare] = &self.front_end.buffers;
        let stored = usize::from(self.kept.first) + usize::from(bin);
        // The bin that holds the mirror's place, whichever is strongest: one bin, one phase.
        let mirror = (self.mirror_at / 16) as usize;
        let points = self.front_end.points;
        [stored, mirror].map(|bin| match self.front_end.window.is_real() {
            false => fft::bin(data, spare, points, bin),
            true => real::bin(data, spare, points, bin),
        })
    }

    /// Where the mirror's echo peaks: a parabola through the logarithms of its strongest bin and the
    /// two beside it, 1/16 bin from its place by the mirror's offset.
    fn mirror_place(&self, offset: i32) -> i16 {
        let power = self.power.get(..self.front_end.points).unwrap_or(&[]);
        let bins = (usize::from(self.mirror.first)..).zip(self.mirror.of(power));
        let Some((peak, _)) = bins.max_by_key(|&(_, p)| p) else {
            return 0;
        };
        let fine = |bin: usize| log::log2_fine(power.get(bin).copied().unwrap_or(0)) + offset;
        let (a, b, c) = (fine(peak.saturating_sub(1)), fine(peak), fine(peak + 1));
        let bend = (2 * b - a - c).max(1);
        // Between the two bins beside it: half a bin to each side where it is a maximum.
        let part = (8 * (c - a) / bend).clamp(-8, 8);
        (16 * peak as i32 + part - self.mirror_at) as i16
    }

    /// Works one chirp off into a profile of all bins of the transform, for people to look at.
    ///
    /// # Errors
    /// A chirp of the wrong length leaves the profile untouched.
    pub fn profile(&mut self, chirp: &[Iq], profile: &mut Profile) -> Result<(), ChirpLength> {
        let (_, offset) = self.measure(chirp)?;
        let power = self.power.get(..self.front_end.points).unwrap_or(&[]);
        profile.clear(self.front_end.points, self.kept);
        for (to, &p) in profile.power.iter_mut().zip(power) {
            *to = to_fine(log::log2_fine(p) + offset);
        }
        let thresholds = profile.threshold.iter_mut().skip(self.kept.first.into());
        for ((k, to), cell) in thresholds
            .enumerate()
            .zip(self.cfar.run(self.kept.of(power)))
        {
            *to = to_fine(cell.log_threshold().saturating_add(offset));
            if let Some(word) = profile.hits.get_mut(k / 32) {
                *word |= u32::from(cell.is_hit()) << (k % 32);
            }
        }
        self.keep(power, &mut profile.hits);
        Ok(())
    }

    /// Transforms one chirp for those who want its complex spectrum: every bin's mantissa, and what
    /// to multiply it by so that a full-scale tone has amplitude 1.
    ///
    /// # Errors
    /// A chirp of the wrong length.
    pub fn spectrum(
        &mut self,
        chirp: &[Iq],
        bins: &mut [Packed; MAX_SAMPLES],
    ) -> Result<f32, ChirpLength> {
        let (levels, exponent) = self.front_end.run::<A, Packed>(chirp, bins)?;
        // Mantissas are (x · c) · gain / 2^32 / 2^exponent; full scale is x = 2^15.
        let unit = math::exp2(exponent as f32 + 17.0);
        Ok(unit / (self.front_end.window.sum() * levels.gain() as f32))
    }

    /// Takes hits that are images out of the mask; returns the number that stay. Real samples have no
    /// images.
    fn keep(&self, power: &[u32], mask: &mut [u32]) -> u16 {
        match self.front_end.window.is_real() {
            false => without_images(power, self.kept, mask),
            true => mask.iter().map(|word| word.count_ones() as u16).sum(),
        }
    }

    /// Chirp to power of every bin; returns what to add to 256 · log2 of it as well.
    fn measure(&mut self, chirp: &[Iq]) -> Result<(ChirpLevels, i32), ChirpLength> {
        let (levels, exponent) = self.front_end.run::<A, u32>(chirp, &mut self.power)?;
        let gain = log::log2_fine(levels.gain() as u32);
        Ok((levels, self.offset + 512 * exponent - 2 * gain))
    }
}

/// Chirp to spectrum: window and transform with their buffers.
#[derive(Clone, Debug)]
struct FrontEnd {
    points: usize,
    window: Window,
    buffers: [[Packed; MAX_SAMPLES]; 2],
}

impl FrontEnd {
    /// Returns the exponent e as well: true values of the transform are 2^e times the bins given.
    fn run<A: Arithmetic, B: Bin>(
        &mut self,
        chirp: &[Iq],
        bins: &mut [B; MAX_SAMPLES],
    ) -> Result<(ChirpLevels, i32), ChirpLength> {
        let expected = self.window.samples();
        if chirp.len() != expected || expected == 0 {
            let got = chirp.len();
            return Err(ChirpLength { got, expected });
        }
        let mut levels = ChirpLevels::of::<A>(chirp);
        let exponent = match self.points {
            _ if self.window.is_real() => {
                let (points, buffers) = (self.points, &mut self.buffers);
                real::transform::<A, B>((chirp, &mut levels), &self.window, points, buffers, bins)
            }
            16 => self.transform::<A, B, 16>(chirp, &levels, bins),
            32 => self.transform::<A, B, 32>(chirp, &levels, bins),
            64 => self.transform::<A, B, 64>(chirp, &levels, bins),
            128 => self.transform::<A, B, 128>(chirp, &levels, bins),
            _ => self.transform::<A, B, 256>(chirp, &levels, bins),
        };
        Ok((levels, exponent))
    }

    /// The transform's passes for N points.
    fn transform<A: Arithmetic, B: Bin, const N: usize>(
        &mut self,
        chirp: &[Iq],
        levels: &ChirpLevels,
        bins: &mut [B; MAX_SAMPLES],
    ) -> i32 {
        let [data, spare] = &mut self.buffers;
        // N is one of the sizes that the buffers hold.
        let (Some(data), Some(spare), Some(bins)) = (
            data.first_chunk_mut::<N>(),
            spare.first_chunk_mut::<N>(),
            bins.first_chunk_mut::<N>(),
        ) else {
            return 0;
        };
        let seen = window::open::<A, N>(chirp, levels, &self.window, data);
        fft::finish::<A, B, N>(data, spare, bins, seen)
    }
}

/// Bins in which the mirror's own echo peaks; none without a mirror.
fn mirror_bins(radar: &RadarConfig, mount: &MountConfig) -> BinWindow {
    if mount.mirror_offset <= 0 {
        return BinWindow::default();
    }
    let spacing = radar.bin_spacing_m();
    let reach = LOBE_BINS * radar.range_resolution_m();
    let low = math::ceil((mount.mirror_offset_m() - reach).max(0.0) / spacing) as u16;
    let high = math::floor((mount.mirror_offset_m() + reach) / spacing) as u16;
    let high = high.min(radar.fft_len() as u16 - 1);
    BinWindow {
        first: low,
        count: (high + 1).saturating_sub(low),
    }
}

/// Takes out the hits that are no stronger than what an I/Q imbalance makes of the echo at their
/// negative frequency (the mirror's own echo, for one); returns the number that stay.
fn without_images(power: &[u32], kept: BinWindow, mask: &mut [u32]) -> u16 {
    let at = |bin: usize| power.get(bin).copied().unwrap_or(0);
    let mut count = 0;
    for (first, word) in (usize::from(kept.first)..).step_by(32).zip(mask) {
        let mut rest = *word;
        while rest != 0 {
            let bit = rest.trailing_zeros();
            rest &= rest - 1;
            let bin = first + bit as usize;
            let image = at(power.len().saturating_sub(bin)) >> IMAGE_SHIFT;
            if at(bin) > image {
                count += 1;
            } else {
                *word &= !(1 << bit);
            }
        }
    }
    count
}

/// Saturates 1/256 octaves to what a profile holds.
fn to_fine(fine: i32) -> i16 {
    fine.clamp(i16::MIN.into(), i16::MAX.into()) as i16
}
