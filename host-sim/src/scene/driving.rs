//! Scans of one scene from a chair that drives on while the mirror turns.
//!
//! Every row is fired from where the chair is then. The echoes are worked out anew every centimetre;
//! in between each keeps its amplitude, its range and directions move with the chair, and the Doppler
//! shift of its speed is added to its beat; what lies far beside the beam waits for the next
//! centimetre. Surfaces stay the same surfaces, as in [`super::sequence`].

use core::f64::consts::{PI, TAU};

use anyhow::{Context, Result};

use super::maths::{LIGHT, Random, cis};
use super::receiver::Receiver;
use super::scatter::{Diffuse, Echo};
use super::sequence::{READING_SD, ROW_S, SCALE_MOST, SCALE_SD, SCAN_STREAMS, Stop, digits};
use super::spec::PlaneSpec;
use super::{CHIRPS, Scene, Tone};
use crate::recording::{Motion, Recording, Sequence};

/// Stream of random numbers for how the chair drives.
const DRIVES: u64 = 4;

/// The echoes are worked out anew after so much travel, metres: by then facets have come into view or
/// left it, and a beam at 30 cm has moved by a tenth of its width.
const GRAIN_M: f64 = 0.01;
/// Echoes this far beside the beam, two of its widths, come by side lobes alone, radians.
const BESIDE: f64 = 0.2;
/// From the last row of a scan to the first of the next one, s: the report, the mirror turning round.
const TURN_S: f64 = 0.1;
/// A joystick held by hand: the speed swings by this share, this often (Hz).
const SWING: f64 = 0.05;
const SWING_HZ: f64 = 0.4;
/// A driven chair rocks on its castors and springs: degrees, and Hz.
const ROCKING_DEG: f64 = 0.12;
const ROCKING_HZ: [f64; 2] = [1.0, 2.5];
/// Odometers tick in half millimetres, and slip by this much within this way, metres.
const TICK_M: f64 = 0.0005;
const SLIP_M: f64 = 0.0015;
const SLIP_WAY_M: f64 = 0.3;

/// Echoes with their places on the grid of beat tones.
type Heard = Vec<(Echo, Option<Tone>)>;

/// How a chair drives during one recording.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    scans: usize,
    speed: f64,
    row_s: f64,
    scale: f64,
    slip: f64,
    swing: f64,
    rocking: [f64; 2],
}

impl Drive {
    /// `scans` scans at `speed` metres a second.
    pub fn new(seed: u64, scans: usize, speed: f64) -> Self {
        let mut rng = Random::new(seed, DRIVES);
        Self {
            scans,
            speed,
            row_s: ROW_S[rng.index(ROW_S.len())],
            scale: 1.0 + (SCALE_SD * rng.normal()).clamp(-SCALE_MOST, SCALE_MOST),
            slip: rng.between(0.0, TAU),
            swing: rng.between(0.0, TAU),
            rocking: [
                rng.between(ROCKING_HZ[0], ROCKING_HZ[1]),
                rng.between(0.0, TAU),
            ],
        }
    }

    /// The same with a row every `row_s` seconds.
    pub fn with_rows(self, row_s: f64) -> Self {
        Self { row_s, ..self }
    }

    /// When row `k` of scan `scan` is fired, of `rows`.
    fn time(&self, scan: usize, k: usize, rows: usize) -> f64 {
        (scan * rows + k) as f64 * self.row_s + scan as f64 * (TURN_S - self.row_s)
    }

    fn phase(&self, time: f64) -> f64 {
        TAU * SWING_HZ * time + self.swing
    }

    /// True travel.
    fn travel(&self, time: f64) -> f64 {
        let swung = libm::cos(self.swing) - libm::cos(self.phase(time));
        self.speed * (time + SWING / (TAU * SWING_HZ) * swung)
    }

    /// True speed.
    fn speed(&self, time: f64) -> f64 {
        self.speed * (1.0 + SWING * libm::sin(self.phase(time)))
    }

