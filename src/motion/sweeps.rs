//! Comparison of two sweeps over the same scene: whether the chair stands, or moves as its controller reports.
//!
//! The strongest echoes of the sweep before are kept. With motion input, both sweeps' echoes are moved to where
//! they lie as seen from the chair's position at the end of its sweep, and the travel in between is subtracted:
//! fixed scatterers must then coincide. Without motion input, each pair of echoes at one height that a straight
//! drive can explain votes for a speed. Ground echoes look alike everywhere and change with every centimetre,
//! so strong echoes have more weight.

use super::odometer::same_place_m;
use crate::config::{Config, Plane};
use crate::drive::{Agreement, Drive, Finding, Input, Mode, PhaseAgreement, Retention};
use crate::math;
use crate::params::motion::{
    DRIVING_SHARE, FROM_DB, MAX_DB, MIN_MARGIN, MIN_SHARE, SAME_HEIGHT_M, SAME_HEIGHT_RAD,
    SAME_PLACE_M, STANDING_M, STANDING_SHARE, STEADY_SHARE,
};
use crate::signal::echoes::{Echo, MotionCompensation, row_of};
use crate::signal::grid::PolarMap;
use heapless::Vec;

/// Number of a sweep's strongest echoes that are compared.
const MAX_SWEEP_ECHOES: usize = 24;

/// A strong echo as it is kept for the comparison with the next sweep.
#[derive(Clone, Copy, Debug)]
struct SweepEcho {
    x_m: f32,
    y_m: f32,
    range_m: f32,
    /// Time from the echo's row to the sweep's last row, seconds.
    before_s: f32,
    weight: f32,
}

type SweepEchoes = Vec<SweepEcho, MAX_SWEEP_ECHOES>;

/// Comparison of each sweep with the one before, whose strongest echoes are kept.
#[derive(Debug)]
pub struct SweepComparison {
    echoes: SweepEchoes,
    plane: Plane,
    /// Whether the kept echoes are given as seen from the mirror at their sweep's last row.
    placed: bool,
}

/// Bin width of the histogram of distances between two sweeps' echoes, metres.
const BIN_M: f32 = 0.01;
/// Number of bins of the histogram of distances to each side of zero.
const BINS: usize = 60;

/// Maximum share of the travel from sweep to sweep that lies between them, where the phases of the later one confirm it.
const MOST_BETWEEN: f32 = 0.1;

/// Number of travels to each side of the reported one that are tested beside it.
const OTHER_TRAVELS: usize = 12;
/// Distance between the travels that are tested beside the reported one, metres.
const OTHER_TRAVEL_STEP_M: f32 = 0.05;

impl Default for SweepComparison {
    fn default() -> Self {
        Self::new()
    }
}

impl SweepComparison {
    /// Empty, before the first sweep.
    pub const fn new() -> Self {
        Self {
            echoes: SweepEchoes::new(),
            plane: Plane::Depth,
            placed: false,
        }
    }

    /// Moves the echoes to where they lie as seen from the mirror at the last row, as far as the motion is
    /// known or can be estimated, and compares them with those of the sweep before.
    ///
    /// A sweep of the other plane in between is not compared, does not replace the stored sweep, and is never
    /// confirmed: its first edge lies farther ahead than the model of treads seen from above searches.
    #[inline(never)]
    pub fn compare(
        &mut self,
        map: &PolarMap,
        config: &Config,
        drive: &Drive<'_>,
        echoes: &mut [Echo],
    ) -> Agreement {
        let input = drive.input;
        let aside = drive.memory == Retention::Aside;
        // Result where the sweep is not compared and the chair is known to stand.
        let by_itself = if aside {
            Finding::Unconfirmed
        } else {
            Finding::Agreed
        };
        let Some(track) = drive.track.filter(|_| drive.mode != Mode::Standing) else {
            self.echoes.clear();
            return Agreement {
                finding: by_itself,
                input: Input::Absent,
            };
        };
        let known = input == Input::Good;
        let mut ride = MotionCompensation::along(track, drive, &config.radar);
        let marks = sweep_echoes(echoes, map, &ride, known);
        let plane = map.geometry().plane;
        let same = self.plane == plane && self.placed == known;
        let comparable = !self.echoes.is_empty() && same && !aside;
        let finding = match (comparable, known, drive.moved_m, drive.since_s) {
            (true, true, Some(moved_m), _) => {
                // The phases know of the way during this sweep only.
                let between_m = (moved_m - track.end().travel_m).abs();
                let seen = between_m < MOST_BETWEEN * moved_m.abs();
                let phases = drive.phases == PhaseAgreement::Agrees && seen;
                self.driven(&marks, moved_m, phases)
            }
            (true, false, _, Some(since_s)) => {
                let creep = self.steady_speed(&marks, since_s);
                ride.steady_speed = creep.speed;
                creep.finding
            }
            _ => Finding::Unconfirmed,
        };
        // The phases of one sweep show its speed.
        let finding = match (finding, drive.phases) {
            (Finding::Unconfirmed, PhaseAgreement::Agrees) => by_itself,
            (Finding::Unconfirmed, PhaseAgreement::Differs) => Finding::Moved,
            _ => finding,
        };
        if known || ride.steady_speed.is_some() {
            echoes
                .iter_mut()
                .for_each(|echo| ride.compensate(echo, map));
        }
        if !aside {
            self.echoes = marks;
            self.plane = plane;
            self.placed = known;
        }
        let missing = drive.mode == Mode::Required && !known;
        let finding = if missing { Finding::Missing } else { finding };
        Agreement { finding, input }
    }

