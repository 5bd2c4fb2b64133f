//! A plot page: title, axes, legend and colour bar around the data.
//!
//! Data are drawn first and may extend beyond the edges. The margins are painted over them, so that
//! no clipping is needed.

use anyhow::Result;
use plotters::prelude::*;

use super::colour::Scale;
use super::shape::Shape;
use super::sheet::{self, FAINT, Face, INK, OVERSAMPLING, Sheet, Spot, Stroke};

const TITLE: f64 = 31.0;
const SUBTITLE: f64 = 24.0;
const LABEL: f64 = 25.0;
const TICK: f64 = 22.0;
const LEGEND: f64 = 23.0;

const LEFT: f64 = 112.0;
const RIGHT: f64 = 44.0;
const RIGHT_WITH_BAR: f64 = 158.0;
const BELOW: f64 = 92.0;
const LEGEND_LINE: f64 = 36.0;
const SWATCH: f64 = 40.0;
const LEGEND_GAP: f64 = 36.0;

/// Rectangle of the page that shows the data, and ranges of the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Top left corner on the page, pixels.
    pub at: Spot,
    /// Width and height on the page, pixels.
    pub size: Spot,
    /// Minimum and maximum abscissa, in the axis's unit.
    pub x: (f64, f64),
    /// Minimum and maximum ordinate, in the axis's unit.
    pub y: (f64, f64),
}

impl Frame {
    /// Returns the place on the page, pixels, of a point (x, y) in the axes' units.
    pub fn spot(&self, x: f64, y: f64) -> Spot {
        let across = (x - self.x.0) / (self.x.1 - self.x.0);
        let up = (y - self.y.0) / (self.y.1 - self.y.0);
        (
            self.at.0 + across * self.size.0,
            self.at.1 + (1.0 - up) * self.size.1,
        )
    }

    /// Returns the frame's width and height in enlarged pixels, [`OVERSAMPLING`] to a pixel of the page.
    pub fn enlarged(&self) -> (u32, u32) {
        let n = f64::from(OVERSAMPLING);
        (
            (self.size.0 * n).round() as u32,
            (self.size.1 * n).round() as u32,
        )
    }

    /// Whether a point (x, y) in the axes' units lies inside.
    pub fn holds(&self, x: f64, y: f64) -> bool {
        (self.x.0..=self.x.1).contains(&x) && (self.y.0..=self.y.1).contains(&y)
    }
}

/// Mark of a legend entry: line, marker or area.
#[derive(Clone, Copy, Debug)]
pub enum Swatch {
    /// A line.
    Line(Stroke),
    /// A marker: shape, radius in pixels, colour.
    Mark(Shape, f64, RGBColor),
    /// An area: colour, opacity, outline.
    Area(RGBColor, f64, Stroke),
}

/// One axis of a plot.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Text beside the axis: the quantity with its unit.
    pub label: String,
    /// Minimum and maximum value, in the label's unit.
    pub span: (f64, f64),
}

impl Axis {
    /// Creates an axis named `label` over `span`.
    pub fn new(label: &str, span: (f64, f64)) -> Self {
        Self {
            label: label.into(),
            span,
        }
    }
}

/// Page around a plot's data: title, axes, legend and colour bar.
#[derive(Clone, Debug)]
pub struct Page {
    /// Title above the plot.
    pub title: String,
    /// Line below the title, such as recording and settings.
    pub subtitle: String,
    /// The abscissa.
    pub x: Axis,
    /// The ordinate.
    pub y: Axis,
    /// Legend: marks with their meanings.
    pub legend: Vec<(Swatch, String)>,
    /// Colour scale of the data and its label; `None` for no colour bar.
    pub bar: Option<(Scale, String)>,
    /// Whether a grid is drawn, for data that are lines.
    pub grid: bool,
}

/// Returns the spacing of the ticks for 4 to 10 of them: 1, 2 or 5 times a power of ten.
fn tick_step(span: f64) -> f64 {
    let rough = span / 10.0;
    let decade = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .find(|s| s * decade >= rough * 0.999)
        .unwrap_or(10.0);
    step * decade
}

/// Returns the positions of ticks within `span`: round numbers, at least `apart` apart, and the number of their
/// decimals.
fn ticks(span: (f64, f64), apart: f64) -> (Vec<f64>, usize) {
    let step = tick_step(span.1 - span.0).max(apart);
    if !step.is_normal() {
        // An empty or infinite span.
        return (Vec::new(), 0);
    }
    let first = (span.0 / step - 1e-6).ceil() as i64;
    let last = (span.1 / step + 1e-6).floor() as i64;
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    ((first..=last).map(|k| k as f64 * step).collect(), decimals)
}

/// Formats a number with a true minus sign.
pub fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.contains(|c: char| c.is_ascii_digit() && c != '0') => format!("−{rest}"),
        Some(rest) => rest.to_owned(),
        None => text,
    }
}

