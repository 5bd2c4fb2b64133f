//! Properties of all random scenes, and of each kind.

use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::*;
use crate::recording::{Recording, Truth};
use crate::replay::{self, Options};
use crate::scene::Scene;
use crate::scene::spec::{PlaneSpec, Way};
use crate::setup;
use stairscan::config::Config;

/// Number of seeds of each kind for which scenes are built.
const SEEDS: u64 = 200;

const WIDE: Variety = Variety {
    instrument: Spread::Wide,
    effects: Spread::Wide,
};

/// Runs `test` on all seeds of all kinds, on all cores.
fn every(test: impl Fn(Kind, u64) + Sync) {
    let jobs = Kind::every().flat_map(|kind| (0..SEEDS).map(move |seed| (kind, seed)));
    let jobs: Vec<(Kind, u64)> = jobs.collect();
    jobs.into_par_iter()
        .for_each(|(kind, seed)| test(kind, seed));
}

fn build(kind: Kind, variety: Variety, seed: u64) -> Scene {
    Scene::new(random_with(kind, variety, seed)).unwrap_or_else(|e| panic!("{kind} {seed}: {e}"))
}

#[test]
fn every_scene_can_be_built_and_its_seed_says_which_it_is() {
    every(|kind, seed| {
        let spec = random(kind, seed);
        assert_eq!(spec, random(kind, seed));
        assert_ne!(spec, random(kind, seed + 1));
        truth_is_consistent(kind, seed, &build(kind, kind.variety(), seed).truth());
        // Other instruments and surfaces on fewer seeds, because the shapes are the same.
        if seed % 4 == 0 {
            build(kind, WIDE, seed);
        }
    });
}

/// Checks that the truth is sorted and complete, and that its direction is that of its plane.
fn truth_is_consistent(kind: Kind, seed: u64, truth: &Truth) {
    let spec = random(kind, seed);
    let built: usize = spec.stairs.iter().map(|s| s.count).sum();
    let down = spec.mount.plane == PlaneSpec::Height;
    // Stairs first, then boxes that may be steps.
    let (stairs, boxes) = truth.uncounted.split_at(built - truth.steps.len());
    let most = if down { 0 } else { spec.boxes.len() };
    assert!(boxes.len() <= most, "{kind} {seed}");
    let direction = match (truth.steps.is_empty(), down) {
        (true, _) => "none",
        (false, true) => "down",
        (false, false) => "up",
    };
    assert_eq!(truth.direction, direction, "{kind} {seed}");
    for list in [truth.steps.as_slice(), stairs] {
        for pair in list.windows(2) {
            assert!(pair[0].distance_m < pair[1].distance_m, "{kind} {seed}");
            let climbs = pair[0].height_m < pair[1].height_m;
            assert_eq!(climbs, spec.stairs[0].direction == Way::Up, "{kind} {seed}");
        }
    }
}

#[test]
fn drops_in_the_depth_plane_are_known_and_no_steps() {
    for kind in [Kind::Brink, Kind::Hole] {
        for seed in 0..40 {
            let truth = build(kind, kind.variety(), seed).truth();
            assert_eq!(truth.direction, "none", "{kind} {seed}");
            assert!(truth.steps.is_empty() && !truth.uncounted.is_empty());
            assert!(truth.uncounted.iter().all(|s| s.height_m < 0.0));
        }
    }
}

#[test]
fn scenes_without_stairs_have_no_steps_at_all() {
    for kind in [Kind::None, Kind::Clutter] {
        for seed in 0..SEEDS {
            assert!(random(kind, seed).stairs.is_empty(), "{kind} {seed}");
        }
    }
}

/// Returns the rises, the goings and the distance of a scene's first flight, metres.
fn flight_of(kind: Kind, seed: u64) -> (Vec<f64>, Vec<f64>, f64) {
    let s = random(kind, seed).stairs.remove(0);
    let rises = if s.rises_m.is_empty() {
        vec![s.rise_m; s.count]
    } else {
        s.rises_m
    };
    let goings = if s.goings_m.is_empty() {
        vec![s.going_m; s.count - 1]
    } else {
        s.goings_m
    };
    (rises, goings, s.distance_m)
}

