//! Expected places of a staircase's point features, and the visible part of its risers.

use super::feature::{Class, FeaturePlace, Spot};
use super::kinds::wall;
use super::points::Model;
use super::sight::sight_m;
use super::staircase::Staircase;
use crate::math;
use crate::params::posterior::{self, FRESNEL_M, TREAD_THICK_M};
use heapless::Vec;

impl Model<'_> {
    /// Whether a place at horizontal distance `x` and height `y` above the ground, metres, lies in the scanned sector
    /// and range.
    pub fn in_scan(&self, x: f32, y: f32) -> bool {
        let slope = (y - self.height_m) / math::max(x, posterior::MIN_X_M);
        slope < self.view.highest
            && slope > self.view.lowest
            && math::hypot(x, y - self.height_m) < self.view.farthest_m
    }

    /// Returns the heights above the ground of the lower and the upper end of the visible part of riser `k`'s face,
    /// metres.
    pub fn face_span(&self, s: &Staircase, k: usize) -> (f32, f32) {
        let (top, base) = (s.level(k + 1), s.level(k));
        if s.open {
            return (top - TREAD_THICK_M, top);
        }
        let edge = if k > 0 { s.x(k - 1) } else { f32::INFINITY };
        (sight_m(self.height_m, s.x(k), base, edge), top)
    }

    /// Returns the expected places of riser `k`'s point features that lie in the scanned sector; `k` may be the wall
    /// behind the last riser.
    #[inline(never)]
    pub fn places(&self, s: &Staircase, k: usize) -> Vec<FeaturePlace, { posterior::FEATURES }> {
        let mut places = Vec::new();
        let h = self.height_m;
        let (x, b, t) = (s.x(k), s.level(k), s.level(k + 1));
        let mut push = |class, x_m: f32, y_m: f32, separation_cells| {
            if self.in_scan(x_m, y_m) {
                let range_m = math::hypot(x_m, y_m - h);
                let _ = places.push(FeaturePlace {
                    class,
                    x_m,
                    y_m,
                    range_m,
                    separation_cells,
                });
            }
        };
        if k >= s.len() {
            let b = if s.open { 0.0 } else { b };
            if s.wall_m.is_finite() {
                for feature in wall::features(b, h).into_iter().flatten() {
                    push(
                        feature.class,
                        s.wall_m,
                        feature.y_m,
                        feature.separation_cells,
                    );
                }
            }
        } else if s.open {
            let class = if t < h {
                Class::EdgeBelow
            } else {
                Class::EdgeAbove
            };
            push(class, x, t, 2.0);
        } else if b < h - posterior::SEES_FOOT_M {
            let edge = x - s.overhang_m;
            if t > h {
                push(Class::Corner, x, b, self.separation_cells(x, b, x, h));
                let margin = math::min(t - h, h - b) / FRESNEL_M;
                push(Class::Flash, x, h, math::min(margin, 2.0));
                if t > h + posterior::TOP_ABOVE_M {
                    push(Class::Top, edge, t, self.separation_cells(edge, t, x, h));
                }
            } else {
                let separation_cells = self.separation_cells(x, b, edge, t);
                push(Class::Corner, x, b, separation_cells);
                push(Class::Nosing, edge, t, separation_cells);
            }
        } else {
            let (low, top) = self.face_span(s, k);
            if top > low {
                let room = math::min((top - low) / posterior::HIDDEN_ROOM_M, 2.0);
                push(Class::Hidden, x, 0.5 * (low + top), room);
            }
        }
        places
    }

    /// Returns the product of two places' ranges and the sine of the angle from the first one up to the second, m².
    pub fn cross_m2(&self, a: Spot, b: Spot) -> f32 {
        a.x_m * (b.y_m - self.height_m) - (a.y_m - self.height_m) * b.x_m
    }

    /// Returns the distance between two features in resolution cells, of angle (beam width) and of range together, at
    /// most 2.
    fn separation_cells(&self, x: f32, y: f32, other_x: f32, other_y: f32) -> f32 {
        let range = math::hypot(x, y - self.height_m);
        let cross = self.cross_m2(Spot::new(x, y), Spot::new(other_x, other_y))
            / math::max(range, posterior::MIN_RANGE_M);
        let other = math::hypot(other_x, other_y - self.height_m);
        let angle = cross / math::max(range, posterior::MIN_RANGE_M) / self.beam_rad;
        math::min(math::hypot(angle, (other - range) / self.cell_m), 2.0)
    }

    /// Returns the SNR, dB, of the strongest echo of the riser before riser `k`, its flash left out; without a riser
    /// before, the SNR of a faint riser.
    pub fn level_before(&self, s: &Staircase, k: usize) -> f32 {
        if k == 0 || k >= s.len() {
            return posterior::FAINT_DB;
        }
        let x = s.x(k - 1);
        let near = self
            .between(x - posterior::SHOWN_WITHIN_M, x + posterior::SHOWN_WITHIN_M)
            .iter();
        let apart = near.filter(|e| (e.y_m - self.height_m).abs() > posterior::FLASH_WITHIN_M);
        apart
            .map(|e| e.snr_db)
            .fold(posterior::SHOWS_NOTHING_DB, math::max)
    }
}
