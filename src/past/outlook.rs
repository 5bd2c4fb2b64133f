//! Log-odds that an answer is first wrong in each way cell, carried on from earlier scans.

use crate::answer::Step;
use crate::math;
use crate::model::MIN_EXPANDED_M;
use crate::model::cloud::{CELL_M, CELLS, FIRST_END_M};
use crate::params::Numbers;
use crate::params::carried::{
    FAR_CELLS_M, FAR_M, MAX_CARRIED_ODDS, MAX_SCANS, MAX_STEP_SIGMAS, PastFeatures,
};

/// Evidence of earlier scans about a way cell.
#[derive(Clone, Copy, Debug, Default)]
struct Past {
    /// Number of scans whose answers agree in the cell, at most [`MAX_SCANS`].
    scans: f32,
    /// Minimum over these scans of the log-odds of an error in the cell, nats.
    least: f32,
    /// Mean over these scans of the log-odds of an error in the cell, nats.
    mean: f32,
}

/// Evidence of earlier scans about a way cell ([`Past`]) packed into three bytes, log-odds in units of 1/[`FINE`] nat.
#[derive(Clone, Copy, Debug, Default)]
struct PackedOdds {
    scans: u8,
    least: i8,
    mean: i8,
}

impl PackedOdds {
    const NONE: Self = Self {
        scans: 0,
        least: 0,
        mean: 0,
    };
}

/// Number of units of the packed log-odds of an error per nat.
const FINE: f32 = 12.0;

impl Past {
    const NONE: Self = Self {
        scans: 0.0,
        least: 0.0,
        mean: 0.0,
    };

    fn pack(&self) -> PackedOdds {
        PackedOdds {
            scans: self.scans as u8,
            least: math::round(self.least * FINE) as i8,
            mean: math::round(self.mean * FINE) as i8,
        }
    }

    fn unpack(p: PackedOdds) -> Self {
        Self {
            scans: f32::from(p.scans),
            least: f32::from(p.least) / FINE,
            mean: f32::from(p.mean) / FINE,
        }
    }

    /// Returns the evidence with one more scan added, whose log-odds of an error are `odds`, nats.
    fn with(&self, odds: f32) -> Self {
        if self.scans <= 0.0 {
            return Self {
                scans: 1.0,
                least: odds,
                mean: odds,
            };
        }
        let scans = math::min(self.scans + 1.0, MAX_SCANS);
        Self {
            scans,
            least: math::min(self.least, odds),
            mean: self.mean + (odds - self.mean) / scans,
        }
    }
}

/// Evidence of earlier scans by way cell, and the cells in which this answer and the one before differ.
#[derive(Debug)]
pub struct CarriedOdds {
    /// Evidence of earlier scans, by way cell as seen from the chair's place at the scan before, the nearest first.
    past: [PackedOdds; CELLS],
    present: [PackedOdds; CELLS],
    /// Forward displacement of the chair since the scan before, metres; none where no evidence was carried on.
    moved_m: Option<f32>,
    /// Cells in which this answer differs from the one before: bit k for cell k.
    differing_cells: u32,
    numbers: Numbers,
}

const _: () = assert!(CELLS <= u32::BITS as usize);

/// Returns the index of the way cell that holds a place, metres from the mirror. For the error of a step, callers pass
/// the place 3 cm before the step.
fn cell(x_m: f32) -> usize {
    math::max(math::ceil((x_m - FIRST_END_M) / CELL_M), 0.0) as usize
}

impl CarriedOdds {
    /// Returns the state without evidence of earlier scans.
    pub(super) const fn new(numbers: Numbers) -> Self {
        Self {
            past: [PackedOdds::NONE; CELLS],
            present: [PackedOdds::NONE; CELLS],
            moved_m: None,
            differing_cells: 0,
            numbers,
        }
    }

    pub(super) fn shift(&mut self, moved_m: f32) {
        self.past = self.present;
        self.moved_m = Some(moved_m);
        self.present = [PackedOdds::NONE; CELLS];
        self.differing_cells = 0;
    }

    pub(super) fn clear_carried(&mut self) {
        self.moved_m = None;
        self.present = [PackedOdds::NONE; CELLS];
        self.differing_cells = 0;
    }

