//! CRC-32, the checksum of sentences, commands, records and the radar link's frames.

/// CRC-32 (ISO-HDLC) by a table of 256 words: some eight instructions a byte.
pub static CRC32: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// Returns the CRC-32 of all parts, concatenated.
pub fn of_parts(parts: &[&[u8]]) -> u32 {
    let mut digest = CRC32.digest();
    for part in parts {
        digest.update(part);
    }
    digest.finalize()
}

/// Returns the CRC-32 of words, each little-endian.
pub fn of_words(words: &[u32]) -> u32 {
    let mut digest = CRC32.digest();
    for byte in words.iter().flat_map(|word| word.to_le_bytes()) {
        digest.update(&[byte]);
    }
    digest.finalize()
}
