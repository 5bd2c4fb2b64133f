//! One boot of the firmware's image with a simulated environment: configuring, scanning, commands, or an interactive
//! terminal.

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
use crate::live::lines::Splitter;
use crate::live::pty::Pty;
use crate::motion::by_trigger::ByTrigger;
use crate::playback::Playback;

/// Timeout of any action in the emulator, on the host's clock, long enough for a slow and busy machine.
const PATIENCE: Duration = Duration::from_secs(180);
/// Pause between polls of sockets and log without data.
const PAUSE: Duration = Duration::from_micros(300);
/// Interval between consecutive motion sentences to the image, which has read one by then.
const APART: Duration = Duration::from_millis(10);
/// Beginning of the log text of a write to the watchdog; the emulator takes the address for a neighbouring device.
const WATCHDOG: &str = "I2S2ext: unimplemented device write";
/// Position of the motor's shaft at power-up, microsteps above the home switch.
const POWER_UP: i64 = 300;

/// Timeouts that the image is configured with, in the emulator's microseconds, about six of which pass in a real one.
/// They are long enough that a busy host causes no fault. For the same reason the homing speed is low.
#[derive(Clone, Copy, Debug)]
pub struct Waits {
    /// Timeout of a chirp, microseconds.
    pub chirp: u32,
    /// Timeout of the radar module's settings, microseconds.
    pub configure: u32,
    /// Timeout of the radar module's first answer, microseconds.
    pub connect: u32,
    /// Speed of homing, microsteps/s. A busy host delays the switch's edge, and two approaches must agree within one
    /// degree.
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

/// A trigger of a chirp, and the position of the shaft when it was served.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shot {
    /// The trigger, with its shaft angle.
    pub trigger: Trigger,
    /// Position from the motor pulses so far, microsteps from the horizontal; `None` before homing.
    pub position: Option<i64>,
}

/// A chirp that the radar module has not sent yet, to test whether the mirror waits for it.
#[derive(Debug)]
struct Withheld {
    /// Bytes of the module's answer with the chirp.
    answer: Vec<u8>,
    /// Shaft angle of its trigger, 0.001 degree.
    shaft_angle: i32,
    /// Time at which its trigger was served.
    since: Instant,
}

/// Returns keys and values of the settings that differ from the defaults, without those of `own`, in an order in which a
/// scanner with default settings takes all of them.
///
/// # Errors
/// A setting has no value.
pub fn changed(settings: &Settings, own: &[&str]) -> Result<Vec<(&'static str, String)>> {
    let default = Settings::default();
    // The mounting is always set: without it no answer is `ok`.
    let changed: Vec<&'static str> = Settings::KEYS
        .iter()
        .copied()
        .filter(|key| !key.starts_with("radar-") && !own.contains(key))
        .filter(|key| settings.get(key) != default.get(key) || MOUNTING.contains(key))
        .collect();
    let sweep = ["first-angle", "angle-step", "angle-count"];
    let shaped = settings.config.mount.plane != default.config.mount.plane
        || changed.iter().any(|key| sweep.contains(key));
    let value = |key: &'static str| -> Result<(&'static str, String)> {
        let value = settings.get(key).context("a key without a value")?;
        Ok((key, value.as_str().to_owned()))
    };
    let others = changed.iter().filter(|key| !sweep.contains(key));
    let mut sets = Vec::new();
    if shaped {
        // A scan of three angles around the middle is valid in every plane: set first, it allows the other keys in
        // any order.
        let middle = [
            ("angle-count", "3"),
            ("first-angle", "0"),
            ("angle-step", "10"),
        ];
        sets.extend(middle.map(|(key, value)| (key, value.to_owned())));
    }
    sets.extend(others.map(|key| value(key)).collect::<Result<Vec<_>>>()?);
    if shaped {
        sets.extend(sweep.into_iter().map(value).collect::<Result<Vec<_>>>()?);
    }
    Ok(sets)
}

