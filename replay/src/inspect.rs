//! Observes the likelihood estimator: the role of each scatterer, and the comparison of the best
//! hypothesis with the others, in nats and as probabilities.

use std::fmt::Write as _;

use serde_json::{Value, json};
use stairscan::answer::{Direction, DropEdge, PossibleStep, Slope};
use stairscan::estimator::Estimator;
use stairscan::infer::Likelihood;
use stairscan::mount::GroundEvidence;
use stairscan::observer::trace::{Candidate, Cell, Explanation, Role, Scatterer};
use stairscan::observer::{Event, Observer};
use stairscan::signal::echoes::{Echo, Lobes};
use stairscan::signal::grid::DB_PER_UNIT;
use stairscan::signal::range::FULL_SCALE;
use stairscan::verdict::{Outcome, Status};

use crate::answer::Answer;
use crate::posterior;
use crate::replay::Scanned;
use crate::views::{
    ExplanationView, InspectView, Point, PosteriorView, ScattererView, Verdict, meaning,
};

/// Distance from the mirror from which on cells of the way ahead are shown, metres; it is compared
/// with a cell's far end.
const WAY_FROM_M: f32 = 0.25;
/// Distance from the mirror up to which cells of the way ahead are shown, metres; it is compared
/// with a cell's far end.
const WAY_TO_M: f32 = 1.65;

/// Rounds a value for JSON to millionths: an f32 has no more significant digits.
pub(crate) fn decimal(v: f64) -> f64 {
    (v * 1e6).round() / 1e6
}

/// Intermediate results of the likelihood estimator for one scan.
#[derive(Clone, Debug)]
pub struct Inspection {
    /// Mean noise in one row's cell, dB relative to full scale.
    noise_db: f64,
    /// Angle bias, degrees, and error of the mounting height, metres, as measured on the ground;
    /// `None` if the ground is not visible.
    calibration: Option<(f64, f64)>,
    /// Evidence, as sums of echoes' weights, for the ground at its configured place and for the best other height or
    /// slope; `None` if the scan's plane does not show the ground.
    floor: Option<GroundEvidence>,
    /// Width of the lobes of strong echoes over the rows, in units of a point scatterer's; `None`
    /// without strong echoes.
    lobes: Option<Lobes>,
    scatterers: Vec<Scatterer>,
    /// Way cells (10 cm each of the way ahead), each with the probability that the answer is correct up to its far end.
    way: Vec<Cell>,
    /// Scatterers, hypotheses and posterior for drawings.
    view: InspectView,
    outcome: Outcome,
}

/// Observer that records the estimator's events.
struct TraceObserver {
    mount_height_m: f64,
    noise_db: f64,
    calibration: Option<(f64, f64)>,
    floor: Option<GroundEvidence>,
    lobes: Option<Lobes>,
    scatterers: Vec<Scatterer>,
    way: Vec<Cell>,
    view: InspectView,
}

/// Returns whether a role supports the best hypothesis, contradicts it, or neither.
fn verdict(role: Role) -> Verdict {
    match role {
        Role::Stray => Verdict::Neither,
        role if role.contradicts() => Verdict::Against,
        _ => Verdict::For,
    }
}

impl TraceObserver {
    /// Describes a hypothesis in words; returns the description, and distance and height of its
    /// steps' edges.
    fn explain(&self, candidate: &Candidate<'_>) -> (String, Vec<Point>) {
        let faces = candidate.faces;
        let steps = match faces.len() {
            1 => "1 step".into(),
            n => format!("{n} steps"),
        };
        match candidate.explanation {
            Explanation::NoStairs => ("no stairs".into(), Vec::new()),
            Explanation::Up { rise_m, open } => {
                let kind = if open { "open" } else { "closed" };
                let edge =
                    |(k, x): (usize, f32)| (f64::from(x), (k + 1) as f64 * f64::from(rise_m));
                let edges = faces.iter().map(|l| l.along_m).enumerate().map(edge);
                let name = format!("{steps} up, {kind}, rise {:.2} m", rise_m);
                (name, edges.collect())
            }
            Explanation::Down { edge_m, going_m } => {
                let edge = |(k, depth): (usize, f32)| {
                    let x = f64::from(edge_m) + k as f64 * f64::from(going_m);
                    (x, self.mount_height_m - f64::from(depth))
                };
                let edges = faces.iter().map(|l| l.along_m).enumerate().map(edge);
                let name = format!("{steps} down, going {going_m:.2} m");
                (name, edges.collect())
            }
        }
    }

