//! Content of the chip's flash as files for other programs: Intel HEX, and raw bytes for an address.

use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::{Context, Result, ensure};
use ed25519_dalek::SigningKey;
use ihex::Record;
use stairscan_boot::layout::{LOADER_VECTORS, SLOTS};
use stairscan_boot::slot::Slot;

use super::package::Package;
use crate::emulate::seal::segments;

/// Number of bytes in a record of Intel HEX: what all programs that write flash accept.
const RECORD: usize = 16;
/// Number of bytes that an address in a record of Intel HEX covers without another record for its upper half.
const BANK: usize = 0x1_0000;
/// Largest gap between two segments that is filled with erased bytes, bytes: what alignment leaves, and less than a sector.
const GAP: u32 = 1024;
/// Value of an erased byte of flash.
const ERASED: u8 = 0xff;

/// Contiguous bytes in flash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Address of the first byte.
    pub address: u32,
    /// Content of the flash from there on.
    pub bytes: Vec<u8>,
}

impl Block {
    /// Returns the address after the last byte.
    fn end(&self) -> u32 {
        self.address + self.bytes.len() as u32
    }

    /// Returns the blocks of an ELF file in the order of their addresses; small gaps are filled with erased bytes.
    ///
    /// # Errors
    /// Names the file, which is no ELF file or loads nothing.
    pub fn of_elf(elf: &Path) -> Result<Vec<Self>> {
        let mut blocks: Vec<Self> = Vec::new();
        for (address, bytes) in segments(elf)? {
            match blocks.last_mut() {
                Some(last)
                    if address
                        .checked_sub(last.end())
                        .is_some_and(|gap| gap <= GAP) =>
                {
                    last.bytes.resize((address - last.address) as usize, ERASED);
                    last.bytes.extend(bytes);
                }
                _ => blocks.push(Self { address, bytes }),
            }
        }
        ensure!(!blocks.is_empty(), "{}: loads nothing", elf.display());
        Ok(blocks)
    }
}

/// Returns the blocks of boot loader and image as a debug probe writes them: the image sealed, signed with `key`, and
/// confirmed in slot A.
///
/// # Errors
/// Names the file that is no loader or no image.
pub fn flash(loader: &Path, image: &Path, key: &SigningKey) -> Result<Vec<Block>> {
    let mut blocks = Block::of_elf(loader)?;
    let package = Package::sign(image, 0, key)?;
    let bytes = package.image(Slot::A).slot(confirmation());
    blocks.push(Block {
        address: SLOTS,
        bytes,
    });
    Ok(blocks)
}

/// Returns the confirmation number of an image that is flashed now, seconds since 1970. Of two confirmed images that with
/// the higher number runs, and updates count on from there.
pub fn confirmation() -> u32 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(1, |now| now.as_secs() as u32)
}

/// Returns all of `blocks` as one, from the beginning of the flash; between them erased bytes.
pub fn whole(blocks: &[Block]) -> Block {
    let mut bytes = Vec::new();
    for block in blocks {
        let from = (block.address - LOADER_VECTORS) as usize;
        let to = from + block.bytes.len();
        bytes.resize(bytes.len().max(to), ERASED);
        bytes[from..to].copy_from_slice(&block.bytes);
    }
    Block {
        address: LOADER_VECTORS,
        bytes,
    }
}

/// Returns `blocks` as text in the format Intel HEX with 32-bit addresses; nothing between them is written.
///
/// # Errors
/// The writer of the format fails.
pub fn intel_hex(blocks: &[Block]) -> Result<String> {
    let mut records = Vec::new();
    for block in blocks {
        let mut rest = block.bytes.as_slice();
        let mut at = block.address;
        let mut bank = None;
        while !rest.is_empty() {
            let (upper, offset) = ((at >> 16) as u16, at as u16);
            if bank.replace(upper) != Some(upper) {
                records.push(Record::ExtendedLinearAddress(upper));
            }
            let count = rest.len().min(RECORD).min(BANK - usize::from(offset));
            let (value, behind) = rest.split_at(count);
            records.push(Record::Data {
                offset,
                value: value.to_vec(),
            });
            (rest, at) = (behind, at + count as u32);
        }
    }
    records.push(Record::EndOfFile);
    ihex::create_object_file_representation(&records).context("Intel HEX")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Returns the bytes of a file in Intel HEX by address.
    fn read(text: &str) -> BTreeMap<u32, u8> {
        let (mut bytes, mut upper, mut ended) = (BTreeMap::new(), 0, false);
        for record in ihex::Reader::new(text) {
            assert!(!ended, "something after the end");
            match record.unwrap() {
                Record::ExtendedLinearAddress(half) => upper = u32::from(half) << 16,
                Record::Data { offset, value } => {
                    let from = upper + u32::from(offset);
                    let placed = (from..).zip(value);
                    placed.for_each(|(at, byte)| assert_eq!(bytes.insert(at, byte), None));
                }
                Record::EndOfFile => ended = true,
                other => panic!("{other:?}"),
            }
        }
        assert!(ended);
        bytes
    }

    fn block(address: u32, count: usize) -> Block {
        let bytes = (0..count).map(|k| (k * 7 + count) as u8).collect();
        Block { address, bytes }
    }

    #[test]
    fn what_is_written_is_read_back_and_nothing_else() {
        for blocks in [
            vec![block(0x0800_0000, 1)],
            vec![block(0x0800_0000, 0x1a8), block(0x0801_0000, 70_000)],
            // A record does not go over the bounds of 64 KB, which an unaligned block would have it do.
            vec![block(0x0801_fff9, 40), block(0x0802_fff0, 16)],
        ] {
            let all = blocks
                .iter()
                .flat_map(|b| (b.address..).zip(b.bytes.clone()));
            assert_eq!(read(&intel_hex(&blocks).unwrap()), all.collect());
            let whole = whole(&blocks);
            assert_eq!(whole.end(), blocks.last().unwrap().end());
            for block in &blocks {
                let from = (block.address - whole.address) as usize;
                assert_eq!(whole.bytes[from..][..block.bytes.len()], block.bytes);
            }
        }
        let two = [block(0x0800_0000, 2), block(0x0800_0004, 1)];
        assert_eq!(whole(&two).bytes[2..4], [ERASED; 2]);
    }
}