    /// What odometry says.
    fn said(&self, travel: f64) -> f64 {
        let slip = |x: f64| SLIP_M * libm::sin(TAU * x / SLIP_WAY_M + self.slip);
        let said = travel * self.scale + slip(travel) - slip(0.0);
        libm::floor(said / TICK_M + 0.5) * TICK_M
    }

    /// Pitch against that of the scene file, degrees.
    fn rocking(&self, time: f64) -> f64 {
        let [hertz, start] = self.rocking;
        let moving = (self.speed / 0.1).min(1.0);
        moving * ROCKING_DEG * libm::sin(TAU * hertz * time + start)
    }

    /// True travel at the last row of `rows` of the last scan.
    pub fn length_m(&self, rows: usize) -> f64 {
        self.travel(self.time(self.scans - 1, rows - 1, rows))
    }
}

/// How much of a direction (a mirror angle less the tilt) runs forward, and how fast the angle grows
/// for each metre forward at a range of one.
fn ahead(plane: PlaneSpec, angle: f64) -> (f64, f64) {
    let (sin, cos) = libm::sincos(angle);
    match plane {
        PlaneSpec::Depth => (cos, sin),
        PlaneSpec::Height => (sin, -cos),
    }
}

impl Scene {
    /// Number of angles of a scan.
    pub fn rows(&self) -> usize {
        self.angles.len()
    }

