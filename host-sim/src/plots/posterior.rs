//! What else may stand there: rivals of the answer with their probability, the numbers of steps with
//! theirs, and the answer's `MAYBE`s.

use anyhow::Result;
use plotters::style::RGBColor;

use super::colour::HUES;
use super::page::{Frame, Swatch, number};
use super::particles::Point;
use super::sheet::{FAINT, Face, INK, Sheet, Stroke};
use super::staircase::surface_to_draw;
use crate::answer::{Answer, metres};
use crate::score::MATCH_M;

/// One hypothesis of the posterior.
#[derive(Clone, Debug)]
pub struct HypothesisView {
    /// What it says.
    pub name: String,
    /// How likely it is, 0…1.
    pub probability: f64,
    /// Distance and height of each of its edges that can be seen.
    pub edges: Vec<Point>,
}

/// What the posterior says; empty where there is none.
#[derive(Clone, Debug, Default)]
pub struct PosteriorView {
    /// Probability of each number of steps, from none.
    pub counts: Vec<f64>,
    /// The hypotheses, the likeliest first.
    pub hypotheses: Vec<HypothesisView>,
}

/// Rivals that are drawn.
const RIVALS: usize = 3;
/// What is less likely is not drawn: it is told as 0 %.
const LEAST: f64 = 0.005;
/// The rivals' colours.
const INKS: [RGBColor; RIVALS] = [HUES[5], HUES[7], HUES[6]];
/// The colour of `MAYBE`s.
const MAYBE: RGBColor = HUES[3];

/// `97 %` of a probability.
fn percent(probability: f64) -> String {
    format!("{} %", number(100.0 * probability, 0))
}

/// The likeliest hypotheses that say something else than the edges of an answer, and how they are drawn.
pub fn rivals<'a>(
    posterior: &'a PosteriorView,
    told: &[Point],
) -> Vec<(Stroke, &'a HypothesisView)> {
    let same = |h: &HypothesisView| {
        let pairs = h.edges.iter().zip(told);
        h.edges.len() == told.len() && pairs.into_iter().all(|(a, b)| near(a, b))
    };
    let likely = posterior
        .hypotheses
        .iter()
        .filter(|h| h.probability >= LEAST);
    let rivals = likely.filter(|h| !same(h));
    let faint = |ink| Stroke::solid(ink, 2.2).dashed(9.0, 6.0).alpha(0.6);
    INKS.into_iter().map(faint).zip(rivals).collect()
}

fn near(a: &Point, b: &Point) -> bool {
    (a.0 - b.0).abs() <= MATCH_M
}

/// The rivals and `MAYBE`s for the legend.
pub fn legend(rivals: &[(Stroke, &HypothesisView)], answer: &Answer) -> Vec<(Swatch, String)> {
    let rival = |(stroke, h): &(Stroke, &HypothesisView)| {
        let label = format!("rival, {}: {}", percent(h.probability), h.name);
        (Swatch::Line(*stroke), label)
    };
    let mut legend: Vec<(Swatch, String)> = rivals.iter().map(rival).collect();
    if !answer.maybes.is_empty() {
        let label = "MAYBE and its probability".to_owned();
        legend.push((Swatch::Line(maybe_stroke()), label));
    }
    legend
}

/// Draws the rivals' staircases, each with its probability where it first departs from the answer.
pub fn draw_rivals(
    sheet: &Sheet<'_>,
    frame: &Frame,
    rivals: &[(Stroke, &HypothesisView)],
    told: &[Point],
) -> Result<()> {
    // The likeliest last, on top; none on another's words.
    for (k, (stroke, rival)) in rivals.iter().enumerate().rev() {
        let line = surface_to_draw(frame, &rival.edges);
        sheet.line(&line, *stroke)?;
        let other = |e: &&Point| !told.iter().any(|t| near(t, e));
        let departs = rival.edges.iter().find(other).or(rival.edges.last());
        let at = departs.map_or((frame.x.1, 0.0), |&e| e);
        let at = frame.spot(at.0.min(frame.x.1), at.1.clamp(frame.y.0, frame.y.1));
        let at = (at.0 - 8.0, at.1 + 20.0 + 24.0 * k as f64);
        let face = Face::plain(20.0).right().ink(stroke.ink);
        sheet.note(&percent(rival.probability), at, face)?;
    }
    Ok(())
}

