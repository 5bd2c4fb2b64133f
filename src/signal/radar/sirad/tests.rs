use std::prelude::v1::*;

use proptest::prelude::*;

use super::*;
use crate::signal::radar::module::ModuleKind;
use crate::testing::port::Port;

const TIMEOUT: u32 = 500_000;
const WISH: RequestedSettings = RequestedSettings {
    kind: ModuleKind::SiRad,
    ..RequestedSettings::DEFAULT
};

fn binary(counter: u16, values: &[i16]) -> Vec<u8> {
    let mut out = vec![0xAA, 0xAA, 0xBB, 0xCC, b'M'];
    out.extend(counter.to_le_bytes());
    out.extend((values.len() as u16).to_le_bytes());
    out.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    out.extend(b"\r\n");
    out
}

fn table(counter: u16, values: &[i16]) -> Vec<u8> {
    let mut out = format!("!M\t{counter}\t{}", values.len());
    for value in values {
        out += &format!("\t{value}");
    }
    (out + "\r\n").into_bytes()
}

/// A SiRad module and its serial port.
struct Bench {
    module: SiRad,
    port: Port,
    now: u32,
}

impl Default for Bench {
    fn default() -> Self {
        let mut port = Port::default();
        // A port that takes few bytes at once.
        port.wires.room = 5;
        Self {
            module: SiRad::default(),
            port,
            now: 0,
        }
    }
}

impl Bench {
    /// Returns a module that has been programmed for 32 samples.
    fn ready() -> Self {
        let mut bench = Self::default();
        assert!(bench.program(&WISH, &binary(0, &[0; 64])).is_ok());
        bench.port.device.clear();
        bench
    }

    fn settings(&mut self) -> Poll<Result<RadarConfig, LinkError>> {
        self.module.settings(&mut self.port, Micros(self.now))
    }

    fn program(
        &mut self,
        requested: &RequestedSettings,
        measured: &[u8],
    ) -> Result<RadarConfig, LinkError> {
        (self.module).program(&mut self.port, Micros(self.now), requested, TIMEOUT);
        for _ in 0..20 {
            assert!(self.settings().is_pending());
        }
        self.port.type_in(b"!Iwho\r\n");
        assert!(self.settings().is_pending());
        self.port.type_in(measured);
        for _ in 0..6 {
            if let Poll::Ready(result) = self.settings() {
                return result;
            }
            self.now += 100_000;
        }
        unreachable!("beyond the time-out")
    }

    fn trigger(&mut self) {
        (self.module).trigger(&mut self.port, Micros(self.now), 0, TIMEOUT);
    }

    fn poll(&mut self, bytes: &[u8], samples: &mut [Iq]) -> Poll<Result<(), LinkError>> {
        self.port.type_in(bytes);
        self.module.poll(&mut self.port, Micros(self.now), samples)
    }

    /// Triggers one chirp of 32 samples, whose answer is `bytes`.
    fn chirp(&mut self, bytes: &[u8]) -> Result<[Iq; 32], LinkError> {
        let mut samples = [Iq::default(); 32];
        self.trigger();
        if let Poll::Ready(result) = self.poll(bytes, &mut samples) {
            return result.map(|()| samples);
        }
        self.now += TIMEOUT;
        match self.poll(&[], &mut samples) {
            Poll::Ready(result) => result.map(|()| samples),
            Poll::Pending => unreachable!("beyond the time-out"),
        }
    }
}

fn ramp() -> [i16; 64] {
    core::array::from_fn(|k| k as i16 - 30)
}

#[test]
fn programmed_as_wished_and_measured() {
    let mut bench = Bench::default();
    let requested = RequestedSettings {
        bandwidth_khz: 5_000_000,
        samples: 130,
        ..WISH
    };
    let radar = bench.program(&requested, &binary(7, &[0; 256])).unwrap();
    assert_eq!(
        String::from_utf8(bench.port.device).unwrap(),
        "!S08047C10\r\n!B20000010\r\n!P000009C4\r\n!I\r\n!N\r\n"
    );
    // The duration of 128 samples of 165.5.
    assert_eq!(radar.bandwidth_khz, 3_867_069);
    assert_eq!(radar.samples, 128);
}

