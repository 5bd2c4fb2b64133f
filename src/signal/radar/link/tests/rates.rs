//! Bit rates of the wire: agreed on, abandoned, and 10^5 chirps at each over a wire with errors of all kinds.

use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;

use super::*;
use crate::testing::framed::{FramedModule, RATES};
use crate::testing::port::{DEVICE, FIRST_BAUD};

const SAMPLES: usize = 16;
/// Interval of polling, microseconds.
const POLL: u32 = 50;

/// Returns the scanner's port, which takes two bytes at once, with a module behind it whose fastest bit rate is
/// `fastest`, Mbaud.
fn far(fastest: u8, seed: u64) -> Port<FramedModule> {
    let radar = RadarConfig {
        samples: SAMPLES as u16,
        ..RadarConfig::DEFAULT
    };
    let ability = Ability {
        fastest,
        ..Ability::NONE
    };
    let mut port = Port::new(FramedModule::new(radar, ability, seed));
    port.wires.supported = RATES;
    port.wires.room = 2;
    port
}

struct Bench {
    link: FrameLink<Port<FramedModule>>,
    now: Micros,
    requested: RequestedSettings,
}

impl Bench {
    fn new(far: Port<FramedModule>) -> Self {
        Self {
            link: FrameLink::new(far),
            now: Micros(u32::MAX - 70_000),
            requested: RequestedSettings::DEFAULT,
        }
    }

    fn rate(&self) -> u32 {
        self.link.frames.wire().baud
    }

    fn settings(&mut self) -> Result<RadarConfig, LinkError> {
        self.link.program(self.now, &self.requested, 100_000);
        loop {
            if let Poll::Ready(result) = self.link.settings(self.now) {
                return result;
            }
            self.now = self.now.plus(POLL);
        }
    }

    /// Triggers a chirp at `angle`, as a repetition if `again` is set, and returns the angle in its answer.
    fn chirp(&mut self, angle: i32, again: bool) -> Result<i32, LinkError> {
        match again {
            false => self.link.trigger(self.now, angle, 5_000),
            true => self.link.retry(self.now, angle, 5_000),
        }
        let mut samples = [Iq::default(); SAMPLES];
        loop {
            if let Poll::Ready(result) = self.link.poll(self.now, &mut samples) {
                let [one, ..] = samples;
                assert!(result.is_err() || samples == [one; SAMPLES]);
                let angle = i32::from(one.i as u16) | i32::from(one.q) << 16;
                return result.map(|()| angle);
            }
            self.now = self.now.plus(POLL);
        }
    }
}

#[test]
fn the_fastest_rate_of_both_is_agreed_on() {
    for (fastest, wished, rate) in [
        (1, 3, 1),
        (2, 3, 2),
        (3, 3, 3),
        (3, 2, 2),
        (3, 1, 1),
        (9, 3, 3),
    ] {
        let mut bench = Bench::new(far(fastest, 1));
        bench.requested.baud = wished * 1_000_000;
        assert!(bench.settings().is_ok());
        assert_eq!(bench.rate(), rate * 1_000_000);
        assert_eq!(bench.chirp(-20_000, false), Ok(-20_000));
        // The next scan keeps the rate.
        assert!(bench.settings().is_ok());
        assert_eq!(bench.rate(), rate * 1_000_000);
        // A slower rate is requested.
        bench.requested.baud = 1_000_000;
        assert!(bench.settings().is_ok());
        assert_eq!(
            (bench.rate(), bench.link.port.wires.rates),
            (1_000_000, [1_000_000; 2])
        );
        assert_eq!(bench.chirp(50_000, false), Ok(50_000));
    }
}

#[test]
fn a_chirp_that_is_triggered_again_is_at_one_megabaud() {
    let mut bench = Bench::new(far(3, 2));
    bench.settings().unwrap();
    bench.link.port.wires.mute = true;
    assert_eq!(bench.chirp(1_000, false), Err(LinkError::Timeout));
    bench.link.port.wires.mute = false;
    assert_eq!(bench.chirp(1_000, true), Ok(1_000));
    assert_eq!(
        (bench.rate(), bench.link.port.wires.rates),
        (1_000_000, [1_000_000; 2])
    );
    // A single failure does not change the rate.
    bench.settings().unwrap();
    assert_eq!(bench.rate(), 3_000_000);
}

/// A trigger that waits for the module's change of bit rate has not been sent: the mirror must stand until it is.
#[test]
fn a_trigger_behind_a_change_of_rate_is_not_sent_yet() {
    let mut bench = Bench::new(far(3, 2));
    bench.settings().unwrap();
    bench.link.trigger(bench.now, 7, 5_000);
    let mut samples = [Iq::default(); SAMPLES];
    for _ in 0..20 {
        let _ = bench.link.poll(bench.now, &mut samples);
    }
    assert!(bench.link.sent());
    bench.link.retry(bench.now, 7, 5_000);
    for _ in 0..20 {
        assert!(bench.link.poll(bench.now, &mut samples).is_pending());
        assert!(!bench.link.sent());
    }
}

#[test]
fn a_rate_that_fails_is_left_alone_for_a_while() {
    let mut bench = Bench::new(far(3, 3));
    bench.settings().unwrap();
    for angle in 0..=i32::from(MAX_FAILURES) {
        bench.link.port.wires.mute = true;
        assert!(bench.chirp(angle, false).is_err());
        bench.link.port.wires.mute = false;
        assert_eq!(bench.chirp(angle, false), Ok(angle));
    }
    assert_eq!(bench.rate(), 3_000_000, "a sweep in passing keeps its rate");
    for _ in 0..u16::from(RETRY_SCANS) {
        bench.settings().unwrap();
        assert_eq!(bench.rate(), 2_000_000);
    }
    bench.settings().unwrap();
    assert_eq!(bench.rate(), 3_000_000);
}

