use super::*;
use crate::answer::DropEdge;
use crate::drive::Retention;
use crate::motion::{Agreement, Finding};
use crate::scanner::Settings;
use crate::track::{RowPose, Track};
use crate::verdict::{Assessment, Evidence};

/// Returns the configuration of a scanner that sweeps both planes, with its mirror `mount_height` (0.01 mm) above
/// the ground.
fn both(mount_height: i32) -> Config {
    let mut config = Config::default();
    config.mount.plane = Planes::Both;
    config.mount.mount_height = mount_height;
    config
}

/// Returns an outcome that reports a drop at `distance_m` and has `finding` as result of comparing two sweeps.
fn reported(distance_m: f32, finding: Finding) -> Outcome {
    let mut outcome = Outcome::silent();
    outcome.answer.drop = Some(DropEdge {
        distance_m,
        distance_sigma_m: 0.01,
        depth_m: None,
        probability: 0.99,
    });
    let agreement = Agreement {
        finding,
        input: Input::Absent,
    };
    outcome.decide(&Evidence {
        assessment: Some(Assessment {
            echo_found: true,
            ..Assessment::nothing(agreement)
        }),
        ..Evidence::default()
    });
    outcome
}

#[test]
fn only_what_an_answer_asks_for_is_made_in_the_other_plane() {
    for below in [false, true] {
        assert_eq!(plane_of(Planes::Depth, below), Plane::Depth);
        assert_eq!(plane_of(Planes::Height, below), Plane::Height);
    }
    assert_eq!(plane_of(Planes::Both, false), Plane::Depth);
    assert_eq!(plane_of(Planes::Both, true), Plane::Height);
}

#[test]
fn the_height_plane_reaches_to_its_last_beam_or_to_the_end_of_the_range() {
    // Mounted 1.2 m above the ground, last beam 50° from straight down.
    let reach = f64::from(reach_m(&both(120_000)));
    assert!(
        (reach - 1.2 * 50f64.to_radians().tan()).abs() < 1e-5,
        "{reach}"
    );
    // Near the horizontal the beam meets the ground beyond the range, and above it nowhere.
    for count in [421, 481] {
        let mut config = both(120_000);
        (config.sweep.angle_step, config.sweep.angle_count) = (250, count);
        config.sweep.first_angle = -20_000;
        let range = f64::from(range_m(&config));
        let reach = f64::from(reach_m(&config));
        assert!(range > 1.9 && range < 3.0, "{range}");
        assert!((reach.hypot(1.2) - range).abs() < 1e-4, "{reach} {range}");
    }
    // No ground is within the range.
    assert_eq!(reach_m(&both(400_000)), 0.0);
}

/// Compares the reach of the height plane with the table of `docs/user/hardware.md`.
#[test]
fn the_document_says_how_far_the_height_plane_sees() {
    let text = include_str!("../../../docs/user/hardware.md");
    for (first, step, count, row) in [
        (-20_000, 250, 281, "| 110° … 40° | −25° … 115° | "),
        (-20_000, 250, 361, "| 110° … 20° | −25° … 115° | "),
        (-80_000, 500, 281, "| 170° … 30° | −85° … 175° | "),
    ] {
        let reported = text.lines().find(|line| line.contains(row)).unwrap();
        for height in [40_000, 120_000] {
            let mut config = both(height);
            config.sweep.first_angle = first;
            (config.sweep.angle_step, config.sweep.angle_count) = (step, count);
            assert!(check_planes(&config).is_ok());
            let reach = std::format!("| {:.2} m", reach_m(&config));
            assert!(reported.contains(&reach), "{reach}: {reported}");
        }
    }
}

#[test]
fn a_near_drop_before_a_standing_chair_asks_for_it() {
    let config = both(120_000);
    let asks = |distance_m, finding, drive: &Drive<'_>| {
        requests_height_plane(
            &config,
            &reported(distance_m, finding),
            drive,
            &Params::DEFAULT,
        )
    };
    let standing = Drive::STANDING;
    assert!(asks(1.1, Finding::Agreed, &standing));
    assert!(!asks(1.5, Finding::Agreed, &standing), "too far to be seen");
    assert!(!requests_height_plane(
        &config,
        &Outcome::silent(),
        &standing,
        &Params::DEFAULT
    ));
    let auto = Drive {
        mode: Mode::Auto,
        ..standing
    };
    assert!(asks(1.1, Finding::Agreed, &auto));
    assert!(!asks(1.1, Finding::Unconfirmed, &auto), "nobody knows");
    assert!(!asks(1.1, Finding::Moved, &auto));
    let required = Drive {
        mode: Mode::Required,
        ..standing
    };
    assert!(!asks(1.1, Finding::Agreed, &required));
    let late = Drive {
        input: Input::Late,
        ..auto
    };
    assert!(!asks(1.1, Finding::Agreed, &late));
}

#[test]
fn a_chair_that_moves_gets_none() {
    let config = both(120_000);
    for (way_m, stands) in [(0.0, true), (0.2, false)] {
        let mut track = Track::new();
        track.begin(281);
        for row in 0..281 {
            let share = f32::from(row) / 280.0;
            track.add(
                row,
                RowPose {
                    time_s: share,
                    travel_m: share * way_m,
                    pitch_rad: 0.0,
                },
            );
        }
        let drive = Drive {
            mode: Mode::Auto,
            input: Input::Good,
            track: Some(&track),
            memory: Retention::Kept,
            ..Drive::STANDING
        };
        let outcome = reported(1.1, Finding::Agreed);
        assert_eq!(
            requests_height_plane(&config, &outcome, &drive, &Params::DEFAULT),
            stands,
            "{way_m}"
        );
    }
}

#[test]
fn settings_with_which_both_planes_cannot_work_are_refused() {
    let mut settings = Settings::default();
    settings.set("plane", "both").unwrap();
    assert_eq!(settings.get("plane").unwrap(), "both");
    assert_eq!(Settings::from_words(&settings.words()), Some(settings));
    for (key, value, field) in [
        // The height plane's first row would need a shaft angle of 170.25°.
        ("first-angle", "-80250", "first-angle"),
        ("angle-count", "261", "angle-count"),
        ("mount-height", "200000", "mount-height"),
        #[cfg(feature = "paper")]
        ("estimator", "paper", "estimator"),
    ] {
        let mut both = settings;
        let error = both.set(key, value).unwrap_err();
        assert_eq!(error.field, field, "{key}");
        assert!(error.expected.contains("plane both"), "{key}");
        assert_eq!(both, settings);
        // Each plane alone accepts the value.
        both.set("plane", "depth").unwrap();
        both.set(key, value).unwrap();
        assert_eq!(both.set("plane", "both").unwrap_err().field, field);
    }
    // Up to the limit of the shaft.
    settings.set("angle-step", "500").unwrap();
    settings.set("first-angle", "-80000").unwrap();
    assert_eq!(settings.config.sweep.angle(280), 60_000);
}
