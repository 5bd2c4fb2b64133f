//! Calibration of the mounting on command: a level ground, and a wall at a measured distance.
//!
//! The chair stands square before a wall, `wall_m` from the mirror's centre. Three things are then known. The
//! wall's flash (its specular reflection, where the beam meets it squarely) lies on the horizontal through the
//! mirror. The corner of wall and ground lies at `(wall_m, 0)`. All other echoes lie on the ground. With r, t
//! an echo's range from the mirror and its angle by the configured mounting, o the mirror's offset, b the error
//! of all angles, s the scale of ranges from the radar, and h the mirror's height:
//!
//! ```text
//! R = s (r + o) - o      T = t + b
//! flash:   R = wall_m                    T = 0
//! corner:  R = √(wall_m² + h²)           T = atan(h / wall_m)
//! floor:   R sin T = h
//! ```
//!
//! Weighted least squares over all of them, linearised a few times, gives h, b and s; echoes off the ground
//! lose weight (Cauchy). A scene that does not fit is refused with a reason.

use crate::params::mounting::{
    CORNER_DB, CORNER_M, CORNER_MARGIN_M, CORNER_OFF_M, CORNER_OFF_RAD, FLASH_DB, LESSER_DB,
    MAX_HEIGHT_ERROR_M, MAX_OFFSET_RAD, MAX_SCALE_ERROR, MIN_GROUND_ECHOES, OUTLIER_SHARE,
    OUTLIER_SIGMAS, RANGE_MODEL_M, SAME_M, TAPE_M,
};
use core::fmt;

use super::variance::floor_variance;
use crate::config::{Config, Plane};
use crate::estimate::Estimate;
use crate::health::MirrorEcho;
use crate::math;
use crate::params::Params;
use crate::signal::echoes::Echo;

/// Permitted distance of the wall, metres: beyond the mirror's own echo with ground before it, and within the
/// range of 3 m.
pub const WALL_M: core::ops::RangeInclusive<f32> = 0.6..=2.5;

/// Maximum distance of a ground echo above or below the ground, metres, with the angle offset that the flash shows and
/// the configured mounting height: it leaves room for the error of that height.
const FLOOR_M: f32 = MAX_HEIGHT_ERROR_M;
/// Standard deviation of the range of the mirror's own echo, bins of the transform: resolution of 1/16 bin,
/// half of it over √3.
const MIRROR_BINS: f32 = 0.018;
/// Number of linearised least-squares fits; the third one already changes nothing.
const ROUNDS: usize = 5;

/// Reason why calibration on command gives no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The scan is of the height plane; calibration needs the depth plane.
    Plane,
    /// The given distance of the wall is outside [`WALL_M`].
    Distance,
    /// No flash of a wall at the expected range and angle.
    NoWall,
    /// Walls at several distances, or something else that faces the scanner.
    SeveralWalls,
    /// Something stands between scanner and wall.
    Clutter,
    /// No corner of wall and ground.
    NoFloor,
    /// Too few ground echoes before the wall.
    FewEchoes,
    /// The echoes do not lie on one level ground with a wall on it.
    Misfit,
    /// The fitted mounting differs from the configured one by more than calibration corrects.
    TooFar,
}

impl Refusal {
    /// Returns the property of the scene that was expected and is missing, as a text for people.
    pub const fn expected(self) -> &'static str {
        match self {
            Self::Plane => "plane: expected depth",
            Self::Distance => "wall: expected at 0.6 to 2.5 m from the mirror",
            Self::NoWall => {
                "no wall: expected a strong echo within 6 degrees of the horizontal and 5 % of the distance"
            }
            Self::SeveralWalls => {
                "several walls: expected one, and nothing else that faces the scanner"
            }
            Self::Clutter => "an object between scanner and wall: expected only ground",
            Self::NoFloor => "no floor: expected the corner of floor and wall",
            Self::FewEchoes => "too few echoes of the floor: expected at least 5 before the wall",
            Self::Misfit => {
                "the echoes do not fit: expected one level floor and a wall that stands on it"
            }
            Self::TooFar => "mounting error too large: expected at most 6 degrees, 15 cm and 5 %",
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.expected())
    }
}

impl core::error::Error for Refusal {}

