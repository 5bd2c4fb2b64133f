//! Markers: shapes that can be distinguished without colour.

use anyhow::Result;
use plotters::style::RGBColor;

use super::sheet::{Sheet, Spot, Stroke};

/// The shape of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// ●
    Dot,
    /// ○
    Ring,
    /// ■
    Square,
    /// ◆
    Diamond,
    /// ▲
    Triangle,
    /// ▼
    Fall,
    /// ▶
    Wedge,
    /// ✕
    Cross,
    /// +
    Plus,
    /// A cross and a plus.
    Star,
}

/// Filled shapes, which distinguish several objects of one kind, such as clusters.
pub const SOLID: [Shape; 6] = [
    Shape::Dot,
    Shape::Square,
    Shape::Triangle,
    Shape::Diamond,
    Shape::Fall,
    Shape::Wedge,
];

/// Corners of a shape relative to the marker's centre, in units of its radius.
type Corners = [Spot];
const SQUARE: &Corners = &[(-0.85, -0.85), (0.85, -0.85), (0.85, 0.85), (-0.85, 0.85)];
const DIAMOND: &Corners = &[(0.0, -1.15), (1.15, 0.0), (0.0, 1.15), (-1.15, 0.0)];
const TRIANGLE: &Corners = &[(0.0, -1.15), (1.05, 0.75), (-1.05, 0.75)];
const FALL: &Corners = &[(0.0, 1.15), (1.05, -0.75), (-1.05, -0.75)];
const WEDGE: &Corners = &[(1.15, 0.0), (-0.75, 1.05), (-0.75, -1.05)];
/// Ends of the lines through a marker's centre, relative to it, in units of its radius.
const CROSS: &[[Spot; 2]] = &[[(-0.8, -0.8), (0.8, 0.8)], [(-0.8, 0.8), (0.8, -0.8)]];
const PLUS: &[[Spot; 2]] = &[[(-1.05, 0.0), (1.05, 0.0)], [(0.0, -1.05), (0.0, 1.05)]];
const STAR: &[[Spot; 2]] = &[CROSS[0], CROSS[1], PLUS[0], PLUS[1]];

impl Sheet<'_> {
    /// Draws a marker of `radius` pixels in colour `ink`, with an outline in colour `edge`.
    pub fn marker(
        &self,
        shape: Shape,
        at: Spot,
        radius: f64,
        ink: RGBColor,
        edge: RGBColor,
    ) -> Result<()> {
        let around = |r: f64, corners: &Corners| -> Vec<Spot> {
            let corner = |&(x, y): &Spot| (at.0 + r * x, at.1 + r * y);
            corners.iter().map(corner).collect()
        };
        let rim = radius + 1.3;
        let polygon = |corners: &Corners| {
            self.fill(&around(rim, corners), edge, 1.0)?;
            self.fill(&around(radius, corners), ink, 1.0)
        };
        let arms = |arms: &[[Spot; 2]]| -> Result<()> {
            for (r, ink, width) in [(rim, edge, 4.6), (radius, ink, 2.2)] {
                for arm in arms {
                    self.line(&around(r, arm), Stroke::solid(ink, width))?;
                }
            }
            Ok(())
        };
        match shape {
            Shape::Dot => {
                self.disc(at, rim, edge)?;
                self.disc(at, radius, ink)
            }
            Shape::Ring => {
                self.disc(at, radius, ink)?;
                self.disc(at, 0.55 * radius, edge)
            }
            Shape::Square => polygon(SQUARE),
            Shape::Diamond => polygon(DIAMOND),
            Shape::Triangle => polygon(TRIANGLE),
            Shape::Fall => polygon(FALL),
            Shape::Wedge => polygon(WEDGE),
            Shape::Cross => arms(CROSS),
            Shape::Plus => arms(PLUS),
            Shape::Star => arms(STAR),
        }
    }
}
