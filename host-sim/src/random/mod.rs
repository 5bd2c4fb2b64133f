//! Random scenes for training, validation and the accuracy tables: buildings, objects, weather and
//! wear.
//!
//! Ranges are those of building codes and of objects in buildings, chosen independently of the
//! detector. One kind, variety and seed gives one fixed scene, because recordings are scored by
//! them. `scenes/README.md` lists in a table what each draw is based on.

mod beside;
mod clutter;
mod down;
mod draw;
mod effects;
mod entrance;
#[cfg(test)]
mod entrance_tests;
mod flight;
mod instrument;
mod none;
mod odd;
mod paving;
mod regular;
mod shaped;
#[cfg(test)]
mod tests;
mod unsteady;

use core::fmt;
use core::str::FromStr;

use crate::scene::maths::Random;
use crate::scene::spec::SceneSpec;

pub use beside::balusters;
pub use clutter::CLUTTER;
pub use effects::{change_materials, roughen};
pub use entrance::ENTRANCE;
pub use none::NONE;

/// Kind of random scenes, by their content.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Kind {
    /// A flight or kerb going up.
    Ascending = 0,
    /// No stairs: consecutive seeds take the contents of [`NONE`] in turn.
    None = 1,
    /// A flight going down, seen from a pole.
    Descending = 2,
    /// A flight going up, one of whose steps is 2 to 4 cm higher or lower than the others.
    Irregular = 3,
    /// A flight going up, each of whose rises and goings deviates slightly from the flight's nominal one.
    Uneven = 4,
    /// A flight going up with one odd rise (2 to 5 cm), one odd going (3 to 8 cm), or both.
    Odd = 5,
    /// Carpeted or worn steps with rounded nosings, 1 to 2 cm in radius.
    Soft = 6,
    /// Low and deep steps whose treads fall towards the front, as in parks and forecourts.
    Low = 7,
    /// Steep steps: rises of 20 to 25 cm, goings of 18 to 24 cm.
    Steep = 8,
    /// Two flights with a landing between them.
    Landing = 9,
    /// A single platform 18 to 30 cm high.
    Platform = 10,
    /// Floating treads: slabs, and gratings with or without a C-channel as nosing.
    Open = 11,
    /// A kerb 3 to 8 cm high, with and without slopes before and after it.
    Kerb = 12,
    /// A flight with something beside, under or over it: stringers, posts, a person, a ceiling's edge.
    Beside = 13,
    /// No stairs: consecutive seeds take the contents of [`CLUTTER`] in turn.
    Clutter = 14,
    /// Flights going down of one to six steps, regular, uneven or odd, seen from a pole.
    Downstairs = 15,
    /// Stairs or a kerb going down ahead, seen in the depth plane: no step to report, but the way is not clear.
    Brink = 16,
    /// A hole in the floor or the end of the floor ahead, seen in the depth plane: the way is not clear.
    Hole = 17,
    /// A flight going up before an instrument of another design: mount, beam, bandwidth, pitch.
    Mounting = 18,
    /// The way between street and foyer, with and without steps: consecutive seeds take the contents of [`ENTRANCE`] in
    /// turn.
    Entrance = 19,
    /// A flight going up before a scanner that is not steady: a chair that vibrates, a shaft that runs out, drifts and
    /// jitter.
    Vibrating = 20,
}

impl Kind {
    /// Kinds of which studies and tables draw scenes.
    pub const ALL: [Kind; 20] = [
        Kind::Ascending,
        Kind::None,
        Kind::Descending,
        Kind::Irregular,
        Kind::Uneven,
        Kind::Odd,
        Kind::Soft,
        Kind::Low,
        Kind::Steep,
        Kind::Landing,
        Kind::Platform,
        Kind::Open,
        Kind::Kerb,
        Kind::Beside,
        Kind::Clutter,
        Kind::Downstairs,
        Kind::Brink,
        Kind::Hole,
        Kind::Mounting,
        Kind::Entrance,
    ];

    /// Kinds that are drawn only where they are asked for, so that tables and fits stay those of [`Kind::ALL`].
    pub const APART: [Kind; 1] = [Kind::Vibrating];

    /// Returns all kinds.
    pub fn every() -> impl Iterator<Item = Kind> {
        Kind::ALL.into_iter().chain(Kind::APART)
    }

