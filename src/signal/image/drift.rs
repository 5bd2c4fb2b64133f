//! Phase by which echoes turn from row to row while the chair moves: that of the motion input, corrected by what the strong
//! echoes of each row show beyond it.
//!
//! All that stands still turns alike in the rows of one lobe, by 4π v T cos θ / λ. Odometers are 2 % off, and which end of
//! the band a module calls its carrier turns 5 % more or less: at 1 mm a row 12 degrees. The fading mean of this rest over
//! the last rows is taken out of each row as well. Multiples of a turn do not matter.

use super::reference::CoherentRow;
use super::walk::aligned;
use crate::math;
use crate::signal::range::packed::Packed;
use core::f32::consts::TAU;

/// Minimum power of a bin over the noise, in two neighbouring rows, whose phase counts: noise has it once in 10^6 rows.
const STRONG: f32 = 10.0;
/// Multiple of the noise at which powers are cut off in the mean that estimates it: echoes raise it little.
const CUT_OFF: f32 = 4.0;
/// Share by which means over the rows fade from row to row.
const FADES: f32 = 0.9;
/// Least phase change from row to row beyond the expected one that is taken out, radians (4 degrees; over a lobe it costs
/// 0.8 dB), and in its own standard deviations.
const MOVES_RAD: f32 = 0.07;
const MOVES_SIGMAS: f32 = 4.0;

/// Fading mean of the phase changes beyond the expected ones, weighted with power, and the phase turned so far.
#[derive(Clone, Debug)]
pub struct Drift {
    /// Mean power of the noise in a bin; 0 before the first row.
    noise: f32,
    sum: [f32; 2],
    /// Variance of the sum across its direction.
    variance: f32,
    change_rad: f32,
    turned_rad: f32,
    /// Seen bin of the first bin of the row before.
    first: i32,
}

impl Drift {
    /// Returns the state before the first row.
    pub const fn new() -> Self {
        Self {
            noise: 0.0,
            sum: [0.0; 2],
            variance: 0.0,
            change_rad: 0.0,
            turned_rad: 0.0,
            first: 0,
        }
    }

    /// Prepares for the first row of a scan.
    pub fn begin(&mut self) {
        self.noise = 0.0;
        (self.sum, self.variance) = ([0.0; 2], 0.0);
        (self.change_rad, self.turned_rad) = (0.0, 0.0);
        self.first = 0;
    }

    /// Takes the next row, whose first bin is seen bin `first` and whose echoes are expected to have turned by `expected_rad`
    /// since the row before; returns the phase that they have turned since the first row, radians. `before` is the memory of
    /// the row before, zeros before the first one.
    pub fn row(
        &mut self,
        row: &CoherentRow<'_>,
        (first, expected_rad): (i32, f32),
        before: &mut [u32],
    ) -> f32 {
        let scale = row.unit * row.unit;
        self.track_noise(row.bins, scale);
        // Without a reference each chirp begins with another phase.
        let fades = if row.referenced { FADES } else { 0.0 };
        self.sum = self.sum.map(|s| s * fades);
        self.variance *= fades * fades;
        let mut strong = false;
        let mut turned = [0.0; 2];
        let by = first.wrapping_sub(core::mem::replace(&mut self.first, first));
        let (skipped, skipped_before) = aligned(by);
        let pairs = row.bins.iter().skip(skipped);
        for (x, then) in pairs.zip(before.iter().skip(skipped_before)) {
            let then = Packed(*then);
            let [a, b, c, d] = [x.re(), x.im(), then.re(), then.im()].map(f32::from);
            let (now, then) = ((a * a + b * b) * scale, (c * c + d * d) * scale);
            if math::min(now, then) > STRONG * self.noise {
                strong = true;
                turned = [
                    turned[0] + (a * c + b * d) * scale,
                    turned[1] + (b * c - a * d) * scale,
                ];
                self.variance += 0.5 * self.noise * (now + then);
            }
        }
        let (sin, cos) = math::sin_cos(expected_rad % TAU);
        let [re, im] = turned;
        self.sum = [
            self.sum[0] + re * cos + im * sin,
            self.sum[1] + im * cos - re * sin,
        ];
        for (kept, x) in before.iter_mut().zip(row.bins.iter()) {
            *kept = x.0;
        }
        if strong {
            let [cos, sin] = self.sum;
            let change = math::atan2(sin, cos);
            let size = math::max(math::hypot(cos, sin), f32::MIN_POSITIVE);
            let sigma = math::sqrt(self.variance) / size;
            let least = math::max(MOVES_RAD, MOVES_SIGMAS * sigma);
            let moves = change.abs() > least || !row.referenced;
            self.change_rad = if moves { change } else { 0.0 };
        }
        self.turned_rad = (self.turned_rad + expected_rad + self.change_rad) % TAU;
        self.turned_rad
    }

    /// Adds the row's bins to the fading mean of the noise.
    fn track_noise(&mut self, bins: &[Packed], scale: f32) {
        let power = |x: &Packed| {
            let (re, im) = (f32::from(x.re()), f32::from(x.im()));
            (re * re + im * im) * scale
        };
        let most = match self.noise > 0.0 {
            true => CUT_OFF * self.noise,
            false => f32::MAX,
        };
        let sum: f32 = bins.iter().map(|x| math::min(power(x), most)).sum();
        let mean = sum / bins.len().max(1) as f32;
        self.noise = match self.noise > 0.0 {
            true => FADES * self.noise + (1.0 - FADES) * mean,
            false => mean,
        };
    }
}
