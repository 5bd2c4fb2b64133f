//! Reader of SigMF files of other programs: any datatype, with missing `stairscan:` keys added.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use super::samples::{Format, Number};
use crate::recording::{self, standard};

/// Reads the JSON document of a metadata file, `.sigmf-meta`.
///
/// # Errors
/// Names the file.
pub fn metadata(path: &Path) -> Result<Value> {
    let file = recording::meta_path(path);
    recording::regular(&file)?;
    let document = recording::document(&recording::text(&file)?);
    let document = document.with_context(|| format!("{}", file.display()))?;
    ensure!(
        document["global"].is_object(),
        "{}: global: missing, expected a JSON object",
        file.display()
    );
    Ok(document)
}

/// Whether a recording's first capture begins after the file's first sample.
pub fn begins_late(document: &Value) -> bool {
    standard::before_first(document).is_ok_and(|before| before > 0)
}

/// Returns the number format of the samples that a metadata document describes, and whether they are real.
///
/// # Errors
/// Names the key, the value found and the expected value.
pub fn format(document: &Value) -> Result<(Format, bool)> {
    let global = &document["global"];
    let Some(datatype) = global["core:datatype"].as_str() else {
        bail!("global core:datatype: missing, expected a text such as \"cf32_le\"");
    };
    standard::check(document)?;
    parse(datatype)
}

/// Parses a SigMF datatype such as `ci16_le`: `c` for complex or `r` for real, encoding, bits and order of bytes.
fn parse(datatype: &str) -> Result<(Format, bool)> {
    let known = || {
        let (name, big) = match datatype.split_once('_') {
            Some((name, "le")) => (name, false),
            Some((name, "be")) => (name, true),
            None => (datatype, false),
            _ => return None,
        };
        let real = name.starts_with('r');
        let (number, bits) = name.strip_prefix(['c', 'r'])?.split_at_checked(1)?;
        let number = match number {
            "i" => Number::Signed,
            "u" => Number::Unsigned,
            "f" => Number::Float,
            _ => return None,
        };
        let bits: usize = bits.parse().ok().filter(|bits| bits % 8 == 0)?;
        // A single byte has no order; a longer number must state it.
        let is_complete = datatype.contains('_') || bits == 8;
        let format = Format::new(number, bits / 8, big).filter(|_| is_complete)?;
        Some((format, real))
    };
    known().with_context(|| {
        format!(
            "global core:datatype: found {datatype:?}, expected ci8, cu8, or ci16, cu16, ci32, cu32, cf32 or \
             cf64 with _le or _be; with r in place of c for real samples"
        )
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde_json::json;

    use super::*;

    #[test]
    fn datatypes_of_the_standard() {
        for (name, number, bytes, big) in [
            ("ci8", Number::Signed, 1, false),
            ("cu8", Number::Unsigned, 1, false),
            ("ci16_le", Number::Signed, 2, false),
            ("cu16_be", Number::Unsigned, 2, true),
            ("ci32_be", Number::Signed, 4, true),
            ("cf32_le", Number::Float, 4, false),
            ("cf64_be", Number::Float, 8, true),
        ] {
            let expected = Format::new(number, bytes, big).map(|format| (format, false));
            assert_eq!(parse(name).ok(), expected, "{name}");
            let real = parse(&name.replacen('c', "r", 1)).unwrap();
            assert_eq!(
                Some(real),
                expected.map(|(format, _)| (format, true)),
                "{name}"
            );
        }
        for wrong in [
            "",
            "c",
            "ci16",
            "cf16_le",
            "ci16_xx",
            "cé8",
            "ci7",
            "ci99999999999999999999",
        ] {
            let error = parse(wrong).unwrap_err().to_string();
            assert!(error.contains("core:datatype"), "{error}");
        }
    }

    #[test]
    fn files_of_more_than_samples_are_refused() {
        let document = |key: &str, value: Value| json!({"global": {"core:datatype": "ci8", key: value}, "captures": []});
        assert!(format(&document("x", json!(0))).is_ok());
        let error = format(&document("core:num_channels", json!(2))).unwrap_err();
        assert!(error.to_string().contains("found 2, expected 1"));
        assert!(format(&document("core:trailing_bytes", json!(4))).is_err());
        let header =
            json!({"global": {"core:datatype": "ci8"}, "captures": [{"core:header_bytes": 8}]});
        assert!(format(&header).is_err());
    }

    proptest! {
        #[test]
        fn no_datatype_brings_it_down(datatype in ".{0,12}") {
            let _ = parse(&datatype);
        }
    }
}
