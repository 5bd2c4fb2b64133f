//! Fault path: motor off, sentence `HALT`, reset.
//!
//! A stack overflow faults with a stack pointer below the memory, where the next push would fault again and lock
//! up the core. So every entry is written in assembly that resets the pointer before it uses the stack. Before that it
//! loads LR and PC of the exception frame, if all of the frame lies within the stack; else the return address that the
//! frame pointer r7 points to: after an overflow that of the function that grew the stack.

use core::panic::PanicInfo;

use cortex_m::peripheral::SCB;
use stairscan::crc;
use stairscan::report::{CrashSite, Sentence};
use stairscan::verdict::Reason;
use stm32f4xx_hal::pac;

use super::cfsr;
use super::clock;
use super::motor;
use super::retained::{self, BootRecord, Crash, CrashRecord};
use super::uart;

macro_rules! last_resort {
    ($name:ident, $crash:expr) => {
        #[unsafe(naked)]
        #[unsafe(no_mangle)]
        pub(super) unsafe extern "C" fn $name() -> ! {
            core::arch::naked_asm!(
                "cpsid i",
                "mrs r1, msp",
                "ldr r0, =_stack_end",
                "cmp r1, r0",
                "blo 2f",
                "ldr r0, =_stack_start - {frame}",
                "cmp r1, r0",
                "bhi 2f",
                "ldrd r2, r3, [r1, {lr}]",
                "b 3f",
                "2: movs r1, #0",
                "movs r2, #0",
                "ldr r0, =_stack_end",
                "cmp r7, r0",
                "blo 3f",
                "ldr r0, =_stack_start - 8",
                "cmp r7, r0",
                "bhi 3f",
                "ldr r2, [r7, #4]",
                "3: ldr r0, =_stack_start",
                "msr msp, r0",
                "movs r0, {crash}",
                "b {faulted}",
                frame = const cfsr::FRAME,
                lr = const cfsr::FRAME_LR,
                crash = const $crash as u32,
                faulted = sym faulted,
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

/// Panic handler. As long as the check of the image's symbols passes, no path of the image leads here; a test
/// build's does.
#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    let caller: u32;
    // SAFETY: copies a register that no call has changed yet.
    unsafe {
        core::arch::asm!("mov {}, lr", out(reg) caller, options(nomem, nostack, preserves_flags));
    }
    let place = info
        .location()
        .map_or(0, |at| crc::of_place(at.file(), at.line(), at.column()));
    // SAFETY: it takes any numbers and never returns.
    unsafe { stairscan_panicked(place, caller) }
}

/// End of a panic: resets the stack pointer and keeps the arguments, the hash of the panic's place and the return
/// address of the panic handler.
#[unsafe(naked)]
#[unsafe(no_mangle)]
unsafe extern "C" fn stairscan_panicked(place: u32, caller: u32) -> ! {
    core::arch::naked_asm!(
        "cpsid i",
        "ldr r2, =_stack_start",
        "msr msp, r2",
        "b {panicked}",
        panicked = sym panicked,
    )
}

extern "C" fn panicked(place: u32, caller: u32) -> ! {
    let site = CrashSite {
        // Bit 0 of a return address is the Thumb state.
        pc: Some(caller & !1),
        cfsr: Some(0),
        place: Some(place),
        ..CrashSite::NONE
    };
    end(Crash::Panic, site)
}

/// Ends the firmware after the exception of this crash's number ([`Crash`]). `lr` and `pc` are those of the exception
/// frame if it lies within the stack, `frame` then its address, else 0; `lr` is then a return address from the stack, or 0.
extern "C" fn faulted(crash: u32, frame: u32, lr: u32, pc: u32) -> ! {
    // SAFETY: the processor's own registers, always there; reading these changes nothing.
    let scb = unsafe { &*SCB::PTR };
    let cfsr = scb.cfsr.read();
    let whole = frame != 0 && cfsr::has_frame(cfsr);
    let site = CrashSite {
        pc: whole.then_some(pc),
        lr: Some(lr).filter(|&lr| whole || frame == 0 && lr != 0),
        cfsr: Some(cfsr),
        address: cfsr::address(cfsr, scb.mmfar.read(), scb.bfar.read()),
        place: None,
    };
    let crash = match Crash::from_number(crash) {
        Crash::HardFault if cfsr::is_memory(cfsr) => Crash::Memory,
        crash => crash,
    };
    end(crash, site)
}

/// Ends the firmware: motor off, records of the crash, sentence `HALT`, reset.
fn end(crash: Crash, site: CrashSite) -> ! {
    // SAFETY: a device's registers, always there; their owner never runs again.
    let port = unsafe { &*pac::GPIOC::ptr() };
    // SAFETY: sets one pin and leaves the others.
    port.bsrr()
        .write(|w| unsafe { w.bits(motor::switch_off()) });
    if crash == Crash::Clock {
        slow_down();
    }
    let before = retained::load();
    retained::store(BootRecord { crash, ..before });
    retained::store_crash(CrashRecord {
        crash,
        boot: before.boots,
        site,
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
