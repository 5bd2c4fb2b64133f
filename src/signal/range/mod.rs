//! Range processing of a chirp to one row of the map: DC removal, window, FFT, power, CA-CFAR (paper II-A,
//! III-C).
//!
//! | pass | reads | does | module |
//! |---|---|---|---|
//! | 1 | chirp | mean, extremes, saturation | `window` |
//! | 2 | chirp | DC removal, normalisation, Hann window, first radix-4 stage | `window` |
//! | 3… | buffers | the other stages, the last straight into power | `fft` |
//! | last | power | logarithm, CA-CFAR | `log`, `cfar` |
//!
//! The arithmetic is 16-bit block floating point. The chirp's swing decides a power of two before the window,
//! and each stage's input magnitude decides how far the stage scales down. The exponent is carried along, so
//! that a weak chirp keeps its bits and cells of all chirps are comparable.
//!
//! # Logarithmic power
//! A cell counts 1/8 octave of power (0.376 dB) relative to the converter's full scale. A tone of amplitude
//! 32768 in a bin's middle gives [`FULL_SCALE`] = 247; √2 times that (both parts at full scale) gives 255; 0 is
//! 93 dB below full scale, near the rounding of a 16-bit converter after the transform. Profiles count 1/256
//! octave on the same scale.

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
use crate::signal::image::CoherentRow;
use cfar::Cfar;
use core::marker::PhantomData;
use log::FINE;
pub use log::FULL_SCALE;
use packed::{Arithmetic, Bin, Native, Packed};
use window::{ChirpLevels, Window};

/// Half width of the window's main lobe, native range bins.
const LOBE_BINS: f32 = 2.0;
/// Number of bins beyond those in which the mirror's echo can peak that its main lobe may still reach.
const NEAR_GAP_BINS: u16 = 1;
/// Maximum level of the I/Q image of an echo at its negative frequency, as a power of two below the echo:
/// 2^-10, -30 dB. A detection must be stronger.
const IMAGE_SHIFT: u32 = 10;

/// Statistics of one chirp for the health checks of radar and mirror.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RowStats {
    /// Number of samples whose I or Q is at full scale.
    pub saturated: u16,
    /// Maximum distance of any I or Q from its mean, units of 16-bit samples; at most 1 when the converter is
    /// silent.
    pub swing: u16,
    /// Means of I and of Q over the chirp's samples, units of 16-bit samples.
    pub mean: Iq,
    /// Minima of I and of Q over the chirp's samples, then their maxima, units of 16-bit samples.
    pub extremes: [Iq; 2],
    /// Level of the mirror's own echo, map units; 0 without a mirror.
    pub mirror_echo: u8,
    /// Range of the mirror echo's peak minus the range expected by the mirror's offset, 1/16 bin of the
    /// transform.
    pub mirror_place: i16,
    /// Level at the mirror's negative frequency, where an I/Q imbalance shows an image of its echo, map units.
    pub image: u8,
    /// Level of the strongest self-echo of the scanner, leakage or mirror, map units.
    pub self_echo: u8,
    /// Level of the strongest bin between the mirror's echo and the first kept bin, map units.
    pub before_window: u8,
    /// Number of CA-CFAR detections of the row.
    pub detections: u16,
}

impl RowStats {
    /// Initial value before the first chirp.
    pub const EMPTY: Self = Self {
        saturated: 0,
        swing: 0,
        mean: Iq { i: 0, q: 0 },
        extremes: [Iq { i: 0, q: 0 }; 2],
        mirror_echo: 0,
        mirror_place: 0,
        image: 0,
        self_echo: 0,
        before_window: 0,
        detections: 0,
    };
}

/// A chirp whose number of samples differs from the configured one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChirpLength {
    /// Number of samples of the chirp.
    pub got: usize,
    /// Number of samples per chirp of the configuration.
    pub expected: usize,
}

impl fmt::Display for ChirpLength {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { got, expected } = self;
        write!(f, "chirp: expected {expected} samples, got {got}")
    }
}

impl core::error::Error for ChirpLength {}

/// Range processor with this target's arithmetic.
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

