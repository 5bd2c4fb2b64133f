//! Tests of `plane both`: the plane of each scan under various interruptions.

use stairscan::config::{Plane, Planes};
use stairscan::report::{ScanLine, Sentence};
use stairscan::scanner::Settings;
use stairscan::scanner::settings::SweepMode;
use stairscan::signal::radar::LinkError;
use stairscan::verdict::{Reason, Status};

use crate::bench::{Bench, IDENTITY, World};

/// Depth plane, as in a scan's head.
const DEPTH: Option<Plane> = Some(Plane::Depth);
/// Height plane.
const HEIGHT: Option<Plane> = Some(Plane::Height);

/// A scanner of both planes in front of a drop that the height plane detects. With the mirror 40 cm above the ground
/// its reach is 48 cm.
fn bench(prepare: impl FnOnce(&mut World)) -> Bench {
    let mut settings = Settings {
        sweep_mode: SweepMode::Stop,
        ..Settings::default()
    };
    settings.config.mount.plane = Planes::Both;
    Bench::boot(Some(settings), IDENTITY, |w| {
        w.drop_m = Some(0.45);
        prepare(w);
    })
}

/// Runs steps until `count` scans have been reported.
fn scans(bench: &mut Bench, count: usize) -> Vec<ScanLine> {
    (0..count).map(|_| bench.scan()).collect()
}

fn planes(scans: &[ScanLine]) -> Vec<Option<Plane>> {
    scans.iter().map(|scan| scan.plane).collect()
}

#[test]
fn a_drop_is_followed_by_one_scan_in_the_height_plane() {
    let mut bench = bench(|_| ());
    let reported = scans(&mut bench, 4);
    assert_eq!(planes(&reported), [DEPTH, HEIGHT, DEPTH, HEIGHT]);
    let numbers: Vec<u32> = reported.iter().map(|scan| scan.scan).collect();
    assert_eq!(numbers, [1, 2, 3, 4]);
    let world = bench.world.0.borrow();
    let triggers = world.module.get().echoes.triggers.clone();
    let ends = |scan: usize| (triggers[281 * scan], triggers[281 * scan + 280]);
    let near = |(a, b): (i32, i32), wanted: (i32, i32)| {
        assert!(
            (a - wanted.0).abs() < 5 && (b - wanted.1).abs() < 5,
            "{a} {b}"
        );
    };
    // Each scan begins near the end of the other plane's.
    near(ends(0), (-20_000, 50_000));
    near(ends(1), (40_000, 110_000));
    near(ends(2), (50_000, -20_000));
    near(ends(3), (110_000, 40_000));
}

#[test]
fn where_nothing_ends_or_only_far_ahead_every_scan_is_of_the_depth_plane() {
    for drop_m in [None, Some(0.5)] {
        let mut bench = bench(|w| w.drop_m = drop_m);
        assert_eq!(planes(&scans(&mut bench, 3)), [DEPTH; 3], "{drop_m:?}");
    }
}

#[test]
fn a_scanner_of_one_plane_does_not_tell_it() {
    for plane in [Planes::Depth, Planes::Height] {
        let mut settings = Settings::default();
        settings.config.mount.plane = plane;
        let mut bench = Bench::boot(Some(settings), IDENTITY, |w| w.drop_m = Some(0.45));
        assert_eq!(planes(&scans(&mut bench, 2)), [None; 2]);
        assert_eq!(bench.world.0.borrow().planes[1], plane.first());
    }
}

#[test]
fn one_scan_on_command_brings_the_one_that_its_drop_asks_for() {
    let mut bench = bench(|w| w.board.get().stopped = true);
    for first in [1, 3] {
        assert_eq!(bench.ask("scan"), "DONE,scan");
        assert_eq!(planes(&scans(&mut bench, 2)), [DEPTH, HEIGHT]);
        for _ in 0..2_000 {
            bench.step();
        }
        assert_eq!(
            (bench.scanner.state(), bench.scanner.scans()),
            ("idle", first + 1)
        );
    }
}

#[test]
fn stop_and_another_setting_end_it() {
    let mut bench = bench(|_| ());
    bench.scan();
    assert_eq!(bench.ask("stop"), "DONE,stop");
    assert_eq!(bench.ask("start"), "DONE,start");
    assert_eq!(bench.scan().plane, DEPTH);
    // A scan that has begun keeps its plane; the next one has the new setting.
    assert_eq!(bench.send("set,plane,depth"), "CONF,plane,depth");
    let reported = scans(&mut bench, 2);
    assert_eq!(planes(&reported), [HEIGHT, None]);
}

#[test]
fn rows_are_lost_and_faults_hold_as_in_any_scan() {
    let lost = Some(LinkError::Timeout);
    let mut bench = bench(|_| ());
    bench.scan();
    bench.world.0.borrow().module.get().errors = [lost, lost, lost].into();
    let reported = bench.scan();
    assert_eq!((reported.plane, reported.lost_rows), (HEIGHT, 1));
    assert!(reported.reasons.has(Reason::LostRows));
    // A row that succeeds at the second attempt is not lost.
    bench.scan();
    bench.world.0.borrow().module.get().errors = [lost, lost].into();
    let reported = bench.scan();
    assert_eq!((reported.plane, reported.lost_rows), (HEIGHT, 0));
    bench.scan();
    bench.world.0.borrow_mut().stall = true;
    let reported = bench.scan();
    assert_eq!((reported.plane, reported.status), (HEIGHT, Status::Fault));
    bench.world.0.borrow_mut().stall = false;
    // After the self-test the order starts again.
    bench.until(|s| matches!(s, Sentence::Scan(scan) if scan.plane == DEPTH && scan.drops == 1));
}