    fn scatterer(&mut self, scatterer: &Scatterer) {
        let echo = &scatterer.echo;
        self.scatterers.push(*scatterer);
        self.view.scatterers.push(ScattererView {
            at: (echo.x_m.into(), echo.y_m.into()),
            snr_db: echo.snr_db.into(),
            role: scatterer.role.as_str(),
            verdict: verdict(scatterer.role),
        });
    }
}

impl Observer for TraceObserver {
    fn event(&mut self, event: Event<'_>) {
        match event {
            Event::Noise(units) => {
                self.noise_db = f64::from((units - f32::from(FULL_SCALE)) * DB_PER_UNIT);
            }
            Event::Calibration(found) => {
                let bias_deg = f64::from(found.bias_rad).to_degrees();
                self.calibration = Some((bias_deg, found.height_m.into()));
            }
            Event::Floor(floor) => self.floor = Some(floor),
            Event::Lobes(lobes) => self.lobes = Some(lobes),
            Event::Scatterer(scatterer) => self.scatterer(scatterer),
            Event::Candidate(candidate) => {
                let (name, edges) = self.explain(candidate);
                self.view.explanations.push(ExplanationView {
                    name,
                    score: candidate.score.into(),
                    winner: candidate.winner,
                    edges,
                });
            }
            Event::Posterior { cloud, view } => {
                self.view.posterior = posterior::view(cloud, view);
            }
            Event::Cell(cell) => self.way.push(*cell),
            // `MAYBE`s are also part of the answer.
            Event::Done(_) | Event::PossibleStep(_) | Event::Particles { .. } => {}
        }
    }
}

/// Repeats the estimation of a finished scan, passing intermediate results to `observer`, and
/// returns its outcome.
pub fn repeat(scanned: &Scanned<'_>, observer: &mut dyn Observer) -> Outcome {
    repeat_with(Likelihood::new(), scanned, observer)
}

/// As [`repeat`], with an estimator that differs from the scanner's.
pub fn repeat_with(
    mut estimator: Likelihood,
    scanned: &Scanned<'_>,
    observer: &mut dyn Observer,
) -> Outcome {
    estimator.outcome(&scanned.mapped(), None, observer)
}

impl Inspection {
    /// Repeats the estimation of a finished scan and records its events.
    pub fn of(scanned: &Scanned<'_>) -> Self {
        let mut witness = TraceObserver {
            mount_height_m: scanned.config.mount.mount_height_m().into(),
            noise_db: 0.0,
            calibration: None,
            floor: None,
            lobes: None,
            scatterers: Vec::new(),
            way: Vec::new(),
            view: InspectView::default(),
        };
        let outcome = repeat(scanned, &mut witness);
        let mut view = witness.view;
        view.explanations
            .sort_by(|a, b| b.score.total_cmp(&a.score));
        Self {
            noise_db: witness.noise_db,
            calibration: witness.calibration,
            floor: witness.floor,
            lobes: witness.lobes,
            scatterers: witness.scatterers,
            way: witness.way,
            view,
            outcome,
        }
    }

    /// Returns the echoes that the estimator used, the strongest first.
    pub fn points(&self) -> impl Iterator<Item = &Echo> {
        self.scatterers.iter().map(|s| &s.echo)
    }

    /// Returns scatterers, hypotheses and posterior for drawings.
    pub fn view(&self) -> &InspectView {
        &self.view
    }