#[test]
fn whichever_end_is_reset_they_find_each_other() {
    // Reset of the module: it starts at 1 Mbaud.
    let mut bench = Bench::new(far(3, 4));
    bench.settings().unwrap();
    bench.link.port.wires.rates[DEVICE] = FIRST_BAUD;
    assert!(bench.settings().is_err());
    assert!(bench.settings().is_ok());
    assert_eq!(
        (bench.rate(), bench.link.port.wires.rates),
        (3_000_000, [3_000_000; 2])
    );
    // Reset of the scanner: its port starts at 1 Mbaud, the module does not.
    let mut port = far(3, 5);
    port.wires.rates = [FIRST_BAUD, 3_000_000];
    let mut bench = Bench::new(port);
    assert!(bench.settings().is_ok());
    assert_eq!(
        (bench.rate(), bench.link.port.wires.rates),
        (3_000_000, [3_000_000; 2])
    );
}

#[test]
fn a_rate_that_only_the_module_can_hear_is_not_kept() {
    // The module confirms the rate and does not change it.
    let mut bench = Bench::new(far(2, 6));
    bench.link.program(bench.now, &bench.requested, 100_000);
    let settings = loop {
        if bench.link.port.device.asked.contains(&FrameKind::Rate) {
            bench.link.port.wires.rates[DEVICE] = FIRST_BAUD;
        }
        if let Poll::Ready(result) = bench.link.settings(bench.now) {
            break result;
        }
        bench.now = bench.now.plus(POLL);
    };
    assert!(settings.is_ok());
    assert_eq!(bench.rate(), 1_000_000);
    assert_eq!(bench.chirp(5, false), Ok(5));
}

#[test]
fn only_what_is_wished_is_programmed_and_the_pin_pulsed() {
    let mut bench = Bench::new(far(1, 7));
    bench.settings().unwrap();
    assert_eq!(bench.chirp(3, false), Ok(3));
    assert_eq!(bench.link.port.device.asked[..1], [FrameKind::Configure]);
    assert_eq!(bench.link.port.wires.edges, 0);
    let mut port = far(1, 7);
    port.device.ability.pin = true;
    let mut bench = Bench::new(port);
    bench.requested.pin = true;
    bench.settings().unwrap();
    assert_eq!(bench.chirp(3, false), Ok(3));
    assert_eq!(bench.link.port.device.asked[..1], [FrameKind::Program]);
    assert_eq!(bench.link.port.wires.edges, 1);
    assert!(bench.link.frames.wire().pin);
}

/// No row gets another row's chirp, and the link recovers from every failure. Tested with 10^5 chirps at each bit rate
/// of the wire (1, 2 and 3 Mbaud). One frame in 300 is damaged, in some scans one in ten. In some scans the module is
/// reset to 1 Mbaud, is silent, or sends without pause.
#[test]
fn a_hundred_thousand_chirps_at_each_rate() {
    for rate in [1, 2, 3] {
        let mut bench = Bench::new(far(rate, 100 + u64::from(rate)));
        let (mut chirps, mut came, mut at_rate) = (0_u32, 0_u32, 0_u32);
        let mut scans = 0_u32;
        while at_rate < 100_000 {
            scans += 1;
            bench.link.port.device.trouble = if scans % 13 == 4 { 10 } else { 300 };
            bench.link.port.wires.mute = scans % 97 == 50;
            let babbles = scans % 97 == 70;
            bench.link.port.wires.babble =
                babbles.then(|| Xoshiro128PlusPlus::seed_from_u64(scans.into()));
            if scans % 31 == 7 {
                // The module is reset to 1 Mbaud, between scans or during one.
                bench.link.port.wires.rates[DEVICE] = FIRST_BAUD;
            }
            // Every fourth scan is one with a turning mirror: no chirp is triggered again.
            let passing = scans.is_multiple_of(4);
            let asked: Vec<_> = (0..5).map(|_| bench.settings()).collect();
            let ill = bench.link.port.wires.mute || babbles;
            let known = asked.iter().any(Result::is_ok);
            assert!(known || ill, "scan {scans}: {asked:?}");
            for row in 0..281 {
                chirps += 1;
                if scans % 53 == 9 && row == 100 {
                    bench.link.port.wires.rates[DEVICE] = FIRST_BAUD;
                }
                let angle = (scans as i32 % 100) * 1_000 + row;
                let mut chirp = bench.chirp(angle, false);
                for _ in 0..2 {
                    if chirp.is_err() && !passing {
                        chirp = bench.chirp(angle, true);
                    }
                }
                if let Ok(found) = chirp {
                    assert_eq!(found, angle, "another row's chirp");
                    came += 1;
                }
                at_rate += u32::from(bench.rate() == u32::from(rate) * 1_000_000);
                if ill && row == 8 {
                    break;
                }
            }
        }
        // Nearly all chirps are received; with a turning mirror one in ten is lost.
        assert!(came > chirps / 100 * 95, "{came} of {chirps} at {rate}");
        assert!(at_rate > chirps / 5, "{at_rate} of {chirps} at {rate}");
    }
}
