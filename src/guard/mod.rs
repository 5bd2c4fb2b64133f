//! The guard: a coarse sweep of the ground ahead, several times a second, and the free distance.
//!
//! In: the polar map of one sweep ([`PolarMap`]) and the chair's travel since the sweep before. Method: a recursive
//! Bayes filter over sweeps. The powers along the ground, above and below it are averaged with those of earlier
//! sweeps, shifted by the chair's travel ([`MeanLines`]). The recursions that evaluate the ground of a full scan
//! ([`crate::model::surfaces`]) then give the likelihood of the first hazard by place (`reach`). Out: [`FreeGround`].
//! The module is apart from [`crate::infer`] because a sweep of some thirty rows resolves no steps: it has no search
//! and no particles, and it keeps state from sweep to sweep.

mod noise;
mod reach;
#[cfg(test)]
mod tests;

use crate::answer::Slope;
use crate::config::Config;
use crate::drive::{Drive, Mode};
use crate::model::Surfaces;
use crate::model::above::{Above, DEPTHS};
use crate::model::chart::Chart;
use crate::model::mean::MeanLines;
use crate::model::surfaces::Recursions;
use crate::motion::MotionCompensation;
use crate::signal::grid::PolarMap;
use crate::verdict::FreeGround;
use reach::Hazards;

/// State kept from guard sweep to guard sweep, and the working memory of one sweep.
#[derive(Debug)]
pub struct Guard {
    ground: Recursions,
    above: Above,
    surfaces: Surfaces,
    mean: MeanLines,
    /// End of the free ground found by the sweep before, metres from the mirror's position in that sweep; `None` before
    /// the first sweep.
    last_m: Option<f32>,
}

impl Default for Guard {
    fn default() -> Self {
        Self::new()
    }
}

impl Guard {
    /// Returns a guard without evidence, as before the first sweep.
    pub const fn new() -> Self {
        Self {
            ground: Recursions::new(),
            above: Above::new(),
            surfaces: Surfaces::NOTHING,
            mean: MeanLines::new(),
            last_m: None,
        }
    }

    /// Discards the evidence of earlier sweeps: the next sweep counts as the first.
    // Out of line: what it puts in place comes over the stack.
    #[inline(never)]
    pub fn forget(&mut self) {
        self.mean = MeanLines::new();
        self.last_m = None;
    }

    /// Returns the free distance ahead, from the polar map of this sweep, the chair's motion (`drive`) and the evidence
    /// of earlier sweeps.
    #[inline(never)]
    pub fn sweep(&mut self, map: &PolarMap, config: &Config, drive: &Drive<'_>) -> FreeGround {
        let moved_m = match drive.mode {
            Mode::Standing => Some(0.0),
            _ => drive.moved_m,
        };
        let chart = Chart {
            bend: Slope::LEVEL,
            map,
            noise: noise::level(map),
            bias_rad: 0.0,
            height_m: 0.0,
            image: None,
            ride: MotionCompensation::of(drive, &config.radar),
        };
        let lines = &mut self.ground.lines;
        self.above.look(&chart, lines);
        self.mean.average(lines, &mut self.above, moved_m);
        self.ground.weigh(&mut self.surfaces, DEPTHS);
        self.conclude(moved_m)
    }

    /// Returns the free distance from this sweep's log-likelihood ratios of hazards by place; `moved_m` is the chair's
    /// forward travel since the sweep before, metres (`None`, unknown, counts as 0). The free distance grows only where
    /// two sweeps agree: of the ends of free ground in this sweep and in the one before, the nearer is used.
    #[inline(never)]
    fn conclude(&mut self, moved_m: Option<f32>) -> FreeGround {
        let hazards = Hazards::new(&self.surfaces, &self.above, &self.ground.lines);
        let before = self.last_m.map(|last| last - moved_m.unwrap_or(0.0));
        let reach = hazards.reach();
        self.last_m = Some(reach.end_m);
        hazards.free(reach, before)
    }
}
