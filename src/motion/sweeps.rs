//! Two sweeps over the same scene compared: whether the chair stands, or moves as its controller says.
//!
//! The strongest echoes of the sweep before are kept. Where the motion is known, both sweeps' echoes
//! are put to the places where the chair ended, and the way between is taken off: what is fixed to the
//! building must then lie in the same places. Where it is not known, each pair of echoes of the same
//! height that a straight drive can have made votes for a speed. Echoes of the floor look alike
//! everywhere and change with every centimetre: strong echoes weigh more.

use super::odometer::{SAME_PLACE_M, same_place_m};
use crate::config::{Config, Plane};
use crate::drive::{Drive, Input, Mode, Retention};
use crate::math;
use crate::signal::echoes::{Echo, Ride, row_of};
use crate::signal::grid::PolarMap;
use heapless::Vec;

/// So many of a sweep's strongest echoes are compared.
const MARKS: usize = 24;

/// What is kept of an echo.
#[derive(Clone, Copy, Debug)]
struct SweepEcho {
    x_m: f32,
    y_m: f32,
    range_m: f32,
    /// When it was seen, before the sweep's last row, seconds.
    before_s: f32,
    weight: f32,
}

type Marks = Vec<SweepEcho, MARKS>;

/// What two sweeps say of the chair's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Whether they agree.
    pub finding: Finding,
    /// State of the motion input.
    pub input: Input,
}

/// Whether two sweeps agree on the chair's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finding {
    /// The chair is known or seen to stand, or the sweeps agree.
    Agreed,
    /// There is no sweep to compare with, or too little in it.
    Alone,
    /// The sweeps do not agree.
    Moved,
    /// Motion input is required, and there is none.
    Missing,
}

impl Agreement {
    /// That of a chair which is known to stand.
    pub const STANDING: Self = Self {
        finding: Finding::Agreed,
        input: Input::Absent,
    };

    /// Where no sweeps are compared: only a chair that is known to stand agrees.
    pub fn untested(mode: Mode) -> Self {
        match mode {
            Mode::Standing => Self::STANDING,
            _ => Self {
                finding: Finding::Alone,
                ..Self::STANDING
            },
        }
    }

    /// The way from the sweep before to this one, metres, where it is known: by the motion input, or
    /// because both agree from the same place.
    pub fn moved_m(&self, drive: &Drive<'_>) -> Option<f32> {
        match (self.finding, self.input) {
            (Finding::Missing, _) => None,
            (_, Input::Good) => drive.moved_m,
            (Finding::Agreed, _) => Some(0.0),
            _ => None,
        }
    }

    /// The same where the steps agree with the motion input, though most of the echoes are of the floor,
    /// which looks alike everywhere.
    pub fn confirmed(self, by_steps: bool) -> Self {
        let open = matches!(self.finding, Finding::Alone | Finding::Moved);
        let finding = match open && by_steps && self.input == Input::Good {
            true => Finding::Agreed,
            false => self.finding,
        };
        Self { finding, ..self }
    }

    /// Whether the echoes are where they are taken to be.
    pub fn placed(&self) -> bool {
        matches!(self.finding, Finding::Agreed | Finding::Alone)
    }
}

/// The sweep before.
#[derive(Debug)]
pub struct Sweeps {
    marks: Marks,
    plane: Plane,
    /// Whether its echoes were put where they lie from the mirror at its last row.
    placed: bool,
}

/// Weights: an echo counts from this power above the noise …
const FROM_DB: f32 = 8.0;
/// … and no more beyond so many decibels on top of it.
const MOST_DB: f32 = 25.0;

/// Two echoes are of one height within this, metres …
const SAME_HEIGHT_M: f32 = 0.012;
/// … and this much for each metre of range, radians: a step of the sweep and what the lobe moves. Along the
/// floor: [`SAME_PLACE_M`].
const SAME_HEIGHT_RAD: f32 = 0.008;

/// Places apart that are looked at: bins of this width, metres …
const BIN_M: f32 = 0.01;
/// … to each side of none.
const BINS: usize = 60;

