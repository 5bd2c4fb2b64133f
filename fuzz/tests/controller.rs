//! Tests of the C parser for the wheelchair's controller: the generated parts are up to date, and it agrees with
//! the scanner's own parser.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use stairscan_fuzz::controller::{directory, page, program, tables, vectors};
use stairscan_replay::limit::{Brakes, FreeAhead, max_speed};

const ANEW: &str = "write it anew: cargo run -p stairscan-fuzz --example controller -- --write";

/// Reports a skipped test; in CI this is a failure.
fn lack(what: &str) {
    let ci = std::env::var_os("CI").is_some_and(|value| value == "true");
    assert!(!ci, "{what}");
    // Not with `eprintln`, whose output the test harness hides for passing tests.
    let _ = writeln!(std::io::stderr(), "SKIPPED {what}");
}

/// Compiles a C source with the parser, with sanitizers if available; `None` without a compiler.
fn compiled(source: &str) -> Option<PathBuf> {
    let Some(compiler) = program::compiler() else {
        lack(&format!(
            "{source} of controller/: no C compiler; install one, or name it in CC"
        ));
        return None;
    };
    // Each test has its own directory, since tests run in parallel.
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("controller").to_owned();
    let into = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    fs::create_dir_all(&into).unwrap();
    let sanitized = program::compile(&compiler, source, &into, true);
    Some(sanitized.unwrap_or_else(|error| {
        lack(&format!("the sanitizers of {source}: {error:#}"));
        program::compile(&compiler, source, &into, false).unwrap()
    }))
}

/// Returns the output of a program for `input`, and whether its exit status was 0.
fn run(program: &Path, arguments: &[&str], input: &str) -> (String, bool) {
    let mut child = Command::new(program)
        .current_dir(directory())
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(input.as_bytes()).unwrap();
    drop(stdin);
    let output = child.wait_with_output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    (String::from_utf8(text).unwrap(), output.status.success())
}

#[test]
fn the_header_s_tables_are_those_of_the_scanner() {
    let header = fs::read_to_string(tables::path()).unwrap();
    assert!(
        header == tables::renewed(&header).unwrap(),
        "stairscan.h: {ANEW}"
    );
}

#[test]
fn the_golden_vectors_are_what_the_scanner_s_parser_says() {
    let held = fs::read_to_string(vectors::path()).unwrap();
    for (held, made) in held.lines().zip(vectors::text().lines()) {
        assert_eq!(held, made, "vectors.tsv: {ANEW}");
    }
    assert!(held == vectors::text(), "vectors.tsv: {ANEW}");
}

#[test]
fn c_holds_the_golden_vectors() {
    let Some(verdict) = compiled("test/verdict.c") else {
        return;
    };
    let (text, content) = run(&verdict, &["vectors.tsv"], "");
    assert!(
        content && text.contains("vectors of vectors.tsv hold"),
        "{text}"
    );
    let changed = Path::new(env!("CARGO_TARGET_TMPDIR")).join("spoilt.tsv");
    let held = fs::read_to_string(vectors::path()).unwrap();
    fs::write(&changed, held.replacen("distance=5005", "distance=5006", 1)).unwrap();
    let (text, content) = run(&verdict, &[changed.to_str().unwrap()], "");
    assert!(!content && text.contains("expected"), "{text}");
}

