//! Check of the chair's motion by the phases of the echoes from row to row.
//!
//! The mirror's own echo has the phase that each chirp began with. An echo's phase relative to it is that of its range
//! alone, 4π R / λ. It stays from one row to the next unless chair or scatterer moves, because the beam's axis turns
//! about a point on the mirror. At 94 GHz a millimetre of range is two thirds of a turn: a chair that goes v in the time T
//! of a row turns echoes at the angle θ by 4π v T cos θ / λ. The phase changes of some twenty rows determine the speed to
//! a few millimetres a second, but for multiples of a turn.

use super::check::{CheckResult, units};
use crate::config::RadarConfig;
use crate::drive::PhaseAgreement;
use crate::math;
use crate::motion::same_place_m;
use crate::params::Numbers;
use crate::params::health::MIN_COHERENCE;
use crate::signal::echoes::forward;
use crate::signal::grid::PolarMap;
use crate::track::Track;
use crate::verdict::Reason;

/// Number of rows for which the echo in one bin is followed: fewer than those of a main lobe.
const FOLLOWED: u8 = 8;
/// Number of steps per degree in which phase changes are reported.
const PER_DEGREE: f32 = 100.0;
/// Number of groups of neighbouring rows whose phase changes are summed apart: of 12 rows with the paper's 281, over
/// which cos θ changes by at most 4 %.
const GROUPS: usize = 24;
/// Length of a unit phasor in the groups' sums. A group has at most a [`GROUPS`]th of the rows: see [`Phases::row`].
const UNIT: f32 = 400.0;

/// Phase changes of echoes from row to row of one scan.
#[derive(Clone, Debug)]
pub struct Phases {
    /// Stored bin whose echo is followed, and the number of rows left until another bin is chosen.
    bin: u8,
    remaining: u8,
    /// Index of the row before, and the phasor of the followed echo in it relative to the mirror's echo; zero where
    /// there was no echo.
    row: u16,
    before: [f32; 2],
    /// Sums of the unit phasors of the phase changes towards the next row of the map, by groups of rows.
    groups: [[i16; 2]; GROUPS],
    phase_changes: u16,
    numbers: Numbers,
}

