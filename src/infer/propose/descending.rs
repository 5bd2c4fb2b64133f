//! Stairs going down, as the search sees them: in the height plane treads face the mirror, one
//! below the other, and the roles of depth and height are exchanged. An edge is where a row of
//! echoes ends and where the shadow on the next tread begins.

use super::roles::Role;
use super::scene::{Mark, Scene};
use super::stairs::{ChainLink, Explanation, Flight, Spacing, Stairs};
use crate::estimate::Estimate;
use crate::math;
use crate::params::Params;

/// First edges tried, metres from the mirror: as far apart as an edge is known at first.
const EDGES_M: [f32; 8] = [-0.24, -0.20, -0.16, -0.12, -0.08, -0.04, 0.0, 0.04];
/// Goings tried, relative to what the stride asks for, metres: as far apart as an edge is known.
const GOINGS_M: [f32; 5] = [-0.04, -0.02, 0.0, 0.02, 0.04];
/// Where ramps downwards begin, metres from the mirror.
const FALLING_FROM_M: [f32; 3] = [0.0, -0.1, -0.2];
/// Slopes of ramps downwards: tan of 1° … 12° in steps of a degree.
const FALLING_SLOPES: [f32; 12] = [
    0.0175, 0.0349, 0.0524, 0.0699, 0.0875, 0.1051, 0.1228, 0.1405, 0.1584, 0.1763, 0.1944, 0.2126,
];
/// Edges and goings over which the likelihood is summed up, metres: 2.5 cm apart, finer than the
/// echoes know them; the bounds are those of stairs that people use and of a wheelchair that stands
/// before them.
const FINE_EDGES_M: [f32; 14] = grid(-0.26, 0.025);
/// See [`FINE_EDGES_M`].
const FINE_GOINGS_M: [f32; 9] = grid(0.20, 0.025);

/// Places one behind the other, equally spaced.
const fn grid<const N: usize>(first: f32, spacing: f32) -> [f32; N] {
    let mut places = [0.0; N];
    let mut k = 0;
    while k < N {
        places[k] = first + spacing * k as f32;
        k += 1;
    }
    places
}

/// What two flights of the same treads may differ in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DescentShape {
    /// Where the ground ends, metres from the mirror.
    pub edge_m: f32,
    /// From one edge to the next, metres.
    pub going_m: f32,
}

/// Stairs going down.
#[derive(Debug)]
pub struct Descending<'e> {
    scene: &'e Scene<'e>,
    /// The ground's last echo in front, and the one before: where it may end.
    ends: [f32; 2],
    null: f32,
}

/// Whether a mark lies right below the mirror, where treads flash.
pub fn is_flash(m: &Mark, p: &Params) -> bool {
    m.x_m.abs() < p.lower_flash_m + p.tread_reach_sigmas * m.x_sigma_m
}

/// A tread, or the ground before the first edge.
#[derive(Clone, Copy, Debug)]
pub struct Tread {
    /// Depth below the mirror, metres.
    pub depth_m: f32,
    /// From where on it can be seen, metres from the mirror.
    pub start_m: f32,
    /// Where it ends.
    pub end_m: f32,
}

impl Tread {
    /// Whether the shadow of the edge before lies on the mark's place.
    fn hides(&self, m: &Mark, p: &Params) -> bool {
        m.x_m < self.start_m && m.along_m > self.depth_m - p.inside_margin_m
    }

