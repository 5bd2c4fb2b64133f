//! Sums of beat tones that get the same weight from the beam, which leaves less work for every row.
//!
//! A facet seen obliquely gives many echoes from one direction, one for each strip across the
//! plane. Their grid points are summed once, and the beam multiplies the sum.

use num_complex::Complex64;

use super::beam::Beam;
use super::tones::Place;

/// Beat tone of one echo: its place on the grid of beat frequencies, its amplitude at the ADC, and its range and
/// directions as in [`super::scatter::Echo`].
#[derive(Clone, Copy)]
pub struct Tone {
    pub place: Place,
    pub amplitude: Complex64,
    pub range: f64,
    pub out: f64,
    pub back: f64,
}

/// Direction and range of a bundle: directions as in [`super::scatter::Echo`], and range of its first tone, metres.
#[derive(Clone, Copy)]
pub struct Source {
    pub range: f64,
    pub out: f64,
    pub back: f64,
}

/// Beat tones of one pair of directions (out and back), summed on consecutive points of the grid of beat frequencies.
#[derive(Clone)]
struct Bundle {
    range: f64,
    out: f64,
    back: f64,
    /// Index, on the grid of beat frequencies, of the bundle's first point.
    first: usize,
    /// Index in `Bundles::values` of the bundle's first grid point.
    start: usize,
}

/// Beat tones, summed by pairs of directions (out and back).
#[derive(Default)]
pub struct Bundles {
    bundles: Vec<Bundle>,
    values: Vec<Complex64>,
}

/// Maximum number of grid points between the end of a bundle and the beginning of a tone that joins it. Tones farther
/// apart form separate bundles, because the points between are computed as well.
const GAP: usize = 16;

impl Bundles {
    /// Sums `tones` into bundles. The tones of one bundle must be consecutive.
    pub fn new(tones: impl IntoIterator<Item = Tone>) -> Self {
        let mut bundles = Self::default();
        for tone in tones {
            bundles.add(&tone);
        }
        bundles
    }

    /// Adds a tone to the last bundle if its directions are the same and it is near on the grid, else to a new bundle.
    pub fn add(&mut self, tone: &Tone) {
        let end = self.values.len();
        let place = &tone.place;
        let start = match self.bundles.last() {
            Some(b) if b.takes(tone, end - b.start) => b.start + place.first - b.first,
            _ => {
                self.bundles.push(Bundle {
                    range: tone.range,
                    out: tone.out,
                    back: tone.back,
                    first: place.first,
                    start: end,
                });
                end
            }
        };
        let needed = (start + place.weights.len()).max(end);
        self.values.resize(needed, Complex64::ZERO);
        for (value, w) in self.values[start..].iter_mut().zip(place.weights) {
            *value += tone.amplitude * w;
        }
    }

    /// Returns a copy in which the tones of each bundle are multiplied by the phase factor that `turn` returns for it,
    /// and its directions (out, back; mirror angles, radians) replaced by the two that `turn` returns.
    pub fn turned(&self, turn: impl Fn(&Source) -> (Complex64, [f64; 2])) -> Self {
        let mut values = Vec::with_capacity(self.values.len());
        let ends = self.bundles.iter().skip(1).map(|b| b.start);
        let ends = ends.chain([self.values.len()]);
        let turned = |(b, end): (&Bundle, usize)| {
            let source = Source {
                range: b.range,
                out: b.out,
                back: b.back,
            };
            let (phase, [out, back]) = turn(&source);
            values.extend(self.values[b.start..end].iter().map(|v| v * phase));
            Bundle {
                out,
                back,
                ..b.clone()
            }
        };
        let bundles = self.bundles.iter().zip(ends).map(turned).collect();
        Self { bundles, values }
    }

    /// Returns the number of bundles.
    #[cfg(test)]
    pub fn directions(&self) -> usize {
        self.bundles.len()
    }

    /// Adds the tones to `grid`, each bundle weighted by the two-way gain of a beam that points at `angle`, radians.
    pub fn weigh(&self, beam: &Beam, angle: f64, grid: &mut [Complex64]) {
        let ends = self.bundles.iter().skip(1).map(|b| b.start);
        let ends = ends.chain([self.values.len()]);
        for (b, end) in self.bundles.iter().zip(ends) {
            let back = beam.in_plane(angle - b.back);
            let out = if b.out == b.back {
                back
            } else {
                beam.in_plane(angle - b.out)
            };
            let gain = out * back;
            for (g, v) in grid[b.first..].iter_mut().zip(&self.values[b.start..end]) {
                *g += v * gain;
            }
        }
    }
}

impl Bundle {
    /// Returns whether `tone` belongs to this bundle, which has `length` grid points so far.
    fn takes(&self, tone: &Tone, length: usize) -> bool {
        let first = tone.place.first;
        let is_near = first >= self.first && first <= self.first + length + GAP;
        is_near && tone.out == self.out && tone.back == self.back
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::maths::Random;
    use crate::scene::tones::Tones;

    #[test]
    fn bundles_are_the_sum_of_their_tones() {
        let times: Vec<f64> = (0..64).map(f64::from).collect();
        let tones = Tones::new(&times, |_| Complex64::ONE);
        let beam = Beam::new(5.0, 5.0, 20.0, 35.0);
        let mut random = Random::new(1, 1);
        let drawn: Vec<Tone> = (0..500)
            .map(|k| {
                let place = tones.place(random.between(0.0, 1.99)).unwrap();
                // Runs of the same direction; some of them come back from another one.
                let back = f64::from(k / 5) * 0.01;
                let out = if k / 5 % 3 == 0 { 0.3 } else { back };
                let amplitude = random.complex(1.0);
                Tone {
                    place,
                    amplitude,
                    range: 1.0,
                    out,
                    back,
                }
            })
            .collect();
        let bundles = Bundles::new(drawn.iter().copied());
        assert!(bundles.bundles.len() > 100 && bundles.bundles.len() < 500);
        for angle in [-0.3, 0.1, 0.5] {
            let (mut grid, mut exact) = (tones.grid(), tones.grid());
            bundles.weigh(&beam, angle, &mut grid);
            for t in &drawn {
                let gain = beam.in_plane(angle - t.out) * beam.in_plane(angle - t.back);
                Tones::add(&mut exact, &t.place, t.amplitude * gain);
            }
            assert!(
                grid.iter()
                    .zip(&exact)
                    .all(|(a, b)| (a - b).l1_norm() < 1e-12)
            );
        }
    }
}
