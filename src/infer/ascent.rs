//! The answer going up: from echoes to proposals, posterior, measured steps and conclusion.

use super::bases::Posterior;
use super::conclusion::{AnswerQuality, Conclusion, Margins, report_flights, report_scatterers};
use super::inference::Inferred;
use super::propose::ascending::Ascending;
use super::propose::roles::Roles;
use super::propose::scene::Scene;
use super::propose::search::{Beam, Proposals, Search};
use super::propose::stairs::FlightShape;
use crate::answer::Answer;
use crate::mount::Calibration;
use crate::observer::trace::Stage;
use crate::observer::{Event, Observer};
use crate::params::Params;
use crate::past::History;
use crate::signal::echoes::Echo;
use crate::signal::grid::Geometry;

/// A scan going up, as the search and the posterior take it.
pub struct Ascent<'a> {
    /// Echoes, the strongest first.
    pub echoes: &'a [Echo],
    /// Geometry of the map.
    pub geometry: &'a Geometry,
    /// Calibration on the ground.
    pub found: &'a Calibration,
    /// Whether the floor confirms the configured mounting; where it does not, the stairs' first corner must.
    pub floor_confirms_mount: bool,
    /// Tuned numbers.
    pub params: &'a Params,
}

impl Ascent<'_> {
    /// Finds the best stairs going up, if they explain the echoes better than any alternative, and writes the answer.
    /// `memory` is the search's working memory.
    #[inline(never)]
    pub fn answer(
        &self,
        memory: &mut Beam,
        posterior: &mut Posterior,
        mut past: Option<&mut History>,
        observer: &mut dyn Observer,
        answer: &mut Answer,
    ) -> AnswerQuality {
        let mut scene = Scene::new(self.geometry.mount_height_m, self.params);
        scene.risers(self.echoes);
        let scene = &scene;
        let stairs = Ascending::new(scene);
        let proposals = Proposals::of(&stairs, memory);
        observer.event(Event::Done(Stage::Search));
        let mut inferred = Inferred::default();
        let bias_sigma_rad = self.found.bias_sigma_rad;
        inferred.infer(&proposals, posterior, past.as_deref_mut(), bias_sigma_rad);
        posterior.report(observer);
        if let Some(past) = &mut past {
            let steps = inferred.measured.as_mut();
            past.combine(steps.map_or(&mut [], |m| m.answer.steps.as_mut_slice()));
        }
        let measured = inferred.measured.as_ref();
        let roles = match measured.filter(|m| !m.supports.is_empty()) {
            Some(measured) => measured.roles.clone(),
            None => bare(&proposals.search),
        };
        report_scatterers(self.echoes, scene, &roles, self.found.bend, observer);
        report_flights(&proposals.search, &inferred, observer);
        let ended = Conclusion {
            scene,
            roles,
            margins: Margins::of(&proposals.search, &inferred),
            open: inferred.flight.as_ref().is_some_and(|b| b.shape.open),
            measured: &inferred.measured,
            geometry: self.geometry,
            probabilities: &inferred.belief,
            calibration_excessive: !self.found.fits(self.params),
            floor_confirms_mount: self.floor_confirms_mount,
            surfaces: &posterior.model.surfaces,
        };
        ended.conclude(past.map(|past| &mut past.carried_odds), observer, answer)
    }
}

/// Returns the role of each mark (an echo in the search) on bare ground, in the marks' order.
fn bare(search: &Search<'_, '_>) -> Roles {
    let mut roles = Roles::new();
    for m in &search.stairs.scene().marks {
        // Cannot fail: there is one role for each mark.
        let _ = roles.push(search.stairs.role(m, &[], FlightShape::default()));
    }
    roles
}
