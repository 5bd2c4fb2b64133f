//! Answer of one scan: direction, steps, drop, and possible further steps. Its status is in [`crate::verdict`].

use crate::estimate::COVERAGE_FACTOR;
use crate::math;

/// Maximum number of steps of one answer.
pub const MAX_STEPS: usize = 16;

/// Maximum number of possible steps or drops besides the answer.
pub const MAX_POSSIBLE_STEPS: usize = 6;

/// Direction of the stairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    /// No stairs.
    #[default]
    None,
    /// Ascending.
    Up,
    /// Descending.
    Down,
}

/// One step of the staircase, in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// Horizontal distance from the mirror's centre to the step's foremost edge, metres; negative behind the mirror.
    pub distance_m: f32,
    /// Height of the step's tread above the surface that the wheelchair stands on, metres.
    pub height_m: f32,
    /// Depth of the step's tread up to the next step's edge, metres; `None` for the last step.
    pub tread_m: Option<f32>,
    /// Height of the step's riser over the tread (or ground) before it, metres, positive; `None` where that is not
    /// known.
    pub riser_m: Option<f32>,
    /// Standard deviation of the step's distance `distance_m`, metres.
    pub distance_sigma_m: f32,
    /// Standard deviation of the step's height `height_m`, metres.
    pub height_sigma_m: f32,
    /// Detection quality: share of the step's expected features that are detected, per cent.
    pub quality: u8,
}

/// Ground that is level and slopes from a place on: a ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Distance from the mirror at which the slope begins, metres; infinite for level ground.
    pub from_m: f32,
    /// Rise per metre; negative going down.
    pub slope: f32,
}

impl Slope {
    /// Level ground.
    pub const LEVEL: Self = Self {
        from_m: f32::INFINITY,
        slope: 0.0,
    };

    /// Returns the height of the ground at distance `x_m`, metres above the level ground.
    pub fn height_m(&self, x_m: f32) -> f32 {
        self.slope * math::max(x_m - self.from_m, 0.0)
    }

    /// Returns the horizontal distance at which a range, metres, from a mirror `mirror_m` metres above the level ground
    /// meets the ground, metres: to 1 mm, since the slope is gentle.
    pub fn reach_m(&self, range_m: f32, mirror_m: f32) -> f32 {
        let reach_m = |down_m: f32| {
            let squared = range_m * range_m - down_m * down_m;
            math::sqrt(math::max(squared, 0.0))
        };
        let level_m = reach_m(mirror_m);
        if self.slope == 0.0 {
            return level_m;
        }
        reach_m(mirror_m - self.height_m(level_m))
    }
}

/// An estimator's answer: direction, steps, drop, and possible further steps. Status, horizon and confidence
/// are in its [`Verdict`](crate::verdict::Verdict).
///
/// ```
/// use stairscan::answer::{Answer, Step};
///
/// let at = |distance_m, height_m| Step { distance_m, height_m, ..Step::default() };
/// let mut answer = Answer::NONE;
/// answer.steps.push(at(0.50, 0.17)).unwrap();
/// answer.steps.push(at(0.78, 0.34)).unwrap();
/// answer.link();
/// let tread_m = answer.steps[0].tread_m.unwrap();
/// assert!((tread_m - 0.28).abs() < 1e-6);
/// assert_eq!(answer.steps[1].tread_m, None);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Direction of the stairs.
    pub direction: Direction,
    /// Steps, nearest first.
    pub steps: heapless::Vec<Step, MAX_STEPS>,
    /// Edge where the ground ends or falls; `None` without one, or where a staircase going down is reported.
    pub drop: Option<DropEdge>,
    /// Possible steps and drops that the answer does not contain, nearest first.
    pub possible_steps: heapless::Vec<PossibleStep, MAX_POSSIBLE_STEPS>,
    /// Slope of the ground, gentle enough to drive on; `None` where the ground is level or not seen to slope.
    pub ground: Option<Slope>,
}

/// Edge where the ground ends, or falls by more than 4 cm, and no staircase going down is reported.
///
/// The guarantee is one-sided: the ground does not end before [`DropEdge::nearest_m`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DropEdge {
    /// Horizontal distance from the mirror's centre to the edge where the ground ends, metres.
    pub distance_m: f32,
    /// Standard deviation of the edge's distance, metres.
    pub distance_sigma_m: f32,
    /// Depth below the ground of the next surface behind the edge, metres, positive; `None` where it is not known.
    pub depth_m: Option<f32>,
    /// Probability that the ground ends at this edge, 0…1.
    pub probability: f32,
}

impl DropEdge {
    /// Returns the lower limit of the edge's distance, distance − 3σ, metres from the mirror's centre.
    pub fn nearest_m(&self) -> f32 {
        self.distance_m - COVERAGE_FACTOR * self.distance_sigma_m
    }
}

