//! Tests of the BGT60TR13C's driver with a model of the chip.

use std::task::Poll;

use host_sim::modules::bgt60::{self, Chip, Fault};
use host_sim::recording::Truth;
use host_sim::scene::spec::SceneSpec;
use stairscan::Iq;
use stairscan::config::{Config, RadarConfig};
use stairscan::pipeline::Pipeline;
use stairscan::scanner::DataPath;
use stairscan::scanner::Micros;
use stairscan::signal::radar::LinkError;
use stairscan::signal::radar::bgt60::{
    Bgt60, FIFO_FAILED, PORT_FAILED, SPI_FAILED, VERIFY_FAILED, WRONG_CHIP,
};
use stairscan::signal::radar::module::{ModuleKind, RequestedSettings};
use stairscan::verdict::Outcome;

/// Defaults of the scanner's settings.
const CONFIGURE_US: u32 = 100_000;
const CHIRP_US: u32 = 50_000;
/// Polling interval.
const STEP_US: u32 = 10;
const WISH: RequestedSettings = RequestedSettings {
    kind: ModuleKind::Bgt60,
    ..RequestedSettings::DEFAULT
};

/// Scanner and chip with a common clock, which wraps during the test.
struct Rig {
    module: Bgt60,
    chip: Chip,
    now: Micros,
}

impl Rig {
    fn new(chip: Chip) -> Self {
        Self {
            module: Bgt60::new(),
            chip,
            now: Micros(u32::MAX - 5_000),
        }
    }

    fn wait<T>(&mut self, mut poll: impl FnMut(&mut Bgt60, &mut Chip, Micros) -> Poll<T>) -> T {
        for _ in 0..2 * CONFIGURE_US / STEP_US {
            self.now = self.now.plus(STEP_US);
            self.chip.at(self.now);
            if let Poll::Ready(answer) = poll(&mut self.module, &mut self.chip, self.now) {
                return answer;
            }
        }
        panic!("no answer")
    }

    fn program(&mut self, requested: &RequestedSettings) -> Result<RadarConfig, LinkError> {
        let Self { module, chip, now } = self;
        module.program(chip, *now, requested, CONFIGURE_US);
        self.wait(|module, chip, now| module.settings(chip, now))
    }

    fn chirp(&mut self, pairs: u16) -> Result<Vec<Iq>, LinkError> {
        let Self { module, chip, now } = self;
        module.trigger(chip, *now, 0, CHIRP_US);
        let mut samples = vec![Iq::default(); pairs.into()];
        self.wait(|module, chip, now| module.poll(chip, now, &mut samples))?;
        Ok(samples)
    }
}

/// A pattern without equal samples.
fn pattern(samples: usize) -> Vec<u16> {
    (0..samples).map(|k| 3 + 7 * k as u16 % 4000).collect()
}

fn as_pairs(codes: &[u16]) -> Vec<Iq> {
    let left = |code: u16| (code as i16 - 2048) << 4;
    let pairs = codes.chunks_exact(2);
    pairs.map(|p| Iq::new(left(p[0]), left(p[1]))).collect()
}

