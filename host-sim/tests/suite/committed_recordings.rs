//! The committed recordings are what `simulate` makes of the committed scenes, byte for byte.

use std::fs;
use std::path::Path;

use host_sim::recording::Recording;
use host_sim::scene::Scene;

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
