//! Plot of the reported staircase over the true one, with the most probable other hypotheses: figs.
//! 13 and 14.

use anyhow::Result;
use plotters::style::WHITE;
use stairscan::answer::Direction;

use super::colour::{CONCLUDED, Palette, TRUE};
use super::page::{Frame, Swatch, number};
use super::plane::{Background, PlotTexts, SagittalPlane};
use super::posterior;
use super::room::LabelPlacer;
use super::shape::Shape;
use super::sheet::{FAINT, Face, INK, Sheet, Spot, Stroke};
use super::surface::{surface, surface_up_to};
use crate::answer::{Answer, metres};
use crate::recording::{TrueStep, Truth};
use crate::score::MATCH_M;
use crate::views::{Point, PosteriorView, true_edges};

/// One reported step.
#[derive(Clone, Copy, Debug)]
pub struct StepView {
    /// Horizontal distance of the step's foremost edge from the mirror, metres.
    pub distance_m: f64,
    /// Height of the step's tread above the ground, metres.
    pub height_m: f64,
    /// Two standard deviations of the edge's distance, and of the tread's height, metres.
    pub two_sigma_m: Point,
}

/// Returns the steps of an answer.
pub fn steps(answer: &Answer) -> Vec<StepView> {
    let step = |s: &stairscan::report::StepLine| StepView {
        distance_m: metres(s.distance),
        height_m: metres(s.height),
        two_sigma_m: (2.0 * metres(s.distance_sigma), 2.0 * metres(s.height_sigma)),
    };
    answer.steps.iter().map(step).collect()
}

/// Draws the reported staircase over the truth, if known, and the probable other hypotheses.
pub fn draw(
    plane: &SagittalPlane<'_>,
    words: &PlotTexts,
    (answer, posterior): (&Answer, &PosteriorView),
    truth: Option<&Truth>,
) -> Result<Vec<u8>> {
    let reported = steps(answer);
    let edges: Vec<Point> = (reported.iter())
        .map(|s| (s.distance_m, s.height_m))
        .collect();
    let runners_up = posterior::runners_up(posterior, &edges);
    let found = Stroke::solid(CONCLUDED, 3.2);
    let no_promise = found.dashed(5.0, 5.0);
    let horizon = answer.horizon_m.unwrap_or(f64::INFINITY);
    let real = Stroke::solid(TRUE, 2.0);
    let mut words = words.clone();
    if !reported.is_empty() {
        let label = format!("the answer{}", posterior::share(posterior, &edges));
        words.legend.push((Swatch::Line(found), label));
        let mark = Swatch::Mark(Shape::Dot, 7.0, CONCLUDED);
        words
            .legend
            .push((mark, "edge of a step, box of ±2σ".into()));
    }
    if reported.iter().any(|step| step.distance_m > horizon) {
        let label = "beyond its horizon: not valid".to_owned();
        words.legend.push((Swatch::Line(no_promise), label));
    }
    if truth.is_some() {
        words
            .legend
            .push((Swatch::Area(TRUE, 0.3, real), "truth".into()));
    }
    if truth.is_some_and(|t| !t.uncounted.is_empty()) {
        let stroke = real.dashed(6.0, 4.0);
        words
            .legend
            .push((Swatch::Line(stroke), "out of sight".into()));
    }
    words.legend.extend(posterior::legend(&runners_up, answer));
    plane.draw(&words, Background::Cfar, Palette::Ground, |sheet, frame| {
        if let Some(truth) = truth {
            draw_truth(sheet, frame, truth)?;
        }
        posterior::draw_runners_up(sheet, frame, &runners_up)?;
        posterior::draw_drop(sheet, frame, answer)?;
        posterior::draw_maybes(sheet, frame, answer)?;
        posterior::draw_counts(sheet, frame, posterior)?;
        if edges.is_empty() {
            return draw_no_steps(sheet, frame, answer);
        }
        let [promised, beyond] = surface_up_to(frame, &edges, horizon);
        sheet.line(&beyond, no_promise)?;
        sheet.line(&promised, found)?;
        let mut room = plane.room(frame);
        room.cover_line(&beyond);
        room.cover_line(&promised);
        if let Some(truth) = truth {
            room.cover_line(&true_line(frame, truth));
        }
        posterior::cover(&mut room, frame, answer, (posterior, &runners_up));
        for step in &reported {
            draw_step(sheet, frame, &mut room, step)?;
        }
        for (k, step) in reported.iter().enumerate() {
            write_step(sheet, frame, &mut room, (k, step), truth)?;
        }
        Ok(())
    })
}

