//! Requests: a length of four bytes, little-endian, that many bytes of JSON, and the bytes of a file or of a port.

use anyhow::{Context, Result};
use serde::Deserialize;
use serde_json::Value;

/// One request.
pub struct Request<'a> {
    pub wanted: Wanted,
    /// Samples, or bytes of a port.
    pub data: &'a [u8],
}

/// Kinds of requests.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "do")]
pub enum Wanted {
    /// Version, estimators and defaults of the scanner.
    About,
    /// A recording as the report page shows it.
    Scan(Files),
    /// The recording's steps as CSV.
    Table(Files),
    /// The recording's metadata with another truth.
    Truth(Truths),
    /// An event at a serial port.
    Port(News),
}

/// A recording with the truth that its metadata are to tell.
#[derive(Debug, Deserialize)]
pub struct Truths {
    #[serde(flatten)]
    pub files: Files,
    /// Truth from the mirror at the first chirp.
    pub whole: Value,
    /// Truth of each scan, from the mirror at its end.
    pub scans: Value,
}

/// A recording's files, but for its samples, and how it is to be scanned.
#[derive(Debug, Deserialize)]
pub struct Files {
    /// Name of the recording, without suffix.
    pub name: String,
    /// Whether the samples are an array of numpy; else they are a SigMF data file.
    #[serde(default)]
    pub array: bool,
    /// Text of the metadata file; an array may do without.
    pub meta: Option<String>,
    /// Text of a table of angles, one a chirp.
    pub angles: Option<String>,
    #[serde(default)]
    pub settings: Settings,
}

/// Settings of the page; `None` leaves what the recording or the scanner's defaults say.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Settings {
    pub estimator: Option<String>,
    pub seed: Option<u32>,
    /// Whether every scan is treated as the first.
    pub single: bool,
    /// `depth` or `height`.
    pub plane: Option<String>,
    pub mount_height_m: Option<f64>,
    pub mirror_offset_m: Option<f64>,
    pub beamwidth_deg: Option<f64>,
    /// Angle that is added to every chirp's, degrees.
    pub angle_offset_deg: Option<f64>,
    /// Value of an array that is full scale; `None`: 1.0 for floating point, the format's range for whole numbers.
    pub full_scale: Option<f64>,
    /// Swept bandwidth of an array, Hz.
    pub bandwidth_hz: Option<f64>,
    /// Angle of an array's first chirp, degrees.
    pub first_angle_deg: Option<f64>,
    /// From one chirp of an array to the next, degrees.
    pub angle_step_deg: Option<f64>,
}

/// An event at a port.
#[derive(Debug, Deserialize)]
pub struct News {
    /// Milliseconds since the page was opened.
    pub now: u64,
    pub what: Event,
    /// Name of a port that was opened.
    #[serde(default)]
    pub port: String,
    /// Speed of a port that was opened, baud.
    #[serde(default)]
    pub baud: u32,
    /// The browser's words about a port that has gone.
    #[serde(default)]
    pub why: String,
}

/// Events of a port.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Event {
    /// A port is open: all before is forgotten.
    Opened,
    /// Bytes have come.
    Bytes,
    /// Time has passed.
    Tick,
    /// The port has gone.
    Gone,
}

impl<'a> Request<'a> {
    /// Takes a request apart.
    ///
    /// # Errors
    /// Says what makes the bytes none.
    pub fn parse(bytes: &'a [u8]) -> Result<Self> {
        let (length, rest) = bytes
            .split_first_chunk()
            .context("a request without length")?;
        let length = usize::try_from(u32::from_le_bytes(*length))?;
        let (head, data) = rest
            .split_at_checked(length)
            .context("a request that is cut off")?;
        let wanted = serde_json::from_slice(head).context("a request of another form")?;
        Ok(Self { wanted, data })
    }
}
