//! One drawing for each test body: the shares of scenes in which scan and guard detect it, and in which they report
//! free ground beyond it, over distance, yaw, pitch, window and ground, and over size where the body has one.

use crate::hardware::sheet::{Anchor, FAINT, INK, Place, Sheet};
use host_sim::score::Share;

use super::body::Body;
use super::plan::{Series, sizes};
use super::results::Measured;
use super::tally::{Counts, Tally, lower, upper};

/// Size (width, height) of a panel with its margins, and the margins (left, top, right, bottom), pixels.
const PANEL: [f64; 2] = [380.0, 250.0];
const MARGIN: [f64; 4] = [52.0, 34.0, 14.0, 44.0];
/// Height of the legend, pixels.
const LEGEND: f64 = 34.0;
/// Number of panels beside each other.
const ACROSS: usize = 3;
/// Colours of scan and guard, distinguishable with red-green colour blindness (Okabe and Ito).
const COLOURS: [&str; 2] = ["#0072b2", "#d55e00"];
/// Half width of a mark, and offset of the marks of scan and guard from the middle of their column,
/// pixels.
const MARK: f64 = 4.0;
const ASIDE: f64 = 6.0;

/// One panel of a drawing: its title, and the counts for each value on its horizontal axis.
struct Panel {
    title: String,
    values: Vec<(String, Tally)>,
}

/// Returns the drawing of a body, all its panels, as SVG text.
pub fn of(measured: &Measured, body: Body) -> String {
    sheet_of(&panels(measured, body)).svg()
}

fn panels(measured: &Measured, body: Body) -> Vec<Panel> {
    let series = [
        (Series::Distance, "distance"),
        (Series::Yaw, "yaw"),
        (Series::Pitch, "pitch, nose up positive"),
        (Series::Window, "loss of the window"),
        (Series::Ground, "ground"),
    ];
    let line = |(series, title): (Series, &str)| Panel {
        title: title.into(),
        values: measured.line(series, body),
    };
    let same = sizes().filter(|size| size.kind() == body.kind());
    let values = same.filter_map(|size| {
        let cm = size.name().split(' ').nth(2)?.to_owned();
        Some((cm, measured.size(size, 0.0)?.clone()))
    });
    let size = Panel {
        title: "size, cm".into(),
        values: values.collect(),
    };
    let all = series.into_iter().map(line).chain([size]);
    all.filter(|panel| !panel.values.is_empty()).collect()
}

fn sheet_of(panels: &[Panel]) -> Sheet {
    let rows = panels.len().div_ceil(ACROSS).max(1);
    let width = PANEL[0] * ACROSS as f64;
    let mut sheet = Sheet::new(width, LEGEND + PANEL[1] * rows as f64);
    legend(&mut sheet);
    for (k, panel) in panels.iter().enumerate() {
        let corner = (
            PANEL[0] * (k % ACROSS) as f64,
            LEGEND + PANEL[1] * (k / ACROSS) as f64,
        );
        draw(&mut sheet, corner, panel);
    }
    sheet
}

/// Returns the plot area of the panel whose top left is at `corner`: left, top, right, bottom, pixels.
fn area(corner: Place) -> [f64; 4] {
    let [left, top, right, bottom] = MARGIN;
    [
        corner.0 + left,
        corner.1 + top,
        corner.0 + PANEL[0] - right,
        corner.1 + PANEL[1] - bottom,
    ]
}

