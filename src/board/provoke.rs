//! Test builds only: faults on command, to see that the fault path works.
//!
//! A control byte on the report port provokes one; the image itself holds none of this.

use core::hint::black_box;

use stairscan::scanner::BytePort;

/// Overflows the stack.
const OVERFLOW: u8 = 0x01;
/// Panics.
const PANIC: u8 = 0x02;
/// Never comes back: the watchdog's case.
const HANG: u8 = 0x03;
/// Executes what lies in RAM.
const EXECUTE: u8 = 0x04;

/// The report port with a trap in front.
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

/// Calls an instruction that lies on the stack: `bx lr`.
fn execute() {
    let code = black_box([0x4770_u16; 2]);
    // Code of this instruction set has odd addresses.
    let place = (&raw const code).addr() + 1;
    // SAFETY: whether it is ever executed is what is tested; it would only return.
    let function: extern "C" fn() = unsafe { core::mem::transmute(place) };
    function();
}

/// Recursion without end: each call keeps something on the stack that the next one needs.
#[inline(never)]
#[allow(unconditional_recursion)]
fn descend(depth: u32) -> u32 {
    let frame = black_box([depth; 32]);
    let deeper = descend(depth.wrapping_add(1));
    frame.iter().fold(deeper, |sum, &x| sum.wrapping_add(x))
}
