//! The echoes as marks for the search: with position, credibility and standard deviations, sorted, grouped into
//! columns.

use crate::math;
use crate::params::Params;
use crate::signal::echoes::{Echo, MAX_ECHOES};
use crate::sort::shell_sort;
use heapless::Vec;

/// Maximum number of columns (places where a face may stand).
pub const MAX_COLUMNS: usize = 32;

/// One echo as the search uses it: its place, standard deviations, SNR, width and credibility.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mark {
    /// Horizontal distance of the echo from the mirror, metres.
    pub x_m: f32,
    /// Height of the echo above the ground, metres.
    pub y_m: f32,
    /// Index of the mark's echo in the scan's list of echoes.
    pub echo: u8,
    /// Position of the echo along the line of sight to the faces that look at the mirror, metres: horizontal distance
    /// for risers, depth below the mirror for treads.
    pub along_m: f32,
    /// Standard deviation of the echo's horizontal distance, metres.
    pub x_sigma_m: f32,
    /// Standard deviation of the echo's height, metres.
    pub y_sigma_m: f32,
    /// Credibility of the echo, 0…1, a factor on its score gains and costs: small near the noise, 1 well above it.
    pub credibility: f32,
    /// Power of the echo over the noise, dB.
    pub snr_db: f32,
    /// Range of the echo from the mirror, metres.
    pub range_m: f32,
    /// Angular width of the echo, in units of a point scatterer's.
    pub width: f32,
    /// Score gain if the echo is part of the floor, nats, before the credibility is applied; 0 going down.
    pub floor_nats: f32,
}

/// A place of a possible face that looks at the mirror: echoes above one another on a riser, or beside one another on
/// a tread.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Column {
    /// Position of the column's strongest echo along the line of sight, metres: horizontal distance for risers.
    pub along_m: f32,
    /// Sum of the credibilities (0…1 each) of the column's echoes that lie off the floor.
    pub credibility: f32,
    /// Whether a flight may begin at this column: one of its echoes lies off the ground, or is on the ground and as
    /// strong as a corner.
    pub begins: bool,
}

/// All echoes sorted along the line of sight, and the columns among them.
#[derive(Debug)]
pub struct Scene<'p> {
    /// All echoes, sorted by [`Mark::along_m`].
    pub marks: Vec<Mark, MAX_ECHOES>,
    /// The columns of echoes, sorted by [`Column::along_m`]; none going down.
    pub columns: Vec<Column, MAX_COLUMNS>,
    /// Mounting height of the mirror above the ground, metres.
    pub mount_height_m: f32,
    /// Tuned parameters of the estimator.
    pub params: &'p Params,
}

/// Returns the score gain `nats`, reduced by half the square of the deviation `z`, which is in standard deviations; at
/// least 0.
pub fn gain(nats: f32, z: f32) -> f32 {
    math::max(nats - 0.5 * z * z, 0.0)
}

impl Mark {
    /// Returns a mark of echo `e`, number `echo` of the scan, with the fields that do not depend on the scanned plane;
    /// the others are 0.
    fn new(echo: u8, e: &Echo) -> Self {
        Self {
            echo,
            x_m: e.x_m,
            y_m: e.y_m,
            snr_db: e.snr_db,
            range_m: e.range_m,
            width: e.width,
            ..Self::default()
        }
    }
}

impl<'p> Scene<'p> {
    /// Returns a scene without echoes. They are filled in place, since they are too large for a small stack.
    pub fn new(mount_height_m: f32, params: &'p Params) -> Self {
        Self {
            marks: Vec::new(),
            columns: Vec::new(),
            mount_height_m,
            params,
        }
    }

