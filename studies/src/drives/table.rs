//! Tables of drives: outcomes in, counts by kind and by cause out.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::{Value, json};

use super::log::DriveLog;
use super::outcome::{Cause, Outcome};
use host_sim::score::{Share, upper_bound};

/// Counts over the drives of one kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Number of drives, with and without a hazard.
    pub drives: usize,
    /// Drives over a hazard up to which the ground's echo is detectable, as a share of the drives
    /// that met a hazard.
    pub over_with_echo: Share,
    /// Drives over a hazard up to which the ground's echo is not detectable, as a share of the
    /// drives that met a hazard.
    pub over_no_echo: Share,
    /// Drives that stopped at most 30 cm before the hazard, as a share of those that met a hazard.
    pub near: Share,
    /// Drives that stopped at most 30 cm before the hazard, as a share of those that stopped before
    /// one, without stops farther away at which the ground's echo is not detectable up to the
    /// hazard.
    pub near_with_echo: Share,
    /// Drives that stopped more than 30 cm before the hazard, as a share of those that met a
    /// hazard.
    pub early: Share,
    /// Drives that reached the end of their way, as a share of those without a hazard.
    pub through: Share,
    /// Final distances from the foremost point to the hazard of the chairs that stopped before one,
    /// metres, ascending.
    gaps_m: Vec<f64>,
}

impl Tally {
    /// Counts the outcomes of the drives with these records.
    pub fn of<'a>(logs: impl Iterator<Item = &'a DriveLog>) -> Self {
        let all: Vec<Outcome> = logs.map(Outcome::of).collect();
        let is_free =
            |o: &&Outcome| matches!(o, Outcome::StoppedWithoutHazard | Outcome::Completed);
        let met: Vec<&Outcome> = all.iter().filter(|o| !is_free(o)).collect();
        let share = |so: fn(&Outcome) -> bool| Share::count(&met, |o| so(o));
        let judged = met.iter().filter(|o| {
            !matches!(
                o,
                Outcome::StoppedEarly {
                    has_ground_echo: false,
                    ..
                }
            )
        });
        let stood = judged.filter(|o| !matches!(o, Outcome::DroveOver { .. }));
        let mut gaps_m: Vec<f64> = (met.iter())
            .filter_map(|o| match o {
                Outcome::StoppedNear { gap_m } | Outcome::StoppedEarly { gap_m, .. } => {
                    Some(*gap_m)
                }
                _ => None,
            })
            .collect();
        gaps_m.sort_by(f64::total_cmp);
        Self {
            drives: all.len(),
            over_with_echo: share(|o| {
                matches!(
                    o,
                    Outcome::DroveOver {
                        has_ground_echo: true,
                        ..
                    }
                )
            }),
            over_no_echo: share(|o| {
                matches!(
                    o,
                    Outcome::DroveOver {
                        has_ground_echo: false,
                        ..
                    }
                )
            }),
            near: share(|o| matches!(o, Outcome::StoppedNear { .. })),
            near_with_echo: Share::count(stood, |o| matches!(o, Outcome::StoppedNear { .. })),
            early: share(|o| matches!(o, Outcome::StoppedEarly { .. })),
            through: Share::count(all.iter().filter(is_free), |o| *o == Outcome::Completed),
            gaps_m,
        }
    }

    /// Returns a quantile (0…1) of the final distances to the hazard, metres; `None` if no chair
    /// stopped before a hazard.
    fn gap_m(&self, quantile: f64) -> Option<f64> {
        let last = self.gaps_m.len().checked_sub(1)?;
        self.gaps_m
            .get((quantile * last as f64 + 0.5) as usize)
            .copied()
    }

    /// Returns the counts, shares and quantiles as a JSON object.
    pub fn json(&self, name: &str) -> Value {
        let gaps = [0.1, 0.5, 0.9].map(|quantile| self.gap_m(quantile));
        json!({
            "kind": name,
            "drives": self.drives,
            "over_shown": self.over_with_echo.json(),
            "over_shown_bound": upper_bound(self.over_with_echo.hits, self.over_with_echo.of),
            "over_dark": self.over_no_echo.json(),
            "near": self.near.json(),
            "near_shown": self.near_with_echo.json(),
            "early": self.early.json(),
            "through": self.through.json(),
            "gap_m": gaps,
        })
    }
}

