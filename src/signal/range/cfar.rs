//! Cell-averaging CFAR over one range profile (paper III-C; Richards, Fundamentals of Radar Signal Processing,
//! ch. 6). Its cost does not depend on the number of training cells.
//!
//! A cell of power p is a detection if p > α · mean of its n training cells. Noise cells are exponentially
//! distributed and, because of window and zero padding, correlated with the matrix R of
//! [`Window::correlation`]. Their sum S then has E[exp(-sS)] = 1 / det(I + sR), so that a cell of independent
//! noise exceeds α S / n with probability
//!
//! ```text
//! P = 1 / det(I + (α / n) · R)
//! ```
//!
//! exactly. (With R = I this is the textbook's (1 + α / n)^-n.) The two sides are farther apart than the
//! correlation extends, so the determinant is the product of both sides' Toeplitz determinants, which the
//! Levinson-Durbin recursion gives for all lengths at once. Near the ends of the profile there are fewer
//! training cells, at last on one side only: each case has its own α.

use super::fft::MAX_POINTS;
use super::packed::Arithmetic;
use super::window::Window;
use crate::config::CfarConfig;
use crate::math;
use crate::signal::grid::BinWindow;

/// Maximum number of training cells on one side.
const MAX_TRAINING: usize = 32;
/// Maximum number of guard cells on one side.
const MAX_GUARD: usize = 16;
/// Number of zeros on each side of the profile, which make bounds checks unnecessary.
const PAD: usize = MAX_GUARD + MAX_TRAINING + 1;
/// Fractional bits of [`CellUnderTest::ratio`].
const RATIO_BITS: u32 = 24;

/// A cell under test with its training cells.
#[derive(Clone, Copy, Debug)]
pub struct CellUnderTest {
    /// Power of the cell under test.
    pub power: u32,
    /// Sum of the training cells' powers.
    pub training: u64,
    /// Ratio n / α of the number of training cells and the threshold factor, Q24; 0 without training cells.
    pub ratio: u32,
}

impl CellUnderTest {
    /// Returns whether the power exceeds the threshold α · training / n, without a division.
    #[inline(always)]
    pub fn is_hit(self) -> bool {
        u64::from(self.power) * u64::from(self.ratio) > self.training << RATIO_BITS
    }

    /// Returns 256 · log2 of the threshold α · training / n; `i32::MAX` without training cells.
    pub fn log_threshold(self) -> i32 {
        if self.ratio == 0 {
            return i32::MAX;
        }
        super::log::log2_wide(self.training) - super::log::log2_fine(self.ratio)
            + (RATIO_BITS * 256) as i32
    }
}

/// CA-CFAR for a given number of cells, window and false-alarm probability.
#[derive(Clone, Debug)]
pub struct Cfar {
    guard: usize,
    training: usize,
    cells: usize,
    ratios: [u32; MAX_POINTS],
    padded: [u32; MAX_POINTS + 2 * PAD],
}

impl Cfar {
    /// Creates a detector without cells; [`Cfar::shape`] sets them.
    pub const fn empty() -> Self {
        Self {
            guard: 0,
            training: 0,
            cells: 0,
            ratios: [0; MAX_POINTS],
            padded: [0; MAX_POINTS + 2 * PAD],
        }
    }

    /// Sets the detector up for the bins `kept` of a profile that was made with `window`.
    pub fn shape(&mut self, config: &CfarConfig, kept: BinWindow, window: &Window) {
        self.guard = usize::from(config.guard).min(MAX_GUARD);
        self.training = usize::from(config.training).min(MAX_TRAINING);
        self.cells = usize::from(kept.count).min(MAX_POINTS);
        self.padded.fill(0);
        let mut correlation = [0.0; MAX_TRAINING];
        for (distance, c) in correlation.iter_mut().enumerate().take(self.training) {
            *c = window.correlation(distance);
        }
        let side = |cells: usize| cells.saturating_sub(self.guard).min(self.training);
        let mut last = (usize::MAX, 0, 0);
        for (k, ratio) in self.ratios.iter_mut().enumerate().take(self.cells) {
            let (near, far) = (side(k), side(self.cells - 1 - k));
            // Neighbouring cells mostly have the same numbers of training cells, and then the same α.
            if (last.0, last.1) != (near, far) {
                let exact = count_over_alpha(&correlation, near, far, config.false_alarm);
                // The cast saturates. The 32nd bit is never needed: n / α ≤ 64 / 0.69.
                last = (near, far, (exact * (1u32 << RATIO_BITS) as f32) as u32);
            }
            *ratio = last.2;
        }
    }

