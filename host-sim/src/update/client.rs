//! An update over the report port, from the first request to the confirmation of the new image.
//!
//! The scanner stops and enters its boot loader. Both ends change to a faster baud rate if they
//! have one. The host sends the image's header, then the payload from the offset that the loader
//! asks for. The loader checks the image and resets the chip. The new image runs on trial, until
//! its self-test confirms it. An update that is interrupted at any point may be repeated: the
//! loader continues after the bytes that it has stored.

use std::time::{Duration, Instant};

use anyhow::{Result, bail, ensure};
use stairscan::report::Sentence;
use stairscan::scanner::command::framed;
use stairscan_boot::frame::{CHUNK, Kind};
use stairscan_boot::header::Header;
use stairscan_boot::receive::{FIRST_BAUD, Info, PROTOCOL};
use stairscan_boot::refusal::Refusal;
use stairscan_boot::slot::Slot;

use super::package::{Package, Signed};
use super::wire::{Link, Reply, Wire};
use crate::live::arrived::Arrived;
use crate::live::trouble::UnexpectedData;

/// Timeout and number of tries of the greeting (`hello`) after a scanner was sent into its loader:
/// the loader checks both slots before it answers, 2 s on the internal oscillator.
const HELLO: (Duration, u32) = (Duration::from_millis(2_500), 6);
/// Timeout and number of tries of the greeting if no image sends sentences, because the loader may
/// be running already.
const ALREADY: (Duration, u32) = (Duration::from_millis(2_500), 1);
/// Maximum time to wait for the first sentence of a running image.
const LISTEN: Duration = Duration::from_millis(700);
/// Maximum time in which a running image reports that it refuses to enter its loader.
const REFUSED: Duration = Duration::from_millis(300);
/// Timeout and number of tries of a greeting of which one may meet the loader: it waits for 10 s.
const CAUGHT: (Duration, u32) = (Duration::from_millis(1_000), 1);
/// Instructions for bringing a loader to wait for a host although its image crashes.
pub const FORCE: &str = "reset the scanner three times, each within a minute after the one before, or reset it with LOADER \
                         (PB12) held at 3.3 V: then its boot loader waits for this command";
/// Timeout and number of tries of the request for another baud rate.
const RATE: (Duration, u32) = (Duration::from_millis(700), 2);
/// Time after which a loader that received nothing at another baud rate is back at the first one.
const RATE_BACK: Duration = Duration::from_millis(2_500);
/// Timeout and number of tries of the header: the loader checks the signature and erases up to
/// three sectors, 4 s each.
const BEGIN: (Duration, u32) = (Duration::from_secs(20), 2);
/// Timeout and number of tries of one piece of the payload: 0.1 s on the wire, 30 ms in flash.
const DATA: (Duration, u32) = (Duration::from_secs(2), 5);
/// Timeout and number of tries of the final request, at which the loader checks hash and signature.
const FINISH: (Duration, u32) = (Duration::from_secs(10), 2);
/// Maximum time to wait for a running image's answer to a command.
const ANSWER: Duration = Duration::from_secs(2);
/// Maximum time from the reset to the new image's first sentence.
const BOOT: Duration = Duration::from_secs(10);

/// Outcome of an update.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The new image has been confirmed.
    Confirmed,
    /// The new image runs on trial, but its self-test has not passed yet; with the last known
    /// cause.
    OnTrial(String),
    /// The loader executes another image than the new one; with the states of both slots, as the
    /// loader reports them.
    RolledBack(String),
    /// No sentence has been received since the reset; with what has been received instead, if anything.
    NotHeard(Option<String>),
}

/// Statistics of a completed transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transfer {
    /// Baud rate of the transfer.
    pub baud: u32,
    /// Offset in the payload at which the transfer continued an earlier one, bytes; 0 for a new
    /// transfer.
    pub resumed: u32,
    /// Number of payload bytes sent in this transfer.
    pub sent: u32,
    /// Duration of the transfer, with the loader's checks.
    pub time: Duration,
}

/// Returns the remedy for a request that the loader refused, for the error message.
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
        Refusal::Supply => {
            "the scanner's supply is below 2.9 V, too low to write flash: see to it, and send again"
        }
        Refusal::NoWayBack => "there is no confirmed image of the same number in the other slot",
    }
}

/// Returns the payload of an answer; an error with the remedy if the loader refused or did not
/// answer the request `what`.
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

