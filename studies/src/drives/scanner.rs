//! The scanner of a drive: the firmware's own scanner code, with the simulated world as radar
//! module and motion input.

use std::cell::RefCell;
use std::rc::Rc;
use std::task::Poll;

use anyhow::{Context, Result, anyhow, bail};
use stairscan::Iq;
use stairscan::config::{Config, RadarConfig};
use stairscan::motion::Odometry;
use stairscan::pipeline::Pipeline;
use stairscan::scanner::{Hardware, LentParts, Micros, Reports, Scanner, Settings};
use stairscan::signal::radar::module::RequestedSettings;
use stairscan::signal::radar::{LinkError, RadarModule};

use super::course::Course;
use super::log::DriveLog;
use super::world::{ROWS, World};
use host_sim::guarded::Guarded;
use host_sim::motion::by_trigger::ByTrigger;
use host_sim::motion::inlet::Inlet;
use host_sim::motion::{MotionSentences, Timetable};
use host_sim::playback::{Playback, SimShaft, deliver, row_at};
use host_sim::recording::Recording;
use host_sim::replay::{Console, SHORTEST_SETTLE_US};
use host_sim::scene::way::Way;
use host_sim::setup;
use host_sim::sweeps::score;
use host_sim::volatile::{Volatile, identity};

/// Maximum number of calls of the scanner's `step` from one sweep's answer to the next, after which
/// the drive fails: about five per row, and those in which it only waits.
const MAX_STEPS: usize = 10_000;

/// Options of a drive.
#[derive(Clone, Copy, Debug, Default)]
pub struct DriveOptions {
    /// Whether motion sentences are sent with the triggers of chirps, as the emulator needs them,
    /// rather than at their times.
    pub by_trigger: bool,
    /// Whether the recording keeps the chirps' samples.
    pub is_kept: bool,
}

/// Result of a finished drive: record, recording and sentences.
pub struct FinishedDrive {
    /// Record of the drive: sweeps, hazard and end.
    pub log: DriveLog,
    /// Recording of all rows, without samples unless [`DriveOptions::is_kept`].
    pub recording: Recording,
    /// The `GUARD` sentences, one per sweep.
    pub sentences: Vec<String>,
}

/// Radar module that simulates each chirp from the chair's position at the time of the trigger.
struct Module<'w, 'a> {
    world: &'w RefCell<World<'a>>,
    timetable: Rc<RefCell<Timetable>>,
    config: Config,
    sweep: usize,
    triggered: bool,
    chirp: Option<Vec<Iq>>,
}

impl RadarModule for Module<'_, '_> {
    fn program(&mut self, _: Micros, _: &RequestedSettings, _: u32) {
        self.sweep += usize::from(std::mem::take(&mut self.triggered));
    }

    fn settings(&mut self, now: Micros) -> Poll<Result<RadarConfig, LinkError>> {
        match self.timetable.borrow().early(now) {
            true => Poll::Pending,
            false => Poll::Ready(Ok(self.config.radar)),
        }
    }

    fn trigger(&mut self, now: Micros, shaft_angle: i32, _: u32) {
        self.triggered = true;
        let row = row_at(&self.config, shaft_angle).filter(|row| *row < ROWS);
        self.chirp = row.and_then(|row| {
            let order = if self.sweep.is_multiple_of(2) {
                row
            } else {
                ROWS - 1 - row
            };
            let number = self.sweep * ROWS + order;
            let chirp = self.world.borrow_mut().fire(number, row);
            self.timetable.borrow_mut().fired(number, now);
            chirp
        });
    }

    fn poll(&mut self, _: Micros, samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        Poll::Ready(deliver(self.chirp.as_deref(), samples))
    }
}

/// Returns the scanner's settings and configuration, and the timetable of motion sentences, which
/// has those of the first row.
fn set_up(world: &World<'_>, options: DriveOptions) -> Result<(Settings, Config, Timetable)> {
    let first = &world.recording;
    let mut playback = Playback::new(first, &Config::default())?.guarding();
    if options.by_trigger {
        playback = playback.by_trigger();
    }
    let mut settings = playback.settings();
    settings.motion = setup::mode(first);
    let timetable = if options.by_trigger {
        Timetable::by_trigger(ByTrigger::new(first).context("no motion")?)
    } else {
        // The timetable sets the time at which the mirror has come to rest.
        settings.timing.settle = SHORTEST_SETTLE_US;
        Timetable::new(MotionSentences::new(first, None).context("no motion")?)
    };
    settings.validate().map_err(|e| anyhow!("{e}"))?;
    Ok((settings, *playback.config(), timetable))
}

