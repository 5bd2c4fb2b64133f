//! Plots of the paper's particle filter: figs. 5 to 8 and 11.

use anyhow::Result;
use plotters::style::{RGBColor, WHITE};
use stairscan::paper::cluster::ClusterVerdict;

use super::colour::{CONCLUDED, HUES, MEASURED, Palette};
use super::page::{Frame, Swatch, number};
use super::plane::{Background, PlotTexts, SagittalPlane};
use super::room::LabelPlacer;
use super::shape::{SOLID, Shape};
use super::sheet::{FAINT, Face, INK, Sheet, Spot, Stroke};
use crate::views::Point;

/// Particles of the paper's filter, before and after resampling.
#[derive(Clone, Debug, Default)]
pub struct ParticleView {
    /// Place (horizontal distance from the mirror, height above the ground) of each particle before resampling, metres.
    pub initial: Vec<Point>,
    /// Place (horizontal distance from the mirror, height above the ground) of each particle after the last round of
    /// resampling, metres.
    pub resampled: Vec<Point>,
    /// Number of resampling rounds.
    pub rounds: usize,
}

/// One cluster of particles.
#[derive(Clone, Debug)]
pub struct ClusterView {
    /// Places (horizontal distance from the mirror, height above the ground) of the cluster's particles, metres.
    pub points: Vec<Point>,
    /// The cluster's middle, metres: weighted mean of its particles' places.
    pub centre: Point,
    /// Whether the cluster is kept, or the reason of its rejection.
    pub fate: ClusterVerdict,
}

/// Correction of a step for the beam's width: from a cluster's end to the reported edge, metres.
#[derive(Clone, Copy, Debug)]
pub struct BeamView {
    /// End of the cluster. Going up: the height of its topmost particle, at the edge's distance (eq. 5); going down:
    /// the distance of its nearest particle, at the edge's height.
    pub end: Point,
    /// Reported edge of the cluster's step (horizontal distance from the mirror, height above the ground), metres.
    pub edge: Point,
}

/// Draws particles over the raw map (figs. 5 and 6).
pub fn particles(
    plane: &SagittalPlane<'_>,
    words: &PlotTexts,
    view: &ParticleView,
) -> Result<Vec<u8>> {
    let mut words = words.clone();
    let rounds = match view.rounds {
        1 => "after 1 round of resampling (large: many copies)".to_owned(),
        n => format!("after {n} rounds of resampling (large: many copies)"),
    };
    words.legend = vec![
        (
            Swatch::Mark(Shape::Diamond, 5.0, HUES[5]),
            "particles at first".into(),
        ),
        (Swatch::Mark(Shape::Dot, 5.0, CONCLUDED), rounds),
    ];
    plane.draw(&words, Background::Raw, Palette::Ground, |sheet, frame| {
        dots(sheet, frame, &view.initial, 2.6, (Shape::Diamond, HUES[5]))?;
        particle_counts(sheet, frame, &view.resampled, 2.6, (Shape::Dot, CONCLUDED))
    })
}

fn dots(
    sheet: &Sheet<'_>,
    frame: &Frame,
    points: &[Point],
    radius: f64,
    (shape, ink): MarkStyle,
) -> Result<()> {
    for &(x, y) in points.iter().filter(|p| frame.holds(p.0, p.1)) {
        sheet.marker(shape, frame.spot(x, y), radius, ink, WHITE)?;
    }
    Ok(())
}

/// Draws a dot for each place with particles. Its area is proportional to the number of particles there, up to
/// `MAX_COPIES`.
fn particle_counts(
    sheet: &Sheet<'_>,
    frame: &Frame,
    points: &[Point],
    radius: f64,
    mark_style: MarkStyle,
) -> Result<()> {
    /// Number of particles at one place from which on the dot that stands for them grows no more.
    const MAX_COPIES: usize = 12;
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    for heap in sorted.chunk_by(|a, b| a == b) {
        let copies = heap.len().min(MAX_COPIES) as f64;
        dots(sheet, frame, &heap[..1], radius * copies.sqrt(), mark_style)?;
    }
    Ok(())
}

