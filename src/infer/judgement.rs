//! The methods of the posterior that evaluate the particles: the likeliest outline of stairs, log-odds of errors of an
//! answer, and possible steps that are not part of the answer.

use super::bases::Posterior;
use super::dimensions::Measured;
use super::propose::stairs::Chain;
use super::variants::{Hypothesis, Variants};
use crate::answer::{Direction, DropEdge, MAX_POSSIBLE_STEPS, PossibleStep};
use crate::config::Plane;
use crate::math;
use crate::model::cloud::{CELLS, Cloud, ReportedAnswer};
use crate::model::{Edge, MAX_STEPS, ReportedDrop, ReportedStep, SAME_M, Staircase};
use crate::observer::trace::{Candidate, ChainLink, Explanation};
use crate::observer::{Event, Observer};
use crate::params::posterior::SHORTEST_LANDING_M;
use crate::params::posterior::{MIN_POSSIBLE_PROBABILITY, OTHER_MARGIN_NATS, VARIED_WITHIN_NATS};
use crate::past::{History, Weighed};
use crate::sort::shell_sort;
use heapless::Vec;

/// Maximum number of distinct places of possible steps that are collected from the particles.
const MAX_PLACES: usize = 16;
/// Maximum number of distinct hypotheses whose variants are added.
const MAX_VARIED: usize = 2;
/// Maximum number of distinct outlines that are kept, the likeliest ones.
const OUTLINES: usize = 6;

/// Particles grouped by their visible steps: equal in number, each within 10 cm of the other's, at any height. A
/// group is represented by its heaviest particle, or by level ground where no step is visible, and has the weight of
/// all.
type Outlines = Vec<Weighed, OUTLINES>;

/// The likeliest explanation by the particles and by earlier scans.
#[derive(Clone, Copy, Debug)]
pub struct Likeliest {
    /// The likeliest staircase; `None` where ground without one is likelier.
    pub staircase: Option<Staircase>,
    /// Log-odds of the likeliest staircase against ground without one, nats.
    pub odds: f32,
    /// Margin of the likeliest explanation over any other staircase or ground without one, nats.
    pub margin: f32,
}

impl Likeliest {
    /// Whether another staircase has as many risers, each within 10 cm of this one's; `None` stands for ground without
    /// stairs.
    pub fn is_like(&self, other: Option<&Staircase>) -> bool {
        let places = |s: Option<&Staircase>| {
            let s = s.copied().unwrap_or_default();
            s.x_m.into_iter().take(s.len())
        };
        same_places(places(self.staircase.as_ref()), places(other))
    }
}

/// The stairs of an answer.
#[derive(Clone, Copy, Debug)]
pub struct StatedStairs<'a> {
    /// The measured steps.
    pub measured: &'a Measured,
    /// The accepted hypothesis.
    pub staircase: &'a Staircase,
}

impl<'a> StatedStairs<'a> {
    /// Returns the stairs of an answer; `None` without steps or hypothesis.
    pub fn of(measured: &'a Option<Measured>, staircase: &'a Option<Staircase>) -> Option<Self> {
        let pair = measured.as_ref().zip(staircase.as_ref());
        pair.map(|(measured, staircase)| Self {
            measured,
            staircase,
        })
    }
}

/// Posterior probabilities for an answer.
#[derive(Clone, Debug, Default)]
pub struct AnswerProbabilities {
    /// Log-odds that the answer is first wrong in each way cell, nats.
    pub error_log_odds: [f32; CELLS],
    /// The reported drop, if any.
    pub drop: Option<DropEdge>,
    /// Possible steps and drops: in the particles with a probability of at least 5 %, but not in the answer. The
    /// nearest first.
    pub possible_steps: Vec<PossibleStep, MAX_POSSIBLE_STEPS>,
}

/// Filling the cloud and evaluating the particles. The struct and the initial hypotheses are in `bases.rs`.
impl Posterior {
    /// Compares the particles with an answer, after [`Posterior::propose`]. The result is written into `probabilities`, so
    /// that there is no second one on the stack.
    #[inline(never)]
    pub fn evaluate(
        &mut self,
        stated: Option<StatedStairs<'_>>,
        drop: Option<DropEdge>,
        probabilities: &mut AnswerProbabilities,
    ) {
        let mut edges: Vec<ReportedStep, MAX_STEPS> = Vec::new();
        let mut answer = Staircase::nothing();
        let mut sigmas = [0.0; MAX_STEPS];
        let steps = stated.map_or(&[][..], |s| &s.measured.answer.steps);
        if let Some(stated) = stated.filter(|_| !steps.is_empty()) {
            answer = *stated.staircase;
        }
        let levels = answer.top_m.iter_mut().zip(&mut sigmas);
        for (step, (top, sigma)) in steps.iter().zip(levels) {
            // Cannot fail: an answer has no more steps than a staircase.
            let _ = edges.push(ReportedStep::of(step));
            (*top, *sigma) = (step.height_m, step.height_sigma_m);
        }
        let reported = ReportedAnswer {
            edges: &edges,
            drop: drop.map(|d| ReportedDrop::new(d.distance_m, d.distance_sigma_m)),
            view: self.model.view,
        };
        // Going down, the answer is already among the hypotheses.
        if answer.kind.direction() == Direction::Up {
            self.add(&answer, &sigmas, answer.last_x() + SHORTEST_LANDING_M);
        }
        self.fill_cloud(&reported);
        self.cloud.resample();
        probabilities.error_log_odds = self.cloud.error_log_odds();
        probabilities.possible_steps = possible_steps(&self.cloud, &reported);
        probabilities.drop = drop;
    }