    /// Returns each cell of a profile (`power` of the kept bins) with its training sum and ratio.
    pub fn run(&mut self, power: &[u32]) -> impl Iterator<Item = CellUnderTest> + '_ {
        self.load(power);
        let windows = Windows::new(self.guard, self.training);
        let from = PAD - windows.reach();
        let cells = self.padded.get(from..).unwrap_or(&[]);
        let tested = windows.tested(cells).iter().zip(&self.ratios);
        let sums = windows
            .steps(cells)
            .scan(windows.first_sum(&self.padded), |sum, step| {
                let training = *sum;
                *sum = training.wrapping_add_signed(step.into());
                Some(training)
            });
        tested
            .zip(sums)
            .take(self.cells)
            .map(|((&power, &ratio), training)| CellUnderTest {
                power,
                training,
                ratio,
            })
    }

    /// Tests the cells of a profile (`power` of the kept bins); bit k % 32 of word k / 32 of `mask` is set if
    /// cell k is a detection.
    pub fn detect<A: Arithmetic>(&mut self, power: &[u32], mask: &mut [u32]) {
        self.load(power);
        match (self.guard, self.training) {
            // The default numbers of cells are compiled as constants.
            (3, 8) => self.test(Windows::new(3, 8), mask, A::test_word::<3, 8>),
            (guard, training) => {
                let windows = Windows::new(guard, training);
                self.test(windows, mask, |cells, ratios, limit, unit| {
                    windows.test_word::<A>(cells, ratios, limit, unit)
                });
            }
        }
    }

    fn load(&mut self, power: &[u32]) {
        let cells = self
            .padded
            .get_mut(PAD..PAD + self.cells)
            .unwrap_or(&mut []);
        if let Some(power) = power.get(..cells.len()) {
            cells.copy_from_slice(power);
        }
    }

    /// Writes the detections to `mask`, 32 cells a word, each word by `test_word`. The zeros after the last
    /// cell give no detections.
    #[inline(always)]
    fn test(
        &self,
        windows: Windows,
        mask: &mut [u32],
        test_word: impl Fn(&[u32], &[u32; 32], u64, i32) -> (u32, u64),
    ) {
        // Plus one, because a detection must exceed the sum: p · ratio ≥ sum · 2^24 + 1.
        let mut limit = (windows.first_sum(&self.padded) << RATIO_BITS) + 1;
        let (ratios, _) = self.ratios.as_chunks::<32>();
        let from = self.padded.get(PAD - windows.reach()..).unwrap_or(&[]);
        let cells = from.windows(2 * windows.reach() + 33).step_by(32);
        for ((cells, ratios), word) in cells.zip(ratios).zip(mask) {
            (*word, limit) = test_word(cells, ratios, limit, 1 << RATIO_BITS);
        }
    }
}

/// Position of the training cells around the cell under test.
#[derive(Clone, Copy)]
struct Windows {
    guard: usize,
    training: usize,
}

impl Windows {
    #[inline(always)]
    fn new(guard: usize, training: usize) -> Self {
        Self { guard, training }
    }

    /// Returns the distance from the cell under test to the farthest training cell.
    #[inline(always)]
    fn reach(self) -> usize {
        self.guard + self.training
    }

    /// Returns the training sum of the profile's first cell, which has training cells on one side only.
    #[inline(always)]
    fn first_sum(self, padded: &[u32]) -> u64 {
        let behind = padded.iter().skip(PAD + self.guard + 1).take(self.training);
        behind.map(|&p| u64::from(p)).sum()
    }

    /// [`Arithmetic::test_word`] for any number of guard and training cells.
    #[inline(always)]
    fn test_word<A: Arithmetic>(
        self,
        cells: &[u32],
        ratios: &[u32; 32],
        mut limit: u64,
        unit: i32,
    ) -> (u32, u64) {
        let mut bits = 0;
        let tested = self.tested(cells).iter().zip(ratios);
        for ((power, ratio), step) in tested.zip(self.steps(cells)) {
            let value = u64::from(*power) * u64::from(*ratio);
            (bits, limit) = A::test(bits, value, limit, step, unit);
        }
        (bits, limit)
    }

