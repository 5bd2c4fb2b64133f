//! Summarises the posterior (the weighted particles): probability by number of steps, and by
//! hypothesis.

use std::fmt::Write as _;
use std::mem::discriminant;

use serde_json::{Value, json};
use stairscan::answer::PossibleStep;
use stairscan::infer::Cloud;
use stairscan::model::{GroundKind, Staircase, View};

use crate::views::{HypothesisView, Point, PosteriorView};

/// Maximum distance between corresponding edges of two particles that count as the same staircase,
/// metres: the matching distance of the score.
const SAME_M: f64 = crate::score::MATCH_M;

/// Groups the particles into hypotheses and returns these, likeliest first, with the probability of
/// each number of steps. Particles with the same visible steps (number, place and kind) are one
/// hypothesis, described by its likeliest particle.
pub fn view(cloud: &Cloud, view: &View) -> PosteriorView {
    let mut particles: Vec<(&Staircase, f32)> = cloud.particles().collect();
    particles.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut groups: Vec<(GroundKind, bool, HypothesisView)> = Vec::new();
    for (staircase, probability) in particles {
        let edges = edges(staircase, view);
        // An open riser is significant only for stairs, not for a single obstacle.
        let open = staircase.kind == GroundKind::Stairs && staircase.open;
        let same = groups.iter_mut().find(|(kind, other, known)| {
            discriminant(kind) == discriminant(&staircase.kind)
                && *other == open
                && alike(&known.edges, &edges)
        });
        match same {
            Some((.., known)) => known.probability += f64::from(probability),
            None => {
                let hypothesis = HypothesisView {
                    name: name(staircase, edges.len()),
                    probability: probability.into(),
                    edges,
                };
                groups.push((staircase.kind, open, hypothesis));
            }
        }
    }
    let mut hypotheses: Vec<HypothesisView> = groups.into_iter().map(|g| g.2).collect();
    hypotheses.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    PosteriorView {
        counts: cloud.counts().into_iter().map(f64::from).collect(),
        hypotheses,
    }
}

fn alike(a: &[Point], b: &[Point]) -> bool {
    let near = |(a, b): (&Point, &Point)| (a.0 - b.0).abs() <= SAME_M;
    a.len() == b.len() && a.iter().zip(b).all(near)
}

/// Returns distance and height of a particle's visible edges, metres: of every step, of a single
/// obstacle, of the drop.
fn edges(staircase: &Staircase, view: &View) -> Vec<Point> {
    let point = |x: f32, y: f32| (f64::from(x), f64::from(y));
    match staircase.kind {
        GroundKind::Stairs | GroundKind::Descent => {
            let seen = staircase.edges(view).filter(|e| e.seen);
            seen.map(|e| point(e.x_m, e.y_m)).collect()
        }
        GroundKind::Box | GroundKind::Threshold => {
            let pairs = staircase.x_m.iter().zip(&staircase.top_m);
            let pairs = pairs.take(staircase.len());
            pairs.map(|(&x, &y)| point(x, y)).collect()
        }
        GroundKind::Drop { at_m } => vec![point(at_m, PossibleStep::DROP_M)],
        GroundKind::Nothing | GroundKind::Ramp { .. } => Vec::new(),
    }
}

/// Formats a number of steps in words, such as `3 steps`.
fn steps(count: usize) -> String {
    format!("{count} step{}", if count == 1 { "" } else { "s" })
}

/// Returns the name of a staircase with `seen` visible edges: number, direction and kind of the
/// steps.
fn name(staircase: &Staircase, seen: usize) -> String {
    let mut name = match staircase.kind {
        GroundKind::Nothing => "no stairs".to_owned(),
        GroundKind::Stairs => {
            let kind = if staircase.open { "open" } else { "closed" };
            let rise = staircase.rise();
            format!("{} up, {kind}, rise {rise:.2} m", steps(seen))
        }
        GroundKind::Descent => {
            let rise = -staircase.rise();
            format!("{} down, rise {rise:.2} m", steps(seen))
        }
        GroundKind::Ramp { from_m, slope } if slope < 0.0 => {
            format!("ramp down of {:.0} % from {from_m:.2} m", -100.0 * slope)
        }
        GroundKind::Ramp { from_m, slope } => {
            format!("ramp of {:.0} % from {from_m:.2} m", 100.0 * slope)
        }
        GroundKind::Drop { at_m } => format!("ground ends at {at_m:.2} m"),
        GroundKind::Box => format!("obstacle, {:.2} m high", staircase.level(1)),
        GroundKind::Threshold => format!("threshold, {:.2} m high", staircase.level(1)),
    };
    if staircase.wall_m.is_finite() {
        let _ = write!(name, ", wall at {:.2} m", staircase.wall_m);
    }
    name
}

