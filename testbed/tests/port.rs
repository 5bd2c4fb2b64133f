//! Tests of the port and the motor: their faults, and their time.

use stairscan::port::BytePort;
use stairscan::scanner::mirror::StepPort;
use stairscan::scanner::ramp::Ramp;
use testbed::port::{DEVICE, SCANNER};
use testbed::{Motor, Pace, Port};

const RAMP: Ramp = Ramp {
    speed: 51_200,
    acceleration: 0,
};

#[test]
fn a_port_with_little_room_takes_and_keeps_little() {
    let mut port: Port = Port::default();
    port.wires.room = 2;
    port.wires.capacity = 3;
    assert_eq!(port.write(b"abc"), 2);
    assert!(port.wires.waiting && port.device == b"ab");
    port.wires.room = 0;
    assert_eq!(port.write(b"c"), 0);
    port.type_in("12345");
    assert_eq!((port.errors(), port.wires.incoming.len()), (2, 3));
    assert_eq!([port.read(), port.read()], [Some(b'1'), Some(b'2')]);
    port.wires.mute = true;
    port.type_in("6");
    assert_eq!([port.read(), port.read()], [Some(b'3'), None]);
}

#[test]
fn whole_lines_are_taken_and_the_rest_is_kept() {
    let mut port: Port = Port::default();
    port.write(b"one\r\ntwo\r\nthr");
    assert_eq!(port.take_lines(), ["one", "two"]);
    port.write(b"ee\n");
    assert_eq!(port.take_lines(), ["three"]);
}

/// On a clock of µs at 1 Mbaud a byte takes 10 of them; one is on the wire, one waits.
#[test]
fn bytes_take_their_time() {
    let mut port: Port = Port::default();
    port.wires.ticks = Some(1_000_000);
    port.wires.lags = true;
    assert_eq!(port.write(b"abc"), 2);
    port.advance(9);
    assert_eq!(port.device, b"");
    port.advance(10);
    assert_eq!(port.device, b"a");
    assert_eq!(port.write(b"c"), 1);
    port.advance(30);
    assert_eq!(port.device, b"abc");
    port.type_in("12");
    port.advance(40);
    assert_eq!([port.read(), port.read()], [Some(b'1'), None]);
    assert_eq!(port.wires.next_arrival(40), Some(50));
}

#[test]
fn what_is_sent_at_another_rate_is_lost_or_another_byte() {
    let mut port: Port = Port::default();
    port.wires.rates[DEVICE] = 3_000_000;
    port.type_in([0x10, 0x11]);
    assert_eq!([port.read(), port.read()], [Some(0x88), None]);
    port.wires.rates[SCANNER] = 3_000_000;
    port.type_in([0x10]);
    assert_eq!(port.read(), Some(0x10));
}

#[test]
fn a_shaft_at_its_end_loses_pulses_and_the_switch_ends_a_search() {
    let mut motor = Motor::at(5, Pace::PerRead(4));
    motor.ends = Some((-3, 8));
    motor.set_enabled(true);
    motor.begin(10, RAMP, false);
    assert!(motor.state().moving);
    motor.turn(100);
    assert_eq!((motor.position, motor.place), (10, 8));
    motor.begin(-100, RAMP, true);
    motor.turn(100);
    let state = motor.state();
    assert!(state.home_edge && !state.moving && motor.home_pressed());
    assert_eq!((state.position, motor.place), (2, 0));
    motor.jammed = true;
    motor.begin(50, RAMP, true);
    motor.turn(5);
    assert!(motor.home_pressed() && !motor.state().home_edge);
    motor.stall_at = Some(8);
    motor.turn(100);
    assert!(motor.state().stalled && !motor.enabled);
}

#[test]
#[should_panic(expected = "a move with the driver off")]
fn a_move_needs_the_driver() {
    Motor::at(0, Pace::AtOnce).begin(1, RAMP, false);
}
