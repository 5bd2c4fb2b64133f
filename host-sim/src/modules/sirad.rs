//! Model of a SiRad radar module at its serial port: commands in, frames out (format:
//! [`stairscan::signal::radar::sirad`]).

use std::cell::RefCell;
use std::collections::VecDeque;
use std::fmt;
use std::rc::Rc;

use stairscan::Iq;
use stairscan::scanner::BytePort;

/// One sample of the module's converter: I, then Q, 12 bits each.
pub type Sample = [i16; 2];

/// Factor between the codes of a 12-bit and of a 16-bit converter.
const SCALE: i16 = 16;

/// Fault of the module, for tests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fault {
    /// No fault.
    #[default]
    None,
    /// The module never answers.
    Silent,
    /// A measurement arrives only after the next request.
    Late,
    /// A measurement is sent twice.
    Repeat,
    /// The last bytes of a measurement are missing.
    Cut,
    /// One byte in the middle of a measurement is missing.
    Gap,
    /// The bytes of a measurement are wrong.
    Garbage,
    /// The module ignores the command that configures the baseband.
    IgnoresConfig,
    /// The module reports that its synthesiser does not lock.
    Error,
    /// The module also measures without a trigger.
    SelfTriggered,
}

/// Source of the samples of a measurement: the argument is their number; `None` means that there is
/// no measurement.
pub type Source<'a> = Box<dyn FnMut(usize) -> Option<Vec<Sample>> + 'a>;

/// Model of the SiRad module.
pub struct SiRadModel<'a> {
    source: Source<'a>,
    /// The fault that is active; it may be changed at any time.
    pub fault: Fault,
    system: u32,
    baseband: u32,
    ramp: u32,
    counter: u16,
    line: Vec<u8>,
    late: Vec<u8>,
    out: VecDeque<u8>,
    /// Number of triggered measurements so far.
    pub measured: u32,
}

impl fmt::Debug for SiRadModel<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SiRadModel after {} measurements", self.measured)
    }
}

impl<'a> SiRadModel<'a> {
    /// Creates a module in its state after power-up, in which it sends WebGUI frames and triggers
    /// itself; the model does neither. `source` supplies the samples.
    pub fn new(source: Source<'a>) -> Self {
        Self {
            source,
            fault: Fault::None,
            system: 0x0110_49BA,
            baseband: 0xB034_C125,
            ramp: 0x1388,
            counter: 0,
            line: Vec::new(),
            late: Vec::new(),
            out: VecDeque::new(),
            measured: 0,
        }
    }

    /// Returns the number of samples per chirp, as configured.
    pub fn samples(&self) -> usize {
        32 << (self.baseband >> 3 & 7)
    }

    /// Returns the swept bandwidth as configured, kHz.
    pub fn bandwidth_khz(&self) -> u32 {
        2_000 * self.ramp
    }

