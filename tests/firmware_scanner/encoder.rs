//! Tests of the scanner with an absolute encoder on its mirror's shaft.

use std::cell::Cell;
use std::rc::Rc;

use crate::bench::{Bench, IDENTITY, Shared};
use stairscan::estimate::Estimate;
use stairscan::mount::Mounting;
use stairscan::report::Sentence;
use stairscan::scanner::command::framed;
use stairscan::scanner::encoder::{AngleEncoder, EncodedMirror, EncoderError};
use stairscan::scanner::settings::SweepMode;
use stairscan::scanner::{MICROSTEPS_PER_TURN, Settings};
use stairscan::verdict::{Reason, Status};

/// Encoder that measures the shaft's real angle, which may differ from the pulses.
#[derive(Clone)]
struct Sensor {
    world: Shared,
    seen: Rc<Seen>,
}

#[derive(Default)]
struct Seen {
    /// Slip of the shaft relative to the pulses, degrees.
    slipped: Cell<f64>,
    silent: Cell<bool>,
    readings: Cell<u32>,
}

impl AngleEncoder for Sensor {
    fn angle(&mut self) -> Result<u16, EncoderError> {
        self.seen.readings.set(self.seen.readings.get() + 1);
        if self.seen.silent.get() {
            return Err(EncoderError::Silent);
        }
        let position = self.world.0.borrow().position;
        let turned = f64::from(position) / f64::from(MICROSTEPS_PER_TURN);
        let turned = turned + (self.seen.slipped.get() + 100.0) / 360.0;
        Ok((turned * 65_536.0).rem_euclid(65_536.0) as u16 & 0xfff0)
    }
}

fn settings(encoder: &str) -> Settings {
    let mut settings = Settings::default();
    settings.set("encoder", encoder).unwrap();
    settings
}

type Over = Bench<EncodedMirror<Shared, Sensor>>;

fn boot(settings: Settings, stopped: bool) -> (Over, Rc<Seen>) {
    let seen = Rc::new(Seen::default());
    let sensor = |world: &Shared| Sensor {
        world: world.clone(),
        seen: seen.clone(),
    };
    let mirror = |world: &Shared| EncodedMirror::new(world.clone(), sensor(world));
    let bench = Bench::over(mirror, Some(settings), IDENTITY, |w| {
        w.board.get().stopped = stopped
    });
    (bench, seen)
}

/// In both sweep modes the encoder is read after homing and after each sweep. If the shaft has slipped,
/// the answer is a fault.
#[test]
fn a_shaft_that_slipped_has_no_answer_and_is_homed_anew() {
    for mode in [SweepMode::Stop, SweepMode::Continuous] {
        let settings = Settings {
            sweep_mode: mode,
            ..settings("as5600")
        };
        let (mut bench, seen) = boot(settings, false);
        for scan in 1..4 {
            let reported = bench.scan();
            assert_eq!(
                (reported.scan, reported.status),
                (scan, Status::Ok),
                "{reported:?}"
            );
        }
        // Readings after homing and three sweeps; the fourth has not ended.
        assert_eq!(seen.readings.get(), 4, "{mode:?}");
        seen.slipped.set(1.0);
        let fault = bench.scan();
        assert_eq!((fault.scan, fault.status), (4, Status::Fault), "{mode:?}");
        assert!(fault.reasons.has(Reason::MirrorSlipped), "{fault:?}");
        // Homing finds the switch at its old place.
        seen.slipped.set(0.0);
        assert_eq!(bench.scan().status, Status::Ok);
    }
}

#[test]
fn a_slip_in_the_first_sweep_behind_homing_is_found() {
    let (mut bench, seen) = boot(settings("as5600"), false);
    while bench.scanner.state() != "scanning" {
        bench.step();
    }
    seen.slipped.set(3.0);
    let fault = bench.scan();
    assert_eq!((fault.scan, fault.status), (1, Status::Fault));
    assert!(fault.reasons.has(Reason::MirrorSlipped), "{fault:?}");
}

#[test]
fn a_silent_encoder_is_a_fault_until_it_answers_or_is_switched_off() {
    let (mut bench, seen) = boot(settings("as5600"), false);
    seen.silent.set(true);
    for _ in 0..2 {
        let fault = bench.scan();
        assert_eq!((fault.scan, fault.status), (0, Status::Fault));
        assert!(fault.reasons.has(Reason::EncoderSilent), "{fault:?}");
        assert!(!bench.world.0.borrow().enabled);
    }
    seen.silent.set(false);
    assert_eq!(bench.scan().status, Status::Ok);
    seen.silent.set(true);
    let fault = bench.scan();
    assert_eq!((fault.scan, fault.status), (2, Status::Fault));
    assert!(fault.reasons.has(Reason::EncoderSilent), "{fault:?}");
    bench.send("set,encoder,none");
    let reported = bench.scan();
    assert_eq!(
        (reported.scan, reported.status),
        (3, Status::Ok),
        "{reported:?}"
    );
}

#[test]
fn no_encoder_is_asked_for_nothing_and_one_that_is_set_sees_home() {
    let (mut bench, seen) = boot(settings("none"), false);
    bench.scan();
    assert_eq!(seen.readings.get(), 0);
    bench.send("set,encoder,as5600");
    bench.scan();
    bench.scan();
    assert!(seen.readings.get() >= 2, "home, and the sweep behind it");
}

/// Calibration saves the reading at home: after a reset a home at another reading is rejected.
#[test]
fn calibration_keeps_what_the_encoder_reads_at_home() {
    let (mut bench, _) = boot(settings("as5600"), true);
    bench.world.0.borrow_mut().mounting = Some(Mounting {
        height_m: Estimate::new(0.398, 1e-3),
        offset_rad: Estimate::new(0.01, 1e-4),
        scale: Estimate::new(1.01, 1e-4),
        mirror_echo_m: Estimate::new(0.2205, 1e-4),
        mirror_level_db: -31.25,
        floor_echoes: 9,
    });
    bench.type_line(framed(&["calibrate", "1500", "20261122"]).trim_end());
    bench.until(|s| matches!(s, Sentence::Done { .. }));
    let saved = bench.world.0.borrow().board.get().load().unwrap();
    // The simulated home is 165.002 degrees above the horizontal; the encoder reads 100 degrees more.
    let kept = saved.motor.encoder.home;
    assert!((294_850..=295_000).contains(&kept), "{kept}");

    let (mut bench, seen) = boot(saved, false);
    seen.slipped.set(-5.0);
    let fault = bench.scan();
    assert_eq!((fault.scan, fault.status), (0, Status::Fault));
    assert!(fault.reasons.has(Reason::MirrorSlipped), "{fault:?}");
    seen.slipped.set(0.0);
    assert_eq!(bench.scan().status, Status::Ok);
}