/// Range processor: turns chirps into rows of the map. Some 6 KB: window, thresholds, transform buffers.
#[derive(Clone, Debug)]
pub struct Processor<A> {
    front_end: FrontEnd,
    kept: BinWindow,
    /// Bins of the transform in which the mirror's own echo can peak.
    mirror: BinWindow,
    /// Range of the mirror's own echo expected by the mirror's offset, 1/16 bin of the transform.
    mirror_at: i32,
    /// Bins of the image of the mirror's echo, at its negative frequency.
    image: BinWindow,
    /// All bins up to the end of `mirror` except bin 0, which holds no echo: leakage and mirror echo.
    self_echo: BinWindow,
    /// Bins between the mirror's echo and the first one that the map keeps.
    before_window: BinWindow,
    /// Offset from 256 · log2 of a bin's power in mantissas to its level in 1/256 octave above the map's zero,
    /// without gain and exponent of the chirp.
    offset: i32,
    cfar: Cfar,
    power: [u32; MAX_SAMPLES],
    /// Exponent of the last chirp's mantissas, and gain of its samples.
    scale: (i32, i32),
    arithmetic: PhantomData<A>,
}

impl<A: Arithmetic> Processor<A> {
    /// Creates a processor that refuses every chirp until [`Processor::configure`] is called: for statics,
    /// because a value of this size must not pass over the stack.
    pub const fn idle() -> Self {
        Self {
            front_end: FrontEnd {
                points: 0,
                window: Window::empty(),
                buffers: [[Packed::ZERO; MAX_SAMPLES]; 2],
                halved: false,
            },
            kept: BinWindow { first: 0, count: 0 },
            mirror: BinWindow { first: 0, count: 0 },
            mirror_at: 0,
            image: BinWindow { first: 0, count: 0 },
            self_echo: BinWindow { first: 0, count: 0 },
            before_window: BinWindow { first: 0, count: 0 },
            offset: 0,
            cfar: Cfar::empty(),
            power: [0; MAX_SAMPLES],
            // All bits zero, so that a static takes no flash.
            scale: (0, 0),
            arithmetic: PhantomData,
        }
    }

    /// Creates a processor for this radar, mount and detection.
    ///
    /// # Errors
    /// Returns the first field that is out of its range, or the bandwidth if no range bin remains beyond the
    /// near limit.
    pub fn new(
        radar: &RadarConfig,
        mount: &MountConfig,
        cfar: &CfarConfig,
    ) -> Result<Self, ConfigError> {
        let mut processor = Self::idle();
        processor.configure(radar, mount, cfar)?;
        Ok(processor)
    }

    /// Sets another configuration of radar, mount and detection; after an error the old one stays in force.
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

    /// Sets the configuration of a scan, whose map may be too small to keep all range bins of each row.
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
        // The negative frequency of bin k is bin N - k.
        let mirrored = |bin: u16| (radar.fft_len() as u16).saturating_sub(bin);
        self.image = match self.mirror.count {
            // Real samples have no negative frequencies.
            _ if radar.real => BinWindow::default(),
            0 => BinWindow::default(),
            _ => window(mirrored(end) + 1, mirrored(self.mirror.first) + 1),
        };
        self.self_echo = window(1, end);
        self.before_window = window(end + NEAR_GAP_BINS, kept.first);
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

    /// Returns the bins of the transform that a row of the map keeps.
    pub fn kept(&self) -> BinWindow {
        self.kept
    }

