use super::labels::{Hit, Level};
use super::*;
use crate::fit::measurement_sample;
use host_sim::random::Kind;
use host_sim::recording::{TrueStep, Truth};
use host_sim::scene::maths::Random;
use host_sim::simulation::random_scan;
use stairscan::config::Plane;
use stairscan::model::{Class, MIN_DB, View};
use stairscan::params::measured;
use stairscan::signal::echoes::Echo;
use stairscan::signal::grid::{Geometry, PolarMap};

const SCANS: usize = 1500;

/// Draws a scan of one riser with corner and nosing, and a metre of tread, from the distributions of a measurement
/// model. Returns the SNR of its strongest echo (tens of dB over 30 dB) and its samples.
fn drawn(g: &Generative, rng: &mut Random) -> (f32, Vec<Sample>) {
    let mut samples = Vec::new();
    let mut normal = |sigma: f32| sigma * rng.normal() as f32;
    let q = normal(0.8);
    let mut hit = |class: usize| {
        let (p, wide) = (&g.points[class], normal(0.1).abs().min(0.5));
        let noise_m = 0.001;
        let spread = p
            .across_sigma_m
            .hypot(p.sigma_per_width_m * wide)
            .hypot(noise_m);
        let hit = Hit {
            range_m: p.range_m + normal(p.range_sigma_m),
            across_m: p.across_m + p.across_per_width_m * wide + normal(spread),
            noise_m,
            wide,
            cos: 1.0,
            above_m: [0.0; 2],
            over_m: 0.0,
        };
        let snr_db = p.snr_db + 10.0 * p.snr_per_db * q + normal(p.snr_sigma_db);
        let level = Level {
            snr_db,
            fade_db: 0.0,
            q,
        };
        (snr_db > MIN_DB).then_some((hit, level))
    };
    let hits = [hit(0), hit(1)];
    let room = rng.between(0.5, 2.0) as f32;
    let odds = |w: [f32; 3]| f64::from(w[0] + w[1] * q + w[2] * (room - 1.0));
    let mut happens = |odds: f64| rng.chance(1.0 / (1.0 + (-odds).exp()));
    let nothing = happens(f64::from(g.hidden.nothing[0] + g.hidden.nothing[1] * q));
    let seen = loop {
        let seen = [0, 1].map(|class| {
            let p = &g.points[class];
            happens(odds([p.seen, p.seen_per_ten_db, p.seen_per_room]))
        });
        if nothing || seen.contains(&true) {
            break seen;
        }
    };
    for (k, class) in [Class::Corner, Class::Nosing].into_iter().enumerate() {
        samples.push(Sample::Feature {
            class,
            riser: 0,
            q,
            room,
            hit: hits[k].filter(|_| seen[k] && !nothing),
        });
    }
    samples.push(Sample::Riser {
        q,
        hidden: false,
        before: 0.0,
        nothing,
    });
    let p = &g.extended[1];
    let mut left = f64::from(p.rate + p.rate_per_ten_db * q).exp();
    // Poisson number: counts exponential gaps.
    loop {
        left += (1.0 - rng.between(0.0, 1.0)).ln();
        if left < 0.0 {
            break;
        }
        let level = loop {
            let mean = p.snr_db + 10.0 * p.snr_per_db * q;
            let snr_db = mean + p.snr_sigma_db * rng.normal() as f32;
            if snr_db > MIN_DB {
                break Level {
                    snr_db,
                    fade_db: 0.0,
                    q,
                };
            }
        };
        samples.push(Sample::Extended {
            class: 1,
            level,
            off_m: p.off_sigma_m * rng.normal() as f32,
            noise_m: 0.0,
        });
    }
    (q, samples)
}

