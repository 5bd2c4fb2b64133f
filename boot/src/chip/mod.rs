//! The loader on the chip: from reset to the image, or to the host that has a new one.
//!
//! It runs without interrupts and waits by polling. The independent watchdog runs from the beginning at its longest period,
//! which the slowest erasure fits in many times, and on into the image, which sets its own: an image that hangs before that
//! is reset, too.

mod board;
mod clock;
mod pin;
mod port;

use core::panic::PanicInfo;
use core::ptr;

use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{SCB, SYST};
use stairscan::scanner::handover::{Handover, WORDS};
use stairscan::scanner::option_bytes::OptionBytes;
use stairscan::scanner::resets::{self, Resets};
use stairscan_boot::floor::Floor;
use stairscan_boot::force::{AtReset, Waiting};
use stairscan_boot::frame::{ANSWER, Decoder, Frame, MAX_FRAME, encode};
use stairscan_boot::key::PublicKey;
use stairscan_boot::layout::{
    FLOOR, FLOOR_NUMBER, FLOOR_SECTOR, SECTORS_PER_SLOT, SLOT_NUMBER, SLOT_SECTOR, SLOTS,
};
use stairscan_boot::receive::{Effect, FIRST_BAUD, Receiver};
use stairscan_boot::refusal::Refusal;
use stairscan_boot::slot::Slots;
use stairscan_boot::start::{Asked, Loader, Start};
use stairscan_boot::tell;
use stm32f4xx_hal::pac;

use board::controller::{self, Chip, Wait};
use board::delay::delay_clocks;
use board::flash::{FlashError, Sectors};
use board::supply;
use clock::{Clocks, HSE};
use port::Port;

include!(concat!(env!("OUT_DIR"), "/trusted.rs"));

/// The loader over this chip's flash.
type ChipLoader = Loader<
    Sectors<Chip<ByPolls>, SLOT_SECTOR, { 2 * SECTORS_PER_SLOT as usize }>,
    Sectors<Chip<ByPolls>, FLOOR_SECTOR, 1>,
    PublicKey,
>;

/// Wait by polls that are 1 µs apart at 168 MHz, and more on the internal oscillator. None pass while the chip stands still
/// in an erasure, since its code lies in the same bank: 2 s for a sector of 128 KB (DS8626, table 42), during which bytes of
/// the report port are lost. The host waits for each answer, so none come; and the watchdog waits longer.
#[derive(Debug)]
struct ByPolls;

impl Wait for ByPolls {
    fn wait(at_most_us: u32, mut ended: impl FnMut() -> bool) -> bool {
        (0..=at_most_us).any(|_| {
            delay_clocks(HSE.core_hz / 1_000_000);
            ended()
        })
    }
}

impl From<FlashError> for Refusal {
    fn from(error: FlashError) -> Self {
        match error {
            FlashError::Supply => Self::Supply,
            FlashError::Place | FlashError::Controller | FlashError::Failed => Self::Flash,
        }
    }
}

/// Rate of the SysTick polls, Hz.
const TICKS: u32 = 1_000;
/// Time without a request at another rate until the first one holds again, ms.
const RATE_SILENCE_MS: u32 = 2_000;

unsafe extern "C" {
    /// Top of SRAM, where no image places anything (`memory.x`).
    static mut _handover: [u32; WORDS];
    /// Behind it.
    static mut _resets: [u32; resets::WORDS];
}

/// A panic, which no request leads to: what is in flash decides anew.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    SCB::sys_reset()
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: the only place that takes them, once, with interrupts that nothing has unmasked.
    let (mut core, chip) = unsafe { (cortex_m::Peripherals::steal(), pac::Peripherals::steal()) };
    start_watchdog(&chip.IWDG);
    pin::start(&chip);
    let (handed, resets) = (take(), count());
    let clocks = clock::start(&chip.RCC, &chip.FLASH, &chip.TIM11);
    start_detector(&chip);
    let mut loader = ChipLoader {
        slots: Slots::new(
            Sectors::new(Chip(ByPolls), SLOTS, SLOT_NUMBER.into()),
            SLOTS,
        ),
        floor: Floor::new(Sectors::new(Chip(ByPolls), FLOOR, FLOOR_NUMBER.into())),
        keys: PublicKey(TRUSTED),
    };
    let mut port = Port::start(&chip, clocks.apb1_hz);
    let found = AtReset {
        handed,
        resets,
        held: pin::is_held(&chip),
    };
    let (forced, resets) = found.decide(|| loader.has_trial());
    leave_count(resets);
    let start = match handed {
        // No try is spent on an image that somebody is about to replace.
        Some(Handover::Update) => None,
        _ if forced.is_some() => None,
        Some(Handover::Confirm) => loader.start(Asked::Confirm),
        _ => loader.start(Asked::Nothing),
    };
    if let Some(line) = tell::sentence(&mut loader, start, handed, forced) {
        port.write(line.bytes());
    }
    match start {
        Some(start) => {
            port.stop(&chip);
            stop_detector(&chip);
            pin::stop(&chip);
            clock::stop(&chip.RCC, &chip.FLASH);
            execute(start, &mut core.SCB)
        }
        None => {
            let waiting = Waiting::new(forced);
            serve(
                &mut loader,
                &mut port,
                &mut core.SYST,
                &clocks,
                &chip,
                waiting,
            )
        }
    }
}

