//! Keys and values, what is refused, and which grids fit the map.

use super::*;

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

fn bins(settings: &Settings) -> u16 {
    let config = &settings.config;
    BinWindow::new(&config.radar, &config.mount, &config.cfar).count
}

#[test]
fn every_grid_of_as_many_cells_as_the_map_has_is_accepted() {
    let mut settings = Settings::default();
    let whole = MAX_CELLS / usize::from(bins(&settings));
    settings.set("angle-count", &whole.to_string()).unwrap();
    // More rows leave out the farthest bins, as long as 2 m are left.
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
