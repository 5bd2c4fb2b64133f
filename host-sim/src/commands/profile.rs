//! `profile REC`: computes one chirp's range profile, or statistics over all chirps, for any FMCW radar's
//! recording.

mod cells;
mod statistics;

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, anyhow};
use cells::Cells;
use num_complex::Complex64;
use serde_json::{Value, json};
use stairscan::config::{CfarConfig, MAX_SAMPLES, MountConfig, to_fixed};
use stairscan::signal::range::packed::Packed;
use stairscan::signal::range::window::Window;
use stairscan::signal::range::{Profile, RangeProcessor};
use stairscan_replay::convert::mirrored;
use statistics::Spectra;

use super::{Format, emit};
use crate::output::Overwrite;
use crate::plots;
use crate::recording::Recording;
use crate::setup;

/// Value that stands for the CFAR threshold in bins that are not tested (leakage, the mirror's echo, aliased ranges),
/// dB relative to full scale: above the converter's maximum.
const OUT_OF_REACH_DB: f32 = 10.0;

/// Arguments of `profile`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Recording, with or without suffix
    recording: PathBuf,
    /// Chirp, counted from 0; without it the one with the strongest echo
    #[arg(long)]
    chirp: Option<usize>,
    /// Draw the profile into this PNG file
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Statistics over all chirps of a radar that stands still: leakage, echoes, noise, phase
    /// (docs/design/real-signals.md)
    #[arg(long, conflicts_with_all = ["chirp", "plot"])]
    statistics: bool,
    /// Successive chirps in a frame, during which the scene is taken to be still; without it all are one frame
    #[arg(long, value_name = "N", requires = "statistics", value_parser = clap::value_parser!(u32).range(2..))]
    frame: Option<u32>,
    #[command(flatten)]
    cells: Cells,
    #[command(flatten)]
    overwrite: Overwrite,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Range profile of one chirp in physical units: ranges from the radar, powers relative to full scale.
#[derive(Clone, Debug)]
pub struct RangeProfile {
    /// Range of every bin, metres.
    pub range_m: Vec<f32>,
    /// Power of every bin, dB relative to full scale.
    pub power_db: Vec<f32>,
    /// CFAR threshold of every bin, dB relative to full scale; 10 dB where a bin is not tested.
    pub threshold_db: Vec<f32>,
    /// Range, metres, and power, dB relative to full scale, of every detection, interpolated between bins.
    pub detections: Vec<(f32, f32)>,
    /// Range, metres, and power, dB relative to full scale, of every echo that is no detection because other echoes lie in
    /// its training cells.
    pub masked: Vec<(f32, f32)>,
    /// Range, metres, and power, dB relative to full scale, of every echo above its threshold that is no detection
    /// because it may be an I/Q image.
    pub images: Vec<(f32, f32)>,
    /// Result of CA-CFAR in each bin.
    pub marks: Vec<Mark>,
}

/// Result of CA-CFAR in a bin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Below the threshold, or not tested.
    Below,
    /// A detection.
    Detection,
    /// Above the threshold, removed as a possible I/Q image.
    Image,
}

impl Mark {
    fn of(profile: &Profile, bin: usize) -> Self {
        match (profile.is_hit(bin), profile.is_image(bin)) {
            (true, _) => Mark::Detection,
            (false, true) => Mark::Image,
            (false, false) => Mark::Below,
        }
    }

    /// Returns the text behind the bin's threshold in the table.
    fn text(self) -> &'static str {
        match self {
            Mark::Below => "",
            Mark::Detection => "  *",
            Mark::Image => "  I/Q image",
        }
    }
}

/// Returns the settings of CA-CFAR for a recording of any radar, with or without a mirror.
fn cfar(recording: &Recording, cells: &Cells) -> CfarConfig {
    let mut cfar = cells.config(CfarConfig::default());
    if recording.meta.mirror.is_none() {
        cfar.near_margin = 0;
    }
    cfar
}

/// Returns the range processor for a recording of any radar, with or without a mirror.
fn processor(recording: &Recording, cells: &Cells) -> Result<RangeProcessor> {
    let radar = setup::radar(recording)?;
    let offset = recording.meta.mirror.as_ref().map_or(0.0, |m| m.offset_m);
    let mount = MountConfig {
        mirror_offset: to_fixed(offset, 1e-5)
            .ok_or_else(|| anyhow!("{}: mirror offset out of range", recording.name))?,
        ..MountConfig::default()
    };
    RangeProcessor::new(&radar, &mount, &cfar(recording, cells))
        .map_err(|e| anyhow!("{}: {e}", recording.name))
}

