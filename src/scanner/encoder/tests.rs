//! Tests with a slipping shaft and a faulty encoder.

use super::*;
use crate::scanner::settings::EncoderConfig;
use crate::schedule::microsteps;
use proptest::prelude::*;

/// A mirror that reaches its target at once, without an error of its own.
#[derive(Default)]
struct Shaft {
    position: i32,
    homed: bool,
    disabled: u32,
}

impl Mirror for Shaft {
    fn start_home(&mut self, motor: &MotorConfig) {
        self.position = microsteps(motor.home_angle);
        self.homed = true;
    }
    fn start_move(&mut self, position: i32, _: &MotorConfig) {
        self.position = position;
    }
    fn poll(&mut self, _: Micros) -> Result<Motion, MirrorError> {
        match self.homed {
            true => Ok(Motion::Still),
            false => Err(MirrorError::NotHomed),
        }
    }
    fn position(&self) -> i32 {
        self.position
    }
    fn homed(&self) -> bool {
        self.homed
    }
    fn disable(&mut self) {
        self.homed = false;
        self.disabled += 1;
    }
}

/// An encoder stub that returns given readings one after the other; the last one repeats.
#[derive(Default)]
struct Sensor {
    /// Readings in the order in which they are returned, 1/65536 turn, or errors.
    reads: Vec<Result<u16, EncoderError>>,
    asked: usize,
}

impl AngleEncoder for Sensor {
    fn angle(&mut self) -> Result<u16, EncoderError> {
        let last = self.reads.len() - 1;
        let answer = self.reads[self.asked.min(last)];
        self.asked += 1;
        answer
    }
}

fn with_encoder(home: i32) -> MotorConfig {
    MotorConfig {
        encoder: EncoderConfig {
            kind: Encoder::As5600,
            home,
        },
        ..MotorConfig::default()
    }
}

type Encoded = EncodedMirror<Shaft, Sensor>;

fn encoded() -> Encoded {
    EncodedMirror::new(Shaft::default(), Sensor::default())
}

/// Polls until the mirror stands, or fails; the encoder reads an angle that differs by `off_deg` degrees from the
/// position by pulses.
fn still(mirror: &mut Encoded, off_deg: f64) -> Result<(), MirrorError> {
    // Any zero of the encoder.
    const ZERO: f64 = 12_345.0;
    let turned = f64::from(mirror.position()) / f64::from(MICROSTEPS_PER_TURN) + off_deg / 360.0;
    let reading = (turned * 65_536.0 + ZERO).rem_euclid(65_536.0) as u16;
    // Twelve bits of resolution.
    let answer = Ok(reading & 0xfff0);
    answers(mirror, vec![answer])
}

fn answers(mirror: &mut Encoded, reads: Vec<Result<u16, EncoderError>>) -> Result<(), MirrorError> {
    (mirror.encoder.reads, mirror.encoder.asked) = (reads, 0);
    let mut now = Micros::default();
    for _ in 0..100 {
        if mirror.poll(now)? == Motion::Still {
            return Ok(());
        }
        now = now.plus(1_000);
    }
    panic!("it must have come to an end");
}

/// Ends a sweep at shaft angle `angle`, 0.001°, and checks the position there, with the shaft off by `off_deg`
/// degrees.
fn end(mirror: &mut Encoded, angle: i32, off_deg: f64) -> Result<(), MirrorError> {
    mirror.start_move(microsteps(angle), &with_encoder(-1));
    assert!(mirror.check_position(), "there is something to wait for");
    still(mirror, off_deg)
}

fn homed(off_deg: f64) -> Encoded {
    let mut mirror = encoded();
    mirror.start_home(&with_encoder(-1));
    still(&mut mirror, off_deg).unwrap();
    mirror
}

#[test]
fn without_an_encoder_nothing_is_read_or_waited_for() {
    let mut mirror = encoded();
    mirror.start_home(&MotorConfig::default());
    assert_eq!(mirror.poll(Micros::default()), Ok(Motion::Still));
    assert!(!mirror.check_position());
    assert_eq!(mirror.home_reading(), None);
}

#[test]
fn a_shaft_that_turns_as_it_is_commanded_agrees() {
    let mut mirror = homed(77.0);
    for _ in 0..4 {
        assert_eq!(end(&mut mirror, 50_000, 77.0), Ok(()));
        assert_eq!(end(&mut mirror, -20_000, 77.0), Ok(()));
    }
}

