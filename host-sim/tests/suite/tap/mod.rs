//! Tests of the tap on the radar link: the bytes between a scanner and its module become a recording, and its replay
//! gives the scanner's sentences.

mod bench;
mod guard;
mod ports;

use host_sim::tap::gather::Part;
use host_sim::tap::scans::Wire;
use stairscan::config::{Config, EstimatorKind};

use bench::{Traffic, read, replayed, scan, tapped};

#[test]
fn replaying_the_tap_gives_the_scanners_sentences() {
    for (name, scans) in [("stair_a", 3), ("descending", 2), ("empty", 1)] {
        let original = read(name);
        let scanned = scan(&original, &Config::default(), scans, &[]);
        let (parts, notes, tap) = tapped(&scanned, &scanned.traffic);
        assert_eq!((parts.len(), notes.len()), (1, 0), "{name}: {notes:?}");
        assert_eq!((tap.damaged(), tap.unmatched_count()), (0, 0));
        let test = format!("tap-{name}");
        let (recording, answers) = replayed(&test, &parts[0], &scanned);
        assert_eq!(answers, scanned.answers, "{name}");
        assert_eq!(recording.scans(), scans);
        // The scheduled angles are recovered from the microsteps, and the samples to the last bit.
        let rows = original.chirps();
        assert_eq!(recording.meta.angles_deg[..rows], original.meta.angles_deg);
        assert_eq!(
            recording.samples[..original.samples.len()],
            original.samples
        );
        // Each answer is found for its scan.
        for (k, said) in scanned.answers.iter().enumerate() {
            let next = parts[0].times.get(k + 1).map(|times| times.1);
            let found = scanned.beside.answer(parts[0].times[k].1, next);
            assert_eq!(found, Some(&said[..]));
        }
    }
}

#[test]
fn the_tap_hears_how_many_chirps_a_row_has() {
    let mut original = read("stair_a");
    original.meta.chirps_per_row = Some(8);
    let scanned = scan(&original, &Config::default(), 1, &[]);
    let (parts, _, _) = tapped(&scanned, &scanned.traffic);
    let (recording, answers) = replayed("tap-dwell", &parts[0], &scanned);
    assert_eq!(recording.meta.chirps_per_row, Some(8));
    assert_eq!(answers, scanned.answers);
}

#[test]
fn other_settings_are_learned_from_the_report() {
    let mut base = Config {
        estimator: EstimatorKind::Paper,
        seed: 9,
        ..Config::default()
    };
    base.mount.mirror_echo = 22_100;
    base.mount.mirror_level = -30_000;
    base.mount.range_scale = 10_000;
    let scanned = scan(&read("stair_b"), &base, 1, &[]);
    let (parts, _, _) = tapped(&scanned, &scanned.traffic);
    let (_, answers) = replayed("tap-settings", &parts[0], &scanned);
    assert_eq!(answers, scanned.answers);
}

/// Rows that the scanner lost are missing in the recording, too, and retries are recorded as the scanner used them.
#[test]
fn the_modules_misdeeds_are_heard_as_the_scanner_heard_them() {
    let faults = [
        "lost@10-12x9",
        "corrupt@20x1",
        "repeat@30",
        "late@40",
        "error@50x9",
    ];
    let scanned = scan(&read("stair_a"), &Config::default(), 1, &faults);
    let (parts, notes, _) = tapped(&scanned, &scanned.traffic);
    let (recording, answers) = replayed("tap-misdeeds", &parts[0], &scanned);
    assert_eq!(answers, scanned.answers);
    assert!(
        scanned.answers[0][0].contains("lost-rows"),
        "{:?}",
        scanned.answers[0]
    );
    assert_eq!(recording.chirps(), 281 - 4);
    assert!(notes[0].contains("4 of 281 rows are missing"), "{notes:?}");
}

