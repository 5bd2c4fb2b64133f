//! Tests of homing and moves with a switch that bounces, sticks and has spikes.

use super::*;
use crate::scanner::driver::DriverError;
use crate::testing::motor::{Motor, Pace};

/// Returns a motor whose shaft is `place` microsteps from the home switch.
fn at(place: i32) -> Motor {
    Motor::at(place, Pace::PerRead(7))
}

fn settle<D: MotorDriver>(stepper: &mut Stepper<Motor, D>) -> Result<(), MirrorError> {
    for ms in 0..100_000 {
        match stepper.poll(Micros(1_000 * ms)) {
            Ok(Motion::Still) => return Ok(()),
            Ok(Motion::Moving) => {}
            Err(error) => return Err(error),
        }
    }
    panic!("never settled");
}

#[test]
fn homing_finds_the_same_place_from_anywhere() {
    let motor = MotorConfig::default();
    for place in [-3000, -5, 0, 1, 300, 20_000, 48_000] {
        let mut stepper = Stepper::new(at(place));
        assert_eq!(stepper.poll(Micros(0)), Err(MirrorError::NotHomed));
        stepper.start_home(&motor);
        settle(&mut stepper).unwrap();
        assert!(stepper.homed());
        let home = microsteps(motor.home_angle);
        assert_eq!(stepper.position() - stepper.port().place, home, "{place}");
        stepper.start_move(1234, &motor);
        settle(&mut stepper).unwrap();
        assert_eq!(
            (stepper.position(), stepper.port().place),
            (1234, 1234 - home)
        );
    }
}

#[test]
fn dead_switch_ends_the_search_with_the_driver_off() {
    let mut bench = at(100);
    bench.switch_works = false;
    let mut stepper = Stepper::new(bench);
    stepper.start_home(&MotorConfig::default());
    assert_eq!(settle(&mut stepper), Err(MirrorError::HomeNotFound));
    assert!(!stepper.port().enabled && !stepper.homed());
    assert_eq!(stepper.port().moves, [-SEARCH]);
}

#[test]
fn jammed_switch_ends_the_search() {
    let mut stepper = Stepper::new(at(-1_000_000));
    stepper.start_home(&MotorConfig::default());
    assert_eq!(settle(&mut stepper), Err(MirrorError::HomeNotFound));
    assert!(!stepper.port().enabled);
}

#[test]
fn stall_switches_off_and_needs_homing() {
    let motor = MotorConfig::default();
    let mut stepper = Stepper::new(at(100));
    stepper.start_home(&motor);
    settle(&mut stepper).unwrap();
    stepper.port.stall_at = Some(500);
    stepper.start_move(stepper.position() + 1000, &motor);
    assert_eq!(settle(&mut stepper), Err(MirrorError::Stall));
    assert!(!stepper.port().enabled && !stepper.homed());
    stepper.port.stall_at = None;
    stepper.start_home(&motor);
    settle(&mut stepper).unwrap();
    assert!(stepper.homed());
}

/// Homes a motor over `bench`; returns the error of the home position, microsteps, and the motor.
fn home(bench: Motor) -> Result<(i32, Stepper<Motor>), MirrorError> {
    let motor = MotorConfig::default();
    let mut stepper = Stepper::new(bench);
    stepper.start_home(&motor);
    settle(&mut stepper)?;
    let off = stepper.position() - stepper.port().place - microsteps(motor.home_angle);
    Ok((off, stepper))
}

/// Spikes on the wire must not define the home position.
#[test]
fn spikes_do_not_home() {
    for level_works in [true, false] {
        for spikes in [
            &[12_000][..],
            &[12_000, 11_900],
            // On the search, and then on the slow approach, but at another position.
            &[12_000, 12_400],
            // On the search close to the switch: both edges of the approach are checked.
            &[500],
            &[20_000, 15_000, 3_000],
            // On the approach to the switch itself.
            &[300],
        ] {
            let mut bench = at(30_000);
            (bench.level_works, bench.spikes) = (level_works, spikes.to_vec());
            let (off, stepper) = home(bench).unwrap();
            assert_eq!(off, 0, "{spikes:?}, level {level_works}");
            assert!(stepper.homed());
        }
    }
}

#[test]
fn spikes_without_end_are_no_switch() {
    let mut bench = at(40_000);
    bench.spikes = (-60_000..39_000).step_by(300).collect();
    bench.switch_works = false;
    assert_eq!(home(bench).unwrap_err(), MirrorError::HomeNotFound);
}

