//! Particles: a probability density as weighted samples in two coordinates (paper III-A).
//!
//! A [`PointCloud`] holds samples in *modes*. Each mode is a subset that is normalised and resampled on its own, so
//! that a weak place keeps its share beside a strong one. Coordinates and weights are defined by the estimator: cells
//! of the map while the particles are weighted, places in the sagittal plane once they are clustered. A particle has
//! eight bytes, all operations are in place, and arithmetic is in integers.

use core::num::NonZeroU32;

use heapless::Vec;
use rand_core::Rng;

pub use crate::config::MAX_PARTICLES;
use crate::math;
pub use crate::observer::paper_trace::{PointParticle, UNITS_PER_CELL};
use crate::sort::shell_sort;

/// Maximum number of modes of one cloud.
pub const MAX_CLOUD_MODES: usize = 64;

/// A normal density in two coordinates without correlation, from which particles are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gaussian {
    /// Mean of each coordinate, units of 1/64 cell.
    pub mean: [i16; 2],
    /// Standard deviation of each coordinate, units of 1/64 cell.
    pub sigma: [u16; 2],
}

impl Gaussian {
    /// Draws the coordinates of one particle; they saturate at 16 bits.
    pub fn draw(&self, rng: &mut impl Rng) -> [i16; 2] {
        let mut at = self.mean;
        for (c, &sigma) in at.iter_mut().zip(&self.sigma) {
            // 16 bits times |z| < 2^14.
            let offset = (i32::from(sigma) * standard_normal(rng)) >> 12;
            let value = i32::from(*c) + offset;
            *c = value.clamp(i16::MIN.into(), i16::MAX.into()) as i16;
        }
        at
    }
}

/// Returns a standard normal deviate in Q12, |z| ≤ 3.45.
///
/// It is the sum of four uniform bytes (Irwin–Hall, excess kurtosis -0.3): it needs one random word and has the same
/// bits on every platform. The tails are sufficient for the start of the particles.
pub fn standard_normal(rng: &mut impl Rng) -> i32 {
    // Four bytes: mean 510, variance 4 (256² - 1) / 12 = 147.80².
    const Q12_PER_SIGMA_X256: i32 = (4096.0 * 256.0 / 147.8) as i32;
    // Adds two bytes at a time, and then the two sums.
    let word = rng.next_u32();
    let pairs = (word & 0x00ff_00ff) + (word >> 8 & 0x00ff_00ff);
    let sum = (pairs + (pairs >> 16)) as u16;
    ((i32::from(sum) - 510) * Q12_PER_SIGMA_X256) >> 8
}

/// Returns a random integer from 0 to `below` - 1, evenly distributed to within 2⁻³² `below`; 0 for 0.
pub fn uniform(rng: &mut impl Rng, below: u32) -> u32 {
    ((u64::from(rng.next_u32()) * u64::from(below)) >> 32) as u32
}

/// Weighted particles in modes (subsets that are resampled separately), with the capacity of a scan.
pub type PointCloud = SizedCloud<MAX_PARTICLES>;

/// Weighted particles in modes (subsets that are resampled separately), at most `N` particles.
#[derive(Debug, Default)]
pub struct SizedCloud<const N: usize> {
    particles: Vec<PointParticle, N>,
    /// Index of the first particle behind each mode.
    ends: Vec<u16, MAX_CLOUD_MODES>,
}

impl<const N: usize> SizedCloud<N> {
    /// Returns a cloud without particles.
    pub const fn new() -> Self {
        Self {
            particles: Vec::new(),
            ends: Vec::new(),
        }
    }

    /// Removes all particles and modes.
    pub fn clear(&mut self) {
        self.particles.clear();
        self.ends.clear();
    }

    /// Returns all particles, mode after mode.
    pub fn particles(&self) -> &[PointParticle] {
        &self.particles
    }

    /// Returns all particles for a change of place or weight.
    pub fn particles_mut(&mut self) -> &mut [PointParticle] {
        &mut self.particles
    }

