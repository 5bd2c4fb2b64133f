//! Plots: the paper's figures, of any recording.
//!
//! | file | content | paper |
//! |---|---|---|
//! | `NAME-fig02-range-profile.png` | the chirp with the clearest targets | fig. 2 |
//! | `NAME-fig04-map.png` | the sagittal plane, every cell | fig. 4 |
//! | `NAME-fig05-particles-uniform.png` | particles with a uniform spread, before and after resampling | fig. 5 |
//! | `NAME-fig06-particles-gmm.png` | particles from Gaussian modes, before and after resampling | fig. 6 |
//! | `NAME-fig07-clusters.png` | clusters, the rejected ones marked | fig. 7 |
//! | `NAME-fig08-clusters-kept.png` | clusters that are accepted as steps | fig. 8 |
//! | `NAME-fig09-cfar-threshold.png` | fig. 2's chirp with its threshold | fig. 9 |
//! | `NAME-fig10-map-cfar.png` | the sagittal plane, CA-CFAR detections | fig. 10 |
//! | `NAME-fig11-beam-correction.png` | from the top particle to the height | fig. 11 |
//! | `NAME-fig13-staircase.png` | the reported staircase over the truth, the most probable other hypotheses faintly | fig. 13 |
//! | `NAME-fig14-staircase.png` | fig. 13 for stairs that lead down | fig. 14 |
//!
//! Each file is written completely or not at all.

mod coherent;
pub mod colour;
mod inspect;
mod page;
mod paper;
mod particles;
mod plane;
mod posterior;
mod profile;
mod room;
mod sector;
mod shape;
mod sheet;
mod staircase;
mod surface;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use stairscan::config::{Config, EstimatorKind, Plane};
use stairscan::signal::echoes::Echo;
use stairscan::signal::grid::PolarMap;
use stairscan::signal::range::{Profile, RangeProcessor};

pub use particles::{BeamView, ClusterView, ParticleView};
pub use plane::Background;
pub use profile::ProfileView;
pub use staircase::{StepView, steps};
pub use surface::surface;

use crate::answer::Answer;
use crate::output::Outputs;
use crate::recording::Recording;
use crate::setup;
use crate::views::{InspectView, Point, PosteriorView};
use plane::{PlotTexts, SagittalPlane};

/// Intermediate results of the paper's estimator on one map.
#[derive(Clone, Debug, Default)]
pub struct PaperView {
    /// Particles that start with a uniform spread.
    pub uniform: ParticleView,
    /// Particles that start in Gaussian modes.
    pub modes: ParticleView,
    /// Clusters of particles before rejection.
    pub clusters: Vec<ClusterView>,
    /// Clusters that are accepted as steps.
    pub kept: Vec<ClusterView>,
    /// Correction of each reported step for the width of the beam.
    pub beams: Vec<BeamView>,
}

/// Data of one scan for its plots.
#[derive(Clone, Copy)]
pub struct ScanView<'a> {
    /// The recording of one scan.
    pub recording: &'a Recording,
    /// Configuration of the scanner.
    pub config: &'a Config,
    /// The scanner's polar map.
    pub map: &'a PolarMap,
    /// The scanner's answer.
    pub answer: &'a Answer,
    /// Intermediate results of the paper's estimator on the map.
    pub paper: &'a PaperView,
    /// Posterior of the default estimator; empty for another estimator.
    pub posterior: &'a PosteriorView,
}

