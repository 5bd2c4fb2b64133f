//! Electrical properties of surface materials and their reflection of waves.

use num_complex::Complex64;

use super::spec::{MaterialSpec, Polarisation};

/// Names of the built-in materials.
pub const NAMES: [&str; 13] = [
    "painted-wood",
    "dark-ceramic",
    "concrete",
    "metal",
    "grating",
    "plaster",
    "carpet",
    "fabric",
    "asphalt",
    "glass",
    "rubber",
    "wet",
    "dark-carpet",
];

/// Returns a built-in material.
///
/// Permittivity and conductivity at 94 GHz are those of Rec. ITU-R P.2040 (table 3: wood, concrete,
/// plasterboard, metal; marble stands for glazed ceramic), extrapolated where its fits end below.
/// Roughness is that of profilometer measurements: paint levels to some ten micrometres over the grain, glaze
/// and sheet metal to a few, cast concrete to tenths of a millimetre. γ at W-band is -15 to -25 dB for
/// concrete and asphalt (Ulaby and Dobson, Handbook of Radar Scattering Statistics for Terrain;
/// Li, Sarabandi 1999) and lower the finer the texture.
pub fn builtin(name: &str) -> Option<MaterialSpec> {
    let plain = MaterialSpec::default();
    Some(match name {
        "painted-wood" => MaterialSpec {
            permittivity: 1.99,
            conductivity: 0.61,
            roughness_m: 60e-6,
            correlation_m: 3e-3,
            diffuse_db: -26.0,
            ..plain
        },
        // 30 cm tiles with cement joints of 3 mm, 1 mm deep.
        "dark-ceramic" => MaterialSpec {
            permittivity: 7.07,
            conductivity: 0.37,
            roughness_m: 15e-6,
            correlation_m: 4e-3,
            diffuse_db: -34.0,
            joint_pitch_m: 0.30,
            joint_width_m: 3e-3,
            joint_depth_m: 1e-3,
            joint_reflection: 0.6,
            ..plain
        },
        "concrete" => MaterialSpec {
            permittivity: 5.24,
            conductivity: 1.62,
            roughness_m: 200e-6,
            correlation_m: 2.5e-3,
            diffuse_db: -20.0,
            ..plain
        },
        "metal" => MaterialSpec {
            permittivity: 1.0,
            conductivity: 1e7,
            roughness_m: 10e-6,
            correlation_m: 5e-3,
            diffuse_db: -38.0,
            ..plain
        },
        // Bearing bars 4 mm thick every 34 mm, with open space between.
        "grating" => MaterialSpec {
            permittivity: 1.0,
            conductivity: 1e7,
            roughness_m: 50e-6,
            correlation_m: 3e-3,
            diffuse_db: -32.0,
            joint_pitch_m: 0.034,
            joint_width_m: 0.030,
            joint_depth_m: 0.0,
            joint_reflection: 0.0,
            ..plain
        },
        "plaster" => MaterialSpec {
            permittivity: 2.73,
            conductivity: 0.61,
            roughness_m: 80e-6,
            correlation_m: 4e-3,
            diffuse_db: -26.0,
            ..plain
        },
        "carpet" => MaterialSpec {
            permittivity: 1.4,
            conductivity: 0.3,
            roughness_m: 700e-6,
            correlation_m: 2e-3,
            diffuse_db: -18.0,
            ..plain
        },
        // Clothed legs: behind the loss of the cloth, skin reflects about as strongly as wood.
        "fabric" => MaterialSpec {
            permittivity: 2.5,
            conductivity: 5.0,
            roughness_m: 500e-6,
            correlation_m: 4e-3,
            diffuse_db: -17.0,
            ..plain
        },
        _ => return ground(name),
    })
}

