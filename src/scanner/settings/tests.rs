//! Tests of keys, values and limits, and of the grids that fit the map.

use super::*;
use crate::estimate::Estimate;
use crate::mount::Mounting;
#[cfg(feature = "paper")]
use crate::setting::Effect;

#[test]
fn every_key_reads_back_what_it_says() {
    let mut settings = Settings::default();
    for &key in Settings::KEYS {
        let text = settings.get(key).unwrap();
        let before = settings;
        match settings.set(key, &text) {
            Ok(()) => assert_eq!(settings.get(key).unwrap(), text, "{key}"),
            Err(error) => assert!(key.starts_with("radar-"), "{error}"),
        }
        if key != "cfar-false-alarm" {
            assert_eq!(before, settings, "{key}");
        }
        let error = settings.set(key, "x7").unwrap_err();
        assert_eq!(error.field, key);
    }
    assert_eq!(settings.get("nonsense"), None);
}

#[test]
fn each_key_is_in_the_table_once_with_a_meaning() {
    let mut keys = Vec::new();
    Settings::DEFAULT.see(&mut |row, _| keys.push(row.key));
    assert_eq!(keys, Settings::KEYS);
    keys.sort_unstable();
    keys.dedup();
    assert_eq!(keys.len(), Settings::KEYS.len());
    let mut meanings = 0;
    Settings::meanings(&mut |meaning| meanings += usize::from(!meaning.is_empty()));
    assert_eq!(meanings, Settings::KEYS.len());
}

/// Returns the table of all settings in `docs/user/hardware.md`, made from their rows.
#[cfg(feature = "paper")]
fn table() -> String {
    let mut meanings = Vec::new();
    Settings::meanings(&mut |meaning| meanings.push(meaning.trim().trim_end_matches('.')));
    let mut table =
        "| key | unit | values | default | hash | meaning |\n|---|---|---|---|---|---|\n"
            .to_owned();
    let mut meanings = meanings.iter();
    Settings::DEFAULT.see(&mut |row, value| {
        let values = match row.limits {
            _ if row.effect == Effect::Module => "read only".to_owned(),
            (i64::MIN, _) if row.expected.starts_with("a whole") => String::new(),
            (i64::MIN, _) => row.expected.replace(" or ", ", "),
            (least, most) => format!("{least} to {most}"),
        };
        let hash = match row.effect {
            Effect::Answer => "yes",
            Effect::AnswerUnlessOne => "unless 1",
            Effect::Operation | Effect::Module => "",
        };
        let (key, unit, default, meaning) =
            (row.key, row.unit, value.text(), meanings.next().unwrap());
        table += &format!("| `{key}` | {unit} | {values} | {default} | {hash} | {meaning} |\n");
    });
    table
}

#[test]
#[cfg(feature = "paper")]
fn the_document_has_the_table() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/user/hardware.md");
    let document = std::fs::read_to_string(path).unwrap();
    assert!(
        document.contains(&table()),
        "docs/user/hardware.md needs:\n{}",
        table()
    );
}

#[test]
fn values_at_the_limits_are_taken_and_those_beyond_are_not() {
    Settings::DEFAULT.see(&mut |row, _| {
        let (least, most) = row.limits;
        if least == i64::MIN {
            return;
        }
        let mut value = 0i32;
        for (number, fits) in [
            (least, true),
            (most, true),
            (least - 1, false),
            (most + 1, false),
        ] {
            value.read(&number.to_string()).unwrap();
            assert_eq!(row.check(&value).is_ok(), fits, "{} {number}", row.key);
        }
        for refused in [least - 1, most + 1] {
            let set = Settings::default().set(row.key, &refused.to_string());
            // A billionth above one half rounds to one half in the field's precision.
            let rounded = row.key == "cfar-false-alarm" && refused > most;
            assert_eq!(
                set.err().map(|error| error.field),
                (!rounded).then_some(row.key)
            );
        }
    });
}

fn bins(settings: &Settings) -> u16 {
    let config = &settings.config;
    BinWindow::new(&config.radar, &config.mount, &config.cfar).count
}

