//! The simulated world of a drive: chair, controller and scene. In: a trigger for each row and a
//! sentence after each sweep. Out: the chirp from the chair's position at that time.
//!
//! The rows set the time: 31 of them, 2.8 ms apart, ten times a second. The chair's place at the
//! next row is known when a row is fired, because commands act only after the chair's latency.

use std::cell::RefCell;
use std::rc::Rc;

use anyhow::{Context, Error, Result};
use stairscan::Iq;
use stairscan::report::GuardLine;

use super::chair::{CYCLE_S, Chair, Pose};
use super::controller::{Controller, FRONT_M, GuardInput};
use super::course::Course;
use super::log::{DriveLog, End, StepIn, SweepLog};
use super::plan::Plan;
use host_sim::motion::Timetable;
use host_sim::motion::place::Place;
use host_sim::recording::Recording;
use host_sim::scene::maths::Random;
use host_sim::scene::sequence::{READING_SD, digits};
use host_sim::scene::way::{Shot, Way};
use host_sim::sweeps::ground::{self, Meter};
use host_sim::sweeps::scenes::{ROW_S, SWEEP_S};
use host_sim::sweeps::score;

/// Number of rows of a guard sweep.
pub const ROWS: usize = 31;
/// Time from a sweep's last row to the first byte of its sentence, seconds: 590,000 instructions,
/// docs/design/guard.md.
const SENTENCE_LATENCY_S: f64 = 0.005;
/// Duration of one byte on the report UART at 115,200 baud, seconds.
const BYTE_S: f64 = 10.0 / 115_200.0;
/// Time for which a chair must stand with the joystick forward to count as stopped, seconds.
const STOP_TIME_S: f64 = 1.5;
/// Speed below which a chair counts as standing, m/s.
const STANDING_M_S: f64 = 0.005;
/// Maximum duration of a drive, seconds.
const LONGEST_S: f64 = 60.0;
/// First of the streams of random numbers for a drive's inclinometer: drive `n` uses `STREAM + n`.
const STREAM: u64 = 0x4452_4956_5000;

/// State of a drive under way.
pub struct World<'a> {
    course: &'a Course,
    ways: &'a [Option<Way<'a>>; 2],
    number: u64,
    plan: Plan,
    rng: Random,
    chair: Chair,
    controller: Controller,
    /// Time of arrival, seconds, and content of the sentence that is being sent to the controller.
    pending_sentence: Option<(f64, GuardInput)>,
    meter: Meter,
    /// Rows of the last [`ground::SWEEPS`] sweeps, from which the range of the ground's echo is
    /// computed.
    rows: Vec<ground::Row>,
    /// Receives the odometer and inclinometer readings that are sent to the scanner as motion
    /// sentences; `None` before [`Self::begin`].
    timetable: Option<Rc<RefCell<Timetable>>>,
    /// The recording of the drive, without samples unless they are to be kept.
    pub recording: Recording,
    is_kept: bool,
    is_joined: bool,
    stood_s: f64,
    end: Option<End>,
    failed: Option<Error>,
    log: DriveLog,
}

/// Returns the time at which row `number` of a drive (from 0, over all sweeps) is fired, seconds.
fn time_s(number: usize) -> f64 {
    (number / ROWS) as f64 * SWEEP_S + (number % ROWS) as f64 * ROW_S
}

