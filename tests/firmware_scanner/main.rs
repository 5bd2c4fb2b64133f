//! Tests of the scanner's state machine over simulated hardware with fault injection.

mod bench;
mod driver;
mod encoder;
mod guard;
mod planes;
mod settings;

use bench::{Bench, IDENTITY, World};
use stairscan::config::RadarConfig;
use stairscan::report::Sentence;
use stairscan::report::sentence::crc32;
use stairscan::scanner::command::framed;
use stairscan::scanner::seal::ImageState;
use stairscan::scanner::{BoardHealth, BootInfo, Settings};
use stairscan::signal::radar::LinkError;
use stairscan::verdict::{Reason, Reasons, Status};

#[test]
fn starts_by_itself_and_sweeps_both_ways_over_the_same_positions() {
    let mut bench = Bench::new(|_| ());
    let lines = bench.until(|s| matches!(s, Sentence::Scan(_)));
    let hash = Settings::default().hash();
    let boot = "$PSTR,BOOT,1.2.3,abcdef,power-on,hsi-16,3";
    let boot = format!("{boot},{hash:08X},00123456789ABCDEF0123456,,,,,,,*");
    assert!(lines[0].starts_with(&boot), "{lines:?}");
    bench.scan();
    let world = bench.world.0.borrow();
    assert_eq!(world.begun[..2], [1, 2]);
    let forward: Vec<u16> = (0..281).collect();
    assert_eq!(world.rows[..281], forward[..]);
    let backward: Vec<u16> = (0..281).rev().collect();
    assert_eq!(world.rows[281..562], backward[..]);
    let mut back = world.module.get().echoes.triggers[281..562].to_vec();
    back.reverse();
    assert_eq!(world.module.get().echoes.triggers[..281], back[..]);
    assert!(
        !world.row_worked_while_still,
        "a chirp was worked off outside the move"
    );
}

/// With default settings: continuous sweeps, alternately forward and backward.
#[test]
fn by_default_rows_are_triggered_in_passing() {
    let mut bench = Bench::boot(Some(Settings::default()), IDENTITY, |_| ());
    assert_eq!(bench.scan().status, Status::Ok);
    assert_eq!(bench.scan().status, Status::Ok);
    let world = bench.world.0.borrow();
    let forward: Vec<u16> = (0..281).collect();
    let backward: Vec<u16> = (0..281).rev().collect();
    assert_eq!(world.rows[..281], forward[..]);
    assert_eq!(world.rows[281..562], backward[..]);
    drop(world);
    // Lost rows are reported, and not requested again.
    let lost = Some(LinkError::Timeout);
    let mut bench = Bench::boot(Some(Settings::default()), IDENTITY, |w| {
        w.module.get().errors = [None, lost, None].into();
    });
    let scan = bench.scan();
    assert_eq!((scan.status, scan.lost_rows), (Status::Degraded, 1));
    assert_eq!(bench.world.0.borrow().lost, [1]);
}

#[test]
fn a_lost_row_is_reported_and_many_are_a_fault() {
    let lost = Some(LinkError::Timeout);
    // The second row succeeds at the second attempt, the fourth is lost.
    let mut bench =
        Bench::new(|w| w.module.get().errors = [None, lost, None, None, lost, lost, lost].into());
    let scan = bench.scan();
    let degraded = (Status::Degraded, 1, Reasons::NONE.with(Reason::LostRows));
    assert_eq!((scan.status, scan.lost_rows, scan.reasons), degraded);
    assert_eq!(bench.world.0.borrow().lost, [3]);
    let scan = bench.scan();
    assert_eq!((scan.scan, scan.status, scan.lost_rows), (2, Status::Ok, 0));

    // Every third row is lost: never eight consecutive ones, but more than 28.
    let pattern = [lost, lost, lost, None, None];
    let mut bench =
        Bench::new(|w| w.module.get().errors = pattern.into_iter().cycle().take(500).collect());
    let scan = bench.scan();
    assert_eq!((scan.status, scan.lost_rows), (Status::Fault, 29));
    assert!(scan.reasons.has(Reason::TooManyLost));
    assert!(
        !bench.world.0.borrow().enabled,
        "the driver stays off in a fault"
    );
    bench.world.0.borrow().module.get().errors.clear();
    assert_eq!(bench.scan().status, Status::Ok);
}

