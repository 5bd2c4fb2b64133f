//! The default estimator: takes in the echoes of one scan, returns the staircase or the ground that explains them
//! best.
//!
//! Going up, a search proposes flights. They and their variants are weighted by the measurement model of
//! [`crate::model`] and become particles. Going down, chains of levels are proposed and weighted, without variants. In
//! both cases the answer is the outline of the highest posterior probability. In the order of the data:
//!
//! | stage | function | result |
//! |---|---|---|
//! | echoes | `Likelihood::detect` | [`Echoes`], `InstrumentEvidence` |
//! | proposals | `Proposals::of` in `propose::search`; going down `propose::descending` | `Proposals` |
//! | posterior | `Inferred::infer` in `inference` | `Posterior`, `Inferred` |
//! | measured | `dimensions::ascending`, `dimensions::descending` | `Measured` |
//! | conclusion | `Conclusion::conclude` in `conclusion` | the answer, `AnswerQuality` |
//! | assessment | `Likelihood::assess` | [`Assessment`] |
//!
//! | module | content |
//! |---|---|
//! | `ascent`, `descent` | the stages from proposals to conclusion, going up and going down |
//! | `propose` | the search: flights that may explain the echoes, each with a score; proposals only |
//! | `bases` | `Posterior` and its initial hypotheses: refined flights, a ramp, level ground |
//! | `readings` | measurements of each riser's place and height from its own echoes |
//! | `gauss` | Gaussian mixture over the levels of a flight of which at most one riser or tread is irregular |
//! | `refine` | fit of a hypothesis's levels, places and overhang to its echoes |
//! | `variants` | variants of a hypothesis: a riser more, fewer, irregular; on bare ground a step, a box, a drop |
//! | `judgement` | the other methods of `Posterior`: likeliest outline, log-odds of errors, possible steps |
//! | `inference` | the answer going up: the modules above in at most two rounds |
//! | `nosings` | distance of each nosing, and the common overhang |
//! | `dimensions` | steps with their standard deviations |
//! | `conclusion` | from the results of an inference to the answer and its quality |
//! | `support`, `horizon` | evidence for each step, reasons that an answer is uncertain, and the horizon |
//!
//! Beside it: [`crate::past`], the evidence of earlier scans; [`crate::model::cloud`], the particles;
//! [`crate::observer::trace`], the intermediate results for an observer.
//!
//! This file joins them: [`Likelihood`] takes in the rows of a scan and makes its answer.

// The stages are `inline(never)`. The stack has 18 KB: merged into one function, the stages would hold the working
// memory of all of them at the same time.

mod ascent;
mod bases;
mod conclusion;
mod depth;
mod descent;
mod dimensions;
mod gauss;
mod horizon;
mod inference;
mod judgement;
mod nosings;
mod propose;
mod readings;
mod refine;
mod support;
mod variants;

#[cfg(test)]
mod tests;

use crate::answer::{Answer, Slope};
use crate::config::Plane;
use crate::estimator::{Estimator, MappedScan};
use crate::model::chart::Chart;
pub use crate::model::cloud::{Cloud, ReportedAnswer};
use crate::model::power::DEPTHS_M;
use crate::model::surfaces::Recursions;
use crate::model::treads::Descending;
use crate::model::{Surfaces, View};
use crate::motion::{Agreement, MotionCompensation, Retention, SweepComparison};
use crate::mount::{Calibration, GroundEvidence};
use crate::observer::trace::Stage;
use crate::observer::{Event, Observer};
use crate::params::generative::Generative;
use crate::params::measured;
use crate::params::{Numbers, Params};
use crate::past::{History, NewScan};
use crate::signal::echoes::{Echoes, Lobes};
use crate::verdict::{Assessment, Reason};
use ascent::Ascent;
use bases::Posterior;
use conclusion::AnswerQuality;
use descent::Descent;
pub use horizon::HorizonAccumulator;
use propose::search::Beam;
pub use variants::weight;

/// The default estimator. Its memory holds the row collector during a scan, and after the last row, in the same
/// place, the working memory of each further stage.
#[derive(Debug)]
pub struct Likelihood {
    phase: Phase,
    echoes: Echoes,
    sweeps: SweepComparison,
    // A reference in the image too: without it the compiler keeps a second measurement model on the stack while it makes
    // the estimator.
    params: &'static Params,
    posterior: Posterior,
}

#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "the phases follow each other in the same memory"
)]
enum Phase {
    Idle,
    Ground(Recursions),
    Up(Beam),
    Down(Descending),
}

