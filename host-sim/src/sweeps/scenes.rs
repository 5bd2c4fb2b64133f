//! Recordings of guard sweeps of random scenes: a kind and a seed in, a recording with the truth of
//! each sweep out.
//!
//! The scenes are those of [`crate::random`], moved so that the first hazard comes within
//! the sweeps' range. Each pair of kind and seed gives one fixed recording. The seeds are assigned
//! to draws as those of full scans are ([`crate::seeds`]).

use anyhow::{Context, Result};
use clap::ValueEnum;

use super::hazards;
use super::truth::{self, Hazard, Truth};
use crate::cache;
use crate::random::{self, random};
use crate::recording::Recording;
use crate::scene::Scene;
use crate::scene::driving::Drive;
use crate::scene::maths::Random;
use crate::scene::sequence::pushed;
use crate::scene::spec::{BoxSpec, PostSpec, SceneSpec};
use crate::seeds::Draw;

/// Number of sweeps of a random recording, alternately forward and backward.
pub const SWEEPS: usize = 14;
/// First row, last row and distance between rows of a sweep, degrees below the horizontal: the
/// recordings' profile, the guard's defaults.
const ROWS_DEG: [f64; 3] = [8.0, 38.0, 1.0];
/// Time from row to row, seconds: 31 rows of a module that takes 2.8 ms for chirp and transfer (3
/// Mbaud, `cargo sim timing`).
pub const ROW_S: f64 = 0.0028;
/// Time from the first row of a sweep to that of the next one, seconds: ten sweeps a second.
pub const SWEEP_S: f64 = 0.1;
/// Period of sweeps of the drive that is simulated ([`Drive`]), seconds: 30 rows, and 0.1 s of
/// turning round between two scans. Speeds are scaled by the ratio to [`SWEEP_S`], so that the
/// travel per sweep is that of ten sweeps a second.
const DRIVEN_S: f64 = 30.0 * ROW_S + 0.1;

/// Range of chair speeds, m/s: those indoors, and towards places where a wheelchair may have to
/// stop.
const SPEEDS: [f64; 2] = [0.1, 0.6];
/// Fraction of the recordings in which the chair stands.
const STANDING: f64 = 0.15;
/// Maximum magnitude of the pitch error that the recording's pitch does not contain, degrees:
/// tyres, and a mount that has settled.
const PITCH_DEG: f64 = 0.4;
/// Range of the first hazard's distance from the mirror at the last sweep, metres.
const AT_END_M: [f64; 2] = [0.6, 1.8];
/// Range of the distance from the mirror, at the last sweep, of a ramp's foot or of the legs of a
/// person who stepped in, metres.
const NEAR_END_M: [f64; 2] = [0.5, 1.3];
/// Minimum length of ground ahead at the last sweep in scenes without stairs and walls, metres:
/// farther than sweeps look.
const GROUND_M: f64 = 3.5;
/// First and last number, counted from 0, of the sweep before which a person may step in.
const STEPS_IN: [usize; 2] = [3, 6];
/// Base of the streams of random numbers for drives and places in recordings, to which the kind's
/// number is added; distinct from the streams of scenes and surfaces.
const STREAM: u64 = 0x4755_4152_4400;
/// Base of the streams of random numbers for scenes of closed-loop drives ([`approach`]), to which
/// the kind's number is added.
const APPROACHES: u64 = 0x4755_4152_4500;

/// Kind of scene for random guard sweeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, ValueEnum)]
#[repr(u8)]
pub enum Kind {
    /// Level floors, some with a threshold of less than 2 cm.
    Level,
    /// Ramps up of 3 to 12 degrees.
    Ramp,
    /// Stairs going down, or a kerb down.
    Brink,
    /// A hole in the floor or the end of it.
    Hole,
    /// A kerb of 3 to 8 cm going up.
    Kerb,
    /// A flight going up.
    Ascending,
    /// A single platform of 18 to 30 cm.
    Platform,
    /// Clutter: furniture, boxes, posts.
    Clutter,
    /// Kerbs, ramps, thresholds, paving and doors of entrances.
    Entrance,
    /// A level floor into which a person steps.
    Person,
}

