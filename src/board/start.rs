//! From reset to a scanner's hardware.

use stairscan::answer::{Reason, Reasons};
use stairscan::report::command::Measure;
use stairscan::scan::link::FrameLink;
use stairscan::scan::mirror::Stepper;
use stairscan::scan::{Board, Identity, Micros};
use stm32f4xx_hal::gpio::{Edge, ExtiPin, GpioExt, Speed};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::_fugit_ExtU32 as _;
use stm32f4xx_hal::rcc::{Enable, RccExt};
use stm32f4xx_hal::syscfg::SysCfgExt;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

use super::clock::{self, Clocks, prescaler};
use super::motor::{self, Handle};
use super::retained::{self, Crash};
use super::uart::{self, LinkPort, ReportPort};

/// Everything that the scanner is built over.
pub struct Hardware {
    /// The mirror's motor.
    pub mirror: Stepper<Handle>,
    /// The radar module.
    pub link: FrameLink<LinkPort>,
    /// The report port.
    pub report: ReportPort,
    /// The rest.
    pub board: ChipBoard,
    /// For the first sentence.
    pub identity: Identity,
    /// Free-running microseconds.
    pub time: Time,
    /// The watchdog, running.
    pub watchdog: Watchdog,
}

/// Microseconds from TIM5.
pub struct Time(pac::TIM5);

impl Time {
    /// The present moment.
    pub fn now(&self) -> Micros {
        Micros(self.0.cnt().read().bits())
    }
}

/// The independent watchdog: it runs from its own oscillator and nothing can stop it.
pub struct Watchdog {
    iwdg: IndependentWatchdog,
    fed: Micros,
}

impl Watchdog {
    /// Without food for so long the chip is reset; longer than any part of the loop takes.
    const PERIOD_MS: u32 = 2_000;
    /// Feeding more often is of no use.
    const PAUSE_US: u32 = 50_000;

    /// Feeds it if the state has met its own deadline.
    pub fn attend(&mut self, now: Micros, healthy: bool) {
        if healthy && now.since(self.fed) >= Self::PAUSE_US {
            self.iwdg.feed();
            self.fed = now;
        }
    }
}

/// What survives a reset, and the stack.
#[derive(Debug)]
pub struct ChipBoard {
    stopped: bool,
}

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

impl Board for ChipBoard {
    fn stopped(&self) -> bool {
        self.stopped
    }

    fn set_stopped(&mut self, stopped: bool) {
        self.stopped = stopped;
        retained::store(stopped, Crash::None);
    }

    fn measure(&self, measure: Measure) -> u32 {
        let (bottom, top) = (&raw const _stack_end, &raw const _stack_start);
        let size = (top as u32).wrapping_sub(bottom as u32);
        match measure {
            Measure::StackSize => size,
            Measure::StackUsed => size - 4 * untouched(bottom, size / 4),
        }
    }
}

/// Words from the bottom of the stack that still hold the start-up code's paint.
fn untouched(bottom: *const u32, words: u32) -> u32 {
    let painted = |k: u32| {
        // SAFETY: the region is the stack's, always mapped; a volatile read of a word that the
        // stack might change at the same time is still a word.
        let word = unsafe { bottom.add(k as usize).read_volatile() };
        word == cortex_m_rt::STACK_PAINT_VALUE
    };
    (0..words).take_while(|&k| painted(k)).count() as u32
}

/// Why the chip was reset, and what `status` shows of it.
fn reset_cause(rcc: &pac::RCC, crash: Crash) -> (&'static str, Reasons) {
    let flags = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    let crashed = Reasons::NONE.with(Reason::Crash);
    match crash {
        Crash::Panic => return ("panic", crashed),
        Crash::HardFault => return ("hard-fault", crashed),
        Crash::Stray => return ("stray-interrupt", crashed),
        Crash::None => {}
    }
    if flags.wdgrstf().bit_is_set() {
        ("watchdog", Reasons::NONE.with(Reason::Watchdog))
    } else if flags.porrstf().bit_is_set() || flags.borrstf().bit_is_set() {
        ("power-on", Reasons::NONE)
    } else if flags.sftrstf().bit_is_set() {
        ("software", Reasons::NONE)
    } else if flags.padrstf().bit_is_set() {
        ("reset-pin", Reasons::NONE)
    } else {
        ("unknown", Reasons::NONE)
    }
}

