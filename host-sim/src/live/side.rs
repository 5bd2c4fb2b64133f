//! The side view of `live`: the reported staircase with ±2σ of each step, the drop edge, and the horizon.

use ratatui::Frame;
use ratatui::layout::{Constraint, Rect};
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::text::Span;
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType};

use crate::answer::{Answer, metres, nearest_m};

/// Length of the tread drawn behind the last step's edge, cm.
const BEHIND: f64 = 30.0;
/// Minimum width of the side view, cm: more than the 1 m that an `ok` answer is valid up to.
const MIN_SPAN_CM: f64 = 120.0;
/// Distance between the marks of each axis, cm.
const MARK: f64 = 50.0;

/// Points (distance, height) of one element of the drawing, cm.
type Points = Vec<(f64, f64)>;

/// Elements of the side view of an answer, all in cm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Outline of ground, risers and treads as one line through these points, from left to right.
    pub outline: Points,
    /// Bars of ±2σ of distance and height, from end to end: for each step a horizontal and then a vertical one.
    pub bars: Vec<[(f64, f64); 2]>,
    /// Distances of a reported drop from the mirror, cm: nearest place (-3σ), edge, farthest place (+3σ).
    pub drop: Option<[f64; 3]>,
    /// Edges of the `MAYBE`s (possible steps), cm: distance, and height above the ground.
    pub maybes: Points,
    /// Horizon: distance from the mirror up to which the answer is valid, cm; `None` if it has none or it is 0.
    pub horizon: Option<f64>,
}

impl Shape {
    /// Returns the side view of an answer; empty for a fault.
    pub fn of(answer: &Answer) -> Self {
        if answer.is_fault() {
            return Self::default();
        }
        let mut outline = vec![(0.0, 0.0)];
        let mut bars = Vec::new();
        let mut level = 0.0;
        let mut end: f64 = MIN_SPAN_CM - BEHIND;
        for step in &answer.steps {
            let [x, y, sx, sy] = [
                step.distance,
                step.height,
                step.distance_sigma,
                step.height_sigma,
            ]
            .map(|length| 100.0 * metres(length));
            outline.extend([(x, level), (x, y)]);
            bars.push([(x - 2.0 * sx, y), (x + 2.0 * sx, y)]);
            bars.push([(x, y - 2.0 * sy), (x, y + 2.0 * sy)]);
            (level, end) = (y, end.max(x));
        }
        let horizon = answer.horizon_m.map(|m| 100.0 * m).filter(|h| *h > 0.0);
        let maybes = answer.maybes.iter();
        let maybes = maybes.map(|m| (100.0 * metres(m.distance), 100.0 * metres(m.height)));
        let maybes: Points = maybes.collect();
        let drop = answer.drop.as_ref().map(|drop| {
            let (edge, near) = (100.0 * metres(drop.distance), 100.0 * nearest_m(drop));
            [near, edge, 2.0 * edge - near]
        });
        let farthest = maybes
            .iter()
            .map(|m| m.0)
            .chain(horizon)
            .chain(drop.map(|band| band[2]))
            .fold(end, f64::max);
        outline.push((farthest + BEHIND, level));
        Self {
            outline,
            bars,
            drop,
            maybes,
            horizon,
        }
    }

    /// Returns minimum and maximum of the distance and of the height shown, rounded outwards to marks of the axes,
    /// cm.
    fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        let bars = self.bars.iter().flatten();
        let all = self.outline.iter().chain(bars).chain(&self.maybes);
        let (mut x, mut y) = ([0.0, MIN_SPAN_CM], [0.0_f64, MARK]);
        for &(along, up) in all {
            x = [along.min(x[0]), along.max(x[1])];
            y = [up.min(y[0]), up.max(y[1])];
        }
        let wide =
            |[low, high]: [f64; 2]| [MARK * (low / MARK).floor(), MARK * (high / MARK).ceil()];
        (wide(x), wide(y))
    }
}

/// Colours of the side view's elements; grey if the answer is stale.
struct Colours {
    outline: Color,
    bars: Color,
    horizon: Color,
    drop: Color,
    maybes: Color,
}

/// Draws the side view of `answer` into `area`; grey if the answer is not `fresh`.
pub fn draw(frame: &mut Frame<'_>, area: Rect, answer: Option<&Answer>, fresh: bool) {
    let shape = answer.map(Shape::of).unwrap_or_default();
    let title = match shape.drop {
        None => " Side view: steps, + their ±2σ, : horizon, ? maybe ",
        Some(_) => " Side view: + ±2σ, : horizon, | drop, = ±3σ, ? maybe ",
    };
    draw_shape(frame, area, &shape, (title, fresh));
}