/// Draws the clusters, with the rejected ones marked (figs. 7 and 8).
pub fn clusters(
    plane: &SagittalPlane<'_>,
    words: &PlotTexts,
    clusters: &[ClusterView],
) -> Result<Vec<u8>> {
    let mut words = words.clone();
    let shown: Vec<(MarkStyle, &ClusterView)> =
        mark_styles(clusters).into_iter().zip(clusters).collect();
    words.legend = shown
        .iter()
        .filter(|(_, c)| c.fate == ClusterVerdict::Kept)
        .enumerate()
        .map(|(k, ((shape, ink), c))| {
            let label = format!("step {}: {} particles", k + 1, c.points.len());
            (Swatch::Mark(*shape, 6.0, *ink), label)
        })
        .collect();
    let fates = [
        (ClusterVerdict::Outlier, "outlier"),
        (ClusterVerdict::Fused(0), "fused into another"),
        (ClusterVerdict::Redundant, "redundant"),
    ];
    let lost: Vec<String> = fates
        .iter()
        .map(|(fate, name)| (count_of(clusters, *fate), name))
        .filter(|(count, _)| *count > 0)
        .map(|(count, name)| format!("{count} {name}"))
        .collect();
    if !lost.is_empty() {
        let mark = Swatch::Mark(Shape::Cross, 7.0, INK);
        words.legend.push((mark, lost.join(", ")));
    }
    if shown.is_empty() {
        words.subtitle.push_str("; no clusters");
    }
    plane.draw(&words, Background::Cfar, Palette::Ground, |sheet, frame| {
        for (mark_style, cluster) in &shown {
            dots(sheet, frame, &cluster.points, 3.6, *mark_style)?;
        }
        let mut room = plane.room(frame);
        for (_, cluster) in &shown {
            cover_dots(&mut room, frame, &cluster.points);
        }
        for ((_, ink), cluster) in shown.iter().filter(|(_, c)| c.fate == ClusterVerdict::Kept) {
            let corners = outline(frame, &cluster.points);
            room.cover_line(&corners);
            sheet.line(&corners, Stroke::solid(*ink, 2.0).dashed(7.0, 4.0))?;
        }
        draw_lost(sheet, frame, &mut room, clusters)
    })
}

/// Draws crosses on the rejected clusters, each with the reason.
fn draw_lost(
    sheet: &Sheet<'_>,
    frame: &Frame,
    room: &mut LabelPlacer,
    clusters: &[ClusterView],
) -> Result<()> {
    let lost = || clusters.iter().filter(|c| c.fate != ClusterVerdict::Kept);
    let spot = |cluster: &ClusterView| frame.spot(cluster.centre.0, cluster.centre.1);
    for at in lost().map(spot) {
        sheet.marker(Shape::Cross, at, 10.0, INK, WHITE)?;
        room.cover_mark(at, 11.0);
    }
    for cluster in lost() {
        let reason = match cluster.fate {
            ClusterVerdict::Outlier => "outlier",
            ClusterVerdict::Fused(_) => "fused",
            ClusterVerdict::Kept | ClusterVerdict::Redundant => "redundant",
        };
        let face = Face::plain(20.0).ink(FAINT);
        room.write(sheet, spot(cluster), &[(reason, face)])?;
    }
    Ok(())
}

/// Marks the places of particles as covered, so that labels avoid them.
fn cover_dots(room: &mut LabelPlacer, frame: &Frame, points: &[Point]) {
    for &(x, y) in points {
        room.cover_mark(frame.spot(x, y), 5.0);
    }
}

/// Returns the number of clusters with this verdict; for `Fused`, whatever the cluster they are fused with.
fn count_of(clusters: &[ClusterView], fate: ClusterVerdict) -> usize {
    let same = |c: &&ClusterView| std::mem::discriminant(&c.fate) == std::mem::discriminant(&fate);
    clusters.iter().filter(same).count()
}

/// Shape and fill colour of the markers that stand for one cluster's particles.
type MarkStyle = (Shape, RGBColor);

/// Assigns shape and colour to each cluster, first to the kept ones, so that these look the same in figs. 7 and 8.
fn mark_styles(clusters: &[ClusterView]) -> Vec<MarkStyle> {
    let kept = count_of(clusters, ClusterVerdict::Kept);
    let (mut next_kept, mut next_other) = (0, kept);
    let mark_style = |c: &ClusterView| {
        let next = match c.fate {
            ClusterVerdict::Kept => &mut next_kept,
            _ => &mut next_other,
        };
        *next += 1;
        let k = *next - 1;
        (SOLID[k % SOLID.len()], HUES[k % HUES.len()])
    };
    clusters.iter().map(mark_style).collect()
}

/// Returns the corners of the box around a cluster's particles, pixels, the first corner twice; empty for a cluster
/// without particles.
fn outline(frame: &Frame, points: &[Point]) -> Vec<Spot> {
    const ROOM: f64 = 9.0;
    let spots = points.iter().map(|&(x, y)| frame.spot(x, y));
    let none = (
        (f64::INFINITY, f64::INFINITY),
        (f64::NEG_INFINITY, f64::NEG_INFINITY),
    );
    let (low, high) = spots.fold(none, |(low, high): (Spot, Spot), s| {
        (
            (low.0.min(s.0), low.1.min(s.1)),
            (high.0.max(s.0), high.1.max(s.1)),
        )
    });
    if low.0 > high.0 {
        return Vec::new();
    }
    let (a, b) = ((low.0 - ROOM, low.1 - ROOM), (high.0 + ROOM, high.1 + ROOM));
    vec![a, (b.0, a.1), b, (a.0, b.1), a]
}

