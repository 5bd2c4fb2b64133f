//! From candidates to echoes: what neither the noise nor a stronger echo could have made.

use super::MAX_BINS;
use super::beam::{self, LEVEL_DB};
use super::candidate::Candidate;
use super::scatterer::{self, Clusters, HANN_CURVATURE, Lobe, Mode, Place, Responses};
use super::trace::{Observer, Stage};
use crate::config::Config;
use crate::math;
use crate::stairs::map::{DB_PER_UNIT, PolarMap};
use crate::stairs::particles::SizedCloud;
use heapless::Vec;
use rand_core::Rng;

/// Most echoes of a scan.
pub const MAX_ECHOES: usize = 64;

/// Filtered power above the noise that counts, dB: noise alone exceeds it once in some hundred
/// independent places.
const NOISE_DB: f32 = 2.8;
/// Where the median over all angles shows side lobes, an echo must stand this high above it, dB.
const LOBE_DB: f32 = 9.0;
/// By how much that median must exceed the noise to be taken for side lobes, dB.
const LOBE_SEEN_DB: f32 = 0.9;
/// Two-way side lobes of the beam, worst case, any angle at the same range, dB.
const PEDESTAL_DB: f32 = 17.0;
/// Range skirts of an echo (sweep non-linearity, oscillator noise near the carrier), dB …
const SKIRT_DB: f32 = 25.0;
/// … and how far they reach, native range bins.
const SKIRT_BINS: f32 = 9.0;
/// Reach of an echo's own lobe in range, native bins.
const LOBE_BINS: f32 = 2.0;
/// I/Q image at Ns - bin, dB.
const IMAGE_DB: f32 = 30.0;
/// Oscillator noise of a strong echo: every range, same angle, dB.
const PHASE_DB: f32 = 40.0;

/// Binary integration of CA-CFAR over the beam: an echo stands out from what surrounds it in range
/// if so many rows let it through …
const HITS: usize = 3;
/// … of those up to this many beside its own. Noise, and all that is as even in range as noise,
/// does once in 10⁷ places.
const HIT_ROWS: usize = 6;

/// By how much a ghost's level differs at most between a cell's middle and the peak within, dB.
const ROUGH_DB: f32 = 3.0;

/// One echo: a point scatterer, as far as the map tells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Echo {
    /// Filtered power above the noise, dB.
    pub db: f32,
    /// Range from the mirror, metres.
    pub range_m: f32,
    /// Angle, radians.
    pub angle_rad: f32,
    /// Horizontal distance from the mirror, metres.
    pub x: f32,
    /// Height above the ground, metres.
    pub y: f32,
    /// Standard width of the filtered lobe in angle, in units of a point scatterer's.
    pub width: f32,
    /// Standard deviation of the angle, radians.
    pub angle_sigma: f32,
    /// Standard deviation of the range, metres.
    pub range_sigma: f32,
    /// Native range bin (c/2B) from the radar.
    pub bin: f32,
}

/// What the map shows where there is no echo.
#[derive(Clone, Copy, Debug)]
pub struct Background<'a> {
    /// Median over the angles per stored range bin, map units.
    pub floors: &'a [u8; MAX_BINS],
    /// Median over the whole map, map units.
    pub noise: f32,
    /// What the filter adds to a level, 1/128 octave.
    pub gain: u16,
}

/// What no candidate may be below, 1/128 octave, less `spare_db`: somewhat less than what [`select`]
/// asks, for a filter that adds `gain` and a noise in map units.
pub fn least(noise: f32, gain: u16, spare_db: f32) -> u16 {
    let above_gain = (noise * DB_PER_UNIT + NOISE_DB - spare_db) / LEVEL_DB;
    gain.saturating_add(above_gain as u32 as u16)
}

/// Whether CA-CFAR lets enough of a candidate's rows through: side lobes over all angles and
/// oscillator noise raise a whole stretch of range and do not.
fn stands_out(map: &PolarMap, row: u16, bin: u8) -> bool {
    let row = usize::from(row);
    let rows = row.saturating_sub(HIT_ROWS)..row + HIT_ROWS + 1;
    map.rows_hit(rows, bin.into()) >= HITS
}

