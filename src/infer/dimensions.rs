//! Dimensions of a flight's steps: measurements from each step's own echoes, combined with the regularity of the
//! flight.

use super::gauss::{self, Fusion, TreadLevels};
use super::nosings;
use super::propose::ascending::{self, Ascending};
use super::propose::roles::Roles;
use super::propose::scene::{Mark, Scene};
use super::propose::search::Search;
use super::propose::stairs::{Flight, MAX_FLIGHT, regular};
use super::readings::Readings;
use super::refine::{Refinement, refine};
use super::support::{Support, next_db};
use crate::answer::{Answer, Direction, Step};
use crate::estimate::Estimate;
use crate::math;
use crate::model::treads::{Descending, TreadAt, Treads};
use crate::model::{GroundKind, Model, Staircase, tread_begins_m};
use crate::observer::trace::{ChainLink, Role};
use crate::params::Params;
use crate::params::descent::TREAD_OFF_M;
use crate::params::posterior::{Limits, PLUMB_FLASH_M, TREAD_END_M};
use heapless::Vec;

/// The steps of a flight, the evidence for each, and the role of each echo.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The steps; none if the flight turns out not to be stairs.
    pub answer: Answer,
    /// Whether a single riser that was found too high or too low for a step may be a step within its uncertainty.
    pub may_be_step: bool,
    /// Evidence for each step, in the order of the answer's steps.
    pub supports: Vec<Support, MAX_FLIGHT>,
    /// Role of each mark (an echo in the search), in the order of the scene's marks.
    pub roles: Roles,
}

impl Measured {
    // Not inlined, since a second answer would lie on the stack.
    #[inline(never)]
    fn new(direction: Direction, roles: Roles) -> Self {
        Self {
            answer: Answer {
                direction,
                ..Answer::NONE
            },
            may_be_step: false,
            supports: Vec::new(),
            roles,
        }
    }

    fn push(&mut self, mut step: Step, support: Support, p: &Params) {
        step.quality = support.quality(p);
        // Cannot fail: a flight is no longer than a report.
        let _ = self.answer.steps.push(step);
        let _ = self.supports.push(support);
    }
}

/// A flight with the score of its likeliest riser height.
#[derive(Clone, Debug)]
pub struct RisenFlight {
    /// The flight.
    pub flight: Flight,
    /// Its riser height, averaged over the likelihood of all echoes, metres.
    pub rise: Estimate,
}

impl RisenFlight {
    /// Returns a flight with its riser height.
    pub fn of(search: &Search<'_, '_>, mut flight: Flight) -> Self {
        let (rise, score) = search.stairs.rise(&flight);
        flight.score = score;
        Self { flight, rise }
    }
}

/// Measures the steps of an ascending flight. `staircase` is the accepted hypothesis, and `bias_sigma_rad` the standard
/// deviation of the shaft's angle error that remains after calibration.
#[inline(never)]
pub fn ascending(
    stairs: &Ascending<'_>,
    risen: &RisenFlight,
    model: &Model<'_>,
    mut staircase: Staircase,
    bias_sigma_rad: f32,
) -> Measured {
    let RisenFlight { flight, rise } = risen;
    let rise = *rise;
    let scene = stairs.scene();
    let p = scene.params;
    let roles = ascending::roles_by(scene, flight, &gauss::straight(rise));
    let overall = Estimate {
        value: rise.value,
        variance: 2.0 * rise.variance + p.flight_rise_sigma_m * p.flight_rise_sigma_m,
    };
    let mut refined = Refinement::default();
    refine(model, &mut staircase, overall, p, &mut refined);
    let Refinement { levels, readings } = &refined;
    let mut measured = Measured::new(Direction::Up, roles);
    if let Some(may_be) = is_obstacle_or_threshold(readings, rise, levels, p) {
        measured.answer.direction = Direction::None;
        measured.may_be_step = may_be;
        return measured;
    }
    let overhang_known = readings.faces.iter().any(|f| f.overhang_seen());
    let mut nosings = nosings::locate(scene, flight, levels);
    if !p.rules.nosing_lines {
        for (nosing, face) in nosings.iter_mut().zip(&readings.faces) {
            let shown_m = face.foot_m.or(face.edge_m);
            *nosing = shown_m.map(|x| Estimate::new(x, p.inferred_x_sigma_m));
        }
    }
    let landings = landings(&flight.chain, p.most_going_m);
    let regular = nosings.iter().zip(&landings);
    let line = fit_line(regular.map(|(x, landing)| x.map(|x| x.value - landing)));
    let faces = readings.faces.iter().zip(&flight.chain);
    let faces = faces.zip(levels).zip(nosings.iter().zip(&landings));
    for (k, (((face, link), level), (nosing, landing))) in faces.enumerate() {
        let along = line.0 + line.1 * k as f32 + landing;
        let x = nosing.unwrap_or(Estimate::new(along, p.inferred_x_sigma_m));
        let bias_m = x.value * bias_sigma_rad;
        let model = p.height_sigma_scale * p.height_sigma_scale * level.height.variance;
        let step = Step {
            distance_m: x.value,
            height_m: level.height.value,
            distance_sigma_m: x.sigma(),
            height_sigma_m: math::sqrt(model + bias_m * bias_m).max(p.least_height_sigma_m),
            ..Step::default()
        };
        let (first, end) = scene.near_range(link.along_m);
        let near = scene.marks.get(first..end).unwrap_or(&[]);
        let snr_db = near.iter().map(|m| m.snr_db).reduce(math::max);
        let marks = near
            .iter()
            .zip(measured.roles.get(first..end).unwrap_or(&[]));
        let support = Support {
            snr_db,
            next_db: next_db(marks.map(|(m, role)| (m, *role == Role::Flash)), p),
            overhang_seen: face.overhang_seen(),
            overhang_known,
            off: level.off,
            off_along_m: x.value - along,
        };
        measured.push(step, support, p);
    }
    measured
}

