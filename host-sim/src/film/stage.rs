//! Layout and timing of the animated drawing of a recording.

use plotters::style::RGBColor;
use stairscan::report::DropLine;
use svg::node::element::{
    Animate, AnimateTransform, Circle, Group, Line, Path, Polygon, Rectangle, Text, Title,
};
use svg::{Document, Node};

use super::shots::{Echo, Film, Shot};
use crate::answer::{metres, nearest_m};
use crate::html::tenths as number;
use crate::plots::colour::{self, MEASURED};
use crate::plots::{steps, surface};
use crate::views::{Point, true_edges};

/// Scale of the drawing, pixels per metre.
const SCALE: f64 = 300.0;
/// Height of the text area at the top, pixels.
const HEAD: f64 = 118.0;
/// Visible length behind the mirror at the first scan, and visible height above the ground, metres.
const BEHIND_M: f64 = 0.85;
const ABOVE_M: f64 = 1.0;
/// Visible length beyond the last step, and visible depth below the lowest ground, metres.
const BEYOND_M: f64 = 0.55;
const BELOW_M: f64 = 0.12;
/// Drawn length of the beam, metres, and its half width, degrees.
const BEAM_M: f64 = 1.9;
const BEAM_DEG: f64 = 2.5;
/// Durations of a scan, of the display of its answer, and of the drive to the next place, seconds.
/// They are longer than in reality, so that they can be followed.
const SWEEP_S: f64 = 1.8;
const READ_S: f64 = 1.7;
const DRIVE_S: f64 = 0.8;
/// Additional time for which the last answer is displayed, seconds.
const REST_S: f64 = 2.0;
/// Duration of the fading in or out of a drawn element, seconds.
const FADE_S: f64 = 0.15;
/// Number of groups into which a scan's echoes are divided; the echoes of a group appear together.
const GROUPS: usize = 16;
/// Maximum number of steps that are described, side by side, and width of the column of each,
/// pixels.
const COLUMNS: usize = 3;
const COLUMN: f64 = 270.0;
/// Minimum signal-to-noise ratio of an echo that is drawn opaque, dB.
const STRONG_DB: f64 = 40.0;

const INK: &str = "#1d2430";
const FAINT: &str = "#6b7280";
const SOLID: &str = "#d6d9de";

/// Visible area of the animation, and the times of its scans.
pub(super) struct Stage {
    /// Visible area, metres: minimum and maximum x (horizontal, from the mirror at the first scan),
    /// and minimum and maximum height above the ground.
    x_m: (f64, f64),
    y_m: (f64, f64),
    /// Time at which each scan's part of the animation begins, and time of the end of the
    /// animation, seconds.
    begins_s: Vec<f64>,
    ends_s: f64,
    /// Height of the mirror above the ground, metres.
    mirror_m: f64,
}

fn hex(colour: RGBColor) -> String {
    format!("#{:02x}{:02x}{:02x}", colour.0, colour.1, colour.2)
}

impl Stage {
    pub(super) fn of(film: &Film) -> Self {
        let edges = film.truth.iter().flat_map(true_edges);
        let answers = film.shots.iter().flat_map(|shot| {
            let place = |s: &stairscan::report::StepLine| {
                (shot.travel_m + metres(s.distance), metres(s.height))
            };
            let drop = shot.answer.drop.iter();
            let drop = drop.map(|d| (shot.travel_m + metres(d.distance), 0.0));
            shot.answer.steps.iter().map(place).chain(drop)
        });
        let points: Vec<Point> = edges.chain(answers).collect();
        let span = |of: fn(&Point) -> f64, low: f64, high: f64| {
            let widen = |(a, b): (f64, f64), v: f64| (a.min(v), b.max(v));
            points.iter().map(of).fold((low, high), widen)
        };
        let (_, far) = span(|p| p.0, 0.0, 1.2);
        let (low, high) = span(|p| p.1, 0.0, film.mount_height_m.max(ABOVE_M - 0.1));
        let (mut begins_s, mut time) = (Vec::new(), 0.0);
        for _ in &film.shots {
            begins_s.push(time);
            time += SWEEP_S + READ_S + DRIVE_S;
        }
        Self {
            x_m: (-BEHIND_M, far + BEYOND_M),
            y_m: (low - BELOW_M, high + 0.1),
            begins_s,
            ends_s: (time + REST_S).max(1.0),
            mirror_m: film.mount_height_m,
        }
    }

