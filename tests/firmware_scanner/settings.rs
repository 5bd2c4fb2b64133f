//! Tests of settings over commands, resets and a flash: validation and persistence.

use stairscan::estimate::Estimate;
use stairscan::mount::Mounting;
use stairscan::report::Sentence;
use stairscan::scanner::command::framed;
use stairscan::scanner::record::MOUNTING;
use stairscan::scanner::{BootInfo, Settings};
use stairscan::signal::radar::LinkError;
use stairscan::signal::radar::module::{ModuleKind, RequestedSettings};
use stairscan::verdict::{Reason, Reasons, Status};

use super::bench::{Bench, IDENTITY, World};

/// Returns the command of `FAIL,…,crc,send …`, as a user would paste it.
fn offered(answer: &str) -> &str {
    answer.split_once(",crc,send ").expect(answer).1
}

#[test]
fn what_changes_settings_counts_only_inside_a_sentence_which_is_offered() {
    let mut bench = Bench::new(|w| w.board.get().stopped = true);
    let answer = bench.ask("set mount-height 41000");
    let offer = "FAIL,set,crc,send $PSTC,set,mount-height,41000*";
    assert!(answer.starts_with(offer), "{answer}");
    assert_eq!(bench.ask("get,mount-height"), "CONF,mount-height,40000");
    assert_eq!(bench.ask(offered(&answer)), "CONF,mount-height,41000");
    // An invalid command is reported at once.
    assert!(bench.ask("set seed x").starts_with("FAIL,set,seed,"));
    let answer = bench.ask("save");
    assert!(bench.world.0.borrow().board.get().load().is_none());
    assert_eq!(bench.ask(offered(&answer)), "DONE,save");
    assert!(bench.world.0.borrow().board.get().load().is_some());
}

/// `update` counts inside a sentence, and from a standstill; the boards of the host have no boot loader.
#[test]
fn the_boot_loader_is_entered_from_a_standstill_by_a_whole_sentence() {
    let mut bench = Bench::new(|w| w.board.get().stopped = true);
    let answer = bench.ask("update");
    assert!(
        answer.starts_with("FAIL,update,crc,send $PSTC,update*"),
        "{answer}"
    );
    let sentence = offered(&answer).to_owned();
    assert_eq!(
        bench.ask(&sentence),
        "FAIL,update,loader,a chip with a boot loader"
    );
    bench.ask("start");
    assert_eq!(bench.ask(&sentence), "FAIL,update,state,idle: stop first");
}

/// Flips each bit of each character of framed and plain commands, one at a time.
#[test]
fn no_damaged_line_changes_a_setting() {
    let mut bench = Bench::new(|w| w.board.get().stopped = true);
    let before = bench.ask("status");
    let sentence = framed(&["set", "angle-count", "101"]);
    for line in [sentence.trim_end(), "set,angle-count,101", "set seed 1"] {
        for bit in 0..8 * line.len() {
            let mut bytes = line.as_bytes().to_vec();
            bytes[bit / 8] ^= 1 << (bit % 8);
            // A CRC in lower case is valid.
            if bytes.eq_ignore_ascii_case(line.as_bytes()) {
                continue;
            }
            bytes.extend(b"\r\n");
            bench.world.0.borrow().port.get().type_in(bytes);
            for _ in 0..40 {
                bench.step();
            }
            bench.take_lines();
        }
    }
    assert_eq!(bench.ask("status"), before);
}

#[test]
fn without_saved_settings_nothing_is_ok_until_the_mounting_has_come() {
    let mut bench = Bench::boot(None, IDENTITY, |_| ());
    let unconfigured = (Status::Degraded, Reasons::NONE.with(Reason::Unconfigured));
    let scan = bench.scan();
    assert_eq!((scan.status, scan.reasons), unconfigured);
    let settings = Settings::default();
    bench.send("set,seed,1");
    for key in MOUNTING {
        let scan = bench.scan();
        assert_eq!((scan.status, scan.reasons), unconfigured, "before {key}");
        let value = settings.get(key).unwrap();
        bench.send(&format!("set,{key},{value}"));
    }
    // The current scan still has the previous settings.
    bench.scan();
    assert_eq!(bench.scan().status, Status::Ok);
}

