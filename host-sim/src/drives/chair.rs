//! A chair: commands in, places and speeds out, with the dead time and the ramps of its drive.

use super::plan::Plan;

/// Time step of the chair's motion, seconds: control cycles and rows are whole numbers of it.
const TICK_S: f64 = 0.0004;
/// From one command to the next, seconds.
pub const CYCLE_S: f64 = 0.02;

/// Where a chair is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Forward travel since the first row, metres.
    pub travel_m: f64,
    /// Forward speed, m/s.
    pub speed_m_s: f64,
}

/// A chair that stands at first.
#[derive(Clone, Debug)]
pub struct Chair {
    latency_s: f64,
    acceleration: f64,
    deceleration: f64,
    /// One a cycle, m/s.
    commands: Vec<f64>,
    /// One a tick.
    poses: Vec<Pose>,
}

impl Chair {
    /// The chair of a plan.
    pub fn new(plan: &Plan) -> Self {
        Self {
            latency_s: plan.latency_s,
            acceleration: plan.acceleration,
            deceleration: plan.deceleration,
            commands: Vec::new(),
            poses: vec![Pose::default()],
        }
    }

    /// Takes the next cycle's command, m/s.
    pub fn command(&mut self, speed_m_s: f64) {
        self.commands.push(speed_m_s);
    }

    /// Number of commands taken.
    pub fn cycles(&self) -> usize {
        self.commands.len()
    }

    /// Where the chair is at `time_s`. Commands that act by then must have come: those of a latency before.
    pub fn at(&mut self, time_s: f64) -> Pose {
        let tick = libm::floor(time_s / TICK_S + 0.5) as usize;
        while self.poses.len() <= tick {
            self.go_on();
        }
        self.poses[tick]
    }

    /// One tick.
    fn go_on(&mut self) {
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
