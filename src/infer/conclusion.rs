//! From the results of an inference, up or down, to the answer and its quality: steps, horizon, possible steps, reasons;
//! and the intermediate results for an observer.

use super::dimensions::Measured;
use super::horizon::{self, HorizonInput};
use super::inference::Inferred;
use super::judgement::AnswerProbabilities;
use super::propose::roles::Roles;
use super::propose::scene::{Mark, Scene};
use super::propose::search::Search;
use super::support;
use crate::answer::{Answer, Slope};
use crate::math;
use crate::model::Surfaces;
use crate::observer::trace::{Candidate, Explanation, Role, Scatterer};
use crate::observer::{Event, Observer};
use crate::params::fitted_for;
use crate::past::CarriedOdds;
use crate::signal::echoes::Echo;
use crate::signal::grid::Geometry;
use crate::verdict::{Reason, Reasons, Validity};

/// Validity of an answer, and the reasons that it is uncertain.
pub struct AnswerQuality {
    /// Horizon and confidence.
    pub valid: Validity,
    /// Whether the calibration or the first corner contradicts the configured mounting.
    pub mounting_off: bool,
    /// Reasons that the answer is uncertain; they are reported, and do not prevent `ok`.
    pub weaknesses: Reasons,
}

/// Margins of the answer over its alternatives.
pub struct Margins {
    /// Margin by the search, nats. With stairs: their score less that of the runner-up. Without stairs: score of the
    /// best flight, where ground without stairs has the score 0.
    pub search: f32,
    /// Margin by the posterior, nats. With stairs: to the runner-up outline. Without stairs: log-odds of the
    /// likeliest stairs against ground without stairs.
    pub posterior: f32,
}

impl Margins {
    /// Returns the margins of an answer going up.
    pub fn of(search: &Search<'_, '_>, inferred: &Inferred) -> Self {
        let measured = inferred.measured.as_ref();
        let stairs = measured.is_some_and(|m| !m.supports.is_empty());
        // A flight that was accepted and then found to be a box or a threshold is not an alternative.
        let flight = inferred
            .flight
            .as_ref()
            .filter(|_| stairs || measured.is_none());
        let Some(rival) = flight else {
            return Self {
                search: f32::NEG_INFINITY,
                posterior: f32::NEG_INFINITY,
            };
        };
        let others = if stairs {
            search.runner_up_score(rival.chain.len())
        } else {
            0.0
        };
        Self {
            search: rival.score - others,
            posterior: if stairs {
                inferred.margin
            } else {
                inferred.odds
            },
        }
    }
}

/// Reports each scatterer's role to the observer, with its height above the level ground before the slope `bend`.
#[inline(never)]
pub fn report_scatterers(
    echoes: &[Echo],
    scene: &Scene<'_>,
    roles: &Roles,
    bend: Slope,
    observer: &mut dyn Observer,
) {
    if !observer.listens() {
        return;
    }
    for (k, &(mut echo)) in (0..).zip(echoes) {
        echo.y_m += bend.height_m(echo.x_m);
        let pair = scene.marks.iter().zip(roles).find(|(m, _)| m.echo == k);
        let role = pair.map_or(Role::Stray, |(_, role)| *role);
        observer.event(Event::Scatterer(&Scatterer { echo, role }));
    }
}

/// Reports every flight of the search with its score to the observer.
#[inline(never)]
pub fn report_flights(search: &Search<'_, '_>, inferred: &Inferred, observer: &mut dyn Observer) {
    if !observer.listens() {
        return;
    }
    let winner = inferred
        .flight
        .as_ref()
        .filter(|_| inferred.measured.is_some());
    observer.event(Event::Candidate(&Candidate {
        explanation: Explanation::NoStairs,
        faces: &[],
        score: 0.0,
        winner: winner.is_none(),
    }));
    for flight in &search.leaders {
        observer.event(Event::Candidate(&Candidate {
            explanation: Explanation::Up {
                rise_m: flight.shape.rise_m,
                open: flight.shape.open,
            },
            faces: &flight.chain,
            score: flight.score,
            winner: winner.is_some_and(|w| w.chain.len() == flight.chain.len()),
        }));
    }
}