/// Returns a built-in material of streets and entrances.
///
/// Roads scatter from inside, except rough ones (Li and Sarabandi 1999, 94 GHz, 70 to 88° from the
/// normal). `scenes/README.md` lists values and sources, and states which values are assumptions.
fn ground(name: &str) -> Option<MaterialSpec> {
    let plain = MaterialSpec::default();
    Some(match name {
        // Permittivity between bitumen (2.7) and stone (5 to 7). The surface is so smooth that
        // volume scatter exceeds that of the relief, whose physical optics has the wrong order of
        // polarisations at grazing angles.
        "asphalt" => MaterialSpec {
            permittivity: 4.0,
            conductivity: 0.5,
            roughness_m: 100e-6,
            correlation_m: 3e-3,
            diffuse_db: -17.0,
            diffuse_inside: true,
            ..plain
        },
        // Rec. ITU-R P.2040, table 3. The back face of a 10 mm pane echoes 22 dB below the front,
        // because the glass takes 10 dB one way; the pane is modelled as a half space. Float glass
        // is optically flat; γ is that of dust and fingerprints.
        "glass" => MaterialSpec {
            permittivity: 6.31,
            conductivity: 1.58,
            roughness_m: 1e-6,
            correlation_m: 5e-3,
            diffuse_db: -48.0,
            ..plain
        },
        // Rubber filled with carbon black.
        "rubber" => MaterialSpec {
            permittivity: 4.0,
            conductivity: 5.0,
            roughness_m: 40e-6,
            correlation_m: 2e-3,
            diffuse_db: -32.0,
            ..plain
        },
        // A closed film of water at 20 °C, at least 0.3 mm thick, over concrete or asphalt: ε = 7.7
        // + 13.3j at 94 GHz (Liebe, Hufford, Manabe 1991, double Debye). The field falls to 1/e in
        // 0.26 mm, so that the film takes 20 dB from the scatter below it, and its surface another
        // 5 dB. Surface tension levels it.
        "wet" => MaterialSpec {
            permittivity: 7.69,
            conductivity: 69.7,
            roughness_m: 5e-6,
            correlation_m: 1e-2,
            diffuse_db: -44.0,
            diffuse_inside: true,
            ..plain
        },
        // Short pile, or an entrance mat, that absorbs the wave.
        "dark-carpet" => MaterialSpec {
            permittivity: 1.25,
            conductivity: 0.5,
            roughness_m: 300e-6,
            correlation_m: 1.5e-3,
            diffuse_db: -32.0,
            ..plain
        },
        _ => return None,
    })
}

/// A material at one carrier frequency and polarisation.
#[derive(Clone, Debug)]
pub struct Material {
    /// Parameters from the scene file.
    pub spec: MaterialSpec,
    permittivity: Complex64,
    polarisation: Polarisation,
}

/// Permittivity of vacuum, F/m.
const EPSILON_0: f64 = 8.854_187_812_8e-12;

impl Material {
    /// Creates the material at `carrier_hz`, with the complex permittivity ε' + jσ/(ωε₀) (time
    /// dependence e^{-jωt}).
    pub fn new(spec: &MaterialSpec, carrier_hz: f64, polarisation: Polarisation) -> Self {
        let loss = spec.conductivity / (core::f64::consts::TAU * carrier_hz * EPSILON_0);
        Self {
            spec: spec.clone(),
            permittivity: Complex64::new(spec.permittivity, loss),
            polarisation,
        }
    }

    /// Returns Fresnel's reflection coefficient of a half space (Balanis, Advanced Engineering
    /// Electromagnetics, sec. 5.3): for the electric field when that is parallel to the edges, for
    /// the magnetic field when that is, so that metal gives -1 and +1.
    pub fn reflection(&self, cos_incidence: f64) -> Complex64 {
        let c = cos_incidence.clamp(0.0, 1.0);
        let inside = root(self.permittivity - (1.0 - c * c));
        let outside = match self.polarisation {
            Polarisation::Horizontal => Complex64::new(c, 0.0),
            Polarisation::Vertical => self.permittivity * c,
        };
        (outside - inside) / (outside + inside)
    }

    /// Returns the fraction of the power that passes the surface.
    fn transmissivity(&self, cos_incidence: f64) -> f64 {
        1.0 - self.reflection(cos_incidence).norm_sqr()
    }

    /// Returns the factor on σ° = γ cos θ of scatter from inside the material: the two-way
    /// transmissivity of the surface relative to that at normal incidence. It is 1 for scatter at
    /// the surface.
    pub fn volume_scatter_factor(&self, cos_incidence: f64) -> f64 {
        if !self.spec.diffuse_inside {
            return 1.0;
        }
        let share = self.transmissivity(cos_incidence) / self.transmissivity(1.0);
        share * share
    }