    /// Returns all intermediate results as text tables with explanations, and the answer in words
    /// at the end.
    pub fn text(&self, answer: &Answer) -> String {
        let mut text = self.surroundings();
        text.push_str(&self.echo_table());
        text.push_str(&self.flights());
        if let Some(view) = self.posterior() {
            text.push_str(&posterior::text(view));
        }
        text.push_str(&self.drop());
        text.push_str(&self.maybes());
        text.push_str(&self.way_table());
        text.push_str(&ending(answer));
        text
    }

    /// Formats noise level and calibration on the ground.
    fn surroundings(&self) -> String {
        let mut text = format!("noise {:.1} dB of full scale", self.noise_db);
        if let Some((bias, height)) = self.calibration {
            let _ = write!(
                text,
                "; angle bias {bias:+.2}°, mount height {:+.1} mm",
                1e3 * height
            );
        }
        if let Some(GroundEvidence {
            configured,
            other,
            bend,
            ..
        }) = self.floor
        {
            let _ = write!(
                text,
                "; log-likelihood of the ground in its place {configured:.1}, elsewhere {other:.1}"
            );
            if bend != Slope::LEVEL {
                let (percent, from_m) = (100.0 * bend.slope, bend.from_m);
                let _ = write!(text, "; ground {percent:+.1} % from {from_m:.2} m");
            }
        }
        if let Some(Lobes { least, median, .. }) = self.lobes {
            let _ = write!(
                text,
                "; width of strong echoes, beams: minimum {least:.2}, median {median:.2}"
            );
        }
        text
    }

    /// Formats the echoes with their roles, and the meanings of the roles.
    fn echo_table(&self) -> String {
        let mut text =
            "\n\n  snr dB  distance m  height m  range σ mm  angle σ °  width  role\n".to_owned();
        for scatterer in &self.scatterers {
            let e = &scatterer.echo;
            let _ = writeln!(
                text,
                "  {:6.1} {:11.3} {:9.3} {:11.2} {:10.2} {:6.2}  {}{}",
                e.snr_db,
                e.x_m,
                e.y_m,
                1e3 * e.range_sigma_m,
                e.angle_sigma_rad.to_degrees(),
                e.width,
                scatterer.role.as_str(),
                if scatterer.role.contradicts() {
                    " (against)"
                } else {
                    ""
                },
            );
        }
        text.push_str(
            "  snr: power above the noise. distance: from the mirror, horizontal. height: above the ground.\n  \
             σ: standard deviation. width: of the lobe over the angle, a point's being 1. Roles here:\n",
        );
        let mut printed: Vec<&str> = Vec::new();
        for role in self.scatterers.iter().map(|s| s.role.as_str()) {
            if !printed.contains(&role) {
                printed.push(role);
                let _ = writeln!(text, "    {role:<8} {}", meaning(role));
            }
        }
        text
    }

    /// Formats the hypotheses of the search with their scores, best first.
    fn flights(&self) -> String {
        let mut text =
            "\n  score nats  flight, with distance and height of each edge, m\n".to_owned();
        for explanation in &self.view.explanations {
            let mark = if explanation.winner { '*' } else { ' ' };
            let _ = write!(
                text,
                "{mark} {:10.2}  {}",
                explanation.score, explanation.name
            );
            for (x, y) in &explanation.edges {
                let _ = write!(text, "  ({x:.3}, {y:.3})");
            }
            text.push('\n');
        }
        text.push_str(
            "  *: same number of steps as the answer. score: log-likelihood ratio of the search \
             against no stairs; it only\n  proposes. closed: stairs with risers; open: without \
             risers.\n",
        );
        text
    }

