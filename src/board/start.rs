//! From reset to a scanner's hardware: clocks, pins, ports, watchdog and the cause of the reset.

use core::sync::atomic::AtomicU16;

use cortex_m::peripheral::{MPU, SCB, SYST};
use stairscan::report::CrashLine;
use stairscan::scanner::command::Measure;
use stairscan::scanner::encoder::as5600::As5600;
use stairscan::scanner::handover::Handover;
use stairscan::scanner::option_bytes::OptionBytes;
use stairscan::scanner::settings::WireLevel;
use stairscan::scanner::store::{Store, StoreError};
use stairscan::scanner::tmc2209::{self, Tmc2209};
use stairscan::scanner::{Board, BoardHealth, BootInfo, SecondMemory, Settings};
use stairscan::signal::radar::any::AnyModule;
use stairscan::signal::radar::wire::LINK_BAUD;
use stairscan::verdict::Reason;
use stm32f4xx_hal::gpio::{
    Edge, ExtiPin, Input, Output, PB0, PB1, PC9, PinState, PushPull, Speed, gpioc,
};
use stm32f4xx_hal::pac::{self, Interrupt};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{Enable, Rcc};
use stm32f4xx_hal::serial::{self, Instance, Serial};
use stm32f4xx_hal::syscfg::SysCfg;

use super::clock::{self, brr};
use super::controller;
use super::encoder::{self, EncoderBus};
use super::flash::FlashError;
use super::handover;
use super::march;
use super::motor::{self, Motor};
use super::protection;
use super::retained::{self, BootRecord, Crash, CrashRecord};
use super::seal;
use super::settings_flash::{self, SettingsFlash};
use super::sleep::Sleep;
use super::spi::{ModuleSpi, SpiPins};
use super::supply;
use super::time::{self, Time};
use super::uart::{
    self, DriverPort, DriverQueue, LinkPort, LinkQueue, REPORT_BAUD, Receiver, ReportPort,
    ReportQueue,
};
use super::watchdog::Watchdog;

/// Hardware that the scanner's loop uses.
pub struct BoardParts {
    /// The radar module of any type, at its serial port or on SPI.
    pub link: AnyModule<LinkPort, ModuleSpi>,
    /// The scanner's half of the serial port that sends sentences and takes commands.
    pub report: ReportPort,
    /// The motor's driver.
    pub driver: Tmc2209<DriverPort>,
    /// The encoder on the mirror's shaft.
    pub encoder: As5600<EncoderBus>,
    /// Retained state, flash of the settings, and measurements of the stack.
    pub board: ChipBoard,
    /// Identity of firmware and chip, cause of the reset, and state of the board, for the sentence `BOOT` and the
    /// scanner.
    pub identity: BootInfo,
    /// Free-running clock, µs.
    pub time: Time,
    /// The running watchdog.
    pub watchdog: Watchdog,
    /// Sleep between two steps.
    pub sleep: Sleep,
    /// The memory protection unit, until the second memory has been searched for.
    pub mpu: Option<MPU>,
}

/// Hardware that the interrupts use.
pub struct Interrupts {
    /// The step generator, shared with the scanner.
    pub motor: Motor,
    /// Receiving half of the radar module's port.
    pub link: Receiver<pac::USART1>,
    /// Receiving half of the report port's serial port, for commands.
    pub report: Receiver<pac::USART2>,
    /// Receiving half of the motor driver's port.
    pub driver: Receiver<pac::USART3>,
}

/// Queues of received bytes from the interrupts to the scanner.
#[derive(Debug)]
pub struct Queues {
    link: LinkQueue,
    report: ReportQueue,
    driver: DriverQueue,
    /// Numbers of bytes damaged or lost since boot: at the ports of radar module, reports and motor driver.
    errors: [AtomicU16; 3],
}

impl Queues {
    /// Creates empty queues.
    pub const fn new() -> Self {
        Self {
            link: LinkQueue::new(),
            report: ReportQueue::new(),
            driver: DriverQueue::new(),
            errors: [const { AtomicU16::new(0) }; 3],
        }
    }
}

