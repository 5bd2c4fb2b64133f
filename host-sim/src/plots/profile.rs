//! Range profiles: figs. 2 and 9.

use anyhow::Result;
use plotters::style::WHITE;
use stairscan::signal::range::Profile;

use super::colour::{CONCLUDED, HUES, MEASURED, TRUE};
use super::page::{Axis, Frame, Page, Swatch, number};
use super::shape::Shape;
use super::sheet::{FAINT, Face, Sheet, Spot, Stroke};

/// Size of the data's place, pixels.
const SIZE: Spot = (1180.0, 560.0);
/// Decibels shown below the typical power of a profile.
const BELOW_TYPICAL_DB: f64 = 14.0;
/// Distance of two labels, pixels.
const LABELS_APART: f64 = 84.0;

/// One range profile as a picture needs it.
#[derive(Clone, Debug)]
pub struct ProfileView {
    /// The recording and the chirp.
    pub subtitle: String,
    /// From one bin to the next, metres.
    pub bin_m: f64,
    /// Power of each bin, dB relative to full scale.
    pub power_db: Vec<f64>,
    /// CFAR threshold of each bin; `None` where nothing is tested.
    pub threshold_db: Vec<Option<f64>>,
    /// Range and power of the detections.
    pub detections: Vec<(f64, f64)>,
    /// Range of the mirror's own echo; `None` without a mirror.
    pub mirror_m: Option<f64>,
}

impl ProfileView {
    /// The view of a profile with bins `bin_m` apart.
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

    /// First and last tested range.
    fn tested(&self) -> Option<(f64, f64)> {
        let first = self.threshold_db.iter().position(Option::is_some)?;
        let last = self.threshold_db.iter().rposition(Option::is_some)?;
        Some((first as f64 * self.bin_m, last as f64 * self.bin_m))
    }

    /// The highest threshold within the width of a label.
    fn threshold_near(&self, range: f64) -> f64 {
        const REACH_M: f64 = 0.03;
        let near = |k: &usize| (*k as f64 * self.bin_m - range).abs() <= REACH_M;
        let bins = (0..self.threshold_db.len()).filter(near);
        bins.filter_map(|k| self.threshold_db[k])
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Round decibels around what is worth seeing.
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

/// Power over range with what its peaks are (fig. 2).
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
        label_peaks(sheet, frame, view, |_| f64::NEG_INFINITY, 28.0)
    })
}

/// Power over range with the threshold that it must exceed (fig. 9).
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
        let line = |range: f64| view.threshold_near(range);
        label_peaks(sheet, frame, view, line, 22.0)
    })
}

const fn power_stroke() -> Stroke {
    Stroke::solid(MEASURED, 2.2)
}

const fn threshold_stroke() -> Stroke {
    Stroke::solid(HUES[2], 2.2).dashed(10.0, 5.0)
}

fn draw_power(sheet: &Sheet<'_>, frame: &Frame, view: &ProfileView) -> Result<()> {
    let line: Vec<Spot> = (view.power_db.iter().enumerate())
        .map(|(k, &db)| frame.spot(k as f64 * view.bin_m, db))
        .collect();
    sheet.line(&line, power_stroke())
}

/// Shades the ranges in which no target is looked for, and says why.
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
    // What wraps round rises from the lower left.
    let corner = spot((far + end) / 2.0, bottom + 0.85 * (top - bottom));
    sheet.text("wraps round", corner, face)
}

/// Writes the range of each peak above it, the strongest first, where there is room,
/// and above the `line` that is drawn there.
fn label_peaks(
    sheet: &Sheet<'_>,
    frame: &Frame,
    view: &ProfileView,
    line: impl Fn(f64) -> f64,
    above: f64,
) -> Result<()> {
    let mut order = view.detections.clone();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut taken: Vec<Spot> = Vec::new();
    if let Some(mirror) = view.mirror_m {
        let bin = (mirror / view.bin_m).round() as usize;
        let peak = view.power_db.iter().skip(bin.saturating_sub(2)).take(5);
        let peak = peak.copied().fold(f64::NEG_INFINITY, f64::max);
        let spot = frame.spot(mirror, peak.max(frame.y.0));
        let spot = (spot.0, spot.1 - 16.0);
        sheet.text("mirror", spot, Face::plain(20.0).ink(FAINT))?;
        taken.push(spot);
    }
    for (range, db) in order {
        let (x, y) = frame.spot(range, db.max(line(range)));
        let spot = (x, y - above);
        let free = |t: &Spot| (t.0 - x).abs() > LABELS_APART || (t.1 - spot.1).abs() > 26.0;
        if taken.iter().all(free) {
            let text = format!("{} m", number(range, 2));
            sheet.note(&text, spot, Face::plain(21.0).bold())?;
            taken.push(spot);
        }
    }
    Ok(())
}
