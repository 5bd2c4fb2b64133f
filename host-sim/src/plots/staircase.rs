//! The reconstructed staircase over the true one, among its likeliest rivals: figs. 13 and 14.

use anyhow::Result;
use plotters::style::WHITE;
use stairscan::answer::Direction;

use super::colour::{CONCLUDED, Palette, TRUE};
use super::page::{Frame, Swatch, number};
use super::plane::{Ground, SagittalPlane, Words};
use super::posterior;
use super::shape::Shape;
use super::sheet::{FAINT, Face, INK, Sheet, Stroke};
use super::surface::{surface, surface_up_to};
use crate::answer::{Answer, metres};
use crate::recording::Truth;
use crate::views::{Point, PosteriorView, true_edges};

/// One reported step.
#[derive(Clone, Copy, Debug)]
pub struct StepView {
    /// Horizontal distance of its foremost edge, metres.
    pub distance_m: f64,
    /// Height of its tread, metres.
    pub height_m: f64,
    /// Two standard deviations of both, metres.
    pub two_sigma_m: Point,
}

/// The steps of an answer.
pub fn steps(answer: &Answer) -> Vec<StepView> {
    let step = |s: &stairscan::report::StepLine| StepView {
        distance_m: metres(s.distance),
        height_m: metres(s.height),
        two_sigma_m: (2.0 * metres(s.distance_sigma), 2.0 * metres(s.height_sigma)),
    };
    answer.steps.iter().map(step).collect()
}

/// The reported staircase over the truth, as far as that is known, and what else may stand there.
pub fn draw(
    plane: &SagittalPlane<'_>,
    words: &Words,
    (answer, posterior): (&Answer, &PosteriorView),
    truth: Option<&Truth>,
) -> Result<Vec<u8>> {
    let reported = steps(answer);
    let edges: Vec<Point> = (reported.iter())
        .map(|s| (s.distance_m, s.height_m))
        .collect();
    let rivals = posterior::rivals(posterior, &edges);
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
        let label = "beyond its horizon: no promise".to_owned();
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
    words.legend.extend(posterior::legend(&rivals, answer));
    plane.draw(&words, Ground::Cfar, Palette::Ground, |sheet, frame| {
        if let Some(truth) = truth {
            draw_truth(sheet, frame, truth)?;
        }
        posterior::draw_rivals(sheet, frame, &rivals)?;
        posterior::draw_drop(sheet, frame, answer)?;
        posterior::draw_maybes(sheet, frame, answer)?;
        posterior::draw_counts(sheet, frame, posterior)?;
        if edges.is_empty() {
            return say_none(sheet, frame, answer);
        }
        let [promised, beyond] = surface_up_to(frame, &edges, horizon);
        sheet.line(&beyond, no_promise)?;
        sheet.line(&promised, found)?;
        for (k, step) in reported.iter().enumerate() {
            draw_step(sheet, frame, k, step, truth)?;
        }
        Ok(())
    })
}

/// The true surface, solid below.
pub fn draw_truth(sheet: &Sheet<'_>, frame: &Frame, truth: &Truth) -> Result<()> {
    let edge = Stroke::solid(TRUE, 2.2);
    let line = surface(frame.x.0 - 1.0, frame.x.1 + 1.0, &true_edges(truth));
    let mut solid: Vec<_> = line.iter().map(|p| frame.spot(p.0, p.1)).collect();
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

/// Room that a step's words take, pixels, and the height of a line of them.
const WORDS: f64 = 230.0;
const LINE: f64 = 24.0;

/// Edge, uncertainty, and how far it is from the truth.
fn draw_step(
    sheet: &Sheet<'_>,
    frame: &Frame,
    k: usize,
    step: &StepView,
    truth: Option<&Truth>,
) -> Result<()> {
    let (x, y) = (step.distance_m, step.height_m);
    let (sx, sy) = step.two_sigma_m;
    let (a, b) = (frame.spot(x - sx, y + sy), frame.spot(x + sx, y - sy));
    sheet.fill_box(a, b, CONCLUDED, 0.18)?;
    let corners = [a, (b.0, a.1), b, (a.0, b.1), a];
    sheet.line(&corners, Stroke::solid(CONCLUDED, 1.4))?;
    let at = frame.spot(x, y);
    sheet.marker(Shape::Dot, at, 6.0, CONCLUDED, WHITE)?;
    let cm = |v: f64| number(100.0 * v, 1);
    // Words stand in the air: before a riser, above the tread after a drop; where the plane ends there, on
    // the other side.
    let face = Face::plain(20.0);
    let (left, right) = (frame.at.0, frame.at.0 + frame.size.0);
    let before = if y < 0.0 {
        at.0 + WORDS > right
    } else {
        at.0 - WORDS > left
    };
    let (aside, face) = if before {
        (-18.0, face.right())
    } else {
        (18.0, face.left())
    };
    let up = match (y < 0.0, before) {
        (true, true) => -22.0,
        (true, false) => 68.0,
        (false, _) => 60.0,
    };
    // All three lines within the plane.
    let (highest, lowest) = (frame.at.1 + 16.0, frame.at.1 + frame.size.1 - 64.0);
    let place = (
        at.0 + aside,
        (at.1 - up).clamp(highest, lowest.max(highest)),
    );
    let text = format!("{}: distance {} cm", k + 1, cm(x));
    sheet.note(&text, place, face.bold())?;
    let text = format!("height {} cm", cm(y));
    sheet.note(&text, (place.0, place.1 + LINE), face.bold())?;
    let nearest = truth.and_then(|t| {
        let off = |s: &&crate::recording::TrueStep| (s.distance_m - x).abs();
        t.steps.iter().min_by(|a, b| off(a).total_cmp(&off(b)))
    });
    let Some(real) = nearest.filter(|s| (s.distance_m - x).abs() <= crate::score::MATCH_M) else {
        return Ok(());
    };
    let signed = |v: f64| {
        let text = cm(v);
        if v > 0.0 && text != "0.0" {
            format!("+{text}")
        } else {
            text
        }
    };
    let text = format!(
        "off by {} and {} cm",
        signed(x - real.distance_m),
        signed(y - real.height_m)
    );
    sheet.note(&text, (place.0, place.1 + 2.0 * LINE), face.ink(FAINT))
}

/// Says in words that there are no steps, and why.
fn say_none(sheet: &Sheet<'_>, frame: &Frame, answer: &Answer) -> Result<()> {
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
