//! Echoes of a scene that a chair passes, computed where and when the beam needs them.
//!
//! The echoes near the beam of a row are those of the present centimetre of the way. Each is
//! shifted with the chair and gets the Doppler shift of its speed. Echoes far beside the beam enter
//! by side lobes only. They are computed every ten centimetres, and shifted from there.

use core::f64::consts::PI;

use anyhow::{Context, Result};

use super::Scene;
use super::bundles::{Bundles, Tone};
use super::facets::Relief;
use super::maths::{LIGHT, cis};
use super::receiver::Receiver;
use super::scatter::{Diffuse, EVERYWHERE, Echo};
use super::sequence::Stop;
use super::spec::PlaneSpec;

/// Travel after which the echoes near the beam's axis are computed anew, metres. By then facets have come into view or
/// left it, and the place that the beam lights at 30 cm has moved by a tenth of the beam's width.
pub const FINE_STEP_M: f64 = 0.01;
/// Travel after which the echoes far from the beam's axis are computed anew, metres.
pub(super) const COARSE_M: f64 = 0.1;
/// Angle from the beam's axis, two beam widths, beyond which echoes enter by side lobes only,
/// radians.
pub(super) const BESIDE: f64 = 0.2;
/// Turn of the beam after which the echoes near its axis are computed anew, radians.
const TURN: f64 = 0.04;

/// Position, speed and angles at which a row is fired.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    /// True forward travel of the chair, metres.
    pub travel_m: f64,
    /// Forward speed, m/s.
    pub speed: f64,
    /// Pitch of the chair, degrees.
    pub pitch_deg: f64,
    /// Mirror angle of the row as scheduled, degrees.
    pub angle_deg: f64,
    /// Time at which the row is fired, seconds from the first row.
    pub time_s: f64,
}

/// The scene as seen from the middle of one stretch of the way.
struct Place {
    stretch: usize,
    middle_m: f64,
    scene: Scene,
    relief: Relief,
}

/// Echoes for the rows fired within one stretch of the way at about the same beam angle.
struct CachedEchoes {
    stretch: usize,
    beam: f64,
    /// Echoes near the beam's axis with their beat tones, as seen from the middle of the stretch.
    near: Vec<(Echo, Tone)>,
    /// Beat tones of the echoes in `near`, in their order, as shifted for the last row.
    tones: Vec<Tone>,
    /// The tones in `tones`, summed into bundles.
    moved: Bundles,
    /// Beat tones of the echoes far from the beam's axis, as seen from the middle of the stretch.
    others: Bundles,
}

/// A scene that a chair passes, with the echoes computed for its present position.
pub struct Passing<'a> {
    scene: &'a Scene,
    seed: u64,
    /// Chair's true pitch less the recorded one, degrees.
    error_deg: f64,
    /// Length of the chair's way, metres.
    end_m: f64,
    receiver: &'a Receiver<'a>,
    relief: Relief,
    place: Option<Place>,
    cached: Option<CachedEchoes>,
    /// Index of a stretch of [`COARSE_M`] of the way, its middle in metres of travel, and all echoes as seen from
    /// there.
    all: Option<(usize, f64, Vec<Echo>)>,
}

/// Returns, for a direction (a beam angle in the scan's plane, radians), the forward component of its unit vector, and
/// the change of the angle per metre of forward travel for an echo at a range of one metre, radians.
pub(super) fn ahead(plane: PlaneSpec, angle: f64) -> (f64, f64) {
    let (sin, cos) = libm::sincos(angle);
    match plane {
        PlaneSpec::Depth => (cos, sin),
        PlaneSpec::Height => (sin, -cos),
    }
}

impl Scene {
    /// Returns `echo` as it is after `on` metres of forward travel. Its range includes the apparent change by the
    /// Doppler shift at `speed` metres per second.
    pub(super) fn nearer(&self, echo: &Echo, on: f64, speed: f64) -> Echo {
        let plane = self.spec.mount.plane;
        let radar = &self.spec.radar;
        let (out, back) = (ahead(plane, echo.out), ahead(plane, echo.back));
        let forward = 0.5 * (out.0 + back.0);
        let wave = 4.0 * PI * radar.carrier_hz / LIGHT;
        let chirp_s = radar.samples_per_chirp as f64 / radar.sample_rate_hz;
        let doppler = speed * forward * radar.carrier_hz * chirp_s / radar.bandwidth_hz;
        Echo {
            range: echo.range - on * forward - doppler,
            amplitude: echo.amplitude * cis(-wave * on * forward),
            out: echo.out + on * out.1 / echo.range,
            back: echo.back + on * back.1 / echo.range,
        }
    }

    /// Returns the scene as seen after `travel` metres, with the pitch of the scene file and a pitch error of `error`
    /// degrees.
    pub(super) fn from(&self, travel: f64, error: f64) -> Result<Self> {
        let stop = Stop {
            travel_m: [travel; 2],
            rocking_deg: 0.0,
        };
        self.at(&stop, error)
            .with_context(|| format!("{travel:.3} m on"))
    }
}