#[test]
fn c_and_rust_agree_on_mutated_lines() {
    let Some(verdict) = compiled("test/verdict.c") else {
        return;
    };
    let tally = program::agree(&verdict, 100_000, 1).unwrap_or_else(|error| panic!("{error:#}"));
    let seen: BTreeSet<&str> = tally.keys().map(String::as_str).collect();
    let wanted = [
        "SCAN",
        "STEP",
        "DROP",
        "MAYBE",
        "GUARD",
        "BOOT",
        "STAT",
        "LIVE",
        "CONF",
        "DONE",
        "FAIL",
        "HALT",
        "start",
        "stop",
        "scan",
        "guard",
        "watch",
        "status",
        "version",
        "crash?",
        "crash-clear",
        "selftest",
        "save",
        "update",
        "reset",
        "get",
        "set",
        "MOTION",
        "bad frame",
        "bad crc",
        "bad field horizon",
        "bad field ending",
        "bad guard switch",
        "bad field reasons",
        "bad field serial",
        "bad field end",
        "bad - line",
        "bad - command",
        "bad - frame",
        "bad - crc",
        "bad set arguments",
        "bad MOTION travel",
        "bad MOTION pitch",
    ];
    let missing: Vec<&str> = wanted
        .into_iter()
        .filter(|kind| !seen.contains(kind))
        .collect();
    assert!(missing.is_empty(), "never came: {missing:?}");
    let taken: u64 = tally
        .iter()
        .filter(|(kind, _)| !kind.starts_with("bad"))
        .map(|(_, n)| n)
        .sum();
    assert!(taken > 15_000, "only {taken} lines were taken");
}

#[test]
fn the_rules_hold() {
    for source in ["test/rules.c", "test/guard.c"] {
        let Some(rules) = compiled(source) else {
            return;
        };
        let (text, content) = run(&rules, &[], "");
        assert!(content, "{text}");
    }
}

#[test]
fn the_speed_limit_holds() {
    let Some(speed) = compiled("test/speed.c") else {
        return;
    };
    let (text, content) = run(&speed, &[], "");
    assert!(
        content && text.starts_with("the speed limit holds"),
        "{text}"
    );
}

/// The speed limit of simulated drives equals that of the C code.
#[test]
fn the_host_s_speed_limit_is_that_of_c() {
    let Some(limit) = compiled("test/limit.c") else {
        return;
    };
    let mut drawn = 1_u32;
    let mut number = || {
        drawn = drawn.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // Small and large numbers with similar frequency.
        drawn >> (drawn % 29)
    };
    let cases: Vec<[u32; 6]> = (0..20_000)
        .map(|_| core::array::from_fn(|_| number()))
        .collect();
    let line = |case: &[u32; 6]| case.map(|n| n.to_string()).join(" ") + "\n";
    let (text, content) = run(&limit, &[], &cases.iter().map(line).collect::<String>());
    assert!(content && text.lines().count() == cases.len());
    for (case, text) in cases.iter().zip(text.lines()) {
        let [
            free_mm,
            age_ms,
            max_speed_mm_s,
            latency_ms,
            deceleration_mm_s2,
            max_age_ms,
        ] = *case;
        let ground = FreeAhead {
            free_mm,
            age_ms,
            max_speed_mm_s,
        };
        let chair = Brakes {
            latency_ms,
            deceleration_mm_s2,
            max_age_ms,
        };
        assert_eq!(max_speed(&ground, &chair).to_string(), text, "{case:?}");
    }
}

#[test]
fn the_joystick_is_only_held_back_and_the_page_shows_what_is_printed() {
    let Some(example) = compiled("speed_limit.c") else {
        return;
    };
    let held = fs::read_to_string(page::path()).unwrap();
    let made = page::renewed(&held, |arguments| program::printed(&example, arguments)).unwrap();
    for (held, made) in held.lines().zip(made.lines()) {
        assert_eq!(held, made, "docs/user/controller.md: {ANEW}");
    }
    assert!(held == made, "docs/user/controller.md: {ANEW}");

    let drive = program::printed(&example, &[]).unwrap();
    let rows: Vec<Vec<i64>> = drive
        .lines()
        .filter_map(|line| {
            line.split_whitespace()
                .map(|field| field.parse().ok())
                .collect()
        })
        .collect();
    assert!(rows.len() > 20, "{drive}");
    let (mut reduced, mut backward) = (0, 0);
    for row in &rows {
        let [_, _, to_kerb, free, limit, joystick, command, _] = row[..] else {
            panic!("{row:?}");
        };
        assert_eq!(command, joystick.min(limit), "{row:?}");
        assert!((0..to_kerb).contains(&free), "{row:?}");
        reduced += i64::from(command < joystick);
        backward += i64::from(command < 0 && command == joystick);
    }
    assert!(reduced > 5 && backward > 1, "{drive}");
    // It stops within 100 mm of the kerb, and also when no sentence is received.
    let nearest = rows.iter().map(|row| row[2]).min();
    assert!(nearest.is_some_and(|mm| mm < 100), "{drive}");
    assert!(
        rows.last().is_some_and(|row| row[4] == 0 && row[7] == 0),
        "{drive}"
    );

    let (text, content) = run(&example, &["speeds"], "");
    assert!(!content && text.contains("found: speeds"), "{text}");
}

