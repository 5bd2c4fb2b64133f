//! The echoes as the assembly sees them: placed, weighed, sorted, gathered into columns.

use super::echo::{Echo, MAX_ECHOES};
use super::role;
use crate::math::{self, RAD_PER_DEG};
use crate::stairs::dimension::sort_key;
use crate::stairs::particles::shell_sort;
use heapless::Vec;

/// Most columns (places where a riser may stand).
pub const MAX_COLUMNS: usize = 32;
/// Echoes this close in x belong to one riser, metres: nosings overhang by up to 4 cm.
pub const COLUMN: f32 = 0.045;
/// Echoes this close in height belong to one tread, metres.
pub const ROW: f32 = 0.025;
/// Height below which an echo may be ground, metres.
const ON_GROUND: f32 = 0.03;
/// A corner outshines the ground this far before it, metres …
const BEFORE: f32 = 0.35;
/// … by this much, dB.
const SHINES_DB: f32 = 5.0;
/// A weaker echo on the ground is no corner, dB.
const CORNER_DB: f32 = 14.0;
/// Weaker echoes in the height plane are left out, dB.
const FAINTEST_TREAD_DB: f32 = 3.0;
/// Octaves of amplitude in a decibel.
const DB_TO_OCTAVE: f32 = 1.0 / 6.020_6;
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
    /// Which echo of the list it is.
    pub echo: u8,
    /// Along the line of sight of the faces that look at the mirror, metres: x for risers, the
    /// depth below the mirror for treads.
    pub along: f32,
    /// Standard deviation of the horizontal distance, metres.
    pub sigma_x: f32,
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
    /// Gain as part of the floor, credibility left out; going up only.
    pub floor: f32,
}

/// A place where a face may stand that looks at the mirror: echoes above one another on a riser,
/// or beside one another on a tread.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Column {
    /// Of its strongest echo, metres.
    pub along: f32,
    /// Sum of the credibilities of what does not lie on the floor.
    pub weight: f32,
    /// Whether a flight may begin here: something stands off the ground, or a corner shines.
    pub begins: bool,
    /// Its echoes: from this mark …
    pub first: usize,
    /// … up to but without this one.
    pub end: usize,
}

/// Cells of the index over the marks …
const CELLS: usize = 128;
/// … and how many of them a metre has: few of them hold two marks.
const CELLS_PER_M: f32 = 40.0;

/// All echoes in order of where they lie along the line of sight, and the columns among them.
#[derive(Debug)]
pub struct Evidence {
    /// In order of [`Mark::along`].
    pub marks: Vec<Mark, MAX_ECHOES>,
    /// Number of marks short of each cell.
    starts: [u8; CELLS],
    /// In order of [`Column::along`].
    pub columns: Vec<Column, MAX_COLUMNS>,
    /// Mirror above the ground, metres.
    pub mount_height: f32,
}

impl Mark {
    /// What does not depend on the plane.
    fn new(echo: u8, e: &Echo) -> Self {
        Self {
            echo,
            x: e.x,
            y: e.y,
            db: e.db,
            range: e.range_m,
            width: e.width,
            ..Self::default()
        }
    }
}

/// How far an echo is believed: none at the noise, wholly from 10 dB on.
pub fn credibility(db: f32) -> f32 {
    ((db - 1.0) / 9.0).clamp(0.15, 1.0)
}

/// Which cell of the index a place falls into; it never falls as the place grows, and what lies
/// before the mirror is in the first.
fn index(along: f32) -> usize {
    (along * CELLS_PER_M) as usize
}

impl Evidence {
    /// Nothing yet.
    pub fn new(mount_height: f32) -> Self {
        Self {
            marks: Vec::new(),
            starts: [0; CELLS],
            columns: Vec::new(),
            mount_height,
        }
    }

    /// Risers: columns of echoes above one another, in the depth plane.
    #[inline(never)]
    pub fn risers(&mut self, echoes: &[Echo]) {
        let marks = (0..).zip(echoes).map(|(k, e)| {
            let side_lobe_floor = e.range_m < UNSEEN_FLOOR && e.y > 0.05 && e.db < 15.0;
            let sigma = math::hypot(0.010, e.range_m * 0.5 * RAD_PER_DEG);
            Mark {
                along: e.x,
                sigma,
                floor: role::floor(e.y, sigma),
                weight: credibility(e.db) * if side_lobe_floor { 0.4 } else { 1.0 },
                ..Mark::new(k, e)
            }
        });
        self.gather(marks, COLUMN, X_MIN);
    }

