//! Colours: of decibels, and of things that must be told apart in print and by everybody.

use plotters::prelude::*;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use stairscan::verdict::Status;

/// Blue, vermilion, green, purple, orange, sky, brown, indigo: the hues of Okabe and Ito, deepened to stand
/// on white, and moved apart in brightness until people without the green cones tell every two apart, and from
/// [`TRUE`] and the ink (plots/deuteranopia.rs measures that).
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

/// Colour of what was measured.
pub const MEASURED: RGBColor = HUES[0];
/// Colour of what the scanner concludes.
pub const CONCLUDED: RGBColor = HUES[1];
/// Colour of what is really there.
pub const TRUE: RGBColor = RGBColor(120, 124, 130);

/// Colour of a status, as `html/page.css` has it.
pub const fn status(status: Status) -> RGBColor {
    match status {
        Status::Ok => RGBColor(0, 106, 122),
        Status::Degraded => RGBColor(148, 98, 0),
        Status::Fault => RGBColor(122, 20, 0),
    }
}

/// How decibels become colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Palette {
    /// Viridis: perceptually uniform, dark blue to yellow.
    Viridis,
    /// White to mid grey, as a ground for colourful things.
    Ground,
}

/// A span of decibels in colours.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// Decibels of the lowest colour.
    pub low: f64,
    /// Decibels of the highest colour.
    pub high: f64,
    /// Which colours.
    pub palette: Palette,
}

impl Scale {
    /// Colour of `db`; what lies beyond the ends has the ends' colour.
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

    /// The same span in other colours.
    pub fn with(self, palette: Palette) -> Self {
        Self { palette, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance.
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
