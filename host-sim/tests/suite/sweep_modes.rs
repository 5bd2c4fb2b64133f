//! Tests of both sweep modes of the image in the emulator: from the edges of STEP, the timer waits between them,
//! and the triggers.
//!
//! Limits: the emulator's clocks run at other rates than the chip's and than each other, so that waits for TIM5
//! (settling, the chirp's duration, timeouts) are not timed here, and bytes arrive when the host sends them. The
//! duration of moves is given in clocks of the core, as the image's timer counts them from expiry to expiry. The rest of a scan's duration is tested in `src/scanner/sweep/tests`, which run the same
//! state machine over simulated time. Without the chip's target or QEMU the tests report it and pass, except in
//! CI.

use host_sim::commands::timing::ScanTime;
use host_sim::emulate::Session;
use host_sim::emulate::session::Waits;
use host_sim::playback::Playback;
use host_sim::recording::Recording;
use host_sim::scene::Scene;
use stairscan::config::Config;
use stairscan::report::{ScanLine, Sentence};
use stairscan::scanner::pace::{Cruise, RowWork};
use stairscan::scanner::settings::SweepMode;
use stairscan::scanner::step_timer::RESTART;
use stairscan::scanner::{Schedule, Settings};
use stairscan::signal::radar::wire::Wire;

use crate::common::{elf, replayed};

/// Clock frequency of the core without a crystal, Hz.
const CORE_HZ: u32 = 16_000_000;
/// Angle of the home switch, 0.001 degree: near the first row.
const HOME: i32 = 15_000;
/// Speed at which a chirp passes the emulator's port before the mirror is two rows further, microsteps/s.
const SLOW: u32 = 100;
const WIRE: Wire = Wire {
    baud: 1_000_000,
    ahead: true,
    pin: false,
};

/// Returns the clocks that the log does not show of the interval before step `k` of a move.
fn restart(k: usize) -> u64 {
    if k == 0 { 0 } else { u64::from(RESTART) }
}

/// Returns a recording of 41 rows of short chirps.
fn recording() -> Recording {
    let scene = Scene::parse(
        "[radar]\nsamples_per_chirp = 64\nbandwidth_hz = 3.2e9\nsample_rate_hz = 64e3\n\
         [sweep]\nfirst_deg = 20.0\nlast_deg = 30.0\n\
         [[wall]]\nat_m = 1.2\nmaterial = \"concrete\"\n[[floor]]\nmaterial = \"concrete\"\n",
    );
    scene.unwrap().simulate("sector", 5)
}

/// Boots, configures and connects a session with `settings`.
fn start<'a>(
    elf: &std::path::Path,
    playback: &'a Playback<'a>,
    settings: &Settings,
) -> Session<'a> {
    let mut session = Session::boot_timed(elf, playback).unwrap();
    session.configure(settings, Waits::default()).unwrap();
    session.move_switch(HOME).unwrap();
    session.skip_lines();
    session
}

/// Returns a scan's sentences with 0 for the hash of the settings.
fn said(sentences: &[String]) -> Vec<String> {
    let body = |line: &String| match Sentence::parse(line).unwrap() {
        Sentence::Scan(head) => {
            let alike = ScanLine {
                settings: 0,
                ..head
            };
            Sentence::Scan(alike).write().trim_end().to_owned()
        }
        _ => line.clone(),
    };
    sentences.iter().map(body).collect()
}