impl Kind {
    /// All kinds, in the order of tables.
    pub const ALL: [Self; 10] = [
        Self::Level,
        Self::Ramp,
        Self::Brink,
        Self::Hole,
        Self::Kerb,
        Self::Ascending,
        Self::Platform,
        Self::Clutter,
        Self::Entrance,
        Self::Person,
    ];

    /// Returns the name that `--kind` takes.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Level => "level",
            Self::Ramp => "ramp",
            Self::Brink => "brink",
            Self::Hole => "hole",
            Self::Kerb => "kerb",
            Self::Ascending => "ascending",
            Self::Platform => "platform",
            Self::Clutter => "clutter",
            Self::Entrance => "entrance",
            Self::Person => "person",
        }
    }

    /// Returns the kind of random full-scan scenes from which this kind is drawn, and the endings
    /// of the descriptions of the scenes that are taken; an empty list takes all.
    const fn source(self) -> (random::Kind, &'static [&'static str]) {
        match self {
            Self::Level | Self::Person => (random::Kind::None, &["floor", "threshold"]),
            Self::Ramp => (random::Kind::None, &["ramp"]),
            Self::Brink => (random::Kind::Brink, &[]),
            Self::Hole => (random::Kind::Hole, &[]),
            Self::Kerb => (random::Kind::Kerb, &[]),
            Self::Ascending => (random::Kind::Ascending, &[]),
            Self::Platform => (random::Kind::Platform, &[]),
            Self::Clutter => (random::Kind::Clutter, &[]),
            Self::Entrance => (random::Kind::Entrance, &[]),
        }
    }

    /// Returns the number of recordings of this kind in a table. For the reporting draw, at least
    /// 3,000 sweeps have a hazard within 1.5 m and 3,000 have none. For the other draws, two cores
    /// simulate all recordings in one minute.
    pub fn recordings(self, draw: Draw) -> u64 {
        match (draw, self) {
            (Draw::Reporting, Self::Level) => 200,
            (Draw::Reporting, _) => 60,
            (_, _) => 6,
        }
    }

    /// Returns the seeds of a draw that give scenes of this kind, ascending.
    pub fn seeds(self, draw: Draw) -> impl Iterator<Item = u64> {
        let (source, wanted) = self.source();
        draw.seeds().filter(move |seed| {
            let shows = |what: &&str| random(source, *seed).description.ends_with(what);
            wanted.is_empty() || wanted.iter().any(shows)
        })
    }
}

/// Sets the rows of a scene's scanner to those of a guard sweep.
pub fn coarse(spec: &mut SceneSpec) {
    let sweep = &mut spec.sweep;
    [sweep.first_deg, sweep.last_deg, sweep.step_deg] = ROWS_DEG;
}

/// Returns a drive of `sweeps` sweeps whose travel per sweep is that of a chair at `speed` m/s with
/// ten sweeps a second.
pub fn drive(seed: u64, sweeps: usize, speed: f64) -> Drive {
    Drive::new(seed, sweeps, speed * SWEEP_S / DRIVEN_S).with_rows(ROW_S)
}

/// Returns guard sweeps of a scene from a driving chair, with their truth.
///
/// # Errors
/// Names the place at which the mirror lies inside or behind a surface.
pub fn sweeps_of(mut spec: SceneSpec, name: &str, seed: u64, drive: &Drive) -> Result<Recording> {
    coarse(&mut spec);
    let mut recording = simulated(&spec, name, seed, drive)?;
    let found = hazards::of(&spec);
    let truth = truth_of(&recording, |_| &found);
    truth::write(&mut recording, &truth);
    Ok(recording)
}

