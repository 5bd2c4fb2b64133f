//! What each riser's own echoes say of its place, its height and its nosing.

use super::ascending::{AscentShape, riser_of};
use super::heights::{Fusion, TreadLevels};
use super::roles::{Riser, Role};
use super::scene::{Mark, Scene};
use super::stairs::{Chain, Flight, MAX_FLIGHT};
use crate::estimate::Estimate;
use crate::math;
use crate::params::Params;
use crate::signal::echoes::MAX_ECHOES;
use heapless::Vec;

/// What each mark is taken for, in the marks' order.
pub type Roles = Vec<Role, MAX_ECHOES>;

/// What one step's own echoes say.
#[derive(Clone, Copy, Debug, Default)]
pub struct Face {
    /// Horizontal distance of the riser, metres.
    pub x_m: Option<f32>,
    /// Whether nosing and riser show apart from each other.
    pub overhang_seen: bool,
    /// Level of the tread, metres.
    pub level: Fusion,
    /// Strongest echo, dB.
    pub snr_db: Option<f32>,
    /// Whether that one is the flash of a face that looks straight at the mirror.
    pub flashes: bool,
}

/// What the echoes say about all steps.
#[derive(Clone, Debug, Default)]
pub struct Readings {
    /// Of each step, the nearest first.
    pub faces: Vec<Face, MAX_FLIGHT>,
    /// Of the riser's height, metres; one place is left for the flight's as a whole.
    pub slopes: Vec<Estimate, { MAX_FLIGHT + 1 }>,
}

/// Riser `k` of a chain whose levels are known.
pub fn riser(chain: &Chain, open: bool, levels: &TreadLevels, k: usize) -> Riser {
    let place = |k: usize| chain.get(k).map(|l| l.along_m);
    let level = |k: usize| levels.get(k).map(|l| l.height.value);
    let before = k.checked_sub(1);
    let base_m = before.and_then(level).unwrap_or(0.0);
    Riser {
        previous_m: before.and_then(place),
        along_m: place(k).unwrap_or(f32::INFINITY),
        base_m,
        top_m: place(k).and(level(k)).unwrap_or(base_m),
        open,
    }
}

/// What each mark is taken for if the flight has these levels.
pub fn roles(scene: &Scene<'_>, flight: &Flight<AscentShape>, levels: &TreadLevels) -> Roles {
    let mut roles = Roles::new();
    for m in &scene.marks {
        let k = riser_of(m, &flight.chain, scene.params.column_m);
        let riser = riser(&flight.chain, flight.shape.open, levels, k);
        // As many as there are marks.
        let _ = roles.push(scene.role(m, &riser));
    }
    roles
}

/// One riser with its echoes.
struct RiserMarks<'e> {
    scene: &'e Scene<'e>,
    p: &'e Params,
    riser: Riser,
    marks: &'e [Mark],
    roles: &'e [Role],
}

fn strongest<'m>(marks: impl Iterator<Item = &'m Mark>) -> Option<&'m Mark> {
    marks.max_by(|a, b| a.snr_db.total_cmp(&b.snr_db))
}

