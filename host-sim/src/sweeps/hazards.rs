//! Hazards of a scene: places that a chair must not drive into or over, as far as a beam along the
//! ground can detect them.
//!
//! A scene in, distances with kinds out, by geometry alone. The truth of full scans
//! ([`crate::scene::truth`]) does not serve here: it lists the steps that a scan must report, but
//! neither walls, legs and boxes nor the end of the ground.

use stairscan::verdict::HazardKind;

use super::truth::Hazard;
use crate::scene::spec::{BoxSpec, DoorSpec, PolylineSpec, SceneSpec, StairsSpec, Way};

/// Minimum height of a rise, and minimum depth of a drop, that is a hazard, metres: the guard's
/// contract.
const MIN_HEIGHT_M: f64 = 0.04;
/// Maximum distance to the side between the swept plane and the nearest part of an object that is
/// still in the beam, metres. The beam of 5° (two-way) lights 4 cm to either side at 1 m.
const ASIDE_M: f64 = 0.08;
/// Maximum height of a box's top at which the box counts as a rise, metres. A higher single step
/// cannot be climbed and is an obstacle.
const MAX_RISE_M: f64 = 0.30;
/// End of a floor for which the scene gives no end, metres from the mirror: as in scene files.
const FLOOR_END_M: f64 = 4.0;

/// A scene and the width of the guard's beam, for tests whether the scene's objects are in the
/// beam.
struct Beam<'a> {
    spec: &'a SceneSpec,
    /// Maximum distance to the side between the swept plane and the nearest part of an object that
    /// is still in the beam, metres.
    aside_m: f64,
}

impl Beam<'_> {
    /// Whether an object whose middle lies `lateral_m` metres beside the swept plane is in the
    /// beam, at any yaw. An object without a width is.
    fn meets(&self, lateral_m: f64, width_m: Option<f64>) -> bool {
        width_m.is_none_or(|width| lateral_m.abs() - 0.5 * width <= self.aside_m)
    }

    /// Whether an object from `bottom_m` to `top_m` high (metres above the ground) is high enough
    /// for a hazard and begins below the mirror. No row looks above the mirror.
    fn reaches(&self, bottom_m: f64, top_m: f64) -> bool {
        top_m > MIN_HEIGHT_M && bottom_m < self.spec.mount.height_m
    }

    fn solid(&self, b: &BoxSpec) -> Option<Hazard> {
        let there = self.meets(b.lateral_m, b.width_m) && self.reaches(b.bottom_m, b.top_m);
        let stands = b.bottom_m < MIN_HEIGHT_M && b.top_m <= MAX_RISE_M;
        there.then_some(Hazard {
            at_m: b.from_m,
            kind: if stands {
                HazardKind::Rise
            } else {
                HazardKind::Obstacle
            },
        })
    }

    /// Returns the hazard of a door: an obstacle if a jamb is in the beam, else a rise if its
    /// threshold is higher than 4 cm.
    fn door(&self, d: &DoorSpec) -> Option<Hazard> {
        let aside = 0.5 * (d.width_m + d.frame_m);
        let jamb = |side: f64| self.meets(d.lateral_m + side, Some(d.frame_m));
        let kind = match jamb(aside) || jamb(-aside) {
            true => HazardKind::Obstacle,
            false => HazardKind::Rise,
        };
        let found = kind == HazardKind::Obstacle || d.threshold_m > MIN_HEIGHT_M;
        found.then_some(Hazard { at_m: d.at_m, kind })
    }

    /// Returns the places at which a free shape (polyline) first rises above the ground, an
    /// obstacle, and first falls below it, a drop.
    fn shape(&self, p: &PolylineSpec) -> Vec<Hazard> {
        let mut pieces: Vec<_> = p.points.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        if let (true, Some(&last), Some(&first)) = (p.closed, p.points.last(), p.points.first()) {
            pieces.push([last, first]);
        }
        let nearest = |low: f64, high: f64| {
            let entries = pieces.iter().filter_map(|piece| within(*piece, low, high));
            entries.reduce(f64::min)
        };
        let up = nearest(MIN_HEIGHT_M, self.spec.mount.height_m)
            .map(|at_m| (at_m, HazardKind::Obstacle));
        let down = nearest(f64::NEG_INFINITY, -MIN_HEIGHT_M).map(|at_m| (at_m, HazardKind::Drop));
        let found = up.into_iter().chain(down);
        found
            .filter(|_| self.meets(p.lateral_m, p.width_m))
            .map(|(at_m, kind)| Hazard { at_m, kind })
            .collect()
    }
}

