//! Wall: behind the risers of any kind, or on level ground. It is a part of a hypothesis rather than a kind of its own.

use crate::model::feature::Class;
use crate::model::normal::{ln, tailed};
use crate::params::posterior;
use heapless::Vec;

/// Width of the posterior of a wall's place, metres, √(2π) included: its strong echo determines it to millimetres.
const VOLUME_M: f32 = 0.006;
/// Prior probability that a wall stands behind the stairs or on the ground, within the 2.5 m ahead.
const P_WALL: f32 = 0.4;
/// Minimum probability that a wall whose corner is visible flashes at the mirror's height, since it is vertical. The
/// lower 95 % bound (Clopper and Pearson 1934) of 64 of 64 walls of tuning scenes whose corner stands 18 dB above the
/// noise.
pub const FLASHES: f32 = 0.954;
/// Probability that a wall has no echo.
pub const HIDDEN: f32 = 0.3;
/// Density of a wall's echoes, relative to a face's.
const SHARE: f32 = 0.25;
/// Standard deviation of the distance of a wall's echoes from it, metres.
const SIGMA_M: f32 = 0.008;
/// Squared deviation, in standard deviations, beyond which an echo is not part of a wall.
const REACH: f32 = 60.0;
/// Depth below the ground before a wall down to which its echoes may lie, metres.
const BELOW_M: f32 = 0.03;
/// Distance between two features of a wall, in resolution cells: they never merge.
const SEPARATION_CELLS: f32 = 2.0;
/// Minimum distance between two walls that are tried, metres: echoes nearer to each other are one wall.
const APART_M: f32 = 0.05;
/// Minimum SNR of an echo that may be a wall, dB.
const MIN_DB: f32 = 8.0;
/// Maximum number of walls that are tried behind a staircase or on level ground, besides no wall.
pub const WALLS: usize = 2;

/// Returns the log-prior of a wall at `wall_m`, metres, or of none (infinity), nats.
pub fn log_prior(wall_m: f32) -> f32 {
    if wall_m.is_finite() {
        const { ln(P_WALL / super::WAY_M * VOLUME_M) }
    } else {
        const { ln(1.0 - P_WALL) }
    }
}

/// Point features of a wall, from the foot up.
#[derive(Clone, Copy, Debug)]
pub struct WallFeature {
    /// Class of the feature.
    pub class: Class,
    /// Height of the feature above the ground, metres.
    pub y_m: f32,
    /// Distance to the neighbouring feature, in resolution cells.
    pub separation_cells: f32,
}

/// Returns the point features of a wall whose foot is at height `foot_m` above the ground, metres, seen from a mirror at
/// `mirror_m`; none where its foot is not visible.
pub fn features(foot_m: f32, mirror_m: f32) -> Option<[WallFeature; 2]> {
    let feature = |class, y_m| WallFeature {
        class,
        y_m,
        separation_cells: SEPARATION_CELLS,
    };
    let visible = foot_m < mirror_m - posterior::SEES_FOOT_M;
    visible.then(|| {
        [
            feature(Class::Corner, foot_m),
            feature(Class::Flash, mirror_m),
        ]
    })
}

/// Returns the density of an echo as part of the wall's face, from that as part of a riser's, `face`; 0 beyond its reach.
/// `off_m` is the echo's distance from the wall, `y_m` its height, and `foot_m` that of the ground before the wall,
/// metres.
#[inline]
pub fn density(face: f32, off_m: f32, y_m: f32, foot_m: f32) -> f32 {
    let z = off_m / SIGMA_M;
    if y_m > foot_m - BELOW_M && z * z < REACH {
        SHARE * face * tailed(z * z) / SIGMA_M
    } else {
        0.0
    }
}

/// An echo that may be a wall.
#[derive(Clone, Copy, Debug)]
pub struct WallEcho {
    /// Horizontal distance from the mirror, metres.
    pub x_m: f32,
    /// SNR, dB.
    pub snr_db: f32,
}

/// Returns "no wall" (infinity) and the distances, metres, of the strongest `echoes` beyond `from_m` that may be a wall.
pub fn places(
    echoes: impl Iterator<Item = WallEcho> + Clone,
    from_m: f32,
) -> Vec<f32, { WALLS + 1 }> {
    let mut walls = Vec::new();
    let _ = walls.push(f32::INFINITY);
    for _ in 0..WALLS {
        let far = echoes.clone().filter(|e| {
            let apart = walls.iter().all(|w: &f32| (w - e.x_m).abs() > APART_M);
            e.snr_db > MIN_DB && e.x_m > from_m && apart
        });
        if let Some(e) = far.max_by(|a, b| a.snr_db.total_cmp(&b.snr_db)) {
            let _ = walls.push(e.x_m);
        }
    }
    walls
}
