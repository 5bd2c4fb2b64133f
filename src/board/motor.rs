//! The mirror's motor: a timer's interrupt makes the pulses, edges of the two inputs end them.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use rtic::Mutex;
use stairscan::scan::mirror::{PulseState, StepPort};
use stairscan::scan::pulser::Pulser;
use stairscan::scan::ramp::Ramp;
use stm32f4xx_hal::gpio::{ExtiPin, Input, Output, PB0, PB1, PC6, PC7, PC8};

/// SysTick counts 24 bits: 0.1 s at 168 MHz, where the slowest first step takes a third of that.
const LONGEST: u32 = 0x00ff_ffff;

/// The pins between board and motor.
pub struct Pins {
    /// STEP.
    pub step: PC6<Output>,
    /// DIR.
    pub dir: PC7<Output>,
    /// EN, active low.
    pub enable: PC8<Output>,
    /// Home switch, high when pressed.
    pub home: PB0<Input>,
    /// The driver's stall output, low when healthy.
    pub stall: PB1<Input>,
}

/// The step generator; scanner and interrupts share it.
pub struct Motor {
    pulser: Pulser<PC6<Output>, PC7<Output>, PC8<Output>>,
    timer: SYST,
    home: PB0<Input>,
    stall: PB1<Input>,
    until_home: bool,
    home_edge: bool,
    stalled: bool,
}

impl Motor {
    /// At a standstill, the driver off. `core_hz` is what SysTick counts.
    pub fn new(pins: Pins, mut timer: SYST, core_hz: u32) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        Self {
            pulser: Pulser::new(pins.step, pins.dir, pins.enable, core_hz),
            timer,
            home: pins.home,
            stall: pins.stall,
            until_home: false,
            home_edge: false,
            stalled: false,
        }
    }

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

    /// SysTick's interrupt: one pulse.
    pub fn tick(&mut self) {
        self.disarm();
        if let Some(ticks) = self.pulser.tick() {
            self.arm(ticks);
        }
    }

    /// The home switch's edge: it ends a move that looks for it.
    pub fn home_edge(&mut self) {
        self.home.clear_interrupt_pending_bit();
        if self.until_home && self.pulser.moving() {
            self.pulser.stop();
            self.disarm();
            self.until_home = false;
            self.home_edge = true;
        }
    }

    /// The stall output's edge: it ends every move and switches the driver off.
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

impl StepPort for Motor {
    fn begin(&mut self, target: i32, ramp: Ramp, until_home: bool) {
        self.until_home = until_home;
        self.home_edge = false;
        // An edge that came before the driver was on is still a level.
        if self.stall.is_high() {
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
}

/// The motor as the scanner has it: each access keeps the motor's interrupts off.
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
}
