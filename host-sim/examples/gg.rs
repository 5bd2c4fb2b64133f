//! Scratch: guard sweeps of random scenes. gg OUT FIRST COUNT
use host_sim::scene::driving::Drive;
use host_sim::scene::maths::Random;
use host_sim::scene::random::{random, Kind};
use host_sim::scene::sequence::pushed;
use host_sim::scene::spec::SceneSpec;
use host_sim::scene::Scene;
use std::path::Path;

const SCANS: usize = 14;

fn hazards(scene: &Scene, spec: &SceneSpec) -> Vec<(f64, &'static str)> {
    let truth = scene.truth();
    let mut out = Vec::new();
    for s in truth.steps.iter().chain(&truth.uncounted) {
        if s.height_m > 0.04 { out.push((s.distance_m, "rise")); }
    }
    for x in truth.ground_ends() { out.push((x, "drop")); }
    let in_way = |z: f64, w: f64| z.abs() - w < 0.3;
    for w in &spec.wall { if w.top_m > 0.04 && w.bottom_m < 1.0 { out.push((w.at_m, "obstacle")); } }
    for p in &spec.post { if in_way(p.lateral_m, 0.5 * p.diameter_m) && p.top_m > 0.04 && p.bottom_m < 1.0 { out.push((p.at_m - 0.5 * p.diameter_m, "obstacle")); } }
    for b in &spec.boxes { if b.top_m > 0.04 && b.bottom_m < 1.0 && in_way(b.lateral_m, b.width_m.map_or(9.0, |w| 0.5 * w)) { out.push((b.from_m, if b.top_m < 0.3 && b.bottom_m < 0.04 { "rise" } else { "obstacle" })); } }
    for d in &spec.door { out.push((d.at_m, "obstacle")); }
    for p in &spec.polyline {
        let (mut up, mut down) = (f64::INFINITY, f64::INFINITY);
        for q in &p.points { if q[1] > 0.04 { up = up.min(q[0]); } if q[1] < -0.04 { down = down.min(q[0]); } }
        if up.is_finite() { out.push((up, "obstacle")); }
        if down.is_finite() { out.push((down, "drop")); }
    }
    out
}

fn person(scene: &mut SceneSpec, (at, lateral): (f64, f64), stride: f64, rng: &mut Random) {
    use host_sim::scene::spec::{BoxSpec, PostSpec};
    let (apart, diameter) = (rng.between(0.08, 0.2), rng.between(0.09, 0.15));
    let (shoe, sole) = (rng.between(0.24, 0.32), rng.between(0.05, 0.09));
    for side in [-0.5, 0.5] {
        let (x, z) = (at + side * stride, lateral + side * (apart + diameter));
        scene.post.push(PostSpec { at_m: x, lateral_m: z, diameter_m: diameter, bottom_m: sole, top_m: rng.between(0.75, 0.95), material: "fabric".into() });
        let toes = x - rng.between(0.3, 0.7) * shoe;
        scene.boxes.push(BoxSpec { from_m: toes, to_m: toes + shoe, bottom_m: 0.0, top_m: sole, width_m: Some(rng.between(0.08, 0.11)), lateral_m: z, mountable: false, material: "fabric".into() });
    }
}

fn main() {
    let a: Vec<String> = std::env::args().collect();
    let (out, first, count): (_, u64, u64) = (a[1].clone(), a[2].parse().unwrap(), a[3].parse().unwrap());
    let kinds = [Kind::None, Kind::Brink, Kind::Kerb, Kind::Clutter, Kind::None, Kind::Hole, Kind::Ascending, Kind::Platform, Kind::Entrance, Kind::None, Kind::Brink, Kind::Clutter, Kind::None, Kind::Kerb];
    let threads: Vec<_> = (0..2u64).map(|t| { let out = out.clone(); std::thread::spawn(move || {
    for seed in (first + t..first + count).step_by(2) {
        let kind = kinds[(seed as usize) % kinds.len()];
        let mut rng = Random::new(seed, 0x4755_4152);
        let mut spec = random(kind, 900_000 + seed);
        // None: no walls near; others somewhere within reach.
        spec.sweep.first_deg = 8.0; spec.sweep.last_deg = 38.0; spec.sweep.step_deg = 1.0;
        let tilt = rng.between(-0.4, 0.4);
        if spec.mount.pitch_deg.is_none() { spec.mount.pitch_error_deg = tilt; }
        let speed = if rng.chance(0.15) { 0.0 } else { rng.between(0.08, 0.4) };
        let way = speed * 14.0 * 0.184;
        // place the first thing such that it comes from 2 m to .6 m
        let scene0 = Scene::new(spec.clone()).unwrap();
        let near = hazards(&scene0, &spec).into_iter().map(|h| h.0).fold(f64::INFINITY, f64::min);
        let want = rng.between(0.65, 1.9);
        let by = if near.is_finite() { want + way - near } else { 0.0 };
        let spec = if near.is_finite() { pushed(spec, by) } else { spec };
        let Ok(scene) = Scene::new(spec.clone()) else { continue };
        let drive = Drive::new(seed, SCANS, speed).with_rows(0.0028);
        let name = format!("{}_{seed}", kind.name());
        let mut rec = match scene.simulate_drive(&name, seed, &drive) { Ok(r) => r, Err(e) => { eprintln!("{name}: {e}"); continue } };
        let mut hz = vec![hazards(&scene, &spec); SCANS];
        let mut label = kind.name().to_string();
        if kind == Kind::None && rng.chance(0.5) {
            let mut with = spec.clone();
            let m = 3 + rng.index(4);
            let at = rng.between(0.75, 1.5) + way * m as f64 / 14.0;
            let lateral = rng.between(-0.25, 0.25);
            let stride = rng.between(0.0, 0.25);
            person(&mut with, (at, lateral), stride, &mut rng);
            if let Ok(two) = Scene::new(with.clone()) { if let Ok(r2) = two.simulate_drive(&name, seed, &drive) {
                let per = rec.samples.len() / SCANS;
                let cut = m * per;
                rec.samples.truncate(cut); rec.samples.extend_from_slice(&r2.samples[cut..]);
                let h2 = hazards(&two, &with);
                for h in &mut hz[m..] { *h = h2.clone(); }
                label = "person".into();
            } }
        }
        let path = format!("{out}/{label}_{seed}");
        rec.name = format!("{label}_{seed}");
        rec.write(Path::new(&path)).unwrap();
        let file = format!("{path}.sigmf-meta");
        let mut json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
        let travel = json["global"]["stairscan:truth_travel_m"].clone();
        let list: Vec<_> = (0..SCANS).map(|k| {
            let t = travel[k].as_f64().unwrap_or(0.0);
            let h = hz[k].iter().map(|h| (h.0 - t, h.1)).filter(|h| h.0 > 0.05).min_by(|a, b| a.0.total_cmp(&b.0)).filter(|h| h.0 < 2.5);
            serde_json::json!({"hazard_m": h.map(|h| h.0), "hazard": h.map(|h| h.1)})
        }).collect();
        json["global"]["stairscan:truth_guard"] = list.into();
        json["global"]["stairscan:mode"] = "guard".into();
        std::fs::write(&file, serde_json::to_string(&json).unwrap()).unwrap();
    } }) }).collect();
    for t in threads { t.join().unwrap(); }
}
