//! Why a tap has no scan, from what it has received.

use stairscan::signal::radar::wire::LINK_BAUD;

use super::pace::Pace;
use super::scans::Tap;
use crate::live::talker::sender;
use crate::live::trouble::UnexpectedData;

/// Returns the reason, as text, why there is no scan to write.
pub fn nothing(tap: &Tap, scans: usize, pace: &Pace) -> String {
    let baud = pace.baud;
    if let Some(instead) = instead(tap, pace) {
        return instead;
    }
    match (tap.received(), pace.agreed) {
        (None, _) => format!(
            "nothing was received on the radar link. Is the receiver's input connected to TX+/TX- \
             or RX+/RX-, with a common ground? Does the scanner scan? Port speed: {baud} baud"
        ),
        (_, Some(agreed)) if pace.tried.len() > 1 => format!(
            "no complete scan was received ({scans} in part): the link went to {agreed} baud, and no intact frame came after \
             that. Does the adapter support this speed? Try --baud {agreed}, or `set link-rate {LINK_BAUD}`, which keeps the \
             link at {LINK_BAUD}"
        ),
        _ => format!("no complete scan was received ({scans} in part), port speed {baud} baud"),
    }
}

/// Returns, as text, what was received if it has no frame of the radar link; `None` if it has one, or nothing was
/// received.
pub fn instead(tap: &Tap, pace: &Pace) -> Option<String> {
    if tap.received().is_some() {
        return None;
    }
    let tried: Vec<String> = pace.tried.iter().map(u32::to_string).collect();
    let tried = tried.join(", ");
    let damaged = tap.damaged();
    let arrived = tap.arrived();
    let what = match arrived.kind() {
        UnexpectedData::Nothing => return None,
        UnexpectedData::Silence | UnexpectedData::Damaged | UnexpectedData::Unknown(_) => {
            "sentences of the report: this is the report port, which --report reads".to_owned()
        }
        UnexpectedData::Others(line) => format!("text of {}: {line}", sender(line)),
        UnexpectedData::Noise | UnexpectedData::Link => format!(
            "bytes of another speed or another device; the link's is {LINK_BAUD} baud until another is agreed on, \
             at most {}. Does the adapter support it?",
            3 * LINK_BAUD
        ),
    };
    Some(format!(
        "no intact frame was received ({damaged} damaged ones, port speed {tried} baud) but {what}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tap::scans::Wire;

    #[test]
    fn nothing_is_only_said_of_no_bytes() {
        let said = |bytes: &[u8]| {
            let mut tap = Tap::default();
            tap.push(0, Wire::Both, bytes);
            nothing(&tap, 0, &Pace::new(LINK_BAUD))
        };
        assert!(said(b"").starts_with("nothing was received"));
        for (bytes, part) in [
            (&b"\xfe\x80\xf8"[..], "another speed"),
            (b"hello: ", "text of another device: hello: "),
            (
                b"$GPGGA,1,2*47",
                "text of a GPS receiver (NMEA 0183, talker GP): $GPGGA",
            ),
            (b"$PSTR,DONE,stop*00", "this is the report port"),
        ] {
            let text = said(bytes);
            assert!(text.contains(part) && !text.contains("nothing"), "{text}");
        }
    }
}
