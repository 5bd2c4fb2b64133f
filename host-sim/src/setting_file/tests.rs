//! Tests of table, units, and invalid files.

use std::collections::BTreeMap;

use stairscan::scanner::Settings;

use super::profile::{self, Profile};
use super::{order, table};

fn defaults() -> BTreeMap<String, String> {
    let settings = Settings::default();
    let values = Settings::KEYS.iter().map(|key| {
        (
            (*key).to_owned(),
            settings.get(key).unwrap().as_str().to_owned(),
        )
    });
    values.collect()
}

fn refused(text: &str) -> String {
    Profile::parse("chair.toml", text).unwrap_err().to_string()
}

#[test]
fn every_setting_is_in_the_table_with_its_default() {
    let keys: Vec<&str> = table::rows().iter().map(|row| row.key).collect();
    assert_eq!(keys, Settings::KEYS);
    let values = defaults();
    for row in table::rows() {
        assert_eq!(row.default, values[row.key], "{}", row.key);
        assert!(!row.meaning.is_empty());
    }
}

#[test]
fn people_s_units_are_written() {
    let spoken = |key: &str, value: &str| table::row(key).unwrap().with_unit(value);
    for (key, value, text) in [
        ("mount-height", "40000", "0.4 m"),
        ("mirror-echo", "22013", "0.22013 m"),
        ("mirror-echo", "0", "never"),
        ("mode-sigma", "100", "1 mm"),
        ("range-scale", "-1234", "-0.1234 %"),
        ("beamwidth", "5000", "5 deg"),
        ("cfar-false-alarm", "170000", "0.017 %"),
        ("vigilance", "500", "0.5"),
        ("radar-carrier", "94000000", "94 GHz"),
        ("settle", "5000", "5 ms"),
        ("pulse-width", "2", "2 us"),
        ("connect-timeout", "10000000", "10 s"),
        ("motor-current", "600", "600 mA"),
        ("motor-current", "1200", "1.2 A"),
        ("speed", "51200", "360 deg/s"),
        ("acceleration", "2560000", "18000 deg/s2"),
        ("encoder-home", "-1", "unknown"),
        ("link-rate", "3000000", "3 Mbaud"),
        ("calibrated", "20261122", "2026-11-22"),
        ("plane", "depth", "depth"),
        ("plane", "both", "both"),
        ("angle-count", "281", "281"),
    ] {
        assert_eq!(spoken(key, value), text, "{key} {value}");
    }
    assert_eq!(table::row("mount-height").unwrap().range(), "0.01 m to 5 m");
    assert_eq!(table::row("plane").unwrap().range(), "depth, height, both");
}

/// A written file sets the same values when it is read: at both limits, at the default and at other
/// values.
#[test]
fn a_file_that_was_written_sets_the_same_values() {
    for row in table::rows()
        .iter()
        .filter(|row| !row.read_only && row.words.is_empty())
    {
        let (least, most) = row.limits.unwrap_or((0, 255));
        let odd = [
            least,
            most,
            least + (most - least) / 3,
            least + (most - least) / 7,
        ];
        for number in odd.into_iter().chain(row.default.parse::<i64>()) {
            if row.key == "calibrated" {
                continue;
            }
            let spoken = row.with_unit(&number.to_string());
            assert_eq!(
                row.unit.parse(row.key, &spoken),
                Ok(number.into()),
                "{} {spoken}",
                row.key
            );
        }
    }
    let values = defaults();
    let text = profile::text(&values, "about");
    let read = Profile::parse("chair.toml", &text).unwrap();
    assert_eq!(read.differences(&values), Vec::<String>::new());
    assert_eq!(
        read.entries.len(),
        Settings::KEYS.len() - 3,
        "but for what the module reports"
    );
    for entry in &read.entries {
        assert_eq!(entry.value, values[entry.row.key]);
    }
    assert!(text.contains("mount-height = \"0.4 m\"\n"), "{text}");
    assert!(text.contains("# 0.01 m to 5 m; default 0.4 m\n"), "{text}");
}

