//! The chip's flash controller, option bytes and voltage detector: registers for the driver in [`super::flash`].

use core::ptr;

use stm32f4xx_hal::pac;

use super::flash::{Controller, Register};

/// Wait for the end of an operation: image and loader measure time by different means.
pub trait Wait {
    /// Waits until `ended` returns `true`, or for `at_most_us` µs; returns whether it ended.
    fn wait(at_most_us: u32, ended: impl FnMut() -> bool) -> bool;
}

/// The chip's controller, whose waits are those of `W`.
#[derive(Debug)]
pub struct Chip<W>(pub W);

fn flash() -> &'static pac::flash::RegisterBlock {
    // SAFETY: a device's registers, always there; once the clocks are set up, the flash driver alone writes them,
    // in no interrupt.
    unsafe { &*pac::FLASH::ptr() }
}

/// Returns the content of FLASH_OPTCR (RM0090 3.9), into which the chip loads its option bytes at reset.
pub fn option_bytes() -> u32 {
    flash().optcr().read().bits()
}

impl<W: Wait> Controller for Chip<W> {
    fn get(&self, register: Register) -> u32 {
        match register {
            Register::Access => flash().acr().read().bits(),
            // Write-only.
            Register::Key => 0,
            Register::Status => flash().sr().read().bits(),
            Register::Control => flash().cr().read().bits(),
        }
    }

    fn set(&mut self, register: Register, value: u32) {
        match register {
            // SAFETY: the driver changes the caches' bits only, in the order of the reference manual.
            Register::Access => flash().acr().write(|w| unsafe { w.bits(value) }),
            Register::Key => flash().keyr().write(|w| w.key().set(value)),
            // SAFETY: ones clear flags, zeros leave the others.
            Register::Status => flash().sr().write(|w| unsafe { w.bits(value) }),
            // Not from the reset value: `value` is all of the register, made from what the driver read.
            // SAFETY: as the reference manual has it, tested on a model of the register.
            Register::Control => flash().cr().write(|w| unsafe { w.bits(value) }),
        };
    }

    fn write_word(&mut self, address: u32, word: u32) {
        // SAFETY: within the driver's region, on a word's bounds; no code and no variable is there.
        unsafe { ptr::write_volatile(address as *mut u32, word) };
        // The write passes the processor's buffer before the busy flag is read.
        cortex_m::asm::dsb();
    }

    fn fetch(&self, address: u32, bytes: &mut [u8]) {
        // SAFETY: within the driver's region, which is always mapped; nobody writes there meanwhile, and any bits
        // are bytes.
        bytes.copy_from_slice(unsafe {
            core::slice::from_raw_parts(address as *const u8, bytes.len())
        });
    }

    fn supplied(&self) -> bool {
        // SAFETY: a device's registers, always there; reading this one changes nothing.
        let pwr = unsafe { &*pac::PWR::ptr() };
        pwr.csr().read().pvdo().bit_is_clear()
    }

    fn wait(&self, at_most_us: u32, ended: impl FnMut() -> bool) -> bool {
        W::wait(at_most_us, ended)
    }
}
