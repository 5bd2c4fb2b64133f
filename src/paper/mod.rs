//! The paper's estimator (sections III and IV): particles converge on places of high intensity, Fuzzy ART groups them
//! into clusters, and every cluster that is not rejected is a step.
//!
//! Choices where the paper is open:
//! - A particle's weight is its power above the minimum, dB. In a cluster's mean (eq. 5) it is linear power, so that
//!   the centre of the echo counts and not its skirts.
//! - Inputs of Fuzzy ART are place and power scaled to 0…1. Places are scaled by the particles' extent in depth and in
//!   height, power above the weakest particle by the range of high-intensity cells. Inputs are sorted by depth.
//!   `vigilance` converts the paper's ρ = 0.5 to a suitable vigilance for these inputs.
//! - Clusters of one riser are fused (III-B: "must be either fused or …"). Clusters too close to another one in height
//!   are rejected.

pub mod bright;
pub mod cluster;
pub mod dimension;
pub mod particles;

use heapless::Vec;
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;

use crate::answer::Answer;
use crate::config::{Config, ParticleConfig, Spread};
use crate::estimator::{Estimator, MappedScan};
use crate::math;
use crate::motion::Agreement;
use crate::observer::{CloudStage, Event, Observer};
use crate::past::History;
use crate::signal::grid::{DB_PER_UNIT, PolarMap};
use crate::verdict::Assessment;
use bright::{HIGH_INTENSITY_DB, IntensityMap, MapLevels};
use cluster::{ClusterVerdict, Extent, FuzzyArt, MAX_CLUSTERS, NO_CLUSTER};
use dimension::ClusterShape;
use particles::{Moments, PointCloud, PointParticle, UNITS_PER_CELL};

/// Minimum distance of two clusters along and across the axis of the mirror's angle (depth and height), metres
/// (III-B): of a closer pair one is redundant.
const REDUNDANT_M: f32 = 0.1;

/// Maximum number of epochs of Fuzzy ART. Boxes only grow, so that most cases settle in two or three.
const EPOCHS: u8 = 6;

/// Minimum number of CA-CFAR detections for an answer, relative to the expected number of false alarms of noise
/// alone.
const FALSE_ALARM_MARGIN: f32 = 3.0;
/// Distance of a particle from its cluster's mean, along or across, beyond which it is an outlier, standard
/// deviations.
const STRAY_SIGMAS: f32 = 3.5;

/// Coordinate system of clustered particles, with its origin in the mirror's centre. The first coordinate is along
/// the axis from which the mirror's angle is measured (forward in the depth plane, down in the height plane), the
/// second one across it (down, forward). Depth and height exchange their roles between the planes, so clustering and
/// rejection are the same for both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Places {
    /// Unit of the coordinates, metres: 1/64 range bin.
    pub unit_m: f32,
}

impl Places {
    /// Returns the coordinate system for `map`'s particles.
    pub fn of(map: &PolarMap) -> Self {
        Self {
            unit_m: map.geometry().bin_m / f32::from(UNITS_PER_CELL),
        }
    }

    /// Converts a particle's coordinates from cells of `map` (angle, range) to this system, in place.
    fn place(self, map: &PolarMap, particle: &mut PointParticle) {
        let geometry = map.geometry();
        let unit = f32::from(UNITS_PER_CELL);
        let [row, bin] = particle.at.map(|c| f32::from(c) / unit);
        // The row's measured angle, plus a fraction of a step.
        let nearest = particle.cell().map_or(0, |(row, _)| row);
        let angle = map.angle_rad(nearest) + (row - nearest as f32) * geometry.step_rad;
        let (sin, cos) = math::sin_cos(angle);
        let range = geometry.range_m(bin) / self.unit_m;
        particle.at = [(range * cos) as i16, (range * sin) as i16];
    }
}

/// The paper's estimator with its memory: the map's levels during the scan, the particles after it.
#[derive(Debug)]
pub struct Paper {
    levels: MapLevels,
    cloud: PointCloud,
}

