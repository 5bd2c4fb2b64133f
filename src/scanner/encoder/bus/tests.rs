//! Tests of the bus against a simulated device that sees only the levels of two wires.

use super::*;
use crate::scanner::encoder::as5600::{ADDRESS, As5600};
use crate::scanner::encoder::{AngleEncoder, EncoderError};
use core::cell::RefCell;
use core::convert::Infallible;
use proptest::prelude::*;

/// State of the simulated device on the I²C bus.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum At {
    /// Not addressed.
    #[default]
    Idle,
    /// Receives a byte, its address or data; `bits` counts the bits received.
    Hears { address: bool, byte: u8, bits: u8 },
    /// Holds the acknowledgement of a byte.
    Acknowledges { address: bool, byte: u8 },
    /// Sends a byte; `bits` counts the bits sent so far.
    Says { bits: u8 },
    /// Receives the acknowledgement of a byte it has sent.
    Asked,
}

/// Two wires with pull-ups, a master's two pins, and a device with 256 registers.
#[derive(Default)]
struct Wires {
    /// Whether the master releases the clock line.
    clock: bool,
    data: bool,
    /// Whether the device holds the data line low.
    holds_data: bool,
    holds_clock: bool,
    /// Number of reads of the clock line during which the device holds it low, at each bit.
    stretch: u32,
    held: u32,
    at: At,
    registers: Vec<u8>,
    pointer: u8,
    /// Whether the register address has been received: the next byte written goes there.
    pointed: bool,
    absent: bool,
    waited_ns: u32,
    /// Time of the clock line's last edge, and the shortest times for which the line was low and high so far, ns.
    edge_ns: u32,
    shortest_ns: Option<(u32, u32)>,
    /// Shortest time between two rising edges of the clock line so far, and time of the last one, ns.
    bit_ns: Option<u32>,
    rise_ns: u32,
    starts: u32,
    stops: u32,
}

impl Wires {
    fn levels(&self) -> (bool, bool) {
        (
            self.clock && !self.holds_clock,
            self.data && !self.holds_data,
        )
    }

    fn said(&self) -> u8 {
        self.registers[usize::from(self.pointer)]
    }

    /// Updates the device when the levels of clock and data line have changed from `before`.
    fn change(&mut self, before: (bool, bool)) {
        if before.0 != self.levels().0 {
            self.time_clock_edge(before.0);
        }
        match (before, self.levels()) {
            ((true, true), (true, false)) => {
                self.starts += 1;
                self.at = At::Hears {
                    address: true,
                    byte: 0,
                    bits: 0,
                };
            }
            ((true, false), (true, true)) => {
                self.stops += 1;
                self.at = At::Idle;
            }
            ((false, _), (true, bit)) => self.rise(bit),
            ((true, _), (false, _)) => self.fall(),
            _ => {}
        }
    }

    /// Measures the time for which the clock line had the level `high` until now.
    fn time_clock_edge(&mut self, high: bool) {
        let now = self.waited_ns;
        let since = now - self.edge_ns;
        self.edge_ns = now;
        let (low, long) = self.shortest_ns.unwrap_or((u32::MAX, u32::MAX));
        self.shortest_ns = Some(match high {
            true => (low, long.min(since)),
            false => (low.min(since), long),
        });
        if !high {
            let bit = now - self.rise_ns;
            self.bit_ns = Some(self.bit_ns.map_or(bit, |least| least.min(bit)));
            self.rise_ns = now;
        }
    }

    fn rise(&mut self, bit: bool) {
        match &mut self.at {
            At::Hears { byte, bits, .. } => {
                *byte = *byte << 1 | u8::from(bit);
                *bits += 1;
            }
            At::Says { bits } => *bits += 1,
            At::Asked => {
                self.pointer = self.pointer.wrapping_add(1);
                self.at = if bit { At::Idle } else { At::Says { bits: 0 } };
            }
            _ => {}
        }
    }

