//! Dimensions of an ascending flight: what each riser's own echoes say, weighed against the
//! regularity of the flight.

use super::ascent::Shape;
use super::descent::{self, Descent};
use super::doubt::{self, Support};
use super::evidence::{Evidence, Mark};
use super::levels::{self, Fusion, Levels, Reading};
use super::search::Stairs;
use super::search::{Flight, MAX_FLIGHT};
use crate::math::{self, RAD_PER_DEG};
use crate::stairs::dimension::sort_key;
use crate::stairs::particles::shell_sort;
use crate::stairs::{Direction, Outcome, Reason, Step};
use heapless::Vec;

/// A single riser higher than this is a box, metres.
const TOO_HIGH: f32 = 0.23;
/// A single riser lower than this is a threshold, metres.
const TOO_LOW: f32 = 0.07;
/// The model is not the whole truth.
const SIGMA: f32 = 1.2;
/// An echo no wider than this is a single scatterer.
const CLEAN: f32 = 1.1;
/// A riser whose top is seen from below this slope shines over its whole height.
const SHINES: f32 = 0.14;
/// A lobe broader than this is not an edge but a face.
const FACE: f32 = 2.0;
/// An edge lies at most this far behind its riser, metres: as far as places are off.
const BEHIND: f32 = 0.02;
/// A corner this much stronger than a flash beside it is where it seems to be, dB.
const OUTSHONE_DB: f32 = 6.0;
/// Closer than this to a flash an echo is pulled towards it, radians.
const HIDE: f32 = 7.4 * RAD_PER_DEG;
/// Standard deviation of the distance of a riser that shows a corner or flashes, metres …
const CORNER_SIGMA: f32 = 0.003;
/// … of one that shows its edge alone …
const EDGE_SIGMA: f32 = 0.006;
/// … and of one that shows nothing.
const INFERRED_SIGMA: f32 = 0.015;
/// Nosings overhang by up to 4 cm: what is not known of it, metres.
const UNSURE_OVERHANG: f32 = 0.008;
/// Less than this is none, metres.
const LEAST_OVERHANG: f32 = 0.005;
/// No height is known better, metres.
const LEAST_SIGMA: f32 = 0.003;

/// Height of a step's top edge from an echo near it. What is seen lies lower: the riser or the
/// tread's front pulls the echo down by an amount that depends on what else shines there, the more
/// the straighter the riser looks at the mirror.
fn top_level(m: &Mark, place: &Place<'_>) -> Reading {
    let (open, flash, hidden) = (place.flight.shape.open, place.flashes(), place.hidden());
    let (low, sigma) = match (open, flash || hidden, place.shines(m), m.width < CLEAN) {
        (true, true, _, _) => (0.030, 0.016),
        (true, false, _, true) => (0.008, 0.012),
        (true, false, _, false) => (0.011, 0.014),
        (false, true, _, _) => (0.022, 0.020),
        (false, false, true, true) => (0.006, 0.012),
        (false, false, true, false) => (0.020, 0.018),
        (false, false, false, true) => (0.004, 0.006),
        (false, false, false, false) => (0.010, 0.012),
    };
    Reading {
        value: m.y + low,
        sigma: math::hypot(sigma, angle_error(m, 0.15, 0.5)),
    }
}

/// Height error of a mark from `fixed` degrees plus `noisy` degrees at 0 dB.
fn angle_error(m: &Mark, fixed: f32, noisy: f32) -> f32 {
    m.range * (fixed + noisy * amplitude(-m.db)) * RAD_PER_DEG
}

/// Amplitude ratio of `db` decibels.
pub fn amplitude(db: f32) -> f32 {
    math::exp2(db * (1.0 / 6.020_6))
}

fn strongest<'m>(marks: impl Iterator<Item = &'m Mark>) -> Option<&'m Mark> {
    marks.max_by(|a, b| a.db.total_cmp(&b.db))
}

/// What one step's own echoes say.
#[derive(Clone, Copy, Debug, Default)]
struct Face {
    /// Horizontal distance of the riser.
    x: Option<Reading>,
    /// How far the nosing stands before it.
    overhang: Option<f32>,
    /// Level of the tread.
    level: Fusion,
    /// Strongest echo, dB.
    db: Option<f32>,
    /// How strong a further face would be at least, dB.
    next_db: f32,
    /// Whether it looks straight at the mirror and flashes.
    flashes: bool,
}