impl Paper {
    /// Returns an estimator before the first scan.
    pub const fn new() -> Self {
        Self {
            levels: MapLevels::new(),
            cloud: PointCloud::new(),
        }
    }
}

impl Estimator for Paper {
    fn begin(&mut self, _map: &PolarMap) {
        self.levels.clear();
    }

    fn row(&mut self, map: &PolarMap, k: usize) {
        if map.present(k) {
            self.levels.add_row(map, k);
        }
    }

    fn conclude(
        &mut self,
        scan: &MappedScan<'_>,
        _past: Option<&mut History>,
        observer: &mut dyn Observer,
        answer: &mut Answer,
    ) -> Option<Assessment> {
        let Self { levels, cloud } = self;
        let (map, config) = (scan.map, scan.config);
        // This estimator has no echoes to compare from sweep to sweep, and computes no confidence.
        let sight = Assessment::nothing(Agreement::untested(scan.drive.mode));
        if levels.hits() as f32 <= FALSE_ALARM_MARGIN * expected_false_alarms(map, config) {
            return Some(sight);
        }
        let seed = u64::from(config.seed) << 32 | u64::from(scan.number);
        let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed);
        let field = IntensityMap::new(map, levels, config.particles.spread);
        converge(&field, &config.particles, &mut rng, cloud, observer);

        let places = Places::of(map);
        (cloud.particles_mut().iter_mut()).for_each(|p| places.place(map, p));
        form_clusters(cloud, config.particles.vigilance);
        let mut shapes = shapes(cloud);
        let mut extents = extents(&shapes, places.unit_m);
        show(observer, CloudStage::Clustered, cloud, &extents);

        cluster::reject_outliers(&mut extents);
        cluster::fuse(&mut extents, REDUNDANT_M);
        join(cloud, &mut extents, &mut shapes, places.unit_m);
        cluster::reject_redundant(&mut extents, REDUNDANT_M);
        show(observer, CloudStage::Rejected, cloud, &extents);

        let kept = (extents.iter().zip(&shapes))
            .filter(|(extent, _)| extent.verdict == ClusterVerdict::Kept)
            .map(|(_, shape)| shape);
        dimension::steps(
            kept,
            map.geometry(),
            places.unit_m,
            &config.particles,
            answer,
        );
        Some(Assessment {
            echo_found: true,
            ..sight
        })
    }
}

impl Default for Paper {
    fn default() -> Self {
        Self::new()
    }
}

/// Reports the particles after the stage `stage` to the observer, with their clusters.
fn show(observer: &mut dyn Observer, stage: CloudStage, cloud: &PointCloud, clusters: &[Extent]) {
    observer.event(Event::Particles {
        stage,
        particles: cloud.particles(),
        clusters,
    });
}

/// Returns the expected number of CA-CFAR detections in a map of noise alone.
fn expected_false_alarms(map: &PolarMap, config: &Config) -> f32 {
    (map.rows() * map.bins()) as f32 * config.cfar.false_alarm
}

/// Draws the particles, resamples them until they have converged on high-intensity places, and merges those at one
/// place.
fn converge(
    field: &IntensityMap<'_>,
    config: &ParticleConfig,
    rng: &mut Xoshiro128PlusPlus,
    cloud: &mut PointCloud,
    observer: &mut dyn Observer,
) {
    cloud.clear();
    let number = usize::from(config.particles);
    if config.spread == Spread::Uniform {
        cloud.add_mode(number, || field.anywhere(rng));
    } else {
        let modes = field.modes(config, rng);
        let count = modes.len().max(1);
        for (k, mode) in modes.iter().enumerate() {
            // As even as integers allow.
            let share = number * (k + 1) / count - number * k / count;
            cloud.add_mode(share, || mode.draw(rng));
        }
    }
    cloud.weigh(|particle| field.weight(particle));
    show(observer, CloudStage::Drawn, cloud, &[]);
    for _ in 0..config.rounds {
        // Particles do not move, so their weights do not change.
        cloud.resample(rng);
        show(observer, CloudStage::Resampled, cloud, &[]);
    }
    cloud.merge_duplicates();
}

