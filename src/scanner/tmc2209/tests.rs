//! Tests of set-up and status with a chip that works, has a fault, or is reset in between.

use super::*;
use crate::scanner::settings::Driver;
use crate::testing::port::{Device, Port, Wires};
use crate::testing::shared::Shared;
use crate::testing::tmc2209::{Chip, ChipFault};
use proptest::prelude::*;
use std::cell::RefMut;
use std::vec::Vec;

/// The wire to the simulated chip: takes one byte at a time.
type Wire = Shared<Port<Chip>>;

fn wire() -> Wire {
    let mut port = Port::new(Chip::default());
    port.wires.room = 1;
    Shared::new(port)
}

fn chip_of(wire: &Wire) -> RefMut<'_, Chip> {
    RefMut::map(wire.get(), |port| &mut port.device)
}

fn motor() -> MotorConfig {
    let mut motor = MotorConfig::default();
    motor.driver.kind = Driver::Tmc2209;
    motor.driver.stall_threshold = 60;
    motor
}

/// Polls the driver until its set-up or reading ends; returns the result and the duration, µs.
fn finish<P: BytePort>(driver: &mut Tmc2209<P>) -> (Result<(), DriverError>, u32) {
    // Across the wrap of the clock.
    let begun = Micros(u32::MAX - 2_000);
    for k in 0..10_000 {
        let now = begun.plus(87 * k);
        if let Poll::Ready(done) = driver.poll(now) {
            return (done, 87 * k);
        }
    }
    panic!("never done");
}

fn set_up(prepare: impl FnOnce(&mut Chip)) -> (Tmc2209<Wire>, Wire, Result<(), DriverError>) {
    let wire = wire();
    prepare(&mut chip_of(&wire));
    let mut driver = Tmc2209::new(wire.clone());
    assert_eq!(driver.poll(Micros(0)), Poll::Ready(Ok(())), "idle");
    driver.set_up(&motor());
    let (done, us) = finish(&mut driver);
    assert!(us < 150_000, "{us}");
    (driver, wire, done)
}

fn look(driver: &mut Tmc2209<Wire>) -> Result<(), DriverError> {
    driver.read_status();
    let (done, us) = finish(driver);
    // Less than the 0.1 s of margin in a move's deadline.
    assert!(us < 50_000, "{us}");
    done
}

#[test]
fn checksums_are_those_of_the_data_sheet() {
    // Requests for GCONF and IOIN, as every other driver of this chip sends them.
    assert_eq!(crc(&[0x05, 0x00, 0x00]), 0x48);
    assert_eq!(crc(&[0x05, 0x00, 0x06]), 0x6f);
}

#[test]
fn a_sound_chip_is_set_up_and_read() {
    let (mut driver, wire, done) = set_up(|_| {});
    assert_eq!(done, Ok(()));
    {
        let chip = chip_of(&wire);
        assert_eq!(chip.register(0x00), 0x1c0);
        assert_eq!(chip.register(0x01), 0, "its reset at power-up is forgotten");
        // 600 mA with 0.98 A at full scale: 19 steps of 32.
        assert_eq!(chip.register(0x10), 18 | 18 << 8);
        assert_eq!(chip.register(0x14), 15_000_000 / 25_600);
        assert_eq!(chip.register(0x40), 60);
        assert_eq!(chip.register(0x6c), 0x1000_0053 | 1 << 17);
        assert_eq!((chip.writes, chip.reads), (7, 4));
    }
    assert_eq!(look(&mut driver), Ok(()));
    assert_eq!(chip_of(&wire).reads, 6);
    assert_eq!(driver.poll(Micros(5)), Poll::Ready(Ok(())), "idle again");
}

#[test]
fn settings_become_registers() {
    let mut motor = motor();
    motor.driver.stall_threshold = 0;
    motor.driver.microsteps = 3200;
    motor.driver.current = 1200;
    let wire = wire();
    let mut driver = Tmc2209::new(wire.clone());
    driver.set_up(&motor);
    assert_eq!(finish(&mut driver).0, Ok(()));
    let chip = chip_of(&wire);
    assert_eq!(chip.register(0x14), 0, "no stall is reported at any speed");
    // 16 microsteps are MRES 4; 1.2 A are beyond the finer range.
    assert_eq!(chip.register(0x6c), 0x1400_0053);
    assert_eq!(chip.register(0x10), 20 | 20 << 8);
}

#[test]
fn currents_are_never_more_than_asked_for() {
    for milliamperes in 100..=1767 {
        let (scale, vsense) = current_scale(milliamperes);
        let volts = if vsense { 0.18 } else { 0.325 };
        let real = f64::from(scale + 1) / 32.0 * volts / 0.13 / 2_f64.sqrt() * 1e3;
        let wanted = f64::from(milliamperes);
        assert!(real <= wanted + 1.0, "{milliamperes} mA: {real}");
        // Error limit: one step of the scale.
        assert!(wanted - real < 56.0, "{milliamperes} mA: {real}");
    }
}

