//! Publishes a port or a recording as a service while it is observed or played.

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use anyhow::{Context as _, Result};

use super::watching::{Args, interrupted, source, watch};
use crate::answer::Answer;
use crate::commands::{emit, logs};
use crate::convert::scans::Scan;
use crate::playback::Playback;
use crate::recording::Recording;
use crate::serve::player::{self, Clock};
use crate::serve::streams::{Service, Stream, publish_scan};

/// Interval at which the end of a session is checked while waiting.
const GRAIN: Duration = Duration::from_millis(50);

/// Properties of the source, a port or a recording, that a service needs to start.
pub struct Offer {
    /// Topics on which the source is published.
    pub streams: &'static [Stream],
    /// Height of the mirror's centre above the ground, metres; the default if the source does not report it.
    #[cfg_attr(not(feature = "ros2"), allow(dead_code))]
    pub mount_height_m: f64,
}

/// Function that starts a service (Foxglove or ROS 2) for a source with the properties of the offer.
type Open<'a> = &'a dyn Fn(&Offer) -> Result<Box<dyn Service>>;

/// Plays a recording or observes a port, and publishes it, until the session is ended.
pub fn run(args: &Args, started: Instant, open: Open<'_>) -> Result<ExitCode> {
    match &args.play {
        Some(path) if logs::is_recording(path) => play(args, path, open),
        _ => port(args, started, open),
    }
}

/// Starts a service, and prints its address and its warning to stderr.
fn opened(open: Open<'_>, offer: &Offer) -> Result<Box<dyn Service>> {
    let service = open(offer)?;
    if let Some(warning) = service.warning() {
        crate::note!("{warning}");
    }
    crate::note!("{}", service.place());
    Ok(service)
}

/// Plays a recording at its true speed and publishes it, until it is interrupted.
fn play(args: &Args, path: &Path, open: Open<'_>) -> Result<ExitCode> {
    let recording = Recording::read(path)?;
    let options = args.settings.options(args.settings.config()?);
    // A recording that cannot be scanned is reported before the service starts.
    Playback::new(&recording, &options.config)?;
    let offer = Offer {
        streams: &Stream::OF_RECORDINGS,
        mount_height_m: mount_height_m(args, Some(&recording))?,
    };
    let service = opened(open, &offer)?;
    let mut clock = Wall::new(interrupted()?);
    let report = &mut |scan: &Scan| {
        emit(&format!(
            "{}: {}\n",
            scan.answer.name(),
            scan.answer.summary()
        ));
    };
    let played = player::play(recording, &options, &*service, &mut clock, report);
    service.stop();
    played.map(|()| ExitCode::SUCCESS)
}

/// Publishes the answers of a report port, or of the demonstration.
fn port(args: &Args, started: Instant, open: Open<'_>) -> Result<ExitCode> {
    let demonstrated = args.demo.as_deref().map(Recording::read).transpose()?;
    let (source, mut state) = source(args, started)?.context("no port")?;
    let offer = Offer {
        streams: &Stream::OF_PORTS,
        mount_height_m: mount_height_m(args, demonstrated.as_ref())?,
    };
    let service = opened(open, &offer)?;
    state.note(0, &service.place());
    let look = &mut |answer: &Answer| {
        let scan = Scan::from_sentences(answer, unix_ns());
        if let Err(error) = publish_scan(&*service, &scan) {
            crate::note!("error: {error:#}");
        }
    };
    let watched = watch(args, (started, &source, state), look);
    service.stop();
    watched
}

/// Returns the height of the mirror's centre above the ground, metres: that of the recording, else that of the
/// settings.
fn mount_height_m(args: &Args, recording: Option<&Recording>) -> Result<f64> {
    let recorded = recording.and_then(|recording| recording.meta.mirror.as_ref());
    Ok(match recorded {
        Some(mirror) => mirror.mount_height_m,
        None => f64::from(args.settings.config()?.mount.mount_height) * 1e-5,
    })
}

/// Returns the time of day, nanoseconds since 1970.
fn unix_ns() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.unwrap_or_default().as_nanos() as u64
}

/// Clock: the time of day at the start, advanced by the monotonic clock.
struct Wall {
    stop: Arc<AtomicBool>,
    begun: Instant,
    begun_ns: u64,
}

impl Wall {
    fn new(stop: Arc<AtomicBool>) -> Self {
        Self {
            stop,
            begun: Instant::now(),
            begun_ns: unix_ns(),
        }
    }
}

impl Clock for Wall {
    fn now_ns(&self) -> u64 {
        self.begun_ns + self.begun.elapsed().as_nanos() as u64
    }

    fn wait_until(&mut self, ns: u64) -> bool {
        loop {
            if self.stop.load(Ordering::Relaxed) {
                return false;
            }
            match Duration::from_nanos(ns.saturating_sub(self.now_ns())) {
                Duration::ZERO => return true,
                left => std::thread::sleep(left.min(GRAIN)),
            }
        }
    }
}
