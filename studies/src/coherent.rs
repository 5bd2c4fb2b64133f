//! What the coherent image shows beside today's echoes: top edges of steps, and ground.

use std::fmt::Write as _;

use host_sim::coherent::CoherentView;
use host_sim::inspect::Inspection;
use host_sim::recording::Truth;
use host_sim::replay::Scanned;
use stairscan::config::Plane;
use stairscan::signal::echoes::Echo;

/// Distance from the mirror up to which top edges count, metres.
const NEAR_M: f64 = 1.6;
/// Distance in range and angle within which an echo is a top edge's, metres and radians: 1 degree.
const SAME_M: f64 = 0.012;
const SAME_RAD: f64 = 0.017_453;
/// Distances at which echoes are counted beside an edge: along the riser's face (5 degrees), and by chance (metres).
const BESIDE_RAD: f64 = 0.087_266;
const BY_CHANCE_M: f64 = 0.06;
/// Height below the mirror's up to which an edge is above it, metres: it shows the face before the edge.
const LEVEL_M: f64 = 0.02;
/// Ground that is examined, metres ahead, and the distance of its cells.
const GROUND_M: (f64, f64) = (0.5, 1.0);
const CELL_M: f64 = 0.015;
/// Power over the noise that noise exceeds once in 1,000 cells: ln 1000.
const SEEN: f32 = 6.907_755;
/// Share of the cells from which on a recording's ground is seen.
const SHOWN: f64 = 0.4;
/// Beam angle at which nothing stands, radians below the horizontal: 12 degrees up.
const AIR_RAD: f32 = -0.209_44;

/// Counts of top edges: all, and with an echo at the edge, beside it, and by chance.
#[derive(Clone, Copy, Debug, Default)]
struct Edges {
    all: f64,
    found: f64,
    beside: f64,
    by_chance: f64,
}

/// Counts of all scans.
#[derive(Debug, Default)]
pub struct Counts {
    /// Top edges below and above the mirror: by today's echoes, then by the coherent image's.
    edges: [[Edges; 2]; 2],
    /// Number of scans with steps, and of all their echoes.
    scans: f64,
    echoes: [f64; 2],
    /// Share of seen cells of each scan without steps, on the ground and in the air.
    ground: Vec<[f64; 2]>,
}

impl Counts {
    /// Whether no scan has been counted.
    pub fn is_empty(&self) -> bool {
        self.scans == 0.0 && self.ground.is_empty()
    }

    /// Adds a scan of the depth plane with ground truth.
    pub fn add(&mut self, scanned: &Scanned<'_>) {
        let recording = scanned.recording();
        let depth = scanned.config.mount.plane.first() == Plane::Depth;
        let truth = recording.meta.truth.as_ref().filter(|_| depth);
        let (Some(truth), false) = (truth, scanned.answer.is_fault()) else {
            return;
        };
        let Some(mut view) = CoherentView::of(scanned) else {
            return;
        };
        if truth.steps.is_empty() {
            let height_m = scanned.config.mount.mount_height_m();
            self.ground.push(ground(&mut view, height_m));
            return;
        }
        let (map, config) = (scanned.pipeline.map(), scanned.config);
        let inspection = Inspection::of(map, config, scanned.answer.scan.scan, &scanned.drive);
        let places = |e: &Echo| (e.range_m.into(), e.angle_rad.into());
        let today: Vec<(f64, f64)> = inspection.points().map(places).collect();
        let coherent: Vec<(f64, f64)> = view.echoes.iter().map(places).collect();
        self.scans += 1.0;
        for (k, echoes) in [today, coherent].iter().enumerate() {
            self.echoes[k] += echoes.len() as f64;
            count(
                &mut self.edges[k],
                truth,
                echoes,
                config.mount.mount_height_m().into(),
            );
        }
    }

    /// Returns the counts as text.
    pub fn text(&self) -> String {
        let mut text =
            "top edges nearer than 1.6 m      of  found  5° beside  6 cm off\n".to_owned();
        for (name, edges) in ["today's echoes", "coherent"].iter().zip(&self.edges) {
            for (place, e) in ["below the mirror", "above it"].iter().zip(edges) {
                let _ = writeln!(
                    text,
                    "{name:<15} {place:<17} {:4.0} {:6.0} {:10.1} {:9.1}",
                    e.all, e.found, e.beside, e.by_chance
                );
            }
        }
        let scans = self.scans.max(1.0);
        let [today, coherent] = self.echoes.map(|n| n / scans);
        let _ = writeln!(
            text,
            "echoes a scan with steps: today {today:.1}, coherent {coherent:.1}"
        );
        let scans = self.ground.len();
        let share = |k: usize| self.ground.iter().map(|s| s[k]).sum::<f64>() / scans.max(1) as f64;
        let shown = self.ground.iter().filter(|s| s[0] >= SHOWN).count();
        let _ = writeln!(
            text,
            "ground 0.5 to 1.0 m ahead, {scans} scans without steps: {:.0} % of the cells seen ({:.1} % in the air), 40 % of them in {shown}",
            100.0 * share(0),
            100.0 * share(1)
        );
        text
    }
}

/// Adds the true steps to the counts of edges below and above the mirror, at `height_m`.
fn count(edges: &mut [Edges; 2], truth: &Truth, echoes: &[(f64, f64)], height_m: f64) {
    for step in truth.steps.iter().filter(|s| s.distance_m <= NEAR_M) {
        let (x, down) = (step.distance_m, height_m - step.height_m);
        let (range, angle) = (x.hypot(down), down.atan2(x));
        let has = |range: f64, angle: f64| {
            let near =
                |e: &(f64, f64)| (e.0 - range).abs() < SAME_M && (e.1 - angle).abs() < SAME_RAD;
            f64::from(u8::from(echoes.iter().any(near)))
        };
        let e = &mut edges[usize::from(step.height_m > height_m - LEVEL_M)];
        e.all += 1.0;
        e.found += has(range, angle);
        e.beside += 0.5 * (has(range, angle + BESIDE_RAD) + has(range, angle - BESIDE_RAD));
        e.by_chance += 0.5 * (has(range + BY_CHANCE_M, angle) + has(range - BY_CHANCE_M, angle));
    }
}

/// Returns the share of cells along the ground that are seen, and of cells at the same ranges in the air.
fn ground(view: &mut CoherentView, height_m: f32) -> [f64; 2] {
    let cells = ((GROUND_M.1 - GROUND_M.0) / CELL_M) as usize;
    let mut seen = [0.0; 2];
    for k in 0..cells {
        let x = (GROUND_M.0 + CELL_M * k as f64) as f32;
        let (range, angle) = (x.hypot(height_m), height_m.atan2(x));
        for (count, angle) in seen.iter_mut().zip([angle, AIR_RAD]) {
            *count += f64::from(u8::from(view.over_noise(range, angle) > SEEN)) / cells as f64;
        }
    }
    seen
}