/// Starts the voltage detector, by which the flash driver sees whether the supply allows it to write. A supply that stays low
/// is no reason not to boot.
fn start_detector(chip: &pac::Peripherals) {
    chip.RCC.apb1enr().modify(|_, w| w.pwren().set_bit());
    // The clock comes two clocks behind the write (ES0182): this read waits for them.
    chip.RCC.apb1enr().read();
    supply::detect(&chip.PWR);
}

/// Leaves the voltage detector as a reset does.
fn stop_detector(chip: &pac::Peripherals) {
    chip.RCC.apb1rstr().modify(|_, w| w.pwrrst().set_bit());
    chip.RCC.apb1rstr().modify(|_, w| w.pwrrst().clear_bit());
    chip.RCC.apb1enr().modify(|_, w| w.pwren().clear_bit());
}

/// The image's message, which then is gone.
fn take() -> Option<Handover> {
    let place = &raw mut _handover;
    // SAFETY: words of SRAM that nothing else uses; any bits are words.
    let words = unsafe { ptr::read_volatile(place) };
    leave([0; WORDS]);
    Handover::from_words(words)
}

fn leave(words: [u32; WORDS]) {
    // SAFETY: as in `take`.
    unsafe { ptr::write_volatile(&raw mut _handover, words) };
}

/// The number of resets before this one; `None` after a loss of power.
fn count() -> Option<Resets> {
    // SAFETY: as in `take`.
    Resets::from_words(unsafe { ptr::read_volatile(&raw mut _resets) })
}

/// Leaves the number of resets for the image and the next reset.
fn leave_count(resets: Option<Resets>) {
    let words = resets.map_or([0; resets::WORDS], Resets::words);
    // SAFETY: as in `take`.
    unsafe { ptr::write_volatile(&raw mut _resets, words) };
}

/// Hands the core over to an image whose signature and hash have just been checked.
fn execute(start: Start, scb: &mut SCB) -> ! {
    if start.trial.is_some() {
        leave(Handover::Trial.words());
        // Three executions without a confirmation end the trial.
        leave_count(None);
    }
    // SAFETY: the address of a vector table on a multiple of 512, within flash.
    unsafe { scb.vtor.write(start.vectors) };
    // SAFETY: a signed image's vector table stands there; nothing of the loader runs again before the next reset.
    unsafe { cortex_m::asm::bootload(start.vectors as *const u32) }
}

/// Starts the independent watchdog at its longest period (RM0090 21.3): 32 kHz / 256 / 4096 are 32 s, at 47 kHz, the fastest that
/// its oscillator may be (DS8626, table 37), 22 s. The slowest erasure takes 4 s.
fn start_watchdog(iwdg: &pac::IWDG) {
    const DIVIDE_BY_256: u8 = 6;
    const LONGEST: u16 = 0xfff;
    iwdg.kr().write(|w| w.key().start());
    iwdg.kr().write(|w| w.key().unlock());
    iwdg.pr().write(|w| w.pr().set(DIVIDE_BY_256));
    // The register's only field, whose reset value is the same.
    iwdg.rlr().write(|w| w.rl().set(LONGEST));
}

fn feed(iwdg: &pac::IWDG) {
    iwdg.kr().write(|w| w.key().feed());
}

/// Carries out the host's requests until one of them, or silence, resets the chip.
fn serve(
    loader: &mut ChipLoader,
    port: &mut Port,
    systick: &mut SYST,
    clocks: &Clocks,
    chip: &pac::Peripherals,
    mut waiting: Waiting,
) -> ! {
    let fastest = clock::fastest(clocks);
    let mut receiver = Receiver::new(fastest, DEVELOPMENT);
    receiver.option_bytes = OptionBytes::of_register(controller::option_bytes());
    let mut decoder = Decoder::new();
    systick.set_clock_source(SystClkSource::Core);
    systick.set_reload(clocks.core_hz / TICKS - 1);
    systick.clear_current();
    systick.enable_counter();
    loop {
        if systick.has_wrapped() {
            feed(&chip.IWDG);
            waiting.tick(pin::is_held(chip));
        }
        if waiting.silent_ms > RATE_SILENCE_MS && port.rate() != FIRST_BAUD {
            port.set_rate(FIRST_BAUD);
            decoder.reset();
        }
        if waiting.is_over() {
            SCB::sys_reset()
        }
        let Some(byte) = port.read() else { continue };
        let Some(frame) = decoder.push(byte) else {
            continue;
        };
        let (kind, sequence) = (frame.kind, frame.sequence);
        let Some((answer, effect)) = receiver.handle(frame, loader) else {
            continue;
        };
        waiting.heard();
        let mut out = [0; MAX_FRAME];
        let answer = Frame {
            kind: kind | ANSWER,
            sequence,
            payload: answer.bytes(),
        };
        let count = encode(answer, &mut out);
        port.write(out.get(..count).unwrap_or_default());
        match effect {
            Effect::None => {}
            Effect::Rate(baud) => port.set_rate(baud),
            Effect::Reset => {
                leave(Handover::Execute.words());
                SCB::sys_reset()
            }
        }
    }
}