    /// Role and gain of a mark on the tread; none if it lies beyond its ends.
    fn gain(&self, m: &Mark, p: &Params) -> Option<(Role, f32)> {
        let reach = p.tread_reach_sigmas * m.x_sigma_m;
        // Behind the mirror's foot the riser is seen too, and with it the corner.
        let corner = self.start_m.is_finite() && self.start_m < 0.0;
        let before = if corner {
            math::max(reach, p.lower_corner_m)
        } else {
            reach
        };
        if m.x_m <= self.start_m - before || m.x_m >= self.end_m + reach {
            return None;
        }
        let z = (m.along_m - self.depth_m) / m.y_sigma_m;
        let (mut role, mut gain) = (Role::Tread, p.lower_tread_nats);
        let below_mirror =
            self.start_m < p.lower_flash_reach_m && self.end_m > -p.lower_flash_reach_m;
        if below_mirror && is_flash(m, p) {
            (role, gain) = (Role::Flash, p.lower_flash_nats);
        }
        let spot = |off: f32| {
            let variance = m.x_sigma_m * m.x_sigma_m + p.edge_spread_m * p.edge_spread_m;
            p.lower_edge_nats - 0.5 * off * off / variance
        };
        if corner && spot(m.x_m - self.start_m) > gain {
            (role, gain) = (Role::Corner, spot(m.x_m - self.start_m));
        }
        if self.end_m.is_finite() && spot(m.x_m - self.end_m + p.edge_short_m) > gain {
            (role, gain) = (Role::Edge, spot(m.x_m - self.end_m + p.edge_short_m));
        }
        Some((role, gain - 0.5 * z * z))
    }
}

impl<'e> Descending<'e> {
    /// Scores everything that is no stair: the ground going on, and ramps downwards.
    #[inline(never)]
    pub fn new(scene: &'e Scene<'e>) -> Self {
        let (p, height) = (scene.params, scene.mount_height_m);
        let mut ends = [0.0f32; 2];
        for m in scene.between(height - p.on_ground_m, height + p.on_ground_m) {
            let [last, _] = ends;
            if m.x_m < p.farthest_edge_m && (m.x_m > last || last == 0.0) {
                ends = [m.x_m, last];
            }
        }
        let mut descending = Self {
            scene,
            ends,
            null: 0.0,
        };
        let ground = Tread {
            depth_m: height,
            start_m: f32::NEG_INFINITY,
            end_m: f32::INFINITY,
        };
        descending.null = descending.tread(&ground) + descending.below(ground.depth_m);
        for slope in FALLING_SLOPES {
            for from in FALLING_FROM_M {
                descending.null = math::max(descending.null, scene.falling_ramp(from, slope));
            }
        }
        descending
    }

    /// Score of the marks near a tread's level.
    fn tread(&self, tread: &Tread) -> f32 {
        let p = self.scene.params;
        let scores = self.zone(tread).iter().map(|m| {
            let gain = match tread.gain(m, p) {
                Some((_, gain)) if gain > 0.0 => gain,
                _ if tread.hides(m, p) => -p.lower_inside_nats,
                _ => -p.lower_stray_nats,
            };
            gain * m.weight
        });
        scores.sum()
    }

    /// The marks that may belong to a tread by their height.
    fn zone(&self, tread: &Tread) -> &[Mark] {
        let zone = self.scene.params.tread_zone_m;
        self.scene
            .between(tread.depth_m - zone, tread.depth_m + zone)
    }

    /// The marks that show the level of a tread: on it, and not far beyond its ends.
    pub fn level_marks(&self, tread: &Tread) -> impl Iterator<Item = &Mark> {
        let p = self.scene.params;
        let tread = *tread;
        self.zone(&tread).iter().filter(move |m| {
            let reach = p.level_margin_m + p.level_sigmas * m.y_sigma_m;
            (m.along_m - tread.depth_m).abs() < reach
                && m.x_m > tread.start_m - p.inside_margin_m
                && m.x_m < tread.end_m + p.lower_corner_m + m.x_sigma_m
        })
    }

    /// Score of the marks below everything.
    fn below(&self, depth: f32) -> f32 {
        let p = self.scene.params;
        let marks = self.scene.between(depth + p.tread_zone_m, f32::INFINITY);
        marks.iter().map(|m| -p.lower_inside_nats * m.weight).sum()
    }

