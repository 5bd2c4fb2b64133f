//! Plots of range profiles: figs. 2 and 9.

use anyhow::Result;
use plotters::style::WHITE;
use stairscan::signal::range::Profile;

use super::colour::{CONCLUDED, HUES, MEASURED, TRUE};
use super::page::{Axis, Frame, Page, Swatch, number};
use super::room::{self, LabelPlacer};
use super::shape::Shape;
use super::sheet::{FAINT, Face, Sheet, Spot, Stroke};

/// Width and height of the area of the data, pixels.
const SIZE: Spot = (1180.0, 560.0);
/// Range of the power axis below the lower quartile of the profile's power over its bins, dB.
const BELOW_TYPICAL_DB: f64 = 14.0;
/// Maximum distance from a peak to its label, pixels.
const LABEL_REACH: f64 = 60.0;
/// Text style of a peak's label.
const LABEL: Face = Face::plain(21.0).bold();

/// One range profile with the data of its plot.
#[derive(Clone, Debug)]
pub struct ProfileView {
    /// Subtitle of the plot: recording and chirp.
    pub subtitle: String,
    /// Spacing of the range bins, metres.
    pub bin_m: f64,
    /// Power of each range bin, dB relative to full scale.
    pub power_db: Vec<f64>,
    /// CFAR threshold of each bin, dB relative to full scale; `None` where no test is made.
    pub threshold_db: Vec<Option<f64>>,
    /// Range, metres, and power, dB relative to full scale, of each detection.
    pub detections: Vec<(f64, f64)>,
    /// Range of the mirror's own echo from the radar, metres; `None` without a mirror.
    pub mirror_m: Option<f64>,
}

impl ProfileView {
    /// Creates the view of a range profile whose bins are `bin_m` metres apart. `mirror_m` is the range of the mirror's
    /// own echo.
    pub fn new(subtitle: String, profile: &Profile, bin_m: f64, mirror_m: Option<f64>) -> Self {
        let bins = 0..profile.bins();
        Self {
            subtitle,
            bin_m,
            power_db: bins.clone().map(|k| profile.power_db(k).into()).collect(),
            threshold_db: bins
                .map(|k| profile.threshold_db(k).map(f64::from))
                .collect(),
            detections: (profile.detections())
                .map(|d| (f64::from(d.bin) * bin_m, f64::from(d.power_db)))
                .collect(),
            mirror_m: mirror_m.filter(|&m| m > 0.0),
        }
    }

    /// Returns the first and the last range that CFAR tests, metres; `None` if it tests none.
    fn tested(&self) -> Option<(f64, f64)> {
        let first = self.threshold_db.iter().position(Option::is_some)?;
        let last = self.threshold_db.iter().rposition(Option::is_some)?;
        Some((first as f64 * self.bin_m, last as f64 * self.bin_m))
    }

    /// Returns minimum and maximum of the power axis, rounded, dB relative to full scale.
    fn span_db(&self) -> (f64, f64) {
        let mut sorted = self.power_db.clone();
        sorted.sort_by(f64::total_cmp);
        let typical = sorted.get(sorted.len() / 4).copied().unwrap_or(-90.0);
        let highest = sorted.last().copied().unwrap_or(0.0);
        let low = ((typical - BELOW_TYPICAL_DB) / 10.0).floor() * 10.0;
        let high = ((highest + 6.0) / 5.0).ceil() * 5.0;
        (low, high.max(low + 20.0))
    }

    fn page(&self, title: &str) -> Page {
        let far = self.bin_m * self.power_db.len() as f64;
        Page {
            title: title.into(),
            subtitle: self.subtitle.clone(),
            x: Axis::new("range from the radar [m]", (0.0, far)),
            y: Axis::new("power [dB of full scale]", self.span_db()),
            legend: Vec::new(),
            bar: None,
            grid: true,
        }
    }
}