#[test]
fn a_known_table_is_recovered() {
    let mut known = prior::START;
    known.points[0].across_m = 0.003;
    known.points[0].across_per_width_m = 0.05;
    known.points[0].snr_db = 33.0;
    known.points[1].snr_per_db = 0.6;
    known.points[1].snr_db = 22.0;
    known.points[1].seen = 1.0;
    known.extended[1].snr_db = 9.0;
    let rng = &mut Random::new(7, 11);
    let mut counts = Counts::default();
    for _ in 0..SCANS {
        let (q, samples) = drawn(&known, rng);
        counts.add(q, [0.0, 1.0, 0.0], &samples);
    }
    let mut table = prior::START;
    let mut numbers = Vec::new();
    for _ in 0..ROUNDS {
        (table, numbers) = estimate::estimate(&counts, &table);
    }
    let number = |name: &str| numbers.iter().find(|n| n.name == name).unwrap();
    let (corner, nosing, tread) = (&known.points[0], &known.points[1], &known.extended[1]);
    for (name, truth, slack) in [
        ("corner across m", corner.across_m, 0.0),
        ("corner across per width m", corner.across_per_width_m, 0.0),
        ("corner snr dB", corner.snr_db, 0.0),
        ("corner snr per dB", corner.snr_per_db, 0.0),
        ("nosing snr per dB", nosing.snr_per_db, 0.02),
        ("corner seen", corner.seen, 0.0),
        ("nosing seen", nosing.seen, 0.0),
        ("corner seen per room", corner.seen_per_room, 0.0),
        ("nosing seen per room", nosing.seen_per_room, 0.0),
        ("riser nothing", known.hidden.nothing[0], 0.0),
        ("riser nothing per 10 dB", known.hidden.nothing[1], 0.0),
        ("tread rate", tread.rate, 0.0),
        ("tread rate per 10 dB", tread.rate_per_ten_db, 0.0),
        ("tread snr per dB", tread.snr_per_db, 0.02),
    ] {
        let n = number(name);
        let off = (n.value - f64::from(truth)).abs();
        // Twenty numbers at three and a half standard errors. `slack` is for the uniform component
        // and the tails, which the model has and the draw has not: they shift slopes a little.
        assert!(off < 3.5 * n.error + slack, "{name}: {truth}, {n:?}");
    }
    assert!(number("corner across m").error < 0.001);
}

fn measurement_samples() -> Vec<MeasurementSample> {
    let kinds = [Kind::Ascending, Kind::Soft, Kind::None];
    let scenes = kinds
        .into_iter()
        .flat_map(|kind| (0..4).map(move |seed| (kind, seed)));
    scenes
        .filter_map(|(kind, seed)| {
            let recording = random_scan(kind, kind.variety(), seed).unwrap();
            measurement_sample(&recording, None).unwrap()
        })
        .collect()
}

#[test]
fn a_rerun_writes_the_same_bytes_whatever_the_threads() {
    let measurement_samples = measurement_samples();
    assert!(measurement_samples.len() > 6);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let measured = pool
            .build()
            .unwrap()
            .install(|| measure(&measurement_samples));
        assert!(measured.rounds.last() > measured.rounds.first());
        write(&measured.table) + &print(&measured.numbers)
    };
    let first = with(1);
    assert_eq!(first, with(1));
    assert_eq!(first, with(3));
}

#[test]
fn what_is_written_is_what_was_counted() {
    let text = write(&measured::MODEL);
    let corner = &measured::MODEL.points[0];
    assert!(
        text.contains(&format!("snr_db: {:?},", corner.snr_db)),
        "{text}"
    );
    assert_eq!(table::rounded(&measured::MODEL), measured::MODEL);
}

fn echo(x_m: f32, y_m: f32, snr_db: f32) -> Echo {
    let range_m = x_m.hypot(0.4 - y_m);
    Echo {
        x_m,
        y_m,
        snr_db,
        range_m,
        angle_rad: (0.4 - y_m).atan2(x_m),
        width: 1.0,
        angle_sigma_rad: 0.002,
        range_sigma_m: 0.001,
        native_bin: 0.0,
        phasor: [1.0, 0.0],
    }
}

#[test]
fn echoes_are_labelled_by_the_true_flight() {
    let measurement_sample = MeasurementSample {
        name: "one step".into(),
        echoes: vec![
            echo(0.9, 0.0, 32.0),
            echo(0.6, 0.001, 9.0),
            echo(0.9, 0.17, 15.0),
        ],
        geometry: Geometry {
            bin_m: 0.0117,
            mount_height_m: 0.4,
            beamwidth_rad: 0.087,
            ..PolarMap::new().geometry().to_owned()
        },
        view: View {
            plane: Plane::Depth,
            height_m: 0.4,
            lowest: -1.12,
            highest: 0.32,
            farthest_m: 2.67,
        },
        truth: Truth {
            direction: "up".into(),
            steps: vec![TrueStep {
                distance_m: 0.9,
                height_m: 0.17,
                snr_db: None,
            }],
            uncounted: Vec::new(),
            drops: None,
        },
        build: None,
    };
    let labelled = label(&measurement_sample, &measured::MODEL).unwrap();
    let seen = |class| {
        let is = |s: &&Sample| matches!(s, Sample::Feature { class: c, hit: Some(_), .. } if *c == class);
        labelled.samples.iter().filter(is).count()
    };
    assert_eq!(
        (seen(Class::Corner), seen(Class::Nosing)),
        (1, 1),
        "{:?}",
        labelled.samples
    );
    let extended: Vec<_> = labelled
        .samples
        .iter()
        .filter_map(|s| match s {
            Sample::Extended { class, .. } => Some(*class),
            _ => None,
        })
        .collect();
    assert_eq!(extended, [2]);
}
