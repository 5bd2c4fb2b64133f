//! A drawing of lines, text and dimensions, written as an SVG file.

use std::fmt::Write as _;

use host_sim::html::{escaped, tenths as number};

/// Alignment of a text to its anchor point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins at the point.
    Start,
    /// The text is centred on the point.
    Middle,
    /// The text ends at the point.
    End,
}

/// A point of a drawing: x to the right and y downwards, pixels from the upper left corner.
pub type Place = (f64, f64);

/// A drawing that collects SVG elements.
#[derive(Clone, Debug)]
pub struct Sheet {
    width: f64,
    height: f64,
    body: String,
    /// Bounding box (left, top, right, bottom, pixels) and content of each text, to find overlaps.
    texts: Vec<([f64; 4], String)>,
}

/// Colour of outlines and text.
pub const INK: &str = "#1d2430";
/// Colour of dimensions and notes.
pub const FAINT: &str = "#5b6470";
/// Fill colour of solid parts.
pub const BODY: &str = "#eef1f5";
/// Colour of the radar beam.
pub const BEAM: &str = "#c2410c";

impl Sheet {
    /// Creates an empty drawing of this size, pixels.
    pub fn new(width: f64, height: f64) -> Self {
        Self {
            width,
            height,
            body: String::new(),
            texts: Vec::new(),
        }
    }

    /// Adds a text at a point of its baseline; `size` is the font's, pixels.
    pub fn text(&mut self, (x, y): Place, anchor: Anchor, size: f64, colour: &str, words: &str) {
        let word = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let _ = writeln!(
            self.body,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"{word}\" font-size=\"{size}\" fill=\"{colour}\">{}</text>",
            number(x),
            number(y),
            escaped(words)
        );
        // Estimated wider than the letters of usual fonts.
        let wide = 0.58 * size * words.chars().count() as f64;
        let left = match anchor {
            Anchor::Start => x,
            Anchor::Middle => x - wide / 2.0,
            Anchor::End => x - wide,
        };
        self.texts.push((
            [left, y - 0.8 * size, left + wide, y + 0.2 * size],
            words.to_owned(),
        ));
    }

    /// Adds a rectangle by its upper left corner and its size, pixels.
    pub fn rect(&mut self, (x, y): Place, (wide, high): (f64, f64), fill: &str) {
        let _ = writeln!(
            self.body,
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{fill}\" stroke=\"{INK}\"/>",
            number(x),
            number(y),
            number(wide),
            number(high)
        );
    }

    /// Adds a line through points; `style` holds SVG attributes.
    pub fn path(&mut self, points: &[Place], style: &str) {
        let points: Vec<String> = points
            .iter()
            .map(|(x, y)| format!("{},{}", number(*x), number(*y)))
            .collect();
        let _ = writeln!(
            self.body,
            "<polyline points=\"{}\" {style}/>",
            points.join(" ")
        );
    }

    /// Adds a solid line between two points.
    pub fn line(&mut self, from: Place, to: Place, colour: &str) {
        self.path(&[from, to], &format!("fill=\"none\" stroke=\"{colour}\""));
    }

    /// Adds a dashed line between two points.
    pub fn dashed(&mut self, from: Place, to: Place, colour: &str) {
        self.path(
            &[from, to],
            &format!("fill=\"none\" stroke=\"{colour}\" stroke-dasharray=\"7 4\""),
        );
    }

    /// Adds an ellipse by its centre and its half axes, pixels.
    pub fn ellipse(&mut self, (x, y): Place, (rx, ry): (f64, f64), fill: &str) {
        let _ = writeln!(
            self.body,
            "<ellipse cx=\"{}\" cy=\"{}\" rx=\"{}\" ry=\"{}\" fill=\"{fill}\" stroke=\"{INK}\"/>",
            number(x),
            number(y),
            number(rx),
            number(ry)
        );
    }

    /// Adds a dimension between two places of the same height or the same distance from the left,
    /// with its text above its middle or left of it.
    pub fn dimension(&mut self, from: Place, to: Place, words: &str) {
        self.path(
            &[from, to],
            &format!(
                "fill=\"none\" stroke=\"{FAINT}\" marker-start=\"url(#a)\" marker-end=\"url(#a)\""
            ),
        );
        let (x, y) = ((from.0 + to.0) / 2.0, (from.1 + to.1) / 2.0);
        if from.1 == to.1 {
            self.text((x, y - 5.0), Anchor::Middle, 12.0, FAINT, words);
        } else {
            self.text((x - 6.0, y + 4.0), Anchor::End, 12.0, FAINT, words);
        }
    }

    /// Returns a description of each pair of texts that overlap, and of each text that leaves the
    /// drawing.
    pub fn overlaps(&self) -> Vec<String> {
        let mut found = Vec::new();
        for (k, (a, words)) in self.texts.iter().enumerate() {
            if a[0] < 0.0 || a[1] < 0.0 || a[2] > self.width || a[3] > self.height {
                found.push(format!("{words} leaves the sheet"));
            }
            for (b, others) in &self.texts[k + 1..] {
                if a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3] {
                    found.push(format!("{words} lies over {others}"));
                }
            }
        }
        found
    }

    /// Returns the content of the SVG file.
    pub fn svg(&self) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
             font-family=\"Noto Sans, DejaVu Sans, sans-serif\">\n\
             <defs><marker id=\"a\" markerWidth=\"9\" markerHeight=\"7\" refX=\"8\" refY=\"3.5\" orient=\"auto-start-reverse\">\
             <path d=\"M0,0.5 L8,3.5 L0,6.5 z\" fill=\"{FAINT}\"/></marker></defs>\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n{}</svg>\n",
            self.body,
            w = number(self.width),
            h = number(self.height)
        )
    }
}
