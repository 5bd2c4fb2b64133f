//! From scan to scan: what earlier scans said of the stairs, carried on with the chair.
//!
//! | module | does |
//! |---|---|
//! | `hypotheses` | the likeliest staircases with their weights, moved by the way the chair went |
//! | `tracks` | each step's place and level, and what their errors have in common from scan to scan |
//! | `outlook` | how sure each place of the way was |
//!
//! Errors repeat from scan to scan: the same face shines in the same way, and a riser that shows nothing
//! shows nothing again. So a weight carried on counts less than a new one and only up to a bound, and
//! variances never fall below what the errors share.

mod hypotheses;
mod outlook;
mod tracks;

pub use hypotheses::{Hypotheses, Weighed};
pub use outlook::Outlook;
pub use tracks::Tracks;

use crate::answer::Step;
use crate::config::{Config, MountConfig, RadarConfig};
use crate::math;
use crate::model::View;
use crate::params::current;

/// The evidence of earlier scans, moved along with the chair.
#[derive(Debug)]
pub struct History {
    /// Number of the scan that it is of; none without one.
    scan: Option<u32>,
    /// With what instrument.
    instrument: (MountConfig, RadarConfig),
    /// What could be seen then.
    view: View,
    /// How far the chair has gone since, metres.
    moved_m: f32,
    /// Whether it contradicts this scan.
    changed: bool,
    /// The staircases that may stand there.
    pub hypotheses: Hypotheses,
    /// The steps that were told.
    pub tracks: Tracks,
    /// How sure the answer was.
    pub outlook: Outlook,
}

impl Default for History {
    fn default() -> Self {
        Self::new()
    }
}

impl History {
    /// Nothing yet.
    pub const fn new() -> Self {
        Self {
            scan: None,
            instrument: (Config::EMPTY.mount, Config::EMPTY.radar),
            view: View::NOTHING,
            moved_m: 0.0,
            changed: false,
            hypotheses: Hypotheses::new(),
            tracks: Tracks::new(),
            outlook: Outlook::new(),
        }
    }

    /// Scan number `scan` is worked off now. What is carried on is moved by the way since the scan
    /// before; where that is not known, the scan before was left out or made with another instrument, it
    /// is forgotten. During this scan the chair went `rode_m` metres.
    #[inline(never)]
    pub fn begin(
        &mut self,
        scan: u32,
        instrument: (MountConfig, RadarConfig),
        view: View,
        moved_m: Option<f32>,
        rode_m: f32,
    ) {
        self.changed = false;
        let follows = self.scan.is_some_and(|last| last.wrapping_add(1) == scan);
        let same = self.instrument == instrument;
        match moved_m.filter(|_| follows && same) {
            Some(moved_m) => {
                self.moved_m = moved_m;
                self.hypotheses.go(moved_m);
                self.tracks.go(moved_m, rode_m);
                self.outlook.go(moved_m);
            }
            None => self.forget(),
        }
        self.hypotheses.seen_from(self.view, view, self.moved_m);
        self.scan = Some(scan);
        self.instrument = instrument;
        self.view = view;
    }

    /// Scan number `scan` stands aside: the one after it follows on the one before it.
    pub fn pass_over(&mut self, scan: u32) {
        let before = scan.wrapping_sub(1);
        if let Some(last) = self.scan.as_mut().filter(|last| **last == before) {
            *last = scan;
        }
    }

    /// Forgets everything: the next scan is a first one.
    pub fn forget(&mut self) {
        self.scan = None;
        self.moved_m = 0.0;
        self.drop_past();
    }

    /// Forgets what was carried to this scan.
    fn drop_past(&mut self) {
        self.hypotheses.drop_past();
        self.tracks.drop_past();
        self.outlook.drop_past();
    }

    /// The steps of this scan's answer, compared with and then combined with what earlier scans said.
    #[inline(never)]
    pub fn combine(&mut self, steps: &mut [Step]) {
        let Self {
            hypotheses,
            tracks,
            outlook,
            ..
        } = self;
        outlook.compare(tracks.told(), steps, |x_m, y_m| {
            hypotheses.could_see(x_m, y_m)
        });
        tracks.combine(steps);
    }

    /// Keeps what may stand there by this scan alone for the next one, weighed by earlier scans, too. Where this scan
    /// contradicts them, they are forgotten first.
    #[inline(never)]
    pub fn keep(&mut self, outlines: &[Weighed]) {
        let expected =
            |o: &&Weighed| self.hypotheses.word(&o.staircase) > -current().carried_most_nats;
        let most =
            |weights: &mut dyn Iterator<Item = f32>| weights.fold(f32::NEG_INFINITY, math::max);
        let alone = most(&mut outlines.iter().map(|o| o.log_weight));
        let known = most(&mut outlines.iter().filter(expected).map(|o| o.log_weight));
        if !self.is_empty() && alone > known + current().scene_changed_nats {
            self.changed = true;
            self.drop_past();
        }
        for o in outlines {
            let word = self.hypotheses.word(&o.staircase);
            self.hypotheses.keep(&o.staircase, o.log_weight + word);
        }
        self.hypotheses.normalise();
    }

    /// Whether what was carried on contradicted this scan and was forgotten.
    pub fn changed(&self) -> bool {
        self.changed
    }

    /// Whether this scan tells just the steps that were told before, where the way since has brought
    /// them: then the motion input was right.
    pub fn confirms(&self) -> bool {
        self.tracks.confirmed() && self.outlook.agrees()
    }

    /// Whether anything was carried to this scan.
    pub fn is_empty(&self) -> bool {
        self.hypotheses.is_empty()
    }
}

#[cfg(test)]
mod tests;
