//! Motion sentence: travel and pitch of the chair, from its controller to the scanner.
//!
//! `$PSTC,MOTION,SEQUENCE,TRAVEL,PITCH*CRC`: sequence number from 0 to 65535, increased by one each time;
//! forward travel in mm with one decimal, cumulative; pitch in 0.001°, nose up positive, or empty. Up to a
//! hundred a second. For more see `docs/design/motion.md`.

use super::sentence::{Fields, Line, ParseError, Tenths, Writer};
use crate::motion::Reading;

/// Beginning of every motion sentence.
pub const PREFIX: &str = "$PSTC,MOTION";
/// Maximum pitch of a chair from the horizontal, nose up or down, that a motion sentence may state, 0.001°.
const STEEPEST: i32 = 45_000;

/// Returns the sentence of `reading`, with its CRC and line end.
///
/// ```
/// use stairscan::motion::Reading;
/// use stairscan::report::motion;
///
/// let reading = Reading { sequence: 7, travel: 1234, pitch: Some(-250) };
/// assert_eq!(motion::write(&reading), "$PSTC,MOTION,7,123.4,-250*A5DC3450\r\n");
/// assert_eq!(motion::parse("MOTION,7,123.4,-250"), Ok(reading));
/// ```
pub fn write(reading: &Reading) -> Line {
    Writer::behind("$PSTC,", "MOTION")
        .number(reading.sequence.into())
        .length(Some(Tenths(reading.travel)))
        .integer(reading.pitch)
        .finish()
}

/// Parses the body of a motion sentence, between `$PSTC,` and `*`.
///
/// # Errors
/// Returns the field that is missing or malformed.
pub fn parse(body: &str) -> Result<Reading, ParseError> {
    let mut fields = Fields(body.split([',']));
    if fields.text("name")? != "MOTION" {
        return Err(ParseError::Field("name"));
    }
    let sequence = fields.number("sequence")?;
    let Tenths(travel) = fields
        .length("travel")?
        .ok_or(ParseError::Field("travel"))?;
    let pitch = match fields.text("pitch")? {
        "" => None,
        text => {
            let pitch = text.parse().map_err(|_| ParseError::Field("pitch"))?;
            if !(-STEEPEST..=STEEPEST).contains(&pitch) {
                return Err(ParseError::Field("pitch"));
            }
            Some(pitch)
        }
    };
    match fields.0.next() {
        None => Ok(Reading {
            sequence,
            travel,
            pitch,
        }),
        Some(_) => Err(ParseError::Field("end")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn fields_that_are_wrong_are_named() {
        for (body, field) in [
            ("STATUS,1,2.0,3", "name"),
            ("MOTION", "sequence"),
            ("MOTION,65536,2.0,3", "sequence"),
            ("MOTION,-1,2.0,3", "sequence"),
            ("MOTION,1", "travel"),
            ("MOTION,1,,3", "travel"),
            ("MOTION,1,2,3", "travel"),
            ("MOTION,1,2.00,3", "travel"),
            ("MOTION,1,999999999999.0,3", "travel"),
            ("MOTION,1,2.0", "pitch"),
            ("MOTION,1,2.0,1.5", "pitch"),
            ("MOTION,1,2.0,45001", "pitch"),
            ("MOTION,1,2.0,3,4", "end"),
        ] {
            assert_eq!(parse(body), Err(ParseError::Field(field)), "{body}");
        }
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back(
            sequence: u16,
            travel in -2_000_000_000..2_000_000_000i32,
            pitch in proptest::option::of(-STEEPEST..=STEEPEST),
        ) {
            let reading = Reading { sequence, travel, pitch };
            let line = write(&reading);
            let body = line.strip_prefix("$PSTC,").unwrap().split('*').next().unwrap();
            prop_assert_eq!(parse(body), Ok(reading));
        }

        #[test]
        fn any_text_never_panics(body in "MOTION[,.0-9a-z-]{0,40}") {
            let _ = parse(&body);
        }
    }
}