/// Returns all hazards of a scene, unordered, with distances from the mirror at the first row.
pub fn of(spec: &SceneSpec) -> Vec<Hazard> {
    within_m(spec, ASIDE_M)
}

/// Returns the hazards of a scene of which a part lies at most `aside_m` metres beside the swept
/// plane, unordered, with distances from the mirror at the first row.
pub fn within_m(spec: &SceneSpec, aside_m: f64) -> Vec<Hazard> {
    let beam = Beam { spec, aside_m };
    let obstacle = |at_m| Hazard {
        at_m,
        kind: HazardKind::Obstacle,
    };
    let mut found: Vec<Hazard> = spec.stairs.iter().filter_map(edge).collect();
    let walls = spec
        .wall
        .iter()
        .filter(|w| beam.reaches(w.bottom_m, w.top_m));
    found.extend(walls.map(|w| obstacle(w.at_m)));
    let posts = spec.post.iter().filter(|p| {
        beam.meets(p.lateral_m, Some(p.diameter_m)) && beam.reaches(p.bottom_m, p.top_m)
    });
    found.extend(posts.map(|p| obstacle(p.at_m - 0.5 * p.diameter_m)));
    found.extend(spec.boxes.iter().filter_map(|b| beam.solid(b)));
    found.extend(spec.door.iter().filter_map(|d| beam.door(d)));
    found.extend(spec.polyline.iter().flat_map(|p| beam.shape(p)));
    found.push(Hazard {
        at_m: ground_end_m(spec),
        kind: HazardKind::Drop,
    });
    found
}

/// Returns the first step of a flight that is too high or too deep to drive over.
fn edge(s: &StairsSpec) -> Option<Hazard> {
    let part = |list: &[f64], k: usize, all: f64| list.get(k).copied().unwrap_or(all);
    let mut at_m = s.distance_m;
    for k in 0..s.count {
        if part(&s.rises_m, k, s.rise_m) > MIN_HEIGHT_M {
            let kind = match s.direction {
                Way::Up => HazardKind::Rise,
                Way::Down => HazardKind::Drop,
            };
            return Some(Hazard { at_m, kind });
        }
        at_m += part(&s.goings_m, k, s.going_m);
    }
    None
}

/// Returns the distance at which a scene's last surface ends, metres.
fn ground_end_m(spec: &SceneSpec) -> f64 {
    let flight = |s: &StairsSpec| {
        let goings = (1..s.count).map(|k| s.goings_m.get(k - 1).copied().unwrap_or(s.going_m));
        s.distance_m + goings.sum::<f64>() + s.landing_m
    };
    let floors = spec.floor.iter().map(|f| f.to_m);
    let open = floors.clone().any(|to_m| to_m.is_none()) && spec.stairs.is_empty();
    let shapes = spec.polyline.iter().filter(|p| p.width_m.is_none());
    let ends = (floors.flatten())
        .chain(spec.ramp.iter().map(|r| r.to_m))
        .chain(spec.stairs.iter().map(flight))
        .chain(shapes.flat_map(|p| p.points.iter().map(|point| point[0])))
        .chain(open.then_some(FLOOR_END_M));
    ends.fold(f64::NEG_INFINITY, f64::max)
}

