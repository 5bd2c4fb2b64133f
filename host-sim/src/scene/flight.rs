//! Flights of stairs as segments: treads, risers, nosings, channels, and the steps of the ground
//! truth.

use super::geometry::{BuiltStep, Lateral, Skin, World, chamfered, rounded};
use super::maths::Vec2;
use super::spec::{StairsSpec, Way};

/// Function that returns the index of a material by its name. The names are checked before shapes are built.
pub type Lookup<'a> = &'a dyn Fn(&str) -> usize;

/// Unit vectors of the level direction forwards and of the upright directions.
const FORWARD: Vec2 = Vec2::new(1.0, 0.0);
const UP: Vec2 = Vec2::new(0.0, 1.0);
const DOWN: Vec2 = Vec2::new(0.0, -1.0);

/// Thickness of a channel's web and flanges, metres: hot-rolled U sections of 30 to 80 mm have 4 to
/// 7 mm (EN 10279), folded ones 3 to 5.
pub const CHANNEL_WALL: f64 = 0.004;

/// Width of the gap between a channel and the tread behind it, which are welded together, metres.
const CHANNEL_GAP: f64 = 0.002;

/// One step of a flight: distance of its foremost edge from the mirror, height of its tread (going down: of the surface
/// before the drop), and its rise, metres.
#[derive(Clone, Copy)]
struct Tread {
    edge: f64,
    height: f64,
    rise: f64,
}

/// Returns the steps of a flight in order: foremost edge and height of every tread (up) or of every surface before a
/// drop (down).
fn treads(s: &StairsSpec) -> Vec<Tread> {
    let (mut edge, mut height) = (s.distance_m, s.base_m);
    (0..s.count)
        .map(|k| {
            let rise = s.rises_m.get(k).copied().unwrap_or(s.rise_m);
            if k > 0 {
                edge += s.goings_m.get(k - 1).copied().unwrap_or(s.going_m);
            }
            let before = height;
            height += if s.direction == Way::Up { rise } else { -rise };
            let top = if s.direction == Way::Up {
                height
            } else {
                before
            };
            Tread {
                edge,
                height: top,
                rise,
            }
        })
        .collect()
}

/// Adds the surfaces of a flight to `world`, and its steps to the truth; `material` returns a material's index.
pub fn stairs(world: &mut World, s: &StairsSpec, material: Lookup) {
    let steps = treads(s);
    let tread = material(&s.material);
    let riser = s.riser_material.as_deref().map_or(tread, material);
    let lateral = Lateral::of(s.width_m, 0.0);
    let strip = s.strip_material.as_deref().map_or(tread, material);
    let flight = Flight {
        spec: s,
        tread: Skin {
            material: tread,
            lateral,
        },
        riser: Skin {
            material: riser,
            lateral,
        },
        strip: Skin {
            material: strip,
            lateral,
        },
    };
    match (s.direction, s.open) {
        (Way::Up, false) => flight.closed_up(world, &steps),
        (Way::Up, true) => flight.open_up(world, &steps),
        (Way::Down, false) => flight.closed_down(world, &steps),
        (Way::Down, true) => flight.open_down(world, &steps),
    }
    flight.truth(world, &steps);
}

struct Flight<'a> {
    spec: &'a StairsSpec,
    tread: Skin,
    riser: Skin,
    strip: Skin,
}

