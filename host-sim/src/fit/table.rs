//! The fitted table as the firmware compiles it.

use std::fmt::Write as _;

use stairscan::params::hazard::{Map, Weights};

fn map(map: Map) -> String {
    format!("Map {{ slope: {:?}, offset: {:?} }}", map.slope, map.offset)
}

/// The source file of the verdict's weights in the depth and in the height plane.
pub fn write(up: &Weights, down: &Weights) -> String {
    let mut out = String::from(
        "//! The verdict's hazards, counted from simulated scans: written by `cargo sim fit`.\n\n\
         use super::hazard::{Map, Weights};\n",
    );
    for (name, plane, weights) in [("UP", "depth", up), ("DOWN", "height", down)] {
        let _ = write!(
            out,
            "\n/// In the {plane} plane.\npub static {name}: Weights = Weights {{\n    hazard: [\n"
        );
        for weight in weights.hazard {
            let _ = writeln!(out, "        {weight:?},");
        }
        let _ = write!(
            out,
            "    ],\n    maps: [{}],\n    ok_from: {:?},\n}};\n",
            weights.maps.map(map).join(", "),
            weights.ok_from
        );
    }
    out
}
