//! A pseudo-terminal: whoever opens its path finds a scanner there.

use std::io::{ErrorKind, Read, Write};
use std::time::Duration;

use anyhow::{Context, Result};
use serialport::{SerialPort, TTYPort};

/// A reader that is there takes what is written within that, however busy the machine; one that is not is waited for
/// once.
const PATIENCE: Duration = Duration::from_secs(2);
/// Written at once: a terminal with less room than that says so beforehand.
const PIECE: usize = 64;

/// A pseudo-terminal.
#[derive(Debug)]
pub struct Pty {
    master: TTYPort,
    /// Keeps the terminal raw, and alive while nobody has it open.
    _slave: TTYPort,
    /// What to open.
    pub path: String,
    /// Bytes of a line whose end has not come.
    partial: Vec<u8>,
    /// Nobody has taken what was written last.
    unread: bool,
}

impl Pty {
    /// A new one.
    ///
    /// # Errors
    /// The system has none.
    pub fn new() -> Result<Self> {
        let (master, slave) = TTYPort::pair().context("a pseudo-terminal")?;
        let path = slave.name().context("a pseudo-terminal without a name")?;
        // Unlike the pair, its copies are closed in programs that this one starts: the emulator would keep the
        // terminal alive.
        let (master, slave) = (master.try_clone_native()?, slave.try_clone_native()?);
        Ok(Self {
            master,
            _slave: slave,
            path,
            partial: Vec::new(),
            unread: false,
        })
    }

    /// The whole lines that have come from the terminal's user. Never waits.
    pub fn read(&mut self) -> Vec<u8> {
        let mut buffer = [0; 256];
        let _ = self.master.set_timeout(Duration::ZERO);
        if let Ok(count) = self.master.read(&mut buffer) {
            self.partial.extend(&buffer[..count]);
        }
        let end = self
            .partial
            .iter()
            .rposition(|b| matches!(b, b'\r' | b'\n'));
        let whole = end.map_or(0, |end| end + 1);
        self.partial.drain(..whole).collect()
    }

    /// Hands bytes over. Like those of a UART, bytes that nobody reads are lost.
    pub fn write(&mut self, bytes: &[u8]) {
        for piece in bytes.chunks(PIECE) {
            let patience = if self.unread {
                Duration::ZERO
            } else {
                PATIENCE
            };
            let _ = self.master.set_timeout(patience);
            self.unread = self.whole(piece).is_err();
        }
    }

    fn whole(&mut self, mut piece: &[u8]) -> std::io::Result<()> {
        while !piece.is_empty() {
            match self.master.write(piece) {
                Ok(count) => piece = &piece[count..],
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}
