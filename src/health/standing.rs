//! That the chair stands while the mirror turns: echoes keep their phase.
//!
//! The mirror's own echo bears the phase that each chirp began with; an echo's phase against it is that
//! of its range alone, 4π R / λ. From one row to the next it stays, for the beam's axis turns about a
//! point on the mirror, unless chair or scatterer moves: a millimetre is two thirds of a turn at
//! 94 GHz. What is told is the mean of 1 - cos φ over φ, the turns between neighbouring rows.

use super::sign::{Sign, units};
use crate::params::current as p;
use crate::signal::grid::PolarMap;
use crate::verdict::Reason;

/// Rows for which one echo is followed: less than a lobe.
const FOLLOWED: u8 = 8;
/// Parts of a degree in which turns are told.
const PARTS: f32 = 100.0;
/// More of these on the mean is a chair that moves.
fn limit() -> i32 {
    (PARTS * p().phase_turned_deg) as i32
}
/// A chair is seen to stand where the turns' mean phasor is so long: they spread by 26 degrees at most.
const TOGETHER: f32 = 0.9;

/// How much echoes turned from row to row of one scan.
#[derive(Clone, Debug)]
pub struct Standing {
    /// The stored bin that is followed, and for how many rows still.
    bin: u8,
    left: u8,
    /// The row before, and its echo against the mirror's there; zero where there was none.
    row: u16,
    before: [f32; 2],
    /// Sum of the turns' cosines and sines, and how many.
    sum: [f32; 2],
    turns: u16,
}

impl Standing {
    pub const fn new() -> Self {
        Self {
            bin: 0,
            left: 0,
            row: 0,
            before: [0.0; 2],
            sum: [0.0; 2],
            turns: 0,
        }
    }

    /// Takes in row `k`, which stands in `map`. `phasors` gives the echo in a stored bin and that of the
    /// mirror, `strongest` is the bin to follow when another one has faded, `noise` the rows' lower
    /// quartile.
    #[inline(never)]
    pub fn row(
        &mut self,
        map: &PolarMap,
        k: u16,
        phasors: impl Fn(u8) -> [[f32; 2]; 2],
        strongest: u8,
        noise: i32,
    ) {
        let seen = i32::from(map.cell(k.into(), self.bin.into())) > noise + units(p().phase_db);
        let now = if seen {
            let [echo, mirror] = phasors(self.bin);
            times_conjugate(echo, mirror)
        } else {
            [0.0; 2]
        };
        let turned = times_conjugate(now, self.before);
        let size = crate::math::sqrt(turned[0] * turned[0] + turned[1] * turned[1]);
        if size > 0.0 && k.abs_diff(self.row) == 1 {
            self.sum = [
                self.sum[0] + turned[0] / size,
                self.sum[1] + turned[1] / size,
            ];
            self.turns += 1;
        }
        (self.row, self.before) = (k, now);
        self.left = self.left.saturating_sub(1);
        if (self.left == 0 || !seen) && strongest != self.bin {
            (self.bin, self.left, self.before) = (strongest, FOLLOWED, [0.0; 2]);
        }
    }

    /// By how much the echoes turned from row to row, on the mean: parts of a degree; none of too few.
    fn turned(&self) -> Option<i32> {
        let [cos, sin] = self.sum;
        let degrees = crate::math::atan2(sin.abs(), cos) / crate::math::RAD_PER_DEG;
        let enough = self.turns >= p().phase_turns as u16;
        enough.then_some((PARTS * degrees) as i32)
    }

    /// Whether enough of the echoes show that nothing moved: on the mean they hardly turn, and no more one by one,
    /// as they do while a chair drives so fast that the mean says nothing.
    pub fn stood(&self) -> bool {
        let together = self.sum[0] >= TOGETHER * f32::from(self.turns);
        together && self.turned().is_some_and(|turned| turned < limit())
    }

    /// What the echoes tell.
    pub fn signs(&self, each: &mut dyn FnMut(Sign)) {
        each(Sign {
            reason: Reason::Moving,
            seen: self.turned().unwrap_or(0),
            limit: limit(),
        });
    }
}

/// a · b*.
fn times_conjugate(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0] * b[0] + a[1] * b[1], a[1] * b[0] - a[0] * b[1]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;
    use crate::math::sin_cos;

    /// An echo in bin 40 whose phase is `phase(row)`, followed over `rows` rows of chirps that begin anywhere.
    fn followed(rows: u16, phase: impl Fn(u16) -> f32) -> Standing {
        let mut map = Box::new(PolarMap::new());
        map.begin(&Config::default()).unwrap();
        let mut standing = Standing::new();
        for k in 0..rows {
            map.fill(k.into(), |row| row.cells[40] = 200);
            let begun = 1.7 * f32::from(k) % core::f32::consts::TAU;
            let at = |angle: f32| {
                let (sin, cos) = sin_cos(angle);
                [900.0 * cos, 900.0 * sin]
            };
            let phasors = |bin| {
                assert_eq!(bin, 40);
                [at((begun + phase(k)) % core::f32::consts::TAU), at(begun)]
            };
            standing.row(&map, k, phasors, 40, 80);
        }
        standing
    }

    /// What is seen of it.
    fn seen(phase: impl Fn(u16) -> f32) -> i32 {
        let mut seen = -1;
        followed(60, phase).signs(&mut |sign| seen = sign.seen);
        seen
    }

    #[test]
    fn a_standing_scene_keeps_its_phase_whatever_the_chirps_begin_with() {
        let still = seen(|_| 1.0);
        assert!(still < 10, "{still}");
        let speckle = seen(|k| if k % 4 < 2 { 0.0 } else { 0.5 });
        assert!(speckle < 100, "{speckle}");
    }

    #[test]
    fn a_creep_turns_it_on_and_on() {
        let creep = seen(|k| 0.2 * f32::from(k));
        assert!((creep - 1_146).abs() < 10, "{creep}");
        let back = seen(|k| 100.0 - 0.2 * f32::from(k));
        assert!((back - 1_146).abs() < 10, "{back}");
    }

    #[test]
    fn a_chair_is_seen_to_stand_by_enough_echoes_that_keep_their_phase() {
        let speckle = |k| if k % 4 < 2 { 0.0 } else { 0.5 };
        assert!(followed(60, |_| 1.0).stood() && followed(60, speckle).stood());
        assert!(!followed(12, |_| 1.0).stood(), "too few");
        assert!(!followed(60, |k| 0.2 * f32::from(k)).stood(), "a creep");
        // So fast that the turns are of any size, though they go by nothing in the mean.
        let fast = |k: u16| [0.0, 1.2, 1.2, 0.0][usize::from(k % 4)];
        assert!(seen(fast) < 400 && !followed(60, fast).stood());
    }
}
