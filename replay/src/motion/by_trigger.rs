//! Motion sentences (travel and pitch of the chair) for a scanner whose clock is not the chair's.
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

/// Maximum travel from sentence to sentence, 0.1 mm: half the travel that the scanner rejects as a
/// jump, however short the time.
const STRIDE: i32 = 100;
/// Maximum change of pitch from sentence to sentence, 0.001°: half the change that the scanner
/// rejects as a jump.
const TILT: i32 = 500;

/// Motion sentences of one recording, each sent when a chirp is triggered.
#[derive(Clone, Debug)]
pub struct ByTrigger {
    /// Place of the chair at each chirp: travel, 0.1 mm, and pitch, 0.001°; `None` without pitch
    /// readings.
    places: Vec<(i32, Option<i32>)>,
    sequence: u16,
}

impl ByTrigger {
    /// Creates the sentences of `recording`; `None` if the recording has no travel.
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

    /// Adds the place at the next chirp, for a chair that is simulated while the scanner scans.
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

    /// Returns the sentence that is sent before the first chirp is triggered: the place of that
    /// chirp.
    pub fn first(&mut self) -> String {
        let place = self.places[0];
        self.line(place)
    }

    /// Returns the sentences that are sent once chirp `k` has been triggered: the chair's place,
    /// then its way to the place of the next chirp.
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