/// Writes all plots of a scan into `dir`, which is created if necessary. Returns their paths.
///
/// # Errors
/// Names the directory or file that cannot be written.
pub fn write_scan((outputs, dir): (&Outputs, &Path), scan: &ScanView<'_>) -> Result<Vec<PathBuf>> {
    let name = &scan.recording.name;
    let mut written = Vec::new();
    let mut keep = |what: &str, picture: Result<Vec<u8>>| -> Result<()> {
        let path = dir.join(format!("{name}-{what}.png"));
        outputs.write_picture(
            &path,
            &picture.with_context(|| format!("{}", path.display()))?,
        )?;
        written.push(path);
        Ok(())
    };
    if let Some(view) = clearest_profile(scan)? {
        keep("fig02-range-profile", profile::peaks(&view))?;
        keep("fig09-cfar-threshold", profile::threshold(&view))?;
    }
    let plane = SagittalPlane::new(scan.map, &points_of_interest(scan));
    let of = |title: &str| PlotTexts {
        title: title.into(),
        subtitle: format!("{name}, {}", sweep(scan)),
        legend: Vec::new(),
    };
    let raw = of("Radar map of the sagittal plane");
    keep("fig04-map", plane.map(&raw, Background::Raw))?;
    let cfar = of("The map after CA-CFAR");
    keep("fig10-map-cfar", plane.map(&cfar, Background::Cfar))?;
    let paper = scan.paper;
    let of = |title: &str| PlotTexts {
        title: format!("{title}: the paper's estimator"),
        subtitle: format!("{name}{}", beside(scan)),
        legend: Vec::new(),
    };
    let words = of("Particles, uniform at first");
    let picture = particles::particles(&plane, &words, &paper.uniform);
    keep("fig05-particles-uniform", picture)?;
    let words = of("Particles, in Gaussian modes at first");
    let picture = particles::particles(&plane, &words, &paper.modes);
    keep("fig06-particles-gmm", picture)?;
    let words = of("Clusters before rejection");
    let picture = particles::clusters(&plane, &words, &paper.clusters);
    keep("fig07-clusters", picture)?;
    let words = of("Clusters after rejection");
    let picture = particles::clusters(&plane, &words, &paper.kept);
    keep("fig08-clusters-kept", picture)?;
    let words = of(match scan.config.mount.plane.first() {
        Plane::Depth => "Heights by the 3 dB beam model",
        Plane::Height => "Distances by the 3 dB beam model",
    });
    let picture = particles::beam(&plane, &words, &paper.kept, &paper.beams);
    keep("fig11-beam-correction", picture)?;
    let truth = scan.recording.meta.truth.as_ref();
    let words = PlotTexts {
        title: "Reconstructed staircase".into(),
        subtitle: format!("{name}: {}", conclusion(scan)),
        legend: Vec::new(),
    };
    let picture = staircase::draw(&plane, &words, (scan.answer, scan.posterior), truth);
    let what = match scan.config.mount.plane.first() {
        Plane::Depth => "fig13-staircase",
        Plane::Height => "fig14-staircase",
    };
    keep(what, picture)?;
    written.sort();
    Ok(written)
}

/// Writes a range profile with its threshold to `file`.
///
/// # Errors
/// Names the file if it cannot be written.
pub fn write_profile((outputs, file): (&Outputs, &Path), view: &ProfileView) -> Result<()> {
    outputs.check_kind(file, &["png"])?;
    outputs.write_picture(file, &profile::threshold(view)?)
}

/// Writes the plot of a scan's evaluation to `file`.
///
/// # Errors
/// Names the file if it cannot be written.
pub fn write_inspect(
    (outputs, file): (&Outputs, &Path),
    scan: &ScanView<'_>,
    view: &InspectView,
) -> Result<()> {
    let plane = SagittalPlane::new(scan.map, &points_of_interest(scan));
    let words = PlotTexts {
        title: "Echoes with their roles, the best hypothesis and its runners-up".into(),
        subtitle: format!(
            "{}: {}; 2.3 nats: ten times as likely",
            scan.recording.name,
            conclusion(scan)
        ),
        legend: Vec::new(),
    };
    let truth = scan.recording.meta.truth.as_ref();
    outputs.write_picture(
        file,
        &inspect::draw(&plane, &words, (view, scan.answer), truth)?,
    )
}

/// Draws the sagittal plane by the power of each row and by the coherent image, the latter with its echoes. Returns the
/// files.
///
/// # Errors
/// Names the file that cannot be written.
pub fn write_coherent(
    (outputs, dir): (&Outputs, &Path),
    name: &str,
    (power, image): (&PolarMap, &PolarMap),
    echoes: &[Echo],
) -> Result<Vec<PathBuf>> {
    let words = |title: &str| PlotTexts {
        title: title.into(),
        subtitle: name.into(),
        legend: Vec::new(),
    };
    let plane = SagittalPlane::new(power, &[]);
    let by_power = plane.map(&words("Power of each row"), Background::Raw)?;
    let plane = plane.showing(image);
    let title = words("Coherent image, and its echoes by CLEAN");
    let by_phase = coherent::draw(&plane, &title, echoes)?;
    let mut written = Vec::new();
    for (what, picture) in [("power", by_power), ("coherent", by_phase)] {
        let file = dir.join(format!("{name}-{what}.png"));
        outputs.write_picture(&file, &picture)?;
        written.push(file);
    }
    Ok(written)
}