/// Returns Fuzzy ART's vigilance for the paper's sensitivity ρ, both in thousandths.
///
/// Inputs fill 0…1 in every direction, so that the smallest vigilance that separates any of them is above 0. ρ is
/// scaled to the range from there, where a cluster may extend over four fifths of each direction, to 1, where every
/// particle is a cluster.
fn vigilance(sensitivity: u16) -> u16 {
    1000 - 4 * (1000 - sensitivity.min(1000)) / 5
}

/// Assigns the particles to clusters by Fuzzy ART: a particle's `mark` becomes the index of its cluster. Removes each
/// cluster's outliers.
fn form_clusters(cloud: &mut PointCloud, sensitivity: u16) {
    cloud.sort_by_key(|p| (p.at, p.weight));
    cloud.merge_duplicates();
    let particles = cloud.particles_mut();
    let mut low = [i16::MAX; 2];
    let mut high = [i16::MIN; 2];
    let mut weakest = u16::MAX;
    for particle in particles.iter_mut() {
        for ((low, high), at) in low.iter_mut().zip(&mut high).zip(particle.at) {
            *low = at.min(*low);
            *high = at.max(*high);
        }
        weakest = particle.weight.min(weakest);
        particle.mark = NO_CLUSTER;
    }
    let scale = |low: i16, high: i16| 255.0 / (f32::from(high) - f32::from(low)).max(1.0);
    let scales = [scale(low[0], high[0]), scale(low[1], high[1])];
    let power_scale = 255.0 * DB_PER_UNIT / HIGH_INTENSITY_DB;
    let features = |p: &PointParticle| {
        // `as` saturates, which limits the power to its range.
        let [along, across] = [0, 1].map(|k: usize| {
            let offset = f32::from(p.at[k & 1]) - f32::from(low[k & 1]);
            (offset * scales[k & 1]) as u8
        });
        let power = f32::from(p.weight.saturating_sub(weakest)) * power_scale;
        [along, across, power as u8]
    };
    let mut art = FuzzyArt::<3, MAX_CLUSTERS>::new(vigilance(sensitivity));
    art.settle(particles, EPOCHS, features, |p| &mut p.mark);
    sort_by_cluster(cloud);
    reject_strays(cloud);
}

/// Removes the outliers among the particles of each cluster, so that the rest is evenly spread: the paper's "outliers
/// detection and removal applied to particles in each cluster".
fn reject_strays(cloud: &mut PointCloud) {
    let mut rest = cloud.particles_mut();
    while let Some((members, after)) = rest.split_at_mut_checked(cluster_len(rest))
        && let Some(m) = Moments::of(&*members, |_| 1)
    {
        rest = after;
        for particle in members {
            let stray = [0, 1].iter().any(|&k: &usize| {
                let offset = f32::from(particle.at[k & 1]) - m.mean[k & 1];
                offset * offset > STRAY_SIGMAS * STRAY_SIGMAS * m.variance[k & 1]
            });
            if stray {
                particle.mark = NO_CLUSTER;
            }
        }
    }
    sort_by_cluster(cloud);
}

/// Sorts the particles by cluster, and in each cluster with the topmost first.
fn sort_by_cluster(cloud: &mut PointCloud) {
    cloud.sort_by_key(|p| (p.mark, p.at[1], p.at[0], p.weight));
}

/// Returns the number of leading particles that belong to the cluster of the first one.
fn cluster_len(particles: &[PointParticle]) -> usize {
    let mark = particles.first().map(|p| p.mark);
    let same = particles.iter().take_while(|p| Some(p.mark) == mark);
    same.count()
}