    /// Adds a mode of `count` particles of weight 1 at the places that `draw` returns; fewer if the cloud is full.
    /// Returns whether there was room for all.
    pub fn add_mode(&mut self, count: usize, mut draw: impl FnMut() -> [i16; 2]) -> bool {
        if self.ends.is_full() {
            return false;
        }
        let complete = (0..count).all(|_| {
            let particle = PointParticle {
                at: draw(),
                weight: 1,
                mark: 1,
            };
            self.particles.push(particle).is_ok()
        });
        let end = self.particles.len() as u16;
        self.ends.push(end).is_ok() && complete
    }

    /// Returns the particles of each mode. Modes without weight have been removed.
    pub fn modes(&self) -> impl Iterator<Item = &[PointParticle]> {
        let mut start = 0;
        self.ends.iter().map(move |&end| {
            let mode = self.particles.get(start..usize::from(end)).unwrap_or(&[]);
            start = usize::from(end);
            mode
        })
    }

    /// Sets each particle's weight to that which `weight` returns for it.
    pub fn weigh(&mut self, mut weight: impl FnMut(&PointParticle) -> u16) {
        for particle in &mut self.particles {
            particle.weight = weight(particle);
        }
    }

    /// Normalises the weights of each mode and resamples it with replacement. A mode whose weights are all zero is
    /// removed. A particle keeps its weight.
    pub fn resample(&mut self, rng: &mut impl Rng) {
        let mut start = 0;
        let mut kept = 0;
        let mut alive = Vec::new();
        for &end in &self.ends {
            let end = usize::from(end);
            let mode = self.particles.get_mut(start..end).unwrap_or(&mut []);
            if resample_mode(mode, rng) {
                kept = move_down(&mut self.particles, start..end, kept);
                // Cannot fail: there are at most as many modes as before.
                let _ = alive.push(kept as u16);
            }
            start = end;
        }
        self.particles.truncate(kept);
        self.ends = alive;
    }

    /// Keeps one of each run of equal particles (same place, same weight) and adds up their marks. After resampling
    /// with replacement, the copies of a particle are adjacent.
    pub fn merge_duplicates(&mut self) {
        let mut ends = self.ends.iter_mut();
        let mut end = ends.next();
        let mut kept = 0_usize;
        let mut fresh = true;
        for k in 0..self.particles.len() {
            while let Some(e) = end.take_if(|e| usize::from(**e) <= k) {
                *e = kept as u16;
                end = ends.next();
                fresh = true;
            }
            let Some(&next) = self.particles.get(k) else {
                break;
            };
            let last = self.particles.get_mut(kept.wrapping_sub(1));
            match last {
                Some(last) if !fresh && last.at == next.at && last.weight == next.weight => {
                    last.mark = last.mark.saturating_add(next.mark);
                }
                _ => {
                    if let Some(slot) = self.particles.get_mut(kept) {
                        *slot = next;
                    }
                    kept += 1;
                    fresh = false;
                }
            }
        }
        end.into_iter().chain(ends).for_each(|e| *e = kept as u16);
        self.particles.truncate(kept);
    }

    /// Sorts all particles by ascending `key` and makes them one mode.
    pub fn sort_by_key<K: Ord>(&mut self, key: impl Fn(&PointParticle) -> K) {
        shell_sort(&mut self.particles, |a, b| key(a) < key(b));
        self.ends.clear();
        // Cannot fail: the 64 places are free.
        let _ = self.ends.push(self.particles.len() as u16);
    }

    /// Keeps the particles for which `keep` returns true, in their order, as one mode.
    pub fn retain(&mut self, keep: impl FnMut(&PointParticle) -> bool) {
        self.particles.retain(keep);
        self.ends.clear();
        // Cannot fail: the 64 places are free.
        let _ = self.ends.push(self.particles.len() as u16);
    }
}

/// Copies the particles `from` to the places from index `to` on, which is not behind their own; returns the index
/// behind the copy.
fn move_down(particles: &mut [PointParticle], from: core::ops::Range<usize>, to: usize) -> usize {
    let count = from.len();
    if from.start != to {
        for k in 0..count {
            let particle = particles.get(from.start + k).copied();
            if let (Some(slot), Some(particle)) = (particles.get_mut(to + k), particle) {
                *slot = particle;
            }
        }
    }
    to + count
}

