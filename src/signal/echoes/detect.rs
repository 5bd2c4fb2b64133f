//! Selection of echoes among the maxima: those that neither noise nor an artefact of a stronger echo explains.

use super::angle_filter::{self, LEVEL_DB};
use super::echo::{Echo, Echoes};
use super::ghosts::{Ghosts, Suspect};
use super::lobe::{Lobe, Responses};
use super::maxima::{MAX_MAXIMA, MaximaFinder, Maximum};
use super::noise::NoiseSamples;
use super::place::MotionCompensation;
use crate::config::Config;
use crate::math;
use crate::params::Params;
use crate::signal::grid::{DB_PER_UNIT, PolarMap};
use heapless::Vec;

/// Minimum number of rows around a maximum with a CA-CFAR detection (binary integration over the beam), from
/// which the maximum counts as distinct in range.
const MIN_DETECTED_ROWS: usize = 3;
/// Number of rows to each side of a maximum in which those with a CA-CFAR detection are counted. With a
/// false-alarm rate of 1.7e-4 per cell, three cells a row and 13 rows, noise alone reaches
/// [`MIN_DETECTED_ROWS`] once in 2·10⁷ positions.
const HIT_ROWS: usize = 6;

/// Background of the filtered map: noise and side lobes between the echoes.
#[derive(Debug)]
pub struct Background<'a> {
    /// Sampled levels of the filtered map, from which the noise floor of each range bin is taken.
    pub samples: &'a NoiseSamples,
    /// Noise: median of the filtered map without the filter's gain, map units (1/8 octave).
    pub noise: f32,
    /// Gain of the angle filter (over the rows) for uniform noise, 1/128 octave of power: 128 is a factor of two in
    /// power.
    pub gain: u16,
}

/// Returns the minimum filtered level of a maximum that is considered as an echo, 1/128 octave of power:
/// (`echo_margin_db` - `spare_db`) above the median `noise` (map units, without the filter's gain), plus the filter's
/// `gain` (1/128 octave).
pub fn least_level(noise: f32, gain: u16, spare_db: f32, params: &Params) -> u16 {
    let above_gain = (noise * DB_PER_UNIT + params.echo_margin_db - spare_db) / LEVEL_DB;
    gain.saturating_add(above_gain as u16)
}

/// Returns whether CA-CFAR has detections in enough rows around a maximum. Side lobes over all angles and
/// oscillator noise raise whole stretches of range and give no detections.
fn is_detected_in_range(map: &PolarMap, row: usize, bin: usize) -> bool {
    let rows = row.saturating_sub(HIT_ROWS)..row + HIT_ROWS + 1;
    map.rows_detected(rows, bin) >= MIN_DETECTED_ROWS
}

/// Writes to `echoes` those maxima of `finder` that only a separate scatterer explains, strongest first, and
/// empties `finder`.
#[inline(never)]
pub fn detect(
    map: &PolarMap,
    finder: &mut MaximaFinder,
    background: &Background<'_>,
    config: &Config,
    motion: Option<&MotionCompensation<'_>>,
    params: &Params,
    echoes: &mut Echoes,
) {
    let least = least_level(background.noise, background.gain, 0.0, params);
    let mut maxima: Vec<Maximum, MAX_MAXIMA> = Vec::new();
    while let Some(maximum) = finder.pop_weakest() {
        if maximum.level() >= least {
            // The vector has the capacity of the finder.
            let _ = maxima.push(maximum);
        }
    }
    let resolution_m = config.radar.range_resolution_m();
    let instrument = Instrument {
        map,
        background,
        resolution_m,
        offset_m: config.mount.mirror_offset_m(),
        responses: Responses::new(map, resolution_m, params),
        motion,
        ghosts: Ghosts {
            params,
            lobe_sigma_rad: angle_filter::lobe_sigma_rad(map.geometry()),
            image_sum: match config.radar.real {
                false => f32::from(config.radar.samples),
                // Real samples have no negative frequencies and no I/Q imbalance.
                true => f32::INFINITY,
            },
        },
        params,
    };
    echoes.clear();
    for &maximum in maxima.iter().rev() {
        if let Some(echo) = instrument.echo(maximum, echoes)
            && echoes.push(echo).is_err()
        {
            break;
        }
    }
}

/// Properties of the scan and the instrument that turn a maximum into an echo.
struct Instrument<'a> {
    map: &'a PolarMap,
    background: &'a Background<'a>,
    resolution_m: f32,
    offset_m: f32,
    responses: Responses,
    motion: Option<&'a MotionCompensation<'a>>,
    ghosts: Ghosts<'a>,
    params: &'a Params,
}

impl Instrument<'_> {
    /// Returns the echo of a maximum; `None` if noise, side lobes or an artefact of a stronger one of `echoes`
    /// explain it.
    #[inline(never)]
    fn echo(&self, maximum: Maximum, echoes: &[Echo]) -> Option<Echo> {
        let (map, params) = (self.map, self.params);
        let Background {
            samples,
            noise,
            gain,
        } = *self.background;
        let (row, bin) = maximum.cell(map.bins());
        let above_gain = f32::from(maximum.level().saturating_sub(gain));
        let snr_db = above_gain * LEVEL_DB - noise * DB_PER_UNIT;
        let stands_out = is_detected_in_range(map, row, bin);
        let floor_db = math::max(f32::from(samples.floor(bin)) - noise, 0.0) * DB_PER_UNIT;
        let margin_db = if floor_db > params.side_lobes_seen_db && !stands_out {
            params.side_lobe_margin_db
        } else {
            params.echo_margin_db
        };
        if snr_db < floor_db + margin_db {
            return None;
        }
        let patch = angle_filter::patch(map, row, bin);
        let geometry = map.geometry();
        let responses = match self.motion {
            None => self.responses,
            Some(ride) => {
                let range_m = geometry.range_m(bin as f32);
                self.responses
                    .of_motion(ride.scatterer_motion(map, row, range_m))
            }
        };
        let lobe = Lobe::new(&patch, &responses, snr_db, params);
        let place = [row as f32 + lobe.row.value, bin as f32 + lobe.bin.value];
        let range_m = geometry.range_m(place[1]);
        let suspect = Suspect {
            native_bin: (range_m + self.offset_m) / self.resolution_m,
            angle_rad: map.angle_rad(row) + lobe.row.value * geometry.step_rad,
            snr_db,
            stands_out,
        };
        if echoes.iter().any(|e| self.ghosts.explain(e, &suspect)) {
            return None;
        }
        let (x_m, y_m) = geometry.point(range_m, suspect.angle_rad);
        Some(Echo {
            snr_db,
            range_m,
            angle_rad: suspect.angle_rad,
            x_m,
            y_m,
            width: lobe.width,
            angle_sigma_rad: lobe.row.sigma() * geometry.step_rad,
            range_sigma_m: lobe.bin.sigma() * geometry.bin_m,
            native_bin: suspect.native_bin,
        })
    }
}