fn maybe_stroke() -> Stroke {
    Stroke::solid(MAYBE, 2.4).dashed(5.0, 4.0)
}

/// Draws what the answer says may stand there: a dashed diamond on a dashed stalk.
pub fn draw_maybes(sheet: &Sheet<'_>, frame: &Frame, answer: &Answer) -> Result<()> {
    const RADIUS: f64 = 11.0;
    for maybe in &answer.maybes {
        let (x, y) = (metres(maybe.distance), metres(maybe.height));
        if !frame.holds(x, y) {
            continue;
        }
        let (at, foot) = (frame.spot(x, y), frame.spot(x, 0.0));
        // Up from the ground, or down from it.
        let way = if y < 0.0 { -1.0 } else { 1.0 };
        let end = (at.0, at.1 + way * RADIUS);
        if (foot.1 - at.1) * way > RADIUS {
            sheet.line(&[foot, end], maybe_stroke().alpha(0.6))?;
        }
        let corners = [
            (0.0, -1.0),
            (1.0, 0.0),
            (0.0, 1.0),
            (-1.0, 0.0),
            (0.0, -1.0),
        ];
        let corner = |(dx, dy): (f64, f64)| (at.0 + RADIUS * dx, at.1 + RADIUS * dy);
        sheet.line(&corners.map(corner), maybe_stroke())?;
        let probability = f64::from(maybe.probability) / 1000.0;
        let face = Face::plain(20.0).left().ink(MAYBE);
        sheet.note(&percent(probability), (at.0 + 18.0, at.1), face)?;
    }
    Ok(())
}

/// Writes the probability of each number of steps into the upper right corner.
pub fn draw_counts(sheet: &Sheet<'_>, frame: &Frame, posterior: &PosteriorView) -> Result<()> {
    const LINE: f64 = 27.0;
    let mut at = (frame.at.0 + frame.size.0 - 14.0, frame.at.1 + 22.0);
    let likely = posterior.counts.iter().enumerate();
    let likely: Vec<(usize, &f64)> = likely.filter(|(_, p)| **p >= LEAST).collect();
    if !likely.is_empty() {
        let face = Face::plain(20.0).right().ink(FAINT);
        sheet.note("posterior", at, face)?;
    }
    for (count, probability) in likely {
        at.1 += LINE;
        let steps = match count {
            0 => "no steps".to_owned(),
            1 => "1 step".to_owned(),
            n => format!("{n} steps"),
        };
        let text = format!("{steps}: {}", percent(*probability));
        sheet.note(&text, at, Face::plain(20.0).right().ink(INK))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_answer_says_is_no_rival_of_it() {
        let hypothesis = |probability, edges: &[Point]| HypothesisView {
            name: String::new(),
            probability,
            edges: edges.to_vec(),
        };
        let posterior = PosteriorView {
            counts: Vec::new(),
            hypotheses: vec![
                hypothesis(0.6, &[(0.62, 0.16), (0.9, 0.3)]),
                hypothesis(0.2, &[(0.6, 0.15)]),
                hypothesis(0.1, &[]),
                hypothesis(0.096, &[(0.6, 0.15), (1.1, 0.3)]),
                hypothesis(0.004, &[(0.3, 0.1)]),
            ],
        };
        let rivals = |told: &[Point]| -> Vec<f64> {
            let rivals = rivals(&posterior, told).into_iter();
            rivals.map(|r| r.1.probability).collect()
        };
        assert_eq!(rivals(&[(0.6, 0.15), (0.91, 0.31)]), [0.2, 0.1, 0.096]);
        assert_eq!(rivals(&[]), [0.6, 0.2, 0.096]);
    }
}
