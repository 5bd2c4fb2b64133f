//! Distance of each nosing, from the echoes on two vertical lines: nosing and riser, with one overhang for the whole
//! flight.
//!
//! A tread with an overhang shows two lines: its front edge, and behind it by the overhang the riser with the inner
//! corner at its foot. A flush tread shows both at one place. Range resolves echoes to one or two millimetres, height
//! to one or two centimetres: so the distances determine the overhang, and the heights assign each echo to a line.
//! The method averages over all overhangs of the whole flight and, for each, over all places of each nosing, weighted
//! by their likelihood. The result is the mean and standard deviation of this mixture.

use super::gauss::TreadLevels;
use super::propose::ascending::riser_at;
use super::propose::roles::Riser;
use super::propose::scene::{Mark, Scene, gain};
use super::propose::stairs::{Flight, MAX_FLIGHT};
use crate::estimate::Estimate;
use crate::math;
use crate::params::Params;
use crate::sort::shell_sort;
use heapless::Vec;

/// Overhangs of the grid, metres: none, and from the smallest one at which two lines can be resolved to the deepest
/// nosings that are built, closer together than the lines are wide.
const OVERHANGS_M: [f32; 11] = [
    0.0, 0.008, 0.014, 0.020, 0.026, 0.032, 0.038, 0.044, 0.050, 0.056, 0.062,
];
/// Cost of an overhanging riser, nats: ln 3. It shows nosing and riser, or the nosing, or the riser, equally often.
const LN_SHOWN: f32 = 1.098_612_3;
/// Minimum likelihood of an overhang of the grid, relative to the likeliest one, at which it is included in the mean.
const NEGLIGIBLE: f32 = 1e-3;
/// Maximum number of echoes near one riser that are used, the strongest: a nosing, a face, a corner, and as many
/// others.
const MOST: usize = 6;
/// Number of the strongest echoes near a riser whose distances are tried as that of the nosing's or the riser's line.
const GENERATORS: usize = 3;

/// Horizontal distances of the nosings, metres from the mirror, the nearest first; `None` for a nosing without an echo.
pub type Nosings = Vec<Option<Estimate>, MAX_FLIGHT>;

/// An echo near a riser.
#[derive(Clone, Copy, Debug)]
struct LineEcho {
    /// Horizontal distance of the echo from the mirror and its standard deviation, metres.
    x: (f32, f32),
    /// Score gain if the echo is part of the nosing's vertical line, by the echo's height alone, nats.
    front: f32,
    /// Score gain if the echo is part of the riser's vertical line, by the echo's height alone, nats.
    back: f32,
    /// Credibility of the echo, 0…1, a factor on its gains: small near the noise, 1 well above it.
    weight: f32,
    snr_db: f32,
}

/// Fit of two lines, nosing and riser, to the echoes near a riser.
#[derive(Clone, Copy, Debug, Default)]
struct Explained {
    nats: f32,
    /// Measured distance from the nosing's line to the riser's, metres, if both have echoes.
    gap_m: Option<f32>,
    /// Smaller of two sums of echo amplitudes (relative to the noise), over the echoes of the nosing's line and over
    /// those of the riser's: the weight of `gap_m`.
    amplitude: f32,
}

/// The strongest echoes near one riser, the strongest first, with their gains on the nosing's and the riser's line.
struct RiserEchoes {
    sightings: Vec<LineEcho, MOST>,
    unexplained_nats: f32,
}

impl RiserEchoes {
    /// Collects the echoes near a riser at distance `along_m`, metres. `top_variance` is the variance of the height of
    /// the riser's top, m².
    fn new(scene: &Scene<'_>, riser: &Riser, along_m: f32, top_variance: f32) -> Self {
        let p = scene.params;
        let from = math::max(along_m - p.nosing_window_m, p.nearest_riser_m);
        let mut sightings = Vec::<LineEcho, MOST>::new();
        for m in scene.between(from, along_m + p.nosing_window_m) {
            let sighting = line_gains(scene, riser, m, top_variance);
            if sightings.push(sighting).is_err()
                && let Some(last) = sightings.last_mut()
                && last.snr_db < sighting.snr_db
            {
                *last = sighting;
            }
            shell_sort(&mut sightings, |a, b| a.snr_db > b.snr_db);
        }
        Self {
            sightings,
            unexplained_nats: p.nosing_stray_nats,
        }
    }

