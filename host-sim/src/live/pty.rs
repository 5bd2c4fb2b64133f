//! A pseudo-terminal at whose path other programs find a scanner.

use std::io::{ErrorKind, Read, Write};
use std::time::Duration;

use anyhow::{Context, Result};
use serialport::{SerialPort, TTYPort};

/// Maximum wait until a reader takes written bytes. A connected reader takes them within it even on a busy machine;
/// an absent one is waited for only once.
const PATIENCE: Duration = Duration::from_secs(2);
/// Maximum number of bytes of one write. The serial port library polls the terminal before each write; with less free
/// space than this the system reports it as not writable.
const PIECE: usize = 64;

/// A pseudo-terminal. Its path can be opened by other programs like a serial port.
#[derive(Debug)]
pub struct Pty {
    master: TTYPort,
    /// Keeps the terminal raw, and open without another user.
    _slave: TTYPort,
    /// Path of the terminal, for other programs to open.
    pub path: String,
    /// Bytes received of a line that is not complete yet.
    partial: Vec<u8>,
    /// Whether the last bytes written found no reader in time; the next write then does not wait.
    unread: bool,
}

impl Pty {
    /// Opens a new pseudo-terminal.
    ///
    /// # Errors
    /// The system cannot provide one.
    pub fn new() -> Result<Self> {
        let (master, slave) = TTYPort::pair().context("a pseudo-terminal")?;
        let path = slave.name().context("a pseudo-terminal without a name")?;
        // The copies, unlike the original pair, are closed in child processes. Otherwise the emulator would keep the
        // terminal open.
        let (master, slave) = (master.try_clone_native()?, slave.try_clone_native()?);
        Ok(Self {
            master,
            _slave: slave,
            path,
            partial: Vec::new(),
            unread: false,
        })
    }

    /// Returns the complete lines from the terminal's user. Does not wait.
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

    /// Writes bytes for the terminal's user. Bytes that are not read are lost, as at a UART.
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