/// Share of the weight that agrees in two sweeps from one place: of 60 simulated pairs from standing
/// chairs all but those without echoes have 0.82 and more, of 70 from moving ones none more than 0.65.
const STANDING_SHARE: f32 = 0.75;
/// A chair that went no farther than this from sweep to sweep stands, metres: a sixth of what an `ok`
/// promises.
const STANDING_M: f32 = 0.005;
/// Share of the weight that agrees where the way between the sweeps is known: 0.34 and more in the
/// same recordings.
const DRIVING_SHARE: f32 = 0.33;
/// By how much weight they must agree better than for any other way: two echoes of 17 dB. With it none
/// of 200 pairs was taken to agree whose travel was reversed or frozen.
const LEAST_LEAD: f32 = 18.0;
/// Other ways that are tried: so many to each side …
const RIVALS: usize = 12;
/// … this far apart, metres.
const RIVAL_M: f32 = 0.05;
/// Share from which a steady creep is believed.
const CREEP_SHARE: f32 = 0.5;
/// Less time between two looks than this share of a sweep says nothing of the speed.
const LEAST_SHARE: f32 = 0.25;

impl Default for Sweeps {
    fn default() -> Self {
        Self::new()
    }
}

impl Sweeps {
    /// Before the first sweep.
    pub const fn new() -> Self {
        Self {
            marks: Marks::new(),
            plane: Plane::Depth,
            placed: false,
        }
    }

    /// Puts the echoes where they lie from the mirror at the last row, as far as the motion is known
    /// or can be seen, and compares them with those of the sweep before. A sweep of the other plane that comes in between
    /// is compared with none, does not become the one before, and is never confirmed: its first edge lies farther ahead
    /// than the model of treads seen from above looks for one.
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
        // Where the chair is known to stand and no sweep is compared with.
        let by_itself = if aside {
            Finding::Alone
        } else {
            Finding::Agreed
        };
        let Some(track) = drive.track.filter(|_| drive.mode != Mode::Standing) else {
            self.marks.clear();
            return Agreement {
                finding: by_itself,
                input: Input::Absent,
            };
        };
        let known = input == Input::Good;
        let mut ride = Ride::along(track, drive, &config.radar);
        let marks = marks(echoes, map, &ride, known);
        let plane = map.geometry().plane;
        let same = self.plane == plane && self.placed == known;
        let comparable = !self.marks.is_empty() && same && !aside;
        let finding = match (comparable, known, drive.moved_m, drive.since_s) {
            (true, true, Some(moved_m), _) => self.driven(&marks, moved_m),
            (true, false, _, Some(since_s)) => {
                let creep = self.creep(&marks, since_s);
                ride.creep = creep.speed;
                creep.finding
            }
            _ if drive.stood && !comparable => by_itself,
            _ => Finding::Alone,
        };
        if known || ride.creep.is_some() {
            echoes.iter_mut().for_each(|echo| ride.place(echo, map));
        }
        if !aside {
            self.marks = marks;
            self.plane = plane;
            self.placed = known;
        }
        let missing = drive.mode == Mode::Required && !known;
        let finding = if missing { Finding::Missing } else { finding };
        Agreement { finding, input }
    }

    /// Whether this sweep agrees with the one before `moved_m` metres back: better than it does with
    /// any other way, and by more than a few weak echoes can make.
    fn driven(&self, marks: &[SweepEcho], moved_m: f32) -> Finding {
        let tolerance_m = same_place_m(moved_m);
        let at = |way: f32| share(&self.marks, marks, tolerance_m, |_, _| way - moved_m);
        let votes = Votes::count(&self.marks, marks, |a, b| Some(b.x_m - a.x_m + moved_m));
        let mut rival = at(votes.peak(2.0 * tolerance_m));
        for k in 1..=RIVALS {
            let way = k as f32 * RIVAL_M + tolerance_m;
            rival = math::max(rival, math::max(at(way), at(-way)));
        }
        let there = at(0.0);
        let weight: f32 = marks.iter().map(|m| m.weight).sum();
        let standing = moved_m.abs() <= STANDING_M && there >= STANDING_SHARE;
        if standing && there * weight >= LEAST_LEAD {
            return Finding::Agreed;
        }
        if there < DRIVING_SHARE || there < rival {
            Finding::Moved
        } else if (there - rival) * weight < LEAST_LEAD {
            Finding::Alone
        } else {
            Finding::Agreed
        }
    }

    /// How fast the chair went, if it went steadily, with `since_s` seconds between the sweeps' ends.
    fn creep(&self, marks: &[SweepEcho], since_s: f32) -> Creep {
        let between = |a: &SweepEcho, b: &SweepEcho| (since_s + a.before_s - b.before_s) / since_s;
        let way = |a: &SweepEcho, b: &SweepEcho| {
            let share = between(a, b);
            (share > LEAST_SHARE).then(|| (a.x_m - b.x_m) / share)
        };
        let still = share(&self.marks, marks, SAME_PLACE_M, |_, _| 0.0);
        let votes = Votes::count(&self.marks, marks, way);
        let most = votes.peak(0.0);
        let peak = share(&self.marks, marks, SAME_PLACE_M, |a, b| {
            -most * between(a, b)
        });
        let fine = refine(&self.marks, marks, most, between);
        if still >= STANDING_SHARE && fine.abs() <= STANDING_M && still >= peak {
            let weight: f32 = marks.iter().map(|m| m.weight).sum();
            let enough = still * weight >= LEAST_LEAD;
            return Creep {
                finding: if enough {
                    Finding::Agreed
                } else {
                    Finding::Alone
                },
                speed: None,
            };
        }
        Creep {
            finding: Finding::Moved,
            speed: (peak >= CREEP_SHARE).then_some(fine / since_s),
        }
    }
}

