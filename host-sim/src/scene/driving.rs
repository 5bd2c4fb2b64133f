//! Scans of one scene from a chair that drives on while the mirror turns.
//!
//! Every row is simulated from the chair's position at its time: of full scans by `passing.rs`, of
//! guard sweeps by `way.rs`. All rows see the same surfaces, as in [`super::sequence`].

use core::f64::consts::TAU;

use anyhow::Result;
use stairscan::Iq;

use super::maths::Random;
use super::passing::{FINE_STEP_M, Passing, Shot};
use super::receiver::Receiver;
use super::scatter::EVERYWHERE;
use super::sequence::{MAX_SCALE_ERROR, READING_SD, ROW_S, SCALE_SD, SCAN_STREAMS, digits};
use super::way::Way;
use super::{CHIRPS, Scene};
use crate::recording::{Motion, Recording, Sequence};

/// Stream of the random numbers of the chair's motion.
const DRIVES: u64 = 4;

/// Time from the last row of a scan to the first row of the next one, s: the report and the
/// mirror's return.
const TURN_S: f64 = 0.1;
/// Relative amplitude of the slow oscillation of the chair's speed with a joystick held by hand.
pub const SWING: f64 = 0.05;
/// Frequency of the slow oscillation of the chair's speed, Hz.
pub const SWING_HZ: f64 = 0.4;
/// Amplitude, degrees, and range of frequencies, Hz, of a driven chair's rocking on its castors and
/// springs.
const ROCKING_DEG: f64 = 0.12;
const ROCKING_HZ: [f64; 2] = [1.0, 2.5];
/// Resolution of the odometer, amplitude of its slip, and the travel over which the slip repeats,
/// metres.
const TICK_M: f64 = 0.0005;
const SLIP_M: f64 = 0.0015;
const SLIP_WAY_M: f64 = 0.3;

/// A chair's odometer, with its errors: scale and periodic slip.
#[derive(Clone, Copy, Debug)]
pub struct Odometer {
    scale: f64,
    slip: f64,
}

impl Odometer {
    /// Draws the errors of an odometer.
    pub fn draw(rng: &mut Random) -> Self {
        Self {
            scale: 1.0 + (SCALE_SD * rng.normal()).clamp(-MAX_SCALE_ERROR, MAX_SCALE_ERROR),
            slip: rng.between(0.0, TAU),
        }
    }

    /// Returns the odometer's reading after a true travel of `travel` metres, metres.
    pub fn reading_m(&self, travel: f64) -> f64 {
        let slip = |x: f64| SLIP_M * libm::sin(TAU * x / SLIP_WAY_M + self.slip);
        let said = travel * self.scale + slip(travel) - slip(0.0);
        libm::floor(said / TICK_M + 0.5) * TICK_M
    }
}

/// Pitch oscillation of a driven chair on its castors and springs.
#[derive(Clone, Copy, Debug)]
pub struct Rocking {
    hertz: f64,
    start: f64,
}

impl Rocking {
    /// Draws frequency and phase of a chair's rocking.
    pub fn draw(rng: &mut Random) -> Self {
        Self {
            hertz: rng.between(ROCKING_HZ[0], ROCKING_HZ[1]),
            start: rng.between(0.0, TAU),
        }
    }

    /// Returns the pitch of a chair at `speed` m/s relative to that at rest, degrees, at `time` seconds.
    pub fn deg(&self, speed: f64, time: f64) -> f64 {
        let moving = (speed / 0.1).min(1.0);
        moving * ROCKING_DEG * libm::sin(TAU * self.hertz * time + self.start)
    }
}

/// Motion of a chair during one recording.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    scans: usize,
    speed: f64,
    row_s: f64,
    odometer: Odometer,
    swing: f64,
    rocking: Rocking,
}

