//! Colours of powers in decibels, and of objects that must be distinguishable in print and with colour blindness.

use plotters::prelude::*;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use stairscan::verdict::Status;

/// Blue, vermilion, green, purple, orange, sky, brown, indigo: the hues of Okabe and Ito, darkened
/// for a white ground. Their brightness is spread until every two can be distinguished with
/// deuteranopia, and each from [`TRUE`] and the ink (measured by plots/deuteranopia.rs).
pub const HUES: [RGBColor; 8] = [
    RGBColor(13, 110, 195),
    RGBColor(205, 72, 0),
    RGBColor(4, 132, 95),
    RGBColor(149, 78, 142),
    RGBColor(214, 140, 0),
    RGBColor(64, 156, 210),
    RGBColor(121, 81, 46),
    RGBColor(75, 54, 148),
];

/// Colour of measured data, such as power and particles.
pub const MEASURED: RGBColor = HUES[0];
/// Colour of the scanner's answer.
pub const CONCLUDED: RGBColor = HUES[1];
/// Colour of the ground truth.
pub const TRUE: RGBColor = RGBColor(120, 124, 130);

/// Returns the colour of a status, as in `html/page.css`.
pub const fn status(status: Status) -> RGBColor {
    match status {
        Status::Ok => RGBColor(0, 106, 122),
        Status::Degraded => RGBColor(148, 98, 0),
        Status::Fault => RGBColor(122, 20, 0),
    }
}

/// Mapping of decibels to colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Palette {
    /// Viridis: perceptually uniform, dark blue to yellow.
    Viridis,
    /// White to mid grey, as a background for coloured marks.
    Ground,
}

/// A range of powers in dB that is mapped to colours.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// Power of the lowest colour, dB relative to full scale; lower powers have the same colour.
    pub low: f64,
    /// Power of the highest colour, dB relative to full scale; higher powers have the same colour.
    pub high: f64,
    /// Mapping to colours.
    pub palette: Palette,
}

impl Scale {
    /// Returns the colour of the power `db`, dB relative to full scale. Values beyond the ends have the ends' colours.
    pub fn colour(&self, db: f64) -> RGBColor {
        let t = ((db - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        let t = if t.is_nan() { 0.0 } else { t };
        match self.palette {
            Palette::Viridis => ViridisRGB.get_color(t),
            Palette::Ground => {
                let fade = |from: f64, to: f64| (from + t * (to - from)).round() as u8;
                RGBColor(fade(250.0, 92.0), fade(251.0, 98.0), fade(252.0, 108.0))
            }
        }
    }

    /// Returns the same range with another mapping to colours.
    pub fn with(self, palette: Palette) -> Self {
        Self { palette, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Brightness of a colour from 0 (black) to 255 (white): its luma with the weights of Rec. 709, without gamma
    /// correction.
    fn luminance(c: RGBColor) -> f64 {
        0.2126 * f64::from(c.0) + 0.7152 * f64::from(c.1) + 0.0722 * f64::from(c.2)
    }

    #[test]
    fn brightness_follows_the_decibels() {
        for (palette, sign) in [(Palette::Viridis, 1.0), (Palette::Ground, -1.0)] {
            let scale = Scale {
                low: -80.0,
                high: -20.0,
                palette,
            };
            let steps: Vec<f64> = (0..=60)
                .map(|k| luminance(scale.colour(f64::from(k) - 80.0)))
                .collect();
            assert!(
                steps.windows(2).all(|w| sign * (w[1] - w[0]) > 0.0),
                "{palette:?}"
            );
            assert_eq!(scale.colour(-200.0), scale.colour(-80.0));
            assert_eq!(scale.colour(200.0), scale.colour(-20.0));
            assert_eq!(scale.colour(f64::NAN), scale.colour(-80.0));
        }
    }
}