    /// Calls `each` with each place of the nosing, metres from the mirror, that an echo suggests for overhang
    /// `overhang_m`; with whether the echo is taken for the riser's line (otherwise for the nosing's); and with the
    /// echo's SNR, dB.
    fn candidate_places(&self, overhang_m: f32, mut each: impl FnMut(f32, bool, f32)) {
        for s in self.sightings.iter().take(GENERATORS) {
            let flush = overhang_m <= 0.0;
            if s.front > 0.0 || (flush && s.back > 0.0) {
                each(s.x.0, false, s.snr_db);
            }
            if !flush && s.back > 0.0 {
                each(s.x.0 - overhang_m, true, s.snr_db);
            }
        }
    }

    /// Returns the fit of a nosing at `front_m`, metres from the mirror, with the riser `overhang_m` behind it, to the
    /// echoes.
    fn fit(&self, front_m: f32, overhang_m: f32) -> Explained {
        let mut nats = 0.0;
        let (mut front, mut back) = ((0.0, 0.0), (0.0, 0.0));
        for s in &self.sightings {
            let z = (s.x.0 - front_m) / s.x.1;
            let behind = (s.x.0 - front_m - overhang_m) / s.x.1;
            let (as_front, as_back) = (gain(s.front, z), gain(s.back, behind));
            let best = math::max(as_front, as_back);
            if best > 0.0 {
                nats += s.weight * best;
                let amplitude = math::amplitude(s.snr_db);
                let line = if as_front >= as_back {
                    &mut front
                } else {
                    &mut back
                };
                line.0 += amplitude;
                line.1 += amplitude * (s.x.0 - front_m);
            } else if math::max(s.front, s.back) > 0.0 {
                nats -= s.weight * self.unexplained_nats;
            }
        }
        if overhang_m <= 0.0 {
            return Explained {
                nats,
                ..Explained::default()
            };
        }
        let both = front.0 > 0.0 && back.0 > 0.0;
        Explained {
            nats: nats - LN_SHOWN,
            gap_m: both.then(|| back.1 / back.0 - front.1 / front.0),
            amplitude: math::min(front.0, back.0),
        }
    }

    /// Returns the best fit of nosing and riser with this overhang, metres, over all candidate places of the nosing;
    /// `None` if there are none.
    fn best(&self, overhang_m: f32) -> Option<Explained> {
        let mut best: Option<Explained> = None;
        self.candidate_places(overhang_m, |front_m, _, _| {
            let explained = self.fit(front_m, overhang_m);
            if best.is_none_or(|b| b.nats < explained.nats) {
                best = Some(explained);
            }
        });
        best
    }
}

/// Returns the gains of an echo on the nosing's line (front edge of the tread) and on the riser's line below it, by its
/// height.
fn line_gains(scene: &Scene<'_>, riser: &Riser, m: &Mark, top_variance: f32) -> LineEcho {
    let p = scene.params;
    let top_z = (m.y_m - riser.top_m) / math::sqrt(m.y_sigma_m * m.y_sigma_m + top_variance);
    let mut front = gain(p.point_nats, top_z);
    let lip_m = math::min(p.lip_m, p.lip_share * (riser.top_m - riser.base_m));
    if (riser.top_m - lip_m - m.y_sigma_m..riser.top_m + m.y_sigma_m).contains(&m.y_m) {
        front = math::max(front, p.face_nats);
    }
    let hidden = scene.hides_foot(riser);
    let mut back = if riser.open || hidden {
        0.0
    } else {
        gain(p.point_nats, (m.y_m - riser.base_m) / m.y_sigma_m)
    };
    let above_foot = hidden || m.y_m > riser.base_m + m.y_sigma_m;
    if above_foot && m.y_m < riser.top_m - p.least_lip_m + 0.5 * m.y_sigma_m {
        back = math::max(back, p.face_nats);
    }
    // Seen from below, the edge on top is no better visible than the edge below it.
    if riser.top_m > scene.mount_height_m {
        front = math::min(front, p.face_nats);
    }
    // An error of an echo's angle moves the horizontal distance of what lies below or above the mirror.
    let slope = (scene.mount_height_m - m.y_m) / m.x_m;
    LineEcho {
        x: (
            m.x_m,
            math::hypot(p.line_sigma_m, slope * m.range_m * p.edge_angle_rad),
        ),
        front,
        back,
        weight: m.credibility,
        snr_db: m.snr_db,
    }
}

