//! Scene files: each gives a scene with a ground truth, or is refused in one line with the expected
//! value.

use host_sim::scene::Scene;

/// Processes the file.
pub fn run(data: &[u8]) {
    let Ok(text) = str::from_utf8(data) else {
        return;
    };
    match Scene::parse(text) {
        Ok(scene) => {
            assert!(scene.rows() >= 1);
            let truth = scene.truth();
            let steps = truth.steps.iter().chain(&truth.uncounted);
            for step in steps {
                assert!(step.distance_m.is_finite() && step.height_m.is_finite());
            }
        }
        Err(error) => {
            let message = format!("{error:#}");
            assert!(message.starts_with(':'), "{message}");
            assert_eq!(message.lines().count(), 1, "{message}");
        }
    }
}
