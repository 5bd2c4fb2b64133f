//! Writes the fitted hazard weights, calibration maps and thresholds as Rust source for the firmware.

use std::fmt::Write as _;

use stairscan::params::hazard::{PlattMap, Weights};

/// Number of weights in one line of the written source.
const NUMBERS_A_ROW: usize = 6;

fn map(map: PlattMap) -> String {
    format!(
        "PlattMap {{ slope: {:?}, offset: {:?} }}",
        map.slope, map.offset
    )
}

/// Returns the Rust source file with the hazard weights of the depth plane (`up`) and the height plane (`down`).
/// `checksum` is that of the tables fitted to a small number of scenes, which a test recomputes.
pub fn write(up: &Weights, down: &Weights, checksum: u32) -> String {
    let mut out = String::from(
        "//! The horizon's hazard weights, counted from simulated scans: written by `cargo study fit`.\n\n\
         use super::hazard::{PlattMap, Weights};\n",
    );
    let _ = write!(
        out,
        "\n/// Checksum of the tables that a small draw gives: a test recomputes it.\npub const CHECKSUM: u32 = \
         {checksum:#010X};\n"
    );
    for (name, plane, weights) in [("UP", "depth", up), ("DOWN", "height", down)] {
        let _ = write!(
            out,
            "\n/// Weights of the {plane} plane.\n#[rustfmt::skip]\npub static {name}: Weights = Weights {{\n    hazard: [\n"
        );
        for row in weights.hazard.chunks(NUMBERS_A_ROW) {
            let row: Vec<String> = row.iter().map(|weight| format!("{weight:?}")).collect();
            let _ = writeln!(out, "        {},", row.join(", "));
        }
        let _ = write!(
            out,
            "    ],\n    maps: [{}],\n    maybe_map: {},\n    ok_from: {:?},\n}};\n",
            weights.maps.map(map).join(", "),
            map(weights.maybe_map),
            weights.ok_from
        );
    }
    out
}
