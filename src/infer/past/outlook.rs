//! How sure each place of the way ahead was in earlier scans.

use crate::answer::Step;
use crate::infer::cloud::{CELL_M, CELLS, FIRST_END_M};
use crate::math;
use crate::model::RIGHT_M;
use crate::params::carried::PastFeatures;
use crate::params::current;

/// Log-odds of an error count up to here either way: e^9 to one is certain.
const MOST_ODDS: f32 = 9.0;
/// Farther than this, metres, what stands behind a landing is mostly too faint to be seen: counted in
/// parts of …
const FAR_M: f32 = 2.0;
/// … so much.
const FAR_CELLS_M: f32 = 0.5;
/// Errors count up to so many standard deviations within what is right.
const MOST_SIGMAS: f32 = 4.0;
/// So many scans count.
const MOST_SCANS: f32 = 4.0;

/// What earlier scans say of a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Past {
    /// Number of scans that agree about it.
    scans: f32,
    /// Log-odds of an error there by the surest of them, …
    least: f32,
    /// … and on the mean.
    mean: f32,
}

/// The same in a few bytes: log-odds in [`FINE`]ths.
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

/// Log-odds are kept in parts of so many to one.
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

    /// With one more scan.
    fn with(&self, odds: f32) -> Self {
        if self.scans <= 0.0 {
            return Self {
                scans: 1.0,
                least: odds,
                mean: odds,
            };
        }
        let scans = math::min(self.scans + 1.0, MOST_SCANS);
        Self {
            scans,
            least: math::min(self.least, odds),
            mean: self.mean + (odds - self.mean) / scans,
        }
    }
}

/// That of each cell, and whether the answer is another one there.
#[derive(Debug)]
pub struct Outlook {
    /// Of earlier scans' cells, where they were.
    past: [PackedOdds; CELLS],
    present: [PackedOdds; CELLS],
    /// How far the chair has gone since, metres; none where nothing was carried on.
    moved_m: Option<f32>,
    /// Cells in which this answer and the one before do not agree, a bit each.
    differs: u32,
}

const _: () = assert!(CELLS <= u32::BITS as usize);

/// Number of the cell that a place lies in; that of a step's error is 3 cm before the step.
fn cell(x_m: f32) -> usize {
    math::max(math::ceil((x_m - FIRST_END_M) / CELL_M), 0.0) as usize
}

impl Outlook {
    /// Nothing.
    pub(super) const fn new() -> Self {
        Self {
            past: [PackedOdds::NONE; CELLS],
            present: [PackedOdds::NONE; CELLS],
            moved_m: None,
            differs: 0,
        }
    }

    pub(super) fn go(&mut self, moved_m: f32) {
        self.past = self.present;
        self.moved_m = Some(moved_m);
        self.present = [PackedOdds::NONE; CELLS];
        self.differs = 0;
    }

    pub(super) fn drop_past(&mut self) {
        self.moved_m = None;
        self.present = [PackedOdds::NONE; CELLS];
        self.differs = 0;
    }

    /// Compares the steps of this answer, before they are combined, with those told before.
    #[inline(never)]
    pub(super) fn compare(
        &mut self,
        told: impl Iterator<Item = (f32, f32)> + Clone,
        steps: &[Step],
        seen: impl Fn(f32, f32) -> bool,
    ) {
        let mut differs = 0;
        let mut mark = |x_m: f32| {
            differs |= 1_u32.checked_shl(cell(x_m - RIGHT_M) as u32).unwrap_or(0);
        };
        for step in steps {
            let same = |(x, y): (f32, f32)| {
                (x - step.distance_m).abs() <= current().same_step_m
                    && (y - step.height_m).abs() <= RIGHT_M
            };
            if seen(step.distance_m, step.height_m) && !told.clone().any(same) {
                mark(step.distance_m);
            }
        }
        for (x_m, _) in told {
            if !steps
                .iter()
                .any(|s| (x_m - s.distance_m).abs() <= current().same_step_m)
            {
                mark(x_m);
            }
        }
        self.differs = differs;
    }

    /// Whether this answer has the steps of the one before.
    pub(super) fn agrees(&self) -> bool {
        self.moved_m.is_some() && self.differs == 0
    }

    /// What earlier scans say of cell `k`, which holds a step at `step_m` or none.
    #[inline(never)]
    fn of(&self, k: usize, step_m: Option<f32>) -> Past {
        let Some(moved_m) = self.moved_m else {
            return Past::NONE;
        };
        let at = |k: usize| self.past.get(k).map_or(Past::NONE, |p| Past::unpack(*p));
        if let Some(x_m) = step_m {
            return at(cell(x_m + moved_m - RIGHT_M));
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

    /// What is known of cell `k` by this scan, whose log-odds of an error there are `odds`, and by
    /// earlier ones; none where nothing was carried on. The cell holds a step or none;
    /// `behind` where none lies farther on either. This scan's word is kept for the next one.
    #[inline(never)]
    pub fn look(
        &mut self,
        k: usize,
        odds: f32,
        step: Option<&Step>,
        behind: bool,
    ) -> Option<PastFeatures> {
        let step_m = step.map(|s| s.distance_m);
        let step_sure = step.map_or(0.0, |s| math::min(RIGHT_M / s.height_sigma_m, MOST_SIGMAS));
        let odds = odds.clamp(-MOST_ODDS, MOST_ODDS);
        let differs = self.differs.checked_shr(k as u32).unwrap_or(0) & 1 == 1;
        let past = if differs {
            Past::NONE
        } else {
            self.of(k, step_m)
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
