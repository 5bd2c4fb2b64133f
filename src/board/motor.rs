//! The mirror's motor: a timer's interrupt makes the pulses, edges of the two inputs end them.
//!
//! In: moves from the scanner, interrupts of SysTick, home switch and stall output. Out: STEP, DIR, EN and the
//! state of the move.

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{SCB, SYST};
use rtic::Mutex;
use stairscan::scanner::mirror::{PulseState, StepPort};
use stairscan::scanner::pulser::Pulser;
use stairscan::scanner::ramp::Ramp;
use stairscan::scanner::settings::{DriverConfig, WireLevel};
use stairscan::scanner::step_timer::{self, StepTimer};
use stm32f4xx_hal::gpio::{Edge, ExtiPin, Input, Output, PB0, PB1, PC6, PC7, PC8, Pull};
use stm32f4xx_hal::pac::EXTI;

use super::delay::delay_clocks;

/// Maximum interval of the timer SysTick, core clocks: 24 bits, 0.1 s at 168 MHz. A longer interval is made of
/// several.
const LONGEST: u32 = 0x00ff_ffff;
/// Minimum interval of the timer SysTick, core clocks.
const SHORTEST: u32 = 2;
/// Number of the pin EN within port GPIOC.
const ENABLE_PIN: u32 = 8;
/// Offset in BSRR from the bit that sets a pin to the bit that resets it.
const BSRR_RESET: u32 = 16;

/// Whether a high EN switches the driver on: a copy for the fault path, which cannot read the settings.
static ENABLE_HIGH: AtomicBool = AtomicBool::new(false);

/// Returns the value for register BSRR of port GPIOC that switches the motor driver off by EN.
pub fn switch_off() -> u32 {
    match ENABLE_HIGH.load(Ordering::Relaxed) {
        true => 1 << (ENABLE_PIN + BSRR_RESET),
        false => 1 << ENABLE_PIN,
    }
}

/// The pins between board and motor driver, and that of the home switch.
pub struct Pins {
    /// STEP: a rising edge moves the motor by one step of the driver.
    pub step: PC6<Output>,
    /// DIR: high if the position grows.
    pub dir: PC7<Output>,
    /// EN: switches the driver on, by the level that the settings name.
    pub enable: PC8<Output>,
    /// Home switch, high when pressed.
    pub home: PB0<Input>,
    /// The driver's stall output STALL.
    pub stall: PB1<Input>,
    /// External interrupts of home switch and stall output.
    pub exti: EXTI,
}

/// The step generator, shared by scanner and interrupts.
pub struct Motor {
    pulser: Pulser<PC6<Output>, PC7<Output>, PC8<Output>>,
    timer: SYST,
    late: StepTimer,
    home: PB0<Input>,
    stall: PB1<Input>,
    exti: EXTI,
    /// Level of the stall input that reports a stall.
    stall_level: WireLevel,
    core_hz: u32,
    /// Number of core clocks for which STEP is held high after the next interval has been computed, and at least as
    /// many before the next pulse.
    hold: u32,
    /// Number of core clocks of a long interval that remain after the part that SysTick counts now.
    rest: u32,
    until_home: bool,
    home_edge: bool,
    stalled: bool,
}

impl Motor {
    /// Creates the motor at standstill with the driver off. `core_hz` is SysTick's frequency; `on` is the level
    /// of EN that switches the driver on.
    pub fn new(pins: Pins, mut timer: SYST, core_hz: u32, on: WireLevel) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        ENABLE_HIGH.store(on == WireLevel::High, Ordering::Relaxed);
        Self {
            pulser: Pulser::with_enable(pins.step, pins.dir, pins.enable, on, core_hz),
            timer,
            late: StepTimer::default(),
            home: pins.home,
            stall: pins.stall,
            exti: pins.exti,
            stall_level: WireLevel::High,
            core_hz,
            hold: 0,
            rest: 0,
            until_home: false,
            home_edge: false,
            stalled: false,
        }
    }

    /// Starts SysTick for an interval of `ticks` core clocks, or the first part of a longer one. It is the only
    /// timer whose interrupt works the same on chip and emulator.
    fn arm(&mut self, ticks: u32) {
        self.disarm();
        self.late = StepTimer::default();
        let shot = set(&mut self.timer, ticks.max(SHORTEST));
        self.rest = ticks.saturating_sub(shot);
        self.timer.enable_interrupt();
        self.timer.enable_counter();
    }

    /// Sets the running timer to expire `due` core clocks after its last expiry, or the first part of a longer time.
    /// Nothing may interrupt between reading its count and its restart, some 30 clocks.
    fn restart(&mut self, due: u32) {
        let Self {
            timer,
            late,
            rest,
            hold,
            ..
        } = self;
        let (reload, least) = (SYST::get_reload(), (*hold).max(SHORTEST));
        cortex_m::interrupt::free(|_| {
            late.restart(due, elapsed(reload), least, |clocks| {
                *rest = clocks - set(timer, clocks);
            });
            // The timer may have expired once more, which `elapsed` has counted.
            SCB::clear_pendst();
        });
    }

    /// Stops the timer and clears a pending interrupt, which would count for the next move.
    fn disarm(&mut self) {
        self.timer.disable_counter();
        SCB::clear_pendst();
    }

    /// Handles SysTick's interrupt: emits one pulse, or starts the next part of a long interval. The timer goes on
    /// counting; what passes until its restart counts as part of the next interval.
    pub fn tick(&mut self) {
        if self.rest > 0 {
            return self.restart(self.rest);
        }
        let gone = elapsed(SYST::get_reload());
        let hold = self.hold;
        let ticks = self.pulser.tick_wide(|| {
            if hold > 0 {
                delay_clocks(hold);
            }
        });
        match ticks {
            Some(ticks) => {
                let due = self.late.due(gone, ticks);
                self.restart(due);
            }
            None => self.disarm(),
        }
    }

    fn stall_reported(&self) -> bool {
        match self.stall_level {
            WireLevel::High => self.stall.is_high(),
            WireLevel::Low => self.stall.is_low(),
        }
    }

    /// Handles an edge of the home switch, which ends a move that searches for the switch.
    pub fn home_edge(&mut self) {
        self.home.clear_interrupt_pending_bit();
        if self.until_home && self.pulser.moving() {
            self.pulser.stop();
            self.disarm();
            self.until_home = false;
            self.home_edge = true;
        }
    }

    /// Handles an edge of the stall output, which ends any move and switches the driver off.
    pub fn stall_edge(&mut self) {
        self.stall.clear_interrupt_pending_bit();
        self.stall();
    }

    fn stall(&mut self) {
        self.pulser.set_enabled(false);
        self.disarm();
        self.stalled = true;
    }
}

