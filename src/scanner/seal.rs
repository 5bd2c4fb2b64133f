//! The image's seal: a checksum over all of it, checked at boot.
//!
//! The linker cannot know the checksum of what it links, so the image is built with a blank seal and
//! `cargo sim seal ELF` puts the right one in before it is flashed or emulated.
//!
//! | word | what (32 bits, little-endian) |
//! |---|---|
//! | 0 | `STCI` |
//! | 1 | end of the vector table, which begins behind the slot's header |
//! | 2 | end of code and constants, which begin behind the seal |
//! | 3 | CRC-32 (ISO-HDLC) of words 0 to 2, the vector table, code and constants |
//!
//! The addresses are those of slot A also where the image is linked for slot B.

use crate::crc;

/// Number of 32-bit words of a seal.
pub const WORDS: usize = 4;
/// Words in the place of the seal before one is put in: all ones.
pub const BLANK: [u32; WORDS] = [u32::MAX; WORDS];
/// Name of the seal's section in the image.
pub const SECTION: &str = ".seal";
/// Address of slot A, where the header of its image begins (`memory.x`).
pub const SLOT: u32 = 0x0802_0000;
/// Address of the vector table, behind the header of 512 bytes.
pub const VECTORS: u32 = SLOT + 0x200;
/// Maximum end of the vector table: the seal itself begins at this address (`memory.x`).
pub const VECTORS_END: u32 = VECTORS + 0x200;
/// Address of code and constants, behind the seal.
pub const CODE: u32 = VECTORS + 0x210;
/// Maximum end of code and constants: the end of the slot of 384 KB.
pub const CODE_END: u32 = SLOT + 384 * 1024;
/// First word of a seal, which identifies it as one.
const MAGIC: u32 = u32::from_le_bytes(*b"STCI");

/// State of an image by comparison with its seal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageState {
    /// The image is the one that was sealed.
    Whole,
    /// The image has not been sealed.
    Blank,
    /// The image has changed since it was sealed, or its seal is damaged.
    Damaged,
}

/// Returns the seal of an image with vector table `vectors`, which lies at [`VECTORS`], and `code`, which lies at
/// [`CODE`]; `None` if either is longer than its room.
pub fn seal(vectors: &[u8], code: &[u8]) -> Option<[u32; WORDS]> {
    let vectors_end = end(VECTORS, vectors.len(), VECTORS_END)?;
    let code_end = end(CODE, code.len(), CODE_END)?;
    let ends = [vectors_end, code_end];
    let [first, second] = ends;
    Some([MAGIC, first, second, sum(ends, vectors, code)])
}

/// Compares an image with its seal. `read` returns the image's bytes from a first address, [`VECTORS`] or
/// [`CODE`], up to a second one, at most [`VECTORS_END`] or [`CODE_END`].
pub fn judge<'a>(seal: [u32; WORDS], read: impl Fn(u32, u32) -> &'a [u8]) -> ImageState {
    let [magic, vectors_end, code_end, crc] = seal;
    if seal == BLANK {
        return ImageState::Blank;
    }
    let vectors = (VECTORS..=VECTORS_END).contains(&vectors_end);
    let code = (CODE..=CODE_END).contains(&code_end);
    if magic != MAGIC || !vectors || !code {
        return ImageState::Damaged;
    }
    let (vectors, code) = (read(VECTORS, vectors_end), read(CODE, code_end));
    match sum([vectors_end, code_end], vectors, code) == crc {
        true => ImageState::Whole,
        false => ImageState::Damaged,
    }
}

fn end(from: u32, length: usize, last: u32) -> Option<u32> {
    let end = from.checked_add(u32::try_from(length).ok()?)?;
    (end <= last).then_some(end)
}

fn sum(ends: [u32; 2], vectors: &[u8], code: &[u8]) -> u32 {
    let [first, second] = ends;
    let head = [MAGIC, first, second].map(u32::to_le_bytes);
    crc::of_parts(&[head.as_flattened(), vectors, code])
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn image() -> (Vec<u8>, Vec<u8>) {
        let bytes = |n: u32| (0..n).map(|k| ((k * 31) >> 3) as u8).collect();
        (bytes(0x188), bytes(1000))
    }

    fn judged(seal: [u32; WORDS], vectors: &[u8], code: &[u8]) -> ImageState {
        judge(seal, |from, to| {
            let bytes = if from == VECTORS { vectors } else { code };
            &bytes[..bytes.len().min((to - from) as usize)]
        })
    }

    #[test]
    fn an_image_is_whole_until_a_bit_of_it_changes() {
        let (vectors, code) = image();
        let good = seal(&vectors, &code).unwrap();
        assert_eq!(judged(good, &vectors, &code), ImageState::Whole);
        assert_eq!(judged(BLANK, &vectors, &code), ImageState::Blank);
        for bit in 0..32 * WORDS {
            let mut bad = good;
            bad[bit / 32] ^= 1 << (bit % 32);
            assert_eq!(
                judged(bad, &vectors, &code),
                ImageState::Damaged,
                "bit {bit}"
            );
        }
        for bit in 0..8 * (vectors.len() + code.len()) {
            let (mut vectors, mut code) = image();
            let byte = match vectors.get_mut(bit / 8) {
                Some(byte) => byte,
                None => &mut code[bit / 8 - 0x188],
            };
            *byte ^= 1 << (bit % 8);
            assert_eq!(
                judged(good, &vectors, &code),
                ImageState::Damaged,
                "bit {bit}"
            );
        }
    }

    #[test]
    fn what_is_too_long_has_no_seal() {
        let room = (CODE_END - CODE) as usize;
        assert!(seal(&[0; 0x200], &std::vec![0; room]).is_some());
        assert_eq!(seal(&[0; 0x204], &[]), None);
        assert_eq!(seal(&[], &std::vec![0; room + 1]), None);
    }
}
