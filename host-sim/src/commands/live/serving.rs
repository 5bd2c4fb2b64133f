//! `live --foxglove`: a port or a recording, served to Foxglove.

use std::net::SocketAddr;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::Result;

use super::watching::Args;

/// Builds and starts the program with the server in place of this one.
#[cfg(not(feature = "foxglove"))]
pub fn run(_: &Args, _: SocketAddr, _: Instant) -> Result<ExitCode> {
    match crate::serve::other_build::start()? {}
}

/// Serves until the session is ended.
#[cfg(feature = "foxglove")]
pub fn run(args: &Args, address: SocketAddr, started: Instant) -> Result<ExitCode> {
    with_server::run(args, address, started)
}

#[cfg(feature = "foxglove")]
mod with_server {
    use std::path::Path;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::{Duration, SystemTime, UNIX_EPOCH};

    use anyhow::Context as _;

    use super::super::watching::{interrupted, source, watch};
    use super::*;
    use crate::answer::Answer;
    use crate::commands::emit;
    use crate::convert::scans::Scan;
    use crate::playback::Playback;
    use crate::recording::Recording;
    use crate::serve::address;
    use crate::serve::player::{self, Clock};
    use crate::serve::server::Server;
    use crate::serve::streams::{Stream, publish_scan};

    /// A session is looked at so often for its end.
    const GRAIN: Duration = Duration::from_millis(50);

    pub fn run(args: &Args, address: SocketAddr, started: Instant) -> Result<ExitCode> {
        match &args.play {
            Some(path) => play(args, path, address),
            None => port(args, address, started),
        }
    }

    /// A server, with its address told on stderr.
    fn listen(address: SocketAddr, streams: &[Stream]) -> Result<Server> {
        let server = Server::start(address, streams)?;
        if let Some(warning) = address::warning(server.address) {
            eprintln!("{warning}");
        }
        eprintln!("Foxglove: open the connection ws://{}", server.address);
        Ok(server)
    }

    /// A recording at its true speed, until it is interrupted.
    fn play(args: &Args, path: &Path, address: SocketAddr) -> Result<ExitCode> {
        let recording = Recording::read(path)?;
        let options = args.settings.options(args.settings.config()?);
        // A recording that no scan can be made of is told before anything is served.
        Playback::new(&recording, &options.config)?;
        let server = listen(address, &Stream::OF_RECORDINGS)?;
        let mut clock = Wall::new(interrupted()?);
        let told = &mut |scan: &Scan| {
            emit(&format!(
                "{}: {}\n",
                scan.answer.name(),
                scan.answer.summary()
            ));
        };
        let played = player::play(recording, &options, &server, &mut clock, told);
        server.stop();
        played.map(|()| ExitCode::SUCCESS)
    }

    /// The answers of a report port, or of the demonstration.
    fn port(args: &Args, address: SocketAddr, started: Instant) -> Result<ExitCode> {
        let (source, mut state) = source(args, started)?.context("no port")?;
        let server = listen(address, &Stream::OF_PORTS)?;
        state.note(0, &format!("Foxglove: ws://{}", server.address));
        let look = &mut |answer: &Answer| {
            let scan = Scan::heard(answer, unix_ns());
            if let Err(error) = publish_scan(&server, &scan) {
                eprintln!("error: {error:#}");
            }
        };
        let watched = watch(args, (started, &source, state), look, false);
        server.stop();
        watched
    }

    /// Now, nanoseconds since 1970.
    fn unix_ns() -> u64 {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        since.unwrap_or_default().as_nanos() as u64
    }

    /// The time of day when playing began, carried on by the steady clock.
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
}