impl Flight<'_> {
    /// Returns the thickness of the overhanging part of a tread at a step of height `rise`, metres.
    fn thickness(&self, rise: f64) -> f64 {
        self.spec.tread_thickness_m.min(0.6 * rise)
    }

    /// Returns the nosing radius at a step of height `rise`, limited by the tread's thickness, metres.
    fn radius(&self, rise: f64) -> f64 {
        self.spec.nosing_radius_m.min(0.45 * self.thickness(rise))
    }

    /// Returns the points of the rounding or chamfer that replaces the corner `at` between the directions `into` and
    /// `out`.
    fn corner(&self, at: Vec2, into: Vec2, out: Vec2, rise: f64) -> Vec<Vec2> {
        let shape = if self.spec.chamfered {
            chamfered
        } else {
            rounded
        };
        shape(at, into, out, self.radius(rise))
    }

    /// Adds to `points` the underside of the nosing, the foremost edge and the nosing strip, from below upwards as for
    /// a flight going up, and to `skins` the skin of each piece.
    fn front(&self, step: Tread, points: &mut Vec<Vec2>, skins: &mut Vec<Skin>) {
        let s = self.spec;
        let edge = Vec2::new(step.edge, step.height + s.strip_proud_m);
        if s.nosing_m > 0.0 {
            let under = step.height - self.thickness(step.rise);
            points.push(Vec2::new(step.edge + s.nosing_m, under));
            points.push(Vec2::new(step.edge, under));
            skins.extend([self.riser, self.tread]);
        }
        let face = if s.nosing_m > 0.0 {
            self.tread
        } else {
            self.riser
        };
        // From the foot of a battered riser to its upper edge.
        let into = if s.batter_m > 0.0 {
            Vec2::new(s.batter_m, step.rise + s.strip_proud_m).unit()
        } else {
            UP
        };
        let arc = self.corner(edge, into, FORWARD, step.rise);
        let edging = if s.strip_m > 0.0 {
            self.strip
        } else {
            self.tread
        };
        skins.push(face);
        skins.extend(core::iter::repeat_n(edging, arc.len() - 1));
        points.extend(arc);
        if s.strip_m > 0.0 {
            let back = step.edge + s.strip_m;
            points.push(Vec2::new(back, edge.y));
            skins.push(self.strip);
            if s.strip_proud_m > 0.0 {
                points.push(Vec2::new(back, step.height));
                skins.push(self.strip);
            }
        }
    }

    fn closed_up(&self, world: &mut World, steps: &[Tread]) {
        let s = self.spec;
        let (mut points, mut skins) = (Vec::new(), Vec::new());
        // The previous tread rises by its fall towards the foot of the next riser.
        let mut tread: Option<Tread> = None;
        let surface = |tread: Option<Tread>, x: f64| {
            tread.map_or(s.base_m, |t| t.height + s.tread_fall * (x - t.edge))
        };
        for &step in steps {
            let foot = step.edge + s.nosing_m - s.batter_m;
            points.push(Vec2::new(foot, surface(tread, foot)));
            // The piece that ends here is the previous tread; the first step has none.
            if points.len() > 1 {
                skins.push(self.tread);
            }
            self.front(step, &mut points, &mut skins);
            tread = Some(step);
        }
        if let Some(last) = steps.last() {
            let end = last.edge + s.landing_m;
            points.push(Vec2::new(end, surface(tread, end)));
            skins.push(self.tread);
        }
        self.emit(world, &points, false, &skins);
    }

    fn closed_down(&self, world: &mut World, steps: &[Tread]) {
        let s = self.spec;
        let Some(first) = steps.first() else { return };
        let start = (first.edge - 1.5).min(-1.0);
        let mut points = vec![Vec2::new(start, s.base_m)];
        let mut skins = Vec::new();
        for &step in steps {
            let edge = Vec2::new(step.edge, step.height);
            let arc = self.corner(edge, FORWARD, DOWN, step.rise);
            skins.extend(core::iter::repeat_n(self.tread, arc.len()));
            points.extend(arc);
            if s.nosing_m > 0.0 {
                let under = step.height - self.thickness(step.rise);
                points.push(Vec2::new(step.edge, under));
                points.push(Vec2::new(step.edge - s.nosing_m, under));
                skins.extend([self.tread, self.tread]);
            }
            points.push(Vec2::new(step.edge - s.nosing_m, step.height - step.rise));
            skins.push(self.riser);
        }
        if let Some(last) = steps.last() {
            points.push(Vec2::new(last.edge + s.landing_m, last.height - last.rise));
            skins.push(self.tread);
        }
        self.emit(world, &points, false, &skins);
    }

    fn open_up(&self, world: &mut World, steps: &[Tread]) {
        let s = self.spec;
        let depth = s.tread_depth_m.unwrap_or(s.going_m + 0.02);
        for (k, &step) in steps.iter().enumerate() {
            let long = if k + 1 == steps.len() {
                depth.max(s.landing_m)
            } else {
                depth
            };
            let back = step.edge + long;
            if s.channel_m > 0.0 {
                self.channel(world, step);
                let behind = step.edge + s.channel_flange_m + CHANNEL_GAP;
                self.slab(world, (behind, back), step.height, step.rise);
            } else {
                self.slab(world, (step.edge, back), step.height, step.rise);
            }
        }
    }

    /// Adds the channel before a floating tread: web and two flanges with sharp edges.
    fn channel(&self, world: &mut World, step: Tread) {
        let s = self.spec;
        let (top, bottom) = (step.height, step.height - s.channel_m);
        let wall = CHANNEL_WALL;
        // x is measured along the flanges from the web outwards.
        let profile = [
            (0.0, top),
            (s.channel_flange_m, top),
            (s.channel_flange_m, top - wall),
            (wall, top - wall),
            (wall, bottom + wall),
            (s.channel_flange_m, bottom + wall),
            (s.channel_flange_m, bottom),
            (0.0, bottom),
        ];
        let points = profile.map(|(x, y)| {
            let along = if s.channel_open {
                s.channel_flange_m - x
            } else {
                x
            };
            Vec2::new(step.edge + along, y)
        });
        let skins = vec![self.riser; points.len()];
        self.emit(world, &points, true, &skins);
    }

    fn open_down(&self, world: &mut World, steps: &[Tread]) {
        let s = self.spec;
        let depth = s.tread_depth_m.unwrap_or(s.going_m + 0.02);
        for (k, &step) in steps.iter().enumerate() {
            let back = if k == 0 {
                (step.edge - 1.5).min(-1.0)
            } else {
                step.edge - depth
            };
            self.slab(world, (back, step.edge), step.height, step.rise);
        }
        if let Some(last) = steps.last() {
            let lower = last.height - last.rise;
            let points = [
                Vec2::new(last.edge - depth, lower),
                Vec2::new(last.edge + s.landing_m, lower),
            ];
            self.emit(world, &points, false, &[self.tread]);
        }
    }

    /// Adds a floating tread with both upper edges rounded.
    fn slab(&self, world: &mut World, (front, back): (f64, f64), top: f64, rise: f64) {
        let under = top - self.thickness(rise);
        let mut points = vec![Vec2::new(front, under)];
        points.extend(self.corner(Vec2::new(front, top), UP, FORWARD, rise));
        let arc = points.len() - 1;
        points.extend(self.corner(Vec2::new(back, top), FORWARD, DOWN, rise));
        points.push(Vec2::new(back, under));
        let mut skins = vec![self.tread; points.len()];
        // Front and its rounding take the riser's material, because a floating tread has no riser.
        for skin in skins.iter_mut().take(arc) {
            *skin = self.riser;
        }
        self.emit(world, &points, true, &skins);
    }

    fn emit(&self, world: &mut World, points: &[Vec2], closed: bool, skins: &[Skin]) {
        world.outline(points, closed, |k| {
            skins.get(k).copied().unwrap_or(self.tread)
        });
    }

    fn truth(&self, world: &mut World, steps: &[Tread]) {
        let s = self.spec;
        for (k, step) in steps.iter().enumerate() {
            let lower = step.height - step.rise;
            let edge = Vec2::new(step.edge, step.height);
            if s.direction == Way::Up {
                let top = step.height + s.strip_proud_m;
                // A floating step has no surface but its tread.
                let foot = if s.open {
                    step.height - self.thickness(step.rise).max(s.channel_m)
                } else {
                    lower
                };
                world.up.push(BuiltStep {
                    distance: step.edge,
                    height: top,
                    rise: step.rise,
                    edge: Vec2::new(step.edge, top),
                    span: (foot, top),
                    below: None,
                });
                continue;
            }
            let end = steps.get(k + 1).map_or(step.edge + s.landing_m, |n| n.edge);
            world.down.push(BuiltStep {
                distance: step.edge,
                height: lower,
                rise: step.rise,
                edge,
                span: (lower, step.height),
                below: Some((Vec2::new(step.edge, lower), Vec2::new(end, lower))),
            });
        }
    }
}