/// Returns the particles of each cluster, from `particles` sorted by [`sort_by_cluster`].
fn members(mut particles: &[PointParticle]) -> impl Iterator<Item = &[PointParticle]> {
    // `chunk_by` has a path to a panic.
    core::iter::from_fn(move || {
        let (members, rest) = particles.split_at_checked(cluster_len(particles))?;
        particles = rest;
        (!members.is_empty()).then_some(members)
    })
}

/// Returns the shape of each cluster; entry k is cluster k. Clusters without particles are included.
fn shapes(cloud: &PointCloud) -> Vec<ClusterShape, MAX_CLUSTERS> {
    let mut shapes = Vec::new();
    for members in members(cloud.particles()) {
        let mark = members.first().map_or(NO_CLUSTER, |p| p.mark);
        while shapes.len() < usize::from(mark) && shapes.push(ClusterShape::default()).is_ok() {}
        if mark != NO_CLUSTER {
            // Cannot fail: there are at most as many marks as places.
            let _ = shapes.push(ClusterShape::of(members));
        }
    }
    shapes
}

/// Returns particle count and mean position (metres) of each cluster, for the rejection rules; `unit_m` is the unit
/// of the particles' coordinates, metres.
fn extents(shapes: &[ClusterShape], unit_m: f32) -> Vec<Extent, MAX_CLUSTERS> {
    let mut extents = Vec::new();
    // Cannot fail: there are as many places as shapes.
    while let Some(shape) = shapes.get(extents.len())
        && extents.push(shape.extent(unit_m)).is_ok()
    {}
    extents
}

