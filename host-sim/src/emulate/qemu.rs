//! The emulator's process: two serial ports and the test channel as sockets, and the log.

use std::fs::{self, File};
use std::io::{ErrorKind, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use stairscan_boot::header::PAYLOAD;
use stairscan_boot::slot::Slot;

use super::image::build_loader;
use super::tools::{EMULATOR, Tool};
use crate::update::keys;
use crate::update::package::Package;
use crate::update::slots::address;

/// QOM path (QEMU's object tree) of the inputs of the chip's edge detector (EXTI).
const EXTI: &str = "/machine/unattached/device[0]/exti";
/// QOM path (QEMU's object tree) of the processor's interrupt controller.
const NVIC: &str = "/machine/unattached/device[0]/armv7m";
/// Timeout of the emulator's connections to the sockets, from the start of its process.
const CONNECT: Duration = Duration::from_secs(30);

/// An input pin of the chip. It reads as 0 in the emulator, but edges can be injected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Input {
    /// Home switch, PB0.
    Home = 0,
    /// Stall output of the motor driver, PB1.
    Stall = 1,
}

/// An emulator process. Dropping it ends the process and deletes its files.
#[derive(Debug)]
pub struct Qemu {
    child: Child,
    dir: PathBuf,
    /// Socket of the serial port to the radar module.
    pub link: UnixStream,
    /// Socket of the report port.
    pub report: UnixStream,
    qtest: UnixStream,
    log: File,
    rest: Vec<u8>,
}

/// Bytes of an erased flash slot up to the offset of its payload.
const BLANK: &[u8] = &[0xff; PAYLOAD as usize];

/// Returns the path of the boot loader's ELF file, which is built once.
fn loader() -> Result<&'static Path> {
    static LOADER: OnceLock<PathBuf> = OnceLock::new();
    if let Some(known) = LOADER.get() {
        return Ok(known);
    }
    let built = build_loader()?;
    Ok(LOADER.get_or_init(|| built))
}

/// Returns the bytes of flash slot A as a debug probe leaves them: the ELF file's image, signed with the development
/// key.
fn development_slot(elf: &Path) -> Result<Vec<u8>> {
    let package = Package::sign(elf, 0, &keys::development()?)?;
    Ok(package.image(Slot::A).slot(1))
}

/// Creates a directory for the emulator's sockets and log. Its path is short, since a socket's path is limited to 108
/// bytes.
fn scratch() -> Result<PathBuf> {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let name = format!("stairscan-{}-{count}", std::process::id());
    let dir = std::env::temp_dir().join(name);
    fs::create_dir_all(&dir).with_context(|| format!("{}", dir.display()))?;
    Ok(dir)
}

impl Qemu {
    /// Starts the emulator with the firmware `elf`. With `timed` the log also contains the values that the firmware
    /// reads from SysTick's registers and writes to them.
    pub fn start(elf: &Path, timed: bool) -> Result<Self> {
        Tool::Emulator.need()?;
        if !elf.is_file() {
            bail!(
                "{}: no such file; `cargo firmware` builds it",
                elf.display()
            );
        }
        let dir = scratch()?;
        let slots = [(Slot::A, development_slot(elf)?)];
        Self::start_slots(&slots, timed, dir)
    }

    /// Starts the emulator with these bytes in flash slots, each with its header, through the boot loader.
    pub fn start_with(slots: &[(Slot, Vec<u8>)]) -> Result<Self> {
        Tool::Emulator.need()?;
        Self::start_slots(slots, false, scratch()?)
    }

    /// Starts the emulator with a firmware `elf` that begins without the boot loader, as the demo image does.
    pub fn start_alone(elf: &Path) -> Result<Self> {
        Tool::Emulator.need()?;
        Self::launch(elf, &[], false, scratch()?)
    }

    fn start_slots(slots: &[(Slot, Vec<u8>)], timed: bool, dir: PathBuf) -> Result<Self> {
        let mut devices = Vec::new();
        for slot in Slot::BOTH {
            let given = slots.iter().find(|(of, _)| *of == slot);
            // Flash that nothing was written to reads as zeros in the emulator.
            let bytes = given.map_or(BLANK, |(_, bytes)| bytes.as_slice());
            let file = dir.join(format!("slot-{}", slot.as_str()));
            fs::write(&file, bytes)?;
            let (file, at) = (file.display(), address(slot));
            devices.push("-device".to_owned());
            devices.push(format!("loader,file={file},addr=0x{at:08x},force-raw=on"));
        }
        Self::launch(loader()?, &devices, timed, dir)
    }