#[test]
fn a_link_that_falls_silent_ends_the_scan_and_recovers() {
    for (error, reason) in [
        (LinkError::Timeout, Reason::LinkSilent),
        (LinkError::Sequence, Reason::LinkSilent),
        (LinkError::Module(2), Reason::ModuleError),
    ] {
        let mut bench = Bench::new(|w| w.module.get().errors = vec![Some(error); 24].into());
        let scan = bench.scan();
        assert_eq!(
            (scan.scan, scan.status, scan.lost_rows),
            (1, Status::Fault, 8)
        );
        assert!(scan.reasons.has(reason), "{error:?}");
        let scan = bench.scan();
        assert_eq!((scan.scan, scan.status), (2, Status::Ok));
    }
}

#[test]
fn a_module_that_never_answers_is_scan_0_and_is_asked_again() {
    let mut bench = Bench::new(|w| w.module.get().radar = None);
    let scan = bench.scan();
    assert_eq!((scan.scan, scan.status), (0, Status::Fault));
    assert!(scan.reasons.has(Reason::LinkSilent));
    assert!(!bench.world.0.borrow().enabled);
    assert!(bench.ask("status").starts_with("STAT,fault,hsi-16,0,"));
    bench.world.0.borrow().module.get().radar = Some(RadarConfig::default());
    let scan = bench.scan();
    assert_eq!((scan.scan, scan.status), (1, Status::Ok));
}

#[test]
fn a_module_set_to_something_impossible_is_a_fault_and_commands_still_work() {
    let wrong = RadarConfig {
        samples: 257,
        ..RadarConfig::default()
    };
    let mut bench = Bench::new(|w| w.module.get().radar = Some(wrong));
    let scan = bench.scan();
    assert_eq!((scan.scan, scan.status), (1, Status::Fault));
    assert!(scan.reasons.has(Reason::ModuleConfig));
    assert_eq!(bench.send("set,seed,9"), "CONF,seed,9");
    bench.world.0.borrow().module.get().radar = Some(RadarConfig::default());
    assert_eq!(bench.scan().status, Status::Ok);
}

#[test]
fn motor_and_arithmetic_faults_leave_the_driver_off() {
    type Break = fn(&mut World, bool);
    let cases: [(Break, Reason); 3] = [
        (|w, on| w.stall = on, Reason::MotorStall),
        (|w, on| w.no_home = on, Reason::HomeNotFound),
        (|w, on| w.arithmetic_broken = on, Reason::SelfTest),
    ];
    for (set, reason) in cases {
        let mut bench = Bench::new(|w| set(w, true));
        let scan = bench.scan();
        assert_eq!((scan.scan, scan.status), (0, Status::Fault));
        assert!(scan.reasons.has(reason));
        assert!(!bench.world.0.borrow().enabled);
        set(&mut bench.world.0.borrow_mut(), false);
        assert_eq!(bench.scan().status, Status::Ok);
    }
    let mut bench = Bench::new(|_| ());
    bench.scan();
    bench.world.0.borrow_mut().stall = true;
    let scan = bench.scan();
    assert_eq!((scan.scan, scan.status), (2, Status::Fault));
    assert!(scan.reasons.has(Reason::MotorStall));
    bench.world.0.borrow_mut().stall = false;
    assert_eq!(bench.scan().scan, 3);
}

