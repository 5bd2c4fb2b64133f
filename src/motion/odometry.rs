//! Motion input: checks each motion sentence against the one before, and interpolates the chair's position to
//! each row's mid chirp.
//!
//! A sentence has no timestamp; its time is that of its arrival. A row's position is therefore known once the
//! next sentence has arrived, and rows wait for it. The last rows of a scan are extrapolated on the line
//! through the last two sentences. Sentences that arrive together after a gap were read at different times: the
//! last of them is the position on arrival, and the travel of all is judged over the gap. An implausible change
//! between two sentences discards the positions of the rows between them, and the scan then counts as one without
//! motion input.

use crate::drive::{Drive, ExpectedTravel, Input, Mode, PhaseAgreement, Retention};
use crate::math::RAD_PER_DEG;
use crate::time::Micros;
use crate::track::{RowPose, Track};
use heapless::Deque;

/// Default age above which a motion sentence is stale, microseconds.
pub const MAX_AGE_US: u32 = 200_000;
/// Maximum number of rows that wait for the next motion sentence: those of 200 ms of the fastest scans.
const MAX_WAITING: usize = 64;
/// Maximum speed of a power chair near stairs, mm/s: 6 km/h, the speed limit of indoor chairs (EN 12184 class A
/// and B), and a margin.
const MAX_MM_S: u64 = 2_000;
/// Permitted excess of the travel between two sentences over the maximum speed, mm: the odometer's resolution and
/// small differences of delay.
const TRAVEL_SLACK_MM: u64 = 20;
/// Maximum pitch rate of a chair that stays on its wheels, degrees/s: off a 5 cm kerb at walking pace.
const MAX_DEG_S: u64 = 60;
/// Maximum noise of an inclinometer, 0.001 degree.
const PITCH_SLACK: u64 = 1_000;
/// Maximum step of the sequence number from one motion sentence to the next: forward for lost sentences (those
/// of 200 ms at 100 Hz, with a margin), backward for sentences out of order.
const MAX_LOST: u16 = 1_000;
/// Maximum time between sentences that arrive together, microseconds, if nothing is known of the time before: one
/// sentence takes 4 ms on the wire.
const TOGETHER_US: u32 = 5_000;

/// Least time over which the speed is measured, microseconds, and half of the most: sentences come by milliseconds early or
/// late, and a chair brakes with 1 m/s².
const SPEED_US: u32 = 30_000;

/// Content of one motion sentence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Sequence number of the sentence, 0…65535, increased by one each time.
    pub sequence: u16,
    /// Forward travel of the chair, cumulative, 0.1 mm.
    pub travel: i32,
    /// The chair's pitch, nose up positive, 0.001°; `None` without an inclinometer.
    pub pitch: Option<i32>,
}

/// A reading and its time of arrival.
#[derive(Clone, Copy, Debug)]
struct Arrived {
    at: Micros,
    reading: Reading,
}

/// Time and travel, 0.1 mm, of a sentence.
#[derive(Clone, Copy, Debug)]
struct Passed {
    at: Micros,
    travel: i32,
}

impl Passed {
    const NOWHERE: Self = Self {
        at: Micros(0),
        travel: 0,
    };
}

/// Time and travel of the last row of a scan.
#[derive(Clone, Copy, Debug)]
struct End {
    at: Micros,
    /// Odometer's travel from which the scan's track counts (0.1 mm), the track's travel at the last row
    /// (metres), and the number of the chain of readings; `None` if the scan's input was not good.
    travel: Option<(i32, f32, u16)>,
}

impl End {
    /// Returns the travel from this last row to the last row `later`, metres; `None` if the input was not good
    /// all the way.
    fn travel_m(&self, later: &Self) -> Option<f32> {
        match (self.travel, later.travel) {
            (Some((a, a_m, chain)), Some((b, b_m, same))) if chain == same => {
                Some(b.wrapping_sub(a) as f32 * 1e-4 + b_m - a_m)
            }
            _ => None,
        }
    }
}

