//! Plots of the posterior: hypotheses other than the answer and numbers of steps, with their
//! probabilities, and the answer's `MAYBE`s and `DROP`.

use anyhow::Result;
use plotters::style::RGBColor;

use super::colour::{CONCLUDED, HUES};
use super::page::{Frame, Swatch, number};
use super::room::LabelPlacer;
use super::sheet::{FAINT, Face, INK, Sheet, Spot, Stroke};
use super::surface::surface_to_draw;
use crate::answer::{Answer, metres, nearest_m};
use crate::score::MATCH_M;
use crate::views::{HypothesisView, Point, PosteriorView};

/// Maximum number of drawn hypotheses other than the answer.
const RUNNERS_UP: usize = 3;
/// Minimum probability of a drawn hypothesis; less is displayed as 0 %.
const MIN_PROBABILITY: f64 = 0.005;
/// Minimum probability of a hypothesis whose edges must be in view: that of a reported `MAYBE`.
const MIN_PROBABILITY_IN_VIEW: f64 = 0.05;
/// Colour, and lengths of dash and gap in pixels, of the hypotheses other than the answer, the most probable first.
const LOOKS: [(RGBColor, f64, f64); RUNNERS_UP] = [
    (HUES[5], 22.0, 8.0),
    (HUES[7], 9.0, 7.0),
    (HUES[6], 3.0, 6.0),
];
/// Opacity, 0…1, of the lines of other hypotheses, which lie over the map.
pub const OPACITY: f64 = 0.7;
/// Colour of `MAYBE`s (possible steps), used by no scatterer and no staircase.
const MAYBE: RGBColor = INK;

/// Formats a probability as `97 %`.
fn percent(probability: f64) -> String {
    format!("{} %", number(100.0 * probability, 0))
}

/// Whether a hypothesis has the same edges as an answer: as many, each at the same distance within [`MATCH_M`].
fn same_edges(hypothesis: &HypothesisView, reported: &[Point]) -> bool {
    let mut pairs = hypothesis.edges.iter().zip(reported);
    hypothesis.edges.len() == reported.len() && pairs.all(|(a, b)| (a.0 - b.0).abs() <= MATCH_M)
}

/// Returns the most probable hypotheses whose edges differ from the answer's, at most `RUNNERS_UP`, with their
/// strokes.
pub fn runners_up<'a>(
    posterior: &'a PosteriorView,
    reported: &[Point],
) -> Vec<(Stroke, &'a HypothesisView)> {
    let likely = (posterior.hypotheses.iter()).filter(|h| h.probability >= MIN_PROBABILITY);
    let runners_up = likely.filter(|h| !same_edges(h, reported));
    strokes().zip(runners_up).collect()
}

/// Returns the strokes of the hypotheses other than the answer, the most probable first. They lie under the answer's
/// line and under each other, each broad enough to show on both sides of the lines above it.
pub fn strokes() -> impl Iterator<Item = Stroke> {
    /// Width of the first stroke, and increment to each next one, pixels.
    const WIDTHS: (f64, f64) = (8.0, 5.0);
    let stroke = |(k, (ink, dash, gap))| {
        let width = WIDTHS.0 + WIDTHS.1 * f64::from(k);
        Stroke::solid(ink, width).dashed(dash, gap).alpha(OPACITY)
    };
    (0..).zip(LOOKS).map(stroke)
}

/// Returns the line of a staircase's surface, pixels, from its edges (distance, height), metres; the line of the level
/// ground if there are none.
pub fn outline(frame: &Frame, edges: &[Point]) -> Vec<Spot> {
    match edges {
        [] => vec![frame.spot(frame.x.0, 0.0), frame.spot(frame.x.1, 0.0)],
        edges => surface_to_draw(frame, edges),
    }
}

/// Returns the probability, by the posterior, of the hypotheses with the answer's edges, as text for the legend such as
/// `, 97 %`; empty without a posterior. `reported` are the edges (distance, height) of the reported steps, metres.
pub fn share(posterior: &PosteriorView, reported: &[Point]) -> String {
    let matching = posterior
        .hypotheses
        .iter()
        .filter(|h| same_edges(h, reported));
    match posterior.hypotheses.as_slice() {
        [] => String::new(),
        _ => format!(", {}", percent(matching.map(|h| h.probability).sum())),
    }
}