/// Connection to a boot loader that answers.
#[derive(Debug)]
pub struct Client<W> {
    link: Link<W>,
    /// The loader's description of itself and of both slots.
    pub info: Info,
    baud: u32,
    /// Whether the scanner was scanning before the update; it is then started again afterwards.
    at_work: bool,
}

impl<W: Wire> Client<W> {
    /// Brings a scanner into its boot loader, unless the loader is running already.
    ///
    /// # Errors
    /// The scanner does not answer, or has no loader.
    pub fn enter(wire: W) -> Result<Self> {
        Self::enter_within(wire, Duration::ZERO, |_| ())
    }

    /// Same as [`Self::enter`], but waits for the loader for `patience` if no image sends it there, and calls `told`
    /// with the remedy. The loader waits for a host if it is forced to, by its pin or by three resets.
    ///
    /// # Errors
    /// The scanner does not answer, or has no loader.
    pub fn enter_within(wire: W, patience: Duration, told: impl FnOnce(&str)) -> Result<Self> {
        let mut link = Link::new(wire);
        let at_work = is_at_work(&mut link)?;
        if at_work.is_some() {
            leave_image(&mut link)?;
        }
        let greeting = if at_work.is_some() { HELLO } else { ALREADY };
        let mut reply = link.ask(Kind::Hello, &[PROTOCOL], greeting)?;
        if reply.is_none() && at_work.is_none() {
            // A scanner that says nothing by itself may still hear.
            leave_image(&mut link)?;
            reply = link.ask(Kind::Hello, &[PROTOCOL], HELLO)?;
        }
        if reply.is_none() && !patience.is_zero() {
            told(FORCE);
            reply = catch(&mut link, patience)?;
        }
        let Some(Reply::Good(payload)) = reply else {
            bail!("no boot loader answers: {}", no_loader(&link.arrived()));
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

    /// Returns the slot into which the loader writes a new image.
    pub fn spare(&self) -> Slot {
        if self.info.spare == 0 {
            Slot::A
        } else {
            Slot::B
        }
    }

    /// Changes the baud rate to the fastest that loader and port support, at most `most`. If that fails, both ends use
    /// the first rate.
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
            if self
                .link
                .ask(Kind::Hello, &[PROTOCOL], HELLO_FAST)?
                .is_some()
            {
                self.baud = baud;
                return Ok(());
            }
        }
        self.link.wire.set_rate(FIRST_BAUD)?;
        std::thread::sleep(RATE_BACK);
        self.link.forget();
        good(
            self.link.ask(Kind::Hello, &[PROTOCOL], HELLO)?,
            "the greeting",
        )
        .map(|_| ())
    }

