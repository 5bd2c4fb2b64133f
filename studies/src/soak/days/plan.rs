//! The seeded plan of the days: between two wraps of the clock mostly idle, with settings changed and saved; around a
//! wrap mostly active, with faults.

use anyhow::{Result, ensure};
use stairscan::report::Sentence;
use stairscan::scanner::Settings;
use stairscan::scanner::record::MOUNTING;

use super::gaps::{DAY_US, MINUTE_US, SPAN_US};
use super::life::Life;

/// Microseconds of a second.
const SECOND_US: u64 = 1_000_000;
/// Settings that the plan changes, with the minimum and maximum of the values it draws, in each setting's unit.
const CHANGED: [(&str, u32, u32); 4] = [
    ("mount-height", 38_000, 42_000),
    ("seed", 0, 1_000_000),
    ("watch-distance", 120_000, 180_000),
    ("chirp-timeout", 40_000, 60_000),
];
/// Longest time from a planned stall or loss of chirps until the scanner meets it, µs: the mirror moves several times a
/// second.
const SHOWS_US: u64 = 10 * SECOND_US;
/// Time in which the port sends the rest of a listing, µs: its queue of 1 KB takes 90 ms.
const LISTING_US: u64 = 100_000;
/// Longest time that the plan waits for an answer after a fault, µs; the checks have a shorter limit of their own.
const OVER_US: u64 = 30 * SECOND_US;

/// Reason for which the scanner's life, from one boot to the next, ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The run is over.
    Over,
    /// A reset, with its cause; without power no state is retained.
    Reset(&'static str),
}

/// Activity of the scanner and its surroundings around a wrap of the clock.
#[derive(Clone, Copy, Debug)]
enum Part {
    Scans,
    Stopping,
    Guard,
    Watch,
    Idle,
    /// Guard sweeps that begin 2³² µs, one span of the clock, after a single scan.
    SpanAfterScan,
    /// A radar module that falls silent and returns 2³² µs, one span of the clock, later.
    SpanOfSilence,
}

/// Activities among which one is drawn for each wrap; an activity is as likely as it is often listed.
const PARTS: [Part; 16] = [
    Part::Scans,
    Part::Scans,
    Part::Scans,
    Part::Scans,
    Part::Guard,
    Part::Guard,
    Part::Guard,
    Part::Guard,
    Part::Watch,
    Part::Watch,
    Part::Watch,
    Part::Stopping,
    Part::Idle,
    Part::Idle,
    Part::SpanAfterScan,
    Part::SpanOfSilence,
];