/// Draws the correction of each step for half the beam's width (3 dB model), from the outermost particle of its
/// cluster to the reported edge (fig. 11).
pub fn beam(
    plane: &SagittalPlane<'_>,
    words: &PlotTexts,
    clusters: &[ClusterView],
    beams: &[BeamView],
) -> Result<Vec<u8>> {
    let half = f64::from(plane.polar().geometry().beamwidth_rad) / 2.0;
    let degrees = number(half.to_degrees(), 1);
    let mut words = words.clone();
    words.legend = vec![
        (
            Swatch::Area(HUES[4], 0.22, Stroke::solid(HUES[4], 1.5)),
            "beam between its 3 dB angles".into(),
        ),
        (Swatch::Mark(Shape::Dot, 5.0, MEASURED), "particles".into()),
        (
            Swatch::Mark(Shape::Triangle, 7.0, MEASURED),
            "outermost particle".into(),
        ),
        (
            Swatch::Mark(Shape::Diamond, 7.0, CONCLUDED),
            format!("edge: less half the beam, d tan {degrees}°"),
        ),
    ];
    if beams.is_empty() {
        words.subtitle.push_str("; no steps");
    }
    let mirror = plane.mirror();
    plane.draw(&words, Background::Cfar, Palette::Ground, |sheet, frame| {
        let mut room = plane.room(frame);
        for beam in beams {
            wedge(sheet, frame, &mut room, (mirror, half), beam)?;
        }
        for cluster in clusters.iter().filter(|c| c.fate == ClusterVerdict::Kept) {
            dots(sheet, frame, &cluster.points, 3.0, (Shape::Dot, MEASURED))?;
            cover_dots(&mut room, frame, &cluster.points);
        }
        for beam in beams {
            correction(sheet, frame, &mut room, beam)?;
        }
        beams
            .iter()
            .try_for_each(|beam| by(sheet, frame, &mut room, beam))
    })
}

/// Draws the beam between its 3 dB angles, with its axis through the cluster's end.
fn wedge(
    sheet: &Sheet<'_>,
    frame: &Frame,
    room: &mut LabelPlacer,
    (from, half): (Point, f64),
    beam: &BeamView,
) -> Result<()> {
    let (dx, dy) = (beam.end.0 - from.0, beam.end.1 - from.1);
    let (reach, angle) = (1.04 * dx.hypot(dy), dy.atan2(dx));
    let at = |angle: f64| frame.spot(from.0 + reach * angle.cos(), from.1 + reach * angle.sin());
    let arc = (-8..=8).map(|k| at(angle + half * f64::from(k) / 8.0));
    let start = frame.spot(from.0, from.1);
    let corners: Vec<Spot> = std::iter::once(start).chain(arc).collect();
    sheet.fill(&corners, HUES[4], 0.16)?;
    let edge = Stroke::solid(HUES[4], 1.6);
    let (sides, middle) = (
        [at(angle - half), start, at(angle + half)],
        [start, at(angle)],
    );
    room.cover_line(&sides);
    room.cover_line(&middle);
    sheet.line(&sides, edge)?;
    sheet.line(&middle, edge.dashed(9.0, 6.0))
}

/// Draws the cluster's end, the reported edge, and a line between them.
fn correction(
    sheet: &Sheet<'_>,
    frame: &Frame,
    room: &mut LabelPlacer,
    beam: &BeamView,
) -> Result<()> {
    let end = frame.spot(beam.end.0, beam.end.1);
    let edge = frame.spot(beam.edge.0, beam.edge.1);
    room.cover_line(&[end, edge]);
    room.cover_mark(end, 11.0);
    room.cover_mark(edge, 11.0);
    sheet.line(&[end, edge], Stroke::solid(INK, 2.2))?;
    sheet.marker(Shape::Triangle, end, 8.0, MEASURED, WHITE)?;
    sheet.marker(Shape::Diamond, edge, 8.0, CONCLUDED, WHITE)
}

/// Writes the correction, and the corrected height or distance, beside the reported edge, cm.
fn by(sheet: &Sheet<'_>, frame: &Frame, room: &mut LabelPlacer, beam: &BeamView) -> Result<()> {
    let (dx, dy) = (beam.edge.0 - beam.end.0, beam.edge.1 - beam.end.1);
    let cm = |v: f64| number(100.0 * v, 1);
    let (by, result) = if dy.abs() > dx.abs() {
        (dy, format!("height {} cm", cm(beam.edge.1)))
    } else {
        (dx, format!("distance {} cm", cm(beam.edge.0)))
    };
    let sign = if by > 0.0 { "+" } else { "" };
    let by = format!("{sign}{} cm", cm(by));
    let face = Face::plain(21.0);
    let lines = [(&by[..], face.bold()), (&result, face.ink(CONCLUDED))];
    room.write(sheet, frame.spot(beam.edge.0, beam.edge.1), &lines)
}