    /// Sends the image for the spare slot at a baud rate of at most `most`, and lets the loader check and start it.
    /// `reported` is called with the number of bytes transferred and the total.
    ///
    /// # Errors
    /// The loader refuses a request (the message contains the remedy), or does not answer.
    pub fn send(
        &mut self,
        package: &Package,
        most: u32,
        mut reported: impl FnMut(u32, u32),
    ) -> Result<Transfer> {
        let Signed { header, payload } = package.image(self.spare());
        self.speed_up(most)?;
        let begun = Instant::now();
        let reply = self.link.ask(Kind::Begin, header, BEGIN)?;
        let resumed = next_of(&good(reply, "the header")?)?;
        let (mut next, total) = (resumed, payload.len() as u32);
        while next < total {
            reported(next, total);
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
        reported(total, total);
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

    /// Requests the loader to return to the confirmed image in the other slot.
    ///
    /// # Errors
    /// There is none, or the loader does not answer.
    pub fn back(&mut self) -> Result<()> {
        good(self.link.ask(Kind::Back, &[], FINISH)?, "the request").map(|_| ())
    }

    /// Requests the loader to execute the image that it selects.
    ///
    /// # Errors
    /// The loader does not answer.
    pub fn boot(&mut self) -> Result<()> {
        good(self.link.ask(Kind::Boot, &[], DATA)?, "the request").map(|_| ())
    }

    /// Follows the sentences after the reset, for `patience` at most, and returns the outcome: the
    /// image on trial, its self-test, its confirmation. `name` is the image's, for messages.
    ///
    /// # Errors
    /// The port has disappeared.
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
                        Outcome::NotHeard(match self.link.arrived().kind() {
                            UnexpectedData::Nothing | UnexpectedData::Silence => None,
                            others => Some(others.explain(FIRST_BAUD).0),
                        })
                    });
                }
                continue;
            };
            if let Some(reported) = LoaderLine::parse(&line) {
                match reported {
                    LoaderLine {
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
                    LoaderLine { slot, .. } if slot == wanted => trial = true,
                    LoaderLine { states, .. } => return Ok(Outcome::RolledBack(states.to_owned())),
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

/// Timeout and number of tries of the greeting at another baud rate: the loader checks both slots
/// at 168 MHz.
const HELLO_FAST: (Duration, u32) = (Duration::from_millis(1_500), 1);

/// Content of the loader's sentence `LOADER`, which it sends before it executes an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoaderLine<'a> {
    /// Slot that is executed; empty if none is.
    pub slot: &'a str,
    /// Number of this execution of an image on trial; `0` for a confirmed image.
    pub trial: &'a str,
    /// States of both slots, as the loader reports them.
    pub states: &'a str,
}

impl<'a> LoaderLine<'a> {
    /// Parses a sentence of the loader; `None` for any other line, or a damaged one.
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

/// Returns why no loader answers, with the remedy, from what the port has delivered.
fn no_loader(arrived: &Arrived) -> String {
    let (what, help) = match arrived.kind() {
        UnexpectedData::Nothing => {
            let what = "nothing is received: the scanner is off, its wire is, or it has none (`cargo board` writes it)";
            (what.to_owned(), Vec::new())
        }
        UnexpectedData::Silence => (
            "its image reports, but does not leave for one".to_owned(),
            vec![
                "Is the wire to REPORT_RX (J2 pin 3) connected? Without a boot loader: `cargo board` writes it."
                    .to_owned(),
            ],
        ),
        others => others.explain(FIRST_BAUD),
    };
    let crashes = format!("If its image crashes: {FORCE}");
    let lines: Vec<String> = [vec![what], help, vec![crashes]].concat();
    lines.join("\n  ")
}

/// Greets the loader again and again until it answers, for `patience`; `None` if it does not.
fn catch<W: Wire>(link: &mut Link<W>, patience: Duration) -> Result<Option<Reply>> {
    let until = Instant::now() + patience;
    while Instant::now() < until {
        if let Some(reply) = link.ask(Kind::Hello, &[], CAUGHT)? {
            return Ok(Some(reply));
        }
        // Of an image that boots again and again.
        link.sentences.clear();
    }
    Ok(None)
}

/// Returns whether the running image is scanning, from its next `LIVE` sentence, sent five times a
/// second; `None` if there is none.
fn is_at_work<W: Wire>(link: &mut Link<W>) -> Result<Option<bool>> {
    link.until(LISTEN, |line| match Sentence::parse(line) {
        Ok(Sentence::Live(live)) => Some(!matches!(live.state, "idle" | "fault")),
        _ => None,
    })
}

/// Stops the scanner and sends it the command to enter its loader.
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
            "the scanner has no boot loader, or a firmware without updates: `cargo board` writes both over a debug probe"
        ),
        Some(field) => bail!("the scanner refuses: {field}"),
        None => Ok(()),
    }
}

/// Returns a line of text on the image in a slot: state, name and number.
pub fn slot_line(info: &Info, slot: Slot) -> String {
    let [a, b] = &info.slots;
    let reported = if slot == Slot::A { a } else { b };
    let text = |bytes: &[u8]| {
        let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
        String::from_utf8_lossy(bytes.get(..end).unwrap_or_default()).into_owned()
    };
    let name = text(&reported.name);
    let of = if name.is_empty() {
        String::new()
    } else {
        format!(": {name}, number {}", reported.number)
    };
    format!("slot {}: {}{of}", slot.as_str(), text(&reported.word))
}

/// Returns name and number of a package's image as text.
pub fn version(package: &Package) -> String {
    let header = Header::parse(&package.image(Slot::A).header);
    header.map_or_else(
        |_| "?".to_owned(),
        |header| format!("{}, number {}", header.name(), header.number),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_device_in_place_of_a_scanner_is_named() {
        let mut arrived = Arrived::default();
        arrived.line("$GPGGA,1,2*47");
        let why = no_loader(&arrived);
        assert!(
            why.starts_with("a GPS receiver (NMEA 0183, talker GP) sends"),
            "{why}"
        );
    }
}
