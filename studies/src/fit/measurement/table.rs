//! Writes the measurement model's parameters as Rust source for the firmware and as text.

use std::fmt::Write as _;

use stairscan::params::generative::{Extended, Generative, Point, TreadEnd, TreadNumbers};

use super::estimate::{EXTENDED_NAMES, Number, POINT_NAMES};

/// Reciprocal of the last decimal that is kept, 0.00001 of the parameter's unit. A hundredth of a millimetre, of a
/// decibel or of a log-odds unit has no effect.
const UNIT: f64 = 1e5;

/// Returns the parameters, rounded to the decimals of the source file.
pub fn rounded(g: &Generative) -> Generative {
    let near = |x: &mut f32| *x = ((f64::from(*x) * UNIT).round() / UNIT) as f32 + 0.0;
    let mut g = *g;
    g.points
        .iter_mut()
        .for_each(|p| point(p).into_iter().for_each(|(_, x)| near(x)));
    g.extended
        .iter_mut()
        .for_each(|p| extended(p).into_iter().for_each(|(_, x)| near(x)));
    let h = &mut g.hidden;
    h.low
        .iter_mut()
        .chain(&mut h.top)
        .chain(&mut h.nothing)
        .for_each(near);
    let t = &mut g.treads;
    t.rate.iter_mut().chain(&mut t.ratio_m2).for_each(near);
    near(&mut t.height_sigma_m);
    near(&mut t.edge_sigma_scale);
    for end in t.ends.iter_mut().chain(&mut t.starts) {
        [&mut end.number, &mut end.off_m, &mut end.sigma_m]
            .into_iter()
            .for_each(near);
    }
    g
}

fn point(p: &mut Point) -> [(&'static str, &mut f32); 12] {
    [
        ("range_m", &mut p.range_m),
        ("range_sigma_m", &mut p.range_sigma_m),
        ("across_m", &mut p.across_m),
        ("across_sigma_m", &mut p.across_sigma_m),
        ("across_per_width_m", &mut p.across_per_width_m),
        ("sigma_per_width_m", &mut p.sigma_per_width_m),
        ("snr_db", &mut p.snr_db),
        ("snr_per_db", &mut p.snr_per_db),
        ("snr_sigma_db", &mut p.snr_sigma_db),
        ("seen", &mut p.seen),
        ("seen_per_ten_db", &mut p.seen_per_ten_db),
        ("seen_per_room", &mut p.seen_per_room),
    ]
}

fn extended(p: &mut Extended) -> [(&'static str, &mut f32); 6] {
    [
        ("rate", &mut p.rate),
        ("rate_per_ten_db", &mut p.rate_per_ten_db),
        ("snr_db", &mut p.snr_db),
        ("snr_per_db", &mut p.snr_per_db),
        ("snr_sigma_db", &mut p.snr_sigma_db),
        ("off_sigma_m", &mut p.off_sigma_m),
    ]
}

/// Returns the Rust source file of the measurement model's parameters.
pub fn write(g: &Generative) -> String {
    let mut g = rounded(g);
    let mut out = String::from(
        "//! The measurement model, counted from simulated scans: written by `cargo study fit`.\n\n\
         use super::generative::{Extended, Generative, Hidden, Point, TreadEnd, TreadNumbers};\n\n\
         /// Parameters of both planes.\npub static MODEL: Generative = Generative {\n    points: [\n",
    );
    for (p, name) in g.points.iter_mut().zip(POINT_NAMES) {
        entry(&mut out, "Point", name, &point(p));
    }
    out.push_str("    ],\n    extended: [\n");
    for (p, name) in g.extended.iter_mut().zip(EXTENDED_NAMES) {
        entry(&mut out, "Extended", name, &extended(p));
    }
    let h = &g.hidden;
    let _ = write!(
        out,
        "    ],\n    hidden: Hidden {{\n        low: {:?},\n        top: {:?},\n        \
         nothing: {:?},\n    }},\n",
        h.low, h.top, h.nothing
    );
    treads(&mut out, &g.treads);
    out.push_str("};\n");
    out
}

fn treads(out: &mut String, t: &TreadNumbers) {
    let _ = write!(
        out,
        "    treads: TreadNumbers {{\n        rate: {:?},\n        ratio_m2: [\n",
        t.rate
    );
    for levels in t.ratio_m2.chunks(5) {
        let each: Vec<_> = levels.iter().map(|x| format!("{x:?}")).collect();
        let _ = writeln!(out, "            {},", each.join(", "));
    }
    let _ = writeln!(
        out,
        "        ],\n        height_sigma_m: {:?},",
        t.height_sigma_m
    );
    for (name, [behind, ahead]) in [("ends", &t.ends), ("starts", &t.starts)] {
        let _ = writeln!(out, "        {name}: [");
        for TreadEnd {
            number,
            off_m,
            sigma_m,
        } in [behind, ahead]
        {
            let _ = writeln!(
                out,
                "            TreadEnd {{\n                number: {number:?},\n                off_m: {off_m:?},\n                \
                 sigma_m: {sigma_m:?},\n            }},"
            );
        }
        out.push_str("        ],\n");
    }
    let _ = writeln!(
        out,
        "        edge_sigma_scale: {:?},\n    }},",
        t.edge_sigma_scale
    );
}

fn entry(out: &mut String, kind: &str, name: &str, fields: &[(&str, &mut f32)]) {
    let _ = writeln!(out, "        // {name}\n        {kind} {{");
    for (field, value) in fields {
        let _ = writeln!(out, "            {field}: {value:?},");
    }
    out.push_str("        },\n");
}

/// Returns a text with every parameter, its standard error and its number of samples.
pub fn print(numbers: &[Number]) -> String {
    let mut out = String::new();
    for n in numbers {
        let _ = writeln!(
            out,
            "  {:<32} {:>10.5} ± {:<9.5} {:>6}",
            n.name, n.value, n.error, n.count
        );
    }
    out
}