/// Motion input, and the track of a scan that results from it.
#[derive(Debug)]
pub struct Odometry {
    /// Last reading, and (`before`) the one before it if the travel between them is known.
    last: Option<Arrived>,
    before: Option<Arrived>,
    /// Readings between which the speed is measured: one at least [`SPEED_US`] before the last, and (`recent`) the one that
    /// takes its place.
    base: Passed,
    recent: Passed,
    /// Arrival of the first of the sentences that arrived together with `last`; its own without others.
    first_at: Micros,
    /// Whether rows have been placed since then.
    placed: bool,
    /// Number of the chain of readings; a new one begins when the travel between two readings is unknown.
    segment: u16,
    state: Input,
    faults: u16,
    waiting: Deque<(u16, Micros), MAX_WAITING>,
    track: Track,
    /// Time of the present scan's first row, and the odometer's travel from which the scan's track counts, 0.1
    /// mm; `None` before that row.
    begun: Option<(Micros, i32)>,
    /// Odometer's travel by the first sentence after that row, 0.1 mm.
    first_travel: Option<i32>,
    /// Time of the scan's last trigger.
    row_at: Micros,
    /// State of the motion input in the present scan: its first fault, `Good` without one.
    scan: Input,
    /// Time and travel of the last row of the last scan, and (`guard_end`) of the last row of the last guard sweep.
    end: Option<End>,
    guard_end: Option<End>,
    since_s: Option<f32>,
    moved_m: Option<f32>,
    /// Travel from the last full scan to the guard sweep that has just ended, metres.
    since_scan_m: Option<f32>,
    retention: Retention,
    /// Age above which a motion sentence is stale, microseconds.
    max_age_us: u32,
}

impl Default for Odometry {
    fn default() -> Self {
        Self::new()
    }
}

impl Odometry {
    /// Creates a motion input that has received no sentence.
    pub const fn new() -> Self {
        Self {
            last: None,
            before: None,
            base: Passed::NOWHERE,
            recent: Passed::NOWHERE,
            first_at: Micros(0),
            placed: false,
            segment: 0,
            state: Input::Absent,
            faults: 0,
            waiting: Deque::new(),
            track: Track::new(),
            begun: None,
            first_travel: None,
            row_at: Micros(0),
            scan: Input::Absent,
            end: None,
            guard_end: None,
            since_s: None,
            moved_m: None,
            since_scan_m: None,
            retention: Retention::Kept,
            max_age_us: MAX_AGE_US,
        }
    }

    /// Returns the state of the motion input at `now`.
    pub fn state(&self, now: Micros) -> Input {
        match self.last {
            Some(last) if now.since(last.at) > self.max_age_us => Input::Late,
            _ => self.state,
        }
    }

    /// Keeps the ages of the last sentence and of the last scans from wrapping with the clock; to be called every few
    /// minutes.
    pub fn keep_ages(&mut self, now: Micros) {
        if let Some(last) = &mut self.last {
            last.at = last.at.aged(now);
        }
        for end in [&mut self.end, &mut self.guard_end].into_iter().flatten() {
            end.at = end.at.aged(now);
        }
    }

    /// Returns the travel for the row triggered at `at`, if the chair may move: by the last two motion sentences, however
    /// old they are, or because there are none and `mode` does not say that it stands.
    pub fn expected_travel(&mut self, mode: Mode, at: Micros) -> Option<ExpectedTravel> {
        let row_before = core::mem::replace(&mut self.row_at, at);
        let metres = |to: Arrived, from: i32| to.reading.travel.wrapping_sub(from) as f32 * 1e-4;
        let travelled =
            |(before, last): (Arrived, Arrived)| before.reading.travel != last.reading.travel;
        let moves = mode != Mode::Standing && self.before.zip(self.last).is_none_or(travelled);
        let step_m = match (self.last, self.begun) {
            (Some(last), Some(_)) => {
                let gap_us = last.at.since(self.base.at).max(1);
                metres(last, self.base.travel) * at.since(row_before) as f32 / gap_us as f32
            }
            _ => 0.0,
        };
        let since_first_m = self.last.zip(self.first_travel);
        moves.then(|| ExpectedTravel {
            since_first_m: since_first_m.map_or(0.0, |(last, first)| metres(last, first)),
            step_m,
        })
    }

    /// Sets the age above which a motion sentence is stale, microseconds.
    pub fn set_max_age(&mut self, oldest_us: u32) {
        self.max_age_us = oldest_us;
    }

    /// Returns the number of motion sentences that were wrong or too late, since boot.
    pub fn faults(&self) -> u16 {
        self.faults
    }

    /// Counts a fault `what` of the motion input, and discards the present scan's positions.
    fn fault(&mut self, what: Input) {
        self.state = what;
        self.faults = self.faults.saturating_add(1);
        self.invalidate_scan(what);
    }

    /// Marks the present scan as one without motion input, because of the fault `what`.
    fn invalidate_scan(&mut self, what: Input) {
        if self.begun.is_some() && self.scan == Input::Good {
            self.scan = what;
        }
    }

    /// Counts a motion sentence that was received damaged.
    pub fn garbled(&mut self) {
        self.fault(Input::Garbled);
    }

