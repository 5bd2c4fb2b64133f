//! Tests of the scanner with a simulated TMC2209 on its single-wire UART.

use std::cell::RefMut;

use crate::bench::{Bench, IDENTITY};
use stairscan::report::Sentence;
use stairscan::scanner::Settings;
use stairscan::scanner::mirror::Stepper;
use stairscan::scanner::settings::SweepMode;
use stairscan::scanner::tmc2209::Tmc2209;
use stairscan::verdict::{Reason, Status};
use testbed::tmc2209::{Chip, ChipFault};
use testbed::{Motor, Pace, Port, Shared};

/// The driver chip on its UART, and its motor, which moves without delay.
#[derive(Clone)]
struct Drive {
    wire: Shared<Port<Chip>>,
    shaft: Shared<Motor>,
}

impl Drive {
    fn chip(&self) -> RefMut<'_, Chip> {
        RefMut::map(self.wire.get(), |port| &mut port.device)
    }
}

fn settings() -> Settings {
    let mut settings = Settings {
        sweep_mode: SweepMode::Stop,
        ..Settings::default()
    };
    settings.set("driver", "tmc2209").unwrap();
    settings
}

type Over = Bench<Stepper<Shared<Motor>, Tmc2209<Shared<Port<Chip>>>>>;

fn boot(settings: Settings, prepare: impl FnOnce(&mut Chip)) -> (Over, Drive) {
    let motor = Drive {
        wire: Shared::new(Port::new(Chip::default())),
        shaft: Shared::new(Motor::at(5_000, Pace::AtOnce)),
    };
    prepare(&mut motor.chip());
    let chip = motor.wire.clone();
    motor.shaft.get().before_move = Some(Box::new(move || {
        let mode = chip.get().device.register(0x00);
        assert_eq!(mode, 0x1c0, "a move before the set-up");
    }));
    let mirror = Stepper::with_driver(motor.shaft.clone(), Tmc2209::new(motor.wire.clone()));
    let bench = Bench::over(|_| mirror, Some(settings), IDENTITY, |_| ());
    (bench, motor)
}

#[test]
fn a_sound_driver_is_set_up_and_read_before_each_scan() {
    let (mut bench, motor) = boot(settings(), |_| ());
    for scan in 1..4 {
        let reported = bench.scan();
        assert_eq!((reported.scan, reported.status), (scan, Status::Ok));
        // Four reads in the set-up, then flags and status for each scan; the next one may have begun.
        let reads = motor.chip().reads;
        assert!((4 + 2 * scan..=6 + 2 * scan).contains(&reads), "{reads}");
    }
    assert_eq!(motor.shaft.get().enables, 1);
}

#[test]
fn a_silent_driver_is_a_fault_and_nothing_moves() {
    for fault in [
        ChipFault::Silent,
        ChipFault::Cut,
        ChipFault::WrongChecksum,
        ChipFault::IgnoresWrites,
    ] {
        let (mut bench, motor) = boot(settings(), |chip| chip.fault = fault);
        let reported = bench.scan();
        assert_eq!(
            (reported.scan, reported.status),
            (0, Status::Fault),
            "{fault:?}"
        );
        assert!(reported.reasons.has(Reason::MotorDriver), "{reported:?}");
        assert_eq!(motor.shaft.get().enables, 0, "EN stayed off");
        // The scanner tries again by itself.
        motor.chip().fault = ChipFault::Well;
        assert_eq!(bench.scan().status, Status::Ok);
    }
}

#[test]
fn the_self_test_names_the_driver() {
    let (mut bench, motor) = boot(settings(), |_| ());
    bench.scan();
    assert_eq!(bench.ask("stop"), "DONE,stop");
    motor.chip().fault = ChipFault::Silent;
    bench.type_line("selftest");
    let refused = |s: &Sentence<'_>| matches!(s, Sentence::Fail { field, .. } if *field == Reason::MotorDriver.as_str());
    bench.until(refused);
}

/// With its power-up registers a driver makes other steps from the same pulses: no answer is `ok` until
/// it has been set up and homed again.
#[test]
fn a_driver_that_was_reset_is_noticed_before_the_next_answer() {
    let (mut bench, motor) = boot(settings(), |_| ());
    assert_eq!(bench.scan().status, Status::Ok);
    // Between two scans: the rows of one are processed, the next has not begun.
    while bench.scanner.state() != "reporting" {
        bench.step();
    }
    let scan = bench.scanner.scans();
    motor.chip().reset();
    let before = bench.scan();
    assert_eq!((before.scan, before.status), (scan, Status::Ok));
    let fault = bench.scan();
    assert_eq!((fault.scan, fault.status), (scan + 1, Status::Fault));
    assert!(fault.reasons.has(Reason::MotorDriver), "{fault:?}");
    assert_eq!(bench.scan().status, Status::Ok);
    assert_eq!(motor.shaft.get().enables, 2, "set up and homed again");
    assert_eq!(motor.chip().register(0x00), 0x1c0);
}

#[test]
fn another_driver_by_command_is_set_up_before_it_moves() {
    let mut settings = settings();
    settings.set("driver", "step-dir").unwrap();
    let (mut bench, motor) = boot(settings, |chip| {
        // As if it were set up: the test bench checks this at each move.
        chip.registers.insert(0x00, 0x1c0);
    });
    assert_eq!(bench.scan().status, Status::Ok);
    assert_eq!(motor.chip().reads, 0, "the wire is not used");
    bench.send("set,driver,tmc2209");
    bench.scan();
    assert_eq!(bench.scan().status, Status::Ok);
    assert_eq!(motor.shaft.get().enables, 2);
    assert!(motor.chip().writes >= 7);
}

/// With `home-check` a sweep that ends near the switch tests it. If the shaft has slipped since homing
/// the answer is a fault.
#[test]
fn a_shaft_that_slipped_is_noticed_where_the_sweep_ends_at_home() {
    let mut settings = settings();
    settings.set("home-check", "on").unwrap();
    let (mut bench, motor) = boot(settings, |_| ());
    for scan in 1..5 {
        let reported = bench.scan();
        assert_eq!(
            (reported.scan, reported.status),
            (scan, Status::Ok),
            "{reported:?}"
        );
    }
    // The fifth scan ends at the far side, the sixth near the switch.
    while bench.scanner.scans() < 5 {
        bench.step();
    }
    motor.shaft.get().place += 40;
    assert_eq!(bench.scan().status, Status::Ok);
    let fault = bench.scan();
    assert_eq!((fault.scan, fault.status), (6, Status::Fault));
    assert!(fault.reasons.has(Reason::MirrorSlipped), "{fault:?}");
    assert_eq!(bench.scan().status, Status::Ok);
    assert_eq!(motor.shaft.get().enables, 2, "homed again");
}

#[test]
fn a_sweep_that_never_ends_at_home_cannot_check_it() {
    let (mut bench, _) = boot(settings(), |_| ());
    assert_eq!(bench.ask("stop"), "DONE,stop");
    bench.send("set,sweep,down");
    let answer = bench.send("set,home-check,on");
    assert!(
        answer.starts_with("FAIL,set,home-check,off with sweep down"),
        "{answer}"
    );
}
