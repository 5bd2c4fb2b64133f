//! The table of parts, loads and wires.

use std::sync::LazyLock;

use serde::Deserialize;

/// Content of `table.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Bought or manufactured parts.
    #[serde(rename = "part")]
    pub parts: Vec<Part>,
    /// Converters, each after those that feed it.
    #[serde(rename = "converter")]
    pub converters: Vec<Converter>,
    /// Current consumers.
    #[serde(rename = "load")]
    pub loads: Vec<Load>,
    /// Blocks that are wired to the chip.
    #[serde(rename = "block")]
    pub blocks: Vec<Block>,
}

/// A bought or manufactured part.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Designation.
    pub what: String,
    /// Maker and part number.
    pub number: String,
    /// Approximate price, euros.
    pub euros: u32,
    /// Whether the part is optional.
    #[serde(default)]
    pub option: bool,
    /// Notes for assembly or purchase.
    pub note: String,
}

/// A converter from one rail to another.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Converter {
    /// Part number.
    pub number: String,
    /// The input rail.
    pub input: String,
    /// The output rail.
    pub output: String,
    /// Input voltage, V.
    pub volts_in: f64,
    /// Output voltage, V.
    pub volts_out: f64,
    /// Efficiency; `None` for a linear regulator, whose output current equals its input current.
    pub efficiency: Option<f64>,
    /// Maximum output current, mA.
    pub limit_ma: f64,
}

/// A current consumer.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// Designation.
    pub what: String,
    /// The rail that supplies it.
    pub rail: String,
    /// Current while the scanner scans, mA.
    pub typical_ma: f64,
    /// Maximum current, mA.
    pub max_ma: f64,
    /// Source of the figures.
    pub from: String,
}

/// A wire to the chip.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wire {
    /// Name in docs/hardware.md.
    pub signal: String,
    /// Pin of the chip.
    pub chip: String,
    /// Pin of the block.
    pub pin: String,
    /// Parts on the wire.
    #[serde(default)]
    pub note: String,
}

/// The side of the chip on which a block is drawn.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// A block that is wired to the chip.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// Its name.
    pub name: String,
    /// Designation of the part.
    pub part: String,
    /// Side on which it is drawn.
    pub side: Side,
    /// Its wires to the chip.
    pub wires: Vec<Wire>,
    /// Pairs of its own pin and a pin of the block beyond.
    #[serde(default)]
    pub links: Vec<[String; 2]>,
    /// Pairs of its pin and the supply to which it is tied.
    #[serde(default)]
    pub rails: Vec<[String; 2]>,
    /// Name of the block beyond.
    pub beyond: Option<String>,
}

/// Returns the table.
pub fn table() -> &'static Table {
    static TABLE: LazyLock<Table> = LazyLock::new(|| {
        // A test reads it too, so that a built table is valid.
        toml::from_str(include_str!("table.toml"))
            .unwrap_or_else(|error| panic!("table.toml: {error}"))
    });
    &TABLE
}
