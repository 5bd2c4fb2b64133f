//! Tests of the capability sheet: its head and shape as committed, and a small one measured.

use host_sim::seeds::Draw;
use serde_json::Value;
use studies::capability::body::Body;
use studies::commands::capability;

use crate::common::study;

/// The published sheet.
const PUBLISHED: &str = include_str!("../../../docs/generated/capability.md");

/// Returns the value of an option in the command that the sheet names.
fn option(name: &str) -> Option<u64> {
    let (_, rest) = PUBLISHED.split_once("Made by `cargo study capability ")?;
    let mut words = rest.split_once('`')?.0.split(' ');
    words.find(|word| *word == name)?;
    words.next()?.parse().ok()
}

/// The sheet takes too long to measure again here. The test checks that it is that of the reporting seeds, with every
/// body, and contains the check of its bounds by a second draw.
#[test]
fn the_published_sheet_is_that_of_the_reporting_seeds() {
    let scenes = option("--scenes").unwrap_or(capability::SCENES);
    let sizes = option("--sizes").unwrap_or(capability::OF_A_SIZE);
    let second = option("--second");
    let heading = capability::heading(Draw::Reporting, [scenes, sizes], second).unwrap();
    assert!(
        PUBLISHED.starts_with(&heading),
        "docs/generated/capability.md was not made by `sh docs/make capability`, whose output begins with:\n{heading}"
    );
    let section = |title: &str| PUBLISHED.lines().filter(|line| *line == title).count();
    for title in [
        "## At a glance",
        "## Smallest rise and drop",
        "## Detection by size",
        "## Detection behind a window with loss",
        "## One condition changed",
        "## Approach",
        "## False alarms on level ground",
        "## Second draw",
        "## Limits",
    ] {
        assert_eq!(section(title), 1, "{title}");
    }
    for body in Body::STANDARD {
        assert!(
            PUBLISHED.contains(&format!("\n| {} |", body.name())),
            "{body:?}"
        );
        let drawing = format!("(capability/{}.svg)", body.kind());
        assert_eq!(PUBLISHED.matches(&drawing).count(), 1, "{body:?}");
    }
    // All rows of a table have as many cells as its head.
    let mut columns = None;
    for line in PUBLISHED.lines() {
        let cells = line.starts_with('|').then(|| line.matches('|').count());
        if let (Some(head), Some(cells)) = (columns, cells) {
            assert_eq!(head, cells, "{line}");
        }
        columns = cells;
    }
}

/// Measures a sheet of one body as JSON, as text and as a page.
#[test]
fn a_small_sheet_has_its_cells_bounds_and_drawing() {
    let dir = std::env::temp_dir().join(format!("stairscan-capability-{}", std::process::id()));
    let (page, plots) = (dir.join("sheet.html"), dir.join("plots"));
    std::fs::create_dir_all(&dir).unwrap();
    let paths = [&page, &plots].map(|path| path.to_str().unwrap());
    let args = [
        "capability",
        "--body",
        "post",
        "--scenes",
        "1",
        "--second",
        "1",
    ];
    let out = study(
        &[
            &args[..],
            &["--format", "json", "-o", paths[0], "--plots", paths[1]],
        ]
        .concat(),
    );
    assert!(out.status.success(), "{out:?}");
    let sheet: Value = serde_json::from_slice(&out.stdout).unwrap();
    let cells = sheet["cells"].as_array().unwrap();
    assert!(cells.len() > 10 && sheet["second"].as_array().unwrap().len() == cells.len());
    for cell in cells {
        let counts = &cell["counts"];
        assert_eq!(
            (&cell["body"], &cell["scenes"]),
            (&"post".into(), &1.into())
        );
        for answers in ["scan", "guard"] {
            assert_eq!(counts[answers]["of"], 1);
            assert!(counts[answers]["detected_lower_95"].as_f64().unwrap() < 0.06);
        }
    }
    let page = std::fs::read_to_string(&page).unwrap();
    let drawing = std::fs::read_to_string(plots.join("post.svg")).unwrap();
    assert!(page.contains("<h1>Capability sheet</h1>") && page.contains(&drawing));
    assert!(page.contains("--draw tuning --scenes 1 --second 1 --body post"));
    let again = study(&[&args[..], &["-o", paths[0]]].concat());
    assert_eq!(
        again.status.code(),
        Some(1),
        "an existing page is not replaced"
    );
    std::fs::remove_dir_all(dir).unwrap();
}