impl Drive {
    /// Creates a drive of `scans` scans at `speed` metres per second.
    pub fn new(seed: u64, scans: usize, speed: f64) -> Self {
        let mut rng = Random::new(seed, DRIVES);
        Self {
            scans,
            speed,
            row_s: ROW_S[rng.index(ROW_S.len())],
            odometer: Odometer::draw(&mut rng),
            swing: rng.between(0.0, TAU),
            rocking: Rocking::draw(&mut rng),
        }
    }

    /// Returns the drive with a row every `row_s` seconds.
    pub fn with_rows(self, row_s: f64) -> Self {
        Self { row_s, ..self }
    }

    /// Returns the time at which row `k` of `rows` (in the order of observation) of scan `scan` is fired, seconds from
    /// the drive's first row.
    fn time(&self, scan: usize, k: usize, rows: usize) -> f64 {
        (scan * rows + k) as f64 * self.row_s + scan as f64 * (TURN_S - self.row_s)
    }

    fn phase(&self, time: f64) -> f64 {
        TAU * SWING_HZ * time + self.swing
    }

    /// Returns the true travel from the drive's first row, metres.
    fn travel(&self, time: f64) -> f64 {
        let swung = libm::cos(self.swing) - libm::cos(self.phase(time));
        self.speed * (time + SWING / (TAU * SWING_HZ) * swung)
    }

    /// Returns the true speed, m/s.
    fn speed(&self, time: f64) -> f64 {
        self.speed * (1.0 + SWING * libm::sin(self.phase(time)))
    }

    /// Returns the true travel at the last row of `rows` of the last scan, metres.
    pub fn length_m(&self, rows: usize) -> f64 {
        self.travel(self.time(self.scans - 1, rows - 1, rows))
    }
}

impl Scene {
    /// Returns the number of angles (rows) of a scan.
    pub fn rows(&self) -> usize {
        self.angles.len()
    }

    /// Simulates `drive.scans` scans of the scene from a driving chair, alternately forward and
    /// backward. The same seed gives the same bytes on every host.
    ///
    /// # Errors
    /// Names the place at which the mirror lies inside or behind a surface.
    pub fn simulate_drive(&self, name: &str, seed: u64, drive: &Drive) -> Result<Recording> {
        self.check_one_chirp()?;
        let course = Course::new(self, seed, drive);
        let relief = self.relief(seed, &course.eyes());
        let receiver = Receiver::new(&self.spec.radar, &self.spec.receiver);
        let place = (course.error_deg, course.length_m);
        let mut passing = Passing::new(self, &receiver, (seed, relief), place);
        let mut sequence = Sequence::default();
        let mut whole = course.record(name, |shot, (scan, row)| {
            let (here, tones) = passing.tones(shot)?;
            let stream = CHIRPS + scan as u64 * SCAN_STREAMS + row as u64;
            let mut random = Random::new(seed, stream);
            let at = (row, shot.time_s);
            Ok(here.chirp(&receiver, &tones, at, &mut random).0)
        })?;
        for scan in 0..drive.scans {
            // The truth's signal-to-noise ratios are those of a chair that stands where the scan
            // ended.
            let end = course.end_m(scan);
            let (here, near) = passing.from(end)?;
            let echoes = passing.echoes(&here, &near, EVERYWHERE);
            let tones = here.place(&receiver, &echoes);
            let stream = CHIRPS + (drive.scans + scan) as u64 * SCAN_STREAMS;
            let there = here.scan(&receiver, &tones, (seed, stream));
            sequence.truth.push(there.truth);
            sequence.truth_travel_m.push(digits(end, 1e5));
        }
        sequence.scans = drive.scans;
        whole.meta.sequence = sequence;
        Ok(whole)
    }