/// Returns the points (x, y), metres, that must be in view: `MAYBE`s, the `DROP`, and edges of probable hypotheses.
pub fn points_of_interest(posterior: &PosteriorView, answer: &Answer) -> Vec<Point> {
    let likely = posterior.hypotheses.iter().take(1 + RUNNERS_UP);
    let likely = likely.filter(|h| h.probability >= MIN_PROBABILITY_IN_VIEW);
    let maybes = answer.maybes.iter();
    let maybes = maybes.map(|m| (metres(m.distance), metres(m.height)));
    likely
        .flat_map(|h| h.edges.iter().copied())
        .chain(maybes)
        .chain(answer.drop.iter().map(|d| (metres(d.distance), 0.0)))
        .collect()
}

/// Returns the legend's entries for hypotheses other than the answer, the `DROP` and the `MAYBE`s: mark and text of
/// each.
pub fn legend(runners_up: &[(Stroke, &HypothesisView)], answer: &Answer) -> Vec<(Swatch, String)> {
    let runner_up = |(stroke, h): &(Stroke, &HypothesisView)| {
        let label = format!("runner-up, {}: {}", percent(h.probability), h.name);
        (Swatch::Line(*stroke), label)
    };
    let mut legend: Vec<(Swatch, String)> = runners_up.iter().map(runner_up).collect();
    if answer.drop.is_some() {
        let label = "DROP: the ground ends, band of ±3σ, with its probability".to_owned();
        legend.push((Swatch::Area(CONCLUDED, BAND, drop_stroke()), label));
    }
    if !answer.maybes.is_empty() {
        let label = "MAYBE: possible step with its probability".to_owned();
        legend.push((Swatch::Line(maybe_stroke()), label));
    }
    legend
}

/// Minimum distance of text from the edges of the drawn plane, pixels.
const EDGE: f64 = 14.0;

/// Draws the staircases of the other hypotheses, each with its probability at its end.
pub fn draw_runners_up(
    sheet: &Sheet<'_>,
    frame: &Frame,
    runners_up: &[(Stroke, &HypothesisView)],
) -> Result<()> {
    let right = frame.at.0 + frame.size.0;
    let mut words: Vec<Spot> = Vec::new();
    let lines = runners_up
        .iter()
        .map(|(_, runner_up)| outline(frame, &runner_up.edges));
    let lines: Vec<Vec<Spot>> = lines.collect();
    // The broadest line lies below the others.
    for ((stroke, _), line) in runners_up.iter().zip(&lines).rev() {
        sheet.line(line, *stroke)?;
    }
    for ((stroke, runner_up), line) in runners_up.iter().zip(&lines) {
        let end = line.last().copied().unwrap_or(frame.at);
        let above = (end.1 - 18.0).clamp(frame.at.1 + EDGE, frame.at.1 + frame.size.1 - EDGE);
        let at = free(&words, (end.0.min(right) - 6.0, above));
        words.push(at);
        let face = Face::plain(20.0).right().ink(stroke.ink);
        sheet.note(&percent(runner_up.probability), at, face)?;
    }
    Ok(())
}

/// Returns the first place from `at` downwards at which a written probability covers none of those already written at
/// the spots `words`.
fn free(words: &[Spot], mut at: Spot) -> Spot {
    const APART: Spot = (70.0, 26.0);
    let covers = |w: &&Spot, at: Spot| (w.0 - at.0).abs() < APART.0 && (w.1 - at.1).abs() < APART.1;
    while let Some(word) = words.iter().find(|w| covers(w, at)) {
        at.1 = word.1 + APART.1;
    }
    at
}

/// Opacity, 0…1, of the band of ±3σ around a reported `DROP`.
const BAND: f64 = 0.15;

fn drop_stroke() -> Stroke {
    Stroke::solid(CONCLUDED, 3.2)
}

/// Draws the reported `DROP`: a vertical line through the plot at its distance, if that is in view, and a band of
/// ±3σ.
pub fn draw_drop(sheet: &Sheet<'_>, frame: &Frame, answer: &Answer) -> Result<()> {
    let Some(drop) = &answer.drop else {
        return Ok(());
    };
    let (x, near) = (metres(drop.distance), nearest_m(drop));
    let inside = |x: f64| x.clamp(frame.x.0, frame.x.1);
    let (top, bottom) = (frame.y.1, frame.y.0);
    let band = [(near, top), (2.0 * x - near, bottom)];
    let [a, b] = band.map(|(x, y)| frame.spot(inside(x), y));
    sheet.fill_box(a, b, CONCLUDED, BAND)?;
    if !frame.holds(x, 0.0) {
        return Ok(());
    }
    sheet.line(&[frame.spot(x, top), frame.spot(x, bottom)], drop_stroke())?;
    let at = frame.spot(x, top);
    let face = Face::plain(20.0).ink(CONCLUDED).bold();
    let probability = f64::from(drop.probability) / 1000.0;
    let words = format!("ground ends, {}", percent(probability));
    let room = at.0 + 200.0 < frame.at.0 + frame.size.0;
    let (aside, face) = if room {
        (10.0, face.left())
    } else {
        (-10.0, face.right())
    };
    sheet.note(&words, (at.0 + aside, at.1 + EDGE + 6.0), face)
}

