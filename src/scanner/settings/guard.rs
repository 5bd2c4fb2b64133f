//! Settings of the guard: its sector of the ground, and its sweep rate.

use crate::config::{Config, ConfigError, EstimatorKind, Plane, SweepConfig, check};
use crate::schedule::Schedule;
use crate::setting::settings;
use crate::signal::grid::{BinWindow, MAX_CELLS};

/// Minimum number of rows of a guard sweep: the noise is taken from every eighth row, and lost rows must be few
/// among them.
const MIN_ROWS: i32 = 9;

settings! {
    /// Settings of the guard's coarse sweep. None of them enters the hash, since a scan's answer does not
    /// depend on them.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub struct GuardConfig
    parts {}
    rows {
        // Design contract: from 8 to 38 degrees in steps of one, a fifth of the beam.
        /// First angle of a guard sweep, below the horizontal.
        first: i32 = 8_000, "guard-first" "0.001 deg" [-20_000 to 80_000] Operation;
        /// Last angle of a guard sweep.
        last: i32 = 38_000, "guard-last" "0.001 deg" [-20_000 to 80_000] Operation;
        /// Angle step of a guard sweep.
        step: u16 = 1_000, "guard-step" "0.001 deg" [100 to 5_000] Operation;
        // Reached at 3 Mbaud with every other setting at its default; an acceleration of 4,000,000 reaches 8.
        /// Minimum guard sweep rate; `guard` is refused if it cannot be reached; 0: no minimum.
        rate: u8 = 7, "guard-rate" "sweeps/s" [0 to 50] Operation;
        /// Distance below which a rise or drop triggers a full scan with `watch`.
        watch_distance: u32 = 150_000, "watch-distance" "0.01 mm" [20_000 to 240_000] Operation;
    }
    also {}
}

impl GuardConfig {
    /// Returns first angle, angle step and number of rows of a guard sweep.
    pub fn sweep(&self) -> SweepConfig {
        let step = i32::from(self.step.max(1));
        let steps = self.last.saturating_sub(self.first) / step;
        SweepConfig {
            first_angle: self.first,
            angle_step: step,
            // `as` saturates.
            angle_count: steps.clamp(0, i32::from(u16::MAX) - 1) as u16 + 1,
        }
    }

    /// Returns the distance of a rise or drop below which `watch` takes a full scan, metres.
    pub fn watch_m(&self) -> f32 {
        self.watch_distance as f32 * 1e-5
    }

    /// Checks that the guard's sector holds at least nine rows.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let way = self.last.saturating_sub(self.first);
        check(
            way >= (MIN_ROWS - 1).saturating_mul(self.step.into()),
            "guard-last",
            "beyond guard-first by 8 times guard-step or more",
        )
    }

    /// Checks that a guard with this configuration works: its sector is in the depth plane, its rows leave no
    /// gap, and the map holds them.
    pub fn check(&self, config: &Config) -> Result<(), ConfigError> {
        let sweep = self.sweep();
        check(
            config.mount.plane.first() == Plane::Depth,
            "plane",
            "depth or both: the guard needs the depth plane",
        )?;
        check(
            config.estimator == EstimatorKind::Likelihood,
            "estimator",
            "likelihood: the only estimator with a guard",
        )?;
        check(
            sweep.angle_step <= config.mount.beamwidth,
            "guard-step",
            "beamwidth at most: otherwise the rows leave gaps",
        )?;
        let window = BinWindow::of_scan(&Config { sweep, ..*config });
        check(
            usize::from(window.count) * usize::from(sweep.angle_count) <= MAX_CELLS,
            "guard-step",
            "a map of 65536 cells at most",
        )?;
        Schedule::in_plane(sweep, Plane::Depth).map(|_| ())
    }
}
