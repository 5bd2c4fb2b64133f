//! Test bodies with their dimensions, as parts of a scene.

use stairscan::verdict::HazardKind;

use host_sim::scene::spec::{FloorSpec, PostSpec, SceneSpec, StairsSpec, Way};

/// Diameter of the post, metres: a bollard or the leg of a table.
const POST_M: f64 = 0.06;
/// Height of the post above the ground, metres: half a metre above the mirror.
const POST_TOP_M: f64 = 0.90;
/// Rise and going of the stairs, metres: 2 rise + going = 63 cm.
const FLIGHT_M: [f64; 2] = [0.17, 0.29];
/// Number of steps of the stairs.
const FLIGHT_STEPS: usize = 4;
/// Length of the ground behind a body's front, metres: beyond the range.
const BEYOND_M: f64 = 2.5;
/// Thickness of a floating tread, metres.
const SLAB_M: f64 = 0.04;
/// Distance from the mirror at which level ground ends, metres: beyond the range.
const LEVEL_M: f64 = 4.0;
/// Minimum height of a rise or depth of a drop, centimetres, that a scan must name at its place to detect it: from this
/// height on a single rise counts as a step.
const MIN_STEP_CM: u32 = 6;

/// A test body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// A platform of this height, centimetres, whose front edge is at the body's place and which continues beyond the
    /// range.
    Rise(u32),
    /// A drop of this depth, centimetres, to a lower floor that continues beyond the range.
    Drop(u32),
    /// An upright round steel post in the plane of the beam.
    Post,
    /// Closed stairs going up.
    Closed,
    /// Stairs going up whose treads float.
    Open,
    /// Closed stairs going down, seen from the upper floor.
    Down,
    /// No body: level ground.
    Level,
}

impl Body {
    /// Bodies that are measured over distance, yaw, pitch and window.
    pub const STANDARD: [Self; 6] = [
        Self::Rise(10),
        Self::Drop(15),
        Self::Post,
        Self::Closed,
        Self::Open,
        Self::Down,
    ];