    /// Whether the point `s` metres along a surface lies in a joint.
    pub fn in_joint(&self, s: f64) -> bool {
        let (pitch, width) = (self.spec.joint_pitch_m, self.spec.joint_width_m);
        pitch > 0.0 && (s / pitch - libm::floor(s / pitch)) * pitch < width
    }
}

/// Returns the principal square root by half-angle formulas, which need only real square roots and
/// so are the same on every host.
fn root(z: Complex64) -> Complex64 {
    let r = (z.re * z.re + z.im * z.im).sqrt();
    let re = ((r + z.re).max(0.0) / 2.0).sqrt();
    let im = ((r - z.re).max(0.0) / 2.0).sqrt();
    Complex64::new(re, if z.im < 0.0 { -im } else { im })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(name: &str, polarisation: Polarisation) -> Material {
        Material::new(&builtin(name).unwrap(), 94e9, polarisation)
    }

    #[test]
    fn every_name_is_a_material() {
        assert!(NAMES.iter().all(|n| builtin(n).is_some()));
        assert!(builtin("cheese").is_none());
    }

    #[test]
    fn metal_turns_the_electric_field_over() {
        let soft = at("metal", Polarisation::Horizontal).reflection(0.7);
        let hard = at("metal", Polarisation::Vertical).reflection(0.7);
        assert!(
            (soft - Complex64::new(-1.0, 0.0)).l1_norm() < 0.01,
            "{soft}"
        );
        assert!((hard - Complex64::new(1.0, 0.0)).l1_norm() < 0.01, "{hard}");
    }

    #[test]
    fn a_dielectric_reflects_as_its_refractive_index_says() {
        // (1 - n) / (1 + n) with n = sqrt(5.24), and no reflection of H-polarised waves at
        // Brewster's angle.
        let lossless = MaterialSpec {
            permittivity: 5.24,
            conductivity: 0.0,
            ..MaterialSpec::default()
        };
        let n = 5.24_f64.sqrt();
        let normal = Material::new(&lossless, 94e9, Polarisation::Horizontal).reflection(1.0);
        assert!((normal.re - (1.0 - n) / (1.0 + n)).abs() < 1e-12 && normal.im.abs() < 1e-12);
        let brewster = 1.0 / (1.0 + n * n).sqrt();
        let hard = Material::new(&lossless, 94e9, Polarisation::Vertical).reflection(brewster);
        assert!(hard.l1_norm() < 1e-12, "{hard}");
    }

    #[test]
    fn what_scatters_inside_fades_at_grazing_angles_in_one_polarisation() {
        let factor = |polarisation, grazing: f64| {
            let asphalt = at("asphalt", polarisation);
            10.0 * asphalt
                .volume_scatter_factor(grazing.to_radians().sin())
                .log10()
        };
        // For ε = 4, in dB: Fresnel by hand.
        for (grazing, book) in [(10.0, -8.6), (20.0, -4.4), (30.0, -2.5), (90.0, 0.0)] {
            let found = factor(Polarisation::Horizontal, grazing);
            assert!((found - book).abs() < 0.4, "{grazing}°: {found} dB");
        }
        // Towards Brewster's angle more power passes the surface than at normal incidence.
        for grazing in [15.0, 25.0, 40.0] {
            let found = factor(Polarisation::Vertical, grazing);
            assert!((-0.7..1.1).contains(&found), "{grazing}°: {found} dB");
        }
        let concrete = at("concrete", Polarisation::Horizontal);
        assert_eq!(concrete.volume_scatter_factor(0.1), 1.0);
    }

    #[test]
    fn joints_come_at_their_pitch() {
        let tile = at("dark-ceramic", Polarisation::Horizontal);
        let share = (0..3000)
            .filter(|k| tile.in_joint((f64::from(*k) + 0.5) * 1e-3))
            .count();
        assert_eq!(share, 30, "ten joints of 3 mm in 3 m");
    }
}
