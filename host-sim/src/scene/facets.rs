//! Surfaces cut into facets shorter than a quarter wavelength, and their roughness.

use std::sync::Arc;

use super::geometry::{Lateral, Segment, World};
use super::material::Material;
use super::maths::{Random, Vec2};

/// Maximum number of facets of one scene: some 50 m of surface at 94 GHz.
pub const MAX_FACETS: usize = 65_536;

/// Maximum number of facets times columns of one scene: some 160 MB of heights, drawn in one or two
/// seconds.
pub const MAX_PATCHES: f64 = 40e6;

/// Maximum width of a column, metres: roughness is drawn for every facet in columns across the plane.
const COLUMN: f64 = 2e-3;

/// One strip of surface across the plane, shorter than a quarter wavelength along its segment.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// Middle of the facet, metres.
    pub at: Vec2,
    /// Unit vector along the segment that the facet is cut from.
    pub along: Vec2,
    /// Unit normal of the visible side.
    pub normal: Vec2,
    /// Length of the facet along its segment, metres.
    pub len: f64,
    /// Index, in the world's segments, of the segment that the facet is cut from.
    pub segment: usize,
    /// Whether the facet lies in a joint of its material.
    pub joint: bool,
    /// Index of the facet's first height in [`Relief`]'s heights; beyond their end for a smooth facet.
    first: usize,
}

/// Facets of all surfaces with their random relief.
#[derive(Clone)]
pub struct Relief {
    /// All facets, segment after segment.
    pub facets: Vec<Facet>,
    /// Index of the first facet of every segment, and as last entry the number of facets.
    pub starts: Vec<usize>,
    /// Columns for which heights are drawn, by segment.
    columns: Vec<Columns>,
    /// Heights of all facets, metres; shared because they take up to 160 MB.
    heights: Arc<Vec<f32>>,
}

/// Returns the number of facets of a world whose facets are not longer than `limit` metres.
pub fn count(world: &World, limit: f64) -> f64 {
    let pieces = world.segments.iter().map(|s| libm::ceil(s.len() / limit));
    pieces.fold(0.0, |sum, n| sum + n)
}

/// Returns the number of patches (facets times columns) of a world within `reach` metres of `eye`, for facets not
/// longer than `limit` metres. Columns reach `lateral_reach` to either side per metre of range.
pub fn patches(world: &World, limit: f64, (eye, reach): (Vec2, f64), lateral_reach: f64) -> f64 {
    let pieces = world.segments.iter().map(|s| {
        let far = (s.a - eye).len().max((s.b - eye).len()).min(reach);
        let columns = Columns::new(&s.lateral, far * lateral_reach).len();
        libm::ceil(s.len() / limit) * columns as f64
    });
    pieces.fold(0.0, |sum, n| sum + n)
}

/// The columns of a surface: fixed lines across the plane, the same for all its facets.
#[derive(Clone, Copy, Debug)]
pub struct Columns {
    middle: f64,
    /// Distance from one column to the next across the plane, metres.
    pub spacing: f64,
    /// Index of the first column; column 0 begins at the middle of the surface, or at the plane if that is wider than
    /// the beam.
    pub low: i64,
    /// Index after that of the last column.
    pub high: i64,
}

impl Columns {
    /// Returns the columns of a surface that lie within `reach` metres to either side of the plane.
    pub fn new(lateral: &Lateral, reach: f64) -> Self {
        let (middle, spacing, half) = if lateral.half.is_finite() {
            // Columns of a post are narrow enough for the phase to follow its curve.
            let widest = if lateral.round { 0.2 * COLUMN } else { COLUMN };
            let half = libm::ceil(lateral.half / widest);
            (lateral.centre, lateral.half / half, half as i64)
        } else {
            (0.0, COLUMN, i64::MAX)
        };
        let low = libm::ceil((-reach - middle) / spacing - 0.5) as i64;
        let high = libm::floor((reach - middle) / spacing - 0.5) as i64 + 1;
        Self {
            middle,
            spacing,
            low: low.max(half.saturating_neg()),
            high: high.min(half),
        }
    }

    /// Returns the middle of column `k`, metres beside the plane.
    pub fn centre(self, k: i64) -> f64 {
        self.middle + (k as f64 + 0.5) * self.spacing
    }

    fn len(self) -> usize {
        usize::try_from(self.high - self.low).unwrap_or(0)
    }

    /// Returns the index of the column that contains `z`, metres beside the plane.
    fn number(self, z: f64) -> i64 {
        libm::floor((z - self.middle) / self.spacing) as i64
    }
}

/// Heights of one facet above its mean surface, metres, column after column; empty for a smooth facet.
#[derive(Clone, Copy)]
pub struct Heights<'a> {
    columns: Columns,
    heights: &'a [f32],
}