    fn fall(&mut self) {
        self.holds_data = false;
        match self.at {
            At::Hears {
                address,
                byte,
                bits: 8,
            } => {
                let mine = !address || byte >> 1 == ADDRESS;
                self.holds_data = mine && !self.absent;
                self.at = match self.holds_data {
                    true => At::Acknowledges { address, byte },
                    false => At::Idle,
                };
            }
            At::Acknowledges {
                address: true,
                byte,
            } if byte & 1 == 1 => self.say(0),
            At::Acknowledges { address, byte } => {
                if !address {
                    assert!(!self.pointed, "nothing is ever written to the chip");
                    self.pointer = byte;
                }
                self.pointed = !address;
                self.at = At::Hears {
                    address: false,
                    byte: 0,
                    bits: 0,
                };
            }
            At::Says { bits: 8 } => self.at = At::Asked,
            At::Says { bits } => self.say(bits),
            _ => {}
        }
        self.held = self.stretch;
        self.holds_clock = self.held > 0;
    }

    fn say(&mut self, bits: u8) {
        self.holds_data = self.said() << bits & 0x80 == 0;
        self.at = At::Says { bits };
    }

    fn set(&mut self, change: impl FnOnce(&mut Self)) {
        let before = self.levels();
        change(self);
        self.change(before);
    }
}

#[derive(Clone, Copy)]
enum Which {
    Clock,
    Data,
}

struct Pin<'a>(&'a RefCell<Wires>, Which);

impl embedded_hal::digital::ErrorType for Pin<'_> {
    type Error = Infallible;
}

impl OutputPin for Pin<'_> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.borrow_mut().set(|wires| match self.1 {
            Which::Clock => wires.clock = false,
            Which::Data => wires.data = false,
        });
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.borrow_mut().set(|wires| match self.1 {
            Which::Clock => wires.clock = true,
            Which::Data => wires.data = true,
        });
        Ok(())
    }
}

impl InputPin for Pin<'_> {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        let mut wires = self.0.borrow_mut();
        if let (Which::Clock, true) = (self.1, wires.clock) {
            wires.held = wires.held.saturating_sub(1);
            if wires.held == 0 {
                wires.set(|wires| wires.holds_clock = false);
            }
        }
        let (clock, data) = wires.levels();
        Ok(match self.1 {
            Which::Clock => clock,
            Which::Data => data,
        })
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}

struct Wait<'a>(&'a RefCell<Wires>);

impl DelayNs for Wait<'_> {
    fn delay_ns(&mut self, ns: u32) {
        self.0.borrow_mut().waited_ns += ns;
    }
}

fn chip() -> RefCell<Wires> {
    let mut wires = Wires {
        clock: true,
        data: true,
        registers: vec![0; 256],
        ..Wires::default()
    };
    wires.registers[0x0b] = 0x20;
    wires.registers[0x0c] = 0x0a;
    wires.registers[0x0d] = 0xbc;
    RefCell::new(wires)
}

fn bus(wires: &RefCell<Wires>) -> PinBus<Pin<'_>, Pin<'_>, Wait<'_>> {
    PinBus::new(
        Pin(wires, Which::Clock),
        Pin(wires, Which::Data),
        Wait(wires),
    )
}

#[test]
fn an_as5600_is_read_over_two_wires() {
    let wires = chip();
    let mut encoder = As5600::new(bus(&wires));
    for _ in 0..3 {
        assert_eq!(encoder.angle(), Ok(0xabc0));
    }
    let wires = wires.borrow();
    assert_eq!((wires.starts, wires.stops), (12, 6));
    assert_eq!(wires.levels(), (true, true), "the bus is left free");
    // Duration of a reading according to docs/user/hardware.md.
    assert!(wires.waited_ns / 3 < 600_000, "{} ns", wires.waited_ns / 3);
    // UM10204, table 10, fast mode; and not slower than 200 kbit/s.
    let (low, high) = wires.shortest_ns.unwrap();
    assert!(low >= 1_300 && high >= 600, "low {low} ns, high {high} ns");
    let bit = wires.bit_ns.unwrap();
    assert!((2_500..=5_000).contains(&bit), "{bit} ns a bit");
}