#[test]
fn the_module_has_the_last_word_on_its_bandwidth() {
    let status = |steps: &str| {
        let mut bytes = format!("!U0p00FF0AAA0072{steps}0010\r\n").into_bytes();
        bytes.extend(binary(0, &[0; 512]));
        bytes
    };
    let answer = |bytes: &[u8]| Bench::default().program(&WISH, bytes);
    let khz = |steps| answer(&status(steps)).map(|radar| radar.bandwidth_khz);
    let whole = |khz: u32| khz * 512 / 587;
    assert_eq!(khz("0BB8"), Ok(whole(6_000_000)));
    assert_eq!(khz("0A28"), Ok(whole(5_200_000)));
    for wrong in ["0000", "0BB9", "F448", "7FFF"] {
        assert_eq!(khz(wrong), Err(LinkError::Answer), "{wrong}");
    }
    // The frames in the other order.
    let mut late = binary(0, &[0; 512]);
    late.extend(b"!U0p00FF0AAA00720A280010\r\n");
    assert_eq!(answer(&late).unwrap().bandwidth_khz, whole(5_200_000));
}

#[test]
fn a_module_that_is_not_set_as_asked() {
    let answer = |bytes: &[u8]| Bench::default().program(&WISH, bytes);
    // The module triggers itself.
    let twice = [binary(0, &[0; 64]), binary(1, &[0; 64])].concat();
    assert_eq!(answer(&twice), Err(LinkError::Sequence));
    // 512 samples; half a sample; no samples at all.
    assert_eq!(answer(&binary(0, &[0; 1024])), Err(LinkError::Answer));
    assert_eq!(answer(&binary(0, &[0; 65])), Err(LinkError::Answer));
    assert_eq!(answer(&binary(0, &[])), Err(LinkError::Answer));
    // The synthesiser does not lock.
    assert_eq!(answer(b"!E0004\r\n"), Err(LinkError::Module(4)));
    assert_eq!(answer(b"!E00010000\r\n"), Err(LinkError::Module(255)));
    // Another frame.
    assert_eq!(answer(b"!R0200....\r\n"), Err(LinkError::Timeout));
    assert_eq!(answer(b""), Err(LinkError::Timeout));
}

#[test]
fn samples_in_both_formats() {
    let values = ramp();
    for frame in [binary, table] {
        let samples = Bench::ready().chirp(&frame(1, &values)).unwrap();
        for (k, sample) in samples.iter().enumerate() {
            let (i, q) = (values[2 * k], values[2 * k + 1]);
            assert_eq!(*sample, Iq::new(q * 16, i * 16));
        }
        let loud = [i16::MIN; 64];
        let samples = Bench::ready().chirp(&frame(1, &loud)).unwrap();
        assert!(samples.iter().all(|s| s.i <= -32767 && s.q <= -32767));
    }
}

#[test]
fn what_is_no_chirp_is_reported_by_its_kind() {
    let whole = binary(1, &ramp());
    let chirp = |bytes: &[u8]| Bench::ready().chirp(bytes).unwrap_err();
    assert_eq!(chirp(b""), LinkError::Timeout);
    assert_eq!(chirp(&whole[..100]), LinkError::Timeout);
    assert_eq!(chirp(&binary(1, &ramp()[..62])), LinkError::Answer);
    assert_eq!(chirp(&table(1, &[0; 66])), LinkError::Answer);
    assert_eq!(
        chirp(b"!M\t1\t64\t5\t6\r\n"),
        LinkError::Frame(FrameError::Crc)
    );
    assert_eq!(chirp(b"!M\t1\t2\t5\t6\t7\r\n"), LinkError::Answer);
    assert_eq!(chirp(b"!M\t1\tx"), LinkError::Frame(FrameError::Crc));
    assert_eq!(chirp(b"!E0009\r\n"), LinkError::Module(9));
    // A byte was lost: the end is not in its place.
    let mut short = whole.clone();
    short.remove(40);
    short.extend(&whole);
    assert_eq!(chirp(&short), LinkError::Frame(FrameError::Crc));
    // The frame of the first measurement, repeated.
    assert_eq!(chirp(&binary(0, &ramp())), LinkError::Sequence);
    // Error flags of zero, garbage before the frame, and another frame beside it.
    let mut beside = b"\xAA\xAA!E0000\r\n!U0p\r\n".to_vec();
    beside.extend(&whole);
    assert!(Bench::ready().chirp(&beside).is_ok());
}

