//! Guard sweeps over time as one SVG: the free distance of each sweep, and the first hazard if the
//! recording has its truth.

use std::fmt::Write as _;

use stairscan::verdict::Status;

use super::truth::Truth;
use crate::answer::metres;
use crate::guarded::Guarded;

/// Sizes of the drawing, pixels.
#[derive(Clone, Copy, Debug)]
pub struct StripLayout {
    /// Width and height of the SVG.
    size: [f64; 2],
    /// Rectangle of the plot: left, top, right, bottom.
    area: [f64; 4],
    /// Number of legend entries in a row, and the distance from one to the next.
    legend: (usize, f64),
}

impl StripLayout {
    /// For a screen: wide.
    pub const WIDE: Self = Self {
        size: [760.0, 300.0],
        area: [52.0, 30.0, 748.0, 256.0],
        legend: (4, 130.0),
    };
    /// For a phone: not scaled down at 390 pixels, of which the page's margins take 32.
    pub const NARROW: Self = Self {
        size: [356.0, 300.0],
        area: [44.0, 50.0, 350.0, 256.0],
        legend: (2, 150.0),
    };

    /// Converts a distance (metres) to a vertical position (pixels).
    fn height(&self, m: f64) -> f64 {
        let [_, top, _, bottom] = self.area;
        bottom - (bottom - top) * m.clamp(0.0, TOP_M) / TOP_M
    }
}

/// Minimum distance between the numbers of two sweeps, pixels.
const NUMBER: f64 = 22.0;
/// Height of a row of the legend, pixels.
const LEGEND_ROW: f64 = 20.0;
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

/// Returns the plot of a recording's sweeps as an SVG document: the answers `words`, one per sweep,
/// and the true hazards.
pub fn svg(words: &[Guarded], truth: Option<&Truth>, layout: &StripLayout) -> String {
    let [left, _, right, bottom] = layout.area;
    let width = (right - left) / words.len().max(1) as f64;
    let [w, h] = layout.size;
    let numbered = numbers_apart(width);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n"
    );
    axes(&mut out, layout);
    for (k, word) in words.iter().enumerate() {
        let (x, status) = (left + width * k as f64, word.line.status);
        let colour = COLOURS.iter().find(|(s, _, _)| *s == status);
        let colour = colour.map_or(TRUTH, |(_, colour, _)| colour);
        // A fault has no distance: a mark on the ground line shows the sweep.
        let top = word
            .line
            .free
            .map_or(bottom - 3.0, |free| layout.height(metres(free)));
        let bar = [
            x + 0.5 * (1.0 - BAR) * width,
            top,
            BAR * width,
            bottom - top,
        ];
        rectangle(&mut out, bar, colour);
        if k % numbered == 0 {
            let middle = x + 0.5 * width;
            text(
                &mut out,
                [middle, bottom + 15.0],
                "middle",
                &word.sweep.to_string(),
            );
        }
        if let Some(Some(hazard)) = truth.and_then(|truth| truth.get(k)) {
            rectangle(
                &mut out,
                [x, layout.height(hazard.at_m) - 1.0, width, 2.0],
                TRUTH,
            );
        }
    }
    legend(&mut out, truth.is_some(), layout);
    out + "</svg>\n"
}

/// Returns how many sweeps further the next number stands, for columns of this width (pixels): 1, 2 or 5 times a power
/// of ten.
fn numbers_apart(width: f64) -> usize {
    let steps = (0..6).flat_map(|power| [1, 2, 5].map(|step| step * 10_usize.pow(power)));
    let mut far_enough = steps.filter(|step| *step as f64 * width >= NUMBER);
    far_enough.next().unwrap_or(1_000_000)
}

/// Draws a grid line, labelled with its distance, every half metre.
fn axes(out: &mut String, layout: &StripLayout) {
    let [left, _, right, bottom] = layout.area;
    for half in 0..=5 {
        let m = 0.5 * f64::from(half);
        rectangle(
            out,
            [left, layout.height(m) - 0.5, right - left, 1.0],
            "#d0d0d0",
        );
        text(
            out,
            [left - 6.0, layout.height(m) + 4.0],
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
fn legend(out: &mut String, truth: bool, layout: &StripLayout) {
    let ([left, top, ..], (columns, apart)) = (layout.area, layout.legend);
    // The last row stands 20 pixels above the plot, as if all four entries were there.
    let rows = (COLOURS.len() + 1).div_ceil(columns);
    let bars = COLOURS
        .iter()
        .map(|(_, colour, name)| (*colour, format!("free, {name}")));
    let line = truth.then(|| (TRUTH, "first hazard".to_owned()));
    for (k, (colour, name)) in bars.chain(line).enumerate() {
        let x = left + apart * (k % columns) as f64;
        let y = top - LEGEND_ROW * (rows - k / columns) as f64;
        rectangle(out, [x, y, 12.0, 10.0], colour);
        text(out, [x + 17.0, y + 9.0], "start", &name);
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
        let drawn = svg(&words, Some(&vec![Some(hazard), None]), &StripLayout::WIDE);
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
        assert!(!svg(&words, None, &StripLayout::WIDE).contains(TRUTH));
    }

    /// Returns the numbers after `key="` in `drawn`.
    fn numbers(drawn: &str, key: &str) -> Vec<f64> {
        let mark = format!(" {key}=\"");
        let values = drawn.split(&mark).skip(1);
        values
            .filter_map(|rest| rest.split('"').next()?.parse().ok())
            .collect()
    }

    #[test]
    fn a_phone_gets_a_drawing_of_its_width_with_text_of_full_size() {
        let body = "PSTR,GUARD,1,ok,1250.0,rise,99.8,";
        let sentence = format!("${body}*{:08X}", stairscan::report::sentence::crc32(body));
        let word = Guarded::parse(0, vec![sentence]).unwrap().remove(0);
        let words: Vec<Guarded> = (1..=120)
            .map(|sweep| Guarded {
                sweep,
                ..word.clone()
            })
            .collect();
        let truth = vec![None; 120];
        let drawn = svg(&words, Some(&truth), &StripLayout::NARROW);
        // 390 pixels less the page's margins.
        assert!(drawn.contains("width=\"356\"") && drawn.contains("font-size=\"12\""));
        assert!(
            numbers(&drawn, "x")
                .iter()
                .all(|x| (0.0..=356.0).contains(x)),
            "{drawn}"
        );
        // 7 pixels a character of 12 pixels: no entry of the legend runs into the next or out of the drawing.
        let (_, apart) = StripLayout::NARROW.legend;
        let longest = COLOURS
            .iter()
            .map(|(_, _, name)| "free, ".len() + name.len())
            .max()
            .unwrap();
        assert!(17.0 + 7.0 * longest as f64 <= apart);
        assert!(44.0 + apart + 17.0 + 7.0 * "first hazard".len() as f64 <= 356.0);
        // Every tenth sweep has its number: 25 pixels from one to the next.
        assert!(
            drawn.contains(">11</text>") && !drawn.contains(">2</text>"),
            "{drawn}"
        );
        assert_eq!(
            [306.0, 116.0, 23.2, 6.2, 0.3].map(numbers_apart),
            [1, 1, 1, 5, 100]
        );
    }
}
