//! Placement of labels: boxes and lines of data in, free boxes out.
//!
//! A coarse grid marks the covered places. A label is placed in the nearest free box, and a thin
//! line leads from it to its point.

use anyhow::Result;

use super::page::Frame;
use super::sheet::{FAINT, Face, Sheet, Spot, Stroke};

/// Width and height of a grid cell, pixels.
const CELL: f64 = 4.0;
/// Distance between the places that are tried for a label, pixels.
const STRIDE: f64 = 8.0;
/// Maximum distance from a point to its label, pixels.
const REACH: f64 = 280.0;
/// Margin around a label, pixels.
const RIM: f64 = 4.0;
/// Distance between a label and its point above which a thin line connects them, pixels.
const BESIDE: f64 = 26.0;
/// Distance between lines of text, in units of the font size.
const LINE: f64 = 1.2;
/// Cost of a covered cell, pixels of distance: so large that a label covers data only if no free place is in reach.
const COVERED: f64 = 1e4;
/// Cost of a pixel of sideways offset between a label and its point: of equally near places the straightest is taken.
const OFFSET_COST: f64 = 0.05;

/// Finds free places for labels in a frame, of which a grid of cells records the covered ones.
#[derive(Clone, Debug)]
pub struct LabelPlacer {
    frame: Frame,
    columns: usize,
    taken: Vec<bool>,
}

impl LabelPlacer {
    /// Creates a placer for `frame` with no cell covered.
    pub fn new(frame: &Frame) -> Self {
        let cells = |length: f64| (length / CELL).ceil().max(1.0) as usize;
        let (columns, rows) = (cells(frame.size.0), cells(frame.size.1));
        Self {
            frame: *frame,
            columns,
            taken: vec![false; columns * rows],
        }
    }

    /// Marks every cell as covered in whose middle `covered` holds; its arguments are (x, y) in the axes' units.
    pub fn cover_where(&mut self, covered: impl Fn(f64, f64) -> bool) {
        let Frame { size, x, y, .. } = self.frame;
        for (k, taken) in self.taken.iter_mut().enumerate() {
            let (column, row) = (k % self.columns, k / self.columns);
            let across = (column as f64 + 0.5) * CELL / size.0;
            let down = (row as f64 + 0.5) * CELL / size.1;
            *taken |= covered(x.0 + across * (x.1 - x.0), y.1 - down * (y.1 - y.0));
        }
    }

    /// Marks the box between two corners as covered.
    pub fn cover(&mut self, a: Spot, b: Spot) {
        for k in self.cells(a, b) {
            self.taken[k] = true;
        }
    }

    /// Marks the square around a marker as covered.
    pub fn cover_mark(&mut self, at: Spot, radius: f64) {
        self.cover(
            (at.0 - radius, at.1 - radius),
            (at.0 + radius, at.1 + radius),
        );
    }

    /// Marks the line through `spots` as covered.
    pub fn cover_line(&mut self, spots: &[Spot]) {
        for pair in spots.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let length = (to.0 - from.0).hypot(to.1 - from.1);
            // A longer line extends far beyond the frame.
            let parts = (length / CELL).ceil().clamp(1.0, 4096.0);
            for k in 0..=parts as usize {
                let t = k as f64 / parts;
                let at = (from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1));
                self.cover_mark(at, 1.0);
            }
        }
    }

    /// Returns the indices of the cells of a box that lie within the frame.
    fn cells(&self, a: Spot, b: Spot) -> impl Iterator<Item = usize> + use<> {
        let (columns, rows) = (self.columns, self.taken.len() / self.columns);
        let span = |a: f64, b: f64, origin: f64, count: usize| {
            let cell = |v: f64| ((v - origin) / CELL).floor();
            let (low, high) = (cell(a.min(b)).max(0.0), cell(a.max(b)) + 1.0);
            low as usize..(high.max(0.0) as usize).min(count)
        };
        let across = span(a.0, b.0, self.frame.at.0, columns);
        let down = span(a.1, b.1, self.frame.at.1, rows);
        down.flat_map(move |row| across.clone().map(move |column| row * columns + column))
    }

    /// Returns the top left corner of the best box of `size` pixels for a label of the point `near`, and the number
    /// of covered cells in it. The best has the fewest covered cells, then the smallest distance, at most `reach`
    /// pixels.
    pub fn find(&self, near: Spot, size: Spot, reach: f64) -> (Spot, usize) {
        let Frame { at, size: all, .. } = self.frame;
        let (low, high) = (
            (at.0 + RIM, at.1 + RIM),
            (at.0 + all.0 - size.0 - RIM, at.1 + all.1 - size.1 - RIM),
        );
        let within = |v: f64, low: f64, high: f64| v.clamp(low, high.max(low));
        let steps = |length: f64| ((length + reach) / STRIDE).ceil() as i32;
        let candidates = (-steps(size.1)..=steps(0.0)).flat_map(|row| {
            (-steps(size.0)..=steps(0.0)).map(move |column| {
                let shift = (f64::from(column) * STRIDE, f64::from(row) * STRIDE);
                (near.0 + shift.0, near.1 + shift.1)
            })
        });
        let mut best = (f64::INFINITY, low, 0);
        for place in candidates {
            let place = (
                within(place.0, low.0, high.0),
                within(place.1, low.1, high.1),
            );
            let end = (place.0 + size.0, place.1 + size.1);
            let gap = distance(near, (place, end));
            let middle = (place.0 + size.0 / 2.0 - near.0).hypot(place.1 + size.1 / 2.0 - near.1);
            let cost = gap + OFFSET_COST * middle;
            if gap > reach || cost >= best.0 {
                continue;
            }
            let rim = ((place.0 - RIM, place.1 - RIM), (end.0 + RIM, end.1 + RIM));
            let covered = self.cells(rim.0, rim.1).filter(|&k| self.taken[k]).count();
            let cost = cost + COVERED * covered as f64;
            if cost < best.0 {
                best = (cost, place, covered);
            }
        }
        (best.1, best.2)
    }

    /// Writes lines of text about `near` where they cover least data, and marks their box as covered.
    pub fn write(&mut self, sheet: &Sheet<'_>, near: Spot, lines: &[(&str, Face)]) -> Result<()> {
        let size = extent(lines);
        let (place, _) = self.find(near, size, REACH);
        let end = (place.0 + size.0, place.1 + size.1);
        if distance(near, (place, end)) > BESIDE {
            let foot = (near.0.clamp(place.0, end.0), near.1.clamp(place.1, end.1));
            sheet.line(&[near, foot], Stroke::solid(FAINT, 1.2))?;
        }
        self.cover(place, end);
        let mut top = place.1;
        for (text, face) in lines {
            let height = LINE * face.size;
            sheet.note(text, (place.0, top + height / 2.0), face.left())?;
            top += height;
        }
        Ok(())
    }
}

