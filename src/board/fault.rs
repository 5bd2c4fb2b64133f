//! The end of a firmware that cannot go on: motor off, one sentence, reset.
//!
//! A stack overflow faults with a stack pointer below the memory, where the next push would fault
//! again and lock the core up. So every way in is written in assembly that resets the pointer
//! before it touches the stack.

use core::panic::PanicInfo;

use stairscan::answer::Reason;
use stairscan::report::Sentence;
use stm32f4xx_hal::pac;

use super::retained::{self, Crash, Record};
use super::uart;

/// EN of the motor's driver, active low: GPIOC pin 8.
const ENABLE_PIN: u32 = 8;

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
    port.bsrr().write(|w| unsafe { w.bits(1 << ENABLE_PIN) });
    let crash = match crash {
        1 => Crash::Panic,
        2 => Crash::HardFault,
        _ => Crash::Stray,
    };
    retained::store(Record {
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
    cortex_m::peripheral::SCB::sys_reset()
}
