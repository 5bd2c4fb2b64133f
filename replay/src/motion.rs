//! Motion sentences of a chair's controller during a recording: generated from the recording's
//! travel and pitch, with faults of their transmission.

pub mod by_trigger;
pub mod inlet;
pub mod place;

use std::collections::VecDeque;

use clap::ValueEnum;
use stairscan::motion::Reading;
use stairscan::report::motion;
use stairscan::scanner::Micros;

use crate::recording::Recording;
use by_trigger::ByTrigger;
use place::Place;

/// Minimum time between two sentences, µs: a hundred per second.
const APART_US: u64 = 10_000;
/// Time from row to row of a recording without times, s: the paper's 281 rows in 1.3 s.
const ROW_S: f64 = 1.3 / 281.0;
/// Motion between two scans of a recording without times: time to come to rest, s, and speed on the
/// way, m/s.
const REST_S: f64 = 0.5;
const SPEED: f64 = 0.25;
/// Time from the first sentence to the first chirp, s: the controller starts before the scanner.
const LEAD_S: f64 = 1.0;
/// Share of lost sentences under [`Fault::Lost`], per cent.
const LOST_PER_CENT: u64 = 30;
/// Delay of sentences under [`Fault::Delayed`], µs.
const DELAY_US: u64 = 300_000;
/// Jump of the travel in each scan under [`Fault::Jumping`], 0.1 mm.
const JUMP: i32 = 1_000;

/// Fault of the motion sentences or of their transmission.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Fault {
    /// No sentence is sent.
    Absent,
    /// 30 % of the sentences are lost.
    Lost,
    /// Two consecutive sentences are exchanged, pair by pair.
    Swapped,
    /// All sentences arrive 300 ms late.
    Delayed,
    /// From the middle of the second scan on, the same sentence is repeated.
    Stuck,
    /// Travel and pitch are constant, while the sentences' sequence number goes on.
    Frozen,
    /// Travel jumps by 10 cm in the middle of each scan.
    Jumping,
    /// Forward travel is reported as backward.
    Reversed,
    /// One sentence in ten has a changed byte.
    Garbled,
}

/// Motion sentences of one recording, or of one scan of it.
#[derive(Clone, Debug)]
pub struct MotionSentences {
    /// For each chirp: its time, µs, and the reading then, travel in 0.1 mm and pitch in 0.001°.
    rows: Vec<(u64, MotionReading)>,
    per_scan: usize,
    fault: Option<Fault>,
    sequence: u16,
    sent_us: Option<u64>,
    under_way: VecDeque<(u64, String)>,
}

/// Content of a motion sentence: the chair's forward travel, 0.1 mm, and its pitch, nose up, 0.001°.
#[derive(Clone, Copy, Debug)]
struct MotionReading {
    travel: f64,
    pitch: Option<f64>,
}

impl MotionSentences {
    /// Creates the sentences of `recording`, with a fault if given; `None` if the recording has no
    /// travel.
    pub fn new(recording: &Recording, fault: Option<Fault>) -> Option<Self> {
        let sensors = &recording.meta.motion;
        if sensors.travel_m.is_empty() {
            return None;
        }
        let per_scan = recording.chirps_per_scan().max(1);
        let mut time = LEAD_S;
        let start = sensors.time_s.first().copied().unwrap_or(0.0);
        let mut rows: Vec<(u64, MotionReading)> = Vec::new();
        for (k, &travel_m) in sensors.travel_m.iter().enumerate() {
            if let (Some(before), true) = (k.checked_sub(1), sensors.time_s.is_empty()) {
                time += ROW_S;
                if k % per_scan == 0 {
                    time += REST_S + (travel_m - sensors.travel_m[before]).abs() / SPEED;
                }
            }
            let time = sensors.time_s.get(k).map_or(time, |t| LEAD_S + t - start);
            let said = MotionReading {
                travel: travel_m * 1e4,
                pitch: sensors.pitch_deg.get(k).map(|p| p * 1e3),
            };
            rows.push(((time * 1e6).round() as u64, said));
        }
        Some(Self {
            rows,
            per_scan,
            fault,
            sequence: 0,
            sent_us: None,
            under_way: VecDeque::new(),
        })
    }

    /// Adds the chair's sensor readings at the next chirp, for a chair that is simulated while the scanner scans.
    fn push(&mut self, row: &Place) {
        let said = MotionReading {
            travel: row.travel_m * 1e4,
            pitch: Some(row.pitch_deg * 1e3),
        };
        let time = LEAD_S + row.time_s;
        self.rows.push(((time * 1e6).round() as u64, said));
    }

