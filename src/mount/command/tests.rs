use super::*;
use crate::math::RAD_PER_DEG;
use std::vec::Vec;

const MIRROR: MirrorEcho = MirrorEcho {
    range_m: 0.2205,
    level_db: -30.0,
};

/// True mounting of the scanner in a test.
#[derive(Clone, Copy)]
struct Real {
    height_m: f32,
    offset_rad: f32,
    scale: f32,
}

const REAL: Real = Real {
    height_m: 0.42,
    offset_rad: 1.2 * RAD_PER_DEG,
    scale: 1.01,
};

/// Returns the echo of a point (x, y), metres, as a scanner with the default configuration and the mounting
/// `real` measures it.
fn echo((x, y): (f32, f32), snr_db: f32, real: Real) -> Echo {
    let mirror_m = Config::default().mount.mirror_offset_m();
    let down = real.height_m - y;
    let range = (math::hypot(x, down) + mirror_m) / real.scale - mirror_m;
    Echo {
        snr_db,
        range_m: range,
        angle_rad: math::atan2(down, x) - real.offset_rad,
        width: 1.05,
        angle_sigma_rad: 0.08 * RAD_PER_DEG,
        range_sigma_m: 0.0002,
        ..Echo::default()
    }
}

/// Returns the echoes of ground and wall, each ground echo slightly above or below the ground.
fn scene(wall_m: f32, real: Real) -> Vec<Echo> {
    let mut echoes = vec![
        echo((wall_m, real.height_m), 50.0, real),
        echo((wall_m, 0.0), 48.0, real),
    ];
    for k in 0..8 {
        let rough = if k % 2 == 0 { 0.001 } else { -0.001 };
        let x = 0.35 + (wall_m - 0.55) * k as f32 / 7.0;
        echoes.push(echo((x, rough), 22.0 - k as f32, real));
    }
    echoes
}

fn of(echoes: &[Echo], wall_m: f32) -> Result<Mounting, Refusal> {
    calibrate(echoes, &Config::default(), MIRROR, wall_m, &Params::DEFAULT)
}

#[test]
fn mounting_errors_are_measured() {
    for wall_m in [0.9_f32, 1.5, 2.2] {
        let found = of(&scene(wall_m, REAL), wall_m).unwrap();
        let off = [
            (found.height_m, REAL.height_m, 0.002),
            (found.offset_rad, REAL.offset_rad, 0.1 * RAD_PER_DEG),
            (found.scale, REAL.scale, 0.001),
        ];
        for (estimate, real, within) in off {
            assert!(
                (estimate.value - real).abs() < within,
                "{wall_m}: {estimate:?}, {real}"
            );
            assert!(
                (estimate.value - real).abs() < 4.0 * estimate.sigma(),
                "{estimate:?}"
            );
            assert!(estimate.sigma() < 2.0 * within, "{estimate:?}");
        }
        let echo_m = 0.2205 * found.scale.value;
        assert!((found.mirror_echo_m.value - echo_m).abs() < 1e-6);
        assert_eq!(found.mirror_level_db, -30.0);
        assert!(found.floor_echoes >= 5);
    }
}

#[test]
fn correct_mounting_is_not_changed() {
    let right = Real {
        height_m: 0.4,
        offset_rad: 0.0,
        scale: 1.0,
    };
    let found = of(&scene(1.5, right), 1.5).unwrap();
    assert!((found.height_m.value - 0.4).abs() < 0.001);
    assert!(found.offset_rad.value.abs() < 0.03 * RAD_PER_DEG);
    assert!((found.scale.value - 1.0).abs() < 5e-4);
}

#[test]
fn an_echo_off_the_floor_changes_little() {
    let mut echoes = scene(1.5, REAL);
    echoes.push(echo((0.8, 0.025), 20.0, REAL));
    let found = of(&echoes, 1.5).unwrap();
    assert!(
        (found.height_m.value - REAL.height_m).abs() < 0.003,
        "{found:?}"
    );
}

#[test]
fn scenes_that_do_not_fit_are_refused() {
    let whole = scene(1.5, REAL);
    let without = |part: usize| {
        let mut echoes = whole.clone();
        echoes.remove(part);
        echoes
    };
    let with = |point: (f32, f32), snr_db: f32| [&whole[..], &[echo(point, snr_db, REAL)]].concat();
    let far = |real: Real| scene(1.5, real);
    let steep = Real {
        offset_rad: 7.0 * RAD_PER_DEG,
        ..REAL
    };
    let long = Real {
        scale: 1.08,
        ..REAL
    };
    let high = Real {
        height_m: 0.6,
        ..REAL
    };
    let mut inclined = whole.clone();
    for e in inclined.iter_mut().skip(2) {
        e.angle_rad += 0.01 / e.range_m * if e.range_m > 0.8 { 3.0 } else { -3.0 };
    }
    let refused = [
        (without(0), 1.5, Refusal::NoWall),
        (without(1), 1.5, Refusal::NoFloor),
        (whole[..5].to_vec(), 1.5, Refusal::FewEchoes),
        (with((1.1, REAL.height_m), 40.0), 1.5, Refusal::SeveralWalls),
        (with((0.9, 0.3), 45.0), 1.5, Refusal::Clutter),
        (whole.clone(), 1.2, Refusal::NoWall),
        (whole.clone(), 0.2, Refusal::Distance),
        (whole.clone(), f32::NAN, Refusal::Distance),
        (far(steep), 1.5, Refusal::NoWall),
        (far(long), 1.5, Refusal::NoWall),
        (far(high), 1.5, Refusal::NoFloor),
        (Vec::new(), 1.5, Refusal::NoWall),
    ];
    for (echoes, wall_m, refusal) in refused {
        assert_eq!(of(&echoes, wall_m), Err(refusal));
    }
    let inclined = of(&inclined, 1.5);
    assert!(
        matches!(inclined, Err(Refusal::Misfit | Refusal::FewEchoes)),
        "{inclined:?}"
    );
    let mut config = Config::default();
    config.mount.plane = crate::config::Planes::Height;
    assert_eq!(
        calibrate(&whole, &config, MIRROR, 1.5, &Params::DEFAULT),
        Err(Refusal::Plane)
    );
}

#[test]
fn a_matrix_times_its_inverse_is_the_identity() {
    let a = [[4.0, 1.5, -0.7], [1.5, 3.0, 0.4], [-0.7, 0.4, 2.0]];
    let b = inverse(&a).unwrap();
    for (r, row) in a.iter().enumerate() {
        for c in 0..3 {
            let product: f32 = row.iter().zip(&b).map(|(x, y)| x * y[c]).sum();
            let expected = if r == c { 1.0 } else { 0.0 };
            assert!((product - expected).abs() < 1e-5, "{r}, {c}: {product}");
        }
    }
    assert_eq!(inverse(&[[1.0, 2.0, 3.0]; 3]), None);
}
