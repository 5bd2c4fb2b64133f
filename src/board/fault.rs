//! The end of a firmware that cannot go on: motor off, one sentence, reset.
//!
//! A stack overflow faults with a stack pointer below the memory, where the next push would fault
//! again and lock the core up. So every way in is written in assembly that resets the pointer
//! before it touches the stack.

use core::panic::PanicInfo;

use cortex_m::peripheral::SCB;
use stairscan::report::Sentence;
use stairscan::verdict::Reason;
use stm32f4xx_hal::pac;

use super::clock;
use super::motor;
use super::retained::{self, BootRecord, Crash};
use super::uart;

/// SCB_CFSR (PM0214 4.4.13): what broke the memory protection.
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
last_resort!(DefaultHandler, Crash::Stray);
// The supply falls.
last_resort!(PVD, Crash::Supply);
// The crystal has stopped.
last_resort!(NonMaskableInt, Crash::Clock);
last_resort!(stairscan_panicked, Crash::Panic);

/// No path of the image leads here as long as the check of its symbols passes; a test build's does.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: it takes no arguments and never returns.
    unsafe { stairscan_panicked() }
}

/// Runs on an empty stack with interrupts off.
extern "C" fn end(crash: u32) -> ! {
    // SAFETY: a device's registers, always there; whoever owns them never runs again.
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
    // Whatever sentence was under way is cut off by the line end and fails its CRC.
    uart::send_last(b"\r\n");
    let line = Sentence::Halt {
        reason: Reason::Crash,
    }
    .write();
    uart::send_last(line.as_bytes());
    SCB::sys_reset()
}

/// Without the crystal the chip runs from its own oscillator: the last sentence needs that one's divider.
fn slow_down() {
    // SAFETY: a device's registers, always there; whoever owns them never runs again.
    let (rcc, usart) = unsafe { (&*pac::RCC::ptr(), &*pac::USART2::ptr()) };
    // SAFETY: 0 is the reset value: that oscillator, nothing divided.
    rcc.cfgr().write(|w| unsafe { w.bits(0) });
    let divider = clock::brr(clock::HSI.apb1_hz, uart::REPORT_BAUD);
    // SAFETY: a divider that the tests of `clock` check.
    usart.brr().write(|w| unsafe { w.bits(divider as u16) });
}
