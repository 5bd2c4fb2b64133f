//! Checks of single numbers. An error names the key and the expected range.

use anyhow::{Result, ensure};

/// Maximum distance of a surface from the mirror, metres.
pub const WORLD: f64 = 50.0;

/// Rejects a number outside `low..=high`, NaN included.
pub fn number(key: &str, value: f64, (low, high): (f64, f64)) -> Result<()> {
    ensure!(
        (low..=high).contains(&value),
        "{key}: {value}: expected a number from {low} to {high}"
    );
    Ok(())
}

/// Rejects the first of a list of numbers that lies outside its range; `prefix` stands before every
/// key.
pub fn numbers(prefix: &str, list: &[(&str, f64, (f64, f64))]) -> Result<()> {
    for (key, value, range) in list {
        number(&format!("{prefix}{key}"), *value, *range)?;
    }
    Ok(())
}

/// Rejects an interval whose higher end does not exceed its lower one; `prefix` stands before both keys.
pub fn ordered(
    prefix: &str,
    (low_key, low): (&str, f64),
    (high_key, high): (&str, f64),
) -> Result<()> {
    let range = (-WORLD, WORLD);
    numbers(prefix, &[(low_key, low, range), (high_key, high, range)])?;
    ensure!(
        high > low,
        "{prefix}{high_key}: {high}: expected more than {low_key}, which is {low}"
    );
    Ok(())
}

/// Permitted range of a place in the scene, metres from the mirror.
pub const POSITION: (f64, f64) = (-WORLD, WORLD);
/// Permitted range of a length, metres.
pub const LENGTH: (f64, f64) = (1e-4, WORLD);
/// Permitted range of powers (dBm), antenna gain, losses and noise figure (dB).
pub const DECIBEL: (f64, f64) = (-300.0, 300.0);
