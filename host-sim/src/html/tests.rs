use std::path::Path;

use serde_json::Value;

use super::*;
use crate::recording::{Recording, TrueStep, Truth};
use crate::replay::{self, Options};

/// Reads a recording of the repository.
fn recorded(name: &str) -> Recording {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
    Recording::read(&dir.join(name)).unwrap()
}

/// Returns the page's entry for a recording of the repository.
fn shown(name: &str) -> Entry {
    entry(&recorded(name), &Options::default()).unwrap()
}

/// Returns the data of a page, parsed as the page's script does.
fn data(page: &str) -> Value {
    let (_, rest) = page.split_once("type=\"application/json\">").unwrap();
    let (data, _) = rest.split_once("</script>").unwrap();
    serde_json::from_str(data).unwrap()
}

#[test]
fn a_page_holds_what_replay_prints() {
    let page = page(vec![shown("stair_a")]).unwrap();
    assert_eq!(data(&page)["revision"], stairscan::REVISION);
    let scan = &data(&page)["recordings"][0]["scans"][0];
    let answer = replay::answer(&recorded("stair_a"), &Options::default()).unwrap();
    let json = answer.json();
    for key in [
        "status",
        "steps",
        "drop",
        "horizon_m",
        "free_m",
        "confidence",
        "reasons",
    ] {
        assert_eq!(scan[key], json[key], "{key}");
    }
    assert_eq!(scan["sentences"][0], answer.sentences[0]);
    let map = &scan["map"];
    let cells = map["rows"].as_u64().unwrap() * map["bins"].as_u64().unwrap();
    let text = map["cells"].as_str().unwrap().len() as u64;
    assert_eq!(text, cells.div_ceil(3) * 4, "base64 of a byte a cell");
    let image = &scan["coherent"];
    let cells = image["rows"].as_u64().unwrap() * map["bins"].as_u64().unwrap();
    let text = image["cells"].as_str().unwrap().len() as u64;
    assert_eq!(text, cells.div_ceil(3) * 4);
    assert!(image["noise_dbfs"].as_f64().unwrap() < -60.0, "{image}");
    assert!(page.len() < 3_000_000);
}

#[test]
fn a_page_asks_no_network_for_anything() {
    let page = page(vec![shown("empty")]).unwrap();
    for foreign in ["http:", "https:", "//cdn", "src=", "@import", "fetch("] {
        assert!(!page.contains(foreign), "{foreign}");
    }
    assert!(!page.contains("{{"), "a place that was not filled");
}

#[test]
fn what_fails_stands_first_and_no_text_ends_the_script() {
    let evil = "</script><script>alert(1)</script>";
    let page = page(vec![
        shown("stair_a"),
        failed(evil, "expected <b>samples</b>"),
    ])
    .unwrap();
    assert_eq!(page.matches("</script>").count(), 2, "data, script");
    let data = data(&page);
    assert_eq!(data["recordings"][0]["name"], evil);
    assert_eq!(data["recordings"][1]["name"], "stair_a");
}

#[test]
fn a_name_is_no_markup() {
    let page = page(vec![failed("<i>", "none")]).unwrap();
    assert!(page.contains("<title>&lt;i&gt; – stairscan</title>"));
}

#[test]
fn every_reason_has_a_meaning() {
    for reason in stairscan::verdict::Reason::ALL {
        let meaning = reason.meaning();
        assert!(meaning.ends_with('.') && meaning.len() > 15, "{meaning}");
    }
}

/// The ground truth shows an edge or a hole, although these are not counted as steps.
#[test]
fn the_truth_has_its_holes() {
    let mut recording = recorded("empty");
    let edge = |distance_m: f64, height_m: f64| TrueStep {
        distance_m,
        height_m,
        snr_db: None,
    };
    recording.meta.truth = Some(Truth {
        direction: "none".to_owned(),
        steps: Vec::new(),
        uncounted: vec![edge(1.5, -0.4), edge(0.8, -0.2)],
        drops: None,
    });
    let entry = entry(&recording, &Options::default()).unwrap();
    let edges = &entry.data["scans"][0]["truth"]["edges"];
    let expected = serde_json::json!([
        {"distance_m": 0.8, "height_m": -0.2},
        {"distance_m": 1.5, "height_m": -0.4},
    ]);
    assert_eq!(*edges, expected);
    let flaws = entry.data["scans"][0]["flaws"].to_string();
    assert!(flaws.contains("the ground ends at 0.80 m"), "{flaws}");
}

#[test]
fn a_rival_is_reported_once_with_score_and_probability() {
    for name in ["stair_a", "stair_b"] {
        let scan = &shown(name).data["scans"][0];
        let rivals = scan["rivals"].as_array().unwrap();
        let winner = rivals.iter().find(|r| r["winner"] == true).unwrap();
        for key in ["score", "probability"] {
            assert!(winner[key].is_number(), "{name}: {key}: {winner}");
        }
        let all = &scan["inspection"];
        let count = |list: &Value| list.as_array().unwrap().len();
        let separate = count(&all["explanations"]) + count(&all["posterior"]["hypotheses"]);
        assert!(rivals.len() < separate, "{name}: {}", rivals.len());
        let sum = |list: &Value| -> f64 {
            let each = list.as_array().unwrap().iter();
            each.filter_map(|r| r["probability"].as_f64()).sum()
        };
        let lost = sum(&all["posterior"]["hypotheses"]) - sum(&scan["rivals"]);
        assert!((0.0..0.2).contains(&lost), "{name}: {lost}");
    }
}

/// Checks the text of the report page's script: no test here runs it.
#[test]
fn the_script_names_what_it_draws() {
    let page = page(vec![shown("stair_a")]).unwrap();
    for words in [
        "s.truth.edges",
        "±2σ of a step",
        "drawDrop(g, s.drop, frame)",
        "DROP at ${cm(s.drop.distance_m)}",
        "\"horizon\"]",
        "beam through the place",
        "beyond its horizon",
        "s.flaws.join",
        "missed (${t.snr_db.toFixed(0)} dB)",
        "@media (max-width: 32rem)",
        "event.pointerType === \"mouse\"",
    ] {
        assert!(page.contains(words), "{words}");
    }
    for words in ["something within the horizon is wrong", "\"seen\""] {
        assert!(!page.contains(words), "{words}");
    }
}