#[test]
fn the_chip_sweeps_what_the_scanner_is_commanded() {
    for (bandwidth_khz, samples) in [(0, 0), (4_000_000, 200), (1_000_000, 64), (0, 256), (0, 16)] {
        let mut rig = Rig::new(Chip::new());
        let requested = RequestedSettings {
            bandwidth_khz,
            samples,
            ..WISH
        };
        let radar = rig.program(&requested).unwrap();
        let chirp = rig.chip.chirp();
        println!("{radar:?} {chirp:?}");
        assert!((chirp.bandwidth_hz() - 1e3 * f64::from(radar.bandwidth_khz)).abs() < 2e3);
        assert!((chirp.carrier_hz() - 1e3 * f64::from(radar.carrier_khz)).abs() < 1e6);
        assert_eq!(chirp.samples, 2 * usize::from(radar.samples));
        assert!(radar.real && radar.validate().is_ok());
        // Limits of tables 54 and 64.
        assert!(58.0e9 < chirp.ramp_hz[0] && chirp.ramp_hz[1] < 63.5e9);
        assert!(chirp.first_hz > chirp.ramp_hz[0] && chirp.rate_hz <= 4e6);
        // The beat of an echo from 3.2 m is below the anti-alias filter's minimum cutoff (table 58).
        let beat = 2.0 * 3.2 / 299_792_458.0 * chirp.step_hz * chirp.rate_hz;
        assert!(beat < 450e3, "{beat}");
        assert!(chirp.duration_s < 2e-3);
        if bandwidth_khz == 0 {
            assert!(radar.bandwidth_khz > 5_200_000, "{radar:?}");
        }
    }
}

#[test]
fn chirps_come_whole_and_one_by_one() {
    for samples in [0, 16, 17, 100, 256] {
        let mut rig = Rig::new(Chip::new());
        let radar = rig.program(&RequestedSettings { samples, ..WISH }).unwrap();
        for turn in 0..3 {
            let mut codes = pattern(2 * usize::from(radar.samples));
            codes.rotate_left(turn);
            rig.chip.echo.clone_from(&codes);
            assert_eq!(rig.chirp(radar.samples), Ok(as_pairs(&codes)));
        }
    }
}

#[test]
fn nothing_of_a_chirp_that_was_given_up_is_left() {
    let mut rig = Rig::new(Chip::new());
    let radar = rig.program(&WISH).unwrap();
    let codes = pattern(256);
    rig.chip.echo = vec![100; 256];
    // The scanner triggers again before, while and after the first chirp is delivered.
    for later in [500, 1_500, 30_000] {
        rig.module.trigger(&mut rig.chip, rig.now, 0, CHIRP_US);
        rig.now = rig.now.plus(later);
        rig.chip.at(rig.now);
        rig.chip.echo.clone_from(&codes);
        assert_eq!(rig.chirp(radar.samples), Ok(as_pairs(&codes)));
    }
}

#[test]
fn the_chip_is_left_alone_while_it_samples() {
    let mut rig = Rig::new(Chip::new());
    rig.program(&WISH).unwrap();
    rig.module.trigger(&mut rig.chip, rig.now, 0, CHIRP_US);
    let transfers = rig.chip.transfers;
    let over = rig.now.plus((1e6 * rig.chip.chirp().duration_s) as u32);
    let mut samples = vec![Iq::default(); 128];
    while !rig.now.reached(over) {
        assert!(
            rig.module
                .poll(&mut rig.chip, rig.now, &mut samples)
                .is_pending()
        );
        // The mirror must not move on either.
        assert!(!rig.module.sent());
        rig.now = rig.now.plus(1);
    }
    assert_eq!(rig.chip.transfers, transfers);
    rig.wait(|module, chip, now| module.poll(chip, now, &mut samples))
        .unwrap();
    assert!(rig.module.sent());
}

#[test]
fn what_clips_stands_at_full_scale() {
    let mut rig = Rig::new(Chip::new());
    rig.program(&WISH).unwrap();
    rig.chip.echo = [0, 0xfff, 1, 0xffe].repeat(64);
    let chirp = rig.chirp(128).unwrap();
    assert_eq!(chirp[0], Iq::new(i16::MIN, i16::MAX));
    assert_eq!(chirp[1], Iq::new(i16::MIN, 32_736));
}