/// Returns the minimum x of the points of a straight piece (two end points `[x, height]`, metres)
/// that are above `low` and below `high`; `None` if there is none.
fn within(piece: [[f64; 2]; 2], low: f64, high: f64) -> Option<f64> {
    let [[x0, y0], [x1, y1]] = piece;
    let (bottom, top) = (y0.min(y1).max(low), y0.max(y1).min(high));
    if bottom >= top && !(y0 == y1 && low < y0 && y0 < high) {
        return None;
    }
    let at = |y: f64| match y1 - y0 {
        0.0 => x0.min(x1),
        rise => x0 + (x1 - x0) * (y - y0) / rise,
    };
    Some(at(bottom).min(at(top)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(text: &str) -> SceneSpec {
        let floor = "[[floor]]\nto_m = 3.5\nmaterial = \"concrete\"\n";
        toml::from_str(&format!("{floor}{text}")).unwrap()
    }

    /// Returns distance, metres, and kind of the nearest hazard of a scene file's text.
    fn first(text: &str) -> (f64, HazardKind) {
        let found = of(&scene(text));
        let nearest = found.iter().min_by(|a, b| a.at_m.total_cmp(&b.at_m));
        nearest.map(|h| (h.at_m, h.kind)).unwrap()
    }

    const END: (f64, HazardKind) = (3.5, HazardKind::Drop);

    #[test]
    fn level_ground_has_its_end_alone() {
        assert_eq!(first(""), END);
    }

    #[test]
    fn the_first_step_above_4_cm_counts() {
        let flight = |rises: &str, way: &str| {
            format!(
                "[[stairs]]\ndirection = \"{way}\"\ndistance_m = 1.0\ncount = 2\nrise_m = 0.1\nrises_m = {rises}\n\
                 going_m = 0.3\nmaterial = \"concrete\"\n"
            )
        };
        assert_eq!(first(&flight("[0.03, 0.1]", "up")), (1.3, HazardKind::Rise));
        assert_eq!(first(&flight("[0.1, 0.1]", "up")), (1.0, HazardKind::Rise));
        assert_eq!(
            first(&flight("[0.1, 0.1]", "down")),
            (1.0, HazardKind::Drop)
        );
    }

    #[test]
    fn things_beside_the_beam_or_above_the_mirror_do_not_count() {
        let thing = |lateral: f64, bottom: f64, top: f64| {
            format!(
                "[[box]]\nfrom_m = 0.8\nto_m = 1.0\nwidth_m = 0.2\nlateral_m = {lateral}\nbottom_m = {bottom}\n\
                 top_m = {top}\nmaterial = \"metal\"\n"
            )
        };
        assert_eq!(first(&thing(0.17, 0.0, 0.2)), (0.8, HazardKind::Rise));
        assert_eq!(first(&thing(0.17, 0.0, 0.5)), (0.8, HazardKind::Obstacle));
        assert_eq!(first(&thing(0.19, 0.0, 0.5)), END);
        assert_eq!(first(&thing(0.0, 0.45, 0.6)), END);
        assert_eq!(first(&thing(0.0, 0.0, 0.03)), END);
        let yaw = format!("{}\n[mount]\nyaw_deg = 3.0\n", thing(0.17, 0.0, 0.5));
        // The lateral distance is measured from the swept plane at any yaw.
        assert_eq!(first(&yaw), (0.8, HazardKind::Obstacle));
    }

    #[test]
    fn posts_count_from_their_front_and_doors_by_their_jambs() {
        let post = "[[post]]\nat_m = 1.0\ndiameter_m = 0.1\ntop_m = 0.9\nmaterial = \"fabric\"\n";
        assert_eq!(first(post), (0.95, HazardKind::Obstacle));
        let door = |lateral: f64| {
            format!("[[door]]\nat_m = 1.0\nlateral_m = {lateral}\nmaterial = \"metal\"\n")
        };
        assert_eq!(first(&door(0.0)), END);
        assert_eq!(first(&door(0.45)), (1.0, HazardKind::Obstacle));
    }

    #[test]
    fn shapes_count_where_they_leave_the_ground() {
        let shape =
            |points: &str| format!("[[polyline]]\npoints = {points}\nmaterial = \"concrete\"\n");
        // A wedge passes 4 cm halfway.
        let (at, kind) = first(&shape("[[1.0, 0.0], [1.2, 0.08], [1.4, 0.08]]"));
        assert!(
            (at - 1.1).abs() < 1e-9 && kind == HazardKind::Obstacle,
            "{at}"
        );
        assert_eq!(
            first(&shape("[[1.0, 0.0], [1.0, -0.2], [1.2, -0.2]]")),
            (1.0, HazardKind::Drop)
        );
        assert_eq!(first(&shape("[[1.0, 0.9], [2.0, 0.9]]")), END);
    }
}
