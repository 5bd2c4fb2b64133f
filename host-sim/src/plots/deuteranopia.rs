//! Simulation of deuteranopia for the colours: Machado, Oliveira and Fernandes 2009, deuteranomaly
//! of severity 1.0, in linear sRGB; differences are CIEDE2000.
//!
//! A difference of 1 is just visible side by side. A colour looked up in a legend must be recognised
//! away from it, so that 10 is required here, some four times the difference for neighbouring
//! swatches.

use palette::color_difference::Ciede2000;
use palette::{FromColor, Lab, LinSrgb, Srgb};
use plotters::style::RGBColor;
use stairscan::verdict::Status;

use super::colour::{self, HUES, TRUE};
use super::inspect::MARKS;
use super::posterior;
use super::sheet::INK;

/// Minimum CIEDE2000 difference of two colours with different meanings in one plot.
const APART: f32 = 10.0;

const DEUTERANOPIA: [[f32; 3]; 3] = [
    [0.367322, 0.860646, -0.227968],
    [0.280085, 0.672501, 0.047413],
    [-0.011820, 0.042940, 0.968881],
];

fn seen(RGBColor(r, g, b): RGBColor) -> Lab {
    let linear: LinSrgb = Srgb::new(r, g, b).into_format::<f32>().into_linear();
    let (r, g, b) = linear.into_components();
    let [r, g, b] = DEUTERANOPIA.map(|row| (row[0] * r + row[1] * g + row[2] * b).clamp(0.0, 1.0));
    Lab::from_color(LinSrgb::new(r, g, b))
}

fn apart(a: RGBColor, b: RGBColor) -> f32 {
    seen(a).difference(seen(b))
}

/// Asserts that every two of `colours` (name, colour) can be distinguished with deuteranopia.
fn all_apart(colours: &[(&str, RGBColor)]) {
    for (k, (one, a)) in colours.iter().enumerate() {
        for (other, b) in &colours[k + 1..] {
            let difference = apart(*a, *b);
            assert!(difference >= APART, "{one} and {other}: {difference:.1}");
        }
    }
}

/// Parses a colour of the form `#rrggbb`; `None` for other text.
fn hex(text: &str) -> Option<RGBColor> {
    let digits = text.trim().strip_prefix('#')?.get(..6)?;
    let part = |k: usize| u8::from_str_radix(digits.get(k..k + 2)?, 16).ok();
    Some(RGBColor(part(0)?, part(2)?, part(4)?))
}

#[test]
fn the_simulation_is_the_published_one() {
    // Red and green that only green cones distinguish; blue and yellow that other cones
    // distinguish.
    let (red, green) = (RGBColor(180, 90, 60), RGBColor(125, 118, 45));
    assert!(apart(red, green) < 8.0, "{}", apart(red, green));
    assert!(apart(RGBColor(0, 0, 255), RGBColor(255, 255, 0)) > 60.0);
    assert_eq!(apart(INK, INK), 0.0);
}

#[test]
fn colours_of_the_pictures_are_distinguished() {
    let names = [
        "blue",
        "vermilion",
        "green",
        "purple",
        "orange",
        "sky",
        "brown",
        "indigo",
    ];
    let mut colours: Vec<_> = names.into_iter().zip(HUES).collect();
    colours.extend([("truth", TRUE), ("ink", INK)]);
    all_apart(&colours);
}

/// Compares the runners-up's strokes as they appear on white: their opacity lets the ground show through.
#[test]
fn rivals_are_distinguished_as_they_are_drawn() {
    let on_white = |ink: RGBColor| {
        let part = |v: u8| 255.0 - posterior::OPACITY * (255.0 - f64::from(v));
        RGBColor(part(ink.0) as u8, part(ink.1) as u8, part(ink.2) as u8)
    };
    let strokes: Vec<_> = posterior::strokes().collect();
    let mut colours: Vec<_> = strokes.iter().map(|s| ("rival", on_white(s.ink))).collect();
    colours.extend([("answer", HUES[1]), ("ink", INK)]);
    all_apart(&colours);
    for pair in strokes.windows(2) {
        assert!(pair[0].width < pair[1].width && pair[0].dash != pair[1].dash);
    }
}

#[test]
fn roles_have_shapes_of_their_own() {
    for (k, a) in MARKS.iter().enumerate() {
        for b in &MARKS[k + 1..] {
            assert_ne!(a.shape, b.shape, "{} and {}", a.role, b.role);
            let difference = apart(a.ink, b.ink);
            let distinct = a.ink == b.ink || difference >= APART;
            assert!(distinct, "{} and {}: {difference}", a.role, b.role);
        }
    }
}

#[test]
fn colours_of_the_page_are_distinguished() {
    let script = include_str!("../../../replay/src/html/draw.js");
    for scheme in ["  light: {", "  dark: {"] {
        let inside = script.lines().find_map(|line| line.strip_prefix(scheme));
        // The map's colours, and those of frame and beam, follow the layers; they have no meaning
        // to be confused.
        let (layers, _) = inside.unwrap().split_once(", beam:").unwrap();
        let colours: Vec<(&str, RGBColor)> = layers
            .split(',')
            .filter_map(|entry| entry.split_once(':'))
            .map(|(name, value)| (name.trim(), hex(value.trim().trim_matches('"')).unwrap()))
            .collect();
        assert!(colours.len() >= 7, "{colours:?}");
        all_apart(&colours);
    }
    let style = include_str!("../../../replay/src/html/page.css");
    let states = [Status::Ok, Status::Degraded, Status::Fault].map(|status| {
        let name = status.as_str();
        let (_, value) = style.split_once(&format!("--{name}:")).unwrap();
        let colour = hex(value).unwrap();
        assert_eq!(colour, colour::status(status), "{name}");
        (name, colour)
    });
    all_apart(&states);
    let (_, dark) = style.split_once("prefers-color-scheme: dark").unwrap();
    let of = |status: Status| {
        let (_, value) = dark.split_once(&format!("--{}:", status.as_str())).unwrap();
        (status.as_str(), hex(value).unwrap())
    };
    all_apart(&[Status::Ok, Status::Degraded, Status::Fault].map(of));
}
