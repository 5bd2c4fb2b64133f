//! The one table of parts, loads and wires.

use std::sync::LazyLock;

use serde::Deserialize;

/// Everything.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// What is bought or made.
    #[serde(rename = "part")]
    pub parts: Vec<Part>,
    /// Converters, each behind those that feed it.
    #[serde(rename = "converter")]
    pub converters: Vec<Converter>,
    /// What takes current.
    #[serde(rename = "load")]
    pub loads: Vec<Load>,
    /// What the chip is wired to.
    #[serde(rename = "block")]
    pub blocks: Vec<Block>,
}

/// What is bought or made.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// What it is.
    pub what: String,
    /// Maker and part number.
    pub number: String,
    /// Price, euros, about.
    pub euros: u32,
    /// Whether a scanner works without it.
    #[serde(default)]
    pub option: bool,
    /// What to mind.
    pub note: String,
}

/// Makes one rail of another.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Converter {
    /// Part number.
    pub number: String,
    /// The rail that feeds it.
    pub input: String,
    /// The rail that it makes.
    pub output: String,
    /// Volts of both.
    pub volts_in: f64,
    /// Volts of the rail that it makes.
    pub volts_out: f64,
    /// Share of the power that it passes on; none for a linear one, which passes its current on.
    pub efficiency: Option<f64>,
    /// Most that it gives, mA.
    pub limit_ma: f64,
}

/// What takes current.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// What.
    pub what: String,
    /// From which rail.
    pub rail: String,
    /// While it scans, mA.
    pub typical_ma: f64,
    /// At most, mA.
    pub most_ma: f64,
    /// Where the figures are from.
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

/// The side of the chip that a block stands on.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// What is wired to the chip.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// Its name.
    pub name: String,
    /// What it is.
    pub part: String,
    /// Where it stands.
    pub side: Side,
    /// Its wires to the chip.
    pub wires: Vec<Wire>,
    /// Its own pin, and that of the block beyond.
    #[serde(default)]
    pub links: Vec<[String; 2]>,
    /// Its pin, and the supply that it is tied to.
    #[serde(default)]
    pub rails: Vec<[String; 2]>,
    /// Name of the block beyond.
    pub beyond: Option<String>,
}

/// The table.
pub fn table() -> &'static Table {
    static TABLE: LazyLock<Table> = LazyLock::new(|| {
        // A test reads it, too: in what is built it is right.
        toml::from_str(include_str!("table.toml"))
            .unwrap_or_else(|error| panic!("table.toml: {error}"))
    });
    &TABLE
}