    /// Processes one chirp into one row of the map; cells beyond the kept bins are unchanged.
    ///
    /// # Errors
    /// A chirp of the wrong length leaves the row unchanged.
    pub fn process(&mut self, chirp: &[Iq], row: &mut Row<'_>) -> Result<RowStats, ChirpLength> {
        let (levels, offset) = self.measure(chirp)?;
        let power = self.power.get(..self.front_end.points).unwrap_or(&[]);
        log::fill_cells(self.kept.of(power), offset, row.cells);
        self.cfar.detect::<A>(self.kept.of(power), row.mask);
        let detections = self.keep(power, row.mask);
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
            self_echo: strongest(self.self_echo),
            before_window: strongest(self.before_window),
            detections,
        })
    }

    /// Returns the amplitude of a mantissa of 1 in the last chirp: a full-scale tone has amplitude 1.
    fn unit(&self) -> f32 {
        let (exponent, gain) = self.scale;
        // Mantissas are (x · c) · gain / 2^32 / 2^exponent; full scale is x = 2^15.
        math::exp2(exponent as f32 + 17.0) / (self.front_end.window.sum() * gain.max(1) as f32)
    }

    /// Returns the kept bins of the last processed chirp with the phase of the mirror's own echo taken out, and without
    /// that echo's I/Q image. They overwrite what [`Processor::phasors`] reads.
    #[inline(never)]
    pub fn coherent(&mut self) -> CoherentRow<'_> {
        let unit = self.unit();
        // Always the nominal bin, not the strongest one: one bin has one phase.
        let reference = (self.mirror_at / 16) as usize;
        let FrontEnd {
            points,
            ref window,
            ref mut buffers,
            halved,
        } = self.front_end;
        let [data, spare] = buffers;
        let bins: &mut [Packed] = match (data.get_mut(..points), spare.get_mut(..points)) {
            (Some(data), Some(spare)) if window.is_real() => {
                real::combine_complex::<A>(data, spare, halved)
            }
            (Some(data), Some(spare)) => fft::last_stage_complex::<A>(data, spare),
            _ => &mut [],
        };
        let mirror = bins.get(reference).filter(|_| self.mirror.count > 0);
        let phasor = mirror.map_or([1.0, 0.0], |x| [f32::from(x.re()), f32::from(x.im())]);
        // The I/Q image of the mirror's own echo hides whatever lies there.
        self.image.of_mut(bins).fill(Packed::ZERO);
        let kept = self.kept.of_mut(bins);
        let [re, im] = phasor;
        let size = math::hypot(re, im).max(1.0);
        let turn = Packed::new(fft::to_q15(re / size), fft::to_q15(-im / size));
        packed::turn::<A>(kept, turn);
        CoherentRow {
            bins: kept,
            unit,
            referenced: self.mirror.count > 0,
        }
    }

    /// Returns the complex values `[re, im]` of stored bin `bin` and of the mirror echo's nominal bin in the
    /// last processed chirp, whose phases can be compared; they have the scale of that chirp.
    pub fn phasors(&self, bin: u8) -> [[f32; 2]; 2] {
        let [data, spare] = &self.front_end.buffers;
        let stored = usize::from(self.kept.first) + usize::from(bin);
        // Always the nominal bin, not the strongest one: one bin has one phase.
        let mirror = (self.mirror_at / 16) as usize;
        let points = self.front_end.points;
        [stored, mirror].map(|bin| match self.front_end.window.is_real() {
            false => fft::bin(data, spare, points, bin),
            true => real::bin(data, spare, points, bin),
        })
    }

    /// Returns the range of the mirror echo's peak minus the expected one, 1/16 bin of the transform: a
    /// parabola through the logarithmic powers of its strongest bin and the two neighbours.
    fn mirror_place(&self, offset: i32) -> i16 {
        let power = self.power.get(..self.front_end.points).unwrap_or(&[]);
        let bins = (usize::from(self.mirror.first)..).zip(self.mirror.of(power));
        let Some((peak, _)) = bins.max_by_key(|&(_, p)| p) else {
            return 0;
        };
        let fine = |bin: usize| log::log2_fine(power.get(bin).copied().unwrap_or(0)) + offset;
        let (a, b, c) = (fine(peak.saturating_sub(1)), fine(peak), fine(peak + 1));
        let bend = (2 * b - a - c).max(1);
        // At a maximum the vertex of the parabola lies within half a bin to each side.
        let part = (8 * (c - a) / bend).clamp(-8, 8);
        (16 * peak as i32 + part - self.mirror_at) as i16
    }

    /// Processes one chirp into a profile: power and CA-CFAR threshold of all bins of the transform, for plots.
    ///
    /// # Errors
    /// A chirp of the wrong length leaves the profile unchanged.
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
            if let Some(word) = profile.detection_bits.get_mut(k / 32) {
                *word |= u32::from(cell.is_hit()) << (k % 32);
            }
        }
        profile.image_bits = profile.detection_bits;
        self.keep(power, &mut profile.detection_bits);
        let kept = profile.detection_bits;
        for (image, kept) in profile.image_bits.iter_mut().zip(kept) {
            *image &= !kept;
        }
        Ok(())
    }

    /// Transforms one chirp to its complex spectrum. `bins` receives the mantissas; the returned factor scales
    /// them so that a full-scale tone has amplitude 1.
    ///
    /// # Errors
    /// A chirp of the wrong length.
    pub fn spectrum(
        &mut self,
        chirp: &[Iq],
        bins: &mut [Packed; MAX_SAMPLES],
    ) -> Result<f32, ChirpLength> {
        let (levels, exponent) = self.front_end.run::<A, Packed>(chirp, bins)?;
        self.scale = (exponent, levels.gain());
        Ok(self.unit())
    }

    /// Removes those detections from `mask` that I/Q images may cause; returns the number of the others. Real
    /// samples have no images.
    fn keep(&self, power: &[u32], mask: &mut [u32]) -> u16 {
        match self.front_end.window.is_real() {
            false => remove_images(power, self.kept, mask),
            true => mask.iter().map(|word| word.count_ones() as u16).sum(),
        }
    }

    /// Computes the power of every bin of a chirp into `self.power`. Returns the chirp's levels, and the offset
    /// from 256 · log2 of a bin's power to its level in 1/256 octave above the map's zero.
    fn measure(&mut self, chirp: &[Iq]) -> Result<(ChirpLevels, i32), ChirpLength> {
        let (levels, exponent) = self.front_end.run::<A, u32>(chirp, &mut self.power)?;
        self.scale = (exponent, levels.gain());
        let gain = log::log2_fine(levels.gain() as u32);
        Ok((levels, self.offset + 512 * exponent - 2 * gain))
    }
}

