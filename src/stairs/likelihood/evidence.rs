//! The echoes as the assembly sees them: placed, weighed, sorted, gathered into columns.

use super::echo::{Echo, MAX_ECHOES};
use crate::math::{self, RAD_PER_DEG};
use heapless::Vec;

/// Most columns (places where a riser may stand).
pub const MAX_COLUMNS: usize = 32;
/// Echoes this close in x belong to one riser, metres: nosings overhang by up to 2.5 cm.
pub const COLUMN: f32 = 0.035;
/// Nearer lie folded-back walls and the floor under the mirror seen by side lobes, metres.
pub const X_MIN: f32 = 0.36;
/// Floor below the scan's last angle, seen by side lobes: nearer than this to the mirror, metres.
const UNSEEN_FLOOR: f32 = 0.54;

/// One echo with what the likelihood needs of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mark {
    /// Horizontal distance, metres.
    pub x: f32,
    /// Height above the ground, metres.
    pub y: f32,
    /// Standard deviation of the height, metres.
    pub sigma: f32,
    /// Credibility, 0…1.
    pub weight: f32,
    /// Power above the noise, dB.
    pub db: f32,
    /// Range from the mirror, metres.
    pub range: f32,
    /// Width in angle in units of a point scatterer's.
    pub width: f32,
}

/// A place where a riser may stand: echoes above one another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Column {
    /// Of its strongest echo, metres.
    pub x: f32,
    /// Sum of the credibilities of what does not lie on the floor.
    pub weight: f32,
    /// Its echoes: from this mark …
    pub first: usize,
    /// … up to but without this one.
    pub end: usize,
}

/// All echoes in order of x, and the columns among them.
#[derive(Debug, Default)]
pub struct Evidence {
    /// In order of x.
    pub marks: Vec<Mark, MAX_ECHOES>,
    /// In order of x.
    pub columns: Vec<Column, MAX_COLUMNS>,
    /// Mirror above the ground, metres.
    pub mount_height: f32,
}

/// How far an echo is believed: none at the noise, wholly from 10 dB on.
pub fn credibility(db: f32) -> f32 {
    ((db - 1.0) / 9.0).clamp(0.15, 1.0)
}

impl Evidence {
    /// Sorts and weighs the echoes of a scan in the depth plane.
    pub fn new(echoes: &[Echo], mount_height: f32) -> Self {
        let mut evidence = Self {
            mount_height,
            ..Self::default()
        };
        for e in echoes {
            let side_lobe_floor = e.range_m < UNSEEN_FLOOR && e.y > 0.05 && e.db < 15.0;
            let weight = credibility(e.db) * if side_lobe_floor { 0.4 } else { 1.0 };
            // The list is as long as the echoes'.
            let _ = evidence.marks.push(Mark {
                x: e.x,
                y: e.y,
                sigma: math::hypot(0.010, e.range_m * 0.5 * RAD_PER_DEG),
                weight,
                db: e.db,
                range: e.range_m,
                width: e.width,
            });
        }
        evidence.marks.sort_unstable_by(|a, b| a.x.total_cmp(&b.x));
        evidence.gather();
        evidence
    }

    /// Gathers columns around the strongest echoes left.
    fn gather(&mut self) {
        let mut taken = [false; MAX_ECHOES];
        for (mark, taken) in self.marks.iter().zip(&mut taken) {
            *taken = mark.x <= X_MIN;
        }
        loop {
            let left = self.marks.iter().zip(&taken).filter(|(_, taken)| !**taken);
            let Some((centre, _)) = left.max_by(|(a, _), (b, _)| a.db.total_cmp(&b.db)) else {
                break;
            };
            let (x, db) = (centre.x, centre.db);
            let mut column = Column {
                x,
                weight: 0.01 * db,
                first: usize::MAX,
                end: 0,
            };
            for (k, (mark, taken)) in self.marks.iter().zip(&mut taken).enumerate() {
                if !*taken && (mark.x - x).abs() <= COLUMN {
                    *taken = true;
                    column.first = column.first.min(k);
                    column.end = k + 1;
                    if mark.y > 0.03 {
                        column.weight += mark.weight;
                    }
                }
            }
            if self.columns.push(column).is_err() {
                break;
            }
        }
        self.columns.sort_unstable_by(|a, b| a.x.total_cmp(&b.x));
    }

    /// Index of the first mark beyond `x`.
    pub fn beyond(&self, x: f32) -> usize {
        self.marks.partition_point(|m| m.x <= x)
    }
}