/// Returns the range profile of chirp `k` of a recording, counted from 0.
pub fn profile(recording: &Recording, cells: &Cells, k: usize) -> Result<RangeProfile> {
    let radar = setup::radar(recording)?;
    let mut processor = processor(recording, cells)?;
    let chirp = recording.chirp(k).ok_or_else(|| {
        anyhow!(
            "{}: chirp {k}: the recording holds chirps 0 to {}",
            recording.name,
            recording.chirps() - 1
        )
    })?;
    let mut profile = Profile::default();
    processor.profile(chirp, &mut profile)?;
    let spacing = radar.bin_spacing_m();
    let bins = 0..profile.bins();
    let echoes = |bins: Vec<usize>| -> Vec<(f32, f32)> {
        let echo = |bin| (bin as f32 * spacing, profile.power_db(bin));
        bins.into_iter().map(echo).collect()
    };
    Ok(RangeProfile {
        marks: bins.clone().map(|b| Mark::of(&profile, b)).collect(),
        range_m: bins.clone().map(|b| b as f32 * spacing).collect(),
        power_db: bins.clone().map(|b| profile.power_db(b)).collect(),
        threshold_db: bins
            .map(|b| profile.threshold_db(b).unwrap_or(OUT_OF_REACH_DB))
            .collect(),
        detections: profile
            .detections()
            .map(|d| (d.bin * spacing, d.power_db))
            .collect(),
        masked: echoes(cells::masked(&profile, &cfar(recording, cells))),
        images: echoes(cells::images(&profile)),
    })
}

/// Returns the index of the chirp with the strongest echo in the tested bins, which exclude leakage and mirror echo. Of
/// equal ones it is the first.
pub fn strongest(recording: &Recording) -> Result<usize> {
    let mut processor = processor(recording, &Cells::default())?;
    let mut profile = Profile::default();
    let mut best = (0, f32::NEG_INFINITY);
    for k in 0..recording.chirps() {
        let Some(chirp) = recording.chirp(k) else {
            continue;
        };
        processor.profile(chirp, &mut profile)?;
        let tested = (0..profile.bins()).filter(|&bin| profile.threshold_db(bin).is_some());
        let power = tested
            .map(|bin| profile.power_db(bin))
            .fold(f32::NEG_INFINITY, f32::max);
        if power > best.1 {
            best = (k, power);
        }
    }
    Ok(best.0)
}

/// Returns the complex spectra of all chirps by the scanner's own transform, in frames of `frame` chirps; all are one
/// frame if `None`.
fn spectra(recording: &Recording, frame: Option<u32>) -> Result<Spectra> {
    let radar = setup::radar(recording)?;
    let mut processor = processor(recording, &Cells::default())?;
    let (mut packed, mut chirps) = ([Packed::ZERO; MAX_SAMPLES], Vec::new());
    for k in 0..recording.chirps() {
        let chirp = recording.chirp(k).unwrap_or_default();
        let unit = f64::from(processor.spectrum(chirp, &mut packed)?);
        let bins = packed.iter().take(radar.fft_len());
        let bins = bins.map(|bin| Complex64::new(bin.re().into(), bin.im().into()) * unit);
        chirps.push(bins.collect());
    }
    let mut window = Window::empty();
    match radar.real {
        false => window.shape(radar.samples.into(), radar.fft_len()),
        true => window.shape_real(radar.samples.into(), radar.fft_len()),
    }
    let kept = processor.kept();
    let first = usize::from(kept.first);
    Ok(Spectra {
        frame: frame.map_or(recording.chirps(), |n| n as usize),
        spacing_m: radar.bin_spacing_m().into(),
        tested: (first, first + usize::from(kept.count)),
        window: [1, 2].map(|apart| window.correlation(apart).abs().into()),
        chirps,
    })
}

impl RangeProfile {
    /// Returns the range profile as one JSON object; `chirp` is its index.
    pub fn json(&self, chirp: usize) -> Value {
        // The shortest decimals of the f32 values, not those of their f64 conversions.
        let list = |values: &[f32]| {
            values
                .iter()
                .map(|&v| json!(decimal(v)))
                .collect::<Vec<_>>()
        };
        let detection = |&(range, power): &(f32, f32)| json!({"range_m": decimal(range), "power_db": decimal(power)});
        json!({
            "chirp": chirp,
            "range_m": list(&self.range_m),
            "power_db": list(&self.power_db),
            "threshold_db": list(&self.threshold_db),
            "detections": self.detections.iter().map(detection).collect::<Vec<_>>(),
            "masked": self.masked.iter().map(detection).collect::<Vec<_>>(),
            "images": self.images.iter().map(detection).collect::<Vec<_>>(),
        })
    }