impl<'a> World<'a> {
    /// Begins drive `number` along a course. `is_kept` says whether its samples are kept.
    ///
    /// # Errors
    /// Names what the scene's scanner lacks.
    pub fn new(
        course: &'a Course,
        ways: &'a [Option<Way<'a>>; 2],
        number: u64,
        is_kept: bool,
    ) -> Result<Self> {
        let plan = Plan::draw(course.seed, number);
        let recording = course.scene().no_sweeps(&course.name, ROWS);
        let name = format!("{}-{number}", course.name);
        let mut world = Self {
            course,
            ways,
            number,
            chair: Chair::new(&plan),
            plan,
            rng: Random::new(course.seed, STREAM + number),
            controller: Controller::default(),
            pending_sentence: None,
            meter: Meter::new(&recording.meta)?,
            rows: Vec::new(),
            timetable: None,
            recording,
            is_kept,
            is_joined: !course.is_joined(),
            stood_s: 0.0,
            end: None,
            failed: None,
            log: DriveLog {
                name,
                sweeps: Vec::new(),
                hazard: None,
                beside: course.beside,
                step_in: None,
                end: End::Stood,
                travel_m: 0.0,
                time_s: 0.0,
            },
        };
        world.place(0);
        Ok(world)
    }

    /// Sets the timetable by which motion sentences are sent from now on; it already has those of
    /// the first row. Clears the recording's samples and angles, which only the set-up needed.
    pub fn begin(&mut self, timetable: Rc<RefCell<Timetable>>) {
        self.timetable = Some(timetable);
        self.recording.samples.clear();
        self.recording.meta.angles_deg.clear();
    }

    /// Returns the chair's pitch at `time_s` (seconds), degrees: the scene's plus that of rocking.
    fn pitch_deg(&mut self, time_s: f64) -> f64 {
        let speed = self.chair.at(time_s).speed_m_s;
        self.course.scene().pitch_deg() + self.plan.rocking.deg(speed, time_s)
    }

    /// Records odometer and inclinometer readings at row `number` of the drive, and sends them to
    /// the scanner.
    fn place(&mut self, number: usize) {
        let time = time_s(number);
        let odometer_m = self.plan.odometer.reading_m(self.chair.at(time).travel_m);
        let reading = self.pitch_deg(time) + READING_SD * self.rng.normal();
        let place = Place {
            time_s: digits(time, 1e5),
            travel_m: digits(odometer_m, 1e4),
            pitch_deg: digits(reading, 1e3),
        };
        let motion = &mut self.recording.meta.motion;
        motion.time_s.push(place.time_s);
        motion.travel_m.push(place.travel_m);
        motion.pitch_deg.push(place.pitch_deg);
        if let Some(timetable) = &self.timetable {
            timetable.borrow_mut().push(&place);
        }
    }

    /// Returns the chirp of row `number` of the drive, which is row `row` of the sweep; `None`
    /// where it cannot be simulated.
    pub fn fire(&mut self, number: usize, row: usize) -> Option<Vec<Iq>> {
        let chirp = self.chirp(number, row);
        chirp.map_err(|error| self.failed = Some(error)).ok()
    }

    /// Checks that the last chirp could be simulated.
    ///
    /// # Errors
    /// Names the place at which the mirror lies inside or behind a surface.
    pub fn check(&mut self) -> Result<()> {
        self.failed.take().map_or(Ok(()), Err)
    }

    /// Returns the chirp of row `number` of the drive, row `row` of the sweep, after it has
    /// simulated all events before that row.
    fn chirp(&mut self, number: usize, row: usize) -> Result<Vec<Iq>> {
        let time = time_s(number);
        self.control(time);
        self.place(number + 1);
        let pose = self.chair.at(time);
        self.update_end(&pose, time);
        let shot = Shot {
            travel_m: pose.travel_m,
            speed: pose.speed_m_s,
            pitch_deg: self.pitch_deg(time),
            angle_deg: self.course.scene().row_deg(row),
            time_s: time,
        };
        let [alone, joined] = self.ways;
        let way = match self.is_joined {
            true => joined.as_ref().or(alone.as_ref()),
            false => alone.as_ref(),
        };
        let way = way.context("a course has a way")?;
        let chirp = way.chirp(&shot, row, (self.number, number as u64))?;
        self.keep(&chirp, number, shot.angle_deg);
        Ok(chirp)
    }

    /// Adds a chirp's powers to `rows`, and its samples and `angle_deg` to the recording if they
    /// are to be kept.
    fn keep(&mut self, chirp: &[Iq], number: usize, angle_deg: f64) {
        let motion = &self.recording.meta.motion;
        let (pitch, travel) = (motion.pitch_deg[number], motion.travel_m[number]);
        if self.rows.len() >= ground::SWEEPS * ROWS {
            self.rows.drain(..ROWS);
        }
        self.rows
            .push(self.meter.row(chirp, angle_deg, pitch, travel));
        if self.is_kept {
            self.recording.samples.extend(chirp);
            self.recording.meta.angles_deg.push(angle_deg);
        }
    }

    /// Runs the control cycles up to `time`, seconds.
    fn control(&mut self, time: f64) {
        loop {
            let now = self.chair.cycles() as f64 * CYCLE_S;
            if now > time {
                return;
            }
            if let Some((_, input)) = self.pending_sentence.take_if(|(at, _)| *at <= now) {
                self.controller.input = Some(input);
            }
            let pose = self.chair.at(now);
            let odometer_m = self.plan.odometer.reading_m(pose.travel_m);
            let joystick = self.plan.joystick(now);
            let controller = &mut self.controller;
            let command = controller.cycle(now, odometer_m, pose.speed_m_s, joystick);
            self.chair.command(command);
            let stands = pose.speed_m_s < STANDING_M_S && joystick > 0.0;
            self.stood_s = if stands { self.stood_s + CYCLE_S } else { 0.0 };
        }
    }

    /// Lets the person step in when the chair is near enough, and decides whether the drive has
    /// ended.
    fn update_end(&mut self, pose: &Pose, time: f64) {
        let hazard = self.course.hazard;
        let ahead_m = hazard.map(|hazard| hazard.at_m - pose.travel_m);
        if !self.is_joined && ahead_m.is_some_and(|ahead_m| ahead_m <= self.plan.steps_in_m) {
            self.is_joined = true;
            let plan = &self.plan;
            let reacts_s = 2.0 * SWEEP_S + 2.0 * SENTENCE_LATENCY_S + CYCLE_S + plan.latency_s;
            let braking = 0.5 * pose.speed_m_s * pose.speed_m_s / plan.deceleration;
            self.log.step_in = Some(StepIn {
                gap_m: ahead_m.unwrap_or(0.0) - FRONT_M,
                needed_m: pose.speed_m_s * reacts_s + braking,
            });
        }
        let passed = self.is_joined && ahead_m.is_some_and(|ahead_m| ahead_m < FRONT_M);
        let end = match self.stood_s {
            _ if passed => Some(End::Passed),
            _ if pose.travel_m >= self.course.end_m => Some(End::Through),
            stood if stood >= STOP_TIME_S || time > LONGEST_S => Some(End::Stood),
            _ => None,
        };
        if self.end.is_none() && end.is_some() {
            self.end = end;
            (self.log.travel_m, self.log.time_s) = (pose.travel_m, time);
        }
    }

    /// Takes the guard's answer on the sweep that the newest row has ended: sends the sentence to
    /// the controller and adds the sweep to the record.
    pub fn receive_sentence(
        &mut self,
        sentence: &str,
        line: &GuardLine,
        guarded: score::GuardAnswer,
    ) {
        let rows = self.recording.meta.motion.travel_m.len() - 1;
        let time = time_s(rows - 1);
        let odometer_m = self.recording.meta.motion.travel_m[rows - 1];
        let arrives = time + SENTENCE_LATENCY_S + (sentence.len() + 2) as f64 * BYTE_S;
        self.pending_sentence = Some((arrives, GuardInput::new(line, time, odometer_m)));
        let pose = self.chair.at(time);
        let hazard = self.course.hazard.filter(|_| self.is_joined);
        self.log.sweeps.push(SweepLog {
            hazard_m: hazard.map(|hazard| hazard.at_m - pose.travel_m),
            answer: guarded,
            reasons: line.reasons,
            ground_echo_range_m: self.meter.ground_echo_range_m(&self.rows, odometer_m),
            speed_m_s: pose.speed_m_s,
        });
    }

    /// Whether the drive has ended.
    pub fn has_ended(&self) -> bool {
        self.end.is_some()
    }

    /// Returns the record and the recording of the finished drive.
    pub fn finish(mut self) -> (DriveLog, Recording) {
        self.log.end = self.end.unwrap_or(End::Stood);
        self.log.hazard = self.course.hazard.filter(|_| self.is_joined);
        let sweeps = self.log.sweeps.len();
        let recording = &mut self.recording;
        recording.name.clone_from(&self.log.name);
        recording.meta.sequence.scans = sweeps;
        let rows = sweeps * ROWS;
        let motion = &mut recording.meta.motion;
        for list in [
            &mut motion.time_s,
            &mut motion.travel_m,
            &mut motion.pitch_deg,
        ] {
            list.truncate(rows);
        }
        recording.meta.angles_deg.truncate(rows);
        recording
            .samples
            .truncate(rows * recording.meta.samples_per_chirp);
        (self.log, self.recording)
    }
}