#[test]
fn a_chip_that_stretches_the_clock_is_waited_for_and_one_that_holds_it_is_not() {
    let wires = chip();
    wires.borrow_mut().stretch = u32::from(STRETCH);
    assert_eq!(As5600::new(bus(&wires)).angle(), Ok(0xabc0));
    let wires = chip();
    wires.borrow_mut().stretch = u32::from(STRETCH) + 1;
    assert_eq!(As5600::new(bus(&wires)).angle(), Err(EncoderError::Silent));
    assert!(wires.borrow().waited_ns < 2_000_000);
}

#[test]
fn nobody_there_no_magnet_and_wires_held_low_are_reported() {
    let wires = chip();
    wires.borrow_mut().absent = true;
    let mut pins = bus(&wires);
    let mut byte = [0];
    let read = pins.write_read(ADDRESS, &[0x0b], &mut byte);
    assert_eq!(read, Err(BusError::NoAcknowledge));
    assert_eq!(As5600::new(pins).angle(), Err(EncoderError::Silent));
    assert_eq!(wires.borrow().levels(), (true, true));

    let wires = chip();
    wires.borrow_mut().registers[0x0b] = 0x10;
    let mut encoder = As5600::new(bus(&wires));
    assert_eq!(encoder.angle(), Err(EncoderError::NoMagnet));

    // Pins that always read 0, as in the emulator.
    struct Ground;
    impl embedded_hal::digital::ErrorType for Ground {
        type Error = Infallible;
    }
    impl OutputPin for Ground {
        fn set_low(&mut self) -> Result<(), Infallible> {
            Ok(())
        }
        fn set_high(&mut self) -> Result<(), Infallible> {
            Ok(())
        }
    }
    impl InputPin for Ground {
        fn is_high(&mut self) -> Result<bool, Infallible> {
            Ok(false)
        }
        fn is_low(&mut self) -> Result<bool, Infallible> {
            Ok(true)
        }
    }
    let wires = chip();
    let mut grounded = PinBus::new(Ground, Ground, Wait(&wires));
    let read = grounded.write_read(ADDRESS, &[0x0b], &mut byte);
    assert_eq!(read, Err(BusError::Held));
    assert!(
        wires.borrow().waited_ns < 5_000_000,
        "every wait has an end"
    );
}

/// After a reset within a reading the device holds the data line: it is clocked out of that.
#[test]
fn a_chip_that_was_interrupted_is_clocked_free() {
    let wires = chip();
    wires.borrow_mut().registers[0x0c] = 0;
    let mut pins = bus(&wires);
    pins.start();
    pins.send(ADDRESS << 1);
    pins.send(0x0c);
    pins.start();
    pins.send(ADDRESS << 1 | 1);
    pins.bit(true);
    assert!(!pins.data_high(), "it says zeros");
    let mut encoder = As5600::new(pins);
    assert_eq!(encoder.angle(), Ok(0x0bc0));
}

proptest! {
    /// Every reading ends, for any levels of the wires.
    #[test]
    fn random_levels_end_in_an_answer(levels in proptest::collection::vec(any::<bool>(), 1..400)) {
        struct Noise<'a>(&'a RefCell<core::iter::Cycle<std::vec::IntoIter<bool>>>);
        impl embedded_hal::digital::ErrorType for Noise<'_> {
            type Error = Infallible;
        }
        impl OutputPin for Noise<'_> {
            fn set_low(&mut self) -> Result<(), Infallible> {
                Ok(())
            }
            fn set_high(&mut self) -> Result<(), Infallible> {
                Ok(())
            }
        }
        impl InputPin for Noise<'_> {
            fn is_high(&mut self) -> Result<bool, Infallible> {
                Ok(self.0.borrow_mut().next().unwrap())
            }
            fn is_low(&mut self) -> Result<bool, Infallible> {
                self.is_high().map(|high| !high)
            }
        }
        let noise = RefCell::new(levels.into_iter().cycle());
        let wires = chip();
        let pins = PinBus::new(Noise(&noise), Noise(&noise), Wait(&wires));
        let _ = As5600::new(pins).angle();
        prop_assert!(wires.borrow().waited_ns < 20_000_000);
    }
}
