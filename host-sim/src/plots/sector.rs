//! Mapping from the polar map to the sagittal plane: the cell shown by each pixel.

use plotters::style::RGBColor;
use stairscan::config::Plane;
use stairscan::signal::grid::{DB_PER_UNIT, PolarMap};
use stairscan::signal::range::FULL_SCALE;

use super::page::Frame;

/// Index in place of a cell's for a pixel that lies outside the scan and shows no cell.
const BLANK: u32 = u32::MAX;
/// Colour outside the scan.
const OUTSIDE: [u8; 3] = [255, 255, 255];

/// Returns the power, dB relative to full scale, of a cell value (units of 0.376 dB).
pub fn decibels(cell: u8) -> f64 {
    (f64::from(cell) - f64::from(FULL_SCALE)) * f64::from(DB_PER_UNIT)
}

/// Returns the cell (row, bin) nearest in angle and range to the point (x, y), metres; `None` outside the scan, or if
/// the chirp was lost.
pub fn cell_at(map: &PolarMap, x: f64, y: f64) -> Option<(usize, usize)> {
    let geometry = map.geometry();
    let (range, angle) = geometry.polar(x as f32, y as f32);
    let bin = ((range - geometry.first_range_m) / geometry.bin_m).round();
    // A NaN bin fails here as well, because comparisons with NaN are false.
    if !(bin >= 0.0 && bin < map.bins() as f32) {
        return None;
    }
    let row = nearest_row(map, angle)?;
    map.present(row).then_some((row, bin as usize))
}

