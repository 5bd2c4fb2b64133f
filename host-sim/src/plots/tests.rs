use super::*;
use crate::output::Outputs;
use crate::recording::{Metadata, MirrorSetup, TrueStep, Truth};
use crate::views::{ExplanationView, HypothesisView, ScattererView, Verdict};
use stairscan::Iq;
use stairscan::config::{CfarConfig, MountConfig, RadarConfig};
use stairscan::paper::cluster::ClusterVerdict;
use stairscan::report::{DropLine, Tenths};
use stairscan::verdict::Status;

use answers::answer;

#[path = "../../../replay/src/score/tests/answers.rs"]
mod answers;

/// A recording of `chirps` equal chirps with `samples` each: one echo at 1 m in noise.
fn recording(samples: usize, mirror: Option<Plane>, chirps: usize) -> Recording {
    let mut noise = 1_u32;
    let mut draw = move || {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(noise >> 16) / 65_536.0 - 0.5
    };
    let bandwidth_hz = 10e9;
    let beat = 2.0 * std::f64::consts::PI * 2.0 / 299_792_458.0 * bandwidth_hz / samples as f64;
    let chirp = (0..samples).map(move |n| {
        let phase = beat * n as f64;
        let mut part = |v: f64| (3000.0 * v + 60.0 * draw()).round() as i16;
        Iq::new(part(phase.cos()), part(phase.sin()))
    });
    let chirp: Vec<Iq> = chirp.collect();
    Recording {
        name: "echo".into(),
        meta: Metadata {
            carrier_hz: 94e9,
            bandwidth_hz,
            samples_per_chirp: samples,
            mirror: mirror.map(|plane| MirrorSetup {
                offset_m: 0.22,
                beamwidth_deg: 5.0,
                mount_height_m: 0.4,
                plane,
            }),
            angles_deg: match mirror {
                Some(_) => (0..chirps).map(|k| k as f64).collect(),
                None => Vec::new(),
            },
            ..Metadata::default()
        },
        samples: chirp.repeat(chirps),
    }
}

/// The configuration and the polar map of a recording.
fn scan(recording: &Recording) -> (Config, Box<PolarMap>) {
    let (config, schedule) = setup::config(recording, 0, &Config::default()).unwrap();
    let mut map = Box::new(PolarMap::new());
    map.begin(&config).unwrap();
    let mut range = RangeProcessor::new(&config.radar, &config.mount, &config.cfar).unwrap();
    for (k, chirp) in schedule.chirps.iter().enumerate() {
        let chirp = recording.chirp(chirp.unwrap()).unwrap();
        let filled = map.fill(k, |mut row| range.process(chirp, &mut row));
        filled.unwrap().unwrap();
    }
    (config, map)
}

/// A posterior of three hypotheses: two steps (90 %), one step (8 %) and none (2 %).
fn posterior() -> PosteriorView {
    let hypothesis = |probability, edges: &[Point]| HypothesisView {
        name: format!("{} steps", edges.len()),
        probability,
        edges: edges.to_vec(),
    };
    PosteriorView {
        counts: vec![0.02, 0.08, 0.9],
        hypotheses: vec![
            hypothesis(0.9, &[(0.5, 0.17), (0.78, 0.34)]),
            hypothesis(0.08, &[(0.5, 0.17)]),
            hypothesis(0.02, &[]),
        ],
    }
}

/// A separate directory for each test.
struct Directory(PathBuf);