/// Returns the range profile of chirp `k` of a recording. `processor` must be set up for the recording's radar.
///
/// # Errors
/// Names the recording if it has no such chirp.
pub fn profile_view(
    recording: &Recording,
    k: usize,
    processor: &mut RangeProcessor,
) -> Result<ProfileView> {
    let name = &recording.name;
    let chirp = recording
        .chirp(k)
        .with_context(|| format!("{name}: no chirp {k}, there are {}", recording.chirps()))?;
    let mut profile = Profile::default();
    processor
        .profile(chirp, &mut profile)
        .with_context(|| format!("{name}: chirp {k}"))?;
    let radar = setup::radar(recording)?;
    let mirror = recording.meta.mirror.as_ref().map(|m| m.offset_m);
    let angle = recording.meta.angles_deg.get(k);
    let angle = angle.map_or(String::new(), |a| format!(", {}°", page::number(*a, 2)));
    Ok(ProfileView::new(
        format!("{name}, chirp {k}{angle}"),
        &profile,
        radar.bin_spacing_m().into(),
        mirror,
    ))
}

/// Returns the range profile with the clearest targets: the largest sum of the cell values (0.376 dB each) of its
/// detected local maxima. `None` if no chirp was received.
fn clearest_profile(scan: &ScanView<'_>) -> Result<Option<ProfileView>> {
    let map = scan.map;
    let clarity = |row: &usize| -> u32 {
        let cells = map.row(*row);
        let peaks = (1..cells.len().saturating_sub(1)).filter(|&bin| {
            map.is_detected(*row, bin)
                && cells[bin - 1] < cells[bin]
                && cells[bin] >= cells[bin + 1]
        });
        peaks.map(|bin| u32::from(cells[bin])).sum()
    };
    let schedule = setup::schedule(scan.recording, 0)?;
    let chirp = |row: &usize| schedule.chirps.get(*row).copied().flatten();
    let best = (0..map.rows())
        .filter(|row| chirp(row).is_some())
        .max_by_key(clarity);
    let Some(k) = best.as_ref().and_then(chirp) else {
        return Ok(None);
    };
    let config = scan.config;
    let mut processor = RangeProcessor::new(&config.radar, &config.mount, &config.cfar)?;
    profile_view(scan.recording, k, &mut processor).map(Some)
}

/// Returns the points (x, y), metres, that must be in view: true and reported steps, `MAYBE`s, the `DROP`, and edges
/// of other probable hypotheses.
fn points_of_interest(scan: &ScanView<'_>) -> Vec<Point> {
    let truth = scan.recording.meta.truth.iter();
    let real = truth.flat_map(|t| t.steps.iter().map(|s| (s.distance_m, s.height_m)));
    let reported = staircase::steps(scan.answer);
    let reported = reported.iter().map(|s| (s.distance_m, s.height_m));
    let doubtful = posterior::points_of_interest(scan.posterior, scan.answer);
    real.chain(reported).chain(doubtful).collect()
}

/// Returns number of chirps and range of angles of the scan, as text.
fn sweep(scan: &ScanView<'_>) -> String {
    let sweep = &scan.config.sweep;
    let degrees = |k: u16| page::number(f64::from(sweep.angle(k)) / 1000.0, 0);
    let last = sweep.angle_count.saturating_sub(1);
    format!(
        "{} chirps from {}° to {}°",
        sweep.angle_count,
        degrees(0),
        degrees(last)
    )
}

/// Returns the end of a subtitle of the paper's plots: the answer if the paper's estimator gave it, otherwise a note
/// that another estimator gave the answer.
fn beside(scan: &ScanView<'_>) -> String {
    let estimator = scan.config.estimator;
    match estimator {
        EstimatorKind::Paper => format!(": {}", conclusion(scan)),
        _ => format!(
            ": not the answer, which estimator {} gives from the same map ({})",
            estimator.as_str(),
            counted(scan.answer)
        ),
    }
}

/// Returns the number of reported steps, as text.
fn counted(answer: &Answer) -> String {
    match answer.steps.len() {
        0 => "no steps".to_owned(),
        1 => format!("1 step {}", answer.scan.direction.as_str()),
        n => format!("{n} steps {}", answer.scan.direction.as_str()),
    }
}

/// Returns status, reasons, number of steps and estimator of the answer, as text.
fn conclusion(scan: &ScanView<'_>) -> String {
    let answer = scan.answer;
    let reasons: Vec<_> = answer.scan.reasons.iter().map(|r| r.as_str()).collect();
    let why = if reasons.is_empty() {
        String::new()
    } else {
        format!(" ({})", reasons.join(", "))
    };
    let steps = counted(answer);
    let estimator = scan.config.estimator.as_str();
    format!(
        "{}{why}, {steps}, estimator {estimator}",
        answer.scan.status.as_str()
    )
}

#[cfg(test)]
mod deuteranopia;
#[cfg(test)]
mod tests;