    /// Returns the likeliest outline by the particles that were evaluated last and by earlier scans.
    #[inline(never)]
    pub fn likeliest(&self, past: Option<&History>) -> Likeliest {
        let outlines = self.outlines();
        let log_prior =
            |o: &Weighed| past.map_or(0.0, |past| past.hypotheses.log_prior(&o.staircase));
        let most = |steps: bool| {
            let of = outlines.iter();
            let of = of.filter(|o| steps != o.staircase.is_empty());
            of.map(|o| (o, o.log_weight + log_prior(o)))
                .max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let (stairs, ground) = (most(true), most(false));
        let odds = match (stairs, ground) {
            (None, _) => f32::NEG_INFINITY,
            (_, None) => f32::INFINITY,
            (Some((_, stairs)), Some((_, ground))) => stairs - ground,
        };
        let weights = || outlines.iter().map(|o| o.log_weight + log_prior(o));
        let most = weights().fold(f32::NEG_INFINITY, math::max);
        let others = weights().filter(|w| *w < most);
        let stairs = stairs.filter(|_| odds >= 0.0);
        Likeliest {
            staircase: stairs.map(|(o, _)| o.staircase),
            odds,
            margin: most - others.fold(f32::NEG_INFINITY, math::max),
        }
    }

    /// Returns the likeliest outlines by this scan alone, the likeliest first, with their log-probabilities.
    #[inline(never)]
    pub fn outlines(&self) -> Outlines {
        let mut outlines = Outlines::new();
        while !outlines.is_full() {
            let known = |s: &Staircase| {
                let same =
                    |o: &Weighed| same_places(self.visible_x(s), self.visible_x(&o.staircase));
                outlines.iter().any(same)
            };
            let fresh = self.cloud.particles().filter(|(s, _)| !known(s));
            let Some((next, _)) = fresh.max_by(|a, b| a.1.total_cmp(&b.1)) else {
                break;
            };
            let same = self.cloud.particles();
            let same = same.filter(|(s, _)| same_places(self.visible_x(s), self.visible_x(next)));
            let bare = self.visible_x(next).next().is_none();
            let outline = Weighed {
                staircase: if bare { Staircase::nothing() } else { *next },
                log_weight: math::ln(same.map(|(_, p)| p).sum()),
            };
            // Cannot fail: the loop ends when it is full.
            let _ = outlines.push(outline);
        }
        outlines
    }

    /// Returns the distances of a staircase's visible steps, metres.
    fn visible_x<'a>(&self, s: &'a Staircase) -> impl Iterator<Item = f32> + 'a {
        let seen = s.edges(&self.model.view).filter(|e| e.seen);
        seen.map(|e| e.x_m)
    }

    /// Reports the particles to the observer.
    pub fn report(&self, observer: &mut dyn Observer) {
        observer.event(Event::Posterior {
            cloud: &self.cloud,
            view: &self.model.view,
        });
    }

    /// Reports to the observer, for each number of steps, the likeliest stairs going down against level ground.
    #[inline(never)]
    pub fn report_descents(&self, likeliest: &Likeliest, observer: &mut dyn Observer) {
        if !observer.listens() {
            return;
        }
        let ground = self.hypotheses.iter().filter(|b| b.staircase.is_empty());
        let ground = ground
            .map(|b| b.log_weight)
            .fold(f32::NEG_INFINITY, math::max);
        let winner = likeliest.staircase.map_or(0, |s| s.len());
        observer.event(Event::Candidate(&Candidate {
            explanation: Explanation::NoStairs,
            faces: &[],
            score: 0.0,
            winner: winner == 0,
        }));
        for count in 1..=MAX_STEPS {
            let alike = self
                .hypotheses
                .iter()
                .filter(|b| b.staircase.len() == count);
            let Some(best) = alike.copied().reduce(Hypothesis::likelier) else {
                continue;
            };
            let s = best.staircase;
            let mut faces = Chain::new();
            for k in 1..=count {
                // A staircase has no more treads than a flight has faces.
                let _ = faces.push(ChainLink {
                    along_m: self.model.view.height_m - s.level(k),
                    column: None,
                });
            }
            observer.event(Event::Candidate(&Candidate {
                explanation: Explanation::Down {
                    edge_m: s.x(0),
                    going_m: s.going().unwrap_or(0.0),
                },
                faces: &faces,
                score: best.log_weight - ground,
                winner: winner == count,
            }));
        }
    }

    /// Fills the cloud with the hypotheses and with variants of the likeliest of them.
    #[inline(never)]
    fn fill_cloud(&mut self, reported: &ReportedAnswer<'_>) {
        let Self {
            model,
            hypotheses,
            cloud,
        } = self;
        cloud.clear();
        let weights = hypotheses.iter().map(|b| b.log_weight);
        let top = weights.fold(f32::NEG_INFINITY, math::max);
        for base in hypotheses.iter() {
            cloud.add(&base.staircase, base.log_weight, &base.sigmas, reported);
            let likely = base.log_weight > top - OTHER_MARGIN_NATS;
            if likely && base.staircase.kind.direction() == Direction::Up {
                Variants {
                    model,
                    reported,
                    cloud,
                }
                .regular(base);
            }
        }
        let mut varied: Vec<&Hypothesis, MAX_VARIED> = Vec::new();
        while !varied.is_full() && model.view.plane == Plane::Depth {
            // Level ground with another wall has the same variants.
            let fresh = |b: &&Hypothesis| {
                let ground = b.staircase.kind.is_level_ground();
                !varied.iter().any(|l| {
                    b.staircase.is_like(&l.staircase)
                        || ground && l.staircase.kind.is_level_ground()
                })
            };
            // Going down, all hypotheses are proposed already.
            let around = hypotheses
                .iter()
                .filter(|b| !b.staircase.kind.variations().is_empty());
            let near = around.filter(|b| b.log_weight > top - VARIED_WITHIN_NATS);
            let next = near.filter(fresh);
            let next = next.max_by(|a, b| a.log_weight.total_cmp(&b.log_weight));
            let Some(base) = next else { break };
            Variants {
                model,
                reported,
                cloud,
            }
            .add_variants(base);
            // Cannot fail: the loop ends when it is full.
            let _ = varied.push(base);
        }
    }
}

