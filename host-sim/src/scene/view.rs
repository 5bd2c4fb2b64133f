//! The view of a scene from one place, which the sums over facets, edges and columns share.

use super::beam::Beam;
use super::geometry::World;
use super::material::Material;
use super::maths::Vec2;
use super::spec::{PlaneSpec, Polarisation};

/// What the echoes depend on besides the surfaces.
pub struct View<'a> {
    /// Surfaces and edges.
    pub world: &'a World,
    /// Their materials.
    pub materials: &'a [Material],
    /// Centre of the mirror: the phase centre.
    pub eye: Vec2,
    /// Plane of the scan: which way mirror angles count.
    pub plane: PlaneSpec,
    /// Pattern.
    pub beam: &'a Beam,
    /// 2π / λ at the carrier.
    pub wavenumber: f64,
    /// Electric field along or across the edges.
    pub polarisation: Polarisation,
    /// Echoes from farther are left out.
    pub reach: f64,
    /// Echoes that do not come back from between these mirror angles are left out, radians.
    pub between: (f64, f64),
}