#[test]
fn flights_keep_the_ranges_of_their_kind() {
    // Rises and goings before workmanship, which moves them by up to 15 mm (40 mm where uneven).
    for (kind, rises, goings) in [
        (Kind::Low, (0.06, 0.12), (0.35, 0.60)),
        (Kind::Steep, (0.20, 0.25), (0.18, 0.24)),
        (Kind::Platform, (0.18, 0.30), (0.0, 0.0)),
        (Kind::Kerb, (0.03, 0.08), (0.0, 0.0)),
        (Kind::Uneven, (0.085, 0.235), (0.18, 0.43)),
        (Kind::Odd, (0.05, 0.27), (0.14, 0.47)),
        (Kind::Landing, (0.07, 0.25), (0.22, 1.4)),
    ] {
        let slack = 0.0151;
        for seed in 0..SEEDS {
            let (r, g, _) = flight_of(kind, seed);
            assert!(
                r.iter()
                    .all(|r| (rises.0 - slack..=rises.1 + slack).contains(r)),
                "{kind} {seed}: {r:?}"
            );
            assert!(
                g.iter()
                    .all(|g| (goings.0 - slack..=goings.1 + slack).contains(g)),
                "{kind} {seed}: {g:?}"
            );
        }
    }
}

#[test]
fn an_odd_flight_differs_in_one_place_or_in_two_that_make_up_for_each_other() {
    let (mut followed, mut stayed, mut goings) = (0, 0, 0);
    for seed in 0..SEEDS {
        let s = random(Kind::Odd, seed).stairs.remove(0);
        let off = |list: &[f64], mean: f64| -> Vec<f64> {
            list.iter()
                .map(|v| v - mean)
                .filter(|d| d.abs() > 1e-9)
                .collect()
        };
        let (rise, going) = (off(&s.rises_m, s.rise_m), off(&s.goings_m, s.going_m));
        assert!(!rise.is_empty() || !going.is_empty(), "{seed}");
        for (list, low, high) in [(&rise, 0.02, 0.05), (&going, 0.03, 0.08)] {
            assert!(list.len() <= 2, "{seed}: {list:?}");
            assert!(
                list.iter()
                    .all(|d| (low - 1e-9..=high + 1e-9).contains(&d.abs()))
            );
            if let [a, b] = list[..] {
                assert!((a + b).abs() < 1e-9, "{seed}: {a} {b}");
            }
        }
        followed += usize::from(rise.len() == 1);
        stayed += usize::from(rise.len() == 2);
        goings += usize::from(!going.is_empty());
    }
    assert!(
        followed > 60 && stayed > 20 && goings > 20,
        "{followed} {stayed} {goings}"
    );
}

#[test]
fn one_step_of_an_irregular_flight_is_off_by_two_to_four_centimetres() {
    for seed in 0..100 {
        let spec = random(Kind::Irregular, seed);
        let s = &spec.stairs[0];
        let off: Vec<f64> = s.rises_m.iter().map(|r| (r - s.rise_m).abs()).collect();
        assert_eq!(off.iter().filter(|d| **d > 0.0).count(), 1);
        assert!(off.iter().any(|d| (0.02..=0.04).contains(d)));
        assert!(s.rises_m.iter().all(|r| (0.06..0.24).contains(r)));
    }
}

#[test]
fn kinds_with_a_list_show_each_of_it_by_turns() {
    for (kind, list) in [
        (Kind::None, &NONE[..]),
        (Kind::Clutter, &CLUTTER[..]),
        (Kind::Entrance, &ENTRANCE[..]),
    ] {
        let total: usize = list.iter().map(|(_, n)| n).sum();
        for (name, n) in list {
            let wanted = format!(": {name}");
            let scenes = (0..total as u64).map(|seed| random(kind, seed).description);
            assert_eq!(
                scenes.filter(|d| d.ends_with(&wanted)).count(),
                *n,
                "{name}"
            );
        }
    }
}