#[test]
fn a_slip_before_an_end_was_read_is_found_from_three_degrees_on() {
    for slip in [-8.0, -3.0, 2.5, 3.0, 170.0] {
        let mut mirror = homed(0.0);
        let found = end(&mut mirror, 50_000, slip);
        assert_eq!(found, Err(MirrorError::Slipped), "{slip}");
        assert!(!mirror.homed(), "it must home anew");
    }
}

/// Readings at two positions may differ by an encoder's linearity error without a slip.
#[test]
fn an_encoder_that_is_not_linear_agrees_with_itself() {
    let mut mirror = homed(0.0);
    for _ in 0..3 {
        assert_eq!(end(&mut mirror, 50_000, 1.9), Ok(()));
        assert_eq!(end(&mut mirror, -20_000, -1.9), Ok(()));
    }
    assert_eq!(end(&mut mirror, 50_000, 2.6), Err(MirrorError::Slipped));
}

#[test]
fn another_sector_is_held_against_home_first() {
    let mut mirror = homed(0.0);
    for angle in [50_000, -20_000, 40_000, -10_000] {
        assert_eq!(end(&mut mirror, angle, 1.0), Ok(()));
    }
    assert_eq!(end(&mut mirror, 40_000, 3.0), Err(MirrorError::Slipped));
}

#[test]
fn home_elsewhere_than_before_is_no_home() {
    let mut mirror = homed(0.0);
    let known = mirror.home_reading().unwrap();
    mirror.disable();
    mirror.start_home(&with_encoder(-1));
    assert_eq!(still(&mut mirror, 85.0), Err(MirrorError::Slipped));
    mirror.start_home(&with_encoder(-1));
    assert_eq!(still(&mut mirror, 0.2), Ok(()));

    // The calibrated reading holds after a reset, too.
    let mut mirror = encoded();
    mirror.start_home(&with_encoder(known));
    assert_eq!(still(&mut mirror, -1.0), Err(MirrorError::Slipped));
    mirror.start_home(&with_encoder(known));
    assert_eq!(still(&mut mirror, 0.0), Ok(()));
}

#[test]
fn one_wrong_reading_is_no_slip_and_a_silent_encoder_is_reported() {
    let mut mirror = homed(0.0);
    let reading = mirror.seen[0].expected_reading(mirror.position());
    let wrong = Ok(reading.wrapping_add(9_000));
    let silent = Err(EncoderError::Silent);
    assert!(mirror.check_position());
    assert_eq!(
        answers(&mut mirror, vec![wrong, silent, Ok(reading)]),
        Ok(())
    );
    assert!(mirror.check_position());
    let three = answers(&mut mirror, vec![silent, silent, silent]);
    assert_eq!(three, Err(MirrorError::Encoder));
    assert!(!mirror.homed());

    let mut mirror = encoded();
    mirror.start_home(&with_encoder(-1));
    let none = answers(&mut mirror, vec![Err(EncoderError::NoMagnet)]);
    assert_eq!(none, Err(MirrorError::Encoder));
}

#[test]
fn an_encoder_that_is_switched_on_sees_home_first() {
    let mut mirror = encoded();
    mirror.start_home(&MotorConfig::default());
    assert_eq!(mirror.poll(Micros::default()), Ok(Motion::Still));
    mirror.check(&MotorConfig::default());
    assert!(mirror.homed());
    mirror.check(&with_encoder(-1));
    assert!(!mirror.homed());
}

proptest! {
    #[test]
    fn a_reading_in_thousandths_comes_back(reading: u16) {
        let kept = thousandths(reading);
        prop_assert!((0..360_000).contains(&kept));
        prop_assert!(distance(reading_of(kept as u32), reading) <= 1);
    }

    /// Over a whole turn, including the wrap of the reading.
    #[test]
    fn places_and_readings_go_together(position in -26_000..26_000_i32, reading: u16) {
        let home = ShaftReading { position: -23_467, reading };
        let exact = f64::from(reading) + f64::from(position + 23_467) * 1.28;
        let off = (f64::from(home.expected_reading(position)) - exact).rem_euclid(65_536.0);
        prop_assert!(!(1.0..=65_535.0).contains(&off), "{}", off);
    }
}
