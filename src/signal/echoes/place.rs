//! Motion compensation: echoes as seen from the mirror at the scan's last row.
//!
//! Each row was observed from the chair's position and pitch at its time. An up-chirp's echo from an
//! approaching scatterer has a beat frequency that is lower by the Doppler shift, so the scatterer appears
//! nearer than it is at mid chirp.

use super::echo::Echo;
use crate::config::{Plane, RadarConfig};
use crate::drive::Drive;
use crate::signal::grid::{Geometry, PolarMap};
use crate::track::{RowPose, Track};

/// Motion of the chair during a scan, by which its echoes are compensated.
#[derive(Clone, Copy, Debug)]
pub struct MotionCompensation<'a> {
    /// Time of each row, and position of the chair at that time.
    pub track: &'a Track,
    /// Steady forward speed that replaces the track's travel, m/s; `None` where the track's travel applies.
    pub steady_speed: Option<f32>,
    /// Range-Doppler coupling: metres by which a scatterer appears nearer, per m/s of approach. It is carrier
    /// times duration over bandwidth of the chirp, seconds.
    pub coupling_s: f32,
}

impl<'a> MotionCompensation<'a> {
    /// Returns the motion of the chair by its motion input; `None` if that was not good during the scan.
    pub fn of(drive: &Drive<'a>, radar: &RadarConfig) -> Option<Self> {
        Some(Self::along(drive.known()?, drive, radar))
    }

    /// Returns the motion along `track`, whether or not the motion input is good; `drive` gives the chirp's
    /// duration.
    pub fn along(track: &'a Track, drive: &Drive<'a>, radar: &RadarConfig) -> Self {
        let ratio = radar.carrier_khz as f32 / radar.bandwidth_khz.max(1) as f32;
        Self {
            track,
            steady_speed: None,
            coupling_s: drive.chirp_s * ratio,
        }
    }

    /// Returns the time of row `row`, which may be fractional, and the chair's travel and pitch at that time.
    pub fn at(&self, row: f32) -> RowPose {
        self.with_steady_speed(self.track.at(row))
    }

    /// Returns the time of the last row, and the chair's travel and pitch at that time.
    pub fn end(&self) -> RowPose {
        self.with_steady_speed(self.track.end())
    }

    fn with_steady_speed(&self, place: RowPose) -> RowPose {
        match self.steady_speed {
            Some(speed) => RowPose {
                travel_m: speed * place.time_s,
                ..place
            },
            None => place,
        }
    }

    /// Returns the chair's forward speed around row `row`, m/s.
    pub fn speed(&self, row: f32) -> f32 {
        self.steady_speed.unwrap_or_else(|| self.track.speed(row))
    }

    /// Changes range, angle and position of `echo` to those of its scatterer as seen from the mirror at the
    /// last row.
    pub fn compensate(&self, echo: &mut Echo, map: &PolarMap) {
        let geometry = map.geometry();
        let row = row_of(echo, map);
        let at = self.at(row);
        let angle_rad = match geometry.plane {
            Plane::Depth => echo.angle_rad - at.pitch_rad,
            Plane::Height => echo.angle_rad + at.pitch_rad,
        };
        let nearing = self.speed(row) * forward(geometry, angle_rad);
        let range_m = echo.range_m + nearing * self.coupling_s;
        let (x_m, y_m) = geometry.point(range_m, angle_rad);
        echo.x_m = x_m - (self.end().travel_m - at.travel_m);
        echo.y_m = y_m;
        (echo.range_m, echo.angle_rad) = geometry.polar(echo.x_m, echo.y_m);
    }
}

/// Returns the horizontal forward component (0 to 1 ahead, negative behind) of the unit vector from the mirror along
/// beam angle `angle_rad`, which is measured as [`Echo::angle_rad`].
pub fn forward(geometry: &Geometry, angle_rad: f32) -> f32 {
    geometry.point(1.0, angle_rad).0
}

/// Returns the (fractional) row of an echo that has not been motion-compensated.
pub fn row_of(echo: &Echo, map: &PolarMap) -> f32 {
    (echo.angle_rad - map.angle_rad(0)) / map.geometry().step_rad
}
