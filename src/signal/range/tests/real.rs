//! Real samples against a reference in double precision: levels, ranges, and robustness against any chirp.

use super::*;

fn real_radar(samples: u16) -> RadarConfig {
    RadarConfig {
        real: true,
        ..radar(samples)
    }
}

fn processor(radar: &RadarConfig, mirror_offset: i32, near_margin: i32) -> RangeProcessor {
    let mount = MountConfig {
        mirror_offset,
        ..MountConfig::default()
    };
    let cfar = CfarConfig {
        near_margin,
        ..CfarConfig::default()
    };
    RangeProcessor::new(radar, &mount, &cfar).unwrap()
}

fn bare_real(samples: u16) -> RangeProcessor {
    processor(&real_radar(samples), 0, 0)
}

fn pairs(values: &[i16]) -> Vec<Iq> {
    let (pairs, _) = values.as_chunks::<2>();
    pairs.iter().map(|&[a, b]| Iq::new(a, b)).collect()
}

fn values(chirp: &[Iq]) -> Vec<f64> {
    let both = chirp.iter().flat_map(|x| [x.i, x.q]);
    both.map(f64::from).collect()
}

/// Returns the spectrum in double precision: one mean, one Hann window over all values, zero-padded transform;
/// relative to a full-scale tone, half of which is at its negative frequency.
fn real_reference(chirp: &[Iq]) -> Vec<(f64, f64)> {
    let x = values(chirp);
    let count = x.len() as f64;
    let mean = x.iter().sum::<f64>() / count;
    let points = 2 * chirp.len().next_power_of_two();
    (0..points / 2)
        .map(|k| {
            let mut sum = (0.0, 0.0);
            for (n, x) in x.iter().enumerate() {
                let w = (0.5 - 0.5 * (TAU * n as f64 / count).cos()) / (32_768.0 * count / 4.0);
                let (sin, cos) = (-TAU * ((k * n) % points) as f64 / points as f64).sin_cos();
                sum = (sum.0 + w * (x - mean) * cos, sum.1 + w * (x - mean) * sin);
            }
            sum
        })
        .collect()
}

/// Returns tones (periods in the chirp, amplitude, phase) with noise of standard deviation `sigma`.
fn real_tones(samples: u16, tones: &[(f64, f64, f64)], sigma: f64, random: &mut Gauss) -> Vec<Iq> {
    let count = 2 * usize::from(samples);
    let values: Vec<i16> = (0..count)
        .map(|n| {
            let tone = |&(turns, a, phase): &(f64, f64, f64)| {
                a * (TAU * turns * n as f64 / count as f64 + phase).cos()
            };
            let sum: f64 = tones.iter().map(tone).sum();
            // The cast saturates: the converter clips.
            (sum + sigma * random.next()).round() as i16
        })
        .collect();
    pairs(&values)
}

/// Returns three tones of random ranges and phases with noise 50 dB below, peaking at `level` dBFS.
fn mixed(samples: u16, level: f64, random: &mut Gauss) -> Vec<Iq> {
    let peak = 32_767.0 * 10f64.powf(level / 20.0);
    let parts = [0.5, 0.3, 0.2].map(|a| {
        let turns = random.uniform() * f64::from(samples);
        (turns, a * peak, random.uniform() * TAU)
    });
    real_tones(samples, &parts, peak * 10f64.powf(-50.0 / 20.0), random)
}

fn real_signal_to_error(processor: &mut RangeProcessor, chirp: &[Iq]) -> f64 {
    let (exact, fixed) = (real_reference(chirp), measured(processor, chirp));
    let pairs = exact.iter().zip(&fixed);
    let error: Vec<_> = pairs.map(|(e, f)| (e.0 - f.0, e.1 - f.1)).collect();
    10.0 * (total(&exact) / total(&error)).log10()
}

#[test]
fn every_size_of_real_chirp_agrees_with_the_reference() {
    let mut random = Gauss::new(11);
    for samples in SIZES {
        let mut processor = bare_real(samples);
        for level in [-1.0, -20.0, -50.0] {
            let worst = (0..8)
                .map(|_| real_signal_to_error(&mut processor, &mixed(samples, level, &mut random)))
                .fold(f64::MAX, f64::min);
            println!("{samples} pairs at {level} dBFS: {worst:.1} dB");
            assert!(worst >= 60.0, "{samples} pairs at {level} dBFS: {worst} dB");
        }
    }
}

