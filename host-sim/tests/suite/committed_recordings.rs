//! Tests that `simulate` reproduces the committed recordings from the committed scenes, byte for
//! byte.

use std::fs;
use std::path::Path;

use host_sim::recording::{Recording, meta_path};
use host_sim::scene::Scene;
use host_sim::sweeps::{scenes, truth};

#[test]
fn simulate_reproduces_every_committed_recording() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("committed");
    fs::create_dir_all(&out).unwrap();
    for name in ["stair_a", "stair_b", "stair_c", "descending", "empty"] {
        let scene = Scene::read(&root.join(format!("scenes/{name}.toml"))).unwrap();
        scene.simulate(name, 0).write(&out.join(name)).unwrap();
        for suffix in ["sigmf-meta", "sigmf-data"] {
            let file = format!("{name}.{suffix}");
            let committed = fs::read(root.join("recordings").join(&file)).unwrap();
            let made = fs::read(out.join(&file)).unwrap();
            assert!(
                made == committed,
                "recordings/{file}: not what `cargo sim simulate scenes/{name}.toml -o \
                 recordings/{name}` makes"
            );
        }
        let read = Recording::read(&root.join("recordings").join(name)).unwrap();
        assert_eq!(read.chirps(), 281);
        assert!(read.meta.truth.is_some());
    }
}

#[test]
fn simulate_reproduces_the_guard_sweeps() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let text = fs::read_to_string(root.join("scenes/kerb.toml")).unwrap();
    let drive = scenes::drive(0, 6, 0.2);
    let made = scenes::sweeps_of(toml::from_str(&text).unwrap(), "guard_kerb", 0, &drive).unwrap();
    let kept = root.join("recordings/guard_kerb");
    assert!(
        made.metadata_text().unwrap() == fs::read_to_string(meta_path(&kept)).unwrap()
            && made.sample_bytes() == fs::read(kept.with_extension("sigmf-data")).unwrap(),
        "recordings/guard_kerb: not what `cargo sim simulate scenes/kerb.toml --guard --sweeps 6 -o \
         recordings/guard_kerb` makes"
    );
    let read = Recording::read(&kept).unwrap();
    assert_eq!((read.chirps(), read.scans()), (6 * 31, 6));
    assert!(
        truth::read(&read)
            .unwrap()
            .unwrap()
            .iter()
            .all(Option::is_some)
    );
}