#[test]
fn the_same_seed_shows_the_same_shapes_whatever_varies_besides() {
    for kind in Kind::every() {
        for seed in 0..20 {
            let (own, wide) = (random(kind, seed), random_with(kind, WIDE, seed));
            assert_eq!(own.stairs, wide.stairs);
            assert_eq!(own.boxes, wide.boxes);
            assert_eq!(own.post, wide.post);
        }
    }
}

#[test]
fn a_wide_instrument_keeps_its_ranges_and_fits_the_scanner() {
    let (mut level, mut rows) = (0, Vec::new());
    for seed in 0..SEEDS {
        let spec = random(Kind::Mounting, seed);
        let (mount, radar) = (&spec.mount, &spec.radar);
        assert!((0.25..=0.80).contains(&mount.height_m));
        assert!((3.0..=8.0).contains(&mount.beamwidth_deg));
        assert!((4e9..=10e9).contains(&radar.bandwidth_hz));
        assert!(mount.pitch_error_deg.abs() <= 0.1);
        level += usize::from(mount.pitch_deg.is_none());
        let recording = blank(&spec);
        let (config, schedule) = setup::config(&recording, 0, &Config::default())
            .unwrap_or_else(|e| panic!("{seed}: {e}"));
        rows.push(schedule.sweep.angle_count);
        assert_eq!(config.radar.samples as usize, radar.samples_per_chirp);
        // The scanner's map must hold rows times range bins, so that the scanner gives an answer.
        if seed % 8 == 0 {
            replay::answer(&recording, &Options::default())
                .unwrap_or_else(|e| panic!("{seed}: {e}"));
        }
    }
    assert!((60..140).contains(&level), "{level}");
    assert!(rows.iter().max() <= Some(&281), "{rows:?}");
}

/// Returns a recording with a scene's metadata, without its flights, floors, posts and walls: a low wall 4 m away.
fn blank(spec: &SceneSpec) -> Recording {
    let mut quiet = spec.clone();
    quiet.stairs.clear();
    quiet.floor.clear();
    quiet.post.clear();
    quiet.wall = vec![crate::scene::spec::WallSpec {
        at_m: 4.0,
        bottom_m: 0.0,
        top_m: 0.1,
        material: "plaster".into(),
    }];
    Scene::new(quiet).unwrap().simulate("blank", 1)
}

#[test]
fn kinds_have_names() {
    for kind in Kind::every() {
        assert_eq!(kind.to_string().parse(), Ok(kind));
    }
    assert!("stairs".parse::<Kind>().is_err());
}

#[test]
fn a_vibrating_scene_keeps_its_ranges_and_no_other_kind_is_unsteady() {
    every(|kind, seed| {
        let spec = random(kind, seed);
        let (mount, mirror, receiver) = (&spec.mount, &spec.mirror, &spec.receiver);
        if kind == Kind::Vibrating {
            assert!((5e-5..=5e-4).contains(&mount.vibration_m));
            assert!((5.0..=60.0).contains(&mount.vibration_hz));
            assert!((1e-5..=5e-5).contains(&mirror.shaft_runout_m));
            assert!(receiver.trigger_jitter_s <= 2e-7);
        } else {
            assert_eq!((mount.vibration_m, mirror.shaft_runout_m), (0.0, 0.0));
            let drifts = [mirror.offset_drift_m_s, receiver.slope_drift_s];
            assert_eq!(drifts, [0.0; 2], "{kind} {seed}");
            let receiver = [
                receiver.carrier_drift_hz_s,
                receiver.trigger_jitter_s,
                receiver.start_phase_deg,
            ];
            assert_eq!(receiver, [0.0; 3], "{kind} {seed}");
        }
    });
}