#[test]
fn weak_and_shifted_real_chirps_keep_their_bits() {
    let mut random = Gauss::new(12);
    let mut processor = bare_real(200);
    for level in (1..=60).map(|l| -f64::from(l)) {
        for offset in [0, 20_000, -32_000] {
            let mut chirp = mixed(200, level, &mut random);
            for x in &mut chirp {
                *x = Iq::new(x.i.saturating_add(offset), x.q.saturating_add(offset));
            }
            let clean = offset == 0 || level < -40.0;
            let ratio = real_signal_to_error(&mut processor, &chirp);
            assert!(
                !clean || ratio >= 60.0,
                "{level} dBFS, {offset}: {ratio} dB"
            );
        }
    }
}

#[test]
fn a_real_tone_stands_in_its_place_at_its_level() {
    let mut random = Gauss::new(13);
    let mut profile = Profile::default();
    for samples in [64u16, 128, 200, 256] {
        let mut processor = bare_real(samples);
        let padding = processor.front_end.points as f64 / f64::from(samples);
        for amplitude in [32_767.0, 3_000.0] {
            for turns in [0.3, 0.5, 0.71].map(|part| part * f64::from(samples)) {
                let phase = random.uniform() * TAU;
                let tones = [(turns, amplitude, phase)];
                let chirp = real_tones(samples, &tones, 2.0, &mut random);
                processor.profile(&chirp, &mut profile).unwrap();
                let strongest = profile
                    .detections()
                    .max_by(|a, b| a.power_db.total_cmp(&b.power_db))
                    .unwrap();
                let off = f64::from(strongest.bin) - turns * padding;
                assert!(off.abs() < 0.1, "{samples} pairs, {turns}: {off} bins off");
                let level = 20.0 * (amplitude / 32_768.0).log10();
                let db = f64::from(strongest.power_db) - level;
                assert!(db.abs() < 0.3, "{samples} pairs, {turns}: {db} dB off");
            }
        }
    }
}

#[test]
fn real_and_complex_chirps_of_a_scene_give_the_same_map() {
    let mut random = Gauss::new(14);
    let c = Config::default();
    let mut complex = usual();
    let mut real = processor(&real_radar(200), c.mount.mirror_offset, c.cfar.near_margin);
    assert_eq!(complex.kept(), real.kept());
    let echoes = [(14.67, 1_500.0), (60.3, 900.0), (130.0, 300.0)];
    let tones = echoes.map(|(turns, a)| (turns, a, random.uniform() * TAU));
    let pairs = real_tones(200, &tones, 3.0, &mut random);
    let iq: Vec<_> = (0..200)
        .map(|n| {
            let mut sum = (3.0 * random.next(), 3.0 * random.next());
            for (turns, a, phase) in tones {
                let angle = TAU * turns * f64::from(n) / 200.0 + phase;
                sum = (sum.0 + a * angle.cos(), sum.1 + a * angle.sin());
            }
            quantise(sum.0, sum.1)
        })
        .collect();
    let ((a, _, s), (b, mask, t)) = (row_of(&mut complex, &iq), row_of(&mut real, &pairs));
    let first = usize::from(real.kept().first);
    for (turns, _) in &echoes[1..] {
        let k = (turns * 1.28).round() as usize - first;
        assert!(a[k].abs_diff(b[k]) <= 1, "{turns}: {} {}", a[k], b[k]);
        assert!(mask[k / 32] >> (k % 32) & 1 != 0, "{turns} is a hit");
    }
    assert!(s.mirror_echo.abs_diff(t.mirror_echo) <= 1);
    assert!((s.mirror_place - t.mirror_place).abs() <= 1);
    assert_eq!(t.image, 0);
    assert!(t.detections > 4);
}

#[test]
fn a_strong_real_echo_takes_none_at_its_mirrored_bin() {
    // With I and Q the weaker one would count as the image of the stronger one.
    let mut random = Gauss::new(15);
    let mut processor = bare_real(256);
    let tones = [(100.0, 20_000.0, 1.0), (156.0, 300.0, 2.0)];
    let chirp = real_tones(256, &tones, 4.0, &mut random);
    let mut profile = Profile::default();
    processor.profile(&chirp, &mut profile).unwrap();
    assert!(profile.is_hit(100) && profile.is_hit(156));
    let (_, mask, stats) = row_of(&mut processor, &chirp);
    let ones: u32 = mask.iter().map(|w| w.count_ones()).sum();
    assert_eq!(ones, u32::from(stats.detections));
}