    /// Returns the time at which chirp `k` (from 0 over all scans) is fired, µs; `None` beyond the
    /// last.
    pub fn time_us(&self, k: usize) -> Option<u64> {
        self.rows.get(k).map(|row| row.0)
    }

    /// Whether chirp `chirp` (from 0 over all scans) is the first or the last of its scan.
    fn at_an_end(&self, chirp: usize) -> bool {
        let place = chirp % self.per_scan;
        place == 0 || place + 1 == self.per_scan
    }

    /// Returns the sentences that arrive at the scanner at `now` (µs). Chirp `k` is the next one
    /// or, at its time, the present one.
    pub fn arriving(&mut self, k: usize, now: u64) -> Vec<String> {
        if self.sent_us.is_none_or(|sent| now >= sent + APART_US) {
            self.send(k, now);
            self.sent_us = Some(now);
        }
        let mut arrived = Vec::new();
        while let Some((_, line)) = self.under_way.pop_front_if(|(at, _)| *at <= now) {
            arrived.push(line);
        }
        arrived
    }

    /// Returns travel and pitch at `now` (µs), interpolated between the chirps `k - 1` and `k`;
    /// `None` before the first.
    fn said(&self, k: usize, now: u64) -> Option<MotionReading> {
        let (to_us, to) = *self.rows.get(k).or(self.rows.last())?;
        let (from_us, from) = k.checked_sub(1).and_then(|k| self.rows.get(k)).copied()?;
        let share = (now.saturating_sub(from_us)) as f64 / (to_us - from_us).max(1) as f64;
        let mix = |a: f64, b: f64| a + share.min(1.0) * (b - a);
        Some(MotionReading {
            travel: mix(from.travel, to.travel),
            pitch: from.pitch.zip(to.pitch).map(|(a, b)| mix(a, b)),
        })
    }

    fn send(&mut self, k: usize, now: u64) {
        let Some(mut said) = self.said(k, now).or(self.rows.first().map(|row| row.1)) else {
            return;
        };
        let stuck = self.fault == Some(Fault::Stuck) && k > self.per_scan + self.per_scan / 2;
        if !stuck {
            self.sequence = self.sequence.wrapping_add(1);
        }
        let number = u64::from(self.sequence);
        // Pseudo-random decision whether a sentence is affected, the same in every run.
        let chance = number.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 33;
        let mut at = now;
        match self.fault {
            Some(Fault::Absent) => return,
            Some(Fault::Lost) if chance % 100 < LOST_PER_CENT => return,
            Some(Fault::Swapped) if number.is_multiple_of(2) => at = now + APART_US + APART_US / 2,
            Some(Fault::Delayed) => at = now + DELAY_US,
            Some(Fault::Frozen) => said = self.rows.first().map_or(said, |row| row.1),
            Some(Fault::Reversed) => said.travel = -said.travel,
            Some(Fault::Jumping) => {
                let jumps = (k + self.per_scan / 2) / self.per_scan;
                said.travel += f64::from(JUMP) * jumps as f64;
            }
            _ => {}
        }
        let reading = Reading {
            sequence: self.sequence,
            travel: said.travel.round() as i32,
            pitch: said.pitch.map(|p| p.round() as i32),
        };
        let mut line = motion::write(&reading).as_str().to_owned();
        if self.fault == Some(Fault::Garbled) && chance % 10 == 0 {
            line = line.replacen('.', ":", 1);
        }
        self.under_way.push_back((at, line));
        self.under_way.make_contiguous().sort_by_key(|(at, _)| *at);
    }
}

/// Time between two steps of the simulated scanner where nothing else limits it, µs.
const GRAIN_US: u64 = 1_000;
/// Number of steps of the simulated scanner from the module's settings to the first trigger, and
/// from row to row.
const STEPS_TO_FIRST: u64 = 2;
const STEPS_PER_ROW: u64 = 4;
/// Maximum time between two steps while the simulated scanner waits for a scan's first chirp, µs.
const WAIT_US: u64 = 50_000;

/// Time between two steps for scans without times, µs: long enough for any mirror to come to rest.
const REST_US: u64 = 10_000;

/// Source of the motion sentences, which also decides when they are sent.
#[derive(Clone, Debug)]
enum Source {
    /// Sentences at the times of the recording.
    Timed(MotionSentences),
    /// Sentences with each trigger, without times.
    ByTrigger(ByTrigger),
}

