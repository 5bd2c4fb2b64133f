//! Hypotheses: adding and removing risers, visibility of their edges, and conflicts with an answer.

use super::*;
use crate::model::staircase::{Conflict, Edge, MAX_STEPS, MIN_EXPANDED_M};

/// Standard deviations of tread heights that are exactly known, 0 m, so that an error is certain or excluded.
const SURE: [f32; MAX_STEPS] = [0.0; MAX_STEPS];

fn conflicts(s: &Staircase, answer: &[(f32, f32)], sigma_m: f32) -> Vec<Conflict> {
    let sigmas = [sigma_m; MAX_STEPS];
    s.conflicts(&reported(answer), None, &VIEW, &sigmas)
        .into_iter()
        .collect()
}

/// Returns which edges are visible, in the order of the risers, given as (distance, height of the top above the
/// ground), metres.
fn seen(risers: &[(f32, f32)], open: bool) -> Vec<bool> {
    let s = Staircase {
        open,
        ..flight(risers)
    };
    s.edges(&VIEW).map(|e| e.seen).collect()
}

#[test]
fn inserted_riser_moves_the_later_ones_back() {
    let s = flight(&[(0.6, 0.15), (0.9, 0.30), (1.2, 0.45)]);
    let front = s.with(0, 0.3, 0.05);
    assert_eq!(
        front,
        flight(&[(0.3, 0.05), (0.6, 0.15), (0.9, 0.30), (1.2, 0.45)])
    );
    let between = s.with(1, 0.7, 0.2);
    assert_eq!(
        between,
        flight(&[(0.6, 0.15), (0.7, 0.2), (0.9, 0.30), (1.2, 0.45)])
    );
    let behind = s.with(3, 1.5, 0.6);
    assert_eq!((behind.len(), behind.x(3), behind.level(4)), (4, 1.5, 0.6));
    assert_eq!((behind.x(2), behind.level(3)), (1.2, 0.45));
    // A riser cannot be added behind a gap.
    assert_eq!(s.with(4, 1.8, 0.8), s);
    // The other fields do not change.
    let open = Staircase {
        open: true,
        wall_m: 2.0,
        ..s
    };
    let more = open.with(3, 1.5, 0.6);
    assert!(more.open && more.wall_m == 2.0);
}

#[test]
fn a_full_staircase_takes_no_more_risers() {
    let full = regular(MAX_STEPS, 0.3, 0.2, 0.1);
    assert_eq!(full.len(), MAX_STEPS);
    for k in [0, 5, MAX_STEPS, MAX_STEPS + 1] {
        assert_eq!(full.with(k, 0.1, 0.02), full);
    }
}

#[test]
fn the_last_riser_is_taken_away() {
    let s = regular(3, 0.6, 0.3, 0.16);
    let less = s.without_last();
    assert_eq!((less.len(), less.last_x()), (2, s.x(1)));
    assert_eq!(less.kind, GroundKind::Stairs);
    assert_eq!(s.with(3, 1.5, 0.6).without_last().len(), 3);
    let mut walled = Staircase {
        wall_m: 1.9,
        open: true,
        ..regular(1, 0.6, 0.3, 0.16)
    };
    walled = walled.without_last();
    let floor = Staircase {
        wall_m: 1.9,
        ..Staircase::nothing()
    };
    assert_eq!(walled, floor, "the wall stays, the flight goes");
    assert!(walled.without_last().is_empty());
}

#[test]
fn only_steps_have_edges_and_an_overhang_brings_them_nearer() {
    let s = Staircase {
        overhang_m: 0.03,
        ..regular(2, 0.8, 0.3, 0.16)
    };
    let edges: Vec<Edge> = s.edges(&VIEW).collect();
    assert_eq!(edges.len(), 2);
    assert!((edges[0].x_m - 0.77).abs() < 1e-6 && (edges[1].y_m - 0.32).abs() < 1e-6);
    // Open treads have no overhang: the edge itself counts as the riser.
    let open = Staircase { open: true, ..s };
    assert_eq!(open.edges(&VIEW).next().map(|e| e.x_m), Some(0.8));
    for kind in [
        GroundKind::Nothing,
        Staircase::ramp(0.8, 0.1).kind,
        Staircase::drop(0.8).kind,
        GroundKind::Box,
        GroundKind::Threshold,
    ] {
        let other = Staircase { kind, ..s };
        assert_eq!(other.edges(&VIEW).count(), 0, "{kind:?}");
    }
}