#[test]
fn what_the_port_knows_to_be_damaged_is_no_chirp() {
    let mut bench = Bench::ready();
    bench.port.wires.errors = 3;
    bench.trigger();
    let mut samples = [Iq::default(); 32];
    assert!(bench.poll(&[], &mut samples).is_pending());
    bench.port.wires.errors = 4;
    assert_eq!(
        bench.poll(&binary(1, &ramp()), &mut samples),
        Poll::Ready(Err(LinkError::Frame(FrameError::Crc)))
    );
}

#[test]
fn a_late_chirp_is_never_taken_for_the_next() {
    let mut bench = Bench::ready();
    let mut samples = [Iq::default(); 32];
    assert_eq!(bench.chirp(&[]), Err(LinkError::Timeout));
    bench.port.device.clear();
    bench.trigger();
    // The late frame arrives before the module has answered the request after it.
    assert!(bench.poll(&binary(1, &[5; 64]), &mut samples).is_pending());
    assert_eq!(bench.port.device, b"!I\r\n");
    assert_eq!(samples, [Iq::default(); 32]);
    assert!(!bench.module.sent());
    let mut rest = b"!Iwho\r\n".to_vec();
    assert!(bench.poll(&rest, &mut samples).is_pending());
    assert_eq!(bench.port.device, b"!I\r\n!N\r\n");
    rest = binary(2, &ramp());
    assert_eq!(bench.poll(&rest, &mut samples), Poll::Ready(Ok(())));
    assert_eq!(samples[3], Iq::new(-23 * 16, -24 * 16));
    // Bytes between two triggers are discarded; nothing is requested after a complete answer.
    bench.port.device.clear();
    bench.port.type_in(binary(3, &[5; 64]));
    assert!(bench.chirp(&binary(4, &ramp())).is_ok());
    assert_eq!(bench.port.device, b"!N\r\n");
}

#[test]
fn a_chirp_that_is_given_up_is_waited_for_too() {
    let mut bench = Bench::ready();
    bench.trigger();
    bench.port.device.clear();
    assert_eq!(bench.chirp(&binary(1, &ramp())), Err(LinkError::Timeout));
    assert_eq!(bench.port.device, b"!I\r\n");
}

#[test]
fn the_mirror_stands_until_the_answer_has_begun() {
    let mut bench = Bench::ready();
    let frame = binary(1, &ramp());
    let mut samples = [Iq::default(); 32];
    assert!(bench.module.sent());
    bench.trigger();
    assert!(bench.poll(&frame[..8], &mut samples).is_pending());
    assert!(!bench.module.sent());
    assert!(bench.poll(&frame[8..9], &mut samples).is_pending());
    assert!(bench.module.sent());
    assert!(bench.poll(&frame[9..], &mut samples).is_ready());
    assert!(bench.module.sent());
}

#[test]
fn little_memory() {
    assert!(size_of::<SiRad>() <= 160, "{}", size_of::<SiRad>());
}

proptest! {
    #[test]
    fn no_byte_breaks_it(
        pieces in prop::collection::vec(
            prop_oneof![
                prop::collection::vec(any::<u8>(), 0..40),
                Just(vec![0xAA, 0xAA, 0xBB, 0xCC, b'M']),
                Just(b"!M\t1\t".to_vec()),
                Just(b"!I\r\n".to_vec()),
                Just(b"!U".to_vec()),
                prop::collection::vec(prop::sample::select(b"0123456789ABF\t-\r\n".to_vec()), 0..80),
                Just(binary(1, &ramp())),
            ],
            0..20,
        ),
        samples in 0usize..300,
        programs in any::<bool>(),
    ) {
        let mut bench = Bench::default();
        let mut chirp = vec![Iq::default(); samples];
        if programs {
            bench.module.program(&mut bench.port, Micros(0), &WISH, TIMEOUT);
        } else {
            bench.trigger();
        }
        for piece in pieces {
            bench.now += 50_000;
            let ready = if programs {
                bench.port.type_in(&piece);
                bench.settings().map_ok(|radar| prop_assert_ok(radar.validate().is_ok())).is_ready()
            } else {
                bench.poll(&piece, &mut chirp).is_ready()
            };
            if ready {
                break;
            }
        }
    }

    #[test]
    fn a_cut_frame_is_none(at in 0usize..139, table_form in any::<bool>()) {
        let frame = if table_form { table(1, &ramp()) } else { binary(1, &ramp()) };
        let mut bench = Bench::ready();
        prop_assert!(bench.chirp(&frame[..at.min(frame.len() - 1)]).is_err());
    }
}

fn prop_assert_ok(ok: bool) {
    assert!(ok, "settings that no scanner can work with");
}