/// What the echoes say about all steps.
#[derive(Clone, Debug, Default)]
struct Readings {
    faces: Vec<Face, MAX_FLIGHT>,
    /// Of the riser's height.
    slopes: Vec<Reading, { MAX_FLIGHT + 1 }>,
}

/// One riser with what is known of it when its echoes are read.
struct Place<'e> {
    flight: &'e Flight<Shape>,
    members: &'e [Mark],
    /// Mirror above the ground.
    height: f32,
    base: f32,
    top: f32,
    /// Standard deviation of the level at the top as known so far.
    top_sigma: f32,
}

impl Place<'_> {
    /// Whether the riser looks straight at the mirror.
    fn flashes(&self) -> bool {
        self.base - 0.02 < self.height && self.height < self.top + 0.03
    }

    /// Whether the nosing before hides the foot.
    fn hidden(&self) -> bool {
        self.base > self.height - 0.01
    }

    /// Whether a mark may show a level that is known to within `sigma`.
    fn near(m: &Mark, level: f32, sigma: f32) -> bool {
        (m.y - level).abs() < (2.5 * math::hypot(m.sigma, sigma)).max(0.03)
    }

    fn corner(&self) -> Option<&Mark> {
        let below = self.base + 0.6 * (self.top - self.base);
        let shows = !self.flight.shape.open && !self.hidden();
        let is = |m: &&Mark| shows && Self::near(m, self.base, 0.0) && m.y < below;
        strongest(self.members.iter().filter(is))
    }

    fn is_flash(&self, m: &Mark) -> bool {
        self.flashes() && (m.y - self.height).abs() < 0.012 + 0.5 * m.sigma
    }

    fn flash(&self) -> Option<&Mark> {
        strongest(self.members.iter().filter(|m| self.is_flash(m)))
    }

    /// The edge at the top, `x` being where the riser stands: treads overhang it, they do not fall
    /// short. A broad lobe on a riser that shines is its face.
    fn nosing(&self, x: f32) -> Option<&Mark> {
        let above = self.base + 0.4 * (self.top - self.base);
        // Floating treads show nothing below their edge that could be taken for it.
        let open = self.flight.shape.open;
        let unsure = if open { self.top_sigma } else { 0.0 };
        let face = |m: &Mark| !open && self.shines(m) && m.width > FACE;
        let is = |m: &&Mark| {
            Self::near(m, self.top, unsure)
                && m.y > above
                && m.x < x + BEHIND
                && !self.is_flash(m)
                && !face(m)
        };
        let tops = self.members.iter().filter(is);
        if self.hidden() {
            strongest(tops)
        } else {
            tops.max_by(|a, b| a.y.total_cmp(&b.y))
        }
    }

    /// Whether the riser looks so straight at the mirror that all of it shines.
    fn shines(&self, m: &Mark) -> bool {
        self.height - self.top < SHINES * m.x
    }
}

