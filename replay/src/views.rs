//! Results of a scan for drawings, the report page and text: echoes with their roles, hypotheses of
//! the search, the posterior, the edges of the ground truth. Plain data without drawing code, so
//! that all output formats can import it.

use crate::recording::Truth;

/// A point of the vertical plane that the beam sweeps, metres: horizontal distance from the mirror,
/// and height above the ground.
pub type Point = (f64, f64);

/// Returns distance and height of the edges of the ground truth, nearest first: visible and hidden
/// steps, edges of drops and the near edges of holes.
pub fn true_edges(truth: &Truth) -> Vec<Point> {
    let all = truth.steps.iter().chain(&truth.uncounted);
    let mut edges: Vec<Point> = all.map(|s| (s.distance_m, s.height_m)).collect();
    edges.sort_by(|a, b| a.0.total_cmp(&b.0));
    edges
}

/// Effect of an echo's role on the best hypothesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The best hypothesis expects the echo.
    For,
    /// The echo is impossible under the best hypothesis.
    Against,
    /// The best hypothesis neither expects the echo nor excludes it.
    Neither,
}

/// One scatterer, an echo with its role.
#[derive(Clone, Copy, Debug)]
pub struct ScattererView {
    /// Horizontal distance from the mirror, and height above the ground, metres.
    pub at: Point,
    /// Power above the noise, dB.
    pub snr_db: f64,
    /// Role: the surface or edge to which the echo is assigned.
    pub role: &'static str,
    /// Effect of the role on the best hypothesis.
    pub verdict: Verdict,
}

/// One hypothesis of the search (the estimator's first stage).
#[derive(Clone, Debug)]
pub struct ExplanationView {
    /// Number of steps, direction and kind, in words.
    pub name: String,
    /// Score of the search: log-likelihood ratio against level ground without stairs, nats.
    pub score: f64,
    /// Whether the hypothesis has as many steps as the scanner's answer.
    pub winner: bool,
    /// Distance and height of each step's edge, metres.
    pub edges: Vec<Point>,
}

/// Scatterers, hypotheses and posterior of one scan.
#[derive(Clone, Debug, Default)]
pub struct InspectView {
    /// Echoes with their roles, strongest first.
    pub scatterers: Vec<ScattererView>,
    /// Hypotheses of the search, likeliest first.
    pub explanations: Vec<ExplanationView>,
    /// The posterior; empty if the estimator has not computed one.
    pub posterior: PosteriorView,
}

/// One hypothesis of the posterior: particles with the same visible steps.
#[derive(Clone, Debug)]
pub struct HypothesisView {
    /// Number of steps, direction and kind, in words.
    pub name: String,
    /// Posterior probability, 0…1: sum of the weights of the hypothesis's particles.
    pub probability: f64,
    /// Distance and height of each visible edge, metres.
    pub edges: Vec<Point>,
}

/// The posterior by number of steps and by hypothesis; empty if the estimator has not computed one.
#[derive(Clone, Debug, Default)]
pub struct PosteriorView {
    /// Probability of each number of steps: `counts[k]` is that of `k` steps.
    pub counts: Vec<f64>,
    /// Hypotheses of the posterior, the likeliest first.
    pub hypotheses: Vec<HypothesisView>,
}

/// Name of each role, and the place from which its echo comes.
const MEANINGS: [(&str, &str); 10] = [
    ("corner", "foot of a riser"),
    ("nosing", "foremost edge of a step"),
    ("flash", "face perpendicular to the beam"),
    ("face", "riser between foot and top"),
    ("tread", "tread, landing or floor"),
    ("edge", "end of a tread, seen from above"),
    (
        "inside",
        "within the solid: contradicts the best hypothesis",
    ),
    (
        "above",
        "above a riser's top: contradicts the best hypothesis",
    ),
    ("clutter", "on a tread: contradicts the best hypothesis"),
    ("unexplained", "not explained by the best hypothesis"),
];

/// Returns the meaning of a role in words; empty for an unknown one.
pub fn meaning(role: &str) -> &'static str {
    let known = MEANINGS.iter().find(|known| known.0 == role);
    known.map_or("", |known| known.1)
}
