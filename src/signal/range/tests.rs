//! Range processing against an f64 reference: error bounds, detections, and robustness against any chirp.

mod real;

use super::*;
use crate::config::Config;
use proptest::prelude::*;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::f64::consts::TAU;

const SIZES: [u16; 15] = [
    16, 17, 24, 31, 32, 33, 63, 64, 65, 100, 128, 129, 200, 255, 256,
];

fn radar(samples: u16) -> RadarConfig {
    RadarConfig {
        samples,
        ..RadarConfig::default()
    }
}

/// A processor without mirror and near margin, so that the smallest sizes have bins left.
fn bare(samples: u16) -> RangeProcessor {
    let mount = MountConfig {
        mirror_offset: 0,
        ..MountConfig::default()
    };
    let cfar = CfarConfig {
        near_margin: 0,
        ..CfarConfig::default()
    };
    RangeProcessor::new(&radar(samples), &mount, &cfar).unwrap()
}

fn usual() -> RangeProcessor {
    let c = Config::default();
    RangeProcessor::new(&c.radar, &c.mount, &c.cfar).unwrap()
}

/// Source of normally distributed numbers (Box and Muller).
struct Gauss(Xoshiro128PlusPlus);

impl Gauss {
    fn new(seed: u64) -> Self {
        Self(Xoshiro128PlusPlus::seed_from_u64(seed))
    }

    fn uniform(&mut self) -> f64 {
        (f64::from(self.0.next_u32()) + 0.5) / 4_294_967_296.0
    }