/// The board for the scanner: retained state, flash of the settings, and measurements of the stack.
#[derive(Debug)]
pub struct ChipBoard {
    record: BootRecord,
    store: Store<SettingsFlash>,
    /// Whether the boot loader waits for this image to be confirmed.
    on_trial: bool,
}

impl ChipBoard {
    /// Returns the settings that are saved in flash; `None` if there are none of this firmware.
    pub fn saved(&mut self) -> Option<Settings> {
        self.store.load()
    }

    fn retain(&mut self, change: impl FnOnce(&mut BootRecord)) {
        change(&mut self.record);
        retained::store(self.record);
    }
}

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

impl Board for ChipBoard {
    fn stopped(&self) -> bool {
        self.record.stopped
    }

    fn set_stopped(&mut self, stopped: bool) {
        self.retain(|record| record.stopped = stopped);
    }

    fn retained_settings_hash(&self) -> Option<u32> {
        self.record.settings
    }

    fn retain_settings_hash(&mut self, hash: u32) {
        self.retain(|record| record.settings = Some(hash));
    }

    fn save(&mut self, settings: &Settings) -> Result<(), StoreError> {
        // Settings of a demo do not reach the scanner that is flashed after it.
        if cfg!(feature = "demo") {
            return Err(StoreError::Controller);
        }
        match self.store.flash_mut().check() {
            Ok(()) => self.store.save(settings),
            Err(FlashError::Supply) => Err(StoreError::Supply),
            Err(_) => Err(StoreError::Controller),
        }
    }

    fn clear_crashes(&mut self) {
        self.retain(|record| record.crashes = 0);
    }

    fn last_crash(&self) -> CrashLine<'static> {
        retained::load_crash().map_or(CrashLine::NONE, CrashRecord::line)
    }

    fn forget_crash(&mut self) {
        retained::forget_crash();
    }

    fn enter_loader(&mut self) {
        handover::reset_with(Handover::Update);
    }

    fn self_test_passed(&mut self) {
        if self.on_trial {
            handover::reset_with(Handover::Confirm);
        }
    }

    fn measure(&self, measure: Measure) -> u32 {
        let (bottom, top) = (&raw const _stack_end, &raw const _stack_start);
        let size = (top as u32).wrapping_sub(bottom as u32);
        match measure {
            Measure::StackSize => size,
            Measure::OptionBytes => option_bytes().map_or(0, OptionBytes::bits),
            Measure::StackUsed => size - 4 * untouched(bottom, size / 4),
        }
    }
}

/// Returns the number of words from the bottom of the stack that still hold the start-up code's fill pattern.
fn untouched(bottom: *const u32, words: u32) -> u32 {
    let painted = |k: u32| {
        // SAFETY: the region is the stack's, always mapped; a volatile read of a word that the stack might
        // change at the same time still gives a word.
        let word = unsafe { bottom.add(k as usize).read_volatile() };
        word == cortex_m_rt::STACK_PAINT_VALUE
    };
    (0..words).take_while(|&k| painted(k)).count() as u32
}

/// Version in the sentence `BOOT`; that of a demo image says so.
const VERSION: &str = match cfg!(feature = "demo") {
    true => concat!(env!("CARGO_PKG_VERSION"), "-demo"),
    false => env!("CARGO_PKG_VERSION"),
};

/// Number of consecutive boots after a crash, a watchdog reset or a loss of supply, none followed by a minute of
/// operation, after which the scanner stays idle.
const CRASH_LOOP: u32 = 3;

/// Returns the retained record `before` with this boot counted; `crashed` if the reset was by crash, watchdog or
/// supply.
fn this_boot(before: BootRecord, crashed: bool) -> BootRecord {
    BootRecord {
        crash: Crash::None,
        boots: before.boots.saturating_add(1),
        crashes: match crashed {
            true => before.crashes.saturating_add(1),
            false => 0,
        },
        ..before
    }
}

