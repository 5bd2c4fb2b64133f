//! Frames to the boot loader and its answers, and the sentences of the scanner between them.

use std::io::{ErrorKind, Read, Write};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use serialport::SerialPort;
use stairscan_boot::frame::{ANSWER, Decoder, Frame, Kind, MAX_FRAME, encode};
use stairscan_boot::refusal::Refusal;

use crate::live::arrived::Arrived;
use crate::live::lines::Splitter;
use crate::live::port::passes;

/// A port on which frames and sentences are transferred.
pub trait Wire {
    /// Reads received bytes into `buffer` and returns their number; 0 after a short time without
    /// any.
    ///
    /// # Errors
    /// The port has disappeared.
    fn receive(&mut self, buffer: &mut [u8]) -> Result<usize>;
    /// Sends all bytes.
    ///
    /// # Errors
    /// The port has disappeared.
    fn send(&mut self, bytes: &[u8]) -> Result<()>;
    /// Changes the port's baud rate.
    ///
    /// # Errors
    /// The port does not support the rate.
    fn set_rate(&mut self, baud: u32) -> Result<()>;
}

impl Wire for Box<dyn SerialPort> {
    fn receive(&mut self, buffer: &mut [u8]) -> Result<usize> {
        match self.read(buffer) {
            Ok(0) => bail!("the port's end was reached"),
            Ok(count) => Ok(count),
            Err(error) if passes(error.kind()) => Ok(0),
            Err(error) => Err(error).context("the port has gone"),
        }
    }

    fn send(&mut self, mut bytes: &[u8]) -> Result<()> {
        while !bytes.is_empty() {
            match self.write(bytes) {
                Ok(count) => bytes = bytes.get(count..).unwrap_or_default(),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error).context("the port takes nothing"),
            }
        }
        self.flush().context("the port takes nothing")
    }

    fn set_rate(&mut self, baud: u32) -> Result<()> {
        self.set_baud_rate(baud)
            .with_context(|| format!("{baud} baud"))
    }
}

/// An answer of the loader to a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// The loader has executed the request; with the answer's payload.
    Good(Vec<u8>),
    /// The loader has refused the request; with the reason.
    Refused(Refusal),
}

/// The host's end of the link to the loader.
#[derive(Debug)]
pub struct Link<W> {
    /// Port on which the loader is connected.
    pub wire: W,
    decoder: Decoder,
    sequence: u8,
    reader: Splitter,
    arrived: Arrived,
    /// Sentences received and not yet processed, oldest first.
    pub sentences: Vec<String>,
}

impl<W: Wire> Link<W> {
    /// Creates the link over a port at the first baud rate.
    pub fn new(wire: W) -> Self {
        Self {
            wire,
            decoder: Decoder::new(),
            sequence: 0,
            reader: Splitter::default(),
            arrived: Arrived::default(),
            sentences: Vec::new(),
        }
    }

    /// Sends a request and returns the answer. After each `patience` without an answer the request
    /// is sent again, `tries` times in all; then `None`.
    ///
    /// # Errors
    /// The port has disappeared.
    pub fn ask(
        &mut self,
        kind: Kind,
        payload: &[u8],
        (patience, tries): (Duration, u32),
    ) -> Result<Option<Reply>> {
        self.sequence = self.sequence.wrapping_add(1);
        let request = Frame {
            kind: kind as u8,
            sequence: self.sequence,
            payload,
        };
        let mut out = [0; MAX_FRAME];
        let count = encode(request, &mut out);
        for _ in 0..tries {
            self.wire.send(out.get(..count).unwrap_or_default())?;
            let until = Instant::now() + patience;
            while Instant::now() < until {
                if let Some(answer) = self.listen(kind)? {
                    return Ok(Some(reply(kind, answer)));
                }
            }
        }
        Ok(None)
    }

    /// Reads the port once, stores sentences, and returns the payload of the answer to the last
    /// request if that has arrived.
    fn listen(&mut self, kind: Kind) -> Result<Option<Vec<u8>>> {
        let mut buffer = [0; 256];
        let count = self.wire.receive(&mut buffer)?;
        self.hear(buffer.get(..count).unwrap_or_default());
        let mut found = None;
        for &byte in buffer.iter().take(count) {
            if let Some(frame) = self.decoder.push(byte)
                && (frame.kind, frame.sequence) == (kind as u8 | ANSWER, self.sequence)
            {
                found = Some(frame.payload.to_vec());
            }
        }
        Ok(found)
    }

    /// Stores the sentences that `bytes` complete, and counts the other lines.
    fn hear(&mut self, bytes: &[u8]) {
        for line in self.reader.push(bytes) {
            self.arrived.line(&line);
            if line.starts_with('$') {
                self.sentences.push(line);
            }
        }
    }

    /// Returns what has been received since the last intact sentence; a line without its end counts.
    pub fn arrived(&self) -> Arrived {
        self.arrived.with_pending(&self.reader)
    }

    /// Calls `done` with each sentence until it returns a result, and returns that result; `None`
    /// after `patience`.
    ///
    /// # Errors
    /// The port has disappeared.
    pub fn until<T>(
        &mut self,
        patience: Duration,
        mut done: impl FnMut(&str) -> Option<T>,
    ) -> Result<Option<T>> {
        let until = Instant::now() + patience;
        let mut buffer = [0; 256];
        loop {
            while !self.sentences.is_empty() {
                let line = self.sentences.remove(0);
                if let Some(found) = done(&line) {
                    return Ok(Some(found));
                }
            }
            if Instant::now() > until {
                return Ok(None);
            }
            let count = self.wire.receive(&mut buffer)?;
            self.hear(buffer.get(..count).unwrap_or_default());
        }
    }

    /// Discards the received bytes and sentences.
    pub fn forget(&mut self) {
        self.sentences.clear();
        self.reader = Splitter::default();
        self.decoder.reset();
    }
}

/// Decodes an answer's payload: a code (0, or the reason of a refusal), then data. An answer to
/// `hello` has no code.
fn reply(kind: Kind, payload: Vec<u8>) -> Reply {
    if kind == Kind::Hello {
        return Reply::Good(payload);
    }
    match payload.split_first() {
        Some((0, rest)) => Reply::Good(rest.to_vec()),
        Some((&code, _)) => Reply::Refused(Refusal::from_code(code).unwrap_or(Refusal::Request)),
        None => Reply::Refused(Refusal::Request),
    }
}
