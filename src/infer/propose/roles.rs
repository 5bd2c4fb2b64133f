//! What an echo is if a flight of stairs goes up there: the one place that says so.
//!
//! Every echo takes the role in which it fits best: that role's gain in nats less half its squared
//! normalised deviation, times its credibility. The search adds these up; dimensions, verdict and
//! `inspect` read the roles that the winner gives.

use super::scene::{Mark, Scene, gain};
use crate::math;
use crate::model::sight_m;
use crate::params::posterior as number;
use crate::signal::echoes::MAX_ECHOES;
use heapless::Vec;

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

/// What each mark is taken for, in the marks' order.
pub type Roles = Vec<Role, MAX_ECHOES>;

/// A riser and the tread before it.
#[derive(Clone, Copy, Debug)]
pub struct Riser {
    /// Where the riser before stands, metres; `None` for the first.
    pub previous_m: Option<f32>,
    /// Where this one stands, metres; infinitely far off for the landing behind the last.
    pub along_m: f32,
    /// Level at its foot, metres.
    pub base_m: f32,
    /// Level at its top, metres.
    pub top_m: f32,
    /// Whether there is nothing below the treads (a floating stair).
    pub open: bool,
}

impl Riser {
    /// The landing behind a last riser, or the whole floor.
    pub fn landing(previous_m: Option<f32>, level_m: f32, open: bool) -> Self {
        Self {
            previous_m,
            along_m: f32::INFINITY,
            base_m: level_m,
            top_m: level_m,
            open,
        }
    }
}

/// How an echo near a riser fits, in nats, its credibility included.
#[derive(Clone, Copy, Debug, Default)]
pub struct RoleFit {
    /// As the inner corner.
    pub corner: f32,
    /// As anything that shows the riser's upper end or its face.
    pub top: f32,
    /// As what only the upper end can make.
    pub edge: f32,
    /// Any other role, with its gain or cost.
    pub other: Option<(Role, f32)>,
    /// Which of those is behind `top`.
    top_role: Role,
}

impl RoleFit {
    fn other(role: Role, nats: f32) -> Self {
        Self {
            other: Some((role, nats)),
            ..Self::default()
        }
    }

    /// The role that fits best.
    pub fn role(&self) -> Role {
        match self.other {
            Some((role, _)) => role,
            None if self.corner > self.top => Role::Corner,
            None if self.top > 0.0 => self.top_role,
            None => Role::Stray,
        }
    }
}

impl Scene<'_> {
    /// Lowest height that can be seen at `x_m` on or behind a tread: what a nosing above the mirror
    /// leaves visible.
    fn sight(&self, x_m: f32, riser: &Riser) -> f32 {
        let edge_m = riser.previous_m.unwrap_or(f32::INFINITY);
        sight_m(self.mount_height_m, x_m, riser.base_m, edge_m)
    }

    /// Whether the nosing before a riser hides its foot.
    pub fn hides_foot(&self, riser: &Riser) -> bool {
        riser.base_m > self.mount_height_m - number::SEES_FOOT_M
    }

    /// Whether a riser looks straight at the mirror.
    pub fn faces_mirror(&self, riser: &Riser) -> bool {
        let p = self.params;
        riser.base_m - p.flash_margin_m < self.mount_height_m
            && self.mount_height_m < riser.top_m + p.flash_margin_m
    }

    /// Gain of a mark as part of the tread before a riser, or of the floor seen through it.
    fn as_tread(&self, m: &Mark, riser: &Riser) -> f32 {
        let on = if riser.base_m < self.mount_height_m {
            gain(self.params.tread_nats, (m.y_m - riser.base_m) / m.y_sigma_m)
        } else {
            0.0
        };
        if riser.open {
            math::max(on, m.floor_nats)
        } else {
            on
        }
    }

    /// Role of a mark on the tread before a riser, and its gain or cost.
    pub fn on_tread(&self, m: &Mark, riser: &Riser) -> (Role, f32) {
        let p = self.params;
        let on = self.as_tread(m, riser);
        if on > 0.0 {
            return (Role::Tread, on * m.weight);
        }
        if m.y_m < self.sight(m.x_m, riser) - p.off_margin_m - 2.0 * m.y_sigma_m {
            return (Role::Inside, -p.inside_nats * m.weight);
        }
        let stands = m.y_m > riser.base_m + p.off_margin_m + m.y_sigma_m;
        if stands && riser.along_m.is_finite() {
            return (Role::Clutter, -p.clutter_nats * m.weight);
        }
        (Role::Stray, -p.stray_nats * m.weight)
    }

    /// How a mark near a riser fits.
    pub fn on_riser(&self, m: &Mark, riser: &Riser) -> RoleFit {
        let p = self.params;
        let (s, w) = (m.y_sigma_m, m.weight);
        let off_mirror = (m.y_m - self.mount_height_m).abs();
        let flash_z = off_mirror / s;
        let flash = self.faces_mirror(riser) && flash_z < 2.0;
        if m.y_m > riser.top_m + p.off_margin_m + 2.0 * s && !flash {
            return RoleFit::other(Role::Above, -p.above_nats * w);
        }
        let low = self.sight(m.x_m, riser);
        if m.y_m < low - p.off_margin_m - 2.0 * s {
            let on = self.as_tread(m, riser);
            return if on > 0.0 {
                RoleFit::other(Role::Tread, on * w)
            } else {
                RoleFit::other(Role::Inside, -p.inside_nats * w)
            };
        }
        if self.hides_foot(riser) {
            // From the sight line over the last nosing up to its own.
            let z = math::max(math::max(m.y_m - riser.top_m, low - m.y_m), 0.0) / s;
            let top = (p.point_nats - 0.5 * z * z) * w;
            let top_role = if flash && flash_z <= z {
                Role::Flash
            } else {
                Role::Nosing
            };
            return RoleFit {
                top,
                edge: top,
                top_role,
                ..RoleFit::default()
            };
        }
        let flash = if flash {
            gain(p.point_nats, flash_z) * w
        } else {
            0.0
        };
        self.on_visible_riser(m, riser, flash)
    }

    /// How a mark fits on a riser that can be seen from foot to top; `flash` is its gain as that.
    fn on_visible_riser(&self, m: &Mark, riser: &Riser, flash: f32) -> RoleFit {
        let p = self.params;
        let (s, w) = (m.y_sigma_m, m.weight);
        let corner = if riser.open {
            0.0
        } else {
            gain(p.point_nats, (m.y_m - riser.base_m) / s) * w
        };
        let nosing = gain(p.point_nats, (m.y_m - riser.top_m) / s) * w;
        let edge = math::max(nosing, flash);
        let top_role = if flash > nosing {
            Role::Flash
        } else {
            Role::Nosing
        };
        let fit = RoleFit {
            corner,
            top: edge,
            edge,
            top_role,
            other: None,
        };
        if m.y_m <= riser.base_m + 2.0 * s || m.y_m >= riser.top_m {
            return fit;
        }
        let face = p.face_nats * w;
        if face <= edge {
            return fit;
        }
        RoleFit {
            top: face,
            top_role: Role::Face,
            ..fit
        }
    }

    /// What a mark is taken for if it lies near a riser or on the tread before it.
    pub fn role(&self, m: &Mark, riser: &Riser) -> Role {
        if m.x_m > riser.along_m - self.params.column_m {
            self.on_riser(m, riser).role()
        } else {
            self.on_tread(m, riser).0
        }
    }
}
