//! One boot of the image with everything around it: configure, scan, ask; or let somebody watch.

mod watched;
mod withheld;

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use stairscan::report::Sentence;
use stairscan::scanner::Settings;
use stairscan::scanner::command::framed;
use stairscan::scanner::record::MOUNTING;

use super::module::{Module, Request, Trigger};
use super::qemu::{Input, Qemu, read_some, write_all};
use super::shaft::Shaft;
use crate::live::pty::Pty;
use crate::motion::by_trigger::ByTrigger;
use crate::playback::Playback;

/// Nothing that the scanner does in the emulator takes longer, on a slow and busy machine.
const PATIENCE: Duration = Duration::from_secs(180);
/// Between two looks at sockets and log when nothing came.
const PAUSE: Duration = Duration::from_micros(300);
/// From motion sentence to motion sentence where many come at once: the image has read one by then.
const APART: Duration = Duration::from_millis(10);
/// How the log names a write to the watchdog, whose neighbour the emulator takes it for.
const WATCHDOG: &str = "I2S2ext: unimplemented device write";
/// Where the shaft stands at power-up, microsteps above the home switch.
const POWER_UP: i64 = 300;

/// Waits in the emulator's hurried microseconds, some six to a real one: long enough that a busy
/// host is no fault; and a speed that is low enough.
#[derive(Clone, Copy, Debug)]
pub struct Waits {
    /// For a chirp.
    pub chirp: u32,
    /// For the module's settings.
    pub configure: u32,
    /// For the module's first answer.
    pub connect: u32,
    /// Of the search for home, microsteps/s: the switch's edge comes as late as the host is busy, and
    /// two approaches must end within a degree of each other.
    pub search_speed: u32,
}

impl Default for Waits {
    fn default() -> Self {
        Self {
            chirp: 60_000_000,
            configure: 20_000_000,
            connect: 600_000_000,
            search_speed: 2_400,
        }
    }
}

/// A trigger and where the pulses had turned the shaft by then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shot {
    /// The trigger.
    pub trigger: Trigger,
    /// Microsteps from the horizontal by the log.
    pub position: Option<i64>,
}

/// A chirp that is kept back.
#[derive(Debug)]
struct Withheld {
    /// The bytes of the answer.
    answer: Vec<u8>,
    /// Shaft angle of its trigger, 0.001 degree.
    shaft_angle: i32,
    /// When its trigger was served.
    since: Instant,
}

/// The image in the emulator, a radar module on its link, a terminal on its report port.
#[derive(Debug)]
pub struct Session<'a> {
    qemu: Qemu,
    playback: &'a Playback<'a>,
    /// What the chair's controller sends.
    motion: Option<ByTrigger>,
    /// The radar module.
    pub module: Module<'a>,
    /// The motor.
    pub shaft: Shaft,
    /// Whether the home switch works.
    pub switch_works: bool,
    pressed: bool,
    home_angle: i32,
    homed: bool,
    feeds: u64,
    /// Every trigger since boot.
    pub shots: Vec<Shot>,
    /// Every sentence since boot, and what was none.
    pub lines: Vec<String>,
    /// Every `LIVE` since boot; they are not among the other lines.
    pub live: Vec<String>,
    /// Lines that [`Session::next_line`] has handed out …
    read: usize,
    /// … and those that were skipped.
    skipped: usize,
    partial: Vec<u8>,
    /// Who watches, and may type.
    watcher: Option<Pty>,
    /// Whether chirps are kept back until the mirror has gone on.
    pub withholds: bool,
    withheld: Option<Withheld>,
    /// Chirps that were kept back until the mirror stood somewhere else.
    pub overtaken: usize,
}

impl<'a> Session<'a> {
    /// Boots `elf`; the radar module plays `playback`, but keeps its handshake back.
    pub fn boot(elf: &Path, playback: &'a Playback<'a>) -> Result<Self> {
        Self::boot_with(elf, playback, (true, false))
    }

    /// The same with every step of the motor timed ([`Shaft::steps`]).
    pub fn boot_timed(elf: &Path, playback: &'a Playback<'a>) -> Result<Self> {
        Self::boot_with(elf, playback, (true, true))
    }

    /// The same with a home switch that does not work.
    pub fn boot_without_switch(elf: &Path, playback: &'a Playback<'a>) -> Result<Self> {
        Self::boot_with(elf, playback, (false, false))
    }

