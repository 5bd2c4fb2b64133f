//! Tests of the scenes of streets and entrances.

use super::{ENTRANCE, Kind, random};
use crate::recording::Truth;
use crate::scene::Scene;
use crate::scene::spec::SceneSpec;

/// Returns the first twenty scenes with the content `what` of [`ENTRANCE`], with their truth.
fn scenes(what: &str) -> Vec<(SceneSpec, Truth)> {
    let place = ENTRANCE.iter().position(|(name, _)| *name == what);
    let first = place.expect("an entry of the list") as u64;
    let of = |k: u64| {
        let spec = random(Kind::Entrance, first + k * ENTRANCE.len() as u64);
        assert!(spec.description.ends_with(&format!(": {what}")));
        let truth = Scene::new(spec.clone()).unwrap().truth();
        (spec, truth)
    };
    (0..20).map(of).collect()
}

#[test]
fn what_is_no_step_is_not_in_the_truth() {
    for what in [
        "tactile paving",
        "grate",
        "threshold with seal",
        "wet floor",
        "dark floor",
        "glass door",
    ] {
        for (_, truth) in scenes(what) {
            assert_eq!(truth.direction, "none", "{what}");
            assert!(truth.steps.is_empty() && truth.uncounted.is_empty());
        }
    }
}

#[test]
fn kerbs_count_from_six_centimetres_over_their_foot() {
    for what in [
        "kerb with gutter",
        "worn kerb",
        "ramp to a kerb",
        "tactile paving, kerb",
    ] {
        let mut counted = 0;
        for (spec, truth) in scenes(what) {
            let s = &spec.stairs[0];
            let steps = usize::from(s.rise_m >= 0.06);
            assert_eq!(truth.steps.len(), steps, "{what}: {}", s.rise_m);
            assert_eq!(truth.uncounted.len(), 1 - steps, "{what}");
            let kerb = truth.steps.iter().chain(&truth.uncounted).next().unwrap();
            assert!((kerb.distance_m - s.distance_m).abs() < 1e-4);
            // From the road, not from the gutter's bottom.
            assert!((kerb.height_m - s.base_m - s.rise_m).abs() < 1e-4);
            counted += steps;
        }
        assert!(counted >= 5, "{what}: {counted}");
    }
}

#[test]
fn gutters_are_shallower_than_a_drop_and_kerbs_worn_as_said() {
    for (spec, _) in scenes("kerb with gutter") {
        let gutter = &spec.ramp[0];
        let width = gutter.to_m - gutter.from_m;
        assert!((0.2..=0.45).contains(&width) && gutter.to_m == spec.stairs[0].distance_m);
        assert!((-0.03..=-0.01).contains(&gutter.to_height_m));
        assert_eq!(gutter.to_height_m, spec.stairs[0].base_m);
    }
    let worn = scenes("worn kerb");
    let kerbs = || worn.iter().map(|(spec, _)| &spec.stairs[0]);
    assert!(kerbs().all(|s| (0.015..=0.03).contains(&s.nosing_radius_m)));
    let (chamfered, battered) = (
        kerbs().filter(|s| s.chamfered).count(),
        kerbs().filter(|s| s.batter_m > 0.0).count(),
    );
    assert!((2..15).contains(&chamfered) && (4..17).contains(&battered));
}

#[test]
fn thresholds_and_paving_stay_below_four_centimetres() {
    let top = |spec: &SceneSpec| {
        let points = spec.polyline.iter().flat_map(|p| &p.points);
        points.map(|[_, y]| *y).fold(0.0, f64::max)
    };
    for (spec, _) in scenes("threshold with seal") {
        assert!((0.02..0.0395).contains(&top(&spec)), "{}", top(&spec));
        assert!(spec.polyline.iter().any(|p| p.material == "rubber"));
    }
    for what in ["tactile paving", "tactile paving, kerb"] {
        assert!(
            scenes(what)
                .iter()
                .all(|(s, _)| (top(s) - 0.005).abs() < 1e-9)
        );
    }
    for (spec, truth) in scenes("tactile paving, stairs") {
        assert!((top(&spec) - 0.006).abs() < 1e-9);
        assert!(truth.steps.len() + truth.uncounted.len() == spec.stairs[0].count);
        assert!(truth.steps.iter().all(|s| s.height_m >= 0.1));
    }
}

#[test]
fn a_grate_is_no_gap_wider_than_a_slot() {
    for (spec, _) in scenes("grate") {
        let fronts: Vec<f64> = spec.polyline.iter().map(|p| p.points[0][0]).collect();
        let thick = spec.polyline[0].points[2][0] - fronts[0];
        let pitches = fronts.windows(2).map(|pair| pair[1] - pair[0]);
        for pitch in pitches {
            assert!(
                (0.010..=0.031).contains(&(pitch - thick)),
                "{pitch} {thick}"
            );
        }
        // The floor continues from bar to bar at its height.
        let (before, behind) = (&spec.floor[0], &spec.floor[1]);
        assert_eq!(before.to_m, Some(fronts[0]));
        let last = fronts[fronts.len() - 1] + thick;
        assert!((behind.from_m - last).abs() < 1e-9 && behind.height_m == 0.0);
    }
}

#[test]
fn strips_that_stand_out_raise_every_step() {
    let mut proud = 0;
    for (spec, truth) in scenes("nosing strips") {
        let s = &spec.stairs[0];
        assert!((0.03..=0.055).contains(&s.strip_m));
        assert_eq!(truth.steps.len() + truth.uncounted.len(), s.count);
        let first = truth.steps.first().unwrap();
        let height = s.rises_m[0] + s.strip_proud_m;
        assert!((first.height_m - height).abs() < 1e-4);
        proud += usize::from(s.strip_proud_m > 0.0);
    }
    assert!((4..17).contains(&proud), "{proud}");
}