    /// Formats the probability that the answer is correct, by cell of the way ahead, with the
    /// probability that is required.
    fn way_table(&self) -> String {
        let mut text = String::new();
        let cells = self.way.iter();
        for cell in cells.filter(|c| (WAY_FROM_M..WAY_TO_M).contains(&c.end_m)) {
            if text.is_empty() {
                text.push_str("\n  up to m  P(correct)  required\n");
            }
            let (right, asked) = (100.0 * cell.p_correct, 100.0 * cell.required);
            let asked = if asked > 100.0 {
                "never".to_owned()
            } else {
                format!("{asked:.1} %")
            };
            let short = if cell.p_correct < cell.required {
                "  too little"
            } else {
                ""
            };
            let _ = writeln!(
                text,
                "  {:7.1}  {right:8.1} %  {asked:>8}{short}",
                cell.end_m
            );
        }
        if !text.is_empty() {
            text.push_str(
                "  P(correct): probability that nothing is wrong from the mirror up to there, by \
                 this scan alone. required: threshold\n  from which on the answer is valid up to \
                 there; never where no threshold meets the error limit.\n",
            );
        }
        text
    }

    /// Returns the posterior; `None` if the estimator has not computed one.
    fn posterior(&self) -> Option<&PosteriorView> {
        Some(&self.view.posterior).filter(|p| !p.counts.is_empty())
    }

    /// Formats the edge of the drop; empty if no drop is reported.
    fn drop(&self) -> String {
        let Some(drop) = &self.outcome.answer.drop else {
            return String::new();
        };
        let depth = drop.depth_m.map_or("-".to_owned(), |m| format!("{m:.3} m"));
        format!(
            "\n  probability  drop\n  {:9.1} %  at {:.3} m, σ {:.4} m, not before {:.3} m, depth {depth}\n",
            100.0 * drop.probability,
            drop.distance_m,
            drop.distance_sigma_m,
            drop.nearest_m()
        )
    }

    /// Formats the possible steps (`MAYBE`) as a text table.
    fn maybes(&self) -> String {
        let mut text = String::new();
        for maybe in &self.outcome.answer.possible_steps {
            if text.is_empty() {
                text.push_str("\n  probability  maybe\n");
            }
            let percent = 100.0 * maybe.probability;
            let at = (maybe.distance_m, maybe.height_m);
            let _ = writeln!(text, "  {percent:9.1} %  ({:.3}, {:.3})", at.0, at.1);
        }
        text
    }

    /// Returns the scatterers (echoes with roles), strongest first, one JSON object each.
    pub fn echoes(&self) -> Vec<Value> {
        let scatterer = |s: &Scatterer| {
            let e = &s.echo;
            json!({
                "x_m": decimal(e.x_m.into()),
                "y_m": decimal(e.y_m.into()),
                "range_m": decimal(e.range_m.into()),
                "range_sigma_m": decimal(e.range_sigma_m.into()),
                "angle_deg": decimal(f64::from(e.angle_rad).to_degrees()),
                "angle_sigma_deg": decimal(f64::from(e.angle_sigma_rad).to_degrees()),
                "snr_db": decimal(e.snr_db.into()),
                "width": decimal(e.width.into()),
                "role": s.role.as_str(),
                "against": s.role.contradicts(),
            })
        };
        self.scatterers.iter().map(scatterer).collect()
    }

    /// Returns the inspection as one JSON object.
    pub fn json(&self, answer: &Answer) -> Value {
        let edge = |&(x, y): &Point| json!({"distance_m": decimal(x), "height_m": decimal(y)});
        let explanation = |e: &ExplanationView| {
            json!({
                "name": e.name,
                "score": decimal(e.score),
                "winner": e.winner,
                "edges": e.edges.iter().map(edge).collect::<Vec<_>>(),
            })
        };
        let drop = |d: &DropEdge| {
            json!({
                "distance_m": decimal(d.distance_m.into()),
                "distance_sigma_m": decimal(d.distance_sigma_m.into()),
                "depth_m": d.depth_m.map(|m| decimal(m.into())),
                "probability": decimal(d.probability.into()),
            })
        };
        let maybe = |m: &PossibleStep| {
            json!({
                "distance_m": decimal(m.distance_m.into()),
                "height_m": decimal(m.height_m.into()),
                "probability": decimal(m.probability.into()),
            })
        };
        let cell = |c: &Cell| {
            json!({
                "up_to_m": decimal(c.end_m.into()),
                "right": decimal(c.p_correct.into()),
                "asked": (c.required <= 1.0).then(|| decimal(c.required.into())),
            })
        };
        json!({
            "recording": answer.recording,
            "scan": answer.part.unwrap_or(answer.scan.scan),
            "noise_dbfs": decimal(self.noise_db),
            "angle_bias_deg": self.calibration.map(|c| decimal(c.0)),
            "mount_height_error_m": self.calibration.map(|c| decimal(c.1)),
            "floor_in_place": self.floor.map(|f| decimal(f.configured.into())),
            "floor_elsewhere": self.floor.map(|f| decimal(f.other.into())),
            "narrowest_lobe": self.lobes.map(|l| decimal(l.least.into())),
            "median_lobe": self.lobes.map(|l| decimal(l.median.into())),
            "posterior": self.posterior().map(posterior::json),
            "drop": self.outcome.answer.drop.as_ref().map(drop),
            "maybe": self.outcome.answer.possible_steps.iter().map(maybe).collect::<Vec<_>>(),
            "way": self.way.iter().map(cell).collect::<Vec<_>>(),
            "explanations": self.view.explanations.iter().map(explanation).collect::<Vec<_>>(),
            "scatterers": self.echoes(),
        })
    }
}