/// Returns, for each riser, by how much the landings before it make it farther away than equal goings would, metres.
fn landings(chain: &[ChainLink], most_going_m: f32) -> Vec<f32, MAX_FLIGHT> {
    let (going_m, _) = regular(chain, most_going_m);
    let mut landings = Vec::new();
    let (mut landing_m, mut before): (f32, Option<&ChainLink>) = (0.0, None);
    for link in chain {
        let away_m = before.map_or(0.0, |before| link.along_m - before.along_m);
        if away_m > most_going_m {
            landing_m += away_m - going_m;
        }
        // Cannot fail: a flight is no longer than a report.
        let _ = landings.push(landing_m);
        before = Some(link);
    }
    landings
}

/// Returns `None` for a flight or a single step. For a single riser too high or too low for a step (an obstacle or a
/// threshold), returns whether it may be a step within its uncertainty.
fn is_obstacle_or_threshold(
    readings: &Readings,
    rise: Estimate,
    levels: &TreadLevels,
    p: &Params,
) -> Option<bool> {
    let ([_], [first, ..]) = (readings.faces.as_slice(), levels.as_slice()) else {
        return None;
    };
    let height = first.height;
    if GroundKind::single(height.value, p).direction() == Direction::Up
        && rise.value >= p.lowest_step_m
    {
        return None;
    }
    // A riser without an echo of its top may be a threshold or a kerb.
    let reach = 2.0 * p.height_sigma_scale * height.sigma();
    Some(height.value + reach > p.lowest_step_m && height.value - reach < p.highest_step_m)
}

/// A tread seen from above: its height, negative below the ground, and the horizontal distances of both ends, metres.
#[derive(Clone, Copy, Debug)]
struct SeenTread {
    tread: TreadAt,
    from_m: f32,
    to_m: f32,
}

impl SeenTread {
    /// Returns tread number `k` of stairs going down; number 0 is the ground before them.
    fn of(s: &Staircase, k: usize, model: &Descending) -> Self {
        let y_m = s.level(k);
        let from_m = match k.checked_sub(1) {
            None => f32::NEG_INFINITY,
            Some(before) => {
                let deeper = model.depth_m(y_m) / model.depth_m(s.level(before));
                tread_begins_m(s.x(before), deeper)
            }
        };
        Self {
            tread: model.tread(y_m),
            from_m,
            to_m: s.x(k),
        }
    }

    /// Returns the role of a mark, if it lies on the tread.
    fn role(&self, m: &Mark) -> Option<Role> {
        let inside = m.x_m > self.from_m - TREAD_END_M && m.x_m < self.to_m + TREAD_END_M;
        if !inside || (m.y_m - self.tread.y_m).abs() > TREAD_OFF_M {
            return None;
        }
        Some(if m.x_m.abs() < PLUMB_FLASH_M {
            Role::Flash
        } else if (m.x_m - self.to_m).abs() < TREAD_END_M {
            Role::Edge
        } else if (m.x_m - self.from_m).abs() < TREAD_END_M {
            Role::Corner
        } else {
            Role::Tread
        })
    }
}