impl Default for Likelihood {
    fn default() -> Self {
        Self::new()
    }
}

impl Likelihood {
    /// Returns an estimator before the first scan.
    pub fn new() -> Self {
        Self::with(Numbers::DEFAULT)
    }

    /// Returns an estimator with these tuned numbers, before the first scan.
    pub fn with(numbers: Numbers) -> Self {
        Self {
            phase: Phase::Idle,
            echoes: Echoes::new(),
            sweeps: SweepComparison::new(),
            params: numbers.get(),
            posterior: Posterior::new(&measured::MODEL, numbers),
        }
    }

    /// Replaces the parameters of the measurement model of the depth plane, so that `cargo sim` can fit the numbers
    /// that depend on it.
    pub const fn measuring(mut self, measured: &'static Generative) -> Self {
        self.posterior.measure(measured);
        self
    }
}

impl Estimator for Likelihood {
    fn conclude(
        &mut self,
        scan: &MappedScan<'_>,
        mut past: Option<&mut History>,
        observer: &mut dyn Observer,
        answer: &mut Answer,
    ) -> Option<Assessment> {
        let instrument = self.detect(scan, past.as_deref_mut(), observer);
        let quality = match scan.map.geometry().plane {
            Plane::Depth => {
                let carried = scan.drive.memory != Retention::Off;
                let past = past.as_deref_mut().filter(|_| carried);
                self.ascend(scan, &instrument, past, observer, answer)?
            }
            Plane::Height => self.descend(scan, observer, answer)?,
        };
        observer.event(Event::Done(Stage::Dimensions));
        let drop_m = answer.drop.map(|drop| drop.nearest_m());
        Some(self.assess(scan, &instrument, &quality, past, drop_m))
    }
}

/// Evidence of a scan's echoes about the instrument and the chair.
struct InstrumentEvidence {
    /// Agreement of the scan with the sweep before and with the motion input.
    agreement: Agreement,
    /// Calibration on the ground; without meaning in the height plane.
    calibration: Calibration,
    /// Whether the ground is elsewhere than the mounting puts it, going up.
    floor_off: bool,
    /// Whether the ground confirms the configured mounting, going up.
    floor_confirms_mount: bool,
    /// Whether the strong echoes' main lobes are narrower or broader than the beam, where that is known: the chair stands.
    lobe_width_off: bool,
}

/// The stages after the last row, in their order.
impl Likelihood {
    /// Takes the echoes of the scan, moves the evidence of earlier scans to the chair's present place, and returns
    /// what the echoes show of the instrument.
    fn detect(
        &mut self,
        scan: &MappedScan<'_>,
        past: Option<&mut History>,
        observer: &mut dyn Observer,
    ) -> InstrumentEvidence {
        let MappedScan {
            map,
            found,
            config,
            drive,
            ..
        } = *scan;
        let p = self.params;
        let echoes = &mut self.echoes;
        echoes.clone_from(&found.echoes);
        let agreement = self.sweeps.compare(map, config, drive, echoes);
        let moved_m = agreement.moved_m(drive);
        let moved_during_scan_m = drive.known().map_or(0.0, |track| track.end().travel_m);
        if let Some(past) = past {
            past.begin(&NewScan {
                number: scan.number,
                mount: config.mount,
                radar: config.radar,
                view: View::of(map),
                moved_m: moved_m.filter(|_| drive.memory == Retention::Kept),
                moved_during_scan_m,
            });
        }
        observer.event(Event::Noise(found.noise));
        observer.event(Event::Done(Stage::Echoes));
        let geometry = map.geometry();
        let up = geometry.plane == Plane::Depth;
        let mut calibration = Calibration::fit(echoes, Slope::LEVEL, geometry, p);
        let floor = up.then(|| GroundEvidence::of(echoes, &calibration, p));
        if let Some(floor) = floor {
            observer.event(Event::Floor(floor));
            if floor.bend != Slope::LEVEL {
                calibration = Calibration::fit(echoes, floor.bend, geometry, p);
            }
        }
        // The row profiles shift in range while the chair moves.
        let still = moved_during_scan_m.abs() < p.beam_still_m && up;
        let lobes = still.then(|| Lobes::of(echoes, geometry, p)).flatten();
        if let Some(lobes) = lobes {
            observer.event(Event::Lobes(lobes));
        }
        InstrumentEvidence {
            agreement,
            calibration,
            floor_off: floor.is_some_and(|floor| !floor.in_place(p)),
            floor_confirms_mount: floor.is_some_and(|floor| floor.confirmed(p)),
            lobe_width_off: lobes.is_some_and(|lobes| !lobes.fit(p)),
        }
    }

