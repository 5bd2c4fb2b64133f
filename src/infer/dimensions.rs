//! Dimensions of a flight's steps: what each step's own echoes say, weighed against the regularity
//! of the flight.

use super::gauss::{self, Fusion, TreadLevels};
use super::nosings;
use super::propose::ascending::{self, Ascending};
use super::propose::descending::{self, Descending};
use super::propose::roles::{Role, Roles};
use super::propose::stairs::{ChainLink, Flight, MAX_FLIGHT, Stairs, regular};
use super::readings::Readings;
use super::refine::refine;
use super::support::{Support, next_db};
use crate::answer::{Answer, Direction, Step};
use crate::estimate::Estimate;
use crate::math;
use crate::model::{Model, Staircase};
use crate::params::Params;
use heapless::Vec;

/// The steps of a flight, what each rests on, and what each echo was taken for.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The steps; none if the flight turns out to be something that is no stair.
    pub answer: Answer,
    /// Whether what turned out to be no stair may be a step as well.
    pub may_be: bool,
    /// One for each step.
    pub supports: Vec<Support, MAX_FLIGHT>,
    /// In the order of the scene's marks.
    pub roles: Roles,
}

impl Measured {
    // Out of line: inlined, a second answer would lie on the stack.
    #[inline(never)]
    fn new(direction: Direction, roles: Roles) -> Self {
        Self {
            answer: Answer {
                direction,
                ..Answer::NONE
            },
            may_be: false,
            supports: Vec::new(),
            roles,
        }
    }

    fn push(&mut self, mut step: Step, support: Support, p: &Params) {
        step.quality = support.quality(p);
        // A flight is no longer than a report.
        let _ = self.answer.steps.push(step);
        let _ = self.supports.push(support);
    }
}

/// The steps of an ascending flight that stands as `staircase` has it, and whose riser height is `rise` by the
/// likelihood of all echoes; `bias_sigma_rad` is the shaft's angle error that calibration leaves.
#[inline(never)]
pub fn ascending(
    stairs: &Ascending<'_>,
    flight: &Flight<ascending::AscentShape>,
    rise: Estimate,
    (model, mut staircase): (&Model<'_>, Staircase),
    bias_sigma_rad: f32,
) -> Measured {
    let scene = stairs.scene();
    let p = scene.params;
    let roles = ascending::roles_by(scene, flight, &gauss::straight(rise));
    let overall = Estimate {
        value: rise.value,
        variance: 2.0 * rise.variance + p.flight_rise_sigma_m * p.flight_rise_sigma_m,
    };
    let (mut levels, mut readings) = (TreadLevels::default(), Readings::default());
    refine(
        model,
        &mut staircase,
        overall,
        p,
        (&mut levels, &mut readings),
    );
    let mut measured = Measured::new(Direction::Up, roles);
    if let Some(may_be) = no_stair(&readings, rise, &levels, p) {
        measured.answer.direction = Direction::None;
        measured.may_be = may_be;
        return measured;
    }
    let overhang_known = readings.faces.iter().any(|f| f.overhang_seen());
    let mut nosings = nosings::locate(scene, flight, &levels);
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
    let faces = faces.zip(&levels).zip(nosings.iter().zip(&landings));
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
            flashes: face.flash_db.is_some() && face.flash_db >= snr_db,
            overhang_seen: face.overhang_seen(),
            overhang_known,
            off: level.off,
            off_along_m: x.value - along,
        };
        measured.push(step, support, p);
    }
    measured
}

/// How much farther each riser stands than it would without a landing, metres.
fn landings(chain: &[ChainLink], most_going_m: f32) -> Vec<f32, MAX_FLIGHT> {
    let (going_m, _) = regular(chain, most_going_m);
    let mut landings = Vec::new();
    let (mut landing_m, mut before): (f32, Option<&ChainLink>) = (0.0, None);
    for link in chain {
        let away_m = before.map_or(0.0, |before| link.along_m - before.along_m);
        if away_m > most_going_m {
            landing_m += away_m - going_m;
        }
        // A flight is no longer than a report.
        let _ = landings.push(landing_m);
        before = Some(link);
    }
    landings
}