    /// Starts the emulator's process with `kernel`, which it executes first, and further arguments.
    fn launch(kernel: &Path, devices: &[String], timed: bool, dir: PathBuf) -> Result<Self> {
        let listen = |name: &str| UnixListener::bind(dir.join(name));
        let listeners = [listen("link")?, listen("report")?, listen("qtest")?];
        let socket = |name: &str| format!("unix:{}", dir.join(name).display());
        let log = dir.join("log");
        File::create(&log)?;
        let errors = File::create(dir.join("stderr"))?;
        let mut child = Command::new(EMULATOR)
            .args([
                "-M",
                "netduinoplus2",
                "-display",
                "none",
                "-monitor",
                "none",
            ])
            // One instruction takes one nanosecond. Timers then run in the processor's own thread. This
            // makes them exact, and ten times faster than waking another thread for every step.
            .args(["-accel", "tcg", "-icount", "shift=0"])
            .args(["-serial", &socket("link"), "-serial", &socket("report")])
            .args(["-qtest", &socket("qtest"), "-qtest-log", "none"])
            .args(["-d", "unimp", "-D"])
            .arg(&log)
            .args(if timed {
                &["-trace", "systick_write", "-trace", "systick_read"][..]
            } else {
                &[]
            })
            .arg("-kernel")
            .arg(kernel)
            .args(devices)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(errors)
            .spawn()
            .with_context(|| EMULATOR)?;
        let streams = accept(&listeners, &mut child, &dir);
        let [link, report, qtest] = match streams {
            Ok(streams) => streams,
            Err(error) => {
                let _ = child.kill();
                let _ = child.wait();
                let _ = fs::remove_dir_all(&dir);
                return Err(error);
            }
        };
        Ok(Self {
            child,
            log: File::open(&log)?,
            dir,
            link,
            report,
            qtest,
            rest: Vec::new(),
        })
    }

    /// Fails if the emulator process has ended.
    pub fn check(&mut self) -> Result<()> {
        if let Some(status) = self.child.try_wait()? {
            bail!("{EMULATOR} ended with {status}: {}", stderr(&self.dir));
        }
        Ok(())
    }

    /// Sets an input pin to the logic level `level` (`true`: high), which injects an edge if the level changes.
    pub fn set(&mut self, input: Input, level: bool) -> Result<()> {
        let line = format!(
            "set_irq_in {EXTI} unnamed-gpio-in {} {}\n",
            input as u8,
            u8::from(level)
        );
        self.qtest.write_all(line.as_bytes())?;
        // The acknowledgements are discarded; they must not fill the socket.
        let mut sink = [0; 256];
        while read_some(&mut self.qtest, &mut sink)? > 0 {}
        Ok(())
    }

    /// Raises an interrupt of the chip by its number, or the non-maskable one if `number` is `None`.
    pub fn interrupt(&mut self, number: Option<u32>) -> Result<()> {
        let line = match number {
            Some(number) => format!("unnamed-gpio-in {number}"),
            None => "NMI 0".to_owned(),
        };
        // A pulse: a constant level would also interrupt the next boot.
        for level in [1, 0] {
            let command = format!("set_irq_in {NVIC} {line} {level}\n");
            self.qtest.write_all(command.as_bytes())?;
        }
        let mut sink = [0; 256];
        while read_some(&mut self.qtest, &mut sink)? > 0 {}
        Ok(())
    }

    /// Returns the complete lines added to the log since the last call.
    pub fn log_lines(&mut self) -> Result<String> {
        self.log.read_to_end(&mut self.rest)?;
        let Some(end) = self.rest.iter().rposition(|&b| b == b'\n') else {
            return Ok(String::new());
        };
        let whole: Vec<u8> = self.rest.drain(..=end).collect();
        Ok(String::from_utf8_lossy(&whole).into_owned())
    }
}

impl Drop for Qemu {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = fs::remove_dir_all(&self.dir);
    }
}

fn stderr(dir: &Path) -> String {
    let text = fs::read_to_string(dir.join("stderr")).unwrap_or_default();
    text.trim().to_owned()
}

/// Waits for the emulator's three connections: radar link, report port, test channel, in the order of `listeners`.
fn accept(listeners: &[UnixListener; 3], child: &mut Child, dir: &Path) -> Result<[UnixStream; 3]> {
    let deadline = Instant::now() + CONNECT;
    let mut one = |listener: &UnixListener| -> Result<UnixStream> {
        listener.set_nonblocking(true)?;
        loop {
            match listener.accept() {
                Ok((stream, _)) => {
                    stream.set_nonblocking(true)?;
                    return Ok(stream);
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => return Err(error.into()),
            }
            if let Some(status) = child.try_wait()? {
                bail!("{EMULATOR} ended with {status}: {}", stderr(dir));
            }
            if Instant::now() > deadline {
                bail!(
                    "{EMULATOR} did not connect within {CONNECT:?}: {}",
                    stderr(dir)
                );
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    };
    Ok([
        one(&listeners[0])?,
        one(&listeners[1])?,
        one(&listeners[2])?,
    ])
}

/// Reads the available bytes into `buffer` and returns their number; 0 if there are none.
pub fn read_some(stream: &mut UnixStream, buffer: &mut [u8]) -> Result<usize> {
    match stream.read(buffer) {
        Ok(n) => Ok(n),
        Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(0),
        Err(error) => Err(error.into()),
    }
}

/// Writes all bytes to a socket and waits for the receiver as long as necessary.
pub fn write_all(stream: &mut UnixStream, mut bytes: &[u8]) -> Result<()> {
    while !bytes.is_empty() {
        match stream.write(bytes) {
            Ok(n) => bytes = &bytes[n..],
            Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {
                std::thread::sleep(Duration::from_micros(200));
            }
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}