/// Runs drive `number` along a course.
///
/// # Errors
/// Names the setting that the scanner rejects, or the place where the mirror lies inside or behind
/// a surface.
pub fn drive<'a>(
    course: &'a Course,
    ways: &'a [Option<Way<'a>>; 2],
    number: u64,
    options: DriveOptions,
) -> Result<FinishedDrive> {
    let mut world = World::new(course, ways, number, options.is_kept)?;
    let (settings, config, timetable) = set_up(&world, options)?;
    let timetable = Rc::new(RefCell::new(timetable));
    world.begin(Rc::clone(&timetable));
    let world = RefCell::new(world);
    let sentences = guard(&world, settings, config, &timetable)
        .with_context(|| format!("{} drive {number}", course.name))?;
    let (log, recording) = world.into_inner().finish();
    Ok(FinishedDrive {
        log,
        recording,
        sentences,
    })
}

/// Runs the guard until the drive has ended, and returns the `GUARD` sentences, one per sweep.
fn guard(
    world: &RefCell<World<'_>>,
    settings: Settings,
    config: Config,
    timetable: &Rc<RefCell<Timetable>>,
) -> Result<Vec<String>> {
    let mut reports = Reports::new();
    let mut odometry = Odometry::new();
    let mut pipeline = Box::new(Pipeline::new());
    let mut now = Micros(0);
    let hardware = Hardware {
        mirror: SimShaft::default(),
        link: Module {
            world,
            timetable: Rc::clone(timetable),
            config,
            sweep: 0,
            triggered: false,
            chirp: None,
        },
        port: Console::new(Inlet::new(Some(Rc::clone(timetable)))),
        board: Volatile::SCANNING,
    };
    let mut scanner = Scanner::new(
        hardware,
        &mut *pipeline,
        LentParts {
            reports: &mut reports,
            odometry: &mut odometry,
        },
        Some(settings),
        identity("host"),
        now,
    );
    scanner.port_mut().inlet.type_in(b"guard on\n");
    let mut sentences = Vec::new();
    let mut steps = 0;
    while !world.borrow().has_ended() {
        scanner.step(now);
        world.borrow_mut().check()?;
        now = timetable.borrow_mut().step(now);
        steps += 1;
        if let Some(lines) = scanner.port_mut().take_scan()? {
            for word in Guarded::parse(0, lines)? {
                let seen = score::GuardAnswer::of(&word);
                world
                    .borrow_mut()
                    .receive_sentence(&word.sentence, &word.line, seen);
                sentences.push(word.sentence);
            }
            steps = 0;
        }
        if steps > MAX_STEPS {
            bail!("the scanner gave no answer");
        }
    }
    Ok(sentences)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drives::controller::FRONT_M;
    use crate::drives::log::End;
    use host_sim::replay::{self, Options};
    use host_sim::seeds::Draw;
    use host_sim::sweeps::scenes::Kind;

    fn course(kind: Kind) -> Course {
        let seed = kind.seeds(Draw::Tuning).next().unwrap();
        Course::new(kind, seed).unwrap()
    }

    #[test]
    fn a_chair_stands_before_a_kerb_and_its_recording_replays_to_the_same_sentences() {
        let course = course(Kind::Kerb);
        let ways = course.ways();
        for by_trigger in [false, true] {
            let options = DriveOptions {
                by_trigger,
                is_kept: true,
            };
            let driven = drive(&course, &ways, 0, options).unwrap();
            assert_eq!(driven.log.end, End::Stood);
            let at_m = driven.log.hazard.unwrap().at_m;
            assert!(driven.log.travel_m > 0.5 && driven.log.travel_m < at_m - FRONT_M);
            let options = Options {
                by_trigger,
                ..Options::default()
            };
            let words = replay::guarded(&driven.recording, &options).unwrap();
            let replayed: Vec<String> = words.into_iter().map(|word| word.sentence).collect();
            assert_eq!(replayed, driven.sentences);
        }
    }

    #[test]
    fn a_chair_comes_to_the_end_of_level_floor() {
        let course = course(Kind::Level);
        let driven = drive(&course, &course.ways(), 1, DriveOptions::default()).unwrap();
        assert_eq!(driven.log.end, End::Through);
        assert!(driven.log.hazard.is_none());
    }
}