    /// Treads: rows of echoes beside one another, in the height plane.
    #[inline(never)]
    pub fn treads(&mut self, echoes: &[Echo]) {
        let mount_height = self.mount_height;
        let below = (0..)
            .zip(echoes)
            .filter(|(_, e)| e.y < 0.06 && e.db > FAINTEST_TREAD_DB);
        let marks = below.map(|(k, e)| {
            let (sin, cos) = math::sin_cos(e.angle_rad);
            let arc = e.range_m * (0.2 + math::exp2(e.db * -DB_TO_OCTAVE)) * RAD_PER_DEG;
            Mark {
                along: mount_height - e.y,
                sigma_x: math::hypot(0.012, arc * cos),
                sigma: math::hypot(0.004, arc * sin),
                weight: credibility(e.db + 1.5),
                ..Mark::new(k, e)
            }
        });
        self.gather(marks, ROW, 0.0);
    }

    /// Sorts the marks and gathers columns around the strongest ones left; what lies nearer than
    /// `nearest` is in none.
    fn gather(&mut self, marks: impl Iterator<Item = Mark>, width: f32, nearest: f32) {
        self.marks.clear();
        self.columns.clear();
        for mark in marks {
            // As many as there are echoes at most.
            let _ = self.marks.push(mark);
        }
        shell_sort(&mut self.marks, |m| sort_key(m.along));
        let mut short = 0;
        for (cell, start) in self.starts.iter_mut().enumerate() {
            let rest = self.marks.get(short..).unwrap_or(&[]);
            short += rest.iter().take_while(|m| index(m.along) < cell).count();
            *start = short as u8;
        }
        let mut taken = [false; MAX_ECHOES];
        for (mark, taken) in self.marks.iter().zip(&mut taken) {
            *taken = mark.along <= nearest;
        }
        loop {
            let left = self.marks.iter().zip(&taken).filter(|(_, taken)| !**taken);
            let Some((centre, _)) = left.max_by(|(a, _), (b, _)| a.db.total_cmp(&b.db)) else {
                break;
            };
            let mut column = Column {
                along: centre.along,
                weight: 0.01 * centre.db,
                begins: self.shines(centre),
                first: usize::MAX,
                end: 0,
            };
            for (k, (mark, taken)) in self.marks.iter().zip(&mut taken).enumerate() {
                if !*taken && (mark.along - column.along).abs() <= width {
                    *taken = true;
                    column.first = column.first.min(k);
                    column.end = k + 1;
                    if mark.y.abs() > ON_GROUND {
                        column.weight += mark.weight;
                        column.begins = true;
                    }
                }
            }
            if self.columns.push(column).is_err() {
                break;
            }
        }
        shell_sort(&mut self.columns, |c| sort_key(c.along));
    }

    /// Whether an echo on the ground outshines what lies before it as a corner does.
    fn shines(&self, centre: &Mark) -> bool {
        let before = self.between(centre.along - BEFORE, centre.along - COLUMN);
        let rest = before.iter().filter(|m| m.y.abs() < ON_GROUND);
        centre.db > CORNER_DB && rest.map(|m| m.db + SHINES_DB).all(|db| db < centre.db)
    }

    /// Number of the first mark beyond `along`.
    pub fn first_beyond(&self, along: f32) -> usize {
        let cell = index(along).min(CELLS - 1);
        let mut number = usize::from(self.starts.get(cell).copied().unwrap_or(0));
        while self.marks.get(number).is_some_and(|m| m.along <= along) {
            number += 1;
        }
        number
    }

    /// Marks with `from` < along ≤ `to`.
    pub fn between(&self, from: f32, to: f32) -> &[Mark] {
        let (first, end) = (self.first_beyond(from), self.first_beyond(to));
        self.marks.get(first..end).unwrap_or(&[])
    }
}
