//! A scanner on a pseudo-terminal.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use host_sim::emulate::image;
use host_sim::live::device::{self, Cable};
use host_sim::live::pty::Pty;
use host_sim::recording::Recording;
use stairscan::config::Config;

pub fn stair_a() -> Recording {
    Recording::read(&image::workspace().join("recordings/stair_a")).unwrap()
}

/// A scanner on a pseudo-terminal, until it is unplugged.
pub struct Scanner {
    pub path: String,
    plug: Arc<AtomicBool>,
    thread: JoinHandle<()>,
}

struct PtyCable {
    pty: Pty,
    pulled: Arc<AtomicBool>,
}

impl Cable for PtyCable {
    fn read(&mut self) -> Vec<u8> {
        self.pty.read()
    }

    fn write(&mut self, bytes: &[u8]) {
        self.pty.write(bytes);
    }

    fn ended(&self) -> bool {
        self.pulled.load(Ordering::Relaxed)
    }
}

impl Scanner {
    /// Runs the scanner's own loop over `recording`.
    pub fn plug_in(recording: Recording) -> Self {
        Self::run(move |pty, pulled| {
            let mut cable = PtyCable { pty, pulled };
            device::run(&recording, &Config::default(), &mut cable).unwrap();
        })
    }

    /// Runs a scripted device that sends `says` five times a second, and answers each line with `answer`. Lines are
    /// without their ends.
    pub fn scripted(
        says: impl Fn() -> String + Send + 'static,
        mut answer: impl FnMut(&str) -> Vec<String> + Send + 'static,
    ) -> Self {
        Self::run(move |mut pty, pulled| {
            let mut last = Instant::now();
            while !pulled.load(Ordering::Relaxed) {
                let typed = pty.read();
                for line in String::from_utf8_lossy(&typed)
                    .lines()
                    .filter(|line| !line.is_empty())
                {
                    for reply in answer(line) {
                        pty.write(format!("{reply}\r\n").as_bytes());
                    }
                }
                if last.elapsed() > Duration::from_millis(200) {
                    pty.write(format!("{}\r\n", says()).as_bytes());
                    last = Instant::now();
                }
                std::thread::sleep(Duration::from_millis(2));
            }
        })
    }

    fn run(work: impl FnOnce(Pty, Arc<AtomicBool>) + Send + 'static) -> Self {
        let pty = Pty::new().unwrap();
        let (path, plug) = (pty.path.clone(), Arc::new(AtomicBool::new(false)));
        let pulled = plug.clone();
        let thread = std::thread::spawn(move || work(pty, pulled));
        Self { path, plug, thread }
    }

    pub fn unplug(self) {
        self.plug.store(true, Ordering::Relaxed);
        self.thread.join().unwrap();
    }
}