/// One overhang of the grid: its fit to all risers, and the sums for the measured overhang.
#[derive(Clone, Copy, Debug, Default)]
struct Overhang {
    nats: f32,
    gaps: f32,
    amplitudes: f32,
}

impl Overhang {
    /// Returns the overhang, metres, as measured by the risers that show both nosing and riser; without any,
    /// `overhang_m`, the value of the grid.
    fn refined(&self, overhang_m: f32, p: &Params) -> Estimate {
        if overhang_m <= 0.0 {
            Estimate::default()
        } else if self.amplitudes > 0.0 {
            Estimate::new(self.gaps / self.amplitudes, p.nosing_sigma_m)
        } else {
            Estimate::new(overhang_m, p.overhang_grid_sigma_m)
        }
    }
}

/// Calls `each_riser` with the echoes near each riser in turn.
fn places(
    scene: &Scene<'_>,
    flight: &Flight,
    levels: &TreadLevels,
    mut each_riser: impl FnMut(&RiserEchoes),
) {
    for (k, (link, level)) in flight.chain.iter().zip(levels).enumerate() {
        let riser = riser_at(&flight.chain, flight.shape.open, levels, k);
        let place = RiserEchoes::new(scene, &riser, link.along_m, level.height.variance);
        each_riser(&place);
    }
}

/// Returns the horizontal distances of the nosings of a flight, metres from the mirror, the nearest first; `levels` are
/// the heights of its treads.
#[inline(never)]
pub fn locate(scene: &Scene<'_>, flight: &Flight, levels: &TreadLevels) -> Nosings {
    let p = scene.params;
    let mut overhangs = [Overhang::default(); OVERHANGS_M.len()];
    // No overhang is as likely as all others together.
    let others = (OVERHANGS_M.len() - 1) as f32;
    for (overhang, &m) in overhangs.iter_mut().zip(&OVERHANGS_M) {
        overhang.nats = if m <= 0.0 { math::ln(others) } else { 0.0 };
    }
    places(scene, flight, levels, |place| {
        for (overhang, &m) in overhangs.iter_mut().zip(&OVERHANGS_M) {
            let Some(best) = place.best(m) else { continue };
            overhang.nats += best.nats;
            if let Some(gap_m) = best.gap_m {
                overhang.gaps += best.amplitude * gap_m;
                overhang.amplitudes += best.amplitude;
            }
        }
    });
    let top = overhangs.iter().map(|o| o.nats);
    let top = top.fold(f32::NEG_INFINITY, math::max);
    let mut nosings = Nosings::new();
    places(scene, flight, levels, |place| {
        let mut mixture = Mixture::default();
        for (overhang, &m) in overhangs.iter().zip(&OVERHANGS_M) {
            let share = math::exp(overhang.nats - top);
            if share > NEGLIGIBLE {
                let refined = overhang.refined(m, p);
                mixture.add(place, m, refined, share, p);
            }
        }
        // Cannot fail: there are as many nosings as faces.
        let _ = nosings.push(mixture.mean());
    });
    nosings
}

/// Mean and variance of a nosing's place over all overhangs and places.
#[derive(Clone, Copy, Debug, Default)]
struct Mixture {
    weight: f32,
    sum: f32,
    squares: f32,
    /// Origin of the sums, metres, so that the squares keep their precision.
    origin_m: f32,
}

impl Mixture {
    /// Adds the candidate places of a nosing with one overhang of the grid, `overhang_m`, which was measured as
    /// `refined`. Their weights add up to `share`.
    fn add(
        &mut self,
        place: &RiserEchoes,
        overhang_m: f32,
        refined: Estimate,
        share: f32,
        p: &Params,
    ) {
        let Some(best) = place.best(overhang_m) else {
            return;
        };
        if self.weight <= 0.0 {
            self.origin_m = place.sightings.first().map_or(0.0, |s| s.x.0);
        }
        let (mut weight, mut sum, mut squares) = (0.0, 0.0, 0.0);
        place.candidate_places(overhang_m, |front_m, is_back, snr_db| {
            let nats = place.fit(front_m, overhang_m).nats - best.nats;
            // Of two places that fit equally well, that of the stronger echo is more accurate.
            let w = math::exp(nats) * math::amplitude(snr_db);
            let own = p.nosing_sigma_m * p.nosing_sigma_m;
            let (shift_m, variance) = if is_back {
                (overhang_m - refined.value, own + refined.variance)
            } else {
                (0.0, own)
            };
            let off_m = front_m + shift_m - self.origin_m;
            weight += w;
            sum += w * off_m;
            squares += w * (off_m * off_m + variance);
        });
        if weight > 0.0 {
            let each = share / weight;
            self.weight += share;
            self.sum += each * sum;
            self.squares += each * squares;
        }
    }

