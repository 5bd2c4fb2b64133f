//! Tests of the commands on the image: its budgets.

use host_sim::emulate::image;
use host_sim::emulate::tools::Tool;
use serde_json::{Value, json};
use studies::commands::budget;

use crate::common::{Scratch, study, tools};

/// Checks flash, RAM and forbidden symbols; `cargo study budget REC` measures the stack.
#[test]
fn the_image_keeps_its_budgets() {
    if !tools(&[Tool::Target]) {
        return;
    }
    let figures = budget::of_image(&image::build(&[]).unwrap()).unwrap();
    for figure in figures {
        assert!(figure.holds(), "{figure:?}");
    }
    // A build that can panic is detected.
    let provoked = image::Image::read(&image::build(&["provoke"]).unwrap()).unwrap();
    assert!(!provoked.may_panic.is_empty());
}

#[test]
fn bench_refuses_what_the_map_does_not_hold_before_it_runs_anything() {
    let scratch = Scratch::new("study-bench");
    let captures: Vec<Value> = (0..5)
        .map(|k| {
            json!({
                "core:sample_start": 16 * k,
                "core:frequency": 94e9,
                "stairscan:mirror_angle_deg": -1.0 + 0.5 * f64::from(k),
            })
        })
        .collect();
    let bandwidth = json!({"stairscan:bandwidth_hz": 2e12});
    let recording = scratch.damaged(&captures, bandwidth, |_| ());
    let out = study(&["bench", recording.to_str().unwrap()]);
    let message = String::from_utf8(out.stderr).unwrap();
    assert_eq!(out.status.code(), Some(1), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(
        message.contains("bad.sigmf-meta: radar-bandwidth: expected"),
        "{message}"
    );
}

#[test]
fn an_endless_image_is_refused() {
    let out = study(&["budget", "--elf", "/dev/zero"]);
    let message = String::from_utf8(out.stderr).unwrap();
    assert_eq!(out.status.code(), Some(1), "{message}");
    assert!(
        message.contains("/dev/zero: expected a regular file"),
        "{message}"
    );
}