/// Whether a single riser that is too high or too low for a step, an obstacle or a threshold, may be one as well;
/// `None` for a step.
fn no_stair(readings: &Readings, rise: Estimate, levels: &TreadLevels, p: &Params) -> Option<bool> {
    let ([_], [first, ..]) = (readings.faces.as_slice(), levels.as_slice()) else {
        return None;
    };
    let height = first.height;
    let climbable = (p.lowest_step_m..=p.highest_step_m).contains(&height.value);
    if climbable && rise.value >= p.lowest_step_m {
        return None;
    }
    // What shows no top may be a threshold as well as a kerb.
    let reach = 2.0 * p.height_sigma_scale * height.sigma();
    Some(height.value + reach > p.lowest_step_m && height.value - reach < p.highest_step_m)
}

/// The steps of a descending flight.
#[inline(never)]
pub fn descending(stairs: &Descending<'_>, flight: &Flight<descending::DescentShape>) -> Measured {
    let scene = stairs.scene();
    let p = scene.params;
    let edges = stairs.edges(flight);
    let mut roles = Roles::new();
    for m in &scene.marks {
        // As many as there are marks.
        let _ = roles.push(stairs.role(m, &flight.chain, flight.shape));
    }
    let mut measured = Measured::new(Direction::Down, roles);
    let levels = lower_levels(stairs, flight, edges.shape());
    for (k, (link, level)) in flight.chain.iter().zip(&levels).enumerate() {
        let edge = edges.at(k);
        let step = Step {
            distance_m: edge.value,
            height_m: level.height.value,
            distance_sigma_m: edge.sigma(),
            height_sigma_m: level.height.sigma().max(p.least_height_sigma_m),
            ..Step::default()
        };
        let near = scene.between(link.along_m - p.row_m, link.along_m + p.row_m);
        let marks = if link.column.is_some() { near } else { &[] };
        let support = Support {
            snr_db: marks.iter().map(|m| m.snr_db).reduce(math::max),
            next_db: next_db(marks.iter().map(|m| (m, descending::is_flash(m, p))), p),
            flashes: false,
            overhang_seen: false,
            overhang_known: false,
            off: level.off,
            off_along_m: 0.0,
        };
        measured.push(step, support, p);
    }
    measured
}

/// Levels of the treads of a descending flight.
fn lower_levels(
    stairs: &Descending<'_>,
    flight: &Flight<descending::DescentShape>,
    shape: descending::DescentShape,
) -> TreadLevels {
    let p = stairs.scene().params;
    let count = flight.chain.len();
    let mut steps = [Fusion::default(); MAX_FLIGHT];
    for (k, fusion) in (1..=count).zip(&mut steps) {
        let tread = stairs.tread_of(&flight.chain, shape, k);
        let (mut weight, mut sum) = (0.0, 0.0);
        for m in stairs.level_marks(&tread) {
            let w = m.weight / (m.y_sigma_m * m.y_sigma_m);
            weight += w;
            sum += w * m.y_m;
        }
        if weight > 0.0 {
            let sigma_m = math::max(math::sqrt(1.0 / weight), p.least_height_sigma_m);
            fusion.add(Estimate::new(sum / weight, sigma_m));
        }
    }
    let last = flight.chain.last();
    let deepest = last.map_or(0.0, |l| l.along_m - stairs.scene().mount_height_m);
    let rise = Estimate::new(-deepest / count.max(1) as f32, p.lower_rise_sigma_m);
    let steps = steps.into_iter().take(count);
    let mut levels = TreadLevels::default();
    gauss::fit(steps, rise, p, &mut levels);
    levels
}

/// Least-squares line through the values that are there, over their index: start and slope.
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
    // A whole number: 0 for fewer than two values.
    let det: f32 = n * skk - sk * sk;
    if det < 0.5 {
        return (if n > 0.0 { sv / n } else { 0.0 }, 0.0);
    }
    let slope = (n * skv - sk * sv) / det;
    ((sv - slope * sk) / n, slope)
}