    /// Compares this sweep's echoes `marks` with the sweep before, with a reported travel of `moved_m` metres
    /// in between. `Agreed` requires that the sweeps agree better than for any other travel, and by more than a
    /// few weak echoes can cause, or that the phases confirm the travel (`by_phases`).
    fn driven(&self, marks: &[SweepEcho], moved_m: f32, by_phases: bool) -> Finding {
        let tolerance_m = same_place_m(moved_m);
        let at = |way: f32| share(&self.echoes, marks, tolerance_m, |_, _| way - moved_m);
        let votes = Votes::count(&self.echoes, marks, |a, b| Some(b.x_m - a.x_m + moved_m));
        let mut rival = at(votes.peak(2.0 * tolerance_m));
        for k in 1..=OTHER_TRAVELS {
            let way = k as f32 * OTHER_TRAVEL_STEP_M + tolerance_m;
            rival = math::max(rival, math::max(at(way), at(-way)));
        }
        let there = at(0.0);
        let weight: f32 = marks.iter().map(|m| m.weight).sum();
        let standing = moved_m.abs() <= STANDING_M && there >= STANDING_SHARE;
        if standing && there * weight >= MIN_MARGIN {
            return Finding::Agreed;
        }
        if there >= DRIVING_SHARE && by_phases {
            // Another travel, at which the ground's echoes may look more alike, would turn the phases otherwise.
            Finding::Agreed
        } else if there < DRIVING_SHARE || there < rival {
            Finding::Moved
        } else if (there - rival) * weight < MIN_MARGIN {
            Finding::Unconfirmed
        } else {
            Finding::Agreed
        }
    }

    /// Estimates a steady speed without motion input from this sweep's echoes `marks` and the sweep before,
    /// whose last rows are `since_s` seconds apart.
    fn steady_speed(&self, marks: &[SweepEcho], since_s: f32) -> SteadySpeed {
        let between = |a: &SweepEcho, b: &SweepEcho| (since_s + a.before_s - b.before_s) / since_s;
        let way = |a: &SweepEcho, b: &SweepEcho| {
            let share = between(a, b);
            (share > MIN_SHARE).then(|| (a.x_m - b.x_m) / share)
        };
        let still = share(&self.echoes, marks, SAME_PLACE_M, |_, _| 0.0);
        let votes = Votes::count(&self.echoes, marks, way);
        let most = votes.peak(0.0);
        let peak = share(&self.echoes, marks, SAME_PLACE_M, |a, b| {
            -most * between(a, b)
        });
        let fine = refine(&self.echoes, marks, most, between);
        if still >= STANDING_SHARE && fine.abs() <= STANDING_M && still >= peak {
            let weight: f32 = marks.iter().map(|m| m.weight).sum();
            let enough = still * weight >= MIN_MARGIN;
            return SteadySpeed {
                finding: if enough {
                    Finding::Agreed
                } else {
                    Finding::Unconfirmed
                },
                speed: None,
            };
        }
        SteadySpeed {
            finding: Finding::Moved,
            speed: (peak >= STEADY_SHARE).then_some(fine / since_s),
        }
    }
}

/// Result of the comparison of two sweeps without motion input: finding, and steady forward speed, m/s, if one
/// explains the echoes.
struct SteadySpeed {
    finding: Finding,
    speed: Option<f32>,
}

