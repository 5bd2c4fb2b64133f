//! The sagittal plane with a map of echoes, as figs. 4 and 10 and as the ground of other plots.

use anyhow::Result;
use stairscan::config::Plane;
use stairscan::signal::grid::PolarMap;

use super::colour::{Palette, Scale};
use super::page::{Axis, Frame, Page, Swatch};
use super::room::LabelPlacer;
use super::sector::{self, Sector};
use super::shape::Shape;
use super::sheet::{FAINT, Face, INK, Sheet, Spot};

/// Maximum width and height of the drawn plane, pixels.
const LARGEST: Spot = (1200.0, 860.0);
/// Minimum width and height of the drawn plane, pixels, for planes that are very long or very flat.
const MIN_SPAN_DB: f64 = 40.0;
/// The label of every colour bar.
const BAR_LABEL: &str = "power [dB of full scale]";

/// Which cells of the polar map are shown as the background of a plot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Background {
    /// Every cell (fig. 4).
    Raw,
    /// CA-CFAR detections; other cells have the minimum power (fig. 10, paper III-C).
    Cfar,
}

/// Texts around the data of a plot.
#[derive(Clone, Debug, Default)]
pub struct PlotTexts {
    /// Title of the plot.
    pub title: String,
    /// Line below the title: recording and settings.
    pub subtitle: String,
    /// Legend: marks with their meanings.
    pub legend: Vec<(Swatch, String)>,
}

/// Sagittal plane of one scan, as the background of plots. All plots of a scan show the same area, with the same
/// colours for the same power.
pub struct SagittalPlane<'a> {
    map: &'a PolarMap,
    view: ((f64, f64), (f64, f64)),
    size: Spot,
    sector: Sector,
    scale: Scale,
}

impl<'a> SagittalPlane<'a> {
    /// Creates the plane of `map` for an area that contains `points` (horizontal distance from the mirror, height above
    /// the ground), metres.
    pub fn new(map: &'a PolarMap, points: &[(f64, f64)]) -> Self {
        let (x, y) = sector::view(map, points);
        let scale = (LARGEST.0 / (x.1 - x.0)).min(LARGEST.1 / (y.1 - y.0));
        // Whole pixels, with the same scale along both axes.
        let pixels = |span: (f64, f64)| ((span.1 - span.0) * scale).round().max(MIN_SPAN_DB);
        let size = (pixels(x), pixels(y));
        let view = ((x.0, x.0 + size.0 / scale), (y.0, y.0 + size.1 / scale));
        let frame = Frame {
            at: (0.0, 0.0),
            size,
            x: view.0,
            y: view.1,
        };
        Self {
            map,
            view,
            size,
            sector: Sector::new(map, &frame),
            scale: span(map),
        }
    }

    /// Returns the same area with another map of the same scan, and that map's colours.
    pub fn showing(self, map: &'a PolarMap) -> Self {
        Self {
            map,
            scale: span(map),
            ..self
        }
    }

    /// Returns a page with this plane's axes, the texts `words`, and a colour bar of `scale`, if any.
    fn page(&self, words: &PlotTexts, scale: Option<Scale>) -> Page {
        Page {
            title: words.title.clone(),
            subtitle: words.subtitle.clone(),
            x: Axis::new("distance from the mirror, horizontal [m]", self.view.0),
            y: Axis::new("height above the ground [m]", self.view.1),
            legend: words.legend.clone(),
            bar: scale.map(|scale| (scale, BAR_LABEL.into())),
            grid: false,
        }
    }

    /// Draws a plot with the map as background, on which `over` draws the plot's own objects, and returns the bytes of
    /// a PNG file.
    pub fn draw(
        &self,
        words: &PlotTexts,
        ground: Background,
        palette: Palette,
        over: impl FnOnce(&Sheet<'_>, &Frame) -> Result<()>,
    ) -> Result<Vec<u8>> {
        let scale = self.scale.with(palette);
        self.page(words, Some(scale))
            .draw(self.size, |sheet, frame| {
                let colours: Vec<_> = (0..=255_u8)
                    .map(|cell| scale.colour(sector::decibels(cell)))
                    .collect();
                let pixels = self.sector.paint(|row, bin| {
                    let shown = ground == Background::Raw || self.map.is_detected(row, bin);
                    let cell = if shown { self.map.cell(row, bin) } else { 0 };
                    colours[usize::from(cell)]
                });
                sheet.lay(frame.at, self.sector.size(), pixels)?;
                over(sheet, frame)?;
                self.draw_mirror(sheet, frame)
            })
    }

    /// Draws the map with nothing on top, and returns the bytes of a PNG file.
    pub fn map(&self, words: &PlotTexts, ground: Background) -> Result<Vec<u8>> {
        self.draw(words, ground, Palette::Viridis, |_, _| Ok(()))
    }

    /// Returns the place of the mirror's centre in the sagittal plane, metres: x = 0, from which horizontal distances
    /// count, and its height above the ground.
    pub fn mirror(&self) -> (f64, f64) {
        (0.0, self.map.geometry().mount_height_m.into())
    }

    /// Returns a placer for labels that avoids the CA-CFAR detections and the mirror.
    pub fn room(&self, frame: &Frame) -> LabelPlacer {
        let mut room = LabelPlacer::new(frame);
        let hit = |(row, bin)| self.map.is_detected(row, bin);
        room.cover_where(|x, y| sector::cell_at(self.map, x, y).is_some_and(hit));
        let (x, y) = self.mirror();
        room.cover_mark(frame.spot(x, y), 44.0);
        room
    }

    /// The scan's polar map.
    pub fn polar(&self) -> &PolarMap {
        self.map
    }

    fn draw_mirror(&self, sheet: &Sheet<'_>, frame: &Frame) -> Result<()> {
        let (x, y) = self.mirror();
        let at = frame.spot(x, y);
        sheet.marker(Shape::Diamond, at, 8.0, INK, plotters::style::WHITE)?;
        let (place, face) = match self.map.geometry().plane {
            Plane::Depth => ((at.0, at.1 - 24.0), Face::plain(20.0)),
            Plane::Height => ((at.0 + 18.0, at.1), Face::plain(20.0).left()),
        };
        sheet.note("mirror", place, face.ink(FAINT))
    }
}

/// Returns the range of powers that the colours cover, dB relative to full scale: from 4 dB below the median cell (the
/// noise) to the strongest cell, rounded outwards to 5 dB.
fn span(map: &PolarMap) -> Scale {
    let mut counts = [0_usize; 256];
    for row in (0..map.rows()).filter(|&row| map.present(row)) {
        for &cell in map.row(row) {
            counts[usize::from(cell)] += 1;
        }
    }
    let cells: usize = counts.iter().sum();
    let mut below = 0;
    let typical = counts.iter().position(|&count| {
        below += count;
        2 * below >= cells
    });
    let highest = counts.iter().rposition(|&count| count > 0);
    let db = |cell: Option<usize>| sector::decibels(cell.unwrap_or(0) as u8);
    let low = ((db(typical) - 4.0) / 5.0).floor() * 5.0;
    let high = (db(highest) / 5.0).ceil() * 5.0;
    Scale {
        low,
        high: high.max(low + 20.0),
        palette: Palette::Viridis,
    }
}
