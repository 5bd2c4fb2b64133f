//! Converts an ELF file to the bytes of either slot.
//!
//! The image is linked for slot A. For slot B nothing is compiled or linked again: the linker
//! leaves its relocations in the file, and every address of code or constants in the image is moved
//! by the distance of the slots. That distance is a multiple of 64 KB, so that only the upper half
//! of an address in two instructions (`movw`, `movt`) changes. A relocation of an unknown kind is
//! an error, never a guess.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use object::read::elf::{ElfFile32, ProgramHeader};
use object::read::{Object, ObjectSection, ObjectSymbol};
use object::{Endianness, RelocationFlags, RelocationTarget, elf};
use stairscan::scanner::seal::{BLANK, CODE, CODE_END, SLOT, VECTORS, WORDS, seal};
use stairscan_boot::header::PAYLOAD;
use stairscan_boot::layout;
use stairscan_boot::slot::Slot;

use crate::recording::regular;

/// Distance of slot B's address from that of slot A, bytes.
const DISTANCE: u32 = layout::SLOT;
const _: () = assert!(DISTANCE.is_multiple_of(0x1_0000) && SLOT == layout::SLOTS);
/// Offset of the seal (the image's own checksum) in a payload, bytes.
const SEAL: usize = 0x200;

/// Bytes of an image after its header, for one slot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Payload(pub Vec<u8>);

/// Returns the payloads for slot A and slot B of an ELF file.
///
/// # Errors
/// Names the file: no ELF file, not linked for slot A, or with a relocation of an unknown kind.
pub fn read(elf: &Path) -> Result<[Payload; 2]> {
    regular(elf)?;
    let name = || elf.display().to_string();
    let bytes = fs::read(elf).with_context(name)?;
    parse(&bytes).with_context(name)
}

/// Returns the flash address of a slot.
pub fn address(slot: Slot) -> u32 {
    match slot {
        Slot::A => SLOT,
        Slot::B => SLOT + DISTANCE,
    }
}

/// Reads the payload for both slots from the bytes of an ELF file.
///
/// # Errors
/// Names what is wrong: no ELF file, not linked for slot A, an unknown relocation.
pub fn parse(bytes: &[u8]) -> Result<[Payload; 2]> {
    let file = ElfFile32::<Endianness>::parse(bytes).context("no ELF file of 32 bits")?;
    let image = Loaded::new(&file)?;
    let mut moved = image.payload.clone();
    relocate(&file, &image, &mut moved)?;
    reseal(&mut moved)?;
    Ok([Payload(image.payload), Payload(moved)])
}

/// The segments of an ELF file that are written to slot A.
struct Loaded {
    /// Bytes of the payload for slot A; 0xFF between the segments.
    payload: Vec<u8>,
    /// Segments: first address at which the segment runs, the address after its last, and the
    /// offset of its bytes in `payload`.
    places: Vec<(u32, u32, usize)>,
}

impl Loaded {
    fn new(file: &ElfFile32<'_, Endianness>) -> Result<Self> {
        let (endian, data) = (file.endian(), file.data());
        let room = (layout::SLOT - PAYLOAD) as usize;
        let mut payload = vec![0xff; room];
        let (mut places, mut end) = (Vec::new(), 0);
        for header in file.elf_program_headers() {
            let (at, size) = (header.p_paddr(endian), header.p_filesz(endian));
            if header.p_type(endian) != elf::PT_LOAD || size == 0 || at == SLOT {
                continue;
            }
            let bytes = header.data(endian, data);
            let bytes = bytes.map_err(|()| anyhow::anyhow!("a segment beyond the file's end"))?;
            let offset = at.checked_sub(SLOT + PAYLOAD).map(|o| o as usize);
            let place = offset.and_then(|o| payload.get_mut(o..o + bytes.len()));
            let (Some(offset), Some(place)) = (offset, place) else {
                bail!("a segment at 0x{at:08x}: not linked for slot A, or longer than a slot");
            };
            place.copy_from_slice(bytes);
            end = end.max(offset + bytes.len());
            let from = header.p_vaddr(endian);
            places.push((from, from.saturating_add(size), offset));
        }
        let least = SEAL + size_of_val(&BLANK);
        ensure!(
            end >= least,
            "no image: {end} bytes are loaded into slot A, expected at least {least}"
        );
        payload.truncate(end.next_multiple_of(4));
        Ok(Self { payload, places })
    }

    /// Returns the offset in the payload of the byte that runs at `address`; `None` outside of all
    /// segments.
    fn offset(&self, address: u32) -> Option<usize> {
        let places = self.places.iter();
        let place = places
            .copied()
            .find(|&(from, to, _)| (from..to).contains(&address));
        place.map(|(from, _, offset)| offset + (address - from) as usize)
    }
}

/// Whether an address is one of code or constants, which moves with the slot. The address after the
/// last one counts too, because symbols of the linker mark ends.
fn moves(address: u32) -> bool {
    (SLOT..=CODE_END).contains(&address)
}