/// Draws `shape` into `area` under a title; grey if it is not `fresh`.
pub fn draw_shape(frame: &mut Frame<'_>, area: Rect, shape: &Shape, (title, fresh): (&str, bool)) {
    let colour = |c: Color| if fresh { c } else { Color::DarkGray };
    let colours = Colours {
        outline: colour(Color::White),
        bars: colour(Color::Yellow),
        horizon: colour(Color::Cyan),
        drop: colour(Color::Red),
        maybes: colour(Color::Magenta),
    };
    let (x, y) = shape.bounds();
    let horizon = upright(shape.horizon, y);
    let drop = upright(shape.drop.map(|band| band[1]), y);
    let band: Points = (shape.drop.iter())
        .flat_map(|band| [(band[0], 0.0), (band[2], 0.0)])
        .collect();
    let sets = datasets(shape, (&horizon, &drop, &band), &colours);
    let axis = |bounds: [f64; 2], title: &'static str| {
        Axis::default()
            .title(title)
            .bounds(bounds)
            .labels(
                marks(bounds)
                    .map(|v| Span::raw(label(v)))
                    .collect::<Vec<_>>(),
            )
            .style(Style::new().fg(Color::Gray))
    };
    let chart = Chart::new(sets)
        .block(Block::bordered().title(title))
        // An empty label reserves the row.
        .x_axis(axis(x, "from mirror, cm").labels(["", ""]))
        .y_axis(axis(y, "height, cm"))
        .legend_position(None)
        .hidden_legend_constraints((Constraint::Length(0), Constraint::Length(0)));
    frame.render_widget(chart, area);
    let inner = Block::bordered().inner(area);
    let widest = marks(y).map(|v| label(v).len()).max().unwrap_or(0) as u16;
    // Layout of the chart, from left to right: labels of the height (at most a third of the width), the axis, the
    // graph.
    let graph = inner.x + widest.min(inner.width / 3) + 1;
    x_labels(frame, Rect { x: graph, ..inner }, inner.right(), x);
}

/// Returns the values at an axis' marks, cm.
fn marks([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    let count = ((high - low) / MARK).round() as usize;
    (0..=count).map(move |k| low + MARK * k as f64)
}

fn label(value: f64) -> String {
    format!("{value:.0}")
}

/// Writes each label of the x axis centred below its value, if it does not overlap the previous label. The chart
/// itself would distribute them evenly over the width, up to 15 % away from their values.
fn x_labels(frame: &mut Frame<'_>, graph: Rect, right: u16, x: [f64; 2]) {
    let Some(width) = right.checked_sub(graph.x + 1) else {
        return;
    };
    let style = Style::new().fg(Color::Gray);
    let mut free = graph.x.saturating_sub(1);
    for value in marks(x) {
        let text = label(value);
        let column = (value - x[0]) / (x[1] - x[0]) * f64::from(width);
        let size = text.len() as u16;
        let centred = (graph.x + column.round() as u16).saturating_sub(size / 2);
        let start = centred.min(right.saturating_sub(size));
        if start >= free {
            let row = graph.bottom().saturating_sub(1);
            frame.buffer_mut().set_string(start, row, &text, style);
            free = start + size + 1;
        }
    }
}

/// Returns the points of a dotted vertical line at the distance `at` over the whole height; none for `None`.
fn upright(at: Option<f64>, [low, high]: [f64; 2]) -> Points {
    let dots = |x: f64| (0..=30).map(move |k| (x, low + (high - low) * f64::from(k) / 30.0));
    at.into_iter().flat_map(dots).collect()
}

fn datasets<'a>(
    shape: &'a Shape,
    (horizon, drop, band): (&'a Points, &'a Points, &'a Points),
    colours: &Colours,
) -> Vec<Dataset<'a>> {
    let line = |data: &'a [(f64, f64)], colour, marker| {
        let set = Dataset::default().data(data).marker(marker);
        set.graph_type(GraphType::Line)
            .style(Style::new().fg(colour))
    };
    let dots = |data: &'a [(f64, f64)], colour, marker| {
        let set = Dataset::default().data(data).marker(marker);
        set.graph_type(GraphType::Scatter)
            .style(Style::new().fg(colour))
    };
    let mut sets = vec![
        dots(horizon, colours.horizon, Marker::Custom(':')),
        line(&shape.outline, colours.outline, Marker::Braille),
    ];
    let bars = shape.bars.iter();
    sets.extend(bars.map(|bar| line(bar, colours.bars, Marker::Custom('+'))));
    sets.push(line(band, colours.drop, Marker::Custom('=')));
    sets.push(dots(drop, colours.drop, Marker::Custom('|')));
    sets.push(dots(&shape.maybes, colours.maybes, Marker::Custom('?')));
    sets
}