/// What two sweeps without motion input say.
struct Creep {
    finding: Finding,
    speed: Option<f32>,
}

/// The strongest echoes, as they are kept.
fn marks(echoes: &[Echo], map: &PolarMap, ride: &Ride<'_>, placed: bool) -> Marks {
    let end_s = ride.end().time_s;
    let mark = |echo: &Echo| {
        let mut at = *echo;
        if placed {
            ride.place(&mut at, map);
        }
        SweepEcho {
            x_m: at.x_m,
            y_m: at.y_m,
            range_m: at.range_m,
            before_s: end_s - ride.at(row_of(echo, map)).time_s,
            weight: (echo.snr_db - FROM_DB).clamp(0.0, MOST_DB),
        }
    };
    echoes.iter().take(MARKS).map(mark).collect()
}

/// Whether two marks may be of one height.
fn level(a: &SweepEcho, b: &SweepEcho) -> bool {
    let reach = SAME_HEIGHT_M + SAME_HEIGHT_RAD * math::max(a.range_m, b.range_m);
    (a.y_m - b.y_m).abs() <= reach
}

/// Share of the weight of `new` that finds a mark of `old` at its height, and `shift` away forward
/// within `tolerance_m`.
fn share(
    old: &[SweepEcho],
    new: &[SweepEcho],
    tolerance_m: f32,
    shift: impl Fn(&SweepEcho, &SweepEcho) -> f32,
) -> f32 {
    let (mut found, mut all) = (0.0, 0.0);
    for b in new {
        all += b.weight;
        let meets =
            |a: &&SweepEcho| level(a, b) && (b.x_m - a.x_m - shift(a, b)).abs() <= tolerance_m;
        if old.iter().any(|a| meets(&a)) {
            found += b.weight;
        }
    }
    found / math::max(all, 1.0)
}

/// The way from sweep to sweep, `most` roughly, from all pairs that agree with it: least squares over
/// their ways, each of a share of the time.
fn refine(
    old: &[SweepEcho],
    new: &[SweepEcho],
    most: f32,
    between: impl Fn(&SweepEcho, &SweepEcho) -> f32,
) -> f32 {
    let (mut sum, mut squares) = (0.0, 0.0);
    for b in new {
        for a in old.iter().filter(|a| level(a, b)) {
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

/// Weights of the pairs, by how far they lie apart.
struct Votes([f32; 2 * BINS + 1]);

impl Votes {
    fn count(
        old: &[SweepEcho],
        new: &[SweepEcho],
        way: impl Fn(&SweepEcho, &SweepEcho) -> Option<f32>,
    ) -> Self {
        let mut votes = Self([0.0; 2 * BINS + 1]);
        for b in new {
            for a in old.iter().filter(|a| level(a, b)) {
                if let Some(way) = way(a, b) {
                    let weight = math::min(a.weight, b.weight);
                    let bin = math::round(way / BIN_M) + BINS as f32;
                    // Half to each side, so that a place between two bins counts as much.
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

    /// The way that most weight is for, farther than `beyond_m` from none.
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
