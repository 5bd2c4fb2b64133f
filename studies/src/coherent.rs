//! Top edges of steps that the estimator's echoes show, and ground that the coherent image and rows alone show.

use std::fmt::Write as _;

use host_sim::coherent::CoherentView;
use host_sim::recording::Truth;
use host_sim::replay::Scanned;
use stairscan::config::Plane;
use stairscan::params::ground_line::LINE_REACH;
use stairscan::signal::grid::{DB_PER_UNIT, PolarMap, two_way_sigma};

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
/// Quantile of the normal distribution that it exceeds once in 1,000 cases.
const NORMAL_QUANTILE: f32 = 3.09;
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
    /// Top edges below and above the mirror.
    edges: [Edges; 2],
    /// Number of scans with steps, and of all their echoes.
    scans: f64,
    echoes: f64,
    /// Shares of seen cells of each scan without steps.
    ground: Vec<Seen>,
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
        let Some(view) = CoherentView::of(scanned) else {
            return;
        };
        if truth.steps.is_empty() {
            let height_m = scanned.config.mount.mount_height_m();
            let map = scanned.pipeline.map();
            self.ground.push(ground(&view, map, height_m));
            return;
        }
        let echoes = view.echoes.iter();
        let echoes: Vec<(f64, f64)> = echoes
            .map(|e| (e.range_m.into(), e.angle_rad.into()))
            .collect();
        self.scans += 1.0;
        self.echoes += echoes.len() as f64;
        let height_m = scanned.config.mount.mount_height_m();
        count(&mut self.edges, truth, &echoes, height_m.into());
    }

    /// Returns the counts as text.
    pub fn text(&self) -> String {
        let mut text =
            "top edges nearer than 1.6 m      of  found  5° beside  6 cm off\n".to_owned();
        for (place, e) in ["below the mirror", "above it"].iter().zip(&self.edges) {
            let _ = writeln!(
                text,
                "{place:<31} {:4.0} {:6.0} {:10.1} {:9.1}",
                e.all, e.found, e.beside, e.by_chance
            );
        }
        let scans = self.scans.max(1.0);
        let _ = writeln!(text, "echoes a scan with steps: {:.1}", self.echoes / scans);
        let scans = self.ground.len();
        let share =
            |k: usize| 100.0 * self.ground.iter().map(|s| s[k]).sum::<f64>() / scans.max(1) as f64;
        let shown = |k: usize| self.ground.iter().filter(|s| s[k] >= SHOWN).count();
        let _ = writeln!(
            text,
            "ground 0.5 to 1.0 m ahead, {scans} scans without steps: cells seen (in the air), scans with 40 %"
        );
        for (k, name) in ["coherent", "mean over rows"].iter().enumerate() {
            let (ground, air, scans) = (share(k), share(k + 2), shown(k));
            let _ = writeln!(text, "{name:<15} {ground:3.0} % ({air:.1} %) {scans:4}");
        }
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

/// Share of seen cells: on the ground by the coherent image and by the mean over rows, then of cells in the air by both.
type Seen = [f64; 4];

/// Returns the shares of cells along the ground, and at the same ranges in the air, that are seen.
fn ground(view: &CoherentView, map: &PolarMap, height_m: f32) -> Seen {
    let cells = ((GROUND_M.1 - GROUND_M.0) / CELL_M) as usize;
    let rows = MeanOfRows::new(map);
    let mut seen = Seen::default();
    for k in 0..cells {
        let x = (GROUND_M.0 + CELL_M * k as f64) as f32;
        let (range, angle) = (x.hypot(height_m), height_m.atan2(x));
        let shown = |angle: f32| {
            let coherent = view.over_noise(range, angle) > SEEN;
            [coherent, rows.shows(map, range, angle)]
        };
        let ([a, b], [c, d]) = (shown(angle), shown(AIR_RAD));
        for (share, is) in seen.iter_mut().zip([a, b, c, d]) {
            *share += f64::from(u8::from(is)) / cells as f64;
        }
    }
    seen
}

/// Mean power over the rows around an angle, with the weights (1 - t²)² that the estimator gives the ground's line.
struct MeanOfRows {
    /// Half-width of the weights, rows.
    reach: usize,
    /// Power that noise exceeds once in 1,000 cells.
    least: f32,
}

impl MeanOfRows {
    fn new(map: &PolarMap) -> Self {
        let geometry = map.geometry();
        let half = LINE_REACH * two_way_sigma(geometry.beamwidth_rad) / geometry.step_rad;
        let reach = (half as usize).max(1);
        let weights = Self::weights(reach);
        let (sum, squares) = weights.fold((0.0, 0.0), |(s, q), (_, w)| (s + w, q + w * w));
        // Quantile of a mean of n exponential powers (Wilson and Hilferty 1931).
        let n = sum * sum / squares;
        let root = 1.0 - 1.0 / (9.0 * n) + NORMAL_QUANTILE / (3.0 * n.sqrt());
        // Noise is exponential: its mean is its median over ln 2.
        let mut levels: Vec<u8> = (0..map.rows())
            .flat_map(|k| map.row(k).iter().copied())
            .collect();
        let middle = levels.len() / 2;
        let (_, median, _) = levels.select_nth_unstable(middle);
        let noise = power(*median) / core::f32::consts::LN_2;
        Self {
            reach,
            least: root.powi(3) * noise,
        }
    }

    /// Returns the offsets of the rows with their weights.
    fn weights(reach: usize) -> impl Iterator<Item = (isize, f32)> {
        let all = -(reach as isize)..=reach as isize;
        all.map(move |k| {
            let t = k as f32 / (reach as f32 + 1.0);
            (k, (1.0 - t * t) * (1.0 - t * t))
        })
    }

    /// Whether the mean exceeds the noise at a range, metres, and an angle, radians.
    fn shows(&self, map: &PolarMap, range_m: f32, angle_rad: f32) -> bool {
        let geometry = map.geometry();
        // The casts saturate.
        let bin = ((range_m - geometry.first_range_m) / geometry.bin_m).round() as usize;
        let row = ((angle_rad - map.angle_rad(0)) / geometry.step_rad).round() as usize;
        let (mut sum, mut weight) = (0.0, 0.0);
        for (k, w) in Self::weights(self.reach) {
            if let Some(cell) = row
                .checked_add_signed(k)
                .and_then(|row| map.row(row).get(bin))
            {
                (sum, weight) = (sum + w * power(*cell), weight + w);
            }
        }
        weight > 0.0 && sum / weight > self.least
    }
}

/// Returns the power of a map's level, in any unit.
fn power(level: u8) -> f32 {
    10f32.powf(f32::from(level) * DB_PER_UNIT / 10.0)
}
