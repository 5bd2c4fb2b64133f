//! Tests of one scanner with three radar modules: each setting uses the module's own protocol.

use std::cell::Cell;
use std::rc::Rc;
use std::task::Poll;

use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use host_sim::modules::bgt60::Chip;
use host_sim::modules::sirad::SiRadPort;
use stairscan::Iq;
use stairscan::config::RadarConfig;
use stairscan::scanner::{BytePort, Micros};
use stairscan::signal::radar::LinkError;
use stairscan::signal::radar::any::AnyModule;
use stairscan::signal::radar::frame::Ability;
use stairscan::signal::radar::module::{ModuleKind, RadarModule, RequestedSettings};
use testbed::{FramedModule, Port};

const TIMEOUT_US: u32 = 500_000;
const STEP_US: u32 = 20;
/// Shaft angle of the triggers, 0.001°, and the samples of a chirp there by the module with frames.
const ANGLE: i32 = -262_127;
const TOLD: Iq = Iq { i: 17, q: -4 };

/// The connected module, and the time.
#[derive(Clone)]
struct Bench {
    plugged: Rc<Cell<ModuleKind>>,
    now: Rc<Cell<Micros>>,
}

/// The serial port: a module with frames, or a SiRad.
struct Line<'a> {
    bench: Bench,
    sirad: SiRadPort<'a>,
    framed: Port<FramedModule>,
}

impl BytePort for Line<'_> {
    fn read(&mut self) -> Option<u8> {
        match self.bench.plugged.get() {
            ModuleKind::Pstr => self.framed.read(),
            ModuleKind::SiRad => self.sirad.read(),
            ModuleKind::Bgt60 => None,
        }
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        match self.bench.plugged.get() {
            ModuleKind::Pstr => self.framed.write(bytes),
            ModuleKind::SiRad => self.sirad.write(bytes),
            ModuleKind::Bgt60 => bytes.len(),
        }
    }
}

/// The SPI port: the chip, or nothing.
struct Spi {
    bench: Bench,
    chip: Chip,
}

impl ErrorType for Spi {
    type Error = <Chip as ErrorType>::Error;
}

impl SpiDevice<u8> for Spi {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        if self.bench.plugged.get() == ModuleKind::Bgt60 {
            self.chip.at(self.bench.now.get());
            return self.chip.transaction(operations);
        }
        for operation in operations {
            if let Operation::Read(words) | Operation::Transfer(words, _) = operation {
                words.fill(0xff);
            }
        }
        Ok(())
    }
}

impl Bench {
    fn wait<T>(
        &self,
        mut poll: impl FnMut(Micros) -> Poll<Result<T, LinkError>>,
    ) -> Result<T, LinkError> {
        for _ in 0..3 * TIMEOUT_US / STEP_US {
            self.now.set(self.now.get().plus(STEP_US));
            if let Poll::Ready(answer) = poll(self.now.get()) {
                return answer;
            }
        }
        panic!("neither an answer nor a time-out")
    }

    /// Configures `module` as a `kind` and returns its settings.
    fn program(
        &self,
        module: &mut dyn RadarModule,
        kind: ModuleKind,
    ) -> Result<RadarConfig, LinkError> {
        let requested = RequestedSettings {
            kind,
            ..RequestedSettings::DEFAULT
        };
        module.program(self.now.get(), &requested, TIMEOUT_US);
        self.wait(|now| module.settings(now))
    }

    fn chirp(&self, module: &mut dyn RadarModule, samples: u16) -> Result<Vec<Iq>, LinkError> {
        let mut chirp = vec![Iq::default(); samples.into()];
        module.trigger(self.now.get(), ANGLE, TIMEOUT_US);
        self.wait(|now| module.poll(now, &mut chirp))?;
        Ok(chirp)
    }
}

fn any(bench: &Bench) -> AnyModule<Line<'static>, Spi> {
    let line = Line {
        bench: bench.clone(),
        sirad: SiRadPort::new(Box::new(|samples| Some(vec![[100, -50]; samples]))),
        framed: Port::new(FramedModule::new(RadarConfig::DEFAULT, Ability::NONE, 0)),
    };
    let mut chip = Chip::new();
    chip.echo = (0..1024).map(|k| 2048 + k % 100).collect();
    let spi = Spi {
        bench: bench.clone(),
        chip,
    };
    AnyModule::new(line, spi)
}

fn bench() -> Bench {
    Bench {
        plugged: Rc::new(Cell::new(ModuleKind::Pstr)),
        now: Rc::new(Cell::new(Micros(u32::MAX - 300_000))),
    }
}

const KINDS: [ModuleKind; 3] = [ModuleKind::Pstr, ModuleKind::SiRad, ModuleKind::Bgt60];

#[test]
fn the_module_that_is_named_is_spoken_to() {
    let bench = bench();
    let mut module = any(&bench);
    // Changes from each kind to each other.
    for kind in KINDS.into_iter().chain(KINDS.into_iter().rev()) {
        bench.plugged.set(kind);
        let radar = bench.program(&mut module, kind).unwrap();
        assert_eq!(radar.validate(), Ok(()));
        let band = radar.carrier_khz / 1_000_000;
        let expected = match kind {
            ModuleKind::Pstr => 94,
            ModuleKind::SiRad => 122,
            ModuleKind::Bgt60 => 60,
        };
        assert_eq!((band, radar.real), (expected, kind == ModuleKind::Bgt60));
        let chirp = bench.chirp(&mut module, radar.samples).unwrap();
        if kind == ModuleKind::Pstr {
            assert!(chirp.iter().all(|&sample| sample == TOLD));
        }
        let times = module.row_times(radar.samples);
        // Its answers have no fixed times.
        assert_eq!(times.is_some(), kind != ModuleKind::SiRad);
        if kind == ModuleKind::Bgt60 {
            let times = times.unwrap();
            assert!((1_050..1_150).contains(&times.trigger_us) && times.chirp_us == Some(256));
        }
    }
}

#[test]
fn another_module_than_the_named_one_is_an_error() {
    for named in KINDS {
        for plugged in KINDS.into_iter().filter(|&kind| kind != named) {
            let bench = bench();
            let mut module = any(&bench);
            bench.plugged.set(plugged);
            let radar = bench.program(&mut module, named);
            assert!(radar.is_err(), "{named:?} with a {plugged:?}: {radar:?}");
        }
    }
}