    fn mean(&self) -> Option<Estimate> {
        (self.weight > 0.0).then(|| {
            let mean = self.sum / self.weight;
            Estimate {
                value: self.origin_m + mean,
                variance: math::max(self.squares / self.weight - mean * mean, 0.0),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::infer::gauss;
    use crate::infer::propose::stairs::FlightShape;
    use crate::observer::trace::ChainLink;
    use crate::signal::echoes::Echo;

    const RISE_M: f32 = 0.15;
    const MOUNT_M: f32 = 0.40;

    /// Returns the nosings of a closed flight with rises of 15 cm and these risers, from echoes of 25 dB at (x, y).
    fn locate_by(risers: &[f32], echoes: &[(f32, f32)]) -> Vec<Option<Estimate>, MAX_FLIGHT> {
        let echoes: std::vec::Vec<Echo> = echoes
            .iter()
            .map(|&(x_m, y_m)| Echo {
                snr_db: 25.0,
                range_m: math::hypot(x_m, MOUNT_M - y_m),
                x_m,
                y_m,
                width: 1.0,
                ..Echo::default()
            })
            .collect();
        let mut scene = Scene::new(MOUNT_M, &Params::DEFAULT);
        scene.risers(&echoes);
        let mut flight = Flight {
            shape: FlightShape {
                rise_m: RISE_M,
                open: false,
            },
            chain: Vec::new(),
            faces: 0.0,
            score: 0.0,
        };
        for &along_m in risers {
            let column = Some(0);
            flight.chain.push(ChainLink { along_m, column }).unwrap();
        }
        let levels = gauss::straight(Estimate::new(RISE_M, 0.003));
        locate(&scene, &flight, &levels)
    }

    fn assert_at(nosing: Option<Estimate>, x_m: f32) {
        let nosing = nosing.unwrap();
        assert!((nosing.value - x_m).abs() < 0.003, "{nosing:?}, not {x_m}");
        assert!(nosing.sigma() < 0.006, "{nosing:?}");
    }

    #[test]
    fn nosing_of_a_riser_with_one_echo_uses_the_flights_overhang() {
        for overhang in [0.02, 0.035, 0.055] {
            let nosings = locate_by(
                &[0.6, 0.9, 1.2],
                &[
                    (0.6, 0.0),
                    (0.6 - overhang, 0.15),
                    (0.9, 0.15),
                    (0.9 - overhang, 0.29),
                    (1.2, 0.30),
                ],
            );
            for (k, nosing) in nosings.iter().enumerate() {
                assert_at(*nosing, 0.6 + 0.3 * k as f32 - overhang);
            }
        }
    }

    #[test]
    fn the_overhang_is_not_taken_off_a_nosing() {
        // The third riser of the flight stands at its nosing's echo.
        let echoes = [
            (0.6, 0.0),
            (0.57, 0.15),
            (0.9, 0.15),
            (0.87, 0.29),
            (1.17, 0.30),
            (1.17, 0.44),
            (1.2, 0.30),
        ];
        let nosings = locate_by(&[0.6, 0.9, 1.17], &echoes);
        assert_at(nosings[2], 1.17);
    }

    #[test]
    fn flush_risers_stand_where_they_are_seen() {
        let nosings = locate_by(&[0.6, 0.9], &[(0.6, 0.0), (0.601, 0.15), (0.9, 0.15)]);
        assert_at(nosings[0], 0.6);
        assert_at(nosings[1], 0.9);
    }

    #[test]
    fn overhang_without_measurement_leaves_the_nosing_uncertain() {
        let nosing = locate_by(&[0.6], &[(0.6, 0.0)])[0].unwrap();
        // The mean is nearer than the corner, and neither end is excluded.
        assert!(nosing.value < 0.599 && nosing.value > 0.57, "{nosing:?}");
        assert!(nosing.sigma() > 0.004, "{nosing:?}");
        assert!(nosing.value + 2.0 * nosing.sigma() > 0.6);
        assert_eq!(locate_by(&[0.6, 0.9], &[(0.6, 0.0)])[1], None);
    }
}
