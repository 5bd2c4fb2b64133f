//! A scene as straight segments: built from the shapes of a scene file, and used by the scattering
//! code.

use super::maths::Vec2;

/// Extent of a surface across the plane that the mirror sweeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lateral {
    /// Offset of the surface's middle from the plane that the mirror sweeps, metres.
    pub centre: f64,
    /// Half of the surface's width, metres; infinite when the surface is wider than any beam.
    pub half: f64,
    /// Whether the surface is that of a round post: it recedes from its middle like a circle of radius `half`.
    pub round: bool,
}

impl Lateral {
    /// A surface wider than the beam.
    pub const WIDE: Self = Self {
        centre: 0.0,
        half: f64::INFINITY,
        round: false,
    };

    /// Creates an extent of `width` (`None`: wider than the beam) with its middle `centre` beside
    /// the plane.
    pub fn of(width: Option<f64>, centre: f64) -> Self {
        width.map_or(Self::WIDE, |w| Self {
            centre,
            half: 0.5 * w,
            round: false,
        })
    }

    /// Returns the distance at which the surface at `z` metres beside the plane lies behind its foremost line, metres;
    /// 0 unless it is round.
    pub fn recess(&self, z: f64) -> f64 {
        if !self.round {
            return 0.0;
        }
        let off = z - self.centre;
        self.half - (self.half * self.half - off * off).max(0.0).sqrt()
    }
}

/// A straight piece of surface. The solid lies to the right of the direction from `a` to `b`.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Start point in the plane that the mirror sweeps, metres.
    pub a: Vec2,
    /// End point in the plane that the mirror sweeps, metres.
    pub b: Vec2,
    /// Index of the segment's material.
    pub material: usize,
    /// Extent of the segment across the plane that the mirror sweeps.
    pub lateral: Lateral,
    /// Whether the segment is a thin sheet, visible from both sides.
    pub sheet: bool,
    /// Length of the outline from its start to this segment, metres. Joints and roughness continue from segment to
    /// segment.
    pub start: f64,
    /// Index of the outline to which the segment belongs.
    pub outline: usize,
}

impl Segment {
    /// Returns the segment's length, metres.
    pub fn len(&self) -> f64 {
        (self.b - self.a).len()
    }

    /// Returns the unit vector from start to end.
    pub fn direction(&self) -> Vec2 {
        (self.b - self.a).unit()
    }

    /// Returns the unit normal of the free side, to the left of the direction from start to end.
    pub fn normal(&self) -> Vec2 {
        self.direction().left()
    }

    /// Returns the fraction (0…1) of the way from `p` to `q` at which the segment crosses it, ends included; `None`
    /// where it does not.
    pub fn crossing(&self, p: Vec2, q: Vec2) -> Option<f64> {
        let (way, along) = (q - p, self.b - self.a);
        let det = way.cross(along);
        if det == 0.0 {
            return None;
        }
        let to = self.a - p;
        let t = to.cross(along) / det;
        let s = to.cross(way) / det;
        ((0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&s)).then_some(t)
    }
}

/// A sharp convex edge, which needs a correction of physical optics.
#[derive(Clone, Copy, Debug)]
pub struct Wedge {
    /// Place of the edge in the plane that the mirror sweeps, metres.
    pub at: Vec2,
    /// Direction of the edge's first face, away from the edge. Angles are measured from this direction, anticlockwise
    /// through free space.
    pub face: Vec2,
    /// Exterior angle, radians: 3π/2 for a square edge, 2π for a sheet's.
    pub exterior: f64,
    /// Index of the material of the edge's faces.
    pub material: usize,
    /// Extent of the edge across the plane that the mirror sweeps.
    pub lateral: Lateral,
}

/// A step as built, for the ground truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuiltStep {
    /// Distance of the step's foremost edge from the mirror, as the recording format defines it, metres.
    pub distance: f64,
    /// Height of the step, as the recording format defines it, metres.
    pub height: f64,
    /// Height of the step's riser, metres.
    pub rise: f64,
    /// The step's foremost edge in the plane, metres, which must lie in sight and within the scan's ranges and angles.
    pub edge: Vec2,
    /// Heights of the lowest and the highest point of the step's own surfaces, metres.
    pub span: (f64, f64),
    /// For a step down: start and end of the surface after the drop, of which one point must be in
    /// sight.
    pub below: Option<(Vec2, Vec2)>,
}