/// Fitted mounting of the scanner, with standard errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// Height of the mirror's centre above the ground, metres.
    pub height_m: Estimate,
    /// Offset that is added to all beam angles, radians: positive where the beam is lower than configured. Errors of
    /// homing and the pitch of the chair cannot be separated.
    pub offset_rad: Estimate,
    /// Factor by which measured ranges from the radar have to be multiplied to be true.
    pub scale: Estimate,
    /// Range of the mirror's own echo, metres from the radar: the value of the setting `mirror-echo`.
    pub mirror_echo_m: Estimate,
    /// Power level of the mirror's own echo, dB relative to full scale.
    pub mirror_level_db: f32,
    /// Number of ground echoes in the fit.
    pub floor_echoes: u8,
}

/// Part of the scene that an echo comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    Flash,
    Corner,
    Floor,
}

/// Parameters of the fit: mirror's height above the ground, offset added to all beam angles, and (`stretch`) the factor
/// of all ranges from the radar minus 1.
#[derive(Clone, Copy, Debug)]
struct MountState {
    height_m: f32,
    offset_rad: f32,
    stretch: f32,
}

/// Geometry of the calibration scene: distances of the wall from the mirror, and of the mirror from the radar.
#[derive(Clone, Copy, Debug)]
struct CalibrationScene {
    wall_m: f32,
    mirror_m: f32,
}

/// A residual of the fit (metres or radians), its derivatives by height, angle offset and range scale (`by`, in
/// this order), and its variance.
struct Equation {
    residual: f32,
    by: [f32; 3],
    variance: f32,
    /// Whether the equation loses weight if its residual is large (Cauchy).
    robust: bool,
}

impl CalibrationScene {
    /// Returns an echo's true range from the mirror, metres, and its true angle below the horizontal, radians,
    /// if the mounting is `s`.
    fn real(&self, e: &Echo, s: &MountState) -> (f32, f32) {
        let from_radar = (1.0 + s.stretch) * (e.range_m + self.mirror_m);
        (from_radar - self.mirror_m, e.angle_rad + s.offset_rad)
    }

    /// Returns an echo's horizontal distance from the mirror and its height above the ground, metres, if the
    /// mounting is `s`.
    fn point(&self, e: &Echo, s: &MountState) -> (f32, f32) {
        let (range, angle) = self.real(e, s);
        let (sin, cos) = math::sin_cos(angle);
        (range * cos, s.height_m - range * sin)
    }

    /// Calls `each` with the equations of one echo, linearised at the mounting `s`: one of a ground echo, two
    /// (range, angle) of flash and corner.
    fn equations(
        &self,
        e: &Echo,
        part: Part,
        s: &MountState,
        p: &Params,
        each: &mut dyn FnMut(Equation),
    ) {
        let (range, angle) = self.real(e, s);
        let by_stretch = e.range_m + self.mirror_m;
        let range_variance = e.range_sigma_m * e.range_sigma_m + RANGE_MODEL_M * RANGE_MODEL_M;
        let angle_variance = e.angle_sigma_rad * e.angle_sigma_rad;
        let corner_m = math::hypot(self.wall_m, s.height_m);
        let (right_m, right_rad, slope, turn) = match part {
            Part::Floor => {
                let (sin, cos) = math::sin_cos(angle);
                return each(Equation {
                    residual: range * sin - s.height_m,
                    by: [-1.0, range * cos, by_stretch * sin],
                    variance: floor_variance(e, range, p),
                    robust: true,
                });
            }
            Part::Flash => (self.wall_m, 0.0, 0.0, 0.0),
            Part::Corner => (
                corner_m,
                math::atan2(s.height_m, self.wall_m),
                s.height_m / corner_m,
                self.wall_m / (corner_m * corner_m),
            ),
        };
        each(Equation {
            residual: range - right_m,
            by: [-slope, 0.0, by_stretch],
            variance: range_variance,
            robust: false,
        });
        each(Equation {
            residual: angle - right_rad,
            by: [-turn, 1.0, 0.0],
            variance: angle_variance,
            robust: false,
        });
    }
}

/// Returns the inverse of a symmetric matrix; `None` if it is singular.
fn inverse(a: &[[f32; 3]; 3]) -> Option<[[f32; 3]; 3]> {
    let minor = |r: usize, c: usize| {
        let (i, j) = ((r + 1) % 3, (r + 2) % 3);
        let (k, l) = ((c + 1) % 3, (c + 2) % 3);
        let at = |r: usize, c: usize| a.get(r).and_then(|row| row.get(c)).copied().unwrap_or(0.0);
        at(i, k) * at(j, l) - at(i, l) * at(j, k)
    };
    let [[first, second, third], ..] = a;
    let det = first * minor(0, 0) + second * minor(0, 1) + third * minor(0, 2);
    if !det.is_normal() {
        return None;
    }
    let mut inverse = [[0.0; 3]; 3];
    for (r, row) in inverse.iter_mut().enumerate() {
        for (c, cell) in row.iter_mut().enumerate() {
            *cell = minor(c, r) / det;
        }
    }
    Some(inverse)
}

