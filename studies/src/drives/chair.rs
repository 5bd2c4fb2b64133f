//! Model of a chair's drive: speed commands in, travel and speed out, with dead time and limited
//! acceleration.

use super::plan::Plan;

/// Time step of the chair's motion, seconds. The control cycle ([`CYCLE_S`]) and the time from row
/// to row of the radar are whole multiples of this step.
const TICK_S: f64 = 0.0004;
/// Period of the cycle in which the chair's controller sends one speed command, seconds.
pub const CYCLE_S: f64 = 0.02;

/// Position and speed of a chair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Forward travel since the scanner's first row, metres.
    pub travel_m: f64,
    /// Forward speed, m/s.
    pub speed_m_s: f64,
}

/// A chair with its drive, at rest at time 0.
#[derive(Clone, Debug)]
pub struct Chair {
    latency_s: f64,
    acceleration: f64,
    deceleration: f64,
    /// Speed commands received, m/s: command `k` is that of the control cycle at `k ·` [`CYCLE_S`].
    commands: Vec<f64>,
    /// Poses computed up to now: pose `k` is that at `k ·` [`TICK_S`].
    poses: Vec<Pose>,
}

impl Chair {
    /// Creates a chair at rest, with the dead time, acceleration and deceleration of a drive's
    /// plan.
    pub fn new(plan: &Plan) -> Self {
        Self {
            latency_s: plan.latency_s,
            acceleration: plan.acceleration,
            deceleration: plan.deceleration,
            commands: Vec::new(),
            poses: vec![Pose::default()],
        }
    }

    /// Adds the speed command of the next control cycle, m/s.
    pub fn command(&mut self, speed_m_s: f64) {
        self.commands.push(speed_m_s);
    }

    /// Number of commands received, which is also the number of the next control cycle.
    pub fn cycles(&self) -> usize {
        self.commands.len()
    }

    /// Returns the pose at `time_s` (seconds), and computes all poses up to then. Commands act one
    /// latency after their control cycle; all that act by `time_s` must have been added.
    pub fn at(&mut self, time_s: f64) -> Pose {
        let tick = libm::floor(time_s / TICK_S + 0.5) as usize;
        while self.poses.len() <= tick {
            self.step();
        }
        self.poses[tick]
    }

    /// Computes the pose one time step after the last one and appends it.
    fn step(&mut self) {
        let before = self.poses[self.poses.len() - 1];
        let acting = self.poses.len() as f64 * TICK_S - self.latency_s;
        let command = match acting {
            // `as` saturates.
            acting if acting >= 0.0 => self.commands.get((acting / CYCLE_S) as usize),
            _ => None,
        };
        let wanted = command.copied().unwrap_or(0.0);
        let [least, most] = [
            before.speed_m_s - self.deceleration * TICK_S,
            before.speed_m_s + self.acceleration * TICK_S,
        ];
        let speed_m_s = wanted.clamp(least.max(0.0).min(most), most);
        let travel_m = before.travel_m + 0.5 * (before.speed_m_s + speed_m_s) * TICK_S;
        self.poses.push(Pose {
            travel_m,
            speed_m_s,
        });
    }
}