    fn x(&self, metres: f64) -> f64 {
        (metres - self.x_m.0) * SCALE
    }

    fn y(&self, metres: f64) -> f64 {
        HEAD + (self.y_m.1 - metres) * SCALE
    }

    fn at(&self, (x, y): Point) -> String {
        format!("{},{}", number(self.x(x)), number(self.y(y)))
    }

    fn width(&self) -> f64 {
        (self.x_m.1 - self.x_m.0) * SCALE
    }

    fn height(&self) -> f64 {
        HEAD + (self.y_m.1 - self.y_m.0) * SCALE + 6.0
    }

    /// Makes `node` an animation of `attribute` over the whole duration: pairs of time (seconds)
    /// and value in `course`, with linear interpolation.
    fn timed<N: Node>(&self, mut node: N, attribute: &str, course: &[(f64, String)]) -> N {
        let share = |t: f64| ((t / self.ends_s).clamp(0.0, 1.0) * 1e4).round() / 1e4;
        let times: Vec<String> = course.iter().map(|c| share(c.0).to_string()).collect();
        let values: Vec<&str> = course.iter().map(|c| c.1.as_str()).collect();
        node.assign("attributeName", attribute);
        node.assign("values", values.join(";"));
        node.assign("keyTimes", times.join(";"));
        node.assign("dur", format!("{}s", self.ends_s));
        node.assign("repeatCount", "indefinite");
        node
    }

    fn opacity(&self, course: &[(f64, f64)]) -> Animate {
        let course: Vec<_> = course.iter().map(|c| (c.0, number(c.1))).collect();
        self.timed(Animate::new(), "opacity", &course)
    }

    /// Animates a translation or rotation: pairs of time (seconds) and the arguments of the SVG
    /// transform `kind` in `course`.
    fn moved(&self, kind: &str, course: &[(f64, String)]) -> AnimateTransform {
        let transform = AnimateTransform::new().set("type", kind);
        self.timed(transform, "transform", course)
    }

    /// Animates the opacity: 1 between two times (seconds), with fading, and 0 otherwise.
    fn shown(&self, from_s: f64, to_s: f64) -> Animate {
        let end = self.ends_s;
        let out = to_s.min(end);
        let mut points = vec![(0.0, 0.0), (from_s, 0.0), (from_s + FADE_S, 1.0)];
        if out >= end {
            points.push((end, 1.0));
        } else {
            points.extend([(out, 1.0), (out + FADE_S, 0.0), (end, 0.0)]);
        }
        self.opacity(&points)
    }

    /// Returns the time at which the answer of scan `k` appears, and the time at which that of the
    /// next scan replaces it, seconds.
    fn answer_interval_s(&self, k: usize) -> (f64, f64) {
        let at = |k: usize| self.begins_s.get(k).map(|begin| begin + SWEEP_S);
        let end = self.ends_s + FADE_S;
        (at(k).unwrap_or(end), at(k + 1).unwrap_or(end))
    }

    pub(super) fn draw(&self, film: &Film) -> Document {
        let (width, height) = (number(self.width()), number(self.height()));
        let mut page = Document::new()
            .set("viewBox", format!("0 0 {width} {height}"))
            .set("font-family", "system-ui, sans-serif")
            .add(Title::new(format!(
                "{}: answers of the scanner during the approach",
                film.name
            )))
            .add(
                Rectangle::new()
                    .set("width", width)
                    .set("height", height)
                    .set("rx", 8)
                    .set("fill", "white"),
            )
            .add(self.ground(film));
        for (k, shot) in film.shots.iter().enumerate() {
            page = self.echoes(k, shot).into_iter().fold(page, Document::add);
        }
        page = page.add(self.chair(film));
        for (k, shot) in film.shots.iter().enumerate() {
            page = page.add(self.answer(k, shot));
        }
        page
    }

