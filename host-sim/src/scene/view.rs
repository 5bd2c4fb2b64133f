//! View of a scene from one place, shared by the sums over facets, edges and columns.

use super::beam::Beam;
use super::geometry::World;
use super::material::Material;
use super::maths::Vec2;
use super::spec::{PlaneSpec, Polarisation};

/// Parameters of the echoes other than the relief of the surfaces.
pub struct View<'a> {
    /// Surfaces and edges.
    pub world: &'a World,
    /// Materials of the surfaces; a segment's `material` is an index into them.
    pub materials: &'a [Material],
    /// Centre of the mirror, which is the phase centre.
    pub eye: Vec2,
    /// Plane of the scan, which sets the zero and the sign of mirror angles.
    pub plane: PlaneSpec,
    /// Antenna pattern.
    pub beam: &'a Beam,
    /// Wavenumber 2π / λ at the carrier, 1/m.
    pub wavenumber: f64,
    /// Direction of the electric field, along or across the edges of the steps.
    pub polarisation: Polarisation,
    /// Maximum range of an echo, metres.
    pub reach: f64,
    /// Interval of mirror angles, radians; echoes that come back from outside it are left out.
    pub between: (f64, f64),
}