    /// Returns the detections and a table of all bins as text.
    fn text(&self, recording: &Recording, chirp: usize) -> String {
        let angle = match recording.meta.angles_deg.get(chirp) {
            Some(angle) => format!(" at {angle:.2}°"),
            None => String::new(),
        };
        let count = self.detections.len();
        let mut out = format!(
            "{}, chirp {chirp}{angle}: {count} detections\n",
            recording.name
        );
        for (range, power) in &self.detections {
            let _ = writeln!(out, "  {range:7.3} m  {power:6.1} dBFS");
        }
        for (range, power) in &self.masked {
            let _ = writeln!(
                out,
                "  {range:7.3} m  {power:6.1} dBFS: masked, below the threshold by echoes in its training cells \
                 (--cfar-training, --cfar-guard)"
            );
        }
        for (range, power) in &self.images {
            let _ = writeln!(
                out,
                "  {range:7.3} m  {power:6.1} dBFS: removed, 30 dB or more below the echo at its negative frequency, whose \
                 I/Q image it may be"
            );
        }
        out.push_str("\n  range from the radar m   power dBFS   threshold (* detection)\n");
        let bins = (self.range_m.iter())
            .zip(&self.power_db)
            .zip(&self.threshold_db)
            .zip(&self.marks);
        for (((range, power), threshold), mark) in bins {
            let threshold = match *threshold {
                OUT_OF_REACH_DB => "     -".to_owned(),
                t => format!("{t:6.1}"),
            };
            let mark = mark.text();
            let _ = writeln!(out, "  {range:22.3}     {power:8.1}      {threshold}{mark}");
        }
        out
    }
}

/// Rounds a range (metres) or power (dB) to millionths, as an f32 has no more significant digits.
fn decimal(value: f32) -> f64 {
    (f64::from(value) * 1e6).round() / 1e6
}

