//! What the image may take of the chip: the one place that says so. `budget` and `bench` check it,
//! `timing` computes with it, and the linker enforces the memory (`memory.x`).

/// Most bytes of flash, of the chip's 1 MB.
pub const FLASH: u64 = 384 * 1024;
/// Bytes of flash that the boot loader may take beside its vector table: one sector.
pub const LOADER: u64 = 64 * 1024;
/// Most bytes of static RAM: what the stack and the handover to the boot loader leave of the chip's 128 KB.
pub const RAM: u64 = 110 * 1024 - 64;
/// Bytes of the stack, less the guard of 32 below it.
pub const STACK_SIZE: u64 = 18 * 1024;
/// Most bytes of the stack in use: 2 KB stay unused in the worst measured case.
pub const STACK: u64 = STACK_SIZE - 2 * 1024;

/// Most instructions of one transform of 256 points.
pub const FFT256: u64 = 10_000;
/// Most instructions from a chirp's samples to its finished row of the map: 0.15 ms at 168 MHz.
pub const CHIRP: u64 = 25_000;
/// Most instructions from the values of a real chirp to its row of the map, without the health of the
/// instrument: 0.19 ms.
pub const CHIRP_REAL: u64 = 32_000;
/// Most instructions from the last row to the finished report: 30 ms at 168 MHz, beside scans of
/// seconds.
pub const POST: u64 = 5_000_000;
/// Most instructions from the last row of a guard sweep to its word: 5 ms at 168 MHz.
pub const GUARD: u64 = 600_000;