/// Returns the cause of the reset as text, and as a reason for `status` if it was a crash, the watchdog or the
/// supply.
fn reset_cause(rcc: &pac::RCC, crash: Crash) -> (&'static str, Option<Reason>) {
    let flags = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    match crash {
        Crash::None => {}
        Crash::Supply => return (crash.as_str(), Some(Reason::Supply)),
        _ => return (crash.as_str(), Some(Reason::Crash)),
    }
    if flags.wdgrstf().bit_is_set() {
        ("watchdog", Some(Reason::Watchdog))
    } else if flags.porrstf().bit_is_set() || flags.borrstf().bit_is_set() {
        ("power-on", None)
    } else if flags.sftrstf().bit_is_set() {
        ("software", None)
    } else if flags.padrstf().bit_is_set() {
        ("reset-pin", None)
    } else {
        ("unknown", None)
    }
}

/// Returns the state of image, memory, supply and clock at this boot.
#[inline(never)]
fn board_health(internal_clock: bool, supplied: bool) -> BoardHealth {
    BoardHealth {
        image: seal::verdict(),
        memory_damaged: !march::passed(),
        supply_low: !supplied,
        internal_clock,
    }
}

/// Returns the chip's option bytes; `None` in the emulator.
fn option_bytes() -> Option<OptionBytes> {
    OptionBytes::of_register(controller::option_bytes())
}

/// Starts a serial port: 8 data bits, no parity, 1 stop bit. `divider`, of the port's clock, must be at least 16.
fn start_port<U: Instance>(
    usart: U,
    pins: (impl Into<U::Tx<PushPull>>, impl Into<U::Rx<PushPull>>),
    divider: u32,
    rcc: &mut Rcc,
) -> Serial<U> {
    let config = serial::Config::default().baudrate(clock::hal_baud(divider).bps());
    match Serial::new(usart, pins, config, rcc) {
        Ok(serial) => serial,
        // Only a divider below 8 is refused, which none of this board's clocks gives.
        Err(_) => SCB::sys_reset(),
    }
}

/// Sets up and returns the motor's inputs and outputs, with interrupts on edges of the inputs, and the radar
/// module's trigger line TRIG, low. `on` is the level of EN that switches the driver on.
fn start_motor(
    home: PB0,
    stall: PB1,
    c: gpioc::Parts,
    syscfg: &mut SysCfg,
    mut exti: pac::EXTI,
    on: WireLevel,
) -> (motor::Pins, PC9<Output>) {
    let off = match on {
        WireLevel::Low => PinState::High,
        WireLevel::High => PinState::Low,
    };
    // EN first: a resistor keeps the driver off until then, and it stays off until homing.
    let enable = c.pc8.into_push_pull_output_in_state(off);
    let mut home: PB0<Input> = home.into_pull_down_input();
    let mut stall: PB1<Input> = stall.into_pull_up_input();
    home.make_interrupt_source(syscfg);
    home.trigger_on_edge(&mut exti, Edge::Rising);
    home.enable_interrupt(&mut exti);
    stall.make_interrupt_source(syscfg);
    stall.trigger_on_edge(&mut exti, Edge::Rising);
    stall.enable_interrupt(&mut exti);
    let trig = c.pc9.into_push_pull_output().speed(Speed::Medium);
    let pins = motor::Pins {
        enable,
        step: c.pc6.into_push_pull_output().speed(Speed::Medium),
        dir: c.pc7.into_push_pull_output(),
        home,
        stall,
        exti,
    };
    (pins, trig)
}