/// Result of the fit: mounting, and number of ground echoes (`floor`) and of outliers among them.
struct MountFit {
    state: MountState,
    /// Standard errors of height (metres), angle offset (radians) and range scale.
    sigmas: [f32; 3],
    floor: u8,
    outliers: u8,
}

/// Echoes of the wall's flash and of the corner of wall and ground, and the start of the fit that follows from
/// them.
struct ReferenceEchoes<'e> {
    flash: &'e Echo,
    corner: &'e Echo,
    start: MountState,
}

fn strongest<'e>(echoes: &'e [Echo], counts: &dyn Fn(&Echo) -> bool) -> Option<&'e Echo> {
    let counted = echoes.iter().filter(|e| counts(e));
    counted.reduce(|a, b| if b.snr_db > a.snr_db { b } else { a })
}

impl CalibrationScene {
    /// Finds the wall's flash and the corner of wall and ground, and checks that nothing else stands there. `nominal_m`
    /// is the configured mounting height, metres.
    fn find<'e>(&self, echoes: &'e [Echo], nominal_m: f32) -> Result<ReferenceEchoes<'e>, Refusal> {
        let scale = |e: &Echo| (self.wall_m + self.mirror_m) / (e.range_m + self.mirror_m);
        let placed = |e: &Echo| {
            let level = e.angle_rad.abs() <= MAX_OFFSET_RAD;
            level && (scale(e) - 1.0).abs() <= MAX_SCALE_ERROR && e.snr_db >= FLASH_DB
        };
        let flash = strongest(echoes, &placed).ok_or(Refusal::NoWall)?;
        let rival = |e: &Echo| {
            let apart = (e.range_m - flash.range_m).abs() > SAME_M;
            apart && e.snr_db >= math::max(FLASH_DB, flash.snr_db - LESSER_DB)
        };
        let start = MountState {
            height_m: nominal_m,
            offset_rad: -flash.angle_rad,
            stretch: scale(flash) - 1.0,
        };
        // A reflector that faces the scanner has its flash at the mirror's height, at any distance.
        let facing = |e: &Echo| (e.angle_rad - flash.angle_rad).abs() <= 0.5 * MAX_OFFSET_RAD;
        if strongest(echoes, &|e| facing(e) && rival(e)).is_some() {
            return Err(Refusal::SeveralWalls);
        }
        let above = |e: &Echo| {
            let (x, y) = self.point(e, &start);
            x < self.wall_m - CORNER_MARGIN_M && y > FLOOR_M
        };
        if strongest(echoes, &|e| above(e) && rival(e)).is_some() {
            return Err(Refusal::Clutter);
        }
        let base = |e: &Echo| {
            let (x, y) = self.point(e, &start);
            (x - self.wall_m).abs() <= CORNER_M && y.abs() <= FLOOR_M && e.snr_db >= CORNER_DB
        };
        let corner = strongest(echoes, &base).ok_or(Refusal::NoFloor)?;
        let (_, y) = self.point(corner, &start);
        let start = MountState {
            height_m: start.height_m - y,
            ..start
        };
        Ok(ReferenceEchoes {
            flash,
            corner,
            start,
        })
    }

    /// Returns whether an echo comes from the ground before the wall, if the mounting is `s`.
    fn is_floor(&self, e: &Echo, s: &MountState, p: &Params) -> bool {
        let (x, y) = self.point(e, s);
        let ahead = x > p.floor_from_m && x < self.wall_m - CORNER_MARGIN_M;
        ahead && y.abs() < p.floor_reach_m && e.snr_db > p.floor_least_db
    }

    fn fit(
        &self,
        echoes: &[Echo],
        found: &ReferenceEchoes<'_>,
        p: &Params,
    ) -> Result<MountFit, Refusal> {
        let mut state = found.start;
        let (mut floor, mut outliers, mut sigmas) = (0_u8, 0_u8, [0.0; 3]);
        for _ in 0..ROUNDS {
            let (mut a, mut b) = ([[0.0; 3]; 3], [0.0; 3]);
            (floor, outliers) = (0, 0);
            let mut add = |eq: Equation| {
                let tails = p.floor_cauchy_sigmas * p.floor_cauchy_sigmas * eq.variance;
                let off = eq.residual * eq.residual;
                let weight = if eq.robust {
                    1.0 / (1.0 + off / tails)
                } else {
                    1.0
                };
                floor = floor.saturating_add(u8::from(eq.robust));
                let far = off > OUTLIER_SIGMAS * OUTLIER_SIGMAS * eq.variance;
                outliers = outliers.saturating_add(u8::from(eq.robust && far));
                for (row, (right, d)) in a.iter_mut().zip(b.iter_mut().zip(eq.by)) {
                    let k = weight * d / eq.variance;
                    *right -= k * eq.residual;
                    for (cell, other) in row.iter_mut().zip(eq.by) {
                        *cell += k * other;
                    }
                }
            };
            self.equations(found.flash, Part::Flash, &state, p, &mut add);
            self.equations(found.corner, Part::Corner, &state, p, &mut add);
            for e in echoes.iter().filter(|e| self.is_floor(e, &state, p)) {
                self.equations(e, Part::Floor, &state, p, &mut add);
            }
            let covariance = inverse(&a).ok_or(Refusal::Misfit)?;
            let step = covariance.map(|row| row.iter().zip(&b).map(|(c, b)| c * b).sum::<f32>());
            let [height, offset, stretch] = step;
            state.height_m += height;
            state.offset_rad += offset;
            state.stretch += stretch;
            let [[h, ..], [_, o, _], [.., s]] = covariance;
            sigmas = [h, o, s].map(math::sqrt);
        }
        Ok(MountFit {
            state,
            sigmas,
            floor,
            outliers,
        })
    }

    /// Checks the fit against the expected scene and the limits of a mounting; `nominal_m` is the configured mounting
    /// height, metres.
    fn check_fit(
        &self,
        found: &ReferenceEchoes<'_>,
        fit: &MountFit,
        nominal_m: f32,
    ) -> Result<(), Refusal> {
        let (range, angle) = self.real(found.corner, &fit.state);
        let off_m = range - math::hypot(self.wall_m, fit.state.height_m);
        let off_rad = angle - math::atan2(fit.state.height_m, self.wall_m);
        if fit.floor < MIN_GROUND_ECHOES {
            return Err(Refusal::FewEchoes);
        }
        let corner = off_m.abs() <= CORNER_OFF_M && off_rad.abs() <= CORNER_OFF_RAD;
        if !corner || f32::from(fit.outliers) > OUTLIER_SHARE * f32::from(fit.floor) {
            return Err(Refusal::Misfit);
        }
        let height = (fit.state.height_m - nominal_m).abs() <= MAX_HEIGHT_ERROR_M;
        let offset = fit.state.offset_rad.abs() <= MAX_OFFSET_RAD;
        if !height || !offset || fit.state.stretch.abs() > MAX_SCALE_ERROR {
            return Err(Refusal::TooFar);
        }
        Ok(())
    }
}