impl Page {
    /// Returns the page's size, pixels, and its frame for data of `size` pixels (rounded to whole ones).
    pub fn layout(&self, size: Spot) -> ((u32, u32), Frame) {
        let size = (size.0.round(), size.1.round());
        let right = if self.bar.is_some() {
            RIGHT_WITH_BAR
        } else {
            RIGHT
        };
        let titles = [
            (TITLE, true, &self.title),
            (SUBTITLE, false, &self.subtitle),
        ];
        let widest = titles.map(|(size, bold, text)| {
            let face = Face::plain(size);
            let face = if bold { face.bold() } else { face };
            face.width(text)
        });
        let least = widest[0].max(widest[1]) + 2.0 * RIGHT;
        let spare = (least - (LEFT + size.0 + right)).max(0.0);
        let above = if self.subtitle.is_empty() {
            64.0
        } else {
            100.0
        };
        let frame = Frame {
            at: ((LEFT + spare / 2.0).round(), above),
            size,
            x: self.x.span,
            y: self.y.span,
        };
        let width = LEFT + size.0 + right + spare;
        let lines = self.legend_lines(width).len();
        let height = above + size.1 + BELOW + LEGEND_LINE * lines as f64 + 8.0;
        ((width.ceil() as u32, height.ceil() as u32), frame)
    }

