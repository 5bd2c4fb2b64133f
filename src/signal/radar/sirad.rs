//! SiRad Easy and Simple, 120 GHz, as a radar module: raw I/Q over a serial port of 1 Mbaud.
//!
//! Sources: Silicon Radar, "SiRad Easy/Simple System & Protocol Description" 2.4 (firmware 1.4), and the
//! maker's wiki, "Output Modes 1.4". `docs/design/modules.md` lists the parts of them that were available, and the
//! facts taken from captures instead.
//!
//! The protocol does not identify the trigger that an answer belongs to, has no checksum, and does not specify
//! the delay from a trigger to the chirp. The mirror therefore stops until an answer begins. After any failure
//! no trigger is sent before the module has answered a request for its info, which follows all earlier
//! triggers: all their answers have then been received and discarded.
//!
//! The module does not acknowledge commands either. A first measurement shows whether they were executed: by
//! the length of its answer, by the status frame beside it, and by the absence of a second answer without a
//! trigger.

mod command;
mod reader;
#[cfg(test)]
mod tests;

use core::task::Poll;

use super::module::{FrameError, LinkError, RequestedSettings};
use crate::Iq;
use crate::config::{MAX_SAMPLES, RadarConfig, SAMPLES};
use crate::port::{BytePort, MAX_READ};
use crate::time::Micros;
pub use reader::{Reader, ReaderEvent};

/// Time without a frame that shows that the module does not trigger itself, microseconds: its maximum pause is
/// 128 ms, and a measurement takes some 16 ms.
const ALONE_US: u32 = 160_000;
/// Centre of the chip's band, kHz, which is taken as the carrier.
const CARRIER_KHZ: u32 = 122_500_000;
/// Duration of the ramp beyond the sampled part, in half sample intervals. Measured (`docs/design/modules.md`).
const UNSAMPLED_HALVES: u32 = 75;
/// Factor from 12-bit samples to full scale.
const SCALE: i16 = 16;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum SiRadStage {
    /// No request is pending.
    #[default]
    Idle,
    /// The answer to [`command::INFO`] is pending; everything before it belongs to earlier requests.
    Barrier,
    /// The raw frame is pending.
    Raw,
    /// The raw frame has been received; a second one would be an error.
    Alone,
}

/// Protocol of a SiRad module. Each call is given the serial port.
#[derive(Debug)]
pub struct SiRad {
    reader: Reader,
    out: heapless::Vec<u8, 48>,
    sent: usize,
    stage: SiRadStage,
    deadline: Micros,
    /// Whether the last request failed, so that answers to it may still arrive.
    resync_needed: bool,
    /// The port's count of damaged bytes at the time of the trigger, to detect those of the answer.
    errors: u16,
    /// Counter of the last accepted raw frame.
    counter: Option<u16>,
    /// Bandwidth that was requested, or that the module reported, kHz.
    bandwidth_khz: u32,
    /// Number of values (I and Q counted separately) of the raw frame that the first measurement gave.
    count: u16,
    /// Time at which the raw frame of the first measurement ended.
    frame_end: Micros,
}

impl SiRad {
    /// Creates a module in an unknown state.
    pub const fn new() -> Self {
        Self {
            reader: Reader::new(),
            out: heapless::Vec::new(),
            sent: 0,
            stage: SiRadStage::Idle,
            deadline: Micros(0),
            resync_needed: false,
            errors: 0,
            counter: None,
            bandwidth_khz: 0,
            count: 0,
            frame_end: Micros(0),
        }
    }

    /// Sets the module up as requested, and starts one measurement. The bandwidth is at most 7 GHz, the maker's
    /// band. The number of samples is 32, 64, 128 or 256: no more than requested, but at least 32.
    pub fn program(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        requested: &RequestedSettings,
        timeout_us: u32,
    ) {
        self.bandwidth_khz = match requested.bandwidth_khz {
            0 => command::USUAL_KHZ,
            khz => khz.clamp(command::STEP_KHZ, command::MAX_KHZ),
        };
        self.counter = None;
        self.begin(port, now, timeout_us);
        self.stage = SiRadStage::Barrier;
        for line in [
            command::system(),
            command::baseband(command::code(requested.samples)),
            command::ramp(self.bandwidth_khz),
        ] {
            // The buffer has room for all of them.
            let _ = self.out.extend_from_slice(&line);
        }
        self.send(port, command::INFO);
    }