/// The results of a finished inference, up or down, from which the answer is written.
pub struct Conclusion<'s> {
    /// Echoes as marks of the search.
    pub scene: &'s Scene<'s>,
    /// Role of each mark under the measured stairs, or on bare ground.
    pub roles: Roles,
    /// Margins of the answer over its alternatives.
    pub margins: Margins,
    /// Whether the treads are open (no risers).
    pub open: bool,
    /// The measured steps; none where ground without stairs is likelier.
    pub measured: &'s Option<Measured>,
    /// Geometry of the map.
    pub geometry: &'s Geometry,
    /// Posterior probabilities for the answer.
    pub probabilities: &'s AnswerProbabilities,
    /// Whether calibration removed a larger error than a correct mounting can have.
    pub calibration_excessive: bool,
    /// Whether the floor confirms the configured mounting.
    pub floor_confirms_mount: bool,
    /// Log-likelihood ratios of a drop or a riser to ground that goes on, from the power along the ground's line.
    pub surfaces: &'s Surfaces,
}

impl Conclusion<'_> {
    /// Writes the answer, of measured stairs or of ground without stairs, and returns its quality.
    #[inline(never)]
    pub fn conclude(
        self,
        outlook: Option<&mut CarriedOdds>,
        observer: &mut dyn Observer,
        answer: &mut Answer,
    ) -> AnswerQuality {
        let scene = self.scene;
        let p = scene.params;
        let mounting_off =
            self.calibration_excessive || !self.floor_confirms_mount && self.corner_off();
        let mut supports = heapless::Vec::new();
        let mut weaknesses = Reasons::NONE;
        if let Some(measured) = self.measured {
            answer.clone_from(&measured.answer);
            supports.clone_from(&measured.supports);
            if measured.may_be_step {
                weaknesses.add(Reason::CloseRival);
            }
        }
        let margin = self.margins.search;
        if supports.is_empty() {
            let strongest_db = scene.marks.iter().map(|m| m.snr_db).fold(0.0, math::max);
            weaknesses = weaknesses.and(support::reasons_without_steps(
                self.margins.posterior,
                strongest_db,
                p,
            ));
        } else {
            let pairs = scene.marks.iter().zip(&self.roles);
            let against = pairs.filter(|(_, role)| role.contradicts()).map(|(m, _)| m);
            weaknesses = weaknesses.and(support::reasons(
                &answer.steps,
                self.margins.posterior,
                &supports,
                against,
                p,
            ));
        }
        answer.link();
        let ground = HorizonInput {
            scene,
            roles: &self.roles,
            steps: &answer.steps,
            supports: &supports,
            margin,
            open: self.open,
            geometry: self.geometry,
            error_log_odds: self.probabilities.error_log_odds,
            surfaces: self.surfaces,
            drop: self.probabilities.drop,
        };
        let valid = horizon::validity(&ground, outlook, &mut |cell| {
            if observer.listens() {
                observer.event(Event::Cell(cell));
            }
        });
        answer
            .possible_steps
            .clone_from(&self.probabilities.possible_steps);
        let map = fitted_for(self.geometry.plane).maybe_map;
        for maybe in &mut answer.possible_steps {
            if observer.listens() {
                observer.event(Event::PossibleStep(maybe));
            }
            maybe.probability = map.calibrated(maybe.probability);
        }
        answer.drop = self.probabilities.drop;
        AnswerQuality {
            valid,
            mounting_off,
            weaknesses,
        }
    }

    /// Whether the corner of floor and first riser, where a reliable one is found, lies above or below the floor.
    #[inline(never)]
    fn corner_off(&self) -> bool {
        let Some(measured) = self.measured else {
            return false;
        };
        let scene = self.scene;
        let p = scene.params;
        if !p.rules.corner_astray {
            return false;
        }
        let Some(first) = measured.answer.steps.first() else {
            return false;
        };
        let foot = |(m, role): &(&Mark, &Role)| {
            let there = (m.x_m - first.distance_m).abs() < p.foot_reach_m;
            let low = m.y_m < 0.5 * first.height_m;
            let foot = matches!(role, Role::Corner | Role::Inside);
            foot && there && low && m.snr_db > p.corner_astray_db
        };
        let feet = scene.marks.iter().zip(&measured.roles).filter(foot);
        let foot = feet.reduce(|a, b| if b.0.snr_db > a.0.snr_db { b } else { a });
        foot.is_some_and(|(m, _)| m.y_m.abs() > p.corner_astray_rad * m.range_m)
    }
}
