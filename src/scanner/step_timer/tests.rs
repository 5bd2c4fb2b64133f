//! Tests of the step rate with a simulated timer, whose interrupt is late and whose handler takes time.

use super::*;
use crate::scanner::ramp::Ramp;
use proptest::prelude::*;

const CORE_HZ: u32 = 168_000_000;
/// Clocks of the handler from the rising edge of STEP to the restart: the next interval is computed, STEP falls.
const HANDLER: u32 = 190;
/// Clocks from the timer's restart to its first expiry that the board's `least` asks for.
const LEAST: u32 = 300;

/// Returns the times of the rising edges of STEP of a move of `total` steps, clocks. The handler of pulse `k` begins
/// `latency(k)` clocks after the timer's expiry.
fn edges(ramp: Ramp, total: u32, mut latency: impl FnMut(u32) -> u32) -> Vec<u64> {
    let mut timer = StepTimer::default();
    let mut expiry = u64::from(ramp.interval(0, total, CORE_HZ));
    let mut edges = Vec::new();
    for k in 0..total {
        let gone = latency(k);
        edges.push(expiry + u64::from(gone));
        if k + 1 < total {
            let due = timer.due(gone, ramp.interval(k + 1, total, CORE_HZ));
            let elapsed = gone + HANDLER;
            let mut left = 0;
            timer.restart(due, elapsed, LEAST, |clocks| left = clocks);
            expiry += u64::from(elapsed + RESTART + left);
        }
    }
    edges
}

/// Returns mean spacing and shortest spacing of `edges`, both over that of the ramp's top speed.
fn spacing(edges: &[u64], top: u32) -> (f64, f64) {
    let pairs = || edges.windows(2).map(|pair| (pair[1] - pair[0]) as f64);
    let top = f64::from(CORE_HZ / top);
    let shortest = pairs().fold(f64::MAX, f64::min);
    (
        pairs().sum::<f64>() / pairs().count() as f64 / top,
        shortest / top,
    )
}

/// A latency that is the same for every pulse changes neither rate nor spacing, as long as handler and latency together
/// leave the timer its minimum.
#[test]
fn a_constant_latency_costs_no_speed() {
    for speed in [5_000, 10_000, 51_200, 102_400] {
        let ramp = Ramp {
            speed,
            acceleration: 0,
        };
        let interval = CORE_HZ / speed;
        for latency in (0..=2_000).step_by(50) {
            if latency > interval / CATCH_UP {
                continue;
            }
            let (mean, shortest) = spacing(&edges(ramp, 5_000, |_| latency), speed);
            assert!((mean - 1.0).abs() < 0.001, "{speed}, {latency}: {mean}");
            assert!(shortest > 0.999, "{speed}, {latency}: {shortest}");
        }
    }
}

#[test]
fn a_handler_that_is_not_subtracted_would_be_slow() {
    // What the test before would find: 190 clocks of 1,640.
    let slow = f64::from(CORE_HZ / 102_400 + HANDLER) / f64::from(CORE_HZ / 102_400);
    assert!(slow > 1.1);
}

/// A long interval is counted in parts, and a second expiry is not lost.
#[test]
fn the_time_since_the_expiry_counts_a_second_one() {
    assert_eq!(elapsed(999, 0, false), 0);
    assert_eq!(elapsed(999, 999, false), 1);
    assert_eq!(elapsed(999, 1, false), 999);
    assert_eq!(elapsed(999, 0, true), 1_000);
    assert_eq!(elapsed(999, 990, true), 1_010);
}

#[test]
fn lateness_beyond_two_intervals_is_not_recovered() {
    let mut timer = StepTimer::default();
    timer.due(100_000, 1_000);
    assert_eq!(timer.late, 2_000);
    let sum: u32 = (0..100).map(|_| timer.due(0, 1_000)).sum();
    assert_eq!((sum, timer.late), (98_000, 0));
}

proptest! {
    /// Latencies up to a quarter of the interval, any sequence of them: the mean rate is the ramp's, and no spacing is
    /// shorter than three quarters of the ramp's.
    #[test]
    fn jitter_costs_no_speed(
        speed in prop_oneof![Just(51_200u32), Just(102_400), 5_000u32..102_400],
        seed in proptest::collection::vec(0u32..1_000, 16..64),
    ) {
        let ramp = Ramp { speed, acceleration: 0 };
        let most = (CORE_HZ / speed / CATCH_UP).min(2_000);
        let latency = |k: u32| seed[k as usize % seed.len()] * most / 1_000;
        let (mean, shortest) = spacing(&edges(ramp, 4_000, latency), speed);
        prop_assert!((mean - 1.0).abs() < 0.001, "{mean}");
        prop_assert!(shortest > 0.749, "{shortest}");
    }

    /// Now and then an interrupt comes up to 2,000 clocks late, more than an interval at 102,400 steps/s.
    #[test]
    fn lateness_of_an_interrupt_is_recovered(
        speed in prop_oneof![Just(51_200u32), Just(102_400)],
        late in proptest::collection::vec(0u32..=2_000, 1..20),
    ) {
        let ramp = Ramp { speed, acceleration: 0 };
        let latency = |k: u32| match k % 40 {
            20 => late[(k / 40) as usize % late.len()],
            _ => 40,
        };
        let (mean, shortest) = spacing(&edges(ramp, 8_000, latency), speed);
        prop_assert!((mean - 1.0).abs() < 0.001, "{mean}");
        prop_assert!(shortest > 0.749, "{shortest}");
    }

    /// On a ramp, too, no spacing is shorter than three quarters of the ramp's, and the move takes as long as planned.
    #[test]
    fn moves_take_as_long_as_their_ramp(total in 2u32..2_000, late in 0u32..400) {
        let ramp = Ramp { speed: 102_400, acceleration: 2_560_000 };
        let latency = |k: u32| if k % 7 == 3 { late } else { 40 };
        let edges = edges(ramp, total, latency);
        for (k, pair) in (1..).zip(edges.windows(2)) {
            let planned = f64::from(ramp.interval(k, total, CORE_HZ));
            prop_assert!((pair[1] - pair[0]) as f64 >= 0.749 * planned);
        }
        let planned: u64 = (0..total).map(|k| u64::from(ramp.interval(k, total, CORE_HZ))).sum();
        let took = edges[edges.len() - 1];
        prop_assert!(took >= planned && took <= planned + 400, "{took}, {planned}");
    }
}
