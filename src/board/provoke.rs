//! Test builds only: provokes faults on request, to test the fault path.
//!
//! A control byte on the report port provokes one fault; release images contain none of this.

use core::hint::black_box;

use stairscan::scanner::BytePort;

/// Control byte: overflows the stack.
const OVERFLOW: u8 = 0x01;
/// Control byte: panics.
const PANIC: u8 = 0x02;
/// Control byte: loops for ever, so that the watchdog resets the chip.
const HANG: u8 = 0x03;
/// Control byte: executes code in RAM.
const EXECUTE: u8 = 0x04;

/// The report port with a filter for the control bytes.
#[derive(Debug)]
pub struct Trap<P>(pub P);

impl<P: BytePort> BytePort for Trap<P> {
    fn read(&mut self) -> Option<u8> {
        let byte = self.0.read()?;
        match byte {
            OVERFLOW => {
                black_box(descend(0));
            }
            PANIC => panic!(),
            HANG => loop {
                cortex_m::asm::nop();
            },
            EXECUTE => execute(),
            _ => {}
        }
        Some(byte)
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        self.0.write(bytes)
    }

    fn errors(&self) -> u16 {
        self.0.errors()
    }
}

/// Calls an instruction on the stack: `bx lr`.
fn execute() {
    let code = black_box([0x4770_u16; 2]);
    // Thumb code has odd addresses.
    let place = (&raw const code).addr() + 1;
    // SAFETY: the test is whether the call is executed at all; it would only return.
    let function: extern "C" fn() = unsafe { core::mem::transmute(place) };
    function();
}

/// Recurses without end: each call keeps data on the stack that is needed after the next one.
#[inline(never)]
#[allow(unconditional_recursion)]
fn descend(depth: u32) -> u32 {
    let frame = black_box([depth; 32]);
    let deeper = descend(depth.wrapping_add(1));
    frame.iter().fold(deeper, |sum, &x| sum.wrapping_add(x))
}