/// Surfaces, edges and steps of a scene.
#[derive(Clone, Debug, Default)]
pub struct World {
    /// Straight pieces of all surfaces.
    pub segments: Vec<Segment>,
    /// Sharp convex edges of the surfaces, which diffract.
    pub wedges: Vec<Wedge>,
    /// Steps going up.
    pub up: Vec<BuiltStep>,
    /// Steps going down.
    pub down: Vec<BuiltStep>,
    /// Fronts of boxes, as steps that do not count because a chair cannot mount them.
    pub boxes: Vec<BuiltStep>,
    /// Heading of the scanner relative to the perpendicular of the edges, radians.
    pub yaw: f64,
    outlines: usize,
}

/// Minimum turn between two segments at a sharp corner, radians. Smaller turns are part of a curve, whose facets need
/// no edge of their own.
const SHARP: f64 = 0.5;

/// Material and lateral extent of an outline.
#[derive(Clone, Copy, Debug)]
pub struct Skin {
    /// Index of the surface's material.
    pub material: usize,
    /// Extent of the surface across the plane that the mirror sweeps.
    pub lateral: Lateral,
}

impl World {
    /// Adds an outline whose solid lies to the right of its direction. A closed outline may have
    /// either direction.
    pub fn outline(&mut self, points: &[Vec2], closed: bool, skins: impl Fn(usize) -> Skin) {
        let mut points = points.to_vec();
        if closed {
            if area(&points) > 0.0 {
                points.reverse();
            }
            points.extend(points.first().copied());
        }
        self.pieces(&points, false, &skins);
        let last = points.len() - 1;
        for k in 1..last {
            self.convex(points[k - 1], points[k], points[k + 1], skins(k));
        }
        if closed {
            self.convex(points[last - 1], points[0], points[1], skins(0));
        }
    }

    /// Adds a thin sheet along `points`.
    pub fn sheet(&mut self, points: &[Vec2], skin: Skin) {
        self.pieces(points, true, &|_| skin);
        let n = points.len();
        for (end, next) in [(points[0], points[1]), (points[n - 1], points[n - 2])] {
            self.wedges.push(Wedge {
                at: end,
                face: (next - end).unit(),
                exterior: core::f64::consts::TAU,
                material: skin.material,
                lateral: skin.lateral,
            });
        }
    }

    /// Turns the scanner by `yaw` radians about the vertical through its mirror.
    ///
    /// Surfaces stay at right angles to the plane of the profile, so that images and shadows do not
    /// change; the beam looks obliquely. Lengths were given in the plane that the mirror sweeps.
    /// Across the edges they are shorter by the cosine, and points of that plane now lie aside.
    /// Steps keep their distance in the plane that the mirror sweeps, in which they are reported.
    pub fn turn(&mut self, yaw: f64) {
        if yaw == 0.0 {
            return;
        }
        self.yaw = yaw;
        let (sin, cos) = libm::sincos(yaw);
        for s in &mut self.segments {
            s.lateral.centre += 0.5 * (s.a.x + s.b.x) * sin;
            s.a.x *= cos;
            s.b.x *= cos;
        }
        for w in &mut self.wedges {
            w.lateral.centre += w.at.x * sin;
            w.at.x *= cos;
            w.face = Vec2::new(w.face.x * cos, w.face.y).unit();
        }
    }

    /// Returns the world as seen from a chair that has come `travel` metres nearer.
    pub fn moved(&self, travel: f64) -> Self {
        let mut world = self.clone();
        let (ahead, across) = (
            Vec2::new(travel, 0.0),
            Vec2::new(travel * libm::cos(self.yaw), 0.0),
        );
        for s in &mut world.segments {
            (s.a, s.b) = (s.a - across, s.b - across);
        }
        for w in &mut world.wedges {
            w.at = w.at - across;
        }
        let World {
            up, down, boxes, ..
        } = &mut world;
        for step in up.iter_mut().chain(down).chain(boxes) {
            step.distance -= travel;
            step.edge = step.edge - ahead;
            step.below = step.below.map(|(from, to)| (from - ahead, to - ahead));
        }
        world
    }

    /// Returns the place in the profile of the point `p` of the plane that the mirror sweeps, and
    /// its lateral offset, metres.
    pub fn place(&self, p: Vec2) -> (Vec2, f64) {
        let (sin, cos) = libm::sincos(self.yaw);
        (Vec2::new(p.x * cos, p.y), p.x * sin)
    }

    fn pieces(&mut self, points: &[Vec2], sheet: bool, skins: &dyn Fn(usize) -> Skin) {
        let mut start = 0.0;
        for (k, pair) in points.windows(2).enumerate() {
            let skin = skins(k);
            let segment = Segment {
                a: pair[0],
                b: pair[1],
                material: skin.material,
                lateral: skin.lateral,
                sheet,
                start,
                outline: self.outlines,
            };
            if segment.len() > 0.0 {
                start += segment.len();
                self.segments.push(segment);
            }
        }
        self.outlines += 1;
    }