/// The image in the emulator, with a radar module at its link and a terminal at its report port.
#[derive(Debug)]
pub struct Session<'a> {
    qemu: Qemu,
    playback: &'a Playback<'a>,
    /// Motion sentences of the chair's controller; `None` if the recording contains no motion.
    motion: Option<ByTrigger>,
    /// The simulated radar module.
    pub module: Module<'a>,
    /// The simulated motor.
    pub shaft: Shaft,
    /// Whether the simulated home switch works.
    pub switch_works: bool,
    pressed: bool,
    home_angle: i32,
    homed: bool,
    feeds: u64,
    /// Every trigger of a chirp since boot.
    pub shots: Vec<Shot>,
    /// Every line of the report port since boot except `LIVE`, sentences and others.
    pub lines: Vec<String>,
    /// Every `LIVE` sentence since boot; not contained in `lines`.
    pub live: Vec<String>,
    /// Number of the `lines` that [`Session::next_line`] has returned.
    read: usize,
    /// Number of the `lines` that were received before the last [`Session::skip_lines`]; [`Session::rewind`] goes back
    /// to there.
    skipped: usize,
    reader: Splitter,
    /// Pseudo-terminal of an observer, who may type commands.
    watcher: Option<Pty>,
    /// Whether the radar module withholds chirps until the mirror has moved on.
    pub withholds: bool,
    withheld: Option<Withheld>,
    /// Number of chirps that were withheld until the mirror had left their row.
    pub overtaken: usize,
}

impl<'a> Session<'a> {
    /// Boots the firmware `elf` and waits for its `BOOT` sentence. The radar module plays `playback`, but withholds
    /// its handshake until [`Self::connect`].
    pub fn boot(elf: &Path, playback: &'a Playback<'a>) -> Result<Self> {
        Self::boot_with(elf, playback, (true, false))
    }

    /// Same as [`Self::boot`], with every step of the motor timed ([`Shaft::steps`]).
    pub fn boot_timed(elf: &Path, playback: &'a Playback<'a>) -> Result<Self> {
        Self::boot_with(elf, playback, (true, true))
    }