    /// Simulates `drive.scans` guard sweeps of the scene from a driving chair. The echoes are those
    /// of a [`Way`], some forty times faster than [`Scene::simulate_drive`]; the truth has no
    /// signal-to-noise ratios.
    ///
    /// # Errors
    /// Names the place at which the mirror lies inside or behind a surface.
    pub fn simulate_sweeps(&self, name: &str, seed: u64, drive: &Drive) -> Result<Recording> {
        self.check_one_chirp()?;
        let course = Course::new(self, seed, drive);
        let way = Way::new(self, seed, course.length_m);
        let mut whole = course.record(name, |shot, (scan, row)| {
            way.chirp(shot, row, (0, (scan * self.rows() + row) as u64))
        })?;
        let mut sequence = Sequence::default();
        for scan in 0..drive.scans {
            let end = course.end_m(scan);
            sequence
                .truth
                .push(self.from(end, course.error_deg)?.truth());
            sequence.truth_travel_m.push(digits(end, 1e5));
        }
        sequence.scans = drive.scans;
        whole.meta.sequence = sequence;
        Ok(whole)
    }
}

/// One drive through a scene: which row is fired from which position, and what the chair's sensors report.
struct Course<'a> {
    scene: &'a Scene,
    drive: &'a Drive,
    /// Chair's true pitch less the recorded one, degrees.
    error_deg: f64,
    length_m: f64,
    /// Random numbers of the sensors' noise, whose first number gave `error_deg`.
    rng: Random,
}

impl<'a> Course<'a> {
    fn new(scene: &'a Scene, seed: u64, drive: &'a Drive) -> Self {
        let mut rng = Random::new(seed, DRIVES + 1);
        let drawn = (0.05 * rng.normal()).clamp(-0.1, 0.1);
        let mount = &scene.spec.mount;
        Self {
            scene,
            drive,
            error_deg: mount.pitch_deg.map_or(drawn, |_| mount.pitch_error_deg),
            length_m: drive.length_m(scene.rows()).max(0.0),
            rng,
        }
    }

    /// Returns the positions on the way from which surfaces are seen, metres of travel, every [`FINE_STEP_M`].
    fn eyes(&self) -> Vec<f64> {
        let grains = (self.length_m / FINE_STEP_M) as usize + 1;
        (0..=grains).map(|g| g as f64 * FINE_STEP_M).collect()
    }

    /// Returns the true travel at the last row of a scan, metres.
    fn end_m(&self, scan: usize) -> f64 {
        let rows = self.scene.rows();
        self.drive.travel(self.drive.time(scan, rows - 1, rows))
    }

    /// Returns the recording of the drive without the metadata of the sequence, which the caller adds; `chirp`
    /// simulates the chirp of a scan and row.
    ///
    /// # Errors Those of `chirp`.
    fn record(
        &self,
        name: &str,
        mut chirp: impl FnMut(&Shot, (usize, usize)) -> Result<Vec<Iq>>,
    ) -> Result<Recording> {
        let (scene, drive, mut rng) = (self.scene, self.drive, self.rng.clone());
        let (base, rows) = (scene.spec.mount.pitch_deg, scene.rows());
        let (mut whole, mut motion) = (scene.empty_recording(name), Motion::default());
        for scan in 0..drive.scans {
            for k in 0..rows {
                let row = if scan % 2 == 0 { k } else { rows - 1 - k };
                let time = drive.time(scan, k, rows);
                let travel = drive.travel(time);
                let pitch = base.unwrap_or(0.0) + drive.rocking.deg(drive.speed, time);
                let shot = Shot {
                    travel_m: travel,
                    speed: drive.speed(time),
                    pitch_deg: pitch,
                    angle_deg: scene.angles[row],
                    time_s: time,
                };
                whole.samples.extend(chirp(&shot, (scan, row))?);
                whole.meta.angles_deg.push(scene.angles[row]);
                let reading = pitch + READING_SD * rng.normal();
                motion.pitch_deg.push(digits(reading, 1e3));
                motion
                    .travel_m
                    .push(digits(drive.odometer.reading_m(travel), 1e4));
                motion.time_s.push(digits(time, 1e5));
            }
        }
        whole.meta.motion = motion;
        whole.meta.truth = Some(scene.truth());
        Ok(whole)
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