/// Formats the posterior as text tables.
pub fn text(posterior: &PosteriorView) -> String {
    let mut text = String::from("\n  probability  number of steps\n");
    for (count, probability) in posterior.counts.iter().enumerate() {
        if *probability >= MIN_REPORTED {
            let _ = writeln!(text, "  {:9.1} %  {count}", 100.0 * probability);
        }
    }
    text.push_str("\n  probability  hypothesis\n");
    for hypothesis in &posterior.hypotheses {
        if hypothesis.probability < MIN_REPORTED {
            break;
        }
        let percent = 100.0 * hypothesis.probability;
        let _ = write!(text, "  {percent:9.1} %  {}", hypothesis.name);
        for (x, y) in &hypothesis.edges {
            let _ = write!(text, "  ({x:.3}, {y:.3})");
        }
        text.push('\n');
    }
    text.push_str("  hypothesis: possible scene with its posterior probability; distance and height of its edges, m\n");
    text
}

/// Minimum probability of a listed hypothesis: a smaller one rounds to 0.0 %.
const MIN_REPORTED: f64 = 0.0005;

/// Returns the posterior as JSON: `counts` by number of steps from 0, `hypotheses` likeliest first.
pub fn json(posterior: &PosteriorView) -> Value {
    // Rounded to millionths: an f32 has no more significant digits.
    let decimal = |v: f64| (v * 1e6).round() / 1e6;
    let edge = |&(x, y): &Point| json!({"distance_m": decimal(x), "height_m": decimal(y)});
    let hypothesis = |h: &HypothesisView| {
        json!({
            "name": h.name,
            "probability": decimal(h.probability),
            "edges": h.edges.iter().map(edge).collect::<Vec<_>>(),
        })
    };
    let counts = posterior.counts.iter().copied().map(decimal);
    json!({
        "counts": counts.collect::<Vec<_>>(),
        "hypotheses": posterior.hypotheses.iter().map(hypothesis).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use stairscan::infer::ReportedAnswer;
    use stairscan::model::MAX_STEPS;

    const VIEW: View = View {
        plane: stairscan::config::Plane::Depth,
        height_m: 0.4,
        lowest: -1.0,
        highest: 0.3,
        farthest_m: 2.8,
    };

    /// Returns the posterior of particles with these weights, for an answer without steps and
    /// drops.
    fn posterior(particles: &[(Staircase, f32)]) -> PosteriorView {
        let reported = ReportedAnswer {
            edges: &[],
            drop: None,
            view: VIEW,
        };
        let mut cloud = Cloud::new();
        for (staircase, weight) in particles {
            cloud.add(staircase, weight.ln(), &[0.01; MAX_STEPS], &reported);
        }
        view(&cloud, &VIEW)
    }

    fn stairs(edges: &[(f32, f32)]) -> Staircase {
        let with = |s: Staircase, (k, &(x, top)): (usize, &(f32, f32))| s.with(k, x, top);
        edges.iter().enumerate().fold(Staircase::nothing(), with)
    }

    #[test]
    fn mass_is_summed_by_hypothesis() {
        let floating = Staircase {
            open: true,
            ..stairs(&[(0.6, 0.15), (0.9, 0.30)])
        };
        let walled = Staircase {
            wall_m: 2.1,
            ..stairs(&[(0.62, 0.15), (0.91, 0.31)])
        };
        let posterior = posterior(&[
            (stairs(&[(0.6, 0.15), (0.9, 0.30)]), 0.4),
            (Staircase::nothing(), 0.1),
            (walled, 0.2),
            (stairs(&[(0.6, 0.15)]), 0.25),
            (floating, 0.05),
        ]);
        let reported = |h: &HypothesisView| (h.name.clone(), (1000.0 * h.probability).round());
        let reported: Vec<(String, f64)> = posterior.hypotheses.iter().map(reported).collect();
        let expected = [
            ("2 steps up, closed, rise 0.15 m", 600.0),
            ("1 step up, closed, rise 0.15 m", 250.0),
            ("no stairs", 100.0),
            ("2 steps up, open, rise 0.15 m", 50.0),
        ];
        assert_eq!(reported, expected.map(|(name, p)| (name.to_owned(), p)));
        let counts: Vec<f64> = (posterior.counts.iter())
            .map(|p| (1000.0 * p).round())
            .collect();
        assert_eq!(counts[..4], [100.0, 250.0, 650.0, 0.0]);
        let text = text(&posterior);
        assert!(text.contains("       65.0 %  2\n"), "{text}");
        let json = json(&posterior);
        assert_eq!(json["counts"][2], 0.65);
        assert_eq!(json["hypotheses"][1]["edges"][0]["distance_m"], 0.6);
    }

    #[test]
    fn what_is_no_stairs_has_its_words() {
        let ramp = Staircase::ramp(0.8, 0.09);
        let drop = Staircase::drop(1.2);
        let obstacle = Staircase {
            kind: GroundKind::Box,
            ..stairs(&[(0.7, 0.5)])
        };
        let posterior = posterior(&[(ramp, 0.5), (drop, 0.3), (obstacle, 0.2)]);
        let names: Vec<&str> = (posterior.hypotheses.iter())
            .map(|h| h.name.as_str())
            .collect();
        let expected = [
            "ramp of 9 % from 0.80 m",
            "ground ends at 1.20 m",
            "obstacle, 0.50 m high",
        ];
        assert_eq!(names, expected);
        assert_eq!(posterior.hypotheses[1].edges.len(), 1);
    }
}
