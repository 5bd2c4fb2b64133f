//! A drawing surface for pixels, text, lines and markers, encoded as a PNG file.
//!
//! Everything is drawn at twice the final size and averaged down, because `plotters` smooths
//! neither thick lines nor filled shapes. Places are final pixels, from the top left corner.

use std::sync::Once;

use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, FontTransform, register_font};

/// A place on the sheet, final pixels.
pub type Spot = (f64, f64);

/// Oversampling factor along each axis.
pub const OVERSAMPLING: u32 = 2;
const SCALE: f64 = OVERSAMPLING as f64;

/// Font family of all text. The program's own fonts are registered under this name, that of the default of
/// `plotters`.
const FAMILY: FontFamily<'static> = FontFamily::SansSerif;

/// Colour of axes and text.
pub const INK: RGBColor = RGBColor(34, 38, 46);
/// Colour of secondary text.
pub const FAINT: RGBColor = RGBColor(105, 112, 122);

/// Style of a text.
#[derive(Clone, Copy)]
pub struct Face {
    /// Font height from the highest to the lowest stroke, pixels.
    pub size: f64,
    /// Whether the text is bold.
    pub bold: bool,
    /// Colour of the text.
    pub ink: RGBColor,
    /// Horizontal alignment of the text to its spot.
    pub anchor: HPos,
    /// Whether the text is turned to read from bottom to top.
    pub upright: bool,
}

impl Face {
    /// Creates the style of centred, regular text, `size` pixels high.
    pub const fn plain(size: f64) -> Self {
        Self {
            size,
            bold: false,
            ink: INK,
            anchor: HPos::Center,
            upright: false,
        }
    }

    /// Returns the style in bold.
    pub const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// Returns the style with text beginning at its spot.
    pub const fn left(self) -> Self {
        Self {
            anchor: HPos::Left,
            ..self
        }
    }

    /// Returns the style with text ending at its spot.
    pub const fn right(self) -> Self {
        Self {
            anchor: HPos::Right,
            ..self
        }
    }

    /// Returns the style in another colour.
    pub const fn ink(self, ink: RGBColor) -> Self {
        Self { ink, ..self }
    }

    /// Returns the style with text turned to read from bottom to top.
    pub const fn upright(self) -> Self {
        Self {
            upright: true,
            ..self
        }
    }

    fn font(&self) -> FontDesc<'static> {
        let style = if self.bold {
            FontStyle::Bold
        } else {
            FontStyle::Normal
        };
        let turn = if self.upright {
            FontTransform::Rotate270
        } else {
            FontTransform::None
        };
        FontDesc::new(FAMILY, self.size * SCALE, style).transform(turn)
    }

    /// Returns the width of `text`, pixels.
    pub fn width(&self, text: &str) -> f64 {
        let flat = Self {
            upright: false,
            ..*self
        };
        register_fonts();
        flat.font()
            .box_size(text)
            .map_or(0.0, |(w, _)| f64::from(w) / SCALE)
    }
}

/// Style of a drawn line.
#[derive(Clone, Copy, Debug)]
pub struct Stroke {
    /// Colour of the line.
    pub ink: RGBColor,
    /// Opacity of the line, 0…1.
    pub alpha: f64,
    /// Width of the line, pixels.
    pub width: f64,
    /// Length of dash and gap, pixels; `None` for a solid line.
    pub dash: Option<(f64, f64)>,
}

impl Stroke {
    /// Creates a solid line.
    pub const fn solid(ink: RGBColor, width: f64) -> Self {
        Self {
            ink,
            alpha: 1.0,
            width,
            dash: None,
        }
    }

    /// Returns the style with dashes and gaps of these lengths, pixels.
    pub const fn dashed(self, dash: f64, gap: f64) -> Self {
        Self {
            dash: Some((dash, gap)),
            ..self
        }
    }

    /// Returns the style with this opacity, 0…1.
    pub const fn alpha(self, alpha: f64) -> Self {
        Self { alpha, ..self }
    }
}

/// The drawing surface, which becomes a PNG file.
pub struct Sheet<'a> {
    area: DrawingArea<BitMapBackend<'a>, Shift>,
}

/// Registers the fonts that are part of the program, because a machine may have none.
fn register_fonts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        for (style, bytes) in [
            (FontStyle::Normal, notosans::REGULAR_TTF),
            (FontStyle::Bold, notosans::BOLD_TTF),
        ] {
            // Fails only for bytes that are no font; text output then reports the missing font.
            let _ = register_font(FAMILY.as_str(), style, bytes);
        }
    });
}

