//! The likelihood model: what each echo may be if a flight of stairs stands there.
//!
//! A hypothesis is a list of risers. It is scored in nats: every echo takes the role in which it
//! fits best and adds that role's gain less half its squared normalised deviation, times its
//! credibility; echoes that contradict the hypothesis cost; so does what should be seen and is not.
//! The score falls into one part a riser (with the tread before it) and one for what lies behind the
//! last, so that flights with the same beginning share its score.

use super::echo::MAX_ECHOES;
use super::evidence::{COLUMN, Evidence, Mark, X_MIN};
use crate::math;
use core::ops::Range;

/// An echo at a place known in x and y: corner, nosing, flash.
const POINT: f32 = 5.4;
/// Between them, on the riser.
const FACE: f32 = 2.5;
/// On a tread or the floor.
const TREAD: f32 = 1.1;
/// A corner 8 dB above everything else on its tread.
const BRIGHT: f32 = 1.1;
/// An echo inside the solid.
const INSIDE: f32 = 2.1;
/// An echo above the top of its own riser.
const ABOVE: f32 = 3.3;
/// An echo standing on a tread, or on the floor in front.
const CLUTTER: f32 = 2.5;
/// Anything else that the hypothesis does not explain.
const STRAY: f32 = 0.4;
/// Each further riser must pay for itself.
const STEP: f32 = 1.6;
/// A closed riser whose inner corner is not seen.
const NO_CORNER: f32 = 1.8;
/// A riser whose upper end is not seen.
const NO_TOP: f32 = 1.5;
/// A riser without any echo.
const NOTHING: f32 = 2.5;
/// Departure of a riser from the line of its predecessors, per (1.5 cm)².
const IRREGULAR: f32 = 0.35;
/// Second and further echoes in the same role count this much.
const AGAIN: f32 = 0.3;

/// A riser whose foot is not at least this much below the mirror shows none, metres.
const HIDDEN_FOOT: f32 = 0.01;

/// Gain of an echo `z` standard deviations off its role's place.
fn gain(role: f32, z: f32) -> f32 {
    math::max(role - 0.5 * z * z, 0.0)
}

/// Gain of an echo at height `y` as part of the floor.
pub fn floor(y: f32, sigma: f32) -> f32 {
    gain(TREAD, y / sigma)
}

/// What an echo is taken for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Role {
    /// The inner corner at the foot of a riser.
    Corner,
    /// The edge at its top.
    Nosing,
    /// The specular reflection of a face that looks straight at the mirror.
    Flash,
    /// A place on a riser between foot and top.
    Face,
    /// A tread, the landing, the floor.
    Tread,
    /// Where a tread ends, seen from above.
    Edge,
    /// Inside the solid: contradicts the flight.
    Inside,
    /// Above the top of its own riser: contradicts the flight.
    Above,
    /// Standing on a tread: contradicts the flight.
    Clutter,
    /// Not explained.
    #[default]
    Stray,
}

impl Role {
    /// Whether an echo in this role speaks against the flight.
    pub const fn contradicts(self) -> bool {
        matches!(self, Self::Inside | Self::Above | Self::Clutter)
    }

    /// Its name.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Corner => "corner",
            Self::Nosing => "nosing",
            Self::Flash => "flash",
            Self::Face => "face",
            Self::Tread => "tread",
            Self::Edge => "edge",
            Self::Inside => "inside",
            Self::Above => "above",
            Self::Clutter => "clutter",
            Self::Stray => "stray",
        }
    }
}

/// A riser and the tread before it.
#[derive(Clone, Copy, Debug)]
pub struct Riser {
    /// Where the riser before stands; `None` for the first.
    pub previous_x: Option<f32>,
    /// Where this one stands; infinitely far off for the landing behind the last.
    pub x: f32,
    /// Level at its foot.
    pub base: f32,
    /// Level at its top.
    pub top: f32,
    /// Whether there is nothing below the treads (a floating stair).
    pub open: bool,
}

/// The tread before a riser.
#[derive(Clone, Copy, Debug, Default)]
pub struct Before {
    /// Its score.
    pub score: f32,
    /// The strongest echo on it near the riser, dB.
    pub strongest: f32,
}

/// How an echo near a riser fits its roles, in nats, its credibility included.
#[derive(Clone, Copy, Debug, Default)]
struct Fit {
    corner: f32,
    /// As anything that shows the riser's upper end or its face.
    top: f32,
    /// As what only the upper end can make.
    edge: f32,
    /// Any other role, with its gain or cost.
    other: Option<(Role, f32)>,
    /// Which of those is behind `top`.
    top_role: Role,
}

impl Evidence {
    /// Lowest height that can be seen at `x` on or behind a tread: what a nosing above the mirror
    /// leaves visible.
    fn sight(&self, x: f32, riser: &Riser) -> f32 {
        let Riser {
            previous_x, base, ..
        } = *riser;
        match previous_x {
            Some(edge_x) if base >= self.mount_height => {
                self.mount_height + (base - self.mount_height) * x / edge_x
            }
            _ => base,
        }
    }

