//! Plot of a scan's evaluation: scatterers with their roles, the best hypothesis and its
//! runners-up.

use anyhow::Result;
use plotters::style::{RGBColor, WHITE};

use super::colour::{CONCLUDED, HUES, Palette, TRUE};
use super::page::{Frame, Swatch, number};
use super::plane::{Background, PlotTexts, SagittalPlane};
use super::posterior;
use super::shape::Shape;
use super::sheet::{FAINT, Face, INK, Sheet, Stroke};
use super::staircase::draw_truth;
use crate::answer::Answer;
use crate::recording::Truth;
use crate::views::{ExplanationView, InspectView, ScattererView, meaning};

/// Marker that stands for one role of echoes (corner, nosing, flash, …) in the plot.
pub struct RoleMark {
    /// Name of the role.
    pub role: &'static str,
    /// Marker shape, different for each role; crossing lines for roles that contradict the best hypothesis.
    pub shape: Shape,
    /// Colour of the role's markers, the same in all plots.
    pub ink: RGBColor,
}

const fn role(role: &'static str, shape: Shape, ink: RGBColor) -> RoleMark {
    RoleMark { role, shape, ink }
}

/// Markers of all roles, in the order of the legend.
pub const MARKS: [RoleMark; 10] = [
    role("corner", Shape::Triangle, HUES[0]),
    role("nosing", Shape::Fall, HUES[3]),
    role("flash", Shape::Diamond, HUES[4]),
    role("face", Shape::Dot, HUES[2]),
    role("tread", Shape::Square, HUES[6]),
    role("edge", Shape::Wedge, HUES[7]),
    role("inside", Shape::Cross, INK),
    role("above", Shape::Plus, INK),
    role("clutter", Shape::Star, INK),
    role("unexplained", Shape::Ring, TRUE),
];

/// Returns shape and colour of a scatterer's marker; a grey ring if its role is not in [`MARKS`].
fn mark(scatterer: &ScattererView) -> (Shape, RGBColor) {
    let known = MARKS.iter().find(|mark| mark.role == scatterer.role);
    known.map_or((Shape::Ring, TRUE), |mark| (mark.shape, mark.ink))
}

/// Returns each role that occurs, the number of its scatterers, and its marker, in the order of [`MARKS`].
fn roles(view: &InspectView) -> Vec<(&'static str, usize, (Shape, RGBColor))> {
    let mut roles: Vec<(&'static str, usize, (Shape, RGBColor))> = Vec::new();
    for scatterer in &view.scatterers {
        match roles.iter_mut().find(|r| r.0 == scatterer.role) {
            Some(role) => role.1 += 1,
            None => roles.push((scatterer.role, 1, mark(scatterer))),
        }
    }
    let place = |role: &str| MARKS.iter().position(|m| m.role == role);
    roles.sort_by_key(|r| place(r.0).unwrap_or(MARKS.len()));
    roles
}

/// Returns the radius of a scatterer's marker, pixels: 4 at an SNR of 0 dB, 10 from 40 dB on.
pub fn radius(snr_db: f64) -> f64 {
    4.0 + 6.0 * (snr_db / 40.0).clamp(0.0, 1.0)
}

/// Draws the scatterers over the CFAR map, with the staircases of the best hypothesis and its
/// runners-up, the posterior of the number of steps, and the answer's `DROP` and `MAYBE`s.
pub fn draw(
    plane: &SagittalPlane<'_>,
    words: &PlotTexts,
    (view, answer): (&InspectView, &Answer),
    truth: Option<&Truth>,
) -> Result<Vec<u8>> {
    let mut words = words.clone();
    let lines = lines(view);
    for (stroke, explanation) in &lines {
        let score = number(explanation.score, 1);
        let which = if explanation.winner {
            "winner"
        } else {
            "rival"
        };
        let label = format!("{which}: {}, {score} nats", explanation.name);
        words.legend.push((Swatch::Line(*stroke), label));
    }
    for (name, count, (shape, ink)) in roles(view) {
        let swatch = Swatch::Mark(shape, 7.0, ink);
        let label = format!("{name} ({count}): {}", meaning(name));
        words.legend.push((swatch, label));
    }
    words.legend.extend(posterior::legend(&[], answer));
    if truth.is_some() {
        let edge = Stroke::solid(TRUE, 2.0);
        words
            .legend
            .push((Swatch::Area(TRUE, 0.3, edge), "truth".into()));
    }
    plane.draw(&words, Background::Cfar, Palette::Ground, |sheet, frame| {
        if let Some(truth) = truth {
            draw_truth(sheet, frame, truth)?;
        }
        // The best hypothesis is drawn last, over the broader lines of the others.
        for (stroke, explanation) in lines.iter().rev() {
            sheet.line(&posterior::outline(frame, &explanation.edges), *stroke)?;
        }
        draw_scatterers(sheet, frame, view)?;
        posterior::draw_drop(sheet, frame, answer)?;
        posterior::draw_maybes(sheet, frame, answer)?;
        posterior::draw_counts(sheet, frame, &view.posterior)
    })
}

/// Returns the hypotheses to draw with their strokes: the best first, then the runners-up by descending score.
fn lines(view: &InspectView) -> Vec<(Stroke, &ExplanationView)> {
    let winner = view.explanations.iter().filter(|e| e.winner);
    let mut runners_up: Vec<&ExplanationView> =
        view.explanations.iter().filter(|e| !e.winner).collect();
    runners_up.sort_by(|a, b| b.score.total_cmp(&a.score));
    let runners_up = runners_up.into_iter().zip(posterior::strokes());
    winner
        .map(|e| (Stroke::solid(CONCLUDED, 3.2), e))
        .chain(runners_up.map(|(e, stroke)| (stroke, e)))
        .collect()
}

fn draw_scatterers(sheet: &Sheet<'_>, frame: &Frame, view: &InspectView) -> Result<()> {
    // The strongest are drawn on top.
    let inside = |s: &&ScattererView| frame.holds(s.at.0, s.at.1);
    for scatterer in view.scatterers.iter().rev().filter(inside) {
        let at = frame.spot(scatterer.at.0, scatterer.at.1);
        let (shape, ink) = mark(scatterer);
        sheet.marker(shape, at, radius(scatterer.snr_db), ink, WHITE)?;
    }
    if view.scatterers.is_empty() {
        let middle = (
            frame.at.0 + frame.size.0 / 2.0,
            frame.at.1 + 0.25 * frame.size.1,
        );
        sheet.note("no scatterers", middle, Face::plain(34.0).bold().ink(FAINT))?;
    }
    Ok(())
}
