//! The guard in `live`: free distance as text and bar, a side view of the last sweep, and a strip of the sweeps before.

use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Position, Rect};
use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Block;
use stairscan::report::GuardLine;
use stairscan::verdict::{HazardKind, Status};

use super::Ms;
use super::guard::{FULL_M, Guard, SweepHistory};
use super::side::{self, Shape};
use crate::answer::metres;

/// Width of the strip over time, characters: one for each sweep, and those of frame and labels.
pub const STRIP: u16 = 43;
/// Width of the strip's labels, characters.
const LABELS: u16 = 4;
/// Size with which a hazard is drawn, cm: a sweep does not measure it.
const SIZE: f64 = 12.0;
/// Length that is drawn behind the free distance, cm.
const BEHIND: f64 = 30.0;
/// Distance between the marks of ground that is not known, cm.
const UNKNOWN: f64 = 6.0;
/// Parts of a cell of the strip, from empty to full.
const EIGHTHS: [&str; 9] = [" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"];

/// Returns the colour of a sweep; grey once it is stale.
fn colour(status: Status, fresh: bool) -> Color {
    match status {
        _ if !fresh => Color::DarkGray,
        Status::Ok => Color::Cyan,
        Status::Degraded => Color::Yellow,
        Status::Fault => Color::Red,
    }
}

/// Returns the two lines with the free distance of the last sweep against the watch distance, and its details.
pub fn lines(guard: &Guard, now: Ms) -> [Line<'static>; 2] {
    let status = guard.line.status;
    let style = Style::new().fg(colour(status, guard.is_fresh(now)));
    [
        format!(" {} {}", guard.bar(), guard.distances()),
        format!(" Guard: {}, {}", status.as_str(), guard.details()),
    ]
    .map(|text| Line::styled(text, style))
}

/// Draws side view and strip; grey if the last sweep is not `fresh`. Without `guard` the scanner has restarted.
pub fn draw(
    frame: &mut Frame<'_>,
    area: Rect,
    guard: Option<&Guard>,
    history: &SweepHistory,
    fresh: bool,
) {
    let [view, strip] =
        Layout::horizontal([Constraint::Min(29), Constraint::Length(STRIP)]).areas(area);
    let hazard = match guard.map(|guard| (guard.line.status, guard.line.hazard)) {
        None => "restarted",
        Some((Status::Fault, _)) => "fault",
        Some((_, HazardKind::None)) => "no hazard",
        Some((_, hazard)) => hazard.as_str(),
    };
    let title = format!(" Last sweep: : free, {hazard} ");
    let shape = guard.map(|guard| shape(&guard.line)).unwrap_or_default();
    side::draw_shape(frame, view, &shape, (&title, fresh));
    draw_strip(frame, strip, history, fresh);
}

/// Returns the side view of a sweep: ground up to the free distance, `:` there, and the hazard, whose size is not
/// measured; `?` where the ground is not known. Empty without a free distance.
fn shape(line: &GuardLine) -> Shape {
    let Some(free) = line.free else {
        return Shape::default();
    };
    let x = 100.0 * metres(free).max(0.0);
    let end = x + BEHIND;
    let behind = match line.hazard {
        HazardKind::None => vec![(end, 0.0)],
        HazardKind::Rise => vec![(x, SIZE), (end, SIZE)],
        HazardKind::Drop => vec![(x, -SIZE), (end, -SIZE)],
        HazardKind::Obstacle => vec![
            (x, 2.0 * SIZE),
            (x + SIZE, 2.0 * SIZE),
            (x + SIZE, 0.0),
            (end, 0.0),
        ],
        HazardKind::Unknown => Vec::new(),
    };
    let unknown = (1..)
        .map(|k| (x + UNKNOWN * f64::from(k), 0.0))
        .take_while(|mark| line.hazard == HazardKind::Unknown && mark.0 <= end);
    Shape {
        maybes: unknown.collect(),
        outline: [(0.0, 0.0), (x, 0.0)].into_iter().chain(behind).collect(),
        horizon: (x > 0.0).then_some(x),
        ..Shape::default()
    }
}

/// Draws the strip: a column for each of the last sweeps, the newest at the right, as high as it is free, coloured by
/// status; `x` for a fault, a gap for a pause, a dotted line at the watch distance.
fn draw_strip(frame: &mut Frame<'_>, area: Rect, history: &SweepHistory, fresh: bool) {
    let legend = [
        (" Sweeps, free m: ", Color::Reset),
        ("ok ", colour(Status::Ok, fresh)),
        ("degraded ", colour(Status::Degraded, fresh)),
        ("x fault ", colour(Status::Fault, fresh)),
    ];
    let title = Line::from_iter(legend.map(|(text, fg)| Span::styled(text, Style::new().fg(fg))));
    let block = Block::bordered().title(title);
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let plot = Rect {
        x: inner.x + LABELS,
        width: inner.width.saturating_sub(LABELS),
        ..inner
    };
    if plot.is_empty() {
        return;
    }
    let buffer = frame.buffer_mut();
    let watch = row(plot, history.watch_m());
    for (m, y) in [
        (FULL_M, plot.top()),
        (0.0, plot.bottom() - 1),
        (history.watch_m(), watch),
    ] {
        buffer.set_string(inner.x, y, format!("{m:.1}"), Style::new().fg(Color::Gray));
    }
    for x in plot.left()..plot.right() {
        buffer.set_string(x, watch, "┄", Style::new().fg(Color::Gray));
    }
    let columns = (plot.left()..plot.right()).rev();
    for (x, sweep) in columns.zip(history.sweeps.iter().rev()) {
        if let Some(line) = sweep {
            draw_column(buffer, plot, x, line, fresh);
        }
    }
}

/// Returns the row of the strip in which the distance `m` (metres) is.
fn row(plot: Rect, m: f64) -> u16 {
    let up = (m / FULL_M).clamp(0.0, 1.0) * f64::from(plot.height);
    let up = (up.ceil() as u16).max(1) - 1;
    plot.bottom() - 1 - up.min(plot.height - 1)
}

/// Draws the sweep `line` as the column `x`, from the bottom.
fn draw_column(buffer: &mut Buffer, plot: Rect, x: u16, line: &GuardLine, fresh: bool) {
    let style = Style::new().fg(colour(line.status, fresh));
    let Some(free) = line.free.filter(|_| line.status != Status::Fault) else {
        buffer.set_string(x, plot.bottom() - 1, "x", style);
        return;
    };
    let share = (metres(free) / FULL_M).clamp(0.0, 1.0);
    // At least one eighth, so that every sweep is seen.
    let mut left = ((share * 8.0 * f64::from(plot.height)).round() as usize).max(1);
    for y in (plot.top()..plot.bottom()).rev() {
        let part = left.min(8);
        if part > 0
            && let Some(cell) = buffer.cell_mut(Position::new(x, y))
        {
            cell.set_symbol(EIGHTHS[part]).set_style(style);
        }
        left -= part;
    }
}