impl Directory {
    fn new(name: &str) -> Self {
        let unique = format!("stairscan-plots-{name}-{}", std::process::id());
        Self(std::env::temp_dir().join(unique))
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Width and height in pixels, and number of different colours, of a PNG file.
fn look(path: &Path) -> (u32, u32, usize) {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let colours: std::collections::HashSet<&[u8]> = pixels.chunks(3).collect();
    (info.width, info.height, colours.len())
}

fn names(paths: &[PathBuf]) -> Vec<String> {
    let name = |p: &PathBuf| p.file_name().unwrap().to_string_lossy().into_owned();
    paths.iter().map(name).collect()
}

/// Writes all plots of a scan, checks that each can be read and that there are no other files, and returns their
/// names.
fn pictures(test: &str, recording: &Recording, answer: &Answer, paper: &PaperView) -> Vec<String> {
    let (config, map) = scan(recording);
    let dir = Directory::new(test);
    let view = ScanView {
        recording,
        config: &config,
        map: &map,
        answer,
        paper,
        posterior: &posterior(),
    };
    let inner = dir.0.join("a/b");
    let written = write_scan((&Outputs::default(), &inner), &view).unwrap();
    for path in &written {
        let (width, height, colours) = look(path);
        assert!(
            (500..1700).contains(&width) && (500..1300).contains(&height),
            "{path:?}"
        );
        assert!(colours > 50, "{path:?}");
    }
    assert_eq!(std::fs::read_dir(&inner).unwrap().count(), written.len());
    names(&written)
}

#[test]
fn a_scan_gives_every_figure_of_the_paper() {
    let mut recording = recording(200, Some(Plane::Depth), 31);
    let step = |distance_m, height_m| TrueStep {
        distance_m,
        height_m,
        snr_db: None,
    };
    recording.meta.truth = Some(Truth {
        direction: "up".into(),
        steps: vec![step(0.5, 0.17), step(0.78, 0.34)],
        uncounted: vec![step(1.1, 0.5)],
        drops: None,
    });
    let cluster = |fate, x: f64| ClusterView {
        points: (0..40).map(|k| (x, 0.1 + 0.005 * f64::from(k))).collect(),
        centre: (x, 0.2),
        fate,
    };
    let particles = ParticleView {
        initial: (0..100).map(|k| (0.3 + 0.01 * f64::from(k), 0.3)).collect(),
        resampled: vec![(0.78, 0.3); 10],
        rounds: 2,
    };
    let paper = PaperView {
        uniform: particles.clone(),
        modes: particles,
        clusters: vec![
            cluster(ClusterVerdict::Kept, 0.78),
            cluster(ClusterVerdict::Redundant, 0.8),
            cluster(ClusterVerdict::Outlier, 1.4),
        ],
        kept: vec![
            cluster(ClusterVerdict::Kept, 0.78),
            cluster(ClusterVerdict::Kept, 1.05),
        ],
        beams: vec![
            BeamView {
                end: (0.78, 0.3),
                edge: (0.78, 0.266),
            },
            BeamView {
                end: (1.0, 0.2),
                edge: (1.04, 0.2),
            },
        ],
    };
    let answer = answer(Status::Ok, &[(5030, 1650), (7800, 3400)]);
    let expected = [
        "echo-fig02-range-profile.png",
        "echo-fig04-map.png",
        "echo-fig05-particles-uniform.png",
        "echo-fig06-particles-gmm.png",
        "echo-fig07-clusters.png",
        "echo-fig08-clusters-kept.png",
        "echo-fig09-cfar-threshold.png",
        "echo-fig10-map-cfar.png",
        "echo-fig11-beam-correction.png",
        "echo-fig13-staircase.png",
    ];
    assert_eq!(pictures("full", &recording, &answer, &paper), expected);
}

#[test]
fn a_fault_and_an_empty_room_have_their_pictures_too() {
    let recording = recording(200, Some(Plane::Height), 5);
    let nothing = PaperView::default();
    let fault = pictures("fault", &recording, &answer(Status::Fault, &[]), &nothing);
    assert_eq!(fault.last().unwrap(), "echo-fig14-staircase.png");
    pictures("clear", &recording, &answer(Status::Ok, &[]), &nothing);
}

/// A reported drop changes the picture, even if its edge or band lies outside the plot.
#[test]
fn a_drop_has_its_mark() {
    let recording = recording(200, Some(Plane::Depth), 31);
    let (config, map) = scan(&recording);
    let dir = Directory::new("drop");
    let image = |name: &str, drop| {
        let answer = Answer {
            drop,
            ..answer(Status::Ok, &[])
        };
        let scan = ScanView {
            recording: &recording,
            config: &config,
            map: &map,
            answer: &answer,
            paper: &PaperView::default(),
            posterior: &PosteriorView::default(),
        };
        let file = dir.0.join(format!("{name}.png"));
        write_inspect((&Outputs::default(), &file), &scan, &InspectView::default()).unwrap();
        std::fs::read(&file).unwrap()
    };
    let drop = |distance, sigma| {
        Some(DropLine {
            distance: Tenths(distance),
            distance_sigma: Tenths(sigma),
            probability: 974,
            ..DropLine::default()
        })
    };
    let none = image("none", None);
    for (name, answer) in [("near", drop(9_000, 150)), ("edge", drop(-2_000, 9_000))] {
        assert!(image(name, answer) != none, "{name}");
    }
}

#[test]
fn silence_does_no_harm() {
    let mut recording = recording(200, Some(Plane::Depth), 5);
    recording.samples.fill(Iq::default());
    let nothing = PaperView::default();
    let (config, map) = scan(&recording);
    let dir = Directory::new("silent");
    let view = ScanView {
        recording: &recording,
        config: &config,
        map: &map,
        answer: &answer(Status::Fault, &[]),
        paper: &nothing,
        posterior: &PosteriorView::default(),
    };
    assert_eq!(
        write_scan((&Outputs::default(), &dir.0), &view)
            .unwrap()
            .len(),
        10
    );
}

#[test]
fn other_radars_have_profiles() {
    let dir = Directory::new("profile");
    for samples in [16, 64, 128, 256] {
        let recording = recording(samples, None, 2);
        let radar = setup::radar(&recording).unwrap();
        let mount = MountConfig {
            mirror_offset: 0,
            ..MountConfig::default()
        };
        let cfar = CfarConfig {
            near_margin: 0,
            ..CfarConfig::default()
        };
        let mut range = RangeProcessor::new(&radar, &mount, &cfar).unwrap();
        let view = profile_view(&recording, 1, &mut range).unwrap();
        assert_eq!(view.power_db.len(), samples);
        let strongest = view.power_db.iter().copied().fold(f64::MIN, f64::max);
        let far = RadarConfig::range_resolution_m(&radar) * samples as f32;
        if far > 1.2 {
            let (range, power) = view.detections[0];
            assert!((range - 1.0).abs() < 0.003, "{samples}: {range}");
            assert!((power - strongest).abs() < 1.6, "{samples}");
        }
        let file = dir.0.join(format!("{samples}.png"));
        write_profile((&Outputs::default(), &file), &view).unwrap();
        assert!(look(&file).2 > 50);
        assert!(
            profile_view(&recording, 2, &mut range).is_err(),
            "no third chirp"
        );
    }
}

#[test]
fn what_the_estimator_thought_has_its_picture() {
    let recording = recording(200, Some(Plane::Depth), 31);
    let (config, map) = scan(&recording);
    let scan = ScanView {
        recording: &recording,
        config: &config,
        map: &map,
        answer: &answer(Status::Ok, &[(7800, 1700)]),
        paper: &PaperView::default(),
        posterior: &PosteriorView::default(),
    };
    let scatterer = |x, role, verdict| ScattererView {
        at: (x, 0.2),
        snr_db: 30.0 * x,
        role,
        verdict,
    };
    let explanation = |score, winner, edges: &[Point]| ExplanationView {
        name: format!("{} steps", edges.len()),
        score,
        winner,
        edges: edges.to_vec(),
    };
    let view = InspectView {
        scatterers: vec![
            scatterer(0.78, "nosing", Verdict::For),
            scatterer(0.8, "corner", Verdict::For),
            scatterer(0.9, "inside", Verdict::Against),
            scatterer(0.4, "unexplained", Verdict::Neither),
        ],
        explanations: vec![
            explanation(12.0, true, &[(0.78, 0.17)]),
            explanation(9.0, false, &[(0.5, 0.1), (0.78, 0.2)]),
            explanation(0.0, false, &[]),
        ],
        posterior: posterior(),
    };
    let dir = Directory::new("inspect");
    for (name, view) in [("full", &view), ("empty", &InspectView::default())] {
        let file = dir.0.join(format!("{name}.png"));
        write_inspect((&Outputs::default(), &file), &scan, view).unwrap();
        assert!(look(&file).2 > 50);
    }
}

#[test]
fn a_directory_that_cannot_be_made_is_named() {
    let dir = Directory::new("refused");
    std::fs::create_dir_all(&dir.0).unwrap();
    std::fs::write(dir.0.join("file"), "").unwrap();
    let recording = recording(200, Some(Plane::Depth), 5);
    let (config, map) = scan(&recording);
    let view = ScanView {
        recording: &recording,
        config: &config,
        map: &map,
        answer: &answer(Status::Ok, &[]),
        paper: &PaperView::default(),
        posterior: &PosteriorView::default(),
    };
    let inner = dir.0.join("file/pictures");
    let error = write_scan((&Outputs::default(), &inner), &view).unwrap_err();
    assert!(format!("{error:#}").contains("file/pictures"), "{error:#}");
    assert_eq!(std::fs::read(dir.0.join("file")).unwrap(), b"");
}