#[test]
fn every_grid_of_as_many_cells_as_the_map_has_is_accepted() {
    let mut settings = Settings::default();
    let whole = MAX_CELLS / usize::from(bins(&settings));
    settings.set("angle-count", &whole.to_string()).unwrap();
    // With more rows the farthest bins are left out, as long as 2 m remain.
    let most = (whole..).find(|rows| {
        let rows = settings.set("angle-count", &rows.to_string());
        rows.is_err()
    });
    let most = most.unwrap();
    assert!((whole + 50..2 * whole).contains(&most), "{most}");
    let refused = settings.set("angle-count", &most.to_string());
    assert_eq!(refused.unwrap_err().field, "angle-count");
    // 321 rows of 190 bins.
    settings.set("cfar-near-margin", "40000").unwrap();
    settings.set("angle-count", "321").unwrap();
    assert!(bins(&settings) >= 190, "{}", bins(&settings));
    // The other extreme: 327 degrees, eight bins to a row.
    settings.config.radar.samples = 20;
    settings.config.radar.bandwidth_khz = 2_342_000;
    assert_eq!(bins(&settings), 8);
    settings.set("first-angle", "-164000").unwrap();
    settings.set("angle-step", "40").unwrap();
    settings.set("angle-count", "8192").unwrap();
}

#[test]
fn a_refused_value_changes_nothing() {
    let mut settings = Settings::default();
    let before = settings;
    for (key, value, field) in [
        ("angle-count", "2", "angle-count"),
        ("angle-count", "8193", "angle-count"),
        ("angle-count", "70000", "angle-count"),
        ("first-angle", "169000", "first-angle"),
        ("settle", "5", "settle"),
        ("seed", "-1", "seed"),
        ("plane", "sideways", "plane"),
        ("chirp-timeout", "600000001", "chirp-timeout"),
    ] {
        assert_eq!(settings.set(key, value).unwrap_err().field, field);
        assert_eq!(settings, before);
    }
    settings.set("seed", "4294967295").unwrap();
    settings.set("first-angle", "-15000").unwrap();
    assert_eq!(settings.config.sweep.first_angle, -15_000);
}

#[test]
fn drivers_that_cannot_be_are_refused() {
    let mut settings = Settings::default();
    for (key, value, field) in [
        ("driver", "l298", "driver"),
        ("microsteps-per-turn", "100", "microsteps-per-turn"),
        ("microsteps-per-turn", "51300", "microsteps-per-turn"),
        ("microsteps-per-turn", "25650", "microsteps-per-turn"),
        // In continuous mode, row positions are met within three microsteps.
        ("microsteps-per-turn", "12700", "microsteps-per-turn"),
        ("enable-level", "5", "enable-level"),
        ("stall-level", "both", "stall-level"),
        ("pulse-width", "0", "pulse-width"),
        ("pulse-width", "51", "pulse-width"),
        // Ten microseconds high and ten low are 50,000 steps/s, and the top speed is one turn a second.
        ("pulse-width", "10", "pulse-width"),
        ("enable-wake", "60001", "enable-wake"),
        ("motor-current", "99", "motor-current"),
        ("motor-current", "1768", "motor-current"),
        ("stall-threshold", "256", "stall-threshold"),
    ] {
        let before = settings;
        assert_eq!(
            settings.set(key, value).unwrap_err().field,
            field,
            "{key} {value}"
        );
        assert_eq!(settings, before);
    }
    settings.set("pulse-width", "9").unwrap();
    assert_eq!(
        settings.set("speed", "102400").unwrap_err().field,
        "pulse-width"
    );
    settings.set("microsteps-per-turn", "12800").unwrap();
    settings.set("pulse-width", "10").unwrap();
    settings.set("sweep-mode", "stop").unwrap();
    settings.set("microsteps-per-turn", "3200").unwrap();
    let refused = settings.set("sweep-mode", "continuous");
    assert_eq!(refused.unwrap_err().field, "microsteps-per-turn");
    // A microstep of 0.3 degrees, and rows 0.25 degrees apart.
    let refused = settings.set("microsteps-per-turn", "1200");
    assert_eq!(refused.unwrap_err().field, "microsteps-per-turn");
}