    /// Adds the edge at `at` between the segment that comes from `before` and the one that goes to `after`, if it is
    /// sharp and convex.
    fn convex(&mut self, before: Vec2, at: Vec2, after: Vec2, skin: Skin) {
        let (along, onward) = ((at - before).unit(), (after - at).unit());
        let turn = libm::atan2(onward.cross(along), along.dot(onward));
        if turn > SHARP {
            self.wedges.push(Wedge {
                at,
                face: onward,
                exterior: core::f64::consts::PI + turn,
                material: skin.material,
                lateral: skin.lateral,
            });
        }
    }
}

/// Returns twice the signed area of a polygon, positive when the points run anticlockwise.
fn area(points: &[Vec2]) -> f64 {
    let Some(&last) = points.last() else {
        return 0.0;
    };
    let mut before = last;
    points.iter().fold(0.0, |sum, &p| {
        let part = before.cross(p);
        before = p;
        sum + part
    })
}

/// Maximum radius whose chords may span a sixth of a radian, metres. They stay within 28 µm of the
/// arc: a tenth of a radian of two-way phase at 94 GHz. Larger radii get more chords.
const COARSE: f64 = 0.008;

/// Returns the arc that replaces the sharp convex corner `at` between the directions `into` and
/// `out`, turning right. Its chords are at most a sixth of the radius long.
pub fn rounded(at: Vec2, into: Vec2, out: Vec2, radius: f64) -> Vec<Vec2> {
    if radius <= 0.0 {
        return vec![at];
    }
    let turn = libm::atan2(out.cross(into), into.dot(out));
    let back = radius * libm::tan(0.5 * turn);
    let first = at - into * back;
    let centre = first - into.left() * radius;
    let finer = (radius / COARSE).max(1.0).sqrt();
    let pieces = libm::ceil(turn * 6.0 * finer).max(2.0) as usize;
    (0..=pieces)
        .map(|k| {
            let (s, c) = libm::sincos(turn * k as f64 / pieces as f64);
            centre + into.left() * (radius * c) + into * (radius * s)
        })
        .collect()
}

/// Returns the two ends of a chamfer at the corner between the directions `into` and `out`, each `depth` metres from
/// the sharp corner `at`.
pub fn chamfered(at: Vec2, into: Vec2, out: Vec2, depth: f64) -> Vec<Vec2> {
    if depth <= 0.0 {
        return vec![at];
    }
    vec![at - into * depth, at + out * depth]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SKIN: Skin = Skin {
        material: 0,
        lateral: Lateral::WIDE,
    };

    fn square(clockwise: bool) -> Vec<Vec2> {
        let mut points = vec![
            Vec2::new(1.0, 0.0),
            Vec2::new(1.0, 0.2),
            Vec2::new(1.3, 0.2),
            Vec2::new(1.3, 0.0),
        ];
        if !clockwise {
            points.reverse();
        }
        points
    }

    #[test]
    fn a_solid_shows_its_outside_whichever_way_it_is_drawn() {
        for clockwise in [true, false] {
            let mut world = World::default();
            world.outline(&square(clockwise), true, |_| SKIN);
            let middle = Vec2::new(1.15, 0.1);
            assert_eq!(world.segments.len(), 4);
            for s in &world.segments {
                assert!(s.normal().dot(s.a - middle) > 0.0);
            }
            assert_eq!(world.wedges.len(), 4);
            for w in &world.wedges {
                assert!((w.exterior - 1.5 * core::f64::consts::PI).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_rounded_corner_touches_both_faces() {
        let (up, forward) = (Vec2::new(0.0, 1.0), Vec2::new(1.0, 0.0));
        let arc = rounded(Vec2::new(0.0, 0.0), up, forward, 0.003);
        let (first, last) = (arc[0], arc[arc.len() - 1]);
        assert!((first - Vec2::new(0.0, -0.003)).len() < 1e-12);
        assert!((last - Vec2::new(0.003, 0.0)).len() < 1e-12);
        let centre = Vec2::new(0.003, -0.003);
        assert!(
            arc.iter()
                .all(|p| ((*p - centre).len() - 0.003).abs() < 1e-12)
        );
    }

    #[test]
    fn an_inner_corner_is_no_edge() {
        let mut world = World::default();
        let points = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.2), (1.5, 0.2)].map(|(x, y)| Vec2::new(x, y));
        world.outline(&points, false, |_| SKIN);
        assert_eq!(world.wedges.len(), 1);
        assert_eq!(world.wedges[0].at, points[2]);
    }
}