#[test]
fn a_level_that_bounces_is_waited_for() {
    let mut bench = at(5_000);
    bench.bounces = 8;
    let (off, stepper) = home(bench).unwrap();
    assert_eq!(off, 0);
    // The search, the way back, and one slow approach: bouncing is not rejected as a spike.
    assert_eq!(stepper.port().moves[1..], [BACK_OFF, -2 * BACK_OFF]);
}

#[test]
fn a_switch_that_does_not_let_go_is_left_further_or_given_up() {
    let mut bench = at(5_000);
    bench.sticks_below = BACK_OFF + 50;
    let (off, stepper) = home(bench).unwrap();
    assert_eq!(off, 0);
    assert!(stepper.port().moves.windows(2).any(|m| m == [BACK_OFF; 2]));
    let mut bench = at(5_000);
    bench.sticks_below = i32::MAX;
    assert_eq!(home(bench).unwrap_err(), MirrorError::HomeNotFound);
}

/// If the switch's level cannot be read, two slow approaches must agree.
#[test]
fn without_a_level_two_approaches_must_agree() {
    let mut bench = at(5_000);
    bench.level_works = false;
    let (off, stepper) = home(bench).unwrap();
    assert_eq!(off, 0);
    let approaches = stepper.port().moves.iter().filter(|&&m| m == -2 * BACK_OFF);
    assert_eq!(approaches.count(), 2);
}

/// The self-test's time limit of homing holds in the worst case.
#[test]
fn homing_takes_less_than_three_turns_at_search_speed() {
    let mut bench = at(40_000);
    bench.spikes = (-60_000..39_000).step_by(1_430).collect();
    bench.switch_works = false;
    let motor = MotorConfig::default();
    let mut stepper = Stepper::new(bench);
    stepper.start_home(&motor);
    assert!(settle(&mut stepper).is_err());
    // Slow moves count eight times; those that an edge ended count in full.
    let moves = &stepper.port().moves;
    let searched = -moves[0];
    let rest: i32 = moves[1..]
        .iter()
        .filter(|&&m| m.abs() <= 2 * BACK_OFF)
        .map(|&m| if m > 0 { m } else { 8 * -m })
        .sum();
    assert!(searched + rest < 3 * MICROSTEPS_PER_TURN, "{moves:?}");
}

/// A driver stub that is ready at the third poll after a request, with an error if `broken`.
#[derive(Default)]
struct Wired {
    set_ups: u32,
    looks: u32,
    busy: u32,
    broken: bool,
}

impl MotorDriver for Wired {
    fn set_up(&mut self, _: &MotorConfig) {
        (self.set_ups, self.busy) = (self.set_ups + 1, 3);
    }
    fn read_status(&mut self) {
        (self.looks, self.busy) = (self.looks + 1, 3);
    }
    fn poll(&mut self, _: Micros) -> Poll<Result<(), DriverError>> {
        self.busy = self.busy.saturating_sub(1);
        match (self.busy, self.broken) {
            (0, false) => Poll::Ready(Ok(())),
            (0, true) => Poll::Ready(Err(DriverError::Silent)),
            _ => Poll::Pending,
        }
    }
    fn tuning_us(&self) -> u32 {
        140_000
    }
}

fn wired() -> MotorConfig {
    let mut motor = MotorConfig::default();
    motor.driver.kind = Driver::Tmc2209;
    motor
}

#[test]
fn the_driver_wakes_before_the_first_pulse() {
    let mut motor = MotorConfig::default();
    motor.driver.enable_wake = 7_000;
    let mut stepper = Stepper::new(at(100));
    stepper.start_home(&motor);
    assert!(stepper.port().enabled);
    for ms in 0..7 {
        assert_eq!(stepper.poll(Micros(1_000 * ms)), Ok(Motion::Moving));
        assert!(stepper.port().moves.is_empty(), "{ms} ms");
    }
    assert_eq!(stepper.poll(Micros(7_000)), Ok(Motion::Moving));
    assert_eq!(stepper.port().moves, [-SEARCH]);
}

#[test]
fn a_driver_with_a_wire_is_set_up_before_it_gets_its_current() {
    let mut stepper = Stepper::with_driver(at(100), Wired::default());
    stepper.start_home(&wired());
    let mut since = None;
    for ms in 0..200 {
        assert_eq!(stepper.poll(Micros(1_000 * ms)), Ok(Motion::Moving));
        if stepper.port().enabled && since.is_none() {
            since = Some(ms);
        }
        if !stepper.port().moves.is_empty() {
            let since = since.expect("EN before the first pulse");
            assert!((140..145).contains(&(ms - since)), "{ms} {since}");
            assert_eq!((since, stepper.driver.set_ups), (2, 1));
            return;
        }
    }
    panic!("never moved");
}