/// Returns the strongest echoes of a sweep for the comparison; `placed` moves them to where they lie at the
/// last row.
fn sweep_echoes(
    echoes: &[Echo],
    map: &PolarMap,
    ride: &MotionCompensation<'_>,
    placed: bool,
) -> SweepEchoes {
    let end_s = ride.end().time_s;
    let mark = |echo: &Echo| {
        let mut at = *echo;
        if placed {
            ride.compensate(&mut at, map);
        }
        SweepEcho {
            x_m: at.x_m,
            y_m: at.y_m,
            range_m: at.range_m,
            before_s: end_s - ride.at(row_of(echo, map)).time_s,
            weight: (echo.snr_db - FROM_DB).clamp(0.0, MAX_DB),
        }
    };
    echoes.iter().take(MAX_SWEEP_ECHOES).map(mark).collect()
}

/// Returns whether the heights of two echoes differ by no more than the tolerance for echoes of one scatterer.
fn same_height(a: &SweepEcho, b: &SweepEcho) -> bool {
    let reach = SAME_HEIGHT_M + SAME_HEIGHT_RAD * math::max(a.range_m, b.range_m);
    (a.y_m - b.y_m).abs() <= reach
}

/// Returns the weight of those echoes of this sweep (`new`) that lie `shift(a, b)` metres forward of an echo of the
/// sweep before (`old`) at their height, within `tolerance_m`, as a share (0 to 1) of the weight of all of `new`; `a`
/// is the old echo, `b` the new one.
fn share(
    old: &[SweepEcho],
    new: &[SweepEcho],
    tolerance_m: f32,
    shift: impl Fn(&SweepEcho, &SweepEcho) -> f32,
) -> f32 {
    let (mut found, mut all) = (0.0, 0.0);
    for b in new {
        all += b.weight;
        let meets = |a: &&SweepEcho| {
            same_height(a, b) && (b.x_m - a.x_m - shift(a, b)).abs() <= tolerance_m
        };
        if old.iter().any(|a| meets(&a)) {
            found += b.weight;
        }
    }
    found / math::max(all, 1.0)
}

/// Refines `most`, an estimate of the chair's forward travel from the sweep before (`old`) to this one (`new`), metres:
/// weighted least squares over all pairs of echoes that agree with it. `between` returns the share of the travel that
/// lies between the observations of a pair.
fn refine(
    old: &[SweepEcho],
    new: &[SweepEcho],
    most: f32,
    between: impl Fn(&SweepEcho, &SweepEcho) -> f32,
) -> f32 {
    let (mut sum, mut squares) = (0.0, 0.0);
    for b in new {
        for a in old.iter().filter(|a| same_height(a, b)) {
            let share = between(a, b);
            let way = a.x_m - b.x_m;
            if (way - most * share).abs() <= SAME_PLACE_M {
                let weight = math::min(a.weight, b.weight);
                sum += weight * share * way;
                squares += weight * share * share;
            }
        }
    }
    if squares > 0.0 { sum / squares } else { most }
}

/// Histogram of the horizontal distances between echoes of two sweeps, or of the travels that these imply: entry k is
/// the weight of the pairs with about (k - [`BINS`]) · [`BIN_M`] metres.
struct Votes([f32; 2 * BINS + 1]);

impl Votes {
    fn count(
        old: &[SweepEcho],
        new: &[SweepEcho],
        way: impl Fn(&SweepEcho, &SweepEcho) -> Option<f32>,
    ) -> Self {
        let mut votes = Self([0.0; 2 * BINS + 1]);
        for b in new {
            for a in old.iter().filter(|a| same_height(a, b)) {
                if let Some(way) = way(a, b) {
                    let weight = math::min(a.weight, b.weight);
                    let bin = math::round(way / BIN_M) + BINS as f32;
                    // Half the weight to each neighbour, so that a distance between two bins is not at a
                    // disadvantage.
                    for (near, share) in [(-1.0, 0.5), (0.0, 1.0), (1.0, 0.5)] {
                        let bin = bin + near;
                        if bin >= 0.0
                            && let Some(votes) = votes.0.get_mut(bin as usize)
                        {
                            *votes += share * weight;
                        }
                    }
                }
            }
        }
        votes
    }

    /// Returns the distance (or travel) that the histogram's fullest bin stands for, metres, among those at least
    /// `beyond_m` from zero; 0 if all are empty.
    fn peak(&self, beyond_m: f32) -> f32 {
        let mut best = (0.0, 0.0);
        for (k, &votes) in self.0.iter().enumerate() {
            let way = (k as f32 - BINS as f32) * BIN_M;
            if votes > best.0 && way.abs() >= beyond_m {
                best = (votes, way);
            }
        }
        best.1
    }
}
