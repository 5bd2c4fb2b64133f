//! Compares the table of parts with the firmware, and the committed files with those that are
//! generated from the table.

use std::collections::{BTreeMap, BTreeSet};

use super::table::table;
use super::{optics, tables, wiring};

const HARDWARE: &str = include_str!("../../../docs/user/hardware.md");
const START: &str = include_str!("../../../src/board/start.rs");
const LOADER: &str = include_str!("../../../boot/src/chip/pin.rs");
const DOCUMENT: &str = include_str!("../../../docs/user/build.md");

/// Returns the microcontroller's pin for each signal in the table.
fn wired() -> BTreeMap<&'static str, &'static str> {
    let wires = table().blocks.iter().flat_map(|block| &block.wires);
    let mut pins = BTreeMap::new();
    for wire in wires {
        let before = pins.insert(wire.signal.as_str(), wire.chip.as_str());
        assert_eq!(before, None, "{} is wired twice", wire.signal);
    }
    pins
}

/// Returns `text` if it is the name of a pin, such as `PA9`; else `None`.
fn pin(text: &str) -> Option<String> {
    let rest = text.strip_prefix(['P', 'p'])?;
    let mut letters = rest.chars();
    let port = letters.next()?.to_ascii_uppercase();
    let digits = letters.as_str();
    let good = ('A'..='C').contains(&port)
        && (1..=2).contains(&digits.len())
        && digits.bytes().all(|b| b.is_ascii_digit());
    good.then(|| format!("P{port}{digits}"))
}

#[test]
fn every_pin_of_the_firmware_is_wired_and_no_other() {
    let words = [START, LOADER].map(|text| text.split(|c: char| !c.is_ascii_alphanumeric()));
    let firmware: BTreeSet<String> = words.into_iter().flatten().filter_map(pin).collect();
    assert!(firmware.len() > 15, "{firmware:?}");
    // The pins of the debug probe belong to the chip.
    let probe = ["PA13", "PA14", "NRST"];
    let wired: BTreeSet<String> = wired()
        .values()
        .filter(|pin| !probe.contains(pin))
        .map(|pin| (*pin).to_owned())
        .collect();
    assert_eq!(
        wired, firmware,
        "src/board/start.rs, boot/src/chip/pin.rs and studies/src/hardware/table.toml"
    );
}

#[test]
fn signals_are_at_the_pins_of_the_hardware_s_document() {
    let rows = HARDWARE
        .lines()
        .skip_while(|line| !line.starts_with("| signal | pin |"))
        .skip(2);
    let mut documented = BTreeMap::new();
    for row in rows.take_while(|line| line.starts_with('|')) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let pins = cells[2]
            .split([',', ' '])
            .filter(|word| pin(word).is_some() || *word == "NRST");
        for (signal, pin) in cells[1].split(", ").zip(pins) {
            documented.insert(signal, pin);
        }
    }
    assert!(documented.len() > 15, "{documented:?}");
    assert_eq!(wired(), documented);
}

#[test]
fn every_rail_gives_what_is_taken() {
    let table = table();
    for converter in &table.converters {
        let most = tables::current(table, &converter.output).most;
        assert!(most > 0.0, "{} feeds nothing", converter.number);
        assert!(
            most <= 0.9 * converter.limit_ma,
            "{}: {most:.0} mA",
            converter.number
        );
    }
    for load in &table.loads {
        let fed = table
            .converters
            .iter()
            .any(|converter| converter.output == load.rail);
        assert!(fed, "{}: nothing makes {}", load.what, load.rail);
    }
    // By hand: 3.3 V radar, 5 V and the motor, through their converters.
    let radar = 260.0 * 3.3 / (0.80 * 12.0);
    let chip = 167.0 * 5.0 / (0.85 * 12.0);
    let most = (770.0 + radar + chip) * 12.0 / (0.80 * 24.0);
    assert!((tables::current(table, "24 V").most - most).abs() < 0.5);
}

/// All rays from the focus have the same optical path. Half a wavelength of error at the edge of
/// the lens would spoil the beam.
#[test]
fn every_way_through_the_lens_is_as_long() {
    let optics = optics::Optics::new();
    let way = |y: f64| {
        let x = optics::sag(y);
        (50.0 + x).hypot(y) + 1.53 * (optics.thick - x)
    };
    for y in 0..=35 {
        assert!(
            (way(f64::from(y)) - way(0.0)).abs() < 1e-9,
            "{y} mm off the axis"
        );
    }
    // The path from chip to mirror is that of `mirror-offset`.
    assert!((way(0.0) + optics.gap - 220.0).abs() < 1e-9);
    assert!(
        (69.0..=70.0).contains(&optics.clear),
        "docs/design/modules.md says some 70 mm: {}",
        optics.clear
    );
    assert!(optics.mirror.0 > optics.clear);
}

#[test]
fn no_words_of_the_drawings_overlap() {
    for sheet in [wiring::draw(table()), optics::draw()] {
        assert_eq!(sheet.overlaps(), Vec::<String>::new());
    }
}

#[test]
fn the_committed_files_are_what_the_command_makes() {
    let files = [
        (
            "docs/generated/wiring.svg",
            include_str!("../../../docs/generated/wiring.svg"),
            wiring::draw(table()).svg(),
        ),
        (
            "docs/generated/optics.svg",
            include_str!("../../../docs/generated/optics.svg"),
            optics::draw().svg(),
        ),
    ];
    for (name, committed, made) in files {
        assert!(committed == made, "{name}: sh docs/make build");
    }
    assert!(
        DOCUMENT.contains(&tables::parts(table())),
        "docs/user/build.md: sh docs/make build"
    );
}