    /// Returns the answer to [`SiRad::program`]. The bandwidth is that from the first sample to the last.
    pub fn settings(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
    ) -> Poll<Result<RadarConfig, LinkError>> {
        let Poll::Ready(answer) = self.advance(port, now, None) else {
            return Poll::Pending;
        };
        Poll::Ready(answer.and_then(|()| self.measured_settings()))
    }

    /// Triggers one chirp. The angle is not sent.
    pub fn trigger(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        _shaft_angle: i32,
        timeout_us: u32,
    ) {
        let resync = self.resync_needed;
        self.begin(port, now, timeout_us);
        if resync {
            self.stage = SiRadStage::Barrier;
            self.send(port, command::INFO);
        } else {
            self.fire(port);
        }
    }

    /// Receives the answer to [`SiRad::trigger`]: as many samples as `samples` holds. They are written as they
    /// arrive, so that after an error some of them may belong to another chirp.
    pub fn poll(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        samples: &mut [Iq],
    ) -> Poll<Result<(), LinkError>> {
        self.advance(port, now, Some(samples))
    }

    /// Returns whether the answer has begun: from then on the mirror must stand for the duration of a chirp at
    /// most.
    pub fn sent(&self) -> bool {
        match self.stage {
            SiRadStage::Idle | SiRadStage::Alone => true,
            SiRadStage::Raw => self.reader.in_raw(),
            SiRadStage::Barrier => false,
        }
    }

    /// Discards everything received so far, and begins a request.
    fn begin(&mut self, port: &mut impl BytePort, now: Micros, timeout_us: u32) {
        port.drain();
        self.reader = Reader::new();
        self.out.clear();
        self.sent = 0;
        self.deadline = now.plus(timeout_us);
        self.resync_needed = true;
    }

    /// Triggers a measurement and waits for its raw frame.
    fn fire(&mut self, port: &mut impl BytePort) {
        self.stage = SiRadStage::Raw;
        self.errors = port.errors();
        self.out.clear();
        self.sent = 0;
        self.send(port, command::TRIGGER);
    }

    fn send(&mut self, port: &mut impl BytePort, bytes: &[u8]) {
        let _ = self.out.extend_from_slice(bytes);
        self.pump(port);
    }

    /// Passes to the port as much of the output as the port takes.
    fn pump(&mut self, port: &mut impl BytePort) {
        let rest = self.out.get(self.sent..).unwrap_or(&[]);
        if !rest.is_empty() {
            self.sent += port.write(rest);
        }
    }

    /// Reads until there is a result or no byte left, or [`MAX_READ`] bytes have been read. `samples` is
    /// `None` for the first measurement.
    fn advance(
        &mut self,
        port: &mut impl BytePort,
        now: Micros,
        mut samples: Option<&mut [Iq]>,
    ) -> Poll<Result<(), LinkError>> {
        self.pump(port);
        if self.stage == SiRadStage::Idle {
            return Poll::Ready(Err(LinkError::Timeout));
        }
        for _ in 0..MAX_READ {
            let Some(byte) = port.read() else { break };
            let Some(event) = self.reader.push(byte) else {
                continue;
            };
            if self.stage == SiRadStage::Barrier {
                if event == ReaderEvent::Info {
                    self.fire(port);
                }
                continue;
            }
            let result = self.take(port, now, event, samples.as_deref_mut());
            if let Some(result) = result {
                return self.finish(result);
            }
        }
        if self.stage == SiRadStage::Alone && now.reached(self.frame_end.plus(ALONE_US)) {
            return self.finish(Ok(()));
        }
        if now.reached(self.deadline) {
            return self.finish(Err(LinkError::Timeout));
        }
        Poll::Pending
    }