/// Sets SysTick to count `ticks` core clocks from now on, or the first part of them; returns the length of that part.
#[inline]
fn set(timer: &mut SYST, ticks: u32) -> u32 {
    let shot = ticks.min(LONGEST);
    timer.set_reload(shot - 1);
    timer.clear_current();
    shot
}

/// Returns the core clocks since the expiry of SysTick whose interrupt is handled now, with `reload` in its reload
/// register.
#[inline]
fn elapsed(reload: u32) -> u32 {
    let count = SYST::get_current();
    let again = SCB::is_pendst_pending();
    // Read once more if it may have expired in between.
    let count = if again { SYST::get_current() } else { count };
    step_timer::elapsed(reload, count, again)
}

impl StepPort for Motor {
    fn begin(&mut self, target: i32, ramp: Ramp, until_home: bool) {
        self.until_home = until_home;
        self.home_edge = false;
        // An edge before the driver was on still shows as a level.
        if self.stall_reported() {
            self.stall();
        } else if let Some(ticks) = self.pulser.begin(target, ramp) {
            self.arm(ticks);
        }
    }

    fn state(&mut self) -> PulseState {
        PulseState {
            position: self.pulser.position(),
            moving: self.pulser.moving(),
            home_edge: self.home_edge,
            stalled: self.stalled,
        }
    }

    fn home_pressed(&mut self) -> bool {
        self.home.is_high()
    }

    fn set_position(&mut self, position: i32) {
        self.pulser.set_position(position);
    }

    fn set_enabled(&mut self, on: bool) {
        if on {
            self.stalled = false;
        } else {
            self.disarm();
        }
        self.pulser.set_enabled(on);
    }

    /// Sets the driver's pulse width, microsteps, and active levels of EN and STALL. The stall input's resistor
    /// pulls a broken STALL wire to the level of a stall.
    fn configure(&mut self, driver: &DriverConfig) {
        self.hold = driver.held_clocks(self.core_hz);
        self.disarm();
        self.pulser.configure(driver.ratio(), driver.enable_level);
        ENABLE_HIGH.store(driver.enable_level == WireLevel::High, Ordering::Relaxed);
        if driver.stall_level != self.stall_level {
            self.stall_level = driver.stall_level;
            let (edge, pull) = match driver.stall_level {
                WireLevel::High => (Edge::Rising, Pull::Up),
                WireLevel::Low => (Edge::Falling, Pull::Down),
            };
            self.stall.set_internal_resistor(pull);
            self.stall.trigger_on_edge(&mut self.exti, edge);
            self.stall.clear_interrupt_pending_bit();
        }
    }
}

/// The motor as the scanner uses it: each access locks out the motor's interrupts.
pub struct Locked<M>(pub M);

impl<M: Mutex<T = Motor>> StepPort for Locked<M> {
    fn begin(&mut self, target: i32, ramp: Ramp, until_home: bool) {
        self.0.lock(|motor| motor.begin(target, ramp, until_home));
    }

    fn state(&mut self) -> PulseState {
        self.0.lock(StepPort::state)
    }

    fn home_pressed(&mut self) -> bool {
        self.0.lock(StepPort::home_pressed)
    }

    fn set_position(&mut self, position: i32) {
        self.0.lock(|motor| motor.set_position(position));
    }

    fn set_enabled(&mut self, on: bool) {
        self.0.lock(|motor| motor.set_enabled(on));
    }

    fn configure(&mut self, driver: &DriverConfig) {
        self.0.lock(|motor| motor.configure(driver));
    }
}
