//! Input from a SiRad: arbitrary bytes, complete frames, answers to requests, silence.
//!
//! An operation is a byte with its arguments:
//!
//! | byte | arguments | operation |
//! |---|---|---|
//! | 0 | u32, u16, u16 | configures the module: bandwidth, kHz, samples, timeout, ms |
//! | 1 | u16 | the scanner triggers a chirp of 32 samples, with this timeout, ms |
//! | 2 | count, bytes | delivers these bytes |
//! | 3 | u16, count, numbers | delivers a binary raw frame with this counter and number of values |
//! | 4 | u16, count, numbers | delivers the same as a table |
//! | 5 | | delivers the module's identity |
//! | 6 | u16 | advances the time, ms |

use std::task::Poll;

use host_sim::modules::sirad::{binary, table};
use stairscan::Iq;
use stairscan::scanner::Micros;
use stairscan::signal::radar::module::{ModuleKind, RequestedSettings};
use stairscan::signal::radar::sirad::SiRad;
use testbed::Port;

use crate::input::Input;

/// Number of samples of the requested chirps.
const SAMPLES: usize = 32;
/// Command that triggers a measurement.
const TRIGGER: &[u8] = b"!N\r\n";

/// Size of the scanner's input buffer, bytes; further bytes are lost and counted.
const ROOM: usize = 2047;

/// Pending request of the scanner.
#[derive(Clone, Copy, PartialEq)]
enum Waiting {
    Nothing,
    Settings,
    Chirp,
}

struct Bench {
    module: SiRad,
    port: Port,
    now: Micros,
    until: Micros,
    waiting: Waiting,
    /// Whether arbitrary bytes have been delivered since the module was created.
    noise: bool,
    /// Whether a complete raw frame of [`SAMPLES`] has been delivered since this request's trigger
    /// was sent.
    answered: bool,
}

impl Bench {
    fn begin(&mut self, waiting: Waiting, timeout_ms: u16) -> u32 {
        let timeout = 1000 * u32::from(timeout_ms).max(1);
        self.until = self.now.plus(timeout);
        self.waiting = waiting;
        self.port.device.clear();
        self.answered = false;
        timeout
    }

    fn frame(&mut self, bytes: &[u8], numbers: usize) {
        let fired = self.port.device.ends_with(TRIGGER);
        self.answered |= fired && numbers == 2 * SAMPLES && self.waiting == Waiting::Chirp;
        self.port.type_in(bytes);
    }

    fn poll(&mut self) {
        let ready = match self.waiting {
            Waiting::Nothing => return,
            Waiting::Settings => {
                let answer = self.module.settings(&mut self.port, self.now);
                answer.map(|settings| {
                    if let Ok(radar) = settings {
                        assert!(radar.bandwidth_khz > 0 && !radar.real, "{radar:?}");
                    }
                })
            }
            Waiting::Chirp => {
                let mut samples = [Iq::default(); SAMPLES];
                let answer = self.module.poll(&mut self.port, self.now, &mut samples);
                answer.map(|chirp| {
                    let may_answer = self.noise || self.answered;
                    assert!(
                        chirp.is_err() || may_answer,
                        "a chirp from before the trigger"
                    );
                })
            }
        };
        match ready {
            Poll::Ready(()) => self.waiting = Waiting::Nothing,
            Poll::Pending if self.port.wires.incoming.is_empty() => {
                assert!(!self.now.reached(self.until), "waits for ever");
            }
            Poll::Pending => {}
        }
    }
}

/// Returns `count` values of a raw frame from the remaining bytes.
fn numbers(input: &mut Input<'_>, count: u8) -> Vec<[i16; 2]> {
    let bytes = input.bytes(4);
    let value = |k: usize| i16::from(bytes.get(k % bytes.len().max(1)).copied().unwrap_or(0));
    // At most 64 for the chirp, and some more.
    let pairs = usize::from(count % 80) / 2;
    (0..pairs)
        .map(|k| [value(2 * k) - 128, value(2 * k + 1) - 128])
        .collect()
}

/// Runs the operations.
pub fn run(data: &[u8]) {
    let mut port = Port::default();
    port.wires.capacity = ROOM;
    // Commands are sent in pieces.
    port.wires.room = 5;
    let mut bench = Bench {
        module: SiRad::new(),
        port,
        now: Micros(u32::MAX - 500_000),
        until: Micros(0),
        waiting: Waiting::Nothing,
        noise: false,
        answered: false,
    };
    let mut input = Input(data);
    while !input.is_empty() {
        match input.byte() % 7 {
            0 => {
                let requested = RequestedSettings {
                    kind: ModuleKind::SiRad,
                    bandwidth_khz: input.word(),
                    samples: input.short(),
                    ..RequestedSettings::DEFAULT
                };
                let timeout = bench.begin(Waiting::Settings, input.short());
                let (module, port) = (&mut bench.module, &mut bench.port);
                module.program(port, bench.now, &requested, timeout);
            }
            1 => {
                let timeout = bench.begin(Waiting::Chirp, input.short());
                let (module, port) = (&mut bench.module, &mut bench.port);
                module.trigger(port, bench.now, -20_000, timeout);
            }
            2 => {
                bench.noise = true;
                bench.port.type_in(input.counted());
            }
            op @ (3 | 4) => {
                let (counter, count) = (input.short(), input.byte());
                let samples = numbers(&mut input, count);
                let bytes = match op {
                    3 => binary(counter, &samples),
                    _ => table(counter, &samples),
                };
                bench.frame(&bytes, 2 * samples.len());
            }
            5 => bench.port.type_in(b"!IDocile\r\n"),
            _ => bench.now = bench.now.plus(1000 * u32::from(input.short())),
        }
        // Commands that are sent in pieces need several calls.
        for _ in 0..12 {
            bench.poll();
        }
    }
}