    /// Returns the cells under test within `cells`, which begins with the first one's first training cell and
    /// ends after the last one's last.
    #[inline(always)]
    fn tested(self, cells: &[u32]) -> &[u32] {
        part(cells, self.reach(), self)
    }

    /// Returns the change of the training sum from each cell under test to the next. `cells` begins with the
    /// first one's first training cell and ends after the last one's last.
    #[inline(always)]
    fn steps(self, cells: &[u32]) -> impl Iterator<Item = i32> {
        let leaves_first = part(cells, 0, self);
        let enters_first = part(cells, self.training, self);
        let leaves_last = part(cells, self.reach() + self.guard + 1, self);
        let enters_last = part(cells, 2 * self.reach() + 1, self);
        let enters = enters_first.iter().zip(enters_last);
        let leaves = leaves_first.iter().zip(leaves_last);
        // Powers are below 2^30, so the difference fits.
        enters.zip(leaves).map(|((e1, e2), (l1, l2))| {
            e1.wrapping_add(*e2).wrapping_sub(*l1).wrapping_sub(*l2) as i32
        })
    }
}

/// Returns the part of `cells` from `start` whose length is the number of cells under test.
#[inline(always)]
fn part(cells: &[u32], start: usize, windows: Windows) -> &[u32] {
    let tested = cells.len().saturating_sub(2 * windows.reach() + 1);
    cells.get(start..start + tested).unwrap_or(&[])
}

/// Returns n / α for n = `near` + `far` training cells on the two sides and false-alarm probability `wanted`; 0
/// without training cells.
fn count_over_alpha(correlation: &[f32], near: usize, far: usize, wanted: f32) -> f32 {
    if near + far == 0 {
        return 0.0;
    }
    let wanted = -math::log2(wanted);
    // Bisection over log2(α / n): log2 det increases with it from 0 without bound.
    let (mut low, mut high) = (-8.0f32, 32.0f32);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if log2_determinants(correlation, near, far, math::exp2(middle)) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    math::exp2(-0.5 * (low + high))
}

