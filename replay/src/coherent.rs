//! Coherent image of a scan, and its echoes by CLEAN, beside those that the estimator uses.

use std::fmt::Write as _;

use serde_json::{Value, json};
use stairscan::config::Config;
use stairscan::signal::echoes::{Echoes, FoundEchoes};
use stairscan::signal::grid::{Geometry, PolarMap};
use stairscan::signal::image::KeptImage;
use stairscan::signal::range::FULL_SCALE;

use crate::inspect::decimal;
use crate::replay::Scanned;

/// Levels of a map per octave of power.
const LEVELS_PER_OCTAVE: f32 = 8.0;

/// A scan's coherent image with its echoes.
pub struct CoherentView {
    /// Echoes, the strongest first.
    pub echoes: Echoes,
    /// Mean power of the noise; a full-scale tone in one row has power 1.
    pub noise: f32,
    image: KeptImage,
    geometry: Geometry,
    config: Config,
}

impl CoherentView {
    /// Finds the echoes of a scan's coherent image; `None` without an image or without rows.
    pub fn of(scanned: &Scanned<'_>) -> Option<Box<Self>> {
        let mut image = scanned.image?.clone();
        image.finish();
        let noise = image.noise()?;
        let (map, config) = (scanned.pipeline.map(), scanned.config);
        let mut found = FoundEchoes::NONE;
        image.clone().detect(map, config, &mut found);
        Some(Box::new(Self {
            echoes: found.echoes,
            noise,
            image,
            geometry: *map.geometry(),
            config: *config,
        }))
    }

    /// Returns the power of the image over its noise at a range from the mirror, metres, and a beam angle, radians.
    pub fn over_noise(&self, range_m: f32, angle_rad: f32) -> f32 {
        let geometry = &self.geometry;
        // The cast saturates.
        let bin = ((range_m - geometry.first_range_m) / geometry.bin_m).round() as usize;
        self.image.power(angle_rad, bin) / self.noise
    }

    /// Returns the image's power at the rows and bins of the map.
    pub fn map(&self) -> Box<PolarMap> {
        let mut map = Box::new(PolarMap::new());
        // The map was shaped by the same configuration before.
        let _ = map.begin(&self.config);
        for k in 0..map.rows() {
            let angle_rad = map.angle_rad(k);
            map.fill(k, |row| {
                for (bin, cell) in row.cells.iter_mut().enumerate() {
                    let power = self.image.power(angle_rad, bin).max(f32::MIN_POSITIVE);
                    let level = f32::from(FULL_SCALE) + LEVELS_PER_OCTAVE * power.log2();
                    // The cast saturates.
                    *cell = level.round() as u8;
                }
            });
        }
        map
    }

    /// Returns the echoes as a table of text.
    pub fn text(&self) -> String {
        let mut text = format!(
            "coherent image: noise {:.1} dB of full scale\n\n  snr dB  distance m  height m  range σ mm  angle σ °\n",
            10.0 * self.noise.log10()
        );
        for e in &self.echoes {
            let _ = writeln!(
                text,
                "  {:6.1} {:11.3} {:9.3} {:11.2} {:10.2}",
                e.snr_db,
                e.x_m,
                e.y_m,
                1e3 * e.range_sigma_m,
                e.angle_sigma_rad.to_degrees(),
            );
        }
        text.push_str("  snr: power of one row's cell above the noise.\n");
        text
    }

    /// Returns the echoes as JSON: noise, dB of full scale, and for each echo what `scatterers` has.
    pub fn json(&self) -> Value {
        let echoes = self.echoes.iter().map(|e| {
            json!({
                "snr_db": decimal(e.snr_db.into()),
                "range_m": decimal(e.range_m.into()),
                "angle_deg": decimal(e.angle_rad.to_degrees().into()),
                "distance_m": decimal(e.x_m.into()),
                "height_m": decimal(e.y_m.into()),
                "range_sigma_m": decimal(e.range_sigma_m.into()),
                "angle_sigma_deg": decimal(e.angle_sigma_rad.to_degrees().into()),
            })
        });
        json!({
            "noise_dbfs": decimal((10.0 * self.noise.log10()).into()),
            "scatterers": echoes.collect::<Vec<_>>(),
        })
    }
}
