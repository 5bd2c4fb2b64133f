//! Warning of a mirrored spectrum: the samples are then no I and Q in turn.
//!
//! A target beats at a positive frequency. Real samples, and rows of all I, then all Q, have their echoes at both
//! frequencies if they are taken for pairs of I and Q; exchanged I and Q have them at the negative one.

use anyhow::{Result, anyhow};
use stairscan::config::{CfarConfig, MAX_SAMPLES, MountConfig};
use stairscan::signal::range::RangeProcessor;
use stairscan::signal::range::packed::Packed;

use crate::recording::Recording;
use crate::setup;

/// Maximum number of chirps that are examined.
const CHIRPS: usize = 64;
/// Share of the bins, at each end of the spectrum, that may hold leakage.
const LEAKAGE_SHARE: usize = 32;
/// Multiple of the median power from which a bin holds an echo: 20 dB.
const ECHO: f64 = 100.0;
/// Power at negative frequencies, as a multiple of that at positive ones, from which the spectrum counts as mirrored:
/// -6 dB. Imbalance of I and Q leaves images below -15 dB.
const MIRRORED: f64 = 0.25;

/// Returns a warning for people if the echoes of a recording are as strong at negative as at positive frequencies;
/// `None` otherwise, for real samples, and without echoes.
///
/// # Errors
/// The radar's keys are out of their ranges.
pub fn warning(recording: &Recording) -> Result<Option<String>> {
    if recording.meta.real {
        return Ok(None);
    }
    let power = spectrum(recording)?;
    let mut sorted = power.clone();
    sorted.sort_by(f64::total_cmp);
    let noise = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
    let leakage = power.len() / LEAKAGE_SHARE + 1;
    let echoes = |bins: &[f64]| -> f64 { bins.iter().filter(|p| **p > ECHO * noise).sum() };
    let (positive, negative) = power.split_at(power.len() / 2);
    let positive = echoes(positive.get(leakage..).unwrap_or_default());
    let negative = echoes(
        negative
            .get(..negative.len().saturating_sub(leakage))
            .unwrap_or_default(),
    );
    if negative <= MIRRORED * positive {
        return Ok(None);
    }
    Ok(Some(
        "the spectrum is mirrored: echoes are at negative frequencies, too. Rows of all I, then all Q: --planar; real \
         samples: --real chirp,sample; else I and Q are exchanged"
            .to_owned(),
    ))
}

/// Returns the power of each bin of the transform, summed over chirps from the whole recording.
fn spectrum(recording: &Recording) -> Result<Vec<f64>> {
    let radar = setup::radar(recording)?;
    let (mount, cfar) = (MountConfig::default(), CfarConfig::default());
    let mount = MountConfig {
        mirror_offset: 0,
        ..mount
    };
    let cfar = CfarConfig {
        near_margin: 0,
        ..cfar
    };
    let processor = RangeProcessor::new(&radar, &mount, &cfar);
    let mut processor = processor.map_err(|e| anyhow!("{}: {e}", recording.name))?;
    let mut packed = [Packed::ZERO; MAX_SAMPLES];
    let mut power = vec![0.0; radar.fft_len()];
    let step = recording.chirps().div_ceil(CHIRPS).max(1);
    for k in (0..recording.chirps()).step_by(step) {
        let chirp = recording.chirp(k).unwrap_or_default();
        let unit = f64::from(processor.spectrum(chirp, &mut packed)?);
        for (sum, bin) in power.iter_mut().zip(&packed) {
            let [re, im] = [bin.re(), bin.im()].map(f64::from);
            *sum += (re * re + im * im) * unit * unit;
        }
    }
    Ok(power)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use serde_json::json;
    use stairscan::Iq;

    use super::*;

    /// Returns a recording whose pairs of numbers are `pair` of the number of the pair.
    fn recording(pair: impl Fn(usize) -> (f64, f64)) -> Recording {
        let document = json!({"global": {
            "core:datatype": "ci16_le",
            "stairscan:bandwidth_hz": 4e9,
            "stairscan:samples_per_chirp": 64,
        }});
        let whole = |v: f64| (8000.0 * v).round() as i16;
        let samples = (0..4 * 64).map(|k| {
            let (i, q) = pair(k % 64);
            Iq::new(whole(i), whole(q))
        });
        Recording::of("x", &document, samples.collect()).unwrap()
    }

    #[test]
    fn pairs_that_are_none_are_noticed() {
        // A tone with 9.3 turns in a chirp.
        let tone = |k: usize, of: usize| (TAU * 9.3 * k as f64 / of as f64).cos();
        let sine = |k: usize, of: usize| (TAU * 9.3 * k as f64 / of as f64).sin();
        let is_warned =
            |pair: &dyn Fn(usize) -> (f64, f64)| warning(&recording(pair)).unwrap().is_some();
        assert!(!is_warned(&|k| (tone(k, 64), sine(k, 64))));
        // An image of -26 dB.
        assert!(!is_warned(&|k| (tone(k, 64), 0.9 * sine(k, 64))));
        assert!(is_warned(&|k| (sine(k, 64), tone(k, 64))), "Q before I");
        assert!(
            is_warned(&|k| (tone(2 * k, 128), tone(2 * k + 1, 128))),
            "real"
        );
        let row = |k: usize| {
            if k < 64 {
                tone(k, 64)
            } else {
                sine(k - 64, 64)
            }
        };
        assert!(is_warned(&|k| (row(2 * k), row(2 * k + 1))), "planar");
        assert!(!is_warned(&|_| (0.0, 0.0)), "silence");
    }
}