    /// Depth of tread `k` of a chain; the ground is tread 0.
    fn depth(&self, chain: &[ChainLink], k: usize) -> f32 {
        let link = k.checked_sub(1).and_then(|k| chain.get(k));
        link.map_or(self.scene.mount_height_m, |l| l.along_m)
    }

    /// The last tread of a chain, without its end.
    fn last(&self, chain: &[ChainLink], shape: DescentShape) -> Tread {
        let depth_m = self.depth(chain, chain.len());
        let start_m = match chain.len().checked_sub(1) {
            None => f32::NEG_INFINITY,
            Some(before) => {
                let edge = shape.edge_m + before as f32 * shape.going_m;
                // Behind an edge before the mirror lies a shadow.
                if edge < 0.0 {
                    edge
                } else {
                    edge * depth_m / self.depth(chain, before)
                }
            }
        };
        Tread {
            depth_m,
            start_m,
            end_m: f32::INFINITY,
        }
    }

    /// Tread `k` of a chain, which the ground begins as tread 0, with its end if it has one.
    pub fn tread_of(&self, chain: &[ChainLink], shape: DescentShape, k: usize) -> Tread {
        let mut tread = self.last(chain.get(..k).unwrap_or(chain), shape);
        if k < chain.len() {
            tread.end_m = shape.edge_m + k as f32 * shape.going_m;
        }
        tread
    }

    /// Mean and covariance of edge and going over their likelihood, the treads given.
    #[inline(never)]
    pub fn edges(&self, flight: &Flight<DescentShape>) -> Edges<'_> {
        let p = self.scene.params;
        let first = flight.chain.first();
        let rise = first.map_or(0.0, |l| l.along_m - self.scene.mount_height_m);
        let strides = |at: &DescentShape| {
            (2.0 * rise + at.going_m - p.stride_m).abs() < p.stride_sigmas * p.stride_sigma_m
        };
        let grid = FINE_EDGES_M.into_iter().flat_map(|edge_m| {
            let goings = FINE_GOINGS_M.into_iter();
            goings.map(move |going_m| DescentShape { edge_m, going_m })
        });
        let mut top = f32::NEG_INFINITY;
        let mut sums = [0f32; MOMENTS];
        for at in grid.filter(strides) {
            let score = self.whole(&flight.chain, at);
            if score > top {
                // A new best: what was summed up shrinks in comparison.
                let shrink = math::exp(top - score);
                sums = sums.map(|s| s * shrink);
                top = score;
            }
            let weight = math::exp(score - top);
            let DescentShape { edge_m, going_m } = at;
            let moments = [
                1.0,
                edge_m,
                going_m,
                edge_m * edge_m,
                going_m * going_m,
                edge_m * going_m,
            ];
            for (sum, moment) in sums.iter_mut().zip(moments) {
                *sum += weight * moment;
            }
        }
        Edges::new(sums, p)
    }
}

/// Sums over a likelihood of 1, edge, going, and their squares and product.
type LikelihoodSums = [f32; MOMENTS];
/// Their number.
const MOMENTS: usize = 6;

/// Where the edges are: the first one, from one to the next, and how sure that is.
#[derive(Clone, Copy, Debug)]
pub struct Edges<'p> {
    edge_m: f32,
    going_m: f32,
    edge_variance: f32,
    going_variance: f32,
    covariance: f32,
    params: &'p Params,
}

impl<'p> Edges<'p> {
    fn new(sums: LikelihoodSums, params: &'p Params) -> Self {
        let [sum, d, g, dd, gg, dg] = sums;
        let (edge_m, going_m) = (d / sum, g / sum);
        Self {
            edge_m,
            going_m,
            edge_variance: dd / sum - edge_m * edge_m,
            going_variance: gg / sum - going_m * going_m,
            covariance: dg / sum - edge_m * going_m,
            params,
        }
    }

    /// First edge and going.
    pub fn shape(&self) -> DescentShape {
        DescentShape {
            edge_m: self.edge_m,
            going_m: self.going_m,
        }
    }