    /// Takes a motion sentence that arrived at `now`: checks it against the one before, and interpolates the
    /// positions of waiting rows.
    pub fn take(&mut self, now: Micros, reading: Reading) {
        let next = Arrived { at: now, reading };
        let Some(last) = self.last else {
            self.state = Input::Good;
            return self.follow(None, next);
        };
        let step = reading.sequence.wrapping_sub(last.reading.sequence);
        if step == 0 {
            // `last` stays: without another sentence the input becomes late.
            return self.fault(Input::Frozen);
        }
        if step > MAX_LOST && step.wrapping_neg() <= MAX_LOST {
            return self.fault(Input::Disordered);
        }
        let trouble = if now.since(last.at) > self.max_age_us {
            Input::Late
        } else if is_steady(&last, &next) {
            self.state = Input::Good;
            self.settle();
            return self.follow(Some(last), next);
        } else if !self.joins(&next) {
            Input::Jumping
        } else if self.placed {
            // Rows lie already where the first of these sentences says, which was too late.
            Input::Late
        } else {
            self.state = Input::Good;
            self.last = Some(next);
            return;
        };
        self.fault(trouble);
        self.settle();
        self.segment = self.segment.wrapping_add(1);
        self.follow(None, next);
    }

    /// Makes `next` the last reading, and `before` the one before it. Waiting rows are placed once no other can arrive
    /// together with it.
    fn follow(&mut self, before: Option<Arrived>, next: Arrived) {
        (self.before, self.last) = (before, Some(next));
        let here = Passed {
            at: next.at,
            travel: next.reading.travel,
        };
        if before.is_none() {
            (self.base, self.recent) = (here, here);
        } else if here.at.since(self.recent.at) >= SPEED_US {
            (self.base, self.recent) = (self.recent, here);
        }
        if self.begun.is_some() && self.first_travel.is_none() {
            self.first_travel = Some(next.reading.travel);
        }
        (self.first_at, self.placed) = (next.at, false);
    }

    /// Returns whether `next` arrives together with the last reading, sooner after it than after half the gap before
    /// it, and is where a chair can be that moved since the reading before the gap.
    fn joins(&self, next: &Arrived) -> bool {
        let gap = |before: Arrived| self.first_at.since(before.at);
        let together = TOGETHER_US.max(self.before.map_or(0, gap) / 2);
        next.at.since(self.first_at) < together
            && self.before.is_none_or(|before| is_steady(&before, next))
    }

    /// Begins a scan of `rows` rows.
    pub fn begin(&mut self, rows: u16) {
        self.track.begin(rows);
        self.waiting.clear();
        self.begun = None;
        self.first_travel = None;
        self.since_s = None;
        self.moved_m = None;
        self.scan = Input::Good;
    }

    /// Takes row `row` of the map, with its mid chirp at `at`; the row waits for the next motion sentence.
    pub fn row(&mut self, row: u16, at: Micros) {
        if self.begun.is_none() {
            let origin = self.last.map_or(0, |last| last.reading.travel);
            self.begun = Some((at, origin));
        }
        self.settle();
        if self.waiting.is_full()
            && let Some((row, at)) = self.waiting.pop_front()
        {
            self.add_without_position(row, at, Input::Late);
        }
        // The queue has room.
        let _ = self.waiting.push_back((row, at));
    }

    /// Adds a row at time `at` whose position is unknown, and marks the scan with the reason `why`.
    fn add_without_position(&mut self, row: u16, at: Micros, why: Input) {
        self.invalidate_scan(match self.state {
            Input::Absent => Input::Absent,
            _ => why,
        });
        let time_s = self.time_s(at);
        let place = RowPose {
            time_s,
            ..self.track.end()
        };
        self.track.add(row, place);
    }

    fn time_s(&self, at: Micros) -> f32 {
        let begun = self.begun.map_or(at, |(begun, _)| begun);
        at.since(begun) as f32 * 1e-6
    }

    /// Places the waiting rows between the last two readings.
    fn settle(&mut self) {
        if let (Some(_), Some(last)) = (self.before, self.last) {
            self.interpolate_waiting(last.at);
        }
    }

    /// Adds the waiting rows up to time `until` to the track, interpolated on the line through the last two
    /// readings.
    fn interpolate_waiting(&mut self, until: Micros) {
        while let Some(&(row, at)) = self.waiting.front() {
            if !until.reached(at) {
                return;
            }
            self.waiting.pop_front();
            self.placed = true;
            match self.place(at) {
                Some(place) => self.track.add(row, place),
                None => self.add_without_position(row, at, Input::Late),
            }
        }
    }