#[test]
fn commands_answer_during_a_scan_and_the_scan_goes_on() {
    let mut bench = Bench::new(|_| ());
    for _ in 0..200 {
        bench.step();
    }
    assert_eq!(bench.scanner.state(), "scanning");
    assert!(bench.ask("status").starts_with("STAT,scanning,hsi-16,1,"));
    assert_eq!(bench.ask("version"), "CONF,version,1.2.3 abcdef");
    assert_eq!(bench.ask("get,angle-step"), "CONF,angle-step,250");
    assert_eq!(bench.ask("get stack-used"), "CONF,stack-used,4321");
    assert_eq!(bench.send("set,angle-count,100"), "CONF,angle-count,100");
    assert_eq!(bench.ask("scan"), "FAIL,scan,state,idle: stop first");
    assert_eq!(
        bench.ask("selftest"),
        "FAIL,selftest,state,idle: stop first"
    );
    let refused = "FAIL,set,angle-count,3 to 8192 (angles)";
    assert_eq!(bench.send("set,angle-count,9999"), refused);
    // A few more rows reduce the maximum range; this number would leave no range bin at 2 m.
    let refused = "FAIL,set,angle-count,a map of 65536 cells at most";
    assert_eq!(bench.send("set,angle-count,720"), refused);
    assert!(bench.ask("hello").starts_with("FAIL,-,command,"));
    assert!(
        bench
            .ask(&"z".repeat(500))
            .starts_with("FAIL,-,line,at most 96")
    );
    assert!(
        bench
            .ask("\u{1}\u{ff}\u{0}")
            .starts_with("FAIL,-,line,printable")
    );
    assert_eq!(bench.scanner.state(), "scanning");
    bench.scan();
    let rows = |bench: &Bench| bench.world.0.borrow().rows.len();
    assert_eq!(rows(&bench), 281, "the running scan keeps its settings");
    bench.scan();
    assert_eq!(rows(&bench), 381);
}

#[test]
fn a_grid_of_other_rows_is_scanned_whole() {
    let mut bench = Bench::new(|w| w.board.get().stopped = true);
    for set in [
        "cfar-near-margin,40000",
        "first-angle,-20000",
        "angle-count,321",
    ] {
        assert_eq!(bench.send(&format!("set,{set}")), format!("CONF,{set}"));
    }
    bench.ask("start");
    assert_eq!(bench.scan().status, Status::Ok);
    let rows: Vec<u16> = (0..321).collect();
    assert_eq!(bench.world.0.borrow().rows[..321], rows[..]);
}

#[test]
fn listing_is_complete_even_through_a_slow_port() {
    let mut bench = Bench::new(|w| w.board.get().stopped = true);
    bench.type_line("get");
    let lines = bench.until(|s| matches!(s, Sentence::Done { command: "get" }));
    let keys = lines.iter().filter(|l| l.contains(",CONF,")).count();
    assert_eq!(keys, Settings::KEYS.len());
}

#[test]
fn stop_survives_a_reset_and_single_scans_return_to_idle() {
    let mut bench = Bench::new(|_| ());
    bench.scan();
    assert_eq!(bench.ask("stop"), "DONE,stop");
    assert!(bench.world.0.borrow().board.get().stopped);
    let mut bench = Bench::new(|w| w.board.get().stopped = true);
    for _ in 0..1000 {
        bench.step();
    }
    assert_eq!(bench.scanner.state(), "idle");
    assert!(!bench.world.0.borrow().enabled, "nothing moves by itself");
    assert_eq!(bench.ask("selftest"), "DONE,selftest");
    assert_eq!(bench.ask("scan"), "DONE,scan");
    assert_eq!(bench.scan().scan, 1);
    for _ in 0..100 {
        bench.step();
    }
    assert_eq!(bench.scanner.state(), "idle");
    assert_eq!(bench.ask("start"), "DONE,start");
    assert_eq!(bench.scan().scan, 2);
    assert_eq!(bench.scan().scan, 3);
    let body = "PSTC,stop";
    let framed = format!("${body}*{:08X}", crc32(body));
    assert_eq!(bench.ask(&framed), "DONE,stop");
}

#[test]
fn a_failed_self_test_answers_its_command() {
    let mut bench = Bench::new(|w| {
        w.board.get().stopped = true;
        w.no_home = true;
    });
    assert_eq!(
        bench.ask("selftest"),
        "FAIL,selftest,home-not-found,a passed self-test"
    );
    assert_eq!(bench.scan().scan, 0);
    bench.world.0.borrow_mut().no_home = false;
    for _ in 0..5000 {
        bench.step();
    }
    assert_eq!(
        bench.scanner.state(),
        "idle",
        "a stopped scanner does not start by itself"
    );
}