impl Heights<'_> {
    /// Returns the heights of `N` columns from column `k` on, metres. Columns beyond the outermost ones take the height
    /// of the outermost.
    pub fn columns<const N: usize>(&self, k: i64) -> [f64; N] {
        let first = usize::try_from(k - self.columns.low);
        match first.ok().and_then(|k| self.heights.get(k..k + N)) {
            Some(heights) => core::array::from_fn(|i| f64::from(heights[i])),
            None => core::array::from_fn(|i| self.column(k + i as i64)),
        }
    }

    fn column(&self, k: i64) -> f64 {
        let last = self.heights.len().saturating_sub(1);
        let index = usize::try_from(k - self.columns.low).unwrap_or(0);
        let height = self.heights.get(index.min(last));
        height.map_or(0.0, |h| f64::from(*h))
    }

    /// Returns the height at `z` metres beside the plane, metres.
    pub fn at(&self, z: f64) -> f64 {
        if self.heights.is_empty() {
            return 0.0;
        }
        self.column(self.columns.number(z))
    }
}

/// Random relief of one surface as an autoregressive field; a row holds one height per column for one facet.
struct Field {
    /// Recursion of the heights from one row to the next: correlation, and factor of the new random numbers.
    along: [f64; 2],
    /// Recursion of the heights from one column to the next: correlation, and factor of the new random numbers.
    across: [f64; 2],
    /// Standard deviation of the heights above the mean surface, metres.
    scale: f64,
    /// Heights of the next row, scaled to standard deviation 1.
    row: Vec<f64>,
}

impl Field {
    /// Draws the heights of the first row.
    fn start(&mut self, rng: &mut Random) {
        let mut drawn = vec![0.0; self.row.len() + 1];
        rng.normals(&mut drawn);
        let mut noise = drawn[0];
        for (h, next) in self.row.iter_mut().zip(&drawn[1..]) {
            *h = noise;
            noise = noise * self.across[0] + next * self.across[1];
        }
    }

    /// Writes `R` rows to `heights`, metres, and draws the row that follows them. Several rows are computed at once,
    /// because within a row each column depends on the one before.
    fn rows<const R: usize>(&mut self, heights: &mut [f32], rng: &mut Random) {
        let width = self.row.len();
        let mut drawn = vec![0.0; R * (width + 1)];
        rng.normals(&mut drawn);
        let drawn: [&[f64]; R] = core::array::from_fn(|r| &drawn[r * (width + 1)..][..width + 1]);
        let mut noise = drawn.map(|d| d[0]);
        for (i, row) in self.row.iter_mut().enumerate() {
            let mut h = *row;
            for r in 0..R {
                heights[r * width + i] = (h * self.scale) as f32;
                h = h * self.along[0] + noise[r] * self.along[1];
                noise[r] = noise[r] * self.across[0] + drawn[r][i + 1] * self.across[1];
            }
            *row = h;
        }
    }
}

impl Relief {
    /// Cuts all segments into facets not longer than `limit` metres and draws their heights.
    ///
    /// The relief is a Gaussian field with the separable exponential autocorrelation σ² e^{-|Δs|/l} e^{-|Δz|/l}, the
    /// usual description of worked surfaces at wavelengths near their correlation length (Ulaby, Moore, Fung, Microwave
    /// Remote Sensing II, sec. 12-5), drawn by two first-order recursions. Heights are drawn to either side of the
    /// plane up to `lateral_reach` times the largest range, below `reach` metres, of the segment's facets from one of
    /// the `eyes`.
    pub fn new(
        world: &World,
        materials: &[Material],
        (limit, reach): (f64, f64),
        (eyes, lateral_reach): (&[Vec2], f64),
        random: &mut Random,
    ) -> Self {
        let mut relief = Self {
            facets: Vec::new(),
            starts: Vec::new(),
            columns: Vec::new(),
            heights: Arc::default(),
        };
        for (index, segment) in world.segments.iter().enumerate() {
            relief.starts.push(relief.facets.len());
            let material = &materials[segment.material];
            let first = eyes.first().copied().unwrap_or(segment.a);
            relief.cut(index, segment, material, limit, first);
            let own = relief.starts[index];
            let far = relief.facets[own..]
                .iter()
                .flat_map(|f| eyes.iter().map(|eye| (f.at - *eye).len()))
                .filter(|r| *r < reach)
                .fold(0.0, f64::max);
            let columns = Columns::new(&segment.lateral, far * lateral_reach);
            relief.columns.push(columns);
            relief.roughen(own, columns, material, random);
        }
        relief.starts.push(relief.facets.len());
        relief
    }

