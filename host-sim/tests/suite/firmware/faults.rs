//! Faults of radar module, motor, home switch and encoder.

use super::*;

/// Every fault of module and motor gives its status, and the next scan is complete again.
#[test]
fn faults_are_reported_and_pass() {
    let Some(elf) = elf() else { return };
    let recording = thinned(&read("stair_a"));
    let playback = Playback::new(&recording, &Config::default()).unwrap();
    let waits = Waits {
        chirp: 3_000_000,
        configure: 3_000_000,
        ..Waits::default()
    };
    let mut session = Session::boot(elf, &playback).unwrap();
    session.configure(&playback.settings(), waits).unwrap();
    session.move_switch(-25_000).unwrap();
    session.skip_lines();
    session.connect().unwrap();
    let clean = head(&session.scan().unwrap());
    assert!(is_sound(&clean), "{clean:?}");
    // Not earlier: with a short hold the scanner would home continuously without a module.
    session.set("fault-hold", "100000").unwrap();
    for (faults, status, reason, rows) in [
        // Errors that a retry or a sequence number corrects are no losses.
        (
            &[
                "corrupt@5-9x1",
                "lost@12x1",
                "late@3x1",
                "repeat@14-40x1",
                "error@11x2",
            ][..],
            clean.status,
            None,
            0,
        ),
        (
            &["lost@12x3", "corrupt@20-22x3"],
            Status::Degraded,
            Some(Reason::LostRows),
            4,
        ),
        (
            &["error@30-50x3"],
            Status::Fault,
            Some(Reason::ModuleError),
            8,
        ),
        (
            &["corrupt@30-50x3"],
            Status::Fault,
            Some(Reason::LinkSilent),
            8,
        ),
        (&["silent@60"], Status::Fault, Some(Reason::LinkSilent), 8),
    ] {
        let parsed: Vec<Fault> = faults.iter().map(|text| text.parse().unwrap()).collect();
        session.module.set_faults(&parsed);
        let scan = head(&session.scan().unwrap());
        assert_eq!(
            (scan.status, scan.lost_rows),
            (status, rows),
            "{faults:?}: {scan:?}"
        );
        assert!(
            reason.is_none_or(|r| scan.reasons.has(r)),
            "{faults:?}: {scan:?}"
        );
        assert!(status != Status::Fault || scan.steps == 0);
        session.module.set_faults(&[]);
        let after = next_scan(&mut session, scan.scan);
        assert!(is_sound(&after), "after {faults:?}: {after:?}");
    }
    wrong_settings(&mut session);
    stalled(&mut session);
    without_encoder(&mut session);
    let no_reset = session
        .lines
        .iter()
        .filter(|line| line.contains(",BOOT,"))
        .count();
    assert_eq!(no_reset, 1, "all of that without a reset");
}

/// Returns the next numbered scan after number `scan`, not a self-test.
fn next_scan(session: &mut Session<'_>, scan: u32) -> ScanLine {
    for _ in 0..4 {
        let next = head(&session.scan().unwrap());
        if next.scan != 0 {
            assert_eq!(next.scan, scan + 1);
            return next;
        }
    }
    panic!("nothing but failed self-tests: {:?}", session.lines);
}

fn wrong_settings(session: &mut Session<'_>) {
    session.module.set_faults(&["config".parse().unwrap()]);
    // The current scan already has its settings.
    session.scan().unwrap();
    let scan = head(&session.scan().unwrap());
    assert_eq!(scan.status, Status::Fault);
    assert!(scan.reasons.has(Reason::ModuleConfig), "{scan:?}");
    session.module.set_faults(&[]);
    let after = next_scan(session, scan.scan);
    assert!(is_sound(&after), "{after:?}");
}

fn stalled(session: &mut Session<'_>) {
    session.idle(Duration::from_millis(300)).unwrap();
    session.stall(true).unwrap();
    let scan = head(&session.scan().unwrap());
    assert_eq!(scan.status, Status::Fault);
    assert!(scan.reasons.has(Reason::MotorStall), "{scan:?}");
    session.stall(false).unwrap();
    let after = next_scan(session, scan.scan);
    assert!(is_sound(&after), "homed again: {after:?}");
    let homed = session.shots.last().and_then(|shot| shot.position);
    assert_eq!(
        homed,
        session.shaft.position(),
        "and the position is right again"
    );
}

/// The emulator's pins read 0, like shorted wires: every wait for them has a timeout.
fn without_encoder(session: &mut Session<'_>) {
    session.set("encoder", "as5600").unwrap();
    let under_way = head(&session.scan().unwrap());
    let fault = head(&session.scan().unwrap());
    assert_eq!((fault.scan, fault.status), (0, Status::Fault));
    assert!(fault.reasons.has(Reason::EncoderSilent), "{fault:?}");
    session.set("encoder", "none").unwrap();
    let after = next_scan(session, under_way.scan);
    assert!(is_sound(&after), "{after:?}");
}

/// Homing without a switch ends with the driver off; with it, the switch is found.
#[test]
fn a_missing_home_switch_is_a_fault_with_the_driver_off() {
    let Some(elf) = elf() else { return };
    let recording = thinned(&read("empty"));
    let playback = Playback::new(&recording, &Config::default()).unwrap();
    let mut session = Session::boot_without_switch(elf, &playback).unwrap();
    session.set("internal-clock", "on").unwrap();
    session.set("fault-hold", "5000000").unwrap();
    session.skip_lines();
    let scan = head(&session.scan().unwrap());
    assert_eq!((scan.scan, scan.status), (0, Status::Fault));
    assert!(scan.reasons.has(Reason::HomeNotFound));
    session.idle(Duration::from_millis(50)).unwrap();
    assert!(!session.shaft.enabled());
    let turn = stairscan::scanner::MICROSTEPS_PER_TURN as u64;
    assert_eq!(
        session.shaft.pulses(),
        turn,
        "the search is one turn and no more"
    );
    // The emulator's inputs have edges but no level: a constantly pressed switch is not detected.
    session.switch_works = true;
    session.shaft.turn_by_hand(300);
    session
        .configure(&playback.settings(), Waits::default())
        .unwrap();
    session.connect().unwrap();
    let after = next_scan(&mut session, 0);
    assert!(is_sound(&after), "{after:?}");
}