    /// Takes in the echoes of the depth plane, and groups echoes above one another into columns.
    #[inline(never)]
    pub fn risers(&mut self, echoes: &[Echo]) {
        let p = self.params;
        let marks = (0..).zip(echoes).map(|(k, e)| {
            let y_sigma_m = math::hypot(p.height_sigma_m, e.range_m * p.height_sigma_rad);
            Mark {
                along_m: e.x_m,
                y_sigma_m,
                floor_nats: gain(p.tread_nats, e.y_m / y_sigma_m),
                credibility: p.credibility(e.snr_db),
                ..Mark::new(k, e)
            }
        });
        self.group_columns(marks, p.column_m, p.nearest_riser_m);
    }

    /// Takes in the echoes of the height plane, without columns.
    pub fn treads(&mut self, echoes: &[Echo]) {
        for (k, e) in (0..).zip(echoes) {
            // Cannot fail: there are as many marks as echoes.
            let _ = self.marks.push(Mark {
                along_m: self.mount_height_m - e.y_m,
                credibility: self.params.credibility(e.snr_db),
                ..Mark::new(k, e)
            });
        }
    }

    /// Stores and sorts the marks, and groups columns of half-width `width`, metres, around the strongest remaining
    /// ones. Marks nearer than `nearest`, metres, are in no column.
    fn group_columns(&mut self, marks: impl Iterator<Item = Mark>, width: f32, nearest: f32) {
        for mark in marks {
            // Cannot fail: there are as many marks as echoes.
            let _ = self.marks.push(mark);
        }
        shell_sort(&mut self.marks, |a, b| a.along_m < b.along_m);
        let mut taken = [false; MAX_ECHOES];
        for (mark, taken) in self.marks.iter().zip(&mut taken) {
            *taken = mark.along_m <= nearest;
        }
        loop {
            let left = self.marks.iter().zip(&taken).filter(|(_, taken)| !**taken);
            let strongest = left.max_by(|(a, _), (b, _)| a.snr_db.total_cmp(&b.snr_db));
            let Some((centre, _)) = strongest else { break };
            let mut column = Column {
                along_m: centre.along_m,
                credibility: 0.0,
                begins: self.is_corner_level(centre),
            };
            for (mark, taken) in self.marks.iter().zip(&mut taken) {
                if !*taken && (mark.along_m - column.along_m).abs() <= width {
                    *taken = true;
                    if mark.y_m.abs() > self.params.floor_reach_m {
                        column.credibility += mark.credibility;
                        column.begins = true;
                    }
                }
            }
            if self.columns.push(column).is_err() {
                break;
            }
        }
        shell_sort(&mut self.columns, |a, b| a.along_m < b.along_m);
    }

    /// Whether an echo's SNR exceeds that of the echoes on the ground before it by as much as a corner's does.
    fn is_corner_level(&self, centre: &Mark) -> bool {
        let p = self.params;
        let before = self.between(
            centre.along_m - p.corner_before_m,
            centre.along_m - p.column_m,
        );
        let mut rest = before.iter().filter(|m| m.y_m.abs() < p.floor_reach_m);
        centre.snr_db > p.corner_least_db
            && rest.all(|m| m.snr_db + p.corner_outshines_db < centre.snr_db)
    }

    /// Returns the index of the first mark whose position along the line of sight is beyond `along`, metres.
    pub fn first_beyond(&self, along: f32) -> usize {
        self.marks.partition_point(|m| m.along_m <= along)
    }

    /// Returns the marks with `from` < [`Mark::along_m`] ≤ `to`, metres.
    pub fn between(&self, from: f32, to: f32) -> &[Mark] {
        let (first, end) = (self.first_beyond(from), self.first_beyond(to));
        self.marks.get(first..end).unwrap_or(&[])
    }

    /// Returns the index of the first mark near a face at `along`, metres, and that of the first mark behind those near
    /// it.
    pub fn near_range(&self, along: f32) -> (usize, usize) {
        let p = self.params;
        let from = math::max(along - p.column_m, p.nearest_riser_m);
        (
            self.first_beyond(from),
            self.first_beyond(along + p.column_m),
        )
    }
}