    fn next(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}

fn quantise(re: f64, im: f64) -> Iq {
    // The cast saturates: the converter clips.
    Iq::new(re.round() as i16, im.round() as i16)
}

/// Returns three tones of random bins and phases with noise 50 dB below, peaking at `level` dBFS.
fn tones(samples: usize, level: f64, random: &mut Gauss) -> Vec<Iq> {
    let peak = 32_767.0 * 10f64.powf(level / 20.0);
    let parts = [0.5, 0.3, 0.2].map(|a| {
        let (turns, phase) = (random.uniform() * samples as f64, random.uniform() * TAU);
        (a * peak, TAU * turns / samples as f64, phase)
    });
    let sigma = peak * 10f64.powf(-50.0 / 20.0);
    let at = |n: usize, random: &mut Gauss| {
        let mut sum = (sigma * random.next(), sigma * random.next());
        for (a, step, phase) in parts {
            let angle = step * n as f64 + phase;
            sum = (sum.0 + a * angle.cos(), sum.1 + a * angle.sin());
        }
        quantise(sum.0, sum.1)
    };
    (0..samples).map(|n| at(n, random)).collect()
}

/// Reference in double precision: mean removed, Hann window, zero-padded transform. Returns the complex
/// spectrum relative to a full-scale tone.
fn reference(chirp: &[Iq]) -> Vec<(f64, f64)> {
    let ns = chirp.len() as f64;
    let mean = |part: fn(&Iq) -> i16| chirp.iter().map(|x| f64::from(part(x))).sum::<f64>() / ns;
    let (mi, mq) = (mean(|x| x.i), mean(|x| x.q));
    let points = chirp.len().next_power_of_two();
    (0..points)
        .map(|k| {
            let mut sum = (0.0, 0.0);
            for (n, x) in chirp.iter().enumerate() {
                let w = (0.5 - 0.5 * (TAU * n as f64 / ns).cos()) / (32_768.0 * ns / 2.0);
                let (re, im) = (w * (f64::from(x.i) - mi), w * (f64::from(x.q) - mq));
                let (sin, cos) = (-TAU * ((k * n) % points) as f64 / points as f64).sin_cos();
                sum = (sum.0 + re * cos - im * sin, sum.1 + re * sin + im * cos);
            }
            sum
        })
        .collect()
}

/// Returns the spectrum of the fixed-point `processor`, complex, relative to a full-scale tone.
fn measured(processor: &mut RangeProcessor, chirp: &[Iq]) -> Vec<(f64, f64)> {
    let mut bins = [Packed::ZERO; 256];
    let unit = f64::from(processor.spectrum(chirp, &mut bins).unwrap());
    let part = |x: i16| f64::from(x) * unit;
    bins.map(|x| (part(x.re()), part(x.im())))[..processor.front_end.points].to_vec()
}

fn total(spectrum: &[(f64, f64)]) -> f64 {
    spectrum.iter().map(|(re, im)| re * re + im * im).sum()
}

/// Returns the ratio of the exact spectrum's power to that of the fixed-point spectrum's error, dB.
fn signal_to_error(processor: &mut RangeProcessor, chirp: &[Iq]) -> f64 {
    let (exact, fixed) = (reference(chirp), measured(processor, chirp));
    let pairs = exact.iter().zip(&fixed);
    let error: Vec<_> = pairs.map(|(e, f)| (e.0 - f.0, e.1 - f.1)).collect();
    10.0 * (total(&exact) / total(&error)).log10()
}

#[test]
fn every_size_agrees_with_the_reference() {
    let mut random = Gauss::new(1);
    for samples in SIZES {
        let mut processor = bare(samples);
        for level in [-1.0, -20.0, -50.0] {
            let chirp = tones(samples.into(), level, &mut random);
            let ratio = signal_to_error(&mut processor, &chirp);
            assert!(
                ratio > 60.0,
                "{samples} samples at {level} dBFS: {ratio} dB"
            );
        }
    }
}

#[test]
fn phasors_are_the_bins_of_the_spectrum_at_every_size() {
    let mut random = Gauss::new(3);
    for samples in [16, 24, 33, 64, 100, 128, 200, 256] {
        let mut processor = bare(samples);
        let chirp = tones(samples.into(), 9000.0, &mut random);
        let mut bins = [Packed::ZERO; MAX_SAMPLES];
        processor.spectrum(&chirp, &mut bins).unwrap();
        let (mut cells, mut mask) = ([0; 256], [0; 8]);
        let count = usize::from(processor.kept().count);
        let mut row = Row {
            cells: &mut cells[..count],
            mask: &mut mask[..count.div_ceil(32)],
        };
        processor.process(&chirp, &mut row).unwrap();
        for bin in 0..count {
            let x = bins[usize::from(processor.kept().first) + bin];
            let [echo, _] = processor.phasors(bin as u8);
            let (a, b) = (f32::from(x.re()), f32::from(x.im()));
            let size = math::sqrt(a * a + b * b);
            let other = math::sqrt(echo[0] * echo[0] + echo[1] * echo[1]);
            // Rounding of a few units may turn the phase of a smaller one.
            if size > 300.0 {
                let cos = (a * echo[0] + b * echo[1]) / (size * other);
                assert!(cos > 0.999, "{samples} samples, bin {bin}: {cos}");
            }
        }
    }
}

#[test]
fn weak_chirps_keep_their_bits() {
    let mut random = Gauss::new(2);
    let mut processor = usual();
    for level in (1..=60).map(|l| -f64::from(l)) {
        let ratio = (0..8)
            .map(|_| signal_to_error(&mut processor, &tones(200, level, &mut random)))
            .fold(f64::MAX, f64::min);
        println!("{level} dBFS: {ratio:.1} dB");
        assert!(ratio >= 60.0, "{level} dBFS: {ratio} dB");
    }
}

#[test]
fn a_large_offset_costs_a_weak_chirp_nothing() {
    let mut random = Gauss::new(3);
    let mut processor = usual();
    for (di, dq) in [(20_000, -30_000), (-32_700, 32_700)] {
        let mut chirp = tones(200, -60.0, &mut random);
        for x in &mut chirp {
            *x = Iq::new(x.i + di, x.q + dq);
        }
        assert!(signal_to_error(&mut processor, &chirp) >= 60.0);
    }
}

#[test]
fn full_scale_stands_at_its_reference() {
    for samples in [64u16, 200, 256] {
        let mut processor = bare(samples);
        let bin = usize::from(samples) / 2;
        let step = TAU * bin as f64 / f64::from(samples);
        let chirp: Vec<_> = (0..samples)
            .map(|n| f64::from(n) * step)
            .map(|a| quantise(32_767.0 * a.cos(), 32_767.0 * a.sin()))
            .collect();
        let mut profile = Profile::default();
        processor.profile(&chirp, &mut profile).unwrap();
        let k = processor.front_end.points / 2;
        let full = i16::from(FULL_SCALE) * 32;
        assert!((profile.power()[k] - full).abs() <= 2, "{samples}");
        assert!(profile.power_db(k).abs() < 0.03);
    }
}

/// Processes a chirp into one row of the default map: cells, detection mask, statistics.
fn row_of(processor: &mut RangeProcessor, chirp: &[Iq]) -> (Vec<u8>, Vec<u32>, RowStats) {
    let count = usize::from(processor.kept().count);
    let (mut cells, mut mask) = (vec![0; count], vec![0; count.div_ceil(32)]);
    let mut row = Row {
        cells: &mut cells,
        mask: &mut mask,
    };
    let stats = processor.process(chirp, &mut row).unwrap();
    (cells, mask, stats)
}

/// Returns a chirp of leakage, offset, mirror echo, targets (bin of 256, amplitude) and noise, in units of
/// samples.
fn scene(targets: &[(f64, f64)], noise: f64, random: &mut Gauss) -> Vec<Iq> {
    let spacing = radar(200).bin_spacing_m();
    let mirror = f64::from(0.22 / spacing);
    let always = [(1.5, 6_000.0), (2.4, 4_000.0), (mirror, 1_500.0)];
    let echoes: Vec<_> = always
        .iter()
        .chain(targets)
        .map(|&(bin, a)| (TAU * bin / 256.0, a, random.uniform() * TAU))
        .collect();
    (0..200)
        .map(|n| {
            let mut sum = (3_000.0 + noise * random.next(), noise * random.next());
            for &(step, a, phase) in &echoes {
                let angle = step * f64::from(n) + phase;
                sum = (sum.0 + a * angle.cos(), sum.1 + a * angle.sin());
            }
            quantise(sum.0, sum.1)
        })
        .collect()
}

#[test]
fn only_targets_are_detected() {
    let mut random = Gauss::new(4);
    let mut processor = usual();
    let mut profile = Profile::default();
    let mut false_alarms = 0;
    for _ in 0..200 {
        let at = 45.0 + 180.0 * random.uniform();
        let chirp = scene(&[(at, 300.0)], 20.0, &mut random);
        processor.profile(&chirp, &mut profile).unwrap();
        let mut detections: Vec<_> = profile.detections().collect();
        let near = |d: &Detection| (f64::from(d.bin) - at).abs() < 0.1;
        let target = detections.iter().position(near).expect("the target");
        let level = 20.0 * (300.0f64 / 32_768.0).log10();
        assert!((f64::from(detections[target].power_db) - level).abs() < 1.0);
        detections.remove(target);
        false_alarms += detections.len();
    }
    // 200 profiles of 217 tested cells at 1.7e-4: 7.4 false alarms expected.
    assert!(false_alarms <= 20, "{false_alarms}");
}

#[test]
fn leakage_mirror_and_wrapping_never_become_targets() {
    let mut random = Gauss::new(5);
    let mut processor = usual();
    let kept = processor.kept();
    assert_eq!((kept.first, kept.first + kept.count), (32, 249));
    let mut hits = 0;
    for _ in 0..500 {
        let (_, _, stats) = row_of(&mut processor, &scene(&[], 5.0, &mut random));
        hits += u32::from(stats.detections);
        // The echo of 1500 of 32768 is 26.8 dB below full scale: 71 map units.
        assert!((i32::from(stats.mirror_echo) - (247 - 71)).abs() <= 4);
        assert_eq!(stats.saturated, 0);
    }
    // 500 rows of 217 cells at 1.7e-4: 18 false alarms expected.
    assert!(hits < 45, "{hits}");
}

#[test]
fn an_image_is_no_target() {
    let mut random = Gauss::new(6);
    let mut processor = usual();
    // Quadrature weaker by 3 % and a wide dynamic range: images 36 dB below, far above the noise.
    let mut chirp = scene(&[(100.0, 8_000.0)], 3.0, &mut random);
    for x in &mut chirp {
        x.q = (f64::from(x.q) * 0.97).round() as i16;
    }
    let mut profile = Profile::default();
    processor.profile(&chirp, &mut profile).unwrap();
    assert!(
        profile.power()[156] > profile.threshold()[156],
        "an image above the threshold"
    );
    assert!(!profile.is_hit(156) && profile.is_image(156));
    assert!(profile.is_hit(100) && !profile.is_image(100));
}

#[test]
fn rows_and_profiles_agree() {
    let mut random = Gauss::new(7);
    let mut processor = usual();
    let mut profile = Profile::default();
    let chirp = scene(&[(60.3, 900.0), (120.8, 100.0)], 10.0, &mut random);
    processor.profile(&chirp, &mut profile).unwrap();
    let (cells, mask, stats) = row_of(&mut processor, &chirp);
    let first = usize::from(processor.kept().first);
    for (k, &cell) in cells.iter().enumerate() {
        let fine = f32::from(profile.power()[first + k].max(0)) / 32.0;
        assert!((f32::from(cell) - fine).abs() < 0.7, "cell {k}");
        assert_eq!(mask[k / 32] >> (k % 32) & 1 != 0, profile.is_hit(first + k));
    }
    let ones: u32 = mask.iter().map(|w| w.count_ones()).sum();
    assert_eq!(ones, u32::from(stats.detections));
    assert!(ones >= 4);
}

#[test]
fn faults_of_the_converter_show() {
    let mut processor = usual();
    let (cells, _, stats) = row_of(&mut processor, &[Iq::new(77, -5); 200]);
    assert!(cells.iter().all(|&c| c == 0));
    assert_eq!((stats.detections, stats.mirror_echo), (0, 0));
    assert!(stats.swing <= 1);
    let mut chirp = [Iq::default(); 200];
    chirp[3] = Iq::new(i16::MIN, 0);
    chirp[4] = Iq::new(0, i16::MAX);
    chirp[5] = Iq::new(i16::MAX, i16::MAX);
    assert_eq!(row_of(&mut processor, &chirp).2.saturated, 3);
}

#[test]
fn false_alarm_rate_is_the_configured_one() {
    let mut random = Gauss::new(8);
    for (samples, false_alarm) in [(200u16, 1.7e-4f32), (200, 4e-3), (64, 2e-3), (129, 3e-3)] {
        let mount = MountConfig {
            mirror_offset: 0,
            ..MountConfig::default()
        };
        let cfar = CfarConfig {
            false_alarm,
            near_margin: 0,
            ..CfarConfig::default()
        };
        let mut processor = RangeProcessor::new(&radar(samples), &mount, &cfar).unwrap();
        let (mut hits, mut edge_hits, mut cells, mut edge_cells) = (0, 0, 0, 0);
        while cells < 1_000_000 {
            let chirp: Vec<_> = (0..samples)
                .map(|_| quantise(60.0 * random.next(), 60.0 * random.next()))
                .collect();
            let (row, mask, _) = row_of(&mut processor, &chirp);
            cells += row.len();
            hits += mask.iter().map(|w| w.count_ones() as usize).sum::<usize>();
            // The first and last cells have training cells on one side only.
            let ends = [0, 1, 2, row.len() - 3, row.len() - 2, row.len() - 1];
            edge_cells += ends.len();
            edge_hits += ends
                .iter()
                .filter(|&&k| mask[k / 32] >> (k % 32) & 1 != 0)
                .count();
        }
        let rate = hits as f64 / cells as f64 / f64::from(false_alarm);
        let edge_rate = edge_hits as f64 / edge_cells as f64 / f64::from(false_alarm);
        println!("{samples} samples: {rate:.2} of the configured rate, {edge_rate:.2} at the ends");
        assert!((0.5..=2.0).contains(&rate), "{samples} samples: {rate}");
        // The ends have few cells: their rate is tested only with enough expected detections.
        if edge_cells as f32 * false_alarm > 30.0 {
            assert!(
                (0.5..=2.0).contains(&edge_rate),
                "{samples} samples, ends: {edge_rate}"
            );
        }
    }
}

#[test]
fn bad_configurations_name_their_field() {
    let good = Config::default();
    let field = |change: fn(&mut Config)| {
        let mut c = good;
        change(&mut c);
        RangeProcessor::new(&c.radar, &c.mount, &c.cfar)
            .unwrap_err()
            .field
    };
    assert_eq!(field(|c| c.radar.samples = 0), "samples");
    assert_eq!(field(|c| c.radar.samples = 257), "samples");
    assert_eq!(field(|c| c.radar.bandwidth_khz = 0), "bandwidth");
    assert_eq!(field(|c| c.radar.bandwidth_khz = u32::MAX), "bandwidth");
    assert_eq!(field(|c| c.cfar.training = 0), "cfar-training");
    assert_eq!(field(|c| c.cfar.guard = 99), "cfar-guard");
    assert_eq!(field(|c| c.cfar.false_alarm = 0.0), "cfar-false-alarm");
    assert_eq!(field(|c| c.cfar.false_alarm = f32::NAN), "cfar-false-alarm");
    assert_eq!(field(|c| c.cfar.near_margin = -1), "cfar-near-margin");
    assert_eq!(field(|c| c.mount.mirror_offset = -1), "mirror-offset");
}

#[test]
fn a_chirp_of_the_wrong_length_is_refused() {
    let mut processor = usual();
    let mut row = Row {
        cells: &mut [7; 4],
        mask: &mut [9],
    };
    for got in [0, 199, 201, 1000] {
        let error = processor.process(&vec![Iq::default(); got], &mut row);
        assert_eq!(error, Err(ChirpLength { got, expected: 200 }));
    }
    assert_eq!(
        (&*row.cells, &*row.mask),
        ([7; 4].as_slice(), [9].as_slice())
    );
    let mut idle = RangeProcessor::idle();
    assert!(idle.process(&[], &mut row).is_err());
}

/// Strategy for random samples at the limits of the arithmetic: full scale, zero, alternation, noise.
fn any_sample() -> impl Strategy<Value = Iq> {
    let rail = prop_oneof![
        Just(i16::MIN),
        Just(-32_767),
        Just(-1),
        Just(0),
        Just(1),
        Just(i16::MAX),
        any::<i16>(),
    ];
    (rail.clone(), rail).prop_map(|(i, q)| Iq::new(i, q))
}

proptest! {
    #[test]
    fn any_chirp_gives_a_row(
        size in 0usize..SIZES.len(),
        samples in prop::collection::vec(any_sample(), 256),
        period in 1usize..=256,
    ) {
        let ns = usize::from(SIZES[size]);
        let chirp: Vec<_> = (0..ns).map(|n| samples[n % period]).collect();
        let mut processor = bare(SIZES[size]);
        let (cells, _, stats) = row_of(&mut processor, &chirp);
        prop_assert!(usize::from(stats.detections) <= cells.len());
        // The powers are below the bound of the overflow argument, and the total agrees with the reference
        // within the precision of 16 bits normalised before the window.
        prop_assert!(processor.power.iter().all(|&p| p < 1 << 30));
        let exact = total(&reference(&chirp));
        let total = total(&measured(&mut processor, &chirp));
        let swing = f64::from(stats.swing) / 32_768.0;
        let tolerance = 1e-3 * exact + 5e-3 * swing * (exact.sqrt() + 5e-3 * swing);
        prop_assert!((exact - total).abs() <= tolerance, "{exact} {total} {swing}");
    }

    #[test]
    fn any_mount_and_radar_gives_bins_or_an_error(
        samples in 0u16..300,
        bandwidth_khz in prop_oneof![0u32..100, 100_000u32..20_000_000, any::<u32>()],
        mirror_offset in 0i32..200_000,
        near_margin in 0i32..200_000,
        guard in 0u8..20,
        training in 0u8..40,
    ) {
        let radar = RadarConfig { samples, bandwidth_khz, ..RadarConfig::default() };
        let mount = MountConfig { mirror_offset, ..MountConfig::default() };
        let cfar = CfarConfig { guard, training, near_margin, ..CfarConfig::default() };
        if let Ok(mut processor) = RangeProcessor::new(&radar, &mount, &cfar) {
            let kept = processor.kept();
            prop_assert!(usize::from(kept.first + kept.count) <= radar.fft_len());
            let chirp = vec![Iq::new(5, -9); samples.into()];
            row_of(&mut processor, &chirp);
        }
    }
}

/// Rounding functions of the range axis: equal to those of the standard library over more than the range of
/// bins and levels.
#[test]
fn whole_numbers_are_those_of_the_standard_library() {
    for k in -400_000..=400_000 {
        let x = k as f32 * 1e-3;
        let y = micromath::F32(x);
        assert_eq!(y.ceil().0, x.ceil(), "{x}");
        assert_eq!(y.floor().0, x.floor(), "{x}");
        assert_eq!(y.round().0, x.round(), "{x}");
    }
}