impl Phases {
    /// Returns the state before a scan's first row.
    pub const fn new(numbers: Numbers) -> Self {
        Self {
            bin: 0,
            remaining: 0,
            row: 0,
            before: [0.0; 2],
            groups: [[0; 2]; GROUPS],
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
        let [re, im] = times_conjugate(now, self.before);
        let size = math::sqrt(re * re + im * im);
        let group = usize::from(k) * GROUPS / map.rows().max(1);
        if size > 0.0
            && k.abs_diff(self.row) == 1
            && let Some(sum) = self.groups.get_mut(group)
        {
            let onward = if k > self.row { UNIT } else { -UNIT };
            // A map of more than 1,900 rows saturates, and all phase changes of its group alike.
            sum[0] = sum[0].saturating_add((UNIT * re / size) as i16);
            sum[1] = sum[1].saturating_add((onward * im / size) as i16);
            self.phase_changes += 1;
        }
        (self.row, self.before) = (k, now);
        self.remaining = self.remaining.saturating_sub(1);
        if (self.remaining == 0 || !seen) && strongest != self.bin {
            (self.bin, self.remaining, self.before) = (strongest, FOLLOWED, [0.0; 2]);
        }
    }

    /// Returns the mean phasor of the phase changes from each row to the next one of the map, `[re, im]`, after
    /// `expected` (radians, for the middle row of each group of rows) has been taken out.
    #[inline(never)]
    fn mean(&self, rows: usize, expected: &dyn Fn(f32) -> f32) -> [f32; 2] {
        let (mut re, mut im) = (0.0, 0.0);
        let rows_per_group = rows as f32 / GROUPS as f32;
        let all = (0u8..).zip(&self.groups);
        for (group, &[a, b]) in all.filter(|(_, sum)| **sum != [0; 2]) {
            let middle = (f32::from(group) + 0.5) * rows_per_group - 1.0;
            let (sin, cos) = math::sin_cos(expected(middle) % core::f32::consts::TAU);
            let turned = times_conjugate([a.into(), b.into()], [cos, sin]);
            (re, im) = (re + turned[0], im + turned[1]);
        }
        let all = UNIT * f32::from(self.phase_changes.max(1));
        [re / all, im / all]
    }

    /// Returns the magnitude of the mean phase change from row to row, 1/100 degree; `None` with fewer than
    /// `phase_turns` changes.
    fn phase_change(&self) -> Option<i32> {
        let [re, im] = self.mean(0, &|_| 0.0);
        let degrees = math::atan2(im.abs(), re) / math::RAD_PER_DEG;
        self.enough().then_some((PER_DEGREE * degrees) as i32)
    }

    fn enough(&self) -> bool {
        self.phase_changes >= self.numbers.phase_turns as u16
    }

    /// Returns whether the phases turn as the travel along `track` has it, in a scan of `map` by `radar`. Vibration, and
    /// multiples of a turn within the scan's angles, spread the phase changes: these then say nothing.
    #[inline(never)]
    pub fn agreement(&self, track: &Track, map: &PolarMap, radar: &RadarConfig) -> PhaseAgreement {
        let rows = map.rows();
        let per_metre = -2.0 * core::f32::consts::TAU / radar.wavelength_m();
        let [re, im] = self.mean(rows, &|row| {
            // The cast saturates.
            let ahead = forward(map.geometry(), map.angle_rad(row as usize));
            per_metre * track.per_row(row).travel_m * ahead
        });
        if !self.enough() || math::hypot(re, im) < MIN_COHERENCE {
            return PhaseAgreement::Unknown;
        }
        // What two sweeps tolerate, over the rows of one. In a bin the phase is that of one end of the swept band or of its
        // middle, by what the module calls the beginning of a chirp.
        let travel_m = track.end().travel_m;
        let band = 0.5 * radar.bandwidth_khz as f32 / radar.carrier_khz.max(1) as f32;
        let tolerance_m = (same_place_m(travel_m) + band * travel_m.abs()) / rows.max(1) as f32;
        let off_m = math::atan2(im.abs(), re) / -per_metre;
        match off_m < tolerance_m {
            true => PhaseAgreement::Agrees,
            false => PhaseAgreement::Differs,
        }
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
    use crate::track::RowPose;

    /// Returns the check's state after `rows` rows with an echo in bin 40 whose phase is `phase(row)`, and their map; each
    /// chirp begins with another phase.
    fn followed(rows: u16, phase: impl Fn(u16) -> f32) -> (Phases, Box<PolarMap>) {
        let mut map = Box::new(PolarMap::new());
        map.begin(&Config::default()).unwrap();
        let mut phases = Phases::new(Numbers::DEFAULT);
        for k in 0..rows {
            map.fill(k.into(), |row| row.cells[40] = 200);
            let begun = 1.7 * f32::from(k) % core::f32::consts::TAU;
            let at = |angle: f32| {
                let (sin, cos) = sin_cos(angle % core::f32::consts::TAU);
                [900.0 * cos, 900.0 * sin]
            };
            let phasors = |bin| {
                assert_eq!(bin, 40);
                [at(begun + phase(k)), at(begun)]
            };
            phases.row(&map, k, phasors, 40, 80);
        }
        (phases, map)
    }

    /// Returns the measured value of the check after 60 rows, 1/100 degree.
    fn seen(phase: impl Fn(u16) -> f32) -> i32 {
        let mut seen = -1;
        followed(60, phase)
            .0
            .report_checks(&mut |check| seen = check.value);
        seen
    }

    /// Returns whether the phases agree with a travel of `per_row_m` metres a row.
    fn agreement(rows: u16, phase: impl Fn(u16) -> f32, per_row_m: f32) -> PhaseAgreement {
        let (phases, map) = followed(rows, phase);
        let mut track = Track::new();
        track.begin(map.rows() as u16);
        for k in 0..map.rows() as u16 {
            let place = RowPose {
                time_s: 0.0046 * f32::from(k),
                travel_m: per_row_m * f32::from(k),
                pitch_rad: 0.0,
            };
            track.add(k, place);
        }
        phases.agreement(&track, &map, &Config::default().radar)
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
        use PhaseAgreement::{Agrees, Differs, Unknown};
        let speckle = |k| if k % 4 < 2 { 0.0 } else { 0.5 };
        assert_eq!(agreement(60, |_| 1.0, 0.0), Agrees);
        assert_eq!(agreement(60, speckle, 0.0), Agrees);
        assert_eq!(agreement(12, |_| 1.0, 0.0), Unknown, "too few");
        assert_eq!(agreement(60, |k| 0.2 * f32::from(k), 0.0), Differs);
        // So fast that single phase changes are large, though their mean is small.
        let fast = |k: u16| [0.0, 1.2, 1.2, 0.0][usize::from(k % 4)];
        assert_eq!(agreement(60, fast, 0.0), Unknown);
        assert!(seen(fast) < 400);
    }

    #[test]
    fn a_chair_that_drives_turns_phases_as_its_odometer_says() {
        use PhaseAgreement::{Agrees, Differs};
        let config = Config::default();
        let mut map = Box::new(PolarMap::new());
        map.begin(&config).unwrap();
        for per_row_m in [0.3e-3, 0.9e-3, 1.4e-3, -0.9e-3] {
            let mut phases = std::vec![0.0];
            for k in 1..200 {
                let ahead = forward(map.geometry(), map.angle_rad(k));
                let nearer = per_row_m * ahead / config.radar.wavelength_m();
                phases.push(phases[k - 1] - 2.0 * core::f32::consts::TAU * nearer);
            }
            let phase = |k: u16| phases[usize::from(k)];
            assert_eq!(agreement(200, phase, per_row_m), Agrees);
            // Wheels that turn on the spot, an odometer that counts backwards or 30 % too much.
            for said in [0.0, -per_row_m, 1.3 * per_row_m] {
                assert_eq!(agreement(200, phase, said), Differs, "{per_row_m} {said}");
            }
        }
    }
}
