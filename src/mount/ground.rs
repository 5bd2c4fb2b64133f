//! Where the ground lies: where mounting height and angle put it, level or with a slope, or elsewhere.
//!
//! Echoes of the ground have known variances in height, and a few echoes are of other things. So the log-likelihood of a
//! ground is a sum over echoes in which none counts for more than [`STRAY_NATS`], and of what stands on one place the
//! strongest echo counts alone. Grounds that are compared:
//!
//! | ground | in its place |
//! |---|---|
//! | level, by the calibration | yes |
//! | level, and from some place on higher or lower: a riser or a drop | yes |
//! | level, and from some place on with a slope | yes |
//! | at another height, or inclined from the wheels on | no: the mounting is wrong |

use super::online::Calibration;
use super::variance::floor_variance;
use crate::answer::Slope;
use crate::math;
use crate::params::Params;
use crate::signal::echoes::{Echo, MAX_ECHOES};

/// Distances from the mirror at which the ground may begin to slope, metres: from the nearest ground echoes on.
const FROM_M: [f32; 6] = [0.2, 0.4, 0.6, 0.8, 1.0, 1.2];
/// Slopes of ground that a chair may drive, up or down, rise per metre: ramps of ISO 21542 have 0.05 to 0.08. The
/// lowest flights have 0.2.
const SLOPES: [f32; 6] = [0.02, 0.04, 0.06, 0.08, 0.1, 0.12];
/// Steps by which the best slope of the grid is moved to each side, place in metres and rise per metre: coarse, then fine.
const MOVES: [(f32, f32); 3] = [(0.1, 0.01), (0.05, 0.005), (0.025, 0.0025)];
/// Maximum log-likelihood ratio by which an echo can be off the ground, nats: one echo in twenty is of something else.
const STRAY_NATS: f32 = 3.0;
/// Log-odds of ground that slopes, one in twenty, to a mounting that is off, one in a hundred, nats.
const SLOPE_NATS: f32 = 1.6;
/// Minimum log-likelihood ratio of a slope to level ground, nats: one ground in twenty slopes, in one of 72 ways.
const BEND_NATS: f32 = 7.3;

/// A ground echo's place and precision.
#[derive(Clone, Copy, Debug)]
struct GroundEcho {
    x_m: f32,
    /// Height as the configured mounting places it, metres.
    y_m: f32,
    /// Height by the calibration on level ground, metres.
    level_y_m: f32,
    /// Half of the inverse variance of the echo's height, 1/m².
    half_precision: f32,
    /// Maximum log-likelihood ratio by which the echo can be off the ground, nats.
    stray_nats: f32,
}

impl GroundEcho {
    /// Returns the log-likelihood of the echo, nats, on this ground.
    fn on(&self, ground: &TestedGround) -> f32 {
        let y_m = if ground.calibrated {
            self.level_y_m
        } else {
            self.y_m
        };
        let mut off_m = y_m - ground.height_m;
        if self.x_m >= ground.bend.from_m {
            off_m -= ground.rise_m + ground.bend.slope * (self.x_m - ground.bend.from_m);
        }
        math::max(-off_m * off_m * self.half_precision, -self.stray_nats)
    }
}

/// A ground on which echoes may lie.
#[derive(Clone, Copy, Debug)]
struct TestedGround {
    /// Whether echoes lie where the calibration on level ground puts them. A slope would be taken for an angle bias in
    /// part.
    calibrated: bool,
    /// Height above the configured ground, metres.
    height_m: f32,
    /// Height by which it rises where the slope begins, metres.
    rise_m: f32,
    bend: Slope,
}

impl TestedGround {
    /// Level ground in its place.
    const LEVEL: Self = Self {
        calibrated: true,
        height_m: 0.0,
        rise_m: 0.0,
        bend: Slope::LEVEL,
    };

    /// Returns ground with this slope, in its place.
    fn sloping(bend: Slope) -> Self {
        Self {
            calibrated: false,
            bend,
            ..Self::LEVEL
        }
    }
}

/// The ground's echoes of a scan.
struct GroundEchoes(heapless::Vec<GroundEcho, MAX_ECHOES>);

impl GroundEchoes {
    /// Selects the echoes that may be ground, the strongest at each place. `level` is the calibration on level ground.
    #[inline(never)]
    fn of(echoes: &[Echo], level: &Calibration, p: &Params) -> Self {
        let mut ground = heapless::Vec::<GroundEcho, MAX_ECHOES>::new();
        for e in echoes {
            let ahead = e.x_m > p.floor_from_m && e.x_m < p.floor_to_m;
            let stands = ground.iter().any(|g| (g.x_m - e.x_m).abs() < p.column_m);
            if ahead && e.y_m.abs() < p.floor_astray_m && !stands {
                // The vector has room for all echoes.
                let _ = ground.push(GroundEcho {
                    x_m: e.x_m,
                    y_m: e.y_m,
                    level_y_m: level.height_of(e),
                    half_precision: 0.5 / floor_variance(e, e.range_m, p),
                    stray_nats: STRAY_NATS * p.credibility(e.snr_db),
                });
            }
        }
        Self(ground)
    }