    /// Draws the true ground, or level ground if the recording has no truth.
    fn ground(&self, film: &Film) -> Polygon {
        let (left, right) = self.x_m;
        let edges = film.truth.as_ref().map(true_edges).unwrap_or_default();
        let mut line = surface(left, right, &edges);
        line.extend([(right, self.y_m.0), (left, self.y_m.0)]);
        let points: Vec<String> = line.into_iter().map(|p| self.at(p)).collect();
        Polygon::new()
            .set("points", points.join(" "))
            .set("fill", SOLID)
    }

    /// Draws the chair with its mirror and beam, and animates their motion from its place at the
    /// first scan.
    fn chair(&self, film: &Film) -> Group {
        let (mut way, mut turn, mut lit) = (Vec::new(), Vec::new(), vec![(0.0, 0.0)]);
        for (shot, &begin) in film.shots.iter().zip(&self.begins_s) {
            let (first, last) = shot.sweep_deg;
            let (ready, done) = (begin + FADE_S, begin + SWEEP_S);
            way.extend([begin, begin + SWEEP_S + READ_S].map(|t| (t, shot.travel_m * SCALE)));
            turn.extend([(begin, first), (done, last)]);
            lit.extend([
                (begin, 0.0),
                (ready, 1.0),
                (done, 1.0),
                (done + FADE_S, 0.0),
            ]);
        }
        for course in [&mut way, &mut turn, &mut lit] {
            course.push((self.ends_s, course.last().map_or(0.0, |last| last.1)));
        }
        let mirror = (0.0, film.mount_height_m);
        let spread = BEAM_M * BEAM_DEG.to_radians().tan();
        let tips = [
            mirror,
            (BEAM_M, mirror.1 + spread),
            (BEAM_M, mirror.1 - spread),
        ];
        let pivot = format!("{} {}", number(self.x(mirror.0)), number(self.y(mirror.1)));
        let turn: Vec<_> = (turn.iter())
            .map(|&(t, angle)| (t, format!("{} {pivot}", number(angle))))
            .collect();
        let way: Vec<_> = way.iter().map(|&(t, x)| (t, number(x))).collect();
        let beam = Polygon::new()
            .set("points", tips.map(|p| self.at(p)).join(" "))
            .set("fill", hex(MEASURED))
            .set("fill-opacity", 0.25)
            .add(self.opacity(&lit))
            .add(self.moved("rotate", &turn));
        let group = Group::new().add(beam);
        let group = self
            .outline(film.mount_height_m)
            .into_iter()
            .fold(group, Group::add);
        group.add(self.moved("translate", &way))
    }

    /// Returns the outlines of a powered wheelchair from the side, with its scanner in front.
    fn outline(&self, mount_height_m: f64) -> Vec<Path> {
        let path = |points: &[Point], width: f64| {
            let places: Vec<String> = points.iter().map(|&p| self.at(p)).collect();
            Path::new()
                .set("d", format!("M{}", places.join(" L")))
                .set("fill", "none")
                .set("stroke", INK)
                .set("stroke-width", width)
                .set("stroke-linecap", "round")
                .set("stroke-linejoin", "round")
        };
        let wheel = |x: f64, radius: f64| {
            let (left, right, r) = (
                self.at((x - radius, radius)),
                self.at((x + radius, radius)),
                number(radius * SCALE),
            );
            Path::new()
                .set(
                    "d",
                    format!("M{left} A{r},{r} 0 1 1 {right} A{r},{r} 0 1 1 {left}"),
                )
                .set("fill", "white")
                .set("stroke", INK)
                .set("stroke-width", 5)
        };
        vec![
            wheel(-0.52, 0.17),
            wheel(-0.16, 0.09),
            path(
                &[
                    (-0.7, 0.92),
                    (-0.63, 0.46),
                    (-0.26, 0.46),
                    (-0.16, 0.14),
                    (-0.04, 0.14),
                ],
                7.0,
            ),
            path(&[(-0.6, 0.62), (-0.32, 0.62)], 7.0),
            path(&[(-0.52, 0.17), (-0.4, 0.46)], 5.0),
            path(&[(-0.26, 0.4), (-0.05, mount_height_m)], 4.0),
            path(&[(-0.05, mount_height_m), (0.0, mount_height_m)], 14.0),
        ]
    }

