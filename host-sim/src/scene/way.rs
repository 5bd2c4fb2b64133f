//! A stretch of way through a scene whose echoes several drives share.
//!
//! In: a scene, a seed of its surfaces and how far chairs go. Out: the chirp of a row from any place of the way. It
//! differs from [`super::passing`], which serves one drive to the last bit: here the echoes of each centimetre are worked
//! out once for all drives, and those of one direction (to a quarter of a degree) are summed into one bundle of beat
//! tones. A row turns each bundle by the phase of the way from the centimetre's middle; its range is right to 1.3 mm, a
//! twelfth of a range bin. Echoes outside the sector that the beam sweeps come by side lobes alone and are
//! worked out every ten centimetres.

use core::cell::{OnceCell, RefCell};
use core::f64::consts::{PI, TAU};

use anyhow::{Context, Result};
use stairscan::Iq;

use super::bundles::{Bundles, Source};
use super::facets::Relief;
use super::maths::{LIGHT, Random, cis};
use super::passing::{BESIDE, COARSE_M, GRAIN_M, ahead, stretch};
use super::receiver::Receiver;
use super::scatter::{Diffuse, EVERYWHERE, Echo};
use super::{CHIRPS, Scene};
use crate::recording::Recording;
use crate::setup;

pub use super::passing::Shot;

/// Ranges within a centimetre's stretch for which beat tones are summed.
const RANGES: usize = 4;
/// Metres from one to the next.
const RANGE_STEP_M: f64 = GRAIN_M / RANGES as f64;
/// Echoes whose directions fall into the same interval are one bundle, radians: the beam is 20 times as wide, and over
/// half a centimetre their phases differ by 0.03 rad.
const DIRECTION: f64 = 0.25 * PI / 180.0;
/// The sector of near echoes goes beyond the rows by two beam widths and by what a chair pitches, radians.
const MARGIN: f64 = BESIDE + 0.03;
/// Streams of random numbers of one drive's chirps.
const DRIVE_STREAMS: u64 = 1 << 24;

/// The scene from the middle of one centimetre of the way, and its echoes as beat tones at each of the ranges.
struct Place {
    middle_m: f64,
    scene: RefCell<Scene>,
    tones: [Bundles; RANGES],
}

/// A scene with its surfaces, and the echoes of the places where chairs have been.
pub struct Way<'a> {
    scene: &'a Scene,
    seed: u64,
    end_m: f64,
    receiver: Receiver<'a>,
    relief: Relief,
    /// Mirror angles of near echoes, radians.
    sector: (f64, f64),
    places: Vec<OnceCell<Place>>,
    /// For every ten centimetres: its middle, and the echoes outside the sector.
    beside: Vec<OnceCell<(f64, Vec<Echo>)>>,
}

