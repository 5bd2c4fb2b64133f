//! A random scene for drives, with the distance of its first hazard and the distance that a chair
//! can travel.

use anyhow::{Context, Result};

use super::controller::FRONT_M;
use host_sim::scene::Scene;
use host_sim::scene::spec::SceneSpec;
use host_sim::scene::way::Way;
use host_sim::sweeps::hazards;
use host_sim::sweeps::scenes::{self, Kind};
use host_sim::sweeps::truth::Hazard;

/// Travel at which the first hazard is placed 0.6 to 1.8 m ahead of the mirror, metres; by then the
/// chair has reached its speed.
const BEFORE_M: f64 = 1.2;
/// Travel at the end of a drive without a hazard or a ramp before that, metres.
const LONGEST_M: f64 = 2.5;
/// Travel that is simulated after the chair's foremost point has reached the hazard, metres.
const BEYOND_M: f64 = 0.03;
/// Step of travel at which the mirror's path is checked for surfaces that it would run into,
/// metres.
const CHECKED_M: f64 = 0.05;
/// Maximum distance between the swept plane and the nearest part of an object, to the side, at
/// which the object still counts as in the beam's axis, metres. At a range of half a metre the beam
/// is 4 cm wide.
const ALONG_M: f64 = 0.02;

/// A scene that chairs drive through, with its first hazard and the length of the way.
pub struct Course {
    /// Kind and seed of the scene, as in the names of recordings: `kerb_007`.
    pub name: String,
    /// Seed of the scene and of everything random in drives through it.
    pub seed: u64,
    scene: Scene,
    /// The scene after a person has stepped in; `None` if nobody steps in.
    joined: Option<Scene>,
    /// The first hazard beyond the chair's foremost point, its distance from the mirror at the first
    /// row; `None` if none is within reach. In a scene into which a person steps, the hazard is that
    /// person.
    pub hazard: Option<Hazard>,
    /// Whether the first hazard lies beside the beam's axis: no part of it is within 2 cm of the
    /// swept plane.
    pub beside: bool,
    /// Travel of the mirror at which a drive ends at the latest, metres.
    pub end_m: f64,
}

impl Course {
    /// Creates the course from a kind of scene and a seed.
    ///
    /// # Errors
    /// Names the part from which no scene can be built.
    pub fn new(kind: Kind, seed: u64) -> Result<Self> {
        let name = format!("{}_{seed:03}", kind.name());
        let approach = scenes::approach(kind, seed, BEFORE_M).with_context(|| name.clone())?;
        let whole = approach.joined.as_ref().unwrap_or(&approach.spec);
        let first = |aside: Option<f64>| {
            let found = match aside {
                Some(aside) => hazards::within_m(whole, aside),
                None => hazards::of(whole),
            };
            let ahead = found.into_iter().filter(|hazard| hazard.at_m > FRONT_M);
            ahead.min_by(|a, b| a.at_m.total_cmp(&b.at_m))
        };
        let hazard = first(None).filter(|hazard| hazard.at_m < LONGEST_M + FRONT_M);
        let along = first(Some(ALONG_M));
        let beside = hazard.is_some_and(|h| along.is_none_or(|along| along.at_m > h.at_m));
        let asked = match hazard {
            Some(hazard) => hazard.at_m - FRONT_M + BEYOND_M,
            None => LONGEST_M.min(foot_m(&approach.spec) - FRONT_M),
        };
        let scene = Scene::new(approach.spec)?;
        let joined = approach.joined.map(Scene::new).transpose()?;
        let end_m = passable(joined.as_ref().unwrap_or(&scene), asked);
        Ok(Self {
            name,
            seed,
            scene,
            joined,
            hazard: hazard.filter(|_| end_m == asked),
            beside,
            end_m,
        })
    }

    /// Returns the ways on which chirps are simulated: before a person has stepped in, and after
    /// that (`None` if nobody steps in).
    pub fn ways(&self) -> [Option<Way<'_>>; 2] {
        let way = |scene| Way::new(scene, self.seed, self.end_m);
        [Some(way(&self.scene)), self.joined.as_ref().map(way)]
    }

    /// Returns the scene at the beginning of a drive.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Whether a person steps into the scene during a drive.
    pub fn is_joined(&self) -> bool {
        self.joined.is_some()
    }
}

/// Returns the distance at which the first ramp begins, metres; infinite without a ramp.
fn foot_m(spec: &SceneSpec) -> f64 {
    let feet = spec.ramp.iter().map(|ramp| ramp.from_m);
    feet.fold(f64::INFINITY, f64::min)
}

/// Returns the travel, at most `asked_m`, over which the mirror stays outside all surfaces, metres.
fn passable(scene: &Scene, asked_m: f64) -> f64 {
    let places = (0..).map(|k| f64::from(k) * CHECKED_M);
    let before = places.take_while(|m| *m < asked_m).chain([asked_m]);
    let free = before.take_while(|m| scene.passable(*m).is_ok());
    free.last().unwrap_or(0.0)
}
