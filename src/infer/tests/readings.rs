//! Measurements of a riser's height, and echoes that must not count as such.

use crate::infer::readings::Readings;
use crate::model::Staircase;
use crate::model::tests::{echo, flight, geometry, model, regular};
use crate::signal::echoes::Echo;

/// Returns the readings (place and height of each riser) that these echoes give for a staircase.
fn read(echoes: &[Echo], s: &Staircase) -> Readings {
    let mut readings = Readings::default();
    model(echoes, &geometry()).readings(s, &mut readings);
    readings
}

/// Two risers of 22 cm. The mirror, 40 cm above the ground, is level with the second one's face, which therefore is at
/// right angles to the line of sight and flashes.
fn facing() -> Staircase {
    regular(2, 0.6, 0.25, 0.22)
}

#[test]
fn a_flash_is_no_reading_of_the_edge_above_it() {
    let flash = [echo(0.85, 0.40, 30.0)];
    let readings = read(&flash, &facing());
    assert!(readings.faces[1].foot_m.is_some());
    assert!(readings.faces[1].level.is_empty(), "{readings:?}");
    let edge = [flash[0], echo(0.85, 0.42, 20.0)];
    let readings = read(&edge, &facing());
    assert!(!readings.faces[1].level.is_empty(), "{readings:?}");
}

#[test]
fn corner_beside_a_flash_of_equal_power_gives_no_height() {
    // A corner 15 cm below the mirror at 85 cm, its flash 10° above it; then the same with 5°.
    for (foot_m, reads) in [(0.22, true), (0.31, false)] {
        let s = flight(&[(0.6, foot_m), (0.85, 0.44)]);
        let echoes = [echo(0.85, 0.40, 30.0), echo(0.85, foot_m, 26.0)];
        let readings = read(&echoes, &s);
        assert_eq!(!readings.faces[0].level.is_empty(), reads, "{readings:?}");
    }
    // A corner much stronger than the flash is measured beside it.
    let s = flight(&[(0.6, 0.31), (0.85, 0.44)]);
    let echoes = [echo(0.85, 0.40, 16.0), echo(0.85, 0.31, 26.0)];
    let readings = read(&echoes, &s);
    assert!(!readings.faces[0].level.is_empty(), "{readings:?}");
}

#[test]
fn riser_with_hidden_foot_measures_the_flights_rise() {
    let s = regular(3, 0.6, 0.25, 0.2);
    // The visible part reaches from the mirror's height, 40 cm, to 60 cm. An echo counts as its middle, with the variance of
    // an even distribution over 20 cm: 6 cm, divided by the mean of both ends' numbers of risers.
    let rise = read(&[echo(1.1, 0.4, 30.0)], &s).rise.mean();
    assert!((rise.sigma() - 0.06 / 2.5).abs() < 0.004, "{rise:?}");
    assert!((rise.value - 0.2).abs() < 2.0 * rise.sigma(), "{rise:?}");
}