    /// Gain of a mark as part of the tread before a riser, or of the floor seen through it.
    #[inline]
    fn as_tread(&self, m: &Mark, riser: &Riser) -> f32 {
        let on = if riser.base < self.mount_height {
            gain(TREAD, (m.y - riser.base) / m.sigma)
        } else {
            0.0
        };
        if riser.open {
            math::max(on, m.floor)
        } else {
            on
        }
    }

    /// Role of a mark on the tread before a riser, and its gain or cost.
    // The search's innermost loop: what depends on the riser alone is worked out once outside.
    #[inline(always)]
    fn on_tread(&self, m: &Mark, riser: &Riser) -> (Role, f32) {
        let on = self.as_tread(m, riser);
        if on > 0.0 {
            return (Role::Tread, on * m.weight);
        }
        if m.y < self.sight(m.x, riser) - 0.02 - 2.0 * m.sigma {
            return (Role::Inside, -INSIDE * m.weight);
        }
        let stands = m.y > riser.base + 0.03 + m.sigma && (m.y - self.mount_height).abs() > 0.03;
        if stands && riser.x.is_finite() {
            return (Role::Clutter, -CLUTTER * m.weight);
        }
        (Role::Stray, -STRAY * m.weight)
    }

    /// How a mark near a riser fits.
    fn on_riser(&self, m: &Mark, riser: &Riser) -> Fit {
        let height = self.mount_height;
        let Riser {
            previous_x,
            x,
            base,
            top,
            open,
        } = *riser;
        let (s, w) = (m.sigma, m.weight);
        let low = self.sight(m.x, riser);
        let at_mirror = base - 0.02 < height && height < top + 0.03;
        let flash = at_mirror && (m.y - height).abs() < 0.01 + 2.0 * s;
        let other = |role, gain: f32| Fit {
            other: Some((role, gain * w)),
            ..Fit::default()
        };
        if m.y > top + 0.015 + 2.0 * s && !flash {
            // A wall far behind flashes over the stairs.
            let far_flash = (m.y - height).abs() < 0.03 && previous_x.is_some();
            return if far_flash {
                other(Role::Stray, -STRAY)
            } else {
                other(Role::Above, -ABOVE)
            };
        }
        if m.y < low - 0.02 - 2.0 * s {
            let on = self.as_tread(m, riser);
            return if on > 0.0 {
                other(Role::Tread, on)
            } else {
                other(Role::Inside, -INSIDE)
            };
        }
        if base > height - HIDDEN_FOOT {
            // From the sight line over the last nosing up to its own.
            let z = math::max(math::max(m.y - top, low - m.y), 0.0) / s;
            let top = (POINT - 0.5 * z * z) * w;
            return Fit {
                top,
                edge: top,
                top_role: Role::Nosing,
                ..Fit::default()
            };
        }
        let corner = if open {
            0.0
        } else {
            gain(POINT, (m.y - base) / s) * w
        };
        let edge = if flash {
            POINT * w
        } else {
            gain(POINT, (m.y - top) / s) * w
        };
        let top_role = if flash { Role::Flash } else { Role::Nosing };
        let fit = Fit {
            corner,
            top: edge,
            edge,
            top_role,
            other: None,
        };
        if m.y <= base + math::max(2.0 * s, 0.04) || m.y >= top {
            return fit;
        }
        // Seen from afar a low riser's nosing and face melt into one echo.
        let blend = top - base < 0.105 * math::max(x, 0.3);
        let face = FACE * w * if blend { 1.4 } else { 1.0 };
        if face <= edge {
            return fit;
        }
        Fit {
            top: face,
            edge: if blend { face } else { edge },
            top_role: Role::Face,
            ..fit
        }
    }

    /// The tread before a riser, or the landing.
    pub fn tread(&self, riser: &Riser) -> Before {
        let from = riser.previous_x.map_or(X_MIN, |x| x + COLUMN);
        let (mut total, mut strongest, mut clutter) = (0.0, 3.0f32, 0.0f32);
        for m in self.between(from, riser.x - COLUMN) {
            let (role, gain) = self.on_tread(m, riser);
            if role == Role::Clutter {
                // What stands on one tread is one thing, however many echoes it has.
                total += AGAIN * math::max(clutter, gain);
                clutter = math::min(clutter, gain);
            } else {
                total += gain;
            }
            let on_level = (m.y - riser.base).abs() < 2.5 * m.sigma;
            if role == Role::Tread && on_level && m.x > riser.x - 0.35 {
                strongest = math::max(strongest, m.db);
            }
        }
        Before {
            score: total + clutter,
            strongest,
        }
    }

