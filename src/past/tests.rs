use super::*;
use crate::config::Config;
use crate::model::Staircase;
use crate::model::cloud::CELLS;
use crate::params::Params;

const VIEW: View = View {
    plane: crate::config::Plane::Depth,
    height_m: 0.4,
    lowest: -1.0,
    highest: 0.35,
    farthest_m: 2.6,
};

/// Returns scan `number` of a standing chair, `moved_m` after the scan before, with the default instrument.
fn new(number: u32, moved_m: Option<f32>) -> NewScan {
    let config = Config::default();
    NewScan {
        number,
        mount: config.mount,
        radar: config.radar,
        view: VIEW,
        moved_m,
        moved_during_scan_m: 0.0,
    }
}

/// A flight of three steps that begins `x_m` metres from the mirror.
fn flight(x_m: f32) -> Staircase {
    let mut s = Staircase::nothing();
    for k in 0..3_u8 {
        let number = f32::from(k);
        s = s.with(usize::from(k), x_m + 0.28 * number, 0.17 * (number + 1.0));
    }
    s
}

fn steps(x_m: f32, sigma_m: f32) -> [Step; 3] {
    [0.0, 1.0, 2.0].map(|k| Step {
        distance_m: x_m + 0.28 * k,
        height_m: 0.17 * (k + 1.0),
        distance_sigma_m: 0.003,
        height_sigma_m: sigma_m,
        ..Step::default()
    })
}

/// The outlines of a scan that shows the flight at `x_m`, metres, with their log-weights: the flight, and level ground.
fn outlines(x_m: f32) -> [Weighed; 2] {
    [(flight(x_m), 5.0), (Staircase::nothing(), -20.0)].map(|(staircase, log_weight)| Weighed {
        staircase,
        log_weight,
    })
}

/// Runs scan `number` of the flight at `x_m`, metres, `moved_m` after the scan before, and returns its combined steps.
fn scan(memory: &mut History, number: u32, x_m: f32, moved_m: Option<f32>) -> [Step; 3] {
    memory.begin(&new(number, moved_m));
    memory.keep(&outlines(x_m));
    let mut steps = steps(x_m, 0.01);
    memory.combine(&mut steps);
    steps
}

#[test]
fn first_scan_is_not_changed() {
    let mut memory = History::default();
    let reported = scan(&mut memory, 1, 1.2, None);
    assert_eq!(reported, steps(1.2, 0.01));
    assert!(memory.is_empty() && !memory.confirms_motion() && !memory.changed());
    assert_eq!(memory.carried_odds.features(12, -3.0, None, true), None);
}

#[test]
fn steps_of_earlier_scans_are_moved_by_the_displacement() {
    let mut memory = History::default();
    scan(&mut memory, 1, 1.2, None);
    let reported = scan(&mut memory, 2, 1.1, Some(0.1));
    assert!(memory.confirms_motion());
    assert_eq!(memory.hypotheses.log_prior(&flight(1.1)), 0.0);
    let worst = -Params::DEFAULT.carried_most_nats;
    assert_eq!(memory.hypotheses.log_prior(&flight(1.2)), worst);
    assert_eq!(memory.hypotheses.log_prior(&Staircase::nothing()), worst);
    for (reported, alone) in reported.iter().zip(&steps(1.1, 0.01)) {
        assert!((reported.distance_m - alone.distance_m).abs() < 1e-4);
        // The height's standard deviation is below that of one scan and above that of two independent ones.
        assert!(reported.height_sigma_m < 0.0099 && reported.height_sigma_m > 0.0071);
        // The distance's standard deviation is that of one scan.
        assert!((reported.distance_sigma_m - 0.003).abs() < 1e-5);
    }
}

#[test]
fn step_out_of_earlier_view_has_log_prior_zero() {
    let mut memory = History::default();
    scan(&mut memory, 1, 2.0, None);
    memory.begin(&new(2, Some(0.2)));
    // The third step came into view in this scan; a fourth is not in view yet.
    let more = flight(1.8).with(3, 2.64, 0.68);
    assert_eq!(memory.hypotheses.log_prior(&more), 0.0);
    assert_eq!(memory.hypotheses.log_prior(&flight(1.8)), 0.0);
}

