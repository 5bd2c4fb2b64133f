//! Tests that `convergence` prints its figures, and that the particles converge.

use crate::common::sim;
use serde_json::Value;

fn convergence(args: &[&str]) -> String {
    let done = sim(&[&["convergence", "--scans", "1"], args].concat());
    assert_eq!(done.status.code(), Some(0));
    String::from_utf8(done.stdout).unwrap()
}

#[test]
fn particles_converge_the_faster_the_better_they_start() {
    let json = convergence(&["--format", "json"]);
    let rows: Vec<Value> = json
        .lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect();
    let names: Vec<&str> = rows.iter().map(|r| r["spread"].as_str().unwrap()).collect();
    assert_eq!(names, ["uniform", "gmm", "gmm-cfar"]);
    let share = |row: usize, round: usize| rows[row]["shares"][round].as_f64().unwrap();
    for (k, rounds) in [15, 5, 2].into_iter().enumerate() {
        assert_eq!(rows[k]["paper_rounds"].as_u64(), Some(rounds));
        assert_eq!(rows[k]["shares"].as_array().unwrap().len(), 16);
        assert!((0..=15).all(|round| (0.0..=1.0).contains(&share(k, round))));
        assert!(share(k, 15) > share(k, 0));
    }
    // At the start and after two rounds: uniform < modes < modes on the CFAR map.
    assert!(share(0, 0) < share(1, 0));
    assert!(share(0, 2) < share(1, 2) && share(1, 2) < share(2, 2));
    let text = convergence(&["--rounds", "3"]);
    assert!(
        text.contains("GMM, CFAR map") && text.lines().count() > 8,
        "{text}"
    );
}

#[test]
fn nonsense_is_a_usage_error() {
    let done = sim(&["convergence", "--rounds", "0"]);
    assert_eq!(done.status.code(), Some(2));
}
