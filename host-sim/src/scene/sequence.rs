//! Several scans of one scene from an approaching chair, which stands while the mirror turns and
//! drives on in between.
//!
//! All scans see the same surfaces: their relief is drawn once for all places, and the diffuse part
//! keeps its scatterers ([`super::scatter::Diffuse::Steady`]). The chair drives across the edges,
//! with a yaw obliquely. Odometry and inclinometer have typical errors.

use anyhow::{Context, Result};

use super::maths::Random;
use super::receiver::Receiver;
use super::scatter::Diffuse;
use super::spec::SceneSpec;
use super::{CHIRPS, Scene, check};
use crate::recording::{Motion, Recording, Sequence};

/// Number of the stream of random numbers for the stops; the next one is for the sensors.
const STOPS: u64 = 2;

/// Number of random streams reserved for the chirps of one scan.
pub(super) const SCAN_STREAMS: u64 = 1024;

/// Errors of odometry: standard deviation and maximum of the relative scale error (tyre pressure and load), and
/// standard deviation of the slip per stop, which adds up, metres.
pub(super) const SCALE_SD: f64 = 0.01;
pub(super) const MAX_SCALE_ERROR: f64 = 0.02;
const WANDER_SD: f64 = 0.0015;

/// Standard deviation of a standing chair's pitch from stop to stop, degrees, by floors, castors and drivers.
const ROCKING_SD: f64 = 0.15;
/// Standard deviation of an inclinometer's single readings, degrees.
pub const READING_SD: f64 = 0.02;

/// Row periods, s: 281 rows in 1.3 or 5.7 s.
pub(super) const ROW_S: [f64; 2] = [4.63e-3, 20.3e-3];
/// Speed between stops, m/s, and time to come to rest at a stop, s.
const SPEED: f64 = 0.25;
const REST_S: f64 = 0.5;

/// Position of the chair during one scan.
#[derive(Clone, Copy, Debug)]
pub struct Stop {
    /// Forward travel since the first stop, metres: the true travel, then that by odometry.
    pub travel_m: [f64; 2],
    /// Pitch of the chair relative to that of the scene file, degrees.
    pub rocking_deg: f64,
}

/// The stops of one approach.
#[derive(Clone, Debug)]
pub struct Approach {
    /// All stops in order; the first has travel 0.
    pub stops: Vec<Stop>,
    row_s: f64,
}

impl Approach {
    /// Draws `scans` stops, `step_m` metres apart in the mean and up to 40 % less or more.
    pub fn new(seed: u64, scans: usize, step_m: f64) -> Self {
        let mut rng = Random::new(seed, STOPS);
        let row_s = ROW_S[rng.index(ROW_S.len())];
        let scale = 1.0 + (SCALE_SD * rng.normal()).clamp(-MAX_SCALE_ERROR, MAX_SCALE_ERROR);
        let (mut travel, mut wander) = (0.0, 0.0);
        let stops = (0..scans)
            .map(|k| {
                if k > 0 {
                    travel += step_m * rng.between(0.6, 1.4);
                    wander += WANDER_SD * rng.normal();
                }
                Stop {
                    travel_m: [travel, travel * scale + wander],
                    rocking_deg: ROCKING_SD * rng.normal(),
                }
            })
            .collect();
        Self { stops, row_s }
    }

    /// Returns the true travel from the first to the last stop, metres.
    pub fn length_m(&self) -> f64 {
        self.stops.last().map_or(0.0, |s| s.travel_m[0])
    }
}

/// Returns the scene as seen from `by` metres farther back. The floor that the chair stands on moves with the chair.
pub fn pushed(mut spec: SceneSpec, by: f64) -> SceneSpec {
    for s in &mut spec.stairs {
        s.distance_m += by;
    }
    for f in &mut spec.floor {
        f.to_m = f.to_m.map(|x| x + by);
        f.from_m += if f.from_m > 0.0 { by } else { 0.0 };
    }
    for r in &mut spec.ramp {
        r.from_m += by;
        r.to_m += by;
    }
    for w in &mut spec.wall {
        w.at_m += by;
    }
    for p in &mut spec.post {
        p.at_m += by;
    }
    for b in &mut spec.boxes {
        b.from_m += by;
        b.to_m += by;
    }
    for d in &mut spec.door {
        d.at_m += by;
    }
    for p in &mut spec.polyline {
        for point in &mut p.points {
            point[0] += by;
        }
    }
    spec
}

impl Scene {
    /// Returns the scene as seen from `stop`; `error_deg` is the true pitch less the recorded one, degrees.
    pub(super) fn at(&self, stop: &Stop, error_deg: f64) -> Result<Self> {
        let mut spec = self.spec.clone();
        let mount = &mut spec.mount;
        let pitch = mount.pitch_deg.unwrap_or(0.0) + stop.rocking_deg;
        mount.pitch_deg = Some(pitch);
        mount.pitch_error_deg = error_deg;
        let world = self.world.moved(stop.travel_m[0]);
        check::world(&spec, &world, self.eye)?;
        Ok(Self {
            spec,
            world,
            materials: self.materials.clone(),
            eye: self.eye,
            beam: self.beam.clone(),
            beats: self.beats.clone(),
            angles: self.angles.clone(),
        })
    }