#[test]
fn what_is_wrong_at_set_up_is_reported() {
    let module = LinkError::Module;
    let stuck = |address| (Fault::Stuck(address), module(VERIFY_FAILED));
    let cases = [
        (Fault::Absent(0xff), module(WRONG_CHIP)),
        (Fault::Absent(0x00), module(WRONG_CHIP)),
        // The identity of a BGT60UTR11AIP.
        (Fault::Identity(0x00_0707), module(WRONG_CHIP)),
        (Fault::Port, module(PORT_FAILED)),
        stuck(0x01),
        stuck(0x04),
        stuck(0x11),
        stuck(0x2e),
        stuck(0x30),
        stuck(0x37),
    ];
    for (fault, error) in cases {
        let mut rig = Rig::new(Chip::with(fault));
        assert_eq!(rig.program(&WISH), Err(error), "{fault:?}");
        // The next attempt works.
        rig.chip.set_fault(None);
        assert!(rig.program(&WISH).is_ok(), "after {fault:?}");
    }
}

#[test]
fn what_is_wrong_with_a_chirp_is_reported() {
    let module = LinkError::Module;
    let cases = [
        (Fault::Absent(0x00), LinkError::Timeout),
        // All error bits of FSTAT are set, and a reset does not clear them.
        (Fault::Absent(0xff), module(VERIFY_FAILED)),
        (Fault::Port, module(PORT_FAILED)),
        (Fault::NeverReady, LinkError::Timeout),
        (Fault::Overflow, module(FIFO_FAILED)),
        (Fault::Short(0), module(FIFO_FAILED)),
        (Fault::Short(20), module(FIFO_FAILED)),
        // Short by one word only: no other piece follows.
        (Fault::Short(127), module(FIFO_FAILED)),
        (Fault::Clocks, module(SPI_FAILED)),
    ];
    for (fault, error) in cases {
        let mut rig = Rig::new(Chip::new());
        rig.program(&WISH).unwrap();
        rig.chip.set_fault(Some(fault));
        assert_eq!(rig.chirp(128), Err(error), "{fault:?}");
        // The next chirps are delivered: a glitch fails one. The chip keeps its error until a reset.
        rig.chip.set_fault(None);
        let codes = pattern(256);
        rig.chip.echo.clone_from(&codes);
        for _ in 0..3 {
            assert_eq!(rig.chirp(128), Ok(as_pairs(&codes)), "after {fault:?}");
        }
    }
}

#[test]
fn a_chirp_of_another_length_is_none() {
    let mut rig = Rig::new(Chip::new());
    rig.program(&WISH).unwrap();
    assert_eq!(rig.chirp(100), Err(LinkError::Answer));
}

/// Scans a staircase with the driver, row by row, and the firmware's pipeline. Returns the result for `scene`,
/// behind a lens with a beam of 5 degrees, and the ground truth.
fn scanned(scene: &str, seed: u64) -> (Outcome, Truth) {
    let mut rig = Rig::new(Chip::new());
    let radar = rig.program(&WISH).unwrap();
    let config = Config {
        radar,
        ..Config::default()
    };
    let spec: SceneSpec = toml::from_str(scene).unwrap();
    let (recording, rows) = bgt60::chirps(&spec, &rig.chip.chirp(), seed).unwrap();
    assert_eq!(rows.len(), usize::from(config.sweep.angle_count));
    let mut pipeline = Box::new(Pipeline::new());
    pipeline.begin(&config, 1).unwrap();
    for (row, codes) in (0..).zip(rows) {
        rig.chip.echo = codes;
        let chirp = rig.chirp(radar.samples).unwrap();
        pipeline.samples().copy_from_slice(&chirp);
        pipeline.row(row);
    }
    (pipeline.finish(), recording.meta.truth.unwrap())
}

#[test]
fn the_first_step_stands_where_it_is() {
    for seed in 0..3 {
        let (outcome, truth) = scanned(include_str!("../../../scenes/stair_a.toml"), seed);
        println!("{outcome:?}");
        let (found, step) = (&outcome.answer.steps[0], &truth.steps[0]);
        let off = |found: f32, true_m: f64| (f64::from(found) - true_m).abs();
        assert!(off(found.distance_m, step.distance_m) < 0.015);
        assert!(off(found.height_m, step.height_m) < 0.015);
    }
}