#[test]
fn settings_outlive_a_reset_in_mid_scan_if_they_were_saved() {
    let mut bench = Bench::new(|w| w.board.get().stopped = true);
    assert_eq!(
        bench.send("set,mount-height,41000"),
        "CONF,mount-height,41000"
    );
    assert_eq!(bench.send("save"), "DONE,save");
    bench.ask("start");
    let hash = bench.scan().settings;
    for _ in 0..300 {
        bench.step();
    }
    assert_eq!(bench.scanner.state(), "scanning");
    let mut bench = bench.reset();
    let scan = bench.scan();
    assert_eq!((scan.status, scan.settings), (Status::Ok, hash));
    assert_ne!(hash, Settings::default().hash());
}

#[test]
fn settings_that_a_reset_lost_are_reported_again_and_again() {
    let mut bench = Bench::boot(None, IDENTITY, |w| w.board.get().stopped = true);
    let height = |bench: &mut Bench| bench.send("set,mount-height,41000");
    for key in MOUNTING {
        let value = Settings::default().get(key).unwrap();
        bench.send(&format!("set,{key},{value}"));
    }
    assert_eq!(bench.send("save"), "DONE,save");
    height(&mut bench);
    bench.ask("start");
    assert_eq!(bench.scan().status, Status::Ok);
    let lost = bench.scan().settings;
    // Two resets: the first one must not clear the cause of the second.
    let mut bench = bench.reset().reset();
    let scan = bench.scan();
    assert_eq!(scan.status, Status::Degraded);
    assert!(scan.reasons.has(Reason::Unconfigured));
    assert_ne!(scan.settings, lost);
    for key in MOUNTING {
        let value = Settings::default().get(key).unwrap();
        bench.send(&format!("set,{key},{value}"));
    }
    height(&mut bench);
    bench.scan();
    let scan = bench.scan();
    assert_eq!((scan.status, scan.settings), (Status::Ok, lost));
}

#[test]
fn save_is_refused_where_it_would_do_harm_or_cannot_be_done() {
    let mut bench = Bench::boot(None, IDENTITY, |w| w.board.get().stopped = true);
    let answer = bench.send("save");
    assert!(
        answer.starts_with("FAIL,save,plane,to be set first"),
        "{answer}"
    );
    let mut bench = Bench::new(|w| w.board.get().break_flash(true));
    for _ in 0..200 {
        bench.step();
    }
    assert_eq!(bench.send("save"), "FAIL,save,state,idle: stop first");
    bench.ask("stop");
    let expected = "FAIL,save,flash,a responding flash controller";
    assert_eq!(bench.send("save"), expected);
    assert!(bench.ask("save now").starts_with("FAIL,save,arguments"));
}

/// A scan is reported with its own settings, whatever is set meanwhile.
#[test]
fn a_scan_names_its_own_settings() {
    let mut bench = Bench::new(|_| ());
    for _ in 0..200 {
        bench.step();
    }
    assert_eq!(bench.scanner.state(), "scanning");
    bench.send("set,seed,77");
    let status = bench.ask("status");
    let (first, second) = (bench.scan().settings, bench.scan().settings);
    assert_eq!(first, Settings::default().hash());
    assert_ne!(second, first);
    assert!(status.ends_with(&format!(",{second:08X}")), "{status}");
}

/// Result of a calibration: 2 mm lower, 1.25° off.
const FOUND: Mounting = Mounting {
    height_m: Estimate::new(0.398, 1e-3),
    offset_rad: Estimate::new(0.021_816_6, 1e-4),
    scale: Estimate::new(1.0125, 1e-4),
    mirror_echo_m: Estimate::new(0.2205, 1e-4),
    mirror_level_db: -31.25,
    floor_echoes: 9,
};
const CALIBRATE: [&str; 3] = ["calibrate", "1500", "20261122"];