#[test]
fn real_phasors_are_the_bins_of_the_spectrum() {
    let mut random = Gauss::new(16);
    for samples in [16, 24, 33, 64, 100, 128, 200, 256] {
        let mut processor = bare_real(samples);
        let chirp = mixed(samples, -3.0, &mut random);
        let mut bins = [Packed::ZERO; MAX_SAMPLES];
        processor.spectrum(&chirp, &mut bins).unwrap();
        let kept = processor.kept();
        for bin in 0..kept.count {
            let x = bins[usize::from(kept.first + bin)];
            let [echo, _] = processor.phasors(bin as u8);
            let (a, b) = (f32::from(x.re()), f32::from(x.im()));
            let (size, other) = (math::hypot(a, b), math::hypot(echo[0], echo[1]));
            if size > 300.0 {
                let cos = (a * echo[0] + b * echo[1]) / (size * other);
                assert!(cos > 0.999, "{samples} pairs, bin {bin}: {cos}");
            }
        }
    }
}

#[test]
fn all_values_count_in_what_is_reported_of_a_real_chirp() {
    let mut processor = bare_real(64);
    let mut chirp = [Iq::new(100, 300); 64];
    let (_, _, stats) = row_of(&mut processor, &chirp);
    assert_eq!(stats.mean, Iq::new(200, 200));
    assert_eq!(stats.extremes, [Iq::new(100, 100), Iq::new(300, 300)]);
    assert_eq!((stats.swing, stats.saturated), (100, 0));
    chirp[5].q = i16::MAX;
    assert_eq!(row_of(&mut processor, &chirp).2.saturated, 1);
    let (cells, _, stats) = row_of(&mut processor, &[Iq::new(-77, -77); 64]);
    assert!(cells.iter().all(|&c| c == 0) && stats.swing <= 1);
}

#[test]
fn false_alarms_in_real_noise_come_at_the_configured_rate() {
    let mut random = Gauss::new(17);
    for samples in [200u16, 64] {
        let (mut hits, mut cells) = (0, 0);
        let radar = real_radar(samples);
        let cfar = CfarConfig {
            false_alarm: 2e-3,
            near_margin: 0,
            ..CfarConfig::default()
        };
        let mount = MountConfig {
            mirror_offset: 0,
            ..MountConfig::default()
        };
        let mut processor = RangeProcessor::new(&radar, &mount, &cfar).unwrap();
        while cells < 300_000 {
            let chirp = real_tones(samples, &[], 60.0, &mut random);
            let (row, _, stats) = row_of(&mut processor, &chirp);
            cells += row.len();
            hits += usize::from(stats.detections);
        }
        let rate = hits as f64 / cells as f64 / 2e-3;
        println!("{samples} pairs: {rate:.2} of the configured rate");
        assert!((0.5..=2.0).contains(&rate), "{samples} pairs: {rate}");
    }
}

#[test]
fn square_waves_at_full_scale_overflow_nowhere() {
    for samples in [16u16, 32, 50, 64, 128, 200, 256] {
        let mut processor = bare_real(samples);
        for period in [2usize, 3, 4, 8, 10, 16, 31, 64, 200] {
            let values: Vec<i16> = (0..2 * usize::from(samples))
                .map(|n| {
                    if n % period < period / 2 {
                        i16::MAX
                    } else {
                        i16::MIN
                    }
                })
                .collect();
            let chirp = pairs(&values);
            let exact = total(&real_reference(&chirp));
            let fixed = total(&measured(&mut processor, &chirp));
            // A square wave with a period of two values is at half the sampling rate, which is not kept.
            assert!(
                (exact - fixed).abs() <= 2e-3 * exact + 1e-4,
                "{samples} pairs, period {period}: {exact} {fixed}"
            );
            row_of(&mut processor, &chirp);
            assert!(processor.power.iter().all(|&p| p < 1 << 30));
        }
    }
}

proptest! {
    #[test]
    fn any_real_chirp_gives_a_row(
        size in 0usize..SIZES.len(),
        samples in prop::collection::vec(any_sample(), 256),
        period in 1usize..=256,
    ) {
        let ns = usize::from(SIZES[size]);
        let chirp: Vec<_> = (0..ns).map(|n| samples[n % period]).collect();
        let mut processor = bare_real(SIZES[size]);
        let (cells, _, stats) = row_of(&mut processor, &chirp);
        prop_assert!(usize::from(stats.detections) <= cells.len());
        prop_assert!(processor.power.iter().all(|&p| p < 1 << 30));
        let exact = total(&real_reference(&chirp));
        let total = total(&measured(&mut processor, &chirp));
        let swing = f64::from(stats.swing) / 32_768.0;
        let tolerance = 1e-3 * exact + 1e-2 * swing * (exact.sqrt() + 1e-2 * swing);
        prop_assert!((exact - total).abs() <= tolerance, "{exact} {total} {swing}");
    }
}