    /// Calibrates on the ground, weights the ground's line, and finds the likeliest stairs or ground going up. Writes the
    /// answer, and returns its quality.
    fn ascend(
        &mut self,
        scan: &MappedScan<'_>,
        instrument: &InstrumentEvidence,
        past: Option<&mut History>,
        observer: &mut dyn Observer,
        answer: &mut Answer,
    ) -> Option<AnswerQuality> {
        let p = self.params;
        let geometry = scan.map.geometry();
        let found = &instrument.calibration;
        found.subtract(&mut self.echoes, geometry);
        observer.event(Event::Calibration(*found));
        self.posterior.set_echoes(&self.echoes, scan.map);
        let surfaces = &mut self.posterior.model.surfaces;
        evaluate_ground_line(scan, found, &mut self.phase, surfaces);
        self.phase = Phase::Up(Beam::new());
        let Phase::Up(memory) = &mut self.phase else {
            return None;
        };
        let up = Ascent {
            echoes: &self.echoes,
            geometry,
            found,
            floor_confirms_mount: instrument.floor_confirms_mount,
            params: p,
        };
        let quality = up.answer(memory, &mut self.posterior, past, observer, answer);
        answer.lie_on(found.bend);
        Some(quality)
    }

    /// Finds the likeliest stairs going down, or level ground. Writes the answer, and returns its quality.
    fn descend(
        &mut self,
        scan: &MappedScan<'_>,
        observer: &mut dyn Observer,
        answer: &mut Answer,
    ) -> Option<AnswerQuality> {
        let posterior = &mut self.posterior;
        self.phase = Phase::Down(Descending::new(&posterior.model.g.treads));
        let Phase::Down(memory) = &mut self.phase else {
            return None;
        };
        posterior.descend(memory, View::of(scan.map), &self.echoes);
        let down = Descent {
            echoes: &self.echoes,
            geometry: scan.map.geometry(),
            params: self.params,
        };
        Some(down.answer(memory, posterior, observer, answer))
    }

    /// Returns the assessment of an answer of this quality, whose drop is at `drop_m`, metres. The evidence for the next
    /// scan is discarded where this one was not placed.
    fn assess(
        &self,
        scan: &MappedScan<'_>,
        instrument: &InstrumentEvidence,
        quality: &AnswerQuality,
        past: Option<&mut History>,
        drop_m: Option<f32>,
    ) -> Assessment {
        let p = self.params;
        let mounting_off = quality.mounting_off || instrument.floor_off;
        let lobe_width_off = instrument.lobe_width_off;
        let echo_found = self.echoes.iter().any(|e| e.snr_db >= p.sure_echo_db);
        let mut weaknesses = quality.weaknesses;
        if past.as_ref().is_some_and(|past| past.changed()) {
            weaknesses.add(Reason::SceneChanged);
        }
        let confirmed = past.as_ref().is_some_and(|past| past.confirms_motion());
        let agreement = instrument.agreement.confirmed(confirmed);
        let placed = !mounting_off && !lobe_width_off && agreement.placed();
        let kept = echo_found && placed && scan.map.geometry().plane == Plane::Depth;
        let forget = !kept || scan.drive.memory == Retention::Off;
        if let Some(past) = past.filter(|_| forget) {
            past.clear();
        }
        Assessment {
            echo_found,
            valid: Some(quality.valid),
            drop_m,
            mounting_off,
            lobe_width_off,
            agreement,
            weaknesses,
        }
    }
}

/// Evaluates the ground's line of a calibrated scan, in the memory that the search uses next, and writes its log-likelihood
/// ratios to `surfaces`.
#[inline(never)]
fn evaluate_ground_line(
    scan: &MappedScan<'_>,
    calibrated: &Calibration,
    phase: &mut Phase,
    surfaces: &mut Surfaces,
) {
    let image = scan
        .image
        .map(|image| image.cleaned(scan.map, scan.config, scan.found));
    let chart = Chart {
        map: scan.map,
        noise: scan.found.noise,
        bias_rad: calibrated.bias_rad,
        height_m: calibrated.height_m,
        bend: calibrated.bend,
        image: image.as_ref(),
        ride: MotionCompensation::of(scan.drive, &scan.config.radar),
    };
    *phase = Phase::Ground(Recursions::new());
    if let Phase::Ground(ground) = phase {
        ground.lines.look(&chart);
        ground.weigh(surfaces, DEPTHS_M.len());
    }
}
