//! An update from the first question to the confirmation.
//!
//! The scanner stops and leaves for its boot loader; both ends go up to a faster rate where they have one; the header is
//! offered, then the payload from where the loader wants it on; the loader checks it and resets the chip; the new image runs
//! on trial, and its self-test confirms it. Whatever breaks off may be begun again: the loader remembers.

use std::time::{Duration, Instant};

use anyhow::{Result, bail, ensure};
use stairscan::report::Sentence;
use stairscan::scanner::command::framed;
use stairscan_boot::frame::{CHUNK, Kind};
use stairscan_boot::header::Header;
use stairscan_boot::receive::{FIRST_BAUD, Info};
use stairscan_boot::refusal::Refusal;
use stairscan_boot::slot::Slot;

use super::package::{Package, Signed};
use super::wire::{Link, Reply, Wire};

/// For a greeting: the loader checks both slots for its answer, 2 s on the internal oscillator.
const HELLO: (Duration, u32) = (Duration::from_millis(2_500), 6);
/// Where no image speaks, the loader may be there already.
const ALREADY: (Duration, u32) = (Duration::from_millis(2_500), 1);
/// For the first sentence of an image that runs.
const LISTEN: Duration = Duration::from_millis(700);
/// For an image's refusal to leave for its loader.
const REFUSED: Duration = Duration::from_millis(300);
/// For the first word at another rate.
const RATE: (Duration, u32) = (Duration::from_millis(700), 2);
/// A loader that heard nothing at another rate is back at the first one within this time.
const RATE_BACK: Duration = Duration::from_millis(2_500);
/// For a signature's check and three erasures of 4 s at most.
const BEGIN: (Duration, u32) = (Duration::from_secs(20), 2);
/// For a piece: 0.1 s on the wire, 30 ms in flash.
const DATA: (Duration, u32) = (Duration::from_secs(2), 5);
/// For the check of hash and signature.
const FINISH: (Duration, u32) = (Duration::from_secs(10), 2);
/// For the image's answer to a command.
const ANSWER: Duration = Duration::from_secs(2);
/// From the reset to the image's first sentence.
const BOOT: Duration = Duration::from_secs(10);

/// Outcome of an update.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The new image has been confirmed.
    Confirmed,
    /// It runs on trial, and its self-test has not passed yet: why, as far as it says.
    OnTrial(String),
    /// The loader runs another image.
    RolledBack(String),
    /// The scanner has stopped sending.
    Silent,
}

/// The transfer as it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transfer {
    /// Rate, baud.
    pub baud: u32,
    /// Offset at which it went on; 0 for a fresh one.
    pub resumed: u32,
    /// Bytes sent.
    pub sent: u32,
    /// Time for these.
    pub time: Duration,
}

/// Returns the remedy for a refusal.
pub fn help(refusal: Refusal) -> &'static str {
    match refusal {
        Refusal::NoImage => "the file is no signed image: `cargo sim keys sign` makes one",
        Refusal::OtherChip => "the image is for another chip or board",
        Refusal::OtherSlot => "the image is linked for another slot: sign the ELF file again",
        Refusal::TooLong => "the image is longer than a slot",
        Refusal::Older => {
            "the image is older than one that the scanner has confirmed: its number is below the counter"
        }
        Refusal::WrongKey => "the image is signed with a key that this scanner does not trust",
        Refusal::BadSignature => {
            "the signature does not belong to the image: the file was changed after it was signed"
        }
        Refusal::CutOff => "not all of the image has come: send it again",
        Refusal::Damaged => "what has come is not what was signed: send it again",
        Refusal::Flash => {
            "the scanner's flash takes nothing, or does not keep it: the chip is worn, locked, or the emulator's"
        }
        Refusal::Request => "the loader does not know this request, or not now",
        Refusal::NoWayBack => "there is no confirmed image of the same number in the other slot",
    }
}

/// An answer's payload, or an error that says what to do.
fn good(reply: Option<Reply>, what: &str) -> Result<Vec<u8>> {
    match reply {
        Some(Reply::Good(payload)) => Ok(payload),
        Some(Reply::Refused(refusal)) => bail!("refused: {}: {}", refusal.as_str(), help(refusal)),
        None => bail!("no answer to {what}: repeat the command, it goes on where it broke off"),
    }
}

fn next_of(payload: &[u8]) -> Result<u32> {
    match payload.first_chunk() {
        Some(bytes) => Ok(u32::from_le_bytes(*bytes)),
        None => bail!("an answer without an offset"),
    }
}

/// A loader that answers.
#[derive(Debug)]
pub struct Client<W> {
    link: Link<W>,
    /// Its description of itself.
    pub info: Info,
    baud: u32,
    /// The scanner was at work before, and is to be again.
    at_work: bool,
}