/// Starts clocks, pins, ports and watchdog; returns the hardware for the scanner's loop and for the interrupts,
/// which come once they are unmasked.
pub fn start(
    timer: SYST,
    mpu: MPU,
    p: pac::Peripherals,
    queues: &'static mut Queues,
) -> (BoardParts, Interrupts) {
    protection::start(&mpu);
    let before = retained::load();
    let (reset, cause) = reset_cause(&p.RCC, before.crash);
    let on_trial = handover::take() == Some(Handover::Trial);
    let mut record = this_boot(before, cause.is_some());
    if on_trial {
        // The boot loader counts these, and the image that it goes back to is not to stand still for them.
        record.crashes = 0;
    }
    retained::store(record);
    let clocks = clock::start(&p.RCC, &p.FLASH, &p.TIM11);
    let mut store = Store::new(settings_flash::open());
    let on = store
        .load()
        .map_or(WireLevel::Low, |saved| saved.motor.driver.enable_level);

    let mut rcc = p.RCC.constrain();
    pac::TIM5::enable(&mut rcc);
    // Set after reset, too: the search for the second memory relies on it.
    rcc.ahb1enr().modify(|_, w| w.ccmdataramen().set_bit());
    let (a, b, c) = (
        p.GPIOA.split(&mut rcc),
        p.GPIOB.split(&mut rcc),
        p.GPIOC.split(&mut rcc),
    );
    let mut syscfg = p.SYSCFG.constrain(&mut rcc);
    let (pins, trig) = start_motor(b.pb0, b.pb1, c, &mut syscfg, p.EXTI, on);
    pac::PWR::enable(&mut rcc);
    let supplied = supply::start(&p.PWR, &pins.exti);
    let health = board_health(clocks == clock::HSI, supplied);
    let link_pins = (
        a.pa9.into_alternate::<7>().speed(Speed::High),
        a.pa10.into_alternate::<7>().internal_pull_up(true),
    );
    let report_pins = (
        a.pa2.into_alternate::<7>(),
        a.pa3.into_alternate::<7>().internal_pull_up(true),
    );
    let driver_pins = (
        b.pb10.into_alternate::<7>(),
        b.pb11.into_alternate::<7>().internal_pull_up(true),
    );
    let [link_errors, report_errors, driver_errors] = &queues.errors;
    let divider = brr(clocks.apb2_hz, LINK_BAUD);
    let serial = start_port(p.USART1, link_pins, divider, &mut rcc);
    let (link, link_receiver) =
        uart::part(serial, Interrupt::USART1, queues.link.split(), link_errors);
    let divider = brr(clocks.apb1_hz, REPORT_BAUD);
    let serial = start_port(p.USART2, report_pins, divider, &mut rcc);
    let (report, report_receiver) = uart::part(
        serial,
        Interrupt::USART2,
        queues.report.split(),
        report_errors,
    );
    let divider = brr(clocks.apb1_hz, tmc2209::BAUD);
    let serial = start_port(p.USART3, driver_pins, divider, &mut rcc);
    let (driver, driver_receiver) = uart::part(
        serial,
        Interrupt::USART3,
        queues.driver.split(),
        driver_errors,
    );

    let encoder = encoder::bus(b.pb8, b.pb9, clocks.core_hz);
    let link = LinkPort::new(link, trig, clocks);
    let spi_pins = SpiPins {
        select: a.pa4.into_push_pull_output_in_state(PinState::High),
        clock: a.pa5,
        from: a.pa6,
        to: a.pa7,
    };
    let spi = ModuleSpi::new(p.SPI1, spi_pins, &mut rcc);
    let time = time::start(p.TIM5, &clocks);
    let watchdog = Watchdog::start(p.IWDG, &p.DBGMCU, clocks.core_hz, time.now());
    let interrupts = Interrupts {
        motor: Motor::new(pins, timer, clocks.core_hz, on),
        link: link_receiver,
        report: report_receiver,
        driver: driver_receiver,
    };
    let parts = BoardParts {
        link: AnyModule::new(link, spi),
        report,
        driver: Tmc2209::new(driver),
        encoder: As5600::new(encoder),
        board: ChipBoard {
            record,
            store,
            on_trial,
        },
        identity: BootInfo {
            version: VERSION,
            revision: stairscan::REVISION,
            reset,
            clock: clocks.name,
            boots: record.boots,
            // Read once interrupts are on (`serial_number`).
            serial: [0; 3],
            second_memory: SecondMemory::Unknown,
            option_bytes: option_bytes().map(OptionBytes::bits),
            cause,
            crash_loop: record.crashes >= CRASH_LOOP,
            health,
        },
        watchdog,
        sleep: Sleep::new(p.TIM2, &clocks, &mut rcc),
        time,
        mpu: Some(mpu),
    };
    (parts, interrupts)
}