    /// Returns the log-likelihood of the echoes on this ground, nats.
    #[inline(never)]
    fn on(&self, ground: &TestedGround) -> f32 {
        self.0.iter().map(|e| e.on(ground)).sum()
    }

    /// Returns the largest log-likelihood, nats, of ground that is level in its place, and goes on at another level. Before
    /// the edge an echo shows it in its place.
    #[inline(never)]
    fn best_levels(&self) -> f32 {
        let mut most = f32::NEG_INFINITY;
        for edge in &self.0 {
            let shows = |e: &GroundEcho| {
                e.x_m < edge.x_m && e.on(&TestedGround::LEVEL) > -0.5 * e.stray_nats
            };
            if !self.0.iter().any(shows) {
                continue;
            }
            for beyond in self.0.iter().filter(|e| e.x_m >= edge.x_m) {
                let ground = TestedGround {
                    rise_m: beyond.level_y_m,
                    bend: Slope {
                        from_m: edge.x_m,
                        slope: 0.0,
                    },
                    ..TestedGround::LEVEL
                };
                most = math::max(most, self.on(&ground));
            }
        }
        most
    }

    /// Returns the log-likelihood, nats, of ground with this slope.
    fn on_slope(&self, bend: Slope) -> f32 {
        self.on(&TestedGround::sloping(bend))
    }

    /// Returns the slope of the largest log-likelihood in a grid, and that, nats.
    #[inline(never)]
    fn best_slope(&self) -> (Slope, f32) {
        let mut best = (Slope::LEVEL, f32::NEG_INFINITY);
        for from_m in FROM_M {
            for rise in SLOPES {
                for slope in [rise, -rise] {
                    let bend = Slope { from_m, slope };
                    let nats = self.on_slope(bend);
                    if nats > best.1 {
                        best = (bend, nats);
                    }
                }
            }
        }
        best
    }

    /// Returns the slope moved from `best`, of log-likelihood `most`, to where it is largest, by coordinate search; and that
    /// log-likelihood, nats.
    #[inline(never)]
    fn moved(&self, mut best: Slope, mut most: f32) -> (Slope, f32) {
        for (from_m, slope) in MOVES {
            for (from_m, slope) in [(from_m, 0.0), (-from_m, 0.0), (0.0, slope), (0.0, -slope)] {
                let bend = Slope {
                    from_m: best.from_m + from_m,
                    slope: best.slope + slope,
                };
                let nats = self.on_slope(bend);
                if nats > most {
                    (best, most) = (bend, nats);
                }
            }
        }
        (best, most)
    }

    /// Returns the largest log-likelihood, nats, of ground that is not where the mounting puts it: beyond the tolerance of
    /// its height, or inclined by more than the tolerance, through the wheels' contact point.
    #[inline(never)]
    fn elsewhere(&self, p: &Params) -> f32 {
        let (near, tilt) = (p.floor_near_steps as i32, p.floor_tilt_steps as i32);
        let (far, steep) = (p.floor_far_steps as i32, p.floor_steep_steps as i32);
        let mut most = f32::NEG_INFINITY;
        for inclined in -steep..=steep {
            let tilted = inclined.abs() > tilt;
            let reach = if tilted { near } else { far };
            for height in -reach..=reach {
                if !tilted && height.abs() <= near {
                    continue;
                }
                let mut ground = TestedGround::sloping(Slope {
                    from_m: 0.0,
                    slope: inclined as f32 * p.floor_slope_step_rad,
                });
                ground.height_m = height as f32 * p.floor_height_step_m;
                most = math::max(most, self.on(&ground));
            }
        }
        most
    }
}

/// Evidence for the ground at and away from its configured place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundEvidence {
    /// Largest log-likelihood of the echoes, nats, for a ground that is where the mounting puts it.
    pub configured: f32,
    /// The same without a riser or a drop, nats: ground that goes on at another level confirms no mounting.
    pub unbroken: f32,
    /// Largest log-likelihood of the echoes, nats, for a ground that is elsewhere.
    pub other: f32,
    /// Slope of the ground: level where no slope has clearly more evidence.
    pub bend: Slope,
}

impl GroundEvidence {
    /// Returns whether the ground is at its configured place: no other place has much more evidence.
    pub fn in_place(&self, p: &Params) -> bool {
        self.other - self.configured <= p.floor_elsewhere_nats
    }

    /// Returns whether the evidence confirms the configured mounting: without a riser or drop it is clearly larger than
    /// for any other ground.
    pub fn confirmed(&self, p: &Params) -> bool {
        self.unbroken > self.other + p.floor_firm_nats
    }