    /// Takes bytes that the scanner sends; commands end with CR LF.
    pub fn receive(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.line.push(byte);
            if self.line.ends_with(b"\r\n") {
                let line = std::mem::take(&mut self.line);
                self.command(&line[..line.len() - 2]);
            }
        }
    }

    /// Returns the next byte for the scanner; `None` if there is none.
    pub fn send(&mut self) -> Option<u8> {
        if self.fault == Fault::Silent {
            self.out.clear();
        }
        self.out.pop_front()
    }

    fn command(&mut self, line: &[u8]) {
        let late = std::mem::take(&mut self.late);
        self.out.extend(late);
        let text = std::str::from_utf8(line).unwrap_or_default();
        let Some(letter) = text.strip_prefix('!').and_then(|t| t.chars().next()) else {
            return;
        };
        match (
            letter,
            u32::from_str_radix(text.get(2..).unwrap_or_default(), 16),
        ) {
            ('S', Ok(bits)) => self.system = bits,
            ('B', Ok(bits)) if self.fault != Fault::IgnoresConfig => self.baseband = bits,
            ('P', Ok(bits)) => self.ramp = bits,
            ('I', _) => self
                .out
                .extend(b"!I0123456789ABCDEF01234567001D1381EBE0\r\n"),
            ('N', _) => self.measure(),
            _ => {}
        }
    }

    fn measure(&mut self) {
        self.measured += 1;
        let frames = self.system >> 4;
        let wanted = self.samples();
        let Some(samples) = (self.source)(wanted) else {
            return;
        };
        self.counter = self.counter.wrapping_add(1);
        let mut bytes = Vec::new();
        if frames & 0x40 != 0 {
            bytes.extend(format!("!U0\u{7f}00FF0AAA0072{:04X}0634\r\n", self.ramp).bytes());
        }
        let raw = match self.system >> 17 & 7 {
            1 => table(self.counter, &samples),
            2 => binary(self.counter, &samples),
            // The WebGUI output has no raw frame.
            _ => Vec::new(),
        };
        if frames & 1 != 0 {
            bytes.extend(self.with_fault(raw));
        }
        let late = self.fault == Fault::Late;
        match late {
            true => self.late = bytes,
            false => self.out.extend(bytes),
        }
    }

    /// Returns a raw frame as the active fault changes it.
    fn with_fault(&mut self, mut raw: Vec<u8>) -> Vec<u8> {
        let middle = raw.len() / 2;
        match self.fault {
            Fault::Cut => raw.truncate(middle),
            Fault::Gap => {
                raw.remove(middle);
            }
            Fault::Garbage => raw.iter_mut().for_each(|b| *b = b.wrapping_mul(37) ^ 0x5A),
            Fault::Repeat => raw.extend(raw.clone()),
            Fault::Error => raw = b"!E0004\r\n".to_vec(),
            Fault::SelfTriggered => {
                self.counter = self.counter.wrapping_add(1);
                let samples = vec![[0; 2]; self.samples()];
                raw.extend(binary(self.counter, &samples));
            }
            _ => {}
        }
        raw
    }
}

/// Returns a raw frame of the module's binary output.
pub fn binary(counter: u16, samples: &[Sample]) -> Vec<u8> {
    let mut out = vec![0xAA, 0xAA, 0xBB, 0xCC, b'M'];
    out.extend(counter.to_le_bytes());
    out.extend((2 * samples.len() as u16).to_le_bytes());
    out.extend(samples.iter().flatten().flat_map(|v| v.to_le_bytes()));
    out.extend(b"\r\n");
    out
}

/// Returns a raw frame of the module's TSV output (text).
pub fn table(counter: u16, samples: &[Sample]) -> Vec<u8> {
    let mut out = format!("!M\t{counter}\t{}", 2 * samples.len());
    for value in samples.iter().flatten() {
        out += &format!("\t{value}");
    }
    (out + "\r\n").into_bytes()
}

/// Converts a recorded chirp to the module's format: 12 bits, echoes at negative frequencies.
pub fn converted(chirp: &[Iq]) -> Vec<Sample> {
    let bits = |v: i16| {
        (i32::from(v) + i32::from(SCALE) / 2)
            .div_euclid(SCALE.into())
            .min(2047) as i16
    };
    chirp.iter().map(|s| [bits(s.q), bits(s.i)]).collect()
}

/// The scanner's end of the serial port of a module.
#[derive(Clone, Debug)]
pub struct SiRadPort<'a>(pub Rc<RefCell<SiRadModel<'a>>>);

impl<'a> SiRadPort<'a> {
    /// Creates a port to a new module with this source of samples.
    pub fn new(source: Source<'a>) -> Self {
        Self(Rc::new(RefCell::new(SiRadModel::new(source))))
    }
}

impl BytePort for SiRadPort<'_> {
    fn read(&mut self) -> Option<u8> {
        self.0.borrow_mut().send()
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        self.0.borrow_mut().receive(bytes);
        bytes.len()
    }
}

#[cfg(test)]
mod tests {
    use std::task::Poll;

    use stairscan::config::RadarConfig;
    use stairscan::scanner::Micros;
    use stairscan::signal::radar::module::{LinkError, ModuleKind, RequestedSettings};
    use stairscan::signal::radar::sirad::SiRad;

    use super::*;

    const TIMEOUT: u32 = 400_000;
    const REQUEST: RequestedSettings = RequestedSettings {
        kind: ModuleKind::SiRad,
        samples: 64,
        ..RequestedSettings::DEFAULT
    };