/// The treads of stairs going down, the ground first.
type SeenTreads = Vec<SeenTread, { MAX_FLIGHT + 1 }>;

/// Returns the ground and the treads of stairs going down, from the top down; on level ground the ground alone.
fn seen_treads(s: &Staircase, model: &Descending) -> SeenTreads {
    let mut treads = SeenTreads::new();
    for k in 0..=s.len() {
        // Cannot fail: a staircase has no more treads.
        let _ = treads.push(SeenTread::of(s, k, model));
    }
    treads
}

/// Returns the role of each mark on level ground, seen from above, in the order of the scene's marks.
#[inline(never)]
pub fn ground_roles(scene: &Scene<'_>, model: &Descending) -> Roles {
    lower_roles(scene, &seen_treads(&Staircase::nothing(), model))
}

/// Returns the role of each mark on the first of `treads` on which it lies, in the marks' order; [`Role::Stray`] for
/// marks on none.
fn lower_roles(scene: &Scene<'_>, treads: &SeenTreads) -> Roles {
    let mut roles = Roles::new();
    for m in &scene.marks {
        let role = treads.iter().find_map(|tread| tread.role(m));
        // Cannot fail: there is one role for each mark.
        let _ = roles.push(role.unwrap_or(Role::Stray));
    }
    roles
}

/// Measures the steps of the stairs going down `s`.
#[inline(never)]
pub fn descending(model: &mut Descending, scene: &Scene<'_>, s: &Staircase) -> Measured {
    let p = scene.params;
    let count = s.len();
    let seen = seen_treads(s, model);
    let mut treads = Treads::new();
    for below in seen.iter().skip(1) {
        // Cannot fail: stairs going down have no more treads.
        let _ = treads.push(below.tread);
    }
    model.evaluate(&treads);
    let mut measured = Measured::new(Direction::Down, lower_roles(scene, &seen));
    let mut levels = TreadLevels::default();
    let rise = Estimate::new(s.rise(), p.flight_rise_sigma_m);
    let steps = seen.iter().skip(1).map(|below| {
        let mut fusion = Fusion::default();
        if let Some(level) = model.level(below.tread, Limits::new(below.from_m, below.to_m)) {
            fusion.add(Estimate {
                variance: math::max(
                    level.variance,
                    p.least_height_sigma_m * p.least_height_sigma_m,
                ),
                ..level
            });
        }
        fusion
    });
    gauss::fit(steps, rise, p, &mut levels);
    for (k, (level, below)) in levels.iter().zip(seen.iter().skip(1)).enumerate() {
        let edge = model.place(count, k);
        let step = Step {
            distance_m: edge.value,
            height_m: level.height.value,
            distance_sigma_m: edge.sigma(),
            height_sigma_m: level.height.sigma().max(p.least_height_sigma_m),
            ..Step::default()
        };
        let roles = scene.marks.iter().map(|m| (m, below.role(m)));
        let near = roles.filter_map(|(m, role)| Some((m, role? == Role::Flash)));
        let support = Support {
            snr_db: near.clone().map(|(m, _)| m.snr_db).reduce(math::max),
            next_db: next_db(near, p),
            overhang_seen: false,
            overhang_known: false,
            off: level.off,
            off_along_m: 0.0,
        };
        measured.push(step, support, p);
    }
    measured
}

/// Returns the least-squares line through the values that are `Some`, over their index: its value at index 0, and its
/// slope per index.
fn fit_line(values: impl Iterator<Item = Option<f32>>) -> (f32, f32) {
    let (mut n, mut sk, mut skk, mut sv, mut skv) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (k, value) in (0u8..).map(f32::from).zip(values) {
        if let Some(v) = value {
            n += 1.0;
            sk += k;
            skk += k * k;
            sv += v;
            skv += k * v;
        }
    }
    // An integer: 0 for fewer than two values.
    let det: f32 = n * skk - sk * sk;
    if det < 0.5 {
        return (if n > 0.0 { sv / n } else { 0.0 }, 0.0);
    }
    let slope = (n * skv - sk * sv) / det;
    ((sv - slope * sk) / n, slope)
}