/// Draws a profile's power over range, with its detections marked (fig. 2).
pub fn peaks(view: &ProfileView) -> Result<Vec<u8>> {
    let mut page = view.page("Range profile");
    page.legend = vec![
        (Swatch::Line(power_stroke()), "power".into()),
        (Swatch::Mark(Shape::Fall, 6.0, HUES[1]), "target".into()),
    ];
    page.draw(SIZE, |sheet, frame| {
        draw_untested(sheet, frame, view)?;
        draw_power(sheet, frame, view)?;
        for &(range, db) in &view.detections {
            let (x, y) = frame.spot(range, db);
            sheet.marker(Shape::Fall, (x, y - 11.0), 6.0, CONCLUDED, WHITE)?;
        }
        label_peaks(sheet, frame, view, LabelPlacer::new(frame))
    })
}

/// Draws a profile's power over range, with the CFAR threshold and the detections (fig. 9).
pub fn threshold(view: &ProfileView) -> Result<Vec<u8>> {
    let mut page = view.page("Range profile with its CFAR threshold");
    page.legend = vec![
        (Swatch::Line(power_stroke()), "power".into()),
        (Swatch::Line(threshold_stroke()), "CFAR threshold".into()),
        (Swatch::Mark(Shape::Dot, 6.5, CONCLUDED), "detection".into()),
    ];
    page.draw(SIZE, |sheet, frame| {
        draw_untested(sheet, frame, view)?;
        draw_power(sheet, frame, view)?;
        let line: Vec<Spot> = (view.threshold_db.iter().enumerate())
            .filter_map(|(k, db)| db.map(|db| frame.spot(k as f64 * view.bin_m, db)))
            .collect();
        sheet.line(&line, threshold_stroke())?;
        for &(range, db) in &view.detections {
            sheet.marker(Shape::Dot, frame.spot(range, db), 6.5, CONCLUDED, WHITE)?;
        }
        let mut room = LabelPlacer::new(frame);
        room.cover_line(&line);
        label_peaks(sheet, frame, view, room)
    })
}

const fn power_stroke() -> Stroke {
    Stroke::solid(MEASURED, 2.2)
}

const fn threshold_stroke() -> Stroke {
    Stroke::solid(HUES[2], 2.2).dashed(10.0, 5.0)
}

fn draw_power(sheet: &Sheet<'_>, frame: &Frame, view: &ProfileView) -> Result<()> {
    sheet.line(&power_line(frame, view), power_stroke())
}

fn power_line(frame: &Frame, view: &ProfileView) -> Vec<Spot> {
    let bins = view.power_db.iter().enumerate();
    bins.map(|(k, &db)| frame.spot(k as f64 * view.bin_m, db))
        .collect()
}

/// Shades the ranges that CFAR does not test, and writes the reasons there.
fn draw_untested(sheet: &Sheet<'_>, frame: &Frame, view: &ProfileView) -> Result<()> {
    let Some((near, far)) = view.tested() else {
        return Ok(());
    };
    let (bottom, top) = frame.y;
    let spot = |x: f64, y: f64| frame.spot(x, y);
    let end = frame.x.1;
    for (from, to) in [(0.0, near), (far, end)] {
        sheet.fill_box(spot(from, top), spot(to, bottom), TRUE, 0.16)?;
    }
    let face = Face::plain(20.0).ink(FAINT).upright();
    let across = |x: f64| spot(x, (top + bottom) / 2.0);
    if view.mirror_m.is_some_and(|m| m < near) {
        sheet.text("radar and mirror: not tested", across(near - 0.05), face)?;
    } else {
        sheet.text("radar itself: not tested", across(near / 2.0), face)?;
    }
    // Aliased echoes rise from the lower left.
    let corner = spot((far + end) / 2.0, bottom + 0.85 * (top - bottom));
    sheet.text("aliased", corner, face)
}

