//! Conversion of numbers of any format to the 16 bits of a recording.
//!
//! A value at the format's full scale becomes 32768. The full scale of integers is the converter's
//! range (8 bits become the upper 8 of 16), that of floating point ±1.0; the caller may name another one.
//! Values are rounded to the nearest, ties to even. +32768 itself, which does not fit 16 bits,
//! becomes 32767. Values further out are rejected, because clipped samples differ from the measured
//! ones.

use anyhow::{Result, bail};
use stairscan::Iq;

/// Full scale of a recording's samples, which have 16 bits.
const FULL: f64 = 32768.0;

/// Encoding of a file's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Number {
    /// Integers in two's complement.
    Signed,
    /// Integers in offset binary, with zero in the middle of the range.
    Unsigned,
    /// IEEE 754 floating point of 32 or 64 bits.
    Float,
}

/// Format of the numbers in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Format {
    /// Encoding of the numbers.
    pub number: Number,
    /// Length of a number, bytes: 1, 2 or 4 for integers, 4 or 8 for floating point.
    pub bytes: usize,
    /// Whether the most significant byte comes first.
    pub big_endian: bool,
}

impl Format {
    /// Returns the format; `None` if the length is not supported for this encoding.
    pub fn new(number: Number, bytes: usize, big_endian: bool) -> Option<Self> {
        let known = match number {
            Number::Float => matches!(bytes, 4 | 8),
            Number::Signed | Number::Unsigned => matches!(bytes, 1 | 2 | 4),
        };
        known.then_some(Self {
            number,
            bytes,
            big_endian,
        })
    }

    /// Returns the default full scale: the magnitude of the most negative integer, or 1.0 for floating point.
    pub fn full_scale(self) -> f64 {
        match self.number {
            Number::Float => 1.0,
            Number::Signed | Number::Unsigned => f64::from(1u32 << (8 * self.bytes - 1)),
        }
    }

    /// Returns the value of the number in `bytes`. Unsigned numbers have their zero at `full_scale`.
    fn value(self, bytes: &[u8], full_scale: f64) -> f64 {
        let mut raw = [0; 8];
        for (to, from) in raw.iter_mut().zip(bytes) {
            *to = *from;
        }
        if self.big_endian
            && let Some(used) = raw.get_mut(..self.bytes)
        {
            used.reverse();
        }
        let bits = u64::from_le_bytes(raw);
        match (self.number, self.bytes) {
            (Number::Float, 4) => f32::from_bits(bits as u32).into(),
            (Number::Float, _) => f64::from_bits(bits),
            (Number::Unsigned, _) => bits as f64 - full_scale,
            (Number::Signed, _) => {
                let unused = 64 - 8 * self.bytes as u32;
                ((bits << unused) as i64 >> unused) as f64
            }
        }
    }
}

/// Scales `value` from the full scale `full_scale` to that of a recording, 16 bits; `None` if it lies outside.
pub fn scaled(value: f64, full_scale: f64) -> Option<i16> {
    let scaled = (value * FULL / full_scale).round_ties_even();
    // NaN lies in no range.
    let inside = (-FULL..=FULL).contains(&scaled);
    inside.then_some(scaled.min(FULL - 1.0) as i16)
}

/// Returns the samples in `bytes`, scaled to the 16 bits of a recording: complex ones, I before Q, or the pairs of
/// real ones. Errors count in chirps of `samples_per_chirp`.
///
/// # Errors
/// Names chirp and sample of a value that is not a number or beyond full scale.
pub fn decode(
    bytes: &[u8],
    format: Format,
    full_scale: Option<f64>,
    samples_per_chirp: usize,
) -> Result<Vec<Iq>> {
    let full_scale = full_scale.unwrap_or(format.full_scale());
    let one = |k: usize, part: &[u8], name: char| {
        let value = format.value(part, full_scale);
        let Some(number) = scaled(value, full_scale) else {
            let (chirp, sample) = (k / samples_per_chirp.max(1), k % samples_per_chirp.max(1));
            bail!(
                "chirp {chirp}, sample {sample}: {name} is {value}, expected a number within \
                 the full scale of ±{full_scale} (--full-scale VALUE, or that field of the page, sets another)"
            );
        };
        Ok(number)
    };
    let pairs = bytes.chunks_exact(2 * format.bytes).enumerate();
    pairs
        .map(|(k, pair)| {
            let (i, q) = pair.split_at(format.bytes);
            Ok(Iq::new(one(k, i, 'I')?, one(k, q, 'Q')?))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8], number: Number, length: usize, big: bool) -> Vec<Iq> {
        let format = Format::new(number, length, big).unwrap();
        decode(bytes, format, None, 1).unwrap()
    }

    #[test]
    fn full_scale_is_full_scale_in_every_format() {
        let ends = Iq::new(i16::MIN, i16::MAX);
        assert_eq!(
            read(&[0x80, 0x7f], Number::Signed, 1, false),
            [Iq::new(-32768, 127 * 256)]
        );
        assert_eq!(
            read(&[0, 255], Number::Unsigned, 1, false),
            [Iq::new(-32768, 127 * 256)]
        );
        assert_eq!(
            read(&[0, 0x80, 0xff, 0x7f], Number::Signed, 2, false),
            [ends]
        );
        assert_eq!(
            read(&[0x80, 0, 0x7f, 0xff], Number::Signed, 2, true),
            [ends]
        );
        let float: Vec<u8> = [-1f32, 1.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        assert_eq!(read(&float, Number::Float, 4, false), [ends]);
        let double: Vec<u8> = [-1f64, 1.0].iter().flat_map(|v| v.to_be_bytes()).collect();
        assert_eq!(read(&double, Number::Float, 8, true), [ends]);
    }

    #[test]
    fn sixteen_bits_stay_as_they_are() {
        for value in i16::MIN..=i16::MAX {
            assert_eq!(scaled(value.into(), 32768.0), Some(value));
            assert_eq!(
                scaled(f64::from(f32::from(value) / 32768.0), 1.0),
                Some(value)
            );
        }
    }

    #[test]
    fn what_is_beyond_full_scale_is_named() {
        let values = [0.0f32, 0.0, 0.5, 1.5];
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let format = Format::new(Number::Float, 4, false).unwrap();
        let error = decode(&bytes, format, None, 1).unwrap_err().to_string();
        assert!(error.contains("chirp 1, sample 0: Q is 1.5"), "{error}");
        assert!(decode(&bytes, format, Some(2.0), 1).is_ok());
        let nan = f32::NAN.to_le_bytes().repeat(2);
        assert!(decode(&nan, format, None, 1).is_err());
    }
}
