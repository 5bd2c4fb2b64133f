//! Shapes that a scene file can contain.

use serde::{Deserialize, Serialize};

/// Direction of a flight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Way {
    /// Upwards, away from the wheelchair.
    #[default]
    Up,
    /// Downwards, away from the wheelchair.
    Down,
}

/// A flight of stairs (a kerb is a flight of one step).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StairsSpec {
    /// Direction of the flight, upwards or downwards.
    #[serde(default)]
    pub direction: Way,
    /// Distance from the mirror to the first step's foremost edge (up), or to the first edge
    /// (down).
    pub distance_m: f64,
    /// Height of the surface before the first step, above that on which the wheelchair stands.
    #[serde(default)]
    pub base_m: f64,
    /// Number of steps.
    pub count: usize,
    /// Rise of every step.
    pub rise_m: f64,
    /// Distance from one foremost edge to the next.
    pub going_m: f64,
    /// Rises of the individual steps in place of `rise_m`: as many as steps.
    #[serde(default)]
    pub rises_m: Vec<f64>,
    /// Individual goings in place of `going_m`: one fewer than steps.
    #[serde(default)]
    pub goings_m: Vec<f64>,
    /// Overhang of a tread over the riser below it.
    #[serde(default)]
    pub nosing_m: f64,
    /// Radius of the rounding of the foremost edge; real treads are broken or rounded by 2 to 10 mm.
    #[serde(default = "default_radius")]
    pub nosing_radius_m: f64,
    /// Whether the foremost edge is chamfered at 45° over `nosing_radius_m` rather than rounded:
    /// chamfered kerbs of EN 1340, chipped edges.
    #[serde(default)]
    pub chamfered: bool,
    /// Batter of the risers: distance of their feet before their upper edges (battered kerbs of EN
    /// 1340). Only for closed flights going up without `nosing_m`.
    #[serde(default)]
    pub batter_m: f64,
    /// Length of a nosing strip along each tread, measured from the foremost edge; 0 for none (DIN
    /// 18040-1: 40 to 50 mm; Approved Document M: 55 mm). Only for closed flights going up.
    #[serde(default)]
    pub strip_m: f64,
    /// Height of the strips above the treads; the steps' heights in the truth include it.
    #[serde(default)]
    pub strip_proud_m: f64,
    /// Material of the strips; the default is that of the treads.
    #[serde(default)]
    pub strip_material: Option<String>,
    /// Thickness of a tread, visible at its overhang and with open risers.
    #[serde(default = "default_thickness")]
    pub tread_thickness_m: f64,
    /// Whether the flight has no risers, so that its treads float.
    #[serde(default)]
    pub open: bool,
    /// Depth of a floating tread; the default is the going plus 2 cm.
    #[serde(default)]
    pub tread_depth_m: Option<f64>,
    /// Slope of the treads down towards their foremost edges, metres per metre, for rain to run off
    /// (outdoor steps: 1 to 3 %). Only for closed flights going up.
    #[serde(default)]
    pub tread_fall: f64,
    /// Height of the C-channel that closes the front of a floating tread, 0 for none. The web
    /// stands upright at the foremost edge (channels of EN 10279, front plates of EN ISO 14122-3
    /// grating treads).
    #[serde(default)]
    pub channel_m: f64,
    /// Depth of the channel's flanges.
    #[serde(default = "default_flange")]
    pub channel_flange_m: f64,
    /// Whether the channel's open side faces the scanner, with the web behind.
    #[serde(default)]
    pub channel_open: bool,
    /// Length of the surface after the last step.
    #[serde(default = "default_landing")]
    pub landing_m: f64,
    /// Material of the treads and, unless given below, of the risers.
    pub material: String,
    /// Material of the risers, of the fronts of floating treads, and of the channels before them.
    #[serde(default)]
    pub riser_material: Option<String>,
    /// Width of the flight across the plane that the mirror sweeps; the default is wider than the beam.
    #[serde(default)]
    pub width_m: Option<f64>,
}

fn default_radius() -> f64 {
    0.003
}

fn default_flange() -> f64 {
    0.03
}

fn default_thickness() -> f64 {
    0.04
}

fn default_landing() -> f64 {
    1.2
}

/// A level surface, seen from above.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FloorSpec {
    /// Distance of the surface's beginning from the mirror, negative behind it.
    #[serde(default = "default_floor_start")]
    pub from_m: f64,
    /// Distance of the surface's end from the mirror; the default is the foot of the first flight going up, else 4 m.
    #[serde(default)]
    pub to_m: Option<f64>,
    /// Height of the floor above the surface that the wheelchair stands on.
    #[serde(default)]
    pub height_m: f64,
    /// Material of the floor.
    pub material: String,
}