    /// Place of edge `k` (0 is the ground's end), metres from the mirror.
    pub fn at(&self, k: usize) -> Estimate {
        let p = self.params;
        let k = k as f32;
        let grid = self.edge_variance + 2.0 * k * self.covariance + k * k * self.going_variance;
        let variance = math::max(grid, 0.0) + p.edge_speckle_m * p.edge_speckle_m;
        Estimate {
            value: self.edge_m + k * self.going_m,
            variance: p.edge_sigma_scale * p.edge_sigma_scale * variance,
        }
    }
}

impl Stairs for Descending<'_> {
    type Shape = DescentShape;

    fn scene(&self) -> &Scene<'_> {
        self.scene
    }

    fn spacing(&self) -> Spacing {
        let p = self.scene.params;
        Spacing {
            least_m: p.least_drop_m,
            most_m: p.most_drop_m,
            tolerance_m: p.tread_tolerance_m,
            landing_m: 0.0,
        }
    }

    fn beginnings(&self) -> impl Iterator<Item = (usize, DescentShape)> {
        let (p, ends) = (self.scene.params, self.ends);
        let columns = self.scene.columns.iter().enumerate();
        columns
            .filter(|(_, column)| column.begins)
            .flat_map(move |(k, column)| {
                let rise = column.along_m - self.scene.mount_height_m;
                let usable = (p.least_drop_m..=p.most_drop_m).contains(&rise);
                let edges = EDGES_M.into_iter().chain(ends).filter(move |_| usable);
                edges.flat_map(move |edge_m| {
                    GOINGS_M.map(|off| {
                        let going_m = p.stride_m - 2.0 * rise + off;
                        (k, DescentShape { edge_m, going_m })
                    })
                })
            })
    }

    fn face(&self, chain: &[ChainLink], next: ChainLink, shape: DescentShape) -> f32 {
        let p = self.scene.params;
        let edge = shape.edge_m + chain.len() as f32 * shape.going_m;
        let tread = Tread {
            end_m: edge,
            ..self.last(chain, shape)
        };
        let mut total = self.tread(&tread);
        let (upper, lower) = (
            tread.depth_m + p.tread_zone_m,
            next.along_m - p.tread_zone_m,
        );
        for m in self.scene.between(upper, lower) {
            let inside = m.x_m < edge - p.tread_reach_sigmas * m.x_sigma_m;
            total -= m.weight
                * if inside {
                    p.lower_inside_nats
                } else {
                    p.lower_stray_nats
                };
        }
        total -= p.lower_step_nats;
        if chain.is_empty() {
            let rise = next.along_m - tread.depth_m;
            let z = (2.0 * rise + shape.going_m - p.stride_m) / p.stride_sigma_m;
            total -= 0.5 * z * z;
        }
        total
    }

    fn behind(&self, chain: &[ChainLink], shape: DescentShape) -> f32 {
        let tread = self.last(chain, shape);
        self.tread(&tread) + self.below(tread.depth_m)
    }

    fn null(&self) -> f32 {
        self.null
    }

    fn role(&self, mark: &Mark, chain: &[ChainLink], shape: DescentShape) -> Role {
        let p = self.scene.params;
        let near = |k: &usize| (mark.along_m - self.depth(chain, *k)).abs() <= p.tread_zone_m;
        let Some(k) = (0..=chain.len()).find(near) else {
            return Role::Stray;
        };
        let tread = self.tread_of(chain, shape, k);
        match tread.gain(mark, p) {
            Some((role, gain)) if gain > 0.0 => role,
            _ if tread.hides(mark, p) => Role::Inside,
            _ => Role::Stray,
        }
    }

    fn open(_shape: DescentShape) -> bool {
        false
    }

    fn explanation(shape: DescentShape) -> Explanation {
        Explanation::Down {
            edge_m: shape.edge_m,
            going_m: shape.going_m,
        }
    }
}