#[test]
fn people_write_units_as_they_like() {
    let parse = |key: &str, text: &str| table::row(key).unwrap().unit.parse(key, text);
    for (key, text, number) in [
        ("mount-height", "40 cm", 40_000),
        ("mount-height", "400mm", 40_000),
        ("mount-height", "0.40 m", 40_000),
        ("first-angle", "-20°", -20_000),
        ("settle", "5000 µs", 5_000),
        ("module-bandwidth", "5337.5 MHz", 5_337_500),
        ("speed", "1 turns/s", 51_200),
        // A value between two microsteps is rounded to the nearest.
        ("speed", "100 deg/s", 14_222),
        ("link-rate", "3_000_000 baud", 3_000_000),
        ("calibrated", "never", 0),
        ("vigilance", "0.25", 250),
    ] {
        assert_eq!(parse(key, text), Ok(number), "{key} {text}");
    }
}

#[test]
fn every_wrong_line_is_named_with_its_value_and_range() {
    let text = "mount-height = 0.4\nmirror-offset = \"9 m\"\n\nplane = \"sideways\"\nretries = 11\nseed = -1\n\
                mount_height = \"1 m\"\nradar-carrier = \"60 GHz\"\nmotion = true\nspeed = \"1 m\"\nbeamwidth = \"5.00001 deg\"\n\
                calibrated = \"yesterday\"\n";
    let message = refused(text);
    for words in [
        "chair.toml:1: mount-height = 0.4: expected a number and its unit (m, cm, mm), such as \"1 m\"; 0.01 m to 5 m",
        "chair.toml:2: mirror-offset = 9 m: expected 0 m to 2 m",
        "chair.toml:4: plane = sideways: expected depth, height, both",
        "chair.toml:5: retries = 11: expected 0 to 10",
        "chair.toml:6: seed = -1: expected a whole number within its type",
        "chair.toml:7: mount_height: no such setting; did you mean mount-height?",
        "chair.toml:8: radar-carrier = 60 GHz: is reported by the radar module",
        "chair.toml:9: motion: expected a number or a string",
        "chair.toml:10: speed = 1 m: expected a number and its unit (deg/s",
        "chair.toml:11: beamwidth = 5.00001 deg: expected a multiple of 0.001 deg",
        "chair.toml:12: calibrated = yesterday: expected a date",
    ] {
        assert!(message.contains(words), "{words} is not in\n{message}");
    }
    assert_eq!(message.lines().count(), 11, "{message}");
    assert!(refused("plane = \"depth\"\nplane = \"height\"\n").starts_with("chair.toml:2:"));
    assert!(refused("plane =\n").starts_with("chair.toml:1:"));
}

/// The scanner would refuse the settings of this file in the order of the file.
#[test]
fn settings_that_only_fit_together_are_put_in_order() {
    let text = "first-angle = \"-100 deg\"\nangle-step = \"1 deg\"\nangle-count = 200\nmodule = \"sirad\"\n\
                configure-timeout = \"500 ms\"\nchirp-timeout = \"150 ms\"\n";
    let profile = Profile::parse("chair.toml", text).unwrap();
    let (changes, wanted) = profile.changes("chair.toml", &defaults()).unwrap();
    assert_eq!(changes.len(), 6);
    let mut scanner = Settings::default();
    for (key, value) in &changes {
        scanner.set(key, value).unwrap();
    }
    assert_eq!(scanner, wanted);
    let profile = Profile::parse("chair.toml", "angle-count = 8000\n").unwrap();
    let message = profile
        .changes("chair.toml", &defaults())
        .unwrap_err()
        .to_string();
    assert!(
        message.starts_with("chair.toml:1: angle-count = 8000: with the other settings, "),
        "{message}"
    );
}

#[test]
fn a_scanner_s_own_settings_are_taken_as_they_are() {
    let mut values = defaults();
    for (key, value) in [
        ("radar-carrier", "60800000"),
        ("radar-bandwidth", "5337500"),
        ("radar-samples", "128"),
    ] {
        values.insert(key.to_owned(), value.to_owned());
    }
    let settings = order::settings_of(&values).unwrap();
    assert_eq!(settings.config.radar.samples, 128);
    values.insert("plane".to_owned(), "sideways".to_owned());
    assert_eq!(order::settings_of(&values).unwrap_err().field, "plane");
}