/// Schedule of a recording's chirps at their original times, with the motion sentences between
/// them: the clock of a simulated scanner.
#[derive(Clone, Debug)]
pub struct Timetable {
    source: Source,
    /// Number of the next chirp; and for the last one fired its scheduled time and the scanner's
    /// time, µs.
    next: usize,
    fired: Option<(u64, u64)>,
    steps: u64,
    /// Bytes that have arrived at the scanner's report port and are not read yet.
    port: VecDeque<u8>,
}

impl Timetable {
    /// Creates the timetable of the motion sentences `feed`, before the first chirp.
    pub fn new(feed: MotionSentences) -> Self {
        Self::with(Source::Timed(feed))
    }

    /// Creates a timetable that ignores the recording's times: each trigger sends the sentences up
    /// to the next chirp.
    pub fn by_trigger(mut source: ByTrigger) -> Self {
        let first = source.first();
        let mut table = Self::with(Source::ByTrigger(source));
        table.type_in(first.as_bytes());
        table
    }

    fn with(source: Source) -> Self {
        Self {
            source,
            next: 0,
            fired: None,
            steps: 0,
            port: VecDeque::new(),
        }
    }

    /// Adds the chair's sensor readings at the next chirp, for a chair that is simulated while the scanner scans.
    pub fn push(&mut self, place: &Place) {
        match &mut self.source {
            Source::Timed(feed) => feed.push(place),
            Source::ByTrigger(source) => source.push(place),
        }
    }

    /// Returns the time at which chirp `chirp` is due, µs; `None` without times.
    fn due(&self, chirp: usize) -> Option<u64> {
        match &self.source {
            Source::Timed(feed) => feed.time_us(chirp),
            Source::ByTrigger(_) => None,
        }
    }

    fn arrive(&mut self, chirp: usize, now: u64) {
        if let Source::Timed(feed) = &mut self.source {
            for line in feed.arriving(chirp, now) {
                self.port.extend(line.bytes());
            }
        }
    }

    /// Returns the time at which the next scan must begin for its first chirp to be in time, µs;
    /// `None` within a scan or without times.
    fn ready(&self) -> Option<u64> {
        let Source::Timed(feed) = &self.source else {
            return None;
        };
        let due = feed.time_us(self.next)?;
        let first = self.next.is_multiple_of(feed.per_scan);
        first.then_some(due - STEPS_TO_FIRST * GRAIN_US)
    }

    /// Whether it is too early at `now` to begin the next scan, so that its first chirp would come before its time in
    /// the recording.
    pub fn early(&self, now: Micros) -> bool {
        self.ready().is_some_and(|ready| u64::from(now.0) < ready)
    }

    /// Records that chirp `chirp` is fired at `now`, and sends the motion sentences that are due.
    pub fn fired(&mut self, chirp: usize, now: Micros) {
        let now = now.0.into();
        match &mut self.source {
            // Motion between two scans is interpolated without data and must not reach into them.
            Source::Timed(feed) if feed.at_an_end(chirp) => feed.sent_us = None,
            Source::Timed(_) => {}
            Source::ByTrigger(source) => {
                let lines = source.at(chirp);
                self.port.extend(lines.iter().flat_map(|line| line.bytes()));
            }
        }
        self.arrive(chirp, now);
        self.fired = self.due(chirp).map(|plan| (plan, now));
        self.next = chirp + 1;
        self.steps = 0;
    }

    /// Returns the time of the simulated scanner's next step after that at `now`.
    pub fn step(&mut self, now: Micros) -> Micros {
        let now = u64::from(now.0);
        if matches!(self.source, Source::ByTrigger(_)) {
            return Micros((now + REST_US) as u32);
        }
        let next = match (self.ready(), self.fired, self.due(self.next)) {
            (Some(ready), _, _) if now < ready => ready.min(now + WAIT_US),
            (None, Some((plan, at)), Some(due)) if self.steps < STEPS_PER_ROW => {
                self.steps += 1;
                at + (due - plan) * self.steps / STEPS_PER_ROW
            }
            _ => now + GRAIN_US,
        };
        if self.ready().is_some() {
            self.arrive(self.next, next);
        }
        Micros(next as u32)
    }

    /// Adds the bytes of typed command lines, after the motion sentences so far.
    pub fn type_in(&mut self, lines: &[u8]) {
        self.port.extend(lines);
    }

    /// Returns the next byte at the scanner's report port; `None` if there is none.
    pub fn read(&mut self) -> Option<u8> {
        self.port.pop_front()
    }
}
