//! Check that the chair stands while the mirror turns: echoes keep their phase from row to row.
//!
//! The mirror's own echo has the phase that each chirp began with. An echo's phase relative to it is that of its range
//! alone, 4π R / λ. It stays from one row to the next unless chair or scatterer moves, because the beam's axis turns
//! about a point on the mirror. At 94 GHz a millimetre of range is two thirds of a turn. The measured value of the
//! check is the angle of the mean phasor of the phase changes between neighbouring rows.

use super::check::{CheckResult, units};
use crate::params::Numbers;
use crate::params::health::MIN_COHERENCE;
use crate::signal::grid::PolarMap;
use crate::verdict::Reason;

/// Number of rows for which the echo in one bin is followed: fewer than those of a main lobe.
const FOLLOWED: u8 = 8;
/// Number of steps per degree in which phase changes are reported.
const PER_DEGREE: f32 = 100.0;

/// Phase changes of echoes from row to row of one scan.
#[derive(Clone, Debug)]
pub struct Standing {
    /// Stored bin whose echo is followed, and the number of rows left until another bin is chosen.
    bin: u8,
    remaining: u8,
    /// Index of the row before, and the phasor of the followed echo in it relative to the mirror's echo; zero where
    /// there was no echo.
    row: u16,
    before: [f32; 2],
    /// Sums of the cosines and of the sines of the phase changes, and number of phase changes.
    sum: [f32; 2],
    phase_changes: u16,
    numbers: Numbers,
}

impl Standing {
    pub const fn new(numbers: Numbers) -> Self {
        Self {
            bin: 0,
            remaining: 0,
            row: 0,
            before: [0.0; 2],
            sum: [0.0; 2],
            phase_changes: 0,
            numbers,
        }
    }

    /// Returns the maximum mean phase change from row to row of a standing chair, 1/100 degree.
    fn limit(&self) -> i32 {
        (PER_DEGREE * self.numbers.phase_turned_deg) as i32
    }

    /// Adds row `k` of `map`. `phasors` returns the phasors of a stored bin and of the mirror's echo, `strongest` is
    /// the bin to follow when the present one has faded, `noise` the running mean of the rows' lower quartiles, map
    /// units.
    #[inline(never)]
    pub fn row(
        &mut self,
        map: &PolarMap,
        k: u16,
        phasors: impl Fn(u8) -> [[f32; 2]; 2],
        strongest: u8,
        noise: i32,
    ) {
        let seen =
            i32::from(map.cell(k.into(), self.bin.into())) > noise + units(self.numbers.phase_db);
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
            self.phase_changes += 1;
        }
        (self.row, self.before) = (k, now);
        self.remaining = self.remaining.saturating_sub(1);
        if (self.remaining == 0 || !seen) && strongest != self.bin {
            (self.bin, self.remaining, self.before) = (strongest, FOLLOWED, [0.0; 2]);
        }
    }

    /// Returns the magnitude of the mean phase change from row to row, 1/100 degree; `None` with fewer than
    /// `phase_turns` changes.
    fn phase_change(&self) -> Option<i32> {
        let [cos, sin] = self.sum;
        let degrees = crate::math::atan2(sin.abs(), cos) / crate::math::RAD_PER_DEG;
        let enough = self.phase_changes >= self.numbers.phase_turns as u16;
        enough.then_some((PER_DEGREE * degrees) as i32)
    }

    /// Returns whether enough echoes show that nothing moved: their mean phase change is small, and the single
    /// changes are alike. On a chair that drives fast the single changes spread, though their mean may be
    /// small.
    pub fn stood(&self) -> bool {
        let together = self.sum[0] >= MIN_COHERENCE * f32::from(self.phase_changes);
        together
            && self
                .phase_change()
                .is_some_and(|turned| turned < self.limit())
    }

    /// Calls `each` with the check's result: the magnitude of the mean phase change from row to row, 1/100 degree, 0
    /// with too few changes.
    pub fn report_checks(&self, each: &mut dyn FnMut(CheckResult)) {
        each(CheckResult {
            reason: Reason::Moving,
            value: self.phase_change().unwrap_or(0),
            limit: self.limit(),
        });
    }
}

/// Returns the complex product a · b*, of the complex numbers a and b as [real, imaginary].
fn times_conjugate(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0] * b[0] + a[1] * b[1], a[1] * b[0] - a[0] * b[1]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;
    use crate::math::sin_cos;

    /// Returns the check's state after `rows` rows with an echo in bin 40 whose phase is `phase(row)`; each chirp
    /// begins with another phase.
    fn followed(rows: u16, phase: impl Fn(u16) -> f32) -> Standing {
        let mut map = Box::new(PolarMap::new());
        map.begin(&Config::default()).unwrap();
        let mut standing = Standing::new(Numbers::DEFAULT);
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

    /// Returns the measured value of the check after 60 rows, 1/100 degree.
    fn seen(phase: impl Fn(u16) -> f32) -> i32 {
        let mut seen = -1;
        followed(60, phase).report_checks(&mut |check| seen = check.value);
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
        // So fast that single phase changes are large, though their mean is small.
        let fast = |k: u16| [0.0, 1.2, 1.2, 0.0][usize::from(k % 4)];
        assert!(seen(fast) < 400 && !followed(60, fast).stood());
    }
}