/// Writes the range of each peak beside it, the strongest first, if there is room beside all lines.
fn label_peaks(
    sheet: &Sheet<'_>,
    frame: &Frame,
    view: &ProfileView,
    mut room: LabelPlacer,
) -> Result<()> {
    room.cover_line(&power_line(frame, view));
    // Texts in the untested ranges stand along their edges.
    if let Some((near, far)) = view.tested() {
        let spot = |x: f64, y: f64| frame.spot(x, y);
        room.cover(spot(frame.x.0, frame.y.1), spot(near, frame.y.0));
        room.cover(spot(far, frame.y.1), spot(frame.x.1, frame.y.0));
    }
    for &(range, db) in &view.detections {
        let (x, y) = frame.spot(range, db);
        room.cover((x - 8.0, y - 20.0), (x + 8.0, y + 8.0));
    }
    if let Some(mirror) = view.mirror_m {
        let bin = (mirror / view.bin_m).round() as usize;
        let peak = view.power_db.iter().skip(bin.saturating_sub(2)).take(5);
        let peak = peak.copied().fold(f64::NEG_INFINITY, f64::max);
        let spot = frame.spot(mirror, peak.max(frame.y.0));
        let spot = (spot.0, spot.1 - 16.0);
        sheet.text("mirror", spot, Face::plain(20.0).ink(FAINT))?;
        room.cover(
            (spot.0 - 34.0, spot.1 - 12.0),
            (spot.0 + 34.0, spot.1 + 12.0),
        );
    }
    for (text, spot) in peak_labels(frame, view, &mut room) {
        sheet.note(&text, spot, LABEL.left())?;
    }
    Ok(())
}

/// Returns text and place of the peaks' labels, the strongest peak first. The place is the text's left end at half
/// its height.
fn peak_labels(frame: &Frame, view: &ProfileView, room: &mut LabelPlacer) -> Vec<(String, Spot)> {
    let mut order = view.detections.clone();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut labels = Vec::new();
    for (range, db) in order {
        let text = format!("{} m", number(range, 2));
        let size = room::extent(&[(&text, LABEL)]);
        let (at, covered) = room.find(frame.spot(range, db), size, LABEL_REACH);
        if covered == 0 {
            room.cover(at, (at.0 + size.0, at.1 + size.1));
            labels.push((text, (at.0, at.1 + size.1 / 2.0)));
        }
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Threshold and power of a profile with two targets remain visible beside their labels.
    #[test]
    fn no_label_covers_a_line() {
        let power_db: Vec<f64> = (0..200)
            .map(|k| match k {
                60 | 80 => -30.0,
                59 | 61 | 79 | 81 => -50.0,
                _ => -80.0 + f64::from(k % 7),
            })
            .collect();
        let threshold = |k: i32| match k {
            50..=57 | 63..=77 | 83..=90 => -28.0,
            _ => -60.0,
        };
        let view = ProfileView {
            subtitle: String::new(),
            bin_m: 0.015,
            power_db,
            threshold_db: (0..200).map(|k| Some(threshold(k))).collect(),
            detections: vec![(0.9, -30.0), (1.2, -30.0)],
            mirror_m: None,
        };
        let (_, frame) = view.page("").layout(SIZE);
        let line: Vec<Spot> = (view.threshold_db.iter().enumerate())
            .filter_map(|(k, db)| db.map(|db| frame.spot(k as f64 * view.bin_m, db)))
            .collect();
        let mut room = LabelPlacer::new(&frame);
        room.cover_line(&line);
        room.cover_line(&power_line(&frame, &view));
        let labels = peak_labels(&frame, &view, &mut room);
        assert_eq!(labels.len(), 2);
        for (text, at) in &labels {
            let (width, height) = room::extent(&[(text, LABEL)]);
            let inside = |s: &Spot| {
                (at.0..=at.0 + width).contains(&s.0) && (s.1 - at.1).abs() <= height / 2.0
            };
            // Lines are straight from point to point; their steep parts are tested too.
            let fine = line.windows(2).flat_map(|pair| {
                let at = |k: i32, a: f64, b: f64| a + f64::from(k) / 50.0 * (b - a);
                (0..=50).map(move |k| (at(k, pair[0].0, pair[1].0), at(k, pair[0].1, pair[1].1)))
            });
            assert!(!fine.into_iter().any(|s| inside(&s)), "{text}");
        }
    }
}
