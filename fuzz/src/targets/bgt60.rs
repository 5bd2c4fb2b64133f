//! The answers of a BGT60TR13C over SPI: the chip's model, with faults and damaged bits.
//!
//! An operation is a byte with its arguments:
//!
//! | byte | arguments | operation |
//! |---|---|---|
//! | 0 | u32, u16, u16 | configures the chip: bandwidth, kHz, samples, timeout, ms |
//! | 1 | u8, u16 | triggers a chirp: number of pairs, timeout, ms |
//! | 2 | count, bytes | flips these bits of the next bytes read |
//! | 3 | u8, u8 | sets a fault of the chip, or none |
//! | 4 | u16 | advances the time, µs |

use std::task::Poll;

use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use host_sim::modules::bgt60::{Chip, Fault};
use stairscan::Iq;
use stairscan::scanner::Micros;
use stairscan::signal::radar::bgt60::Bgt60;
use stairscan::signal::radar::module::{ModuleKind, Wish};

use crate::input::Input;

/// Maximum length of a transfer, bytes: longer ones would delay the scanner's other work.
const LONGEST: usize = 52;

/// The chip's model with a bus that flips bits.
struct Wires {
    chip: Chip,
    flips: Vec<u8>,
}

impl ErrorType for Wires {
    type Error = ErrorKind;
}

impl SpiDevice for Wires {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        self.chip.transaction(operations)?;
        for operation in operations {
            let read: &mut [u8] = match operation {
                Operation::TransferInPlace(read) | Operation::Transfer(read, _) => read,
                Operation::Read(read) => read,
                _ => continue,
            };
            assert!(read.len() <= LONGEST, "{} bytes in one go", read.len());
            let flips = self.flips.len().min(read.len());
            for (byte, flip) in read.iter_mut().zip(self.flips.drain(..flips)) {
                *byte ^= flip;
            }
        }
        Ok(())
    }
}

/// Pending operation of the scanner.
#[derive(Clone, Copy, PartialEq)]
enum Waiting {
    Nothing,
    Settings,
    Chirp(usize),
}

fn fault(kind: u8, detail: u8) -> Option<Fault> {
    Some(match kind % 9 {
        0 => Fault::Absent(detail),
        1 => Fault::Identity(detail.into()),
        2 => Fault::Stuck(detail % 0x60),
        3 => Fault::NeverReady,
        4 => Fault::Overflow,
        5 => Fault::Short(detail.into()),
        6 => Fault::Clocks,
        7 => Fault::Port,
        _ => return None,
    })
}

/// Runs the operations.
pub fn run(data: &[u8]) {
    let mut wires = Wires {
        chip: Chip::new(),
        flips: Vec::new(),
    };
    let mut module = Bgt60::new();
    let mut now = Micros(u32::MAX - 50_000);
    let (mut until, mut waiting) = (now, Waiting::Nothing);
    let mut input = Input(data);
    while !input.is_empty() {
        match input.byte() % 5 {
            0 => {
                let wish = Wish {
                    kind: ModuleKind::Bgt60,
                    bandwidth_khz: input.word(),
                    samples: input.short(),
                    ..Wish::DEFAULT
                };
                let timeout = 1000 * u32::from(input.short()).max(1);
                (until, waiting) = (now.plus(timeout), Waiting::Settings);
                wires.chip.at(now);
                module.program(&mut wires, now, &wish, timeout);
            }
            1 => {
                let pairs = usize::from(input.byte()) + 1;
                let timeout = 1000 * u32::from(input.short()).max(1);
                (until, waiting) = (now.plus(timeout), Waiting::Chirp(pairs));
                wires.chip.at(now);
                module.trigger(&mut wires, now, -20_000, timeout);
            }
            2 => wires.flips = input.counted().to_vec(),
            3 => {
                let fault = fault(input.byte(), input.byte());
                wires.chip.set_fault(fault);
            }
            _ => now = now.plus(input.short().into()),
        }
        // One register for each call, and 16 words of the FIFO.
        for _ in 0..60 {
            wires.chip.at(now);
            let ready = match waiting {
                Waiting::Nothing => break,
                Waiting::Settings => module.settings(&mut wires, now).map(|settings| {
                    if let Ok(radar) = settings {
                        assert!(radar.real && radar.validate().is_ok(), "{radar:?}");
                    }
                }),
                Waiting::Chirp(pairs) => {
                    let mut samples = vec![Iq::default(); pairs];
                    module.poll(&mut wires, now, &mut samples).map(|_| ())
                }
            };
            match ready {
                Poll::Ready(()) => waiting = Waiting::Nothing,
                Poll::Pending => assert!(!now.reached(until), "waits for ever"),
            }
        }
    }
}
