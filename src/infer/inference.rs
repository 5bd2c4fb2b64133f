//! The answer going up: search and earlier scans propose, the posterior decides.

use super::bases::{Posterior, ROUNDS, flight};
use super::depth;
use super::dimensions::{self, Measured};
use super::judgement::{AnswerProbabilities, Likeliest};
use super::propose::search::Search;
use super::propose::stairs::Flight;
use crate::estimate::Estimate;
use crate::model::Staircase;
use crate::past::History;

/// A flight, and its riser height averaged over the likelihood of all echoes.
type FlightWithRise = (Flight, Estimate);

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
    /// Infers the answer by the posterior and writes it into `self`. `best` is the search's best flight,
    /// `bias_sigma_rad` the standard deviation of the shaft's angle error that remains after calibration.
    #[inline(never)]
    pub fn infer(
        &mut self,
        search: &Search<'_, '_>,
        best: Option<Flight>,
        (posterior, past): (&mut Posterior, Option<&mut History>),
        bias_sigma_rad: f32,
    ) {
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
            let reported = self.measured.as_ref().zip(reported.as_ref());
            posterior.evaluate(reported, None, &mut self.belief);
        }
        if reported.is_none()
            && let Some(mut drop) = posterior.cloud.end()
        {
            let model = &posterior.model;
            drop.depth_m = depth::behind(&model.echoes, model.height_m, drop.distance_m);
            posterior.evaluate(None, Some(drop), &mut self.belief);
        }
        if self.flight.is_none() {
            self.flight = best.map(|flight| with_rise(search, flight).0);
        }
        if let Some(past) = past {
            past.keep(&posterior.outlines());
        }
    }

    /// Takes the search's best flight as the answer, without the posterior, and measures it.
    #[inline(never)]
    pub fn search_alone(
        &mut self,
        search: &Search<'_, '_>,
        best: Option<Flight>,
        posterior: &Posterior,
        bias_sigma_rad: f32,
    ) {
        let likeliest = Likeliest::of(best.as_ref());
        (self.odds, self.margin) = (likeliest.odds, likeliest.margin);
        self.flight = best.map(|flight| with_rise(search, flight).0);
        if let Some(staircase) = &likeliest.staircase {
            self.measure(search, posterior, staircase, bias_sigma_rad);
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
        let (flight, rise) = with_rise(search, flight(search, staircase));
        let begun = (&posterior.model, *staircase);
        let measured = dimensions::ascending(search.stairs, &flight, rise, begun, bias_sigma_rad);
        self.measured = Some(measured);
        self.flight = Some(flight);
    }
}

/// Returns a flight with the score of its likeliest riser height, and the riser height averaged over the likelihood of
/// all echoes, metres.
fn with_rise(search: &Search<'_, '_>, mut flight: Flight) -> FlightWithRise {
    let (rise, score) = search.stairs.rise(&flight);
    flight.score = score;
    (flight, rise)
}