    struct Bench<'a> {
        module: SiRad,
        port: SiRadPort<'a>,
        now: u32,
    }

    impl<'a> Bench<'a> {
        /// Creates a port to a module whose samples are all the number of the measurement.
        fn new() -> Self {
            let mut number = 0;
            Self {
                module: SiRad::new(),
                port: SiRadPort::new(Box::new(move |samples| {
                    number += 1;
                    Some(vec![[number; 2]; samples])
                })),
                now: 0,
            }
        }

        fn inject(&mut self, fault: Fault) {
            self.port.0.borrow_mut().fault = fault;
        }

        fn program(&mut self) -> Result<RadarConfig, LinkError> {
            (self.module).program(&mut self.port, Micros(self.now), &REQUEST, TIMEOUT);
            loop {
                self.now += 1_000;
                let answer = self.module.settings(&mut self.port, Micros(self.now));
                if let Poll::Ready(answer) = answer {
                    return answer;
                }
            }
        }

        /// Requests a chirp and returns the number of the measurement that was received.
        fn chirp(&mut self) -> Result<i16, LinkError> {
            let mut samples = [Iq::default(); 64];
            (self.module).trigger(&mut self.port, Micros(self.now), 0, TIMEOUT);
            loop {
                self.now += 1_000;
                let answer = (self.module).poll(&mut self.port, Micros(self.now), &mut samples);
                if let Poll::Ready(answer) = answer {
                    return answer.map(|()| samples[20].i / SCALE);
                }
            }
        }
    }

    #[test]
    fn programmed_and_triggered() {
        let mut bench = Bench::new();
        let radar = bench.program().unwrap();
        assert_eq!((radar.samples, radar.bandwidth_khz), (64, 3_783_251));
        assert_eq!(bench.port.0.borrow().bandwidth_khz(), 6_000_000);
        for number in 2..10 {
            assert_eq!(bench.chirp(), Ok(number));
        }
    }

    #[test]
    fn what_goes_wrong_is_reported_and_mended() {
        for fault in [
            Fault::Silent,
            Fault::Late,
            Fault::Cut,
            Fault::Gap,
            Fault::Garbage,
            Fault::Error,
        ] {
            let mut bench = Bench::new();
            assert!(bench.program().is_ok());
            bench.inject(fault);
            let error = bench.chirp().unwrap_err();
            match fault {
                Fault::Error => assert_eq!(error, LinkError::Module(4)),
                Fault::Gap => assert!(matches!(error, LinkError::Frame(_) | LinkError::Timeout)),
                _ => assert_eq!(error, LinkError::Timeout, "{fault:?}"),
            }
            assert!(bench.chirp().is_err(), "{fault:?}");
            bench.inject(Fault::None);
            let measured = bench.port.0.borrow().measured;
            // The chirp belongs to the last trigger, never to an earlier one.
            assert_eq!(bench.chirp(), Ok(measured as i16 + 1), "{fault:?}");
        }
    }

    #[test]
    fn a_repeated_chirp_is_not_the_next_rows() {
        let mut bench = Bench::new();
        assert!(bench.program().is_ok());
        bench.inject(Fault::Repeat);
        for number in 2..6 {
            assert_eq!(bench.chirp(), Ok(number));
        }
    }

    #[test]
    fn a_module_that_is_not_set_up() {
        let programmed = |fault| {
            let mut bench = Bench::new();
            bench.inject(fault);
            bench.program()
        };
        assert_eq!(programmed(Fault::Silent), Err(LinkError::Timeout));
        assert_eq!(programmed(Fault::SelfTriggered), Err(LinkError::Sequence));
        assert_eq!(programmed(Fault::Error), Err(LinkError::Module(4)));
        // The WebGUI setting, of 512 samples.
        assert_eq!(programmed(Fault::IgnoresConfig), Err(LinkError::Answer));
    }

    #[test]
    fn a_chirp_comes_through_in_twelve_bits() {
        let chirp = [
            Iq::new(16_000, -160),
            Iq::new(32_767, i16::MIN),
            Iq::new(-9, 7),
        ];
        let samples = [[-10, 1000], [-2048, 2047], [0, -1]];
        assert_eq!(converted(&chirp), samples);
        assert_eq!(binary(1, &samples).len(), 5 + 4 + 12 + 2);
        assert!(table(1, &samples).ends_with(b"\t0\t-1\r\n"));
    }
}
