//! Tables of parts with their cost, and of the power budget, as Markdown.

use std::fmt::Write as _;

use super::table::{Converter, Part, Table};

/// Returns the bill of materials as a Markdown table.
pub fn parts(table: &Table) -> String {
    let mut text = String::new();
    for (title, option) in [("needed", false), ("option or tool", true)] {
        let of: Vec<&Part> = table
            .parts
            .iter()
            .filter(|part| part.option == option)
            .collect();
        let _ = writeln!(
            text,
            "| {title} | part number | about, € | note |\n|---|---|---|---|"
        );
        for Part {
            what,
            number,
            euros,
            note,
            ..
        } in &of
        {
            let _ = writeln!(text, "| {what} | {number} | {euros} | {note} |");
        }
        let sum: u32 = of.iter().map(|part| part.euros).sum();
        let _ = writeln!(text, "| **sum** | | **{sum}** | |\n");
    }
    text.trim_end().to_owned() + "\n"
}

/// Current of a supply rail, mA.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Current {
    /// Typical current on the rail while the scanner scans, mA.
    pub typical: f64,
    /// Maximum current on the rail, mA.
    pub most: f64,
}

/// Returns the current that a rail has to supply: that of its loads, and the input currents of the
/// converters that it feeds.
pub fn current(table: &Table, rail: &str) -> Current {
    let mut sum = Current::default();
    for load in table.loads.iter().filter(|load| load.rail == rail) {
        sum.typical += load.typical_ma;
        sum.most += load.max_ma;
    }
    for converter in table
        .converters
        .iter()
        .filter(|converter| converter.input == rail)
    {
        let out = current(table, &converter.output);
        sum.typical += input(converter, out.typical);
        sum.most += input(converter, out.most);
    }
    sum
}

/// Returns the input current of a converter, mA, for an output current of `out` mA.
fn input(converter: &Converter, out: f64) -> f64 {
    match converter.efficiency {
        Some(share) => out * converter.volts_out / (share * converter.volts_in),
        None => out,
    }
}

/// Returns the power budget as Markdown tables: loads, then rails and converters.
pub fn power(table: &Table) -> String {
    let mut text =
        "| load | rail | typical, mA | at most, mA | from |\n|---|---|---|---|---|\n".to_owned();
    for load in &table.loads {
        let _ = writeln!(
            text,
            "| {} | {} | {:.0} | {:.0} | {} |",
            load.what, load.rail, load.typical_ma, load.max_ma, load.from
        );
    }
    text += "\n| rail | made by | typical, mA | at most, mA | capacity, mA | used at most \
        |\n|---|---|---|---|---|---|\n";
    for converter in &table.converters {
        let Current { typical, most } = current(table, &converter.output);
        let _ = writeln!(
            text,
            "| {} | {} | {typical:.0} | {most:.0} | {:.0} | {:.0} % |",
            converter.output,
            converter.number,
            converter.limit_ma,
            100.0 * most / converter.limit_ma
        );
    }
    if let Some(first) = table.converters.first() {
        let Current { typical, most } = current(table, &first.input);
        let watts = |ma: f64| ma * first.volts_in / 1e3;
        let _ = writeln!(
            text,
            "| {} | chair's battery | {typical:.0} | {most:.0} | | {:.1} W typical, {:.1} W at most |",
            first.input,
            watts(typical),
            watts(most)
        );
    }
    text
}
