//! Physical optics: from facets and edges to the echoes that the radar receives.
//!
//! Every facet is a sheet of current that radiates coherently: -jΓk cos θ per metre in units of the
//! two-dimensional far field (Knott, Shaeffer, Tuley, Radar Cross Section, ch. 5). Its range sets
//! its phase, so that specular reflections, speckle, shadow edges and the fall-off with incidence
//! result from sums and need no assumptions. Inner corners come from the same facets, lit by the
//! image of the antenna in another surface (geometric optics for the first bounce, physical optics
//! for the second). Phases are e^{+jkr}.

use core::f64::consts::PI;

use num_complex::Complex64;

use super::edge;
use super::facets::{Facet, Relief};
use super::geometry::{Segment, Wedge};
use super::lateral::{Across, BLOCK, PATCH, Strip};
use super::material::Material;
use super::maths::{Random, Vec2, cis, power, sinc};
use super::scatterers::{SCATTERERS, Scatterers};
use super::sight::{Shade, shade};
use super::spec::{PlaneSpec, Polarisation};
use super::view::View;

/// Echo of one facet or edge, before weighting by the beam's pattern in the plane.
#[derive(Clone, Copy, Debug)]
pub struct Echo {
    /// Range from the mirror's centre, metres: half the length of the way out and back.
    pub range: f64,
    /// Complex amplitude √σ / (r₁ r₂), 1/m, which the radar equation's constant multiplies.
    pub amplitude: Complex64,
    /// Direction in which the wave leaves the mirror, as a mirror angle, radians.
    pub out: f64,
    /// Direction from which the wave comes back, as a mirror angle, radians.
    pub back: f64,
}