    fn boot_with(
        elf: &Path,
        playback: &'a Playback<'a>,
        (switch_works, timed): (bool, bool),
    ) -> Result<Self> {
        let qemu = Qemu::start(elf, timed)?;
        let mut session = Self {
            qemu,
            playback,
            motion: playback.motion(),
            module: Module::new(playback),
            shaft: Shaft::new(POWER_UP),
            switch_works,
            feeds: 0,
            pressed: false,
            home_angle: Settings::default().motor.home_angle,
            homed: false,
            shots: Vec::new(),
            lines: Vec::new(),
            live: Vec::new(),
            read: 0,
            skipped: 0,
            partial: Vec::new(),
            watcher: None,
            withholds: false,
            withheld: None,
            overtaken: 0,
        };
        session.wait_for("the boot sentence", |s| matches!(s, Sentence::Boot { .. }))?;
        Ok(session)
    }

    /// One look at everything; whether there was anything.
    fn poll(&mut self) -> Result<bool> {
        let mut buffer = [0; 4096];
        let mut busy = self.follow_shaft()?;
        busy |= self.release()?;
        let n = read_some(&mut self.qemu.link, &mut buffer)?;
        if n > 0 {
            busy = true;
            self.serve(&buffer[..n])?;
        }
        let n = read_some(&mut self.qemu.report, &mut buffer)?;
        if n > 0 {
            busy = true;
            self.partial.extend(&buffer[..n]);
            self.split_lines();
        }
        busy |= self.pass_on(&buffer[..n])?;
        if !busy {
            self.qemu.check()?;
        }
        Ok(busy)
    }

    fn split_lines(&mut self) {
        while let Some(end) = self.partial.iter().position(|&b| b == b'\n') {
            let line: Vec<u8> = self.partial.drain(..=end).collect();
            let line = String::from_utf8_lossy(&line).trim_end().to_owned();
            if matches!(Sentence::parse(&line), Ok(Sentence::Live(_))) {
                self.live.push(line);
            } else if !line.is_empty() {
                self.lines.push(line);
            }
        }
    }

    /// Turns the shaft by what the log has gained and moves the switch with it.
    fn follow_shaft(&mut self) -> Result<bool> {
        let lines = self.qemu.log_lines()?;
        for line in lines.lines() {
            self.shaft.log_line(line);
            self.feeds += u64::from(line.starts_with(WATCHDOG) && line.contains("0xaaaa"));
            let pressed = self.shaft.pressed() && self.switch_works;
            if pressed != self.pressed {
                self.pressed = pressed;
                self.qemu.set(Input::Home, pressed)?;
            }
        }
        if !self.shaft.enabled() {
            self.homed = false;
            // The emulator's inputs have edges but no level: left on its switch, the shaft could never be
            // homed again.
            if self.pressed {
                self.shaft.turn_by_hand(POWER_UP);
                self.pressed = false;
                self.qemu.set(Input::Home, false)?;
            }
        }
        Ok(!lines.is_empty())
    }

    /// Answers the radar link. The log is older than the request, so the shaft is up to date.
    fn serve(&mut self, bytes: &[u8]) -> Result<()> {
        let (answer, requests) = self.module.receive(bytes);
        self.follow_shaft()?;
        for request in &requests {
            match *request {
                Request::Configure if !self.homed => {
                    // The self-test asks the module right after homing, from a standstill.
                    self.shaft.is_home(self.home_angle);
                    self.homed = true;
                }
                Request::Configure => {}
                Request::Trigger(trigger) => {
                    self.shots.push(Shot {
                        trigger,
                        position: self.shaft.position(),
                    });
                    self.drive(trigger.shaft_angle)?;
                }
            }
        }
        match requests.last() {
            Some(Request::Trigger(trigger)) if self.withholds => {
                self.withheld = Some(Withheld {
                    answer,
                    shaft_angle: trigger.shaft_angle,
                    since: Instant::now(),
                });
                Ok(())
            }
            _ => write_all(&mut self.qemu.link, &answer),
        }
    }

    /// Types the motion sentences that belong to a trigger. The chirp, which is sent after them, is eight times
    /// as long: they have been read by the time that its row is worked off.
    fn drive(&mut self, shaft_angle: i32) -> Result<()> {
        let Some(chirp) = self.module.number(shaft_angle) else {
            return Ok(());
        };
        let lines = self.motion.as_mut().map(|motion| motion.at(chirp));
        let lines = lines.unwrap_or_default();
        for line in &lines {
            self.type_bytes(line.as_bytes())?;
            if lines.len() > 2 {
                std::thread::sleep(APART);
            }
        }
        Ok(())
    }