#[test]
fn a_tmc2209_has_halves_of_256_microsteps() {
    let mut settings = Settings::default();
    settings.set("sweep-mode", "stop").unwrap();
    settings.set("driver", "tmc2209").unwrap();
    for (microsteps, halvings) in [(51_200, 0), (25_600, 1), (3_200, 4), (1_600, 5)] {
        settings
            .set("microsteps-per-turn", &microsteps.to_string())
            .unwrap();
        assert_eq!(settings.motor.driver.mres(), Some(halvings));
    }
    let refused = settings.set("microsteps-per-turn", "10000");
    assert_eq!(refused.unwrap_err().field, "microsteps-per-turn");
    settings.set("driver", "step-dir").unwrap();
    settings.set("microsteps-per-turn", "10000").unwrap();
    let refused = settings.set("driver", "tmc2209");
    assert_eq!(refused.unwrap_err().field, "microsteps-per-turn");
}

/// A module whose answers take longer than the timeouts is refused; the error names the timeout to change
/// first.
#[test]
fn a_module_gets_the_time_that_it_needs() {
    let mut settings = Settings::default();
    let refused = |s: &mut Settings| s.set("module", "sirad").unwrap_err().field;
    assert_eq!(refused(&mut settings), "configure-timeout");
    settings.set("configure-timeout", "400000").unwrap();
    assert_eq!(refused(&mut settings), "chirp-timeout");
    settings.set("chirp-timeout", "100000").unwrap();
    settings.set("module", "sirad").unwrap();
    let shorter = settings.set("chirp-timeout", "99999").unwrap_err();
    assert_eq!(shorter.field, "chirp-timeout");
    settings.set("module", "bgt60").unwrap();
    settings.set("chirp-timeout", "50000").unwrap();
}

#[test]
fn several_chirps_per_row_need_a_module_that_adds_them() {
    let mut settings = Settings::default();
    for refused in ["0", "33", "-1", "x"] {
        let error = settings.set("chirps-per-row", refused).unwrap_err();
        assert_eq!(
            error.to_string(),
            "chirps-per-row: expected 1 to 32 (chirps)"
        );
    }
    settings.set("chirps-per-row", "32").unwrap();
    let error = settings.set("module", "bgt60").unwrap_err();
    assert_eq!(
        error.to_string(),
        "chirps-per-row: expected 1: this module's driver cannot add chirps"
    );
    settings.set("chirps-per-row", "1").unwrap();
    for (key, value) in [
        ("configure-timeout", "500000"),
        ("chirp-timeout", "150000"),
        ("module", "sirad"),
    ] {
        settings.set(key, value).unwrap();
    }
    let error = settings.set("chirps-per-row", "2").unwrap_err();
    assert_eq!(error.field, "chirps-per-row");
}

#[test]
fn a_row_is_captured_and_waited_for_as_long_as_its_chirps_take() {
    let mut settings = Settings::default();
    let times = |s: &Settings| (s.capture_us(), s.row_timeout_us());
    assert_eq!(times(&settings), (1_000, 50_000));
    settings.set("chirps-per-row", "16").unwrap();
    assert_eq!(times(&settings), (16_000, 65_000));
    // Of an unknown duration only the timeout is known.
    settings.set("chirp-duration", "0").unwrap();
    assert_eq!(times(&settings), (0, 50_000));
    settings.set("chirp-duration", "1000000").unwrap();
    settings.set("chirp-timeout", "600000000").unwrap();
    settings.set("chirps-per-row", "32").unwrap();
    assert_eq!(times(&settings), (32_000_000, 600_000_000));
}

#[test]
fn a_calibration_sets_the_mounting_and_adds_to_scale_and_home() {
    let mut settings = Settings::default();
    settings.config.mount.range_scale = 10_000;
    settings.motor.home_angle = -2_000;
    settings.calibrate(&Mounting {
        height_m: Estimate::new(0.412, 0.001),
        offset_rad: Estimate::new(0.01, 0.001),
        scale: Estimate::new(1.01, 0.001),
        mirror_echo_m: Estimate::new(0.2215, 0.001),
        mirror_level_db: -21.5,
        floor_echoes: 20,
    });
    let mount = settings.config.mount;
    assert_eq!((mount.mount_height, mount.mirror_echo), (41_200, 22_150));
    assert_eq!(mount.mirror_level, -21_500);
    // 1.01 · 1.01, and 0.01 rad = 0.573°.
    assert_eq!(
        (mount.range_scale, settings.motor.home_angle),
        (20_100, -1_427)
    );
}
