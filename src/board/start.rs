//! From reset to a scanner's hardware.

use cortex_m::peripheral::{SCB, SYST};
use stairscan::answer::{Reason, Reasons};
use stairscan::report::command::Measure;
use stairscan::scan::frame::LINK_BAUD;
use stairscan::scan::link::FrameLink;
use stairscan::scan::{Board, Identity, Micros};
use stm32f4xx_hal::gpio::{Edge, ExtiPin, PinState, PushPull, Speed, gpiob, gpioc};
use stm32f4xx_hal::pac::{self, Interrupt};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Enable, Rcc};
use stm32f4xx_hal::serial::{self, Instance, Serial};
use stm32f4xx_hal::syscfg::SysCfg;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

use super::clock::{self, Clocks, brr, prescaler};
use super::motor::{self, Motor};
use super::retained::{self, Crash};
use super::uart::{self, LinkPort, LinkQueue, REPORT_BAUD, Receiver, ReportPort, ReportQueue};

/// What the scanner's loop works with.
pub struct Parts {
    /// The radar module.
    pub link: FrameLink<LinkPort>,
    /// The report port.
    pub report: ReportPort,
    /// What survives a reset, and the stack.
    pub board: ChipBoard,
    /// For the first sentence.
    pub identity: Identity,
    /// Free-running microseconds.
    pub time: Time,
    /// The watchdog, running.
    pub watchdog: Watchdog,
}

/// What the interrupts work with.
pub struct Interrupts {
    /// The step generator, which the scanner shares.
    pub motor: Motor,
    /// Receives from the radar module.
    pub link: Receiver<pac::USART1>,
    /// Receives commands.
    pub report: Receiver<pac::USART2>,
}

/// Received bytes on their way from the interrupts to the scanner.
#[derive(Debug)]
pub struct Queues {
    link: LinkQueue,
    report: ReportQueue,
}

impl Queues {
    /// Empty ones.
    pub const fn new() -> Self {
        Self {
            link: LinkQueue::new(),
            report: ReportQueue::new(),
        }
    }
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

/// A port: 8 data bits, no parity, 1 stop bit. Divider 16 and above.
fn start_port<U: Instance>(
    usart: U,
    pins: (impl Into<U::Tx<PushPull>>, impl Into<U::Rx<PushPull>>),
    divider: u32,
    rcc: &mut Rcc,
) -> Serial<U> {
    let config = serial::Config::default().baudrate(clock::hal_baud(divider).bps());
    match Serial::new(usart, pins, config, rcc) {
        Ok(serial) => serial,
        // Only a divider below 8 is refused, which no clock of this board makes.
        Err(_) => SCB::sys_reset(),
    }
}

/// Inputs and outputs of the motor; edges of the inputs interrupt.
fn start_motor(
    b: gpiob::Parts,
    c: gpioc::Parts,
    syscfg: &mut SysCfg,
    exti: &mut pac::EXTI,
) -> motor::Pins {
    let mut pins = motor::Pins {
        // EN first and high: the driver stays off until homing.
        enable: c.pc8.into_push_pull_output_in_state(PinState::High),
        step: c.pc6.into_push_pull_output().speed(Speed::Medium),
        dir: c.pc7.into_push_pull_output(),
        home: b.pb0.into_pull_down_input(),
        stall: b.pb1.into_pull_up_input(),
    };
    pins.home.make_interrupt_source(syscfg);
    pins.home.trigger_on_edge(exti, Edge::Rising);
    pins.home.enable_interrupt(exti);
    pins.stall.make_interrupt_source(syscfg);
    pins.stall.trigger_on_edge(exti, Edge::Rising);
    pins.stall.enable_interrupt(exti);
    pins
}

/// Starts everything. The interrupts come once they are unmasked.
pub fn start(timer: SYST, p: pac::Peripherals, queues: &'static mut Queues) -> (Parts, Interrupts) {
    let record = retained::load();
    retained::store(record.stopped(), Crash::None);
    let (reset, reasons) = reset_cause(&p.RCC, record.crash());
    let clocks = clock::start(&p.RCC, &p.FLASH);

    let mut rcc = p.RCC.constrain();
    pac::TIM5::enable(&mut rcc);
    let (a, b, c) = (
        p.GPIOA.split(&mut rcc),
        p.GPIOB.split(&mut rcc),
        p.GPIOC.split(&mut rcc),
    );
    let (mut syscfg, mut exti) = (p.SYSCFG.constrain(&mut rcc), p.EXTI);
    let pins = start_motor(b, c, &mut syscfg, &mut exti);
    let link_pins = (
        a.pa9.into_alternate::<7>().speed(Speed::High),
        a.pa10.into_alternate::<7>().internal_pull_up(true),
    );
    let report_pins = (
        a.pa2.into_alternate::<7>(),
        a.pa3.into_alternate::<7>().internal_pull_up(true),
    );
    let divider = brr(clocks.apb2_hz, LINK_BAUD);
    let serial = start_port(p.USART1, link_pins, divider, &mut rcc);
    let (link, link_receiver) = uart::part(serial, Interrupt::USART1, queues.link.split());
    let divider = brr(clocks.apb1_hz, REPORT_BAUD);
    let serial = start_port(p.USART2, report_pins, divider, &mut rcc);
    let (report, report_receiver) = uart::part(serial, Interrupt::USART2, queues.report.split());

    let time = start_time(p.TIM5, &clocks);
    let mut iwdg = IndependentWatchdog::new(p.IWDG);
    iwdg.stop_on_debug(&p.DBGMCU, true);
    iwdg.start(Watchdog::PERIOD_MS.millis());
    let interrupts = Interrupts {
        motor: Motor::new(pins, timer, clocks.core_hz),
        link: link_receiver,
        report: report_receiver,
    };
    let parts = Parts {
        link: FrameLink::new(link),
        report,
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
        watchdog: Watchdog {
            iwdg,
            fed: time.now(),
        },
        time,
    };
    (parts, interrupts)
}