fn draw(sheet: &mut Sheet, corner: Place, panel: &Panel) {
    let [left, top, right, bottom] = area(corner);
    sheet.text((left, top - 12.0), Anchor::Start, 14.0, INK, &panel.title);
    let height = |share: f64| bottom - (bottom - top) * share;
    for quarter in 0..=4 {
        let y = height(0.25 * f64::from(quarter));
        sheet.line((left, y), (right, y), "#d8dce2");
        let percent = format!("{} %", 25 * quarter);
        sheet.text((left - 6.0, y + 4.0), Anchor::End, 12.0, FAINT, &percent);
    }
    let column = (right - left) / panel.values.len() as f64;
    let middle = |k: usize| left + column * (k as f64 + 0.5);
    for (k, (value, _)) in panel.values.iter().enumerate() {
        let place = (middle(k), bottom + 18.0);
        sheet.text(place, Anchor::Middle, 11.0, FAINT, value);
    }
    let counts: [fn(&Tally) -> &Counts; 2] = [|t| &t.scan, |t| &t.guard];
    for (channel, (counts, colour)) in counts.into_iter().zip(COLOURS).enumerate() {
        let aside = ASIDE * (2.0 * channel as f64 - 1.0);
        let at = |k: usize, share: Share| share.value().map(|p| (middle(k) + aside, height(p)));
        let values = panel.values.iter().enumerate();
        let line: Vec<Place> = values
            .clone()
            .filter_map(|(k, (_, t))| at(k, counts(t).detected))
            .collect();
        sheet.path(
            &line,
            &format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\" opacity=\"0.5\""),
        );
        for (k, (_, tally)) in values {
            let (detected, beyond) = (counts(tally).detected, counts(tally).free_beyond_body);
            if let Some(place) = at(k, detected) {
                sheet.line((place.0, height(lower(detected))), place, colour);
                mark(sheet, channel, place, colour);
            }
            if let Some(place) = at(k, beyond) {
                sheet.dashed((place.0, height(upper(beyond))), place, colour);
                cross(sheet, place, colour);
            }
        }
    }
}

/// Draws a dot for the scan (channel 0) or a square for the guard (channel 1), centred on (x, y).
fn mark(sheet: &mut Sheet, channel: usize, (x, y): Place, colour: &str) {
    match channel {
        0 => sheet.ellipse((x, y), (MARK, MARK), colour),
        _ => sheet.rect((x - MARK, y - MARK), (2.0 * MARK, 2.0 * MARK), colour),
    }
}

/// Draws a cross centred on (x, y): the mark of answers that are `ok` with free ground beyond the body.
fn cross(sheet: &mut Sheet, (x, y): Place, colour: &str) {
    let style = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"");
    for side in [-1.0, 1.0] {
        let ends = [(x - MARK, y - side * MARK), (x + MARK, y + side * MARK)];
        sheet.path(&ends, &style);
    }
}

fn legend(sheet: &mut Sheet) {
    let names = ["scan", "guard"];
    for (channel, (name, colour)) in names.into_iter().zip(COLOURS).enumerate() {
        let x = MARGIN[0] + 520.0 * channel as f64;
        mark(sheet, channel, (x, 16.0), colour);
        let words = format!("{name} detects, with lower bound");
        sheet.text((x + 10.0, 20.0), Anchor::Start, 12.0, INK, &words);
        cross(sheet, (x + 240.0, 16.0), colour);
        let words = format!("{name} `ok` and free beyond").replace('`', "");
        sheet.text((x + 250.0, 20.0), Anchor::Start, 12.0, INK, &words);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capability::plan::cells;
    use crate::capability::results::{Heading, Times};
    use host_sim::seeds::Draw;

    #[test]
    fn every_body_has_a_drawing_whose_words_do_not_overlap() {
        let times = Times {
            scan_s: 0.8,
            sweep_s: 0.1,
        };
        let measured = Measured {
            head: Heading {
                command: String::new(),
                draw: Draw::Tuning,
                times,
            },
            cells: cells(4, 4)
                .into_iter()
                .map(|cell| (cell, Tally::default()))
                .collect(),
            second: None,
        };
        for body in Body::STANDARD {
            let panels = panels(&measured, body);
            let sized = matches!(body, Body::Rise(_) | Body::Drop(_));
            assert_eq!(panels.len(), 5 + usize::from(sized));
            assert_eq!(
                sheet_of(&panels).overlaps(),
                Vec::<String>::new(),
                "{body:?}"
            );
        }
    }
}
