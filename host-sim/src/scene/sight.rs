//! Obstruction of straight lines of sight, in the plane and by posts beside it.

use super::geometry::World;
use super::maths::Vec2;

/// The blocked part of a line of sight to a scatterer. An object that reaches across the whole beam blocks all of the
/// scatterer's columns, a post or narrow box only the columns in its shadow.
#[derive(Clone, Debug, Default)]
pub struct Shade {
    full: bool,
    strips: Vec<(f64, f64)>,
}

impl Shade {
    /// Returns whether all columns are blocked.
    pub fn is_full(&self) -> bool {
        self.full
    }

    /// Returns whether the ray to the column at `z` metres beside the plane is blocked.
    pub fn covers(&self, z: f64) -> bool {
        self.full || self.strips.iter().any(|&(low, high)| z > low && z < high)
    }
}

/// Fraction of a ray's length at either end within which crossings are ignored: they belong to the surfaces on which
/// the ray starts and ends.
const GRAZE: f64 = 1e-6;

/// Returns the shade on the way from `from` to `to`. `scale` gives the lateral offset of a ray at its start and at its
/// end per unit of the column's offset: `(0, 1)` for rays that leave the mirror's centre.
///
/// Segments `skip` (indices) are those on which the ray starts or ends; they do not block it.
pub fn shade(world: &World, from: Vec2, to: Vec2, scale: (f64, f64), skip: [usize; 2]) -> Shade {
    let mut shade = Shade::default();
    for (index, segment) in world.segments.iter().enumerate() {
        if skip.contains(&index) {
            continue;
        }
        let Some(t) = segment.crossing(from, to) else {
            continue;
        };
        if !(GRAZE..=1.0 - GRAZE).contains(&t) {
            continue;
        }
        let lateral = segment.lateral;
        let beside = scale.0 + (scale.1 - scale.0) * t;
        if !lateral.half.is_finite() {
            shade.full = true;
            return shade;
        }
        if beside > 0.0 {
            let (low, high) = (lateral.centre - lateral.half, lateral.centre + lateral.half);
            shade.strips.push((low / beside, high / beside));
        }
    }
    shade
}

/// Returns whether the point `to`, which lies on a surface in the swept plane, is visible from `from`, the mirror's
/// centre.
pub fn visible(world: &World, from: Vec2, to: Vec2) -> bool {
    let (to, aside) = world.place(to);
    // A ray that ends just short of the point does not hit the surface on which the point lies.
    let short = to.towards(from, 1e-4);
    !shade(world, from, short, (0.0, 1.0), [usize::MAX; 2]).covers(aside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::geometry::{Lateral, Skin};

    fn world(lateral: Lateral) -> World {
        let mut world = World::default();
        let skin = Skin {
            material: 0,
            lateral,
        };
        let points = [Vec2::new(1.0, -1.0), Vec2::new(1.0, 1.0)];
        world.outline(&points, false, |_| skin);
        world
    }

    const EYE: Vec2 = Vec2::new(0.0, 0.0);

    #[test]
    fn a_wall_hides_what_is_behind_it_and_not_itself() {
        let world = world(Lateral::WIDE);
        assert!(!visible(&world, EYE, Vec2::new(2.0, 0.0)));
        assert!(visible(&world, EYE, Vec2::new(1.0, 0.3)));
        assert!(visible(&world, EYE, Vec2::new(2.0, 2.5)), "over its top");
    }

    #[test]
    fn a_post_casts_a_shadow_as_wide_as_the_intercept_theorem_says() {
        let world = world(Lateral::of(Some(0.04), 0.01));
        let shade = shade(
            &world,
            EYE,
            Vec2::new(2.0, 0.0),
            (0.0, 1.0),
            [usize::MAX; 2],
        );
        assert!(!shade.is_full());
        assert!(shade.covers(0.05) && shade.covers(-0.01));
        assert!(!shade.covers(0.07) && !shade.covers(-0.03));
    }
}
