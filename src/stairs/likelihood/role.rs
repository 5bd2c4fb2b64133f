//! The likelihood model: what each echo may be if a flight of stairs stands there.
//!
//! A hypothesis is a list of risers. It is scored in nats: every echo takes the role in which it
//! fits best and adds that role's gain less half its squared normalised deviation, times its
//! credibility; echoes that contradict the hypothesis cost; so does what should be seen and is not.
//! The score falls into one part a riser (with the tread before it) and one for what lies behind the
//! last, so that flights with the same beginning share its score.

use super::evidence::{COLUMN, Evidence, Mark, X_MIN};

/// An echo at a place known in x and y: corner, nosing, flash.
const POINT: f32 = 5.4;
/// Between them, on the riser.
const FACE: f32 = 2.5;
/// On a tread or the floor.
const TREAD: f32 = 1.1;
/// A corner 8 dB above everything else on its tread.
const BRIGHT: f32 = 1.1;
/// An echo inside the solid.
const INSIDE: f32 = 2.1;
/// An echo above the top of its own riser.
const ABOVE: f32 = 3.3;
/// An echo standing on a tread, or on the floor in front.
const CLUTTER: f32 = 2.5;
/// Anything else that the hypothesis does not explain.
const STRAY: f32 = 0.4;
/// Each further riser must pay for itself.
const STEP: f32 = 1.25;
/// A closed riser whose inner corner is not seen.
const NO_CORNER: f32 = 1.8;
/// A riser whose upper end is not seen.
const NO_TOP: f32 = 1.5;
/// A riser without any echo.
const NOTHING: f32 = 2.5;
/// Departure of a riser from the line of its predecessors, per (1.5 cm)².
const IRREGULAR: f32 = 0.35;
/// Second and further echoes in the same role count this much.
const AGAIN: f32 = 0.3;

/// Gain of an echo `z` standard deviations off its role's place.
fn gain(role: f32, z: f32) -> f32 {
    (role - 0.5 * z * z).max(0.0)
}

/// A riser and the tread before it.
#[derive(Clone, Copy, Debug)]
pub struct Riser {
    /// Where the riser before stands; `None` for the first.
    pub previous_x: Option<f32>,
    /// Where this one stands.
    pub x: f32,
    /// Level at its foot.
    pub base: f32,
    /// Level at its top.
    pub top: f32,
    /// Whether there is nothing below the treads (a floating stair).
    pub open: bool,
}

impl Evidence {
    /// Lowest height that can be seen at `x` behind a nosing at (`edge_x`, `edge_y`).
    fn sight(&self, x: f32, edge_x: Option<f32>, edge_y: f32) -> f32 {
        match edge_x {
            Some(edge_x) if edge_y >= self.mount_height => {
                self.mount_height + (edge_y - self.mount_height) * x / edge_x
            }
            _ => edge_y,
        }
    }

    /// Marks with `from` < x ≤ `to`.
    fn between(&self, from: f32, to: f32) -> &[Mark] {
        let (a, b) = (self.beyond(from), self.beyond(to));
        self.marks.get(a..b).unwrap_or(&[])
    }

    /// Score of the tread in front of a riser (or of the landing, `riser_x` infinite) and the
    /// strongest echo on it near the riser, dB.
    fn tread(&self, previous_x: Option<f32>, riser_x: f32, level: f32, open: bool) -> (f32, f32) {
        let height = self.mount_height;
        let from = previous_x.map_or(X_MIN, |x| x + COLUMN);
        let (mut total, mut strongest) = (0.0, 3.0f32);
        for m in self.between(from, riser_x - COLUMN) {
            let low = self.sight(m.x, previous_x, level);
            let z = (m.y - level) / m.sigma;
            let on = self.on_tread(m, level, open);
            if on > 0.0 {
                total += on * m.weight;
                if z.abs() < 2.5 && m.x > riser_x - 0.35 {
                    strongest = strongest.max(m.db);
                }
            } else if m.y < low - 0.02 - 2.0 * m.sigma {
                total -= INSIDE * m.weight;
            } else if m.y > level + 0.03 + m.sigma
                && riser_x.is_finite()
                && (m.y - height).abs() > 0.03
            {
                total -= CLUTTER * m.weight;
            } else {
                total -= STRAY * m.weight;
            }
        }
        (total, strongest)
    }

    /// Gain of a mark as part of the tread at `level`, or of the floor seen through an open stair.
    fn on_tread(&self, m: &Mark, level: f32, open: bool) -> f32 {
        let on = if level < self.mount_height {
            gain(TREAD, (m.y - level) / m.sigma)
        } else {
            0.0
        };
        if open {
            on.max(gain(TREAD, m.y / m.sigma))
        } else {
            on
        }
    }

