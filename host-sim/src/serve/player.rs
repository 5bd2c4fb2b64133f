//! Plays a recording at its true speed, repeatedly: each chirp at its time, each scan's answer with its last chirp.
//!
//! The answers are those of `replay`, computed some scans ahead by a thread. A recording without timestamps takes one
//! second a scan, as in MCAP files.

use std::sync::Arc;
use std::sync::mpsc::{self, Receiver};

use anyhow::{Context, Result};

use super::streams::{self, Outlet, Picture};
use crate::convert::scans::{SECOND_NS, Scan, chirp_ns};
use crate::playback::Playback;
use crate::recording::Recording;
use crate::replay::{self, Options};

/// Number of scans whose answers are computed ahead of the playback.
const AHEAD: usize = 2;
/// Pause between the last chirp of a recording with timestamps and the first chirp of the next
/// pass, nanoseconds.
const PAUSE_NS: u64 = SECOND_NS;

/// Clock of a playback, real or simulated.
pub trait Clock {
    /// Returns the current time, nanoseconds since 1970.
    fn now_ns(&self) -> u64;
    /// Waits until the time `ns`, nanoseconds since 1970. Returns `false` if the session has ended.
    fn wait_until(&mut self, ns: u64) -> bool;
}

/// A scan with the answer computed for it.
struct Part {
    scan: Scan,
    picture: Picture,
}

/// Times of a recording's chirps, nanoseconds since the start of a pass over the recording.
struct Times<'a> {
    recording: &'a Recording,
    first_ns: u64,
}

impl<'a> Times<'a> {
    fn of(recording: &'a Recording) -> Self {
        Self {
            recording,
            first_ns: chirp_ns(recording, 0).unwrap_or(0),
        }
    }

    /// Returns the time of chirp `k` (from 0 over all scans), nanoseconds since the start of a
    /// pass.
    fn chirp(&self, k: usize) -> u64 {
        let spread = || {
            let per_scan = self.recording.chirps_per_scan().max(1) as u64;
            (k as u64 + 1) * SECOND_NS / per_scan
        };
        let at = chirp_ns(self.recording, k).unwrap_or_else(spread);
        at.saturating_sub(self.first_ns)
    }

    /// Returns the duration of a pass over the recording, nanoseconds.
    fn pass(&self) -> u64 {
        let last = self.chirp(self.recording.chirps().saturating_sub(1));
        match chirp_ns(self.recording, 0) {
            Some(_) => last + PAUSE_NS,
            None => last,
        }
    }
}

/// Plays `recording` to `outlet` until `clock` ends it. `on_scan` is called with each scan as published.
///
/// # Errors
/// The recording cannot be scanned; the message names the cause.
pub fn play(
    recording: Recording,
    options: &Options,
    outlet: &dyn Outlet,
    clock: &mut dyn Clock,
    on_scan: &mut dyn FnMut(&Scan),
) -> Result<()> {
    Playback::new(&recording, &options.config)?;
    let recording = Arc::new(recording);
    let coming = work_out(&recording, *options);
    let times = Times::of(&recording);
    let mut parts = vec![next(&coming)?];
    let mut begin_ns = clock.now_ns();
    loop {
        for k in 0..recording.scans() {
            if k == parts.len() {
                parts.push(next(&coming)?);
            }
            let session = Session {
                times: &times,
                outlet,
                begin_ns,
            };
            match session.scan(&parts[k], clock)? {
                Some(scan) => on_scan(&scan),
                None => return Ok(()),
            }
        }
        begin_ns += times.pass();
    }
}

/// Starts a thread that replays the scans of a recording in order, and returns the receiver of the
/// results.
fn work_out(recording: &Arc<Recording>, options: Options) -> Receiver<Result<Part>> {
    let (sender, coming) = mpsc::sync_channel(AHEAD);
    let recording = recording.clone();
    std::thread::spawn(move || {
        let done = replay::answers(&recording, &options, |scanned| {
            // Without a receiver the remaining scans are not needed either.
            let _ = sender.send(Ok(Part {
                scan: Scan::of(&recording, scanned),
                picture: Picture::of(scanned.pipeline.map()),
            }));
        });
        if let Err(error) = done {
            let _ = sender.send(Err(error));
        }
    });
    coming
}

fn next(coming: &Receiver<Result<Part>>) -> Result<Part> {
    coming.recv().context("the scanner gave no answer")?
}

/// State of one pass over a recording, which began at `start`.
struct Session<'a> {
    times: &'a Times<'a>,
    outlet: &'a dyn Outlet,
    begin_ns: u64,
}

impl Session<'_> {
    /// Plays one scan and returns it; `None` if the session has ended meanwhile.
    fn scan(&self, part: &Part, clock: &mut dyn Clock) -> Result<Option<Scan>> {
        let recording = self.times.recording;
        let number = &part.scan.json["scan"];
        let mut stamp_ns = self.begin_ns;
        for k in recording.chirps_of(part.scan.answer.scan_of_recording()) {
            stamp_ns = self.begin_ns + self.times.chirp(k);
            if !clock.wait_until(stamp_ns) {
                return Ok(None);
            }
            streams::publish_chirp(self.outlet, recording, (number, k), stamp_ns);
        }
        let scan = Scan {
            stamp_ns,
            ..part.scan.clone()
        };
        streams::publish_scan(self.outlet, &scan)?;
        streams::publish_map(self.outlet, &part.picture, stamp_ns)?;
        Ok(Some(scan))
    }
}