/// A possible step or drop that the answer does not contain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PossibleStep {
    /// Horizontal distance of the possible step or drop from the mirror's centre, metres.
    pub distance_m: f32,
    /// Height of the possible step above the ground, metres; [`PossibleStep::DROP_M`] for a possible drop, whose depth
    /// is unknown.
    pub height_m: f32,
    /// Probability that the step or drop exists, 0…1.
    pub probability: f32,
}

impl PossibleStep {
    /// Height above the ground that stands for a possible drop, metres, negative: the minimum depth that is a drop to a
    /// wheelchair.
    pub const DROP_M: f32 = -0.1;
}

impl Answer {
    /// Answer without stairs, drop or possible steps.
    pub const NONE: Self = Self {
        direction: Direction::None,
        steps: heapless::Vec::new(),
        drop: None,
        possible_steps: heapless::Vec::new(),
        ground: None,
    };

    /// Resets to [`Answer::NONE`].
    pub fn clear(&mut self) {
        self.direction = Direction::None;
        self.steps.clear();
        self.drop = None;
        self.possible_steps.clear();
        self.ground = None;
    }

    /// Places the answer, whose heights are above the sloping ground, on that ground: then they are above the level
    /// ground before it.
    pub fn lie_on(&mut self, ground: Slope) {
        for step in &mut self.steps {
            step.height_m += ground.height_m(step.distance_m);
        }
        for maybe in &mut self.possible_steps {
            if maybe.height_m > 0.0 {
                maybe.height_m += ground.height_m(maybe.distance_m);
            }
        }
        self.ground = Some(ground).filter(|ground| *ground != Slope::LEVEL);
    }

    /// Computes the tread depths and riser heights of the steps, which must be sorted by distance: a tread extends to
    /// the next step's edge; a riser begins at the height of the tread before it, the first one at the ground.
    pub fn link(&mut self) {
        let mut level = 0.0;
        for step in &mut self.steps {
            step.riser_m = Some((step.height_m - level).abs());
            level = step.height_m;
            step.tread_m = None;
        }
        let mut next = None;
        for step in self.steps.iter_mut().rev() {
            step.tread_m = next.map(|distance: f32| distance - step.distance_m);
            next = Some(step.distance_m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cleared_answer_tells_no_drop() {
        let drop = DropEdge {
            distance_m: 0.9,
            distance_sigma_m: 0.02,
            ..DropEdge::default()
        };
        assert!((drop.nearest_m() - 0.84).abs() < 1e-6);
        let mut answer = Answer {
            drop: Some(drop),
            ..Answer::NONE
        };
        answer.clear();
        assert_eq!(answer, Answer::NONE);
    }

    #[test]
    fn an_answer_on_a_slope_is_above_the_level_ground_before_it() {
        let ramp = Slope {
            from_m: 0.5,
            slope: 0.1,
        };
        let mut answer = Answer::NONE;
        for distance_m in [0.4, 1.5] {
            let step = Step {
                distance_m,
                height_m: 0.16,
                ..Step::default()
            };
            answer.steps.push(step).unwrap();
        }
        for height_m in [0.16, PossibleStep::DROP_M] {
            let maybe = PossibleStep {
                distance_m: 1.0,
                height_m,
                probability: 0.2,
            };
            answer.possible_steps.push(maybe).unwrap();
        }
        let level = answer.clone();
        answer.lie_on(Slope::LEVEL);
        assert_eq!(answer, level);
        answer.lie_on(ramp);
        let close = |a: f32, b: f32| (a - b).abs() < 1e-6;
        assert!(close(answer.steps[0].height_m, 0.16) && close(answer.steps[1].height_m, 0.26));
        assert!(close(answer.possible_steps[0].height_m, 0.21));
        assert!(close(
            answer.possible_steps[1].height_m,
            PossibleStep::DROP_M
        ));
        assert_eq!(answer.ground, Some(ramp));
        // A range meets the ground where its height says, to a millimetre.
        let x_m = ramp.reach_m(1.2, 0.4);
        let range_m = math::hypot(x_m, 0.4 - ramp.height_m(x_m));
        assert!((range_m - 1.2).abs() < 1e-3, "{range_m}");
    }

    #[test]
    fn treads_and_risers_come_from_neighbours() {
        let at = |distance_m, height_m| Step {
            distance_m,
            height_m,
            ..Step::default()
        };
        let mut answer = Answer::NONE;
        for step in [at(0.5, 0.17), at(0.8, 0.34), at(1.1, 0.53)] {
            answer.steps.push(step).unwrap();
        }
        answer.link();
        let steps = answer.steps;
        let close = |a: Option<f32>, b: f32| a.is_some_and(|a| (a - b).abs() < 1e-6);
        assert!(close(steps[0].tread_m, 0.3) && close(steps[1].tread_m, 0.3));
        assert_eq!(steps[2].tread_m, None);
        assert!(close(steps[0].riser_m, 0.17) && close(steps[2].riser_m, 0.19));
    }
}