/// Line height of the list of probabilities of each number of steps, pixels.
const COUNT: f64 = 27.0;

fn maybe_stroke() -> Stroke {
    Stroke::solid(MAYBE, 2.4).dashed(5.0, 4.0)
}

/// Draws the reported possible steps (`MAYBE`): a dashed diamond on a dashed line from the ground, and the
/// probability.
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
        let face = Face::plain(20.0).ink(MAYBE);
        let room = at.0 + 90.0 < frame.at.0 + frame.size.0;
        let (aside, face) = if room {
            (18.0, face.left())
        } else {
            (-18.0, face.right())
        };
        sheet.note(&percent(probability), (at.0 + aside, at.1), face)?;
    }
    Ok(())
}

/// Writes the probability of each number of steps into the upper left corner, which stairs that
/// lead up leave free.
pub fn draw_counts(sheet: &Sheet<'_>, frame: &Frame, posterior: &PosteriorView) -> Result<()> {
    let mut at = (frame.at.0 + 14.0, frame.at.1 + 22.0);
    let counts = posterior.counts.iter().enumerate();
    let likely: Vec<(usize, &f64)> = counts.filter(|(_, p)| **p >= MIN_PROBABILITY).collect();
    let face = Face::plain(20.0).left();
    if !likely.is_empty() {
        sheet.note("number of steps", at, face.ink(FAINT))?;
    }
    for (count, probability) in likely {
        at.1 += COUNT;
        let text = format!("{count}:  {}", percent(*probability));
        sheet.note(&text, at, face)?;
    }
    Ok(())
}

/// Marks the drawn objects as covered, so that labels avoid them: lines of the other hypotheses, the drop's line,
/// marks of the possible steps, the list of step counts.
pub fn cover(
    room: &mut LabelPlacer,
    frame: &Frame,
    answer: &Answer,
    (posterior, runners_up): (&PosteriorView, &[(Stroke, &HypothesisView)]),
) {
    for (_, runner_up) in runners_up {
        room.cover_line(&outline(frame, &runner_up.edges));
    }
    if let Some(drop) = &answer.drop {
        let x = metres(drop.distance);
        room.cover_line(&[frame.spot(x, frame.y.1), frame.spot(x, frame.y.0)]);
    }
    for maybe in &answer.maybes {
        let at = frame.spot(metres(maybe.distance), metres(maybe.height));
        room.cover((at.0 - 12.0, at.1 - 12.0), (at.0 + 80.0, at.1 + 12.0));
    }
    let counts = posterior
        .counts
        .iter()
        .filter(|p| **p >= MIN_PROBABILITY)
        .count() as f64;
    let end = (frame.at.0 + 170.0, frame.at.1 + 34.0 + COUNT * counts);
    room.cover(frame.at, end);
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
        let runners_up = |reported: &[Point]| -> Vec<f64> {
            let runners_up = runners_up(&posterior, reported).into_iter();
            runners_up.map(|r| r.1.probability).collect()
        };
        assert_eq!(runners_up(&[(0.6, 0.15), (0.91, 0.31)]), [0.2, 0.1, 0.096]);
        assert_eq!(runners_up(&[]), [0.6, 0.2, 0.096]);
    }

    #[test]
    fn probabilities_do_not_cover_each_other() {
        let words = [(100.0, 50.0), (120.0, 80.0), (400.0, 106.0)];
        assert_eq!(free(&words, (110.0, 30.0)), (110.0, 106.0));
        assert_eq!(free(&words, (110.0, 20.0)), (110.0, 20.0));
        assert_eq!(free(&words, (300.0, 50.0)), (300.0, 50.0));
    }

    #[test]
    fn the_answers_own_share_is_reported() {
        let hypothesis = |probability, edges: &[Point]| HypothesisView {
            name: String::new(),
            probability,
            edges: edges.to_vec(),
        };
        let posterior = PosteriorView {
            counts: Vec::new(),
            hypotheses: vec![
                hypothesis(0.6, &[(0.6, 0.15)]),
                hypothesis(0.3, &[]),
                hypothesis(0.1, &[(0.61, 0.17)]),
            ],
        };
        assert_eq!(share(&posterior, &[(0.6, 0.15)]), ", 70 %");
        assert_eq!(share(&PosteriorView::default(), &[]), "");
    }
}