impl<'e> RiserMarks<'e> {
    fn with(&self, is: impl Fn(&Mark, Role) -> bool) -> impl Iterator<Item = &'e Mark> {
        let pairs = self.marks.iter().zip(self.roles);
        pairs.filter(move |(m, role)| is(m, **role)).map(|(m, _)| m)
    }

    fn strongest_as(&self, wanted: Role) -> Option<&'e Mark> {
        strongest(self.with(|_, role| role == wanted))
    }

    /// The edge at the top.
    fn nosing(&self) -> Option<&'e Mark> {
        let tops = self.with(|_, role| role == Role::Nosing);
        if self.scene.hides_foot(&self.riser) {
            strongest(tops)
        } else {
            tops.max_by(|a, b| a.y_m.total_cmp(&b.y_m))
        }
    }

    /// Height error of a mark from a `fixed` angle and one at 0 dB, radians.
    fn angle_error_m(m: &Mark, fixed_rad: f32, noise_rad: f32) -> f32 {
        m.range_m * (fixed_rad + noise_rad * math::amplitude(-m.snr_db))
    }

    /// Height of the step's top edge from an echo near it. What is seen lies lower: the riser or the
    /// tread's front pulls the echo down by an amount that depends on what else shines there, the
    /// more the straighter the riser looks at the mirror.
    fn top_level(&self, m: &Mark) -> Estimate {
        let p = self.p;
        let beside_flash =
            self.scene.faces_mirror(&self.riser) || self.scene.hides_foot(&self.riser);
        let (shines, clean) = (
            self.scene.shines_at(m, &self.riser),
            m.width < p.clean_width,
        );
        let (low_m, sigma_m) = match (self.riser.open, beside_flash, shines, clean) {
            (true, true, _, _) => (p.open_flash_low_m, p.open_flash_sigma_m),
            (true, false, _, true) => (p.open_clean_low_m, p.open_clean_sigma_m),
            (true, false, _, false) => (p.open_broad_low_m, p.open_broad_sigma_m),
            (false, true, _, _) => (p.closed_flash_low_m, p.closed_flash_sigma_m),
            (false, false, true, true) => (p.shining_clean_low_m, p.shining_clean_sigma_m),
            (false, false, true, false) => (p.shining_broad_low_m, p.shining_broad_sigma_m),
            (false, false, false, true) => (p.closed_clean_low_m, p.closed_clean_sigma_m),
            (false, false, false, false) => (p.closed_broad_low_m, p.closed_broad_sigma_m),
        };
        let angle_m = Self::angle_error_m(m, p.edge_angle_rad, p.edge_noise_rad);
        Estimate::new(m.y_m + low_m, math::hypot(sigma_m, angle_m))
    }

    /// Level of the tread before from the corner at its end.
    fn corner_level(&self, m: &Mark) -> Estimate {
        let p = self.p;
        let (low_m, sigma_m) = if m.width < p.clean_width {
            (0.0, p.corner_clean_sigma_m)
        } else {
            (p.corner_broad_low_m, p.corner_broad_sigma_m)
        };
        let angle_m = Self::angle_error_m(m, p.corner_angle_rad, p.corner_noise_rad);
        Estimate::new(m.y_m - low_m, math::hypot(sigma_m, angle_m))
    }

    /// Height of the flight's risers from an echo at height `y_m` on riser `k`, whose foot the
    /// nosing before hides: it lies somewhere on the visible part. `q` is the ratio of the two
    /// distances.
    fn hidden_slope(&self, y_m: f32, q: f32, k: f32) -> Option<Estimate> {
        let (p, height) = (self.p, self.scene.mount_height_m);
        let visible = height + (self.riser.base_m - height) * q;
        let per_rise = 0.5 * q * k + 0.5 * (k + 1.0);
        let span = math::max(self.riser.top_m - visible, p.hidden_least_span_m);
        (y_m > visible - p.hidden_reach_m).then(|| {
            Estimate::new(
                (y_m - 0.5 * height * (1.0 - q)) / per_rise,
                (p.hidden_sigma_m + p.hidden_sigma_span * span) / per_rise,
            )
        })
    }

    /// Reads the riser's echoes; what a corner says of the tread before goes to `before`.
    fn read(&self, before: Option<&mut Face>) -> Face {
        let mut face = Face::default();
        let Some(all) = strongest(self.marks.iter()) else {
            return face;
        };
        let corner = self.strongest_as(Role::Corner);
        let flash = self.strongest_as(Role::Flash);
        let known = strongest(corner.into_iter().chain(flash));
        face.x_m = Some(known.unwrap_or(all).x_m);
        face.snr_db = Some(all.snr_db);
        face.flashes = flash.is_some_and(|m| m.echo == all.echo);
        if let Some(m) = corner
            && let Some(before) = before
        {
            before.level.add(self.corner_level(m));
        }
        let open = self.riser.open;
        if let Some(m) = self.nosing()
            && (open || !self.scene.hides_foot(&self.riser))
        {
            face.level.add(self.top_level(m));
            face.overhang_seen = known.is_some();
        }
        face
    }
}

/// Reads every riser's echoes, given the levels as known so far and what each mark is taken for.
#[inline(never)]
pub fn read(
    scene: &Scene<'_>,
    flight: &Flight<AscentShape>,
    levels: &TreadLevels,
    roles: &Roles,
) -> Readings {
    let mut out = Readings::default();
    let mut before_x: Option<f32> = None;
    for (k, link) in flight.chain.iter().enumerate() {
        let (first, end) = match link.column {
            Some(_) => scene.near_range(link.along_m),
            None => (0, 0),
        };
        let place = RiserMarks {
            scene,
            p: scene.params,
            riser: riser(&flight.chain, flight.shape.open, levels, k),
            marks: scene.marks.get(first..end).unwrap_or(&[]),
            roles: roles.get(first..end).unwrap_or(&[]),
        };
        let face = place.read(out.faces.last_mut());
        if let (Some(before), Some(x), Some(all)) =
            (before_x, face.x_m, strongest(place.marks.iter()))
            && scene.params.rules.hidden_slope
            && scene.hides_foot(&place.riser)
            && !place.riser.open
            && let Some(slope) = place.hidden_slope(all.y_m, x / before, k as f32)
        {
            let _ = out.slopes.push(slope);
        }
        before_x = face.x_m;
        // As many as the flight has.
        let _ = out.faces.push(face);
    }
    out
}