/// Returns the index of the stretch of `grain` metres that contains `travel`, and its middle.
pub(super) fn stretch(travel: f64, grain: f64) -> (usize, f64) {
    let stretch = (travel / grain).max(0.0) as usize;
    (stretch, (stretch as f64 + 0.5) * grain)
}

impl<'a> Passing<'a> {
    /// Creates the passing of `scene` on a way of `end_m` metres, with the surfaces `relief` of `seed`; `error_deg` is
    /// the true pitch less the recorded one, degrees.
    pub fn new(
        scene: &'a Scene,
        receiver: &'a Receiver<'a>,
        (seed, relief): (u64, Relief),
        (error_deg, end_m): (f64, f64),
    ) -> Self {
        // Computed here once, so that the scenes cloned from this one share it.
        scene.beats();
        Self {
            scene,
            seed,
            error_deg,
            end_m,
            receiver,
            relief,
            place: None,
            cached: None,
            all: None,
        }
    }

    /// Returns the scene and the relief of its surfaces as seen after `travel` metres.
    pub fn from(&self, travel: f64) -> Result<(Scene, Relief)> {
        let scene = self.scene.from(travel, self.error_deg)?;
        let mut relief = self.relief.clone();
        relief.move_by(&self.scene.world, travel);
        Ok((scene, relief))
    }

    /// Returns the echoes of `scene` with the surfaces `relief` that come back from between two mirror angles, radians.
    pub fn echoes(&self, scene: &Scene, relief: &Relief, between: (f64, f64)) -> Vec<Echo> {
        let mut view = scene.view();
        view.between = between;
        view.echoes(relief, &mut Diffuse::Steady(self.seed))
    }

    /// Returns the scene at the place where `shot` is fired, and the beat tones of its echoes.
    ///
    /// # Errors
    /// Names the place at which the mirror lies inside or behind a surface.
    pub fn tones(&mut self, shot: &Shot) -> Result<(&Scene, Vec<&Bundles>)> {
        let beam = self.go(shot)?;
        self.update_echoes(shot.travel_m, beam)?;
        let (Some(place), Some(cached)) = (&self.place, &mut self.cached) else {
            return Ok((self.scene, Vec::new()));
        };
        let (here, receiver) = (&place.scene, self.receiver);
        let gain = receiver.gain(here.antenna_gain_dbi());
        let on = shot.travel_m - place.middle_m;
        for ((echo, from_middle), tone) in cached.near.iter().zip(&mut cached.tones) {
            let is_beside = (echo.back - beam).abs() > BESIDE;
            let moved = || here.tone(receiver, gain, &here.nearer(echo, on, shot.speed));
            *tone = match is_beside {
                true => *from_middle,
                false => moved().unwrap_or(*from_middle),
            };
        }
        cached.moved = Bundles::new(cached.tones.iter().copied());
        Ok((here, vec![&cached.moved, &cached.others]))
    }

    /// Moves the scene to the stretch that contains the position of `shot`, and returns the beam's angle, radians.
    fn go(&mut self, shot: &Shot) -> Result<f64> {
        let (at, middle_m) = stretch(shot.travel_m, FINE_STEP_M);
        let mut place = match self.place.take() {
            Some(place) if place.stretch == at => place,
            _ => {
                let (scene, relief) = self.from(middle_m)?;
                Place {
                    stretch: at,
                    middle_m,
                    scene,
                    relief,
                }
            }
        };
        let mount = &mut place.scene.spec.mount;
        mount.pitch_deg = Some(shot.pitch_deg);
        let tilt = mount.tilt_deg(shot.pitch_deg);
        self.place = Some(place);
        Ok((shot.angle_deg + tilt).to_radians())
    }