/// Incomplete data are reported and never replaced.
#[test]
fn what_the_tap_loses_is_missing_and_reported() {
    let scanned = scan(&read("stair_a"), &Config::default(), 3, &[]);
    let chirps = |traffic: &Traffic| -> Vec<usize> {
        let long = |k: &usize| traffic[*k].2.len() > 500;
        (0..traffic.len()).filter(long).collect()
    };
    let mut traffic = scanned.traffic.clone();
    let places = chirps(&traffic);
    // In the second scan one chirp is damaged, one truncated, and one request missing.
    traffic[places[300]].2[400] ^= 1;
    traffic[places[310]].2.truncate(300);
    traffic[places[320] - 1].2.clear();
    let (parts, notes, tap) = tapped(&scanned, &traffic);
    let held: Vec<(usize, usize)> = (parts.iter())
        .map(|part| (part.times.len(), part.recording.chirps()))
        .collect();
    assert_eq!(held, [(1, 281), (1, 278), (1, 281)]);
    assert!(notes[0].contains("2 of 280 rows are missing"), "{notes:?}");
    assert!(tap.damaged() >= 2 && tap.unmatched_count() == 1, "{tap:?}");
    let names: Vec<_> = parts
        .iter()
        .map(|part| part.recording.name.as_str())
        .collect();
    assert_eq!(names, ["tap", "tap-2", "tap-3"]);
    for (k, part) in parts.iter().enumerate() {
        let (recording, answers) = replayed("tap-losses", part, &scanned);
        assert_eq!(answers.len(), 1);
        let lost = answers[0][0].contains("lost-rows");
        assert_eq!(lost, k == 1, "{}", recording.name);
    }
}

#[test]
fn scans_that_were_not_heard_from_end_to_end_are_left_out() {
    let scanned = scan(&read("stair_a"), &Config::default(), 2, &[]);
    // The tap begins during the first scan and ends during the second.
    let some = scanned.traffic[200..900].to_vec();
    let (parts, notes, _) = tapped(&scanned, &some);
    assert!(parts.is_empty());
    assert!(
        notes[0].contains("the recording began within it"),
        "{notes:?}"
    );
    assert!(notes[1].contains("only, of -20° to 50°"), "{notes:?}");
}

/// Two ports are read one after the other, and one port may carry both directions.
#[test]
fn it_does_not_matter_how_the_bytes_arrive() {
    let scanned = scan(&read("stair_a"), &Config::default(), 2, &[]);
    let (expected, _, _) = tapped(&scanned, &scanned.traffic);
    let same = |traffic: &Traffic, what: &str| {
        let (parts, notes, tap) = tapped(&scanned, traffic);
        assert_eq!((parts.len(), notes.len()), (1, 0), "{what}: {notes:?}");
        assert_eq!(tap.unmatched_count(), 0, "{what}");
        assert_eq!(
            parts[0].recording.samples, expected[0].recording.samples,
            "{what}"
        );
        let angles = |part: &Part| part.recording.meta.angles_deg.clone();
        assert_eq!(angles(&parts[0]), angles(&expected[0]), "{what}");
    };
    let mut both = scanned.traffic.clone();
    both.iter_mut().for_each(|(_, wire, _)| *wire = Wire::Both);
    same(&both, "one port");
    // The module's answers are read before the scanner's requests, and three requests late.
    for shift in [-2_i64, 6] {
        let mut order: Vec<(i64, usize)> = (scanned.traffic.iter().enumerate())
            .map(|(k, (_, wire, _))| match wire {
                Wire::FromModule => (k as i64 + shift, k),
                _ => (k as i64, k),
            })
            .collect();
        order.sort();
        let traffic = order
            .iter()
            .map(|(_, k)| scanned.traffic[*k].clone())
            .collect();
        same(&traffic, &format!("answers shifted by {shift}"));
    }
    // In pieces of seven bytes.
    let pieces = scanned.traffic.iter().flat_map(|(at, wire, bytes)| {
        let pieces: Vec<_> = bytes.chunks(7).map(|p| (*at, *wire, p.to_vec())).collect();
        pieces
    });
    same(&pieces.collect(), "pieces");
}
