//! Fault path: motor off, sentence `HALT`, reset.
//!
//! A stack overflow faults with a stack pointer below the memory, where the next push would fault again and lock
//! up the core. So every entry is written in assembly that resets the pointer before it uses the stack.

use core::panic::PanicInfo;

use cortex_m::peripheral::SCB;
use stairscan::report::Sentence;
use stairscan::verdict::Reason;
use stm32f4xx_hal::pac;

use super::clock;
use super::motor;
use super::retained::{self, BootRecord, Crash};
use super::uart;

/// Flags of register SCB_CFSR (PM0214 4.4.13) that report violations of memory protection.
const MEMORY_VIOLATIONS: u32 = 0xff;

macro_rules! last_resort {
    ($name:ident, $crash:expr) => {
        #[unsafe(naked)]
        #[unsafe(no_mangle)]
        pub(super) unsafe extern "C" fn $name() -> ! {
            core::arch::naked_asm!(
                "cpsid i",
                "ldr r0, =_stack_start",
                "msr msp, r0",
                "movs r0, {crash}",
                "b {end}",
                crash = const $crash as u32,
                end = sym end,
            )
        }
    };
}

last_resort!(HardFault, Crash::HardFault);
last_resort!(DefaultHandler, Crash::UnhandledInterrupt);
// Interrupt of the supply's voltage detector.
last_resort!(PVD, Crash::Supply);
// Interrupt of a crystal that has stopped.
last_resort!(NonMaskableInt, Crash::Clock);
last_resort!(stairscan_panicked, Crash::Panic);

/// Panic handler. As long as the check of the image's symbols passes, no path of the image leads here; a test
/// build's does.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: it takes no arguments and never returns.
    unsafe { stairscan_panicked() }
}

/// Ends the firmware after the crash of this number ([`Crash`]): motor off, sentence `HALT`, reset. Runs on an
/// empty stack with interrupts off.
extern "C" fn end(crash: u32) -> ! {
    // SAFETY: a device's registers, always there; their owner never runs again.
    let port = unsafe { &*pac::GPIOC::ptr() };
    // SAFETY: sets one pin and leaves the others.
    port.bsrr()
        .write(|w| unsafe { w.bits(motor::switch_off()) });
    // SAFETY: the processor's own registers, always there; reading this one changes nothing.
    let violations = unsafe { (*SCB::PTR).cfsr.read() } & MEMORY_VIOLATIONS;
    let crash = match Crash::from_number(crash) {
        Crash::HardFault if violations != 0 => Crash::Memory,
        crash => crash,
    };
    if crash == Crash::Clock {
        slow_down();
    }
    retained::store(BootRecord {
        crash,
        ..retained::load()
    });
    // The line end cuts off a sentence under way, which then fails its CRC.
    uart::send_last(b"\r\n");
    let line = Sentence::Halt {
        reason: Reason::Crash,
    }
    .write();
    uart::send_last(line.as_bytes());
    SCB::sys_reset()
}

/// Resets the clock's dividers, and sets the report port's divider for the internal oscillator, from which the
/// chip runs if the crystal has stopped.
fn slow_down() {
    // SAFETY: a device's registers, always there; their owner never runs again.
    let (rcc, usart) = unsafe { (&*pac::RCC::ptr(), &*pac::USART2::ptr()) };
    // SAFETY: 0 is the reset value: the internal oscillator, nothing divided.
    rcc.cfgr().write(|w| unsafe { w.bits(0) });
    let divider = clock::brr(clock::HSI.apb1_hz, uart::REPORT_BAUD);
    // SAFETY: a divider that the tests of `clock` check.
    usart.brr().write(|w| unsafe { w.bits(divider as u16) });
}