    /// Draws the echoes of scan `k`, which appear as the beam passes them.
    fn echoes(&self, k: usize, shot: &Shot) -> Vec<Group> {
        let (first, last) = shot.sweep_deg;
        let begin = self.begins_s.get(k).copied().unwrap_or(0.0);
        let until = self
            .begins_s
            .get(k + 1)
            .map_or(self.ends_s + FADE_S, |next| next - DRIVE_S);
        let share = |e: &Echo| {
            let below = (self.mirror_m - e.at.1).atan2(e.at.0).to_degrees();
            ((below - first) / (last - first)).clamp(0.0, 1.0)
        };
        let group = |g: usize| {
            let (from, to) = (g as f64 / GROUPS as f64, (g + 1) as f64 / GROUPS as f64);
            let passed =
                |e: &&Echo| (from..to).contains(&share(e)) || (to >= 1.0 && share(e) >= 1.0);
            let dots: Vec<Circle> = shot
                .echoes
                .iter()
                .filter(passed)
                .map(|e| self.dot(shot, e))
                .collect();
            (!dots.is_empty()).then(|| {
                let time = begin + (from + to) / 2.0 * SWEEP_S;
                let group = Group::new().set("fill", hex(MEASURED)).set("opacity", 0);
                dots.into_iter()
                    .fold(group, Group::add)
                    .add(self.shown(time, until))
            })
        };
        (0..GROUPS).filter_map(group).collect()
    }

    fn dot(&self, shot: &Shot, echo: &Echo) -> Circle {
        let strength = (echo.snr_db / STRONG_DB).clamp(0.15, 1.0);
        Circle::new()
            .set("cx", number(self.x(shot.travel_m + echo.at.0)))
            .set("cy", number(self.y(echo.at.1)))
            .set("r", number(2.0 + 4.0 * strength))
            .set("fill-opacity", number(0.9 * strength))
    }

    /// Draws the answer of scan `k`: text above, the steps with their ±2σ, the drop, and the
    /// horizon.
    fn answer(&self, k: usize, shot: &Shot) -> Group {
        let hue = &hex(colour::status(shot.answer.scan.status));
        let (from, to) = self.answer_interval_s(k);
        let mut group = Group::new()
            .set("opacity", 0)
            .add(self.shown(from, to - FADE_S));
        let here = shot.travel_m;
        let steps = steps(&shot.answer);
        for s in &steps {
            let (x, y) = (here + s.distance_m, s.height_m);
            let (dx, dy) = s.two_sigma_m;
            group = group.add(
                Rectangle::new()
                    .set("x", number(self.x(x - dx) - 3.0))
                    .set("y", number(self.y(y + dy)))
                    .set("width", number(2.0 * dx * SCALE + 6.0))
                    .set("height", number(2.0 * dy * SCALE))
                    .set("fill", hue.as_str())
                    .set("fill-opacity", 0.45),
            );
        }
        let edges: Vec<Point> = steps
            .iter()
            .map(|s| (here + s.distance_m, s.height_m))
            .collect();
        let end = edges.last().map_or(here, |last| last.0) + 0.15;
        let line = surface(here, end, &edges);
        let places: Vec<String> = line.into_iter().map(|p| self.at(p)).collect();
        group = group.add(
            Path::new()
                .set("d", format!("M{}", places.join(" L")))
                .set("fill", "none")
                .set("stroke", hue.as_str())
                .set("stroke-width", 3.5)
                .set("stroke-linejoin", "round"),
        );
        if let Some(drop) = &shot.answer.drop {
            group = group.add(self.drop(here, drop, hue));
        }
        group = Self::words(shot, hue).into_iter().fold(group, Group::add);
        let horizon = shot.answer.horizon_m.filter(|&horizon| horizon > 0.0);
        match horizon {
            Some(horizon) => self
                .horizon(shot.travel_m + horizon)
                .into_iter()
                .fold(group, Group::add),
            None => group,
        }
    }