    fn cut(&mut self, index: usize, s: &Segment, material: &Material, limit: f64, eye: Vec2) {
        let n = libm::ceil(s.len() / limit).max(1.0) as usize;
        let len = s.len() / n as f64;
        let normal = s.normal();
        let flipped = s.sheet && normal.dot(eye - s.a) < 0.0;
        let normal = if flipped { normal * -1.0 } else { normal };
        for k in 0..n {
            let way = (k as f64 + 0.5) * len;
            let joint = material.in_joint(s.start + way);
            let depth = if joint {
                material.spec.joint_depth_m
            } else {
                0.0
            };
            self.facets.push(Facet {
                at: s.a + s.direction() * way - normal * depth,
                along: s.direction(),
                normal,
                len,
                segment: index,
                joint,
                first: usize::MAX,
            });
        }
    }

    fn roughen(&mut self, own: usize, columns: Columns, material: &Material, rng: &mut Random) {
        let rough = material.spec.roughness_m;
        if rough <= 0.0 || columns.len() == 0 {
            return;
        }
        let keep = |step: f64| libm::exp(-step / material.spec.correlation_m);
        let Some(facet) = self.facets.get(own) else {
            return;
        };
        let (along, across) = (keep(facet.len), keep(columns.spacing));
        let mut field = Field {
            along: [along, (1.0 - along * along).sqrt()],
            across: [across, (1.0 - across * across).sqrt()],
            scale: rough,
            row: vec![0.0; columns.len()],
        };
        let heights = Arc::make_mut(&mut self.heights);
        let (start, width) = (heights.len(), columns.len());
        let facets = &mut self.facets[own..];
        heights.resize(start + width * facets.len(), 0.0);
        for (k, facet) in facets.iter_mut().enumerate() {
            facet.first = start + k * width;
        }
        field.start(rng);
        let mut fours = heights[start..].chunks_exact_mut(4 * width);
        for four in &mut fours {
            field.rows::<4>(four, rng);
        }
        for one in fours.into_remainder().chunks_exact_mut(width) {
            field.rows::<1>(one, rng);
        }
    }

    /// Shifts the facets for a chair that has come `travel` metres nearer (see [`World::moved`]).
    pub fn move_by(&mut self, world: &World, travel: f64) {
        let step = Vec2::new(travel * libm::cos(world.yaw), 0.0);
        for facet in &mut self.facets {
            facet.at = facet.at - step;
        }
    }

    /// Returns the heights of facet `k`.
    pub fn heights(&self, k: usize) -> Heights<'_> {
        let facet = &self.facets[k];
        let columns = self.columns[facet.segment];
        let end = facet.first.saturating_add(columns.len());
        Heights {
            columns,
            heights: self.heights.get(facet.first..end).unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::geometry::Skin;
    use crate::scene::material::builtin;
    use crate::scene::spec::Polarisation;

    fn plate(rough: f64, correlation: f64) -> Relief {
        let mut world = World::default();
        let points = [Vec2::new(1.0, -0.5), Vec2::new(1.0, 0.5)];
        let skin = Skin {
            material: 0,
            lateral: Lateral::WIDE,
        };
        world.outline(&points, false, |_| skin);
        let mut spec = builtin("metal").unwrap();
        spec.roughness_m = rough;
        spec.correlation_m = correlation;
        let material = Material::new(&spec, 94e9, Polarisation::Horizontal);
        let eye = Vec2::new(0.0, 0.0);
        let mut random = Random::new(1, 1);
        Relief::new(&world, &[material], (8e-4, 6.0), (&[eye], 0.1), &mut random)
    }

    #[test]
    fn facets_are_shorter_than_a_quarter_wavelength() {
        let relief = plate(0.0, 1e-3);
        assert_eq!(relief.facets.len(), 1250);
        assert!(relief.facets.iter().all(|f| f.len <= 8e-4));
        assert_eq!(relief.heights(17).at(0.01), 0.0);
    }

    #[test]
    fn heights_have_their_deviation_and_correlation() {
        let relief = plate(100e-6, 3e-3);
        let h = |k: usize, c: i32| relief.heights(k).at((f64::from(c) + 0.5) * COLUMN) / 100e-6;
        let cells: Vec<(usize, i32)> = (0..1200)
            .flat_map(|k| (-40..40).map(move |c| (k, c)))
            .collect();
        let mean = |f: &dyn Fn(usize, i32) -> f64| {
            cells.iter().map(|&(k, c)| f(k, c)).sum::<f64>() / cells.len() as f64
        };
        assert!((mean(&|k, c| h(k, c) * h(k, c)) - 1.0).abs() < 0.05);
        let along = mean(&|k, c| h(k, c) * h(k + 5, c));
        assert!((along - (-4.0_f64 / 3.0).exp()).abs() < 0.04, "{along}");
        let across = mean(&|k, c| h(k, c) * h(k, c + 1));
        assert!((across - (-2.0_f64 / 3.0).exp()).abs() < 0.04, "{across}");
    }
}
