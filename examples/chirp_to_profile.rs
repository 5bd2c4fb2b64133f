//! One chirp to a range profile with its detections, by the code that runs on the chip.
//!
//! ```sh
//! cargo run --example chirp_to_profile > profile.txt
//! gnuplot -p -e 'plot "profile.txt" using 1:2 with lines, "" using 1:3 with lines'
//! ```
//!
//! The chirp is made here: the echo of the mirror, 22 cm from the radar, two targets behind it, and
//! noise. Columns are the range from the mirror in metres, power and CA-CFAR threshold in dB
//! relative to full scale; lines with `#` name the detections.

use std::error::Error;
use std::f64::consts::TAU;

use stairscan::Iq;
use stairscan::config::Config;
use stairscan::signal::range::{Profile, RangeProcessor};

/// What stands before the radar: range from the mirror in metres, amplitude in units of 32768.
const ECHOES: [(f64, f64); 3] = [(0.0, 8000.0), (0.60, 900.0), (0.95, 250.0)];
/// Amplitude of the noise, uniform, in the same unit.
const NOISE: f64 = 20.0;

/// A chirp of `samples` samples: an echo at range R from the radar beats R / (c / 2B) times a chirp.
fn chirp(config: &Config) -> Vec<Iq> {
    let resolution_m = f64::from(config.radar.range_resolution_m());
    let offset_m = f64::from(config.mount.mirror_offset_m());
    // A linear congruential generator (Knuth's MMIX): the same noise on every run.
    let mut state = 1_u64;
    let mut noise = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        NOISE * ((state >> 40) as f64 / f64::from(1 << 23) - 1.0)
    };
    let samples = config.radar.samples;
    let sample = |n: u16| {
        let (mut i, mut q) = (noise(), noise());
        for (range_m, amplitude) in ECHOES {
            let beats = (range_m + offset_m) / resolution_m;
            let phase = TAU * beats * f64::from(n) / f64::from(samples);
            i += amplitude * phase.cos();
            q += amplitude * phase.sin();
        }
        Iq::new(i.round() as i16, q.round() as i16)
    };
    (0..samples).map(sample).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    // The paper's radar, mount and detector.
    let config = Config::default();
    let mut range = RangeProcessor::new(&config.radar, &config.mount, &config.cfar)?;
    let mut profile = Profile::default();
    range.profile(&chirp(&config), &mut profile)?;

    let from_mirror_m =
        |bin: f32| bin * config.radar.bin_spacing_m() - config.mount.mirror_offset_m();
    println!("# range from the mirror [m], power [dBFS], threshold [dBFS]");
    for bin in 0..profile.bins() {
        let range_m = from_mirror_m(bin as f32);
        let power_db = profile.power_db(bin);
        // Nothing is tested at the mirror's own echo and where negative frequencies wrap round.
        if let Some(threshold_db) = profile.threshold_db(bin) {
            println!("{range_m:.4} {power_db:.1} {threshold_db:.1}");
        }
    }
    for found in profile.detections() {
        let range_m = from_mirror_m(found.bin);
        println!("# detection at {range_m:.3} m, {:.1} dBFS", found.power_db);
    }
    Ok(())
}