/// Returns the recording of a kind and seed, with its truth.
///
/// # Errors
/// Names the part of which no scene can be built, or the place at which the mirror lies inside or
/// behind a surface.
pub fn recording(kind: Kind, seed: u64) -> Result<Recording> {
    let name = format!("{}_{seed:03}", kind.name());
    let drawn = Drawn::new(kind, seed).with_context(|| name.clone())?;
    let mut recording = simulated(&drawn.spec, &name, seed, &drawn.drive)?;
    let alone = hazards::of(&drawn.spec);
    let (mut from, mut joined) = (SWEEPS, Vec::new());
    if let Some((sweep, spec)) = &drawn.joined {
        let then = simulated(spec, &name, seed, &drawn.drive)?;
        splice(&mut recording, &then, *sweep);
        (from, joined) = (*sweep, hazards::of(spec));
    }
    let truth = truth_of(
        &recording,
        |sweep| if sweep < from { &alone } else { &joined },
    );
    truth::write(&mut recording, &truth);
    Ok(recording)
}

/// Returns the recording of a scene with its drive, without truth of hazards: from the cache, or
/// simulated.
fn simulated(spec: &SceneSpec, name: &str, seed: u64, drive: &Drive) -> Result<Recording> {
    let key = format!("sweeps {seed} {drive:?} of {spec:?}");
    cache::recording(name, &key, || {
        Scene::new(spec.clone())?.simulate_sweeps(name, seed, drive)
    })
}

/// Returns the first hazard at the end of each sweep. `hazards(k)` gives all hazards that are there
/// at sweep `k`, with distances from the mirror at the first row.
fn truth_of<'a>(recording: &Recording, hazards: impl Fn(usize) -> &'a Vec<Hazard>) -> Truth {
    let travel = recording.meta.sequence.truth_travel_m.iter().enumerate();
    travel
        .map(|(sweep, at)| truth::first(hazards(sweep), *at))
        .collect()
}

/// Replaces sweep `from` (counted from 0) and all later sweeps of `recording` by the same sweeps of
/// `then`.
fn splice(recording: &mut Recording, then: &Recording, from: usize) {
    let cut = from * recording.chirps_per_scan() * recording.meta.samples_per_chirp;
    recording.samples.truncate(cut);
    recording.samples.extend_from_slice(&then.samples[cut..]);
    let truth = &mut recording.meta.sequence.truth;
    truth.truncate(from);
    truth.extend_from_slice(&then.meta.sequence.truth[from..]);
}

/// A random scene with the drive of a chair towards its hazard, as drawn for one recording.
struct Drawn {
    spec: SceneSpec,
    drive: Drive,
    /// The scene with a person in it, and the number of the sweep (from 0) from which on it
    /// replaces the first scene; `None` if nobody steps in.
    joined: Option<(usize, SceneSpec)>,
}

impl Drawn {
    fn new(kind: Kind, seed: u64) -> Result<Self> {
        let rng = &mut Random::new(seed, STREAM + kind as u64);
        let mut spec = random(kind.source().0, seed);
        coarse(&mut spec);
        tilt(&mut spec, rng);
        let speed = match rng.chance(STANDING) {
            true => 0.0,
            false => rng.between(SPEEDS[0], SPEEDS[1]),
        };
        let drive = drive(seed, SWEEPS, speed);
        let rows = (ROWS_DEG[1] - ROWS_DEG[0]) / ROWS_DEG[2] + 1.0;
        let way = drive.length_m(rows as usize);
        let spec = placed(kind, spec, way, rng)?;
        let joined = (kind == Kind::Person).then(|| {
            let sweep = STEPS_IN[0] + rng.index(STEPS_IN[1] - STEPS_IN[0] + 1);
            let mut with = spec.clone();
            person(
                &mut with,
                way + rng.between(NEAR_END_M[0], NEAR_END_M[1]),
                rng,
            );
            (sweep, with)
        });
        Ok(Self {
            spec,
            drive,
            joined,
        })
    }
}

