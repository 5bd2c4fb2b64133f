//! Wide draws of the properties of scanner and surfaces that a recording does not state.

use std::collections::BTreeSet;

use crate::scene::check::used_materials;
use crate::scene::material::builtin;
use crate::scene::maths::Random;
use crate::scene::spec::{MaterialSpec, Polarisation, SceneSpec};

/// Draws, from their range in real instruments, surfaces, antenna pattern, sweep errors, polarisation and yaw.
pub fn wide(scene: &mut SceneSpec, rng: &mut Random) {
    surfaces(scene, rng);
    pattern(scene, rng);
    sweep(scene, rng);
    scene.radar.polarisation = if rng.chance(0.5) {
        Polarisation::Horizontal
    } else {
        Polarisation::Vertical
    };
    // Drivers head for stairs to within some degrees. A scanner whose yaw exceeds its beam width
    // receives no specular reflection of a riser.
    scene.mount.yaw_deg = (1.8 * rng.normal()).clamp(-5.0, 5.0);
}

/// Draws new properties for every material that the scene uses. W-band reviews of concrete, wood
/// and asphalt scatter over 10 dB in γ and a factor of four in roughness (Ulaby and Dobson; Li and
/// Sarabandi 1999), permittivities over a fifth (Rec. ITU-R P.2040, table 3).
fn surfaces(scene: &mut SceneSpec, rng: &mut Random) {
    change_materials(scene, |material| {
        material.permittivity = (material.permittivity * rng.between(0.85, 1.2)).max(1.0);
        material.conductivity *= factor(rng, 1.5);
        roughen(material, factor(rng, 2.2));
        material.correlation_m *= factor(rng, 1.8);
        material.diffuse_db = (material.diffuse_db + rng.between(-5.0, 5.0)).min(-8.0);
    });
}

/// Multiplies a material's roughness. The facet model does not hold for a relief of a wavelength.
pub fn roughen(material: &mut MaterialSpec, factor: f64) {
    material.roughness_m = (material.roughness_m * factor).min(1.2e-3);
}

/// Changes every material that the scene uses, in the order of their names.
pub fn change_materials(scene: &mut SceneSpec, mut change: impl FnMut(&mut MaterialSpec)) {
    let used: BTreeSet<String> = used_materials(scene)
        .into_iter()
        .map(|(_, name)| name.to_owned())
        .collect();
    for name in used {
        let given = scene.materials.get(&name).cloned();
        if let Some(mut material) = given.or_else(|| builtin(&name)) {
            change(&mut material);
            scene.materials.insert(name, material);
        }
    }
}

/// Draws a factor from 1 / `most` to `most`, uniform in its logarithm.
fn factor(rng: &mut Random, most: f64) -> f64 {
    libm::exp(libm::log(most) * rng.between(-1.0, 1.0))
}

/// Draws the antenna pattern: side lobes of feeds and lenses from uniform to well tapered (Hansen,
/// Phased Array Antennas, sec. 3.2: 13 to 30 dB), and the floor from mirror errors of 20 to 100 µm
/// (Ruze: 1 - e^{-(4πε/λ)²} of the power, spread by their correlation), 27 to 45 dB below the peak.
fn pattern(scene: &mut SceneSpec, rng: &mut Random) {
    scene.mirror.sidelobe_db = rng.between(16.0, 28.0);
    scene.mirror.sidelobe_floor_db = rng.between(27.0, 45.0);
}

/// Draws the sweep errors, from a phase-locked loop (straight to 1e-5) to a predistorted
/// free-running oscillator (some 0.05 % of bow, 0.01 % of ripple, a slope that has drifted by 0.1
/// %), and the anti-alias filter, which attenuates echoes from beyond the maximum range more or
/// less.
fn sweep(scene: &mut SceneSpec, rng: &mut Random) {
    let receiver = &mut scene.receiver;
    receiver.sweep_slope = (3e-4 * rng.normal()).clamp(-1e-3, 1e-3);
    receiver.sweep_bow = rng.between(-5e-4, 5e-4);
    receiver.sweep_ripple = factor(rng, 3.0) * 3e-5;
    receiver.sweep_ripple_cycles = rng.between(2.0, 20.0);
    receiver.phase_noise_dbc_hz = rng.between(-85.0, -70.0);
    receiver.antialias_cutoff = rng.between(0.95, 1.25);
    receiver.antialias_order = 3 + rng.index(5) as u32;
}