    /// Polls until `done` has something to say.
    fn run<T>(
        &mut self,
        what: &str,
        mut done: impl FnMut(&mut Self) -> Result<Option<T>>,
    ) -> Result<T> {
        let deadline = Instant::now() + PATIENCE;
        loop {
            if let Some(value) = done(self)? {
                return Ok(value);
            }
            if !self.poll()? {
                std::thread::sleep(PAUSE);
            }
            if Instant::now() > deadline {
                let last: Vec<_> = self.lines.iter().rev().take(5).collect();
                bail!("{what} did not come within {PATIENCE:?}; last sentences: {last:?}");
            }
        }
    }

    /// The next line of the report port that has not been handed out.
    pub fn next_line(&mut self, what: &str) -> Result<String> {
        self.run(what, |session| {
            let line = session.lines.get(session.read).cloned();
            session.read += usize::from(line.is_some());
            Ok(line)
        })
    }

    /// Reads on to the first sentence that satisfies `wanted`.
    pub fn wait_for(
        &mut self,
        what: &str,
        wanted: impl Fn(&Sentence<'_>) -> bool,
    ) -> Result<String> {
        loop {
            let line = self.next_line(what)?;
            let Ok(sentence) = Sentence::parse(&line) else {
                continue;
            };
            if wanted(&sentence) {
                return Ok(line);
            }
            // Waiting on would be waiting for another boot's answer.
            if matches!(sentence, Sentence::Halt { .. }) {
                bail!("the image halted while {what} was due: {line}");
            }
        }
    }

    /// Lets the scanner run for a while.
    pub fn idle(&mut self, time: Duration) -> Result<()> {
        let until = Instant::now() + time;
        self.run("time", |_| Ok((Instant::now() >= until).then_some(())))
    }

    /// Types raw bytes.
    pub fn type_bytes(&mut self, bytes: &[u8]) -> Result<()> {
        write_all(&mut self.qemu.report, bytes)
    }

    /// Types a command and returns its one answer. Sentences of scans in between stay in
    /// [`Session::lines`] and are not handed out again.
    pub fn command(&mut self, line: &str) -> Result<String> {
        self.type_bytes(format!("{line}\r\n").as_bytes())?;
        self.wait_for(&format!("the answer to {line}"), |sentence| {
            !matches!(
                sentence,
                Sentence::Scan(_)
                    | Sentence::Step(_)
                    | Sentence::Drop(_)
                    | Sentence::Maybe(_)
                    | Sentence::Guard(_)
                    | Sentence::Boot { .. }
            )
        })
    }

    /// Sets one value; an error if it is refused.
    pub fn set(&mut self, key: &str, value: &str) -> Result<()> {
        let answer = self.command(framed(&["set", key, value]).trim_end())?;
        let accepted = matches!(
            Sentence::parse(&answer),
            Ok(Sentence::Config { key: k, value: v }) if k == key && v == value
        );
        ensure!(accepted, "set,{key},{value}: the image answers {answer}");
        Ok(())
    }

    /// Brings the image to `settings` and the waits that the emulator needs.
    pub fn configure(&mut self, settings: &Settings, waits: Waits) -> Result<()> {
        let emulators = [
            ("connect-timeout", waits.connect.to_string()),
            ("configure-timeout", waits.configure.to_string()),
            ("chirp-timeout", waits.chirp.to_string()),
            ("search-speed", waits.search_speed.to_string()),
            // There is no crystal: up to here nothing has moved. The search for home begins at once, at the
            // speed that has just been set.
            ("internal-clock", "on".to_owned()),
        ];
        for (key, value) in &emulators {
            self.set(key, value)?;
        }
        self.command("stop")?;
        self.command("start")?;
        let default = Settings::default();
        // A scan of three angles around the middle is valid in every plane, so that no order of
        // the other keys passes through an invalid one.
        // How the scanner is mounted is told in any case: without that no answer is `ok`.
        let changed: Vec<_> = Settings::KEYS
            .iter()
            .filter(|key| !key.starts_with("radar-"))
            .filter(|key| !emulators.iter().any(|(set, _)| set == *key))
            .filter(|key| settings.get(key) != default.get(key) || MOUNTING.contains(key))
            .collect();
        let sweep = ["angle-count", "first-angle", "angle-step"];
        let shaped = settings.config.mount.plane != default.config.mount.plane
            || changed.iter().any(|key| sweep.contains(key));
        if shaped {
            self.set("angle-count", "3")?;
            self.set("first-angle", "0")?;
            self.set("angle-step", "10")?;
        }
        let value = |key: &str| settings.get(key).context("a key without a value");
        for key in changed.iter().filter(|key| !sweep.contains(key)) {
            self.set(key, &value(key)?)?;
        }
        if shaped {
            for key in ["first-angle", "angle-step", "angle-count"] {
                self.set(key, &value(key)?)?;
            }
        }
        Ok(())
    }

    /// Puts the home switch to another angle of the shaft (0.001°) and has the scanner home again:
    /// near the sweep's first row a fault costs less time.
    pub fn move_switch(&mut self, home_angle: i32) -> Result<()> {
        self.set("home-angle", &home_angle.to_string())?;
        self.home_angle = home_angle;
        self.command("stop")?;
        self.command("start")?;
        Ok(())
    }

    /// Lets the radar module answer.
    pub fn connect(&mut self) -> Result<()> {
        if let Some(motion) = &mut self.motion {
            let first = motion.first();
            self.type_bytes(first.as_bytes())?;
        }
        let answer = self.module.get_ready();
        write_all(&mut self.qemu.link, &answer)
    }

    /// The next scan's sentences, `SCAN` first. Faults of self-tests before the module was
    /// connected are not among them.
    pub fn scan(&mut self) -> Result<Vec<String>> {
        let is_scan = |sentence: &Sentence<'_>| matches!(sentence, Sentence::Scan(_));
        let mut sentences = vec![self.wait_for("a scan", is_scan)?];
        let Ok(Sentence::Scan(head)) = Sentence::parse(&sentences[0]) else {
            bail!("{}: no SCAN", sentences[0]);
        };
        for _ in 0..head.following() {
            let belongs = |sentence: &Sentence<'_>| {
                matches!(
                    sentence,
                    Sentence::Step(_) | Sentence::Drop(_) | Sentence::Maybe(_)
                )
            };
            sentences.push(self.wait_for("the rest of a scan", belongs)?);
        }
        Ok(sentences)
    }