    /// Draws the page around `size` pixels of data, which `data` draws, and returns the bytes of a PNG file.
    pub fn draw(
        &self,
        size: Spot,
        data: impl FnOnce(&Sheet<'_>, &Frame) -> Result<()>,
    ) -> Result<Vec<u8>> {
        let (page, frame) = self.layout(size);
        sheet::draw(page, |sheet| {
            data(sheet, &frame)?;
            self.surround(sheet, page, &frame)
        })
    }

    /// Draws margins, axes, titles, legend and colour bar.
    pub fn surround(&self, sheet: &Sheet<'_>, page: (u32, u32), frame: &Frame) -> Result<()> {
        let (w, h) = (f64::from(page.0), f64::from(page.1));
        let (left, top) = frame.at;
        let (right, bottom) = (left + frame.size.0, top + frame.size.1);
        for (a, b) in [
            ((0.0, 0.0), (w, top - 1.0)),
            ((0.0, bottom + 1.0), (w, h)),
            ((0.0, 0.0), (left - 1.0, h)),
            ((right + 1.0, 0.0), (w, h)),
        ] {
            sheet.fill_box(a, b, WHITE, 1.0)?;
        }
        self.axes(sheet, frame)?;
        let middle = w / 2.0;
        sheet.text(&self.title, (middle, 34.0), Face::plain(TITLE).bold())?;
        if !self.subtitle.is_empty() {
            let face = Face::plain(SUBTITLE).ink(FAINT);
            sheet.text(&self.subtitle, (middle, 70.0), face)?;
        }
        if let Some((scale, label)) = &self.bar {
            colour_bar(sheet, frame, scale, label)?;
        }
        self.draw_legend(sheet, w, bottom + BELOW)
    }

    fn axes(&self, sheet: &Sheet<'_>, frame: &Frame) -> Result<()> {
        let (left, top) = frame.at;
        let (right, bottom) = (left + frame.size.0, top + frame.size.1);
        let line = Stroke::solid(INK, 1.5);
        let grid = Stroke::solid(INK, 1.0).alpha(0.13);
        // Labels of one axis must not touch each other.
        let apart = |span: (f64, f64), length: f64, room: f64| room * (span.1 - span.0) / length;
        let (xs, decimals) = ticks(frame.x, apart(frame.x, frame.size.0, 62.0));
        for x in xs {
            let (at, _) = frame.spot(x, 0.0);
            if self.grid {
                sheet.line(&[(at, top), (at, bottom)], grid)?;
            }
            sheet.line(&[(at, bottom), (at, bottom + 7.0)], line)?;
            let text = number(x, decimals);
            sheet.text(&text, (at, bottom + 23.0), Face::plain(TICK))?;
        }
        let (ys, decimals) = ticks(frame.y, apart(frame.y, frame.size.1, 34.0));
        for y in ys {
            let (_, at) = frame.spot(0.0, y);
            if self.grid {
                sheet.line(&[(left, at), (right, at)], grid)?;
            }
            sheet.line(&[(left - 7.0, at), (left, at)], line)?;
            let text = number(y, decimals);
            sheet.text(&text, (left - 13.0, at), Face::plain(TICK).right())?;
        }
        let corners = [
            (left, top),
            (right, top),
            (right, bottom),
            (left, bottom),
            (left, top),
        ];
        sheet.line(&corners, line)?;
        let middle = ((left + right) / 2.0, (top + bottom) / 2.0);
        sheet.text(&self.x.label, (middle.0, bottom + 58.0), Face::plain(LABEL))?;
        let place = (left - 84.0, middle.1);
        sheet.text(&self.y.label, place, Face::plain(LABEL).upright())
    }

    /// Breaks the legend into lines that fit a page of `width` pixels. Returns each line's entries and its width,
    /// pixels.
    fn legend_lines(&self, width: f64) -> Vec<(Vec<&(Swatch, String)>, f64)> {
        let mut lines: Vec<(Vec<&(Swatch, String)>, f64)> = Vec::new();
        for entry in &self.legend {
            let long = SWATCH + 12.0 + Face::plain(LEGEND).width(&entry.1);
            match lines.last_mut() {
                Some((line, used)) if *used + LEGEND_GAP + long <= width - 60.0 => {
                    line.push(entry);
                    *used += LEGEND_GAP + long;
                }
                _ => lines.push((vec![entry], long)),
            }
        }
        lines
    }

    fn draw_legend(&self, sheet: &Sheet<'_>, width: f64, top: f64) -> Result<()> {
        let face = Face::plain(LEGEND).left();
        for (k, (line, used)) in self.legend_lines(width).iter().enumerate() {
            let y = top + LEGEND_LINE * (k as f64 + 0.35);
            let mut x = (width - used) / 2.0;
            for (swatch, label) in line {
                draw_swatch(sheet, swatch, (x, y))?;
                sheet.text(label, (x + SWATCH + 12.0, y), face)?;
                x += SWATCH + 12.0 + face.width(label) + LEGEND_GAP;
            }
        }
        Ok(())
    }
}

fn draw_swatch(sheet: &Sheet<'_>, swatch: &Swatch, (x, y): Spot) -> Result<()> {
    match *swatch {
        Swatch::Line(stroke) => sheet.line(&[(x, y), (x + SWATCH, y)], stroke),
        Swatch::Mark(shape, radius, ink) => sheet.marker(
            shape,
            (x + SWATCH / 2.0 + 6.0, y),
            radius.max(5.0),
            ink,
            WHITE,
        ),
        Swatch::Area(ink, alpha, edge) => {
            let (a, b) = ((x, y - 9.0), (x + SWATCH, y + 9.0));
            sheet.fill_box(a, b, ink, alpha)?;
            sheet.line(&[a, (b.0, a.1), b, (a.0, b.1), a], edge)
        }
    }
}

fn colour_bar(sheet: &Sheet<'_>, frame: &Frame, scale: &Scale, label: &str) -> Result<()> {
    const WIDTH: f64 = 22.0;
    let left = frame.at.0 + frame.size.0 + 26.0;
    let (top, bottom) = (frame.at.1, frame.at.1 + frame.size.1);
    let rows = ((bottom - top) * f64::from(OVERSAMPLING)) as u32;
    let columns = (WIDTH * f64::from(OVERSAMPLING)) as u32;
    let at = |row: u32| {
        let up = 1.0 - (f64::from(row) + 0.5) / f64::from(rows);
        scale.colour(scale.low + up * (scale.high - scale.low))
    };
    let pixels = (0..rows).flat_map(|row| {
        let RGBColor(r, g, b) = at(row);
        std::iter::repeat_n([r, g, b], columns as usize).flatten()
    });
    sheet.lay((left, top), (columns, rows), pixels.collect())?;
    let line = Stroke::solid(INK, 1.2);
    let corners = [
        (left, top),
        (left + WIDTH, top),
        (left + WIDTH, bottom),
        (left, bottom),
        (left, top),
    ];
    sheet.line(&corners, line)?;
    let span = scale.high - scale.low;
    let (marks, decimals) = ticks((scale.low, scale.high), 34.0 * span / frame.size.1);
    for db in marks {
        let y = bottom - (db - scale.low) / span * (bottom - top);
        sheet.line(&[(left + WIDTH, y), (left + WIDTH + 6.0, y)], line)?;
        let place = (left + WIDTH + 11.0, y);
        sheet.text(&number(db, decimals), place, Face::plain(TICK).left())?;
    }
    let place = (left + WIDTH + 82.0, (top + bottom) / 2.0);
    sheet.text(label, place, Face::plain(LABEL).upright())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks((0.0, 1.0), 0.0).0.len(), 11);
        for nothing in [(0.4, 0.4), (0.0, f64::INFINITY), (0.0, f64::NAN)] {
            assert_eq!(ticks(nothing, f64::NAN), (Vec::new(), 0));
        }
        let (marks, decimals) = ticks((-0.31, 1.29), 0.0);
        assert_eq!((marks.len(), decimals), (8, 1));
        assert!((marks[0] + 0.2).abs() < 1e-12 && (marks[7] - 1.2).abs() < 1e-12);
        assert_eq!(
            ticks((-90.0, 0.0), 0.0),
            ((-9..=0).map(|k| f64::from(k) * 10.0).collect(), 0)
        );
    }

    #[test]
    fn numbers_have_a_minus_and_zero_has_none() {
        assert_eq!(number(-1.25, 1), "−1.2");
        assert_eq!(number(-0.001, 1), "0.0");
        assert_eq!(number(3.0, 0), "3");
    }

    #[test]
    fn corners_are_where_the_axes_end() {
        let frame = Frame {
            at: (100.0, 50.0),
            size: (800.0, 400.0),
            x: (-0.5, 1.5),
            y: (0.0, 1.0),
        };
        assert_eq!(frame.spot(-0.5, 1.0), (100.0, 50.0));
        assert_eq!(frame.spot(1.5, 0.0), (900.0, 450.0));
        assert_eq!(frame.spot(0.5, 0.5), (500.0, 250.0));
        assert!(frame.holds(1.5, 0.0) && !frame.holds(1.6, 0.0));
    }
}