#[test]
fn the_example_says_what_may_be_done_on_the_readme_s_report() {
    let Some(example) = compiled("example.c") else {
        return;
    };
    let readme = fs::read_to_string(directory().join("../README.md")).unwrap();
    // Without the lines that describe a sentence's fields.
    let is_sentence = |line: &&str| line.starts_with("$PSTR,") && !line.contains('<');
    let lines: Vec<&str> = readme.lines().map(str::trim).filter(is_sentence).collect();
    let (text, content) = run(&example, &[], &(lines.join("\r\n") + "\r\n"));
    assert!(content, "{text}");
    assert!(
        text.starts_with("scan 1: ok\n") && text.contains("\n  step 1: distance 500.2 mm"),
        "{text}"
    );
    assert!(
        text.contains("go: the answer is ok; valid for 1040.0 mm, level for 440.2 mm"),
        "{text}"
    );
    assert!(
        text.ends_with("a second later:\n  stop: silence\n"),
        "{text}"
    );

    let damaged = lines.join("\n").replacen("780.1", "790.1", 1) + "\n";
    let (text, content) = run(&example, &[], &damaged);
    assert!(!content && text.contains("a line is damaged"), "{text}");
    assert!(!text.contains("go:"), "{text}");
}

#[test]
fn the_example_drives_by_guard_sweeps() {
    let Some(example) = compiled("example.c") else {
        return;
    };
    let bodies = [
        "PSTR,DONE,guard",
        "PSTR,GUARD,1,ok,1900.0,none,99.9,",
        "PSTR,GUARD,2,ok,700.0,drop,99.8,",
        "PSTR,GUARD,3,ok,465.0,rise,99.8,",
        "PSTR,GUARD,4,ok,0.0,obstacle,99.8,",
        "PSTR,GUARD,5,degraded,900.0,unknown,50.0,lost-rows",
        "PSTR,GUARD,6,ok,1900.0,none,99.9,",
        "PSTR,HALT,crash",
        "PSTR,GUARD,7,fault,,unknown,0.0,motor-stall",
        "PSTR,GUARD,8,ok,1900.0,none,99.9,",
    ];
    let lines: Vec<String> = bodies.iter().map(|body| vectors::closed(body)).collect();
    let (text, content) = run(&example, &[], &(lines.join("\r\n") + "\r\n"));
    let expected = "sweep 1
  go, 600 mm/s: free for 1440 mm, then nothing in range
sweep 2
  slow, 424 mm/s: free for 240 mm, then a drop
sweep 3
  stop: no braking distance left in 5 mm, then a rise
sweep 4
  stop: no free ground, then an obstacle
sweep 5
  stop: the answer is degraded
sweep 6
  go, 600 mm/s: free for 1440 mm, then nothing in range
  stop: the scanner has a fault
sweep 7
  stop: the scanner has a fault
sweep 8
  go, 600 mm/s: free for 1440 mm, then nothing in range
a second later:
  stop: silence
";
    assert!(content && text == expected, "{text}");
}
