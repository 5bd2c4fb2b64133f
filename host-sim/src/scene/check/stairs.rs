//! Checks of flights of stairs and kerbs.

use anyhow::{Result, ensure};

use super::number::{LENGTH, POSITION, number, numbers};
use crate::scene::flight::CHANNEL_WALL;
use crate::scene::spec::{StairsSpec, Way};

/// Maximum number of steps of one flight.
const MAX_STEPS: usize = 64;

/// Rejects a flight that cannot be built.
pub fn flight(prefix: &str, s: &StairsSpec) -> Result<()> {
    ensure!(
        (1..=MAX_STEPS).contains(&s.count),
        "{prefix}count: {}: expected 1 to {MAX_STEPS} steps",
        s.count
    );
    let (rise, going) = ((0.005, 2.0), (0.02, 5.0));
    let values = [
        ("distance_m", s.distance_m, POSITION),
        ("base_m", s.base_m, POSITION),
        ("rise_m", s.rise_m, rise),
        ("going_m", s.going_m, going),
        ("nosing_m", s.nosing_m, (0.0, 0.9 * s.going_m)),
        ("nosing_radius_m", s.nosing_radius_m, (0.0, 0.1)),
        ("batter_m", s.batter_m, (0.0, 0.5 * going.1)),
        ("strip_m", s.strip_m, (0.0, 0.9 * s.going_m)),
        ("strip_proud_m", s.strip_proud_m, (0.0, 0.02)),
        ("tread_thickness_m", s.tread_thickness_m, (1e-3, 1.0)),
        (
            "tread_depth_m",
            s.tread_depth_m.unwrap_or(s.going_m),
            (0.02, 5.0),
        ),
        ("tread_fall", s.tread_fall, (0.0, 0.1)),
        ("channel_m", s.channel_m, (0.0, 0.3)),
        ("channel_flange_m", s.channel_flange_m, (1e-3, 0.2)),
        ("landing_m", s.landing_m, LENGTH),
        ("width_m", s.width_m.unwrap_or(1.0), LENGTH),
    ];
    numbers(prefix, &values)?;
    for (key, list, range, wanted) in [
        ("rises_m", &s.rises_m, rise, s.count),
        ("goings_m", &s.goings_m, going, s.count - 1),
    ] {
        ensure!(
            list.is_empty() || list.len() == wanted,
            "{prefix}{key}: {} numbers: expected {wanted} for count = {}",
            list.len(),
            s.count
        );
        for (k, value) in list.iter().enumerate() {
            number(&format!("{prefix}{key}[{k}]"), *value, range)?;
        }
    }
    let shortest = s.goings_m.iter().copied().fold(s.going_m, f64::min);
    ensure!(
        s.nosing_m + 2.0 * s.nosing_radius_m < shortest && s.landing_m > s.nosing_radius_m,
        "{prefix}nosing_m: {}: expected nosing and rounding to leave some of the going of {shortest}",
        s.nosing_m
    );
    let lowest = s.rises_m.iter().copied().fold(s.rise_m, f64::min);
    let longest = s.goings_m.iter().copied().fold(s.going_m, f64::max);
    ensure!(
        s.tread_fall == 0.0 || (s.direction == Way::Up && !s.open),
        "{prefix}tread_fall: {}: expected 0 for floating treads and flights going down",
        s.tread_fall
    );
    ensure!(
        s.tread_fall * longest < 0.5 * lowest,
        "{prefix}tread_fall: {}: expected a fall over the going of {longest} below half the rise of {lowest}",
        s.tread_fall
    );
    front(prefix, s, (lowest, shortest))?;
    channel(prefix, s, (lowest, shortest))
}

/// Checks battered (inclined) risers and nosing strips: only on closed flights going up, and smaller than the lowest
/// riser and the shortest tread.
fn front(prefix: &str, s: &StairsSpec, (lowest, shortest): (f64, f64)) -> Result<()> {
    let closed = s.direction == Way::Up && !s.open;
    ensure!(
        s.batter_m == 0.0 || (closed && s.nosing_m == 0.0),
        "{prefix}batter_m: {}: expected 0 for floating treads, flights going down and treads with a nosing",
        s.batter_m
    );
    ensure!(
        s.batter_m < 0.5 * lowest && s.batter_m + 2.0 * s.nosing_radius_m < shortest,
        "{prefix}batter_m: {}: expected less than half the rise of {lowest}, and to leave some of the going",
        s.batter_m
    );
    ensure!(
        s.strip_m == 0.0 || (closed && s.tread_fall == 0.0),
        "{prefix}strip_m: {}: expected 0 for floating treads, flights going down and treads with fall",
        s.strip_m
    );
    let longest = shortest.min(s.landing_m) - s.nosing_m - s.batter_m;
    ensure!(
        s.strip_m == 0.0 || (s.nosing_radius_m < s.strip_m && s.strip_m < longest),
        "{prefix}strip_m: {}: expected more than nosing_radius_m, and to leave some of the tread",
        s.strip_m
    );
    ensure!(
        s.strip_m > 0.0 || (s.strip_proud_m == 0.0 && s.strip_material.is_none()),
        "{prefix}strip_m: 0: expected more, for strip_proud_m or strip_material say what the strips are like"
    );
    Ok(())
}

/// Checks a channel: only on floating treads going up, lower than the rise and shorter than the
/// tread.
fn channel(prefix: &str, s: &StairsSpec, (lowest, shortest): (f64, f64)) -> Result<()> {
    if s.channel_m == 0.0 {
        return Ok(());
    }
    ensure!(
        s.open && s.direction == Way::Up,
        "{prefix}channel_m: {}: expected 0 but for floating treads going up",
        s.channel_m
    );
    let least = 4.0 * CHANNEL_WALL;
    ensure!(
        (least..lowest).contains(&s.channel_m),
        "{prefix}channel_m: {}: expected from {least} to less than the rise of {lowest}",
        s.channel_m
    );
    let depth = s.tread_depth_m.unwrap_or(shortest).min(shortest);
    ensure!(
        (least..depth).contains(&s.channel_flange_m),
        "{prefix}channel_flange_m: {}: expected from {least} to less than the tread's depth of {depth}",
        s.channel_flange_m
    );
    Ok(())
}