fn relocate(file: &ElfFile32<'_, Endianness>, image: &Loaded, moved: &mut [u8]) -> Result<()> {
    let mut count = 0;
    for section in file.sections() {
        for (at, relocation) in section.relocations() {
            let Some(offset) = u32::try_from(at).ok().and_then(|at| image.offset(at)) else {
                continue;
            };
            let RelocationFlags::Elf { r_type } = relocation.flags() else {
                bail!("a relocation at 0x{at:08x} that is none of ELF");
            };
            let target = match relocation.target() {
                RelocationTarget::Symbol(index) => file.symbol_by_index(index)?.address() as u32,
                _ => 0,
            };
            let field = moved.get_mut(offset..offset + 4);
            let field: &mut [u8; 4] = field
                .and_then(|f| f.try_into().ok())
                .context("a cut field")?;
            apply(r_type, moves(target), field).with_context(|| format!("at 0x{at:08x}"))?;
            count += 1;
        }
    }
    ensure!(
        count > 0,
        "no relocations: without them an image cannot be moved to slot B"
    );
    Ok(())
}

/// Relocates one field of the payload for slot B. `moves` says whether its target moves with the
/// slot (ELF for the Arm architecture, table "Relocation codes").
fn apply(kind: elf::RelocationType, moves: bool, field: &mut [u8; 4]) -> Result<()> {
    match kind {
        elf::R_ARM_NONE | elf::R_ARM_V4BX => {}
        elf::R_ARM_ABS32 | elf::R_ARM_TARGET1 if moves => {
            let word = u32::from_le_bytes(*field);
            ensure!(
                self::moves(word & !1),
                "an address 0x{word:08x} outside of the slot"
            );
            *field = (word + DISTANCE).to_le_bytes();
        }
        // The lower half of an address does not change.
        elf::R_ARM_ABS32 | elf::R_ARM_TARGET1 | elf::R_ARM_THM_MOVW_ABS_NC => {}
        elf::R_ARM_THM_MOVT_ABS if moves => {
            let upper = upper_half(field);
            ensure!(
                self::moves(u32::from(upper) << 16 | 0xffff & SLOT),
                "an address 0x{upper:04x}…. outside of the slot"
            );
            set_upper_half(field, upper + (DISTANCE >> 16) as u16);
        }
        elf::R_ARM_THM_MOVT_ABS => {}
        // From code to code, which move together.
        elf::R_ARM_THM_PC22
        | elf::R_ARM_THM_JUMP24
        | elf::R_ARM_THM_JUMP19
        | elf::R_ARM_THM_PC11
        | elf::R_ARM_THM_PC9
        | elf::R_ARM_PREL31
        | elf::R_ARM_REL32
            if moves => {}
        other => bail!("a relocation of kind {other:?}, which is not known"),
    }
    Ok(())
}

/// Returns the 16-bit immediate of the instruction `movt` (Armv7-M, A7.7.79, encoding T1):
/// imm4:i:imm3:imm8.
fn upper_half(field: &[u8; 4]) -> u16 {
    let [a, b, c, d] = *field;
    let (first, second) = (u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]));
    (first & 0xf) << 12 | (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xff
}

fn set_upper_half(field: &mut [u8; 4], value: u16) {
    let [a, b, c, d] = *field;
    let (first, second) = (u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]));
    let first = first & !0x040f | value >> 12 | (value >> 11 & 1) << 10;
    let second = second & !0x70ff | (value >> 8 & 7) << 12 | value & 0xff;
    let [a, b] = first.to_le_bytes();
    let [c, d] = second.to_le_bytes();
    *field = [a, b, c, d];
}

/// Replaces the seal in the payload for slot B by that of the relocated bytes; a blank seal stays
/// blank.
fn reseal(moved: &mut [u8]) -> Result<()> {
    let at = SEAL..SEAL + 4 * WORDS;
    let (words, _) = moved[at.clone()].as_chunks::<4>();
    let words: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
    if words == BLANK {
        return Ok(());
    }
    let [_, vectors_end, code_end, _] = words[..] else {
        bail!("no seal");
    };
    let part = |from: u32, to: u32| {
        let at = |address: u32| Some(address.checked_sub(VECTORS)? as usize);
        at(from)
            .zip(at(to))
            .and_then(|(from, to)| moved.get(from..to))
    };
    let parts = part(VECTORS, vectors_end).zip(part(CODE, code_end));
    // A seal that is damaged stays so.
    let Some(whole) = parts.and_then(|(vectors, code)| seal(vectors, code)) else {
        return Ok(());
    };
    moved[at].copy_from_slice(whole.map(u32::to_le_bytes).as_flattened());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_upper_half_of_an_address_is_replaced_and_nothing_else() {
        for register in 0..15_u8 {
            for value in [0, 0x0802, 0x0807, 0x1234, 0xf8ff, 0xffff] {
                // movt rD, #0
                let mut field = [0xc0, 0xf2, 0x00, register];
                set_upper_half(&mut field, value);
                assert_eq!(upper_half(&field), value);
                assert_eq!(field[3] & 0x8f, register);
                set_upper_half(&mut field, 0);
                assert_eq!(field, [0xc0, 0xf2, 0x00, register]);
            }
        }
        // movt r1, #0x0802 as an assembler has it.
        assert_eq!(upper_half(&[0xc0, 0xf6, 0x02, 0x01]), 0x0802);
    }
}
