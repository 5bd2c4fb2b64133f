use std::path::Path;

use serde_json::Value;

use super::*;
use crate::recording::Recording;
use crate::replay::{self, Options};

/// A recording of the repository.
fn recorded(name: &str) -> Recording {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
    Recording::read(&dir.join(name)).unwrap()
}

/// Its entry.
fn shown(name: &str) -> Entry {
    entry(&recorded(name), &Options::default()).unwrap()
}

/// The data of a page, as its script reads them.
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
    let told = answer.json();
    for key in ["status", "steps", "horizon_m", "confidence", "reasons"] {
        assert_eq!(scan[key], told[key], "{key}");
    }
    assert_eq!(scan["sentences"][0], answer.sentences[0]);
    let map = &scan["map"];
    let cells = map["rows"].as_u64().unwrap() * map["bins"].as_u64().unwrap();
    let text = map["cells"].as_str().unwrap().len() as u64;
    assert_eq!(text, cells.div_ceil(3) * 4, "base64 of a byte a cell");
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
    for reason in stairscan::answer::Reason::ALL {
        let meaning = reason.meaning();
        assert!(meaning.ends_with('.') && meaning.len() > 15, "{meaning}");
    }
}
