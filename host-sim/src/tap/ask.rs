//! Acquires scans from a radar module at a port: this program takes the scanner's place, with the scanner's own link.

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
use stairscan::signal::radar::module::Wish;
use stairscan::signal::radar::{LinkError, RadarModule};

use super::scans::Wire;
use crate::live::port::passes;

/// Timeout of one answer, µs. USB adapters wait up to 16 ms before they forward data.
const TIMEOUT_US: u32 = 500_000;
/// Number of repetitions of a request without an answer.
const RETRIES: u32 = 2;

/// Bytes of a port with their direction, recorded since the last read.
pub type Overheard = Rc<RefCell<Vec<(Wire, u8)>>>;

/// A port that records its bytes in both directions.
#[derive(Debug)]
pub struct Tapped<P> {
    port: P,
    overheard: Overheard,
}

impl<P: BytePort> Tapped<P> {
    /// Records the bytes of `port`.
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

/// Interval between two reads of a port that has disappeared.
const GONE: Duration = Duration::from_millis(20);

/// A serial port with the link's interface.
pub struct Serial {
    port: Box<dyn SerialPort>,
    arrived: VecDeque<u8>,
}

impl Serial {
    /// Uses `port`, whose timeout is the maximum duration of a read.
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
            // A port that has disappeared returns no bytes, and the link reports a timeout. The read returns at once;
            // without this pause the loop would use all of the processor.
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

/// Number of consecutive lost rows that ends a scan, as in the scanner.
const LOST_IN_A_ROW: u32 = 8;

/// Acquires one scan: the module's settings, then a chirp at each of `angles` of the shaft (0.001°). `now` returns
/// the current time; `stop` ends the scan.
///
/// # Errors
/// The module does not report its settings, or stops answering. A single missing chirp is reported by the tap.
pub fn scan(
    link: &mut dyn RadarModule,
    angles: &[i32],
    stop: &AtomicBool,
    now: &mut dyn FnMut() -> Micros,
) -> Result<()> {
    let settings = attempts(|| {
        link.program(now(), &Wish::DEFAULT, TIMEOUT_US);
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

/// Repeats `ask` until it succeeds, at most [`RETRIES`] times.
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

/// Polls until the result is ready. Every request has a timeout.
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

/// Returns a link over a recorded port.
pub fn link<P: BytePort>(port: P, overheard: &Overheard) -> FrameLink<Tapped<P>> {
    FrameLink::new(Tapped::new(port, overheard.clone()))
}