    /// Same as [`Self::boot`], with a defective home switch.
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
            reader: Splitter::default(),
            watcher: None,
            withholds: false,
            withheld: None,
            overtaken: 0,
        };
        session.wait_for("the boot sentence", |s| matches!(s, Sentence::Boot { .. }))?;
        Ok(session)
    }

    /// Polls log, radar link and report port once, and answers the image. Returns whether there were data.
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
            self.read_lines(&buffer[..n]);
        }
        busy |= self.pass_on(&buffer[..n])?;
        if !busy {
            self.qemu.check()?;
        }
        Ok(busy)
    }

    /// Stores the lines that `bytes` of the report port complete.
    fn read_lines(&mut self, bytes: &[u8]) {
        for line in self.reader.push(bytes) {
            match Sentence::parse(&line) {
                Ok(Sentence::Live(_)) => self.live.push(line),
                _ => self.lines.push(line),
            }
        }
    }

    /// Updates shaft and home switch from the new lines of the log. Returns whether there were any.
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
            // The emulator's inputs have edges but no level: a shaft that stays on its switch could never be homed
            // again.
            if self.pressed {
                self.shaft.turn_by_hand(POWER_UP);
                self.pressed = false;
                self.qemu.set(Input::Home, false)?;
            }
        }
        Ok(!lines.is_empty())
    }

    /// Answers the image's requests in `bytes` from the radar link. The log is read first, so that the shaft's
    /// position is up to date.
    fn serve(&mut self, bytes: &[u8]) -> Result<()> {
        let (answer, requests) = self.module.receive(bytes);
        self.follow_shaft()?;
        for request in &requests {
            match *request {
                Request::Configure if !self.homed => {
                    // The self-test requests the module's settings right after homing, at standstill.
                    self.shaft.is_home(self.home_angle);
                    self.homed = true;
                }
                Request::Configure | Request::Rate(_) => {}
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

    /// Sends the motion sentences that belong to the trigger at `shaft_angle` (0.001°). The chirp is sent after them
    /// and is eight times as long, so that they have been read when its row is processed.
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

    /// Polls until `done` returns a value, and returns that; fails after [`PATIENCE`]. `what` names it in the error.
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

    /// Returns the next line of the report port that has not been returned yet.
    pub fn next_line(&mut self, what: &str) -> Result<String> {
        self.run(what, |session| {
            let line = session.lines.get(session.read).cloned();
            session.read += usize::from(line.is_some());
            Ok(line)
        })
    }

    /// Returns the line of the first further sentence that satisfies `wanted`; `what` names it in the error.
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
            // A later answer would be that of another boot.
            if matches!(sentence, Sentence::Halt { .. }) {
                bail!("the image halted while {what} was due: {line}");
            }
        }
    }

    /// Lets the scanner run for `time` on the host's clock.
    pub fn idle(&mut self, time: Duration) -> Result<()> {
        let until = Instant::now() + time;
        self.run("time", |_| Ok((Instant::now() >= until).then_some(())))
    }

    /// Sends raw bytes to the report port.
    pub fn type_bytes(&mut self, bytes: &[u8]) -> Result<()> {
        write_all(&mut self.qemu.report, bytes)
    }

    /// Sends a command and returns its reply, which is one line. Sentences of scans in between stay in
    /// [`Session::lines`] and are not returned again.
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

    /// Changes one setting of the image; an error if it is refused.
    pub fn set(&mut self, key: &str, value: &str) -> Result<()> {
        let answer = self.command(framed(&["set", key, value]).trim_end())?;
        let accepted = matches!(
            Sentence::parse(&answer),
            Ok(Sentence::Config { key: k, value: v }) if k == key && v == value
        );
        ensure!(accepted, "set,{key},{value}: the image answers {answer}");
        Ok(())
    }

    /// Sets the `settings` that differ from the defaults, and timeouts and homing speed for the emulator.
    pub fn configure(&mut self, settings: &Settings, waits: Waits) -> Result<()> {
        let emulators = [
            ("connect-timeout", waits.connect.to_string()),
            ("configure-timeout", waits.configure.to_string()),
            ("chirp-timeout", waits.chirp.to_string()),
            ("search-speed", waits.search_speed.to_string()),
            // The emulator has no crystal: nothing has moved so far. Homing begins at once, at the speed that has
            // just been set.
            ("internal-clock", "on".to_owned()),
        ];
        for (key, value) in &emulators {
            self.set(key, value)?;
        }
        self.command("stop")?;
        self.command("start")?;
        let own: Vec<&str> = emulators.iter().map(|(key, _)| *key).collect();
        for (key, value) in changed(settings, &own)? {
            self.set(key, &value)?;
        }
        Ok(())
    }

    /// Moves the home switch to another angle of the shaft (0.001°) and lets the scanner home again. A switch near
    /// the sweep's first row shortens the homing after a fault.
    pub fn move_switch(&mut self, home_angle: i32) -> Result<()> {
        self.set("home-angle", &home_angle.to_string())?;
        self.home_angle = home_angle;
        self.command("stop")?;
        self.command("start")?;
        Ok(())
    }

    /// Lets the radar module answer from now on, after the first motion sentence, if there is one.
    pub fn connect(&mut self) -> Result<()> {
        if let Some(motion) = &mut self.motion {
            let first = motion.first();
            self.type_bytes(first.as_bytes())?;
        }
        let answer = self.module.get_ready();
        write_all(&mut self.qemu.link, &answer)
    }

    /// Returns the next scan's sentences, `SCAN` first, then its `STEP`s, `DROP` and `MAYBE`s.
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

    /// Runs `count` scans, each with the settings of the recording for it. `answered` gets each scan's sentences and
    /// may configure the module for the next scan.
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
                // Settings that change during a scan apply to the next one. A scan without a single trigger has
                // failed, and reports it.
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

    /// Returns the `GUARD` sentences of `count` guard sweeps, each with the settings of the recording for it.
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

    /// Whether the lines from index `from` on contain a `SCAN` sentence.
    fn has_scan(&self, from: usize) -> bool {
        let lines = self.lines.iter().skip(from);
        lines
            .map(|line| Sentence::parse(line))
            .any(|s| matches!(s, Ok(Sentence::Scan(_))))
    }

    /// Makes the lines since [`Session::skip_lines`] available to [`Session::next_line`] again.
    pub fn rewind(&mut self) {
        self.read = self.skipped;
    }

    /// Waits for the `HALT` sentence of a crash and returns its line.
    pub fn next_halt(&mut self) -> Result<String> {
        self.wait_for("a halt", |s| matches!(s, Sentence::Halt { .. }))
    }

    /// Returns the number of times that the image has fed the watchdog since boot.
    pub fn watchdog_feeds(&self) -> u64 {
        self.feeds
    }

    /// Skips the lines received so far: [`Session::next_line`] does not return them.
    pub fn skip_lines(&mut self) {
        self.read = self.lines.len();
        self.skipped = self.read;
    }

    /// Raises an interrupt of the chip by its number, or the non-maskable one if `number` is `None`.
    pub fn interrupt(&mut self, number: Option<u32>) -> Result<()> {
        self.qemu.interrupt(number)
    }

    /// Sets the stall output of the motor driver to the logic level `level`; `true` is high.
    pub fn stall(&mut self, level: bool) -> Result<()> {
        self.qemu.set(Input::Stall, level)
    }
}
