//! Data path without signal processing: its outcomes come from the verdict, by evidence that is drawn at random.
//!
//! It takes the time of a real one, and compares the motion that it is given with the true motion.

use std::cell::RefCell;
use std::rc::Rc;

use stairscan::Iq;
use stairscan::answer::{Direction, Step};
use stairscan::config::{Config, ConfigError, MAX_SAMPLES};
use stairscan::drive::Drive;
use stairscan::motion::{Agreement, Finding};
use stairscan::mount::Mounting;
use stairscan::scanner::DataPath;
use stairscan::verdict::{
    Assessment, Conditions, Evidence, FreeGround, GuardEvidence, GuardResult, HazardKind,
    MotionQuality, Outcome, Status, Validity,
};

use super::world::World;

/// Minimum and maximum time of processing a row, a scan's answer and a guard sweep's result, µs: up to their budgets of
/// 75,000 and 5,000,000 instructions at 168 MHz (docs/generated/benchmarks.md).
const ROW_US: [u64; 2] = [80, 450];
const ANSWER_US: [u64; 2] = [10_000, 30_000];
const RESULT_US: [u64; 2] = [1_000, 5_000];
/// Tolerance of the reported time between two scans, seconds; it covers the time that an answer takes.
const TIME_S: f64 = 0.5;
/// Longest time between two scans that is compared exactly, seconds. For a longer one the scanner may report any time
/// above this.
const LONGEST_S: f64 = 600.0;
/// Tolerance of the reported travel between two scans, metres: [`TIME_S`] at walking pace.
const TRAVEL_M: f64 = 0.6;

/// Time of a scan's last row, µs of the run, and the chair's true travel then, metres.
#[derive(Clone, Copy, Debug)]
struct Ended {
    at: u64,
    travel_m: f64,
}

/// Ends of the last scans of one kind: full scans or guard sweeps.
#[derive(Clone, Copy, Debug, Default)]
struct Series {
    /// Last row of the last scan with a result, and of a later one that a fault or `stop` ended.
    concluded: Option<Ended>,
    broken: Option<Ended>,
    /// Latest row of the scan that is under way.
    row: Option<Ended>,
}

impl Series {
    fn begin(&mut self) {
        self.broken = self.row.take().or(self.broken);
    }

    fn conclude(&mut self, now: Ended) {
        *self = Self {
            concluded: Some(now),
            ..Self::default()
        };
    }
}

/// True forward travel of the chair, metres; it continues where the counter in the motion sentences begins anew.
pub type TrueTravel = Rc<RefCell<f64>>;

/// Data path that takes the time of a real one and draws its outcomes at random.
#[derive(Debug)]
pub struct StubPath {
    world: Rc<RefCell<World>>,
    travel: TrueTravel,
    samples: [Iq; MAX_SAMPLES],
    scans: Series,
    sweeps: Series,
    sweeping: bool,
    /// Time of the last answer that was no fault, µs of the run.
    pub answered: Rc<RefCell<Option<u64>>>,
}

impl StubPath {
    /// Creates a data path as it is after boot.
    pub fn new(world: Rc<RefCell<World>>, travel: TrueTravel) -> Self {
        Self {
            world,
            travel,
            samples: [Iq::default(); MAX_SAMPLES],
            scans: Series::default(),
            sweeps: Series::default(),
            sweeping: false,
            answered: Rc::default(),
        }
    }

    fn work(&self, [least, most]: [u64; 2]) {
        let world = &mut *self.world.borrow_mut();
        world.busy_us += least + world.jitter(most - least);
        world.touched = true;
    }

    fn chance(&self, one_in: u64) -> bool {
        self.world.borrow_mut().jitter(one_in) == 0
    }

    fn present(&self) -> Ended {
        Ended {
            at: self.world.borrow().now,
            travel_m: *self.travel.borrow(),
        }
    }

    fn passed(&mut self) {
        let now = Some(self.present());
        match self.sweeping {
            true => self.sweeps.row = now,
            false => self.scans.row = now,
        }
    }