    /// `count` scans one after the other, each with the settings that the recording brings for it;
    /// `answered` gets each scan's sentences and may set the module up for the next.
    pub fn scans(
        &mut self,
        count: usize,
        mut answered: impl FnMut(&mut Self, Vec<String>) -> Result<()>,
    ) -> Result<()> {
        for scan in 0..count {
            let before = self.read;
            let commands = match scan + 1 < count {
                true => self.playback.commands_after(scan),
                false => Vec::new(),
            };
            if !commands.is_empty() {
                // What is set while a scan is under way is for the next one. A scan without a
                // single trigger has failed, and says so.
                self.run("a scan's first trigger", |session| {
                    let begun = session.module.begun() > scan || session.has_scan(before);
                    Ok(begun.then_some(()))
                })?;
            }
            for (key, value) in commands {
                self.set(key, &value)?;
            }
            self.read = before;
            let sentences = self.scan()?;
            answered(self, sentences)?;
        }
        Ok(())
    }

    /// The sentences of `count` guard sweeps one after the other, each with the settings that the recording brings for it.
    pub fn sweeps(&mut self, count: usize) -> Result<Vec<String>> {
        let mut sentences = Vec::new();
        for sweep in 0..count {
            let before = self.read;
            let commands = match sweep + 1 < count {
                true => self.playback.commands_after(sweep),
                false => Vec::new(),
            };
            if !commands.is_empty() {
                self.run("a sweep's first trigger", |session| {
                    Ok((session.module.begun() > sweep).then_some(()))
                })?;
            }
            for (key, value) in commands {
                self.set(key, &value)?;
            }
            self.read = before;
            sentences.push(self.wait_for("a guard sweep", |s| matches!(s, Sentence::Guard(_)))?);
        }
        Ok(sentences)
    }

    /// Whether the head of a scan stands among the lines from `from` on.
    fn has_scan(&self, from: usize) -> bool {
        let lines = self.lines.iter().skip(from);
        lines
            .map(|line| Sentence::parse(line))
            .any(|s| matches!(s, Ok(Sentence::Scan(_))))
    }

    /// Hands out again what has been printed since [`Session::skip_lines`].
    pub fn rewind(&mut self) {
        self.read = self.skipped;
    }

    /// Waits for the sentence of a crash.
    pub fn next_halt(&mut self) -> Result<String> {
        self.wait_for("a halt", |s| matches!(s, Sentence::Halt { .. }))
    }

    /// How often the watchdog has been fed since boot.
    pub fn watchdog_feeds(&self) -> u64 {
        self.feeds
    }

    /// Forgets what has been printed so far.
    pub fn skip_lines(&mut self) {
        self.read = self.lines.len();
        self.skipped = self.read;
    }

    /// Raises an interrupt of the chip by its number, or the one that cannot be masked.
    pub fn interrupt(&mut self, number: Option<u32>) -> Result<()> {
        self.qemu.interrupt(number)
    }

    /// Drives the driver's stall output.
    pub fn stall(&mut self, level: bool) -> Result<()> {
        self.qemu.set(Input::Stall, level)
    }
}
