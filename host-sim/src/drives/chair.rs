//! Model of a chair's drive: speed commands in, travel and speed out, with dead time and limited
//! acceleration.

use super::plan::Plan;

/// Time step of the chair's motion, seconds. Control cycles and row times are whole multiples of
/// it.
const TICK_S: f64 = 0.0004;
/// Period of the control cycle, seconds.
pub const CYCLE_S: f64 = 0.02;

/// Position and speed of a chair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Forward travel since the first row, metres.
    pub travel_m: f64,
    /// Forward speed, m/s.
    pub speed_m_s: f64,
}

/// A chair that is at rest at first.
#[derive(Clone, Debug)]
pub struct Chair {
    latency_s: f64,
    acceleration: f64,
    deceleration: f64,
    /// One command per control cycle, m/s.
    commands: Vec<f64>,
    /// One pose per time step of [`TICK_S`].
    poses: Vec<Pose>,
}

impl Chair {
    /// Creates the chair of a plan.
    pub fn new(plan: &Plan) -> Self {
        Self {
            latency_s: plan.latency_s,
            acceleration: plan.acceleration,
            deceleration: plan.deceleration,
            commands: Vec::new(),
            poses: vec![Pose::default()],
        }
    }

    /// Adds the command of the next control cycle, m/s.
    pub fn command(&mut self, speed_m_s: f64) {
        self.commands.push(speed_m_s);
    }

    /// Number of commands taken.
    pub fn cycles(&self) -> usize {
        self.commands.len()
    }

    /// Returns the pose at `time_s`, seconds. The commands that act by then must have been added:
    /// those up to one latency earlier.
    pub fn at(&mut self, time_s: f64) -> Pose {
        let tick = libm::floor(time_s / TICK_S + 0.5) as usize;
        while self.poses.len() <= tick {
            self.step();
        }
        self.poses[tick]
    }

    /// Advances by one time step.
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