    /// Compares the time and travel that `drive` states since the last scan with the true ones; `series` has the ends
    /// of the scans of the same kind. Records a failed check in the world.
    fn compare(&self, drive: &Drive<'_>, series: &Series) {
        let now = self.present();
        let candidates = [series.concluded, series.broken];
        let mut before = candidates.iter().flatten().peekable();
        let Some(s) = drive.since_s.map(f64::from) else {
            return;
        };
        if before.peek().is_none() || before.any(|before| agrees(drive, s, before, &now)) {
            return;
        }
        let kind = if self.sweeping { "guard sweep" } else { "scan" };
        let truth: Vec<String> = (candidates.iter().flatten())
            .map(|before| {
                let s = (now.at - before.at) as f64 * 1e-6;
                format!("{s:.2} s, {:.2} m", now.travel_m - before.travel_m)
            })
            .collect();
        let text = format!(
            "{kind}: {s:.2} s and {:?} m since the one before instead of {}",
            drive.moved_m,
            truth.join(" or ")
        );
        self.world.borrow_mut().failed.push(text);
    }

    fn answer(&self, outcome: &mut Outcome) {
        if !self.chance(3) {
            return;
        }
        let (count, first) = {
            let world = &mut *self.world.borrow_mut();
            (1 + world.jitter(5), world.jitter(1_000))
        };
        outcome.answer.direction = Direction::Up;
        for k in 0..count {
            let step = Step {
                distance_m: 0.6 + first as f32 * 1e-3 + 0.28 * k as f32,
                height_m: 0.17 * (k + 1) as f32,
                distance_sigma_m: 0.01,
                height_sigma_m: 0.01,
                quality: 90,
                ..Step::default()
            };
            let _ = outcome.answer.steps.push(step);
        }
        outcome.answer.link();
    }
}

/// Whether the time `s`, seconds, and the travel of `drive` are those from `before` to `now`, within the tolerances.
fn agrees(drive: &Drive<'_>, s: f64, before: &Ended, now: &Ended) -> bool {
    let true_s = (now.at - before.at) as f64 * 1e-6;
    let true_m = now.travel_m - before.travel_m;
    let time = (s - true_s).abs() < TIME_S || (s > LONGEST_S && true_s > LONGEST_S);
    let travel = (drive.moved_m).is_none_or(|m| (f64::from(m) - true_m).abs() < TRAVEL_M);
    time && travel
}

impl DataPath for StubPath {
    fn begin(&mut self, _: &Config, _: u32) -> Result<(), ConfigError> {
        self.sweeping = false;
        self.scans.begin();
        Ok(())
    }

    fn samples(&mut self) -> &mut [Iq] {
        &mut self.samples
    }

    fn row(&mut self, _: u16) {
        self.passed();
        self.work(ROW_US);
    }

    fn lost(&mut self, _: u16) {
        self.passed();
    }

    fn conclude(&mut self, drive: &Drive<'_>, conditions: Conditions) -> Outcome {
        self.compare(drive, &self.scans);
        self.scans.conclude(self.present());
        let mut outcome = Outcome::silent();
        self.answer(&mut outcome);
        let valid = Validity {
            horizon_m: 1.5,
            confidence: 0.99,
            first_step: 0.98,
        };
        let agreement = Agreement {
            finding: Finding::Agreed,
            input: drive.input,
        };
        let assessment = Assessment {
            echo_found: !self.chance(200),
            valid: Some(valid),
            ..Assessment::nothing(agreement)
        };
        outcome.decide(&Evidence {
            conditions,
            assessment: Some(assessment),
            ..Evidence::default()
        });
        if outcome.status() != Status::Fault {
            let now = self.world.borrow().now;
            *self.answered.borrow_mut() = Some(now);
        }
        self.work(ANSWER_US);
        outcome
    }

    fn begin_guard(&mut self, _: &Config, _: u32) -> Result<(), ConfigError> {
        self.sweeping = true;
        self.sweeps.begin();
        Ok(())
    }

    fn guard(&mut self, drive: &Drive<'_>, conditions: Conditions) -> GuardResult {
        self.compare(drive, &self.sweeps);
        self.sweeps.conclude(self.present());
        self.work(RESULT_US);
        let near = self.chance(100);
        let ground = FreeGround {
            free_m: if near { 1.2 } else { 2.4 },
            hazard: if near {
                HazardKind::Rise
            } else {
                HazardKind::None
            },
            confidence: 0.995,
        };
        GuardResult::new(&GuardEvidence {
            echo_found: true,
            conditions,
            motion: MotionQuality::of(drive),
            ground: Some(ground),
            ..GuardEvidence::default()
        })
    }

    fn calibrate(&mut self, _: f32) -> Result<Mounting, ConfigError> {
        Err(ConfigError {
            field: "scene",
            expected: "a data path with signal processing",
        })
    }

    fn self_test(&mut self) -> bool {
        true
    }
}
