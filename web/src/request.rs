//! Requests: a length of four bytes, little-endian, JSON of this length, and the bytes of a file or of a port.

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
    /// A recording in the form of the report page.
    Scan(Files),
    /// The recording's steps as CSV.
    Table(Files),
    /// The recording's metadata with another ground truth.
    Truth(Truths),
    /// An event at a serial port.
    Port(News),
}

/// A recording with the ground truth for its metadata.
#[derive(Debug, Deserialize)]
pub struct Truths {
    #[serde(flatten)]
    pub files: Files,
    /// Ground truth relative to the mirror at the first chirp.
    pub whole: Value,
    /// Ground truth of each scan, relative to the mirror at its end.
    pub scans: Value,
}

/// A recording's files except its samples, and the options of its scan.
#[derive(Debug, Deserialize)]
pub struct Files {
    /// Name of the recording, without suffix.
    pub name: String,
    /// Whether the samples are a numpy array; otherwise they are a SigMF data file.
    #[serde(default)]
    pub array: bool,
    /// Text of the metadata file; optional for an array.
    pub meta: Option<String>,
    /// Text of a table of angles, one for each chirp.
    pub angles: Option<String>,
    #[serde(default)]
    pub settings: Settings,
}

/// Settings of the page; `None` keeps the value of the recording or the scanner's default.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Settings {
    pub estimator: Option<String>,
    pub seed: Option<u32>,
    /// Whether every scan is treated as the first one.
    pub single: bool,
    /// `depth` or `height`.
    pub plane: Option<String>,
    pub mount_height_m: Option<f64>,
    pub mirror_offset_m: Option<f64>,
    pub beamwidth_deg: Option<f64>,
    /// Angle that is added to every chirp's, degrees.
    pub angle_offset_deg: Option<f64>,
    /// Full-scale value of an array; `None`: 1.0 for floating point, the format's range for integers.
    pub full_scale: Option<f64>,
    /// Swept bandwidth of an array, Hz.
    pub bandwidth_hz: Option<f64>,
    /// Angle of an array's first chirp, degrees.
    pub first_angle_deg: Option<f64>,
    /// Angle between two chirps of an array, degrees.
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
    /// Baud rate of a port that was opened.
    #[serde(default)]
    pub baud: u32,
    /// The browser's message about a port that has disappeared.
    #[serde(default)]
    pub why: String,
}

/// Events of a port.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Event {
    /// A port was opened; all earlier state is reset.
    Opened,
    /// Bytes were received.
    Bytes,
    /// Time has passed.
    Tick,
    /// The port has disappeared.
    Gone,
}

impl<'a> Request<'a> {
    /// Parses a request.
    ///
    /// # Errors
    /// The bytes are not a request; the message names the cause.
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