    /// Computes the evidence from the echoes of a map, placed without any calibration. `level` is the calibration on level
    /// ground.
    #[inline(never)]
    pub fn of(echoes: &[Echo], level: &Calibration, p: &Params) -> Self {
        let ground = GroundEchoes::of(echoes, level, p);
        let level = ground.on(&TestedGround::LEVEL);
        let mut found = Self {
            configured: level,
            unbroken: level,
            other: ground.elsewhere(p),
            bend: Slope::LEVEL,
        };
        // No ground makes the echoes likelier than certain.
        if level > -BEND_NATS && found.confirmed(p) {
            return found;
        }
        found.configured = math::max(level, ground.best_levels());
        let (bend, nats) = ground.best_slope();
        // What may as well be a tilted mounting is no slope.
        let rival = math::max(found.configured, found.other - SLOPE_NATS);
        if nats > level + BEND_NATS && nats > rival {
            (found.bend, found.configured) = ground.moved(bend, nats);
            found.unbroken = found.configured;
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::RAD_PER_DEG;
    use crate::signal::grid::Geometry;

    const P: &Params = &Params::DEFAULT;

    /// Distances of the ground's echoes, metres.
    const PLACES_M: [f32; 8] = [0.38, 0.46, 0.55, 0.63, 0.72, 0.81, 0.9, 1.0];

    /// Returns the evidence of echoes of 15 dB on ground with these heights, metres.
    fn seen(height_m: impl Fn(f32) -> f32) -> GroundEvidence {
        let geometry = Geometry::default();
        let echoes: std::vec::Vec<Echo> = PLACES_M
            .map(|x_m| {
                let y_m = height_m(x_m);
                let down_m = geometry.mount_height_m - y_m;
                Echo {
                    range_m: math::hypot(x_m, down_m),
                    angle_rad: math::atan2(down_m, x_m),
                    x_m,
                    y_m,
                    snr_db: 15.0,
                    width: 1.0,
                    ..Echo::default()
                }
            })
            .into();
        let level = Calibration::fit(&echoes, Slope::LEVEL, &geometry, P);
        GroundEvidence::of(&echoes, &level, P)
    }

    #[test]
    fn a_slope_is_found_and_no_wrong_mounting() {
        for (from_m, slope) in [(0.4, 0.05), (0.5, -0.08), (0.6, 0.12), (0.45, -0.06)] {
            let truth = Slope { from_m, slope };
            let found = seen(|x_m| truth.height_m(x_m));
            assert!(
                found.in_place(P) && found.confirmed(P),
                "{truth:?}: {found:?}"
            );
            let off_m = |x_m| (found.bend.height_m(x_m) - truth.height_m(x_m)).abs();
            let most = PLACES_M.map(off_m).into_iter().fold(0.0, math::max);
            assert!(most < 0.006, "{truth:?}: {most} m off, {found:?}");
        }
    }

    #[test]
    fn level_ground_with_a_step_has_no_slope_and_is_in_its_place() {
        for rise_m in [0.0, 0.08, 0.15, -0.07, -0.12] {
            let found = seen(|x_m| if x_m < 0.5 { 0.0 } else { rise_m });
            assert_eq!(found.bend, Slope::LEVEL, "{rise_m}");
            assert!(found.in_place(P), "{rise_m}: {found:?}");
        }
    }

    #[test]
    fn a_mounting_that_is_too_high_too_low_or_tilted_is_wrong() {
        for height_m in [0.03, -0.03, 0.08, -0.08] {
            let found = seen(|_| height_m);
            assert!(!found.in_place(P), "{height_m}: {found:?}");
        }
        for degrees in [2.0_f32, -2.0, 4.0, -4.0] {
            let found = seen(|x_m| x_m * degrees * RAD_PER_DEG);
            let told = found.bend != Slope::LEVEL || !found.in_place(P);
            assert!(told, "{degrees}: {found:?}");
        }
    }

    #[test]
    fn a_floor_that_is_only_seen_elsewhere_is_out_of_place() {
        let floor = |configured, other| GroundEvidence {
            configured,
            unbroken: configured,
            other,
            bend: Slope::LEVEL,
        };
        for fits in [(0.0, 0.0), (0.0, -9.0), (-1.5, 0.0), (-9.0, -8.0)] {
            assert!(floor(fits.0, fits.1).in_place(P), "{fits:?}");
        }
        for off in [(-9.0, 0.0), (-18.0, -9.0)] {
            assert!(!floor(off.0, off.1).in_place(P), "{off:?}");
        }
        assert!(floor(-1.0, -6.0).confirmed(P) && !floor(-1.0, -1.0).confirmed(P));
        assert!(!floor(0.0, 0.0).confirmed(P));
    }
}
