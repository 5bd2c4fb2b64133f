//! The chair's controller: motion sentences twenty times a second, with counters that wrap.

use std::cell::RefCell;
use std::rc::Rc;

use stairscan::motion::Reading;
use stairscan::report::motion;
use stairscan::report::sentence::Line;

use super::data::TrueTravel;
use host_sim::scene::maths::Random;

/// Mean time between two motion sentences, µs, and the range of its jitter: half of it to either side.
const PERIOD_US: u64 = 50_000;
const JITTER_US: f64 = 2_000.0;
/// Travel at which the counter jumps to its negative, 0.1 mm: within the ±200 km that a sentence may hold
/// (docs/design/motion.md).
const RESTART: i64 = 1_999_000_000;
/// Value of the travel counter at the beginning of the run, 0.1 mm: 10 km before the first jump, which therefore comes
/// within days.
const FIRST: i64 = RESTART - 100_000_000;
/// Maximum speed of the chair, m/s. The scanner accepts 2 m/s from one arrival of a motion sentence to the next, and an
/// answer's 30 ms may shorten that time.
const MAX_M_S: f64 = 1.0;
/// Largest change of speed from one motion sentence to the next, m/s: 1 m/s².
const CHANGE_M_S: f64 = 0.05;

/// Simulated controller of the chair: drives at random and sends motion sentences.
pub struct Controller {
    /// Whether the controller sends its motion sentences.
    pub sends: bool,
    /// Time of the next motion sentence, µs since the beginning of the run.
    pub next: u64,
    sequence: u16,
    /// Travel counter as the motion sentences state it, 0.1 mm.
    travel: i64,
    true_travel: TrueTravel,
    speed_m_s: f64,
    aim_m_s: f64,
    pitch: i32,
    /// Number of wraps of the motion sentences' sequence number.
    pub wraps: u64,
    /// Number of times that the travel counter has jumped from its maximum to its minimum.
    pub restarts: u64,
    random: Random,
}

/// Number of the stream of random numbers for the chair's motion.
const STREAM: u64 = 0x4348_4149;

impl Controller {
    /// Creates the controller of a standing chair, which sends motion sentences.
    pub fn new(seed: u64) -> Self {
        Self {
            sends: true,
            next: 0,
            sequence: 65_000,
            travel: FIRST,
            true_travel: Rc::new(RefCell::new(0.0)),
            speed_m_s: 0.0,
            aim_m_s: 0.0,
            pitch: 0,
            wraps: 0,
            restarts: 0,
            random: Random::new(seed, STREAM),
        }
    }

    /// Returns a handle of the chair's true travel, with which a data path compares the reported travel.
    pub fn true_travel(&self) -> TrueTravel {
        self.true_travel.clone()
    }

    /// Drives on to the next motion sentence. Returns its line, `None` if the controller does not send, and whether the
    /// travel counter has jumped.
    pub fn tick(&mut self) -> (Option<Line>, bool) {
        let random = &mut self.random;
        self.next += PERIOD_US + random.between(0.0, JITTER_US) as u64 - JITTER_US as u64 / 2;
        if random.chance(0.005) {
            let drives = random.chance(0.5);
            self.aim_m_s = if drives {
                random.between(0.1, MAX_M_S)
            } else {
                0.0
            };
        }
        let change = (self.aim_m_s - self.speed_m_s).clamp(-CHANGE_M_S, CHANGE_M_S);
        self.speed_m_s += change;
        let way_m = self.speed_m_s * PERIOD_US as f64 * 1e-6;
        let before = *self.true_travel.borrow();
        *self.true_travel.borrow_mut() = before + way_m;
        self.travel += ((before + way_m) * 1e4) as i64 - (before * 1e4) as i64;
        let restart = self.travel > RESTART;
        if restart {
            self.travel -= 2 * RESTART;
            self.restarts += 1;
        }
        self.pitch = (self.pitch + random.index(41) as i32 - 20).clamp(-2_000, 2_000);
        let line = self.sends.then(|| self.line());
        (line, restart)
    }

    fn line(&mut self) -> Line {
        self.sequence = self.sequence.wrapping_add(1);
        self.wraps += u64::from(self.sequence == 0);
        motion::write(&Reading {
            sequence: self.sequence,
            travel: self.travel as i32,
            pitch: Some(self.pitch),
        })
    }
}
