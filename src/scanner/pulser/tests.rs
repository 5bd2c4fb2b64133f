//! Tests of pulses, levels, and drivers with coarser steps.

use super::*;
use crate::scanner::ramp::COMPUTED;
use crate::scanner::settings::DriverConfig;
use core::cell::Cell;
use core::convert::Infallible;
use proptest::prelude::*;

struct Pin<'a>(&'a Cell<(bool, u32)>);

impl embedded_hal::digital::ErrorType for Pin<'_> {
    type Error = Infallible;
}

impl OutputPin for Pin<'_> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set((false, self.0.get().1));
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        let (level, rises) = self.0.get();
        self.0.set((true, rises + u32::from(!level)));
        Ok(())
    }
}

/// STEP pin that records how many intervals were computed during each pulse.
#[derive(Default)]
struct Wide {
    up: u32,
    widths: std::vec::Vec<u32>,
}

impl embedded_hal::digital::ErrorType for &mut Wide {
    type Error = Infallible;
}

impl OutputPin for &mut Wide {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.widths.push(COMPUTED.get() - self.up);
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.up = COMPUTED.get();
        Ok(())
    }
}

#[test]
fn the_last_pulse_is_as_wide_as_the_others() {
    let (mut step, dir, enable) = (Wide::default(), Cell::default(), Cell::default());
    let ramp = Ramp {
        speed: 1000,
        acceleration: 10_000,
    };
    let mut pulser = Pulser::new(&mut step, Pin(&dir), Pin(&enable), 1_000_000);
    for target in [1, 40, 39] {
        pulser.begin(target, ramp);
        while pulser.tick().is_some() {}
    }
    assert_eq!(step.widths, [1; 41]);
}

#[test]
fn pulses_count_and_driver_levels() {
    let (step, dir, enable) = (Cell::default(), Cell::default(), Cell::default());
    let ramp = Ramp {
        speed: 1000,
        acceleration: 10_000,
    };
    let mut pulser = Pulser::new(Pin(&step), Pin(&dir), Pin(&enable), 1_000_000);
    assert!(enable.get().0, "driver off after reset");
    pulser.set_enabled(true);
    assert!(!enable.get().0);
    let mut ticks = pulser.begin(100, ramp);
    while ticks.is_some() {
        ticks = pulser.tick();
    }
    assert_eq!((pulser.position(), step.get()), (100, (false, 100)));
    assert!(dir.get().0);
    assert!(pulser.begin(100, ramp).is_none());
    pulser.begin(60, ramp);
    assert!(!dir.get().0);
    for _ in 0..10 {
        pulser.tick();
    }
    pulser.set_enabled(false);
    assert_eq!(pulser.tick(), None);
    assert_eq!((pulser.position(), pulser.moving()), (90, false));
    assert!(enable.get().0);
}

/// Returns an enabled pulser over pins for STEP, DIR and EN, and a driver with `microsteps` microsteps a turn.
fn coarse<'a>(
    pins: &'a [Cell<(bool, u32)>; 3],
    microsteps: u16,
) -> Pulser<Pin<'a>, Pin<'a>, Pin<'a>> {
    let [step, dir, enable] = pins;
    let mut pulser = Pulser::new(Pin(step), Pin(dir), Pin(enable), 1_000_000);
    let driver = DriverConfig {
        microsteps,
        ..DriverConfig::default()
    };
    pulser.configure(driver.ratio(), WireLevel::Low);
    pulser.set_enabled(true);
    pulser
}

#[test]
fn the_driver_is_switched_by_the_level_it_needs() {
    let pins = Default::default();
    let [step, dir, enable] = &pins;
    let mut pulser =
        Pulser::with_enable(Pin(step), Pin(dir), Pin(enable), WireLevel::High, 1_000_000);
    assert!(!enable.get().0, "off, and never was on");
    assert_eq!(enable.get().1, 0);
    pulser.set_enabled(true);
    assert!(enable.get().0);
    pulser.configure(Ratio::ONE, WireLevel::Low);
    pulser.set_enabled(false);
    assert!(enable.get().0, "off where a low level is on");
}

#[test]
fn step_stays_high_while_it_is_held() {
    let pins = Default::default();
    let mut pulser = coarse(&pins, 51_200);
    let ramp = Ramp {
        speed: 1000,
        acceleration: 0,
    };
    pulser.begin(2, ramp);
    let mut held = false;
    let next = pulser.tick_wide(|| held = pins[0].get().0);
    assert!(held && !pins[0].get().0);
    assert_eq!(next, Some(1000));
}

#[test]
fn a_coarse_driver_turns_as_fast() {
    let ramp = Ramp {
        speed: 51_200,
        acceleration: 2_560_000,
    };
    let fine: u32 = ramp.duration_us(9_600);
    for microsteps in [25_600, 6_400, 3_200, 1_600] {
        let pins = Default::default();
        let mut pulser = coarse(&pins, microsteps);
        let (mut us, mut next) = (0, pulser.begin(9_600, ramp));
        while let Some(ticks) = next {
            us += ticks;
            next = pulser.tick();
        }
        // Each interval is computed for its midpoint, so coarse steps approximate the ramps less exactly.
        assert!(
            us.abs_diff(fine) < fine / 20,
            "{microsteps}: {us} of {fine}"
        );
        assert_eq!(pulser.position(), 9_600);
        assert_eq!(pins[0].get().1, 9_600 * u32::from(microsteps) / 51_200);
    }
}

proptest! {
    #[test]
    fn nothing_accumulates(
        hundreds in 2u16..=512,
        home in -25_000i32..25_000,
        targets in proptest::collection::vec(-25_000i32..25_000, 1..40),
    ) {
        let pins: [Cell<(bool, u32)>; 3] = Default::default();
        let mut pulser = coarse(&pins, 100 * hundreds);
        let ramp = Ramp { speed: 51_200, acceleration: 0 };
        pulser.set_position(home);
        // Real position of the shaft, in the driver's own steps from home.
        let (mut place, own) = (0_i32, f64::from(hundreds) / 512.0);
        let target = |t: &i32| f64::from(t - home) * own;
        for aim in &targets {
            pulser.begin(*aim, ramp);
            loop {
                let before = pins[0].get().1;
                let more = pulser.tick().is_some();
                let pulses = (pins[0].get().1 - before) as i32;
                place += if pins[1].get().0 { pulses } else { -pulses };
                let there = f64::from(home) + f64::from(place) / own;
                prop_assert!((there - f64::from(pulser.position())).abs() <= 0.5 + 1e-6);
                if !more {
                    break;
                }
            }
            prop_assert!((target(aim) - f64::from(place)).abs() <= 0.5 + 1e-6);
            // A move to the reported position is empty.
            prop_assert!(pulser.begin(pulser.position(), ramp).is_none());
        }
    }
}
