//! A stretch of way through a scene whose echoes are shared by several drives.
//!
//! In: a scene, a seed of its surfaces and the length of the way. Out: the chirp of a row from any
//! place of the way. `passing.rs` serves one drive exactly. Here the echoes of each two centimetres
//! are computed once for all drives, and those of one direction (to a quarter of a degree) are
//! summed into one bundle of beat tones. A row shifts each bundle by the phase of the travel from
//! their middle; its range is exact to 1.3 mm, a twelfth of a range bin. Echoes outside the sector
//! that the beam sweeps enter by side lobes only and are computed every ten centimetres.

use core::cell::{OnceCell, RefCell};
use core::f64::consts::{PI, TAU};

use anyhow::{Context, Result};
use num_complex::Complex64;
use stairscan::Iq;

use super::bundles::{Bundles, Source, Tone};
use super::facets::Relief;
use super::maths::{LIGHT, Random, cis};
use super::passing::{BESIDE, COARSE_M, ahead, stretch};
use super::receiver::Receiver;
use super::scatter::{Diffuse, EVERYWHERE, Echo};
use super::scatterers::Scatterers;
use super::tones::Spread;
use super::{CHIRPS, Scene};
use crate::recording::Recording;
use crate::setup;

pub use super::passing::Shot;

/// Travel after which echoes are computed anew, metres. With a first-order shift, phases are exact
/// to 0.1 rad on the nearest ground.
const COARSE_STEP_M: f64 = 0.02;
/// Number of range shifts within a stretch of [`COARSE_STEP_M`] for which beat tones are summed in advance.
const RANGES: usize = 8;
/// Step from one range shift to the next, metres.
const RANGE_STEP_M: f64 = COARSE_STEP_M / RANGES as f64;
/// Width of the interval of directions whose echoes form one bundle, radians. The beam is 20 times as wide, and the
/// phases differ by 0.05 rad over a centimetre of travel.
const DIRECTION: f64 = 0.25 * PI / 180.0;
/// Margin of the sector whose echoes are computed for every stretch, beyond the rows' angles, radians: two beam widths
/// and the chair's pitch.
const MARGIN: f64 = BESIDE + 0.03;
/// Number of random streams reserved for one drive's chirps.
const DRIVE_STREAMS: u64 = 1 << 24;

/// The scene as seen from the middle of one stretch of the way, and its echoes as beat tones at each of the range
/// shifts.
struct Place {
    middle_m: f64,
    scene: RefCell<Scene>,
    tones: [Bundles; RANGES],
}

/// A scene with its surfaces, and the cached echoes of the stretches of the way where chairs have been.
pub struct Way<'a> {
    scene: &'a Scene,
    seed: u64,
    end_m: f64,
    receiver: Receiver<'a>,
    relief: Relief,
    scatterers: Scatterers,
    spread: Spread,
    /// Interval of mirror angles from which echoes are computed for every stretch, radians.
    sector: (f64, f64),
    places: Vec<OnceCell<Place>>,
    /// Echoes from outside `sector`, one entry for each ten centimetres of the way: the middle of these, metres of
    /// travel, and the echoes as seen from there.
    beside: Vec<OnceCell<(f64, Vec<Echo>)>>,
}