/// Resamples a mode in place by systematic resampling (Kitagawa 1996). A comb of n equidistant teeth with one random
/// offset is laid over the cumulated weights, and each particle is copied once for each of its teeth. The expected
/// number of copies is exactly n times the normalised weight. Returns whether there was any weight.
fn resample_mode(mode: &mut [PointParticle], rng: &mut impl Rng) -> bool {
    let n = mode.len() as u32;
    let total: u32 = mode.iter().map(|p| u32::from(p.weight)).sum();
    let Some(total) = NonZeroU32::new(total) else {
        return false;
    };
    // Survivors are moved to the front, with their number of copies as the mark.
    let mut below_tooth = uniform(rng, total.get());
    let mut kept = 0;
    for k in 0..mode.len() {
        let Some(&particle) = mode.get(k) else { break };
        below_tooth += n * u32::from(particle.weight);
        let copies = below_tooth / total;
        below_tooth -= copies * total.get();
        if let (true, Some(slot)) = (copies > 0, mode.get_mut(kept)) {
            *slot = PointParticle {
                mark: copies as u16,
                ..particle
            };
            kept += 1;
        }
    }
    // The copies are written from the last survivor on: k survivors have at least k copies, so that none is
    // overwritten before it is copied.
    let mut end = mode.len();
    for k in (0..kept).rev() {
        let Some(&particle) = mode.get(k) else { break };
        let start = end.saturating_sub(usize::from(particle.mark));
        if let Some(copies) = mode.get_mut(start..end) {
            copies.fill(PointParticle {
                mark: 1,
                ..particle
            });
        }
        end = start;
    }
    true
}

/// Weighted mean and covariance of particles' coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// Sum of the particles' weights.
    pub weight: u32,
    /// Mean of each coordinate, in units of the coordinates.
    pub mean: [f32; 2],
    /// Variance of each coordinate, in squared units of the coordinates.
    pub variance: [f32; 2],
    /// Covariance of the two coordinates, in squared units of the coordinates.
    pub covariance: f32,
}

