//! A scene as straight segments: what the shapes of a scene file become, and what the physics reads.

use super::maths::Vec2;

/// How far a surface reaches across the plane that the mirror sweeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lateral {
    /// Middle of the surface, metres beside the plane.
    pub centre: f64,
    /// Half its width; infinite when it is wider than any beam.
    pub half: f64,
    /// A round post: its surface recedes from its middle like a circle of radius `half`.
    pub round: bool,
}

impl Lateral {
    /// Wider than the beam.
    pub const WIDE: Self = Self {
        centre: 0.0,
        half: f64::INFINITY,
        round: false,
    };

    /// `width` wide (or wider than the beam), its middle `centre` beside the plane.
    pub fn of(width: Option<f64>, centre: f64) -> Self {
        width.map_or(Self::WIDE, |w| Self {
            centre,
            half: 0.5 * w,
            round: false,
        })
    }

    /// How far the surface at `z` lies behind its foremost line.
    pub fn recess(&self, z: f64) -> f64 {
        if !self.round {
            return 0.0;
        }
        let off = z - self.centre;
        self.half - (self.half * self.half - off * off).max(0.0).sqrt()
    }
}

/// A straight piece of surface; the solid lies to the right of the way from `a` to `b`.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Start.
    pub a: Vec2,
    /// End.
    pub b: Vec2,
    /// Index of its material.
    pub material: usize,
    /// Extent across the plane.
    pub lateral: Lateral,
    /// A thin sheet, seen from both sides.
    pub sheet: bool,
    /// Metres of the same outline before its start: joints and roughness run on from piece to piece.
    pub start: f64,
    /// Outline that it belongs to.
    pub outline: usize,
}

impl Segment {
    /// Length.
    pub fn len(&self) -> f64 {
        (self.b - self.a).len()
    }

    /// Direction from start to end.
    pub fn direction(&self) -> Vec2 {
        (self.b - self.a).unit()
    }

    /// The free side's normal.
    pub fn normal(&self) -> Vec2 {
        self.direction().left()
    }

    /// Where on the way from `p` to `q` (0…1) the segment is crossed, ends included.
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

/// A sharp convex edge, whose diffraction physical optics alone gets wrong.
#[derive(Clone, Copy, Debug)]
pub struct Wedge {
    /// Where it is.
    pub at: Vec2,
    /// Along its first face, away from the edge. Angles count from there, anticlockwise through the
    /// free space.
    pub face: Vec2,
    /// Exterior angle, radians: 3π/2 for a square edge, 2π for a sheet's.
    pub exterior: f64,
    /// Index of its material.
    pub material: usize,
    /// Extent across the plane.
    pub lateral: Lateral,
}

/// A step as it is built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuiltStep {
    /// Distance of the edge that counts, as the recording format defines it.
    pub distance: f64,
    /// Height that counts, as the recording format defines it.
    pub height: f64,
    /// Height of its riser.
    pub rise: f64,
    /// The step's foremost edge: the point that must be in sight, range and angles.
    pub edge: Vec2,
    /// Lowest and highest point of the step's own surfaces.
    pub span: (f64, f64),
    /// Of a step down: the surface after the drop, from and to; one of its points must be in sight.
    pub below: Option<(Vec2, Vec2)>,
}

/// All that the radar can see.
#[derive(Clone, Debug, Default)]
pub struct World {
    /// Surfaces.
    pub segments: Vec<Segment>,
    /// Sharp edges.
    pub wedges: Vec<Wedge>,
    /// Steps going up.
    pub up: Vec<BuiltStep>,
    /// Steps going down.
    pub down: Vec<BuiltStep>,
    /// Fronts of boxes that no chair could mount.
    pub boxes: Vec<BuiltStep>,
    /// Heading of the scanner against the perpendicular of the edges, radians.
    pub yaw: f64,
    outlines: usize,
}

/// A corner that turns by less is part of a curve, whose facets need no edge of their own.
const SHARP: f64 = 0.5;

/// How an outline's surface is made and how far it reaches.
#[derive(Clone, Copy, Debug)]
pub struct Skin {
    /// Index of its material.
    pub material: usize,
    /// Extent across the plane.
    pub lateral: Lateral,
}

impl World {
    /// Adds an outline whose solid lies to the right of its way; a closed one may run either way.
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

    /// Adds a thin sheet.
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
    /// Surfaces keep running at right angles to the plane of the profile, so that images and shadows stay
    /// as they are; it is the beam that looks aslant. Lengths were given in the plane that the mirror
    /// sweeps: across the edges they are shorter by the cosine, and what lay in that plane now lies
    /// aside. Steps keep their place in the plane that the mirror sweeps, where they are reported.
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

    /// The same world from a chair that has come `travel` metres nearer.
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

    /// The point that lies at `p` in the plane that the mirror sweeps: its place in the profile, and how
    /// far aside.
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

    /// Adds the edge at `at` between the pieces from `before` and to `after` if it is sharp and convex.
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

/// Twice the signed area, positive when the points run anticlockwise.
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

/// Largest radius whose chords may span a sixth of a radian: they then keep within 28 µm of the arc, a
/// tenth of a radian of phase at 94 GHz out and back. Larger ones get more chords.
const COARSE: f64 = 0.008;

/// A rounded convex corner from the direction `into` to the direction `out`, turning right, in place
/// of the sharp corner `at`: points of the arc, chords no longer than a sixth of the radius.
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

/// A corner broken off in place of rounded: the two ends of the chamfer, each `depth` from the sharp corner `at`.
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