    /// Simulates a scan from every stop, alternately forward and backward. The same seed gives the
    /// same bytes on every host.
    ///
    /// # Errors
    /// Names the scan before which the mirror lies inside or behind a surface.
    pub fn simulate_approach(
        &self,
        name: &str,
        seed: u64,
        approach: &Approach,
    ) -> Result<Recording> {
        // The inclinometer's error is constant for the whole approach.
        let mut rng = Random::new(seed, STOPS + 1);
        let drawn = (0.05 * rng.normal()).clamp(-0.1, 0.1);
        let error = match self.spec.mount.pitch_deg {
            Some(_) => self.spec.mount.pitch_error_deg,
            None => drawn,
        };
        let travels: Vec<f64> = approach.stops.iter().map(|s| s.travel_m[0]).collect();
        let relief = self.relief(seed, &travels);
        let receiver = Receiver::new(&self.spec.radar, &self.spec.receiver);
        let mut whole = self.empty_recording(name);
        let (mut motion, mut truths) = (Motion::default(), Vec::new());
        let mut time = 0.0;
        for (k, stop) in approach.stops.iter().enumerate() {
            let here = self.at(stop, error).with_context(|| {
                format!(
                    "scan {} of the approach, {:.3} m on",
                    k + 1,
                    stop.travel_m[0]
                )
            })?;
            let mut seen = relief.clone();
            seen.move_by(&self.world, stop.travel_m[0]);
            let echoes = here.view().echoes(&seen, &mut Diffuse::Steady(seed));
            let tones = here.place(&receiver, &echoes);
            let first = CHIRPS + k as u64 * SCAN_STREAMS;
            let scan = here.scan(&receiver, &tones, (seed, first));
            let mut rows: Vec<usize> = (0..self.angles.len()).collect();
            if k % 2 == 1 {
                rows.reverse();
            }
            for row in rows {
                whole.samples.extend(&scan.chirps[row]);
                whole.meta.angles_deg.push(self.angles[row]);
                let reading = here.spec.mount.pitch_deg.unwrap_or(0.0) + READING_SD * rng.normal();
                motion.pitch_deg.push(digits(reading, 1e3));
                motion.travel_m.push(digits(stop.travel_m[1], 1e4));
                motion.time_s.push(digits(time, 1e5));
                time += approach.row_s;
            }
            let on = approach
                .stops
                .get(k + 1)
                .map_or(0.0, |n| n.travel_m[0] - stop.travel_m[0]);
            time += on / SPEED + REST_S;
            truths.push(scan.truth);
        }
        whole.meta.motion = motion;
        whole.meta.truth = truths.first().cloned();
        whole.meta.sequence = Sequence {
            scans: approach.stops.len(),
            truth: truths,
            truth_travel_m: travels.iter().map(|t| digits(*t, 1e5)).collect(),
        };
        Ok(whole)
    }
}