/// A random scene for a closed-loop drive (`cargo study drives`), whose chair drives until it stops.
#[derive(Clone, Debug)]
pub struct Approach {
    /// The scene at the beginning.
    pub spec: SceneSpec,
    /// The scene after a person has stepped in; `None` if nobody does.
    pub joined: Option<SceneSpec>,
}

/// Returns the scene of a kind and seed for closed-loop drives. Its first hazard, its ramp or its
/// person lies as far beyond `way_m` (metres) as in recordings beyond the place of the last sweep.
///
/// # Errors
/// Names the part of which no scene can be built, or the place at which the mirror lies inside or
/// behind a surface.
pub fn approach(kind: Kind, seed: u64, way_m: f64) -> Result<Approach> {
    let rng = &mut Random::new(seed, APPROACHES + kind as u64);
    let mut spec = random(kind.source().0, seed);
    coarse(&mut spec);
    tilt(&mut spec, rng);
    let spec = placed(kind, spec, way_m, rng)?;
    let joined = (kind == Kind::Person).then(|| {
        let mut with = spec.clone();
        let at_m = way_m + rng.between(NEAR_END_M[0], NEAR_END_M[1]);
        person(&mut with, at_m, rng);
        with
    });
    Ok(Approach { spec, joined })
}

/// Adds a random pitch error, which the recording's pitch does not contain, to a scene's mount.
fn tilt(spec: &mut SceneSpec, rng: &mut Random) {
    let error = rng.between(-PITCH_DEG, PITCH_DEG);
    let mount = &mut spec.mount;
    mount.pitch_deg.get_or_insert(0.0);
    mount.pitch_error_deg = error;
}

/// Returns a scene moved along the way so that its first hazard, or its ramp, has a distance drawn
/// for the last sweep after `way` metres of travel.
fn placed(kind: Kind, mut spec: SceneSpec, way: f64, rng: &mut Random) -> Result<SceneSpec> {
    let open = spec.stairs.is_empty() && spec.wall.is_empty();
    if open && let Some(last) = spec.floor.last_mut() {
        // Scenes of full scans end where full scans no longer look.
        last.to_m = last.to_m.map(|to_m| to_m.max(way + GROUND_M));
    }
    let hazards = hazards::of(&spec).into_iter().map(|hazard| hazard.at_m);
    let first = hazards.fold(f64::INFINITY, f64::min);
    let by = match kind {
        Kind::Level | Kind::Person => 0.0,
        Kind::Ramp => {
            let foot = spec
                .ramp
                .iter()
                .map(|ramp| ramp.from_m)
                .fold(f64::INFINITY, f64::min);
            way + rng.between(NEAR_END_M[0], NEAR_END_M[1]) - foot
        }
        _ if open && first >= way + GROUND_M => 0.0,
        _ => way + rng.between(AT_END_M[0], AT_END_M[1]) - first,
    };
    // A scene that was moved nearer than it was drawn may leave the mirror inside a surface.
    let places = [by, by.max(0.0), by.max(0.0) + 0.5].map(|by| pushed(spec.clone(), by));
    let mut failed = None;
    for place in places {
        let ends = Scene::new(place.clone()).and_then(|_| Scene::new(pushed(place.clone(), -way)));
        match ends {
            Ok(_) => return Ok(place),
            Err(error) => failed = Some(error),
        }
    }
    failed.map_or(Ok(spec), Err)
}

