//! The checksum of everything that the scanner says and hears.

/// CRC-32 (ISO-HDLC) of sentences, commands and the radar link's frames, by a table of 256 words:
/// some eight instructions a byte.
pub static CRC32: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
