//! Depth plane and height plane of one scanner: selection of a scan's plane, with the setting `plane both`.
//!
//! The depth plane detects where the ground ends, but hardly the treads below, which are in the shadow of the
//! edge. The height plane covers treads from above, and nothing far ahead. So every scan is made in the depth
//! plane, except the one after an answer of the depth plane that reports a drop, if the height plane reaches
//! that drop ([`reach_m`]) and the chair stands ([`requests_height_plane`]). A scan in the height plane is independent of
//! the others: it is compared with none of them and leaves their evidence unchanged
//! ([`Retention::Aside`](crate::drive::Retention)).

use crate::config::{Config, ConfigError, EstimatorKind, Plane, Planes, check};
use crate::drive::{Drive, Input, Mode};
use crate::math;
use crate::params::Params;
use crate::schedule::Schedule;
use crate::signal::grid::BinWindow;
use crate::verdict::{Outcome, Reason};

/// Angle of the last row, 0.001°, beyond which the two planes have common ground: the height plane reaches the ground
/// at H tan α (α from straight down), the depth plane at H / tan α (α below the horizontal), with mounting height H.
const COMMON_GROUND: i32 = 45_000;

/// Returns the plane of a scan; `height_requested` if the previous answer requests the height plane.
pub(super) fn plane_of(planes: Planes, height_requested: bool) -> Plane {
    match planes {
        Planes::Both if height_requested => Plane::Height,
        _ => planes.first(),
    }
}

/// Checks that the shaft can turn to every row of every plane, and that `both` can lead to a scan in the height
/// plane.
pub(super) fn check_planes(config: &Config) -> Result<(), ConfigError> {
    Schedule::new(config)?;
    if config.mount.plane != Planes::Both {
        return Ok(());
    }
    let turned = Schedule::in_plane(config.sweep, Plane::Height);
    check(
        turned.is_ok(),
        "first-angle",
        "-80000 or more with plane both: the height plane turns the shaft to 90 degrees less the angle",
    )?;
    let last = config
        .sweep
        .angle(config.sweep.angle_count.saturating_sub(1));
    check(
        last > COMMON_GROUND,
        "angle-count",
        "with plane both angles beyond 45 degrees: otherwise the planes have no common ground",
    )?;
    let (height_m, range_m) = (config.mount.mount_height_m(), range_m(config));
    check(
        2.0 * height_m * height_m < range_m * range_m,
        "mount-height",
        "with plane both less than 0.7 of the range beyond the mirror",
    )?;
    check(
        config.estimator == EstimatorKind::Likelihood,
        "estimator",
        "likelihood with plane both: no other estimator reports drops",
    )
}

/// Returns the range of the map's last range bin, metres from the mirror.
fn range_m(config: &Config) -> f32 {
    let window = BinWindow::of_scan(config);
    let end = f32::from(window.first.saturating_add(window.count));
    end * config.radar.bin_spacing_m() - config.mount.mirror_offset_m()
}

/// Returns how far ahead of the mirror the height plane covers the ground, metres: to where the beam of its
/// last row meets it, or to the end of the range.
pub(super) fn reach_m(config: &Config) -> f32 {
    let last = config.sweep.angle_count.saturating_sub(1);
    let (_, cos) = math::sin_cos(config.sweep.angle(last) as f32 * 1e-3 * math::RAD_PER_DEG);
    let (height_m, range_m) = (config.mount.mount_height_m(), range_m(config));
    let slant_m = if height_m < cos * range_m {
        height_m / cos
    } else {
        range_m
    };
    math::sqrt(slant_m * slant_m - height_m * height_m)
}

/// Whether an answer of the depth plane requests a scan in the height plane: it reports a drop within the
/// height plane's reach, and the chair stands.
pub(super) fn requests_height_plane(
    config: &Config,
    outcome: &Outcome,
    drive: &Drive<'_>,
    p: &Params,
) -> bool {
    let near = |m: f32| m <= reach_m(config);
    let edge = outcome.answer.drop.as_ref();
    edge.is_some_and(|edge| near(edge.distance_m)) && stands(outcome, drive, p)
}

/// Whether the chair stands: it is known to, or its controller reports it, or, without any motion input, two
/// sweeps from one position agree.
fn stands(outcome: &Outcome, drive: &Drive<'_>, p: &Params) -> bool {
    let reasons = outcome.reasons();
    match (drive.mode, drive.input) {
        (Mode::Standing, _) => true,
        (_, Input::Good) => drive
            .track
            .is_some_and(|track| !track.moves(p.stood_m, p.stood_rad)),
        (Mode::Auto, Input::Absent) => {
            !reasons.has(Reason::Unconfirmed) && !reasons.has(Reason::Moving)
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests;
