//! Tests of the measurement model going down on synthetic echoes.

extern crate std;

use super::flights::{NONE, share};
use super::*;
use crate::config::Plane;
use crate::params::measured::MODEL;
use std::boxed::Box;
use std::vec::Vec as List;

const HEIGHT_M: f32 = 1.2;
const RISE_M: f32 = 0.17;
const GOING_M: f32 = 0.29;

fn view() -> View {
    View {
        plane: Plane::Height,
        height_m: HEIGHT_M,
        lowest: -0.3,
        highest: 1.0,
        farthest_m: 2.6,
    }
}

fn echo(x_m: f32, y_m: f32, snr_db: f32) -> Echo {
    let down_m = HEIGHT_M - y_m;
    Echo {
        snr_db,
        range_m: math::hypot(x_m, down_m),
        angle_rad: math::atan2(x_m, down_m),
        x_m,
        y_m,
        width: 1.0,
        angle_sigma_rad: 0.002,
        range_sigma_m: 0.0003,
        native_bin: 0.0,
        phasor: [1.0, 0.0],
    }
}

/// Echoes along treads that end at `edges`, metres from the mirror: every 8 cm where the treads are visible, and at
/// their ends.
fn stairs(edges: &[f32]) -> List<Echo> {
    let mut echoes = List::new();
    let mut from_m = -0.3;
    for k in 0..=edges.len() {
        let y_m = -RISE_M * k as f32;
        let to_m = edges.get(k).copied().unwrap_or(1.1);
        let mut x_m = from_m + 0.005;
        while x_m < to_m {
            echoes.push(echo(x_m, y_m, 15.0));
            x_m += 0.08;
        }
        echoes.push(echo(to_m - 0.005, y_m, 15.0));
        let deeper = (HEIGHT_M - y_m + RISE_M) / (HEIGHT_M - y_m);
        from_m = if to_m < 0.0 { to_m } else { to_m * deeper };
    }
    echoes
}

fn looked(echoes: &[Echo], levels: &[f32]) -> Box<Descending> {
    let mut model = Box::new(Descending::new(&MODEL.treads));
    model.set_echoes(echoes, view());
    let treads: List<_> = levels.iter().map(|y_m| model.tread(*y_m)).collect();
    model.evaluate(&treads);
    model
}

fn levels(count: usize) -> List<f32> {
    (1..=count).map(|k| -RISE_M * k as f32).collect()
}

#[test]
fn edges_lie_where_treads_end_and_the_next_begin() {
    let edges = [-0.10, -0.10 + GOING_M, -0.10 + 2.0 * GOING_M];
    let model = looked(&stairs(&edges), &levels(3));
    for (k, edge) in edges.iter().enumerate() {
        let place = model.place(3, k);
        assert!((place.value - edge).abs() < 0.012, "{k}: {place:?}");
        assert!(place.sigma() < 0.015, "{k}: {place:?}");
    }
}

#[test]
fn irregular_edge_keeps_its_place_with_a_larger_sigma() {
    let edges = [-0.10, -0.10 + GOING_M + 0.05, -0.10 + 2.0 * GOING_M];
    let model = looked(&stairs(&edges), &levels(3));
    let odd = model.place(3, 1);
    assert!((odd.value - edges[1]).abs() < 0.02, "{odd:?}");
    let last = model.place(3, 2);
    assert!((last.value - edges[2]).abs() < 0.02, "{last:?}");
}

#[test]
fn as_many_treads_as_there_are_weigh_most() {
    for count in 1..=3 {
        let edges: List<_> = (0..count).map(|k| -0.05 + GOING_M * k as f32).collect();
        let model = looked(&stairs(&edges), &levels(4));
        let weights: List<_> = (0..=4).map(|n| model.weigh(n).log_weight).collect();
        let most = (0..=4).max_by(|a, b| weights[*a].total_cmp(&weights[*b]));
        assert_eq!(most, Some(count), "{weights:?}");
    }
}

#[test]
fn repeated_evaluation_gives_the_same_weight() {
    let echoes = stairs(&[-0.05, 0.24]);
    let mut model = looked(&echoes, &levels(2));
    let before = (model.weigh(2).log_weight, model.place(2, 1));
    let other = [model.tread(-0.12), model.tread(-0.5)];
    model.evaluate(&other);
    let treads: List<_> = levels(2).iter().map(|y_m| model.tread(*y_m)).collect();
    model.evaluate(&treads);
    assert_eq!((model.weigh(2).log_weight, model.place(2, 1)), before);
}

/// The distance of an edge that nothing shows where the flights have it was not a number.
#[test]
fn an_edge_that_nothing_shows_has_a_distance() {
    for off_m in [0.15, 0.3, 0.45] {
        let mut edges: List<f32> = (0..6).map(|k| -0.25 + 0.19 * k as f32).collect();
        edges[3] += off_m;
        let model = looked(&stairs(&edges), &levels(6));
        for k in 0..6 {
            let place = model.place(6, k);
            assert!(place.value.is_finite() && place.sigma() > 0.0, "{place:?}");
        }
    }
}

#[test]
fn without_echoes_and_of_odd_ones_everything_is_a_number() {
    let odd = [
        echo(0.0, 0.0, f32::NAN),
        echo(f32::NAN, -0.17, 9.0),
        echo(9.0, -40.0, 900.0),
        echo(-9.0, 40.0, -900.0),
    ];
    for echoes in [&[][..], &odd] {
        let model = looked(echoes, &[-0.17, -0.34, 40.0, -900.0]);
        for count in 0..=4 {
            let weighed = model.weigh(count);
            assert!(!weighed.log_weight.is_nan(), "{count} {weighed:?}");
            for k in 0..count {
                let place = model.place(count, k);
                assert!(place.value.is_finite() && place.variance.is_finite());
            }
        }
    }
}

#[test]
fn shares_are_powers_of_e() {
    for (nats, expected) in [(0, 1.0), (-64, (-1.0f32).exp()), (-320, (-5.0f32).exp())] {
        assert!((share(nats) / expected - 1.0).abs() < 1e-4, "{nats}");
    }
    assert_eq!(share(NONE), 0.0);
}
