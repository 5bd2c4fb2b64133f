//! The radar module itself on a port: this program asks in the scanner's place, with the scanner's own link.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::{Read, Write};
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::Poll;
use std::time::Duration;

use anyhow::{Result, bail};
use serialport::SerialPort;
use stairscan::Iq;
use stairscan::scanner::{BytePort, Micros};
use stairscan::signal::radar::FrameLink;
use stairscan::signal::radar::module::RequestedSettings;
use stairscan::signal::radar::{LinkError, RadarModule};

use super::scans::Wire;
use crate::live::port::passes;

/// For one answer, µs: USB adapters wait up to 16 ms before they pass on what came.
const TIMEOUT_US: u32 = 500_000;
/// Further requests where one was not answered.
const RETRIES: u32 = 2;

/// What went over a port since it was asked last.
pub type Overheard = Rc<RefCell<Vec<(Wire, u8)>>>;

/// A port whose bytes are overheard in both directions.
#[derive(Debug)]
pub struct Tapped<P> {
    port: P,
    overheard: Overheard,
}

impl<P: BytePort> Tapped<P> {
    /// Overhears `port`.
    pub fn new(port: P, overheard: Overheard) -> Self {
        Self { port, overheard }
    }
}

impl<P: BytePort> BytePort for Tapped<P> {
    fn read(&mut self) -> Option<u8> {
        let byte = self.port.read()?;
        self.overheard.borrow_mut().push((Wire::FromModule, byte));
        Some(byte)
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        let count = self.port.write(bytes);
        let taken = bytes.iter().take(count).map(|byte| (Wire::ToModule, *byte));
        self.overheard.borrow_mut().extend(taken);
        count
    }
}

/// Between two reads of a port that has gone.
const GONE: Duration = Duration::from_millis(20);

/// A serial port as the link wants it.
pub struct Serial {
    port: Box<dyn SerialPort>,
    arrived: VecDeque<u8>,
}

impl Serial {
    /// Over `port`, whose time-out is how long a look for a byte may take.
    pub fn new(port: Box<dyn SerialPort>) -> Self {
        let arrived = VecDeque::new();
        Self { port, arrived }
    }
}

impl BytePort for Serial {
    fn read(&mut self) -> Option<u8> {
        if self.arrived.is_empty() {
            let mut buffer = [0; 1024];
            let read = self.port.read(&mut buffer);
            // A port that has gone gives no bytes: then the link says that nothing came. It does so at once, and
            // would be read as fast as this host can.
            if !matches!(&read, Ok(1..)) && !matches!(&read, Err(e) if passes(e.kind())) {
                std::thread::sleep(GONE);
            }
            let count = read.unwrap_or(0);
            self.arrived.extend(&buffer[..count]);
        }
        self.arrived.pop_front()
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        self.port.write(bytes).unwrap_or(0)
    }
}

/// So many rows lost one after the other end a scan, as the scanner's own.
const LOST_IN_A_ROW: u32 = 8;

/// One scan: the module's settings, then a chirp at each of `angles` of the shaft (0.001°). `now` is asked for the time
/// again and again; `stop` ends the scan.
///
/// # Errors
/// The module does not tell its settings, or falls silent. A single chirp that does not come is left to the tap to tell.
pub fn scan(
    link: &mut dyn RadarModule,
    angles: &[i32],
    stop: &AtomicBool,
    now: &mut dyn FnMut() -> Micros,
) -> Result<()> {
    let settings = attempts(|| {
        link.program(now(), &RequestedSettings::DEFAULT, TIMEOUT_US);
        wait(|| link.settings(now()))
    });
    let radar = match settings {
        Ok(radar) => radar,
        Err(error) => bail!("the module does not tell its settings: {}", explain(error)),
    };
    let mut samples = vec![Iq::default(); usize::from(radar.samples)];
    let mut lost = 0;
    for &angle in angles {
        if stop.load(Ordering::Relaxed) {
            return Ok(());
        }
        let chirp = attempts(|| {
            link.trigger(now(), angle, TIMEOUT_US);
            wait(|| link.poll(now(), &mut samples))
        });
        match chirp {
            Ok(()) => lost = 0,
            Err(error) if lost + 1 == LOST_IN_A_ROW => {
                bail!("{LOST_IN_A_ROW} chirps did not come: {}", explain(error));
            }
            Err(_) => lost += 1,
        }
    }
    Ok(())
}

/// Asks until there is an answer, or enough.
fn attempts<T>(mut ask: impl FnMut() -> Result<T, LinkError>) -> Result<T, LinkError> {
    let mut result = ask();
    for _ in 0..RETRIES {
        if result.is_ok() {
            break;
        }
        result = ask();
    }
    result
}

/// Polls until there is an answer; every question has its time-out.
fn wait<T>(mut poll: impl FnMut() -> Poll<Result<T, LinkError>>) -> Result<T, LinkError> {
    loop {
        if let Poll::Ready(result) = poll() {
            return result;
        }
    }
}

fn explain(error: LinkError) -> String {
    match error {
        LinkError::Timeout => {
            "nothing came. Is it powered, and are its TX+/TX- and RX+/RX- the right way round?"
                .to_owned()
        }
        LinkError::Frame(_) => {
            "what came is damaged. The link's speed is 1,000,000 baud".to_owned()
        }
        LinkError::Module(code) => format!("it reports error {code} (docs/link.md)"),
        _ => "it answers something else".to_owned(),
    }
}

/// The link over a port, overheard.
pub fn link<P: BytePort>(port: P, overheard: &Overheard) -> FrameLink<Tapped<P>> {
    FrameLink::new(Tapped::new(port, overheard.clone()))
}
