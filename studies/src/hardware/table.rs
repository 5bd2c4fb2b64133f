//! The table of a scanner's parts, loads and wires, read from `table.toml`.

use std::sync::LazyLock;

use serde::Deserialize;

/// Content of `table.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Bought or manufactured parts.
    #[serde(rename = "part")]
    pub parts: Vec<Part>,
    /// Voltage converters, each after those that feed it.
    #[serde(rename = "converter")]
    pub converters: Vec<Converter>,
    /// Consumers of current.
    #[serde(rename = "load")]
    pub loads: Vec<Load>,
    /// Circuit blocks that are wired to the microcontroller.
    #[serde(rename = "block")]
    pub blocks: Vec<Block>,
}

/// A bought or manufactured part.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Name of the part.
    pub what: String,
    /// Maker and part number.
    pub number: String,
    /// Approximate price, euros.
    pub euros: u32,
    /// Whether the scanner works without the part.
    #[serde(default)]
    pub option: bool,
    /// Notes for assembly or purchase.
    pub note: String,
}

/// A voltage converter from one supply rail to another.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Converter {
    /// Maker's part number.
    pub number: String,
    /// Name of the input rail.
    pub input: String,
    /// Name of the output rail.
    pub output: String,
    /// Input voltage, V.
    pub volts_in: f64,
    /// Output voltage, V.
    pub volts_out: f64,
    /// Efficiency, 0…1; `None` for a linear regulator, whose output current equals its input
    /// current.
    pub efficiency: Option<f64>,
    /// Maximum output current, mA.
    pub limit_ma: f64,
}

/// A current consumer.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// Name of the load.
    pub what: String,
    /// Name of the supply rail that feeds the load.
    pub rail: String,
    /// Typical current of the load while the scanner scans, mA.
    pub typical_ma: f64,
    /// Maximum current of the load, mA.
    pub max_ma: f64,
    /// Source of both currents, such as a data sheet, as text.
    pub from: String,
}

/// A wire from a block to the microcontroller.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wire {
    /// Name of the signal in docs/user/hardware.md.
    pub signal: String,
    /// Name of the wire's pin at the microcontroller, such as `PA9`.
    pub chip: String,
    /// Name of the wire's pin at the block.
    pub pin: String,
    /// Parts in the wire, such as resistors.
    #[serde(default)]
    pub note: String,
}

/// The side of the microcontroller on which a block is drawn.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Left of the microcontroller.
    Left,
    /// Right of the microcontroller.
    Right,
}

/// A circuit block that is wired to the microcontroller.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// Name of the block.
    pub name: String,
    /// Name of the block's part in the list of parts.
    pub part: String,
    /// Side of the microcontroller on which the block is drawn.
    pub side: Side,
    /// Wires from the block to the microcontroller.
    pub wires: Vec<Wire>,
    /// Wires to the block `beyond`: pairs of a pin of this block and a pin of the other one.
    #[serde(default)]
    pub links: Vec<[String; 2]>,
    /// Pairs of a pin of the block and the supply to which the pin is tied.
    #[serde(default)]
    pub rails: Vec<[String; 2]>,
    /// Name of the block on the side away from the microcontroller; `None` without one.
    pub beyond: Option<String>,
}

/// Returns the table, parsed once.
pub fn table() -> &'static Table {
    static TABLE: LazyLock<Table> = LazyLock::new(|| {
        // A test reads it too, so that a built table is valid.
        toml::from_str(include_str!("table.toml"))
            .unwrap_or_else(|error| panic!("table.toml: {error}"))
    });
    &TABLE
}
