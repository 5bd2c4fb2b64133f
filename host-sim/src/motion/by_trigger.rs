//! Motion sentences for a scanner whose clock is not the chair's.
//!
//! The emulator's clock runs fast by a factor that depends on the machine's load, so that a
//! sentence sent at its time would arrive at another time. Here the sentences report a chair that
//! stands while a chirp is under way, and that moves on to the place of the next chirp before that
//! one is triggered. A row then lies between two sentences with the same content, and its place
//! does not depend on their times of arrival.

use stairscan::motion::Reading;
use stairscan::report::motion;

use super::place::Place;
use crate::recording::Recording;

/// Maximum travel from sentence to sentence, 0.1 mm: half the distance that the scanner takes for a
/// jump over any time, however short.
const STRIDE: i32 = 100;
/// Maximum change of pitch from sentence to sentence, 0.001°: likewise half the limit.
const TILT: i32 = 500;

/// Motion sentences of one recording.
#[derive(Clone, Debug)]
pub struct ByTrigger {
    /// Travel and pitch at each chirp.
    places: Vec<(i32, Option<i32>)>,
    sequence: u16,
}

impl ByTrigger {
    /// Creates the sentences of `recording`; `None` if it has no travel.
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

    /// Returns the sentence before the first chirp is triggered.
    pub fn first(&mut self) -> String {
        let place = self.places[0];
        self.line(place)
    }

    /// Returns the sentences once chirp `k` has been triggered: the chair's place, then its way to
    /// the place of the next chirp.
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
