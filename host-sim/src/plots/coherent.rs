//! Plot of the coherent image with the echoes that CLEAN finds in it.

use anyhow::Result;
use plotters::style::WHITE;
use stairscan::signal::echoes::Echo;

use super::colour::{Palette, TRUE};
use super::inspect::radius;
use super::plane::{Background, PlotTexts, SagittalPlane};
use super::shape::Shape;

/// Draws the image with a ring around each echo, the larger the stronger.
pub fn draw(plane: &SagittalPlane<'_>, words: &PlotTexts, echoes: &[Echo]) -> Result<Vec<u8>> {
    plane.draw(words, Background::Raw, Palette::Viridis, |sheet, frame| {
        for echo in echoes.iter().rev() {
            let (x, y) = (f64::from(echo.x_m), f64::from(echo.y_m));
            if frame.holds(x, y) {
                let radius = radius(echo.snr_db.into());
                sheet.marker(Shape::Ring, frame.spot(x, y), radius, TRUE, WHITE)?;
            }
        }
        Ok(())
    })
}
