//! Addresses in the flash of the STM32F405 (RM0090, table 5): sectors 0 to 3 of 16 KB, 4 of 64 KB, 5 to 11 of 128 KB.
//!
//! | sectors | bytes from | what |
//! |---|---|---|
//! | 0 | 0x08000000 | the loader's vector table |
//! | 1, 2 | 0x08004000 | settings |
//! | 3 | 0x0800c000 | anti-rollback counter |
//! | 4 | 0x08010000 | the loader |
//! | 5 to 7 | 0x08020000 | slot A |
//! | 8 to 10 | 0x08080000 | slot B |
//! | 11 | 0x080e0000 | free |

/// Start of the loader's vector table.
pub const LOADER_VECTORS: u32 = 0x0800_0000;
/// Start of the anti-rollback counter.
pub const FLOOR: u32 = 0x0800_c000;
/// Bytes of the anti-rollback counter's sector.
pub const FLOOR_SECTOR: usize = 16 * 1024;
/// Number of the anti-rollback counter's sector.
pub const FLOOR_NUMBER: u8 = 3;
/// Start of slot A.
pub const SLOTS: u32 = 0x0802_0000;
/// Bytes of a sector of the slots.
pub const SLOT_SECTOR: usize = 128 * 1024;
/// Number of the first sector of the slots.
pub const SLOT_NUMBER: u8 = 5;
/// Sectors of a slot: the budget of the image is 384 KB.
pub const SECTORS_PER_SLOT: u32 = 3;
/// Bytes of a slot.
pub const SLOT: u32 = SECTORS_PER_SLOT * SLOT_SECTOR as u32;
/// Board identifier in the header of an image: the STM32F405 of this board. Each board has its own.
pub const CHIP: u32 = u32::from_le_bytes(*b"F405");
