//! Time of each row of a scan, and position of the chair at that time.
//!
//! Rows are kept in blocks, each with the means of its rows. A chair of a hundred kilograms moves along a
//! straight line within the tens of milliseconds of one block, and the means remove most of an inclinometer's
//! noise.

/// Maximum number of blocks of a scan. The paper's 281 rows are six a block, some 30 ms of its fastest scan.
const BLOCKS: usize = 48;

/// Time of a row, and position of the chair at that time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RowPose {
    /// Time since the scan's first row, seconds.
    pub time_s: f32,
    /// Forward travel since the scan's first row, metres.
    pub travel_m: f32,
    /// The chair's pitch, nose up positive, radians.
    pub pitch_rad: f32,
}

impl RowPose {
    const ZERO: Self = Self {
        time_s: 0.0,
        travel_m: 0.0,
        pitch_rad: 0.0,
    };

    fn mix(self, other: Self, share: f32) -> Self {
        let mix = |a: f32, b: f32| a + share * (b - a);
        Self {
            time_s: mix(self.time_s, other.time_s),
            travel_m: mix(self.travel_m, other.travel_m),
            pitch_rad: mix(self.pitch_rad, other.pitch_rad),
        }
    }
}

/// Means over several neighbouring rows of time, chair's position (travel and pitch) and row index, with the number of
/// rows.
#[derive(Clone, Copy, Debug)]
struct Block {
    row: f32,
    place: RowPose,
    rows: u16,
}

impl Block {
    const EMPTY: Self = Self {
        row: 0.0,
        place: RowPose::ZERO,
        rows: 0,
    };

    fn add(&mut self, row: u16, place: RowPose) {
        self.rows = self.rows.saturating_add(1);
        let share = 1.0 / f32::from(self.rows);
        self.row += share * (f32::from(row) - self.row);
        self.place = self.place.mix(place, share);
    }
}

/// Times of the rows of one scan, and positions of the chair at these times.
#[derive(Clone, Debug)]
pub struct Track {
    blocks: [Block; BLOCKS],
    rows_per_block: u16,
    last: RowPose,
}

impl Default for Track {
    fn default() -> Self {
        Self::new()
    }
}

impl Track {
    /// Returns a track without rows.
    pub const fn new() -> Self {
        Self {
            blocks: [Block::EMPTY; BLOCKS],
            rows_per_block: 1,
            last: RowPose::ZERO,
        }
    }

    /// Discards all rows, and prepares for the first of the `rows` rows of a scan.
    pub fn begin(&mut self, rows: u16) {
        self.blocks.fill(Block::EMPTY);
        self.rows_per_block = rows.div_ceil(BLOCKS as u16).max(1);
        self.last = RowPose::ZERO;
    }

    /// Adds row `row` of the map with its time and the chair's position. Rows are added in the order of observation.
    pub fn add(&mut self, row: u16, place: RowPose) {
        let block = usize::from(row / self.rows_per_block.max(1));
        if let Some(block) = self.blocks.get_mut(block) {
            block.add(row, place);
        }
        self.last = place;
    }

    /// Returns time and position of the row added last.
    pub fn end(&self) -> RowPose {
        self.last
    }

    /// Returns whether the chair moved during the scan: by more than `travel_m` metres or `pitch_rad` radians
    /// from its position at the first row.
    pub fn moves(&self, travel_m: f32, pitch_rad: f32) -> bool {
        let mut seen = self.blocks.iter().filter(|b| b.rows > 0);
        let first = seen.next().map_or(RowPose::ZERO, |b| b.place);
        self.last.travel_m.abs() > travel_m
            || seen.any(|b| {
                (b.place.travel_m - first.travel_m).abs() > travel_m
                    || (b.place.pitch_rad - first.pitch_rad).abs() > pitch_rad
            })
    }

