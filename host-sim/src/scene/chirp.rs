//! One chirp: from the beat tones of a scene to the samples of one mirror angle.
//!
//! In: beat tones, the mirror's angle and the time. Out: the samples of the row, the mean of its chirps.

use core::f64::consts::TAU;

use num_complex::Complex64;
use stairscan::Iq;
use stairscan::signal::radar::dwell::ChirpSum;

use super::bundles::Bundles;
use super::displacement::{MirrorShift, vibrates};
use super::maths::{Random, cis};
use super::receiver::Receiver;
use super::{Scene, shaft};

/// One chirp: when and whereto it is fired, and its errors in time.
pub(super) struct Firing {
    /// Angle of the mirror in the chirp's middle, degrees.
    pub row_deg: f64,
    /// Time of the chirp's middle, seconds from the first row.
    pub time_s: f64,
    /// Beam angle less mirror angle, radians.
    pub tilt: f64,
    /// Delay of all samples, sample periods.
    pub delay: f64,
    /// Shift of every sample's time, sample periods.
    pub warp: Vec<f64>,
}

impl Scene {
    /// Simulates angle number `row` at `time_s` seconds: the mean of its chirps. Returns its samples, and its complex
    /// echoes before the receiver's noise and errors.
    pub(super) fn chirp(
        &self,
        receiver: &Receiver,
        tones: &[&Bundles],
        (row, time_s): (usize, f64),
        random: &mut Random,
    ) -> (Vec<Iq>, Vec<Complex64>) {
        let (radar, mirror) = (&self.spec.radar, &self.spec.mirror);
        let off = mirror.bias_deg + mirror.jitter_deg * random.normal();
        let row_deg = self.angles[row] + off;
        let count = f64::from(radar.chirps_per_row);
        let chirp_s = radar.samples_per_chirp as f64 / radar.sample_rate_hz;
        let periods = receiver.beat(self.spec.mount.mirror_offset_m) * receiver.samples() as f64;
        let mut sums = vec![[0.0; 2]; radar.samples_per_chirp];
        // One chirp keeps its phase.
        let turned = !radar.real && radar.chirps_per_row > 1;
        let mut sum = ChirpSum::new(&mut sums, turned.then_some(periods as f32));
        let mut mean = vec![Complex64::ZERO; radar.samples_per_chirp];
        for k in 0..radar.chirps_per_row {
            // A mirror that turns passes the row's angle in the middle of the chirps.
            let on_s = (f64::from(k) - 0.5 * (count - 1.0)) * chirp_s;
            let middle = (row_deg + on_s * mirror.turn_deg_s, time_s + on_s);
            let (chirp, echo) = self.single_chirp(receiver, tones, middle, random);
            sum.add(&chirp);
            mean.iter_mut().zip(echo).for_each(|(m, e)| *m += e / count);
        }
        let mut samples = vec![Iq::default(); radar.samples_per_chirp];
        sum.finish(&mut samples);
        (samples, mean)
    }

    /// Simulates one chirp, in whose middle, at `time_s`, the mirror is at `row_deg`. Returns its samples, and its
    /// complex echoes before the receiver's noise and errors.
    fn single_chirp(
        &self,
        receiver: &Receiver,
        tones: &[&Bundles],
        (row_deg, time_s): (f64, f64),
        random: &mut Random,
    ) -> (Vec<Iq>, Vec<Complex64>) {
        let (mirror, mount) = (&self.spec.mirror, &self.spec.mount);
        let shaft = (row_deg + shaft::vibration_deg(mirror, row_deg)).to_radians();
        let pitch = mount.pitch_deg.unwrap_or(0.0) + mount.pitch_error_deg;
        let firing = Firing {
            row_deg,
            time_s,
            tilt: mount.tilt_deg(pitch).to_radians(),
            delay: receiver.delay(time_s, random),
            warp: receiver.warp(time_s, random),
        };
        let start = receiver.start_phase(random);
        let shift = MirrorShift::new(mirror, shaft, time_s);
        let mut echo = vec![Complex64::ZERO; receiver.samples()];
        if shaft::turns(mirror) || vibrates(mount) {
            self.turning_echoes(&firing, tones, &mut echo);
        } else {
            let grid = self.weighed(shaft + firing.tilt, tones, firing.delay);
            self.beats().tones.sum(&grid, &firing.warp, &mut echo);
        }
        let wave = 2.0 * self.view().wavenumber;
        let by_mirror = cis(wave * shift.echoes);
        echo.iter_mut().for_each(|e| *e *= by_mirror);
        let own = cis(wave * (mirror.runout_m * libm::sin(shaft) + shift.own));
        let inside = self.inside_of(receiver, &firing, own);
        let analog = echo.iter().zip(inside).map(|(a, b)| (a + b) * start);
        let analog: Vec<Complex64> = analog.collect();
        let echo = echo
            .into_iter()
            .step_by(self.spec.radar.values_per_sample());
        (receiver.digitise(&analog, random), echo.collect())
    }

    /// Returns the echoes from inside the scanner in one chirp, sample by sample, with the phase factor `own` of the
    /// mirror's own echo.
    fn inside_of(
        &self,
        receiver: &Receiver,
        firing: &Firing,
        own: Complex64,
    ) -> impl Iterator<Item = Complex64> {
        let late = |range: f64| cis(TAU * receiver.beat(range) * firing.delay);
        let turns = [
            late(self.spec.receiver.leakage_range_m),
            late(self.spec.mount.mirror_offset_m) * own,
        ];
        let [leakage, mirror] = &self.beats().inside;
        let pairs = leakage.iter().zip(mirror).zip(&firing.warp);
        pairs.map(move |((a, b), w)| a.moved(*w) * turns[0] + b.moved(*w) * turns[1])
    }

    /// Returns the grid of beat frequencies with the tones as weighted by a beam that points at `angle`, radians, and
    /// sampled `delay` sample periods late.
    pub(super) fn weighed(&self, angle: f64, tones: &[&Bundles], delay: f64) -> Vec<Complex64> {
        let mut grid = self.beats().tones.grid();
        for bundles in tones {
            bundles.weigh(&self.beam, angle, &mut grid);
        }
        if delay != 0.0 {
            self.beats().tones.delay(&mut grid, delay);
        }
        grid
    }
}