impl<'a> Way<'a> {
    /// The way from the scene's mirror to `end_m` metres on, with the surfaces of `seed`.
    pub fn new(scene: &'a Scene, seed: u64, end_m: f64) -> Self {
        // Made once, and not by every scene that is made of this one.
        scene.beats();
        let grains = (end_m / GRAIN_M) as usize + 1;
        let eyes: Vec<f64> = (0..=grains).map(|g| g as f64 * GRAIN_M).collect();
        let rows = scene.angles.iter().map(|angle| angle.to_radians());
        let sector = rows.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), row| {
            (low.min(row - MARGIN), high.max(row + MARGIN))
        });
        Self {
            scene,
            seed,
            end_m,
            receiver: Receiver::new(&scene.spec.radar, &scene.spec.receiver),
            relief: scene.relief(seed, &eyes),
            sector,
            places: (0..grains).map(|_| OnceCell::new()).collect(),
            beside: (0..=grains / 10).map(|_| OnceCell::new()).collect(),
        }
    }

    /// The chirp of row `row`, number `number` of drive `drive`, fired as `shot` says.
    ///
    /// # Errors
    /// Says where the mirror has come to lie inside or behind a surface.
    pub fn chirp(&self, shot: &Shot, row: usize, (drive, number): (u64, u64)) -> Result<Vec<Iq>> {
        let place = self.place(shot.travel_m)?;
        let tones = self.tones(place, shot);
        let mut here = place.scene.borrow_mut();
        here.spec.mount.pitch_deg = Some(shot.pitch_deg);
        let stream = CHIRPS + (drive + 1) * DRIVE_STREAMS + number;
        let mut random = Random::new(self.seed, stream);
        let (chirp, _) = here.chirp(&self.receiver, &[&tones], row, &mut random);
        Ok(chirp)
    }

    /// The beat tones of a place as they are heard from where `shot` is fired.
    fn tones(&self, place: &Place, shot: &Shot) -> Bundles {
        let radar = &self.scene.spec.radar;
        let plane = self.scene.spec.mount.plane;
        let on = shot.travel_m.min(self.end_m) - place.middle_m;
        let chirp_s = radar.samples_per_chirp as f64 / radar.sample_rate_hz;
        // The Doppler shift is that of a way that is so much longer.
        let shifted = on + shot.speed * radar.carrier_hz * chirp_s / radar.bandwidth_hz;
        let k = ((shifted + 0.5 * GRAIN_M) / RANGE_STEP_M) as usize;
        let k = k.min(RANGES - 1);
        let wave = 4.0 * PI * radar.carrier_hz / LIGHT;
        let middle = 0.5 * (self.receiver.samples() as f64 - 1.0);
        let beat = TAU * middle * self.receiver.beat(shifted - range_shift(k));
        place.tones[k].turned(|Source { range, out, back }| {
            let (leaves, comes) = (ahead(plane, *out), ahead(plane, *back));
            let forward = 0.5 * (leaves.0 + comes.0);
            let turns = [out + on * leaves.1 / range, back + on * comes.1 / range];
            (cis(-(wave * on + beat) * forward), turns)
        })
    }

    /// The place that `travel_m` falls into.
    fn place(&self, travel_m: f64) -> Result<&Place> {
        let (at, middle_m) = stretch(travel_m.min(self.end_m), GRAIN_M);
        let (at, middle_m) = match self.places.get(at) {
            Some(_) => (at, middle_m.min(self.end_m)),
            None => (self.places.len() - 1, self.end_m),
        };
        let cell = &self.places[at];
        if let Some(place) = cell.get() {
            return Ok(place);
        }
        let place = self.look(middle_m)?;
        Ok(cell.get_or_init(|| place))
    }

    /// The scene and its surfaces from `travel` metres on.
    fn from(&self, travel: f64) -> Result<(Scene, Relief)> {
        let scene = self
            .scene
            .from(travel, self.scene.spec.mount.pitch_error_deg)?;
        let mut relief = self.relief.clone();
        relief.move_by(&self.scene.world, travel);
        Ok((scene, relief))
    }

    /// Works a place out.
    fn look(&self, middle_m: f64) -> Result<Place> {
        let (scene, relief) = self.from(middle_m)?;
        let mut view = scene.view();
        view.between = self.sector;
        let mut echoes = view.echoes(&relief, &mut Diffuse::Steady(self.seed));
        let (from_m, beside) = self.beside(middle_m)?;
        let on = middle_m - from_m;
        echoes.extend(beside.iter().map(|echo| scene.nearer(echo, on, 0.0)));
        let interval = |angle: f64| libm::floor(angle / DIRECTION);
        for echo in &mut echoes {
            echo.out = (interval(echo.out) + 0.5) * DIRECTION;
            echo.back = (interval(echo.back) + 0.5) * DIRECTION;
        }
        let keys = |e: &Echo| [e.back, e.out, e.range];
        echoes.sort_unstable_by(|a, b| {
            let pairs = keys(a).into_iter().zip(keys(b));
            pairs.fold(core::cmp::Ordering::Equal, |order, (a, b)| {
                order.then(a.total_cmp(&b))
            })
        });
        let gain = self.receiver.gain(scene.antenna_gain_dbi());
        let plane = scene.spec.mount.plane;
        let tones = core::array::from_fn(|k| {
            let shift = range_shift(k);
            Bundles::new(echoes.iter().filter_map(|echo| {
                let forward = 0.5 * (ahead(plane, echo.out).0 + ahead(plane, echo.back).0);
                let range = echo.range - shift * forward;
                scene.tone(&self.receiver, gain, &Echo { range, ..*echo })
            }))
        });
        Ok(Place {
            middle_m,
            scene: RefCell::new(scene),
            tones,
        })
    }

    /// The echoes outside the sector, from the middle of the ten centimetres that `travel_m` falls into.
    fn beside(&self, travel_m: f64) -> Result<&(f64, Vec<Echo>)> {
        let (at, middle_m) = stretch(travel_m, COARSE_M);
        let cell = &self.beside[at.min(self.beside.len() - 1)];
        if let Some(beside) = cell.get() {
            return Ok(beside);
        }
        // Behind the end there may be a wall.
        let middle_m = middle_m.min(self.end_m.max(travel_m));
        let (scene, relief) = self.from(middle_m)?;
        let mut view = scene.view();
        view.between = EVERYWHERE;
        let mut echoes = view.echoes(&relief, &mut Diffuse::Steady(self.seed));
        let (low, high) = self.sector;
        echoes.retain(|echo| echo.back < low || echo.back >= high);
        Ok(cell.get_or_init(|| (middle_m, echoes)))
    }
}

/// Middle of range `k` of a centimetre's stretch, metres from the stretch's middle.
fn range_shift(k: usize) -> f64 {
    (k as f64 + 0.5) * RANGE_STEP_M - 0.5 * GRAIN_M
}

impl Scene {
    /// Mirror angle of a row, degrees.
    pub fn row_deg(&self, row: usize) -> f64 {
        self.angles[row]
    }

    /// Pitch of the chair at rest, degrees.
    pub fn pitch_deg(&self) -> f64 {
        self.spec.mount.pitch_deg.unwrap_or(0.0)
    }

    /// A recording by this scanner of one sweep of `rows` rows without echoes, by which a scanner can be set up.
    pub fn no_sweeps(&self, name: &str, rows: usize) -> Recording {
        let mut recording = self.empty_recording(name);
        recording.meta.angles_deg = self.angles.iter().take(rows).copied().collect();
        recording.samples = vec![Iq::default(); rows * recording.meta.samples_per_chirp];
        recording.meta.sequence.scans = 1;
        setup::mark_guard(&mut recording);
        recording
    }

    /// Whether the mirror is in free space `travel_m` metres on.
    ///
    /// # Errors
    /// Says inside or behind which surface it lies.
    pub fn passable(&self, travel_m: f64) -> Result<()> {
        let from = self.from(travel_m, self.spec.mount.pitch_error_deg);
        from.map(|_| ()).with_context(|| "the way")
    }
}
