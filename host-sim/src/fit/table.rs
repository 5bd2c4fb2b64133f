//! Writes the fitted table as Rust source for the firmware.

use std::fmt::Write as _;

use stairscan::params::hazard::{Map, Weights};

/// Numbers in one row of the table.
const NUMBERS_A_ROW: usize = 6;

fn map(map: Map) -> String {
    format!("Map {{ slope: {:?}, offset: {:?} }}", map.slope, map.offset)
}

/// Returns the source file with the verdict's weights of the depth and the height plane and the checksum of the
/// tables of a small draw.
pub fn write(up: &Weights, down: &Weights, checksum: u32) -> String {
    let mut out = String::from(
        "//! The verdict's hazards, counted from simulated scans: written by `cargo sim fit`.\n\n\
         use super::hazard::{Map, Weights};\n",
    );
    let _ = write!(
        out,
        "\n/// Checksum of the tables that a small draw gives: a test counts it again.\npub const CHECKSUM: u32 = \
         {checksum:#010X};\n"
    );
    for (name, plane, weights) in [("UP", "depth", up), ("DOWN", "height", down)] {
        let _ = write!(
            out,
            "\n/// In the {plane} plane.\n#[rustfmt::skip]\npub static {name}: Weights = Weights {{\n    hazard: [\n"
        );
        for row in weights.hazard.chunks(NUMBERS_A_ROW) {
            let row: Vec<String> = row.iter().map(|weight| format!("{weight:?}")).collect();
            let _ = writeln!(out, "        {},", row.join(", "));
        }
        let _ = write!(
            out,
            "    ],\n    maps: [{}],\n    maybe: {},\n    ok_from: {:?},\n}};\n",
            weights.maps.map(map).join(", "),
            map(weights.maybe),
            weights.ok_from
        );
    }
    out
}