    /// An echo `on` metres farther forward, at `speed` metres a second.
    fn nearer(&self, echo: &Echo, on: f64, speed: f64) -> Echo {
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

    /// Scans the scene `drive.scans` times from a chair that drives on, the mirror going back and forth.
    /// The same seed gives the same bytes on every host.
    ///
    /// # Errors
    /// Says where the mirror has come to lie inside or behind a surface.
    pub fn simulate_drive(&self, name: &str, seed: u64, drive: &Drive) -> Result<Recording> {
        let mut rng = Random::new(seed, DRIVES + 1);
        let drawn = (0.05 * rng.normal()).clamp(-0.1, 0.1);
        let base = self.spec.mount.pitch_deg;
        let error = base.map_or(drawn, |_| self.spec.mount.pitch_error_deg);
        let rows = self.angles.len();
        let length = drive.length_m(rows).max(0.0);
        let grains = (length / GRAIN_M) as usize + 1;
        let eyes: Vec<f64> = (0..=grains).map(|g| g as f64 * GRAIN_M).collect();
        let relief = self.relief(seed, &eyes);
        let receiver = Receiver::new(&self.spec.radar, &self.spec.receiver);
        let mut whole = self.empty_recording(name);
        let (mut motion, mut sequence) = (Motion::default(), Sequence::default());
        let mut seen: Option<(usize, Scene, Heard)> = None;
        for scan in 0..drive.scans {
            for k in 0..rows {
                let row = if scan % 2 == 0 { k } else { rows - 1 - k };
                let time = drive.time(scan, k, rows);
                let travel = drive.travel(time);
                let grain = (travel / GRAIN_M).max(0.0) as usize;
                if seen.as_ref().is_none_or(|(at, _, _)| *at != grain) {
                    let middle = (grain as f64 + 0.5) * GRAIN_M;
                    let here = self.from(middle, error)?;
                    let mut near = relief.clone();
                    near.move_by(&self.world, middle);
                    let echoes = here.view().echoes(&near, &mut Diffuse::Steady(seed));
                    let gain = receiver.gain(here.antenna_gain_dbi());
                    let pairs = echoes
                        .into_iter()
                        .map(|e| (e, here.tone(&receiver, gain, &e)));
                    let pairs = pairs.collect();
                    seen = Some((grain, here, pairs));
                }
                let pitch = base.unwrap_or(0.0) + drive.rocking(time);
                if let Some((_, here, echoes)) = &mut seen {
                    here.spec.mount.pitch_deg = Some(pitch);
                    let on = travel - (grain as f64 + 0.5) * GRAIN_M;
                    let speed = drive.speed(time);
                    let gain = receiver.gain(here.antenna_gain_dbi());
                    let tilt = here.spec.mount.tilt_deg(pitch);
                    let beam = (self.angles[row] + tilt).to_radians();
                    let tones = echoes.iter().filter_map(|(echo, tone)| {
                        if (echo.back - beam).abs() > BESIDE {
                            return *tone;
                        }
                        here.tone(&receiver, gain, &here.nearer(echo, on, speed))
                    });
                    let tones: Vec<Tone> = tones.collect();
                    let stream = CHIRPS + scan as u64 * SCAN_STREAMS + row as u64;
                    let mut random = Random::new(seed, stream);
                    let (chirp, _) = here.chirp(&receiver, &tones, row, &mut random);
                    whole.samples.extend(chirp);
                }
                whole.meta.angles_deg.push(self.angles[row]);
                let reading = pitch + READING_SD * rng.normal();
                motion.pitch_deg.push(digits(reading, 1e3));
                motion.travel_m.push(digits(drive.said(travel), 1e4));
                motion.time_s.push(digits(time, 1e5));
            }
            let end = drive.travel(drive.time(scan, rows - 1, rows));
            // From where the scan ended a standing chair would see how strong each step is.
            let here = self.from(end, error)?;
            let mut near = relief.clone();
            near.move_by(&self.world, end);
            let echoes = here.view().echoes(&near, &mut Diffuse::Steady(seed));
            let tones = here.place(&receiver, &echoes);
            let stream = CHIRPS + (drive.scans + scan) as u64 * SCAN_STREAMS;
            let there = here.scan(&receiver, &tones, (seed, stream));
            sequence.truth.push(there.truth);
            sequence.truth_travel_m.push(digits(end, 1e5));
        }
        sequence.scans = drive.scans;
        whole.meta.motion = motion;
        whole.meta.truth = Some(self.truth());
        whole.meta.sequence = sequence;
        Ok(whole)
    }

    /// The scene from `travel` metres on, level as the scene file says.
    fn from(&self, travel: f64, error: f64) -> Result<Self> {
        let stop = Stop {
            travel_m: [travel; 2],
            rocking_deg: 0.0,
        };
        self.at(&stop, error)
            .with_context(|| format!("{travel:.3} m on"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLIGHT: &str = "[[stairs]]\ndistance_m = 1.4\ncount = 2\nrise_m = 0.17\ngoing_m = 0.29\n\
                          material = \"concrete\"\n[[floor]]\nmaterial = \"concrete\"\n";

    #[test]
    fn travel_is_what_the_speed_adds_up_to() {
        let drive = Drive::new(5, 3, 0.3);
        let (mut travel, step) = (0.0, 1e-4);
        for k in 0..40_000 {
            let time = k as f64 * step;
            assert!((drive.travel(time) - travel).abs() < 1e-4, "{time}");
            travel += step * drive.speed(time + 0.5 * step);
        }
    }

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
    fn a_drive_says_where_it_was_at_every_row() {
        let scene = Scene::parse(FLIGHT).unwrap();
        let drive = Drive::new(3, 2, 0.2).with_rows(4.63e-3);
        let recording = scene.simulate_drive("drive", 3, &drive).unwrap();
        let meta = &recording.meta;
        assert_eq!((recording.scans(), meta.angles_deg.len()), (2, 2 * 281));
        let travel = &meta.sequence.truth_travel_m;
        for (k, truth) in meta.sequence.truth.iter().enumerate() {
            let from_here = truth.steps[0].distance_m;
            assert!((from_here + travel[k] - 1.4).abs() < 2e-5, "{from_here}");
            let said = meta.motion.travel_m[281 * (k + 1) - 1];
            assert!((said - travel[k]).abs() < 0.02 * travel[k] + 0.005);
        }
        assert!(travel[0] > 0.2 && meta.motion.travel_m[140] > 0.08);
        let again = scene.simulate_drive("drive", 3, &drive).unwrap();
        assert_eq!(recording.samples, again.samples);
    }
}
