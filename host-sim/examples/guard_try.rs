use host_sim::recording::Recording;
use host_sim::replay::{self, Options};
use stairscan::estimator::{Estimator, MappedScan};
use stairscan::guard::{Ahead, Filter, HazardKind};
use stairscan::infer::Likelihood;
use std::path::Path;

fn main() {
    for path in std::env::args().skip(1) {
        let recording = Recording::read(Path::new(&path)).unwrap();
        let mut estimator = Box::new(Likelihood::new());
        let mut filter = Filter::new();
        let mut n = 0;
        replay::answers(&recording, &Options::default(), |s| {
            n += 1;
            let map = s.pipeline.map();
            estimator.begin(map);
            for k in 0..map.rows() {
                estimator.row(map, k);
            }
            let scan = MappedScan { map, config: s.config, number: n, drive: &s.drive };
            let mut ahead = Ahead::new();
            let noise = estimator.look_ahead(&scan, &mut ahead);
            let free = filter.take(&ahead, s.drive.moved_m);
            let what = match free.what { None => "none", Some(HazardKind::Rise) => "rise", Some(HazardKind::Drop) => "drop", Some(HazardKind::Obstacle) => "obstacle" };
            let sum = |k: usize| ahead.hazards[k].iter().map(|w| (w * 1000.0).round() / 1000.0).collect::<Vec<f32>>();
            println!("{}", serde_json::json!({"recording": recording.name, "guard": n, "status": "ok", "free_m": free.free_m, "what": what, "confidence": free.confidence, "noise": noise, "moved": s.drive.moved_m, "free": ahead.free, "rise": sum(0), "obst": sum(1), "drop": sum(2)}));
        }).unwrap();
    }
}
