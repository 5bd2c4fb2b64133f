//! Conditions of a measurement, and the scene of a body under one of them.
//!
//! Everything that the condition does not fix is drawn for each scene: mounting errors, side lobes,
//! the properties of each material, and a few centimetres and degrees, so that no cell depends on
//! one range bin or one angle.

use host_sim::scene::material::{NAMES, builtin};
use host_sim::scene::maths::Random;
use host_sim::scene::spec::{MaterialSpec, SceneSpec};

use super::body::Body;

/// Materials of dry ground, used in turn where a condition names none: the simulator's wood, glazed tiles, concrete,
/// carpet and grating.
pub const GROUNDS: [&str; 5] = [
    "painted-wood",
    "dark-ceramic",
    "concrete",
    "carpet",
    "grating",
];
/// Material of ground under a film of water.
pub const WET: &str = "wet";
/// Distance of the reference condition, metres.
pub const REFERENCE_M: f64 = 1.0;

/// System loss with a clean window, dB: the simulator's default.
const CLEAN_DB: f64 = 15.0;
/// Maximum deviation of the body's place from the condition's distance, metres either way: more
/// than two range bins.
const PLACE_M: f64 = 0.025;
/// Maximum deviation of the chair's heading from the condition's yaw, degrees either way.
const YAW_DEG: f64 = 1.0;
/// [Standard deviation, maximum] of the pitch error that the scanner does not know, degrees: homing of the mirror,
/// tyres.
const PITCH_DEG: [f64; 2] = [0.15, 0.4];
/// [Standard deviation, maximum] of the error of the mirror's configured height above the ground, metres.
const HEIGHT_M: [f64; 2] = [0.002, 0.005];
/// Range of the level of the beam's first side lobes from which each scene's is drawn, dB below the beam's peak.
const SIDE_LOBES_DB: [f64; 2] = [18.0, 24.0];
/// Maximum deviation of the power that a material scatters diffusely from that of the built-in material, dB either way.
const TEXTURE_DB: f64 = 4.0;
/// Maximum deviation of a material's roughness from that of the built-in material, a factor either way.
const ROUGHNESS: f64 = 2.0;
/// Maximum roughness of a material, metres. The facet model does not hold for a relief of a wavelength.
const ROUGHEST_M: f64 = 1.2e-3;
/// Stream of the random numbers from which a scene's deviations are drawn; the streams of surfaces and chirps are
/// others.
const STREAM: u64 = 0x4341_5041;

/// Condition under which all scenes of a cell are measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// Distance of the body's front from the mirror, metres.
    pub distance_m: f64,
    /// Heading of the chair relative to the perpendicular of the body's edge, degrees.
    pub yaw_deg: f64,
    /// Pitch of the chair as the inclinometer reports it, degrees, nose up positive.
    pub pitch_deg: f64,
    /// Two-way loss of the window beyond that of a clean one, dB.
    pub loss_db: f64,
    /// Material of ground and body; `None` uses those of [`GROUNDS`], one scene after the other.
    pub ground: Option<&'static str>,
    /// Speed towards the body, m/s; 0 for a chair that stands.
    pub speed: f64,
}

impl Condition {
    /// The reference condition: 1 m ahead, square, level, clean, dry, standing.
    pub const REFERENCE: Self = Self {
        distance_m: REFERENCE_M,
        yaw_deg: 0.0,
        pitch_deg: 0.0,
        loss_db: 0.0,
        ground: None,
        speed: 0.0,
    };
}

/// A scene with the place of its body.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The scene.
    pub spec: SceneSpec,
    /// Distance of the body's front from the mirror, metres.
    pub at_m: f64,
}

/// Returns scene number `turn` of a cell, with its random deviations from `seed`. Where the condition names no ground,
/// `turn` selects one of [`GROUNDS`].
pub fn scene(body: Body, condition: &Condition, turn: usize, seed: u64) -> Setup {
    let rng = &mut Random::new(seed, STREAM);
    let mut spec = SceneSpec::default();
    instrument(&mut spec, condition, rng);
    let at_m = condition.distance_m + rng.between(-PLACE_M, PLACE_M);
    let ground = condition.ground.unwrap_or(GROUNDS[turn % GROUNDS.len()]);
    for name in [ground, "metal"] {
        spec.materials.insert(name.into(), piece(name, rng));
    }
    body.place(&mut spec, at_m, ground);
    Setup { spec, at_m }
}

/// Draws a normal deviate of the given standard deviation, clipped to ± the maximum.
fn clipped([deviation, most]: [f64; 2], rng: &mut Random) -> f64 {
    (deviation * rng.normal()).clamp(-most, most)
}

/// Sets the window's loss, the beam's side lobes, the chair's yaw and pitch, and the mounting errors; errors and side
/// lobes are drawn.
fn instrument(spec: &mut SceneSpec, condition: &Condition, rng: &mut Random) {
    spec.radar.system_loss_db = CLEAN_DB + condition.loss_db;
    spec.mirror.sidelobe_db = rng.between(SIDE_LOBES_DB[0], SIDE_LOBES_DB[1]);
    let mount = &mut spec.mount;
    mount.yaw_deg = condition.yaw_deg + rng.between(-YAW_DEG, YAW_DEG);
    mount.pitch_deg = Some(condition.pitch_deg);
    mount.pitch_error_deg = clipped(PITCH_DEG, rng);
    mount.height_error_m = clipped(HEIGHT_M, rng);
}

/// Returns the built-in material `name` with a random deviation of its diffusely scattered power and its roughness.
fn piece(name: &str, rng: &mut Random) -> MaterialSpec {
    debug_assert!(NAMES.contains(&name));
    let plain = builtin(name).unwrap_or_default();
    let factor = libm::exp(libm::log(ROUGHNESS) * rng.between(-1.0, 1.0));
    MaterialSpec {
        diffuse_db: plain.diffuse_db + rng.between(-TEXTURE_DB, TEXTURE_DB),
        roughness_m: (plain.roughness_m * factor).min(ROUGHEST_M),
        ..plain
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use host_sim::scene::Scene;

    /// Each standard body can be built at the ends of all ranges.
    #[test]
    fn scenes_can_be_built() {
        let ends = [(0.4, 0.0, -4.0), (2.0, 14.0, 4.0), (0.4, 14.0, 0.0)];
        for (k, body) in Body::STANDARD.into_iter().enumerate() {
            for (distance_m, yaw_deg, pitch_deg) in ends {
                for ground in GROUNDS.into_iter().chain([WET]) {
                    let condition = Condition {
                        distance_m,
                        yaw_deg,
                        pitch_deg,
                        ground: Some(ground),
                        ..Condition::REFERENCE
                    };
                    let setup = scene(body, &condition, k, k as u64);
                    assert!((setup.at_m - distance_m).abs() <= PLACE_M);
                    Scene::new(setup.spec)
                        .unwrap_or_else(|e| panic!("{body:?} {condition:?}: {e}"));
                }
            }
        }
    }

    #[test]
    fn grounds_come_by_turns_and_loss_adds_up() {
        let condition = Condition {
            loss_db: 20.0,
            ..Condition::REFERENCE
        };
        for (turn, ground) in GROUNDS.into_iter().enumerate() {
            let spec = scene(Body::Level, &condition, turn + 5, 3).spec;
            assert_eq!(spec.floor[0].material, ground);
            assert_eq!(spec.radar.system_loss_db, 35.0);
        }
    }
}