impl<W: Wire> Client<W> {
    /// Brings a scanner into its boot loader, unless it is there.
    ///
    /// # Errors
    /// The scanner does not answer, or has no loader.
    pub fn enter(wire: W) -> Result<Self> {
        let mut link = Link::new(wire);
        let at_work = is_at_work(&mut link)?;
        if at_work.is_some() {
            leave_image(&mut link)?;
        }
        let patience = if at_work.is_some() { HELLO } else { ALREADY };
        let mut reply = link.ask(Kind::Hello, &[], patience)?;
        if reply.is_none() && at_work.is_none() {
            // A scanner that says nothing by itself may still hear.
            leave_image(&mut link)?;
            reply = link.ask(Kind::Hello, &[], HELLO)?;
        }
        let Some(Reply::Good(payload)) = reply else {
            bail!(
                "no boot loader answers: the scanner is off, its wire is, or it has none (`cargo flash` writes it)"
            );
        };
        let Some(info) = Info::parse(&payload) else {
            bail!(
                "the boot loader speaks another version: expected one that this program was built with"
            );
        };
        Ok(Self {
            link,
            info,
            baud: FIRST_BAUD,
            at_work: at_work == Some(true),
        })
    }

    /// The slot that a new image goes to.
    pub fn spare(&self) -> Slot {
        if self.info.spare == 0 {
            Slot::A
        } else {
            Slot::B
        }
    }

    /// Goes up to the fastest rate that loader, port and user have. What does not work is left at the first rate.
    fn speed_up(&mut self, most: u32) -> Result<()> {
        let fastest = u32::from(self.info.fastest) * 100_000;
        let rates = [3_000_000, 2_000_000, 1_000_000];
        let wanted = rates.into_iter().find(|&rate| rate <= most.min(fastest));
        let Some(baud) = wanted else { return Ok(()) };
        let agreed = self.link.ask(Kind::Rate, &baud.to_le_bytes(), RATE)?;
        if !matches!(agreed, Some(Reply::Good(_))) {
            return Ok(());
        }
        if self.link.wire.set_rate(baud).is_ok() {
            self.link.forget();
            if self.link.ask(Kind::Hello, &[], HELLO_FAST)?.is_some() {
                self.baud = baud;
                return Ok(());
            }
        }
        self.link.wire.set_rate(FIRST_BAUD)?;
        std::thread::sleep(RATE_BACK);
        self.link.forget();
        good(self.link.ask(Kind::Hello, &[], HELLO)?, "the greeting").map(|_| ())
    }

    /// Sends the image for the spare slot, and lets the loader check and start it. `told` gets how far it has come.
    ///
    /// # Errors
    /// A refusal, each with its own words, or a wire that broke.
    pub fn send(
        &mut self,
        package: &Package,
        most: u32,
        mut told: impl FnMut(u32, u32),
    ) -> Result<Transfer> {
        let Signed { header, payload } = package.image(self.spare());
        self.speed_up(most)?;
        let begun = Instant::now();
        let reply = self.link.ask(Kind::Begin, header, BEGIN)?;
        let resumed = next_of(&good(reply, "the header")?)?;
        let (mut next, total) = (resumed, payload.len() as u32);
        while next < total {
            told(next, total);
            let rest = payload.get(next as usize..).unwrap_or_default();
            let piece = rest.get(..CHUNK).unwrap_or(rest);
            let data = [&next.to_le_bytes(), piece].concat();
            let reply = self.link.ask(Kind::Data, &data, DATA)?;
            let answered = next_of(&good(reply, "a piece of the image")?)?;
            ensure!(
                answered <= total,
                "the loader asks for bytes behind the image"
            );
            next = answered;
        }
        told(total, total);
        let reply = self.link.ask(Kind::Finish, &[], FINISH)?;
        // A reset that swallowed the answer shows in what is heard next.
        if let Some(Reply::Refused(refusal)) = reply {
            bail!("refused: {}: {}", refusal.as_str(), help(refusal));
        }
        Ok(Transfer {
            baud: self.baud,
            resumed,
            sent: total - resumed,
            time: begun.elapsed(),
        })
    }

    /// Goes back to the image before.
    ///
    /// # Errors
    /// There is none, or the wire broke.
    pub fn back(&mut self) -> Result<()> {
        good(self.link.ask(Kind::Back, &[], FINISH)?, "the request").map(|_| ())
    }

    /// Leaves the loader for whatever it then executes.
    ///
    /// # Errors
    /// The wire broke.
    pub fn boot(&mut self) -> Result<()> {
        good(self.link.ask(Kind::Boot, &[], DATA)?, "the request").map(|_| ())
    }

