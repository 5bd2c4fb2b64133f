//! Views of a scan for drawings, the report page and text: echoes with their roles, hypotheses of the search, the
//! posterior, the edges of the ground truth. Plain data without drawing code, so that all output formats can
//! import it.

use crate::recording::Truth;

/// A point of the plane, metres.
pub type Point = (f64, f64);

/// Returns the edges of the ground truth, nearest first: visible and hidden steps, drop edges and the near edges
/// of holes.
pub fn true_edges(truth: &Truth) -> Vec<Point> {
    let all = truth.steps.iter().chain(&truth.uncounted);
    let mut edges: Vec<Point> = all.map(|s| (s.distance_m, s.height_m)).collect();
    edges.sort_by(|a, b| a.0.total_cmp(&b.0));
    edges
}

/// Effect of a role on the best hypothesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Expected by the winner.
    For,
    /// Impossible under the winner.
    Against,
    /// Neither expected nor impossible.
    Neither,
}

/// One scatterer.
#[derive(Clone, Copy, Debug)]
pub struct ScattererView {
    /// Position, metres.
    pub at: Point,
    /// Power above the noise, dB.
    pub snr_db: f64,
    /// Role: the surface or edge that it is assigned to.
    pub role: &'static str,
    /// Effect of the role on the best hypothesis.
    pub verdict: Verdict,
}

/// One hypothesis of the search.
#[derive(Clone, Debug)]
pub struct ExplanationView {
    /// Number of steps, direction and kind, in words.
    pub name: String,
    /// Log-likelihood ratio against no stairs, nats.
    pub score: f64,
    /// Whether it is the answer.
    pub winner: bool,
    /// Distance and height of each step's edge.
    pub edges: Vec<Point>,
}

/// Scatterers, hypotheses and posterior of one scan.
#[derive(Clone, Debug, Default)]
pub struct InspectView {
    /// Scatterers, strongest first.
    pub scatterers: Vec<ScattererView>,
    /// Hypotheses of the search, likeliest first.
    pub explanations: Vec<ExplanationView>,
    /// The posterior; empty where there is none.
    pub posterior: PosteriorView,
}

/// One hypothesis of the posterior.
#[derive(Clone, Debug)]
pub struct HypothesisView {
    /// Number of steps, direction and kind, in words.
    pub name: String,
    /// Probability, 0…1.
    pub probability: f64,
    /// Distance and height of each of its visible edges.
    pub edges: Vec<Point>,
}

/// The posterior by number of steps and by hypothesis; empty without one.
#[derive(Clone, Debug, Default)]
pub struct PosteriorView {
    /// Probability of each number of steps, from none.
    pub counts: Vec<f64>,
    /// The hypotheses, the likeliest first.
    pub hypotheses: Vec<HypothesisView>,
}

/// The echo that each role comes from.
const MEANINGS: [(&str, &str); 10] = [
    ("corner", "foot of a riser"),
    ("nosing", "foremost edge of a step"),
    ("flash", "face that looks straight at the mirror"),
    ("face", "riser between foot and top"),
    ("tread", "tread, landing or floor"),
    ("edge", "end of a tread, seen from above"),
    ("inside", "within the solid: against the winner"),
    ("above", "above a riser's top: against the winner"),
    ("clutter", "standing on a tread: against the winner"),
    ("stray", "not explained by the winner"),
];

/// Meaning of a role in words; empty for an unknown one.
pub fn meaning(role: &str) -> &'static str {
    let known = MEANINGS.iter().find(|known| known.0 == role);
    known.map_or("", |known| known.1)
}