#[test]
fn evidence_is_discarded_where_the_displacement_is_unknown() {
    for (number, moved_m) in [(2, None), (3, Some(0.1))] {
        let mut memory = History::default();
        scan(&mut memory, 1, 1.2, None);
        let reported = scan(&mut memory, number, 1.1, moved_m);
        assert_eq!(reported, steps(1.1, 0.01), "{number} {moved_m:?}");
        assert!(memory.is_empty());
    }
    let mut memory = History::default();
    scan(&mut memory, 1, 1.2, None);
    let mut other = new(2, Some(0.1));
    other.mount.mount_height += 100;
    memory.begin(&other);
    assert!(memory.is_empty());
}

#[test]
fn an_odometer_that_stands_still_is_not_confirmed() {
    let mut memory = History::default();
    scan(&mut memory, 1, 1.2, None);
    for (k, x_m) in (2..).zip([1.16, 1.12, 1.08]) {
        scan(&mut memory, k, x_m, Some(0.0));
        assert!(!memory.confirms_motion(), "{x_m}");
    }
}

#[test]
fn five_scans_from_one_place_are_little_surer_than_one() {
    let mut memory = History::default();
    scan(&mut memory, 1, 1.2, None);
    let mut last = 0.01;
    for number in 2..=5 {
        let reported = scan(&mut memory, number, 1.2, Some(0.0));
        assert!(reported[2].height_sigma_m <= last);
        last = reported[2].height_sigma_m;
    }
    assert!(last > 0.005, "{last}");
}

#[test]
fn readings_that_disagree_make_no_one_surer() {
    let mut memory = History::default();
    scan(&mut memory, 1, 1.2, None);
    memory.begin(&new(2, Some(0.1)));
    let mut reported = steps(1.1, 0.01);
    reported[1].height_m += 0.05;
    memory.combine(&mut reported);
    assert!(
        reported[1].height_sigma_m > 0.012,
        "{}",
        reported[1].height_sigma_m
    );
    assert!(!memory.confirms_motion());
}

#[test]
fn a_contradicted_memory_is_a_first_scan() {
    let mut memory = History::default();
    scan(&mut memory, 1, 1.2, None);
    memory.begin(&new(2, Some(0.1)));
    memory.keep(&outlines(1.4));
    assert!(memory.changed() && memory.is_empty());
    let mut reported = steps(1.1, 0.01);
    memory.combine(&mut reported);
    assert_eq!(reported, steps(1.1, 0.01));
    assert_eq!(memory.carried_odds.features(12, -3.0, None, true), None);
}

#[test]
fn cell_counts_the_earlier_scans_that_agree() {
    let mut memory = History::default();
    scan(&mut memory, 1, 1.2, None);
    for k in 0..CELLS {
        memory.carried_odds.features(k, -4.0, None, true);
    }
    scan(&mut memory, 2, 1.1, Some(0.1));
    let known = memory.carried_odds.features(10, -1.0, None, true).unwrap();
    let [unseen, _, seen, _, least, mean, scans, differs, ..] = known;
    assert_eq!((unseen, seen, scans, differs), (0.0, 1.0, 1.0, 0.0));
    assert!((least + 4.0).abs() < 0.1 && (mean + 4.0).abs() < 0.1);
}

#[test]
fn contradicted_evidence_is_not_kept_in_the_log_weights() {
    let mut memory = History::default();
    scan(&mut memory, 1, 1.2, None);
    memory.begin(&new(2, Some(0.1)));
    let like_before = Weighed {
        log_weight: -8.5,
        ..outlines(1.1)[0]
    };
    let other = Weighed {
        log_weight: 0.0,
        ..outlines(1.4)[0]
    };
    memory.keep(&[other, like_before]);
    assert!(memory.changed() && memory.is_empty());
    memory.begin(&new(3, Some(0.0)));
    let word = memory.hypotheses.log_prior(&like_before.staircase);
    let alone = math::max(
        Params::DEFAULT.carried_share * like_before.log_weight,
        -Params::DEFAULT.carried_most_nats,
    );
    assert!((word - alone).abs() < 1e-5, "{word} {alone}");
}
