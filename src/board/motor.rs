//! The mirror's motor: a timer's interrupt makes the pulses, edges of the two inputs end them.

use core::cell::UnsafeCell;

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;
use stairscan::scan::mirror::{PulseState, StepPort};
use stairscan::scan::pulser::Pulser;
use stairscan::scan::ramp::Ramp;
use stm32f4xx_hal::gpio::{ExtiPin, Input, Output, PB0, PB1, PC6, PC7, PC8};
use stm32f4xx_hal::pac::{self, Interrupt, interrupt};

/// SysTick counts 24 bits: 0.1 s at 168 MHz, where the slowest first step takes a third of that.
const LONGEST: u32 = 0x00ff_ffff;

/// STEP, DIR and EN.
pub type Pins = (PC6<Output>, PC7<Output>, PC8<Output>);
/// Home switch (high when pressed) and stall output of the driver (low when healthy).
pub type Inputs = (PB0<Input>, PB1<Input>);

/// What main loop and interrupts share.
struct Motor {
    pulser: Pulser<PC6<Output>, PC7<Output>, PC8<Output>>,
    timer: SYST,
    home: PB0<Input>,
    stall: PB1<Input>,
    until_home: bool,
    home_edge: bool,
    stalled: bool,
}

/// Reached only with interrupts masked, or from the three interrupts of the motor, which have one
/// priority and so never interrupt each other.
struct Shared(UnsafeCell<Option<Motor>>);

// SAFETY: see above; `with` and `in_interrupt` are the only ways in.
unsafe impl Sync for Shared {}

static MOTOR: Shared = Shared(UnsafeCell::new(None));

impl Shared {
    fn with<T: Default>(&self, act: impl FnOnce(&mut Motor) -> T) -> T {
        cortex_m::interrupt::free(|_| self.in_interrupt(act))
    }

    fn in_interrupt<T: Default>(&self, act: impl FnOnce(&mut Motor) -> T) -> T {
        // SAFETY: nothing else can hold the reference, see `Shared`.
        match unsafe { &mut *self.0.get() } {
            Some(motor) => act(motor),
            None => T::default(),
        }
    }
}

impl Motor {
    /// One shot of SysTick, which counts core clocks. It is the only timer whose interrupt chip and
    /// emulator agree on.
    fn arm(&mut self, ticks: u32) {
        self.disarm();
        self.timer.set_reload(ticks.clamp(2, LONGEST) - 1);
        self.timer.clear_current();
        self.timer.enable_interrupt();
        self.timer.enable_counter();
    }

    /// Stops the timer and forgets an interrupt that has not been served: the next one is of the
    /// next move.
    fn disarm(&mut self) {
        self.timer.disable_counter();
        cortex_m::peripheral::SCB::clear_pendst();
    }

    fn tick(&mut self) {
        self.disarm();
        if let Some(ticks) = self.pulser.tick() {
            self.arm(ticks);
        }
    }

    fn on_home(&mut self) {
        if self.until_home && self.pulser.moving() {
            self.pulser.stop();
            self.disarm();
            self.until_home = false;
            self.home_edge = true;
        }
    }

    fn on_stall(&mut self) {
        self.pulser.set_enabled(false);
        self.disarm();
        self.stalled = true;
    }
}

/// Handle of the main loop.
#[derive(Debug)]
pub struct Handle(());

/// Starts timer and inputs; the driver stays off.
pub fn start(pins: Pins, inputs: Inputs, mut timer: SYST, core_hz: u32) -> Handle {
    let (step, dir, enable) = pins;
    let (home, stall) = inputs;
    timer.set_clock_source(SystClkSource::Core);
    let motor = Motor {
        pulser: Pulser::new(step, dir, enable, core_hz),
        timer,
        home,
        stall,
        until_home: false,
        home_edge: false,
        stalled: false,
    };
    // SAFETY: the interrupts that share it are unmasked only below.
    unsafe { *MOTOR.0.get() = Some(motor) };
    for interrupt in [Interrupt::EXTI0, Interrupt::EXTI1] {
        // SAFETY: their handlers use what has just been set up.
        unsafe { pac::NVIC::unmask(interrupt) };
    }
    Handle(())
}

#[exception]
fn SysTick() {
    MOTOR.in_interrupt(Motor::tick);
}

#[interrupt]
fn EXTI0() {
    MOTOR.in_interrupt(|motor| {
        motor.home.clear_interrupt_pending_bit();
        motor.on_home();
    });
}

#[interrupt]
fn EXTI1() {
    MOTOR.in_interrupt(|motor| {
        motor.stall.clear_interrupt_pending_bit();
        motor.on_stall();
    });
}

impl StepPort for Handle {
    fn begin(&mut self, target: i32, ramp: Ramp, until_home: bool) {
        MOTOR.with(|motor| {
            motor.until_home = until_home;
            motor.home_edge = false;
            // An edge that came before the driver was on is still a level.
            if motor.stall.is_high() {
                motor.on_stall();
            } else if let Some(ticks) = motor.pulser.begin(target, ramp) {
                motor.arm(ticks);
            }
        });
    }

    fn state(&mut self) -> PulseState {
        MOTOR.with(|motor| PulseState {
            moving: motor.pulser.moving(),
            home_edge: motor.home_edge,
            stalled: motor.stalled,
        })
    }

    fn home_pressed(&mut self) -> bool {
        MOTOR.with(|motor| motor.home.is_high())
    }

    fn position(&self) -> i32 {
        MOTOR.with(|motor| motor.pulser.position())
    }

    fn set_position(&mut self, position: i32) {
        MOTOR.with(|motor| motor.pulser.set_position(position));
    }

    fn set_enabled(&mut self, on: bool) {
        MOTOR.with(|motor| {
            if on {
                motor.stalled = false;
            } else {
                motor.disarm();
            }
            motor.pulser.set_enabled(on);
        });
    }
}