/// The mirror moves on before the chirp is received, stops at every row's microstep and nowhere else, and its
/// moves take as long as `timing` calculates.
#[test]
fn in_stop_mode_the_mirror_overtakes_the_chirp() {
    let Some(elf) = elf() else { return };
    let recording = recording();
    let playback = Playback::new(&recording, &Config::default()).unwrap();
    let settings = Settings {
        sweep_mode: SweepMode::Stop,
        ..playback.settings()
    };
    let mut session = start(elf, &playback, &settings);
    session.withholds = true;
    session.connect().unwrap();
    let scanned = session.scan().unwrap();
    assert_eq!(said(&scanned), said(&replayed(&recording, 1)[0]));
    let schedule = Schedule::new(&settings.config).unwrap();
    let rows = schedule.rows();
    assert_eq!(session.overtaken, usize::from(rows) - 1, "of {rows} rows");

    // Moves of one row begin and end with the ramp's longest waits. The places between two of them are those
    // where the mirror stopped.
    let ramp = settings.motor.ramp();
    let place = |row: u16| i64::from(schedule.position(row));
    let within: Vec<(i64, u64)> = (session.shaft.steps().iter())
        .copied()
        .skip_while(|(position, _)| *position != place(0))
        .skip(1)
        .take((place(rows - 1) - place(0)) as usize)
        .collect();
    let (mut at, mut total) = (0, 0);
    for row in 1..rows {
        let way = (place(row) - place(row - 1)) as usize;
        for k in 0..way {
            let (position, clocks) = within[at + k];
            assert_eq!(position, place(row - 1) + k as i64 + 1);
            let planned = ramp.interval(k as u32, way as u32, CORE_HZ);
            assert_eq!(
                clocks + restart(k),
                u64::from(planned),
                "step {k} to row {row}"
            );
            total += clocks + restart(k);
        }
        at += way;
    }
    let time = ScanTime::stop(&settings, &schedule, WIRE);
    let (name, moves) = time.parts[0];
    let us = total as f64 / f64::from(CORE_HZ) * 1e6;
    assert!(
        (us / moves as f64 - 1.0).abs() < 0.01,
        "{name}: {us} us, not {moves}"
    );
}

/// The mirror turns through the sector without a pause, forward and backward, the triggers are at their rows'
/// places, and the answers equal those of `replay`.
#[test]
fn a_continuous_sweep_turns_at_constant_speed() {
    let Some(elf) = elf() else { return };
    let recording = recording();
    let playback = Playback::new(&recording, &Config::default()).unwrap();
    let mut settings = Settings {
        sweep_mode: SweepMode::Continuous,
        ..playback.settings()
    };
    settings.motor.speed = SLOW;
    let mut session = start(elf, &playback, &settings);
    session.connect().unwrap();
    let expected = replayed(&recording, 2);
    for expected in &expected {
        assert_eq!(said(&session.scan().unwrap()), said(expected));
    }
    settings.config.radar = playback.radar();
    let schedule = Schedule::new(&settings.config).unwrap();
    let rows = schedule.rows();
    let cruise = Cruise::new(
        &settings,
        &schedule,
        WIRE.row_times(settings.config.radar.samples),
        RowWork::Scan,
    )
    .unwrap();
    assert_eq!(cruise.speed, SLOW);

    // All steps between the first and the last row's triggers have the same duration, in both directions.
    let (low, high) = (schedule.position(0), schedule.position(rows - 1));
    let lead = cruise.lead;
    let inside = i64::from(low - lead)..=i64::from(high + lead);
    let sector = session.shaft.steps().iter();
    let sector: Vec<u64> = sector
        .filter(|(position, _)| inside.contains(position))
        .map(|(_, clocks)| *clocks)
        .collect();
    let wait = u64::from(CORE_HZ / SLOW);
    let once = (high - low + 2 * lead) as usize + 1;
    assert!(sector.len() >= 2 * once - 1, "{} of {once}", sector.len());
    let counted = wait - u64::from(RESTART);
    let other = sector.iter().find(|&&clocks| clocks != counted);
    assert_eq!(other, None, "of {counted} clocks each");
    // Time from row to row: steps times waits, with the chip's clock.
    let row_us =
        f64::from(high - low) / f64::from(rows - 1) * wait as f64 * 1e6 / f64::from(CORE_HZ);
    let planned = f64::from(cruise.period_us);
    assert!(
        (row_us / planned - 1.0).abs() < 0.001,
        "{row_us}, not {planned}"
    );

    // Triggers in their order; the host receives them slightly late.
    let shots = &session.shots[..2 * usize::from(rows)];
    for (k, shot) in shots.iter().enumerate() {
        let k = k as u16;
        let (row, way) = if k < rows {
            (k, 1)
        } else {
            (2 * rows - 1 - k, -1)
        };
        let position = schedule.position(row);
        let printed = stairscan::schedule::shaft_angle(position);
        assert_eq!(shot.trigger.shaft_angle, printed, "trigger {k}");
        let past = way * (shot.position.unwrap() - i64::from(position)) + i64::from(lead);
        assert!(
            (0..35).contains(&past),
            "trigger {k}: {past} microsteps late"
        );
    }
    assert_eq!(session.shaft.idle_pulses(), 0);
}
