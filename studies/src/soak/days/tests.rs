//! Tests of the endurance test over simulated days: half a day passes, and each defect is found.

use std::time::Instant as WallClock;

use super::life::{Life, LifeMemory, Run};
use super::*;

/// Returns the failed checks of a run of five hours with `defect`.
fn failures(defect: Defect) -> Vec<String> {
    run(0.2, 3, Some(defect), |_| ()).failures
}

/// Boots a scanner of `run`, compares its settings with those saved before, and saves others.
fn boot(run: &mut Run, mount_height: &str) {
    let mut memory = LifeMemory::new();
    let mut life = Life::new(&mut memory, run, "power-on");
    life.live_until(0, |_| ()).unwrap();
    for words in [
        &["stop"][..],
        &["set", "mount-height", mount_height],
        &["save"],
    ] {
        // Without a mounting `save` is refused.
        life.command(words).unwrap();
    }
    run.active.set("mount-height", mount_height).unwrap();
    run.saved = Some(run.active);
}

#[test]
fn half_a_day_passes() {
    let begun = WallClock::now();
    let summary = days(0.5, 6, |_| ());
    println!(
        "{:.1} s\n{}",
        begun.elapsed().as_secs_f64(),
        summary.table()
    );
    assert_eq!(summary.failures, Vec::<String>::new());
    let [clock, sequence, _] = summary.wraps;
    assert!(clock >= 5 && sequence >= 5, "{clock} {sequence}");
    let counts = &summary.counts;
    assert!(counts.faults > 5 && counts.recovered == counts.faults);
    assert!(counts.scans > 500 && counts.sweeps > 5_000 && summary.saves > 20);
    for gap in &summary.gaps {
        assert!(gap.all > 0 && gap.near_wrap > 0 && gap.near_wrap <= gap.all);
    }
    assert!(summary.erasures.iter().all(|&count| count > 0));
}

#[test]
fn a_clock_that_jumps_is_found() {
    let found = failures(Defect::ClockJumps);
    assert!(found[0].contains("uptime is not"), "{found:?}");
}

#[test]
fn a_byte_that_changes_is_found() {
    let found = failures(Defect::ByteChanges);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("$PSTR"), "{found:?}");
}

#[test]
fn a_loop_that_hangs_is_found() {
    let found = failures(Defect::LoopHangs);
    assert!(
        found.iter().any(|line| line.contains("watchdog")),
        "{found:?}"
    );
    assert!(
        found.iter().any(|line| line.contains("no LIVE")),
        "{found:?}"
    );
}

#[test]
fn a_module_that_falls_silent_is_found() {
    assert!(!failures(Defect::ModuleSilent).is_empty());
}

#[test]
fn a_flash_that_loses_its_content_is_found() {
    let mut run = Run::new(5);
    boot(&mut run, "41000");
    boot(&mut run, "39000");
    assert_eq!(run.watch.failures, Vec::<String>::new());
    run.world.borrow().board.get().flash.lose();
    boot(&mut run, "41000");
    let found = &run.watch.failures;
    assert!(found[0].contains("not the boot sentence"), "{found:?}");
    assert!(
        found
            .iter()
            .any(|line| line.contains("not the value that was saved"))
    );
}

#[test]
fn a_guard_that_is_switched_off_and_on_within_a_sweep_counts_from_one() {
    let mut run = Run::new(6);
    let mut memory = LifeMemory::new();
    let mut life = Life::new(&mut memory, &mut run, "power-on");
    life.live_until(0, |_| ()).unwrap();
    life.run.watch.guard_anew();
    for _ in 0..20 {
        life.command(&["guard", "on"]).unwrap();
        life.run_until(life.now() + 3_050_000);
        life.run.watch.guard_anew();
        life.command(&["guard", "off"]).unwrap();
    }
    assert_eq!(run.watch.failures, Vec::<String>::new());
    assert!(run.watch.counts.sweeps > 100);
}