/// Goes through the candidates, strongest first, and keeps what only a scatterer of its own
/// explains.
#[inline(never)]
pub fn select(
    map: &PolarMap,
    candidates: &[Candidate],
    background: &Background<'_>,
    config: &Config,
    rng: &mut impl Rng,
    observer: &mut impl Observer,
) -> Vec<Echo, MAX_ECHOES> {
    let geometry = map.geometry();
    let Background {
        floors,
        noise,
        gain,
    } = *background;
    let resolution_m = config.radar.range_resolution_m();
    let offset_m = config.mount.mirror_offset_m();
    let samples = f32::from(config.radar.samples);
    let responses = Responses::new(map, resolution_m);
    let mut modes: Vec<Mode, MAX_ECHOES> = Vec::new();
    // Two-way pattern seen through the matched filter.
    let lobe_sigma = beam::two_way_sigma(geometry.beamwidth_rad) * core::f32::consts::SQRT_2;
    let mut echoes = Vec::new();
    for candidate in candidates {
        let (row, bin) = (candidate.row(), candidate.bin());
        let floor = floors.get(usize::from(bin)).copied().unwrap_or(0);
        let floor_db = math::max(f32::from(floor) - noise, 0.0) * DB_PER_UNIT;
        let above_gain = f32::from(candidate.level().saturating_sub(gain));
        let db = above_gain * LEVEL_DB - noise * DB_PER_UNIT;
        // Looked at only where it can matter.
        let lobes = floor_db > LOBE_SEEN_DB;
        let strongest = echoes.first().map_or(db, |e: &Echo| e.db);
        let stands_out = (lobes || db < strongest + 1.0 - PHASE_DB) && stands_out(map, row, bin);
        let needed = if lobes && !stands_out {
            LOBE_DB
        } else {
            NOISE_DB
        };
        if db < floor_db + needed {
            continue;
        }
        // What is far below a ghost need not be looked at closely.
        let is_ghost = |bin: f32, angle: f32, db: f32| {
            let native = (geometry.range_m(bin) + offset_m) / resolution_m;
            let explains = |e: &Echo| {
                let needed = db - e.db;
                // Farther off in range no ghost reaches up to its skirts.
                ((native - e.bin).abs() < LOBE_BINS || needed < 1.0 - SKIRT_DB)
                    && needed < ghost_db(e, native, angle, lobe_sigma, samples, stands_out)
            };
            echoes.iter().any(explains)
        };
        let row_angle = map.angle_rad(usize::from(row));
        if is_ghost(bin.into(), row_angle, db + ROUGH_DB) {
            continue;
        }
        let lobe = Lobe::new(&beam::patch(map, row, bin), &responses, db);
        let [row_off, bin_off] = lobe.peak;
        let cell = [row, bin.into()];
        let bin = f32::from(bin) + bin_off;
        let angle_rad = row_angle + row_off * geometry.step_rad;
        let range_m = geometry.range_m(bin);
        let native = (range_m + offset_m) / resolution_m;
        if is_ghost(bin, angle_rad, db) {
            continue;
        }
        let (x, y) = geometry.point(range_m, angle_rad);
        let echo = Echo {
            db,
            range_m,
            angle_rad,
            x,
            y,
            width: lobe.width,
            bin: native,
            ..Echo::default()
        };
        if echoes.push(echo).is_err() {
            break;
        }
        let _ = modes.push(Mode { cell, lobe });
    }
    observer.done(Stage::Echoes);
    let particles = usize::from(config.particles.particles);
    let mut cloud = SizedCloud::new();
    let mut clusters = Clusters::new();
    let (mut settled, mut kept) = (0, 0);
    scatterer::refine(&mut cloud, &modes, particles, rng, |place| {
        let Some(&(mut echo)) = echoes.get(settled) else {
            return;
        };
        settled += 1;
        echo.settle(map, &place);
        // A mode that went to where a stronger one is shows the same scatterer once more.
        if clusters.is_new(&place)
            && let Some(place) = echoes.get_mut(kept)
        {
            *place = echo;
            kept += 1;
        }
    });
    echoes.truncate(kept);
    observer.done(Stage::Particles);
    echoes
}

impl Echo {
    /// Moves the echo to where its particles say that it is.
    fn settle(&mut self, map: &PolarMap, place: &Place) {
        let geometry = map.geometry();
        let [row, bin] = place.at;
        let [row_sigma, bin_sigma] = place.sigma;
        let whole = row as usize;
        self.range_m = geometry.range_m(bin);
        self.angle_rad = map.angle_rad(whole) + (row - whole as f32) * geometry.step_rad;
        (self.x, self.y) = geometry.point(self.range_m, self.angle_rad);
        self.angle_sigma = row_sigma * geometry.step_rad;
        self.range_sigma = bin_sigma * geometry.bin_m;
    }
}

/// Highest level relative to echo `e` that `e` itself could show at the place (native bin, angle).
fn ghost_db(
    e: &Echo,
    native: f32,
    angle: f32,
    lobe_sigma: f32,
    samples: f32,
    stands_out: bool,
) -> f32 {
    const NEVER: f32 = -99.0;
    let bins = (native - e.bin).abs();
    let turn = (angle - e.angle_rad) / lobe_sigma;
    let lobe = -2.171_472_4 * turn * turn;
    let mut ghost = lobe + 1.0
        - if bins <= SKIRT_BINS {
            SKIRT_DB
        } else if stands_out {
            -NEVER
        } else {
            PHASE_DB
        };
    if bins < LOBE_BINS {
        let response = if bins < 1.7 {
            -HANN_CURVATURE * bins * bins
        } else {
            NEVER
        };
        ghost = math::max(ghost, response + math::max(lobe + 3.0, -PEDESTAL_DB));
    }
    if (native + e.bin - samples).abs() < 2.5 {
        ghost = math::max(ghost, lobe + 1.0 - IMAGE_DB);
    }
    ghost
}
