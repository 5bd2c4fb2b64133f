//! The echoes of a scene that a chair passes, worked out where and when the beam asks for them.
//!
//! A row hears the echoes near its beam as they are on this centimetre of the way, each moved on with the
//! chair and given the Doppler shift of its speed. What lies far beside the beam comes by side lobes alone
//! and is worked out every ten centimetres, and moved from there.

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

/// The echoes near the beam are worked out anew after so much travel, metres: by then facets have come
/// into view or left it, and a beam at 30 cm has moved by a tenth of its width.
pub const GRAIN_M: f64 = 0.01;
/// All others after so much.
pub(super) const COARSE_M: f64 = 0.1;
/// Echoes this far beside the beam, two of its widths, come by side lobes alone, radians.
pub(super) const BESIDE: f64 = 0.2;
/// The beam turns by so much before the echoes near it are worked out anew, radians.
const TURN: f64 = 0.04;

/// Where a row is fired from, and how.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    /// Forward travel, metres.
    pub travel_m: f64,
    /// Forward speed, m/s.
    pub speed: f64,
    /// Pitch of the chair, degrees.
    pub pitch_deg: f64,
    /// Mirror angle of the row, degrees.
    pub angle_deg: f64,
}

/// The scene from the middle of one stretch of the way.
struct Place {
    stretch: usize,
    middle_m: f64,
    scene: Scene,
    relief: Relief,
}

/// What rows hear from one stretch of the way, the beam looking much the same way.
struct Heard {
    stretch: usize,
    beam: f64,
    /// Echoes near the beam, from the middle of the stretch.
    near: Vec<(Echo, Tone)>,
    /// The tones of these, as the last row heard them.
    tones: Vec<Tone>,
    /// The same, put together.
    moved: Bundles,
    /// The tones of all others.
    others: Bundles,
}

/// A scene that a chair passes.
pub struct Passing<'a> {
    scene: &'a Scene,
    seed: u64,
    /// Error of the pitch that the recording states, degrees.
    error_deg: f64,
    /// How far the chair goes, metres.
    end_m: f64,
    receiver: &'a Receiver<'a>,
    relief: Relief,
    place: Option<Place>,
    heard: Option<Heard>,
    /// All echoes from the middle of a coarse stretch.
    all: Option<(usize, f64, Vec<Echo>)>,
}

/// How much of a direction (a mirror angle less the tilt) runs forward, and how fast the angle grows
/// for each metre forward at a range of one.
pub(super) fn ahead(plane: PlaneSpec, angle: f64) -> (f64, f64) {
    let (sin, cos) = libm::sincos(angle);
    match plane {
        PlaneSpec::Depth => (cos, sin),
        PlaneSpec::Height => (sin, -cos),
    }
}

impl Scene {
    /// An echo `on` metres farther forward, at `speed` metres a second.
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

    /// The scene from `travel` metres on, level as the scene file says.
    pub(super) fn from(&self, travel: f64, error: f64) -> Result<Self> {
        let stop = Stop {
            travel_m: [travel; 2],
            rocking_deg: 0.0,
        };
        self.at(&stop, error)
            .with_context(|| format!("{travel:.3} m on"))
    }
}

/// Which stretch of `grain` metres `travel` falls into, and the middle of it.
pub(super) fn stretch(travel: f64, grain: f64) -> (usize, f64) {
    let stretch = (travel / grain).max(0.0) as usize;
    (stretch, (stretch as f64 + 0.5) * grain)
}

impl<'a> Passing<'a> {
    /// `scene`, with the surfaces `relief` of `seed` and an error of the stated pitch in degrees, which a
    /// chair passes up to `end_m`.
    pub fn new(
        scene: &'a Scene,
        receiver: &'a Receiver<'a>,
        (seed, relief): (u64, Relief),
        (error_deg, end_m): (f64, f64),
    ) -> Self {
        // Made once, and not by every scene that is made of this one.
        scene.beats();
        Self {
            scene,
            seed,
            error_deg,
            end_m,
            receiver,
            relief,
            place: None,
            heard: None,
            all: None,
        }
    }

    /// The scene and its surfaces from `travel` metres on.
    pub fn from(&self, travel: f64) -> Result<(Scene, Relief)> {
        let scene = self.scene.from(travel, self.error_deg)?;
        let mut relief = self.relief.clone();
        relief.move_by(&self.scene.world, travel);
        Ok((scene, relief))
    }

    /// The echoes of `scene` with its surfaces that come back from `between` two mirror angles.
    pub fn echoes(&self, scene: &Scene, relief: &Relief, between: (f64, f64)) -> Vec<Echo> {
        let mut view = scene.view();
        view.between = between;
        view.echoes(relief, &mut Diffuse::Steady(self.seed))
    }

    /// The scene as the receiver sees it from where `shot` is fired, and the beat tones of its echoes.
    ///
    /// # Errors
    /// Says where the mirror has come to lie inside or behind a surface.
    pub fn tones(&mut self, shot: &Shot) -> Result<(&Scene, Vec<&Bundles>)> {
        let beam = self.go(shot)?;
        self.listen(shot.travel_m, beam)?;
        let (Some(place), Some(heard)) = (&self.place, &mut self.heard) else {
            return Ok((self.scene, Vec::new()));
        };
        let (here, receiver) = (&place.scene, self.receiver);
        let gain = receiver.gain(here.antenna_gain_dbi());
        let on = shot.travel_m - place.middle_m;
        for ((echo, from_middle), tone) in heard.near.iter().zip(&mut heard.tones) {
            let is_beside = (echo.back - beam).abs() > BESIDE;
            let moved = || here.tone(receiver, gain, &here.nearer(echo, on, shot.speed));
            *tone = match is_beside {
                true => *from_middle,
                false => moved().unwrap_or(*from_middle),
            };
        }
        heard.moved = Bundles::new(heard.tones.iter().copied());
        Ok((here, vec![&heard.moved, &heard.others]))
    }

    /// Goes to the stretch of the way where `shot` is fired, and says where the beam looks.
    fn go(&mut self, shot: &Shot) -> Result<f64> {
        let (at, middle_m) = stretch(shot.travel_m, GRAIN_M);
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

    /// Works out the echoes that `beam` needs, if those that were heard before do not do.
    fn listen(&mut self, travel: f64, beam: f64) -> Result<()> {
        let Some(place) = &self.place else {
            return Ok(());
        };
        let still = |h: &Heard| h.stretch == place.stretch && (beam - h.beam).abs() <= TURN;
        if self.heard.as_ref().is_some_and(still) {
            return Ok(());
        }
        let (coarse, middle_m) = stretch(travel, COARSE_M);
        if self.all.as_ref().is_none_or(|(at, _, _)| *at != coarse) {
            // Behind the end there may be a wall.
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
        self.heard = Some(Heard {
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
        let travel_m = 0.5 * GRAIN_M;
        let (here, relief) = passing.from(travel_m).unwrap();
        let echoes = passing.echoes(&here, &relief, EVERYWHERE);
        for angle_deg in [-15.0, 0.0, 20.0, 45.0] {
            let shot = Shot {
                travel_m,
                speed: 0.0,
                pitch_deg: 0.0,
                angle_deg,
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
            let heard = passing.heard.as_ref().unwrap();
            let near = heard
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
        };
        let (_, tones) = passing.tones(&shot).unwrap();
        assert!(tones.iter().any(|t| t.directions() > 0));
    }
}