fn default_floor_start() -> f64 {
    -0.6
}

/// An inclined surface, seen from above.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RampSpec {
    /// Distance of the ramp's beginning from the mirror.
    pub from_m: f64,
    /// Distance of the ramp's end from the mirror.
    pub to_m: f64,
    /// Height of the ramp at its beginning, above the surface that the wheelchair stands on.
    #[serde(default)]
    pub from_height_m: f64,
    /// Height of the ramp at its end, above the surface that the wheelchair stands on.
    pub to_height_m: f64,
    /// Material of the ramp.
    pub material: String,
}

/// An upright surface, seen from the front.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallSpec {
    /// Distance of the wall from the mirror.
    pub at_m: f64,
    /// Height of the wall's foot above the surface that the wheelchair stands on.
    #[serde(default)]
    pub bottom_m: f64,
    /// Height of the wall's top above the surface that the wheelchair stands on.
    #[serde(default = "default_wall_top")]
    pub top_m: f64,
    /// Material of the wall.
    pub material: String,
}

fn default_wall_top() -> f64 {
    2.5
}

/// A round upright post or leg.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PostSpec {
    /// Distance of the post's axis from the mirror.
    pub at_m: f64,
    /// Lateral offset of the post's axis from the plane that the mirror sweeps.
    #[serde(default)]
    pub lateral_m: f64,
    /// Diameter of the post.
    pub diameter_m: f64,
    /// Height of the post's lower end above the surface that the wheelchair stands on.
    #[serde(default)]
    pub bottom_m: f64,
    /// Height of the post's upper end above the surface that the wheelchair stands on.
    pub top_m: f64,
    /// Material of the post.
    pub material: String,
}

/// A rectangular solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxSpec {
    /// Distance of the box's front from the mirror.
    pub from_m: f64,
    /// Distance of the box's back from the mirror.
    pub to_m: f64,
    /// Height of the box's underside above the surface that the wheelchair stands on.
    #[serde(default)]
    pub bottom_m: f64,
    /// Height of the box's top above the surface that the wheelchair stands on.
    pub top_m: f64,
    /// Width of the box across the plane that the mirror sweeps; the default is wider than the beam.
    #[serde(default)]
    pub width_m: Option<f64>,
    /// Lateral offset of the box's middle from the plane that the mirror sweeps.
    #[serde(default)]
    pub lateral_m: f64,
    /// Whether a chair could mount the box. If so, a box of 6 to 30 cm is a step of the truth, else an uncounted one.
    #[serde(default)]
    pub mountable: bool,
    /// Material of the box.
    pub material: String,
}

/// A door frame: two jambs, a lintel and, if it has one, a threshold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DoorSpec {
    /// Distance of the door frame's front from the mirror.
    pub at_m: f64,
    /// Thickness of the wall in which the door is.
    #[serde(default = "default_door_depth")]
    pub depth_m: f64,
    /// Clear width of the opening.
    #[serde(default = "default_door_width")]
    pub width_m: f64,
    /// Clear height of the opening.
    #[serde(default = "default_door_height")]
    pub height_m: f64,
    /// Lateral offset of the middle of the opening from the plane that the mirror sweeps.
    #[serde(default)]
    pub lateral_m: f64,
    /// Width of a jamb and height of the lintel.
    #[serde(default = "default_frame")]
    pub frame_m: f64,
    /// Height of the door's threshold, 0 for none.
    #[serde(default)]
    pub threshold_m: f64,
    /// Material of the door frame and threshold.
    pub material: String,
}

fn default_door_depth() -> f64 {
    0.12
}

fn default_door_width() -> f64 {
    0.9
}

fn default_door_height() -> f64 {
    2.0
}

fn default_frame() -> f64 {
    0.08
}

/// A free shape. An open one is a thin sheet visible from both sides, a closed one a solid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PolylineSpec {
    /// Corners of the shape, `[x, height]` each: `x` forward from the mirror, height above the surface that the
    /// wheelchair stands on, metres.
    pub points: Vec<[f64; 2]>,
    /// Whether the last corner is joined to the first.
    #[serde(default)]
    pub closed: bool,
    /// Width of the shape across the plane that the mirror sweeps; the default is wider than the beam.
    #[serde(default)]
    pub width_m: Option<f64>,
    /// Lateral offset of the shape's middle from the plane that the mirror sweeps.
    #[serde(default)]
    pub lateral_m: f64,
    /// Material of the shape.
    pub material: String,
}