#[test]
fn a_driver_that_does_not_answer_gets_no_current() {
    let broken = Wired {
        broken: true,
        ..Wired::default()
    };
    let mut stepper = Stepper::with_driver(at(100), broken);
    stepper.start_home(&wired());
    // An old stall is cleared only with EN, and must not hide the error.
    stepper.port.stalled = true;
    assert_eq!(settle(&mut stepper), Err(MirrorError::Driver));
    assert!(!stepper.port().enabled && !stepper.homed());
    // A driver without a UART fails in the same way.
    let mut stepper = Stepper::new(at(100));
    stepper.start_home(&wired());
    assert_eq!(settle(&mut stepper), Err(MirrorError::Driver));
}

#[test]
fn a_scan_waits_for_the_look_at_the_driver() {
    let motor = wired();
    let mut stepper = Stepper::with_driver(at(100), Wired::default());
    stepper.check(&motor);
    assert_eq!(stepper.driver.looks, 0, "nothing to look at before homing");
    stepper.start_home(&motor);
    settle(&mut stepper).unwrap();
    let moves = stepper.port().moves.len();
    stepper.check(&motor);
    stepper.start_move(1_000, &motor);
    for _ in 0..2 {
        assert_eq!(stepper.poll(Micros(0)), Ok(Motion::Moving));
        assert_eq!(stepper.port().moves.len(), moves, "the move waits, too");
    }
    settle(&mut stepper).unwrap();
    assert_eq!(stepper.position(), 1_000);
    stepper.start_move(2_000, &motor);
    assert_eq!(stepper.port().moves.len(), moves + 2);
    settle(&mut stepper).unwrap();
    stepper.driver.broken = true;
    stepper.check(&motor);
    assert_eq!(settle(&mut stepper), Err(MirrorError::Driver));
    assert!(!stepper.port().enabled && !stepper.homed());
}

#[test]
fn another_driver_needs_homing() {
    let mut motor = MotorConfig::default();
    let mut stepper = Stepper::new(at(100));
    stepper.start_home(&motor);
    settle(&mut stepper).unwrap();
    motor.speed /= 2;
    stepper.check(&motor);
    assert!(stepper.homed(), "a speed is no driver");
    motor.driver.microsteps = 25_600;
    stepper.check(&motor);
    assert!(!stepper.homed() && !stepper.port().enabled);
}

/// Returns a homed motor whose shaft has slipped by `by` microsteps that were not counted.
fn slipped(by: i32, motor: &MotorConfig) -> Stepper<Motor> {
    let mut stepper = Stepper::new(at(3_000));
    stepper.start_home(motor);
    settle(&mut stepper).unwrap();
    stepper.start_move(0, motor);
    settle(&mut stepper).unwrap();
    stepper.port.place += by;
    stepper
}

#[test]
fn a_switch_that_is_where_it_was_is_found_there_again() {
    let motor = MotorConfig::default();
    for by in [-2, 0, 1, 2] {
        let mut stepper = slipped(by, &motor);
        stepper.check_home(&motor);
        assert_eq!(settle(&mut stepper), Ok(()), "{by}");
        let off = stepper.position() - microsteps(motor.home_angle);
        assert!(stepper.homed() && off == -by, "{off} after {by}");
        stepper.start_move(77, &motor);
        settle(&mut stepper).unwrap();
        assert_eq!(stepper.position(), 77);
    }
}

#[test]
fn a_shaft_that_has_slipped_is_found_out() {
    let motor = MotorConfig::default();
    for by in [-20_000, -400, -150, -64, -3, 3, 64, 150, 400, 20_000] {
        let mut stepper = slipped(by, &motor);
        stepper.check_home(&motor);
        assert_eq!(settle(&mut stepper), Err(MirrorError::Slipped), "{by}");
        assert!(!stepper.homed() && !stepper.port.enabled, "{by}");
    }
}

#[test]
fn one_spike_on_the_way_to_the_switch_is_no_slip() {
    let motor = MotorConfig::default();
    let mut stepper = slipped(0, &motor);
    stepper.port.spikes.push(60);
    stepper.check_home(&motor);
    assert_eq!(settle(&mut stepper), Ok(()));
    assert_eq!(stepper.position(), microsteps(motor.home_angle));
    // A switch that does not work any more counts as a slip, not as a spike.
    stepper.port.switch_works = false;
    stepper.check_home(&motor);
    assert_eq!(settle(&mut stepper), Err(MirrorError::Slipped));
}

#[test]
fn without_a_home_there_is_nothing_to_look_for() {
    let mut stepper = Stepper::new(at(100));
    stepper.check_home(&MotorConfig::default());
    assert_eq!(stepper.poll(Micros(0)), Err(MirrorError::NotHomed));
}