    /// Draws the edge of a drop as seen from the mirror at `here` metres: a vertical line, and a
    /// band of ±3σ.
    fn drop(&self, here: f64, drop: &DropLine, hue: &str) -> Group {
        let (edge, near) = (metres(drop.distance), nearest_m(drop));
        let inside = |m: f64| self.x((here + m).clamp(self.x_m.0, self.x_m.1));
        let (left, x, right) = (inside(near), inside(edge), inside(2.0 * edge - near));
        let (top, bottom) = (HEAD + 40.0, self.y(self.y_m.0));
        let band = Rectangle::new()
            .set("x", number(left))
            .set("y", number(top))
            .set("width", number(right - left))
            .set("height", number(bottom - top))
            .set("fill", hue)
            .set("fill-opacity", 0.2);
        let line = Line::new()
            .set("x1", number(x))
            .set("x2", number(x))
            .set("y1", number(top))
            .set("y2", number(bottom))
            .set("stroke", hue)
            .set("stroke-width", 3.5);
        let label = Text::new("the ground ends")
            .set("x", number(x))
            .set("dx", -8)
            .set("y", number(top + 14.0))
            .set("font-size", 15)
            .set("text-anchor", "end")
            .set("fill", hue);
        Group::new().add(band).add(line).add(label)
    }

    fn horizon(&self, x_m: f64) -> Vec<Group> {
        let (edge_m, label) = if x_m < self.x_m.1 {
            (x_m, "valid up to here")
        } else {
            (self.x_m.1 - 0.01, "valid beyond the drawing")
        };
        let x = number(self.x(edge_m));
        let line = Line::new()
            .set("x1", x.clone())
            .set("x2", x.clone())
            .set("y1", number(HEAD + 18.0))
            .set("y2", number(self.y(self.y_m.0)))
            .set("stroke", FAINT)
            .set("stroke-width", 2)
            .set("stroke-dasharray", "7 5");
        let label = Text::new(label)
            .set("x", x)
            .set("dx", -8)
            .set("y", number(HEAD + 32.0))
            .set("font-size", 15)
            .set("text-anchor", "end")
            .set("fill", FAINT);
        vec![Group::new().add(line).add(label)]
    }

    /// Returns the lines of text on an answer: number of steps and status, horizon and reasons, and
    /// the first steps side by side.
    fn words(shot: &Shot, hue: &str) -> Vec<Text> {
        let line = |words: String, (x, y): (f64, f64), size: u32, fill: &str| {
            Text::new(words)
                .set("x", x)
                .set("y", y)
                .set("font-size", size)
                .set("fill", fill)
        };
        let summary = shot.answer.summary();
        // "ok (reason): steps, valid up to …"; the reasons go to the second line.
        let (status, rest) = summary.split_once(": ").unwrap_or((&summary, ""));
        let (status, reasons) = status.split_once(" (").unwrap_or((status, ""));
        let (what, validity) = rest.split_once(", ").unwrap_or((rest, ""));
        let reasons = reasons.trim_end_matches(')');
        let parts: Vec<&str> = [validity, reasons]
            .into_iter()
            .filter(|part| !part.is_empty())
            .collect();
        let mut lines = vec![
            line(format!("{status}: {what}"), (20.0, 40.0), 26, hue).set("font-weight", "bold"),
            line(parts.join("; "), (20.0, 68.0), 18, INK),
        ];
        for (s, column) in shot.answer.steps.iter().take(COLUMNS).zip(0u32..) {
            let words = format!(
                "{}:  {:.1} ± {:.1} / {:.1} ± {:.1} cm",
                s.index,
                100.0 * metres(s.distance),
                200.0 * metres(s.distance_sigma),
                100.0 * metres(s.height),
                200.0 * metres(s.height_sigma)
            );
            let x = 20.0 + COLUMN * f64::from(column);
            lines.push(line(words, (x, 96.0), 17, FAINT));
        }
        lines
    }
}
