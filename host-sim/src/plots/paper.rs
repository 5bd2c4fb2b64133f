//! Observer of the paper's estimator: collects particles and clusters of each stage for the plots.

use stairscan::config::{Config, ParticleConfig, Plane, Spread};
use stairscan::estimator::Estimator;
use stairscan::observer::{CloudStage, Event, Observer};
use stairscan::paper::cluster::{ClusterVerdict, Extent};
use stairscan::paper::particles::{PointParticle, UNITS_PER_CELL};
use stairscan::paper::{Paper, Places};
use stairscan::signal::echoes::FoundEchoes;
use stairscan::signal::grid::PolarMap;
use stairscan::verdict::Outcome;

use super::PaperView;
use super::particles::{BeamView, ClusterView, ParticleView};
use crate::views::Point;

/// Intermediate results of the paper's estimator on one scan.
struct TraceObserver<'a> {
    map: &'a PolarMap,
    particles: ParticleView,
    /// Each particle's place (horizontal distance from the mirror, height above the ground), metres, and the index of
    /// its cluster in `extents`. `[0]`: before, `[1]`: after the rejection rules have removed clusters of outliers and
    /// those that repeat another cluster's object.
    marked: [Vec<(Point, u16)>; 2],
    extents: Vec<Extent>,
}

impl<'a> TraceObserver<'a> {
    fn new(map: &'a PolarMap) -> Self {
        Self {
            map,
            particles: ParticleView::default(),
            marked: [Vec::new(), Vec::new()],
            extents: Vec::new(),
        }
    }

    /// Returns the place of a particle (horizontal distance from the mirror, height above the ground), metres. Its
    /// coordinates are row and range bin of the map, in units of 1/[`UNITS_PER_CELL`].
    fn drawn(&self, particle: &PointParticle) -> Point {
        let unit = f32::from(UNITS_PER_CELL);
        let [row, bin] = particle.at.map(|c| f32::from(c) / unit);
        let geometry = self.map.geometry();
        let nearest = row.round().max(0.0);
        let angle = self.map.angle_rad(nearest as usize) + (row - nearest) * geometry.step_rad;
        let (x, y) = geometry.point(geometry.range_m(bin), angle);
        (x.into(), y.into())
    }

    /// Returns the place (horizontal distance from the mirror, height above the ground), metres, of a particle or of a
    /// cluster's middle, from its coordinates along and across the axis at which the mirror's angle is 0, metres from
    /// the mirror. `across` is positive downwards in scans of stairs going up, forwards in those of stairs going down.
    fn placed(&self, along: f32, across: f32) -> Point {
        let mount = self.map.geometry().mount_height_m;
        let (x, y) = match self.map.geometry().plane {
            Plane::Depth => (along, mount - across),
            Plane::Height => (across, mount - along),
        };
        (x.into(), y.into())
    }

    fn marks(&self, particles: &[PointParticle]) -> Vec<(Point, u16)> {
        let unit = Places::of(self.map).unit_m;
        let marked = particles.iter().map(|p| {
            let [along, across] = p.at.map(|c| f32::from(c) * unit);
            (self.placed(along, across), p.mark)
        });
        marked.collect()
    }

    /// Returns the clusters of `marked` particles (place, index of the cluster), nearest first, each with its verdict
    /// after all rejection rules.
    fn clusters(&self, marked: &[(Point, u16)]) -> Vec<ClusterView> {
        let numbered = self.extents.iter().enumerate();
        let cluster = |(k, extent): (usize, &Extent)| {
            let members = marked.iter().filter(|(_, mark)| usize::from(*mark) == k);
            ClusterView {
                points: members.map(|(point, _)| *point).collect(),
                centre: self.placed(extent.along_m, -extent.across_m),
                fate: extent.verdict,
            }
        };
        let clusters = numbered.map(cluster).filter(|c| !c.points.is_empty());
        let mut clusters: Vec<ClusterView> = clusters.collect();
        // Nearest first, in the order of steps.
        clusters.sort_by(|a, b| a.centre.0.total_cmp(&b.centre.0));
        clusters
    }
}

impl Observer for TraceObserver<'_> {
    fn event(&mut self, event: Event<'_>) {
        let Event::Particles {
            stage,
            particles,
            clusters,
        } = event
        else {
            return;
        };
        match stage {
            CloudStage::Drawn => {
                let drawn = particles.iter().map(|p| self.drawn(p));
                self.particles.initial = drawn.collect();
            }
            CloudStage::Resampled => {
                let drawn = particles.iter().map(|p| self.drawn(p));
                self.particles.resampled = drawn.collect();
                self.particles.rounds += 1;
            }
            CloudStage::Clustered => self.marked[0] = self.marks(particles),
            CloudStage::Rejected => {
                self.marked[1] = self.marks(particles);
                self.extents = clusters.to_vec();
            }
        }
    }
}

/// Runs the paper's estimator on a map. Returns its outcome, and the observer with the particles and clusters of each
/// stage.
fn observe<'a>(map: &'a PolarMap, config: &Config, scan: u32) -> (Outcome, TraceObserver<'a>) {
    let mut paper = Box::new(Paper::new());
    paper.begin(map);
    for row in 0..map.rows() {
        paper.row(map, row);
    }
    let mut witness = TraceObserver::new(map);
    let outcome = paper.finish(map, &FoundEchoes::NONE, config, scan, &mut witness);
    (outcome, witness)
}

impl PaperView {
    /// Runs the paper's estimator on `map` three times: with uniform particles and with Gaussian modes of the raw
    /// map, each for the paper's number of rounds (figs. 5 and 6), and with the settings of `config` for all later
    /// stages.
    pub fn of(map: &PolarMap, config: &Config, scan: u32) -> Self {
        let spread = |spread: Spread| {
            let particles = ParticleConfig {
                spread,
                rounds: spread.rounds(),
                ..config.particles
            };
            let config = Config {
                particles,
                ..*config
            };
            observe(map, &config, scan).1.particles
        };
        let (outcome, witness) = observe(map, config, scan);
        let kept: Vec<ClusterView> = witness
            .clusters(&witness.marked[1])
            .into_iter()
            .filter(|c| c.fate == ClusterVerdict::Kept)
            .collect();
        Self {
            uniform: spread(Spread::Uniform),
            modes: spread(Spread::GmmRaw),
            clusters: witness.clusters(&witness.marked[0]),
            beams: beams(map.geometry().plane, &outcome, &kept),
            kept,
        }
    }
}

/// Returns for each reported step the correction for the beam's width: from the end of the nearest kept cluster to the
/// reported edge.
fn beams(plane: Plane, outcome: &Outcome, kept: &[ClusterView]) -> Vec<BeamView> {
    let along = |p: Point| match plane {
        Plane::Depth => p.0,
        Plane::Height => p.1,
    };
    let beam = |step: &stairscan::answer::Step| {
        let edge: Point = (step.distance_m.into(), step.height_m.into());
        let off = |c: &&ClusterView| (along(c.centre) - along(edge)).abs();
        let cluster = kept.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
        let points = cluster.points.iter();
        let end = match plane {
            Plane::Depth => (edge.0, points.map(|p| p.1).max_by(f64::total_cmp)?),
            Plane::Height => (points.map(|p| p.0).min_by(f64::total_cmp)?, edge.1),
        };
        Some(BeamView { end, edge })
    };
    outcome.answer.steps.iter().filter_map(beam).collect()
}
