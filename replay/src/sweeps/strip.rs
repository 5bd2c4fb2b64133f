//! Guard sweeps over time as one SVG: the free distance of each sweep, and the first hazard if the
//! recording has its truth.

use std::fmt::Write as _;

use stairscan::verdict::Status;

use super::truth::Truth;
use crate::answer::metres;
use crate::guarded::Guarded;

/// Size of the SVG, and the rectangle of the plot (left, top, right, bottom), pixels.
const SIZE: [f64; 2] = [760.0, 300.0];
const AREA: [f64; 4] = [52.0, 30.0, 748.0, 256.0];
/// Distance at the top of the plot, metres: hazards beyond 2.5 m are not counted.
const TOP_M: f64 = 2.5;
/// Fraction of the width of a sweep's column that its bar takes.
const BAR: f64 = 0.8;
/// Colour and legend of each status; the colours are distinguishable with red-green colour
/// blindness (Okabe and Ito).
const COLOURS: [(Status, &str, &str); 3] = [
    (Status::Ok, "#0072b2", "ok"),
    (Status::Degraded, "#e69f00", "degraded"),
    (Status::Fault, "#8c8c8c", "fault"),
];
/// Colour of the mark of the true hazard.
const TRUTH: &str = "#d55e00";

/// Converts a distance (metres) to a vertical position in the SVG (pixels).
fn height(m: f64) -> f64 {
    let [_, top, _, bottom] = AREA;
    bottom - (bottom - top) * m.clamp(0.0, TOP_M) / TOP_M
}

/// Returns the plot of a recording's sweeps as an SVG document: the answers `words`, one per sweep,
/// and the true hazards.
pub fn svg(words: &[Guarded], truth: Option<&Truth>) -> String {
    let [left, _, right, bottom] = AREA;
    let width = (right - left) / words.len().max(1) as f64;
    let [w, h] = SIZE;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n"
    );
    axes(&mut out);
    for (k, word) in words.iter().enumerate() {
        let (x, status) = (left + width * k as f64, word.line.status);
        let colour = COLOURS.iter().find(|(s, _, _)| *s == status);
        let colour = colour.map_or(TRUTH, |(_, colour, _)| colour);
        // A fault has no distance: a mark on the ground line shows the sweep.
        let top = word
            .line
            .free
            .map_or(bottom - 3.0, |free| height(metres(free)));
        let bar = [
            x + 0.5 * (1.0 - BAR) * width,
            top,
            BAR * width,
            bottom - top,
        ];
        rectangle(&mut out, bar, colour);
        if words.len() <= 30 || k % 10 == 0 {
            let middle = x + 0.5 * width;
            text(
                &mut out,
                [middle, bottom + 15.0],
                "middle",
                &word.sweep.to_string(),
            );
        }
        if let Some(Some(hazard)) = truth.and_then(|truth| truth.get(k)) {
            rectangle(&mut out, [x, height(hazard.at_m) - 1.0, width, 2.0], TRUTH);
        }
    }
    legend(&mut out, truth.is_some());
    out + "</svg>\n"
}

/// Draws a grid line, labelled with its distance, every half metre.
fn axes(out: &mut String) {
    let [left, _, right, bottom] = AREA;
    for half in 0..=5 {
        let m = 0.5 * f64::from(half);
        rectangle(out, [left, height(m) - 0.5, right - left, 1.0], "#d0d0d0");
        text(
            out,
            [left - 6.0, height(m) + 4.0],
            "end",
            &format!("{m:.1} m"),
        );
    }
    text(
        out,
        [0.5 * (left + right), bottom + 34.0],
        "middle",
        "guard sweep",
    );
}

/// Draws the legend of the colours, with the true hazard's if `truth`.
fn legend(out: &mut String, truth: bool) {
    let [left, top, ..] = AREA;
    let bars = COLOURS
        .iter()
        .map(|(_, colour, name)| (*colour, format!("free, {name}")));
    let line = truth.then(|| (TRUTH, "first hazard".to_owned()));
    for (k, (colour, name)) in bars.chain(line).enumerate() {
        let x = left + 130.0 * k as f64;
        rectangle(out, [x, top - 20.0, 12.0, 10.0], colour);
        text(out, [x + 17.0, top - 11.0], "start", &name);
    }
}

fn rectangle(out: &mut String, [x, y, width, height]: [f64; 4], colour: &str) {
    let _ = writeln!(
        out,
        "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{colour}\"/>"
    );
}

fn text(out: &mut String, [x, y]: [f64; 2], anchor: &str, words: &str) {
    let _ = writeln!(
        out,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"#1b1b1b\">{words}</text>"
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweeps::truth::Hazard;
    use stairscan::verdict::HazardKind;

    #[test]
    fn each_sweep_has_a_bar_and_its_hazard_a_line() {
        let bodies = [
            "PSTR,GUARD,1,ok,1250.0,rise,99.8,",
            "PSTR,GUARD,2,fault,,unknown,0.0,motor-stall",
        ];
        let sentences =
            bodies.map(|body| format!("${body}*{:08X}", stairscan::report::sentence::crc32(body)));
        let words = Guarded::parse(0, sentences.to_vec()).unwrap();
        let hazard = Hazard {
            at_m: 1.25,
            kind: HazardKind::Rise,
        };
        let drawn = svg(&words, Some(&vec![Some(hazard), None]));
        // Half of the height: 1.25 of 2.5 m.
        assert!(
            drawn.contains("y=\"143.0\" width=\"278.4\" height=\"113.0\" fill=\"#0072b2\""),
            "{drawn}"
        );
        assert!(drawn.contains("y=\"253.0\" width=\"278.4\" height=\"3.0\" fill=\"#8c8c8c\""));
        assert_eq!(
            drawn
                .matches(&format!("height=\"2.0\" fill=\"{TRUTH}\""))
                .count(),
            1
        );
        assert!(!svg(&words, None).contains(TRUTH));
    }
}