/// Returns the pixel of the enlarged sheet at a spot.
fn enlarged(spot: Spot) -> (i32, i32) {
    // `as` saturates, so that places far outside stay outside.
    (
        (spot.0 * SCALE).round() as i32,
        (spot.1 * SCALE).round() as i32,
    )
}

/// Draws on a white sheet of `size` pixels and returns the bytes of a PNG file.
pub fn draw(size: (u32, u32), draw: impl FnOnce(&Sheet<'_>) -> Result<()>) -> Result<Vec<u8>> {
    register_fonts();
    let large = (size.0 * OVERSAMPLING, size.1 * OVERSAMPLING);
    let mut pixels = vec![255; large.0 as usize * large.1 as usize * 3];
    {
        let area = BitMapBackend::with_buffer(&mut pixels, large).into_drawing_area();
        let sheet = Sheet { area };
        draw(&sheet)?;
        sheet.area.present().map_err(failed)?;
    }
    encode(size, &averaged(size, &pixels))
}

fn failed<E: std::error::Error + Send + Sync>(error: DrawingAreaErrorKind<E>) -> anyhow::Error {
    anyhow!("picture: {error}")
}

/// Returns the picture in final size: the mean of the enlarged pixels of each pixel, three bytes each.
fn averaged(size: (u32, u32), pixels: &[u8]) -> Vec<u8> {
    let n = OVERSAMPLING as usize;
    let row = size.0 as usize * n * 3;
    let mut small = Vec::with_capacity(pixels.len() / (n * n));
    for rows in pixels.chunks_exact(row * n) {
        for x in 0..size.0 as usize {
            for channel in 0..3 {
                let mut sum = 0;
                for (dy, dx) in (0..n).flat_map(|dy| (0..n).map(move |dx| (dy, dx))) {
                    sum += usize::from(rows[dy * row + (x * n + dx) * 3 + channel]);
                }
                small.push(((sum + n * n / 2) / (n * n)) as u8);
            }
        }
    }
    small
}

fn encode(size: (u32, u32), pixels: &[u8]) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size.0, size.1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(bytes)
}

impl Sheet<'_> {
    /// Writes `text` with the middle of its capitals at the height of `at`.
    pub fn text(&self, text: &str, at: Spot, face: Face) -> Result<()> {
        // `plotters` centres the text's box, whose middle lies below that of the capitals by this
        // part of the size.
        const HANG: f64 = 0.165;
        let shift = HANG * face.size;
        let at = if face.upright {
            (at.0 + shift, at.1)
        } else {
            (at.0, at.1 + shift)
        };
        let style = face
            .font()
            .into_text_style(&self.area)
            .color(&face.ink)
            .pos(Pos::new(face.anchor, VPos::Center));
        self.area
            .draw_text(text, &style, enlarged(at))
            .map_err(failed)
    }

    /// Writes `text` with a white rim around its letters, so that it is legible on any ground and
    /// hides nothing beside them.
    pub fn note(&self, text: &str, at: Spot, face: Face) -> Result<()> {
        const RIM: f64 = 1.7;
        for turn in 0..8 {
            let (dy, dx) = (f64::from(turn) * std::f64::consts::FRAC_PI_4).sin_cos();
            self.text(text, (at.0 + RIM * dx, at.1 + RIM * dy), face.ink(WHITE))?;
        }
        self.text(text, at, face)
    }

    /// Fills the box between two corners with a colour of opacity `alpha`.
    pub fn fill_box(&self, a: Spot, b: Spot, ink: RGBColor, alpha: f64) -> Result<()> {
        let style = ink.mix(alpha).filled();
        let corners = [enlarged(a), enlarged(b)];
        self.area
            .draw(&Rectangle::new(corners, style))
            .map_err(failed)
    }

    /// Fills a polygon.
    pub fn fill(&self, corners: &[Spot], ink: RGBColor, alpha: f64) -> Result<()> {
        let corners: Vec<_> = corners.iter().map(|&c| enlarged(c)).collect();
        self.area
            .draw(&Polygon::new(corners, ink.mix(alpha)))
            .map_err(failed)
    }

    /// Draws a line through `spots`.
    pub fn line(&self, spots: &[Spot], stroke: Stroke) -> Result<()> {
        match stroke.dash {
            None => self.solid(spots, stroke),
            Some((dash, gap)) => dashes(spots, dash, gap)
                .iter()
                .try_for_each(|dash| self.solid(dash, stroke)),
        }
    }

    fn solid(&self, spots: &[Spot], stroke: Stroke) -> Result<()> {
        if spots.len() < 2 {
            return Ok(());
        }
        let width = (stroke.width * SCALE).round().max(1.0) as u32;
        let style = stroke.ink.mix(stroke.alpha).stroke_width(width);
        let spots: Vec<_> = spots.iter().map(|&s| enlarged(s)).collect();
        self.area
            .draw(&PathElement::new(spots, style))
            .map_err(failed)
    }

    /// Fills a circle.
    pub fn disc(&self, at: Spot, radius: f64, ink: RGBColor) -> Result<()> {
        let radius = (radius * SCALE).round().max(1.0) as i32;
        self.area
            .draw(&Circle::new(enlarged(at), radius, ink.filled()))
            .map_err(failed)
    }

    /// Copies a picture of `size` enlarged pixels (three bytes each) to the sheet, its top left corner at `at`.
    pub fn lay(&self, at: Spot, size: (u32, u32), pixels: Vec<u8>) -> Result<()> {
        let image = BitMapElement::with_owned_buffer(enlarged(at), size, pixels)
            .ok_or_else(|| anyhow!("picture: {} by {} pixels expected", size.0, size.1))?;
        self.area.draw(&image).map_err(failed)
    }
}