    /// Marks the cells in which the steps of this answer, before they are combined, differ from those `reported` before
    /// (distance and height, metres). `seen` returns whether the scan before could see a step at a distance and height.
    #[inline(never)]
    pub(super) fn compare(
        &mut self,
        reported: impl Iterator<Item = (f32, f32)> + Clone,
        steps: &[Step],
        seen: impl Fn(f32, f32) -> bool,
    ) {
        let same_step_m = self.numbers.same_step_m;
        let mut differs = 0;
        let mut mark = |x_m: f32| {
            differs |= 1_u32
                .checked_shl(cell(x_m - MIN_EXPANDED_M) as u32)
                .unwrap_or(0);
        };
        for step in steps {
            let same = |(x, y): (f32, f32)| {
                (x - step.distance_m).abs() <= same_step_m
                    && (y - step.height_m).abs() <= MIN_EXPANDED_M
            };
            if seen(step.distance_m, step.height_m) && !reported.clone().any(same) {
                mark(step.distance_m);
            }
        }
        for (x_m, _) in reported {
            if !steps
                .iter()
                .any(|s| (x_m - s.distance_m).abs() <= same_step_m)
            {
                mark(x_m);
            }
        }
        self.differing_cells = differs;
    }

    /// Whether this answer has the same steps as the one before.
    pub(super) fn agrees(&self) -> bool {
        self.moved_m.is_some() && self.differing_cells == 0
    }

    /// Returns the evidence of earlier scans about way cell `k`, moved by the chair's displacement. `step_m` is the
    /// distance of the step in the cell, metres, if there is one.
    #[inline(never)]
    fn carried_evidence(&self, k: usize, step_m: Option<f32>) -> Past {
        let Some(moved_m) = self.moved_m else {
            return Past::NONE;
        };
        let at = |k: usize| self.past.get(k).map_or(Past::NONE, |p| Past::unpack(*p));
        if let Some(x_m) = step_m {
            return at(cell(x_m + moved_m - MIN_EXPANDED_M));
        }
        let place = k as f32 + moved_m / CELL_M;
        let (near, far) = (math::floor(place), math::ceil(place));
        let share = place - near;
        let (near, far) = (
            at(math::max(near, 0.0) as usize),
            at(math::max(far, 0.0) as usize),
        );
        if near.scans <= 0.0 || far.scans <= 0.0 {
            return Past::NONE;
        }
        let mix = |a: f32, b: f32| a + share * (b - a);
        Past {
            scans: math::min(near.scans, far.scans),
            least: mix(near.least, far.least),
            mean: mix(near.mean, far.mean),
        }
    }

    /// Returns the features of way cell `k` by this scan and earlier ones; `None` where nothing was carried on. `odds`
    /// are this scan's log-odds that the answer is first wrong in the cell, nats, which are stored for the next scan.
    /// `step` is the answer's step in the cell, if any; `behind` is whether the cell and everything farther away have
    /// no step.
    #[inline(never)]
    pub fn features(
        &mut self,
        k: usize,
        odds: f32,
        step: Option<&Step>,
        behind: bool,
    ) -> Option<PastFeatures> {
        let step_m = step.map(|s| s.distance_m);
        let step_sure = step.map_or(0.0, |s| {
            math::min(MIN_EXPANDED_M / s.height_sigma_m, MAX_STEP_SIGMAS)
        });
        let odds = odds.clamp(-MAX_CARRIED_ODDS, MAX_CARRIED_ODDS);
        let differs = self.differing_cells.checked_shr(k as u32).unwrap_or(0) & 1 == 1;
        let past = if differs {
            Past::NONE
        } else {
            self.carried_evidence(k, step_m)
        };
        if let Some(place) = self.present.get_mut(k) {
            *place = past.with(odds).pack();
        }
        self.moved_m?;
        let known = f32::from(past.scans > 0.0);
        let behind = known * f32::from(behind);
        let step = known * f32::from(step_m.is_some());
        Some([
            1.0 - known,
            (1.0 - known) * odds,
            known,
            known * odds,
            past.least,
            past.mean,
            past.scans,
            f32::from(differs),
            behind * math::max(FIRST_END_M + CELL_M * k as f32 - FAR_M, 0.0) / FAR_CELLS_M,
            behind,
            behind * odds,
            step * step_sure,
        ])
    }
}