    /// Computes the echoes that a row with the beam angle `beam`, radians, needs after `travel` metres, unless the
    /// cached ones still serve.
    fn update_echoes(&mut self, travel: f64, beam: f64) -> Result<()> {
        let Some(place) = &self.place else {
            return Ok(());
        };
        let still = |h: &CachedEchoes| h.stretch == place.stretch && (beam - h.beam).abs() <= TURN;
        if self.cached.as_ref().is_some_and(still) {
            return Ok(());
        }
        let (coarse, middle_m) = stretch(travel, COARSE_M);
        if self.all.as_ref().is_none_or(|(at, _, _)| *at != coarse) {
            // Beyond the end there may be a wall.
            let middle_m = middle_m.min(self.end_m.max(place.middle_m));
            let (scene, relief) = self.from(middle_m)?;
            let echoes = self.echoes(&scene, &relief, EVERYWHERE);
            self.all = Some((coarse, middle_m, echoes));
        }
        let (low, high) = (beam - TURN - BESIDE, beam + TURN + BESIDE);
        let (here, receiver) = (&place.scene, self.receiver);
        let gain = receiver.gain(here.antenna_gain_dbi());
        let near = self.echoes(here, &place.relief, (low, high)).into_iter();
        let near = near.filter_map(|echo| Some((echo, here.tone(receiver, gain, &echo)?)));
        let near: Vec<(Echo, Tone)> = near.collect();
        let others = self.all.as_ref().map(|(_, middle_m, all)| {
            let on = place.middle_m - middle_m;
            let others = all.iter().map(|echo| here.nearer(echo, on, 0.0));
            let others = others.filter(|e| e.back < low || e.back >= high);
            Bundles::new(others.filter_map(|echo| here.tone(receiver, gain, &echo)))
        });
        self.cached = Some(CachedEchoes {
            stretch: place.stretch,
            beam,
            tones: near.iter().map(|(_, tone)| *tone).collect(),
            near,
            moved: Bundles::default(),
            others: others.unwrap_or_default(),
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_echo_brought_nearer_is_the_one_that_is_seen_from_there() {
        // A post: one echo, whose range and directions the shift by a few millimetres must give.
        let scene = Scene::parse(
            "[[post]]\nat_m = 1.2\ndiameter_m = 0.02\ntop_m = 1.0\nmaterial = \"concrete\"\n",
        );
        let scene = scene.unwrap();
        let relief = scene.relief(3, &[0.0, 0.004]);
        let seen = |travel: f64| {
            let mut near = relief.clone();
            near.move_by(&scene.world, travel);
            let here = scene.from(travel, 0.0).unwrap();
            here.view().echoes(&near, &mut Diffuse::Steady(3))
        };
        let (before, after) = (seen(0.0), seen(0.004));
        assert_eq!(before.len(), after.len());
        for (a, b) in before.iter().zip(&after) {
            let moved = scene.nearer(a, 0.004, 0.0);
            assert!((moved.range - b.range).abs() < 2e-5, "{moved:?} {b:?}");
            assert!((moved.out - b.out).abs() < 1e-4 && (moved.back - b.back).abs() < 1e-4);
        }
    }

    #[test]
    fn what_is_near_the_beam_and_what_is_beside_it_are_all_there_is() {
        let scene = Scene::parse(
            "[[stairs]]\ndistance_m = 1.4\ncount = 2\nrise_m = 0.17\ngoing_m = 0.29\n\
             material = \"concrete\"\n[[floor]]\nmaterial = \"concrete\"\n",
        );
        let scene = scene.unwrap();
        let receiver = Receiver::new(&scene.spec.radar, &scene.spec.receiver);
        let relief = scene.relief(5, &[0.0, 0.1]);
        let mut passing = Passing::new(&scene, &receiver, (5, relief), (0.0, 0.1));
        let travel_m = 0.5 * FINE_STEP_M;
        let (here, relief) = passing.from(travel_m).unwrap();
        let echoes = passing.echoes(&here, &relief, EVERYWHERE);
        for angle_deg in [-15.0, 0.0, 20.0, 45.0] {
            let shot = Shot {
                travel_m,
                speed: 0.0,
                pitch_deg: 0.0,
                angle_deg,
                time_s: 0.0,
            };
            let (_, tones) = passing.tones(&shot).unwrap();
            // Facets may cross the sector's border within the two centimetres between both grains.
            let count = tones.iter().map(|t| t.directions()).sum::<usize>() as f64;
            let all = here.place(&receiver, &echoes).directions() as f64;
            assert!((count - all).abs() < 0.05 * all, "{count} of {all}");
            let beam = f64::to_radians(angle_deg);
            let gain = receiver.gain(here.antenna_gain_dbi());
            let expected = echoes.iter().filter(|e| (e.back - beam).abs() <= BESIDE);
            let expected = expected.filter_map(|e| here.tone(&receiver, gain, e));
            let cached = passing.cached.as_ref().unwrap();
            let near = cached
                .tones
                .iter()
                .filter(|t| (t.back - beam).abs() <= BESIDE);
            for (a, b) in expected.zip(near) {
                assert_eq!((a.amplitude, a.out, a.back), (b.amplitude, b.out, b.back));
            }
        }
    }

    #[test]
    fn a_chair_may_stop_just_before_a_wall() {
        let scene = Scene::parse("[[wall]]\nat_m = 0.23\nmaterial = \"concrete\"\n").unwrap();
        let receiver = Receiver::new(&scene.spec.radar, &scene.spec.receiver);
        let end_m = 0.21;
        let relief = scene.relief(5, &[0.0, end_m]);
        let mut passing = Passing::new(&scene, &receiver, (5, relief), (0.0, end_m));
        let shot = Shot {
            travel_m: end_m,
            speed: 0.1,
            pitch_deg: 0.0,
            angle_deg: 0.0,
            time_s: 0.0,
        };
        let (_, tones) = passing.tones(&shot).unwrap();
        assert!(tones.iter().any(|t| t.directions() > 0));
    }
}