/// Source of the random scatterers that make the diffuse part of the echoes.
pub enum Diffuse<'a> {
    /// New scatterers for every facet, drawn from this generator.
    Fresh(&'a mut Random),
    /// Fixed scatterers drawn by this seed, whose sum changes as the chair moves.
    Steady(u64),
    /// Fixed scatterers of a cache, which keeps them once drawn.
    Kept(&'a Scatterers),
}

/// Interval of mirror angles that excludes no echo.
pub const EVERYWHERE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// Minimum length of a surface that mirrors the first of two bounces, metres: about half a Fresnel
/// zone.
const SHORTEST_MIRROR: f64 = 0.01;

/// One leg of the path, out or back, relative to the facet that scatters.
#[derive(Clone, Copy)]
struct Leg {
    /// Length of the leg, metres.
    r: f64,
    /// Cosine of the incidence angle.
    cos: f64,
    /// Sine of the incidence angle, signed along the facet.
    sin: f64,
    /// Unit vector from the facet to the source of the leg.
    towards: Vec2,
}

impl Leg {
    fn new(facet: &Facet, source: Vec2) -> Self {
        let way = source - facet.at;
        let r = way.len();
        let towards = way * (1.0 / r);
        Self {
            r,
            cos: facet.normal.dot(towards),
            sin: facet.along.dot(towards),
            towards,
        }
    }
}

/// The first bounce of two, off the surface that acts as a mirror: its place, and its effect on the phase.
struct Bounce<'a> {
    facet: usize,
    cos: f64,
    /// Place of the first bounce: fraction of the way from the image of the antenna to the second facet.
    share: f64,
    /// Unit vector of the direction in which the wave leaves the scanner.
    leaves: Vec2,
    shades: [&'a Shade; 2],
}

impl View<'_> {
    /// Returns the mirror angle at which the point `p` is seen, radians.
    pub fn angle(&self, p: Vec2) -> f64 {
        let mut way = p - self.eye;
        // Lengths along the beam are longer than across the edges; see `World::turn`.
        way.x /= libm::cos(self.world.yaw);
        match self.plane {
            PlaneSpec::Depth => libm::atan2(-way.y, way.x),
            PlaneSpec::Height => libm::atan2(way.x, -way.y),
        }
    }

    fn is_between(&self, angle: f64) -> bool {
        let (low, high) = self.between;
        angle >= low && angle < high
    }

    /// Returns all echoes: single bounces, edges and inner corners.
    pub fn echoes(&self, relief: &Relief, diffuse: &mut Diffuse) -> Vec<Echo> {
        let mut echoes = Vec::new();
        let lit: Vec<Option<Shade>> = (relief.facets.iter())
            .map(|f| self.line_of_sight(f))
            .collect();
        for (k, direct) in lit.iter().enumerate() {
            if let Some(direct) = direct {
                self.single(relief, k, direct, diffuse, &mut echoes);
            }
        }
        for wedge in &self.world.wedges {
            self.edge(wedge, &mut echoes);
        }
        for mirror in 0..self.world.segments.len() {
            if self.is_mirror(mirror) {
                self.corners(relief, mirror, &lit, &mut echoes);
            }
        }
        echoes
    }

    /// Returns the shade on a facet; `None` if the facet is turned away, hidden or too far.
    fn line_of_sight(&self, facet: &Facet) -> Option<Shade> {
        let leg = Leg::new(facet, self.eye);
        if leg.cos <= 0.0 || leg.r > self.reach || !self.is_between(self.angle(facet.at)) {
            return None;
        }
        let skip = [facet.segment, usize::MAX];
        let shade = shade(self.world, self.eye, facet.at, (0.0, 1.0), skip);
        (!shade.is_full()).then_some(shade)
    }

    fn material(&self, facet: &Facet) -> (&Material, f64) {
        let material = &self.materials[self.world.segments[facet.segment].material];
        let share = if facet.joint {
            material.spec.joint_reflection
        } else {
            1.0
        };
        (material, share)
    }

    /// Adds to `to` the single-bounce echoes of facet `k`: the coherent part and the diffuse part.
    fn single(
        &self,
        relief: &Relief,
        k: usize,
        direct: &Shade,
        diffuse: &mut Diffuse,
        to: &mut Vec<Echo>,
    ) {
        let facet = &relief.facets[k];
        let (material, share) = self.material(facet);
        if share == 0.0 {
            return;
        }
        let leg = Leg::new(facet, self.eye);
        let angle = self.angle(facet.at);
        let mut echo = |root: Complex64, farther: f64| {
            to.push(Echo {
                range: leg.r + farther,
                amplitude: root * cis(2.0 * self.wavenumber * leg.r) / (leg.r * leg.r),
                out: angle,
                back: angle,
            });
        };
        // σ° = γ cos θ, isotropic in azimuth and uncorrelated from facet to facet (Barton, Radar
        // Equations for Modern Radar, sec. 3.6: constant-γ model).
        let gamma = power(material.spec.diffuse_db) * share * share;
        let per_metre = gamma * leg.cos * facet.len * material.volume_scatter_factor(leg.cos);
        for strip in self.facet_sum(relief, k, [leg, leg], None, direct) {
            let coherent = strip.sum * material.reflection(leg.cos) * share;
            let spread = match diffuse {
                Diffuse::Fresh(rng) => rng.complex(per_metre * strip.lit),
                Diffuse::Steady(_) | Diffuse::Kept(_) => Complex64::ZERO,
            };
            echo(coherent + spread, strip.farther);
        }
        let lateral = &self.world.segments[facet.segment].lateral;
        let sight = (leg.r, -leg.towards.x);
        let strips = match diffuse {
            Diffuse::Fresh(_) => Vec::new(),
            Diffuse::Steady(seed) => {
                let mut rng = Random::new(*seed, SCATTERERS + k as u64);
                self.patches(lateral, sight, direct, || rng.complex(PATCH))
            }
            Diffuse::Kept(scatterers) => scatterers.with(k, self.patch_count(leg.r), |drawn| {
                let mut drawn = drawn.iter().copied();
                self.patches(lateral, sight, direct, || drawn.next().unwrap_or_default())
            }),
        };
        for strip in strips {
            echo(strip.sum * per_metre.sqrt(), strip.farther);
        }
    }

    /// Returns √σ of facet `k`, strip by strip, for a reflection coefficient of 1 and the path of the two legs,
    /// relative to the phase of the facet's middle.
    fn facet_sum(
        &self,
        relief: &Relief,
        k: usize,
        [one, two]: [Leg; 2],
        bounce: Option<&Bounce>,
        direct: &Shade,
    ) -> Vec<Strip> {
        let facet = &relief.facets[k];
        let wave = self.wavenumber;
        let (cos, sin) = (one.cos + two.cos, one.sin + two.sin);
        // Exact for a flat facet: the phase is linear along it.
        let strength = 0.5 * wave * cos * facet.len * sinc(0.5 * wave * facet.len * sin);
        let lateral = self.world.segments[facet.segment].lateral;
        let recedes = lateral.round && facet.normal.x.abs() > 0.5;
        let heights = relief.heights(k);
        let first = bounce.map(|b| (2.0 * b.cos, b.share, relief.heights(b.facet)));
        let paths = |column: i64, places: &[f64; BLOCK]| {
            let mut paths = heights.columns(column).map(|height| -height * cos);
            if recedes {
                for (path, z) in paths.iter_mut().zip(places) {
                    *path += lateral.recess(*z) * cos;
                }
            }
            if let Some((twice, share, heights)) = &first {
                for (path, z) in paths.iter_mut().zip(places) {
                    *path -= twice * heights.at(z * share);
                }
            }
            paths
        };
        let hidden = |z: f64| {
            direct.covers(z) || bounce.is_some_and(|b| b.shades.iter().any(|s| s.covers(z)))
        };
        let across = Across {
            lateral: &lateral,
            legs: [one.r, two.r],
            // The wave leaves the scanner towards the first bounce, if there is one.
            forward: [
                bounce.map_or(-one.towards.x, |b| b.leaves.x),
                -two.towards.x,
            ],
        };
        let mut strips = self.across(&across, paths, hidden);
        for strip in &mut strips {
            strip.sum = Complex64::new(0.0, -strength) * strip.sum;
        }
        strips
    }

    /// Adds to `to` the diffraction echo of a sharp edge, which physical optics leaves out.
    fn edge(&self, wedge: &Wedge, to: &mut Vec<Echo>) {
        let way = self.eye - wedge.at;
        let r = way.len();
        if r > self.reach {
            return;
        }
        let turned = libm::atan2(wedge.face.cross(way), wedge.face.dot(way));
        let phi = if turned < 0.0 {
            turned + 2.0 * PI
        } else {
            turned
        };
        if phi >= wedge.exterior {
            return;
        }
        let near = wedge.at.towards(self.eye, 1e-4);
        let seen = shade(self.world, self.eye, near, (0.0, 1.0), [usize::MAX; 2]);
        if seen.is_full() {
            return;
        }
        let cos = libm::sin(phi).max(libm::sin(wedge.exterior - phi));
        let reflection = self.materials[wedge.material].reflection(cos.max(0.0));
        let fringe = match self.polarisation {
            Polarisation::Horizontal => edge::fringe(phi, wedge.exterior, true) * -reflection,
            Polarisation::Vertical => edge::fringe(phi, wedge.exterior, false) * reflection,
        };
        let across = Across {
            lateral: &wedge.lateral,
            legs: [r, r],
            forward: [-way.x / r; 2],
        };
        let angle = self.angle(wedge.at);
        if !self.is_between(angle) {
            return;
        }
        let strips = self.across(&across, |_, _| [0.0; BLOCK], |z| seen.covers(z));
        to.extend(strips.iter().map(|strip| Echo {
            range: r + strip.farther,
            amplitude: fringe * strip.sum * cis(2.0 * self.wavenumber * r) / (r * r),
            out: angle,
            back: angle,
        }));
    }

    /// Returns whether segment `index` is flat and large enough to mirror a wave, and faces the antenna.
    fn is_mirror(&self, index: usize) -> bool {
        let s = &self.world.segments[index];
        let faces = s.sheet || s.normal().dot(self.eye - s.a) > 0.0;
        faces && flat(s)
    }

    /// Adds to `to` all echoes of two bounces, the first off segment `mirror`, the second off a facet; `lit` has the
    /// shade on every facet.
    fn corners(&self, relief: &Relief, mirror: usize, lit: &[Option<Shade>], to: &mut Vec<Echo>) {
        let s = &self.world.segments[mirror];
        let side = if s.normal().dot(self.eye - s.a) < 0.0 {
            -1.0
        } else {
            1.0
        };
        let normal = s.normal() * side;
        let image = self.eye - normal * (2.0 * normal.dot(self.eye - s.a));
        for (k, direct) in lit.iter().enumerate() {
            let facet = &relief.facets[k];
            let Some(direct) = direct else { continue };
            let height = normal.dot(facet.at - s.a);
            if facet.segment == mirror || height <= 0.0 {
                continue;
            }
            let legs = [Leg::new(facet, image), Leg::new(facet, self.eye)];
            if legs[0].cos <= 0.0 || 0.5 * (legs[0].r + legs[1].r) > self.reach {
                continue;
            }
            let Some(at) = s.crossing(image, facet.at) else {
                continue;
            };
            let point = image.towards(facet.at, at);
            self.corner(relief, (mirror, point, at), k, (legs, direct), to);
        }
    }

    /// Adds to `to` the echo of the path antenna → `point` on segment `mirror` → facet `k` → antenna.
    fn corner(
        &self,
        relief: &Relief,
        (mirror, point, share): (usize, Vec2, f64),
        k: usize,
        (legs, direct): ([Leg; 2], &Shade),
        to: &mut Vec<Echo>,
    ) {
        let facet = &relief.facets[k];
        let s = &self.world.segments[mirror];
        let out = shade(
            self.world,
            self.eye,
            point,
            (0.0, share),
            [mirror, usize::MAX],
        );
        let onward = shade(
            self.world,
            point,
            facet.at,
            (share, 1.0),
            [mirror, facet.segment],
        );
        if out.is_full() || onward.is_full() {
            return;
        }
        let first = relief.starts[mirror];
        let count = relief.starts[mirror + 1] - first;
        let along = (point - s.a).len() / s.len() * count as f64;
        let bounce_facet = first + (along as usize).min(count - 1);
        let cos = s.normal().dot((self.eye - point).unit()).abs();
        let bounce = Bounce {
            facet: bounce_facet,
            cos,
            share,
            leaves: (point - self.eye).unit(),
            shades: [&out, &onward],
        };
        let (one, one_share) = self.material(&relief.facets[bounce_facet]);
        let (two, two_share) = self.material(facet);
        // Half the angle between the legs: the incidence angle of specular reflection at the facet.
        let half = (0.5 * (1.0 + legs[0].towards.dot(legs[1].towards)))
            .max(0.0)
            .sqrt();
        let reflection = one.reflection(cos) * two.reflection(half) * (one_share * two_share);
        // The reverse path is as strong (reciprocity). It is computed when the second surface
        // serves as mirror; for a second surface that is too small for that it is added here.
        let ways = if self.is_mirror(facet.segment) {
            1.0
        } else {
            2.0
        };
        let path = legs[0].r + legs[1].r;
        let strips = self.facet_sum(relief, k, legs, Some(&bounce), direct);
        to.extend(strips.iter().map(|strip| Echo {
            range: 0.5 * path + strip.farther,
            amplitude: strip.sum * reflection * ways * cis(self.wavenumber * path)
                / (legs[0].r * legs[1].r),
            out: self.angle(point),
            back: self.angle(facet.at),
        }));
    }
}

fn flat(s: &Segment) -> bool {
    s.len() >= SHORTEST_MIRROR && !s.lateral.round && s.lateral.half >= 0.05
}