/// Formats the answer in sentences: contents, horizon, and the meaning of each reason.
fn ending(answer: &Answer) -> String {
    let count = answer.steps.len();
    let what = match (answer.scan.status, answer.scan.direction) {
        (Status::Fault, _) => "no answer".to_owned(),
        (_, Direction::None) => "no stairs".to_owned(),
        (_, way) => format!(
            "{count} step{} {}",
            if count == 1 { "" } else { "s" },
            way.as_str()
        ),
    };
    let validity = match (answer.horizon_m, answer.scan.confidence) {
        (Some(horizon), Some(tenths)) if horizon > 0.0 => format!(
            ", valid up to {horizon:.1} m from the mirror ({:.1} % confidence)",
            f64::from(tenths) / 10.0
        ),
        (Some(_), Some(_)) => ", valid nowhere".to_owned(),
        _ => String::new(),
    };
    let status = answer.scan.status.as_str();
    let mut text = format!("\nThe scanner reports {what} with the status {status}{validity}.\n");
    for reason in answer.scan.reasons.iter() {
        let _ = writeln!(text, "  {}: {}", reason.as_str(), reason.meaning());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Recording;
    use crate::replay;
    use std::path::Path;

    /// Inspects the first scan of a recording of the repository; returns the inspection and the
    /// answer.
    fn inspection(name: &str) -> (Inspection, Answer) {
        let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
        let recording = Recording::read(&dir.join(name)).unwrap();
        let options = replay::Options::default();
        let mut seen = None;
        replay::answers(&recording, &options, |scanned| {
            let answer = scanned.answer;
            let inspection = Inspection::of(scanned);
            seen = Some((inspection, answer.clone()));
        })
        .unwrap();
        seen.unwrap()
    }

    #[test]
    fn the_winner_is_what_is_reported() {
        for (name, steps) in [("stair_a", 3), ("descending", 4), ("empty", 0)] {
            let (inspection, reported) = inspection(name);
            let winners: Vec<_> = (inspection.view.explanations.iter())
                .filter(|e| e.winner)
                .map(|e| e.edges.len())
                .collect();
            assert_eq!(
                (winners, reported.steps.len()),
                (vec![steps], steps),
                "{name}"
            );
        }
    }

    #[test]
    fn every_scatterer_stands_in_table_and_json() {
        let (inspection, answer) = inspection("stair_a");
        assert!(inspection.scatterers.len() > 5);
        let json = inspection.json(&answer);
        let listed = json["scatterers"].as_array().unwrap();
        assert_eq!(listed.len(), inspection.scatterers.len());
        let text = inspection.text(&answer);
        for scatterer in listed {
            let role = scatterer["role"].as_str().unwrap();
            assert!(
                !meaning(role).is_empty() && text.contains(meaning(role)),
                "{role}"
            );
            assert!(scatterer["x_m"].is_f64() && scatterer["snr_db"].is_f64());
        }
    }

    #[test]
    fn the_posterior_stands_in_table_and_json() {
        let (inspection, answer) = inspection("stair_a");
        let json = inspection.json(&answer);
        let sum = |list: &Value, of: &dyn Fn(&Value) -> f64| -> f64 {
            list.as_array().unwrap().iter().map(of).sum()
        };
        let posterior = &json["posterior"];
        let counts = &posterior["counts"];
        assert!((sum(counts, &|p| p.as_f64().unwrap()) - 1.0).abs() < 1e-3);
        assert!(counts[3].as_f64().unwrap() > 0.5, "{counts}");
        let hypotheses = &posterior["hypotheses"];
        let mass = sum(hypotheses, &|h| h["probability"].as_f64().unwrap());
        assert!((mass - 1.0).abs() < 1e-3, "{hypotheses}");
        let likeliest = &hypotheses[0];
        assert_eq!(likeliest["edges"].as_array().unwrap().len(), 3);
        let text = inspection.text(&answer);
        assert!(text.contains(likeliest["name"].as_str().unwrap()), "{text}");
        let maybes = json["maybe"].as_array().unwrap();
        assert_eq!(maybes.len(), answer.maybes.len());
    }

    #[test]
    fn the_ending_is_a_sentence_with_its_reasons() {
        let (inspection, answer) = inspection("stair_b");
        let text = inspection.text(&answer);
        let (_, end) = text.split_once("The scanner reports ").unwrap();
        let status = answer.scan.status.as_str();
        let beginning = format!("3 steps up with the status {status}, valid");
        assert!(end.starts_with(&beginning), "{end}");
        for reason in answer.scan.reasons.iter() {
            assert!(end.contains(reason.meaning()), "{end}");
        }
    }

    /// The answer is valid in those cells of the way where its probability exceeds the threshold.
    #[test]
    fn the_way_shows_where_the_answer_stops_to_be_valid() {
        let (inspection, answer) = inspection("stair_a");
        let json = inspection.json(&answer);
        let enough = |cell: &&Value| cell["right"].as_f64() >= cell["asked"].as_f64();
        let way = json["way"].as_array().unwrap();
        let last = way.iter().rfind(enough).unwrap();
        assert_eq!(last["up_to_m"].as_f64(), answer.horizon_m);
        let text = inspection.text(&answer);
        assert!(text.contains("  up to m  P(correct)  required\n"), "{text}");
        assert!(text.contains("  too little\n"), "{text}");
    }

    #[test]
    fn a_drop_stands_in_text_and_json() {
        let (mut inspection, answer) = inspection("stair_a");
        assert!(inspection.json(&answer)["drop"].is_null());
        assert!(!inspection.text(&answer).contains("  drop\n"));
        inspection.outcome.answer.drop = Some(DropEdge {
            distance_m: 1.5,
            distance_sigma_m: 0.02,
            depth_m: None,
            probability: 0.75,
        });
        let drop = &inspection.json(&answer)["drop"];
        assert_eq!(drop["distance_m"].as_f64(), Some(1.5));
        assert!(drop["depth_m"].is_null() && drop["probability"].is_number());
        let text = inspection.text(&answer);
        let words = "at 1.500 m, σ 0.0200 m, not before 1.440 m, depth -\n";
        assert!(text.contains(words), "{text}");
    }

    #[test]
    fn going_down_the_likeliest_hypothesis_is_the_answer() {
        let (inspection, answer) = inspection("descending");
        let json = inspection.json(&answer);
        let likeliest = &json["posterior"]["hypotheses"][0];
        let edges = likeliest["edges"].as_array().unwrap();
        assert_eq!(edges.len(), answer.steps.len());
        for (edge, step) in edges.iter().zip(&answer.steps) {
            let off = edge["distance_m"].as_f64().unwrap() - f64::from(step.distance.metres());
            assert!(off.abs() < 0.03, "{edge} {step:?}");
        }
        let name = likeliest["name"].as_str().unwrap();
        assert!(name.contains("down"), "{name}");
    }
}
