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
use stairscan::signal::radar::module::RequestedSettings;
use stairscan::signal::radar::{LinkError, RadarModule};

use super::scans::Wire;
use crate::live::port::passes;

/// Maximum time to wait for the module's answer to one request, µs. USB adapters wait up to 16 ms
/// before they forward data.
const TIMEOUT_US: u32 = 500_000;
/// Number of repetitions of a request without an answer.
const RETRIES: u32 = 2;

/// Bytes of a port with the wire on which they passed, recorded since this list was last emptied.
pub type TappedBytes = Rc<RefCell<Vec<(Wire, u8)>>>;

/// A port that passes bytes on and records them in both directions.
#[derive(Debug)]
pub struct Tapped<P> {
    port: P,
    tapped: TappedBytes,
}

impl<P: BytePort> Tapped<P> {
    /// Wraps `port`, so that all bytes read and written are added to `tapped`.
    pub fn new(port: P, tapped: TappedBytes) -> Self {
        Self { port, tapped }
    }
}

impl<P: BytePort> BytePort for Tapped<P> {
    fn read(&mut self) -> Option<u8> {
        let byte = self.port.read()?;
        self.tapped.borrow_mut().push((Wire::FromModule, byte));
        Some(byte)
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        let count = self.port.write(bytes);
        let taken = bytes.iter().take(count).map(|byte| (Wire::ToModule, *byte));
        self.tapped.borrow_mut().extend(taken);
        count
    }
}

/// Interval between two reads of a port that has disappeared.
const GONE: Duration = Duration::from_millis(20);

/// A serial port with the interface that the radar link needs: byte by byte, without waiting for
/// more.
pub struct Serial {
    port: Box<dyn SerialPort>,
    arrived: VecDeque<u8>,
}

impl Serial {
    /// Creates the interface to `port`, whose timeout is the maximum duration of a read.
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

/// Number of consecutive rows without a chirp that ends a scan, as in the scanner.
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
        link.program(now(), &RequestedSettings::DEFAULT, TIMEOUT_US);
        wait(|| link.settings(now()))
    });
    let radar = match settings {
        Ok(radar) => radar,
        Err(error) => bail!(
            "the module does not report its settings: {}",
            explain(error)
        ),
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
                bail!(
                    "{LOST_IN_A_ROW} chirps were not received: {}",
                    explain(error)
                );
            }
            Err(_) => lost += 1,
        }
    }
    Ok(())
}

/// Repeats the request `ask` until it succeeds, at most [`RETRIES`] times after the first.
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

/// Polls the answer to a request until it is ready; every request of the link has a timeout.
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
            "nothing was received. Is it powered, and are its TX+/TX- and RX+/RX- the right way round?"
                .to_owned()
        }
        LinkError::Frame(_) => {
            "the received bytes are damaged. The link's speed is 1,000,000 baud until another is agreed on".to_owned()
        }
        LinkError::Module(code) => format!("it reports error {code} (docs/design/link.md)"),
        _ => "it sends another reply".to_owned(),
    }
}

/// Returns a radar link whose bytes are recorded in `tapped`.
pub fn link<P: BytePort>(port: P, tapped: &TappedBytes) -> FrameLink<Tapped<P>> {
    FrameLink::new(Tapped::new(port, tapped.clone()))
}