/// Moves the particles of fused clusters to the cluster with which they are fused, and updates `extents` and
/// `shapes`.
fn join(cloud: &mut PointCloud, extents: &mut [Extent], shapes: &mut [ClusterShape], unit_m: f32) {
    for particle in cloud.particles_mut() {
        let extent = extents.get(usize::from(particle.mark));
        if let Some(ClusterVerdict::Fused(into)) = extent.map(|e| e.verdict) {
            particle.mark = into;
        }
    }
    sort_by_cluster(cloud);
    for members in members(cloud.particles()) {
        let mark = members.first().map_or(NO_CLUSTER, |p| p.mark);
        let place = (extents.get_mut(usize::from(mark))).zip(shapes.get_mut(usize::from(mark)));
        if let Some((extent, shape)) = place {
            *shape = ClusterShape::of(members);
            *extent = Extent {
                verdict: extent.verdict,
                ..shape.extent(unit_m)
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::Direction;
    use crate::config::Planes;
    use crate::signal::echoes::FoundEchoes;
    use crate::verdict::{Reason, Reasons, Status};
    use proptest::prelude::*;

    /// Returns a scan of `config` with cells from `cell(range, angle)`: level, and whether it is a CFAR detection.
    fn scan(config: &Config, mut cell: impl FnMut(f32, f32) -> (u8, bool)) -> (PolarMap, Paper) {
        let mut map = PolarMap::new();
        map.begin(config).unwrap();
        let mut paper = Paper::new();
        paper.begin(&map);
        let geometry = *map.geometry();
        for k in 0..map.rows() {
            let angle = map.angle_rad(k);
            map.fill(k, |row| {
                for (bin, place) in row.cells.iter_mut().enumerate() {
                    let (level, hit) = cell(geometry.range_m(bin as f32), angle);
                    *place = level;
                    row.mask[bin / 32] |= u32::from(hit) << (bin % 32);
                }
            });
            paper.row(&map, k);
        }
        (map, paper)
    }

    /// For each riser a corner and, 10 dB weaker, a nosing, seen by a beam that is 6 dB (two-way) down at half its
    /// width, on noise of level 40.
    fn staircase(config: &Config, steps: &[(f32, f32, f32)]) -> (PolarMap, Paper) {
        let mut map = PolarMap::new();
        map.begin(config).unwrap();
        let geometry = *map.geometry();
        let echoes: std::vec::Vec<(f32, f32, f32)> = (steps.iter())
            .flat_map(|&(x, bottom, top)| [(x, bottom, 190.0), (x, top, 163.0)])
            .map(|(x, y, peak)| {
                let (range, angle) = geometry.polar(x, y);
                (range, angle, peak)
            })
            .collect();
        scan(config, |range, angle| {
            let level = (echoes.iter())
                .map(|&(r, a, peak)| {
                    let (bins, beams) = ((range - r) / geometry.bin_m, (angle - a) / 0.0436);
                    peak - 16.0 * (bins * bins + beams * beams)
                })
                .fold(40.0, f32::max);
            (level as u8, level > 72.0)
        })
    }

    #[test]
    fn steps_are_found_where_they_are() {
        let config = Config::default();
        let steps = [(0.6, 0.0, 0.2), (0.9, 0.2, 0.4), (1.2, 0.4, 0.6)];
        let mut errors = vec![];
        for seed in 0..20 {
            let config = Config { seed, ..config };
            let (map, mut paper) = staircase(&config, &steps);
            let outcome = paper.finish(&map, &FoundEchoes::NONE, &config, 1, &mut ());
            assert_eq!(outcome.answer.direction, Direction::Up);
            for (step, &(distance, _, top)) in outcome.answer.steps.iter().zip(&steps) {
                errors.push((
                    (step.distance_m - distance).abs(),
                    (step.height_m - top).abs(),
                ));
            }
        }
        // With few particles, two steps sometimes fall into one cluster, or the topmost particle is an outlier.
        assert!(errors.len() >= 50, "{} of 60 steps", errors.len());
        let middle = errors.len() / 2;
        errors.sort_by(|a, b| a.1.total_cmp(&b.1));
        assert!(errors[middle].1 < 0.02, "height {}", errors[middle].1);
        errors.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert!(errors[middle].0 < 0.005, "distance {}", errors[middle].0);
    }

    #[test]
    fn a_particle_far_from_its_cluster_is_taken_out_of_it() {
        let mut cloud = PointCloud::new();
        let mut k = 0;
        // 40 side by side in each of two clusters, and one outlier beside the second.
        cloud.add_mode(81, || {
            k += 1;
            [if k > 40 { 3000 } else { 0 } + k % 5, k % 7]
        });
        for (k, particle) in (0..).zip(cloud.particles_mut()) {
            particle.mark = u16::from(k >= 40);
            if k == 80 {
                particle.at[1] = 400;
            }
        }
        reject_strays(&mut cloud);
        let particles = cloud.particles();
        let of = |mark| particles.iter().filter(|p| p.mark == mark).count();
        assert_eq!([of(0), of(1), of(NO_CLUSTER)], [40, 40, 1]);
        assert!(
            particles
                .iter()
                .all(|p| (p.mark == NO_CLUSTER) == (p.at[1] == 400))
        );
    }

    #[test]
    fn noise_is_no_stairs() {
        let config = Config::default();
        // As many detections as expected false alarms, evenly spread.
        let mut cells = 0_u32;
        let (map, mut paper) = scan(&config, |_, _| {
            cells += 1;
            (40, cells.is_multiple_of(2500))
        });
        assert!(paper.levels.hits() > 20);
        let outcome = paper.finish(&map, &FoundEchoes::NONE, &config, 1, &mut ());
        assert_eq!(outcome.reasons(), Reasons::NONE.with(Reason::NoEcho));
        assert!(outcome.status() == Status::Fault && outcome.answer == Answer::NONE);
    }

    #[test]
    fn every_stage_is_shown() {
        struct Record(std::vec::Vec<(CloudStage, usize)>);
        impl Observer for Record {
            fn event(&mut self, event: Event<'_>) {
                let Event::Particles {
                    stage,
                    particles,
                    clusters,
                    ..
                } = event
                else {
                    panic!("the paper's estimator tells {event:?}");
                };
                self.0.push((stage, particles.len()));
                let formed = matches!(stage, CloudStage::Clustered | CloudStage::Rejected);
                assert_eq!(formed, !clusters.is_empty());
            }
        }
        let config = Config::default();
        let (map, mut paper) = staircase(&config, &[(0.6, 0.0, 0.17), (0.9, 0.17, 0.34)]);
        let mut record = Record(vec![]);
        paper.finish(&map, &FoundEchoes::NONE, &config, 1, &mut record);
        let stages: std::vec::Vec<CloudStage> = record.0.iter().map(|s| s.0).collect();
        use CloudStage::{Clustered, Drawn, Rejected, Resampled};
        assert_eq!(stages, [Drawn, Resampled, Resampled, Clustered, Rejected]);
        assert_eq!(record.0[0].1, 1000);
        assert!(record.0[4].1 < record.0[2].1);
    }

    #[test]
    fn sensitivity_spans_the_vigilance() {
        assert_eq!([0, 500, 1000, 2000].map(vigilance), [200, 600, 1000, 1000]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn any_map_and_configuration_give_finite_steps_and_the_same_ones_again(
            seed in any::<u32>(),
            noise in any::<u64>(),
            density in 0_u32..=100,
            top in 1_u8..,
            (samples, bandwidth_khz) in (32_u16..=256, 1_000_000_u32..100_000_000),
            (first_angle, angle_step, angle_count) in
                (-90_000_i32..90_000, 10_i32..250, 3_u16..=250),
            (mode_sigma, vigilance) in (100_i32..100_000, 0_u16..=1000),
            (particles, modes, rounds) in (10_u16..=1000, 1_u8..=32, 1_u8..=20),
            spread in prop_oneof![
                Just(Spread::Uniform), Just(Spread::GmmRaw), Just(Spread::GmmCfar)],
            height in any::<bool>(),
        ) {
            let mut config = Config { seed, ..Config::default() };
            config.radar.samples = samples;
            config.radar.bandwidth_khz = bandwidth_khz;
            config.sweep.first_angle = first_angle;
            config.sweep.angle_step = angle_step;
            config.sweep.angle_count = angle_count;
            config.mount.plane = if height { Planes::Height } else { Planes::Depth };
            config.particles = ParticleConfig {
                particles, modes, rounds, spread, mode_sigma, vigilance,
            };
            prop_assume!(config.validate().is_ok() && PolarMap::new().begin(&config).is_ok());
            let mut rng = Xoshiro128PlusPlus::seed_from_u64(noise);
            let (map, mut paper) = scan(&config, |_, _| {
                let level = particles::uniform(&mut rng, u32::from(top)) as u8;
                (level, particles::uniform(&mut rng, 100) < density)
            });
            let outcome = paper.finish(&map, &FoundEchoes::NONE, &config, 7, &mut ());
            prop_assert!(outcome.status() != Status::Ok);
            let no_promise = Reasons::NONE.with(Reason::NoPromise);
            prop_assert!(outcome.status() == Status::Fault || outcome.reasons() == no_promise);
            prop_assert!(outcome.status() != Status::Fault || outcome.answer.steps.is_empty());
            let farthest = map.geometry().range_m(map.bins() as f32);
            for step in &outcome.answer.steps {
                prop_assert!(step.distance_m.abs() <= 1.1 * farthest, "{:?}", step);
                prop_assert!((step.height_m - map.geometry().mount_height_m).abs() <= 1.1 * farthest);
                prop_assert!(step.distance_sigma_m > 0.0 && step.distance_sigma_m < farthest);
                prop_assert!(step.height_sigma_m > 0.0 && step.height_sigma_m < farthest);
                prop_assert!(step.quality <= 100);
                prop_assert!(step.tread_m.is_none_or(f32::is_finite));
                prop_assert!(step.riser_m.is_none_or(f32::is_finite));
            }
            prop_assert_eq!(paper.finish(&map, &FoundEchoes::NONE, &config, 7, &mut ()), outcome);
        }
    }
}