#[test]
fn a_port_that_takes_nothing_stops_neither_scan_nor_watchdog() {
    let mut bench = Bench::new(|w| w.stick_port(true));
    for _ in 0..60_000 {
        bench.step();
    }
    let scans = bench.scanner.scans();
    assert!(scans > 2);
    bench.world.0.borrow_mut().stick_port(false);
    assert_eq!(bench.scan().scan, 1);
}

#[test]
fn stop_switches_the_driver_off_and_the_next_scan_homes() {
    let mut bench = Bench::new(|_| ());
    bench.scan();
    assert!(bench.world.0.borrow().enabled);
    assert_eq!(bench.ask("stop"), "DONE,stop");
    assert!(!bench.world.0.borrow().enabled);
    bench.ask("start");
    assert_eq!(bench.scan().status, Status::Ok);
}

#[test]
fn crashes_that_follow_one_another_end_in_a_fault_until_somebody_starts() {
    let identity = BootInfo {
        cause: Some(Reason::Crash),
        crash_loop: true,
        ..IDENTITY
    };
    let mut bench = Bench::boot(Some(Settings::default()), identity, |_| ());
    let scan = bench.scan();
    assert_eq!((scan.scan, scan.status), (0, Status::Fault));
    let reported = Reasons::NONE.with(Reason::Crash).with(Reason::CrashLoop);
    assert_eq!(scan.reasons, reported);
    for _ in 0..20_000 {
        bench.step();
    }
    assert_eq!((bench.scanner.state(), bench.scanner.scans()), ("fault", 0));
    assert!(!bench.world.0.borrow().enabled);
    assert_eq!(bench.ask("start"), "DONE,start");
    assert_eq!(bench.scan().status, Status::Ok);
    assert!(
        !bench.world.0.borrow().board.get().crashes_cleared,
        "not a minute yet"
    );
    for _ in 0..60_000 {
        bench.step();
    }
    assert!(bench.world.0.borrow().board.get().crashes_cleared);
    // A stopped scanner stays stopped, also in a crash loop.
    let mut bench = Bench::boot(Some(Settings::default()), identity, |w| {
        w.board.get().stopped = true
    });
    for _ in 0..100 {
        bench.step();
    }
    assert_eq!(bench.scanner.state(), "idle");
}

/// Returns the `LIVE`s of the next `ms` milliseconds.
fn live(bench: &mut Bench, ms: u32) -> Vec<String> {
    bench.take_lines();
    (0..ms).for_each(|_| bench.step());
    let lines = bench.take_lines();
    lines.into_iter().filter(|l| l.contains(",LIVE,")).collect()
}

#[test]
fn live_comes_five_times_a_second_in_every_state() {
    let mut bench = Bench::new(|w| w.board.get().stopped = true);
    for (command, state) in [("stop", "idle"), ("start", "scanning")] {
        bench.ask(command);
        (0..500).for_each(|_| bench.step());
        let reported = live(&mut bench, 1000);
        assert_eq!(reported.len(), 5, "{reported:?}");
        for line in &reported {
            assert!(line.contains(&format!(",LIVE,{state},")), "{line}");
        }
    }
    let mut bench = Bench::new(|w| w.module.get().radar = None);
    assert_eq!(bench.scan().status, Status::Fault);
    let reported = live(&mut bench, 1000);
    assert_eq!(reported.len(), 5, "{reported:?}");
    let Ok(Sentence::Live(first)) = Sentence::parse(&reported[0]) else {
        panic!("{reported:?}");
    };
    assert_eq!((first.state, first.scan, first.age_ms), ("fault", 0, None));
    assert!(first.link_errors > 0 && first.uptime_ms > 1000);
}