/// Fits the mounting of the scanner from a scan of the ground and a wall `wall_m` metres from the mirror's
/// centre.
///
/// The echoes are placed with `config`, without any calibration; `mirror` is the mirror's own echo with the
/// same configuration.
///
/// # Errors
/// Returns the property of the scene that is not as expected.
pub fn calibrate(
    echoes: &[Echo],
    config: &Config,
    mirror: MirrorEcho,
    wall_m: f32,
    p: &Params,
) -> Result<Mounting, Refusal> {
    if config.mount.plane.first() != Plane::Depth {
        return Err(Refusal::Plane);
    }
    if !WALL_M.contains(&wall_m) {
        return Err(Refusal::Distance);
    }
    let scene = CalibrationScene {
        wall_m,
        mirror_m: config.mount.mirror_offset_m(),
    };
    let nominal_m = config.mount.mount_height_m();
    let found = scene.find(echoes, nominal_m)?;
    let fit = scene.fit(echoes, &found, p)?;
    scene.check_fit(&found, &fit, nominal_m)?;
    let [height, offset, stretch] = fit.sigmas;
    let tape = TAPE_M / (wall_m + scene.mirror_m);
    Ok(Mounting {
        height_m: Estimate::new(fit.state.height_m, height),
        offset_rad: Estimate::new(fit.state.offset_rad, offset),
        scale: Estimate::new(1.0 + fit.state.stretch, math::hypot(stretch, tape)),
        // Its range after the scale has been corrected.
        mirror_echo_m: Estimate::new(
            mirror.range_m * (1.0 + fit.state.stretch),
            MIRROR_BINS * config.radar.bin_spacing_m(),
        ),
        mirror_level_db: mirror.level_db,
        floor_echoes: fit.floor,
    })
}

#[cfg(test)]
mod tests;
