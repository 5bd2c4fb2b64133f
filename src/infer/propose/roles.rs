//! Classification of an echo, given a flight going up. This is the only place that defines it.
//!
//! Every echo gets the role in which it fits best. Its gain is that of the role in nats, less half of its squared
//! normalised deviation, times its credibility. The search adds these gains up. Dimensions, verdict and `inspect` use
//! the roles that the winner gives.

use super::scene::{Mark, Scene, gain};
use crate::math;
use crate::model::sight_m;
use crate::observer::trace::Role;
use crate::params::posterior;
use crate::signal::echoes::MAX_ECHOES;
use heapless::Vec;

/// Role of each mark (an echo in the search), in the marks' order.
pub type Roles = Vec<Role, MAX_ECHOES>;

/// A riser and the tread before it.
#[derive(Clone, Copy, Debug)]
pub struct Riser {
    /// Horizontal distance from the mirror of the riser before this one, metres; `None` for the first riser.
    pub previous_m: Option<f32>,
    /// Horizontal distance of this riser from the mirror, metres; infinite for the landing behind the last riser.
    pub along_m: f32,
    /// Height above the ground of the tread or floor at this riser's foot, metres.
    pub base_m: f32,
    /// Height above the ground of this riser's top, metres.
    pub top_m: f32,
    /// Whether the treads are open (no risers).
    pub open: bool,
}

impl Riser {
    /// Returns the landing behind a last riser, or the whole floor: as the tread before a riser at infinity.
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

/// Fit of an echo near a riser, nats, weighted by its credibility.
#[derive(Clone, Copy, Debug, Default)]
pub struct RoleFit {
    /// Score gain if the echo is the inner corner at the riser's foot, nats.
    pub corner: f32,
    /// Score gain if the echo is a feature of the riser's upper end (such as the nosing) or part of its face, nats.
    pub top: f32,
    /// Score gain if the echo is the nosing, a flash, or the visible part of a riser whose foot is hidden, nats.
    pub edge: f32,
    /// Another role that the echo has near the riser, with its score gain (or cost, where negative), nats; `None` where
    /// the gains `corner`, `top` and `edge` decide.
    pub other: Option<(Role, f32)>,
    /// Role (nosing, flash or face) to which the score gain `top` belongs.
    top_role: Role,
}

impl RoleFit {
    fn other(role: Role, nats: f32) -> Self {
        Self {
            other: Some((role, nats)),
            ..Self::default()
        }
    }

    /// Returns the role with the largest gain.
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
    /// Returns the lowest height that is visible at `x_m` on or behind a tread, over the nosing before it, metres.
    fn sight(&self, x_m: f32, riser: &Riser) -> f32 {
        let edge_m = riser.previous_m.unwrap_or(f32::INFINITY);
        sight_m(self.mount_height_m, x_m, riser.base_m, edge_m)
    }

    /// Whether the nosing before a riser hides its foot.
    pub fn hides_foot(&self, riser: &Riser) -> bool {
        riser.base_m > self.mount_height_m - posterior::SEES_FOOT_M
    }

    /// Whether a riser's face is at right angles to a line of sight: the mirror's height lies within it.
    pub fn faces_mirror(&self, riser: &Riser) -> bool {
        let p = self.params;
        riser.base_m - p.flash_margin_m < self.mount_height_m
            && self.mount_height_m < riser.top_m + p.flash_margin_m
    }

    /// Returns the gain of a mark as part of the tread before a riser, or of the floor seen through open treads,
    /// nats.
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

    /// Returns the role of a mark on the tread before a riser, and its gain (or cost, where negative), nats.
    pub fn on_tread(&self, m: &Mark, riser: &Riser) -> (Role, f32) {
        let p = self.params;
        let on = self.as_tread(m, riser);
        if on > 0.0 {
            return (Role::Tread, on * m.credibility);
        }
        if m.y_m < self.sight(m.x_m, riser) - p.off_margin_m - 2.0 * m.y_sigma_m {
            return (Role::Inside, -p.inside_nats * m.credibility);
        }
        let stands = m.y_m > riser.base_m + p.off_margin_m + m.y_sigma_m;
        if stands && riser.along_m.is_finite() {
            return (Role::Clutter, -p.clutter_nats * m.credibility);
        }
        (Role::Stray, -p.stray_nats * m.credibility)
    }

    /// Returns the gains of a mark near a riser in the roles that it may have there.
    pub fn on_riser(&self, m: &Mark, riser: &Riser) -> RoleFit {
        let p = self.params;
        let (s, w) = (m.y_sigma_m, m.credibility);
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
            // Visible from the sight line over the nosing before it up to its own nosing.
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

    /// Returns the gains of a mark on a riser that is visible from foot to top. `flash` is its gain as a flash, nats.
    fn on_visible_riser(&self, m: &Mark, riser: &Riser, flash: f32) -> RoleFit {
        let p = self.params;
        let (s, w) = (m.y_sigma_m, m.credibility);
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

    /// Returns the role of a mark near a riser or on the tread before it.
    pub fn role(&self, m: &Mark, riser: &Riser) -> Role {
        if m.x_m > riser.along_m - self.params.column_m {
            self.on_riser(m, riser).role()
        } else {
            self.on_tread(m, riser).0
        }
    }
}