/// Reads every riser's echoes, given the levels as known so far (step k's is the top of riser k).
fn read(evidence: &Evidence, flight: &Flight<Shape>, levels: &Levels) -> Readings {
    let height = evidence.mount_height;
    let mut out = Readings::default();
    let mut before_x: Option<f32> = None;
    for ((k, link), [foot, edge]) in (0u8..).zip(&flight.chain).zip(levels.risers()) {
        let (base, top) = (foot.height, edge.height);
        let column = link
            .column
            .and_then(|c| evidence.columns.get(usize::from(c)));
        let members = column
            .and_then(|c| evidence.marks.get(c.first..c.end))
            .unwrap_or(&[]);
        let place = Place {
            flight,
            members,
            height,
            base,
            top,
            top_sigma: edge.sigma,
        };
        let mut face = Face::default();
        if let Some(all) = strongest(members.iter()) {
            let (corner, flash) = (place.corner(), place.flash());
            let known = strongest(corner.into_iter().chain(flash));
            let x = known.unwrap_or(all).x;
            let sigma = if known.is_some() {
                CORNER_SIGMA
            } else {
                EDGE_SIGMA
            };
            face.x = Some(Reading { value: x, sigma });
            face.db = Some(all.db);
            face.flashes = place.flashes() && (all.y - height).abs() < 0.01 + 2.0 * all.sigma;
            face.next_db = doubt::next_db(members, |m| place.is_flash(m));
            let outshone = |m: &Mark| flash.is_some_and(|f| f.db > m.db - OUTSHONE_DB);
            if let Some(m) = corner
                && !(outshone(m) && (height - base) / link.along < HIDE)
                && let Some(before) = out.faces.last_mut()
            {
                before.level.add(corner_level(m));
            }
            if let Some(m) = place.nosing(x)
                && (!place.hidden() || flight.shape.open)
            {
                let beside_flash = flash.is_some() && !flight.shape.open;
                if !(beside_flash && (m.y - height).abs() / link.along < 0.5 * HIDE) {
                    face.level.add(top_level(m, &place));
                }
                face.overhang = known.map(|_| x - m.x);
            }
            if let Some(before) = before_x
                && place.hidden()
                && !flight.shape.open
                && let Some(slope) = hidden_slope(&place, all.y, x / before, k.into())
            {
                let _ = out.slopes.push(slope);
            }
            before_x = Some(x);
        } else {
            before_x = None;
        }
        // As many as the flight has.
        let _ = out.faces.push(face);
    }
    out
}

/// Level of a tread from the corner at its end.
fn corner_level(m: &Mark) -> Reading {
    let (low, sigma) = if m.width < CLEAN {
        (0.0, 0.003)
    } else {
        (0.008, 0.013)
    };
    Reading {
        value: m.y - low,
        sigma: math::hypot(sigma, angle_error(m, 0.1, 0.3)),
    }
}

/// Height of the flight's risers from an echo at height `y` on riser `k`, whose foot the nosing
/// before hides: it lies somewhere on the visible part. `q` is the ratio of the two distances.
fn hidden_slope(place: &Place<'_>, y: f32, q: f32, k: f32) -> Option<Reading> {
    let height = place.height;
    let visible = height + (place.base - height) * q;
    let per_rise = 0.5 * q * k + 0.5 * (k + 1.0);
    (y > visible - 0.05).then(|| Reading {
        value: (y - 0.5 * height * (1.0 - q)) / per_rise,
        sigma: (0.015 + 0.35 * (place.top - visible).max(0.05)) / per_rise,
    })
}

/// The steps of a flight, and what each rests on.
pub struct Sized {
    /// The steps; none if the flight turns out to be something that is no stair.
    pub outcome: Outcome,
    /// One for each step.
    pub supports: Vec<Support, MAX_FLIGHT>,
}

/// The steps of an ascending flight whose riser height is `rise` by the likelihood of all echoes;
/// `bias_sigma` is the shaft's angle error that calibration leaves.
#[inline(never)]
pub fn ascending(
    evidence: &Evidence,
    flight: &Flight<Shape>,
    rise: Reading,
    bias_sigma: f32,
) -> Sized {
    let overall = Reading {
        value: rise.value,
        sigma: math::hypot(core::f32::consts::SQRT_2 * rise.sigma, 0.01),
    };
    let mut levels = Levels::straight(rise);
    let mut readings = Readings::default();
    // Which echo plays which role depends on the levels: the second reading knows those that the
    // first one found.
    for _ in 0..2 {
        readings = read(evidence, flight, &levels);
        let _ = readings.slopes.push(overall);
        let mut steps = Vec::<Fusion, MAX_FLIGHT>::new();
        for face in &readings.faces {
            let _ = steps.push(face.level);
        }
        levels = levels::fit(&steps, &readings.slopes);
    }
    if let ([_], Some(first)) = (flight.chain.as_slice(), levels.places.first()) {
        let climbable = TOO_LOW..=TOO_HIGH;
        if !climbable.contains(&first.height) || rise.value < TOO_LOW {
            let mut outcome = Outcome::clear();
            // What shows no top may be a threshold as well as a kerb.
            let reach = 2.0 * SIGMA * first.sigma;
            if first.height + reach > TOO_LOW && first.height - reach < TOO_HIGH {
                doubt::degrade(&mut outcome, Reason::CloseRival);
            }
            return Sized {
                outcome,
                supports: Vec::new(),
            };
        }
    }
    let overhang = overhang(&readings, flight.shape.open);
    let line = fit_line(readings.faces.iter().map(|f| f.x.map(|x| x.value)));
    let faces = (0u8..).zip(&readings.faces).zip(&levels.places);
    sized(
        Direction::Up,
        faces.map(|((k, face), place)| {
            let along = line.0 + line.1 * f32::from(k);
            let x = face.x.unwrap_or(Reading {
                value: along,
                sigma: INFERRED_SIGMA,
            });
            let step = Step {
                distance_m: x.value - overhang.value,
                height_m: place.height,
                distance_sigma_m: math::hypot(x.sigma, overhang.sigma),
                height_sigma_m: math::hypot(SIGMA * place.sigma, x.value * bias_sigma)
                    .max(LEAST_SIGMA),
                ..Step::default()
            };
            let support = Support {
                db: face.db,
                next_db: face.next_db,
                flashes: face.flashes,
                off: place.off,
                off_sigma: place.off_sigma,
                off_along: x.value - along,
            };
            (step, support)
        }),
    )
}

