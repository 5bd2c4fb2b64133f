//! Resource budgets of the image, defined only here. `budget` and `bench` check them, `timing`
//! calculates with them, and the linker enforces those of the memory (`memory.x`).

/// Maximum flash use of the firmware image, bytes: a slot of 384 KB less the 512 bytes of its signed header.
pub const FLASH: u64 = 384 * 1024 - 512;
/// Maximum flash of the boot loader, bytes, without its vector table, which lies in another sector:
/// one sector of 64 KB.
pub const LOADER: u64 = 64 * 1024;
/// Maximum static RAM, bytes: the chip's 128 KB less the stack and the handover to the boot loader.
pub const RAM: u64 = 110 * 1024 - 192;
/// Size of the stack, bytes, without the 32 guard bytes below it.
pub const STACK_SIZE: u64 = 18 * 1024 + 128;
/// Maximum stack use, bytes: 2 KB stay unused in the worst measured case.
pub const STACK: u64 = STACK_SIZE - 2 * 1024;

/// Maximum number of instructions of a 256-point FFT.
pub const FFT256: u64 = 10_000;
/// Maximum number of instructions from a chirp's samples to its row of map and coherent image: 0.45 ms at 168 MHz.
pub const CHIRP: u64 = 75_000;
/// Maximum number of instructions from the samples of a real-valued chirp to its row of the map,
/// without the health checks of the instrument: 0.19 ms.
pub const CHIRP_REAL: u64 = 32_000;
/// Maximum number of instructions from the last row to the complete report: 30 ms at 168 MHz; a scan
/// takes seconds.
pub const POST: u64 = 5_000_000;
/// Maximum number of instructions from the last row of a guard sweep to its `GUARD` sentence: 5 ms at
/// 168 MHz.
pub const GUARD: u64 = 600_000;