/// Fault: its name, its cause, and the expected error.
type Wrong = (&'static str, fn(&mut Chip), DriverError);

#[test]
fn each_misbehaviour_is_reported() {
    use DriverError::{Fault, Reset, Silent};
    let wrongs: [Wrong; 8] = [
        ("silent", |c| c.fault = ChipFault::Silent, Silent),
        ("cut", |c| c.fault = ChipFault::Cut, Silent),
        ("checksum", |c| c.fault = ChipFault::WrongChecksum, Silent),
        ("other register", |c| c.fault = ChipFault::Other, Silent),
        ("deaf", |c| c.fault = ChipFault::IgnoresWrites, Silent),
        ("overtemperature", |c| c.put(0x6f, 1 << 1), Fault),
        ("short", |c| c.put(0x6f, 1 << 3), Fault),
        ("short of the low side", |c| c.put(0x6f, 1 << 5), Fault),
    ];
    for (what, wrong, error) in wrongs {
        let (_, _, done) = set_up(wrong);
        assert_eq!(done, Err(error), "{what}");
    }
    let later: [Wrong; 6] = [
        ("reset", Chip::reset, Reset),
        ("driver error", |c| c.put(0x01, 2), Fault),
        ("charge pump", |c| c.put(0x01, 4), Fault),
        ("silent", |c| c.fault = ChipFault::Silent, Silent),
        ("checksum", |c| c.fault = ChipFault::WrongChecksum, Silent),
        ("short", |c| c.put(0x6f, 1 << 2), Fault),
    ];
    for (what, wrong, error) in later {
        let (mut driver, wire, done) = set_up(|_| {});
        assert_eq!(done, Ok(()));
        wrong(&mut chip_of(&wire));
        assert_eq!(look(&mut driver), Err(error), "{what}");
        assert_eq!(driver.poll(Micros(5)), Poll::Ready(Ok(())), "idle again");
    }
}

#[test]
fn warnings_and_open_loads_are_no_faults() {
    let (mut driver, wire, _) = set_up(|_| {});
    // DRV_STATUS: otpw, ola, olb, stst.
    let warnings = 1 | 1 << 6 | 1 << 7 | 1 << 31;
    chip_of(&wire).registers.insert(0x6f, warnings);
    assert_eq!(look(&mut driver), Ok(()));
}

#[test]
fn a_reset_in_the_midst_of_the_set_up_leaves_no_register_out() {
    for after in 1..=7 {
        let (_, wire, done) = set_up(|chip| chip.resets_after = Some(after));
        assert_eq!(done, Ok(()), "{after}");
        let chip = chip_of(&wire);
        assert_eq!(chip.register(0x00), 0x1c0);
        assert_eq!(chip.register(0x40), 60);
        assert_eq!(chip.register(0x01), 0);
    }
}

#[test]
fn any_lost_byte_is_made_good() {
    // Bytes of a set-up: a read request of 4, seven writes of 8, and three read requests of 4.
    for lost in 0..72 {
        let (_, wire, done) = set_up(|chip| chip.loses.push(lost));
        assert_eq!(done, Ok(()), "byte {lost}");
        let chip = chip_of(&wire);
        assert_eq!(chip.register(0x00), 0x1c0, "byte {lost}");
        assert_eq!(chip.register(0x6c), 0x1002_0053, "byte {lost}");
    }
}

#[test]
fn what_a_chip_forgets_is_not_forgotten_by_a_new_set_up() {
    let (mut driver, wire, _) = set_up(|_| {});
    chip_of(&wire).reset();
    assert_eq!(look(&mut driver), Err(DriverError::Reset));
    driver.set_up(&motor());
    assert_eq!(finish(&mut driver).0, Ok(()));
    assert_eq!(chip_of(&wire).register(0x40), 60);
    assert_eq!(look(&mut driver), Ok(()));
}

/// A device that sends arbitrary bytes, on a port that takes any number.
struct Noise {
    bytes: Vec<u8>,
    at: usize,
}

impl Device for Noise {
    fn receive(&mut self, _: u8, _: u64, _: &mut Wires) {}

    fn send(&mut self) -> Option<u8> {
        self.at += 1;
        let byte = self.bytes.get(self.at % (self.bytes.len() + 1));
        byte.copied()
    }

    fn room(&self) -> usize {
        self.at % 5
    }
}

proptest! {
    #[test]
    fn anything_on_the_wire_comes_to_an_end(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let mut driver = Tmc2209::new(Port::new(Noise { bytes, at: 0 }));
        driver.set_up(&motor());
        let (done, _) = finish(&mut driver);
        // Random bytes do not form four valid answers.
        prop_assert_eq!(done, Err(DriverError::Silent));
        driver.read_status();
        let _ = finish(&mut driver);
    }

    #[test]
    fn any_status_is_judged(flags in any::<u32>(), status in any::<u32>()) {
        let (mut driver, wire, _) = set_up(|_| {});
        chip_of(&wire).registers.insert(0x01, flags);
        chip_of(&wire).registers.insert(0x6f, status);
        let well = flags & 7 == 0 && status & 0x3e == 0;
        prop_assert_eq!(look(&mut driver).is_ok(), well);
    }
}
