//! Evidence of earlier scans, moved along with the chair.
//!
//! | module | content |
//! |---|---|
//! | `hypotheses` | the likeliest staircases with their weights, moved by the chair's displacement |
//! | `tracks` | each step's place and level, combined over scans with correlated errors |
//! | `outlook` | log-odds of an error in each cell of the way |
//!
//! Errors repeat from scan to scan: the same face reflects in the same way, and a riser without an echo has none in
//! the next scan either. Therefore a carried log-weight is scaled down and limited, and variances never fall below
//! the correlated part of the errors.

mod hypotheses;
mod outlook;
mod tracks;

pub use hypotheses::{CarriedHypotheses, Weighed};
pub use outlook::CarriedOdds;
pub use tracks::Tracks;

use crate::answer::Step;
use crate::config::{Config, MountConfig, RadarConfig};
use crate::math;
use crate::model::View;
use crate::params::Numbers;

/// The evidence of earlier scans, moved along with the chair.
#[derive(Debug)]
pub struct History {
    /// Number of the latest scan; none before the first one.
    scan: Option<u32>,
    /// Settings of the mounting at the latest scan.
    mount: MountConfig,
    /// Settings of the radar at the latest scan.
    radar: RadarConfig,
    /// Field of view of the latest scan.
    view: View,
    /// Forward displacement of the chair between the latest scan and the one before, metres.
    moved_m: f32,
    /// Whether the latest scan contradicted the evidence of earlier scans, which was then discarded.
    changed: bool,
    /// The likeliest staircases, at their present places, with their weights.
    pub hypotheses: CarriedHypotheses,
    /// Reported steps, with distances and heights combined over scans.
    pub tracks: Tracks,
    /// Log-odds that the answer is wrong, by way cell.
    pub carried_odds: CarriedOdds,
    numbers: Numbers,
}

/// A scan that begins: its number, its instrument, and the chair's motion since the scan before.
#[derive(Clone, Copy, Debug)]
pub struct NewScan {
    /// Number of the scan.
    pub number: u32,
    /// Settings of the mounting.
    pub mount: MountConfig,
    /// Settings of the radar.
    pub radar: RadarConfig,
    /// Field of view of the scan.
    pub view: View,
    /// Forward displacement of the chair since the scan before, metres; `None` if unknown.
    pub moved_m: Option<f32>,
    /// Forward displacement during this scan, metres.
    pub moved_during_scan_m: f32,
}

impl Default for History {
    fn default() -> Self {
        Self::new(Numbers::DEFAULT)
    }
}

impl History {
    /// Returns a history without scans.
    pub const fn new(numbers: Numbers) -> Self {
        Self {
            scan: None,
            mount: Config::EMPTY.mount,
            radar: Config::EMPTY.radar,
            view: View::NOTHING,
            moved_m: 0.0,
            changed: false,
            hypotheses: CarriedHypotheses::new(numbers),
            tracks: Tracks::new(numbers),
            carried_odds: CarriedOdds::new(numbers),
            numbers,
        }
    }

    /// Begins a scan. The evidence is moved by the displacement since the scan before. It is discarded if the
    /// displacement is unknown, or if the scan before was left out or made with another instrument.
    #[inline(never)]
    pub fn begin(&mut self, new: &NewScan) {
        self.changed = false;
        let follows = self
            .scan
            .is_some_and(|last| last.wrapping_add(1) == new.number);
        let same = self.mount == new.mount && self.radar == new.radar;
        match new.moved_m.filter(|_| follows && same) {
            Some(moved_m) => {
                self.moved_m = moved_m;
                self.hypotheses.shift(moved_m);
                self.tracks.shift(moved_m, new.moved_during_scan_m);
                self.carried_odds.shift(moved_m);
            }
            None => self.clear(),
        }
        self.hypotheses.set_views(self.view, new.view, self.moved_m);
        self.scan = Some(new.number);
        (self.mount, self.radar) = (new.mount, new.radar);
        self.view = new.view;
    }

    /// Leaves scan number `scan` out: the scan after it follows on the one before it.
    pub fn skip_scan(&mut self, scan: u32) {
        let before = scan.wrapping_sub(1);
        if let Some(last) = self.scan.as_mut().filter(|last| **last == before) {
            *last = scan;
        }
    }

    /// Discards everything: the next scan counts as the first one.
    pub fn clear(&mut self) {
        self.scan = None;
        self.moved_m = 0.0;
        self.clear_carried();
    }

    /// Discards the evidence that was carried to this scan.
    fn clear_carried(&mut self) {
        self.hypotheses.clear_carried();
        self.tracks.clear_carried();
        self.carried_odds.clear_carried();
    }

    /// Compares the steps of this scan's answer with the earlier ones, then combines them: the distances, heights and
    /// standard deviations in `steps` become the combined ones.
    #[inline(never)]
    pub fn combine(&mut self, steps: &mut [Step]) {
        let Self {
            hypotheses,
            tracks,
            carried_odds,
            ..
        } = self;
        carried_odds.compare(tracks.reported_steps(), steps, |x_m, y_m| {
            hypotheses.could_see(x_m, y_m)
        });
        tracks.combine(steps);
    }

    /// Stores the outlines of this scan for the next one, with their cumulative log-weights. If this scan contradicts
    /// the earlier ones, their evidence is discarded first.
    #[inline(never)]
    pub fn keep(&mut self, outlines: &[Weighed]) {
        let expected = |o: &&Weighed| {
            self.hypotheses.log_prior(&o.staircase) > -self.numbers.carried_most_nats
        };
        let most =
            |weights: &mut dyn Iterator<Item = f32>| weights.fold(f32::NEG_INFINITY, math::max);
        let alone = most(&mut outlines.iter().map(|o| o.log_weight));
        let known = most(&mut outlines.iter().filter(expected).map(|o| o.log_weight));
        if !self.is_empty() && alone > known + self.numbers.scene_changed_nats {
            self.changed = true;
            self.clear_carried();
        }
        for o in outlines {
            let word = self.hypotheses.log_prior(&o.staircase);
            self.hypotheses.keep(&o.staircase, o.log_weight + word);
        }
        self.hypotheses.normalise();
    }

    /// Whether the carried evidence contradicted this scan and was discarded.
    pub fn changed(&self) -> bool {
        self.changed
    }

    /// Whether this scan has exactly the steps that were reported before, at the places expected from the
    /// displacement. This confirms the motion input.
    pub fn confirms_motion(&self) -> bool {
        self.tracks.confirmed() && self.carried_odds.agrees()
    }

    /// Whether no evidence was carried to this scan.
    pub fn is_empty(&self) -> bool {
        self.hypotheses.is_empty()
    }
}

#[cfg(test)]
mod tests;
