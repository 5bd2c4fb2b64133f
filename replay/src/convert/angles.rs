//! A table of angles: one angle per row, degrees, in the order of the chirps.

use anyhow::{Context, Result, ensure};

use crate::recording::degrees;

/// Returns the angles in a file's text, degrees: one in each row, without a heading.
///
/// # Errors
/// Names the line.
pub fn parse(text: &str) -> Result<Vec<f64>> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let mut angles = Vec::new();
    for row in reader.records() {
        let row = row.context("no table")?;
        let line = row.position().map_or(0, csv::Position::line);
        let cell = row.get(0).unwrap_or_default();
        let angle = cell.parse().ok().filter(|angle: &f64| angle.is_finite());
        ensure!(
            row.len() == 1 && angle.is_some(),
            "line {line}: found {:?}, expected one angle in degrees",
            row.iter()
                .collect::<Vec<_>>()
                .join(",")
                .chars()
                .take(40)
                .collect::<String>()
        );
        angles.extend(angle);
    }
    ensure!(!angles.is_empty(), "holds no angle");
    degrees(&angles)?;
    Ok(angles)
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::*;

    #[test]
    fn radians_are_named() {
        let table = |scale: f64| {
            (-20..=60).fold(String::new(), |mut text, k| {
                let _ = writeln!(text, "{}", f64::from(k) * scale);
                text
            })
        };
        assert_eq!(parse(&table(1.0)).unwrap().len(), 81);
        let error = format!("{:#}", parse(&table(1f64.to_radians())).unwrap_err());
        assert!(
            error.contains("81 angles, from -0.3491 to 1.0472: they look like radians"),
            "{error}"
        );
    }

    #[test]
    fn one_angle_a_row() {
        assert_eq!(
            parse("-20.00\n -19.75\r\n1e1\n").unwrap(),
            [-20.0, -19.75, 10.0]
        );
        for (text, words) in [
            ("angle\n1\n", "line 1: found \"angle\""),
            ("1\n2,3\n", "line 2"),
            ("1\nnan\n", "line 2: found \"nan\""),
            ("", "holds no angle"),
        ] {
            let error = format!("{:#}", parse(text).unwrap_err());
            assert!(error.contains(words), "{error}");
        }
    }
}
