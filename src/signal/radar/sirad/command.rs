//! Commands that set up a SiRad module.
//!
//! A command is `!`, a letter, for some letters 32 bits as eight hexadecimal digits, CR and LF. The layout of
//! the bits is that of firmware 1.4 (System & Protocol Description 2.4, command frames); reserved bits are 0.

/// Maximum bandwidth that can be requested, kHz: the band of the chip, about 119 to 126 GHz.
pub const MAX_KHZ: u32 = 7_000_000;
/// Default bandwidth, kHz: that of the kit's own captures, and below the 6.1 GHz that its command `!K` found.
pub const USUAL_KHZ: u32 = 6_000_000;
/// Resolution of the ramp's bandwidth, kHz.
pub const STEP_KHZ: u32 = 2_000;

/// Minimum number of samples of a ramp; a code k stands for 2^k times this.
const FEWEST: u16 = 32;
/// Code of 256 samples of a ramp, the maximum of a chirp.
const MAX_SAMPLES_CODE: u32 = 3;

/// A command with 32 bits, as it is sent: `!`, letter, eight hexadecimal digits, CR, LF.
pub type CommandLine = [u8; 12];

/// Command for one measurement: both triggers at once.
pub const TRIGGER: &[u8] = b"!N\r\n";
/// Command for the system info; the module answers it after all earlier commands.
pub const INFO: &[u8] = b"!I\r\n";

/// Bits of the system configuration:
///
/// | bits | meaning | value used |
/// |---|---|---|
/// | 31..29 | delay of the self trigger | 0 |
/// | 27 | linear magnitude | 1 |
/// | 26 | target list in mm (0) or cm | 0 |
/// | 25..24 | LEDs | off |
/// | 19..17 | output: 0 WebGUI, 1 TSV, 2 binary | 2 |
/// | 16 | automatic gain: rows would not be comparable | 0 |
/// | 15..14 | gain: 8, 21, 43 or 56 dB | 21 dB |
/// | 13, 12 | second, first serial port | both |
/// | 11..4 | frames: error, status, targets, CFAR, range, phase, complex, raw | error, status, raw |
/// | 1 | self trigger | 0 |
/// | 0 | pre-trigger | 0 |
const SYSTEM: u32 = 1 << 27 | 2 << 17 | 1 << 14 | 3 << 12 | 1 << 11 | 1 << 10 | 1 << 4;

/// Returns the system configuration [`SYSTEM`] as a command.
pub fn system() -> CommandLine {
    line(b'S', SYSTEM)
}

/// Returns the command of the baseband configuration for `2^code` times [`FEWEST`] samples:
///
/// | bits | meaning | value used |
/// |---|---|---|
/// | 31, 30 | window and filter of the module's own processing | off |
/// | 29 | subtract the converter's mean | on |
/// | 28..12 | CFAR, averages and points of the module's own processing | 0 |
/// | 11..9 | downsampling | none |
/// | 8..6 | ramps per measurement: 1, 2, 4 … | 1 |
/// | 5..3 | samples per ramp: 32, 64, 128 … | `code` |
/// | 2..0 | cycles of 36 MHz per sample: 14, 15, 17 … | 14 |
pub fn baseband(code: u32) -> CommandLine {
    line(b'B', 1 << 29 | (code & 7) << 3)
}

/// Returns the command that sets the ramp's bandwidth to `bandwidth_khz`: 16 bits in steps of [`STEP_KHZ`],
/// upwards.
pub fn ramp(bandwidth_khz: u32) -> CommandLine {
    line(b'P', (bandwidth_khz / STEP_KHZ) & 0x7FFF)
}

/// Returns the code of a ramp's number of samples, `2^code` times [`FEWEST`]: the largest that does not exceed
/// `samples`, but at least 32; the maximum for 0.
pub fn code(samples: u16) -> u32 {
    match samples {
        0 => MAX_SAMPLES_CODE,
        _ => (samples / FEWEST).max(1).ilog2().min(MAX_SAMPLES_CODE),
    }
}

fn line(letter: u8, bits: u32) -> CommandLine {
    let mut line = *b"!.00000000\r\n";
    let [_, at, digits @ ..] = &mut line;
    *at = letter;
    for (k, digit) in digits.iter_mut().take(8).enumerate() {
        let nibble = (bits >> (28 - 4 * k) & 15) as u8;
        *digit = match nibble {
            0..10 => b'0' + nibble,
            _ => b'A' - 10 + nibble,
        };
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_as_documented() {
        assert_eq!(&system(), b"!S08047C10\r\n");
        // One ramp of 32, 64, 128 or 256 samples, with the mean subtracted.
        assert_eq!(&baseband(0), b"!B20000000\r\n");
        assert_eq!(&baseband(1), b"!B20000008\r\n");
        assert_eq!(&baseband(2), b"!B20000010\r\n");
        assert_eq!(&baseband(3), b"!B20000018\r\n");
        // 6 GHz in steps of 2 MHz.
        assert_eq!(&ramp(6_000_000), b"!P00000BB8\r\n");
        assert_eq!(&ramp(6_001_999), b"!P00000BB8\r\n");
        // Never a downward ramp.
        assert_eq!(&ramp(u32::MAX)[..6], b"!P0000");
    }

    #[test]
    fn no_more_samples_than_wished() {
        let samples = |requested| 32 << code(requested);
        assert_eq!(samples(0), 256);
        for (requested, got) in [
            (16, 32),
            (32, 32),
            (63, 32),
            (64, 64),
            (200, 128),
            (256, 256),
            (u16::MAX, 256),
        ] {
            assert_eq!(samples(requested), got, "{requested}");
        }
    }
}