/// Returns `x` rounded to a multiple of `1 / per`, and never -0.
pub fn digits(x: f64, per: f64) -> f64 {
    libm::floor(x * per + 0.5) / per + 0.0
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::random::{Kind, random};
    use crate::scene::maths::{LIGHT, cis};
    use crate::scene::scatter::Echo;

    const FLIGHT: &str = "[[stairs]]\ndistance_m = 1.0\ncount = 2\nrise_m = 0.17\ngoing_m = 0.29\n\
                          material = \"concrete\"\n[[floor]]\nmaterial = \"concrete\"\n";

    fn approach(step: f64) -> Recording {
        let scene = Scene::parse(FLIGHT).unwrap();
        scene
            .simulate_approach("near", 3, &Approach::new(3, 3, step))
            .unwrap()
    }

    #[test]
    fn an_approach_says_where_it_stood_and_what_is_true_from_there() {
        let recording = approach(0.1);
        let meta = &recording.meta;
        let travel = &meta.sequence.truth_travel_m;
        assert_eq!((meta.sequence.scans, meta.angles_deg.len()), (3, 3 * 281));
        assert_eq!(travel[0], 0.0);
        for (k, truth) in meta.sequence.truth.iter().enumerate() {
            let from_here = truth.steps[0].distance_m;
            assert!((from_here + travel[k] - 1.0).abs() < 2e-5, "{from_here}");
            assert_eq!(truth.steps.len(), 2);
            // Standing: odometry gives the same reading for all rows, 2 % and some millimetres off.
            let said = &meta.motion.travel_m[281 * k..281 * (k + 1)];
            assert!(said.iter().all(|s| *s == said[0]));
            assert!((said[0] - travel[k]).abs() < 0.02 * travel[k] + 0.01);
            let rising = meta.angles_deg[281 * k] < meta.angles_deg[281 * k + 1];
            assert_eq!(rising, k % 2 == 0);
        }
        assert_eq!(meta.truth.as_ref(), meta.sequence.truth.first());
        assert!(meta.motion.time_s.windows(2).all(|w| w[0] < w[1]));
        let again = approach(0.1);
        assert_eq!(recording.samples, again.samples);
    }

    #[test]
    fn an_approach_reads_back_as_it_was_written() {
        let dir = std::env::temp_dir().join(format!("stairscan-approach-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let written = approach(0.1);
        written.write(&dir.join("near")).unwrap();
        let read = Recording::read(&dir.join("near")).unwrap();
        std::fs::remove_dir_all(&dir).unwrap();
        assert_eq!(read.samples, written.samples);
        assert_eq!(read.meta.motion, written.meta.motion);
        assert_eq!(read.meta.sequence, written.meta.sequence);
    }

    /// Returns the echoes of a scene after the travel `travels[k]`, metres, over surfaces drawn once for all `travels`.
    fn after(scene: &Scene, travels: &[f64], k: usize, seed: u64) -> Vec<Echo> {
        let stop = Stop {
            travel_m: [travels[k]; 2],
            rocking_deg: 0.0,
        };
        let here = scene.at(&stop, 0.0).unwrap();
        let mut relief = scene.relief(seed, travels);
        relief.move_by(&scene.world, travels[k]);
        here.view().echoes(&relief, &mut Diffuse::Steady(seed))
    }

    #[test]
    fn surfaces_stay_the_same_surface_and_look_another_from_farther_on() {
        // A floor that scatters diffusely, facet by facet: a millimetre on, the echo less its phase
        // along the way is the same. Half a metre on, the wave front has another curvature over the
        // width of the beam, and the sum differs in part.
        let scene = Scene::parse(
            "[material.dull]\npermittivity = 1.0\nconductivity = 0.0\nroughness_m = 0.0\n\
             diffuse_db = -10.0\n[[floor]]\nfrom_m = 1.2\nto_m = 1.4\nmaterial = \"dull\"\n",
        )
        .unwrap();
        let wave = 4.0 * core::f64::consts::PI * 94e9 / LIGHT;
        let travels = [0.0, 0.001, 0.5];
        let seen = [0, 1, 2].map(|k| -> Vec<Complex64> {
            let echoes = after(&scene, &travels, k, 7);
            let lit = echoes.iter().filter(|e| e.amplitude.norm_sqr() > 1e-20);
            lit.map(|e| e.amplitude * cis(-wave * e.range)).collect()
        });
        let alike = |a: &[Complex64], b: &[Complex64]| {
            let product: Complex64 = a.iter().zip(b).map(|(x, y)| x * y.conj()).sum();
            let power = |v: &[Complex64]| v.iter().map(Complex64::norm_sqr).sum::<f64>();
            product.norm_sqr().sqrt() / (power(a) * power(b)).sqrt()
        };
        assert!(seen[0].len() > 200 && seen[0].len() == seen[2].len());
        let (near, far) = (alike(&seen[0], &seen[1]), alike(&seen[0], &seen[2]));
        assert!(near > 0.99 && far < 0.9, "{near} {far}");
    }

    #[test]
    fn steady_scatterers_are_as_strong_as_fresh_ones() {
        let scene = Scene::parse(
            "[material.dull]\npermittivity = 1.0\nconductivity = 0.0\nroughness_m = 0.0\n\
             diffuse_db = -10.0\n[[floor]]\nfrom_m = 0.9\nto_m = 1.1\nmaterial = \"dull\"\n",
        )
        .unwrap();
        let power = |echoes: Vec<Echo>| echoes.iter().map(|e| e.amplitude.norm_sqr()).sum::<f64>();
        let steady: f64 = (0..40).map(|s| power(after(&scene, &[0.0], 0, s))).sum();
        let fresh: f64 = (0..40).map(|s| power(scene.echoes(s))).sum();
        assert!((steady / fresh - 1.0).abs() < 0.05, "{}", steady / fresh);
    }

    #[test]
    fn a_chair_does_not_drive_into_a_wall() {
        let scene = Scene::parse("[[wall]]\nat_m = 0.3\nmaterial = \"plaster\"\n").unwrap();
        let error = scene.simulate_approach("wall", 1, &Approach::new(1, 5, 0.2));
        let message = format!("{:#}", error.unwrap_err());
        assert!(message.starts_with("scan 3 of the approach"), "{message}");
        assert!(
            message.contains("the mirror lies inside or behind"),
            "{message}"
        );
    }

    #[test]
    fn every_kind_can_be_approached() {
        for kind in Kind::every() {
            for seed in 0..20 {
                let way = Approach::new(seed, 5, 0.1);
                let scene = Scene::new(pushed(random(kind, seed), way.length_m()))
                    .unwrap_or_else(|e| panic!("{kind} {seed}: {e}"));
                for stop in &way.stops {
                    scene
                        .at(stop, 0.0)
                        .unwrap_or_else(|e| panic!("{kind} {seed}: {e}"));
                }
                let last = scene.at(&way.stops[4], 0.0).unwrap().truth();
                let drawn = Scene::new(random(kind, seed)).unwrap().truth();
                if let (Some(a), Some(b)) = (last.steps.first(), drawn.steps.first()) {
                    assert!((a.distance_m - b.distance_m).abs() < 1e-4 || a.height_m != b.height_m);
                }
            }
        }
    }
}
