//! Summary of a run: counts, largest gaps, and wear of the flash.

use stairscan::scanner::store::SLOT;
use testbed::board::SECTOR;

use super::gaps::{DAY_US, Gap};
use super::life::Run;
use super::watch::Counts;
use super::world::ENDURANCE;

/// Result of an endurance run.
#[derive(Clone, Debug)]
pub struct Summary {
    /// Texts of the failed checks, each with day, time and sentence; a hundred, and one if the flash refused
    /// operations.
    pub failures: Vec<String>,
    /// Number of failed checks that are not in `failures`.
    pub more_failures: u64,
    /// Simulated time, days.
    pub days: f64,
    /// Numbers of sentences and of planned faults.
    pub counts: Counts,
    /// Number of chirps that the radar module has delivered.
    pub rows: u64,
    /// Number of boots of the scanner.
    pub boots: u64,
    /// Numbers of wraps: of the scanner's clock, of the motion sentences' sequence number, and of their travel counter.
    pub wraps: [u64; 3],
    /// Largest gap between two `LIVE` sentences, largest gap between two guard sweeps, and longest time from a fault's
    /// end to the next answer.
    pub gaps: [Gap; 3],
    /// Number of times that the settings were saved.
    pub saves: u64,
    /// Number of erasures of each of the two flash sectors.
    pub erasures: [u64; 2],
    /// Number of operations that the flash refused.
    pub refused: u64,
}

impl Summary {
    /// Returns the summary of a finished run.
    pub fn of(run: Run) -> Self {
        let world = run.world.borrow();
        let mut failures = run.watch.failures;
        let flash = world.board.get().flash.clone();
        let refused = flash.misused;
        if refused > 0 {
            failures.push(format!("the flash refused {refused} operations"));
        }
        Self {
            failures,
            more_failures: run.watch.dropped,
            days: world.now as f64 / DAY_US as f64,
            counts: run.watch.counts,
            rows: world.module.get().answered,
            boots: run.boots,
            wraps: [run.wraps, run.controller.wraps, run.controller.restarts],
            gaps: [run.watch.live_gap, run.watch.sweep_gap, run.watch.recovery],
            saves: run.saves,
            erasures: [0, 1].map(|sector| flash.erasures[sector]),
            refused,
        }
    }

    /// Returns the number of saves after which both sectors have reached their endurance: erasures times the number of
    /// records in the two sectors.
    pub fn endurance_saves() -> u64 {
        2 * ENDURANCE * (SECTOR as u64 / u64::from(SLOT))
    }

    /// Returns the summary as a table.
    pub fn table(&self) -> String {
        let [clock, sequence, travel] = self.wraps;
        let Counts {
            scans,
            sweeps,
            live,
            sentences,
            faults,
            recovered,
        } = self.counts;
        let [first, second] = self.erasures;
        let mut rows = vec![
            (
                "simulated time",
                format!("{:.1} days, {} boots", self.days, self.boots),
            ),
            ("sentences", format!("{sentences}, {live} of them LIVE")),
            (
                "scans",
                format!("{scans}, and {sweeps} guard sweeps; {} rows", self.rows),
            ),
            (
                "wraps",
                format!(
                    "{clock} of the clock, {sequence} of the motion sentences' number, {travel} of its travel"
                ),
            ),
        ];
        for (name, gap) in ["LIVE", "guard sweeps", "recovery"]
            .into_iter()
            .zip(&self.gaps)
        {
            rows.push((name, gap_text(gap)));
        }
        rows.push((
            "planned faults",
            format!("{faults}, recovered by itself from {recovered}"),
        ));
        rows.push((
            "saves",
            format!(
                "{}; erasures of the sectors: {first} and {second}",
                self.saves
            ),
        ));
        rows.push((
            "flash",
            format!(
                "{} saves until a sector has {ENDURANCE} erasures",
                Self::endurance_saves()
            ),
        ));
        let failed = self.failures.len() as u64 + self.more_failures;
        rows.push(("failed checks", failed.to_string()));
        let line = |(name, text): &(&str, String)| format!("{name:<16}{text}\n");
        rows.iter().map(line).collect()
    }
}

/// Returns a gap as text, ms: the largest, and the largest near a wrap of the clock with the number of such gaps.
fn gap_text(gap: &Gap) -> String {
    format!(
        "{} ms at most, {} ms within a minute of a wrap (of {})",
        gap.all / 1_000,
        gap.near_wrap / 1_000,
        gap.count_near
    )
}
