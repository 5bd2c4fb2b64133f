//! Devices that are recognised by a line of text that they send: those with NMEA 0183, and computers that boot.

/// Talkers of NMEA 0183: the two letters after `$` or `!`, and the device.
const TALKERS: [(&str, &str); 18] = [
    ("AI", "an AIS receiver"),
    ("BD", "a BeiDou receiver"),
    ("GA", "a Galileo receiver"),
    ("GB", "a BeiDou receiver"),
    ("GL", "a GLONASS receiver"),
    ("GN", "a GNSS receiver"),
    ("GP", "a GPS receiver"),
    ("GQ", "a QZSS receiver"),
    ("HC", "a magnetic compass"),
    ("HE", "a gyrocompass"),
    ("II", "an integrated instrument"),
    ("IN", "an integrated navigation system"),
    ("QZ", "a QZSS receiver"),
    ("SD", "a depth sounder"),
    ("TI", "a rate-of-turn indicator"),
    ("VW", "a speed log"),
    ("WI", "a weather instrument"),
    ("YX", "a transducer"),
];
/// Beginnings of proprietary sentences of NMEA 0183, and their maker.
const PROPRIETARY: [(&str, &str); 4] = [
    ("PGRM", "Garmin"),
    ("PMTK", "MediaTek"),
    ("PSRF", "SiRF"),
    ("PUBX", "u-blox"),
];
/// Texts of computers, and what each is of.
const CONSOLES: [(&str, &str); 3] = [
    ("U-Boot ", "the boot loader U-Boot"),
    ("[    0.000000] ", "the Linux kernel"),
    ("login: ", "a computer's console"),
];
/// Length of the type of sentence that follows the talker.
const FORMATTER: usize = 3;

/// Returns the name of the device that sent the line; `None` if it is not recognised.
pub fn known(line: &str) -> Option<String> {
    if let Some(device) = nmea(line) {
        return Some(device);
    }
    let (_, console) = CONSOLES.iter().find(|(text, _)| line.contains(text))?;
    Some((*console).to_owned())
}

/// Returns the name of the device that sent the line, or that it is another one than a scanner.
pub fn sender(line: &str) -> String {
    known(line).unwrap_or_else(|| "another device".to_owned())
}

/// Returns the device whose sentence of NMEA 0183 a line holds, with its talker. The checksum is not compared: a damaged
/// sentence names its device, too.
fn nmea(line: &str) -> Option<String> {
    let begin = line.find(['$', '!'])?;
    let (address, _) = line[begin + 1..].split_once(',')?;
    let formed = |byte: u8| byte.is_ascii_uppercase() || byte.is_ascii_digit();
    if !address.bytes().all(formed) {
        return None;
    }
    if let Some((mark, maker)) = PROPRIETARY
        .iter()
        .find(|(mark, _)| address.starts_with(mark))
    {
        return Some(format!("a GPS receiver (NMEA 0183, {mark} of {maker})"));
    }
    let (talker, device) = TALKERS.iter().find(|(talker, _)| {
        address.starts_with(talker) && address.len() == talker.len() + FORMATTER
    })?;
    Some(format!("{device} (NMEA 0183, talker {talker})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_talkers_are_named_and_others_are_not() {
        for (line, device) in [
            (
                "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47",
                "a GPS receiver (NMEA 0183, talker GP)",
            ),
            // Without its end.
            ("$GNRMC,", "a GNSS receiver (NMEA 0183, talker GN)"),
            (
                "12:00:01 !AIVDM,1,1,,B,x,0*5C",
                "an AIS receiver (NMEA 0183, talker AI)",
            ),
            ("$PUBX,00,*33", "a GPS receiver (NMEA 0183, PUBX of u-blox)"),
            ("U-Boot 2024.01", "the boot loader U-Boot"),
            ("board login: ", "a computer's console"),
            ("GPGGA,1,2", "another device"),
            ("$GPGGA", "another device"),
            ("$GPgga,1", "another device"),
            ("$GPGGAX,1", "another device"),
            ("$PSTR,LIVE,scanning", "another device"),
            ("$ZZABC,1*00", "another device"),
            ("", "another device"),
            ("\u{e9}$\u{e9},", "another device"),
        ] {
            assert_eq!(sender(line), device, "{line}");
        }
    }

    #[test]
    fn each_talker_has_one_row() {
        assert!(TALKERS.is_sorted_by(|(a, _), (b, _)| a < b));
        assert!(PROPRIETARY.is_sorted_by(|(a, _), (b, _)| a < b));
    }
}