    /// Score of everything behind the last riser of a flight.
    pub fn landing(&self, last_x: Option<f32>, level: f32, open: bool) -> f32 {
        self.tread(last_x, f32::INFINITY, level, open).0
    }

    /// Score of one riser and the tread before it.
    pub fn riser(&self, riser: &Riser) -> f32 {
        let height = self.mount_height;
        let Riser {
            previous_x,
            x,
            base,
            top,
            open,
        } = *riser;
        let (mut total, brightest_on_tread) = self.tread(previous_x, x, base, open);
        let (mut corner, mut nosing, mut edge, mut corner_db) = (0.0f32, 0.0f32, 0.0f32, -99.0f32);
        let marks = self.between((x - COLUMN).max(X_MIN), x + COLUMN);
        let hidden_foot = base > height - 0.01;
        for m in marks {
            let (s, w) = (m.sigma, m.weight);
            let low = self.sight(m.x, previous_x, base);
            let flash = base - 0.02 < height
                && height < top + 0.03
                && (m.y - height).abs() < 0.01 + 2.0 * s;
            if m.y > top + 0.015 + 2.0 * s && !flash {
                let cost = if (m.y - height).abs() < 0.03 && previous_x.is_some() {
                    STRAY
                } else {
                    ABOVE
                };
                total -= cost * w;
                continue;
            }
            if m.y < low - 0.02 - 2.0 * s {
                let on = self.on_tread(m, base, open);
                total += if on > 0.0 { on * w } else { -INSIDE * w };
                continue;
            }
            if hidden_foot {
                // From the sight line over the last nosing up to its own.
                let z = (m.y - top).max(low - m.y).max(0.0) / s;
                let g = (POINT - 0.5 * z * z) * w;
                if g > nosing {
                    nosing = g;
                    edge = g;
                }
                continue;
            }
            let as_corner = if open {
                0.0
            } else {
                gain(POINT, (m.y - base) / s) * w
            };
            let mut as_top = if flash {
                POINT * w
            } else {
                gain(POINT, (m.y - top) / s) * w
            };
            edge = edge.max(as_top);
            if base + (2.0 * s).max(0.04) < m.y && m.y < top {
                let blend = top - base < 0.105 * x.max(0.3);
                as_top = as_top.max(FACE * w * if blend { 1.4 } else { 1.0 });
                if blend {
                    edge = edge.max(as_top);
                }
            }
            if as_corner > as_top && as_corner > corner {
                total += AGAIN * corner;
                corner = as_corner;
                corner_db = m.db;
            } else if as_top > nosing {
                total += AGAIN * nosing;
                nosing = as_top;
            } else if as_corner > 0.0 || as_top > 0.0 {
                total += AGAIN * as_corner.max(as_top);
            } else {
                total -= STRAY * w;
            }
        }
        total -= STEP;
        if marks.is_empty() {
            return total - NOTHING;
        }
        // A flash's flank hides the corner below it.
        let near_flash = top > height - 0.02 && height - base < 0.13 * x;
        if !open && !hidden_foot && corner < 1.0 && !near_flash {
            total -= NO_CORNER;
        }
        if edge < 0.8 {
            total -= NO_TOP;
        }
        if corner > 1.0 && corner_db > 8f32.max(brightest_on_tread + 8.0) {
            total += BRIGHT;
        }
        total + corner + nosing
    }

    /// Score of ground that rises steadily by `slope` from `from_x` on; slope 0 is the flat floor.
    fn ramp(&self, from_x: f32, slope: f32) -> f32 {
        let mut total = 0.0;
        for m in self.between(X_MIN, f32::INFINITY) {
            let z = (m.y - slope * (m.x - from_x).max(0.0)) / m.sigma;
            let g = TREAD - 0.5 * z * z;
            total += m.weight
                * if g > 0.0 {
                    g
                } else if z < -2.0 {
                    -INSIDE
                } else {
                    -STRAY
                };
        }
        total
    }

    /// Score of the best ramp or flat floor.
    pub fn best_ramp(&self) -> f32 {
        let mut best = f32::NEG_INFINITY;
        // tan of 0° and 3° … 11°
        const SLOPES: [f32; 10] = [
            0.0, 0.0524, 0.0699, 0.0875, 0.1051, 0.1228, 0.1405, 0.1584, 0.1763, 0.1944,
        ];
        for slope in SLOPES {
            for from in 0..10u8 {
                best = best.max(self.ramp(0.3 + 0.1 * f32::from(from), slope));
            }
        }
        best
    }
}

/// Cost of three risers in a row that are not evenly spaced.
pub fn irregularity(a: f32, b: f32, c: f32) -> f32 {
    let d = (c - 2.0 * b + a) / 0.015;
    (IRREGULAR * d * d).min(1.0)
}