    /// Returns the two blocks before and after `row`, or the two nearest ones; `None` without rows.
    fn around(&self, row: f32) -> Option<(Block, Block)> {
        let filled = |k: &usize| self.blocks.get(*k).is_some_and(|b| b.rows > 0);
        let reaches = |k: &usize| self.blocks.get(*k).is_some_and(|b| b.row >= row);
        // Rows of the blocks before this one are smaller. The cast saturates.
        let here = (row / f32::from(self.rows_per_block.max(1))) as usize;
        let upper = (here.min(BLOCKS)..BLOCKS).filter(filled).find(reaches);
        let before = |k: usize| (0..k).rev().find(filled);
        let (a, b) = match (before(upper.unwrap_or(BLOCKS)), upper) {
            (Some(a), Some(b)) => (a, b),
            (Some(b), None) => (before(b).unwrap_or(b), b),
            (None, b) => {
                let a = b?;
                (a, (a + 1..BLOCKS).find(filled).unwrap_or(a))
            }
        };
        self.blocks.get(a).copied().zip(self.blocks.get(b).copied())
    }

    /// Returns time and position of row `row`, which may be fractional: linear interpolation between blocks,
    /// and extrapolation before the first and after the last.
    pub fn at(&self, row: f32) -> RowPose {
        let Some((a, b)) = self.around(row) else {
            return RowPose::ZERO;
        };
        let rows = b.row - a.row;
        if rows == 0.0 {
            return a.place;
        }
        a.place.mix(b.place, (row - a.row) / rows)
    }

    /// Returns the changes of time, travel and pitch from one row of the map to the next, around `row`.
    pub fn per_row(&self, row: f32) -> RowPose {
        let Some((a, b)) = self.around(row).filter(|(a, b)| b.row != a.row) else {
            return RowPose::ZERO;
        };
        let rows = b.row - a.row;
        RowPose {
            time_s: (b.place.time_s - a.place.time_s) / rows,
            travel_m: (b.place.travel_m - a.place.travel_m) / rows,
            pitch_rad: (b.place.pitch_rad - a.place.pitch_rad) / rows,
        }
    }

    /// Returns the forward speed around `row`, m/s.
    pub fn speed(&self, row: f32) -> f32 {
        let step = self.per_row(row);
        if step.time_s == 0.0 {
            0.0
        } else {
            step.travel_m / step.time_s
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Position of a chair at 0.2 m/s whose nose rises, 5 ms per row.
    fn place(arrival: u16) -> RowPose {
        let time_s = 0.005 * f32::from(arrival);
        RowPose {
            time_s,
            travel_m: 0.2 * time_s,
            pitch_rad: 0.01 * time_s,
        }
    }

    #[test]
    fn a_straight_drive_is_kept_whichever_way_the_rows_come() {
        for backward in [false, true] {
            for rows in [3u16, 40, 281, 1500] {
                let mut track = Track::new();
                track.begin(rows);
                let arrival = |row: u16| if backward { rows - 1 - row } else { row };
                for k in 0..rows {
                    track.add(arrival(k), place(k));
                }
                for row in 0..rows {
                    let (found, there) = (track.at(f32::from(row)), place(arrival(row)));
                    assert!(
                        (found.time_s - there.time_s).abs() < 2e-5,
                        "{row} of {rows}"
                    );
                    assert!((found.travel_m - there.travel_m).abs() < 5e-6);
                    assert!((found.pitch_rad - there.pitch_rad).abs() < 5e-6);
                }
                assert_eq!(track.end(), place(rows - 1));
                assert!((track.speed(1.0) - 0.2).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn lost_rows_leave_the_others_where_they_are() {
        let mut track = Track::new();
        track.begin(281);
        for k in (0..281).filter(|k| k % 7 != 0 && !(60..80).contains(k)) {
            track.add(k, place(k));
        }
        for row in [0u16, 63, 70, 140, 280] {
            let (found, there) = (track.at(f32::from(row)), place(row));
            assert!((found.travel_m - there.travel_m).abs() < 5e-6, "{row}");
        }
    }

    #[test]
    fn without_rows_there_is_no_motion() {
        let mut track = Track::new();
        track.begin(281);
        assert_eq!((track.at(7.0), track.speed(7.0)), (RowPose::ZERO, 0.0));
        track.add(9, place(9));
        assert_eq!(track.at(200.0), place(9));
    }
}