    /// Returns the body's short name without the size, such as `rise`, as `--body` and files use it.
    pub const fn kind(self) -> &'static str {
        match self {
            Self::Rise(_) => "rise",
            Self::Drop(_) => "drop",
            Self::Post => "post",
            Self::Closed => "closed-stairs",
            Self::Open => "open-stairs",
            Self::Down => "stairs-down",
            Self::Level => "level",
        }
    }

    /// Returns the name with the size, such as `rise of 10 cm`.
    pub fn name(self) -> String {
        match self {
            Self::Rise(cm) => format!("rise of {cm} cm"),
            Self::Drop(cm) => format!("drop of {cm} cm"),
            Self::Post => "post".into(),
            Self::Closed => "closed stairs up".into(),
            Self::Open => "open stairs up".into(),
            Self::Down => "stairs down".into(),
            Self::Level => "level ground".into(),
        }
    }

    /// Returns the body's dimensions as text.
    pub fn dimensions(self) -> String {
        let [rise, going] = FLIGHT_M.map(|m| 100.0 * m);
        match self {
            Self::Rise(cm) => format!(
                "one edge of {cm} cm across the way, rounded by 3 mm, and a level top that goes on"
            ),
            Self::Drop(cm) => format!("the ground ends; the next floor is {cm} cm lower"),
            Self::Post => format!(
                "steel, {:.0} cm thick and {:.0} cm high, its axis in the plane of the beam",
                100.0 * POST_M,
                100.0 * POST_TOP_M
            ),
            Self::Closed => format!("{FLIGHT_STEPS} steps of {rise:.0} by {going:.0} cm"),
            Self::Open => format!("the same without risers: slabs of {:.0} cm", 100.0 * SLAB_M),
            Self::Down => {
                format!("{FLIGHT_STEPS} steps of {rise:.0} by {going:.0} cm, seen from above")
            }
            Self::Level => "nothing stands or ends within the range".into(),
        }
    }

    /// Returns the hazard that a guard sweep should name at the end of its free distance; `None` for level ground.
    pub const fn ending(self) -> Option<HazardKind> {
        match self {
            Self::Rise(_) | Self::Closed | Self::Open => Some(HazardKind::Rise),
            Self::Drop(_) | Self::Down => Some(HazardKind::Drop),
            Self::Post => Some(HazardKind::Obstacle),
            Self::Level => None,
        }
    }

    /// Whether a scan detects the body only by reporting a step or a drop at its place. For other bodies a free
    /// distance that ends at or before the body is enough.
    pub const fn needs_named_detection(self) -> bool {
        match self {
            Self::Rise(cm) | Self::Drop(cm) => cm >= MIN_STEP_CM,
            Self::Closed | Self::Open | Self::Down => true,
            Self::Post | Self::Level => false,
        }
    }

    /// Adds body and ground to `spec`, with the body's front `at_m` metres ahead. `ground` is the material of both,
    /// except of a post, which is of metal.
    pub fn place(self, spec: &mut SceneSpec, at_m: f64, ground: &str) {
        let flight = |count, rise_m| flight(count, rise_m, at_m, ground);
        match self {
            Self::Rise(cm) => spec.stairs.push(flight(1, 0.01 * f64::from(cm))),
            Self::Drop(cm) => spec.stairs.push(StairsSpec {
                direction: Way::Down,
                ..flight(1, 0.01 * f64::from(cm))
            }),
            Self::Closed => spec.stairs.push(flight(FLIGHT_STEPS, FLIGHT_M[0])),
            Self::Open => spec.stairs.push(StairsSpec {
                open: true,
                ..flight(FLIGHT_STEPS, FLIGHT_M[0])
            }),
            Self::Down => spec.stairs.push(StairsSpec {
                direction: Way::Down,
                ..flight(FLIGHT_STEPS, FLIGHT_M[0])
            }),
            Self::Post => {
                spec.post.push(PostSpec {
                    at_m: at_m + 0.5 * POST_M,
                    // In the plane that the mirror sweeps, at any yaw.
                    lateral_m: 0.0,
                    diameter_m: POST_M,
                    bottom_m: 0.0,
                    top_m: POST_TOP_M,
                    material: "metal".into(),
                });
            }
            Self::Level => {}
        }
        // A flight going down includes its upper floor.
        if !matches!(self, Self::Drop(_) | Self::Down) {
            spec.floor.push(FloorSpec {
                from_m: -0.6,
                to_m: spec.stairs.is_empty().then_some(LEVEL_M),
                height_m: 0.0,
                material: ground.into(),
            });
        }
    }
}

/// Returns a flight going up of `count` risers, each `rise_m` metres high, the first at `distance_m` metres from the
/// mirror. Risers are closed, without nosings.
fn flight(count: usize, rise_m: f64, distance_m: f64, material: &str) -> StairsSpec {
    // Gratings have front plates (EN ISO 14122-3).
    let riser = (material == "grating").then(|| "metal".to_owned());
    StairsSpec {
        direction: Way::Up,
        distance_m,
        base_m: 0.0,
        count,
        rise_m,
        going_m: FLIGHT_M[1],
        rises_m: Vec::new(),
        goings_m: Vec::new(),
        nosing_m: 0.0,
        nosing_radius_m: 0.003,
        chamfered: false,
        batter_m: 0.0,
        strip_m: 0.0,
        strip_proud_m: 0.0,
        strip_material: None,
        tread_thickness_m: SLAB_M,
        open: false,
        tread_depth_m: None,
        tread_fall: 0.0,
        channel_m: 0.0,
        channel_flange_m: 0.03,
        channel_open: false,
        landing_m: BEYOND_M,
        material: material.into(),
        riser_material: riser,
        width_m: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use host_sim::sweeps::{hazards, truth};

    /// The bodies stand at the given place, and are the hazards that they are named after.
    #[test]
    fn a_body_is_the_first_hazard_of_its_scene() {
        for body in Body::STANDARD {
            let mut spec = SceneSpec::default();
            body.place(&mut spec, 0.8, "concrete");
            let first = truth::first(&hazards::of(&spec), 0.0).unwrap();
            assert!((first.at_m - 0.8).abs() < 1e-9, "{body:?} {first:?}");
            assert_eq!(Some(first.kind), body.ending(), "{body:?}");
        }
    }

    #[test]
    fn level_ground_has_no_hazard() {
        let mut spec = SceneSpec::default();
        Body::Level.place(&mut spec, 1.0, "carpet");
        assert_eq!(truth::first(&hazards::of(&spec), 0.0), None);
    }
}