    /// Scores of the landings below the mirror at one level that begin with the marks of `range`:
    /// entry k of `sums` is that of all marks from number k on. Those behind the range are known.
    pub fn landings(
        &self,
        level: f32,
        open: bool,
        sums: &mut [f32; MAX_ECHOES + 1],
        range: Range<usize>,
    ) {
        let landing = Riser {
            previous_x: None,
            x: f32::INFINITY,
            base: level,
            top: level,
            open,
        };
        let mut sum = sums.get(range.end).copied().unwrap_or(0.0);
        let marks = self.marks.get(range.clone()).unwrap_or(&[]);
        let places = sums.get_mut(range).unwrap_or(&mut []);
        for (place, mark) in places.iter_mut().zip(marks).rev() {
            sum += self.on_tread(mark, &landing).1;
            *place = sum;
        }
    }

    /// Score of everything behind the last riser of a flight.
    pub fn landing(&self, previous_x: Option<f32>, base: f32, open: bool) -> f32 {
        self.tread(&Riser {
            previous_x,
            x: f32::INFINITY,
            base,
            top: base,
            open,
        })
        .score
    }

    /// Score of one riser and the tread `before` it.
    pub fn riser(&self, riser: &Riser, before: Before) -> f32 {
        let height = self.mount_height;
        let Riser {
            x, base, top, open, ..
        } = *riser;
        let mut total = before.score - STEP;
        let marks = self.between(math::max(x - COLUMN, X_MIN), x + COLUMN);
        if marks.is_empty() {
            return total - NOTHING;
        }
        // The best echo in each role counts in full, further ones a little.
        let (mut corner, mut nosing, mut edge, mut corner_db) = (0.0f32, 0.0f32, 0.0f32, -99.0f32);
        for m in marks {
            let fit = self.on_riser(m, riser);
            edge = math::max(edge, fit.edge);
            if let Some((_, gain)) = fit.other {
                total += gain;
            } else if fit.corner > fit.top && fit.corner > corner {
                total += AGAIN * corner;
                corner = fit.corner;
                corner_db = m.db;
            } else if fit.top > nosing {
                total += AGAIN * nosing;
                nosing = fit.top;
            } else if fit.corner > 0.0 || fit.top > 0.0 {
                total += AGAIN * math::max(fit.corner, fit.top);
            } else {
                total -= STRAY * m.weight;
            }
        }
        // A flash's flank hides the corner below it.
        let near_flash = top > height - 0.02 && height - base < 0.13 * x;
        if !open && base <= height - HIDDEN_FOOT && corner < 1.0 && !near_flash {
            total -= NO_CORNER;
        }
        if edge < 0.8 {
            total -= NO_TOP;
        }
        if corner > 1.0 && corner_db > math::max(8.0, before.strongest + 8.0) {
            total += BRIGHT;
        }
        total + corner + nosing
    }

    /// What a mark is taken for if it lies near a riser (`true`) or on the tread before it.
    pub fn role(&self, m: &Mark, riser: &Riser, near: bool) -> Role {
        if !near {
            return self.on_tread(m, riser).0;
        }
        match self.on_riser(m, riser) {
            Fit {
                other: Some((role, _)),
                ..
            } => role,
            fit if fit.corner > fit.top => Role::Corner,
            fit if fit.top > 0.0 => fit.top_role,
            _ => Role::Stray,
        }
    }

    /// Score of `marks` on ground that rises steadily by `slope` from `from_x` on, added to that of
    /// the marks before them; slope 0 is the flat floor.
    fn ramp(&self, marks: &[Mark], from_x: f32, slope: f32, before: f32) -> f32 {
        let mut total = before;
        for m in marks {
            let z = (m.y - slope * math::max(m.x - from_x, 0.0)) / m.sigma;
            let g = TREAD - 0.5 * z * z;
            total += m.weight
                * if g > 0.0 {
                    g
                } else if z < -2.0 {
                    -INSIDE
                } else {
                    -STRAY
                };
        }
        total
    }

    /// Score of the best ramp or flat floor.
    pub fn best_ramp(&self) -> f32 {
        // tan of 3.2° … 11.6°
        const SLOPES: [f32; 8] = [
            0.0559, 0.0769, 0.0981, 0.1192, 0.1405, 0.1620, 0.1835, 0.2053,
        ];
        // The steepest misses what begins between these by less than an echo's height is known.
        const FROM: [f32; 8] = [0.30, 0.42, 0.54, 0.66, 0.78, 0.90, 1.02, 1.14];
        let marks = self.between(X_MIN, f32::INFINITY);
        let (mut flat, mut rest) = (0.0, marks);
        let mut best = f32::NEG_INFINITY;
        for from in FROM {
            let (before, behind) = rest.split_at(rest.partition_point(|m| m.x <= from));
            (flat, rest) = (self.ramp(before, 0.0, 0.0, flat), behind);
            for slope in SLOPES {
                best = math::max(best, self.ramp(rest, from, slope, flat));
            }
        }
        math::max(best, self.ramp(rest, 0.0, 0.0, flat))
    }
}

/// Cost of three risers in a row that are not evenly spaced.
pub fn irregularity(a: f32, b: f32, c: f32) -> f32 {
    let d = (c - 2.0 * b + a) / 0.015;
    math::min(IRREGULAR * d * d, 1.0)
}
