//! The answer going down: from echoes to posterior, measured steps and conclusion.

use super::bases::Posterior;
use super::conclusion::{AnswerQuality, Conclusion, Margins, report_scatterers};
use super::dimensions;
use super::judgement::{AnswerProbabilities, StatedStairs};
use super::propose::scene::Scene;
use crate::answer::{Answer, Slope};
use crate::model::Surfaces;
use crate::model::treads::Descending;
use crate::observer::trace::Stage;
use crate::observer::{Event, Observer};
use crate::params::Params;
use crate::signal::echoes::Echo;
use crate::signal::grid::Geometry;

/// A scan going down, as the posterior takes it.
pub struct Descent<'a> {
    /// Echoes, the strongest first.
    pub echoes: &'a [Echo],
    /// Geometry of the map.
    pub geometry: &'a Geometry,
    /// Tuned numbers.
    pub params: &'a Params,
}

impl Descent<'_> {
    /// Finds the likeliest stairs going down, or level ground, and writes the answer. `posterior` holds the hypotheses.
    #[inline(never)]
    pub fn answer(
        &self,
        model: &mut Descending,
        posterior: &mut Posterior,
        observer: &mut dyn Observer,
        answer: &mut Answer,
    ) -> AnswerQuality {
        let mut scene = Scene::new(self.geometry.mount_height_m, self.params);
        scene.treads(self.echoes);
        observer.event(Event::Done(Stage::Search));
        let mut belief = AnswerProbabilities::default();
        posterior.evaluate(None, None, &mut belief);
        let likeliest = posterior.likeliest(None);
        let found = likeliest.staircase;
        let measured = found
            .as_ref()
            .map(|s| dimensions::descending(model, &scene, s));
        if let Some(stated) = StatedStairs::of(&measured, &found) {
            posterior.evaluate(Some(stated), None, &mut belief);
        }
        posterior.report(observer);
        let roles = match &measured {
            Some(measured) => measured.roles.clone(),
            None => dimensions::ground_roles(&scene, model),
        };
        report_scatterers(self.echoes, &scene, &roles, Slope::LEVEL, observer);
        posterior.report_descents(&likeliest, observer);
        let ended = Conclusion {
            scene: &scene,
            roles,
            margins: Margins {
                search: likeliest.margin,
                posterior: if measured.is_some() {
                    likeliest.margin
                } else {
                    likeliest.odds
                },
            },
            open: false,
            measured: &measured,
            geometry: self.geometry,
            probabilities: &belief,
            calibration_excessive: false,
            floor_confirms_mount: true,
            surfaces: &Surfaces::NOTHING,
        };
        ended.conclude(None, observer, answer)
    }
}