impl Moments {
    /// Returns the moments of `particles` with the weights that `weight` returns; `None` if all weights are zero.
    pub fn of<'a>(
        particles: impl IntoIterator<Item = &'a PointParticle>,
        mut weight: impl FnMut(&PointParticle) -> u16,
    ) -> Option<Self> {
        // Sums are relative to the first particle, to keep their precision.
        let mut origin = None;
        let mut total = 0_u32;
        let mut first = [0_i64; 2];
        let mut second = [0_i64; 3];
        for particle in particles {
            let w = weight(particle);
            let [a0, b0] = *origin.get_or_insert(particle.at);
            let a = i32::from(particle.at[0]) - i32::from(a0);
            let b = i32::from(particle.at[1]) - i32::from(b0);
            let (wa, wb) = (i64::from(w) * i64::from(a), i64::from(w) * i64::from(b));
            total = total.saturating_add(u32::from(w));
            first[0] += wa;
            first[1] += wb;
            second[0] += wa * i64::from(a);
            second[1] += wb * i64::from(b);
            second[2] += wa * i64::from(b);
        }
        let [a0, b0] = origin?.map(f32::from);
        if total == 0 {
            return None;
        }
        let scale = 1.0 / total as f32;
        let [a, b] = first.map(|s| s as f32 * scale);
        let [aa, bb, ab] = second.map(|s| s as f32 * scale);
        Some(Self {
            weight: total,
            mean: [a0 + a, b0 + b],
            variance: [math::max(aa - a * a, 0.0), math::max(bb - b * b, 0.0)],
            covariance: ab - a * b,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand_core::SeedableRng;
    use rand_xoshiro::Xoshiro128PlusPlus;

    fn rng(seed: u64) -> Xoshiro128PlusPlus {
        Xoshiro128PlusPlus::seed_from_u64(seed)
    }

    /// Returns a cloud with one mode for each list of weights; particle k of mode m is at (m, k).
    fn cloud(modes: &[&[u16]]) -> PointCloud {
        let mut cloud = PointCloud::new();
        for (m, weights) in modes.iter().enumerate() {
            let mut k = -1;
            assert!(cloud.add_mode(weights.len(), || {
                k += 1;
                [m as i16, k]
            }));
        }
        let mut weights = modes.iter().copied().flatten();
        cloud.weigh(|_| *weights.next().unwrap());
        cloud
    }

    #[test]
    fn normal_deviates_have_mean_zero_and_variance_one() {
        let mut rng = rng(1);
        let n = 200_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..n {
            let z = f64::from(standard_normal(&mut rng)) / 4096.0;
            assert!(z.abs() < 3.46);
            sum += z;
            squares += z * z;
        }
        assert!((sum / f64::from(n)).abs() < 0.01);
        assert!((squares / f64::from(n) - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_gaussian_is_drawn_where_it_was_asked_for() {
        let gaussian = Gaussian {
            mean: [1000, -300],
            sigma: [100, 20],
        };
        let mut rng = rng(2);
        let mut cloud = PointCloud::new();
        assert!(cloud.add_mode(1000, || gaussian.draw(&mut rng)));
        let m = Moments::of(cloud.particles(), |_| 1).unwrap();
        assert!((m.mean[0] - 1000.0).abs() < 10.0 && (m.mean[1] + 300.0).abs() < 2.0);
        assert!((m.variance[0].sqrt() - 100.0).abs() < 7.0);
        assert!((m.variance[1].sqrt() - 20.0).abs() < 1.5);
        assert!(m.covariance.abs() < 200.0);
    }

    #[test]
    fn a_cell_reaches_half_a_cell_around_its_middle() {
        let cell = |row, bin| {
            let at = [row, bin];
            PointParticle {
                at,
                weight: 0,
                mark: 0,
            }
            .cell()
        };
        assert_eq!(cell(-32, 31), Some((0, 0)));
        assert_eq!(cell(32, 95), Some((1, 1)));
        assert_eq!(cell(-33, 0), None);
        assert_eq!(cell(i16::MAX, i16::MAX), Some((512, 512)));
    }

    #[test]
    fn coordinates_saturate() {
        let gaussian = Gaussian {
            mean: [i16::MAX, i16::MIN],
            sigma: [u16::MAX, u16::MAX],
        };
        let mut rng = rng(3);
        let at: [[i16; 2]; 64] = core::array::from_fn(|_| gaussian.draw(&mut rng));
        assert!(at.iter().any(|a| a[0] == i16::MAX) && at.iter().any(|a| a[1] == i16::MIN));
    }

    #[test]
    fn resampling_is_unbiased_and_keeps_to_the_nearest_whole_copies() {
        let weights = [1_u16, 0, 2, 3, 10, 4];
        let total: u16 = weights.iter().sum();
        let mut copies = [0_u32; 6];
        let runs = 20_000;
        for seed in 0..runs {
            let mut cloud = cloud(&[&weights]);
            cloud.resample(&mut rng(seed));
            assert_eq!(cloud.particles().len(), 6);
            let mut drawn = [0_u32; 6];
            cloud
                .particles()
                .iter()
                .for_each(|p| drawn[p.at[1] as usize] += 1);
            for ((&n, &w), sum) in drawn.iter().zip(&weights).zip(&mut copies) {
                let expected = 6.0 * f64::from(w) / f64::from(total);
                assert!((f64::from(n) - expected).abs() < 1.0);
                *sum += n;
            }
        }
        for (&n, &w) in copies.iter().zip(&weights) {
            let expected = 6.0 * f64::from(w) / f64::from(total);
            assert!((f64::from(n) / runs as f64 - expected).abs() < 0.02);
        }
    }

    #[test]
    fn modes_are_resampled_on_their_own_and_die_without_weight() {
        let mut cloud = cloud(&[&[0, 0], &[1, 0, 0], &[0], &[60_000, 60_000]]);
        cloud.resample(&mut rng(5));
        let places: std::vec::Vec<std::vec::Vec<[i16; 2]>> = cloud
            .modes()
            .map(|m| m.iter().map(|p| p.at).collect())
            .collect();
        assert_eq!(places, [vec![[1, 0]; 3], vec![[3, 0], [3, 1]]]);
        cloud.merge_duplicates();
        let sizes: std::vec::Vec<usize> = cloud.modes().map(<[PointParticle]>::len).collect();
        assert_eq!(sizes, [1, 2]);
        assert_eq!(cloud.particles()[0].mark, 3);
    }

    #[test]
    fn a_full_cloud_takes_no_more() {
        let mut cloud = PointCloud::new();
        assert!(cloud.add_mode(MAX_PARTICLES - 1, || [0, 0]));
        assert!(!cloud.add_mode(2, || [1, 1]));
        assert_eq!(cloud.particles().len(), MAX_PARTICLES);
        cloud.clear();
        assert!((0..MAX_CLOUD_MODES).all(|_| cloud.add_mode(1, || [0, 0])));
        assert!(!cloud.add_mode(1, || [0, 0]));
        assert_eq!(cloud.particles().len(), MAX_CLOUD_MODES);
    }

    #[test]
    fn no_particles_have_no_moments() {
        assert_eq!(Moments::of([], |_| 1), None);
        assert_eq!(Moments::of([&PointParticle::default()], |_| 0), None);
    }

    proptest! {
        #[test]
        fn resampling_keeps_numbers_and_draws_only_from_its_mode(
            modes in proptest::collection::vec(
                proptest::collection::vec(prop_oneof![Just(0), any::<u16>()], 1..40), 1..20),
            seed in any::<u64>(),
        ) {
            let modes: std::vec::Vec<&[u16]> = modes.iter().map(|m| &m[..]).collect();
            let mut cloud = cloud(&modes);
            cloud.resample(&mut rng(seed));
            let alive = (0_i16..).zip(&modes).filter(|(_, w)| w.iter().any(|&w| w > 0));
            prop_assert_eq!(cloud.modes().count(), alive.clone().count());
            for (mode, (m, weights)) in cloud.modes().zip(alive) {
                prop_assert_eq!(mode.len(), weights.len());
                for p in mode {
                    prop_assert_eq!(p.at[0], m);
                    prop_assert!(p.weight > 0 && p.weight == weights[p.at[1] as usize]);
                }
            }
            let n = cloud.particles().len();
            cloud.merge_duplicates();
            let drawn: usize = cloud.particles().iter().map(|p| usize::from(p.mark)).sum();
            prop_assert_eq!(drawn, n);
        }

        #[test]
        fn moments_agree_with_f64(
            points in proptest::collection::vec((any::<i16>(), any::<i16>(), 1_u16..), 1..200),
        ) {
            let particles: std::vec::Vec<PointParticle> = points
                .iter()
                .map(|&(a, b, weight)| PointParticle { at: [a, b], weight, mark: 0 })
                .collect();
            let m = Moments::of(&particles, |p| p.weight).unwrap();
            let total: f64 = points.iter().map(|p| f64::from(p.2)).sum();
            let mean = |f: &dyn Fn(f64, f64) -> f64| {
                points.iter().map(|p| f64::from(p.2) * f(f64::from(p.0), f64::from(p.1))).sum::<f64>() / total
            };
            let (a, b) = (mean(&|a, _| a), mean(&|_, b| b));
            prop_assert!((f64::from(m.mean[0]) - a).abs() < 0.05);
            prop_assert!((f64::from(m.mean[1]) - b).abs() < 0.05);
            let bound = 1e-6 * 65_536.0 * 65_536.0;
            prop_assert!((f64::from(m.variance[0]) - mean(&|x, _| (x - a) * (x - a))).abs() < bound);
            prop_assert!((f64::from(m.covariance) - mean(&|x, y| (x - a) * (y - b))).abs() < bound);
        }
    }
}