impl Life<'_> {
    /// Runs the plan from a boot to `end` or to the next reset.
    ///
    /// # Errors
    /// A command is not answered, or is refused.
    pub fn live_until(&mut self, end: u64, mut look: impl FnMut(u64)) -> Result<Ending> {
        self.begin()?;
        while self.now() < end {
            look(self.now() / DAY_US);
            let lead = self.between(60, 300);
            if let Some(ending) = self.quiet((self.next_wrap() - lead).min(end))? {
                return Ok(ending);
            }
            if self.now() >= end {
                break;
            }
            let part = PARTS[self.run.random.index(PARTS.len())];
            let until = (self.next_wrap() + self.between(60, 900)).min(end);
            self.around_wrap(part, until)?;
        }
        Ok(Ending::Over)
    }

    /// Returns a random time between `low` and `high` seconds, in µs.
    fn between(&mut self, low: u32, high: u32) -> u64 {
        let seconds = self.run.random.between(low.into(), high.into());
        (seconds * SECOND_US as f64) as u64
    }

    /// Compares the boot sentence and all settings with those saved; sets and saves the settings of the mounting if a
    /// reset has lost them.
    fn begin(&mut self) -> Result<()> {
        let expected = self.run.saved.unwrap_or_default();
        let lost = self.run.saved.is_none() || self.run.active.hash() != expected.hash();
        let before = std::mem::replace(&mut self.run.active, expected);
        self.expect_turns();
        self.run.watch.replies.clear();
        self.run_for(SECOND_US, |life| !life.run.watch.replies.is_empty());
        let instant = self.run.instant();
        let boot = self.run.watch.replies.first().cloned().unwrap_or_default();
        match Sentence::parse(&boot) {
            Ok(Sentence::Boot(boot)) if boot.settings == expected.hash() => {}
            _ => (self.run.watch).fail(
                instant,
                "not the boot sentence of the saved settings",
                &boot,
            ),
        }
        self.compare_settings(&expected)?;
        if lost {
            for key in MOUNTING {
                let value = before.get(key).unwrap_or_default();
                self.set(key, &value)?;
            }
            self.stop()?;
            self.save()?;
        }
        Ok(())
    }

    /// Compares all settings, as the scanner lists them on `get`, with `expected`; records each difference as a failed
    /// check.
    fn compare_settings(&mut self, expected: &Settings) -> Result<()> {
        self.checked(&["get"])?;
        let instant = self.run.instant();
        let replies = std::mem::take(&mut self.run.watch.replies);
        for line in &replies {
            if let Ok(Sentence::Config { key, value }) = Sentence::parse(line)
                && expected.get(key).is_none_or(|text| text.as_str() != value)
            {
                self.run
                    .watch
                    .fail(instant, "not the value that was saved", line);
            }
        }
        let listed = replies
            .iter()
            .filter(|line| line.contains(",CONF,"))
            .count();
        ensure!(
            listed == Settings::KEYS.len(),
            "{instant}: {listed} settings are listed"
        );
        Ok(())
    }

    /// Sends the scanner a command that it must execute; a refusal is a failed check.
    fn checked(&mut self, words: &[&str]) -> Result<()> {
        if !self.command(words)? {
            let instant = self.run.instant();
            let reply = self.run.watch.replies.last().cloned().unwrap_or_default();
            self.run.watch.fail(instant, "refused", &reply);
        }
        Ok(())
    }

    fn set(&mut self, key: &'static str, value: &str) -> Result<()> {
        self.checked(&["set", key, value])?;
        let set = self.run.active.set(key, value);
        ensure!(set.is_ok(), "set,{key},{value}: refused");
        self.expect_turns();
        Ok(())
    }

    fn stop(&mut self) -> Result<()> {
        self.run.watch.pauses_sweeps();
        self.checked(&["stop"])?;
        self.run.watch.ends_scan();
        Ok(())
    }

    fn save(&mut self) -> Result<()> {
        self.checked(&["save"])?;
        self.run.saves += 1;
        self.run.saved = Some(self.run.active);
        Ok(())
    }

    /// Keeps the scanner idle until `until`, with commands at random times; returns the reset that ends the life, if
    /// one comes.
    fn quiet(&mut self, until: u64) -> Result<Option<Ending>> {
        if self.now() >= until {
            return Ok(None);
        }
        self.stop()?;
        loop {
            let pause = self.between(20, 600);
            self.run_until((self.now() + pause).min(until));
            if self.now() >= until {
                self.sends(true);
                return Ok(None);
            }
            if let Some(ending) = self.errand()? {
                return Ok(Some(ending));
            }
        }
    }

    /// Sends one random command, or begins or ends a pause of the motion sentences, while the scanner is idle; or
    /// returns a reset.
    fn errand(&mut self) -> Result<Option<Ending>> {
        match self.run.random.index(50) {
            0 => return Ok(Some(self.reset())),
            1..25 => {
                for _ in 0..=self.run.random.index(3) {
                    self.change()?;
                }
                // A change that is not saved is lost at the next reset.
                if self.run.random.chance(0.9) {
                    self.save()?;
                }
            }
            25..30 => self.sends(!self.run.controller.sends),
            30..35 => self.checked(&["selftest"])?,
            35..40 => {
                self.checked(&["scan"])?;
                self.run_for(SHOWS_US, |life| life.state() == "idle");
            }
            40..45 => {
                let now = self.now();
                self.run.watch.line_refused(now);
                self.send(&["hello"]);
            }
            _ => self.chatter()?,
        }
        Ok(None)
    }

    /// Sends a random command that changes no setting and starts nothing.
    fn chatter(&mut self) -> Result<()> {
        let lines: [&[&str]; 5] = [
            &["status"],
            &["version"],
            &["get", "mount-height"],
            &["get"],
            &["reset"],
        ];
        let line = lines[self.run.random.index(lines.len())];
        let listing = line == ["get"];
        if listing {
            self.run.watch.listing_until(u64::MAX);
        }
        self.checked(line)?;
        if listing {
            self.run.watch.listing_until(self.now() + LISTING_US);
        }
        Ok(())
    }

    fn change(&mut self) -> Result<()> {
        let (key, low, high) = CHANGED[self.run.random.index(CHANGED.len())];
        let value = low + self.run.random.index((high - low) as usize) as u32;
        self.set(key, &value.to_string())
    }

    /// Returns a reset, half of them by loss of power, which also erases the retained state.
    fn reset(&mut self) -> Ending {
        if self.run.random.chance(0.5) {
            self.run.world.borrow().board.get().lose_power();
            Ending::Reset("power-on")
        } else {
            Ending::Reset("software")
        }
    }

    /// Switches the motion sentences on or off.
    fn sends(&mut self, on: bool) {
        let now = self.now();
        self.run.controller.sends = on;
        self.run.watch.motion_sends(now, on);
    }

    /// Runs the activity `part` over the wrap of the clock, mostly until `until`, µs of the run.
    fn around_wrap(&mut self, part: Part, until: u64) -> Result<()> {
        match part {
            Part::Scans => self.scans(until),
            Part::Stopping => {
                self.stop()?;
                self.set("sweep-mode", "stop")?;
                self.scans(until)?;
                self.stop()?;
                self.set("sweep-mode", "continuous")
            }
            Part::Guard => self.guard("guard", until),
            Part::Watch => self.guard("watch", until),
            Part::Idle => {
                self.stop()?;
                self.run_until(until);
                Ok(())
            }
            Part::SpanAfterScan => self.span_after_scan(),
            Part::SpanOfSilence => self.span_of_silence(),
        }
    }

    fn scans(&mut self, until: u64) -> Result<()> {
        self.checked(&["start"])?;
        self.disturbed(until, false)
    }

    fn guard(&mut self, command: &str, until: u64) -> Result<()> {
        self.checked(&["start"])?;
        self.run.watch.guard_anew();
        self.checked(&[command, "on"])?;
        self.disturbed(until, true)?;
        self.run.watch.guard_anew();
        self.checked(&[command, "off"])
    }

    /// Runs until `until` with random faults, pauses of the motion sentences, lost chirps and commands; `guards` tells
    /// whether guard sweeps are on.
    fn disturbed(&mut self, until: u64, guards: bool) -> Result<()> {
        loop {
            let pause = self.between(5, 60);
            self.run_until((self.now() + pause).min(until));
            if self.now() >= until {
                return Ok(());
            }
            match self.run.random.index(20) {
                0 => {
                    let silence = self.between(3, 40);
                    self.silence(silence);
                }
                1 => self.stall(),
                2..5 => self.lose_motion(),
                5..8 => {
                    let now = self.now();
                    self.run.watch.chirps_lost(now + SECOND_US);
                    self.run.world.borrow().module.get().losing = 1;
                }
                8..12 if guards => {
                    self.checked(&["scan"])?;
                    self.run.watch.pauses_sweeps();
                }
                12..15 if !guards => {
                    self.stop()?;
                    let pause = self.between(0, 5);
                    self.run_until(self.now() + pause);
                    self.checked(&["start"])?;
                }
                _ => self.chatter()?,
            }
        }
    }

    /// Lets the radar module fall silent for `us` microseconds, and waits for the first answer after that.
    fn silence(&mut self, us: u64) {
        self.run.watch.fault_begins();
        self.run.world.borrow().module.get().silent = true;
        self.run_until(self.now() + us);
        self.run.world.borrow().module.get().silent = false;
        self.recover();
    }

    /// Lets the motor stall once, and waits for the first answer after that.
    fn stall(&mut self) {
        self.run.watch.fault_begins();
        self.run.world.borrow_mut().shaft.stalls = true;
        self.run_for(SHOWS_US, |life| life.state() == "fault");
        self.recover();
    }

    fn recover(&mut self) {
        let instant = self.run.instant();
        self.run.watch.fault_ends(instant);
        self.run_for(OVER_US, |life| !life.run.watch.is_faulty());
        self.run.watch.pauses_sweeps();
    }

    /// Stops the motion sentences for up to 30 s.
    fn lose_motion(&mut self) {
        let pause = self.between(0, 30);
        self.sends(false);
        self.run_until(self.now() + pause);
        self.sends(true);
    }

    /// Scans once, waits 2³² µs (one span of the clock) without motion sentences, and guards for a minute.
    fn span_after_scan(&mut self) -> Result<()> {
        self.stop()?;
        self.checked(&["scan"])?;
        self.run_for(SHOWS_US, |life| life.state() == "idle");
        let scanned = self.now();
        self.sends(false);
        let late = self.between(0, 4);
        self.run_until(scanned + SPAN_US + late);
        self.sends(true);
        self.run.watch.guard_anew();
        self.checked(&["guard", "on"])?;
        self.run_until(self.now() + MINUTE_US);
        self.run.watch.guard_anew();
        self.checked(&["guard", "off"])
    }

    /// Guards while the radar module is silent for up to 20 s less than 2³² µs (one span of the clock).
    fn span_of_silence(&mut self) -> Result<()> {
        self.checked(&["start"])?;
        self.run.watch.guard_anew();
        self.checked(&["guard", "on"])?;
        let guards = self.between(20, 60);
        self.run_until(self.now() + guards);
        let early = self.between(0, 20);
        self.silence(SPAN_US - early);
        self.run_until(self.now() + MINUTE_US);
        self.run.watch.guard_anew();
        self.checked(&["guard", "off"])
    }
}
