//! Where the first hazard stands, by the echoes and lines of one sweep: the single rises, walls and drops that
//! [`Variants`] weighs on level ground, summed up by place. The guard's evidence.

use super::bases::NEAREST_M;
use super::variants::{Base, Variants};
use super::{Likelihood, Phase, look_along};
use crate::estimator::MappedScan;
use crate::guard::{Filter, Free};
use crate::math;
use crate::model::chart::Chart;
use crate::model::surfaces::{Recursions, SLOT_M, SLOTS};
use crate::model::{GroundKind, MAX_STEPS, Sigmas, Staircase};
use crate::motion::Ride;

/// A rise or fall of more than this ends the free ground, metres: design contract.
pub const HAZARD_M: f32 = 0.04;
/// Lighter by so many nats than the heaviest is nothing.
const NOTHING: f32 = 20.0;

/// What ends the free ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HazardKind {
    /// A rise that may be a step.
    Rise,
    /// Something taller, or a wall.
    Obstacle,
    /// The ground ends or falls.
    Drop,
}

impl HazardKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Rise, Self::Obstacle, Self::Drop];
}

/// Weight of the first hazard by kind and place, slots of [`SLOT_M`] from the mirror on, and of ground without one,
/// as multiples of the heaviest hypothesis.
#[derive(Clone, Debug)]
pub struct Ahead {
    /// By kind, in the order of [`HazardKind::ALL`], and slot.
    pub hazards: [[f32; SLOTS]; HazardKind::ALL.len()],
    /// Of ground without a hazard.
    pub free: f32,
    heaviest: f32,
}

impl Default for Ahead {
    fn default() -> Self {
        Self::new()
    }
}

impl Ahead {
    /// Nothing weighed yet.
    pub const fn new() -> Self {
        Self {
            hazards: [[0.0; SLOTS]; HazardKind::ALL.len()],
            free: 0.0,
            heaviest: f32::NEG_INFINITY,
        }
    }

    /// Adds a hypothesis of this log-weight.
    pub fn add(&mut self, s: &Staircase, log_weight: f32) {
        if !log_weight.is_finite() || log_weight < self.heaviest - NOTHING {
            return;
        }
        if log_weight > self.heaviest {
            let shrink = math::exp(math::max(self.heaviest - log_weight, -NOTHING));
            let sums = self.hazards.as_flattened_mut().iter_mut();
            sums.chain([&mut self.free]).for_each(|sum| *sum *= shrink);
            self.heaviest = log_weight;
        }
        let weight = math::exp(log_weight - self.heaviest);
        let place = first_hazard(s).and_then(|(kind, x_m)| {
            let row = self.hazards.get_mut(kind as usize)?;
            // `as` saturates.
            row.get_mut((x_m / SLOT_M) as usize)
        });
        *place.unwrap_or(&mut self.free) += weight;
    }
}

/// Kind and place of a hypothesis's first hazard, metres.
fn first_hazard(s: &Staircase) -> Option<(HazardKind, f32)> {
    let wall = s.wall_m.is_finite().then_some((HazardKind::Obstacle, s.wall_m));
    let high = s.level(1) > HAZARD_M;
    match s.kind {
        GroundKind::Drop { at_m } => Some((HazardKind::Drop, at_m)),
        GroundKind::Stairs | GroundKind::Threshold if high => Some((HazardKind::Rise, s.x(0))),
        GroundKind::Box => Some((HazardKind::Obstacle, s.x(0))),
        _ => wall,
    }
}

impl Likelihood {
    /// How far the ground is free after the sweep of `scan`, by it and those before, in place of
    /// [`Estimator::conclude`](crate::estimator::Estimator::conclude). `None` where no sweep's rows have been taken in.
    #[inline(never)]
    pub fn guard(&mut self, scan: &MappedScan<'_>, filter: &mut Filter) -> Option<Free> {
        let MappedScan { map, config, drive, .. } = *scan;
        let Phase::Rows(_) = &mut self.phase else { return None };
        let chart = Chart { map, noise: noise(map), bias_rad: 0.0, height_m: 0.0, ride: Ride::of(drive, &config.radar) };
        self.phase = Phase::Ground(Recursions::new());
        let Phase::Ground(ground) = &mut self.phase else { return None };
        ground.lines.look(&chart);
        let step = filter.step(drive.moved_m);
        ground.lines.average(&mut filter.past, drive.moved_m.unwrap_or(0.0), step);
        let surfaces = &mut self.posterior.model.surfaces;
        ground.weigh(surfaces);
        let mut things = [0.0; SLOTS];
        ground.things(&mut things);
        Some(filter.read(surfaces, &things, drive.moved_m))
    }

    /// Weighs what may stand ahead by one sweep of the ground, after its last row, in place of
    /// [`Estimator::conclude`](crate::estimator::Estimator::conclude). Returns the mean noise, map units; `None` when that has been.
    #[inline(never)]
    pub fn look_ahead(&mut self, scan: &MappedScan<'_>, ahead: &mut Ahead) -> Option<f32> {
        let Phase::Rows(collector) = &mut self.phase else {
            return None;
        };
        let MappedScan {
            map, config, drive, ..
        } = *scan;
        let noise = collector.finish(map, config, self.params, drive, &mut self.echoes);
        self.posterior.take(&self.echoes, map);
        let chart = Chart {
            map,
            noise,
            bias_rad: 0.0,
            height_m: 0.0,
            ride: Ride::of(drive, &config.radar),
        };
        look_along(&chart, &mut self.phase, &mut self.posterior.model.surfaces);
        *ahead = Ahead::new();
        self.weigh_ahead(ahead);
        Some(noise)
    }

    /// Level ground, a ramp, walls, and single rises and drops before each of them.
    #[inline(never)]
    fn weigh_ahead(&mut self, ahead: &mut Ahead) {
        self.posterior
            .add(&Staircase::nothing(), &[0.0; MAX_STEPS], NEAREST_M);
        let bases = &self.posterior.bases;
        for base in bases {
            ahead.add(&base.staircase, base.log_weight);
        }
        let Some(base) = bases.iter().copied().reduce(Base::likelier) else {
            return;
        };
        let mut sink = |s: &Staircase, weight: f32, _: &Sigmas| ahead.add(s, weight);
        Variants {
            model: &self.posterior.model,
            sink: &mut sink,
        }
        .around(&base);
    }
}

/// Mean noise of a sweep, map units: the cells that the ground does not reach.
fn noise(map: &crate::signal::grid::PolarMap) -> f32 {
    let geometry = map.geometry();
    let mut counts = [0_u16; 256];
    let mut all = 0_u32;
    let off = (7.0_f32).to_radians();
    for row in 0..map.rows() {
        let angle = map.angle_rad(row);
        for (bin, &level) in map.row(row).iter().enumerate() {
            let range_m = geometry.range_m(bin as f32);
            if range_m < 0.45 || range_m > 2.6 || level == 0 { continue; }
            let down = geometry.mount_height_m / range_m;
            let line = if down < 1.0 { math::atan2(down, math::sqrt(1.0 - down * down)) } else { f32::INFINITY };
            if (line - angle).abs() < off { continue; }
            counts[usize::from(level)] += 1;
            all += 1;
        }
    }
    let want = all as f32 * 0.35;
    let mut sum = 0.0;
    for (level, n) in counts.iter().enumerate() {
        let next = sum + f32::from(*n);
        if next >= want && *n > 0 {
            return level as f32 - 0.5 + (want - sum) / f32::from(*n) + 8.0 * math::log2(1.0 / 0.4308);
        }
        sum = next;
    }
    0.0
}