/// Returns the row whose beam angle, that of the motor's microstep, is nearest to `angle`, radians; `None` if it lies
/// more than half a step before the first or beyond the last row. Between two rows it may be farther off, as the
/// microsteps deviate from the schedule.
fn nearest_row(map: &PolarMap, angle: f32) -> Option<usize> {
    let (mut low, mut high) = (0, map.rows());
    while low < high {
        let middle = (low + high) / 2;
        if map.angle_rad(middle) < angle {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    let off = |k: &usize| (map.angle_rad(*k) - angle).abs();
    let near = [low.checked_sub(1), Some(low).filter(|&k| k < map.rows())];
    let row = near
        .into_iter()
        .flatten()
        .min_by(|a, b| off(a).total_cmp(&off(b)))?;
    let between = low > 0 && low < map.rows();
    (between || off(&row) <= 0.5 * map.geometry().step_rad.abs()).then_some(row)
}

/// The cell of every (enlarged) pixel of a frame, computed once for all plots of a scan.
pub struct Sector {
    size: (u32, u32),
    bins: usize,
    cells: Vec<u32>,
}

impl Sector {
    /// Computes the cells that `frame` shows.
    pub fn new(map: &PolarMap, frame: &Frame) -> Self {
        let size = frame.enlarged();
        let place = |column: u32, row: u32| {
            let across = (f64::from(column) + 0.5) / f64::from(size.0);
            let down = (f64::from(row) + 0.5) / f64::from(size.1);
            (
                frame.x.0 + across * (frame.x.1 - frame.x.0),
                frame.y.1 - down * (frame.y.1 - frame.y.0),
            )
        };
        let pixels = (0..size.1).flat_map(|row| (0..size.0).map(move |column| (column, row)));
        let cells = pixels.map(|(column, row)| {
            let (x, y) = place(column, row);
            cell_at(map, x, y).map_or(BLANK, |(row, bin)| (row * map.bins() + bin) as u32)
        });
        Self {
            size,
            bins: map.bins(),
            cells: cells.collect(),
        }
    }

    /// Returns the frame's width and height in enlarged pixels.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Returns the colours of all pixels, three bytes each, line by line; `colour` gives that of a cell (row, bin).
    pub fn paint(&self, colour: impl Fn(usize, usize) -> RGBColor) -> Vec<u8> {
        let cells = self.cells.iter().flat_map(|&cell| {
            if cell == BLANK {
                return OUTSIDE;
            }
            let RGBColor(r, g, b) = colour(cell as usize / self.bins, cell as usize % self.bins);
            [r, g, b]
        });
        cells.collect()
    }
}

/// Returns minimum and maximum of x, and of y, of the area that the scan covers, metres.
pub fn extent(map: &PolarMap) -> ((f64, f64), (f64, f64)) {
    let geometry = map.geometry();
    let ends = [0.0, map.bins().saturating_sub(1) as f32];
    let points = (0..map.rows())
        .flat_map(|row| ends.map(|bin| geometry.point(geometry.range_m(bin), map.angle_rad(row))));
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let grow = |s: (f64, f64), v: f64| (s.0.min(v), s.1.max(v));
    points.fold((none, none), |(xs, ys), (x, y)| {
        (grow(xs, x.into()), grow(ys, y.into()))
    })
}

/// Whether a cell is a detection together with one beside it in angle, which is rare for noise.
fn is_echo(map: &PolarMap, row: usize, bin: usize) -> bool {
    let beside = [row.checked_sub(1), row.checked_add(1)];
    map.is_detected(row, bin)
        && beside
            .into_iter()
            .flatten()
            .any(|row| map.is_detected(row, bin))
}

/// Returns minimum and maximum of x, and of y, of the displayed area, metres. It holds the echoes, the mirror, the
/// ground below it and `points` of interest, with a margin, within the area that the scan covers.
pub fn view(map: &PolarMap, points: &[(f64, f64)]) -> ((f64, f64), (f64, f64)) {
    /// Echoes down to this power below the strongest one widen the view, dB.
    const STRONG_DB: f64 = 35.0;
    const MARGIN_M: (f64, f64) = (0.3, 0.15);
    /// Minimum width and height of the view, metres.
    const MIN_SPAN_M: (f64, f64) = (1.2, 0.8);
    let geometry = map.geometry();
    let mount = f64::from(geometry.mount_height_m);
    let hits = || {
        (0..map.rows()).flat_map(|row| {
            let bins = (0..map.bins()).filter(move |&bin| is_echo(map, row, bin));
            bins.map(move |bin| (row, bin))
        })
    };
    let strongest = hits().map(|(r, b)| map.cell(r, b)).max().unwrap_or(0);
    let least = decibels(strongest) - STRONG_DB;
    let (mut xs, mut ys): (Vec<f64>, Vec<f64>) = hits()
        .filter(|&(r, b)| decibels(map.cell(r, b)) >= least)
        .map(|(row, bin)| {
            let (x, y) = geometry.point(geometry.range_m(bin as f32), map.angle_rad(row));
            (f64::from(x), f64::from(y))
        })
        .unzip();
    let span = |values: &mut Vec<f64>, fixed: [f64; 2], of: fn(&(f64, f64)) -> f64| {
        values.sort_by(f64::total_cmp);
        // One echo in a hundred may lie outside.
        let cut = values.len() / 100;
        let kept = values.iter().skip(cut).take(values.len() - 2 * cut);
        let all = kept.copied().chain(fixed).chain(points.iter().map(of));
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |s, v| {
            (s.0.min(v), s.1.max(v))
        })
    };
    let x = span(&mut xs, [0.0, 0.0], |p| p.0);
    let y = span(&mut ys, [0.0, mount], |p| p.1);
    let (all_x, all_y) = extent(map);
    let clip = |v: (f64, f64), all: (f64, f64), origin: f64, margin: f64, least: f64| {
        let low = (v.0 - margin).max(all.0.min(origin) - 0.08);
        let high = (v.1 + margin).min(all.1.max(origin) + 0.08);
        (low, high.max(low + least))
    };
    let x = clip(x, all_x, 0.0, MARGIN_M.0, MIN_SPAN_M.0);
    let y = match geometry.plane {
        // Echoes that appear below the ground are mirror images in it.
        Plane::Depth => clip((y.0.max(-0.1), y.1), all_y, mount, MARGIN_M.1, MIN_SPAN_M.1),
        Plane::Height => clip(y, all_y, mount, MARGIN_M.1, MIN_SPAN_M.1),
    };
    (x, y)
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use stairscan::config::Config;

    /// A map of `plane` with cell value `level` everywhere and one strong, detected cell at `spot` (row, bin).
    pub fn map_with_spot(plane: Plane, level: u8, spot: (usize, usize)) -> Box<PolarMap> {
        let mut config = Config::default();
        config.mount.plane = plane.into();
        let mut map = Box::new(PolarMap::new());
        map.begin(&config).unwrap();
        for k in 0..map.rows() {
            map.fill(k, |row| {
                row.cells.fill(level);
                if k == spot.0 {
                    row.cells[spot.1] = 240;
                    row.mask[spot.1 / 32] |= 1 << (spot.1 % 32);
                }
            });
        }
        map
    }

    #[test]
    fn a_bright_cell_appears_at_its_place_in_both_planes() {
        // Row 120 is 10° (-20° + 120 · 0.25°).
        let (sin, cos) = 10f64.to_radians().sin_cos();
        for plane in [Plane::Depth, Plane::Height] {
            let map = map_with_spot(plane, 40, (120, 60));
            let range = f64::from(map.geometry().range_m(60.0));
            let (x, y) = match plane {
                Plane::Depth => (range * cos, 0.4 - range * sin),
                Plane::Height => (range * sin, 0.4 - range * cos),
            };
            assert_eq!(cell_at(&map, x, y), Some((120, 60)));
            let frame = Frame {
                at: (0.0, 0.0),
                size: (150.0, 150.0),
                x: (x - 0.075, x + 0.075),
                y: (y - 0.075, y + 0.075),
            };
            let sector = Sector::new(&map, &frame);
            let pixels = sector.paint(|row, bin| RGBColor(map.cell(row, bin), 0, 0));
            let bright: Vec<(f64, f64)> = (pixels.chunks(3).enumerate())
                .filter(|(_, p)| p[0] == 240)
                .map(|(k, _)| ((k % 300) as f64 / 2.0, (k / 300) as f64 / 2.0))
                .collect();
            // A cell is a bin (11.7 mm) by a quarter of a degree; its area in pixels of 0.5 mm.
            let area = 1.1712 * range * 100.0 * 0.25f64.to_radians() / 0.0025;
            assert!(
                (bright.len() as f64 / area - 1.0).abs() < 0.1,
                "{}",
                bright.len()
            );
            let mean =
                |f: fn(&(f64, f64)) -> f64| bright.iter().map(f).sum::<f64>() / bright.len() as f64;
            // The middle of the frame is the middle of the cell, to half a pixel.
            assert!((mean(|p| p.0) - 74.75).abs() < 0.5, "{plane:?}");
            assert!((mean(|p| p.1) - 74.75).abs() < 0.5, "{plane:?}");
        }
    }

    #[test]
    fn nothing_is_shown_where_the_radar_did_not_look() {
        let map = map_with_spot(Plane::Depth, 40, (0, 0));
        assert_eq!(cell_at(&map, 0.0, 0.4), None, "nearer than the first bin");
        assert_eq!(cell_at(&map, 5.0, 0.4), None, "beyond the last bin");
        assert_eq!(cell_at(&map, 0.1, -1.0), None, "below the last angle");
        assert_eq!(cell_at(&map, f64::NAN, 0.4), None);
        let mut config = Config::default();
        config.sweep.angle_count = 10;
        let mut map = Box::new(PolarMap::new());
        map.begin(&config).unwrap();
        assert_eq!(cell_at(&map, 1.0, 0.74), None, "no chirp arrived");
    }

    #[test]
    fn a_shaft_on_its_microsteps_leaves_no_gaps() {
        let mut map = Box::new(PolarMap::new());
        map.begin(&Config::default()).unwrap();
        for k in 0..map.rows() {
            map.fill(k, |_| ());
        }
        for k in 0..10_000 {
            let angle = (-20.0 + 70.0 * f64::from(k) / 10_000.0).to_radians();
            let at = cell_at(&map, angle.cos(), 0.4 - angle.sin());
            let (row, _) = at.unwrap();
            let off = |row: usize| (map.angle_rad(row) - angle as f32).abs();
            assert!(
                (0..map.rows()).all(|other| off(row) <= off(other) + 1e-6),
                "{k}"
            );
        }
    }

    #[test]
    fn the_view_holds_its_points_and_the_echo() {
        for plane in [Plane::Depth, Plane::Height] {
            let map = map_with_spot(plane, 40, (200, 100));
            let (x, y) = view(&map, &[(1.5, 0.3), (0.2, 0.0)]);
            for (px, py) in [(1.5, 0.3), (0.2, 0.0), (0.0, 0.4)] {
                assert!(x.0 <= px && px <= x.1 && y.0 <= py && py <= y.1);
            }
            let all = extent(&map);
            assert!(
                x.1 <= all.0.1 + 0.09 && y.0 >= all.1.0 - 0.09,
                "{x:?} {y:?} {all:?}"
            );
        }
    }
}