/// Returns the dashes of a line through `spots`, each as a line of its own; lengths in pixels.
fn dashes(spots: &[Spot], dash: f64, gap: f64) -> Vec<Vec<Spot>> {
    let mut cut: Vec<Vec<Spot>> = Vec::new();
    let mut open = spots.first().map(|&s| vec![s]);
    let mut left = dash;
    for pair in spots.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        let mut done = 0.0;
        while length - done >= left {
            done += left;
            let t = done / length;
            let at = (from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1));
            match open.take() {
                Some(mut line) => {
                    line.push(at);
                    cut.push(line);
                    left = gap;
                }
                None => {
                    open = Some(vec![at]);
                    left = dash;
                }
            }
        }
        left -= length - done;
        if let Some(line) = &mut open {
            line.push(to);
        }
    }
    cut.extend(open);
    cut
}

#[cfg(test)]
mod tests {
    use super::super::shape::Shape;
    use super::*;

    #[test]
    fn a_picture_is_a_png_of_its_size() {
        let picture = draw((61, 40), |sheet| {
            sheet.text("Höhe ρ σ −1°", (30.0, 20.0), Face::plain(12.0))
        });
        let picture = picture.unwrap();
        let decoder = png::Decoder::new(std::io::Cursor::new(&picture));
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (61, 40));
        assert_eq!(pixels.len(), 61 * 40 * 3);
        // Letters are present, and only near their place.
        assert!(pixels.iter().any(|&p| p < 120));
        assert!(pixels[..61 * 3 * 5].iter().all(|&p| p == 255));
    }

    /// The areas between the letters of a label and beside it remain visible.
    #[test]
    fn a_label_hides_no_more_than_its_letters() {
        let (width, height) = (80, 40);
        let picture = draw((width, height), |sheet| {
            sheet.fill_box((0.0, 0.0), (80.0, 40.0), INK, 1.0)?;
            sheet.note("l   l", (40.0, 20.0), Face::plain(20.0).ink(FAINT))
        });
        let picture = picture.unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&picture))
            .read_info()
            .unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        let row = &pixels[20 * 80 * 3..21 * 80 * 3];
        let (letters, gap) = (row.iter().copied().max(), row[40 * 3]);
        assert!(letters > Some(200), "a white rim");
        assert_eq!(gap, INK.0, "between the two letters");
    }

    #[test]
    fn what_lies_far_outside_does_no_harm() {
        let far = [(-1e12, 5.0), (1e12, 7.0)];
        let picture = draw((20, 20), |sheet| {
            sheet.line(&far[..1], Stroke::solid(INK, 1.0))?;
            sheet.marker(Shape::Dot, (-1e5, 1e5), 3.0, INK, WHITE)?;
            sheet.fill_box((-50.0, -50.0), (500.0, 500.0), INK, 1.0)
        });
        assert!(!picture.unwrap().is_empty());
    }

    #[test]
    fn dashes_have_their_lengths() {
        let cut = dashes(&[(0.0, 0.0), (10.0, 0.0), (10.0, 7.0)], 4.0, 2.0);
        let expected: [&[Spot]; 3] = [
            &[(0.0, 0.0), (4.0, 0.0)],
            &[(6.0, 0.0), (10.0, 0.0)],
            &[(10.0, 2.0), (10.0, 6.0)],
        ];
        assert_eq!(cut, expected);
    }
}
