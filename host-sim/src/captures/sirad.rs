//! Reads captures of a SiRad radar module: bytes from its port, or files that other programs wrote.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use stairscan::signal::radar::sirad::{Reader, ReaderEvent};

use super::mat;
use crate::modules::sirad::Sample;
use crate::recording;

/// Chirps recorded from a SiRad module with one setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    /// Swept bandwidth that was set, kHz; `None` if the capture does not contain it.
    pub bandwidth_khz: Option<u32>,
    /// Samples of each chirp, in order of time; all chirps have equal length.
    pub chirps: Vec<Vec<Sample>>,
}

/// Content of a capture in JSON: bandwidth in MHz, and a list I, Q, I, Q … for each chirp.
#[derive(Deserialize)]
struct Listed {
    #[serde(rename = "Bandwidth")]
    bandwidth_mhz: f64,
    data: Vec<Vec<i16>>,
}

impl Capture {
    /// Reads a file by its suffix: `.mat` with `complexData` and `BW` in Hz, `.json` with `data`
    /// and `Bandwidth`, any other as bytes from the port.
    ///
    /// # Errors
    /// Names the file and the expected content.
    pub fn read(path: &Path) -> Result<Self> {
        recording::regular(path)?;
        let bytes = fs::read(path).with_context(|| format!("{}", path.display()))?;
        let capture = match path.extension().and_then(|e| e.to_str()) {
            Some("mat") => matlab(&bytes),
            Some("json") => listed(&bytes),
            _ => Ok(logged(&bytes)),
        };
        let capture = capture.with_context(|| format!("{}", path.display()))?;
        capture
            .check()
            .with_context(|| format!("{}", path.display()))?;
        Ok(capture)
    }

    /// Returns the number of samples of each chirp.
    pub fn samples(&self) -> usize {
        self.chirps.first().map_or(0, Vec::len)
    }

    fn check(&self) -> Result<()> {
        let samples = self.samples();
        ensure!(samples > 0, "no chirp");
        ensure!(
            matches!(samples, 32 | 64 | 128 | 256),
            "{samples} samples a chirp, expected 32, 64, 128 or 256"
        );
        ensure!(
            self.chirps.iter().all(|chirp| chirp.len() == samples),
            "chirps of more than one length"
        );
        Ok(())
    }
}

fn khz(hz: f64) -> Result<u32> {
    ensure!((1e6..1e11).contains(&hz), "bandwidth {hz} Hz");
    Ok((hz / 1e3).round() as u32)
}

fn matlab(bytes: &[u8]) -> Result<Capture> {
    let mut found = mat::read(bytes)?;
    let chirp = found
        .remove("complexData")
        .context("no variable complexData")?;
    let hz = found
        .get("BW")
        .and_then(|v| v.first())
        .context("no variable BW")?;
    let whole = |v: f64| -> Result<i16> {
        ensure!(
            (-32768.0..=32767.0).contains(&v),
            "{v}: no sample of 16 bits"
        );
        Ok(v.round() as i16)
    };
    let samples: Result<Vec<Sample>> = chirp
        .iter()
        .map(|s| Ok([whole(s.re)?, whole(s.im)?]))
        .collect();
    Ok(Capture {
        bandwidth_khz: Some(khz(hz.re)?),
        chirps: vec![samples?],
    })
}

fn listed(bytes: &[u8]) -> Result<Capture> {
    let listed: Listed = serde_json::from_slice(bytes)?;
    let chirp = |values: &Vec<i16>| {
        let (pairs, rest) = values.as_chunks::<2>();
        if !rest.is_empty() {
            bail!("I without Q");
        }
        Ok(pairs.to_vec())
    };
    Ok(Capture {
        bandwidth_khz: Some(khz(1e6 * listed.bandwidth_mhz)?),
        chirps: listed.data.iter().map(chirp).collect::<Result<_>>()?,
    })
}

/// Returns the chirps of the complete raw frames among the bytes of a port.
fn logged(bytes: &[u8]) -> Capture {
    let (mut reader, mut values, mut chirps) = (Reader::new(), Vec::new(), Vec::new());
    for &byte in bytes {
        match reader.push(byte) {
            Some(ReaderEvent::Value(0, value)) => values = vec![value],
            Some(ReaderEvent::Value(_, value)) => values.push(value),
            Some(ReaderEvent::Raw { count, .. }) if usize::from(count) == values.len() => {
                let (pairs, rest) = values.as_chunks::<2>();
                if rest.is_empty() {
                    chirps.push(pairs.to_vec());
                }
                values.clear();
            }
            Some(ReaderEvent::Raw { .. } | ReaderEvent::Broken) => values.clear(),
            _ => {}
        }
    }
    Capture {
        bandwidth_khz: None,
        chirps,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modules::sirad::{binary, table};

    #[test]
    fn frames_among_other_bytes() {
        let chirps: [Vec<Sample>; 2] = [1, 2].map(|k| vec![[k, -k]; 32]);
        let log = [
            b"!I\r\n".to_vec(),
            binary(1, &chirps[0]),
            binary(2, &chirps[0])[..90].to_vec(),
            b"\r\n".to_vec(),
            vec![0; 300],
            table(3, &chirps[1]),
        ]
        .concat();
        assert_eq!(logged(&log).chirps, chirps);
    }

    #[test]
    fn a_program_s_list() {
        let capture =
            listed(br#"{"Bandwidth": 6000, "Ramps": 1, "data": [[1, 2, 3, 4]]}"#).unwrap();
        assert_eq!(capture.bandwidth_khz, Some(6_000_000));
        assert_eq!(capture.chirps, [[[1, 2], [3, 4]]]);
        assert!(listed(br#"{"Bandwidth": 6000, "data": [[1, 2, 3]]}"#).is_err());
        assert!(capture.check().is_err());
    }
}