/// Adds a person who stands at `at_m` metres, one of whose legs is in the beam: legs of 9 to 15 cm
/// over shoes of 24 to 32 cm, one foot up to 25 cm before the other (DIN 33402-2: calf and thigh
/// circumferences, foot lengths).
fn person(scene: &mut SceneSpec, at_m: f64, rng: &mut Random) {
    let (apart, diameter) = (rng.between(0.08, 0.2), rng.between(0.09, 0.15));
    let (shoe, sole) = (rng.between(0.24, 0.32), rng.between(0.05, 0.09));
    let (stride, in_beam) = (rng.between(0.0, 0.25), rng.between(-0.05, 0.05));
    let other = if rng.chance(0.5) { 1.0 } else { -1.0 };
    for (step, side) in [(0.0, 0.0), (stride, other)] {
        let (x, lateral) = (at_m + step, in_beam + side * (apart + diameter));
        scene.post.push(PostSpec {
            at_m: x,
            lateral_m: lateral,
            diameter_m: diameter,
            bottom_m: sole,
            top_m: rng.between(0.75, 0.95),
            material: "fabric".into(),
        });
        let toes = x - rng.between(0.3, 0.7) * shoe;
        scene.boxes.push(BoxSpec {
            from_m: toes,
            to_m: toes + shoe,
            bottom_m: 0.0,
            top_m: sole,
            width_m: Some(rng.between(0.08, 0.11)),
            lateral_m: lateral,
            mountable: false,
            material: "fabric".into(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the first hazard as seen from the first sweep, and as seen after the whole way.
    fn ends(kind: Kind, seed: u64) -> [Option<Hazard>; 2] {
        let drawn = Drawn::new(kind, seed).unwrap();
        let spec = drawn.joined.map_or(drawn.spec, |(_, spec)| spec);
        let found = hazards::of(&spec);
        [0.0, drawn.drive.length_m(31)].map(|travel| truth::first(&found, travel))
    }

    #[test]
    fn hazards_come_within_the_range_and_level_ground_has_none() {
        for kind in Kind::ALL {
            let seeds: Vec<u64> = kind.seeds(Draw::Tuning).take(8).collect();
            for seed in seeds {
                let [_, last] = ends(kind, seed);
                let level = matches!(kind, Kind::Level | Kind::Ramp);
                let at = last.map_or(f64::INFINITY, |hazard| hazard.at_m);
                match kind {
                    _ if level => assert_eq!(last, None, "{kind:?} {seed}"),
                    // Some scenes have no hazard: mats, low kerbs.
                    Kind::Clutter | Kind::Entrance | Kind::Kerb => assert!(at > 0.2, "{at}"),
                    _ => assert!((0.25..=2.4).contains(&at), "{kind:?} {seed}: {at}"),
                }
            }
        }
    }

    #[test]
    fn draws_share_no_seed_and_shows_what_they_are_named() {
        let first = |draw| Kind::Ramp.seeds(draw).next().unwrap();
        assert!(first(Draw::Tuning) < first(Draw::Validation));
        assert!(first(Draw::Validation) < first(Draw::Reporting));
        let ramp = random(random::Kind::None, first(Draw::Reporting));
        assert_eq!(ramp.ramp.len(), 1);
    }

    #[test]
    fn the_way_from_sweep_to_sweep_is_that_of_ten_a_second() {
        let way = drive(3, SWEEPS, 0.4).length_m(31);
        // 13 sweeps and 30 rows, varied by the joystick's swing.
        assert!((way - 0.4 * 1.35).abs() < 0.05, "{way}");
    }

    #[test]
    fn who_steps_in_is_there_from_that_sweep_on() {
        let seed = Kind::Person.seeds(Draw::Tuning).next().unwrap();
        let recording = recording(Kind::Person, seed).unwrap();
        let truth = truth::read(&recording).unwrap().unwrap();
        let from = truth.iter().position(Option::is_some).unwrap();
        assert!((STEPS_IN[0]..=STEPS_IN[1]).contains(&from), "{truth:?}");
        assert!(truth[from..].iter().all(Option::is_some));
        assert_eq!(recording.chirps(), SWEEPS * 31);
        assert_eq!(recording.scans(), SWEEPS);
    }
}
