//! Diffraction by sharp edges.

use core::f64::consts::PI;

/// Returns the backscattered far field of the edge of a perfectly conducting wedge after Keller, in the units of
/// [`fringe`]. `phi` is the direction of the radar, measured from the first face, and `exterior` the angle of free
/// space, radians; `soft`: the electric field is parallel to the edge (Ufimtsev, Fundamentals of the Physical Theory of
/// Diffraction, eqs. 2.61, 2.63).
pub fn keller(phi: f64, exterior: f64, soft: bool) -> f64 {
    let n = exterior / PI;
    let reflected = 1.0 / (libm::cos(PI / n) - libm::cos(2.0 * phi / n));
    let incident = 1.0 / (libm::cos(PI / n) - 1.0);
    let sum = if soft {
        incident - reflected
    } else {
        incident + reflected
    };
    libm::sin(PI / n) / n * sum
}

/// Returns the far field that physical optics gives for the edge of [`keller`], in the same units and with the same
/// arguments: half the tangent of every lit face's angle (Ufimtsev, eqs. 3.46 to 3.50, in backscattering direction).
pub fn physical_optics(phi: f64, exterior: f64, soft: bool) -> f64 {
    let mut sum = 0.0;
    for face in [phi, exterior - phi] {
        if face > 0.0 && face < PI {
            sum += 0.5 * libm::tan(face);
        }
    }
    if soft { sum } else { -sum }
}

/// Returns the far field that a sharp edge adds to that of the facets of its two faces: Keller's field less that of
/// physical optics, with the arguments of [`keller`]. It is finite everywhere, in units of the two-dimensional far
/// field u = f e^{j(kr+π/4)} / √(2πkr) of a wave of amplitude 1.
pub fn fringe(phi: f64, exterior: f64, soft: bool) -> f64 {
    // Both terms diverge towards the normal of a face, and cancel there.
    let nudged = [0.5 * PI, exterior - 0.5 * PI]
        .into_iter()
        .find(|normal| (phi - normal).abs() < 1e-4)
        .map_or(phi, |normal| normal + 1e-4);
    keller(nudged, exterior, soft) - physical_optics(nudged, exterior, soft)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: f64 = 1.5 * PI;

    #[test]
    fn fringes_are_finite_and_steady_across_the_normals() {
        for exterior in [SQUARE, 2.0 * PI] {
            for soft in [true, false] {
                for k in 1..2000 {
                    let phi = exterior * f64::from(k) / 2000.0;
                    assert!(fringe(phi, exterior, soft).abs() < 1.2, "{phi}");
                }
                let (below, above) = (0.5 * PI - 2e-4, 0.5 * PI + 2e-4);
                let step = fringe(below, exterior, soft) - fringe(above, exterior, soft);
                assert!(step.abs() < 1e-2);
            }
        }
    }

    #[test]
    fn a_half_plane_scatters_as_sommerfeld_found() {
        // Backscatter of a half plane, soft: f = -(1 - 1/cos φ)/2; hard: -(1 + 1/cos φ)/2.
        for phi in [0.3, 0.9, 1.4, 2.2] {
            let (s, h) = (keller(phi, 2.0 * PI, true), keller(phi, 2.0 * PI, false));
            assert!((s + 0.5 * (1.0 - 1.0 / phi.cos())).abs() < 1e-9, "{s}");
            assert!((h + 0.5 * (1.0 + 1.0 / phi.cos())).abs() < 1e-9, "{h}");
        }
    }

    #[test]
    fn a_wedge_looks_the_same_from_both_faces() {
        for phi in [0.2, 0.7, 1.3, 2.0] {
            let (a, b) = (
                fringe(phi, SQUARE, true),
                fringe(SQUARE - phi, SQUARE, true),
            );
            assert!((a - b).abs() < 1e-9);
        }
    }
}