    /// Listens to what comes after the reset: the image on trial, its self-test, its confirmation, for `patience` at most.
    ///
    /// # Errors
    /// The port has gone.
    pub fn follow(&mut self, name: &str, patience: Duration) -> Result<Outcome> {
        let wanted = self.spare().as_str();
        self.link.wire.set_rate(FIRST_BAUD)?;
        let mut trial = false;
        let mut last = "its self-test has not ended".to_owned();
        let until = Instant::now() + patience;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let heard = self
                .link
                .until(left.min(BOOT), |line| Some(line.to_owned()))?;
            let Some(line) = heard else {
                if !trial || Instant::now() >= until {
                    return Ok(if trial {
                        Outcome::OnTrial(last)
                    } else {
                        Outcome::Silent
                    });
                }
                continue;
            };
            if let Some(told) = Told::parse(&line) {
                match told {
                    Told {
                        slot, trial: "0", ..
                    } if slot == wanted => {
                        if self.at_work {
                            self.link.until(BOOT, |line| match Sentence::parse(line) {
                                Ok(Sentence::Boot { .. }) => Some(()),
                                _ => None,
                            })?;
                            self.link.wire.send(framed(&["start"]).as_bytes())?;
                        }
                        return Ok(Outcome::Confirmed);
                    }
                    Told { slot, .. } if slot == wanted => trial = true,
                    Told { states, .. } => return Ok(Outcome::RolledBack(states.to_owned())),
                }
            }
            match Sentence::parse(&line) {
                // The self-test runs by itself unless the scanner was stopped, as it was for the update.
                Ok(Sentence::Boot { .. }) => {
                    let test = framed(&["selftest"]);
                    self.link.wire.send(test.as_bytes())?;
                }
                Ok(Sentence::Fail { field, .. }) => last = format!("its self-test fails: {field}"),
                Ok(Sentence::Halt { .. }) => last = format!("it crashed: {line}"),
                _ => {}
            }
            if Instant::now() >= until {
                return Ok(Outcome::OnTrial(format!("{name}: {last}")));
            }
        }
    }
}

/// For a greeting at another rate: both slots are checked at 168 MHz.
const HELLO_FAST: (Duration, u32) = (Duration::from_millis(1_500), 1);

/// The loader's sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Told<'a> {
    /// The slot that is executed, empty for none.
    pub slot: &'a str,
    /// Which execution on trial, `0` for a confirmed image.
    pub trial: &'a str,
    /// States of both slots.
    pub states: &'a str,
}

impl<'a> Told<'a> {
    /// Reads it; `None` for any other line, or a damaged one.
    pub fn parse(line: &'a str) -> Option<Self> {
        let (body, crc) = line.strip_prefix('$')?.rsplit_once('*')?;
        let right = stairscan::crc::of_parts(&[body.as_bytes()]);
        (u32::from_str_radix(crc, 16) == Ok(right)).then_some(())?;
        let (slot, rest) = body.strip_prefix("PSTR,LOADER,")?.split_once(',')?;
        let (trial, states) = rest.split_once(',')?;
        Some(Self {
            slot,
            trial,
            states,
        })
    }
}

/// Whether an image speaks at the port, and is at work: it says five times a second how it fares.
fn is_at_work<W: Wire>(link: &mut Link<W>) -> Result<Option<bool>> {
    link.until(LISTEN, |line| match Sentence::parse(line) {
        Ok(Sentence::Live(live)) => Some(!matches!(live.state, "idle" | "fault")),
        _ => None,
    })
}

/// Stops the scanner and sends it into its loader.
fn leave_image<W: Wire>(link: &mut Link<W>) -> Result<()> {
    // Behind whatever stands in the scanner's line buffer.
    let stop = framed(&["stop"]);
    link.wire.send(format!("\r\n{stop}").as_bytes())?;
    link.until(ANSWER, |line| match Sentence::parse(line) {
        Ok(Sentence::Done { command }) => (command == "stop").then_some(()),
        _ => None,
    })?;
    link.forget();
    link.wire.send(framed(&["update"]).as_bytes())?;
    let refused = link.until(REFUSED, |line| match Sentence::parse(line) {
        Ok(Sentence::Fail { field, .. }) => Some(field.to_owned()),
        _ => None,
    })?;
    match refused.as_deref() {
        Some("loader" | "command") => bail!(
            "the scanner has no boot loader, or a firmware without updates: `cargo flash` writes both over a debug probe"
        ),
        Some(field) => bail!("the scanner refuses: {field}"),
        None => Ok(()),
    }
}

/// A line on a slot's image for people.
pub fn slot_line(info: &Info, slot: Slot) -> String {
    let [a, b] = &info.slots;
    let told = if slot == Slot::A { a } else { b };
    let text = |bytes: &[u8]| {
        let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
        String::from_utf8_lossy(bytes.get(..end).unwrap_or_default()).into_owned()
    };
    let name = text(&told.name);
    let of = if name.is_empty() {
        String::new()
    } else {
        format!(": {name}, number {}", told.number)
    };
    format!("slot {}: {}{of}", slot.as_str(), text(&told.word))
}

/// Version in words of a package.
pub fn version(package: &Package) -> String {
    let header = Header::parse(&package.image(Slot::A).header);
    header.map_or_else(
        |_| "?".to_owned(),
        |header| format!("{}, number {}", header.name(), header.number),
    )
}
