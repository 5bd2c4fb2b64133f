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

/// Returns the hash of a place in the source, such as that of a panic: the CRC-32 of the file's name, then line and
/// column as little-endian words.
pub fn of_place(file: &str, line: u32, column: u32) -> u32 {
    of_parts(&[file.as_bytes(), &line.to_le_bytes(), &column.to_le_bytes()])
}

/// Returns the CRC-32 of words, each little-endian.
pub fn of_words(words: &[u32]) -> u32 {
    let mut digest = CRC32.digest();
    for byte in words.iter().flat_map(|word| word.to_le_bytes()) {
        digest.update(&[byte]);
    }
    digest.finalize()
}
