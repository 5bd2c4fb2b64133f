//! Tests of scene files that cannot be scanned: one message with the file, its line or key and the
//! expected value, exit status 1, and nothing written.

use std::fs;
use std::path::PathBuf;

use crate::common::sim;

/// Directory of one test, removed at its end.
struct Desk(PathBuf);

impl Desk {
    fn new(name: &str) -> Self {
        let dir = std::env::temp_dir().join(format!("stairscan-{name}-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        Self(dir)
    }

    /// Runs `simulate` on `text`. Returns its exit status, its standard error, and the files left
    /// behind.
    fn simulate(&self, text: &str) -> (Option<i32>, String, Vec<String>) {
        let scene = self.0.join("bad.toml");
        fs::write(&scene, text).unwrap();
        let out = self.0.join("out");
        let [scene, out] = [&scene, &out].map(|path| path.to_str().unwrap());
        let done = sim(&["simulate", scene, "-o", out]);
        let left = fs::read_dir(&self.0).unwrap();
        let left = left.map(|e| e.unwrap().file_name().into_string().unwrap());
        (
            done.status.code(),
            String::from_utf8(done.stderr).unwrap(),
            left.filter(|name| name != "bad.toml").collect(),
        )
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

const FLOOR: &str = "[[floor]]\nmaterial = \"concrete\"\n";

fn flight(line: &str) -> String {
    let keys = [
        "distance_m = 0.5",
        "count = 3",
        "rise_m = 0.17",
        "going_m = 0.28",
    ];
    let name = line.split('=').next().unwrap_or_default();
    let kept: Vec<&str> = keys.into_iter().filter(|k| !k.starts_with(name)).collect();
    format!(
        "[[stairs]]\n{}\n{line}\nmaterial = \"concrete\"\n{FLOOR}",
        kept.join("\n")
    )
}

#[test]
fn every_bad_scene_gets_one_message() {
    let desk = Desk::new("bad-scenes");
    let cases: Vec<(String, &[&str])> = vec![
        ("[[floor]\n".into(), &["bad.toml:1:"]),
        (
            flight("risers_m = 0.2"),
            &["bad.toml:6:", "unknown field `risers_m`", "rises_m"],
        ),
        (
            flight("rise_m = \"high\""),
            &["bad.toml:5:", "invalid type", "expected f64"],
        ),
        (
            flight("rise_m = -0.1"),
            &["bad.toml: stairs[0].rise_m: -0.1: expected a number from"],
        ),
        (
            flight("rise_m = nan"),
            &["bad.toml: stairs[0].rise_m: NaN: expected a number from"],
        ),
        (
            flight("going_m = inf"),
            &["bad.toml: stairs[0].going_m: inf: expected"],
        ),
        (
            flight("count = 0"),
            &["bad.toml: stairs[0].count: 0: expected 1 to 64 steps"],
        ),
        (flight("count = -1"), &["bad.toml:5:", "expected usize"]),
        (
            flight("rises_m = [0.1]"),
            &["stairs[0].rises_m: 1 numbers: expected 3 for count = 3"],
        ),
        (
            flight("nosing_m = 0.27"),
            &["stairs[0].nosing_m: 0.27: expected"],
        ),
        (
            flight("base_m = 0.7"),
            &["mount.height_m: 0.4: the mirror lies inside"],
        ),
        (
            "description = \"void\"\n".into(),
            &["bad.toml: no surface: expected at least one of"],
        ),
        (
            FLOOR.replace("concrete", "cheese"),
            &["floor[0].material: \"cheese\": expected one of"],
        ),
        (
            format!("{FLOOR}height_m = 0.5\n"),
            &["mount.height_m: 0.4: the mirror lies inside"],
        ),
        (
            format!(
                "{FLOOR}[[box]]\nfrom_m = -0.1\nto_m = 0.2\ntop_m = 0.6\nmaterial = \"metal\"\n"
            ),
            &["mount.height_m: 0.4: the mirror lies inside or behind"],
        ),
        (
            format!(
                "{FLOOR}[[box]]\nfrom_m = 0.9\nto_m = 0.6\ntop_m = 0.6\nmaterial = \"metal\"\n"
            ),
            &["box[0].to_m: 0.6: expected more than from_m, which is 0.9"],
        ),
        (
            "[[floor]]\nto_m = 49.0\nfrom_m = -49.0\nmaterial = \"metal\"\n".into(),
            &["bad.toml: too much surface:", "expected at most 65536"],
        ),
        (
            format!(
                "[mount]\nbeamwidth_deg = 30.0\n[radar]\nbandwidth_hz = 2e9\n{FLOOR}to_m = 20.0\n"
            ),
            &[
                "too much surface:",
                "patches of facets",
                "at most 40 million",
            ],
        ),
        (
            format!("[sweep]\nlast_deg = 100.0\nstep_deg = 0.01\n{FLOOR}"),
            &["sweep.step_deg: 0.01: expected at most 8192"],
        ),
        (
            format!("[radar]\nsamples_per_chirp = 300\n{FLOOR}"),
            &["radar.samples_per_chirp: 300"],
        ),
        (
            flight("nosing_m = 0.03\nbatter_m = 0.02"),
            &["stairs[0].batter_m: 0.02: expected 0 for floating treads"],
        ),
        (
            flight("batter_m = 0.1"),
            &["stairs[0].batter_m: 0.1: expected less than half the rise of 0.17"],
        ),
        (
            flight("direction = \"down\"\nstrip_m = 0.04"),
            &["stairs[0].strip_m: 0.04: expected 0 for floating treads"],
        ),
        (
            flight("strip_m = 0.002"),
            &["stairs[0].strip_m: 0.002: expected more than nosing_radius_m"],
        ),
        (
            flight("strip_material = \"metal\""),
            &["stairs[0].strip_m: 0: expected more"],
        ),
        (
            flight("strip_m = 0.04\nstrip_material = \"cheese\""),
            &["stairs[0].strip_material: \"cheese\": expected one of"],
        ),
        (
            format!("[material.odd]\nconductivity = 1e7\ndiffuse_inside = true\n{FLOOR}"),
            &["material.odd.diffuse_inside: true: expected false for a conductivity above 300"],
        ),
        (
            format!("[material.odd]\nroughness_m = -1e-3\n{FLOOR}"),
            &["material.odd.roughness_m"],
        ),
        (
            flight("tread_fall = 0.02\nopen = true"),
            &["stairs[0].tread_fall: 0.02: expected 0 for floating treads"],
        ),
        (
            flight("tread_fall = 0.1\nrises_m = [0.17, 0.17, 0.05]"),
            &["stairs[0].tread_fall: 0.1: expected a fall over the going of 0.28"],
        ),
        (
            flight("channel_m = 0.05"),
            &["stairs[0].channel_m: 0.05: expected 0 but for floating treads"],
        ),
        (
            flight("channel_m = 0.18\nopen = true"),
            &["stairs[0].channel_m: 0.18: expected from 0.016 to less than the rise"],
        ),
        (
            flight("channel_m = 0.05\nopen = true\nchannel_flange_m = 0.19\ntread_depth_m = 0.1"),
            &["stairs[0].channel_flange_m: 0.19: expected from 0.016"],
        ),
        (
            format!("[mount]\nyaw_deg = 40.0\n{FLOOR}"),
            &["mount.yaw_deg: 40: expected a number from -15 to 15"],
        ),
        (
            format!("[mount]\npitch_deg = nan\n{FLOOR}"),
            &["mount.pitch_deg: NaN: expected"],
        ),
        (
            "[[polyline]]\npoints = [[1.0, 0.0], [1.0, 0.0]]\nmaterial = \"metal\"\n".into(),
            &["polyline[0].points[1]: the same as the corner before"],
        ),
    ];
    for (text, wanted) in cases {
        let (code, message, left) = desk.simulate(&text);
        assert_eq!(code, Some(1), "{text}\n{message}");
        assert_eq!(message.lines().count(), 1, "one message, not\n{message}");
        for part in wanted {
            assert!(
                message.contains(part),
                "{part}: not in {message}for\n{text}"
            );
        }
        assert!(left.is_empty(), "half-written: {left:?}");
    }
}

#[test]
fn a_scene_file_says_itself_how_it_varies() {
    let file = "scenes/stair_a.toml";
    let done = sim(&[
        "simulate",
        file,
        "-o",
        "/nonexistent/out",
        "--effects",
        "wide",
    ]);
    assert_eq!(done.status.code(), Some(1));
    let message = String::from_utf8(done.stderr).unwrap();
    assert!(
        message.contains("--effects: expected random:KIND as scene, not scenes/stair_a.toml"),
        "{message}"
    );
}

#[test]
fn a_missing_file_and_an_unknown_kind_are_named() {
    let simulate = |scene: &str| {
        let done = sim(&["simulate", scene, "-o", "/nonexistent/out"]);
        (done.status.code(), String::from_utf8(done.stderr).unwrap())
    };
    let (code, message) = simulate("/nonexistent/scene.toml");
    assert_eq!(code, Some(1));
    assert!(
        message.contains("/nonexistent/scene.toml: No such file"),
        "{message}"
    );
    let (code, message) = simulate("random:cheese");
    assert_eq!(code, Some(1));
    assert!(
        message.contains("\"cheese\": expected one of ascending, none"),
        "{message}"
    );
}