    /// Returns the chair's pose at time `at`, on the line through the last two motion sentences: time since the scan's
    /// first row, travel since the last sentence before that row, and pitch. `None` before the first of the two.
    fn place(&self, at: Micros) -> Option<RowPose> {
        let (before, last) = (self.before?, self.last?);
        // No extrapolation to times before the two readings.
        if !at.reached(before.at) {
            return None;
        }
        let (_, origin) = self.begun?;
        let span = last.at.since(before.at);
        let share = if span == 0 {
            1.0
        } else {
            at.since(before.at) as f32 / span as f32
        };
        let between = |a: i32, b: i32| a as f32 + share * (b.wrapping_sub(a)) as f32;
        let travel = between(
            before.reading.travel.wrapping_sub(origin),
            last.reading.travel.wrapping_sub(origin),
        );
        let pitch = match (before.reading.pitch, last.reading.pitch) {
            (Some(a), Some(b)) => between(a, b),
            _ => 0.0,
        };
        Some(RowPose {
            time_s: self.time_s(at),
            travel_m: travel * 1e-4,
            pitch_rad: pitch * 1e-3 * RAD_PER_DEG,
        })
    }

    /// Ends a scan of the other plane (depth or height) in between: the next scan's travel counts from the scan
    /// before this one.
    pub fn finish_aside(&mut self, now: Micros) {
        let before = self.end;
        self.finish(now);
        self.end = before;
        (self.since_s, self.moved_m) = (None, None);
    }

    /// Ends a scan after its last row, at time `now`: gives the waiting rows their positions, and determines time and
    /// travel since the last row of the scan before.
    pub fn finish(&mut self, now: Micros) {
        let last_row = self.waiting.back().map(|&(_, at)| at);
        match self.last {
            Some(last) if now.since(last.at) <= self.max_age_us => self.interpolate_waiting(now),
            stale => {
                if stale.is_some() {
                    self.fault(Input::Late);
                    self.segment = self.segment.wrapping_add(1);
                    (self.before, self.last) = (None, None);
                }
                while let Some((row, at)) = self.waiting.pop_front() {
                    self.add_without_position(row, at, Input::Late);
                }
            }
        }
        let Some((begun, origin)) = self.begun else {
            return;
        };
        let end = self.track.end();
        let at = last_row.unwrap_or(begun.plus((end.time_s * 1e6) as u32));
        let known = self.scan == Input::Good;
        let travel = known.then_some((origin, end.travel_m, self.segment));
        if let Some(before) = self.end {
            self.since_s = Some(at.since(before.at) as f32 * 1e-6);
            self.moved_m = before.travel_m(&End { at, travel });
        }
        self.end = Some(End { at, travel });
    }

    /// Ends a guard sweep after its last row. Its travel counts from the guard sweep before, and the next
    /// scan's from the scan before.
    pub fn finish_guard(&mut self, now: Micros) {
        let scan = core::mem::replace(&mut self.end, self.guard_end);
        self.finish(now);
        self.guard_end = self.end;
        self.since_scan_m = scan
            .zip(self.end)
            .and_then(|(scan, end)| scan.travel_m(&end));
        self.end = scan;
    }

    /// Returns the travel from the last full scan to the last guard sweep, metres; `None` if the input was not
    /// good all the way.
    pub fn since_scan_m(&self) -> Option<f32> {
        self.since_scan_m
    }

    /// Returns the chair's motion in the scan that has just ended.
    pub fn drive(&self, mode: Mode, chirp_us: u32) -> Drive<'_> {
        if mode == Mode::Standing {
            let memory = match self.retention {
                Retention::Aside => Retention::Aside,
                _ => Drive::STANDING.memory,
            };
            return Drive {
                memory,
                ..Drive::STANDING
            };
        }
        Drive {
            mode,
            input: self.scan,
            track: Some(&self.track),
            moved_m: self.moved_m,
            since_s: self.since_s,
            phases: PhaseAgreement::Unknown,
            chirp_s: chirp_us as f32 * 1e-6,
            memory: self.retention,
        }
    }

    /// Sets whether the evidence of scans before the present one is used.
    pub fn set_retention(&mut self, memory: Retention) {
        self.retention = memory;
    }
}

/// Returns whether a chair can have moved from one reading to the next: within its maximum speed and pitch
/// rate.
fn is_steady(a: &Arrived, b: &Arrived) -> bool {
    let us = u64::from(b.at.since(a.at));
    let travel = u64::from(b.reading.travel.abs_diff(a.reading.travel));
    // Both sides in nanometres: 0.1 mm is 100,000 nm, and 1 mm/s over 1 µs is 1 nm.
    let far = travel * 100_000 > MAX_MM_S * us + TRAVEL_SLACK_MM * 1_000_000;
    let tipped = match (a.reading.pitch, b.reading.pitch) {
        (Some(a), Some(b)) => {
            u64::from(b.abs_diff(a)) * 1_000 > MAX_DEG_S * us + PITCH_SLACK * 1_000
        }
        (None, None) => false,
        // An inclinometer that appears or disappears.
        _ => true,
    };
    !far && !tipped
}

#[cfg(test)]
mod tests;