#[test]
fn edge_is_visible_unless_hidden_or_outside_the_field_of_view() {
    // From 40 cm above the ground, a nosing 15 cm above the mirror at half a metre hides one 20 cm above it at 90 cm.
    assert_eq!(seen(&[(0.5, 0.55), (0.9, 0.6)], false), [true, false]);
    // Between open treads it is visible.
    assert_eq!(seen(&[(0.5, 0.55), (0.9, 0.6)], true), [true, true]);
    // A nosing above the line of sight is visible, even if one between them is hidden.
    assert_eq!(
        seen(&[(0.6, 0.5), (0.9, 0.52), (1.2, 0.7)], false),
        [true, false, true]
    );
    // Below the lowest and above the highest angle, and beyond the range.
    assert_eq!(seen(&[(0.1, 0.05), (0.4, 0.2)], false), [false, true]);
    assert_eq!(seen(&[(0.5, 0.5), (0.8, 0.75)], false), [true, false]);
    assert_eq!(seen(&[(2.8, 0.2), (3.1, 0.35)], false), [true, false]);
}

#[test]
fn the_view_of_a_map_is_half_a_beam_narrower_than_its_sector() {
    let mut map = Box::new(PolarMap::new());
    let config = Config::default();
    map.begin(&config).unwrap();
    let geometry = map.geometry();
    let view = View::of(&map);
    let (low, high) = (map.angle_rad(0), map.angle_rad(map.rows() - 1));
    let steepest = low.max(high) - 0.5 * geometry.beamwidth_rad;
    assert!((view.highest + (low.min(high) + 0.5 * geometry.beamwidth_rad).tan()).abs() < 1e-3);
    assert!((view.lowest.atan() + steepest).abs() < 1e-3);
    assert_eq!(view.height_m, geometry.mount_height_m);
    let last = geometry.range_m(map.bins() as f32);
    assert!(view.farthest_m < last && view.farthest_m > last - 0.2);
}

#[test]
fn answer_equal_to_the_hypothesis_has_no_conflict() {
    let s = regular(3, 0.7, 0.3, 0.16);
    let answer = [(0.71, 0.165), (0.99, 0.31), (1.31, 0.49)];
    for c in conflicts(&s, &answer, 0.0) {
        assert!(c.probability < 1e-6, "{c:?}");
    }
    assert!(conflicts(&Staircase::nothing(), &[], 0.01).is_empty());
}

#[test]
fn missing_and_false_steps_are_reported_where_they_are() {
    let s = regular(3, 0.7, 0.3, 0.16);
    let sure = |c: &Conflict| c.probability > 0.999;
    // The second step is missing.
    let missing: Vec<_> = conflicts(&s, &[(0.7, 0.16), (1.3, 0.48)], 0.0);
    let at: Vec<f32> = missing.iter().filter(|c| sure(c)).map(|c| c.x_m).collect();
    assert_eq!(at, [s.x(1)]);
    // One step between and one before are false.
    let answer = [
        (0.4, 0.1),
        (0.7, 0.16),
        (0.85, 0.2),
        (1.0, 0.32),
        (1.3, 0.48),
    ];
    let made_up = conflicts(&s, &answer, 0.0);
    let at: Vec<f32> = made_up.iter().filter(|c| sure(c)).map(|c| c.x_m).collect();
    assert_eq!(at, [0.4, 0.85]);
    // Steps more than 10 cm apart are different ones: one missing, one false; the nearest first.
    let apart = conflicts(&regular(1, 1.0, 0.3, 0.16), &[(0.88, 0.16)], 0.0);
    let at: Vec<f32> = apart.iter().filter(|c| sure(c)).map(|c| c.x_m).collect();
    assert_eq!(at, [0.88, 1.0]);
    // On a floor every reported step is false.
    assert_eq!(
        conflicts(&Staircase::nothing(), &[(0.7, 0.1)], 0.0).len(),
        1
    );
}

#[test]
fn three_centimetres_are_the_difference_of_an_exact_answer() {
    let s = regular(1, 1.0, 0.3, 0.16);
    let only = |answer: (f32, f32), sigma_m: f32| {
        let all = conflicts(&s, &[answer], sigma_m);
        assert_eq!(all.len(), 1);
        all[0]
    };
    let near = only((1.0 + MIN_EXPANDED_M - 0.001, 0.16), 0.0);
    let far = only((1.0 - MIN_EXPANDED_M - 0.001, 0.16), 0.0);
    assert!(near.probability < 1e-6 && far.probability == 1.0);
    assert!(
        (far.x_m - 0.969).abs() < 1e-6,
        "where the nearer of both is"
    );
    let low = only((1.0, 0.16 + MIN_EXPANDED_M - 0.002), 0.0);
    let high = only((1.0, 0.16 - MIN_EXPANDED_M - 0.002), 0.0);
    assert!(low.probability < 1e-3 && high.probability > 0.999);
}