/// Window and transform of a chirp to its spectrum, with their buffers.
#[derive(Clone, Debug)]
struct FrontEnd {
    points: usize,
    window: Window,
    buffers: [[Packed; MAX_SAMPLES]; 2],
    /// Whether the bins of the last chirp of real samples were halved.
    halved: bool,
}

impl FrontEnd {
    /// Transforms a chirp to `bins`. Returns the chirp's levels and the exponent e: the true values of the
    /// transform are 2^e times `bins`.
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
                let window = &self.window;
                let (exponent, halved) =
                    real::transform::<A, B>(chirp, &mut levels, window, points, buffers, bins);
                self.halved = halved;
                exponent
            }
            16 => self.transform::<A, B, 16>(chirp, &levels, bins),
            32 => self.transform::<A, B, 32>(chirp, &levels, bins),
            64 => self.transform::<A, B, 64>(chirp, &levels, bins),
            128 => self.transform::<A, B, 128>(chirp, &levels, bins),
            _ => self.transform::<A, B, 256>(chirp, &levels, bins),
        };
        Ok((levels, exponent))
    }

    /// Windows a chirp and transforms it to `bins` with N points. Returns the exponent e: the true values of the bins
    /// are 2^e times `bins`.
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
        let seen = window::window_and_first_stage::<A, N>(chirp, levels, &self.window, data);
        fft::finish::<A, B, N>(data, spare, bins, seen)
    }
}

/// Returns the bins in which the mirror's own echo can peak; none without a mirror.
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

/// Removes the detections from `mask` that are no stronger than the possible I/Q image of the echo at their
/// negative frequency (the mirror's own echo, for example); returns the number of the others.
fn remove_images(power: &[u32], kept: BinWindow, mask: &mut [u32]) -> u16 {
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

/// Limits a logarithmic power, 1/256 octave, to the 16 bits of a profile.
fn to_fine(fine: i32) -> i16 {
    fine.clamp(i16::MIN.into(), i16::MAX.into()) as i16
}