/// Returns log2 det(I + s R) for the `near` training cells of one side plus that for the `far` cells of the
/// other, where R is the symmetric Toeplitz matrix of the noise's `correlation` over the distance in cells.
///
/// Levinson-Durbin recursion: the determinant is the product of the prediction errors.
fn log2_determinants(correlation: &[f32], near: usize, far: usize, s: f32) -> f32 {
    let at = |lag: usize| s * correlation.get(lag).copied().unwrap_or(0.0);
    let mut predictor = [0.0f32; MAX_TRAINING];
    let mut error = 1.0 + at(0);
    let mut sum = 0.0;
    for order in 0..near.max(far).min(MAX_TRAINING) {
        if order > 0 {
            let taken = &predictor[..order - 1];
            let dot: f32 = taken
                .iter()
                .zip(1..)
                .map(|(a, lag)| a * at(order - lag))
                .sum();
            let reflection = (at(order) - dot) / error;
            let previous = predictor;
            let mirrored = previous[..order - 1].iter().rev();
            for (a, b) in predictor.iter_mut().zip(mirrored) {
                *a -= reflection * b;
            }
            predictor[order - 1] = reflection;
            error *= 1.0 - reflection * reflection;
        }
        let both = u8::from(order < near) + u8::from(order < far);
        sum += f32::from(both) * math::log2(error);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::range::packed::Native;
    use proptest::prelude::*;

    fn shaped(config: &CfarConfig, cells: u16) -> Cfar {
        let mut window = Window::empty();
        window.shape(200, 256);
        let mut cfar = Cfar::empty();
        let kept = BinWindow {
            first: 0,
            count: cells,
        };
        cfar.shape(config, kept, &window);
        cfar
    }

    proptest! {
        #[test]
        fn running_sums_equal_the_definition(
            power in prop::collection::vec(prop_oneof![0u32..100, 0u32..1 << 30], 1..=256),
            (guard, training) in prop_oneof![(0u8..=16, 1u8..=32), Just((3, 8))],
        ) {
            let config = CfarConfig { guard, training, ..CfarConfig::default() };
            let mut cfar = shaped(&config, power.len() as u16);
            let (guard, training) = (usize::from(guard), usize::from(training));
            let cells: Vec<_> = cfar.run(&power).collect();
            let mut mask = [0; 8];
            cfar.detect::<Native>(&power, &mut mask);
            for (k, cell) in cells.iter().enumerate() {
                prop_assert_eq!(mask[k / 32] >> (k % 32) & 1 != 0, cell.is_hit(), "cell {}", k);
            }
            prop_assert_eq!(cells.len(), power.len());
            for (k, cell) in cells.into_iter().enumerate() {
                let tested = |&j: &usize| (guard + 1..=guard + training).contains(&j.abs_diff(k));
                let window: Vec<_> = (0..power.len()).filter(tested).collect();
                let sum: u64 = window.iter().map(|&j| u64::from(power[j])).sum();
                prop_assert_eq!(cell.power, power[k]);
                prop_assert_eq!(cell.training, sum);
                prop_assert_eq!(cell.ratio == 0, window.is_empty());
                // The logarithmic threshold agrees with the comparison.
                let log = crate::signal::range::log::log2_fine(cell.power);
                if cell.power > 0 && cell.training > 0 && (log - cell.log_threshold()).abs() > 3 {
                    prop_assert_eq!(cell.is_hit(), log > cell.log_threshold());
                }
            }
        }
    }

    /// Returns det(I + sR) for `cells` training cells by Gaussian elimination in f64.
    fn determinant(correlation: &[f32], cells: usize, s: f64) -> f64 {
        let entry = |i: usize, j: usize| {
            let r = s * f64::from(correlation[i.abs_diff(j)]);
            if i == j { 1.0 + r } else { r }
        };
        let mut m: Vec<Vec<f64>> = (0..cells)
            .map(|i| (0..cells).map(|j| entry(i, j)).collect())
            .collect();
        let mut product = 1.0;
        for k in 0..cells {
            product *= m[k][k];
            for i in k + 1..cells {
                let (upper, lower) = m.split_at_mut(i);
                let f = lower[0][k] / upper[k][k];
                for (x, y) in lower[0].iter_mut().zip(&upper[k]).skip(k) {
                    *x -= f * y;
                }
            }
        }
        product
    }

    #[test]
    fn alpha_gives_the_wanted_probability() {
        for (samples, points) in [(200, 256), (64, 64), (129, 256)] {
            let mut window = Window::empty();
            window.shape(samples, points);
            let correlation: Vec<_> = (0..32).map(|d| window.correlation(d)).collect();
            for (near, far) in [(0, 1), (0, 8), (3, 8), (8, 8), (32, 32)] {
                for wanted in [1e-2f32, 1.7e-4, 1e-6] {
                    let s = 1.0 / f64::from(count_over_alpha(&correlation, near, far, wanted));
                    let both = [near, far].map(|n| determinant(&correlation, n, s));
                    let reached = 1.0 / (both[0] * both[1]);
                    let off = reached / f64::from(wanted);
                    assert!(
                        (0.98..1.02).contains(&off),
                        "{near} + {far} at {wanted}: {off}"
                    );
                }
            }
        }
    }

    #[test]
    fn independent_cells_give_the_textbook_factor() {
        let mut white = [0.0; 32];
        white[0] = 1.0;
        // Richards, eq. 6.45: α = n (P^(-1/n) - 1).
        let exact = 16.0 * (1e-4f64.powf(-1.0 / 16.0) - 1.0);
        let alpha = 16.0 / f64::from(count_over_alpha(&white, 8, 8, 1e-4));
        assert!((alpha / exact - 1.0).abs() < 1e-3);
    }

    #[test]
    fn the_default_probability_stands_for_12_db() {
        let cfar = shaped(&CfarConfig::default(), 217);
        let ratio = f64::from(cfar.ratios[100]) / f64::from(1 << RATIO_BITS);
        let db = 10.0 * (16.0 / ratio).log10();
        assert!((db - 12.0).abs() < 0.05, "{db} dB");
    }
}
