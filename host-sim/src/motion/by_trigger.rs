//! Motion sentences for a scanner whose clock is not the chair's.
//!
//! The emulator's clock hurries, and by how much depends on what else the machine has to do: a sentence that is
//! sent at its time would arrive at another one. So the chair stands, as far as the scanner is told, while a
//! chirp is under way, and goes on to the place of the next one before that is triggered: a row then lies
//! between two sentences that say the same, and its place does not depend on when they came.

use stairscan::motion::Reading;
use stairscan::report::motion;

use super::place::Place;
use crate::recording::Recording;

/// From sentence to sentence the chair goes no farther, 0.1 mm: half of what is taken for a jump however
/// short the time.
const STRIDE: i32 = 100;
/// Likewise its pitch, 0.001°.
const TILT: i32 = 500;

/// The sentences of one recording.
#[derive(Clone, Debug)]
pub struct ByTrigger {
    /// Travel and pitch at each chirp.
    places: Vec<(i32, Option<i32>)>,
    sequence: u16,
}

impl ByTrigger {
    /// Those of `recording`; none where it does not say how far the chair went.
    pub fn new(recording: &Recording) -> Option<Self> {
        let sensors = &recording.meta.motion;
        let place = |(k, travel_m): (usize, &f64)| {
            let pitch = sensors.pitch_deg.get(k);
            let travel = (travel_m * 1e4).round() as i32;
            (travel, pitch.map(|p| (p * 1e3).round() as i32))
        };
        let places: Vec<_> = sensors.travel_m.iter().enumerate().map(place).collect();
        (!places.is_empty()).then_some(Self {
            places,
            sequence: 0,
        })
    }

    /// Adds the place of the next chirp.
    pub fn push(&mut self, place: &Place) {
        let travel = (place.travel_m * 1e4).round() as i32;
        let pitch = (place.pitch_deg * 1e3).round() as i32;
        self.places.push((travel, Some(pitch)));
    }

    fn line(&mut self, (travel, pitch): (i32, Option<i32>)) -> String {
        self.sequence = self.sequence.wrapping_add(1);
        let reading = Reading {
            sequence: self.sequence,
            travel,
            pitch,
        };
        motion::write(&reading).as_str().to_owned()
    }

    /// Before the first chirp is triggered.
    pub fn first(&mut self) -> String {
        let place = self.places[0];
        self.line(place)
    }

    /// Once chirp `k` has been triggered: where the chair is, then its way to the place of the next chirp.
    pub fn at(&mut self, k: usize) -> Vec<String> {
        let Some(&from) = self.places.get(k) else {
            return Vec::new();
        };
        let to = self.places.get(k + 1).copied().unwrap_or(from);
        let strides = |a: i32, b: i32, most: i32| a.abs_diff(b).div_ceil(most as u32);
        let tilts = from.1.zip(to.1).map_or(0, |(a, b)| strides(a, b, TILT));
        let count = strides(from.0, to.0, STRIDE).max(tilts).max(1) as i32;
        let on = |a: i32, b: i32, n: i32| a + ((b - a) as i64 * n as i64 / count as i64) as i32;
        (0..=count)
            .map(|n| {
                let pitch = from.1.zip(to.1).map(|(a, b)| on(a, b, n));
                self.line((on(from.0, to.0, n), pitch))
            })
            .collect()
    }
}
