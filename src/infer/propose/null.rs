//! Score of level ground in the search.

use super::scene::{Mark, Scene};

impl Scene<'_> {
    /// Returns the search's score of level ground, nats, from which the scores of flights count.
    pub fn level_ground_score(&self) -> f32 {
        let p = self.params;
        let on_ground = |m: &Mark| {
            let z = m.y_m / m.y_sigma_m;
            let on = p.tread_nats - 0.5 * z * z;
            let nats = if on > 0.0 {
                on
            } else if z < -2.0 {
                -p.inside_nats
            } else {
                -p.stray_nats
            };
            m.credibility * nats
        };
        let marks = self.between(p.nearest_riser_m, f32::INFINITY);
        marks.iter().map(on_ground).sum()
    }
}