impl<'a> Way<'a> {
    /// Creates the way from the scene's mirror to `end_m` metres on, with the surfaces of `seed`.
    pub fn new(scene: &'a Scene, seed: u64, end_m: f64) -> Self {
        // Computed here once, so that the scenes cloned from this one share it.
        scene.beats();
        let grains = (end_m / COARSE_STEP_M) as usize + 1;
        let eyes: Vec<f64> = (0..=grains).map(|g| g as f64 * COARSE_STEP_M).collect();
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
            scatterers: Scatterers::new(seed),
            spread: Spread::default(),
            sector,
            places: (0..grains).map(|_| OnceCell::new()).collect(),
            beside: (0..=(end_m / COARSE_M) as usize)
                .map(|_| OnceCell::new())
                .collect(),
        }
    }

    /// Returns the chirp of row `row`, fired as in `shot`. `drive` and `number` (the chirp's index in the drive) select
    /// its random numbers.
    ///
    /// # Errors Names the place at which the mirror lies inside or behind a surface.
    pub fn chirp(&self, shot: &Shot, row: usize, (drive, number): (u64, u64)) -> Result<Vec<Iq>> {
        let place = self.place(shot.travel_m)?;
        let tones = self.tones(place, shot);
        let mut here = place.scene.borrow_mut();
        here.spec.mount.pitch_deg = Some(shot.pitch_deg);
        let stream = CHIRPS + (drive + 1) * DRIVE_STREAMS + number;
        let mut random = Random::new(self.seed, stream);
        let (chirp, _) = here.chirp(&self.receiver, &[&tones], (row, shot.time_s), &mut random);
        Ok(chirp)
    }

    /// Returns the beat tones of the stretch `place`, shifted to the position and speed of `shot`.
    fn tones(&self, place: &Place, shot: &Shot) -> Bundles {
        let radar = &self.scene.spec.radar;
        let plane = self.scene.spec.mount.plane;
        let on = shot.travel_m.min(self.end_m) - place.middle_m;
        let chirp_s = radar.samples_per_chirp as f64 / radar.sample_rate_hz;
        // The Doppler shift is equivalent to this additional travel.
        let shifted = on + shot.speed * radar.carrier_hz * chirp_s / radar.bandwidth_hz;
        let k = ((shifted + 0.5 * COARSE_STEP_M) / RANGE_STEP_M) as usize;
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

    /// Returns the stretch of the way that contains `travel_m`, computed at its first use.
    fn place(&self, travel_m: f64) -> Result<&Place> {
        let (at, middle_m) = stretch(travel_m.min(self.end_m), COARSE_STEP_M);
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

    /// Returns the scene and the relief of its surfaces as seen after `travel` metres.
    fn from(&self, travel: f64) -> Result<(Scene, Relief)> {
        let scene = self
            .scene
            .from(travel, self.scene.spec.mount.pitch_error_deg)?;
        let mut relief = self.relief.clone();
        relief.move_by(&self.scene.world, travel);
        Ok((scene, relief))
    }

    /// Computes the echoes as seen from `middle_m`, metres of travel, the middle of a stretch.
    fn look(&self, middle_m: f64) -> Result<Place> {
        let (scene, relief) = self.from(middle_m)?;
        let mut view = scene.view();
        view.between = self.sector;
        let mut echoes = view.echoes(&relief, &mut Diffuse::Kept(&self.scatterers));
        let (from_m, beside) = self.beside(middle_m)?;
        let on = middle_m - from_m;
        echoes.extend(beside.iter().map(|echo| scene.nearer(echo, on, 0.0)));
        let tones = self.bundled(&scene, &mut echoes);
        Ok(Place {
            middle_m,
            scene: RefCell::new(scene),
            tones,
        })
    }

    /// Returns the beat tones of a stretch's echoes, summed direction by direction, at each of the range shifts.
    fn bundled(&self, scene: &Scene, echoes: &mut [Echo]) -> [Bundles; RANGES] {
        let interval = |angle: f64| libm::floor(angle / DIRECTION) as i64;
        let direction = |e: &Echo| (interval(e.back), interval(e.out));
        let nearer = |a: &Echo, b: &Echo| a.range.total_cmp(&b.range);
        echoes.sort_unstable_by(|a, b| direction(a).cmp(&direction(b)).then(nearer(a, b)));
        let (plane, offset_m) = (scene.spec.mount.plane, scene.spec.mount.mirror_offset_m);
        let gain = self.receiver.gain(scene.antenna_gain_dbi());
        let middle = 0.5 * (self.receiver.samples() as f64 - 1.0);
        let tones = &self.scene.beats().tones;
        let mut bundles: [Bundles; RANGES] = Default::default();
        for group in echoes.chunk_by(|a, b| direction(a) == direction(b)) {
            let (back, out) = direction(&group[0]);
            let [back, out] = [back, out].map(|k| (k as f64 + 0.5) * DIRECTION);
            let forward = 0.5 * (ahead(plane, out).0 + ahead(plane, back).0);
            let shifts: [(f64, Complex64); RANGES] = core::array::from_fn(|k| {
                let beat = self.receiver.beat(range_shift(k) * forward);
                (tones.at(beat) - tones.at(0.0), cis(-TAU * beat * middle))
            });
            for echo in group {
                let beat = self.receiver.beat(echo.range + offset_m);
                let (at, centre) = (tones.at(beat), cis(TAU * beat * middle));
                let amplitude = echo.amplitude * gain * centre;
                for (bundles, (shift, turn)) in bundles.iter_mut().zip(shifts) {
                    let place = tones.place_by(&self.spread, at - shift, turn);
                    let Some(place) = place else { continue };
                    bundles.add(&Tone {
                        amplitude: amplitude * turn,
                        place,
                        range: echo.range,
                        out,
                        back,
                    });
                }
            }
        }
        bundles
    }

    /// Returns the echoes from outside the sector, as seen from the middle of the ten centimetres that contain
    /// `travel_m`, with that middle, metres.
    fn beside(&self, travel_m: f64) -> Result<&(f64, Vec<Echo>)> {
        let (at, middle_m) = stretch(travel_m, COARSE_M);
        let cell = &self.beside[at.min(self.beside.len() - 1)];
        if let Some(beside) = cell.get() {
            return Ok(beside);
        }
        // Beyond the end there may be a wall.
        let middle_m = middle_m.min(self.end_m.max(travel_m));
        let (scene, relief) = self.from(middle_m)?;
        let mut view = scene.view();
        view.between = EVERYWHERE;
        let mut echoes = view.echoes(&relief, &mut Diffuse::Kept(&self.scatterers));
        let (low, high) = self.sector;
        echoes.retain(|echo| echo.back < low || echo.back >= high);
        Ok(cell.get_or_init(|| (middle_m, echoes)))
    }
}

/// Returns the travel of range shift `k`, metres from the stretch's middle.
fn range_shift(k: usize) -> f64 {
    (k as f64 + 0.5) * RANGE_STEP_M - 0.5 * COARSE_STEP_M
}

impl Scene {
    /// Returns the mirror angle of row `row`, degrees.
    pub fn row_deg(&self, row: usize) -> f64 {
        self.angles[row]
    }

    /// Returns the pitch of the chair at rest, degrees.
    pub fn pitch_deg(&self) -> f64 {
        self.spec.mount.pitch_deg.unwrap_or(0.0)
    }

    /// Returns a recording of one guard sweep of `rows` rows whose samples are all zero, from which a scanner can be
    /// set up.
    pub fn no_sweeps(&self, name: &str, rows: usize) -> Recording {
        let mut recording = self.empty_recording(name);
        recording.meta.angles_deg = self.angles.iter().take(rows).copied().collect();
        recording.samples = vec![Iq::default(); rows * recording.meta.samples_per_chirp];
        recording.meta.sequence.scans = 1;
        setup::mark_guard(&mut recording);
        recording
    }

    /// Checks that the mirror is in free space after `travel_m` metres.
    ///
    /// # Errors
    /// Names the surface inside or behind which the mirror lies.
    pub fn passable(&self, travel_m: f64) -> Result<()> {
        let from = self.from(travel_m, self.spec.mount.pitch_error_deg);
        from.map(|_| ()).with_context(|| "the way")
    }
}

#[cfg(test)]
mod tests {
    use super::super::passing::Passing;
    use super::*;

    const SCENE: &str = "[[stairs]]\ndistance_m = 1.4\ncount = 2\nrise_m = 0.17\ngoing_m = 0.29\n\
                         material = \"concrete\"\n[[floor]]\nmaterial = \"concrete\"\n\
                         [sweep]\nfirst_deg = 8.0\nlast_deg = 38.0\nstep_deg = 1.0\n[mirror]\njitter_deg = 0.0\n";

    /// Returns the power of a chirp's echoes, and the power of their difference from those of a second chirp.
    fn powers(a: &[Complex64], b: &[Complex64]) -> (f64, f64) {
        let sum = |of: &dyn Fn(usize) -> Complex64| (0..a.len()).map(|k| of(k).norm_sqr()).sum();
        (sum(&|k| a[k]), sum(&|k| a[k] - b[k]))
    }

    #[test]
    fn chirps_are_those_of_one_drive_alone() {
        let scene = Scene::parse(SCENE).unwrap();
        let way = Way::new(&scene, 5, 0.4);
        let receiver = Receiver::new(&scene.spec.radar, &scene.spec.receiver);
        let relief = scene.relief(5, &[0.0, 0.4]);
        let mut passing = Passing::new(&scene, &receiver, (5, relief), (0.0, 0.4));
        let (mut power, mut error) = (0.0, 0.0);
        for (k, row) in [0, 5, 10, 15, 20, 25, 30, 12, 3, 28]
            .into_iter()
            .enumerate()
        {
            let shot = Shot {
                travel_m: 0.2003 + 0.0043 * k as f64,
                speed: 0.5,
                pitch_deg: 0.1,
                angle_deg: scene.angles[row],
                time_s: 0.0,
            };
            let random = || Random::new(5, 7);
            let place = way.place(shot.travel_m).unwrap();
            let tones = way.tones(place, &shot);
            let mut here = place.scene.borrow_mut();
            here.spec.mount.pitch_deg = Some(shot.pitch_deg);
            let (_, ours) = here.chirp(&receiver, &[&tones], (row, 0.0), &mut random());
            let (there, tones) = passing.tones(&shot).unwrap();
            let (_, theirs) = there.chirp(&receiver, &tones, (row, 0.0), &mut random());
            let (p, e) = powers(&theirs, &ours);
            (power, error) = (power + p, error + e);
        }
        assert!(error < 0.02 * power, "{error:e} of {power:e}");
    }
}