/// Prints the range profile of one chirp, or the statistics over all chirps.
pub fn run(args: &Args) -> Result<ExitCode> {
    let outputs = args.overwrite.reading([&args.recording]);
    args.plot.iter().try_for_each(|file| outputs.check(file))?;
    let recording = Recording::read(&args.recording)?;
    if let Some(words) = mirrored::warning(&recording)? {
        crate::note!("note: {}: {words}", recording.name);
    }
    if args.statistics {
        let found = spectra(&recording, args.frame)?.statistics();
        let found = found.with_context(|| recording.name.clone())?;
        emit(&match args.format {
            Format::Json => format!("{}\n", found.json()),
            Format::Text => found.text(&recording.name),
        });
        return Ok(ExitCode::SUCCESS);
    }
    let chirp = match args.chirp {
        Some(chirp) => chirp,
        None => strongest(&recording)?,
    };
    let profile = profile(&recording, &args.cells, chirp)?;
    emit(&match args.format {
        Format::Json => format!("{}\n", profile.json(chirp)),
        Format::Text => {
            let text = profile.text(&recording, chirp);
            let chosen = match args.chirp {
                Some(_) => String::new(),
                None => format!(
                    "the strongest of {} chirps; --chirp K shows another\n",
                    recording.chirps()
                ),
            };
            format!("{chosen}{text}")
        }
    });
    if let Some(file) = &args.plot {
        let view =
            plots::profile_view(&recording, chirp, &mut processor(&recording, &args.cells)?)?;
        plots::write_profile((&outputs, file), &view)?;
        if args.format == Format::Text {
            emit(&format!("\npicture\n  {}\n", file.display()));
        }
    }
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::Parser as _;
    use stairscan::Iq;

    use super::*;

    impl Cells {
        /// Returns the options of a command line.
        fn parse(options: &[&str]) -> Self {
            let line = ["profile", "two"].iter().chain(options);
            OfProfile::parse_from(line).args.cells
        }
    }

    #[derive(clap::Parser)]
    struct OfProfile {
        #[command(flatten)]
        args: Args,
    }

    #[test]
    fn the_strongest_chirp_is_that_of_the_strongest_echo() {
        let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
        let mut recording = Recording::read(&dir.join("stair_a")).unwrap();
        let ns = recording.meta.samples_per_chirp;
        // Leakage and the mirror's echo, the strongest of each chirp, are unchanged; all other echoes are
        // attenuated by 48 dB.
        let chosen = 150;
        assert_ne!(strongest(&recording).unwrap(), chosen);
        for (k, sample) in recording.samples.iter_mut().enumerate() {
            if k / ns != chosen {
                (sample.i, sample.q) = (sample.i >> 8, sample.q >> 8);
            }
        }
        assert_eq!(strongest(&recording).unwrap(), chosen);
        let shown = profile(&recording, &Cells::default(), chosen).unwrap();
        assert_eq!(shown.json(chosen)["chirp"], chosen);
    }

    /// A reflector whose quadrature is 3 % weak: its image lies at the negative frequency, far above the noise.
    #[test]
    fn an_image_is_called_one_and_is_not_marked_as_a_detection() {
        let noise = |n: usize| ((n * 7919 + 13) % 31) as f64 / 5.0 - 3.0;
        let samples = (0..64).map(|n| {
            let (sin, cos) = (std::f64::consts::TAU * 40.0 * n as f64 / 64.0).sin_cos();
            Iq::new(
                (12_000.0 * cos + noise(n)) as i16,
                (0.97 * 12_000.0 * sin + noise(3 * n + 1)) as i16,
            )
        });
        let document = json!({"global": {
            "core:datatype": "ci16_le", "stairscan:bandwidth_hz": 5.5e9, "stairscan:samples_per_chirp": 64,
        }});
        let recording = Recording::of("one", &document, samples.collect()).unwrap();
        let shown = profile(&recording, &Cells::default(), 0).unwrap();
        let spacing = 2.998e8 / (2.0 * 5.5e9);
        let bins = shown.images.iter();
        let bins: Vec<i64> = bins.map(|(m, _)| (m / spacing).round() as i64).collect();
        assert_eq!(bins, [24], "{shown:?}");
        assert!(shown.power_db[24] > shown.threshold_db[24]);
        assert_eq!(
            (shown.marks[24], shown.marks[40]),
            (Mark::Image, Mark::Detection)
        );
        assert!(shown.masked.is_empty(), "{:?}", shown.masked);
        let text = shown.text(&recording, 0);
        let row = text.lines().find(|line| line.contains("  I/Q image"));
        assert!(row.is_some_and(|row| !row.contains('*')), "{text}");
        assert!(
            text.contains("below the echo at its negative frequency"),
            "{text}"
        );
        assert_eq!(shown.json(0)["images"].as_array().unwrap().len(), 1);
    }

    /// Two reflectors 5 bins apart over weak noise: each lies in the other's training cells.
    #[test]
    fn reflectors_that_mask_each_other_are_named() {
        let tone = |n: usize, bin: f64, level: f64| {
            let (sin, cos) = (std::f64::consts::TAU * bin * n as f64 / 64.0).sin_cos();
            (level * cos, level * sin)
        };
        let noise = |n: usize| ((n * 7919 + 13) % 31) as f64 - 15.0;
        let samples = (0..64).map(|n| {
            let [a, b] = [12.0, 17.0].map(|bin| tone(n, bin, 4000.0));
            Iq::new(
                (a.0 + b.0 + noise(n)) as i16,
                (a.1 + b.1 + noise(3 * n + 1)) as i16,
            )
        });
        let document = json!({"global": {
            "core:datatype": "ci16_le", "stairscan:bandwidth_hz": 5.5e9, "stairscan:samples_per_chirp": 64,
        }});
        let recording = Recording::of("two", &document, samples.collect()).unwrap();
        let hidden = profile(&recording, &Cells::default(), 0).unwrap();
        let at = |found: &[(f32, f32)]| -> Vec<i64> {
            let spacing = 2.998e8 / (2.0 * 5.5e9);
            found
                .iter()
                .map(|(range, _)| (range / spacing).round() as i64)
                .collect()
        };
        assert_eq!(
            (at(&hidden.detections), at(&hidden.masked)),
            (vec![], vec![12, 17])
        );
        let text = hidden.text(&recording, 0);
        assert!(
            text.contains("masked") && !text.contains("I/Q image"),
            "{text}"
        );
        assert_eq!(hidden.json(0)["masked"].as_array().unwrap().len(), 2);
        let near = Cells::parse(&["--cfar-guard", "1", "--cfar-training", "2"]);
        let shown = profile(&recording, &near, 0).unwrap();
        let strong = shown
            .detections
            .iter()
            .copied()
            .filter(|(_, power)| *power > -30.0);
        assert_eq!(at(&strong.collect::<Vec<_>>()), [12, 17]);
        assert!(shown.masked.is_empty());
        // At a false-alarm rate of one half everything above the mean is a detection.
        let often = Cells::parse(&["--cfar-false-alarm", "0.5"]);
        assert!(profile(&recording, &often, 0).unwrap().detections.len() > 2);
    }
}