#[test]
fn the_expanded_uncertainty_is_the_difference() {
    let s = regular(1, 1.0, 0.3, 0.16);
    // Three standard deviations, between 3 and 8 cm.
    for (sigma_m, within_m) in [(0.005, 0.03), (0.015, 0.045), (0.05, 0.08)] {
        let wrong = |(off_x_m, off_y_m): (f32, f32), sigmas_m| {
            let (distance_sigma_m, height_sigma_m) = sigmas_m;
            let reported = ReportedStep::of(&Step {
                distance_m: 1.0 + off_x_m,
                height_m: 0.16 + off_y_m,
                distance_sigma_m,
                height_sigma_m,
                ..Step::default()
            });
            s.conflicts(&[reported], None, &VIEW, &SURE)[0].probability > 0.5
        };
        for (off_m, so) in [(within_m - 0.002, false), (within_m + 0.002, true)] {
            assert_eq!(wrong((off_m, 0.0), (sigma_m, 0.0)), so, "{sigma_m}");
            assert_eq!(wrong((0.0, -off_m), (0.0, sigma_m)), so, "{sigma_m}");
        }
    }
}

#[test]
fn a_level_that_is_not_known_is_wrong_with_a_probability() {
    let s = regular(1, 1.0, 0.3, 0.16);
    let wrong = |off_m: f32, sigma_m: f32| {
        let all = conflicts(&s, &[(1.0, 0.16 + off_m)], sigma_m);
        all[0].probability
    };
    // Tails of the normal distribution: beyond 2 and 1 sigma on both sides, and one half at the limit.
    for (off_m, sigma_m, p) in [
        (0.0, 0.015, 0.0455),
        (0.0, 0.03, 0.3173),
        (0.03, 0.01, 0.5),
        (-0.02, 0.01, 0.1587),
    ] {
        assert!(
            (wrong(off_m, sigma_m) - p).abs() < 0.02,
            "{off_m} {sigma_m}"
        );
    }
    assert!(wrong(0.0, 0.01) < wrong(0.0, 0.02) && wrong(0.0, 0.02) < wrong(0.01, 0.02));
    // Each step has its own standard deviation.
    let two = regular(2, 0.7, 0.3, 0.16);
    let mut sigmas = SURE;
    sigmas[1] = 0.03;
    let all = two.conflicts(&reported(&[(0.7, 0.16), (1.0, 0.32)]), None, &VIEW, &sigmas);
    assert!(all[0].probability < 1e-6 && all[1].probability > 0.2);
}

#[test]
fn invisible_step_missing_from_the_answer_is_no_conflict() {
    let s = flight(&[(0.5, 0.55), (0.9, 0.6)]);
    // The second step is hidden. It may be unreported, reported at its place, or reported at a wrong height.
    for answer in [
        &[(0.5, 0.55)][..],
        &[(0.5, 0.55), (0.9, 0.6)],
        &[(0.5, 0.55), (0.95, 0.7)],
    ] {
        let all = conflicts(&s, answer, 0.0);
        assert!(all.iter().all(|c| c.probability < 1e-6), "{all:?}");
    }
    // A reported step where there is none is still an error.
    let all = conflicts(&s, &[(0.5, 0.55), (1.2, 0.6)], 0.0);
    assert!(all.iter().any(|c| c.probability == 1.0 && c.x_m == 1.2));
}

#[test]
fn a_drop_contradicts_every_answer() {
    let brink = Staircase::drop(1.4);
    for answer in [&[][..], &[(0.8, 0.1)]] {
        let all = conflicts(&brink, answer, 0.01);
        let at: Vec<f32> = all.iter().map(|c| c.x_m).collect();
        assert_eq!(at.last(), Some(&1.4));
        assert_eq!(at.len(), answer.len() + 1);
        assert!(all.iter().all(|c| c.probability == 1.0));
    }
}

#[test]
fn tread_hidden_by_an_edge_going_down_is_not_visible() {
    let view = View {
        plane: crate::config::Plane::Height,
        height_m: 1.0,
        lowest: -0.3,
        highest: 1.0,
        farthest_m: 2.6,
    };
    let seen = |edges: &[(f32, f32)]| -> std::vec::Vec<bool> {
        let s = Staircase::descent(edges.iter().copied());
        s.edges(&view).map(|e| e.seen).collect()
    };
    assert_eq!(
        seen(&[(-0.1, -0.17), (0.2, -0.34), (0.5, -0.51)]),
        [true; 3]
    );
    // Behind the scanned sector, and ahead of it.
    assert_eq!(seen(&[(-0.5, -0.17), (2.0, -0.34)]), [false; 2]);
    // The tread below the first edge ends before the sight line over that edge reaches it.
    assert_eq!(seen(&[(0.5, -0.6), (0.7, -0.9)]), [false, true]);
}
