//! The answer going up: search and earlier scans propose, the posterior decides.

use super::bases::{Posterior, ROUNDS, flight};
use super::depth;
use super::dimensions::{self, Measured, RisenFlight};
use super::judgement::{AnswerProbabilities, StatedStairs};
use super::propose::search::{Proposals, Search};
use super::propose::stairs::Flight;
use crate::model::Staircase;
use crate::past::History;

/// The answer of a scan going up, its evidence, and its margins over the alternatives.
#[derive(Debug, Default)]
pub struct Inferred {
    /// The accepted staircase as a flight of the search; without one, the search's best flight.
    pub flight: Option<Flight>,
    /// Log-odds of the likeliest staircase against ground without one, nats.
    pub odds: f32,
    /// Margin of the likeliest outline over the runner-up, nats.
    pub margin: f32,
    /// Measured steps of the accepted staircase; `None` if ground without stairs is likelier.
    pub measured: Option<Measured>,
    /// Posterior probabilities for the answer: log-odds of its errors, its drop, and possible steps that it does not
    /// have.
    pub belief: AnswerProbabilities,
}

impl Inferred {
    /// Infers the answer by the posterior and writes it into `self`. `bias_sigma_rad` is the standard deviation of the
    /// shaft's angle error that remains after calibration.
    #[inline(never)]
    pub fn infer(
        &mut self,
        proposals: &Proposals<'_, '_>,
        posterior: &mut Posterior,
        past: Option<&mut History>,
        bias_sigma_rad: f32,
    ) {
        let search = &proposals.search;
        posterior.propose(search, past.as_deref());
        posterior.evaluate(None, None, &mut self.belief);
        let mut reported: Option<Staircase> = None;
        for _ in 0..ROUNDS {
            let likeliest = posterior.likeliest(past.as_deref());
            (self.odds, self.margin) = (likeliest.odds, likeliest.margin);
            if likeliest.is_like(reported.as_ref()) {
                break;
            }
            reported = likeliest.staircase;
            (self.measured, self.flight) = (None, None);
            if let Some(staircase) = &reported {
                self.measure(search, posterior, staircase, bias_sigma_rad);
            }
            let stated = StatedStairs::of(&self.measured, &reported);
            posterior.evaluate(stated, None, &mut self.belief);
        }
        if reported.is_none()
            && let Some(mut drop) = posterior.cloud.end()
        {
            let model = &posterior.model;
            drop.depth_m = depth::behind(&model.echoes, model.height_m, drop.distance_m);
            posterior.evaluate(None, Some(drop), &mut self.belief);
        }
        if self.flight.is_none() {
            self.flight = proposals
                .best
                .clone()
                .map(|flight| RisenFlight::of(search, flight).flight);
        }
        if let Some(past) = past {
            past.keep(&posterior.outlines());
        }
    }

    /// Measures the steps of the accepted staircase, and sets `measured` and `flight`.
    #[inline(never)]
    fn measure(
        &mut self,
        search: &Search<'_, '_>,
        posterior: &Posterior,
        staircase: &Staircase,
        bias_sigma_rad: f32,
    ) {
        let risen = RisenFlight::of(search, flight(search, staircase));
        self.measured = Some(dimensions::ascending(
            search.stairs,
            &risen,
            &posterior.model,
            *staircase,
            bias_sigma_rad,
        ));
        self.flight = Some(risen.flight);
    }
}