#[test]
fn live_tells_the_age_of_the_answer_and_what_went_wrong() {
    let lost = Some(LinkError::Timeout);
    let mut bench = Bench::new(|w| w.module.get().errors = [None, lost, None, lost].into());
    bench.scan();
    bench.ask("hello");
    bench.ask("stop");
    (0..300).for_each(|_| bench.step());
    let reported = live(&mut bench, 1000);
    let parsed = reported.iter().map(|line| match Sentence::parse(line) {
        Ok(Sentence::Live(live)) => live,
        other => panic!("{other:?}"),
    });
    let parsed: Vec<_> = parsed.collect();
    for pair in parsed.windows(2) {
        assert_eq!(pair[1].uptime_ms - pair[0].uptime_ms, 200);
        assert_eq!(pair[1].age_ms.unwrap() - pair[0].age_ms.unwrap(), 200);
    }
    let last = parsed.last().unwrap();
    assert!((1200..2500).contains(&last.age_ms.unwrap()), "{last:?}");
    assert_eq!((last.refused, last.link_errors, last.scan), (1, 2, 2));
    assert_eq!((last.motion, last.motion_faults), ("absent", 0));
}

#[test]
fn a_stuck_port_is_owed_one_live_at_most() {
    let mut bench = Bench::new(|w| {
        w.board.get().stopped = true;
        w.stick_port(true);
    });
    (0..10_000).for_each(|_| bench.step());
    bench.world.0.borrow_mut().stick_port(false);
    let reported = live(&mut bench, 100);
    assert!(reported.len() <= 1, "{reported:?}");
}

/// A fault of processor, memory or supply is reported repeatedly, and nothing moves.
#[test]
fn an_unfit_board_never_scans() {
    type Defect = fn(&mut BoardHealth);
    let defects: [(Reason, Defect); 4] = [
        (Reason::ImageDamaged, |f| f.image = ImageState::Damaged),
        (Reason::MemoryDamaged, |f| f.memory_damaged = true),
        (Reason::Supply, |f| f.supply_low = true),
        (Reason::InternalClock, |f| f.internal_clock = true),
    ];
    for (reason, defect) in defects {
        let mut health = BoardHealth::GOOD;
        defect(&mut health);
        let identity = BootInfo { health, ..IDENTITY };
        let mut bench = Bench::boot(Some(Settings::default()), identity, |_| ());
        for _ in 0..2 {
            let scan = bench.scan();
            assert_eq!((scan.scan, scan.status), (0, Status::Fault), "{reason:?}");
            assert!(scan.reasons.has(reason), "{scan:?}");
        }
        assert_eq!(bench.ask("stop"), "DONE,stop");
        let refused = bench.ask("selftest");
        let expected = format!("FAIL,selftest,{},", reason.as_str());
        assert!(refused.starts_with(&expected), "{refused}");
        assert!(
            bench
                .world
                .0
                .borrow()
                .module
                .get()
                .echoes
                .triggers
                .is_empty()
        );
        assert!(!bench.world.0.borrow().enabled);
    }
}

/// The internal oscillator is accepted while a setting allows it.
#[test]
fn the_internal_oscillator_is_allowed_by_a_setting() {
    let identity = BootInfo {
        health: BoardHealth {
            internal_clock: true,
            ..BoardHealth::GOOD
        },
        ..IDENTITY
    };
    let mut settings = Settings::default();
    settings.set("internal-clock", "on").unwrap();
    let mut bench = Bench::boot(Some(settings), identity, |_| ());
    assert_eq!(bench.scan().status, Status::Ok);
    let off = framed(&["set", "internal-clock", "off"]);
    bench.ask(off.trim_end());
    let scans = (0..3).map(|_| bench.scan());
    let last = scans.last().unwrap();
    assert!(last.reasons.has(Reason::InternalClock), "{last:?}");
}

#[test]
fn an_unsealed_image_is_never_ok() {
    let identity = BootInfo {
        health: BoardHealth {
            image: ImageState::Blank,
            ..BoardHealth::GOOD
        },
        ..IDENTITY
    };
    let mut bench = Bench::boot(Some(Settings::default()), identity, |_| ());
    let scan = bench.scan();
    assert_eq!((scan.scan, scan.status), (1, Status::Degraded));
    assert!(scan.reasons.has(Reason::ImageUnsealed));
}
