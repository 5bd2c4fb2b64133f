//! Tests that `table1` prints its figures as text and as JSON.

use crate::common::study;
use serde_json::Value;

fn table1(args: &[&str]) -> String {
    let done = study(&[&["table1", "--scans", "1"], args].concat());
    assert_eq!(done.status.code(), Some(0));
    String::from_utf8(done.stdout).unwrap()
}

#[test]
fn three_stairs_beside_the_papers_figures() {
    let json = table1(&["--format", "json"]);
    let rows: Vec<Value> = json
        .lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect();
    let names: Vec<&str> = rows.iter().map(|r| r["stair"].as_str().unwrap()).collect();
    assert_eq!(names, ["Stair A", "Stair B", "Stair C"]);
    for row in &rows {
        assert_eq!(row["paper_height_error_cm"].as_array().unwrap().len(), 3);
        assert!(row["exact"].as_u64().unwrap() <= 1);
        let found = row["found"].as_array().unwrap();
        let errors = row["depth_error_cm"].as_array().unwrap();
        for (found, error) in found.iter().zip(errors) {
            assert_eq!(found.as_u64() == Some(0), error.is_null());
            assert!(error.as_f64().is_none_or(|e| (0.0..=10.0).contains(&e)));
        }
    }
    let text = table1(&[]);
    for (row, name) in rows.iter().zip(names) {
        let line = text.lines().find(|l| l.starts_with(name)).unwrap();
        let rate = format!(" {}/1", row["exact"]);
        assert!(line.ends_with(&rate), "{line}: {rate}");
        assert!(
            line.contains(&format!("({})", row["paper_depth_error_cm"][0])),
            "{line}"
        );
    }
}