/// TIM5 as a free-running counter of microseconds.
fn start_time(timer: pac::TIM5, clocks: &Clocks) -> Time {
    let division = prescaler(clocks.timer_hz, 1_000_000);
    timer.psc().write(|w| w.psc().set(division as u16));
    // SAFETY: any value is one; this is the whole range.
    timer.arr().write(|w| unsafe { w.bits(u32::MAX) });
    timer.egr().write(|w| w.ug().update());
    timer.cr1().write(|w| w.cen().enabled());
    Time(timer)
}

/// Starts everything. Call it once.
pub fn start(core: cortex_m::Peripherals, p: pac::Peripherals) -> Hardware {
    let record = retained::load();
    retained::store(record.stopped(), Crash::None);
    let (reset, reasons) = reset_cause(&p.RCC, record.crash());
    let clocks = clock::start(&p.RCC, &p.FLASH);

    let mut rcc = p.RCC.constrain();
    pac::USART1::enable(&mut rcc);
    pac::USART2::enable(&mut rcc);
    pac::TIM5::enable(&mut rcc);

    let (a, b, c) = (
        p.GPIOA.split(&mut rcc),
        p.GPIOB.split(&mut rcc),
        p.GPIOC.split(&mut rcc),
    );
    // EN first and high: the driver stays off until homing.
    let enable = c
        .pc8
        .into_push_pull_output_in_state(stm32f4xx_hal::gpio::PinState::High);
    let (step, dir) = (
        c.pc6.into_push_pull_output().speed(Speed::Medium),
        c.pc7.into_push_pull_output(),
    );
    let mut syscfg = p.SYSCFG.constrain(&mut rcc);
    let mut exti = p.EXTI;
    let (mut home, mut stall) = (b.pb0.into_pull_down_input(), b.pb1.into_pull_up_input());
    home.make_interrupt_source(&mut syscfg);
    home.trigger_on_edge(&mut exti, Edge::Rising);
    home.enable_interrupt(&mut exti);
    stall.make_interrupt_source(&mut syscfg);
    stall.trigger_on_edge(&mut exti, Edge::Rising);
    stall.enable_interrupt(&mut exti);
    a.pa9.into_alternate::<7>().speed(Speed::High);
    a.pa10.into_alternate::<7>().internal_pull_up(true);
    a.pa2.into_alternate::<7>();
    a.pa3.into_alternate::<7>().internal_pull_up(true);

    let time = start_time(p.TIM5, &clocks);
    let mut iwdg = IndependentWatchdog::new(p.IWDG);
    iwdg.stop_on_debug(&p.DBGMCU, true);
    iwdg.start(Watchdog::PERIOD_MS.millis());
    let watchdog = Watchdog {
        iwdg,
        fed: time.now(),
    };
    Hardware {
        mirror: Stepper::new(motor::start(
            (step, dir, enable),
            (home, stall),
            core.SYST,
            clocks.core_hz,
        )),
        link: FrameLink::new(uart::link(p.USART1, clocks.apb2_hz)),
        report: uart::report(p.USART2, clocks.apb1_hz),
        board: ChipBoard {
            stopped: record.stopped(),
        },
        identity: Identity {
            version: env!("CARGO_PKG_VERSION"),
            revision: env!("STAIRSCAN_REVISION"),
            reset,
            clock: clocks.name,
            reasons,
        },
        time,
        watchdog,
    }
}