/// Draws the true surface, filled below.
pub fn draw_truth(sheet: &Sheet<'_>, frame: &Frame, truth: &Truth) -> Result<()> {
    let edge = Stroke::solid(TRUE, 2.2);
    let mut solid = true_line(frame, truth);
    let hidden = truth.uncounted.iter().map(|s| (s.distance_m, s.height_m));
    sheet.line(&solid, edge)?;
    let below = frame.y.0 - 1.0;
    solid.push(frame.spot(frame.x.1 + 1.0, below));
    solid.push(frame.spot(frame.x.0 - 1.0, below));
    sheet.fill(&solid, TRUE, 0.22)?;
    for (x, y) in hidden.filter(|p| frame.holds(p.0, p.1)) {
        const HALF_WIDTH: f64 = 60.0;
        let at = frame.spot(x, y);
        let (left, right) = (
            frame.at.0 + HALF_WIDTH,
            frame.at.0 + frame.size.0 - HALF_WIDTH,
        );
        let middle = at.0.clamp(left, right.max(left));
        let place = (middle, (at.1 - 18.0).max(frame.at.1 + 14.0));
        sheet.note("out of sight", place, Face::plain(18.0).ink(FAINT))?;
    }
    Ok(())
}

/// Returns the line of the true surface, pixels, from edge to edge of the frame.
fn true_line(frame: &Frame, truth: &Truth) -> Vec<Spot> {
    let line = surface(frame.x.0 - 1.0, frame.x.1 + 1.0, &true_edges(truth));
    line.iter().map(|p| frame.spot(p.0, p.1)).collect()
}

/// Draws a step's edge, and its uncertainty as a box of ±2σ.
fn draw_step(
    sheet: &Sheet<'_>,
    frame: &Frame,
    room: &mut LabelPlacer,
    step: &StepView,
) -> Result<()> {
    const RADIUS: f64 = 6.0;
    let (x, y) = (step.distance_m, step.height_m);
    let (sx, sy) = step.two_sigma_m;
    let (a, b) = (frame.spot(x - sx, y + sy), frame.spot(x + sx, y - sy));
    sheet.fill_box(a, b, CONCLUDED, 0.18)?;
    let corners = [a, (b.0, a.1), b, (a.0, b.1), a];
    sheet.line(&corners, Stroke::solid(CONCLUDED, 1.4))?;
    let at = frame.spot(x, y);
    room.cover(a, b);
    room.cover_mark(at, RADIUS + 2.0);
    sheet.marker(Shape::Dot, at, RADIUS, CONCLUDED, WHITE)
}

/// Writes number, distance and height of a step beside it, and the deviation from the true step, if one is near, cm.
fn write_step(
    sheet: &Sheet<'_>,
    frame: &Frame,
    room: &mut LabelPlacer,
    (k, step): (usize, &StepView),
    truth: Option<&Truth>,
) -> Result<()> {
    let (x, y) = (step.distance_m, step.height_m);
    let cm = |v: f64| number(100.0 * v, 1);
    let near = |s: &&TrueStep| (s.distance_m - x).abs() <= MATCH_M;
    let steps = truth.map_or(&[][..], |t| &t.steps);
    let off = |s: &TrueStep| (s.distance_m - x).abs();
    let real = steps.iter().filter(near);
    let real = real.min_by(|a, b| off(a).total_cmp(&off(b)));
    let signed = |v: f64| {
        let text = cm(v);
        match v > 0.0 && text != "0.0" {
            true => format!("+{text}"),
            false => text,
        }
    };
    let face = Face::plain(20.0);
    let values = [
        format!("{}: distance {} cm", k + 1, cm(x)),
        format!("height {} cm", cm(y)),
    ];
    let off = real.map(|real| {
        let off = [x - real.distance_m, y - real.height_m].map(signed);
        format!("off by {} and {} cm", off[0], off[1])
    });
    let values = values.iter().map(|line| (line.as_str(), face.bold()));
    let off = off.iter().map(|line| (line.as_str(), face.ink(FAINT)));
    let lines: Vec<(&str, Face)> = values.chain(off).collect();
    room.write(sheet, frame.spot(x, y), &lines)
}

/// Writes into the plot that there are no steps; for a fault, that there is no answer, with the reasons.
fn draw_no_steps(sheet: &Sheet<'_>, frame: &Frame, answer: &Answer) -> Result<()> {
    let what = if answer.is_fault() {
        format!("no answer: {}", answer.scan.reasons)
    } else if answer.scan.direction == Direction::None {
        "no stairs".to_owned()
    } else {
        "no steps".to_owned()
    };
    let middle = (
        frame.at.0 + frame.size.0 / 2.0,
        frame.at.1 + 0.25 * frame.size.1,
    );
    sheet.note(&what, middle, Face::plain(40.0).bold().ink(INK))
}
