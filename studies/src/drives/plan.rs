//! Random parameters of one drive: the driver's joystick, the chair's drive and its sensors.

use core::f64::consts::TAU;

use host_sim::scene::driving::{Odometer, Rocking, SWING, SWING_HZ};
use host_sim::scene::maths::Random;

/// Stream of the random numbers of plans, distinct from the streams of scenes, surfaces and chirps.
const STREAM: u64 = 0x4452_4956_4500;

/// Range of the mean speed asked by the joystick, m/s.
const CRUISE: [f64; 2] = [0.2, 0.8];
/// Range of the dead time of motor controller and bus, seconds. With one control cycle it is at
/// most the latency that the controller assumes.
const LATENCY_S: [f64; 2] = [0.1, 0.18];
/// Ranges, minimum and maximum, of the chair's deceleration and of its acceleration, m/s².
const DECELERATION: [f64; 2] = [1.0, 1.6];
const ACCELERATION: [f64; 2] = [0.4, 0.9];
/// Fraction of the drives in which the joystick is held back (a lower speed) for a while, and of
/// those in which it is released (no speed).
const HELD_BACK: f64 = 0.3;
const RELEASED: f64 = 0.3;
/// Ranges of the beginning and of the duration of a pause of the joystick, seconds.
const BEGINS_S: [f64; 2] = [0.5, 4.0];
const LASTS_S: [f64; 2] = [0.4, 1.5];
/// Range of a person's distance from the mirror at which he or she steps in, metres.
const STEPS_IN_M: [f64; 2] = [0.6, 1.6];

/// Random parameters of one drive: its driver's joystick, the chair and the chair's sensors.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Mean speed asked by the joystick, m/s.
    cruise: f64,
    /// Phase at time 0 of the sine by which the joystick's speed swings about its mean, radians.
    swing: f64,
    /// Periods in which the joystick asks for less: beginning and end, seconds, and the fraction of
    /// the speed that remains.
    pauses: [(f64, f64, f64); 2],
    /// Dead time from a command to its effect, seconds.
    pub latency_s: f64,
    /// Deceleration of the chair, m/s².
    pub deceleration: f64,
    /// Acceleration of the chair, m/s².
    pub acceleration: f64,
    /// Model of the chair's odometer with its errors.
    pub odometer: Odometer,
    /// Model of the chair's rocking: changes of pitch while it drives.
    pub rocking: Rocking,
    /// Distance between mirror and person at which the person steps in, metres.
    pub steps_in_m: f64,
}

impl Plan {
    /// Draws the plan of drive `number` through the scene of seed `seed`.
    pub fn draw(seed: u64, number: u64) -> Self {
        let rng = &mut Random::new(seed, STREAM + number);
        let between = |rng: &mut Random, [low, high]: [f64; 2]| rng.between(low, high);
        let pause = |rng: &mut Random, chance: f64, share: f64| {
            let from = between(rng, BEGINS_S);
            let to = from + between(rng, LASTS_S);
            match rng.chance(chance) {
                true => (from, to, share),
                false => (0.0, 0.0, 1.0),
            }
        };
        let share = rng.between(0.3, 0.7);
        Self {
            cruise: between(rng, CRUISE),
            swing: rng.between(0.0, TAU),
            pauses: [pause(rng, HELD_BACK, share), pause(rng, RELEASED, 0.0)],
            latency_s: between(rng, LATENCY_S),
            deceleration: between(rng, DECELERATION),
            acceleration: between(rng, ACCELERATION),
            odometer: Odometer::draw(rng),
            rocking: Rocking::draw(rng),
            steps_in_m: between(rng, STEPS_IN_M),
        }
    }

    /// Returns the speed asked by the joystick at `time_s` (seconds), m/s.
    pub fn joystick(&self, time_s: f64) -> f64 {
        let swung = 1.0 + SWING * libm::sin(TAU * SWING_HZ * time_s + self.swing);
        let held = self
            .pauses
            .iter()
            .filter(|(from, to, _)| (*from..*to).contains(&time_s));
        held.fold(self.cruise * swung, |speed, (_, _, share)| speed * share)
    }
}