    fn finish(&mut self, result: Result<(), LinkError>) -> Poll<Result<(), LinkError>> {
        self.stage = SiRadStage::Idle;
        self.resync_needed = result.is_err();
        Poll::Ready(result)
    }

    /// Processes an event of the received bytes after the trigger. Returns the result that ends the request;
    /// `None` while it is pending.
    fn take(
        &mut self,
        port: &impl BytePort,
        now: Micros,
        event: ReaderEvent,
        samples: Option<&mut [Iq]>,
    ) -> Option<Result<(), LinkError>> {
        match event {
            ReaderEvent::Value(at, value) => {
                if let Some(sample) = samples.and_then(|s| s.get_mut(usize::from(at / 2))) {
                    put(sample, at, value);
                }
                None
            }
            ReaderEvent::Raw { counter, count } => self.raw(port, now, counter, count, samples),
            ReaderEvent::Broken => Some(Err(LinkError::Frame(FrameError::Crc))),
            ReaderEvent::Bandwidth(steps) => {
                let reported_khz = u32::try_from(steps).unwrap_or(0) * command::STEP_KHZ;
                if samples.is_none() {
                    // A value above the requested bandwidth is invalid: the frame then has another format than
                    // assumed.
                    self.bandwidth_khz = if reported_khz <= self.bandwidth_khz {
                        reported_khz
                    } else {
                        0
                    };
                }
                None
            }
            ReaderEvent::Error(0) | ReaderEvent::Info => None,
            ReaderEvent::Error(flags) => Some(Err(LinkError::Module(match flags as u8 {
                0 => u8::MAX,
                flags => flags,
            }))),
        }
    }

    /// Processes the end of a raw frame of `count` values with this counter. Returns the result that ends the request; `None` if
    /// it stays pending.
    fn raw(
        &mut self,
        port: &impl BytePort,
        now: Micros,
        counter: u16,
        count: u16,
        samples: Option<&mut [Iq]>,
    ) -> Option<Result<(), LinkError>> {
        if port.errors() != self.errors {
            return Some(Err(LinkError::Frame(FrameError::Crc)));
        }
        if self.stage == SiRadStage::Alone || self.counter == Some(counter) {
            return Some(Err(LinkError::Sequence));
        }
        self.counter = Some(counter);
        match samples {
            Some(samples) if usize::from(count) == 2 * samples.len() => Some(Ok(())),
            Some(_) => Some(Err(LinkError::Answer)),
            None => {
                (self.stage, self.count, self.frame_end) = (SiRadStage::Alone, count, now);
                None
            }
        }
    }

    /// Returns the radar settings that the first measurement shows: the number of its samples, and the
    /// bandwidth between the first one and the last.
    fn measured_settings(&self) -> Result<RadarConfig, LinkError> {
        let samples = self.count / 2;
        if !self.count.is_multiple_of(2) || !SAMPLES.contains(&samples) || self.bandwidth_khz == 0 {
            return Err(LinkError::Answer);
        }
        let halves = 2 * u32::from(samples);
        Ok(RadarConfig {
            carrier_khz: CARRIER_KHZ,
            // At most 7 × 10^6 times 512, which is below 2^32.
            bandwidth_khz: self.bandwidth_khz * halves / (halves + UNSAMPLED_HALVES),
            samples,
            real: false,
        })
    }
}

const _: () = assert!(2 * MAX_SAMPLES as u64 * command::MAX_KHZ as u64 <= u32::MAX as u64);

impl Default for SiRad {
    fn default() -> Self {
        Self::new()
    }
}

/// Writes value `at` of a raw frame (I, Q, I, Q …) into its sample. The module's beat signal has the opposite
/// sense of rotation: I and Q are exchanged so that a greater range is a higher frequency.
fn put(sample: &mut Iq, at: u16, value: i16) {
    let value = value.saturating_mul(SCALE);
    match at % 2 {
        0 => sample.q = value,
        _ => sample.i = value,
    }
}