/// Heading, in Markdown, of the table of [`row`]s.
pub const HEADING: &str = "| drives in | drives | to a hazard | drove over, with ground echo | \
    upper 95 % bound (Clopper-Pearson) | drove over, without ground echo | stopped within 30 cm | \
    of these, with ground echo | stopped farther away | gap, cm: 10 %, 50 %, 90 % | no hazard: \
    completed |\n|---|---|---|---|---|---|---|---|---|---|---|\n";

/// Returns the table's line, in Markdown, for one kind of scene.
pub fn row(name: &str, tally: &Tally) -> String {
    let counted = |share: Share| match share.of {
        0 => "–".into(),
        of => format!("{}/{of}", share.hits),
    };
    let bound = match tally.over_with_echo.of {
        0 => "–".into(),
        of => format!(
            "{:.2} %",
            100.0 * upper_bound(tally.over_with_echo.hits, of)
        ),
    };
    let gap = |q| {
        tally
            .gap_m(q)
            .map_or("–".into(), |m| format!("{:.0}", 100.0 * m))
    };
    format!(
        "| {name} | {} | {} | {} | {bound} | {} | {} | {} | {} | {}, {}, {} | {} |\n",
        tally.drives,
        tally.near.of,
        tally.over_with_echo.hits,
        tally.over_no_echo.hits,
        counted(tally.near),
        counted(tally.near_with_echo),
        counted(tally.early),
        gap(0.1),
        gap(0.5),
        gap(0.9),
        counted(tally.through)
    )
}

/// Counts the drives over a hazard by cause and by whether the ground's echo was detectable up to
/// the hazard.
pub fn causes(logs: &[DriveLog]) -> BTreeMap<(Cause, bool), usize> {
    let mut counts = BTreeMap::new();
    for log in logs {
        if let Outcome::DroveOver {
            has_ground_echo,
            cause,
        } = Outcome::of(log)
        {
            *counts.entry((cause, has_ground_echo)).or_default() += 1;
        }
    }
    counts
}

/// Returns the table of [`causes`], in Markdown.
pub fn causes_text(logs: &[DriveLog]) -> String {
    let counts = causes(logs);
    let mut out = String::from(
        "| drove over a hazard | with ground echo | without ground echo |\n|---|---|---|\n",
    );
    let count =
        |cause, has_ground_echo| counts.get(&(cause, has_ground_echo)).copied().unwrap_or(0);
    for cause in Cause::ALL {
        let (with_echo, no_echo) = (count(cause, true), count(cause, false));
        let _ = writeln!(out, "| {} | {with_echo} | {no_echo} |", cause.as_str());
    }
    out
}

/// Counts the chairs that stopped farther than 30 cm before a hazard, or without one. The key is
/// the last sentence's status, kind of hazard and reasons. The columns: hazard up to which the
/// ground's echo is detectable, hazard up to which it is not, no hazard.
pub fn halts(logs: &[DriveLog]) -> BTreeMap<String, [usize; 3]> {
    let mut counts: BTreeMap<String, [usize; 3]> = BTreeMap::new();
    for log in logs {
        let column = match Outcome::of(log) {
            Outcome::StoppedEarly {
                has_ground_echo: true,
                ..
            } => 0,
            Outcome::StoppedEarly {
                has_ground_echo: false,
                ..
            } => 1,
            Outcome::StoppedWithoutHazard => 2,
            _ => continue,
        };
        let Some(last) = log.sweeps.last() else {
            continue;
        };
        let reasons = last.reasons.to_string();
        let word = format!(
            "{}, {}",
            last.answer.status.as_str(),
            last.answer.ending.as_str()
        );
        let name = [word, reasons].join(" ").trim_end().to_owned();
        counts.entry(name).or_default()[column] += 1;
    }
    counts
}

/// Returns the table of [`halts`], in Markdown.
pub fn halts_text(logs: &[DriveLog]) -> String {
    let mut out = String::from(
        "| last sentence of chairs that stopped farther away | hazard, with ground echo | hazard, \
         without ground echo | no hazard |\n|---|---|---|---|\n",
    );
    for (word, [with_echo, no_echo, free]) in halts(logs) {
        let _ = writeln!(out, "| {word} | {with_echo} | {no_echo} | {free} |");
    }
    out
}