/// Whether both lists of distances, metres, have the same length, and differ by less than 10 cm in each place.
fn same_places(a: impl Iterator<Item = f32>, mut b: impl Iterator<Item = f32>) -> bool {
    let mut same = true;
    for x_m in a {
        same &= b.next().is_some_and(|other| (x_m - other).abs() < SAME_M);
    }
    same && b.next().is_none()
}

/// Returns the possible steps, the nearest first: visible edges and drops of particles that are not part of the answer,
/// with those within 10 cm of each other merged.
fn possible_steps(
    cloud: &Cloud,
    reported: &ReportedAnswer<'_>,
) -> Vec<PossibleStep, MAX_POSSIBLE_STEPS> {
    let mut sums: Vec<PossibleStep, MAX_PLACES> = Vec::new();
    for (staircase, probability) in cloud.particles() {
        let seen = staircase.edges(&reported.view).filter(|e| e.seen);
        let drop = staircase.kind.end_m().map(|x_m| Edge {
            x_m,
            y_m: PossibleStep::DROP_M,
            seen: true,
        });
        for edge in seen.chain(drop) {
            let near = |x_m: f32| (x_m - edge.x_m).abs() <= SAME_M;
            let covered = reported.drop.is_some_and(|t| t.covers(edge.x_m)) && edge.y_m < 0.0;
            if covered || reported.edges.iter().any(|t| near(t.x_m)) {
                continue;
            }
            let place = sums.iter_mut().find(|m| {
                near(m.distance_m / m.probability) && (m.height_m < 0.0) == (edge.y_m < 0.0)
            });
            let (distance_m, height_m) = (probability * edge.x_m, probability * edge.y_m);
            match place {
                Some(m) => {
                    m.distance_m += distance_m;
                    m.height_m += height_m;
                    m.probability += probability;
                }
                // Where there is no room, there are so many places that each one is unlikely.
                None => drop_full(sums.push(PossibleStep {
                    distance_m,
                    height_m,
                    probability,
                })),
            }
        }
    }
    let mut possible_steps = Vec::new();
    let likely = |m: &&PossibleStep| m.probability >= MIN_POSSIBLE_PROBABILITY;
    for m in sums.iter().filter(likely) {
        let step = PossibleStep {
            distance_m: m.distance_m / m.probability,
            height_m: m.height_m / m.probability,
            probability: math::min(m.probability, 1.0),
        };
        drop_full(possible_steps.push(step));
    }
    shell_sort(&mut possible_steps, |a: &PossibleStep, b| {
        a.distance_m < b.distance_m
    });
    possible_steps
}

/// Discards a possible step for which there was no room.
fn drop_full(_: Result<(), PossibleStep>) {}