#[test]
fn a_calibration_is_saved_with_its_date_and_the_chip() {
    let mut bench = Bench::new(|w| {
        w.board.get().stopped = true;
        w.mounting = Some(FOUND);
    });
    let answer = bench.ask("calibrate 1500 20261122");
    assert!(answer.starts_with("FAIL,calibrate,crc,send $PSTC,calibrate,1500,20261122*"));
    let home: i32 = bench
        .ask("get,home-angle")
        .split(',')
        .next_back()
        .unwrap()
        .parse()
        .unwrap();
    bench.type_line(offered(&answer));
    let done = bench.until(|s| matches!(s, Sentence::Done { .. }));
    assert!(done.iter().all(|line| !line.contains(",SCAN,")), "{done:?}");
    let mut reported = done.iter().filter(|line| !line.contains(",LIVE,"));
    let scale = reported.next().unwrap();
    assert!(scale.contains("CONF,range-scale,12500*"), "{done:?}");
    let saved = bench.world.0.borrow().board.get().load().unwrap();
    assert_eq!(saved.config.mount.mount_height, 39_800);
    assert_eq!(saved.config.mount.mirror_echo, 22_050);
    assert_eq!(saved.config.mount.mirror_level, -31_250);
    assert_eq!(saved.config.mount.range_scale, 12_500);
    assert_eq!(saved.motor.home_angle, home + 1_250);
    assert_eq!(saved.calibrated.date, 20_261_122);
    assert_eq!(bench.ask("get,mount-height"), "CONF,mount-height,39800");
    assert!(!bench.world.0.borrow().homed, "home is elsewhere now");

    // The same chip accepts them after a reset, another one does not.
    let mut bench = Bench::boot(Some(saved), IDENTITY, |_| ());
    assert_eq!(bench.scan().status, Status::Ok);
    let other = BootInfo {
        serial: [1, 2, 3],
        ..IDENTITY
    };
    let mut bench = Bench::boot(Some(saved), other, |_| ());
    assert!(bench.scan().reasons.has(Reason::Unconfigured));
}

#[test]
fn a_calibration_that_fails_changes_nothing() {
    let line = framed(&CALIBRATE);
    let refused = |prepare: &dyn Fn(&mut World), field: &str| {
        let mut bench = Bench::new(|w| {
            w.board.get().stopped = true;
            w.mounting = Some(FOUND);
            prepare(w);
        });
        let before = bench.ask("status");
        let answer = bench.ask(line.trim_end());
        assert!(
            answer.starts_with(&format!("FAIL,calibrate,{field},")),
            "{answer}"
        );
        let hash = |status: &str| status.split(',').next_back().unwrap().to_owned();
        assert_eq!(hash(&bench.ask("status")), hash(&before), "{field}");
        assert!(bench.world.0.borrow().board.get().load().is_none());
        assert_eq!(
            bench.world.0.borrow().begun.is_empty(),
            field == "self-test"
        );
    };
    refused(&|w| w.mounting = None, "scene");
    refused(&|w| w.board.get().break_flash(true), "flash");
    refused(
        &|w| w.module.get().errors = [Some(LinkError::Timeout); 3].into(),
        "rows",
    );
    refused(&|w| w.arithmetic_broken = true, "self-test");
    // Only while stopped, and only if the mounting is approximately known.
    let mut bench = Bench::new(|w| w.mounting = Some(FOUND));
    let answer = bench.ask(line.trim_end());
    assert!(answer.starts_with("FAIL,calibrate,state,"), "{answer}");
    let mut bench = Bench::boot(None, IDENTITY, |w| w.board.get().stopped = true);
    let answer = bench.ask(line.trim_end());
    assert!(answer.starts_with("FAIL,calibrate,plane,"), "{answer}");
}

/// Settings of the module apply from the next scan on.
#[test]
fn the_module_is_what_the_setting_says() {
    let mut bench = Bench::new(|_| ());
    assert_eq!(bench.scan().status, Status::Ok);
    assert_eq!(
        bench.world.0.borrow().module.get().requested,
        RequestedSettings::DEFAULT
    );
    for (key, value) in [
        ("module-bandwidth", "5500000"),
        ("module-samples", "128"),
        ("link-rate", "2000000"),
        ("trigger-pin", "on"),
        ("module", "bgt60"),
    ] {
        let answer = bench.send(&format!("set,{key},{value}"));
        assert_eq!(answer, format!("CONF,{key},{value}"));
    }
    // The current scan, and the next one.
    bench.scan();
    bench.scan();
    let requested = RequestedSettings {
        kind: ModuleKind::Bgt60,
        bandwidth_khz: 5_500_000,
        samples: 128,
        baud: 2_000_000,
        pin: true,
        chirps: 1,
    };
    assert_eq!(bench.world.0.borrow().module.get().requested, requested);
    let refused = bench.send("set,chirps-per-row,8");
    assert!(refused.starts_with("FAIL,set,chirps-per-row,"), "{refused}");
    bench.send("set,module,pstr");
    assert_eq!(bench.send("set,chirps-per-row,8"), "CONF,chirps-per-row,8");
    bench.scan();
    bench.scan();
    assert_eq!(bench.world.0.borrow().module.get().requested.chirps, 8);
}