    /// Returns the name that `random:KIND` uses.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Ascending => "ascending",
            Kind::None => "none",
            Kind::Descending => "descending",
            Kind::Irregular => "irregular",
            Kind::Uneven => "uneven",
            Kind::Odd => "odd",
            Kind::Soft => "soft",
            Kind::Low => "low",
            Kind::Steep => "steep",
            Kind::Landing => "landing",
            Kind::Platform => "platform",
            Kind::Open => "open",
            Kind::Kerb => "kerb",
            Kind::Beside => "beside",
            Kind::Clutter => "clutter",
            Kind::Downstairs => "downstairs",
            Kind::Brink => "brink",
            Kind::Hole => "hole",
            Kind::Mounting => "mounting",
            Kind::Entrance => "entrance",
            Kind::Vibrating => "vibrating",
        }
    }

    /// Returns the default variety. The first four kinds keep the variety with which recordings and
    /// tables were made.
    pub const fn variety(self) -> Variety {
        match self {
            Kind::Ascending | Kind::None | Kind::Descending | Kind::Irregular | Kind::Vibrating => {
                Variety {
                    instrument: Spread::Paper,
                    effects: Spread::Paper,
                }
            }
            Kind::Mounting => Variety {
                instrument: Spread::Wide,
                effects: Spread::Wide,
            },
            _ => Variety {
                instrument: Spread::Paper,
                effects: Spread::Wide,
            },
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Kind {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        Kind::every().find(|k| k.name() == text).ok_or_else(|| {
            let names: Vec<&str> = Kind::every().map(Kind::name).collect();
            format!("\"{text}\": expected one of {}", names.join(", "))
        })
    }
}

/// Width of the distributions from which properties of a random scene are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Spread {
    /// Tolerances of the paper's instrument, and this crate's table of materials.
    Paper,
    /// The range of real instruments, surfaces and drivers of chairs.
    Wide,
}

/// Spread of a scene's random properties besides its shapes. Each of the two parts has its own stream of random
/// numbers, so that the same seed gives the same staircase with either spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variety {
    /// Properties that a recording states of its scanner: mount, beam, bandwidth, samples, angles,
    /// pitch.
    pub instrument: Spread,
    /// Properties that a recording does not state: surfaces, antenna pattern, sweep errors, polarisation, yaw.
    pub effects: Spread,
}

/// Numbers of the streams of random numbers for a scene's shapes, instrument, effects and unsteadiness, to which the kind's
/// number is added. They differ from the streams of a scan.
const STREAM: u64 = 0x5343_454E_4500;
const INSTRUMENT: u64 = 0x494E_5354_5200;
const EFFECTS: u64 = 0x4546_4645_4300;
const UNSTEADY: u64 = 0x554E_5354_4400;

/// Returns the scene of a kind that `seed` draws, with the kind's default variety.
pub fn random(kind: Kind, seed: u64) -> SceneSpec {
    random_with(kind, kind.variety(), seed)
}

/// Returns the scene of a kind that `seed` draws, with a given variety.
pub fn random_with(kind: Kind, variety: Variety, seed: u64) -> SceneSpec {
    let stream = |of: u64| Random::new(seed, of + kind as u64);
    let rng = &mut stream(STREAM);
    let mut scene = SceneSpec::default();
    instrument::equipment(&mut scene, rng);
    let what = match kind {
        Kind::Ascending | Kind::Mounting | Kind::Vibrating => regular::ascending(&mut scene, rng),
        Kind::None => none::none(&mut scene, seed, rng),
        Kind::Descending => regular::descending(&mut scene, rng),
        Kind::Irregular => odd::irregular(&mut scene, rng),
        Kind::Uneven => odd::uneven(&mut scene, rng),
        Kind::Odd => odd::odd(&mut scene, rng),
        Kind::Soft => shaped::soft(&mut scene, rng),
        Kind::Low => shaped::low(&mut scene, rng),
        Kind::Steep => shaped::steep(&mut scene, rng),
        Kind::Landing => shaped::landing(&mut scene, rng),
        Kind::Platform => shaped::platform(&mut scene, rng),
        Kind::Open => shaped::open(&mut scene, rng),
        Kind::Kerb => shaped::kerb(&mut scene, rng),
        Kind::Beside => beside::beside(&mut scene, rng),
        Kind::Clutter => clutter::clutter(&mut scene, seed, rng),
        Kind::Downstairs => down::downstairs(&mut scene, rng),
        Kind::Brink => down::brink(&mut scene, rng),
        Kind::Hole => down::hole(&mut scene, rng),
        Kind::Entrance => entrance::entrance(&mut scene, seed, rng),
    };
    if variety.instrument == Spread::Wide {
        instrument::wide(&mut scene, &mut stream(INSTRUMENT));
    }
    if variety.effects == Spread::Wide {
        effects::wide(&mut scene, &mut stream(EFFECTS));
    }
    if kind == Kind::Vibrating {
        unsteady::unsteady(&mut scene, &mut stream(UNSTEADY));
    }
    scene.description = format!("random scene, {kind} {seed}: {what}");
    scene
}
