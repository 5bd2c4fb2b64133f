//! A random scene for drives: where its hazard is, and how far a chair can go.

use anyhow::{Context, Result};

use super::controller::FRONT_M;
use crate::scene::Scene;
use crate::scene::spec::SceneSpec;
use crate::scene::way::Way;
use crate::sweeps::hazards;
use crate::sweeps::scenes::{self, Kind};
use crate::sweeps::truth::Hazard;

/// The first hazard is 0.6 to 1.8 m beyond this, metres: far enough that the chair has its speed.
const BEFORE_M: f64 = 1.2;
/// Where no hazard is nearer the drive ends here, metres.
const LONGEST_M: f64 = 2.5;
/// Chirps are simulated so far beyond the place where the foremost point reaches the hazard, metres.
const BEYOND_M: f64 = 0.03;
/// The mirror is held free of all surfaces at places so far apart, metres.
const CHECKED_M: f64 = 0.05;
/// Things in the beam's axis: their nearest part is at most this far from the plane, metres. At half a metre the
/// beam is 4 cm wide.
const ALONG_M: f64 = 0.02;

/// A scene that chairs drive through.
pub struct Course {
    /// Kind and seed, as recordings are named.
    pub name: String,
    /// Seed of everything that is random in it.
    pub seed: u64,
    scene: Scene,
    /// After somebody has stepped in.
    joined: Option<Scene>,
    /// The first hazard, from the mirror at the first row; of a scene into which somebody steps, that person.
    pub hazard: Option<Hazard>,
    /// Whether the hazard lies beside the beam's axis.
    pub beside: bool,
    /// Travel of the mirror at which the way ends, metres.
    pub end_m: f64,
}

impl Course {
    /// The scene of a kind and seed.
    ///
    /// # Errors
    /// Says what no scene can be built of.
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

    /// Its way before and after somebody has stepped in.
    pub fn ways(&self) -> [Option<Way<'_>>; 2] {
        let way = |scene| Way::new(scene, self.seed, self.end_m);
        [Some(way(&self.scene)), self.joined.as_ref().map(way)]
    }

    /// The scene at the beginning.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Whether somebody steps in.
    pub fn is_joined(&self) -> bool {
        self.joined.is_some()
    }
}

/// Where the first ramp begins, metres; infinite without one.
fn foot_m(spec: &SceneSpec) -> f64 {
    let feet = spec.ramp.iter().map(|ramp| ramp.from_m);
    feet.fold(f64::INFINITY, f64::min)
}

/// How far, up to `asked_m`, the mirror goes in free space.
fn passable(scene: &Scene, asked_m: f64) -> f64 {
    let places = (0..).map(|k| f64::from(k) * CHECKED_M);
    let before = places.take_while(|m| *m < asked_m).chain([asked_m]);
    let free = before.take_while(|m| scene.passable(*m).is_ok());
    free.last().unwrap_or(0.0)
}