/// The steps of a descending flight.
#[inline(never)]
pub fn descending(descent: &Descent<'_>, flight: &Flight<descent::Shape>) -> Sized {
    let edges = descent.edges(flight);
    let levels = descent.levels(flight, &edges);
    let links = flight.chain.iter().enumerate().zip(&levels.places);
    sized(
        Direction::Down,
        links.map(|((k, link), place)| {
            let edge = edges.at(k);
            let step = Step {
                distance_m: edge.value,
                height_m: place.height,
                distance_sigma_m: edge.sigma,
                height_sigma_m: place.sigma.max(LEAST_SIGMA),
                ..Step::default()
            };
            let column = link
                .column
                .and_then(|c| descent.evidence().columns.get(usize::from(c)));
            let marks = column.and_then(|c| descent.evidence().marks.get(c.first..c.end));
            let marks = marks.unwrap_or(&[]);
            let support = Support {
                db: strongest(marks.iter()).map(|m| m.db),
                next_db: doubt::next_db(marks, descent::is_flash),
                flashes: false,
                off: place.off,
                off_sigma: place.off_sigma,
                off_along: 0.0,
            };
            (step, support)
        }),
    )
}

/// Puts the steps into an outcome.
fn sized(direction: Direction, faces: impl Iterator<Item = (Step, Support)>) -> Sized {
    let mut out = Sized {
        outcome: Outcome::clear(),
        supports: Vec::new(),
    };
    out.outcome.direction = direction;
    for (mut step, support) in faces {
        step.quality = support.quality();
        // A flight is no longer than a report.
        let _ = out.outcome.steps.push(step);
        let _ = out.supports.push(support);
    }
    out
}

/// How far the nosings stand before their risers, on the median: all alike on one staircase; not
/// known if no riser shows both.
fn overhang(readings: &Readings, open: bool) -> Reading {
    if open {
        return Reading::default();
    }
    let mut values = Vec::<f32, MAX_FLIGHT>::new();
    for value in readings.faces.iter().filter_map(|f| f.overhang) {
        // There is room for every face.
        let _ = values.push(value);
    }
    shell_sort(&mut values, |&v| sort_key(v));
    let (Some(least), Some(most)) = (values.first(), values.last()) else {
        return Reading {
            value: 0.0,
            sigma: UNSURE_OVERHANG,
        };
    };
    let upper = values.get(values.len() / 2).unwrap_or(most);
    let lower = values.get((values.len() - 1) / 2).unwrap_or(least);
    let median = 0.5 * (lower + upper);
    // The echoes' disagreement; a single one says nothing about it.
    let sigma = match values.len() {
        1 => 0.5 * UNSURE_OVERHANG,
        n => 0.5 * (most - least) / math::sqrt(n as f32),
    };
    Reading {
        value: if median > LEAST_OVERHANG { median } else { 0.0 },
        sigma,
    }
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
    let det: f32 = n * skk - sk * sk;
    if det.abs() < 1e-6 {
        return (if n > 0.0 { sv / n } else { 0.0 }, 0.0);
    }
    let slope = (n * skv - sk * sv) / det;
    ((sv - slope * sk) / n, slope)
}