/// Returns width and height of lines of text, pixels.
pub fn extent(lines: &[(&str, Face)]) -> Spot {
    let width = lines.iter().map(|(text, face)| face.width(text));
    let height: f64 = lines.iter().map(|(_, face)| LINE * face.size).sum();
    (width.fold(0.0, f64::max), height)
}

/// Returns the distance from a spot to a box; 0 within it.
fn distance(spot: Spot, (low, high): (Spot, Spot)) -> f64 {
    let off = |v: f64, low: f64, high: f64| (low - v).max(v - high).max(0.0);
    off(spot.0, low.0, high.0).hypot(off(spot.1, low.1, high.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Frame = Frame {
        at: (100.0, 50.0),
        size: (600.0, 400.0),
        x: (0.0, 1.0),
        y: (0.0, 1.0),
    };

    #[test]
    fn words_stand_beside_what_they_speak_of_and_cover_nothing() {
        let mut room = LabelPlacer::new(&FRAME);
        // A column of data with a mark in it, and labels written earlier.
        room.cover((300.0, 50.0), (340.0, 450.0));
        let mark = (320.0, 200.0);
        let size = (150.0, 60.0);
        let mut boxes: Vec<(Spot, Spot)> = vec![((300.0, 50.0), (340.0, 450.0))];
        for _ in 0..6 {
            let (place, covered) = room.find(mark, size, REACH);
            let end = (place.0 + size.0, place.1 + size.1);
            assert_eq!(covered, 0);
            for (low, high) in &boxes {
                let apart =
                    place.0 >= high.0 || end.0 <= low.0 || place.1 >= high.1 || end.1 <= low.1;
                assert!(apart, "{place:?} covers {low:?} to {high:?}");
            }
            assert!(place.0 >= 100.0 && end.0 <= 700.0 && place.1 >= 50.0 && end.1 <= 450.0);
            room.cover(place, end);
            boxes.push((place, end));
        }
        // The first labels are the nearest.
        assert!(distance(mark, boxes[1]) < 30.0, "{boxes:?}");
    }

    #[test]
    fn where_all_is_taken_the_least_is_covered() {
        let mut room = LabelPlacer::new(&FRAME);
        room.cover((100.0, 50.0), (700.0, 450.0));
        let (place, covered) = room.find((400.0, 200.0), (40.0, 20.0), 50.0);
        assert!(
            covered > 0 && (300.0..500.0).contains(&place.0),
            "{place:?}"
        );
    }

    #[test]
    fn lines_and_cells_of_the_data_are_taken() {
        let mut room = LabelPlacer::new(&FRAME);
        room.cover_line(&[(-1e9, 250.0), (1e9, 250.0)]);
        room.cover_line(&[(100.0, 250.0), (700.0, 250.0)]);
        room.cover_where(|x, y| x > 0.5 && y > 0.5);
        let (place, covered) = room.find((400.0, 250.0), (60.0, 30.0), REACH);
        assert_eq!(covered, 0);
        let above = place.1 + 30.0 < 250.0;
        assert!(!above || place.0 + 60.0 < 400.0, "{place:?}");
    }
}
